use super::*;
use crate::certificate::Bounds;
use crate::closed::curved;
use crate::distance::{Approach, Distance, DistanceResult, approach};
use crate::motion::tests::Draw;
use crate::{Difference, PosedSupport};
use dcd_geom::glam::DQuat;
use dcd_geom::{Curved, Pose};

fn curved_shape(draw: &mut Draw, k: usize) -> Curved {
    let half = draw.vector().abs() * 0.4 + 0.1;
    let (height, radius) = match k / 2 % 5 {
        0 => (half.x, 0.02),
        1 => (0.02, half.y),
        _ => (half.x, half.y),
    };
    let shape = match k % 2 {
        0 => Curved::cylinder(height, radius),
        _ => Curved::cone(height, radius),
    };
    shape.unwrap().rounded([0.0, 0.0, 0.05][k % 3]).unwrap()
}

/// Turned at random, some of them with an axis in common or nearly, or square to the other's.
fn poses(draw: &mut Draw, k: usize) -> [Pose; 2] {
    let turn = DQuat::from_scaled_axis(draw.vector() * 3.0);
    let tilt = match k % 8 {
        0 => DVec3::ZERO,
        1 => draw.vector() * 1e-7,
        2 => DVec3::X * std::f64::consts::FRAC_PI_2,
        3 => DVec3::X * std::f64::consts::PI,
        _ => draw.vector() * 3.0,
    };
    let turned = turn * DQuat::from_scaled_axis(tilt);
    let away = draw.vector() * 1.3;
    // Square to an axis, too.
    let away = if k.is_multiple_of(5) { turn * DVec3::new(away.x, 0.0, away.z) } else { away };
    let far = draw.vector() * [0.0, 1e3][k / 8 % 2];
    [Pose::new(turn, far).unwrap(), Pose::new(turned, far + away).unwrap()]
}

/// What the search in f64 proves to its end.
fn by_search(sides: [PosedShape<'_>; 2]) -> Option<Distance> {
    let [a, b] = sides.map(|side| PosedSupport::shape(side.shape, side.pose));
    let difference = Difference::new(a, b)?;
    let bounds = Bounds::of(&difference);
    let mut near = Approach::begin(&difference);
    approach(&difference, &bounds, 0.0, &mut near).ok()?;
    let is_apart = near.lower > bounds.swept_upper();
    is_apart.then(|| near.distance(&bounds, difference.scale(), (a, b)))
}

fn known(found: Option<Limited>) -> Option<Distance> {
    match found {
        Some(Limited::Known(DistanceResult::Apart(found))) => Some(found),
        _ => None,
    }
}

#[test]
fn feet_are_the_nearest_points_that_another_formula_finds() {
    let mut draw = Draw(17);
    for k in 0..3000 {
        let curved = curved_shape(&mut draw, k);
        let profile = Profile::of(&curved).unwrap();
        let point = draw.vector() * [0.2, 0.7, 3.0][k % 3];
        let point = if k.is_multiple_of(7) { DVec3::new(0.0, 0.0, point.z) } else { point };
        let (foot, due) = (profile.foot(point), curved::nearest(&curved, point));
        assert!(foot.point.distance(due) < 1e-14, "{k}: {curved:?} {point} {foot:?} {due}");
        assert_eq!(foot.part == Part::Inside, foot.point == point, "{k}: {foot:?}");
        let along = draw.vector().normalize();
        let moved = 1e-6;
        let there = profile.foot(point + along * moved);
        if there.part == foot.part {
            let follows = (there.point - foot.point).dot(along) / moved;
            assert!((follows - profile.follows(&foot, along)).abs() < 1e-3, "{k}: {foot:?}");
        }
    }
}

#[test]
fn shapes_without_height_or_radius_or_with_lengths_that_have_no_products_are_left_alone() {
    let lengths = [0.0, f64::from_bits(1), 1e-300, 1e-90, 1e-9, 1.0, 1e90, 1e300];
    for height in lengths {
        for radius in lengths {
            for curved in [Curved::cylinder(height, radius), Curved::cone(height, radius)] {
                let is_plain = height == radius && (1e-70..1e70).contains(&(height + radius));
                assert_eq!(Profile::of(&curved.unwrap()).is_some(), is_plain, "{height} {radius}");
            }
        }
    }
}

#[test]
fn two_curved_shapes_are_as_far_apart_as_the_search_finds_and_nearly_all_are_found() {
    for gap in [0.0, 1e-6] {
        let mut draw = Draw(41);
        let (mut tried, mut found_of_them) = (0, 0);
        for k in 0..8000 {
            let curved = [k, k / 3 + 1].map(|k| Shape::from(curved_shape(&mut draw, k)));
            let poses = poses(&mut draw, k);
            let sides = [0, 1].map(|k| PosedShape { shape: &curved[k], pose: &poses[k] });
            let found = known(distance([gap, f64::INFINITY], sides));
            let Some(due) = by_search(sides) else {
                continue;
            };
            tried += 1;
            let Some(found) = found else { continue };
            found_of_them += 1;
            let off = (found.distance - due.distance).abs();
            let size = 2.0 + poses[0].translation().distance(poses[1].translation());
            assert!(off <= found.error_bound + due.error_bound, "{k}: {found:?} {due:?}");
            assert!(found.error_bound <= (1.1 * gap).max(4e-14) * size, "{k}: {found:?}");
            let between = found.point_b - found.point_a - found.normal * found.distance;
            assert!(between.length() < 1e-11, "{k}: {found:?}");
            for (far, is_beyond) in [(0.99, false), (1.01, true)] {
                let limited = distance([gap, due.distance / far], sides);
                let beyond = matches!(limited, Some(Limited::Beyond));
                assert!(!beyond || is_beyond, "{k}: {far} {due:?}");
            }
        }
        assert!(tried > 4000 && found_of_them * 100 >= tried * 95, "{found_of_them} of {tried}");
    }
}
