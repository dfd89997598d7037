//! A table of the queries.

use anyhow::Result;
use dcd_benches::{Cell, Column, Header, Report, Table};

use crate::contest::{ACCURACIES, MARGIN, Measurement, Outcome, Race};

pub(crate) fn report(header: Header, outcomes: &[Outcome]) -> Result<Report> {
    let title = "Distance, depth and manifold beside Parry's";
    let mut report = Report::new("questions", title, header);
    report.note(
        "Interleaved in one process, one thread and more; the median of the rounds with the least and the most. Two ratios: `narrow`, our \
         narrow phase (yes or no, and what is measured) against Parry's queries in f32 of the same candidate pairs; and `whole`, our whole \
         step (boxes, tree, pairs, narrow phase) against Parry's (its boxes, grown by half the margin, its binned tree, the tree \
         against itself, its queries). `step / queries` is our whole step against Parry's queries alone. The queries are \
         `closest_points` with the margin, `contact`, `contact_manifolds` without a warm start; on more threads than one in tasks \
         of 1,024 pairs, and Parry's tree against itself on them too.",
    );
    report.note(format!(
        "Distances are of pairs within {MARGIN} m. The bound is proved for each answer; every answer is checked against the \
         certified one of its pair.",
    ));
    let columns =
        ["scene", "objects", "question", "accuracy", "threads", "pairs", "found", "Parry finds"];
    let columns = columns.map(Column::new).into_iter().chain([
        Column::new("narrow").unit("ms"),
        Column::new("Parry's queries").unit("ms"),
        Column::new("narrow ratio").unit("×").decimals(2),
        Column::new("least").unit("×").decimals(2),
        Column::new("most").unit("×").decimals(2),
        Column::new("whole").unit("ms"),
        Column::new("Parry's step").unit("ms"),
        Column::new("whole ratio").unit("×").decimals(2),
        Column::new("whole, least").unit("×").decimals(2),
        Column::new("whole, most").unit("×").decimals(2),
        Column::new("step / queries").unit("×").decimals(2),
        Column::new("bound, 99 of 100").unit("µm").decimals(4),
        Column::new("worst bound").unit("µm").decimals(4),
    ]);
    let mut table = Table::new("times", "Times, and Parry's by ours", columns);
    for outcome in outcomes {
        for (measured, race) in outcome.measurements.iter().flat_map(with_races) {
            let ms = |time: std::time::Duration| time.as_secs_f64() * 1e3;
            let Race { threads, narrow, whole, mixed } = race;
            let counts = [*threads, measured.candidates, measured.found, measured.parry_found];
            let names = [
                Cell::from(outcome.scene.as_str()),
                Cell::from(outcome.objects),
                Cell::from(measured.kind.name()),
                Cell::from(measured.accuracy.as_str()),
            ];
            let numbers = [
                ms(narrow.a.median),
                ms(narrow.b.median),
                narrow.ratio,
                narrow.least,
                narrow.most,
                ms(whole.a.median),
                ms(whole.b.median),
                whole.ratio,
                whole.least,
                whole.most,
                mixed.ratio,
                measured.p99 * 1e6,
                measured.worst * 1e6,
            ];
            let counts = counts.map(Cell::from);
            table.push(names.into_iter().chain(counts).chain(numbers.map(Cell::from)))?;
        }
    }
    report.table(summary(outcomes)?);
    report.table(table);
    Ok(report)
}

/// How many times Parry's queries take the time of our narrow phase: a line for each question of a scene, on one thread
/// and on all.
fn summary(outcomes: &[Outcome]) -> Result<Table> {
    let threads = threads_of(outcomes);
    let mut columns: Vec<Column> =
        ["scene", "objects", "question", "pairs", "found"].map(Column::new).into();
    for count in &threads {
        for (name, _) in ACCURACIES {
            let title =
                if *count == 1 { name.to_owned() } else { format!("{name}, {count} threads") };
            columns.push(Column::new(title).unit("×").decimals(1));
        }
    }
    let mut table = Table::new("summary", "Parry's queries by our narrow phase", columns);
    for outcome in outcomes {
        for of_kind in outcome.measurements.chunk_by(|a, b| a.kind == b.kind) {
            let first = &of_kind[0];
            let names = [
                Cell::from(outcome.scene.as_str()),
                Cell::from(outcome.objects),
                Cell::from(first.kind.name()),
            ];
            let counts = [first.candidates, first.found].map(Cell::from);
            let ratios = threads.iter().flat_map(|&threads| {
                ACCURACIES.map(|(name, _)| {
                    let same = of_kind.iter().filter(|measured| measured.accuracy == name);
                    let mut races = same.flat_map(|measured| &measured.races);
                    let found = races.find(|race| race.threads == threads);
                    found.map_or(Cell::from(""), |found| Cell::from(found.narrow.ratio))
                })
            });
            table.push(names.into_iter().chain(counts).chain(ratios))?;
        }
    }
    Ok(table)
}

/// On how many threads something was measured, ascending.
fn threads_of(outcomes: &[Outcome]) -> Vec<usize> {
    let races = outcomes.iter().flat_map(|outcome| &outcome.measurements).flat_map(with_races);
    let mut threads: Vec<usize> = races.map(|(_, race)| race.threads).collect();
    threads.sort_unstable();
    threads.dedup();
    threads
}

/// Each of a question's races beside it.
fn with_races(measured: &Measurement) -> impl Iterator<Item = (&Measurement, &Race)> {
    measured.races.iter().map(move |race| (measured, race))
}
