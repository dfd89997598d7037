//! Compounds and meshes beside Parry's: each difference is judged by exact integers on parts.

use crate::common::{contacts, rival_contacts};
use dcd_broad::BruteForce;
use dcd_geom::glam::DVec3;
use dcd_geom::{Pair, Polytope, Pose, Scene, Shape};
use dcd_gjk::{Certified, Overlap, Pairwise, PosedShape, PosedSupport, Verdict, certified, mesh};
use dcd_io::{data, load_mesh};
use dcd_parry::{Library, ParryShapes, Query};
use dcd_scenes::poses_in;

/// Seeded points in a cube round the origin.
fn points(half: f64, seed: u64) -> impl Iterator<Item = DVec3> {
    poses_in(DVec3::splat(-half), DVec3::splat(half), seed).map(|pose| pose.translation())
}

fn mesh(triangles: usize, seed: u64) -> Shape {
    let middles = points(0.6, seed).take(triangles);
    let corners: Vec<_> = points(0.4, seed + 1000).take(3 * triangles).collect();
    let vertices = middles.zip(corners.chunks(3)).flat_map(|(m, c)| [m + c[0], m + c[1], m + c[2]]);
    let indices = (0..triangles as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]);
    Shape::mesh(vertices.collect(), indices.collect()).unwrap()
}

fn hull(half: f64, seed: u64) -> Shape {
    Shape::hull(points(half, seed).take(12).collect()).unwrap()
}

fn compound(seed: u64) -> Shape {
    let places = poses_in(DVec3::splat(-0.7), DVec3::splat(0.7), seed);
    let shapes = [
        hull(0.3, seed),
        Shape::cuboid(DVec3::new(0.2, 0.3, 0.1)).unwrap(),
        Shape::sphere(0.25).unwrap(),
        hull(0.2, seed + 1),
    ];
    Shape::compound(shapes.into_iter().zip(places).collect()).unwrap()
}

/// Meshes, compounds and convex shapes, alternating.
fn mixed(objects: usize, half: f64, seed: u64) -> Scene {
    let shape = |k: u64| match k % 5 {
        0 | 1 => mesh(1 + (k % 37) as usize, seed * 1000 + k),
        2 | 3 => compound(seed * 1000 + k),
        _ => hull(0.5, seed * 1000 + k),
    };
    let poses = poses_in(DVec3::splat(-half), DVec3::splat(half), seed).take(objects).collect();
    Scene::one_each((0..objects as u64).map(shape).collect(), poses).unwrap()
}

/// The parts as polytopes in the frame of their shape.
fn polytopes(shape: &Shape) -> Vec<Polytope> {
    match shape {
        Shape::Compound(compound) => {
            compound.parts().iter().map(|p| p.placed().as_polytope().unwrap().clone()).collect()
        }
        Shape::Mesh(mesh) => (0..mesh.triangles().len())
            .map(|k| Polytope::hull(mesh.corners(k).unwrap().to_vec()).unwrap())
            .collect(),
        convex => vec![convex.as_polytope().unwrap().clone()],
    }
}

/// Every pair of parts in integers.
fn truth(a: PosedShape<'_>, b: PosedShape<'_>) -> bool {
    let parts_b = polytopes(b.shape);
    polytopes(a.shape).iter().any(|in_a| {
        let a = PosedSupport::polytope(in_a, a.pose);
        parts_b
            .iter()
            .any(|in_b| certified::overlap_exactly(a, PosedSupport::polytope(in_b, b.pose)))
    })
}

fn placed(scene: &Scene, object: u32) -> PosedShape<'_> {
    PosedShape { shape: scene.shape(object as usize), pose: &scene.poses()[object as usize] }
}

/// That the proved contacts are right wherever Parry says otherwise; how often it does.
fn differences(scene: &Scene, proved: &[Pair], theirs: &[Pair], way: &str) -> usize {
    let only = |these: &[Pair], those: &[Pair]| {
        these.iter().copied().filter(|pair| those.binary_search(pair).is_err()).collect::<Vec<_>>()
    };
    let (missed, invented) = (only(proved, theirs), only(theirs, proved));
    for (pairs, touches) in [(&missed, true), (&invented, false)] {
        for pair in pairs {
            let (a, b) = (placed(scene, pair.i), placed(scene, pair.j));
            assert_eq!(truth(a, b), touches, "{way}: {pair:?}");
        }
    }
    missed.len() + invented.len()
}

#[test]
fn compounds_and_meshes_agree_with_parry_or_exact_integers_say_why_not() {
    for seed in 1..4 {
        let scene = mixed(150, 3.0, seed);
        let proved = contacts(BruteForce, Overlap::default(), &scene);
        assert!((100..5000).contains(&proved.len()), "{}", proved.len());
        assert_eq!(contacts(BruteForce, Pairwise(Certified), &scene), proved, "{seed}");
        let of_f64 = contacts(BruteForce, ParryShapes::<f64>::new(&scene), &scene);
        assert_eq!(differences(&scene, &proved, &of_f64, "f64"), 0, "{seed}");
        let pipeline = rival_contacts::<f64>(Query::IntersectionTest, &scene);
        assert_eq!(differences(&scene, &proved, &pipeline, "pipeline"), 0, "{seed}");
        let of_f32 = contacts(BruteForce, ParryShapes::<f32>::new(&scene), &scene);
        assert!(differences(&scene, &proved, &of_f32, "f32") < 10, "{seed}");
    }
}

#[test]
fn a_rounded_mesh_and_a_part_that_parry_lacks_are_refused() {
    let rounded = mesh(3, 1).rounded(0.1).unwrap();
    assert!(<f64 as Library>::form(&rounded).is_none());
    let inside = Shape::compound(vec![(hull(0.3, 1), Pose::IDENTITY)]).unwrap();
    assert!(<f64 as Library>::form(&inside).is_some());
    let flat = Shape::hull(vec![DVec3::ZERO]).unwrap();
    let refused = <f64 as Library>::form(&flat).is_none();
    let inside = Shape::compound(vec![(flat, Pose::IDENTITY)]).unwrap();
    assert_eq!(<f64 as Library>::form(&inside).is_none(), refused);
}

#[test]
fn the_robot_among_its_surroundings_agrees_with_parry_or_exact_integers_say_why_not() {
    let [Some(fixed), Some(moving)] = ["meshes/env.obj", "meshes/rob.obj"].map(data::file) else {
        println!("skipped: the data folder has no meshes");
        return;
    };
    let fixed = load_mesh(&fixed).unwrap();
    let (low, high) = fixed.extent();
    let (fixed, moving) = (fixed.into_shape().unwrap(), load_mesh(&moving).unwrap());
    let moving = moving.into_shape().unwrap();
    let [form_fixed, form_moving] =
        [&fixed, &moving].map(|shape| <f64 as Library>::form(shape).unwrap());
    let here = <f64 as Library>::pose(&Pose::IDENTITY);
    let mut scratch = mesh::Scratch::default();
    let mut touching = 0;
    for (k, pose) in poses_in(low, high, 3).take(300).enumerate() {
        let a = PosedShape { shape: &fixed, pose: &Pose::IDENTITY };
        let b = PosedShape { shape: &moving, pose: &pose };
        let ours = mesh::overlap(a, b, &mut scratch).0;
        let there = (&form_moving, &<f64 as Library>::pose(&pose));
        let theirs = <f64 as Library>::touching(Query::default(), (&form_fixed, &here), there);
        let yes = ours == Verdict::Touching(());
        assert!(yes || ours == Verdict::Apart, "{k}");
        if theirs != Some(yes) {
            assert_eq!(truth(a, b), yes, "pose {k}");
        }
        touching += usize::from(yes);
    }
    assert!((50..250).contains(&touching), "{touching}");
}
