//! One slab of 200 × 200 × 1 among the hulls.

use anyhow::Result;
use dcd_benches::{Agreement, Column, Report, Table, Units};
use dcd_broad::TreePairs;
use dcd_bvh::{BinaryTree, BoundingTree, BuildTree, NodeContent, PaperTree};
use dcd_exec::Par;
use dcd_geom::{Aabb, Scene};
use dcd_io::{RawObject, RawScene, RawShape};
use dcd_pipeline::Pipeline;
use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

use crate::case::{Case, Setting, spec};
use crate::table1::Preset;
use crate::variant::{Job, Timed, double_phase};

/// Half of the slab's edges, metres: through the middle of the scene, without rotation.
const HALF: DVec3 = DVec3::new(100.0, 100.0, 0.5);

/// One pipeline without the slab and with it.
#[derive(Debug, Serialize, Deserialize)]
struct Spoilt {
    before: Step,
    after: Step,
}

#[derive(Debug, Serialize, Deserialize)]
struct Step {
    /// Of the paper's tree; our tree's leaves hold sixteen at most.
    largest_leaf: Option<u64>,
    timed: Timed,
}

fn key(preset: Preset) -> String {
    format!("claims/slab/{}", preset.name())
}

pub(super) fn plan() -> Vec<String> {
    Preset::ALL.map(key).to_vec()
}

pub(super) fn measure(setting: &Setting, units: &mut Units) -> Result<()> {
    for preset in Preset::ALL {
        units.run(&key(preset), || {
            let mut raw = spec(setting.seed, setting.largest()).raw()?;
            let before = step_of(preset, setting, &Case::new(raw.clone().into_scene()?));
            add_slab(&mut raw);
            let after = step_of(preset, setting, &Case::new(raw.into_scene()?));
            Ok(Spoilt { before, after })
        })?;
    }
    Ok(())
}

fn add_slab(raw: &mut RawScene) {
    let (rotation, translation) = (DQuat::IDENTITY, DVec3::ZERO);
    raw.objects.push(RawObject { shape: raw.shapes.len() as u32, rotation, translation });
    raw.shapes.push(RawShape::Cuboid { half_extents: HALF });
}

fn step_of(preset: Preset, setting: &Setting, case: &Case) -> Step {
    let job = Job { setting, case, exec: Par::WarmPool.into() };
    let of_tree = |broad: TreePairs<PaperTree>| Step {
        largest_leaf: Some(largest_leaf(broad.builder, &case.scene)),
        timed: job.pipeline(double_phase(broad)),
    };
    match preset {
        Preset::AsWritten => of_tree(TreePairs::paper_as_written()),
        Preset::AsCoded => of_tree(TreePairs::paper_as_coded()),
        Preset::Ours => Step { largest_leaf: None, timed: job.pipeline(Pipeline::new()) },
    }
}

/// How many AABBs the fullest leaf holds.
fn largest_leaf(builder: PaperTree, scene: &Scene) -> u64 {
    let aabbs: Vec<Aabb> = (0..scene.len()).map(|i| scene.aabb(i)).collect();
    let mut tree = BinaryTree::default();
    builder.build(&aabbs, Par::WarmPool.into(), &mut tree);
    let mut largest = 0;
    let mut rest: Vec<u32> = tree.root().into_iter().collect();
    while let Some(number) = rest.pop() {
        match tree.node(number).below {
            NodeContent::Nodes(children) => rest.extend(children),
            NodeContent::Boxes(boxes) => largest = largest.max(boxes.len() as u64),
        }
    }
    largest
}

/// How the contacts stand with the slab, as far as they are known.
pub(super) fn agreements(units: &Units) -> Vec<(String, Agreement)> {
    let agreement = |preset: Preset| {
        let spoilt: Spoilt = units.get(&key(preset))?;
        Some((key(preset), spoilt.after.timed.agreement))
    };
    Preset::ALL.into_iter().filter_map(agreement).collect()
}

pub(super) fn draw(setting: &Setting, units: &Units, report: &mut Report) -> Result<()> {
    let columns = [
        Column::new("pipeline"),
        Column::new("largest leaf, without"),
        Column::new("with"),
        Column::new("candidates, without"),
        Column::new("with"),
        Column::new("step, without").unit("ms"),
        Column::new("with").unit("ms"),
        Column::new("slower").decimals(2),
    ];
    let title = format!("One slab of 200 × 200 × 1 among {} hulls", setting.largest());
    let mut table = Table::new("slab", title, columns);
    for preset in Preset::ALL {
        let spoilt: Option<Spoilt> = units.get(&key(preset));
        let [before, after] =
            [spoilt.as_ref().map(|s| &s.before), spoilt.as_ref().map(|s| &s.after)];
        let seconds = |step: &Step| step.timed.sample.median.as_secs_f64();
        let slower = before.zip(after).map(|(before, after)| seconds(after) / seconds(before));
        table.push([
            preset.name().into(),
            before.and_then(|step| step.largest_leaf).into(),
            after.and_then(|step| step.largest_leaf).into(),
            before.map(|step| step.timed.candidates).into(),
            after.map(|step| step.timed.candidates).into(),
            before.map(|step| step.timed.sample.median).into(),
            after.map(|step| step.timed.sample.median).into(),
            slower.into(),
        ])?;
    }
    report.note(
        "The code takes axis and midpoint from the AABBs' extent and sorts by centroids, so that one \
         large AABB can put all centroids on one side; what cannot be split is a leaf. The text takes \
         both from the centroids. Steps are parallel.",
    );
    report.table(table);
    Ok(())
}
