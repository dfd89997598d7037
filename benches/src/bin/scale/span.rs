//! Work and span: the tasks of a step as recorded on one thread, scheduled on many workers.

use std::hint::black_box;
use std::time::{Duration, Instant};

use anyhow::Result;
use dcd_benches::{
    Axis, Cell, Column, Figure, Options, Pair, Report, Series, Table, Units, timing,
};
use dcd_exec::{Exec, Stage};
use dcd_geom::Scene;
use dcd_pipeline::Par;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::record::{Program, Recorder, STAGES, median, task_times};
use crate::runner::{Case, PARTS, Runner, WHOLE, on_threads};
use crate::schedule::{Charges, Forecast, IDLE, Losses, forecast};

/// Workers that a step is scheduled on; the paper's machine has 28.
const WORKERS: [usize; 10] = [1, 2, 4, 8, 16, 28, 32, 64, 96, 128];
/// Those of which the stages' losses are shown.
const SHOWN: [usize; 3] = [2, 28, 64];
/// A forecast further off the measured time of two threads than this is called wrong.
const TOLERANCE: f64 = 0.15;

/// What a step was seen to consist of and to cost.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Seen {
    program: Program,
    charges: Charges,
    /// As [`PARTS`]: first two threads, then one.
    measured: [Pair; PARTS.len()],
}

fn key(case: &Case) -> String {
    format!("span/{}", case.key())
}

/// The units of all cases.
pub(crate) fn plan(cases: &[Case]) -> Vec<String> {
    cases.iter().map(key).collect()
}

/// Records a case on one thread, and measures it and its charges on two.
pub(crate) fn measure(case: &Case, options: &Options, units: &mut Units) -> Result<()> {
    let rounds = super::rounds(options);
    units.run(&key(case), || {
        let scene = case.scene()?;
        on_threads(2, || see(scene, rounds))
    })?;
    Ok(())
}

/// On a pool of two threads. Each kind of run has a pipeline of its own, warm and with its buffers
/// where its threads have put them.
fn see(scene: &Scene, rounds: u32) -> Result<Seen> {
    let recorder = Recorder::default();
    let (mut one, mut two) = (Runner::new(scene, Par::Serial), Runner::new(scene, Par::WarmPool));
    let measured = timing::pairs_of(rounds, || two.times(), || one.times());

    let (mut programs, mut alone, mut together) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..rounds {
        one.observed(Exec::observed(Par::Serial, &recorder));
        let events = recorder.take();
        alone.push(task_times(&events));
        programs.push(Program::of(&events)?);
        two.observed(Exec::observed(Par::WarmPool, &recorder));
        together.push(task_times(&recorder.take()));
    }
    two.agrees_with(&one)?;
    let slowdown = std::array::from_fn(|stage| {
        let ratios = alone.iter().zip(&together).map(|(one, two)| two[stage] / one[stage]);
        let ratio = median(ratios.filter(|ratio| ratio.is_finite()).collect());
        // Nothing is faster beside others; what seems so is noise.
        ratio.max(1.0)
    });
    let charges = Charges {
        task: task_overhead(),
        waking: waking(rounds),
        joining: joining(rounds),
        slowdown,
    };
    Ok(Seen { program: Program::median(&programs)?, charges, measured })
}

/// What a task costs beside its work, nanoseconds: tasks that do nothing, on two threads.
fn task_overhead() -> f64 {
    const TASKS: usize = 4096;
    let once = |_| {
        let (time, ()) = timing::time(|| {
            Exec::from(Par::WarmPool).tasks(TASKS, |k| {
                black_box(k);
            });
        });
        2.0 * time.as_secs_f64() * 1e9 / TASKS as f64
    };
    median((0..64).map(once).collect())
}

/// What a section costs beside its tasks, nanoseconds, after the other thread has been idle for each
/// of [`IDLE`] since it worked in the same step.
fn joining(rounds: u32) -> [f64; IDLE.len()] {
    IDLE.map(|idle| {
        Exec::from(Par::WarmPool).within_pool(|exec| {
            // Both threads are awake when the first of them is measured.
            beside_its_tasks(exec, 0.0);
            median((0..16 * rounds).map(|_| beside_its_tasks(exec, idle)).collect())
        })
    })
}

/// The same for the first section of a step, before which the other thread sleeps.
fn waking(rounds: u32) -> f64 {
    const ASLEEP: f64 = 3e5;
    let once = |_| beside_its_tasks(Par::Pool.into(), ASLEEP);
    median((0..16 * rounds).map(once).collect())
}

/// What a section of two like tasks takes beside their time, on two threads, after so many
/// nanoseconds without one.
fn beside_its_tasks(exec: Exec, idle: f64) -> f64 {
    const WORK: Duration = Duration::from_micros(30);
    work_for(Duration::from_nanos(idle as u64));
    let (time, ()) = timing::time(|| exec.tasks(2, |_| work_for(WORK)));
    time.saturating_sub(WORK).as_secs_f64() * 1e9
}

fn work_for(time: Duration) {
    let begun = Instant::now();
    while begun.elapsed() < time {
        std::hint::spin_loop();
    }
}

impl Seen {
    fn forecast(&self, workers: usize) -> Forecast {
        forecast(&self.program, workers, &self.charges)
    }

    /// By how much of the measured time the forecast for two threads is off.
    fn error(&self) -> f64 {
        let measured = self.measured[WHOLE].a.median.as_secs_f64() * 1e9;
        self.forecast(2).time() / measured - 1.0
    }
}

/// Draws what is there.
pub(crate) fn show(cases: &[Case], units: &Units, report: &mut Report) -> Result<()> {
    report.heading("Work and span");
    NOTES.into_iter().for_each(|note| report.note(note));
    let seen = cases.iter().filter_map(|case| Some((case, units.get::<Seen>(&key(case))?)));
    let seen: Vec<(&Case, Seen)> = seen.collect();
    report.table(parts(&seen)?);
    report.table(two_threads(&seen)?);
    for (case, seen) in &seen {
        let (error, bound) = (100.0 * seen.error(), 100.0 * TOLERANCE);
        let held = if seen.error().abs() <= TOLERANCE { "within" } else { "NOT within" };
        report.note(format!(
            "{}: the forecast for two threads is off by {error:+.1} %, {held} the required {bound:.0} %.",
            case.key()
        ));
    }
    report.table(workers(&seen)?);
    report.figure(figure(&seen)?);
    report.table(limits(&seen)?);
    report.attach("span", seen.iter().map(|(case, seen)| object(case, seen)).collect());
    Ok(())
}

const NOTES: [&str; 3] = [
    "The time of every task is recorded in steps on one thread, and the serial work between \
     sections; piece by piece the median of the rounds. The schedule runs section after section, \
     as the step does, with a barrier between; whoever is free takes the next task. A task is \
     charged with what an empty task costs, and its time with the slow-down that the tasks of its \
     stage showed at two threads; a worker joins a section after what the other of two threads took \
     for that when it had been idle as long, times log2 of the workers: many microseconds for one \
     that sleeps, as all do before a step, next to nothing for one that has worked in the step, for \
     it stays awake. All three are measured in the same run.",
    "A parallel sort is no set of tasks: it is taken as a quicksort whose every level takes as long \
     as the others, and charged with its longest chain and a fair share of the rest.",
    "What is assumed and not measured: that the slow-down at many threads is that at two, which \
     holds as long as memory has more channels for more cores.",
];

fn named(case: &Case) -> Vec<Cell> {
    vec![case.name().into(), case.objects().into()]
}

/// What each stage consists of.
fn parts(seen: &[(&Case, Seen)]) -> Result<Table> {
    let time = |name: &str| Column::new(name).unit("ms");
    let mut columns = ["scene", "N", "stage"].map(Column::new).to_vec();
    columns.extend([time("work"), time("of it serial"), Column::new("tasks")]);
    columns.push(Column::new("longest task").unit("µs").decimals(1));
    columns.push(Column::new("slow-down at two").unit("×").decimals(2));
    columns.extend(
        ["a task's overhead", "joining, awake", "joining, asleep"]
            .map(|name| Column::new(name).unit("µs").decimals(2)),
    );
    let mut table = Table::new("parts", "What a step consists of", columns);
    for (case, Seen { program, charges, .. }) in seen {
        for (stage, part) in PARTS.into_iter().enumerate().take(STAGES) {
            let mut row = named(case);
            row.push(part.into());
            row.extend([program.work(stage), program.serial(stage)].map(|ns| Cell::from(ns / 1e6)));
            row.push(program.tasks(stage).into());
            row.push((program.longest(stage) / 1e3).into());
            row.push(charges.slowdown[stage].into());
            let awake = charges.joining.into_iter().fold(0.0, f64::max);
            row.extend([charges.task, awake, charges.waking].map(|ns| Cell::from(ns / 1e3)));
            table.push(row)?;
        }
    }
    Ok(table)
}

/// The forecast for two threads beside what they take.
fn two_threads(seen: &[(&Case, Seen)]) -> Result<Table> {
    let time = |name: &str| Column::new(name).unit("ms");
    let mut columns = ["scene", "N", "stage"].map(Column::new).to_vec();
    columns.extend(["one thread", "two threads", "two, forecast"].map(time));
    columns.push(Column::new("off by").unit("%").decimals(1));
    columns.push(Column::new("speed-up").unit("×").decimals(2));
    let mut table = Table::new("two-threads", "Two threads, measured and forecast", columns);
    for (case, seen) in seen {
        let forecast = seen.forecast(2);
        for (k, part) in PARTS.into_iter().enumerate() {
            let ns = if k == WHOLE { forecast.time() } else { forecast.stages[k] };
            let Pair { a, b, ratio, .. } = seen.measured[k];
            let off = 100.0 * (ns / (a.median.as_secs_f64() * 1e9) - 1.0);
            let mut row = named(case);
            row.push(part.into());
            row.extend([b.median, a.median].map(Cell::from));
            row.extend([ns / 1e6, off, ratio].map(Cell::from));
            table.push(row)?;
        }
    }
    Ok(table)
}

/// The schedule on each number of workers.
fn workers(seen: &[(&Case, Seen)]) -> Result<Table> {
    let mut columns = ["scene", "N", "workers"].map(Column::new).to_vec();
    columns.push(Column::new("time").unit("ms"));
    columns.push(Column::new("speed-up").unit("×").decimals(1));
    columns.push(Column::new("efficiency").decimals(2));
    columns.push(Column::new("most is lost to"));
    let mut table = Table::new("workers", "The step on many workers, forecast", columns);
    for (case, seen) in seen {
        for count in WORKERS {
            let forecast = seen.forecast(count);
            let mut row = named(case);
            row.push(count.into());
            let numbers = [forecast.time() / 1e6, forecast.speedup(), forecast.efficiency()];
            row.extend(numbers.map(Cell::from));
            row.push(limit(&seen.program, &forecast));
            table.push(row)?;
        }
    }
    Ok(table)
}

/// The greatest loss of all stages, in words.
fn limit(program: &Program, forecast: &Forecast) -> Cell {
    let of_stage = |stage: usize| {
        let named = Losses::NAMES.into_iter().zip(forecast.losses[stage].each());
        named.map(move |(name, loss)| (loss, name, stage))
    };
    let all = (0..STAGES).flat_map(of_stage);
    match all.max_by(|a, b| a.0.total_cmp(&b.0)) {
        Some((loss, name, stage)) if loss > 0.0 => {
            let share = 100.0 * loss / forecast.time();
            let (part, tasks) = (PARTS[stage], program.tasks(stage));
            format!("{part}: {name}, {share:.0} % of the step ({tasks} tasks)").into()
        }
        _ => Cell::Missing,
    }
}

/// What each stage loses.
fn limits(seen: &[(&Case, Seen)]) -> Result<Table> {
    let mut columns = ["scene", "N", "workers", "stage"].map(Column::new).to_vec();
    columns.push(Column::new("time").unit("ms"));
    columns.push(Column::new("fair share").unit("ms"));
    columns.extend(Losses::NAMES.map(|name| Column::new(name).unit("ms")));
    let mut table = Table::new("limits", "What keeps each stage from its fair share", columns);
    for (case, seen) in seen {
        for count in SHOWN {
            let forecast = seen.forecast(count);
            for (stage, part) in PARTS.into_iter().enumerate().take(STAGES) {
                let mut row = named(case);
                row.extend([count.into(), part.into()]);
                let fair = seen.program.work(stage) / count as f64;
                row.extend([forecast.stages[stage], fair].map(|ns| Cell::from(ns / 1e6)));
                row.extend(forecast.losses[stage].each().map(|ns| Cell::from(ns / 1e6)));
                table.push(row)?;
            }
        }
    }
    Ok(table)
}

fn figure(seen: &[(&Case, Seen)]) -> Result<Figure> {
    let (x, y) = (Axis::logarithmic("workers"), Axis::logarithmic("speed-up"));
    let mut figure = Figure::new("workers", "Forecast speed-up over one thread", x, y);
    for (case, seen) in seen {
        let points = WORKERS.map(|count| (count as f64, seen.forecast(count).speedup()));
        figure.push(Series::measured(case.key(), points))?;
    }
    figure.push(Series::measured("ideal", WORKERS.map(|count| (count as f64, count as f64))))?;
    Ok(figure)
}

fn object(case: &Case, seen: &Seen) -> Value {
    let forecasts: Vec<Value> = WORKERS
        .iter()
        .map(|&count| {
            let forecast = seen.forecast(count);
            json!({
                "workers": count,
                "ms": forecast.time() / 1e6,
                "speedup": forecast.speedup(),
                "efficiency": forecast.efficiency(),
                "limit": limit(&seen.program, &forecast).to_json(),
            })
        })
        .collect();
    json!({
        "scene": case.name(),
        "objects": case.objects(),
        "measured_two_threads": {
            "ms": seen.measured[WHOLE].a.median.as_secs_f64() * 1e3,
            "speedup": seen.measured[WHOLE].ratio,
            "rounds": seen.measured[WHOLE].a.runs,
        },
        "forecast_error_at_two": seen.error(),
        "charges_ns": {
            "task": seen.charges.task,
            "waking": seen.charges.waking,
            "idle": IDLE,
            "joining": seen.charges.joining,
        },
        "slowdown": Stage::ALL.map(|stage| seen.charges.slowdown[stage as usize]),
        "forecasts": forecasts,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_scene_is_recorded_whole_and_forecast() -> Result<()> {
        let case = Case::new("sparse", 3000, 1)?;
        let scene = case.scene()?;
        let seen = on_threads(2, || see(scene, 3))?;
        for stage in 0..STAGES {
            assert!(seen.program.work(stage) > 0.0 && seen.charges.slowdown[stage] >= 1.0);
        }
        assert!(seen.program.tasks(Stage::Boxes as usize) > 1);
        assert!(seen.charges.task > 0.0 && seen.error().is_finite());
        let speedups = WORKERS.map(|count| seen.forecast(count).speedup());
        assert!((1..WORKERS.len()).all(|k| speedups[k] <= WORKERS[k] as f64 + 1e-9));
        assert!((speedups[0] - 1.0).abs() < 1e-9);
        Ok(())
    }
}
