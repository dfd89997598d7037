//! Queries through the whole step: the same answers at any number of threads, and step after step.
#![allow(missing_docs)]

use dcd_broad::WideTree;
use dcd_exec::with_threads;
use dcd_geom::Scene;
use dcd_gjk::{
    Contact, Depths, Distances, Manifolds, NarrowPhase, PairSolver, Proximities, ThenMeasure,
    Within,
};
use dcd_pipeline::{Par, Pipeline};
use dcd_scenes::SceneSpec;

fn scene() -> Scene {
    SceneSpec::parse("paper").unwrap().with_objects(300).with_seed(5).scene().unwrap()
}

fn answers<N: NarrowPhase + Send>(narrow: N, scene: &Scene, par: Par) -> Vec<Contact<N::Answer>> {
    let mut pipeline = Pipeline::with(WideTree::default(), narrow);
    let first: Vec<_> = pipeline.step(scene, par).answers().collect();
    let second: Vec<_> = pipeline.step(scene, par).answers().collect();
    assert_eq!(first.len(), second.len());
    second
}

fn are_the_same_at_any_number_of_threads<S>(solver: S)
where
    S: PairSolver<Answer: PartialEq + std::fmt::Debug> + Copy + Send + 'static,
{
    let scene = scene();
    let run = |par| answers(ThenMeasure::new(solver).unwrap(), &scene, par);
    let serial = run(Par::Serial);
    assert!(serial.len() > 100, "{}", serial.len());
    for threads in [1, 2, 5] {
        assert_eq!(with_threads(threads, || run(Par::Pool)).unwrap(), serial);
    }
}

#[test]
fn every_query_reports_the_same_at_any_number_of_threads() {
    are_the_same_at_any_number_of_threads(Depths);
    are_the_same_at_any_number_of_threads(Manifolds);
    are_the_same_at_any_number_of_threads(Distances::within(0.05).unwrap());
    are_the_same_at_any_number_of_threads(Proximities::within(0.05).unwrap());
}

#[test]
fn a_margin_finds_more_pairs_and_all_of_the_touching_ones() {
    let scene = scene();
    let pairs = |margin: f64| -> Vec<_> {
        let contacts = answers(Within::margin(margin).unwrap(), &scene, Par::Serial);
        let mut pairs: Vec<_> = contacts.iter().map(|contact| contact.pair).collect();
        pairs.sort_unstable();
        pairs
    };
    let (touching, near) = (pairs(0.0), pairs(0.05));
    assert!(near.len() > touching.len());
    assert!(touching.iter().all(|pair| near.binary_search(pair).is_ok()));
}
