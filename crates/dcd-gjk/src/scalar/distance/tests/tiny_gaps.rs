//! Cylinders and cones a hair beside each other and beside polytopes, at features of which the gap is known.

use crate::motion::tests::Draw;
use crate::query::Accuracy;
use crate::{Distance, DistanceResult, PosedShape, distance};
use dcd_geom::glam::{DQuat, DVec2, DVec3};
use dcd_geom::{Pose, Shape};

/// A shape, a point of its surface, and a direction from which that point is the nearest; its own frame.
struct At {
    shape: Shape,
    point: DVec3,
    outward: DVec3,
}

fn curved(draw: &mut Draw, k: usize) -> At {
    let [height, radius, share] = (draw.vector().abs() * 0.5 + 0.1).to_array();
    let is_cone = k.is_multiple_of(2);
    let shape = if is_cone { Shape::cone(height, radius) } else { Shape::cylinder(height, radius) };
    let top = if is_cone { 0.0 } else { radius };
    let azimuth = DVec2::from_angle(draw.vector().x * 3.0);
    let slant = DVec2::new(2.0 * height, radius - top).normalize();
    let side = (azimuth * slant.x).extend(slant.y);
    let (point, outward) = match k / 2 % 4 {
        0 => ((azimuth * radius * share).extend(-height), DVec3::NEG_Z),
        1 => (
            (azimuth * (radius + (top - radius) * share)).extend(height * (2.0 * share - 1.0)),
            side,
        ),
        2 => ((azimuth * radius).extend(-height), side.lerp(DVec3::NEG_Z, share).normalize()),
        _ => ((azimuth * top).extend(height), side.lerp(DVec3::Z, share).normalize()),
    };
    At { shape: shape.unwrap(), point, outward }
}

fn polytope(draw: &mut Draw, k: usize) -> At {
    let half = draw.vector().abs() * 0.5 + 0.1;
    let within = draw.vector() * half;
    let shape = match k % 3 {
        0 => Shape::cuboid(half),
        1 => Shape::capsule(half.z, 0.0),
        _ => Shape::hull((0..8).map(|c| half * sign(c)).collect()),
    };
    let (point, outward) = match (k % 3, k / 3 % 3) {
        (1, 0) => (half.z * DVec3::Z, DVec3::new(0.3, 0.2, 0.7)),
        (1, _) => (within.z * DVec3::Z, DVec3::X),
        (_, 0) => (DVec3::new(within.x, within.y, half.z), DVec3::Z),
        (_, 1) => (DVec3::new(within.x, half.y, half.z), DVec3::new(0.0, 0.6, 0.8)),
        _ => (half, DVec3::new(0.4, 0.5, 0.6)),
    };
    At { shape: shape.unwrap(), point, outward: outward.normalize() }
}

fn sign(corner: usize) -> DVec3 {
    let bit = |k: usize| if corner >> k & 1 == 0 { 1.0 } else { -1.0 };
    DVec3::new(bit(0), bit(1), bit(2))
}

/// The second shape that far before the first, and then turned a little round the point.
fn poses(draw: &mut Draw, [a, b]: [&At; 2], (gap, tilt): (f64, f64)) -> [Pose; 2] {
    let turn = DQuat::from_scaled_axis(draw.vector() * 3.0);
    let spin = DQuat::from_rotation_z(draw.vector().x * 3.0);
    let up = DVec3::Z;
    let of_a = (turn * DQuat::from_rotation_arc(a.outward, up)).normalize();
    let tilted = DQuat::from_scaled_axis(draw.vector() * tilt) * spin;
    let of_b = (turn * tilted * DQuat::from_rotation_arc(b.outward, -up)).normalize();
    let pose_a = Pose::new(of_a, DVec3::ZERO).unwrap();
    let there = pose_a.apply(a.point) + turn * up * gap;
    [pose_a, Pose::new(of_b, there - of_b * b.point).unwrap()]
}

/// How many of many pairs have a bound above 1e-11, which it may be where the truth is known to be `gap` and is within it.
fn are_bounded(seed: u64, other: impl Fn(&mut Draw, usize) -> At) -> [usize; 2] {
    let mut draw = Draw(seed);
    let [mut wide, mut beside, mut tried] = [0; 3];
    for k in 0..6000 {
        let (a, b) = (curved(&mut draw, k), other(&mut draw, k / 8));
        let gap = 10f64.powi(-5 - (k / 3 % 9) as i32);
        let tilt = [0.0, 1e-12, 1e-10, 1e-9, 1e-8, 1e-6, 1e-4][k % 7];
        let poses = poses(&mut draw, [&a, &b], (gap, tilt));
        let sides = [(&a, &poses[0]), (&b, &poses[1])]
            .map(|(at, pose)| PosedShape { shape: &at.shape, pose });
        for accuracy in [Accuracy::F64, Accuracy::Certified] {
            let (found, _) = distance::distance_at(accuracy, sides[0], sides[1]);
            let DistanceResult::Apart(found) = found else { continue };
            tried += 1;
            wide += usize::from(found.error_bound > 1e-11);
            if tilt == 0.0 {
                let off = (found.distance - gap).abs();
                assert!(off <= found.error_bound + 2e-15, "{k}: {gap:e} {found:?}");
            }
            let Distance { point_a, point_b, normal, .. } = found;
            let between = (point_b - point_a).length();
            let is_apart = (between - found.distance).abs() <= found.error_bound + 4e-15;
            // Of a search that ends in rounding both points may be its last, and the bound that of earlier ones.
            beside += usize::from(!is_apart);
            assert!((normal.length() - 1.0).abs() < 1e-15, "{k}: {normal}");
        }
    }
    assert!(beside * 1000 <= tried, "{beside} of {tried}");
    [wide, tried]
}

#[test]
fn cylinders_and_cones_that_all_but_meet_are_bounded_as_if_they_were_far() {
    let [wide, tried] = are_bounded(3, curved);
    assert!(tried > 10_000 && wide * 500 <= tried, "{wide} of {tried}");
}

#[test]
fn cylinders_and_cones_that_all_but_meet_polytopes_are_bounded_as_if_they_were_far() {
    let [wide, tried] = are_bounded(4, polytope);
    assert!(tried > 10_000 && wide * 500 <= tried, "{wide} of {tried}");
}
