//! Parry's ways against each other, and against separating axes, on whole scenes.

use crate::common::{QUERIES, contacts, rival_contacts};
use dcd_exec::Par;
use dcd_geom::glam::DVec3;
use dcd_geom::{Kind, Pair, Scene};
use dcd_gjk::{Certified, Pairwise, contract};
use dcd_parry::{Library, ParryBvh, ParryGjk, ParryPipeline, ParryShapes, Query};
use dcd_scenes::SceneSpec;

#[test]
fn every_way_in_f64_finds_the_contacts_that_are_proved_among_hulls() {
    for seed in 1..4 {
        let scene = SceneSpec::paper().with_objects(400).with_seed(seed).scene().unwrap();
        let proved = contacts(ParryBvh::default(), Pairwise(Certified), &scene);
        assert!(proved.len() > 1000);
        let gjk = Pairwise(ParryGjk::<f64>::default());
        assert_eq!(contacts(ParryBvh::default(), gjk, &scene), proved, "{seed}");
        for query in QUERIES {
            let shapes = ParryShapes::<f64>::default().with_query(query);
            assert_eq!(contacts(ParryBvh::default(), shapes, &scene), proved, "{query:?} {seed}");
            assert_eq!(rival_contacts::<f64>(query, &scene), proved, "{query:?} {seed}");
        }
    }
}

#[test]
fn cuboids_touch_where_no_axis_separates_them() {
    let scene = SceneSpec::boxes().with_objects(400).with_seed(5).scene().unwrap();
    let (mut expected, mut doubtful) = (Vec::new(), Vec::new());
    for i in 0..scene.len() as u32 {
        for j in i + 1..scene.len() as u32 {
            match separation(&scene, i as usize, j as usize) {
                s if s < -1e-5 => expected.push(Pair { i, j }),
                s if s < 1e-5 => doubtful.push(Pair { i, j }),
                _ => {}
            }
        }
    }
    assert!(expected.len() > 300, "{}", expected.len());
    let assert_found = |mut found: Vec<Pair>, way: &str| {
        found.retain(|pair| doubtful.binary_search(pair).is_err());
        assert_eq!(found, expected, "{way}");
    };
    let each = (Pairwise(ParryGjk::<f32>::default()), Pairwise(ParryGjk::<f64>::default()));
    assert_found(contacts(ParryBvh::default(), each.0, &scene), "GJK f32");
    assert_found(contacts(ParryBvh::default(), each.1, &scene), "GJK f64");
    for query in QUERIES {
        assert_found(rival_contacts::<f32>(query, &scene), &format!("{query:?} f32"));
        assert_found(rival_contacts::<f64>(query, &scene), &format!("{query:?} f64"));
    }
}

/// The largest separation of two cuboids over their fifteen axes.
fn separation(scene: &Scene, i: usize, j: usize) -> f64 {
    let placed = [i, j].map(|k| {
        let Some(Kind::Cuboid { half_extents }) = scene.shape(k).as_polytope().map(|p| p.kind())
        else {
            panic!("object {k} is no cuboid");
        };
        let rotation = scene.poses()[k].rotation();
        let axes = [rotation.x_axis, rotation.y_axis, rotation.z_axis];
        (axes, half_extents, scene.poses()[k].translation())
    });
    let [(axes_a, half_a, t_a), (axes_b, half_b, t_b)] = placed;
    let edges = axes_a.into_iter().flat_map(|a| axes_b.map(|b| a.cross(b)));
    let proper = edges.filter(|axis| axis.length() > 1e-6).map(DVec3::normalize);
    let all = axes_a.into_iter().chain(axes_b).chain(proper);
    let reach = |axes: [DVec3; 3], half: DVec3, d: DVec3| -> f64 {
        axes.iter().zip(half.to_array()).map(|(axis, h)| axis.dot(d).abs() * h).sum()
    };
    all.map(|d| (t_b - t_a).dot(d).abs() - reach(axes_a, half_a, d) - reach(axes_b, half_b, d))
        .fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn a_second_step_of_moved_objects_finds_what_a_fresh_pipeline_finds() {
    let spec = SceneSpec::paper().with_objects(200);
    let (mut scene, later) = (spec.scene().unwrap(), spec.with_seed(9).scene().unwrap());
    let mut pipeline = ParryPipeline::<f32>::new(&scene, Query::IntersectionTest);
    let before = pipeline.place(&scene).step(Par::Serial).sorted_contacts();
    for (i, &pose) in later.poses().iter().enumerate() {
        scene.set_pose(i, pose).unwrap();
    }
    let moved = pipeline.place(&scene).step(Par::Serial).sorted_contacts();
    assert_ne!(moved, before);
    assert_eq!(moved, rival_contacts::<f32>(Query::IntersectionTest, &scene));
}

#[test]
fn another_scene_gets_its_own_shapes() {
    let first = SceneSpec::paper().with_objects(150).scene().unwrap();
    let other = SceneSpec::paper().with_objects(150).with_seed(2).scene().unwrap();
    let expected = contacts(ParryBvh::default(), Pairwise(ParryGjk::<f64>::default()), &other);
    assert_eq!(contacts(ParryBvh::default(), ParryShapes::<f64>::new(&first), &other), expected);
    let mut pipeline = ParryPipeline::<f64>::new(&first, Query::default());
    pipeline.place(&first).step(Par::Serial);
    assert_eq!(pipeline.place(&other).step(Par::Serial).sorted_contacts(), expected);
}

#[test]
fn parrys_narrow_phases_keep_the_contract() {
    fn keeps<R: Library>(scene: &Scene, pairs: &[Pair]) {
        contract::narrow_phase(&Pairwise(ParryGjk::<R>::default()), scene, pairs).unwrap();
        for query in QUERIES {
            let shapes = ParryShapes::<R>::default().with_query(query);
            contract::narrow_phase(&shapes, scene, pairs).unwrap();
        }
    }
    let all = (0..30).flat_map(|i| (i + 1..30).map(move |j| Pair::new(i, j)));
    let pairs: Vec<_> = all.collect();
    for spec in [SceneSpec::paper(), SceneSpec::boxes(), SceneSpec::bricks(1.0)] {
        let scene = spec.with_objects(30).scene().unwrap();
        keeps::<f32>(&scene, &pairs);
        keeps::<f64>(&scene, &pairs);
    }
}
