//! Ghosts: how their share falls with the number of objects, and a model of them.

use anyhow::{Context, Result};
use dcd_benches::{Cell, Column, Options, Report, Table, Units};
use dcd_exec::Par;
use dcd_pipeline::Question;
use dcd_ranks::{RankScene, Share, Transport, threads};
use dcd_scenes::SceneSpec;
use serde::{Deserialize, Serialize};

/// All ranks together, in a step whose shapes are known; the first step apart.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Ghosts {
    pub(crate) ghosts: u64,
    pub(crate) sent_bytes: u64,
    pub(crate) first_sent_bytes: u64,
}

const SIZE_RANKS: usize = 8;
const MODEL_RANKS: [usize; 5] = [2, 4, 8, 16, 64];
/// The model is fitted at these.
const FITTED: [usize; 2] = [2, 4];

fn sizes(options: &Options) -> [usize; 4] {
    if options.quick { [500, 1_000, 2_000, 4_000] } else { [15_625, 62_500, 250_000, 1_000_000] }
}

/// The objects of the model's rows.
fn model_objects(options: &Options) -> usize {
    if options.quick { 4_000 } else { 1_000_000 }
}

fn key(objects: usize, ranks: usize) -> String {
    format!("ghosts/N={objects}/ranks={ranks}")
}

fn cases(options: &Options) -> Vec<(usize, usize)> {
    let mut cases: Vec<(usize, usize)> =
        sizes(options).into_iter().map(|objects| (objects, SIZE_RANKS)).collect();
    cases.extend(MODEL_RANKS.into_iter().map(|ranks| (model_objects(options), ranks)));
    cases.sort_unstable();
    cases.dedup();
    cases
}

pub(crate) fn plan(options: &Options) -> Vec<String> {
    cases(options).into_iter().map(|(objects, ranks)| key(objects, ranks)).collect()
}

pub(crate) fn measure(options: &Options, units: &mut Units) -> Result<()> {
    for (objects, ranks) in cases(options) {
        units.run(&key(objects, ranks), || counted(objects, ranks, options.seed))?;
    }
    Ok(())
}

fn counted(objects: usize, size: usize, seed: u64) -> Result<Ghosts> {
    let spec = SceneSpec::sparse().with_objects(objects).with_seed(seed);
    let found = threads::run(size, |rank| -> Result<Ghosts> {
        let part = |rank: usize| objects * rank / size;
        let range = part(rank.rank())..part(rank.rank() + 1);
        let first = range.start as u64;
        let scene =
            spec.share_by(range, &dcd_io::run::in_order)?.into_scene_by(&dcd_io::run::in_order);
        let share =
            Share::of_scene(&scene.context("a scene")?, first, |shape| first + shape as u64);
        let mut ranked = RankScene::new(rank, share, Question::default())?;
        let sent = || rank.traffic().sent;
        let before = sent();
        ranked.refresh(Par::Serial)?;
        let first = sent();
        ranked.refresh(Par::Serial)?;
        Ok(Ghosts {
            ghosts: ranked.ghost_count() as u64,
            sent_bytes: sent() - first,
            first_sent_bytes: first - before,
        })
    });
    let mut all = Ghosts { ghosts: 0, sent_bytes: 0, first_sent_bytes: 0 };
    for rank in found {
        let rank = rank?;
        all.ghosts += rank.ghosts;
        all.sent_bytes += rank.sent_bytes;
        all.first_sent_bytes += rank.first_sent_bytes;
    }
    Ok(all)
}

/// How many planes through the whole world cut it into so many equal boxes, a power of two: each axis in turn
/// is halved.
pub(crate) fn planes(ranks: usize) -> f64 {
    let halvings = ranks.max(1).ilog2();
    (0..3).map(|axis| f64::from((1u32 << ((halvings + 2 - axis) / 3)) - 1)).sum()
}

/// What was fitted: for each plane through a world of N objects these times N^(2/3).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fitted {
    pub(crate) ghosts: f64,
    pub(crate) bytes_a_ghost: f64,
}

impl Fitted {
    /// Ghosts of all ranks.
    pub(crate) fn ghosts(self, objects: f64, ranks: usize) -> f64 {
        self.ghosts * planes(ranks) * objects.powf(2.0 / 3.0)
    }
}

fn fit(options: &Options, units: &Units) -> Option<Fitted> {
    let objects = model_objects(options);
    let known: Option<Vec<(usize, Ghosts)>> =
        FITTED.into_iter().map(|ranks| Some((ranks, units.get(&key(objects, ranks))?))).collect();
    let known = known?;
    let sum = |of: &dyn Fn(&(usize, Ghosts)) -> f64| known.iter().map(of).sum::<f64>();
    let ghosts = sum(&|(_, found)| found.ghosts as f64);
    let surface = sum(&|(ranks, _)| planes(*ranks)) * (objects as f64).powf(2.0 / 3.0);
    let bytes_a_ghost = sum(&|(_, found)| found.sent_bytes as f64) / ghosts;
    Some(Fitted { ghosts: ghosts / surface, bytes_a_ghost })
}

pub(crate) fn show(
    options: &Options,
    units: &Units,
    report: &mut Report,
) -> Result<Option<Fitted>> {
    let columns = [
        Column::new("N"),
        Column::new("ghosts"),
        Column::new("of all objects").unit("%").decimals(2),
        Column::new("share × N^(1/3)").decimals(2),
        Column::new("sent in a step").unit("kB").decimals(1),
        Column::new("sent in the first").unit("kB").decimals(1),
    ];
    let mut table = Table::new("surface", "Ghosts at 8 ranks", columns);
    for objects in sizes(options) {
        let Some(found) = units.get::<Ghosts>(&key(objects, SIZE_RANKS)) else { continue };
        let share = found.ghosts as f64 / objects as f64;
        table.push([
            Cell::from(objects as u64),
            Cell::from(found.ghosts),
            Cell::Number(100.0 * share),
            Cell::Number(share * (objects as f64).cbrt()),
            Cell::Number(found.sent_bytes as f64 / 1e3),
            Cell::Number(found.first_sent_bytes as f64 / 1e3),
        ])?;
    }
    report.heading("Ghosts are on the surface");
    report.note(
        "The scene `sparse`, whose density stays about the same; ranks are threads, which changes no count. As the \
         surface, the share falls with the cube root of the number of objects. The first step sends the shapes too.",
    );
    report.table(table);
    let Some(fitted) = fit(options, units) else { return Ok(None) };
    let columns = [
        Column::new("ranks"),
        Column::new("planes"),
        Column::new("ghosts"),
        Column::new("by the model").decimals(0),
        Column::new("off by").unit("%").decimals(1),
        Column::new("sent").unit("kB").decimals(1),
        Column::new("by the model ").unit("kB").decimals(1),
        Column::new("off by ").unit("%").decimals(1),
    ];
    let mut table = Table::new("model", "The model of ghosts", columns);
    let objects = model_objects(options);
    for ranks in MODEL_RANKS {
        let Some(found) = units.get::<Ghosts>(&key(objects, ranks)) else { continue };
        let ghosts = fitted.ghosts(objects as f64, ranks);
        let bytes = ghosts * fitted.bytes_a_ghost;
        let (known, sent) = (found.ghosts as f64, found.sent_bytes as f64);
        table.push([
            Cell::from(ranks as u64),
            Cell::Number(planes(ranks)),
            Cell::from(found.ghosts),
            Cell::Number(ghosts),
            Cell::Number(100.0 * (ghosts / known - 1.0)),
            Cell::Number(sent / 1e3),
            Cell::Number(bytes / 1e3),
            Cell::Number(100.0 * (bytes / sent - 1.0)),
        ])?;
    }
    report.note(format!(
        "The model, of {objects} objects in a cube: ghosts = {:.2} · planes · N^(2/3), the planes being those that cut \
         the cube into the ranks' boxes (1 for 2 ranks, 2 for 4, 3 for 8, 9 for 64), and {:.0} bytes a ghost and step. \
         Fitted at 2 and 4 ranks; at 1 there is no ghost.",
        fitted.ghosts, fitted.bytes_a_ghost
    ));
    report.table(table);
    Ok(Some(fitted))
}
