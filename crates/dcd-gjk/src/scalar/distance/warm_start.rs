//! A warm start for GJK in f64: where GJK in f32 ends, of which nothing is believed.
//!
//! From there the search in f64 has, mostly, one support left to take. What f32 gets wrong costs it more of them. Where
//! cores hardly touch it knows less than from afar, for it tries fewer directions: `approach` searches again there.

use crate::body::Body;
use crate::gjk::Simplex;
use crate::rims::Rims;
use crate::supports::InBlocks;
use crate::{Difference, Vertex};
use dcd_geom::glam::{DVec3, Mat3, Vec3};
use dcd_geom::{Curved, Polytope, Support};
use dcd_simd::{Block, Kernel, Lanes, WIDTH, dispatch};
use std::ops::Range;

/// How many supports the search in f32 takes at most; hulls need 3 to 6. No unit. Fewer: more supports in f64.
const MOST: usize = 24;

/// The square of the nearest point's distance has to fall below this part of what it was, else rounding alone moves it. No
/// unit. Larger: idle steps. Smaller: more supports in f64.
const NEARER: f32 = 1.0 - 1e-6;

/// How near the bounds have to come where one core is curved: then its nearest feature is known, mostly. Unit: the difference's
/// size, about 1. Larger: features that are not the nearest. Smaller: supports that a step of Newton's would have spared.
const CLOSE: f32 = 3e-3;

/// The scales at which coordinates and their products stay well within f32. Per metre.
const SCALES: Range<f64> = 1.0 / (1u128 << 80) as f64..(1u128 << 80) as f64;

/// The vertices of a difference between which its nearest point probably is, at most three; none of shapes that are neither
/// polytopes nor cylinders or cones, of two polytopes with few vertices, whose supports are as quick in f64, and where f32 is of no
/// use. The same on every path.
pub(super) fn warm_start<A: InBlocks, B: InBlocks>(
    difference: &Difference<'_, f64, A, B>,
    simplex: &mut Simplex<f64>,
) {
    let (a, b) = difference.maps();
    let (Some(a), Some(b)) = (Core::of(a), Core::of(b)) else { return };
    let have_few = a.has_few_vertices() && b.has_few_vertices();
    if have_few || !SCALES.contains(&difference.scale()) {
        return;
    }
    let corners = dispatch(Search { a, b, frame: Frame::of(difference) });
    for &Corner { features: [k, l], .. } in corners.list() {
        let (a, b) = (a.body().support(k), b.body().support(l));
        simplex.push(Vertex { w: difference.world(a.point, b.point), a, b });
    }
}

/// A core that the search knows.
#[derive(Clone, Copy)]
enum Core<'a> {
    Polytope(&'a Polytope),
    Curved(&'a Curved, Rims),
}

impl<'a> Core<'a> {
    fn of(map: &'a impl InBlocks) -> Option<Self> {
        let of_curved =
            |curved: &'a Curved| Self::Curved(curved, Rims::of(curved, curved.inner().centre));
        map.polytope().map(Self::Polytope).or_else(|| map.curved().map(of_curved))
    }

    fn is_curved(self) -> bool {
        matches!(self, Self::Curved(..))
    }

    fn has_few_vertices(self) -> bool {
        matches!(self, Self::Polytope(polytope) if polytope.vertex_blocks().is_empty())
    }

    fn body(self) -> Body<'a> {
        match self {
            Self::Polytope(polytope) => Body::Polytope(polytope),
            Self::Curved(curved, _) => Body::Curved(curved),
        }
    }

    /// The point that is farthest along a direction of its own frame but for rounding, relative to its centre, and its number.
    #[inline(always)]
    fn farthest<L: Lanes>(&self, l: L, direction: Vec3) -> Support<f32> {
        match self {
            Self::Polytope(polytope) => farthest(l, polytope, direction),
            Self::Curved(_, rims) => {
                let (point, feature) = rims.farthest(direction);
                Support { point, feature }
            }
        }
    }
}

/// The difference in the frame of A, scaled: a − R·b + middle, of points relative to the centres.
struct Frame {
    turn: Mat3,
    middle: Vec3,
    scale: f32,
}

impl Frame {
    fn of<A: InBlocks, B: InBlocks>(difference: &Difference<'_, f64, A, B>) -> Self {
        let [of_a, of_b] = difference.rotations();
        let back = of_a.transpose();
        Self {
            turn: (back * of_b).as_mat3(),
            middle: (back * difference.middle()).as_vec3(),
            scale: difference.scale() as f32,
        }
    }
}

/// GJK in f32.
struct Search<'a> {
    a: Core<'a>,
    b: Core<'a>,
    frame: Frame,
}

impl Kernel for Search<'_> {
    type Output = Corners;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Corners {
        let mut corners = Corners::default();
        let mut direction = self.frame.middle;
        let mut nearest_so_far = f32::MAX;
        let is_curved = self.a.is_curved() || self.b.is_curved();
        for _ in 0..MOST {
            let corner = self.lowest(l, direction);
            // Of polytopes the last vertex is one that is known.
            let gap = nearest_so_far - direction.dot(corner.at);
            let is_close = is_curved && gap < CLOSE * direction.length();
            if is_close || corners.holds(&corner) {
                break;
            }
            let Some(near) = corners.nearest_with(&corner) else { break };
            let squared = near.point.length_squared();
            // Written so that NaN ends it.
            if !(squared < nearest_so_far * NEARER) {
                break;
            }
            corners.keep(corner, near.kept);
            (nearest_so_far, direction) = (squared, near.point);
        }
        corners
    }
}

impl Search<'_> {
    /// The vertex of the difference that is lowest along a direction of the frame, but for rounding.
    #[inline(always)]
    fn lowest<L: Lanes>(&self, l: L, direction: Vec3) -> Corner {
        let Self { a, b, frame: Frame { turn, middle, scale } } = self;
        let in_b = Vec3::new(
            turn.x_axis.dot(direction),
            turn.y_axis.dot(direction),
            turn.z_axis.dot(direction),
        );
        let (a, b) = (a.farthest(l, -direction), b.farthest(l, in_b));
        let at = (a.point - *turn * b.point) * *scale + *middle;
        Corner { at, features: [a.feature, b.feature] }
    }
}

/// The farthest vertex of a polytope but for rounding, relative to its centre: the first among equals.
#[inline(always)]
fn farthest<L: Lanes>(l: L, polytope: &Polytope, direction: Vec3) -> Support<f32> {
    let vertices = polytope.vertices();
    match polytope.vertex_blocks().split_first() {
        None => farthest_of_few(vertices, polytope.inner().centre, direction),
        Some(blocks) => farthest_in_blocks(l, blocks, vertices.len(), direction),
    }
}

#[inline(always)]
fn farthest_of_few(vertices: &[DVec3], centre: DVec3, direction: Vec3) -> Support<f32> {
    let (mut most, mut found) = (f32::NEG_INFINITY, Support { point: Vec3::ZERO, feature: 0 });
    for (feature, &vertex) in (0..).zip(vertices) {
        let point = (vertex - centre).as_vec3();
        let along = point.dot(direction);
        if along > most {
            (most, found) = (along, Support { point, feature });
        }
    }
    found
}

#[inline(always)]
fn farthest_in_blocks<L: Lanes>(
    l: L,
    (first, rest): (&Block, &[Block]),
    count: usize,
    direction: Vec3,
) -> Support<f32> {
    let d = direction.to_array().map(|x| l.splat(x));
    let mut most = first.along(l, &d);
    for block in rest {
        most = l.max(most, block.along(l, &d));
    }
    let most = l.splat(l.largest(most));
    for (number, block) in std::iter::once(first).chain(rest).enumerate() {
        let bits = l.bits(l.le(most, block.along(l, &d))) & 0xffff;
        if bits != 0 {
            let k = bits.trailing_zeros() as usize;
            // The last block is filled up with the last vertex.
            let feature = (number * WIDTH + k).min(count - 1) as u32;
            return Support { point: block.point(k), feature };
        }
    }
    Support { point: first.point(0), feature: 0 }
}

/// A vertex of the difference.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Corner {
    at: Vec3,
    /// The vertices of A and of B, by index.
    features: [u32; 2],
}

/// A simplex that does not hold the origin.
#[derive(Clone, Copy, Debug, Default)]
struct Corners {
    corners: [Corner; 3],
    count: usize,
}

/// The point of a simplex with a new vertex that is nearest to the origin, and which of the old ones the smallest face has
/// that holds it.
struct Near {
    point: Vec3,
    kept: Kept,
}

/// Which of the vertices that a simplex had.
#[derive(Clone, Copy)]
enum Kept {
    None,
    One(usize),
    Two(usize, usize),
}

impl Corners {
    fn list(&self) -> &[Corner] {
        &self.corners[..self.count]
    }

    #[inline(always)]
    fn holds(&self, corner: &Corner) -> bool {
        self.list().iter().any(|known| known.features == corner.features)
    }

    /// `None` where the simplex and the new vertex hold the origin.
    #[inline(always)]
    fn nearest_with(&self, new: &Corner) -> Option<Near> {
        let [p, q, r] = self.corners.map(|corner| corner.at);
        let a = new.at;
        Some(match self.count {
            0 => Near { point: a, kept: Kept::None },
            1 => of_segment(a, (p, 0)),
            2 => of_triangle(a, (p, 0), (q, 1)),
            _ => return of_tetrahedron(a, [p, q, r]),
        })
    }

    /// Those of the old vertices, and the new one.
    #[inline(always)]
    fn keep(&mut self, new: Corner, kept: Kept) {
        let of = self.corners;
        (self.corners, self.count) = match kept {
            Kept::None => ([new; 3], 1),
            Kept::One(k) => ([of[k], new, new], 2),
            Kept::Two(j, k) => ([of[j], of[k], new], 3),
        };
    }
}

/// Of a new vertex and an old one, by its number. The nearest point is not the old one: it was nearest before.
#[inline(always)]
fn of_segment(a: Vec3, (b, of_b): (Vec3, usize)) -> Near {
    let edge = b - a;
    let along = -a.dot(edge);
    if along > 0.0 {
        let share = (along / edge.length_squared()).min(1.0);
        Near { point: a + edge * share, kept: Kept::One(of_b) }
    } else {
        Near { point: a, kept: Kept::None }
    }
}

/// Of a new vertex and two old ones: of its face, or of an edge that has the new one.
#[inline(always)]
fn of_triangle(a: Vec3, (b, of_b): (Vec3, usize), (c, of_c): (Vec3, usize)) -> Near {
    let (to_b, to_c) = (b - a, c - a);
    let normal = to_b.cross(to_c);
    // Whether the origin is beyond an edge, seen along the normal.
    let beyond_b = normal.cross(to_b).dot(a) > 0.0;
    let beyond_c = to_c.cross(normal).dot(a) > 0.0;
    match [beyond_b, beyond_c] {
        [false, false] => {
            let height = normal.dot(a) / normal.length_squared();
            Near { point: normal * height, kept: Kept::Two(of_b, of_c) }
        }
        [true, false] => of_segment(a, (b, of_b)),
        [false, true] => of_segment(a, (c, of_c)),
        [true, true] => nearer(of_segment(a, (b, of_b)), of_segment(a, (c, of_c))),
    }
}

/// Of a new vertex and three old ones; `None` where they hold the origin.
#[inline(always)]
fn of_tetrahedron(a: Vec3, [p, q, r]: [Vec3; 3]) -> Option<Near> {
    let mut best: Option<Near> = None;
    let (p, q, r) = ((p, 0), (q, 1), (r, 2));
    for (b, c, other) in [(p, q, r), (q, r, p), (r, p, q)] {
        let normal = (b.0 - a).cross(c.0 - a);
        // Only a face that sees the origin on its outer side.
        if normal.dot(a) * normal.dot(other.0 - a) > 0.0 {
            let found = of_triangle(a, b, c);
            best = Some(match best {
                Some(best) => nearer(best, found),
                None => found,
            });
        }
    }
    best
}

#[inline(always)]
fn nearer(one: Near, other: Near) -> Near {
    if other.point.length_squared() < one.point.length_squared() { other } else { one }
}

#[cfg(test)]
mod tests;
