//! What Parry does not say is undecided, and never a panic.

use crate::common::{self, answers, decide, two};
use dcd_exec::Par;
use dcd_geom::glam::DVec3;
use dcd_geom::{Pair, Pose, Scene, Shape, Support, SupportMap};
use dcd_gjk::{Pairwise, Reason};
use dcd_parry::{Library, ParryBvh, ParryGjk, ParryPipeline, ParryShapes, Query};
use dcd_pipeline::Pipeline;
use std::sync::Arc;

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(DVec3::new(x, y, z)).unwrap()
}

/// No convex shape: for any direction it answers far to the side and a little beyond the origin,
/// so that the simplex comes nearer for ever.
struct Endless;

impl SupportMap<f64> for Endless {
    fn support(&self, d: DVec3) -> Support<f64> {
        let aside = DVec3::new(-d.y, d.x, 0.0) * 100.0 + d * 1e-3;
        let point = if d == DVec3::Z { DVec3::Y } else { aside };
        Support { point: point + DVec3::Z, feature: 0 }
    }
}

fn assert_undecided<R: Library>(scene: &Scene, reason: Reason) {
    let gjk = Pairwise(ParryGjk::<R>::default());
    assert_eq!(decide(&gjk, scene), Err(reason));
}

#[test]
fn running_out_of_iterations_is_no_answer() {
    let endless = Shape::custom(Arc::new(Endless)).unwrap();
    let point = Shape::sphere(0.0).unwrap();
    let scene = two((&endless, Pose::IDENTITY), (&point, at(0.0, 0.0, 1.0)));
    assert_undecided::<f32>(&scene, Reason::Iterations);
    assert_undecided::<f64>(&scene, Reason::Iterations);
}

#[test]
fn apart_along_x_is_still_an_answer() {
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    common::assert_all((&cube, Pose::IDENTITY), (&cube, at(3.0, 0.0, 0.0)), false);
    common::assert_all((&cube, Pose::IDENTITY), (&cube, at(-3.0, 0.0, 0.0)), false);
}

#[test]
fn a_panic_inside_parry_is_an_undecided_pair() {
    /// Finite along the axes, where it is checked, and NaN between them.
    struct Violation;
    impl SupportMap<f64> for Violation {
        fn support(&self, d: DVec3) -> Support<f64> {
            let on_axis = d.abs().max_element() == d.abs().element_sum();
            let point = if on_axis { d.normalize_or_zero() } else { DVec3::NAN };
            Support { point, feature: 0 }
        }
    }
    let broken = Shape::custom(Arc::new(Violation)).unwrap();
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let scene = two((&cube, Pose::IDENTITY), (&broken, at(1.0, 0.0, 0.0)));
    assert_undecided::<f64>(&scene, Reason::Foreign);
}

#[test]
fn numbers_beyond_parrys_range_are_undecided() {
    let [small, large] = [1e3, 1e10].map(|h| Shape::cuboid(DVec3::splat(h)).unwrap());
    let near = two((&small, Pose::IDENTITY), (&large, at(1.0, 2.0, 3.0)));
    for (way, answer) in answers::<f32>(&near) {
        assert_eq!(answer, Err(Reason::Range), "{way}");
    }
    for (way, answer) in answers::<f64>(&near) {
        assert_eq!(answer, Ok(true), "{way}");
    }
    // Far from the origin but not from each other is in range.
    let far = two((&small, at(1e12, 0.0, 0.0)), (&small, at(1e12, 0.0, 500.0)));
    for (way, answer) in answers::<f32>(&far) {
        assert_eq!(answer, Ok(true), "{way}");
    }
}

/// Clouds without volume, or next to none, of all kinds.
fn degenerate() -> Vec<Vec<DVec3>> {
    let grid = |scale: DVec3| -> Vec<DVec3> {
        (0..27)
            .map(|k| DVec3::new((k % 3).into(), (k / 3 % 3).into(), (k / 9).into()) * scale)
            .collect()
    };
    let turned = DVec3::new(0.3, -0.7, 0.11);
    let mut clouds = vec![vec![DVec3::ONE], vec![DVec3::ZERO; 40], vec![DVec3::X, -DVec3::X]];
    clouds.push((0..30).map(|k| turned * f64::from(k) / 7.0).collect());
    for thin in [0.0, 1e-300, 1e-20, 1e-16, 1e-12, 1e-9, 1e-7, 1e-5, 1e-4, 1e-3] {
        for scale in [1e-30, 1e-6, 1.0, 1e6, 1e30] {
            clouds.push(grid(DVec3::new(1.0, 1.0, thin) * scale));
            clouds.push(grid(DVec3::new(1.0, thin, thin) * scale));
            clouds.push(
                grid(DVec3::new(1.0, 1.0, thin) * scale)
                    .into_iter()
                    .map(|p| p + turned * scale)
                    .collect(),
            );
        }
    }
    clouds
}

fn assert_degenerate_hulls_do_no_harm<R: Library>() {
    let shapes: Vec<_> = degenerate().into_iter().map(|c| Shape::hull(c).unwrap()).collect();
    let poses = vec![Pose::IDENTITY; shapes.len()];
    let scene = Scene::one_each(shapes, poses).unwrap();
    for query in common::QUERIES {
        let shapes = ParryShapes::<R>::new(&scene).with_query(query);
        let refused: Vec<u32> = shapes.refused().collect();
        assert!([0, 1, 2, 3].iter().all(|point_or_line| refused.contains(point_or_line)));
        let mut pipeline = Pipeline::with(ParryBvh::default(), shapes);
        let step = pipeline.step(&scene, Par::Serial);
        let foreign = step.report().undecided().iter().filter(|u| u.reason == Reason::Foreign);
        let of_refused = |pair: &Pair| refused.contains(&pair.i) || refused.contains(&pair.j);
        assert!(step.candidates().filter(of_refused).count() <= foreign.count());
        let answered = step.contacts().map(|(i, j)| Pair { i, j });
        assert_eq!(answered.filter(of_refused).count(), 0);
        ParryPipeline::<R>::new(&scene, query).place(&scene).step(Par::Serial);
    }
}

#[test]
fn hulls_without_volume_are_refused_or_answered_for() {
    assert_degenerate_hulls_do_no_harm::<f32>();
    assert_degenerate_hulls_do_no_harm::<f64>();
}

#[test]
fn refused_objects_stay_out_of_the_pipeline_and_the_others_keep_their_numbers() {
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let line = Shape::hull(vec![DVec3::ZERO, DVec3::X]).unwrap();
    let shapes = vec![line.clone(), cube.clone(), line, cube.clone(), cube];
    let poses = vec![
        at(0.0, 0.0, 0.0),
        at(0.5, 0.0, 0.0),
        at(0.6, 0.0, 0.0),
        at(5.0, 0.0, 0.0),
        at(0.0, 0.5, 0.0),
    ];
    let scene = Scene::one_each(shapes, poses).unwrap();
    let mut pipeline = ParryPipeline::<f64>::new(&scene, Query::IntersectionTest);
    let mut ready = pipeline.place(&scene);
    let step = ready.step(Par::Serial);
    assert_eq!(step.refused(), [0, 2]);
    assert_eq!(step.sorted_contacts(), [Pair { i: 1, j: 4 }]);
    assert_eq!(step.contact_count(), 1);
    assert_eq!(step.candidates().len(), 1);
}

#[test]
fn an_empty_scene_gives_nothing() {
    let scene = Scene::default();
    let mut pipeline = ParryPipeline::<f32>::new(&scene, Query::Distance);
    assert_eq!(pipeline.place(&scene).step(Par::Pool).contact_count(), 0);
}
