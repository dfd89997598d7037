//! The default pipeline against the slowest obvious one: every pair, exact integers where f64
//! cannot prove it.

use dcd_broad::{BruteForce, SweepAndPrune, WideTree};
use dcd_geom::glam::DVec3;
use dcd_geom::{Pose, Scene, Shape};
use dcd_gjk::{
    Accuracy, Certified, Gjk, Method, NarrowPhase, Overlap, Pairwise, SimdDistances, contract,
};
use dcd_pipeline::{BroadPhase, Par, Pipeline};
use dcd_scenes::SceneSpec;
use dcd_simd::Path;

/// Few enough objects for every pair to be judged, in volumes small enough for many to touch.
fn scenes() -> Vec<(String, Scene)> {
    let names = ["paper", "needles", "plates", "boxes", "big-and-small", "identical"];
    let bricks = ["bricks", "bricks-overlapping", "bricks-apart"];
    let seeded = names.into_iter().map(|name| (name, 150)).chain(bricks.map(|name| (name, 125)));
    let mut scenes: Vec<_> = seeded
        .map(|(name, objects)| {
            let spec = SceneSpec::parse(name).unwrap().with_objects(objects).with_seed(3);
            (name.to_owned(), spec.scene().unwrap())
        })
        .collect();
    scenes.push(("mixed".to_owned(), mixed()));
    scenes
}

/// Spheres, rounded boxes, flat, needle-like and single points in one place.
fn mixed() -> Scene {
    let paper = SceneSpec::parse("paper").unwrap().with_objects(60).with_seed(5).scene().unwrap();
    let shapes = (0..60).map(|k| {
        let hull = paper.shape(k).as_polytope().unwrap().clone();
        let squashed = |x: f64, y: f64, z: f64| {
            let scale = dcd_geom::glam::DVec3::new(x, y, z);
            Shape::hull(hull.vertices().iter().map(|&v| v * scale).collect()).unwrap()
        };
        match k % 6 {
            0 => Shape::sphere(0.3 + 0.01 * k as f64).unwrap(),
            1 => hull.rounded(0.1).unwrap().into(),
            2 => squashed(2.0, 2.0, 0.0),
            3 => squashed(0.0, 3.0, 0.0),
            4 => Shape::hull(vec![dcd_geom::glam::DVec3::splat(0.1)]).unwrap(),
            _ => hull.into(),
        }
    });
    let shapes = shapes.collect();
    let near = |pose: &Pose| Pose::from_matrix(*pose.rotation(), pose.translation() * 0.4).unwrap();
    Scene::one_each(shapes, paper.poses().iter().map(near).collect()).unwrap()
}

/// The sorted contacts of a step.
fn contacts(broad: impl BroadPhase, narrow: impl NarrowPhase, scene: &Scene) -> Vec<(u32, u32)> {
    let mut pipeline = Pipeline::with(broad, narrow);
    let step = pipeline.step(scene, Par::Serial);
    assert!(step.report().undecided().is_empty());
    let mut contacts: Vec<_> = step.contacts().collect();
    contacts.sort_unstable();
    contacts
}

#[test]
fn every_simd_path_gives_the_exact_answers() {
    for (name, scene) in scenes() {
        let truth = contacts(BruteForce, Pairwise(Certified), &scene);
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            let ours = contacts(WideTree::on(path), Overlap::on(path), &scene);
            assert_eq!(ours, truth, "{name} on {path:?}");
        }
    }
}

#[test]
fn every_broad_phase_leads_to_the_same_contacts() {
    for (name, scene) in scenes() {
        let wide = contacts(WideTree::default(), Overlap::default(), &scene);
        assert_eq!(contacts(SweepAndPrune::default(), Overlap::default(), &scene), wide, "{name}");
        assert_eq!(contacts(BruteForce, Overlap::default(), &scene), wide, "{name}");
    }
}

#[test]
fn the_narrow_phases_keep_the_contract() {
    for (name, scene) in scenes() {
        let mut pipeline = Pipeline::new();
        let pairs: Vec<_> = pipeline.step(&scene, Par::Serial).candidates().collect();
        let broken = |e| panic!("{name}: {e}");
        contract::narrow_phase(&Overlap::default(), &scene, &pairs).unwrap_or_else(broken);
        contract::narrow_phase(&Pairwise(Gjk::<f64>::default()), &scene, &pairs)
            .unwrap_or_else(broken);
    }
}

#[test]
fn f32_and_f64_without_the_exact_method_are_never_wrong_only_undecided() {
    for (name, scene) in scenes() {
        let truth = contacts(BruteForce, Pairwise(Certified), &scene);
        check(&name, Pairwise(Gjk::<f32>::default()), &scene, &truth);
        check(&name, Pairwise(Gjk::<f64>::default()), &scene, &truth);
    }
    fn check(name: &str, narrow: impl NarrowPhase, scene: &Scene, truth: &[(u32, u32)]) {
        let mut pipeline = Pipeline::with(BruteForce, narrow);
        let step = pipeline.step(scene, Par::Serial);
        let undecided: Vec<(u32, u32)> =
            step.report().undecided().iter().map(|u| u.pair.into()).collect();
        let mut found: Vec<_> = step.contacts().collect();
        found.sort_unstable();
        assert!(found.iter().all(|pair| truth.binary_search(pair).is_ok()), "{name}");
        let missed = truth.iter().filter(|pair| found.binary_search(pair).is_err());
        assert!(missed.clone().all(|pair| undecided.binary_search(pair).is_ok()), "{name}");
    }
}

#[test]
fn overlapping_and_separate_bricks_stay_off_the_exact_method() {
    for (name, method_may_be_exact) in
        [("bricks-overlapping", false), ("bricks-apart", false), ("bricks", true)]
    {
        let scene = SceneSpec::parse(name).unwrap().with_objects(512).scene().unwrap();
        let mut pipeline = Pipeline::with(WideTree::default(), Overlap::default());
        let exact = pipeline.step(&scene, Par::Serial).report().resolved(Method::Exact);
        assert_eq!(exact > 0, method_may_be_exact, "{name}: {exact}");
    }
}

#[test]
fn no_object_and_one_object_give_no_pairs() {
    let mut pipeline = Pipeline::new();
    for objects in [0, 1] {
        let shapes = vec![Shape::sphere(1.0).unwrap(); objects];
        let scene = Scene::one_each(shapes, vec![Pose::IDENTITY; objects]).unwrap();
        for par in [Par::Serial, Par::Pool] {
            let step = pipeline.step(&scene, par);
            assert_eq!((step.contact_count(), step.candidate_count()), (0, 0));
        }
    }
}

#[test]
fn filters_are_called_before_any_narrow_work() {
    use dcd_geom::{Filter, Object};
    let sphere = Shape::sphere(1.0).unwrap();
    let object =
        |groups, mask| Object { filter: Filter { groups, mask }, ..Object::new(0, Pose::IDENTITY) };
    let scene =
        Scene::new(vec![sphere], [object(1, 2), object(2, 1), object(1, 2), object(2, 2)]).unwrap();
    let mut pipeline = Pipeline::new();
    let step = pipeline.step(&scene, Par::Serial);
    let mut found: Vec<_> = step.contacts().collect();
    found.sort_unstable();
    assert_eq!(found, [(0, 1), (1, 2)]);
    assert_eq!(step.candidate_count(), 2);
}

#[test]
fn a_direction_whose_square_underflows_does_not_part_a_sphere_from_the_sliver_that_it_touches() {
    // Found by fuzzing: two corners 4e-34 m apart, and with the centre they span a plane whose
    // normal is as short. Its length is 0 in f32, and so was what the sphere's radius took away.
    let corners = [[0.0; 3], [3.9e-34, 0.0, 0.0], [0.0, 1.0, 2.375], [0.0, 0.375, 0.5]];
    let sliver = Shape::hull(corners.map(DVec3::from_array).to_vec()).unwrap();
    let shapes = vec![Shape::sphere(0.5).unwrap(), sliver];
    let poses = [0.0, 0.5].map(|z| Pose::from_translation(DVec3::new(1.0, 0.0, z)).unwrap());
    let scene = Scene::one_each(shapes, poses.to_vec()).unwrap();
    for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
        assert_eq!(contacts(WideTree::default(), Overlap::on(path), &scene), [(0, 1)], "{path:?}");
    }
}

#[test]
fn distances_are_the_same_bytes_on_every_path() {
    // Of thousands of hulls: which stage proves a pair apart may differ from path to path, and one bound in ten thousand with it.
    for name in ["game-hulls", "needles"] {
        let scene =
            SceneSpec::parse(name).unwrap().with_objects(10_000).with_seed(0).scene().unwrap();
        let mut first = None;
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            let narrow = SimdDistances::on(path, 0.1, Accuracy::F32).unwrap();
            let mut pipeline = Pipeline::with(WideTree::default(), narrow);
            let found: Vec<_> = pipeline.step(&scene, Par::Serial).answers().collect();
            let first = first.get_or_insert_with(|| found.clone());
            assert!(*first == found, "{name} {path:?}");
        }
        let measured = first.unwrap().iter().filter(|found| found.answer.is_some()).count();
        assert!(measured > 1000, "{name}: {measured}");
    }
}
