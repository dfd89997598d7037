//! Hulls of every form, placed anywhere.

use super::bodies::{
    Placed, box_or_hull, cloud, cuboid, direction, hull, moved, power_of_ten, quarter_turns, sized,
    turned,
};
use crate::random::Draw;
use dcd_geom::{Polytope, Pose};
use glam::DVec3;

type Pair = Option<[Placed; 2]>;

pub(super) fn random(draw: &mut Draw) -> Pair {
    let spot = draw.point(-1.2, 1.2);
    Some([(hull(draw, 1.0)?, turned(draw, DVec3::ZERO)?), (hull(draw, 1.0)?, turned(draw, spot)?)])
}

/// Pairs from 1 to 1e9 from the origin.
pub(super) fn far(k: usize, draw: &mut Draw) -> Pair {
    let out = direction(draw) * power_of_ten((k % 10) as i32);
    let [(a, at_a), (b, at_b)] = random(draw)?;
    let at_a = moved(&at_a, at_a.translation() + out)?;
    let at_b = moved(&at_b, at_b.translation() + out)?;
    Some([(a, at_a), (b, at_b)])
}

/// Pairs of sizes from 1e-9 to 1e9 metres.
pub(super) fn scaled(k: usize, draw: &mut Draw) -> Pair {
    let size = power_of_ten((k % 19) as i32 - 9);
    let [(a, at_a), (b, at_b)] = random(draw)?;
    let at_b = moved(&at_b, at_b.translation() * size)?;
    Some([(sized(&a, size)?, at_a), (sized(&b, size)?, at_b)])
}

/// The second is 1 to 1e-6 as large, near a vertex of the first or anywhere in its AABB.
pub(super) fn ratio(k: usize, draw: &mut Draw) -> Pair {
    let size = power_of_ten(-((k % 7) as i32));
    let a = (hull(draw, 1.0)?, turned(draw, DVec3::ZERO)?);
    let spot = match k % 3 {
        0 => draw.point(-1.0, 1.0),
        _ => a.1.apply(a.0.vertices()[k % a.0.vertices().len()]) + draw.point(-1.0, 1.0) * size,
    };
    let pair = [a, (hull(draw, size)?, turned(draw, spot)?)];
    Some(if k.is_multiple_of(2) { pair } else { swapped(pair) })
}

pub(super) fn stretched(stretch: DVec3, draw: &mut Draw) -> Pair {
    let a = Polytope::hull(cloud(draw, stretch)).ok()?;
    let b = Polytope::hull(cloud(draw, stretch)).ok()?;
    let at_a = turned(draw, DVec3::ZERO)?;
    // Together along what they are thick in, else most would be far apart.
    let spot = *at_a.rotation() * (draw.point(-1.0, 1.0) * stretch);
    let at_b = match draw.count(0..3) {
        0 => moved(&at_a, spot)?,
        _ => turned(draw, spot)?,
    };
    Some([(a, at_a), (b, at_b)])
}

/// Two plates, in one plane exactly, in one plane but for rounding, or across.
pub(super) fn flat(k: usize, draw: &mut Draw) -> Pair {
    let plate = DVec3::new(1.0, 1.0, 0.0);
    let [a, b] = [cloud(draw, plate), cloud(draw, plate)].map(|p| Polytope::hull(p).ok());
    let spot = draw.point(-1.5, 1.5) * plate;
    let at_a = turned(draw, DVec3::ZERO)?;
    let (at_a, at_b) = match k % 3 {
        0 => (Pose::IDENTITY, moved(&Pose::IDENTITY, spot)?),
        1 => (at_a, moved(&at_a, *at_a.rotation() * spot)?),
        _ => (at_a, turned(draw, spot * 0.5)?),
    };
    Some([(a?, at_a), (b?, at_b)])
}

/// A segment of several points and another, or a hull; along one line, crossing, or skew.
pub(super) fn collinear(k: usize, draw: &mut Draw) -> Pair {
    let line = DVec3::new(1.0, 0.0, 0.0);
    let a = Polytope::hull(cloud(draw, line)).ok()?;
    let at_a = turned(draw, DVec3::ZERO)?;
    let b = match k % 4 {
        3 => hull(draw, 1.0)?,
        _ => Polytope::hull(cloud(draw, line)).ok()?,
    };
    let spot = draw.point(-1.0, 1.0);
    let (at_a, at_b) = match k % 4 {
        0 => (Pose::IDENTITY, moved(&Pose::IDENTITY, spot * line * 2.0)?),
        1 => (at_a, moved(&at_a, *at_a.rotation() * (spot * line * 2.0))?),
        _ => (at_a, turned(draw, spot * 0.3)?),
    };
    Some([(a, at_a), (b, at_b)])
}

/// A point: with another, on a vertex, on the middle of an edge but for rounding, anywhere.
pub(super) fn point(k: usize, draw: &mut Draw) -> Pair {
    let one = |p: DVec3| Polytope::hull(vec![p]).ok();
    let spot = if k.is_multiple_of(2) { DVec3::ZERO } else { draw.point(-1.0, 1.0) };
    let a = (box_or_hull(k, draw, 1.0)?, turned(draw, spot)?);
    let [first, second] = [0, 1].map(|v| a.0.vertices()[v]);
    match k % 5 {
        0 => {
            let p = draw.point(-1.0, 1.0);
            let step = if k.is_multiple_of(2) { 0.0 } else { f64::EPSILON };
            Some([(one(p)?, a.1), (one(p + DVec3::X * step)?, a.1)])
        }
        1 => Some([(one(first)?, a.1), a]),
        2 => Some([(one((first + second) * 0.5)?, a.1), a]),
        3 => Some([(one(a.1.apply(first))?, Pose::IDENTITY), a]),
        _ => Some([(one(draw.point(-1.0, 1.0))?, a.1), a]),
    }
}

/// Every point two to five times, in any order.
pub(super) fn duplicate(draw: &mut Draw) -> Pair {
    let [a, b] = random(draw)?;
    let mut again = |(shape, pose): Placed| {
        let vertices = shape.vertices();
        let mut points = vertices.to_vec();
        let more = vertices.len() as u32 * draw.count(1..4);
        for _ in 0..more {
            points.push(vertices[draw.count(0..vertices.len() as u32) as usize]);
        }
        let third = points.len() / 3;
        points.rotate_left(third);
        Some((Polytope::hull(points).ok()?, pose))
    };
    Some([again(a)?, again(b)?])
}

/// A tenth to a hundredth as large, near the middle of the other.
pub(super) fn nested(k: usize, draw: &mut Draw) -> Pair {
    let outer = (box_or_hull(k, draw, 1.0)?, turned(draw, DVec3::ZERO)?);
    let size = outer.0.inner().radius * draw.between(0.01, 0.5);
    let middle = outer.1.apply(outer.0.inner().centre);
    let spot = middle + draw.point(-1.0, 1.0) * size;
    let inner = box_or_hull(k / 2, draw, size)?;
    Some([outer, (inner, turned(draw, spot)?)])
}

/// Round one point of their insides, turned alike, by quarter turns, or any way.
pub(super) fn concentric(k: usize, draw: &mut Draw) -> Pair {
    let (a, b) = (box_or_hull(k, draw, 1.0)?, box_or_hull(k / 3, draw, 1.0)?);
    let at_a = turned(draw, DVec3::ZERO)?;
    let at_b = match k % 3 {
        0 => at_a,
        1 => Pose::from_matrix(quarter_turns(draw), DVec3::ZERO).ok()?,
        _ => turned(draw, DVec3::ZERO)?,
    };
    let shift = at_a.apply(a.inner().centre) - at_b.apply(b.inner().centre);
    let at_b = moved(&at_b, shift)?;
    Some([(a, at_a), (b, at_b)])
}

/// One shape twice at one pose, near the origin or far out.
pub(super) fn identical(k: usize, draw: &mut Draw) -> Pair {
    let shape = match k % 3 {
        0 => cuboid(draw)?,
        _ => hull(draw, power_of_ten(k as i32 % 7 - 3))?,
    };
    let out = direction(draw) * power_of_ten(k as i32 % 5);
    let place = (shape, turned(draw, out)?);
    Some([place.clone(), place])
}

/// The middles of their insides less apart than either's inner sphere reaches.
pub(super) fn deep(draw: &mut Draw) -> Pair {
    let (a, b) = (hull(draw, 1.0)?, hull(draw, 1.0)?);
    let (at_a, at_b) = (turned(draw, DVec3::ZERO)?, turned(draw, DVec3::ZERO)?);
    let off = draw.point(-0.5, 0.5) * a.inner().radius.max(b.inner().radius);
    let shift = at_a.apply(a.inner().centre) - at_b.apply(b.inner().centre) + off;
    let at_b = moved(&at_b, shift)?;
    Some([(a, at_a), (b, at_b)])
}

fn swapped([a, b]: [Placed; 2]) -> [Placed; 2] {
    [b, a]
}
