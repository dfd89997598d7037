//! The same bytes at any thread count, from fresh buffers and from used ones.

use dcd_broad::{BroadPhase, SweepAndPrune, TreePairs, WideTree};
use dcd_exec::with_threads;
use dcd_geom::Scene;
use dcd_gjk::Overlap;
use dcd_pipeline::{Par, Pipeline};
use dcd_scenes::SceneSpec;

fn scene(objects: usize) -> Scene {
    SceneSpec::parse("paper").unwrap().with_objects(objects).with_seed(11).scene().unwrap()
}

/// Candidates and contacts in the order in which a step reports them.
type Reported = (Vec<(u32, u32)>, Vec<(u32, u32)>);

fn reported<B: BroadPhase>(
    pipeline: &mut Pipeline<B, Overlap>,
    scene: &Scene,
    par: Par,
) -> Reported {
    let step = pipeline.step(scene, par);
    (step.candidates().map(Into::into).collect(), step.contacts().collect())
}

fn the_order_is_one<B: BroadPhase + Send>(fresh: impl Fn() -> B + Sync) {
    let (large, small) = (scene(1500), scene(300));
    let serial = reported(&mut Pipeline::with(fresh(), Overlap::default()), &large, Par::Serial);
    for threads in [1, 2, 3, 7] {
        let again = with_threads(threads, || {
            let mut pipeline = Pipeline::with(fresh(), Overlap::default());
            let first = reported(&mut pipeline, &large, Par::Pool);
            // Used buffers, after a smaller scene, and serial after pooled.
            reported(&mut pipeline, &small, Par::Pool);
            [
                first,
                reported(&mut pipeline, &large, Par::Pool),
                reported(&mut pipeline, &large, Par::Serial),
            ]
        });
        for one in again.unwrap() {
            assert!(one == serial, "{threads} threads");
        }
    }
}

#[test]
fn the_wide_tree_reports_one_order_at_1_2_3_and_7_threads() {
    the_order_is_one(WideTree::default);
}

#[test]
fn both_paper_presets_report_one_order_at_1_2_3_and_7_threads() {
    the_order_is_one(TreePairs::paper_as_written);
    the_order_is_one(TreePairs::paper_as_coded);
}

#[test]
fn sweep_and_prune_reports_one_order_at_1_2_3_and_7_threads() {
    the_order_is_one(SweepAndPrune::default);
}
