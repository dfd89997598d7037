//! A shape on a half-space: what it shows along the normal, as far as it is below the plane.
//!
//! Heights are products in the shape's own frame, the corners seen along the normal likewise: nothing is clipped, and
//! none of it is listed.

use super::clip::different;
use super::facing::Part;
use super::reduce::{self, Spot};
use super::stand_in::StandIn;
use super::{Feature, Manifold, ManifoldPoint, SAME, bound_of, write_one_point};
use crate::PosedShape;
use crate::epa::Depth;
use dcd_geom::glam::{DVec2, DVec3};
use dcd_geom::{Shape, SupportMap};

/// How many corners are held; of a face with more, the general way.
const MOST: usize = 8;

/// A corner of what a shape shows.
#[derive(Clone, Copy, Default)]
struct Corner {
    index: u32,
    /// In the shape's own frame.
    point: DVec3,
    /// Seen along the normal.
    at: DVec2,
    /// Below the plane, with what is swept round the core.
    depth: f64,
}

impl Spot for Corner {
    fn at(&self) -> DVec2 {
        self.at
    }

    fn depth(&self) -> f64 {
        self.depth
    }
}

/// Writes the manifold of a half-space and a polytope, cylinder or cone over an empty one; false of others.
pub(super) fn write(depth: &Depth, [a, b]: [PosedShape<'_>; 2], found: &mut Manifold) -> bool {
    let (side, number) = match (a.shape, b.shape) {
        (_, Shape::HalfSpace(_)) => (a, 0),
        (Shape::HalfSpace(_), _) => (b, 1),
        _ => return false,
    };
    // From the shape into the half-space.
    let towards = if number == 0 { depth.normal } else { -depth.normal };
    let local = side.pose.rotation().transpose() * towards;
    let resting = Resting { side, towards, local, number };
    match side.shape {
        Shape::Polytope(polytope) => {
            let vertices = polytope.vertices();
            let part = Part::facing(polytope, local);
            let has_line = vertices.len() == 2;
            let size = 2.0 * polytope.outer_radius();
            let corner = |k: u32| vertices[k as usize];
            resting.write([a, b], depth, (part, has_line, size), corner, found)
        }
        Shape::Curved(curved) => {
            let stand_in = StandIn::of(curved, local);
            let size = 2.0 * curved.reach();
            let corner = |k: u32| stand_in.corner(k);
            resting.write([a, b], depth, (stand_in.part, true, size), corner, found)
        }
        _ => false,
    }
}

/// A shape that looks into a half-space.
struct Resting<'a> {
    side: PosedShape<'a>,
    /// Where it looks, of unit length; in its own frame too.
    towards: DVec3,
    local: DVec3,
    /// Which of the pair it is.
    number: usize,
}

impl Resting<'_> {
    /// By the part that is shown, of a shape so large; `has_line` where an edge is all that the shape shows there.
    fn write(
        &self,
        sides: [PosedShape<'_>; 2],
        depth: &Depth,
        (part, has_line, size): (Part<'_>, bool, f64),
        corner: impl Fn(u32) -> DVec3,
        found: &mut Manifold,
    ) -> bool {
        let radius = self.side.shape.radius();
        let ends;
        let (listed, level): (&[u32], f64) = match part {
            Part::Vertex(_) => (&[], 0.0),
            Part::Edge(of_edge) => {
                ends = of_edge;
                let level = if has_line && radius > 0.0 {
                    let edge = corner(ends[1]) - corner(ends[0]);
                    edge.reject_from_normalized(self.local).length() / edge.length()
                } else {
                    0.0
                };
                (&ends, level)
            }
            Part::Face { normal, corners, .. } => (corners, normal.dot(self.local).abs()),
        };
        if listed.len() > MOST {
            return false;
        }
        let mut corners = [Corner::default(); MOST];
        let count = self.below(depth, listed, corner, &mut corners);
        let count = different(&mut corners[..count], size);
        let corners = &corners[..count];
        let tolerance = SAME * size;
        let deepest = corners.iter().map(|corner| corner.depth).fold(f64::NEG_INFINITY, f64::max);
        let stands_for_all = deepest >= depth.depth - tolerance;
        let error_bound = bound_of(depth, size, sides);
        let kept = reduce::to_four(corners, tolerance).filter(|_| stands_for_all);
        let Some((kept, count)) = kept else {
            write_one_point(depth, self.features(part.name()), found);
            found.error_bound = error_bound;
            return true;
        };
        let mut off_surface = 0.0f64;
        let inside = radius * (1.0 - level).max(0.0);
        for (to, &k) in found.points.iter_mut().zip(&kept[..count]) {
            let corner = &corners[k];
            off_surface = off_surface.max(inside.min((depth.depth - corner.depth).max(0.0)));
            self.place(corner, radius, depth.depth, to);
        }
        found.points[0].depth = depth.depth;
        found.normal = depth.normal;
        found.count = count as u8;
        found.error_bound = (error_bound + off_surface).min(f64::MAX);
        true
    }

    /// The listed corners that are not above the plane: how many.
    #[inline]
    fn below(
        &self,
        depth: &Depth,
        listed: &[u32],
        corner: impl Fn(u32) -> DVec3,
        corners: &mut [Corner; MOST],
    ) -> usize {
        let on_plane = if self.number == 0 { depth.point_b } else { depth.point_a };
        let from_plane = self.side.pose.translation() - on_plane;
        let base = self.towards.dot(from_plane) + self.side.shape.radius();
        let (x, y) = self.local.any_orthonormal_pair();
        let mut count = 0;
        for &index in listed {
            let point = corner(index);
            let below = self.local.dot(point) + base;
            if below >= 0.0 {
                let at = DVec2::new(x.dot(point), y.dot(point));
                corners[count] = Corner { index, point, at, depth: below };
                count += 1;
            }
        }
        count
    }

    /// Writes a corner's points: of the shape, and of the plane over it.
    fn place(&self, corner: &Corner, radius: f64, most: f64, to: &mut ManifoldPoint) {
        let on_shape = self.side.pose.apply(corner.point) + self.towards * radius;
        let on_plane = on_shape - self.towards * corner.depth;
        (to.point_a, to.point_b) =
            if self.number == 0 { (on_shape, on_plane) } else { (on_plane, on_shape) };
        to.depth = corner.depth.clamp(0.0, most);
        to.features = self.features(Feature::Vertex(corner.index));
    }

    fn features(&self, own: Feature) -> [Feature; 2] {
        let mut features = [Feature::Surface; 2];
        features[self.number] = own;
        features
    }
}
