//! What changes for all objects at once reaches those that rest, and no order depends on the past.

use dcd_geom::glam::DVec3;
use dcd_geom::{Object, Pose, Scene, Shape};
use dcd_gjk::{Coherent, Within};
use dcd_pipeline::{NarrowPhase, Overlap, Par, Pipeline, WideTree};

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(DVec3::new(x, y, z)).unwrap()
}

fn sphere(radius: f64) -> Shape {
    Shape::sphere(radius).unwrap()
}

/// The contacts of a step, compared with a fresh pipeline's, order included.
fn reported<N>(
    kept: &mut Pipeline<WideTree, N>,
    fresh: N,
    scene: &Scene,
    when: &str,
) -> Vec<(u32, u32)>
where
    N: NarrowPhase<Answer = ()>,
{
    let mut fresh = Pipeline::with(WideTree::default(), fresh);
    let (step, due) = (kept.step(scene, Par::Serial), fresh.step(scene, Par::Serial));
    assert_eq!(step.aabbs(), due.aabbs(), "{when}");
    assert!(step.candidates().eq(due.candidates()), "{when}");
    assert_eq!(step.report().undecided(), due.report().undecided(), "{when}");
    let contacts: Vec<_> = step.contacts().collect();
    assert_eq!(contacts, due.contacts().collect::<Vec<_>>(), "{when}");
    contacts
}

/// The static sphere's first place, and its second; it touches the one at (1, 1, 0) at the origin only.
const PLACES: [[f64; 3]; 2] = [[0.0, 0.0, 0.0], [-0.5, -0.5, 0.0]];

/// Runs the steps that come between two places of a static sphere of which something is known.
fn with_a_static_sphere_that_moves(between: impl Fn(&mut Scene, &mut dyn FnMut(&Scene, &str))) {
    for [from, to] in [PLACES, [PLACES[1], PLACES[0]]] {
        let pair =
            Shape::compound(vec![(sphere(1.0), Pose::IDENTITY), (sphere(1.0), at(0.5, 0.0, 0.0))]);
        let shapes = vec![sphere(1.0), pair.unwrap(), sphere(1e-5)];
        let place = |[x, y, z]: [f64; 3]| at(x, y, z);
        let objects = [
            Object::new(0, place(from)).fixed(),
            Object::new(0, at(1.0, 1.0, 0.0)),
            Object::new(0, at(100.0, 0.0, 0.0)),
            Object::new(0, at(0.0, 0.0, 100.0)),
        ];
        let mut scene = Scene::new(shapes, objects).unwrap();
        let mut kept = Pipeline::with(WideTree::default(), Coherent::default());
        let mut step = |scene: &Scene, when: &str| {
            let touches = reported(&mut kept, Coherent::default(), scene, when).contains(&(0, 1));
            let there = scene.poses()[0].translation() == DVec3::ZERO;
            assert_eq!(touches, there, "{when}");
        };
        step(&scene, "the first step");
        between(&mut scene, &mut step);
        step(&scene, "before the static sphere moves");
        scene.set_pose(0, place(to)).unwrap();
        for _ in 0..3 {
            step(&scene, "after the static sphere has moved");
        }
    }
}

#[test]
fn a_proof_ends_when_a_static_object_moves_after_a_compound_has_taken_a_slot() {
    with_a_static_sphere_that_moves(|scene, step| {
        scene.remove(scene.handle(2).unwrap()).unwrap();
        scene.insert(Object::new(1, at(100.0, 0.0, 0.0))).unwrap();
        (0..3).for_each(|_| step(scene, "a compound takes a slot"));
    });
}

#[test]
fn a_proof_ends_when_a_static_object_moves_after_a_small_object_has_taken_a_slot() {
    with_a_static_sphere_that_moves(|scene, step| {
        scene.remove(scene.handle(2).unwrap()).unwrap();
        scene.insert(Object::new(2, at(100.0, 0.0, 0.0))).unwrap();
        (0..3).for_each(|_| step(scene, "a small sphere takes a slot"));
    });
}

#[test]
fn a_proof_ends_when_a_static_object_moves_after_another_has_travelled_thousands_of_its_radii() {
    with_a_static_sphere_that_moves(|scene, step| {
        for jump in 0..1030 {
            scene.set_pose(2, at(100.0 + 50.0 * f64::from(jump % 2), 0.0, 0.0)).unwrap();
            step(scene, "a sphere leaps to and fro");
        }
    });
}

#[test]
fn a_proof_ends_when_a_static_object_moves_after_the_shapes_have_become_more() {
    with_a_static_sphere_that_moves(|scene, step| {
        scene.add_shapes([Shape::half_space(DVec3::Z, -50.0).unwrap()]).unwrap();
        step(scene, "a shape is added");
        scene.insert(Object::new(3, Pose::IDENTITY).fixed()).unwrap();
        (0..3).for_each(|_| step(scene, "a floor is there"));
    });
}

/// From −2 to 2 in eighths, of a sequence without a pattern.
fn number(k: u64) -> f64 {
    let mixed = (k + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mixed = (mixed ^ mixed >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    f64::from((mixed >> 40) as u32 % 4097) / 1024.0 - 2.0
}

#[test]
fn contacts_come_in_the_order_of_a_fresh_pipeline_after_shapes_of_another_kind_are_added() {
    let mut contacts = 0;
    for seed in 0..300u64 {
        let shapes = (0..4).map(|k| {
            let half =
                [3 * k, 3 * k + 1, 3 * k + 2].map(|k| 0.2 + 0.2 * number(999 * seed + k).abs());
            Shape::cuboid(DVec3::from_array(half)).unwrap()
        });
        let objects = (0..40u32).map(|i| {
            let k = 1_000_003 * (seed + 1) + 3 * u64::from(i);
            let object = Object::new(i % 4, at(number(k), number(k + 1), number(k + 2)));
            if i < 25 { object.fixed() } else { object }
        });
        let mut scene = Scene::new(shapes.collect(), objects).unwrap();
        let mut kept = Pipeline::new();
        reported(&mut kept, Overlap::default(), &scene, "cuboids alone");
        let added = scene.add_shapes([sphere(0.5)]).unwrap();
        contacts += reported(&mut kept, Overlap::default(), &scene, "a kind of shape more").len();
        scene.insert(Object::new(added.start, Pose::IDENTITY)).unwrap();
        reported(&mut kept, Overlap::default(), &scene, "a sphere among the cuboids");
    }
    assert!(contacts > 3000, "{contacts}");
}

#[test]
fn a_static_object_is_not_lost_while_another_is_out_of_the_range_of_a_margin() {
    let margin = 1e36;
    let objects = [Object::new(0, Pose::IDENTITY).fixed(), Object::new(0, at(0.5, 0.0, 0.0))];
    let mut scene = Scene::new(vec![sphere(1.0)], objects).unwrap();
    let within = || Within::margin(margin).unwrap();
    let coherent = || Within::by(Coherent::default(), margin).unwrap();
    let mut kept = Pipeline::with(WideTree::default(), within());
    let mut remembering = Pipeline::with(WideTree::default(), coherent());
    for (x, touches) in [(0.5, true), (9.9e36, false), (0.5, true), (5e36, false), (0.7, true)] {
        scene.set_pose(1, at(x, 0.0, 0.0)).unwrap();
        let when = format!("at {x:e}");
        assert_eq!(reported(&mut kept, within(), &scene, &when).len(), usize::from(touches));
        reported(&mut remembering, coherent(), &scene, &when);
    }
}
