//! A triangle against a cuboid by their thirteen separating axes, in f64 with a bound: whether they touch, and how deep
//! (docs/numerics/proofs.md, "a triangle and a cuboid").

use super::bounds::U64;
use super::reach::Couple;
use super::side::Part;
use crate::closed::nearest_of_triangle;
use crate::epa::Depth;
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Kind, Pose, Shape};
use dcd_simd::{larger, smaller};
use std::hint::select_unpredictable;

/// What the corners of a triangle lose on their way into the cuboid's frame. Unit: u·m.
pub(super) const PLACED: f64 = 40.0;

/// What one axis' reach loses, and what the direction of a product of edges loses. Unit: u of the sizes.
pub(super) const AXIS: f64 = 16.0;

/// The sine between an edge of each below which they count as parallel: their product is no axis then, and the bound
/// counts the way that makes them so. Larger: wider bounds. Smaller: axes that are rounding.
const PARALLEL: f64 = 1e-9;

/// Lengths of edges, metres, whose products with each other have squares clear of underflow. Smaller: lengths of axes
/// that are rounding.
const SHORTEST: f64 = 1e-60;

/// How often the witnesses are brought nearer to each other. No unit. Smaller: wider bounds.
const ROUNDS: usize = 8;

/// How far the witnesses may be beside each other to be brought no nearer. Unit: u of the sizes. Larger: wider bounds.
const OVER: f64 = 9.0;

/// What the axes say.
pub(super) enum ByAxes {
    /// An axis that separates the two: world, from the second to the first.
    Apart(DVec3),
    /// They touch, and so deep, if that is known as well.
    Touching(Option<Depth>),
}

/// A triangle in the frame of a cuboid.
struct Placed {
    corners: [DVec3; 3],
    half: DVec3,
    /// At least the length of every vector from the one to the other.
    size: f64,
    /// How far the corners may be off, metres.
    off: f64,
}

/// The axis of the least reach, and what is known of all.
struct Least {
    reach: f64,
    /// From the triangle to the cuboid, of unit length.
    normal: DVec3,
    feature: Axis,
    /// No axis reaches less.
    at_least: f64,
}

/// Of which features the axis is the normal.
#[derive(Clone, Copy)]
enum Axis {
    Triangle,
    /// A direction of the cuboid.
    Cuboid(usize),
    /// An edge of the triangle, by its first corner, and a direction of the cuboid.
    Edges(usize, usize),
}

impl<'a> Couple<'a> {
    /// The depth of parts that touch by a formula that is good enough: of two triangles by theirs; else by the axes of a cuboid, else by the nearest points,
    /// else where a part is pressed into the triangle; that first of a hull, whose planes take five times as long and say no
    /// more there. What the planes or the nearest points say may be `known`: it changes no bit.
    pub(super) fn by_formula(
        &self,
        known: Option<Depth>,
        is_good: impl Fn(&Depth) -> bool,
    ) -> Option<Depth> {
        if let [Part::Triangle { .. }, Part::Triangle { .. }] = self.parts() {
            return self.of_two_triangles().filter(is_good);
        }
        let is_hull = self.parts().iter().any(Part::is_hull);
        // Each returned at once: handed on by one after the other they would be copied as often.
        if is_hull
            && let Some(found) = self.pressed()
            && is_good(&found)
        {
            return Some(found);
        }
        if let Some(found) = known
            && is_good(&found)
        {
            return Some(found);
        }
        // What touches has no side between.
        if let Some(ByAxes::Touching(Some(found))) = self.by_axes_after(|_, _| None)
            && is_good(&found)
        {
            return Some(found);
        }
        if is_hull {
            return None;
        }
        if let Some(found) = self.by_nearest()
            && is_good(&found)
        {
            return Some(found);
        }
        self.pressed().filter(is_good)
    }

    /// `None` of other parts, and where the bound leaves open whether they touch.
    pub(super) fn by_axes(&self) -> Option<ByAxes> {
        self.by_axes_after(Placed::side_between)
    }

    /// The same, after a direction of a cuboid that separates the two, if that finds one.
    fn by_axes_after(&self, between: impl Fn(&Placed, f64) -> Option<DVec3>) -> Option<ByAxes> {
        let triangle = match self.parts() {
            [Part::Triangle { .. }, Part::Shape(_)] => 0,
            [Part::Shape(_), Part::Triangle { .. }] => 1,
            _ => return None,
        };
        let (Part::Triangle { corners, radius: swept, .. }, Part::Shape(Shape::Polytope(core))) =
            (&self.parts()[triangle], &self.parts()[1 - triangle])
        else {
            return None;
        };
        let half = match core.kind() {
            Kind::Cuboid { half_extents } => half_extents,
            Kind::Hull => return self.by_planes((corners, triangle), core),
            _ => return None,
        };
        let poses = [self.poses()[triangle], self.poses()[1 - triangle]];
        // 1 where the normal from the triangle to the cuboid is that from the first to the second.
        let sense = if triangle == 0 { 1.0 } else { -1.0 };
        let placed = self.placed(corners, half, (poses, sense));
        let radius = swept + core.swept_radius();
        let turn = poses[1].rotation();
        if let Some(axis) = between(&placed, radius) {
            return Some(ByAxes::Apart(*turn * axis * -sense));
        }
        let least = match placed.least(radius) {
            Ok(least) => least?,
            Err(axis) => return Some(ByAxes::Apart(*turn * axis * -sense)),
        };
        // Of cores that do not meet, the axes do not bound what the radii overlap.
        if !(least.at_least > placed.off) {
            return None;
        }
        let (at_cuboid, beside) = placed.witness(&least)?;
        let depth = least.reach + radius;
        let open = (least.reach - least.at_least).max(0.0) + placed.off;
        let error_bound = open + beside + AXIS * U64 * (placed.size + radius);
        // Of unit length also where the pose is hardly a rotation: radii may be many times the size.
        let normal = (*turn * least.normal).normalize();
        let deepest = *turn * at_cuboid - normal * core.swept_radius();
        let at_cuboid = poses[1].translation() + deepest;
        let at_triangle = poses[1].translation() + (deepest + normal * depth);
        let (point_a, point_b) =
            if triangle == 0 { (at_triangle, at_cuboid) } else { (at_cuboid, at_triangle) };
        let found = Depth { depth, normal: normal * sense, point_a, point_b, error_bound };
        (depth.is_finite() && error_bound.is_finite()).then_some(ByAxes::Touching(Some(found)))
    }

    fn placed(
        &self,
        corners: &[DVec3; 3],
        half: DVec3,
        (poses, sense): ([&Pose; 2], f64),
    ) -> Placed {
        let back = poses[1].rotation().transpose();
        let to_cuboid = self.delta() * sense;
        let placed = |corner: DVec3| back * (*poses[0].rotation() * corner - to_cuboid);
        let corners = [placed(corners[0]), placed(corners[1]), placed(corners[2])];
        let squares = corners.map(DVec3::length_squared);
        let farthest = larger(larger(squares[0], squares[1]), squares[2]).sqrt();
        let deviation = poses[0].deviation() + poses[1].deviation();
        let off = (PLACED * U64 + 4.0 * deviation) * self.size();
        Placed { corners, half, size: farthest + half.length() + off, off }
    }
}

impl Placed {
    /// The direction of the cuboid along which they are farthest from each other, if by more than `radius`: where one
    /// separates them, no other axis is needed.
    fn side_between(&self, radius: f64) -> Option<DVec3> {
        let [p, q, r] = self.corners;
        // Where the cuboid is on the positive side of the triangle, and on the negative one.
        let (forth, back) = (-self.half - p.max(q).max(r), p.min(q).min(r) - self.half);
        let gap = forth.max(back);
        let axis = gap.max_position();
        // NaN is no gap.
        if !(gap[axis] > radius + self.rounding(radius) + self.off) {
            return None;
        }
        let direction = DMat3::IDENTITY.col(axis);
        Some(if forth[axis] > back[axis] { direction } else { -direction })
    }

    /// What an axis' reach loses, metres.
    fn rounding(&self, radius: f64) -> f64 {
        AXIS * U64 * (self.size + radius)
    }

    /// The axis along which they reach least past each other; an axis that separates them by more than `radius` is an
    /// error. `None` where the triangle has no normal, or one that may be rounding.
    fn least(&self, radius: f64) -> Result<Option<Least>, DVec3> {
        let [p, q, r] = self.corners;
        let edges = [q - p, r - q, p - r];
        let normal = edges[0].cross(edges[1]);
        let area = normal.length();
        let lengths = [edges[0].length(), edges[1].length(), edges[2].length()];
        let shortest = smaller(smaller(lengths[0], lengths[1]), lengths[2]);
        // The square of what is compared does not underflow. Written so that NaN is no triangle.
        if !(area > SHORTEST * SHORTEST && shortest > SHORTEST) {
            return Ok(None);
        }
        // The products of edges with the cuboid's directions are as long as the edges are off these.
        let across = [across(edges[0]), across(edges[1]), across(edges[2])];
        let (mut moved, mut parallel) = (0.0f64, 0);
        for (across, edge) in across.iter().zip(lengths) {
            for &sine in across {
                if sine <= PARALLEL * edge {
                    moved += sine;
                    parallel += 1;
                }
            }
        }
        // Two have a corner in common, from where both can be made parallel; three are a needle.
        if parallel > 2 {
            return Ok(None);
        }
        let rounding = AXIS * U64;
        let mut axes = Axes { size: self.size, ..Axes::default() };
        let longest = larger(larger(lengths[0], lengths[1]), lengths[2]);
        let off = (rounding * longest + 8.0 * moved) * (longest + moved) / area;
        let unit = normal / area;
        axes.add(0, [unit.dot(p), unit.dot(q), unit.dot(r)], unit.abs().dot(self.half), off);
        axes.add(1, [p.x, q.x, r.x], self.half.x, 0.0);
        axes.add(2, [p.y, q.y, r.y], self.half.y, 0.0);
        axes.add(3, [p.z, q.z, r.z], self.half.z, 0.0);
        for (i, (from, opposite)) in [(p, r), (q, p), (r, q)].into_iter().enumerate() {
            let ends = [edges[i], from, opposite, self.half].map(|v| v.to_array());
            for (j, [k, l]) in [[1, 2], [2, 0], [0, 1]].into_iter().enumerate() {
                let length = across[i][j];
                if length > PARALLEL * lengths[i] {
                    let inverse = 1.0 / length;
                    let off = (rounding * lengths[i] + 4.0 * moved) * inverse;
                    axes.add_product(4 + 3 * i + j, (&ends, [k, l]), inverse, off);
                }
            }
        }
        let feature = match axes.number {
            0 => Axis::Triangle,
            j @ 1..=3 => Axis::Cuboid(j - 1),
            number => Axis::Edges((number - 4) / 3, (number - 4) % 3),
        };
        let axis = match feature {
            Axis::Triangle => unit,
            Axis::Cuboid(j) => DMat3::IDENTITY.col(j),
            Axis::Edges(i, j) => edges[i].cross(DMat3::IDENTITY.col(j)) / across[i][j],
        };
        let rounding = self.rounding(radius);
        let normal = if axes.is_back { -axis } else { axis };
        // Also along the rounded axis this is true.
        if axes.reach + radius + rounding + self.off < 0.0 {
            return Err(normal);
        }
        let at_least = axes.at_least - rounding - 2.0 * moved;
        Ok(Some(Least { reach: axes.reach, normal, feature, at_least }))
    }

    /// The point of the cuboid that is deepest along the least axis, over a point of the triangle; and how far the two
    /// are beside each other.
    fn witness(&self, least: &Least) -> Option<(DVec3, f64)> {
        let (normal, reach) = (least.normal, least.reach);
        let up = normal * reach;
        // The farthest feature of the cuboid against the normal: a corner, an edge or a side.
        let level = 1e-12;
        let low = DVec3::select(normal.cmplt(DVec3::splat(level)), self.half, -self.half);
        let high = DVec3::select(normal.cmpgt(DVec3::splat(-level)), -self.half, self.half);
        let (low, high) = (low.min(high), low.max(high));
        let (low, high) = match least.feature {
            Axis::Edges(_, j) => {
                let along = DMat3::IDENTITY.col(j) * self.half;
                let middle = DVec3::select(normal.cmpgt(DVec3::ZERO), -self.half, self.half);
                let middle = middle - middle * DMat3::IDENTITY.col(j);
                (middle - along, middle + along)
            }
            _ => (low, high),
        };
        // The place, and the point of the triangle that it is under, if that is known.
        let (mut at, known) = match least.feature {
            Axis::Triangle => ((low + high) * 0.5, None),
            Axis::Cuboid(_) => {
                let corners = self.corners.map(|corner| (normal.dot(corner), corner));
                let second = usize::from(corners[1].0 > corners[0].0);
                let most = if corners[2].0 > corners[second].0 { 2 } else { second };
                let corner = corners[most].1;
                ((corner - up).clamp(low, high), Some(corner))
            }
            Axis::Edges(i, j) => {
                // Where the edge is over that of the cuboid, seen along a direction square to it.
                let (from, to) = (self.corners[i], self.corners[(i + 1) % 3]);
                let edge = to - from;
                let mut across = edge;
                across[j] = 0.0;
                let square = across.length_squared();
                let share = across.dot(low + up - from) / square;
                let on_edge = from + edge * share.clamp(0.0, 1.0);
                ((on_edge - up).clamp(low, high), Some(on_edge))
            }
        };
        let near = OVER * U64 * self.size;
        let (mut next, mut beside) = (known, f64::INFINITY);
        for _ in 0..=ROUNDS {
            let over = next.take().unwrap_or_else(|| nearest_of_triangle(self.corners, at + up));
            beside = over.distance(at + up);
            if beside <= near {
                break;
            }
            at = (over - up).clamp(low, high);
        }
        beside.is_finite().then_some((at, beside))
    }
}

/// The least reach of the axes so far.
struct Axes {
    /// At least the length of every vector from the triangle to the cuboid.
    size: f64,
    reach: f64,
    /// Which axis has it, by its place in their order.
    number: usize,
    /// Whether it is that against the axis.
    is_back: bool,
    /// No axis reaches less, but for rounding.
    at_least: f64,
}

impl Default for Axes {
    fn default() -> Self {
        Self { size: 0.0, reach: f64::INFINITY, number: 0, is_back: false, at_least: f64::INFINITY }
    }
}

impl Axes {
    /// Compares an axis of unit length, which may be off the true one by an angle: the heights of points of the triangle
    /// between which it is, and how far the cuboid reaches.
    #[inline(always)]
    fn add(&mut self, number: usize, heights: [f64; 3], of_cuboid: f64, off: f64) {
        let [p, q, r] = heights;
        let (low, high) = (smaller(smaller(p, q), r), larger(larger(p, q), r));
        // The cuboid goes along the axis, or against it.
        let [forth, back] = [high + of_cuboid, of_cuboid - low];
        let is_back = forth > back;
        let reach = select_unpredictable(is_back, back, forth);
        self.at_least = smaller(self.at_least, reach - off * self.size);
        // Selected: which axis is the least cannot be predicted.
        let is_less = reach < self.reach;
        self.reach = select_unpredictable(is_less, reach, self.reach);
        self.number = select_unpredictable(is_less, number, self.number);
        self.is_back = select_unpredictable(is_less, is_back, self.is_back);
    }

    /// The product of an edge and a direction of the cuboid, of one by that length: from the edge, its first corner, the
    /// corner opposite and the half edges, and the cuboid's other two directions. Both ends of the edge are at one height.
    #[inline(always)]
    fn add_product(
        &mut self,
        number: usize,
        ([edge, from, opposite, half], [k, l]): (&[[f64; 3]; 4], [usize; 2]),
        inverse: f64,
        off: f64,
    ) {
        let height = |corner: &[f64; 3]| (edge[l] * corner[k] - edge[k] * corner[l]) * inverse;
        let (from, opposite) = (height(from), height(opposite));
        let of_cuboid = (edge[l].abs() * half[k] + edge[k].abs() * half[l]) * inverse;
        self.add(number, [from, opposite, opposite], of_cuboid, off);
    }
}

/// How long the products of an edge with the three axes are.
fn across(edge: DVec3) -> [f64; 3] {
    let DVec3 { x, y, z } = edge * edge;
    [(y + z).sqrt(), (z + x).sqrt(), (x + y).sqrt()]
}

#[cfg(test)]
mod tests;
