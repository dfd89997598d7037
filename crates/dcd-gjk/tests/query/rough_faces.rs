//! Hulls whose flat faces are bent by what their coordinates were rounded to: f32, or decimals of a file.

use super::manifolds::grounds;
use super::scenes::Draw;
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Polytope, Pose, Scene, Shape, SupportMap};
use dcd_gjk::query::MeasureAt;
use dcd_gjk::{Accuracy, Manifold, Manifolds, PosedShape, SimdDepths, Verdict};
use dcd_pipeline::{Par, Pipeline, WideTree};

const ACCURACIES: [Accuracy; 3] = [Accuracy::F32, Accuracy::F64, Accuracy::Certified];

/// To f32, to six decimals, or to five digits of a size of a metre.
fn rounded(point: DVec3, k: usize) -> DVec3 {
    match k % 3 {
        0 => point.as_vec3().as_dvec3(),
        1 => (point * 1e6).round() / 1e6,
        _ => (point * 2e5).round() / 2e5,
    }
}

/// A box, or a prism of eight sides, turned before its corners are rounded; and the pose that turns it back, at that height of its middle.
fn rough(draw: &mut Draw, k: usize, height: f64) -> (Shape, Pose) {
    let turn = DQuat::from_scaled_axis(draw.vector() * 3.0);
    let sides = [4, 8][k / 3 % 2];
    let half = 0.4;
    let corner = |j: usize| {
        let angle = std::f64::consts::TAU * ((j / 2) as f64 + 0.5) / sides as f64;
        let across = DVec3::new(angle.cos(), angle.sin(), 0.0) * 0.5;
        across + DVec3::Z * if j.is_multiple_of(2) { -half } else { half }
    };
    let corners = (0..2 * sides).map(|j| rounded(turn * corner(j), k)).collect();
    let spin = DQuat::from_rotation_z(0.3 + k as f64);
    let place = DVec3::new(0.1, 0.05, height + half);
    (Shape::hull(corners).unwrap(), Pose::new(spin * turn.inverse(), place).unwrap())
}

/// That four points are round the middle of what rests, and on the surfaces to within the bound.
fn judge(what: &str, found: &Manifold, body: PosedShape<'_>, deep: f64) {
    let points = found.points();
    assert_eq!(points.len(), 4, "{what}: {found:?}");
    assert!(found.normal.distance(DVec3::Z) < 1e-4, "{what}: {found:?}");
    assert!(found.error_bound < 1e-4, "{what}: {found:?}");
    let middle = points.iter().map(|point| point.point_b).sum::<DVec3>() / 4.0;
    let from = middle - body.pose.translation();
    assert!(from.truncate().length() < 0.15, "{what}: {found:?}");
    let hull = body.shape.as_polytope().unwrap();
    for point in points {
        assert!((point.depth - deep).abs() < 1e-4, "{what}: {found:?}");
        assert!(point.point_a.z.abs() <= 1e-9 + found.error_bound, "{what}: {found:?}");
        // On the side of the body that looks down, seen by its own support: another method.
        let local = body.pose.rotation().transpose() * (point.point_b - body.pose.translation());
        let down = body.pose.rotation().transpose() * -DVec3::Z;
        let lowest = SupportMap::<f64>::support(hull, down).point.dot(down);
        assert!((local.dot(down) - lowest).abs() <= 1e-5 + found.error_bound, "{what}: {found:?}");
        let between = point.point_a - point.point_b - found.normal * point.depth;
        assert!(between.length() <= 2.0 * found.error_bound, "{what}: {between} {found:?}");
    }
}

#[test]
fn a_box_whose_corners_were_rounded_stands_on_four_points() {
    let mut draw = Draw(61);
    for (name, ground) in grounds() {
        for k in 0..60 {
            for deep in [0.01, 1e-3] {
                let (shape, pose) = rough(&mut draw, k, -deep);
                let a = PosedShape { shape: &ground.shape, pose: &ground.pose };
                let b = PosedShape { shape: &shape, pose: &pose };
                for accuracy in ACCURACIES {
                    let what = format!("{k} on {name}, {deep}, {accuracy:?}");
                    let solver = Manifolds::default();
                    let found = solver.measure_at(accuracy, a, b, &mut Default::default());
                    let Verdict::Touching(found) = found else { panic!("{what}: {found:?}") };
                    let [only] = &found[..] else { panic!("{what}: {found:?}") };
                    judge(&what, only, b, deep);
                }
            }
        }
    }
}

#[test]
fn rough_boxes_stand_on_each_other_in_a_scene() {
    let mut draw = Draw(62);
    let deep = 2e-3;
    let (mut shapes, mut poses) = (Vec::new(), Vec::new());
    for k in 0..48 {
        for storey in 0..2 {
            let height = f64::from(storey) * (0.8 - deep);
            let (shape, pose) = rough(&mut draw, k, height);
            let far = DVec3::X * (3 * k) as f64;
            shapes.push(shape);
            poses.push(pose.with_translation(pose.translation() + far).unwrap());
        }
    }
    let scene = Scene::one_each(shapes, poses).unwrap();
    for accuracy in ACCURACIES {
        let narrow = SimdDepths::new(Manifolds::default(), accuracy);
        let mut pipeline = Pipeline::with(WideTree::default(), narrow);
        let step = pipeline.step(&scene, Par::Serial);
        assert_eq!(step.contact_count(), 48, "{accuracy:?}");
        for contact in step.answers() {
            let what = format!("{:?}, {accuracy:?}", contact.pair);
            let [only] = &contact.answer[..] else { panic!("{what}: {:?}", contact.answer) };
            assert_eq!(only.points().len(), 4, "{what}: {only:?}");
            assert!(only.error_bound < 1e-4, "{what}: {only:?}");
            for point in only.points() {
                assert!((point.depth - deep).abs() < 1e-4, "{what}: {only:?}");
            }
        }
    }
}

#[test]
fn what_is_bent_more_keeps_its_faces() {
    let corners = |bend: f64| {
        let corner = |k: u32| {
            let side = |bit: u32| if k >> bit & 1 == 0 { -0.5 } else { 0.5 };
            DVec3::new(side(0), side(1), side(2))
        };
        let mut all: Vec<DVec3> = (0..8).map(corner).collect();
        all[7].z += bend;
        Polytope::hull(all).unwrap()
    };
    for (bend, faces) in [(0.0, 6), (1e-7, 6), (5e-6, 6), (1e-3, 7)] {
        let hull = corners(bend);
        let contact = hull.contact_facets();
        assert_eq!(contact.facets().len(), faces, "{bend}");
        assert!(contact.unevenness() <= 1e-5 * 3f64.sqrt(), "{bend}");
        assert_eq!(hull.facets().unevenness(), 0.0);
        // A vertex is in its face's plane but for the unevenness.
        for facet in contact.facets() {
            let heights = contact
                .corners(facet)
                .iter()
                .map(|&k| facet.normal.dot(hull.vertices()[k as usize]));
            let (low, high) =
                heights.fold((f64::MAX, f64::MIN), |(low, high), h| (low.min(h), high.max(h)));
            assert!(high - low <= 2.0 * contact.unevenness() + 1e-9, "{bend}");
        }
    }
}
