//! Table 1: the four stages of the paper's two presets and of our default, serial and parallel.

use std::time::Duration;

use anyhow::Result;
use dcd_benches::{Agreement, Column, Pair, Report, Table, Units, timing};
use dcd_broad::{BroadPhase, TreePairs};
use dcd_exec::{Exec, Par};
use dcd_gjk::NarrowPhase;
use dcd_pipeline::{Pipeline, StageClock};
use serde::{Deserialize, Serialize};

use crate::case::{Case, Cases, Setting};
use crate::published;
use crate::variant::double_phase;

/// The four stages, and the whole.
const ROWS: [&str; 5] =
    ["AABBs", "BVH build", "broad-phase traversal", "narrow phase", "end to end"];

/// A pipeline that the tables show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Preset {
    /// The paper's, as its text has it.
    AsWritten,
    /// The paper's, as its code has it.
    AsCoded,
    /// Our default.
    Ours,
}

impl Preset {
    pub(crate) const ALL: [Self; 3] = [Self::AsWritten, Self::AsCoded, Self::Ours];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::AsWritten => "as written",
            Self::AsCoded => "as coded",
            Self::Ours => "our default",
        }
    }

    fn key(self) -> String {
        format!("table1/{}", self.name())
    }
}

/// Serial (`b`) beside parallel (`a`) for each row.
#[derive(Debug, Serialize, Deserialize)]
struct Stages {
    rows: Vec<Pair>,
    agreement: Agreement,
}

pub(crate) fn plan() -> Vec<String> {
    Preset::ALL.map(Preset::key).to_vec()
}

pub(crate) fn measure(setting: &Setting, units: &mut Units, cases: &mut Cases) -> Result<()> {
    for preset in Preset::ALL {
        units.run(&preset.key(), || {
            let case = cases.get(setting.largest())?;
            Ok(match preset {
                Preset::AsWritten => {
                    stages(setting, case, || double_phase(TreePairs::paper_as_written()))
                }
                Preset::AsCoded => {
                    stages(setting, case, || double_phase(TreePairs::paper_as_coded()))
                }
                Preset::Ours => stages(setting, case, <Pipeline>::default),
            })
        })?;
    }
    Ok(())
}

/// Serial and parallel interleaved, each with buffers of its own.
fn stages<B, N>(setting: &Setting, case: &Case, new: impl Fn() -> Pipeline<B, N>) -> Stages
where
    B: BroadPhase,
    N: NarrowPhase<Answer = ()>,
{
    let (mut serial, mut parallel) = (new(), new());
    let (first, step) = timing::time(|| serial.step(&case.scene, Par::Serial));
    let agreement = case.agreement_of(step.contacts(), step.report());
    let rows = timing::pairs_of(
        setting.effort.runs(first),
        || observed(&mut parallel, case, Par::WarmPool),
        || observed(&mut serial, case, Par::Serial),
    );
    Stages { rows: rows.to_vec(), agreement }
}

/// The times of one step's stages, and of the whole.
fn observed<B, N>(pipeline: &mut Pipeline<B, N>, case: &Case, par: Par) -> [Duration; 5]
where
    B: BroadPhase,
    N: NarrowPhase<Answer = ()>,
{
    let clock = StageClock::default();
    let exec = Exec::observed(par, &clock);
    let (whole, _) = timing::time(|| pipeline.step(&case.scene, exec).contact_count());
    let [boxes, build, pairs, narrow] = clock.take();
    [boxes, build, pairs, narrow, whole]
}

pub(crate) fn draw(setting: &Setting, units: &Units, report: &mut Report) -> Result<()> {
    let objects = setting.largest();
    let ms = |name: &str| Column::new(name).unit("ms");
    let columns = [
        Column::new("pipeline"),
        Column::new("stage"),
        ms("serial"),
        ms("parallel"),
        Column::new("speed-up").decimals(2),
        Column::new("runs"),
        ms("serial").published(),
        ms("parallel").published(),
        Column::new("speed-up").decimals(2).published(),
    ];
    let title = format!("Table 1: stages at N = {objects}");
    let mut table = Table::new("table1", title, columns);
    for preset in Preset::ALL {
        let stages: Option<Stages> = units.get(&preset.key());
        for (k, stage) in ROWS.into_iter().enumerate() {
            let row = stages.as_ref().and_then(|stages| stages.rows.get(k));
            let [serial, parallel] = published_row(preset, k);
            table.push([
                preset.name().into(),
                stage.into(),
                row.map(|pair| pair.b.median).into(),
                row.map(|pair| pair.a.median).into(),
                row.map(|pair| pair.ratio).into(),
                row.map(|pair| pair.a.runs).into(),
                serial.into(),
                parallel.into(),
                serial.zip(parallel).map(|(serial, parallel)| serial / parallel).into(),
            ])?;
        }
    }
    report.heading("Table 1: the stages");
    report.note(format!(
        "Serial is the same code on one thread; serial and parallel took turns, and the speed-up is \
         the median of the rounds' ratios. Both presets of the paper judge pairs by our GJK in f64, \
         one pair at a time; our default is certified, its first stage prepares the lanes' copies \
         of the vertices too. The paper's column is its code's, at N = {}, with its own GJK, on a \
         processor of 20 cores and 28 threads; its serial traversal is not the code of its parallel \
         one, so that its 4.09 mixes two effects.",
        published::OBJECTS
    ));
    report.table(table);
    Ok(())
}

/// What the paper prints for a row. Its code was measured: so it stands beside that preset.
fn published_row(preset: Preset, row: usize) -> [Option<f64>; 2] {
    if preset != Preset::AsCoded {
        return [None, None];
    }
    match published::TABLE_1.get(row) {
        Some(&(serial, parallel)) => [Some(serial), Some(parallel)],
        None => published::double_phase().map(Some),
    }
}

/// How the contacts of each preset stand, as far as they are known.
pub(crate) fn agreements(units: &Units) -> Vec<(String, Agreement)> {
    let agreement = |preset: Preset| {
        let stages: Stages = units.get(&preset.key())?;
        Some((preset.key(), stages.agreement))
    };
    Preset::ALL.into_iter().filter_map(agreement).collect()
}
