//! One of two shapes as its parts: spheres round all of them, and those that are looked at as they were given, where they are.

use super::slab::Slab;
use super::{MOST, UNIT};
use crate::PosedShape;
use dcd_geom::glam::DVec3;
use dcd_geom::{Part, Pose, Shape, Sphere, SupportMap};
use dcd_simd::{ArrayVec, prefetch};
use std::slice;

/// What moving a part to its place twice, or by a product of poses, loses. Unit: u of the part's reach and its place.
/// Derived: 32.
const PLACED: f64 = 34.0;

/// The same in the compound's own frame, of the part's reach and its place there. Derived: 8.
const IN_FRAME: f64 = 8.5;

/// The most that may be, relative to the part's reach: far from the origin rounding is more than the accuracy allows.
const NEAR: f64 = 1e-10;

/// What the height of a sphere's centre over a slab may be off. Relative to the lengths. Derived: 2.1 times
/// [`super::slab::TURNED`], and 24u. Smaller: parts that are missed.
const ABOVE: f64 = 4e-12;

/// What a pose that is hardly a rotation makes of a sphere's radius, relative to it. Smaller: parts that are missed.
const STRETCH: f64 = 1e-5;

/// What a centre loses when it is moved. Unit: u of its place before and after. Derived: 9.
const MOVED: f64 = 16.0;

/// A part where it is.
#[derive(Clone, Copy)]
pub(super) struct Given<'a> {
    pub(super) number: u32,
    /// As it was given.
    pub(super) shape: &'a Shape,
    pub(super) pose: Pose,
    /// How far its points may be from those of the part that answers are given for, metres.
    pub(super) moved: f64,
}

impl<'a> Given<'a> {
    /// The part of that number of a shape at a pose; of a convex shape itself. `None` where it is farther from where its compound has
    /// it than is allowed.
    pub(super) fn of(shape: &'a Shape, pose: &Pose, number: u32) -> Option<Self> {
        let Shape::Compound(compound) = shape else {
            return Some(Self { number, shape, pose: *pose, moved: 0.0 });
        };
        let part = compound.parts().get(number as usize)?;
        let (pose, moved) = place(pose, part)?;
        Some(Self { number, shape: &part.shape, pose, moved })
    }

    /// The same in the compound's own frame.
    fn in_frame(compound: &'a [Part], number: u32) -> Option<Self> {
        let part = compound.get(number as usize)?;
        let moved = moved_in_frame(part)?;
        Some(Self { number, shape: &part.shape, pose: part.pose, moved })
    }

    pub(super) fn posed(&self) -> PosedShape<'_> {
        PosedShape { shape: self.shape, pose: &self.pose }
    }
}

/// Where a part of a compound is, and how far that may be from where the compound has it.
pub(in crate::query) fn place(whole: &Pose, part: &Part) -> Option<(Pose, f64)> {
    let pose = whole.compose(&part.pose).ok()?;
    let reach = part.reach();
    let size = reach + part.pose.translation().length() + pose.translation().length();
    // Of a curved part that was moved the support map is what answers are given for.
    let moved = PLACED * UNIT * size + 2.0 * part.placed().support_error();
    (moved <= NEAR * reach).then_some((pose, moved))
}

/// How far a part may be from where its compound has it, in the compound's frame. `None` where that is too far.
pub(in crate::query) fn moved_in_frame(part: &Part) -> Option<f64> {
    let reach = part.reach();
    let size = reach + part.pose.translation().length();
    // Of a curved part that was moved the support map is what answers are given for.
    let moved = IN_FRAME * UNIT * size + 2.0 * part.placed().support_error();
    (moved <= NEAR * reach).then_some(moved)
}

/// Whose frame a shape's parts are seen in.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Frame {
    Own,
    Other,
}

/// The parts of one shape, or a convex shape as its own only one.
#[derive(Default)]
pub(super) struct Side<'a> {
    /// The shape where it is, and whose frame its parts are seen in.
    whole: Option<(PosedShape<'a>, Frame)>,
    /// Of a convex shape.
    slab: Option<Slab>,
    /// Round each part, by number; of infinite radius round a half-space.
    spheres: ArrayVec<Sphere, MOST>,
    /// Those that were looked at.
    given: ArrayVec<Given<'a>, MOST>,
}

impl<'a> Side<'a> {
    /// Takes a shape in place of none: `None` of shapes that are neither convex nor compounds, of those that are known by their support
    /// maps alone, and of too many parts.
    pub(super) fn fill(&mut self, whole: PosedShape<'a>, frame: Frame) -> Option<()> {
        let Shape::Compound(compound) = whole.shape else {
            self.spheres.push(moved(sphere_round(whole.shape)?, whole.pose));
            (self.whole, self.slab) = (Some((whole, frame)), Slab::of(whole));
            return Some(());
        };
        let spheres = compound.part_bounding_spheres();
        if spheres.len() > MOST {
            return None;
        }
        match frame {
            Frame::Own => self.spheres.extend(spheres.iter().copied()),
            Frame::Other => self.spheres.extend(spheres.iter().map(|&s| moved(s, whole.pose))),
        }
        self.whole = Some((whole, frame));
        Some(())
    }

    /// How many parts there are.
    pub(super) fn len(&self) -> usize {
        self.spheres.len()
    }

    /// A part as it was given, in its own frame.
    pub(super) fn shape(&self, number: u32) -> Option<&'a Shape> {
        match self.whole?.0.shape {
            Shape::Compound(compound) => Some(&compound.parts().get(number as usize)?.shape),
            convex => Some(convex),
        }
    }

    /// Fetches a part: a hint, without effect on any result.
    pub(super) fn prefetch(&self, number: u32) {
        if let Some((PosedShape { shape: Shape::Compound(compound), .. }, _)) = self.whole {
            prefetch(compound.parts().get(number as usize).map_or(&[], slice::from_ref));
        }
    }

    /// Finds where a part is; `None` where it is too far from where its compound has it.
    pub(super) fn look_at(&mut self, number: u32) -> Option<()> {
        if self.get(number).is_none() {
            let (PosedShape { shape, pose }, frame) = self.whole?;
            self.given.push(match (shape, frame) {
                (Shape::Compound(compound), Frame::Own) => {
                    Given::in_frame(compound.parts(), number)?
                }
                _ => Given::of(shape, pose, number)?,
            });
        }
        Some(())
    }

    /// A part that was looked at.
    pub(super) fn get(&self, number: u32) -> Option<&Given<'a>> {
        self.given.iter().find(|part| part.number == number)
    }

    /// At least how far apart parts of those numbers are, as the spheres round them show, or a sphere and a slab; below 0 where
    /// they may meet.
    #[inline]
    pub(super) fn gap(&self, other: &Self, [j, k]: [u32; 2]) -> f64 {
        let (a, b) = (self.spheres[j as usize], other.spheres[k as usize]);
        let of_slab = match (self.slab, other.slab) {
            (Some(slab), None) => gap_beside(b, slab),
            (None, Some(slab)) => gap_beside(a, slab),
            _ => f64::NEG_INFINITY,
        };
        let far = a.centre.abs().element_sum() + b.centre.abs().element_sum();
        let radii = (a.radius + b.radius) * (1.0 + STRETCH);
        let of_spheres = a.centre.distance(b.centre) - radii - 64.0 * UNIT * far;
        // A sphere round a half-space says nothing.
        if of_spheres > of_slab { of_spheres } else { of_slab }
    }
}

/// The same of a sphere and a slab.
fn gap_beside(sphere: Sphere, Slab { outward, low, high, far }: Slab) -> f64 {
    let height = outward.dot(sphere.centre);
    let lost = ABOVE * (far + sphere.centre.abs().element_sum());
    (height - high).max(low - height) - sphere.radius * (1.0 + STRETCH) - lost
}

/// Round a convex shape in its own frame; `None` of those that are known by their support maps alone.
fn sphere_round(shape: &Shape) -> Option<Sphere> {
    let (centre, radius) = match shape {
        Shape::Polytope(polytope) => {
            (polytope.inner().centre, polytope.outer_radius() + polytope.swept_radius())
        }
        Shape::Curved(curved) => (DVec3::ZERO, curved.reach() + curved.swept_radius()),
        Shape::HalfSpace(_) => (DVec3::ZERO, f64::INFINITY),
        _ => return None,
    };
    Some(Sphere { centre, radius })
}

/// A sphere at a pose, with what its centre loses.
#[inline]
fn moved(Sphere { centre, radius }: Sphere, pose: &Pose) -> Sphere {
    let far = centre.abs().element_sum() + pose.translation().abs().element_sum();
    Sphere { centre: pose.apply(centre), radius: radius + MOVED * UNIT * far }
}
