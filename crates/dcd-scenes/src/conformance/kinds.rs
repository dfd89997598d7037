//! Pairs of shapes of every kind between neighbouring floats: flat and rounded ones, compounds, meshes,
//! cylinders and cones, many of them far from the origin of their own frame.

use super::bodies::{cloud, cuboid, direction, moved, power_of_ten, quarter_turns, sized, turned};
use super::flips::last_touching;
use crate::random::Draw;
use dcd_geom::{Polytope, Pose, Shape};
use glam::DVec3;

/// Two shapes and where they are.
#[derive(Clone, Debug)]
pub struct ShapePair {
    /// The first.
    pub a: Shape,
    /// The first shape's pose.
    pub pose_a: Pose,
    /// The second.
    pub b: Shape,
    /// The second shape's pose.
    pub pose_b: Pose,
}

impl ShapePair {
    /// Whether one of them is a cylinder or a cone, for which no exact method answers.
    #[must_use]
    pub fn is_curved(&self) -> bool {
        [&self.a, &self.b].into_iter().any(|shape| matches!(shape, Shape::Curved(_)))
    }
}

/// What the shapes of a pair have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShapeFamily {
    /// Points, segments, triangles and flat hulls with a radius: no sphere is inscribed in their cores.
    Flat,
    /// Hulls and cuboids, with and without a radius.
    Polytopes,
    /// Compounds of one to three such parts.
    Compounds,
    /// Triangle meshes, with and without a radius.
    Meshes,
    /// Cylinders and cones, with and without a radius.
    Curved,
}

impl ShapeFamily {
    /// All of them, in the order of a report.
    pub const ALL: [Self; 5] =
        [Self::Flat, Self::Polytopes, Self::Compounds, Self::Meshes, Self::Curved];

    /// The family of pair `k` of [`shape_flip`].
    #[must_use]
    pub const fn of(k: u64) -> Self {
        match k % 6 {
            0 => Self::Flat,
            1 | 2 => Self::Polytopes,
            3 => Self::Compounds,
            4 => Self::Meshes,
            _ => Self::Curved,
        }
    }

    /// Its name in a report.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Flat => "flat, rounded",
            Self::Polytopes => "hulls and cuboids, some rounded",
            Self::Compounds => "compounds",
            Self::Meshes => "meshes",
            Self::Curved => "cylinders and cones",
        }
    }
}

/// Whether a pair touches; `None` where that is not known.
pub type ShapeJudge<'a> = &'a dyn Fn(&ShapePair) -> Option<bool>;

/// How far from the origin of its own frame a shape is, in a cycle; in sizes.
const OUT: [f64; 4] = [0.0, 1e3, 1e7, 1e12];

/// Streams of these pairs' draws: above those of [`super::flip`].
const STREAMS: u64 = 3 << 62;

/// Pair `k` of a seed, moved along a line until it stops touching: the two neighbouring floats there, the
/// one that touches first. `None` where `touches` sees no end of it, or does not know.
#[must_use]
pub fn shape_flip(seed: u64, k: u64, touches: ShapeJudge<'_>) -> Option<[ShapePair; 2]> {
    let mut draw = Draw::new(seed, STREAMS | k);
    let kind = (k % 6) as usize;
    let size = power_of_ten(6 * (k / 6 % 3) as i32 - 6);
    let out = OUT[(k / 18 % 4) as usize] * size;
    let (pair, along) = match kind {
        5 => curved(&mut draw, size, out)?,
        _ => {
            let [a, b] = [(); 2].map(|()| body(kind, &mut draw, size, out));
            let ((a, pose_a), (b, pose_b)) = (a?, b?);
            (ShapePair { a, pose_a, b, pose_b }, direction(&mut draw) * size)
        }
    };
    let at = |steps: f64| {
        let t = pair.pose_b.translation() + along * steps;
        Some(ShapePair { pose_b: moved(&pair.pose_b, t)?, ..pair.clone() })
    };
    let flip = last_touching(64.0, |steps| touches(&at(steps)?))?;
    Some([at(flip)?, at(flip.next_up())?])
}

/// A core of one kind, round a point `far` of its own frame.
fn core(kind: usize, draw: &mut Draw, size: f64, far: DVec3) -> Option<Polytope> {
    let around = |points: Vec<DVec3>| points.into_iter().map(|p| far + p).collect::<Vec<_>>();
    let flat = |draw: &mut Draw, count: u32| {
        let (x, y) = (direction(draw) * size, direction(draw) * size);
        let weights = |draw: &mut Draw| (draw.between(-1.0, 1.0), draw.between(-1.0, 1.0));
        (0..count).map(|_| weights(draw)).map(|(u, v)| x * u + y * v).collect::<Vec<_>>()
    };
    let core = match (kind, draw.count(0..5)) {
        // So many copies of one point that the sums of their mean are rounded.
        (0, 0) => {
            let copies = draw.count(30..99) as usize;
            Polytope::hull(vec![far + direction(draw) * size; copies])
        }
        (0, 1) => Polytope::segment(far + direction(draw) * size, far + direction(draw) * size),
        (0, 2) => Polytope::triangle([(); 3].map(|()| far + direction(draw) * size)),
        (0, _) => Polytope::hull(around(flat(draw, 6))),
        (_, 0) => Polytope::hull(sized(&cuboid(draw)?, size)?.vertices().to_vec()),
        (_, 1) => Polytope::hull(around(flat(draw, 5))),
        _ => Polytope::hull(around(cloud(draw, DVec3::splat(size)))),
    };
    core.ok()
}

/// A shape of one kind at a pose that brings its middle near the origin of the world.
fn body(kind: usize, draw: &mut Draw, size: f64, out: f64) -> Option<(Shape, Pose)> {
    let far = direction(draw) * out;
    let radius = match draw.count(0..3) {
        // What has no sphere inside is touched by its radius alone.
        0 if kind > 0 => 0.0,
        1 => size * 1e-3,
        _ => size * draw.between(0.1, 1.0),
    };
    let (shape, middle) = match kind {
        0..=2 => {
            let core = core(kind, draw, size, far)?.rounded(radius).ok()?;
            let middle = core.inner().centre;
            (Shape::from(core), middle)
        }
        3 => {
            let parts = draw.count(1..4);
            let part = |draw: &mut Draw| {
                let core = core(draw.count(0..2) as usize, draw, size, DVec3::ZERO)?;
                let place = far + direction(draw) * size;
                let pose = turned(draw, place)?;
                Some((core.rounded(radius).ok()?.into(), pose))
            };
            let parts = (0..parts).map(|_| part(draw)).collect::<Option<Vec<_>>>()?;
            let middle = parts[0].1.translation();
            (Shape::compound(parts).ok()?, middle)
        }
        _ => {
            let corners: Vec<DVec3> = (0..5).map(|_| far + direction(draw) * size).collect();
            let middle = corners.iter().fold(DVec3::ZERO, |sum, &p| sum + p * 0.2);
            let mesh = Shape::mesh(corners, vec![[0, 1, 2], [0, 2, 3], [4, 1, 2]]).ok()?;
            (mesh.rounded(radius).ok()?, middle)
        }
    };
    let rotation = *turned(draw, DVec3::ZERO)?.rotation();
    let near = direction(draw) * (0.01 * size);
    Some((shape, Pose::from_matrix(rotation, near - rotation * middle).ok()?))
}

/// Two cylinders, or a cone and a cylinder, in places that can be judged, and the way out.
fn curved(draw: &mut Draw, size: f64, out: f64) -> Option<(ShapePair, DVec3)> {
    let mut length = || draw.between(0.1, 1.0) * size;
    let (h, r, g, s) = (length(), length(), length(), length());
    let swept = [length(), length()];
    let swept = if draw.count(0..2) == 0 { [0.0; 2] } else { swept };
    let turn = quarter_turns(draw);
    let across = turn.x_axis * (draw.between(-0.5, 0.5) * r.min(s));
    let up = turn.z_axis * (draw.between(-0.9, 0.9) * h.min(g));
    let cylinder = |h, r| Shape::cylinder(h, r).ok();
    let (a, between, turn_b, along) = match draw.count(0..5) {
        0 => (cylinder(h, r)?, across + up, turn, turn.y_axis),
        1 => (cylinder(h, r)?, across, turn, turn.z_axis),
        2 => (Shape::cone(h, r).ok()?, across + up - turn.z_axis * h, turn, turn.y_axis),
        // From where the apex is in the cylinder.
        3 => (Shape::cone(h, r).ok()?, across + turn.z_axis * (h + 0.5 * g), turn, turn.z_axis),
        _ => {
            let crossed = glam::DMat3::from_cols(turn.y_axis, turn.z_axis, turn.x_axis);
            (cylinder(h, r)?, across + up * 0.5, crossed, turn.y_axis)
        }
    };
    let b = cylinder(g, s)?;
    let at_a = direction(draw) * out;
    let pair = ShapePair {
        a: a.rounded(swept[0]).ok()?,
        pose_a: Pose::from_matrix(turn, at_a).ok()?,
        b: b.rounded(swept[1]).ok()?,
        pose_b: Pose::from_matrix(turn_b, at_a + between).ok()?,
    };
    Some((pair, along * size))
}
