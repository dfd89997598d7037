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
            Share::of_scene(&scene.context("a scene")?, first, |shape| first + shape as u64)?;
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

/// Into how many slabs each axis is cut by so many ranks, a power of two: each axis in turn is halved.
fn slabs(ranks: usize) -> [f64; 3] {
    let halvings = ranks.max(1).ilog2();
    [0, 1, 2].map(|axis| f64::from(1u32 << ((halvings + 2 - axis) / 3)))
}

/// What was fitted: how large boxes are, by the world's edge, is this by the cube root of their number.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fitted {
    size: f64,
    pub(crate) bytes_a_ghost: f64,
}

impl Fitted {
    /// Ghosts of all ranks: along an axis cut by p planes a box meets 1 + p·size slabs on average.
    pub(crate) fn ghosts(self, objects: f64, ranks: usize) -> f64 {
        let size = self.size / objects.cbrt();
        let met = slabs(ranks).map(|slabs| 1.0 + (slabs - 1.0) * size);
        objects * (met.iter().product::<f64>() - 1.0)
    }
}

/// The size that gives as many ghosts at the fitted numbers of ranks as were found, by bisection.
fn fit(options: &Options, units: &Units) -> Option<Fitted> {
    let objects = model_objects(options);
    let known: Option<Vec<Ghosts>> =
        FITTED.into_iter().map(|ranks| units.get(&key(objects, ranks))).collect();
    let known = known?;
    let ghosts: f64 = known.iter().map(|found| found.ghosts as f64).sum();
    let bytes: f64 = known.iter().map(|found| found.sent_bytes as f64).sum();
    let of = |size: f64| Fitted { size, bytes_a_ghost: bytes / ghosts };
    let by_model = |size: f64| {
        FITTED.into_iter().map(|ranks| of(size).ghosts(objects as f64, ranks)).sum::<f64>()
    };
    let (mut low, mut high) = (0.0, 100.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if by_model(middle) < ghosts { low = middle } else { high = middle }
    }
    Some(of(low))
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
        Column::new("slabs"),
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
            Cell::from(slabs(ranks).map(|slabs| slabs.to_string()).join(" × ")),
            Cell::from(found.ghosts),
            Cell::Number(ghosts),
            Cell::Number(100.0 * (ghosts / known - 1.0)),
            Cell::Number(sent / 1e3),
            Cell::Number(bytes / 1e3),
            Cell::Number(100.0 * (bytes / sent - 1.0)),
        ])?;
    }
    report.note(format!(
        "The model: {objects} objects uniform in a cube that is cut into slabs along each axis; a box {:.2}·N^(-1/3) \
         of the cube's edge long meets 1 + p times that of p + 1 slabs, and is a ghost in all but one of the ranks' \
         boxes that it meets; {:.0} bytes a ghost and step. Both numbers are fitted at 2 and 4 ranks; at 1 there is \
         no ghost.",
        fitted.size, fitted.bytes_a_ghost
    ));
    report.table(table);
    Ok(Some(fitted))
}
