//! Sixteen triangles against a convex body with vertices: directions that separate the two, and points that both have,
//! in f32 with bounds for all rounding (docs/numerics/proofs.md, "Parts").

mod cuboid_axes;

use super::bounds::{
    BODY_DETERMINANT, BODY_HEIGHT, BODY_NEAREST, BODY_REACH, BODY_SEPARATION, CUBOID_SEPARATION,
    SHORTEST, SHORTEST_SQUARE, SMALLEST_SPHERE, SWEPT, TURNED, U, U64, up,
};
use super::relative_pose::RelativePose;
use super::side::{Parts, Side};
use super::spheres::nearest;
use crate::simd::vector::V3;
use dcd_geom::glam::{DMat3, DVec3, Vec3, Vec4};
use dcd_geom::{Kind, Shape, Triangles};
use dcd_simd::{Lanes, Row};

/// Of how many vertices a hull is tested in lanes. No unit. Larger: a leaf costs more than the few triangles of it that
/// are near. Smaller: triangles resolved one by one.
const MOST: usize = 64;

/// A convex second shape with vertices, in the first shape's axes and relative to its middle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Body {
    form: Form,
    /// From the first shape's origin.
    pub(super) middle: DVec3,
    /// At least how far it reaches along each axis, and at most, from its middle. Rounded.
    extent: [Vec3; 2],
    /// At least the length of every vertex, metres.
    reach: f64,
    /// The swept radii of both shapes: at least, and at most.
    swept: [f64; 2],
    slack: f64,
    /// What the two matrices depart from rotations by, relative.
    departure: f64,
}

#[derive(Clone, Copy, Debug)]
enum Form {
    /// The directions of its edges, and half of them.
    Cuboid { axes: [Vec3; 3], half: Vec3 },
    /// From the middle to an end.
    Segment { half: Vec3 },
    /// Its vertices are kept elsewhere.
    Hull,
}

/// Lanes that are proved to touch, and to be apart.
#[derive(Clone, Copy, Default)]
pub(super) struct Proved {
    pub(super) touching: u32,
    pub(super) apart: u32,
}

/// The bounds of one leaf.
struct Bounds {
    /// At least the length of every corner, relative to the body's middle, and of every vertex. Metres.
    size: f64,
    /// At least that of every corner.
    far: f64,
    /// What a separation must exceed per |d|₁.
    per_norm1: f32,
    /// Per |d|.
    radius: f32,
    /// And in any case.
    least: f32,
}

impl Body {
    /// `None` of shapes without vertices or with very many, of spheres, and where a pose is no rotation. Writes the
    /// vertices of a hull.
    #[inline(always)]
    pub(super) fn of(
        relative: &RelativePose,
        [a, b]: [&Side<'_>; 2],
        vertices: &mut Vec<Vec3>,
    ) -> Option<Self> {
        let Parts::One(Shape::Polytope(polytope)) = b.parts else { return None };
        let (turn_a, turn_b) = (a.pose.deviation(), b.pose.deviation());
        let departure = turn_a + turn_b;
        // Written so that NaN is no rotation.
        if !(departure < TURNED) {
            return None;
        }
        let turn = relative.rotation;
        let centre = polytope.inner().centre;
        let extent;
        let form = match (polytope.kind(), polytope.vertices()) {
            (Kind::Point, _) => return None,
            (Kind::Cuboid { half_extents: half }, _) => {
                let axes = [turn.x_axis.as_vec3(), turn.y_axis.as_vec3(), turn.z_axis.as_vec3()];
                let half = half.as_vec3();
                let [x, y, z] = axes;
                let reach = x.abs() * half.x + y.abs() * half.y + z.abs() * half.z;
                extent = [-reach, reach];
                Form::Cuboid { axes, half }
            }
            (Kind::Segment, &[from, to]) => {
                let half = (turn * ((to - from) * 0.5)).as_vec3();
                extent = [-half.abs(), half.abs()];
                Form::Segment { half }
            }
            (_, all) if all.len() <= MOST => {
                extent = turned(turn, (all, centre), vertices);
                Form::Hull
            }
            _ => return None,
        };
        let stretch = (1.0 + turn_a) * (1.0 + turn_b) * (1.0 + 16.0 * U64);
        let swept = a.radius() + polytope.swept_radius();
        Some(Self {
            form,
            middle: turn * centre + relative.offset,
            extent,
            reach: polytope.outer_radius() * stretch,
            swept: [
                swept * (1.0 - turn_a) * (1.0 - 16.0 * U64),
                swept * relative.stretch() * (1.0 + 16.0 * U64),
            ],
            slack: relative.slack(),
            departure,
        })
    }

    /// The smallest and the largest coordinate along each of the first shape's axes, but for rounding.
    #[inline(always)]
    pub(super) fn extent(&self) -> (DVec3, DVec3) {
        let [min, max] = self.extent.map(|end| self.middle + end.as_dvec3());
        (min - self.swept[1], max + self.swept[1])
    }

    /// Whether no other test in lanes knows more of the triangles.
    pub(super) fn is_cuboid(&self) -> bool {
        matches!(self.form, Form::Cuboid { .. })
    }

    /// What is proved of a leaf's triangles in the open lanes. Writes an upper bound of how deep each triangle and the body overlap,
    /// where that is wanted: metres, infinite where it is not known.
    #[inline(always)]
    pub(super) fn decide<L: Lanes>(
        &self,
        l: L,
        (leaf, open): (&Triangles, u32),
        vertices: &[Vec3],
        at_most: Option<&mut Row>,
    ) -> Proved {
        let offset = self.middle - leaf.centre;
        let bounds = self.bounds(leaf.radius + offset.length());
        let corners = relative(l, leaf, offset);
        match self.form {
            Form::Cuboid { axes, half } => {
                self.by_axes(l, &bounds, (corners, at_most), (axes, half))
            }
            Form::Segment { half } => self.by_ends(l, &bounds, (corners, at_most), half, open),
            Form::Hull => self.by_vertices(l, &bounds, (corners, at_most), vertices, open),
        }
    }

    /// What is proved of a cuboid and a leaf's triangles in the open lanes without its axes, which is mostly enough where one
    /// triangle is; nothing of other bodies.
    #[inline(always)]
    pub(super) fn decide_at_once<L: Lanes>(&self, l: L, (leaf, open): (&Triangles, u32)) -> Proved {
        let Form::Cuboid { axes, half } = self.form else { return Proved::default() };
        let offset = self.middle - leaf.centre;
        let bounds = self.bounds(leaf.radius + offset.length());
        self.by_farthest_corner(l, &bounds, relative(l, leaf, offset), (axes, half), open)
    }

    /// Of a leaf whose corners are that far, metres.
    fn bounds(&self, far: f64) -> Bounds {
        let size = far + self.reach;
        let separation = match self.form {
            Form::Cuboid { .. } => CUBOID_SEPARATION * U + self.departure,
            _ => BODY_SEPARATION * U,
        };
        let per_norm1 = 1.01 * (separation * size + 4.0 * self.slack);
        let [_, swept] = self.swept;
        let (radius, least) = if swept > 0.0 {
            (swept * (1.0 + 2.0 * SWEPT), 2.0 * SHORTEST * size)
        } else {
            (0.0, 0.0)
        };
        Bounds {
            size,
            far,
            per_norm1: up(per_norm1),
            radius: if radius > 0.0 { up(radius) } else { 0.0 },
            least: least as f32 + f32::MIN_POSITIVE,
        }
    }

    /// A hull: by the triangle's normal, and whether the line from its middle to its farthest vertex goes through the
    /// triangle.
    #[inline(always)]
    fn by_vertices<L: Lanes>(
        &self,
        l: L,
        bounds: &Bounds,
        (corners, at_most): ([V3<L>; 3], Option<&mut Row>),
        vertices: &[Vec3],
        open: u32,
    ) -> Proved {
        let plane = Plane::of(l, corners);
        let (most, at) = farthest(l, plane.normal, vertices);
        let gap = l.sub(plane.low, most);
        let apart = open & bounds.beyond(l, gap, plane.normal);
        if apart == open {
            return Proved { touching: 0, apart };
        }
        if let Some(row) = at_most {
            l.store(bounds.at_most(l, gap, plane.normal), row);
        }
        let lost = [BODY_HEIGHT, BODY_DETERMINANT];
        Proved { touching: self.pierced(l, (bounds, lost), corners, &plane, (most, at)), apart }
    }

    /// A capsule: by the triangle's normal, and by the triangle's point nearest to the end that is nearer to its plane.
    #[inline(always)]
    fn by_ends<L: Lanes>(
        &self,
        l: L,
        bounds: &Bounds,
        (corners, at_most): ([V3<L>; 3], Option<&mut Row>),
        half: Vec3,
        open: u32,
    ) -> Proved {
        let half = splat(l, half);
        let plane = Plane::of(l, corners);
        let along = plane.normal.dot(l, half);
        let of_plane = l.sub(plane.low, l.abs(along));
        let mut apart = open & bounds.beyond(l, of_plane, plane.normal);
        if apart == open {
            return Proved { touching: 0, apart };
        }
        let end = V3::select(l, l.lt(along, l.splat(0.0)), half.neg(l), half);
        let [p, q, r] = corners;
        let near = nearest(l, [p.sub(l, end), q.sub(l, end), r.sub(l, end)]);
        let touching = self.is_within(l, bounds, near);
        let low = min3(l, near.dot(l, p), near.dot(l, q), near.dot(l, r));
        let gap = l.sub(low, l.abs(near.dot(l, half)));
        apart |= open & bounds.beyond(l, gap, near);
        if let Some(row) = at_most {
            let by_plane = bounds.at_most(l, of_plane, plane.normal);
            l.store(l.min(bounds.at_most(l, gap, near), by_plane), row);
        }
        Proved { touching, apart }
    }

    /// The lanes in which a vector between a point of the triangle and one of the core is surely within the radii.
    #[inline(always)]
    fn is_within<L: Lanes>(&self, l: L, bounds: &Bounds, near: V3<L>) -> u32 {
        let within = self.swept[0] - 1.01 * (BODY_NEAREST * U * bounds.size + 4.0 * self.slack);
        // Written so that NaN proves nothing.
        if !(within > SMALLEST_SPHERE) {
            return 0;
        }
        let most = (within * within * (1.0 - 4.0 * U)) as f32;
        l.bits(l.lt(near.dot(l, near), l.splat(most.next_down())))
    }

    /// The lanes in which the segment from the middle to a point of the core goes through the triangle; what heights and
    /// determinants lose.
    #[inline(always)]
    fn pierced<L: Lanes>(
        &self,
        l: L,
        (bounds, [of_height, of_determinant]): (&Bounds, [f64; 2]),
        [p, q, r]: [V3<L>; 3],
        plane: &Plane<L>,
        (height, at): (L::F, V3<L>),
    ) -> u32 {
        let Bounds { size, far, .. } = *bounds;
        let off = (U * far + 2.0 * self.slack) * far * size;
        let clear = l.splat(up(of_height * off) + f32::MIN_POSITIVE);
        let crosses = l.and(l.lt(clear, plane.low), l.lt(clear, l.sub(height, plane.high)));
        let side = l.splat(up(of_determinant * off) + f32::MIN_POSITIVE);
        let sides = [at.dot(l, p.cross(l, q)), at.dot(l, q.cross(l, r)), at.dot(l, r.cross(l, p))];
        let low = min3(l, sides[0], sides[1], sides[2]);
        let high = max3(l, sides[0], sides[1], sides[2]);
        let inside = l.or(l.lt(side, low), l.lt(high, l.neg(side)));
        l.bits(l.and(crosses, inside))
    }

    /// The lanes that the direction from the body's middle to the nearest points separates, of those that are open.
    #[inline(always)]
    pub(super) fn beside<L: Lanes>(
        &self,
        l: L,
        leaf: &Triangles,
        (vertices, direction): (&[Vec3], V3<L>),
    ) -> u32 {
        let offset = self.middle - leaf.centre;
        let far = leaf.radius + offset.length();
        let bounds = self.bounds(far);
        let [p, q, r] = relative(l, leaf, offset);
        let low = min3(l, direction.dot(l, p), direction.dot(l, q), direction.dot(l, r));
        let most = match self.form {
            Form::Segment { half } => l.abs(direction.dot(l, splat(l, half))),
            _ => farthest_along(l, direction, vertices),
        };
        bounds.beyond(l, l.sub(low, most), direction)
    }
}

impl Bounds {
    /// What a gap along d must exceed, from its rounding bound and d·d.
    #[inline(always)]
    fn with_radius<L: Lanes>(&self, l: L, bound: L::F, square: L::F) -> L::F {
        let bound = l.add(bound, l.splat(self.least));
        if self.radius > 0.0 {
            l.mul_add(l.splat(self.radius), l.sqrt(square), bound)
        } else {
            bound
        }
    }

    /// The lanes in which the gap along d proves the two apart.
    #[inline(always)]
    fn beyond<L: Lanes>(&self, l: L, gap: L::F, d: V3<L>) -> u32 {
        let bound = l.mul(l.splat(self.per_norm1), d.norm1(l));
        l.bits(l.lt(self.with_radius(l, bound, d.dot(l, d)), gap))
    }

    /// At least how far the two reach past each other along d, metres, from the gap along it: infinite for NaN.
    #[inline(always)]
    fn at_most<L: Lanes>(&self, l: L, gap: L::F, d: V3<L>) -> L::F {
        let square = d.dot(l, d);
        let reach = l.sub(l.mul(l.splat(self.per_norm1), d.norm1(l)), gap);
        let reach = l.div(reach, l.sqrt(square));
        // Cores that are apart along d have a reach below 0: what it loses makes the sum no smaller.
        let lost = l.mul(l.abs(reach), l.splat(BODY_REACH));
        let at_most = l.add(l.add(reach, lost), l.splat(self.radius));
        let far = l.splat(f32::INFINITY);
        // Written so that NaN, and a direction without length, bound nothing.
        let at_most = l.select(l.lt(at_most, far), at_most, far);
        l.select(l.lt(l.splat(SHORTEST_SQUARE), square), at_most, far)
    }

    /// The same along one of the axes that the corners are given in.
    #[inline(always)]
    fn at_most_along_unit<L: Lanes>(&self, l: L, gap: L::F) -> L::F {
        let far = l.splat(f32::INFINITY);
        // Infinite for NaN.
        l.min(l.sub(l.splat(up(f64::from(self.per_norm1) + f64::from(self.radius))), gap), far)
    }
}

/// A leaf's corners, relative to a point of that offset from its centre.
#[inline(always)]
fn relative<L: Lanes>(l: L, leaf: &Triangles, offset: DVec3) -> [V3<L>; 3] {
    let middle = splat(l, offset.as_vec3());
    let [p, q, r] = &leaf.corners;
    let (p, q, r) = (V3::load(l, &p.0), V3::load(l, &q.0), V3::load(l, &r.0));
    [p.sub(l, middle), q.sub(l, middle), r.sub(l, middle)]
}

/// Writes vertices relative to a centre, turned and rounded. Their least and their greatest coordinates.
///
/// Each in four components, which fill a register; of the last nobody asks.
#[inline(always)]
fn turned(turn: DMat3, (all, centre): (&[DVec3], DVec3), turned: &mut Vec<Vec3>) -> [Vec3; 2] {
    let column = |axis: DVec3| [axis.x, axis.y, axis.z, 0.0];
    let (x, y, z) = (column(turn.x_axis), column(turn.y_axis), column(turn.z_axis));
    let mut extent = [Vec4::INFINITY, Vec4::NEG_INFINITY];
    turned.clear();
    turned.resize(all.len(), Vec3::ZERO);
    for (turned, &vertex) in turned.iter_mut().zip(all) {
        let v = vertex - centre;
        let of = |k: usize| (x[k] * v.x + y[k] * v.y + z[k] * v.z) as f32;
        let vertex = Vec4::new(of(0), of(1), of(2), of(3));
        extent = [extent[0].min(vertex), extent[1].max(vertex)];
        *turned = vertex.truncate();
    }
    extent.map(Vec4::truncate)
}

/// The planes of sixteen triangles.
struct Plane<L: Lanes> {
    /// Away from the origin, of any length.
    normal: V3<L>,
    /// The least and the greatest height of a corner along it.
    low: L::F,
    high: L::F,
}

impl<L: Lanes> Plane<L> {
    #[inline(always)]
    fn of(l: L, [p, q, r]: [V3<L>; 3]) -> Self {
        let normal = q.sub(l, p).cross(l, r.sub(l, p));
        let is_below = l.lt(normal.dot(l, p), l.splat(0.0));
        let normal = V3::select(l, is_below, normal.neg(l), normal);
        let heights = [normal.dot(l, p), normal.dot(l, q), normal.dot(l, r)];
        let [a, b, c] = heights;
        Self { normal, low: min3(l, a, b, c), high: max3(l, a, b, c) }
    }
}

/// The greatest height of the vertices along sixteen directions, and where it is.
#[inline(always)]
fn farthest<L: Lanes>(l: L, direction: V3<L>, vertices: &[Vec3]) -> (L::F, V3<L>) {
    let mut most = l.splat(f32::NEG_INFINITY);
    let mut at = splat(l, Vec3::ZERO);
    for &vertex in vertices {
        let vertex = splat(l, vertex);
        let height = direction.dot(l, vertex);
        let is_higher = l.lt(most, height);
        most = l.select(is_higher, height, most);
        at = V3::select(l, is_higher, vertex, at);
    }
    (most, at)
}

/// The greatest height alone.
#[inline(always)]
fn farthest_along<L: Lanes>(l: L, direction: V3<L>, vertices: &[Vec3]) -> L::F {
    let mut most = l.splat(f32::NEG_INFINITY);
    for &vertex in vertices {
        most = l.max(most, direction.dot(l, splat(l, vertex)));
    }
    most
}

#[inline(always)]
fn splat<L: Lanes>(l: L, v: Vec3) -> V3<L> {
    V3(l.splat(v.x), l.splat(v.y), l.splat(v.z))
}

#[inline(always)]
fn min3<L: Lanes>(l: L, a: L::F, b: L::F, c: L::F) -> L::F {
    l.min(l.min(a, b), c)
}

#[inline(always)]
fn max3<L: Lanes>(l: L, a: L::F, b: L::F, c: L::F) -> L::F {
    l.max(l.max(a, b), c)
}
