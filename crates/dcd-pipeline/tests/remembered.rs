//! No order depends on the past.

use dcd_geom::glam::DVec3;
use dcd_geom::{Object, Pose, Scene, Shape};
use dcd_pipeline::{NarrowPhase, Overlap, Par, Pipeline, WideTree};

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(DVec3::new(x, y, z)).unwrap()
}

fn ball(radius: f64) -> Shape {
    Shape::sphere(radius).unwrap()
}

/// The contacts of a step, compared with a fresh pipeline's, order included.
fn told<N>(kept: &mut Pipeline<WideTree, N>, fresh: N, scene: &Scene, when: &str) -> Vec<(u32, u32)>
where
    N: NarrowPhase<Answer = ()>,
{
    let mut fresh = Pipeline::new(WideTree::default(), fresh);
    let (step, due) = (kept.step(scene, Par::Serial), fresh.step(scene, Par::Serial));
    assert_eq!(step.aabbs(), due.aabbs(), "{when}");
    assert!(step.candidates().eq(due.candidates()), "{when}");
    assert_eq!(step.report().undecided(), due.report().undecided(), "{when}");
    let contacts: Vec<_> = step.contacts().collect();
    assert_eq!(contacts, due.contacts().collect::<Vec<_>>(), "{when}");
    contacts
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
        let mut kept = <Pipeline>::default();
        told(&mut kept, Overlap::default(), &scene, "cuboids alone");
        let added = scene.add_shapes([ball(0.5)]).unwrap();
        contacts += told(&mut kept, Overlap::default(), &scene, "a kind of shape more").len();
        scene.insert(Object::new(added.start, Pose::IDENTITY)).unwrap();
        told(&mut kept, Overlap::default(), &scene, "a ball among the cuboids");
    }
    assert!(contacts > 3000, "{contacts}");
}
