//! A compound of few parts on a half-space at the accuracies of f32 and f64: what each part shows along the normal, as far as it
//! is below the plane, in the compound's frame.
//!
//! All parts meet the plane along one normal: there is one manifold, and no part is compared with another.

use super::bounds::{TURNED, bound_of};
use super::clip::different;
use super::on_plane::{MOST as CORNERS, Resting};
use super::reduce::{self, Spot};
use super::{Feature, Manifold, ManifoldPoint, SAME, unevenness};
use crate::closed::level::PlaneInFrame;
use crate::epa::Depth;
use crate::mesh::PartIndex;
use crate::query::{Accuracy, few_parts};
use crate::{PosedShape, Verdict};
use dcd_geom::glam::{DVec2, DVec3};
use dcd_geom::{Pose, Shape, SupportMap};
use dcd_simd::ArrayVec;

/// The most parts. More: corners that are written to be sorted out.
const MOST: usize = 16;

/// A corner of a part that is not above the plane.
#[derive(Clone, Copy, Default)]
struct PartCorner {
    part: u32,
    index: u32,
    /// Of the part's surface, in the compound's frame.
    point: DVec3,
    /// Seen along the normal.
    at: DVec2,
    depth: f64,
    /// How far inside a swept surface the point may be.
    inside: f64,
    /// What the part's depth may be off by.
    error_bound: f64,
}

impl Spot for PartCorner {
    #[inline]
    fn at(&self) -> DVec2 {
        self.at
    }

    #[inline]
    fn depth(&self) -> f64 {
        self.depth
    }
}

/// The parts of a compound that touch a half-space.
struct Below {
    corners: ArrayVec<PartCorner, { MOST * CORNERS }>,
    /// Square to the normal, in the compound's frame.
    axes: (DVec3, DVec3),
    /// The deepest part, how deep it is, and what that may be off by: another may be deeper by its own bound.
    part: u32,
    depth: f64,
    upper: f64,
    error_bound: f64,
    /// How large the largest part is.
    size: f64,
    /// How far a part's lowest corner may be above its lowest vertex, metres.
    uneven: f64,
}

/// Writes the manifold of a compound and a half-space, in that order, over an empty one; `None`, and nothing written, of other
/// shapes, and where it is not known at once which parts touch.
pub(super) fn write(at: Accuracy, [a, b]: [PosedShape<'_>; 2], found: &mut Manifold) -> Option<()> {
    let (Shape::Compound(compound), Shape::HalfSpace(_)) = (a.shape, b.shape) else { return None };
    let parts = compound.parts();
    if parts.len() > MOST {
        return None;
    }
    let plane = PlaneInFrame::of(at, b, a.pose)?;
    let [inward, normal] = plane.inward();
    let mut below = Below::new(inward);
    for (number, part) in (0..).zip(parts) {
        // Of others the placed part is a foreign shape, which has no corners.
        part.shape.as_polytope()?;
        let posed = PosedShape { shape: &part.shape, pose: &part.pose };
        let (gap, lowest) = plane.gap_of(posed, few_parts::moved_in_frame(part)?)?;
        match gap.verdict() {
            Verdict::Touching(depth) => below.add((number, posed), b, &depth, lowest)?,
            Verdict::Apart => {}
            Verdict::Undecided(_) => return None,
        }
    }
    below.write(normal, [a, b], found)
}

impl Below {
    // Made where it is kept: it is large.
    #[inline(always)]
    fn new(inward: DVec3) -> Self {
        Self {
            corners: ArrayVec::new(),
            axes: inward.any_orthonormal_pair(),
            part: 0,
            depth: 0.0,
            upper: 0.0,
            error_bound: 0.0,
            size: 0.0,
            uneven: 0.0,
        }
    }

    /// Adds a part that touches, of that depth in the compound's frame; its lowest vertex may be known. `None` of a face with
    /// many corners.
    #[inline(always)]
    fn add(
        &mut self,
        (part, posed): (u32, PosedShape<'_>),
        half_space: PosedShape<'_>,
        depth: &Depth,
        lowest: Option<u32>,
    ) -> Option<()> {
        let size = Resting::seen(depth, [posed, half_space], lowest, |resting| {
            let (x, y) = self.axes;
            let pose = posed.pose;
            let inside = resting.inside() + TURNED * pose.deviation() * posed.shape.radius();
            let (swept, error_bound) = (resting.swept(), depth.error_bound);
            resting.each_below(depth, |index, corner, depth| {
                let point = pose.apply(corner) + swept;
                let at = DVec2::new(x.dot(point), y.dot(point));
                self.corners.push(PartCorner {
                    part,
                    index,
                    point,
                    at,
                    depth,
                    inside,
                    error_bound,
                });
            });
            resting.size()
        })?;
        self.size = self.size.max(size);
        self.uneven = self.uneven.max(unevenness([posed.shape, half_space.shape]));
        self.upper = self.upper.max(depth.depth + depth.error_bound);
        if depth.depth > self.depth {
            (self.part, self.depth, self.error_bound) = (part, depth.depth, depth.error_bound);
        }
        Some(())
    }

    /// `None`, and nothing written, where no corner is as deep as the deepest part.
    fn write(
        &mut self,
        normal: DVec3,
        sides: [PosedShape<'_>; 2],
        found: &mut Manifold,
    ) -> Option<()> {
        let count = different(&mut self.corners, self.size);
        let corners = &self.corners[..count];
        let tolerance = SAME * self.size;
        let (kept, count) = reduce::to_four(corners, tolerance)?;
        let kept = &kept[..count];
        // The first is the deepest, and stands for all if it is as deep as its part. False for NaN.
        if !(corners[kept[0]].depth >= self.depth - tolerance - self.uneven) {
            return None;
        }
        let [a, _] = sides;
        found.points.extend(kept.iter().map(|&k| self.point(&corners[k], (normal, a.pose))));
        found.points[0].depth = self.depth;
        found.normal = normal;
        found.parts = [Some(PartIndex::Part(self.part)), None];
        let whole = self.whole();
        let off_surface = |&k: &usize| {
            let PartCorner { inside, depth, error_bound, .. } = corners[k];
            let own = (error_bound - whole.error_bound).max(0.0);
            inside.min((self.depth - depth).max(0.0)) + own
        };
        let off_surface = kept.iter().map(off_surface).fold(0.0, f64::max);
        let error_bound = bound_of(&whole, self.size, sides) + off_surface + self.uneven;
        found.error_bound = error_bound.min(f64::MAX);
        Some(())
    }

    /// The depth of the deepest part, whose bound counts that another may be deeper.
    fn whole(&self) -> Depth {
        let above = (self.upper - self.depth).next_up();
        Depth { depth: self.depth, error_bound: self.error_bound.max(above), ..Depth::default() }
    }

    /// A corner's points in the world: of the part, and of the plane over it.
    #[inline(always)]
    fn point(&self, corner: &PartCorner, (normal, pose): (DVec3, &Pose)) -> ManifoldPoint {
        let point_a = pose.apply(corner.point);
        ManifoldPoint {
            point_a,
            point_b: point_a - normal * corner.depth,
            depth: corner.depth.clamp(0.0, self.depth),
            features: [Feature::Vertex(corner.index), Feature::Surface],
            parts: [Some(PartIndex::Part(corner.part)), None],
        }
    }
}

#[cfg(test)]
mod tests;
