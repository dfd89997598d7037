//! From one thread to all cores, stage by stage.

use anyhow::Result;
use dcd_benches::{
    Axis, Cell, Column, Figure, Options, Pair, Report, Series, Table, Units, timing,
};
use dcd_pipeline::Par;
use serde::{Deserialize, Serialize};

use crate::runner::{Case, PARTS, Runner, WHOLE, on_threads};

/// Up to this many threads every number of them is measured, beyond it the doubles.
const ONE_BY_ONE: usize = 8;

/// A number of threads, interleaved with the serial step.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Run {
    threads: usize,
    /// As [`PARTS`]: first so many threads, then one.
    parts: [Pair; PARTS.len()],
    /// The whole step with threads kept awake from section to section, then with threads that may
    /// sleep.
    awake: Pair,
}

fn key(case: &Case) -> String {
    format!("threads/{}", case.key())
}

/// The units of all cases.
pub(crate) fn plan(cases: &[Case]) -> Vec<String> {
    cases.iter().map(key).collect()
}

/// Measures a case at every number of threads.
pub(crate) fn measure(case: &Case, options: &Options, units: &mut Units) -> Result<()> {
    let rounds = super::rounds(options);
    units.run(&key(case), || {
        let scene = case.scene()?;
        let run = |threads| {
            on_threads(threads, || {
                let (mut many, mut one) =
                    (Runner::new(scene, Par::WarmPool), Runner::new(scene, Par::Serial));
                let parts = timing::pairs_of(rounds, || many.times(), || one.times());
                many.agrees_with(&one)?;
                let mut asleep = Runner::new(scene, Par::Pool);
                let awake = timing::pairs_of(rounds, || many.times(), || asleep.times())[WHOLE];
                asleep.agrees_with(&one)?;
                Ok(Run { threads, parts, awake })
            })
        };
        counts(options.threads()).into_iter().map(run).collect::<Result<Vec<Run>>>()
    })?;
    Ok(())
}

/// Draws what is there.
pub(crate) fn show(cases: &[Case], units: &Units, report: &mut Report) -> Result<()> {
    report.heading("Threads");
    report.note(
        "Each number of threads takes turns with the serial step, which is the same code without \
         the pool; a speed-up is the median of the rounds' ratios. One thread in a pool of one \
         shows what the pool itself costs. Threads are kept awake from section to section \
         (`Par::WarmPool`); the last column is what a step with threads that may sleep \
         (`Par::Pool`) takes over that, the median of interleaved rounds.",
    );
    let mut columns = ["scene", "N", "threads"].map(Column::new).to_vec();
    columns.push(Column::new("whole").unit("ms"));
    columns
        .extend(PARTS.map(|part| Column::new(format!("{part}, speed-up")).unit("×").decimals(2)));
    columns.extend(["least", "most"].map(|name| Column::new(name).unit("×").decimals(2)));
    columns.push(Column::new("with threads that may sleep").unit("×").decimals(2));
    let mut table = Table::new("threads", "From one thread to all cores", columns);
    let title = "Speed-up of the whole step over one thread";
    let axes = [Axis::linear("threads"), Axis::linear("speed-up")];
    let [x, y] = axes;
    let mut figure = Figure::new("threads", title, x, y);
    for case in cases {
        let Some(runs) = units.get::<Vec<Run>>(&key(case)) else { continue };
        for run in &runs {
            let whole = run.parts[WHOLE];
            let mut row = vec![Cell::from(case.name()), case.objects().into(), run.threads.into()];
            row.push(whole.a.median.into());
            row.extend(run.parts.map(|part| Cell::from(part.ratio)));
            row.extend([whole.least, whole.most].map(Cell::from));
            row.push(run.awake.ratio.into());
            table.push(row)?;
        }
        let points = runs.iter().map(|run| (run.threads as f64, run.parts[WHOLE].ratio));
        figure.push(Series::measured(case.key(), points.filter(|(_, ratio)| ratio.is_finite())))?;
    }
    report.table(table);
    report.figure(figure);
    Ok(())
}

/// The numbers of threads that are measured on so many cores.
fn counts(cores: usize) -> Vec<usize> {
    let mut counts: Vec<usize> = (1..=cores.min(ONE_BY_ONE)).collect();
    let doubles = std::iter::successors(Some(2 * ONE_BY_ONE), |count| Some(2 * count));
    counts.extend(doubles.take_while(|&count| count < cores));
    if cores > ONE_BY_ONE {
        counts.push(cores);
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_machine_is_measured_from_one_thread_to_all_its_cores() {
        assert_eq!(counts(1), [1]);
        assert_eq!(counts(2), [1, 2]);
        assert_eq!(counts(8), [1, 2, 3, 4, 5, 6, 7, 8]);
        assert_eq!(counts(28), [1, 2, 3, 4, 5, 6, 7, 8, 16, 28]);
        assert_eq!(counts(64)[8..], [16, 32, 64]);
    }
}
