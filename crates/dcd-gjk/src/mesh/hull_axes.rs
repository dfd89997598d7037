//! A triangle against a solid hull by the planes of their difference: whether they touch, and how deep
//! (docs/numerics/proofs.md, "a triangle and a hull").

mod features;
mod lanes;
mod round;

use super::bounds::{U, U64};
use super::cuboid::{AXIS, ByAxes, PLACED};
use super::reach::Couple;
use crate::closed::nearest_of_triangle;
use crate::epa::Depth;
use dcd_geom::Polytope;
use dcd_geom::glam::DVec3;
use dcd_simd::{Path, Unfused, dispatch_on};
use features::{HullFeatures, shares};
use lanes::{Feature, HullAxes, PLANE};

/// Lengths, metres, whose products f32 holds.
const SIZES: std::ops::Range<f64> = 1e-6..1e8;

/// Twice a triangle's area by the square of its longest edge below which it is left to the search.
const NEEDLE: f64 = 1e-4;

/// What the direction of a product of two edges loses in f64. Unit: u of their lengths by the product's.
const LEAN: f64 = 16.0;

/// How far the triangle's witness may be from what it is a point of, relative to the size: more is the plane of another
/// feature, as near but for rounding. Larger: wider bounds.
const BESIDE: f64 = 1e-9;

/// A triangle in the frame of a hull, from its centre.
struct Placed<'a> {
    hull: HullFeatures<'a>,
    corners: [DVec3; 3],
    /// Of unit length.
    normal: DVec3,
    /// At least how much that or a face's normal is off, radians.
    tilt: f64,
    /// The longest edge.
    longest: f64,
    /// At least the length of every vector from the one to the other.
    size: f64,
    /// How far the corners may be off, metres.
    off: f64,
}

/// The plane that is nearest to the origin.
struct Least {
    /// From the triangle to the hull, of unit length.
    normal: DVec3,
    feature: Of,
    /// How far the two reach past each other along it.
    reach: f64,
    /// No plane is nearer.
    at_least: f64,
}

/// What it is made of.
#[derive(Clone, Copy)]
enum Of {
    Plane(Feature),
    /// A vertex of the hull, and the triangle.
    Vertex(usize),
}

impl Couple<'_> {
    /// [`Couple::by_axes`] of a hull.
    pub(super) fn by_planes(
        &self,
        (corners, triangle): (&[DVec3; 3], usize),
        hull: &Polytope,
    ) -> Option<ByAxes> {
        let other = 1 - triangle;
        let sense = if triangle == 0 { 1.0 } else { -1.0 };
        let placed = self.in_hull((corners, triangle), hull)?;
        let least = placed.least()?;
        let radius = self.parts()[0].radius() + self.parts()[1].radius();
        let turn = self.poses()[other].rotation();
        let rounding = AXIS * U64 * (placed.size + radius);
        // Also along the rounded normal this is true.
        if least.reach + radius + rounding + placed.off < 0.0 {
            return Some(ByAxes::Apart(*turn * least.normal * -sense));
        }
        let at_least = least.at_least - rounding - placed.tilt * placed.size;
        // Of cores that do not meet, the planes do not bound what the radii overlap. Written so that NaN is none.
        if !(at_least > placed.off) {
            return None;
        }
        let Some((at_hull, beside)) = placed.witness(&least) else {
            return Some(ByAxes::Touching(None));
        };
        let depth = least.reach + radius;
        let error_bound = (least.reach - at_least).max(0.0) + placed.off + beside + rounding;
        // Of unit length also where the pose is hardly a rotation: radii may be many times the size.
        let normal = (*turn * least.normal).normalize();
        let at_hull = *turn * (at_hull + hull.inner().centre) - normal * hull.swept_radius();
        let origin = self.poses()[other].translation();
        let [of_hull, of_triangle] = [origin + at_hull, origin + (at_hull + normal * depth)];
        let [point_a, point_b] =
            if triangle == 0 { [of_triangle, of_hull] } else { [of_hull, of_triangle] };
        let found = Depth { depth, normal: normal * sense, point_a, point_b, error_bound };
        let is_finite = depth.is_finite() && error_bound.is_finite();
        Some(ByAxes::Touching(is_finite.then_some(found)))
    }

    /// `None` of needles, and of lengths that f32 does not hold.
    fn in_hull<'h>(
        &self,
        (corners, triangle): (&[DVec3; 3], usize),
        hull: &'h Polytope,
    ) -> Option<Placed<'h>> {
        let features = HullFeatures::of(hull)?;
        let [of_triangle, of_hull] = [self.poses()[triangle], self.poses()[1 - triangle]];
        let back = of_hull.rotation().transpose();
        let sense = if triangle == 0 { 1.0 } else { -1.0 };
        let (turn, delta) = (back * *of_triangle.rotation(), back * (self.delta() * sense));
        let from = delta + hull.inner().centre;
        let [p, q, r] = corners.map(|corner| turn * corner - from);
        let edges = [q - p, r - p, r - q].map(DVec3::length_squared);
        let longest = edges[0].max(edges[1]).max(edges[2]);
        let normal = (q - p).cross(r - p);
        let area = normal.length();
        let squares = [p, q, r].map(DVec3::length_squared);
        let far = squares[0].max(squares[1]).max(squares[2]).sqrt();
        let deviation = of_triangle.deviation() + of_hull.deviation();
        let off = (PLACED * U64 + 4.0 * deviation) * self.size();
        let size = far + hull.outer_radius() + off;
        // Written so that NaN is no triangle.
        let is_known = area > NEEDLE * longest && area > SIZES.start * SIZES.start;
        (is_known && SIZES.contains(&size)).then(|| Placed {
            hull: features,
            corners: [p, q, r],
            normal: normal / area,
            tilt: features.rows.normal_error().max(LEAN * U64 * longest / area),
            longest: longest.sqrt() * (1.0 + 8.0 * U64),
            size,
            off,
        })
    }
}

impl Placed<'_> {
    /// `None` where the planes are no closed surface round the origin, or may be none.
    fn least(&self) -> Option<Least> {
        let [p, q, r] = self.corners;
        let search = HullAxes {
            rows: self.hull.rows,
            corner: p.as_vec3(),
            edges: [(q - p).as_vec3(), (r - p).as_vec3()],
            longest: self.longest,
            size: self.size,
        };
        let planes = dispatch_on(Path::best(), Unfused(search));
        let lost = PLANE * U * self.size;
        let mut others = f64::from(planes.others) - lost;
        let mut nearest = f64::from(planes.nearest);
        let mut of = (Of::Plane(planes.feature), DVec3::ZERO);
        let [behind, before] = planes.vertices?;
        for (mut set, outward) in [(behind, -self.normal), (before, self.normal)] {
            while set != 0 {
                let vertex = set.trailing_zeros() as usize;
                set &= set - 1;
                let distance = outward.dot(self.hull.vertex(vertex) - p);
                if distance < nearest {
                    others = others.min(match of.0 {
                        Of::Plane(_) => nearest - lost,
                        Of::Vertex(_) => nearest,
                    });
                    (nearest, of) = (distance, (Of::Vertex(vertex), outward));
                } else {
                    others = others.min(distance);
                }
            }
        }
        let (outward, distance) = match of {
            (Of::Vertex(_), outward) => (outward, nearest),
            (Of::Plane(feature), _) => self.plane(feature)?,
        };
        Some(Least {
            normal: -outward,
            feature: of.0,
            reach: self.reach(outward),
            at_least: distance.min(others),
        })
    }

    /// The outward unit normal of a plane and its distance from the origin.
    fn plane(&self, feature: Feature) -> Option<(DVec3, f64)> {
        match feature {
            Feature::Face(face, corner) => {
                let (outward, corners) = self.hull.rows.face_polygon(face)?;
                let at = self.hull.vertex(*corners.first()? as usize);
                Some((outward, outward.dot(at - *self.corners.get(corner)?)))
            }
            Feature::Edge(edge, _) => {
                let [from, along, on, across] = self.edges(feature, edge)?;
                let product = along.cross(across);
                let length = product.length();
                let (outward, sine) = (product / length, length / along.length());
                let lost = LEAN * U64 * self.size * self.longest / sine;
                Some((outward, outward.dot(from - on) - lost))
            }
        }
    }

    /// An edge of the hull and one of the triangle: where each begins, and what leads to its end.
    fn edges(&self, feature: Feature, edge: usize) -> Option<[DVec3; 4]> {
        let Feature::Edge(_, [k, l]) = feature else { return None };
        let [from, along] = self.hull.edge(edge)?;
        let (on, end) = (*self.corners.get(k)?, *self.corners.get(l)?);
        Some([from, along, on, end - on])
    }

    /// The corner that is lowest along a direction.
    fn lowest(&self, direction: DVec3) -> usize {
        let heights = self.corners.map(|corner| direction.dot(corner));
        let second = usize::from(heights[1] < heights[0]);
        if heights[2] < heights[second] { 2 } else { second }
    }

    /// How far the two reach past each other where the hull leaves along a direction.
    fn reach(&self, outward: DVec3) -> f64 {
        let lowest = self.corners[self.lowest(outward)];
        self.hull.reach(outward) - outward.dot(lowest)
    }

    /// The point of the hull that is deepest, from the centre, and how far the point over it is from the triangle; `None`
    /// where another plane, as near but for rounding, has them.
    fn witness(&self, least: &Least) -> Option<(DVec3, f64)> {
        let up = least.normal * least.reach;
        let outward = -least.normal;
        let (at, beside) = match least.feature {
            Of::Vertex(vertex) => {
                let at = self.hull.vertex(vertex);
                (at, nearest_of_triangle(self.corners, at + up).distance(at + up))
            }
            Of::Plane(Feature::Face(face, _)) => {
                let (_, corners) = self.hull.rows.face_polygon(face)?;
                let at = self.corners[self.lowest(outward)] - up;
                // At a sharp corner its sides say less than the distance.
                (at, if self.hull.is_in_face(corners, outward, at) { 0.0 } else { f64::INFINITY })
            }
            Of::Plane(feature @ Feature::Edge(edge, _)) => {
                let edges @ [from, along, on, across] = self.edges(feature, edge)?;
                let [share, of_triangle] = shares(edges);
                let at = from + along * share.clamp(0.0, 1.0);
                (at, (on + across * of_triangle.clamp(0.0, 1.0)).distance(at + up))
            }
        };
        // Written so that NaN is beside.
        (beside <= BESIDE * self.size).then_some((at, beside))
    }
}

#[cfg(test)]
mod tests;
