//! A shape on a half-space: what it shows along the normal, as far as it is below the plane.
//!
//! Heights are products in the shape's own frame, the corners seen along the normal likewise: nothing is clipped, and
//! none of it is listed.

mod few_corners;

use super::clip::{self, different};
use super::facing::Part;
use super::feature::View;
use super::leaning_edge::level_of_edge;
use super::reduce::{self, Spot};
use super::stand_in::StandIn;
use super::{Feature, Manifold, ManifoldPoint, SAME, bound_of, unevenness, write_one_point};
use crate::PosedShape;
use crate::epa::Depth;
use dcd_geom::glam::{DVec2, DVec3};
use dcd_geom::{Shape, SupportMap};
use dcd_simd::ArrayVec;

/// How many corners are held; of a face with more, the general way.
pub(super) const MOST: usize = 8;

/// A corner of what a shape shows.
#[derive(Clone, Copy, Default)]
struct ShownCorner {
    index: u32,
    /// In the shape's own frame.
    point: DVec3,
    /// Seen along the normal.
    at: DVec2,
    /// Below the plane, with what is swept round the core.
    depth: f64,
}

impl Spot for ShownCorner {
    #[inline]
    fn at(&self) -> DVec2 {
        self.at
    }

    #[inline]
    fn depth(&self) -> f64 {
        self.depth
    }
}

/// What has the corners of what a shape shows, by their numbers.
#[derive(Clone, Copy)]
enum Source<'a> {
    Vertices(&'a [DVec3]),
    StandIn(&'a StandIn),
}

impl Source<'_> {
    /// A corner in the shape's own frame.
    #[inline(always)]
    fn corner(self, k: u32) -> DVec3 {
        match self {
            Self::Vertices(vertices) => vertices[k as usize],
            Self::StandIn(stand_in) => stand_in.corner(k),
        }
    }
}

/// Writes the manifold of that depth over an empty one; false, and nothing written, of other shapes than a half-space and one
/// on it, and of faces with many corners.
pub(super) fn write(depth: &Depth, sides: [PosedShape<'_>; 2], found: &mut Manifold) -> bool {
    Resting::seen(depth, sides, None, |resting| resting.write(depth, found)).is_some()
}

/// Adds the corners that a shape has in a half-space, seen along the view's normal, which is that of the depth: what each shows
/// as a whole. `None`, and no corner, as [`write`](fn@write) has it.
pub(super) fn add(
    view: &View,
    depth: &Depth,
    sides: [PosedShape<'_>; 2],
    corners: &mut Vec<clip::Corner>,
) -> Option<([Feature; 2], f64)> {
    Resting::seen(depth, sides, None, |resting| resting.add(view, depth, corners))
}

/// A polytope, cylinder or cone that looks into a half-space.
pub(super) struct Resting<'a> {
    sides: [PosedShape<'a>; 2],
    /// Which of the pair it is.
    number: usize,
    /// Where it looks, of unit length; in its own frame too.
    towards: DVec3,
    local: DVec3,
    /// What it shows, where that was made: what is copied right after it has been written is waited for.
    part: &'a Part<'a>,
    source: Source<'a>,
    /// How large it is.
    size: f64,
}

impl Resting<'_> {
    /// What `see` makes of it. `None` of other shapes, and of faces with many corners. The lowest vertex may be known, up to
    /// rounding.
    #[inline(always)]
    pub(super) fn seen<T>(
        depth: &Depth,
        sides: [PosedShape<'_>; 2],
        lowest: Option<u32>,
        see: impl FnOnce(&Resting<'_>) -> T,
    ) -> Option<T> {
        let number = match sides.map(|side| side.shape) {
            [_, Shape::HalfSpace(_)] => 0,
            [Shape::HalfSpace(_), _] => 1,
            _ => return None,
        };
        let side = sides[number];
        let towards = if number == 0 { depth.normal } else { -depth.normal };
        let local = side.pose.rotation().transpose() * towards;
        let (shown, stand_in);
        let (part, source, size) = match side.shape {
            Shape::Polytope(polytope) => {
                shown = Part::round(polytope, local, lowest);
                (&shown, Source::Vertices(polytope.vertices()), 2.0 * polytope.outer_radius())
            }
            Shape::Curved(curved) => {
                stand_in = StandIn::of(curved, local);
                (&stand_in.part, Source::StandIn(&stand_in), 2.0 * curved.reach())
            }
            _ => return None,
        };
        if matches!(part, Part::Face { corners, .. } if corners.len() > MOST) {
            return None;
        }
        Some(see(&Resting { sides, number, towards, local, part, source, size }))
    }

    /// The features and the bound where it shows a vertex, which touches in the witnesses of the depth.
    #[inline]
    pub(super) fn in_one_point(&self, depth: &Depth) -> Option<([Feature; 2], f64)> {
        let is_vertex = matches!(self.part, Part::Vertex(_));
        is_vertex.then(|| (self.features(self.part.name()), bound_of(depth, self.size, self.sides)))
    }

    /// Writes the manifold of that depth over an empty one.
    #[inline]
    pub(super) fn write(&self, depth: &Depth, found: &mut Manifold) {
        let is_written = match *self.corners() {
            [p, q] => self.write_edge([p, q], depth, found),
            [p, q, r] => self.write_triangle([p, q, r], depth, found),
            _ => false,
        };
        if !is_written {
            self.write_chosen(depth, found);
        }
    }

    /// The same of any number of corners, four of which stand for all.
    #[inline(never)]
    fn write_chosen(&self, depth: &Depth, found: &mut Manifold) {
        let mut corners = ArrayVec::new();
        self.list(depth, &mut corners);
        let count = different(&mut corners, self.size);
        let corners = &corners[..count];
        let tolerance = SAME * self.size;
        let error_bound = bound_of(depth, self.size, self.sides);
        // The first is the deepest, and stands for all if it is as deep as the pair.
        let kept = reduce::to_four(corners, tolerance)
            .filter(|(kept, _)| corners[kept[0]].depth >= depth.depth - tolerance - self.uneven());
        let Some((kept, count)) = kept else {
            write_one_point(depth, self.features(self.part.name()), found);
            found.error_bound = error_bound;
            return;
        };
        let mut shallowest = depth.depth;
        found.points.extend(kept[..count].iter().map(|&k| {
            let ShownCorner { index, point, depth: own, .. } = corners[k];
            shallowest = shallowest.min(own);
            self.point((index, point, own), depth.depth)
        }));
        found.points[0].depth = depth.depth;
        found.normal = depth.normal;
        let off_surface = self.off_surface(depth, shallowest) + self.uneven();
        found.error_bound = (error_bound + off_surface).min(f64::MAX);
    }

    /// How far its lowest corner may be above its lowest vertex, where its faces are bent: metres.
    #[inline]
    fn uneven(&self) -> f64 {
        unevenness(self.sides.map(|side| side.shape))
    }

    /// How large it is, metres.
    #[inline]
    pub(super) fn size(&self) -> f64 {
        self.size
    }

    /// From a point of its core to that of its surface over it, along the normal.
    #[inline]
    pub(super) fn swept(&self) -> DVec3 {
        self.towards * self.sides[self.number].shape.radius()
    }

    /// How far inside a swept surface a point of what it shows may be that is swept along the normal: metres.
    #[inline]
    pub(super) fn inside(&self) -> f64 {
        let radius = self.sides[self.number].shape.radius();
        if radius == 0.0 { 0.0 } else { radius * (1.0 - self.level()).max(0.0) }
    }

    /// Hands on the corners of what it shows that are not above the plane, as [`Resting::below`] does.
    #[inline(always)]
    pub(super) fn each_below(&self, depth: &Depth, found: impl FnMut(u32, DVec3, f64)) {
        match self.part {
            Part::Vertex(only) => self.below(depth, std::slice::from_ref(only), found),
            _ => self.below(depth, self.corners(), found),
        }
    }

    /// The corners of a face or an edge; none of a vertex.
    #[inline(always)]
    fn corners(&self) -> &[u32] {
        match self.part {
            Part::Vertex(_) => &[],
            Part::Edge(ends) => ends,
            Part::Face { corners, .. } => corners,
        }
    }

    /// Adds the corners that it has in the half-space, seen along the view's normal: see [`add`].
    fn add(
        &self,
        view: &View,
        depth: &Depth,
        corners: &mut Vec<clip::Corner>,
    ) -> ([Feature; 2], f64) {
        let side = self.sides[self.number];
        let (radius, inside) = (side.shape.radius(), self.inside());
        let from = side.pose.translation() - self.sides[0].pose.translation();
        self.each_below(depth, |index, point, depth| {
            let (at, height) = view.of(*side.pose.rotation() * point + from);
            let heights = match self.number {
                0 => [height + radius, height + radius - depth],
                _ => [height - radius + depth, height - radius],
            };
            let features = self.features(Feature::Vertex(index));
            corners.push(clip::Corner::new(at, heights, features).inside(inside));
        });
        (self.features(self.part.name()), self.size)
    }

    /// Lists the corners of what it shows that are not above the plane.
    #[inline(always)]
    fn list(&self, depth: &Depth, found: &mut ArrayVec<ShownCorner, MOST>) {
        let (x, y) = self.local.any_orthonormal_pair();
        self.below(depth, self.corners(), |index, point, depth| {
            let at = DVec2::new(x.dot(point), y.dot(point));
            found.push(ShownCorner { index, point, at, depth });
        });
    }

    /// How far inside a swept surface points may be that are swept along the normal, by the depth of the shallowest: metres.
    #[inline(always)]
    fn off_surface(&self, depth: &Depth, shallowest: f64) -> f64 {
        self.inside().min((depth.depth - shallowest).max(0.0))
    }

    /// The cosine of the angle by which a face or an edge leans; 0 for a vertex.
    fn level(&self) -> f64 {
        match (*self.part, self.sides[self.number].shape) {
            (Part::Face { normal, .. }, _) => normal.dot(self.local).abs(),
            (Part::Edge(ends), Shape::Polytope(polytope)) => {
                level_of_edge(polytope, ends, self.local)
            }
            (Part::Edge([j, k]), _) => {
                let edge = self.source.corner(k) - self.source.corner(j);
                edge.reject_from_normalized(self.local).length() / edge.length()
            }
            (Part::Vertex(_), _) => 0.0,
        }
    }

    /// Hands on those of some corners that are not above the plane: the index, the place in the shape's own frame, the depth.
    #[inline(always)]
    fn below(&self, depth: &Depth, corners: &[u32], mut found: impl FnMut(u32, DVec3, f64)) {
        let base = self.origin_below(depth);
        for &index in corners {
            let point = self.source.corner(index);
            let depth = self.local.dot(point) + base;
            if depth >= 0.0 {
                found(index, point, depth);
            }
        }
    }

    /// How far a core's point at the origin of its own frame would be below the plane, with what is swept round it.
    #[inline(always)]
    fn origin_below(&self, depth: &Depth) -> f64 {
        let side = self.sides[self.number];
        let on_plane = if self.number == 0 { depth.point_b } else { depth.point_a };
        self.towards.dot(side.pose.translation() - on_plane) + side.shape.radius()
    }

    /// The points of a corner, by its index, its place in the shape's own frame and its depth: of the shape, and of the plane
    /// over it.
    #[inline]
    fn point(&self, (index, point, depth): (u32, DVec3, f64), most: f64) -> ManifoldPoint {
        let side = self.sides[self.number];
        let swept = side.pose.translation() + self.swept();
        let on_shape = *side.pose.rotation() * point + swept;
        let on_plane = on_shape - self.towards * depth;
        let (point_a, point_b) =
            if self.number == 0 { (on_shape, on_plane) } else { (on_plane, on_shape) };
        let depth = depth.clamp(0.0, most);
        let features = self.features(Feature::Vertex(index));
        ManifoldPoint { point_a, point_b, depth, features, parts: [None; 2] }
    }

    fn features(&self, own: Feature) -> [Feature; 2] {
        if self.number == 0 { [own, Feature::Surface] } else { [Feature::Surface, own] }
    }
}

#[cfg(test)]
mod tests;
