//! The search beside the exact one, and its bound where that is hard to get.

use super::{ExpandingSearch, Surface, Tolerance};
use crate::Difference;
use crate::certificate::Bounds;
use crate::query::Accuracy;
use crate::{PosedShape, PosedSupport, Verdict, certified, epa};
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Polytope, Pose, Shape, SupportMap};

/// Numbers in 0 … 1, the same in every run.
struct Draw(u64);

impl Draw {
    fn unit(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    fn pose(&mut self, far: f64) -> Pose {
        let turn = DQuat::from_scaled_axis(self.vector() * 3.0);
        Pose::new(turn.normalize(), self.vector() * far).unwrap()
    }

    fn polytope(&mut self) -> Shape {
        let count = 4 + (self.unit() * 60.0) as usize;
        let shape = match (self.unit() * 4.0) as usize {
            0 => Shape::cuboid(self.vector().abs() * 0.8 + 0.01).unwrap(),
            1 => Shape::hull((0..count).map(|_| self.vector()).collect()).unwrap(),
            2 => {
                let thin = DVec3::new(1.0, 1.0, 1e-3);
                Shape::hull((0..count).map(|_| self.vector() * thin).collect()).unwrap()
            }
            _ => Shape::capsule(0.5, 0.1 + 0.3 * self.unit()).unwrap(),
        };
        if self.unit() < 0.3 { shape.swept(0.2 * self.unit()).unwrap() } else { shape }
    }
}

/// The search in f64 alone.
fn depth_of_overlap(
    a: PosedShape<'_>,
    b: PosedShape<'_>,
    accuracy: Accuracy,
    surface: &mut Surface,
) -> Option<epa::Depth> {
    super::depth_of_overlap(a, b, accuracy, surface, |_| None).map(|found| found.depth)
}

/// The exact search's word, if the two touch.
fn truth(a: PosedShape<'_>, b: PosedShape<'_>, scratch: &mut epa::Scratch) -> Option<epa::Depth> {
    let (in_a, in_b) = (a.shape.as_polytope()?, b.shape.as_polytope()?);
    let (a, b) = (PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose));
    match epa::depth(a, b, scratch) {
        Verdict::Touching(depth) => Some(depth),
        _ => None,
    }
}

#[test]
fn the_exact_depth_is_within_the_bound_at_every_accuracy_and_most_pairs_are_answered() {
    let (mut draw, mut surface, mut scratch) =
        (Draw(1), Surface::default(), epa::Scratch::default());
    let [mut touching, mut answered] = [0; 2];
    for k in 0..4000 {
        let (shape_a, shape_b) = (draw.polytope(), draw.polytope());
        let (pose_a, pose_b) = (draw.pose(0.6), draw.pose(0.6));
        let a = PosedShape { shape: &shape_a, pose: &pose_a };
        let b = PosedShape { shape: &shape_b, pose: &pose_b };
        let Some(truth) = truth(a, b, &mut scratch) else { continue };
        touching += 1;
        for accuracy in [Accuracy::F32, Accuracy::F64] {
            let found = depth_of_overlap(a, b, accuracy, &mut surface);
            let there_and_back = depth_of_overlap(b, a, accuracy, &mut surface);
            assert_eq!(found.map(|f| f.mirrored()), there_and_back, "{k}");
            let Some(found) = found else { continue };
            answered += usize::from(accuracy == Accuracy::F64);
            let off = (found.depth - truth.depth).abs();
            assert!(off <= found.error_bound + truth.error_bound, "{k}: {found:?} {truth:?}");
            let between = found.point_a - found.point_b - found.normal * found.depth;
            assert!(between.length() < 1e-5, "{k}: {found:?}");
            // The size of a pair here is up to 8.
            let most = if accuracy == Accuracy::F32 { 1.6e-5 } else { 1e-9 };
            assert!(found.error_bound <= most, "{k}: {found:?}");
        }
    }
    assert!(touching > 1000 && answered * 100 > touching * 95, "{answered} of {touching}");
}

#[test]
fn curved_shapes_are_answered_within_bounds_that_agree_with_their_hulls() {
    let (mut draw, mut surface) = (Draw(2), Surface::default());
    let [mut touching, mut answered] = [0; 2];
    for k in 0..300 {
        let [shape_a, shape_b] = [(); 2].map(|()| {
            let (height, radius) = (0.2 + draw.unit(), 0.1 + 0.6 * draw.unit());
            if draw.unit() < 0.5 {
                Shape::cylinder(height, radius).unwrap()
            } else {
                Shape::cone(height, radius).unwrap()
            }
        });
        let (pose_a, pose_b) = (draw.pose(0.5), draw.pose(0.5));
        let a = PosedShape { shape: &shape_a, pose: &pose_a };
        let b = PosedShape { shape: &shape_b, pose: &pose_b };
        if certified::overlap_of(a, b).0 != Verdict::Touching(()) {
            continue;
        }
        touching += 1;
        let Some(found) = depth_of_overlap(a, b, Accuracy::F64, &mut surface) else { continue };
        answered += 1;
        // Moved by a little more than the depth they are apart, by a little less they are not.
        for (factor, expected) in
            [(1.0 + 1e-8, Verdict::Apart), (1.0 - 1e-8, Verdict::Touching(()))]
        {
            let length = found.depth * factor + (factor - 1.0).signum() * 1e-12;
            let moved = pose_b.translation() + found.normal * length;
            let pose = Pose::from_matrix(*pose_b.rotation(), moved).unwrap();
            let b = PosedShape { shape: &shape_b, pose: &pose };
            assert_eq!(certified::overlap_of(a, b).0, expected, "{k}: {found:?}");
        }
    }
    assert!(touching > 100 && answered * 10 > touching * 9, "{answered} of {touching}");
}

/// Moved along their normals until they overlap by a part of their size, beside the exact search.
#[test]
fn shallow_depths_are_those_of_the_exact_search() {
    // Another seed by `DCD_SEED`.
    let seed = std::env::var("DCD_SEED").map_or(5, |seed| seed.parse().expect("a seed"));
    let (mut draw, mut surface, mut scratch) =
        (Draw(seed), Surface::default(), epa::Scratch::default());
    let [mut asked, mut answered] = [0; 2];
    for k in 0..2000 {
        let mut hull = || loop {
            let shape = draw.polytope();
            if shape.radius() == 0.0 {
                break shape;
            }
        };
        let (shape_a, shape_b) = (hull(), hull());
        let (pose_a, pose_b) = (draw.pose(0.6), draw.pose(0.6));
        let a = PosedShape { shape: &shape_a, pose: &pose_a };
        let at = |pose| PosedShape { shape: &shape_b, pose };
        let Some(deep) = truth(a, at(&pose_b), &mut scratch) else { continue };
        let shallow = 10f64.powi(-2 - k % 7);
        let way = deep.normal * (deep.depth - shallow);
        let pose_b = pose_b.with_translation(pose_b.translation() + way).unwrap();
        let Some(exact) = truth(a, at(&pose_b), &mut scratch) else { continue };
        asked += 1;
        let found = depth_of_overlap(a, at(&pose_b), Accuracy::Certified, &mut surface);
        let back = depth_of_overlap(at(&pose_b), a, Accuracy::Certified, &mut surface);
        assert_eq!(back.map(epa::Depth::mirrored), found, "{k}");
        let Some(found) = found else { continue };
        answered += 1;
        let off = (found.depth - exact.depth).abs();
        assert!(off <= found.error_bound + exact.error_bound, "{k}: {found:?}, {exact:?}");
        assert!(found.error_bound <= 1e-10 * found.depth, "{k}: {found:?}");
        assert!((found.normal.length() - 1.0).abs() < 1e-15);
        let apart = found.point_a - found.point_b;
        assert!(apart.distance(found.normal * found.depth) < 1e-14, "{k}: {found:?}");
    }
    assert!(asked > 600 && answered * 10 > asked * 9, "{answered} of {asked}");
}

/// Along two normals equally deep: each face is edge on to the other's normal, and rounding must not make it the one that
/// the normal leaves by.
#[test]
fn two_faces_equally_deep_have_witnesses_along_one_of_them() {
    let cube = Shape::hull(Polytope::cuboid(DVec3::splat(0.5)).unwrap().vertices().to_vec());
    let cube = cube.unwrap();
    let (mut draw, mut surface) = (Draw(8), Surface::default());
    for k in 0..200 {
        let turn = draw.pose(0.0);
        let depth = 10f64.powi(-1 - k % 4);
        let place = *turn.rotation() * DVec3::new(1.0 - depth, 0.3, 1.0 - depth);
        let other = turn.with_translation(place).unwrap();
        let a = PosedShape { shape: &cube, pose: &turn };
        let b = PosedShape { shape: &cube, pose: &other };
        for accuracy in [Accuracy::F32, Accuracy::F64, Accuracy::Certified] {
            let found = depth_of_overlap(a, b, accuracy, &mut surface);
            let Some(found) = found else { continue };
            assert!((found.depth - depth).abs() < 1e-6, "{k} {accuracy:?}: {found:?}");
            let apart = found.point_a - found.point_b;
            assert!(
                apart.distance(found.normal * found.depth) < 1e-6,
                "{k} {accuracy:?}: {found:?}"
            );
        }
    }
}

/// A cylinder, cone or ellipsoid, and another shape that is no sphere, thin or flat now and then.
fn curved_pair(draw: &mut Draw, k: usize) -> [Shape; 2] {
    let curved = |draw: &mut Draw| {
        let size = |draw: &mut Draw| [1.0, 1.0, 1e-3, 0.05][k / 3 % 4] * (0.1 + 0.6 * draw.unit());
        let (height, radius) = match k % 2 {
            0 => (size(draw), 0.1 + 0.6 * draw.unit()),
            _ => (0.1 + 0.6 * draw.unit(), size(draw)),
        };
        match (draw.unit() * 3.0) as usize {
            0 => Shape::cylinder(height, radius).unwrap(),
            1 => Shape::cone(height, radius).unwrap(),
            _ => {
                let third = height + (radius - height) * draw.unit();
                Shape::ellipsoid(DVec3::new(radius, third, height)).unwrap()
            }
        }
    };
    let first = curved(draw);
    let other = match k % 5 {
        0 | 1 => curved(draw),
        2 => Shape::triangle([(); 3].map(|()| draw.vector())).unwrap(),
        3 => Shape::capsule(0.1 + 0.4 * draw.unit(), 0.2 * draw.unit()).unwrap(),
        _ => draw.polytope(),
    };
    let first = if k.is_multiple_of(7) { first.swept(0.1 * draw.unit()).unwrap() } else { first };
    if draw.unit() < 0.5 { [first, other] } else { [other, first] }
}

/// Turned any way, alike, about each other's axes or square to them, or nearly so; the place near or on an axis now and then.
fn poses(draw: &mut Draw, k: usize) -> [Pose; 2] {
    let turn = DQuat::from_scaled_axis(draw.vector() * 3.0);
    let other = match k / 2 % 5 {
        0 => turn,
        1 => turn * DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2),
        2 => turn * DQuat::from_scaled_axis(draw.vector() * 10f64.powi(-(k as i32 / 10 % 12))),
        _ => DQuat::from_scaled_axis(draw.vector() * 3.0),
    };
    let mut place = draw.vector() * 0.6;
    if k.is_multiple_of(11) {
        place = turn * (DVec3::Z * place.z);
    }
    [Pose::new(turn, DVec3::ZERO).unwrap(), Pose::new(other.normalize(), place).unwrap()]
}

#[test]
fn pieces_prove_the_depth_that_a_fine_surface_has() {
    let seed = std::env::var("DCD_SEED").map_or(9, |seed| seed.parse().expect("a seed"));
    let (mut draw, mut surface) = (Draw(seed), Surface::default());
    let (mut found_by_pieces, mut compared, mut widest) = (0, 0, 0.0f64);
    for k in 0..6000 {
        let [shape_a, shape_b] = curved_pair(&mut draw, k);
        let [pose_a, pose_b] = poses(&mut draw, k);
        let a = PosedShape { shape: &shape_a, pose: &pose_a };
        let b = PosedShape { shape: &shape_b, pose: &pose_b };
        if certified::overlap_of(a, b).0 != Verdict::Touching(()) {
            continue;
        }
        let bodies = [a, b].map(|side| PosedSupport::shape(side.shape, side.pose));
        let tolerance = Tolerance::of(Accuracy::F64).of_curved();
        let Some(difference) = Difference::new(bodies[0], bodies[1]) else { continue };
        let scale = difference.scale();
        let search = ExpandingSearch { difference, bodies, tolerance };
        let bounds = Bounds::of(&search.difference);
        let found = search.of_overlapping_cores(&bounds, &mut surface, Some(super::by_pieces));
        let fine = search.of_overlapping_cores(&bounds, &mut surface, None);
        let (Some(found), Some(fine)) = (found, fine) else { continue };
        compared += 1;
        found_by_pieces += usize::from(found != fine);
        let off = (found.depth - fine.depth).abs();
        assert!(off <= found.error_bound + fine.error_bound, "{k}: {found:?} {fine:?}");
        if found != fine {
            widest = widest.max(found.error_bound * scale);
            let apart = found.point_a - found.point_b - found.normal * found.depth;
            assert!(apart.length() * scale < 1e-9, "{k}: {found:?}");
            for (side, point, outward) in
                [(a, found.point_a, found.normal), (b, found.point_b, -found.normal)]
            {
                let local = side.pose.rotation().transpose() * outward;
                let support = SupportMap::<f64>::support(side.shape, local).point;
                let most = outward.dot(side.pose.apply(support)) + side.shape.radius();
                let off = (outward.dot(point) - most) * scale;
                assert!(off.abs() < 1e-9, "{k}: {off:e} {found:?} {shape_a:?} {shape_b:?}");
            }
        }
    }
    assert!(found_by_pieces * 4 > compared && compared > 1000, "{found_by_pieces} of {compared}");
    assert!(widest < 1e-12, "{widest:e}");
}
