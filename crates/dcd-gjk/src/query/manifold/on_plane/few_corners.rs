//! An edge or a triangle on a half-space: those of its corners that are not above the plane are the points, and none is
//! chosen.

use super::super::clip::APART;
use super::super::{Manifold, SAME, bound_of};
use super::Resting;
use crate::epa::Depth;
use dcd_geom::glam::DVec3;

/// How far apart corners must be, and from being in line, relative to the size: twice what makes one of two, for what leans by
/// fifteen degrees is shorter by a thirtieth as it is seen along the normal. Larger: more is left to the general way, which has
/// the same points.
const NEAR: f64 = 2.0 * SAME.max(APART);

impl Resting<'_> {
    /// Writes the manifold of an edge over an empty one; false, and nothing written, where its ends are hardly apart, or none is
    /// as deep as the pair.
    #[inline(always)]
    pub(super) fn write_edge(&self, ends: [u32; 2], depth: &Depth, found: &mut Manifold) -> bool {
        let [p, q] = ends.map(|end| self.source.corner(end));
        let near = NEAR * self.size;
        (q - p).length_squared() > near * near && self.write_all(ends, [p, q], depth, found)
    }

    /// The same of a triangle, unless it is a needle.
    #[inline(always)]
    pub(super) fn write_triangle(
        &self,
        corners: [u32; 3],
        depth: &Depth,
        found: &mut Manifold,
    ) -> bool {
        let [p, q, r] = corners.map(|corner| self.source.corner(corner));
        let edges = [q - p, r - p, r - q];
        let [e, f, g] = edges.map(DVec3::length_squared);
        let near = NEAR * self.size;
        // Each corner is so far from the line through the others, and so from both.
        let is_wide = edges[0].cross(edges[1]).length_squared() > near * near * e.max(f).max(g);
        is_wide && self.write_all(corners, [p, q, r], depth, found)
    }

    /// The same of corners that are clearly apart and not in line.
    #[inline(always)]
    fn write_all<const N: usize>(
        &self,
        indices: [u32; N],
        points: [DVec3; N],
        depth: &Depth,
        found: &mut Manifold,
    ) -> bool {
        let base = self.origin_below(depth);
        let depths = points.map(|point| self.local.dot(point) + base);
        let mut first = 0;
        for k in 1..N {
            first = if depths[k] > depths[first] { k } else { first };
        }
        let deepest = depths[first];
        // Written so that NaN is not as deep.
        if !(deepest >= 0.0 && deepest >= depth.depth - SAME * self.size - self.uneven()) {
            return false;
        }
        let most = depth.depth;
        found.points.push(self.point((indices[first], points[first], deepest), most));
        found.points[0].depth = most;
        let mut shallowest = most.min(deepest);
        for k in (0..N).filter(|&k| k != first && depths[k] >= 0.0) {
            found.points.push(self.point((indices[k], points[k], depths[k]), most));
            shallowest = shallowest.min(depths[k]);
        }
        let error_bound = bound_of(depth, self.size, self.sides);
        found.normal = depth.normal;
        let off_surface = self.off_surface(depth, shallowest) + self.uneven();
        found.error_bound = (error_bound + off_surface).min(f64::MAX);
        true
    }
}
