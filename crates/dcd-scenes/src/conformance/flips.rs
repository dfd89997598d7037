//! Pairs between neighbouring floats.

use super::bodies::{Placed, cloud, cuboid, direction, moved, power_of_ten, sized, turned};
use super::{Case, Judge};
use crate::random::Draw;
use dcd_geom::{Polytope, Pose};
use glam::DVec3;

/// How the hulls are stretched, in a cycle.
const STRETCHES: [DVec3; 4] =
    [DVec3::ONE, DVec3::new(1.0, 1.0, 0.02), DVec3::new(0.05, 0.05, 1.0), DVec3::ONE];

/// What is bisected: hulls, plates, needles and cuboids, rounded or not, with their middles at one
/// place, turned alike or not, at scales of 1e-6, 1 and 1e6, some far out.
pub(super) fn origin(k: usize, draw: &mut Draw) -> Option<[Placed; 2]> {
    let size = power_of_ten(6 * (k % 3) as i32 - 6);
    let out = if k % 4 == 3 { direction(draw) * size * 1e5 } else { DVec3::ZERO };
    let (a, b) = (shape(k, size, draw)?, shape(k / 5, size, draw)?);
    let at_a = turned(draw, out)?;
    let at_b = if k.is_multiple_of(5) { at_a } else { turned(draw, out)? };
    let shift = at_a.apply(a.inner().centre) - at_b.apply(b.inner().centre);
    let at_b = moved(&at_b, at_b.translation() + shift)?;
    Some([(a, at_a), (b, at_b)])
}

fn shape(k: usize, size: f64, draw: &mut Draw) -> Option<Polytope> {
    let core = match k % 5 {
        4 => sized(&cuboid(draw)?, size)?,
        form => Polytope::hull(cloud(draw, STRETCHES[form] * size)).ok()?,
    };
    let radius = if k % 8 == 7 { draw.between(0.01, 0.3) * size } else { 0.0 };
    core.rounded(radius).ok()
}

/// A pair whose second body slides along a line.
#[derive(Clone, Debug)]
pub struct Slide {
    from: Case,
    along: DVec3,
}

impl Slide {
    /// The pair as the second body moves along `along`, metres for a step of 1.
    #[must_use]
    pub fn new(from: Case, along: DVec3) -> Self {
        Self { from, along }
    }

    /// The pair after so many steps. `None` where its translation overflows.
    #[must_use]
    pub fn at(&self, steps: f64) -> Option<Case> {
        let t = self.from.pose_b.translation() + self.along * steps;
        let pose_b: Pose = moved(&self.from.pose_b, t)?;
        Some(Case { pose_b, ..self.from.clone() })
    }

    /// The last number of steps in 0..far at which the pair touches; at the next float it does
    /// not. `None` if it does not touch at 0, or touches at `far`.
    #[must_use]
    pub fn flip(&self, far: f64, touches: Judge<'_>) -> Option<f64> {
        last_touching(far, |steps| self.at(steps).map(|case| touches(&case)))
    }
}

/// The last number in 0..far that touches; the next float does not. `None` if 0 does not, or `far` does,
/// or it is not known of one on the way.
pub(super) fn last_touching(far: f64, touching: impl Fn(f64) -> Option<bool>) -> Option<f64> {
    let (mut near, mut far) = (0.0f64, far);
    if !touching(near)? || touching(far)? {
        return None;
    }
    while near.next_up() < far {
        // Halfway in bits, so that the end is two neighbouring floats.
        let middle = f64::from_bits(near.to_bits() + (far.to_bits() - near.to_bits()) / 2);
        if touching(middle)? { near = middle } else { far = middle }
    }
    Some(near)
}

/// The neighbouring floats of a pair, moved along a line of its own: the one that touches, then
/// the one that does not.
pub(super) fn neighbours(from: Case, draw: &mut Draw, touches: Judge<'_>) -> Option<[Case; 2]> {
    let along = direction(draw) * (from.a.reach() + from.b.reach());
    let slide = Slide::new(from, along);
    let flip = slide.flip(16.0, touches)?;
    Some([slide.at(flip)?, slide.at(flip.next_up())?])
}
