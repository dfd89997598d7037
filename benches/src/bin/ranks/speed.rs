//! Two ranks of one thread beside one process of two threads, interleaved.

use std::time::Duration;

use anyhow::{Context, Result, anyhow};
use dcd_benches::{Cell, Column, Options, Report, Table, Units, timing};
use dcd_exec::{Par, with_threads};
use dcd_geom::Scene;
use dcd_pipeline::Pipeline;
use dcd_scenes::SceneSpec;
use serde::{Deserialize, Serialize};

use crate::program::Program;

const SCENES: [(&str, usize); 2] = [("sparse", 100_000), ("sparse", 1_000_000)];
const ROUNDS: usize = 5;
const STEPS: usize = 7;

/// Medians of a round, milliseconds.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Round {
    threads_ms: f64,
    ranks_ms: f64,
    exchange_ms: f64,
}

fn key(scene: &str, objects: usize) -> String {
    format!("speed/{scene}/N={objects}")
}

pub(crate) fn plan() -> Vec<String> {
    SCENES.iter().map(|(scene, objects)| key(scene, *objects)).collect()
}

pub(crate) fn measure(program: &Program, options: &Options, units: &mut Units) -> Result<()> {
    for (name, objects) in SCENES {
        units.run(&key(name, objects), || {
            let spec = SceneSpec::parse(name)?.with_objects(objects).with_seed(options.seed);
            let scene = spec.scene()?;
            let mut pipeline = Pipeline::new();
            pipeline.prepare_shapes(&scene);
            (0..ROUNDS)
                .map(|_| {
                    let threads_ms = on_threads(&scene, &mut pipeline)?;
                    on_ranks(program, &spec, threads_ms)
                })
                .collect::<Result<Vec<_>>>()
        })?;
    }
    Ok(())
}

/// The median of the steps, milliseconds.
fn on_threads(scene: &Scene, pipeline: &mut Pipeline) -> Result<f64> {
    let times = with_threads(2, || {
        (0..STEPS)
            .map(|_| timing::time(|| pipeline.step(scene, Par::WarmPool).contact_count()).0)
            .collect::<Vec<Duration>>()
    });
    Ok(median(times.map_err(|error| anyhow!("no threads: {error}"))?))
}

fn on_ranks(program: &Program, spec: &SceneSpec, threads_ms: f64) -> Result<Round> {
    let numbers = [spec.objects as u64, spec.seed, STEPS as u64].map(|number| number.to_string());
    let [count, seed, steps] = numbers.each_ref().map(String::as_str);
    let arguments = ["--scene", spec.name(), "--n", count, "--seed", seed, "--repeat", steps]
        .map(str::to_owned);
    let report = program.detect(2, &arguments)?;
    let ms = |stage: &str| report["ms"][stage]["median"].as_f64().context("no time");
    Ok(Round { threads_ms, ranks_ms: ms("total")?, exchange_ms: ms("exchange")? })
}

fn median(mut times: Vec<Duration>) -> f64 {
    times.sort_unstable();
    times.get(times.len() / 2).map_or(0.0, |time| time.as_secs_f64() * 1e3)
}

pub(crate) fn show(units: &Units, report: &mut Report) -> Result<()> {
    let columns = [
        Column::new("scene"),
        Column::new("N"),
        Column::new("two threads").unit("ms").decimals(2),
        Column::new("two ranks").unit("ms").decimals(2),
        Column::new("of which exchange").unit("ms").decimals(2),
        Column::new("threads by ranks").unit("×").decimals(2),
        Column::new("least").unit("×").decimals(2),
        Column::new("most").unit("×").decimals(2),
    ];
    let mut table = Table::new("speed", "Two ranks beside two threads", columns);
    for (scene, objects) in SCENES {
        let Some(rounds) = units.get::<Vec<Round>>(&key(scene, objects)) else { continue };
        let middle = |of: &dyn Fn(&Round) -> f64| {
            let mut numbers: Vec<f64> = rounds.iter().map(of).collect();
            numbers.sort_unstable_by(f64::total_cmp);
            (numbers[0], numbers[numbers.len() / 2], numbers[numbers.len() - 1])
        };
        let (least, ratio, most) = middle(&|round| round.threads_ms / round.ranks_ms);
        table.push([
            Cell::from(scene),
            Cell::from(objects as u64),
            Cell::Number(middle(&|round| round.threads_ms).1),
            Cell::Number(middle(&|round| round.ranks_ms).1),
            Cell::Number(middle(&|round| round.exchange_ms).1),
            Cell::Number(ratio),
            Cell::Number(least),
            Cell::Number(most),
        ])?;
    }
    report.heading("Two ranks beside two threads");
    report.note(format!(
        "{ROUNDS} rounds, in each the median of {STEPS} steps of `Pipeline` on two threads and then of \
         `mpirun -n 2 dcd-mpi`, the slower rank counting; the exchange of poses is in it, shapes that a rank has seen \
         are not sent again. A rank's objects lie in memory in the order of their places, the scene's in that of their \
         numbers."
    ));
    report.table(table);
    Ok(())
}
