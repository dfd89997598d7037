//! Figure 3: what is left of all pairs behind the broad phase.

use anyhow::Result;
use dcd_benches::{Axis, Column, Figure, Report, Series, Table, Units};
use dcd_broad::{BroadPhase, SweepAndPrune, TreePairs};
use dcd_exec::{Par, Segments};
use dcd_geom::{Aabb, Scene};
use serde::{Deserialize, Serialize};

use crate::case::{Cases, Setting, pairs_of};
use crate::published;

/// Candidate pairs of one scene, by the way of finding them.
#[derive(Debug, Serialize, Deserialize)]
struct Survivors {
    as_written: u64,
    as_coded: u64,
    /// Those whose own AABBs overlap, by a sweep that shares nothing with the trees.
    overlapping: u64,
}

fn key(objects: usize) -> String {
    format!("fig3/N={objects}")
}

pub(crate) fn plan(setting: &Setting) -> Vec<String> {
    setting.sizes.iter().map(|&objects| key(objects)).collect()
}

pub(crate) fn measure(setting: &Setting, units: &mut Units, cases: &mut Cases) -> Result<()> {
    for &objects in setting.sizes {
        units.run(&key(objects), || {
            let scene = &cases.get(objects)?.scene;
            Ok(Survivors {
                as_written: candidates(scene, TreePairs::paper_as_written()),
                as_coded: candidates(scene, TreePairs::paper_as_coded()),
                overlapping: candidates(scene, SweepAndPrune::default()),
            })
        })?;
    }
    Ok(())
}

/// How many candidates a broad phase finds among the scene's boxes.
pub(crate) fn candidates(scene: &Scene, mut broad: impl BroadPhase) -> u64 {
    let aabbs: Vec<Aabb> = (0..scene.len()).map(|i| scene.aabb(i)).collect();
    let mut found = Segments::default();
    broad.build(&aabbs, Par::Pool.into());
    broad.pairs(&aabbs, |_, _| true, Par::Pool.into(), &mut found);
    found.len() as u64
}

pub(crate) fn draw(setting: &Setting, units: &Units, report: &mut Report) -> Result<()> {
    let percent = Axis::linear("candidates of all pairs [%]");
    let title = "Figure 3: survivors of the broad phase";
    let mut figure = Figure::new("fig3", title, Axis::logarithmic("objects N"), percent);
    let share = |objects: usize, count: u64| {
        (objects as f64, 100.0 * count as f64 / pairs_of(objects) as f64)
    };
    let measured = |of: fn(&Survivors) -> u64| {
        setting.sizes.iter().filter_map(move |&objects| {
            let survivors: Survivors = units.get(&key(objects))?;
            Some(share(objects, of(&survivors)))
        })
    };
    figure.push(Series::measured("per leaf, as coded", measured(|s| s.as_coded)))?;
    figure.push(Series::measured("per leaf, as written", measured(|s| s.as_written)))?;
    figure.push(Series::measured("per pair", measured(|s| s.overlapping)))?;
    let published = published::FIGURE_3.into_iter().map(|(objects, count)| share(objects, count));
    figure.push(Series::published("per leaf, as coded", published))?;

    report.heading("Figure 3: survivors of the broad phase");
    report.note(
        "Per leaf, every pair of two overlapping leaves is a candidate, as in the paper; per pair, \
         those whose own AABBs overlap. That share hardly depends on N, since the scene is as large \
         for every N: what declines in the paper's figure is the looseness of leaves, which shrink \
         as N grows. Its scene and ours are two draws of one distribution.",
    );
    report.figure(figure);
    report.table(table(setting, units)?);
    Ok(())
}

fn table(setting: &Setting, units: &Units) -> Result<Table> {
    let columns = [
        Column::new("N"),
        Column::new("pairs"),
        Column::new("per leaf, as written"),
        Column::new("per leaf, as coded"),
        Column::new("per pair"),
        Column::new("per leaf").published(),
    ];
    let mut table = Table::new("survivors", "Candidate pairs", columns);
    for &objects in setting.sizes {
        let survivors: Option<Survivors> = units.get(&key(objects));
        let count = |of: fn(&Survivors) -> u64| survivors.as_ref().map(of).into();
        let published = published::FIGURE_3.into_iter().find(|(size, _)| *size == objects);
        table.push([
            objects.into(),
            pairs_of(objects).into(),
            count(|s| s.as_written),
            count(|s| s.as_coded),
            count(|s| s.overlapping),
            published.map(|(_, count)| count).into(),
        ])?;
    }
    Ok(table)
}
