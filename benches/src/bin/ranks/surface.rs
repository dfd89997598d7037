//! Ghosts: how their share falls with the number of objects, and a model of them.

use anyhow::{Context, Result};
use dcd_benches::{Cell, Column, Options, Report, Table, Units};
use dcd_exec::Par;
use dcd_pipeline::Question;
use dcd_ranks::{RankScene, Share, Transport, threads};
use dcd_scenes::SceneSpec;
use serde::{Deserialize, Serialize};

use crate::model::{Fitted, World};

/// All ranks together, in a step whose shapes are known; the first step apart.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Ghosts {
    pub(crate) ghosts: u64,
    pub(crate) sent_bytes: u64,
    pub(crate) first_sent_bytes: u64,
    /// The edge of the cube in which the objects lie, metres.
    pub(crate) edge: f64,
}

const SIZE_RANKS: usize = 8;
const MODEL_RANKS: [usize; 5] = [2, 4, 8, 16, 64];
/// The model is fitted at these.
const FITTED: [usize; 2] = [2, 4];

fn sizes(options: &Options) -> [usize; 4] {
    if options.quick { [250, 500, 1_000, 2_000] } else { [15_625, 62_500, 250_000, 1_000_000] }
}

/// The objects of the model's rows; it is fitted at the most.
fn model_objects(options: &Options) -> Vec<usize> {
    if options.quick { vec![1_000] } else { vec![62_500, 250_000, 1_000_000] }
}

fn key(objects: usize, ranks: usize) -> String {
    format!("ghosts/N={objects}/ranks={ranks}")
}

fn cases(options: &Options) -> Vec<(usize, usize)> {
    let mut cases: Vec<(usize, usize)> =
        sizes(options).into_iter().map(|objects| (objects, SIZE_RANKS)).collect();
    cases.extend(
        model_objects(options)
            .into_iter()
            .flat_map(|objects| MODEL_RANKS.into_iter().map(move |ranks| (objects, ranks))),
    );
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
        let scene = scene.context("a scene")?;
        let far = scene.poses().iter().map(|pose| pose.translation().abs().max_element());
        let edge = 2.0 * far.fold(0.0, f64::max);
        let share = Share::of_scene(&scene, first, |shape| first + shape as u64)?;
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
            edge,
        })
    });
    let mut all = Ghosts { ghosts: 0, sent_bytes: 0, first_sent_bytes: 0, edge: 0.0 };
    for rank in found {
        let rank = rank?;
        all.ghosts += rank.ghosts;
        all.sent_bytes += rank.sent_bytes;
        all.first_sent_bytes += rank.first_sent_bytes;
        all.edge = all.edge.max(rank.edge);
    }
    Ok(all)
}

/// The world whose ghosts at [`FITTED`] ranks the model is fitted to, and the model.
fn fit(options: &Options, units: &Units) -> Option<(World, Fitted)> {
    let objects = model_objects(options).into_iter().max()?;
    let known = FITTED.into_iter().map(|ranks| units.get::<Ghosts>(&key(objects, ranks)));
    let known = known.collect::<Option<Vec<_>>>()?;
    let ghosts: f64 = known.iter().map(|found| found.ghosts as f64).sum();
    let bytes: f64 = known.iter().map(|found| found.sent_bytes as f64).sum();
    let world = World { objects: objects as f64, edge: known[0].edge };
    Some((world, Fitted::of(world, &FITTED, ghosts, bytes)))
}

pub(crate) fn show(
    options: &Options,
    units: &Units,
    report: &mut Report,
) -> Result<Option<(World, Fitted)>> {
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
    let Some((world, fitted)) = fit(options, units) else { return Ok(None) };
    report.note(format!(
        "The model: boxes of {:.2} m, uniform in a cube as large as the scene's, are cut by the ranks' own rule, and \
         those that reach into other regions are counted; {:.0} bytes a ghost and step. Both numbers are fitted to 2 \
         and 4 ranks of {} objects; at 1 there is no ghost. No rank and no step of the others is needed to say these: \
         the boxes are others than the scene's, all of one size, and as many.",
        fitted.box_edge, fitted.bytes_a_ghost, world.objects
    ));
    report.table(by_model(options, units, fitted)?);
    Ok(Some((world, fitted)))
}

/// The model beside what was counted.
fn by_model(options: &Options, units: &Units, fitted: Fitted) -> Result<Table> {
    let columns = [
        Column::new("N"),
        Column::new("ranks"),
        Column::new("ghosts"),
        Column::new("by the model").decimals(0),
        Column::new("off by").unit("%").decimals(1),
        Column::new("sent").unit("kB").decimals(1),
        Column::new("by the model ").unit("kB").decimals(1),
        Column::new("off by ").unit("%").decimals(1),
    ];
    let mut table = Table::new("model", "The model of ghosts", columns);
    let rows = model_objects(options).into_iter();
    for (objects, ranks) in rows.flat_map(|objects| MODEL_RANKS.map(|ranks| (objects, ranks))) {
        let Some(found) = units.get::<Ghosts>(&key(objects, ranks)) else { continue };
        let world = World { objects: objects as f64, edge: found.edge };
        let ghosts = fitted.ghosts(world, ranks);
        let bytes = ghosts * fitted.bytes_a_ghost;
        let (known, sent) = (found.ghosts as f64, found.sent_bytes as f64);
        table.push([
            Cell::from(objects as u64),
            Cell::from(ranks as u64),
            Cell::from(found.ghosts),
            Cell::Number(ghosts),
            Cell::Number(100.0 * (ghosts / known - 1.0)),
            Cell::Number(sent / 1e3),
            Cell::Number(bytes / 1e3),
            Cell::Number(100.0 * (bytes / sent - 1.0)),
        ])?;
    }
    Ok(table)
}
