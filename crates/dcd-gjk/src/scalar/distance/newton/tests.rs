use super::*;
use crate::PosedSupport;
use crate::motion::tests::Draw;
use crate::query::Accuracy;
use crate::{Distance, DistanceResult, distance::distance_at};
use dcd_geom::Pose;
use dcd_geom::glam::DQuat;

/// What the search in f64 proves alone, to its end.
fn by_search([a, b]: [PosedShape<'_>; 2]) -> Option<Distance> {
    let bodies = [a, b].map(|side| PosedSupport::shape(side.shape, side.pose));
    let difference = Difference::new(bodies[0], bodies[1])?;
    let bounds = Bounds::of(&difference);
    let mut near = Approach::begin(&difference);
    search(&difference, &bounds, 0.0, &mut near).ok()?;
    let is_apart = near.lower > bounds.swept_upper();
    is_apart.then(|| near.distance(&bounds, difference.scale(), (bodies[0], bodies[1])))
}

fn found_at(accuracy: Accuracy, [a, b]: [PosedShape<'_>; 2]) -> Option<Distance> {
    match distance_at(accuracy, a, b).0 {
        DistanceResult::Apart(found) => Some(found),
        _ => None,
    }
}

const KINDS: [&str; 7] =
    ["cylinder", "cone", "rounded cylinder", "cuboid", "rounded cuboid", "hull", "triangle"];

fn shape(draw: &mut Draw, kind: &str) -> Shape {
    let half = draw.vector().abs() * 0.4 + 0.1;
    let shape = match kind {
        "cylinder" => Shape::cylinder(half.x, half.y),
        "cone" => Shape::cone(half.x, half.y),
        "rounded cylinder" => Shape::cylinder(half.x, half.y).unwrap().rounded(0.05),
        "cuboid" => Shape::cuboid(half),
        "rounded cuboid" => Shape::cuboid(half).unwrap().rounded(0.05),
        "hull" => Shape::hull((0..20).map(|_| draw.vector().normalize() * half).collect()),
        _ => Shape::triangle([0, 1, 2].map(|_| draw.vector() * half)),
    };
    shape.unwrap()
}

/// Turned at random, a quarter of them with an axis in common or nearly.
fn poses(draw: &mut Draw, k: usize) -> [Pose; 2] {
    let turn = DQuat::from_scaled_axis(draw.vector() * 3.0);
    let tilt = draw.vector() * [3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 0.0, 1e-7][k % 8];
    let (far, away) = (draw.vector() * [0.0, 1e3][k / 8 % 2], draw.vector() * 1.3);
    let turned = DQuat::from_scaled_axis(tilt) * turn;
    [Pose::new(turn, far).unwrap(), Pose::new(turned, far + away).unwrap()]
}

/// How near the bounds of nearly all are at an accuracy: relative to the size of some metres.
fn limit(accuracy: Accuracy, are_curved: bool) -> f64 {
    match accuracy {
        // Of two curved shapes formulas end where the bound is good enough.
        Accuracy::F32 if are_curved => 1e-6,
        // Newton's last step is known to be small by the one before.
        Accuracy::F32 => 1e-10,
        _ => 1e-14,
    }
}

#[test]
fn curved_shapes_are_as_far_apart_as_the_search_finds_and_nearly_all_to_the_last_digits() {
    let kinds = KINDS[..3].iter().flat_map(|one| KINDS.map(|other| (one, other)));
    for (accuracy, (one, other)) in kinds.flat_map(|kinds| {
        [Accuracy::F32, Accuracy::F64, Accuracy::Certified].map(|accuracy| (accuracy, kinds))
    }) {
        let mut draw = Draw(31);
        let limit = limit(accuracy, KINDS[..3].contains(&other));
        let (mut tried, mut sharp) = (0, 0);
        for k in 0..400 {
            let shapes = [shape(&mut draw, one), shape(&mut draw, other)];
            let poses = poses(&mut draw, k);
            let sides = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
            let (Some(due), Some(found)) = (by_search(sides), found_at(accuracy, sides)) else {
                continue;
            };
            let back = found_at(accuracy, [sides[1], sides[0]]).unwrap();
            assert_eq!(back.mirrored(), found, "{one}-{other} {k}");
            let off = (found.distance - due.distance).abs();
            let bounds = found.error_bound + due.error_bound;
            assert!(off <= bounds, "{one}-{other} {k}: {found:?} {due:?}");
            let between = found.point_b - found.point_a - found.normal * found.distance;
            let far = 1.0 + poses[0].translation().length();
            // Where a search ends, its normal is known by the root of its bound.
            assert!(between.length() < 1e-8 * far, "{one}-{other} {accuracy:?} {k}: {found:?}");
            tried += 1;
            sharp += u32::from(found.error_bound < limit * (2.0 + far));
        }
        let are_sharp = tried > 100 && sharp * 10 >= tried * 7;
        assert!(are_sharp, "{one}-{other} {accuracy:?}: {sharp} of {tried}");
    }
}

/// The certified bound of a distance that is known, at the accuracy of f64.
fn is_sharp(shapes: [Shape; 2], there: Pose, due: f64) {
    let here = Pose::IDENTITY;
    let sides =
        [(&shapes[0], &here), (&shapes[1], &there)].map(|(shape, pose)| PosedShape { shape, pose });
    let found = found_at(Accuracy::F64, sides).unwrap();
    let is_right = (found.distance - due).abs() <= found.error_bound;
    assert!(is_right && found.error_bound < 1e-13, "{found:?}, {due}");
}

#[test]
fn sides_rims_and_discs_have_the_distances_that_are_known_of_them() {
    let cylinder = || Shape::cylinder(1.0, 0.25).unwrap();
    let upright = |x, y, z| Pose::from_translation(DVec3::new(x, y, z)).unwrap();
    let turned =
        |axis: DVec3, angle, at| Pose::new(DQuat::from_axis_angle(axis, angle), at).unwrap();
    // Two sides whose axes cross.
    let across = turned(DVec3::X, 1.2, DVec3::new(0.9, 0.05, -0.1));
    is_sharp([cylinder(), cylinder()], across, 0.4);
    // A corner above a disc, beside its middle.
    let corner = DQuat::from_rotation_arc(DVec3::ONE.normalize(), DVec3::NEG_Z);
    let cube = Shape::cuboid(DVec3::splat(0.25)).unwrap();
    let height = 1.25 + 0.25 * 3f64.sqrt();
    let above = Pose::new(corner, DVec3::new(0.07, 0.11, height)).unwrap();
    is_sharp([cylinder(), cube], above, 0.25);
    // Two sides whose axes are parallel.
    is_sharp([cylinder(), cylinder()], upright(0.9, 0.3, 0.1), 0.9f64.hypot(0.3) - 0.5);
    // A rim beside a rim: coaxial planes, discs at two heights.
    is_sharp([cylinder(), cylinder()], upright(0.8, 0.0, 2.4), 0.3f64.hypot(0.4));
    // An apex above a disc, upside down.
    let cone = Shape::cone(0.5, 0.25).unwrap();
    let flipped = turned(DVec3::X, std::f64::consts::PI, DVec3::new(0.1, 0.02, 1.75));
    is_sharp([cylinder(), cone], flipped, 0.25);
}

#[test]
fn shapes_without_height_or_radius_have_bounds_that_hold() {
    let mut draw = Draw(8);
    for k in 0..2000 {
        let flat = [0.0, 1e-12, 0.3][k % 3];
        let thin = [0.0, 1e-12, 0.2][k / 3 % 3];
        let one = if k % 2 == 0 { Shape::cylinder(flat, thin) } else { Shape::cone(flat, thin) };
        let shapes = [one.unwrap(), shape(&mut draw, KINDS[k % KINDS.len()])];
        let poses = poses(&mut draw, k);
        let sides = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
        let (Some(due), Some(found)) = (by_search(sides), found_at(Accuracy::F32, sides)) else {
            continue;
        };
        let off = (found.distance - due.distance).abs();
        assert!(off <= found.error_bound + due.error_bound, "{k}: {found:?} {due:?}");
    }
}

#[test]
fn an_edge_ends_at_corners_that_the_feature_has() {
    let corners = [DVec3::X, DVec3::Y, DVec3::ZERO];
    let of = |weights, count| Feature::Flat { corners, weights, count }.edge();
    assert_eq!(of([0.0, 0.0], 1), Some([DVec3::X, DVec3::X]));
    for second in [0.0, 0.25, 1.0] {
        assert_eq!(of([second, 0.0], 2), Some([DVec3::X, DVec3::Y]));
    }
    assert_eq!(of([0.4, 0.5], 3), Some([DVec3::Y, DVec3::ZERO]));
    assert_eq!(of([0.1, 0.5], 3), Some([DVec3::X, DVec3::ZERO]));
    assert_eq!(of([0.5, 0.1], 3), Some([DVec3::X, DVec3::Y]));
}

/// The origin of its frame is no point of the triangle, and nearer.
#[test]
fn a_flat_disc_is_as_far_from_a_triangle_as_from_its_nearest_corner() {
    let disc = Shape::cylinder(1e-6, 1.0).unwrap();
    let near = DVec3::new(0.5, 0.0, 0.0);
    let triangle = Shape::triangle([near, DVec3::X, near]).unwrap();
    let across = DMat3::from_cols(DVec3::Z, DVec3::NEG_Y, DVec3::X);
    let disc_pose = Pose::from_matrix(across, DVec3::new(-1.0, -0.5, 0.25)).unwrap();
    let turn = DQuat::from_scaled_axis(DVec3::new(8e-9, -8e-8, 5e-8)).normalize();
    let pose = Pose::new(turn, DVec3::new(0.25, 0.0, 1.0)).unwrap();
    let sides =
        [(&disc, &disc_pose), (&triangle, &pose)].map(|(shape, pose)| PosedShape { shape, pose });
    for accuracy in [Accuracy::F32, Accuracy::F64, Accuracy::Certified] {
        let found = found_at(accuracy, sides).unwrap();
        // A turn by 1e-7 lifts the corner by its square.
        let is_right = (found.distance - (1.75 - 1e-6)).abs() <= found.error_bound + 1e-13;
        assert!(is_right && found.point_b.x > 0.7, "{accuracy:?}: {found:?}");
    }
}

#[test]
fn equations_are_solved_and_refused_where_they_curve_the_wrong_way() {
    let rows =
        [[4.0, 0.0, 0.0, 0.0], [1.0, 3.0, 0.0, 0.0], [0.5, -1.0, 5.0, 0.0], [0.0, 0.25, 1.0, 2.0]];
    let due = [1.0, -2.0, 0.5, 3.0];
    let entry = |j: usize, k: usize| if j <= k { rows[j][k] } else { rows[k][j] };
    let right = [0, 1, 2, 3].map(|j| (0..4).map(|k| entry(j, k) * due[k]).sum());
    let found = solved(rows, right).unwrap();
    assert!(found.iter().zip(due).all(|(x, y)| (x - y).abs() < 1e-14), "{found:?}");
    let mut wrong = rows;
    wrong[2][2] = -1.0;
    assert!(solved(wrong, right).is_none());
    wrong[2][2] = f64::NAN;
    assert!(solved(wrong, right).is_none());
}
