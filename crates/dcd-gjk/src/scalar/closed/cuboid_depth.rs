//! How deep two cuboids overlap, or a cuboid and a sphere or capsule, rounded or not: the fifteen axes are all that
//! can be the least.
//!
//! A sphere's core is a box without extent, a capsule's one that extends along one axis alone. The difference of two
//! boxes is the sum of six segments, whose faces are normal to an edge of each pair: three
//! axes of a, three of b, nine products of one and one. The axes are computed as those of two rotations, in a's
//! frame; what the poses depart from rotations by, and all rounding, is in the bounds
//! (docs/numerics/proofs.md, "The depth of cuboids").

use super::{SIZES, UNIT};
use crate::PosedSupport;
use crate::epa::Depth;
use crate::expanding::SHALLOW;
use crate::query::Accuracy;
use dcd_geom::glam::{DMat3, DVec2, DVec3};
use dcd_geom::{Kind, Polytope, Vector};

/// The largest deviation of a pose for which the bounds below hold, and are of use.
const DEVIATION: f64 = 256.0 * UNIT;

/// What the overlap along an axis of a or b may be off by: u, and deviations of both, times the pair's size.
/// Derived: 14 and 3.1.
const FACE: [f64; 2] = [32.0, 4.0];

/// The same along a product, times its length: 62 and 10.5, divided by the length.
const CROSS: [f64; 2] = [96.0, 16.0];

/// What the length of a product may be off by: u and deviations.
const SINE: [f64; 2] = [8.0, 2.0];

/// The squared length below which a product proves nothing by itself: 2⁻⁴⁰. Larger: worse bounds of nearly parallel
/// boxes. Smaller: those of axes that rounding has turned.
const PARALLEL: f64 = 1.0 / (1u64 << 40) as f64;

/// How often a point goes from one level face to the other before the two are taken to meet in a corner that
/// rounding hides. Fewer: more pairs left to the general search.
const NEARER: usize = 16;

/// The bounds that are good enough: relative to the depth, and to the pair's size by half-extents, which is at most √3
/// times that by reaches: 256u of the latter.
fn tolerance(accuracy: Accuracy) -> [f64; 2] {
    match accuracy {
        Accuracy::F32 => [0.0, 1e-6],
        Accuracy::F64 => [1e-10, 147.0 * UNIT],
        Accuracy::Certified => [1e-9, 0.0],
    }
}

/// A box at its place.
#[derive(Clone, Copy)]
pub(super) struct Placed {
    pub(super) half: DVec3,
    pub(super) axes: [DVec3; 3],
    /// From a's centre, in world axes.
    pub(super) centre: DVec3,
}

/// What is normal to a face of the difference.
#[derive(Clone, Copy)]
pub(super) enum Axis {
    OfA(usize),
    OfB(usize),
    Product(usize, usize),
}

/// Which axes are looked at, a bit each: three of a, three of b, and the products of axis j of a and axis k of b at
/// 6 + 3j + k.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Axes(pub(crate) u16);

impl Axes {
    /// All fifteen.
    pub(crate) const ALL: Self = Self(0x7fff);

    #[inline(always)]
    fn has(self, number: usize) -> bool {
        self.0 >> number & 1 == 1
    }

    /// The same with a and b exchanged.
    pub(crate) fn mirrored(self) -> Self {
        let bit = |number: usize| self.0 >> number & 1;
        let product = |j: usize, k: usize| bit(6 + 3 * k + j) << (6 + 3 * j + k);
        let products = (0..9).map(|n| product(n / 3, n % 3)).sum::<u16>();
        Self(self.0 >> 3 & 7 | (self.0 & 7) << 3 | products)
    }
}

/// The axis of the least overlap so far.
#[derive(Clone, Copy)]
struct Least {
    axis: Axis,
    value: f64,
    error: f64,
    /// No overlap along any axis is below this.
    lower: f64,
}

/// The depth of two that touch, with a bound as good as required: `None` where it is not, for other shapes, and
/// where the cores do not surely overlap.
pub(crate) fn depth(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    accuracy: Accuracy,
) -> Option<Depth> {
    depth_along(Axes::ALL, a, b, accuracy)
}

/// The same where all other axes surely overlap more than one of those.
pub(crate) fn depth_along(
    axes: Axes,
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    accuracy: Accuracy,
) -> Option<Depth> {
    let is_cuboid = |side: &Polytope| matches!(side.kind(), Kind::Cuboid { .. });
    if !is_cuboid(a.map) && !is_cuboid(b.map) {
        return None;
    }
    let (half_a, half_b) = (half_extents(a.map)?, half_extents(b.map)?);
    let radii = [a.map.swept_radius(), b.map.swept_radius()];
    let radius = radii[0] + radii[1];
    let (search, [placed_a, placed_b]) = posed([a, b], [half_a, half_b])?;
    let (delta, size) = (placed_b.centre, search.size);
    let Least { axis, value, error, lower } = search.least(axes)?;
    let depth = value + radius;
    let error_bound = error.max(value - lower) + 4.0 * UNIT * (depth + error);
    let [relative, of_size] = tolerance(accuracy);
    if !(lower > 0.0 && error_bound <= (relative * depth).max(of_size * size)) {
        return None;
    }
    if accuracy == Accuracy::Certified && !(depth >= SHALLOW * size) {
        return None;
    }
    let normal = match axis {
        Axis::OfA(k) => placed_a.axes[k],
        Axis::OfB(k) => placed_b.axes[k],
        Axis::Product(j, k) => placed_a.axes[j].cross(placed_b.axes[k]),
    };
    let normal = normal.normalize() * if normal.dot(delta) < 0.0 { -1.0 } else { 1.0 };
    let slack = 8.0 * search.error(FACE);
    let [in_a, in_b] = match axis {
        Axis::OfA(k) => {
            let point = placed_a.meets(k, &placed_b, normal, slack)?;
            [point + normal * value, point]
        }
        Axis::OfB(k) => {
            let point = placed_b.meets(k, &placed_a, -normal, slack)?;
            [point, point - normal * value]
        }
        Axis::Product(j, k) => {
            crossing([&placed_a, &placed_b], [j, k], normal, slack.max(8.0 * error))?
        }
    };
    let origin = a.pose.translation();
    let (point_a, point_b) =
        (origin + (in_a + normal * radii[0]), origin + (in_b - normal * radii[1]));
    Some(Depth { depth, normal, point_a, point_b, error_bound })
}

/// Whether an axis shows that two are farther apart than a margin, metres; false of other shapes.
pub(crate) fn are_beyond(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    margin: f64,
) -> bool {
    let halves = [half_extents(a.map), half_extents(b.map)];
    let [Some(half_a), Some(half_b)] = halves else { return false };
    let Some((search, _)) = posed([a, b], [half_a, half_b]) else { return false };
    // Three sums lose less.
    let most = -(a.map.swept_radius() + b.map.swept_radius() + margin) * (1.0 + 4.0 * UNIT);
    let least = search.of_faces(Axes::ALL);
    if least.value + least.error < most {
        return true;
    }
    let error = search.error(CROSS);
    for k in 0..3 {
        for j in 0..3 {
            let (value, squared) = search.of_product(j, k);
            if squared >= PARALLEL && (value + error) / squared.sqrt() < most {
                return true;
            }
        }
    }
    false
}

/// The half-extents of a core that is a box round its origin, be it only a segment along z or a point.
fn half_extents(polytope: &Polytope) -> Option<DVec3> {
    match (polytope.kind(), polytope.vertices()) {
        (Kind::Cuboid { half_extents }, _) => Some(half_extents),
        (Kind::Point, &[only]) if only == DVec3::ZERO => Some(DVec3::ZERO),
        (Kind::Segment, &[p, q]) if p == -q && p.truncate() == DVec2::ZERO => {
            Some(DVec3::Z * p.z.abs())
        }
        _ => None,
    }
}

/// Two boxes at their places; `None` out of range.
#[inline(always)]
pub(super) fn posed(
    [a, b]: [PosedSupport<'_, Polytope>; 2],
    [half_a, half_b]: [DVec3; 2],
) -> Option<(OverlapSearch, [Placed; 2])> {
    let delta = b.pose.translation() - a.pose.translation();
    let size = delta.norm1() + half_a.element_sum() + half_b.element_sum();
    let deviations = [a.pose.deviation(), b.pose.deviation()];
    let radius = a.map.swept_radius() + b.map.swept_radius();
    // False for NaN.
    let is_in_range = SIZES.contains(&size) && radius < SIZES.end;
    if !(is_in_range && deviations[0].max(deviations[1]) <= DEVIATION) {
        return None;
    }
    let (turn_a, turn_b) = (a.pose.rotation(), b.pose.rotation());
    let placed_a = Placed { half: half_a, axes: columns(turn_a), centre: DVec3::ZERO };
    let placed_b = Placed { half: half_b, axes: columns(turn_b), centre: delta };
    let search = OverlapSearch {
        half_a: half_a.to_array(),
        half_b: half_b.to_array(),
        along_a: (turn_a.transpose() * delta).to_array(),
        along_b: (turn_b.transpose() * delta).to_array(),
        cosines: (turn_a.transpose() * *turn_b).to_cols_array_2d(),
        size,
        spread: deviations[0] + deviations[1],
    };
    Some((search, [placed_a, placed_b]))
}

fn columns(m: &DMat3) -> [DVec3; 3] {
    [m.x_axis, m.y_axis, m.z_axis]
}

/// The overlaps along the axes.
pub(super) struct OverlapSearch {
    half_a: [f64; 3],
    half_b: [f64; 3],
    /// From a's centre to b's along the axes of each.
    along_a: [f64; 3],
    along_b: [f64; 3],
    /// `cosines[k][j]` is that of axis j of a and axis k of b.
    cosines: [[f64; 3]; 3],
    size: f64,
    /// The sum of the poses' deviations.
    spread: f64,
}

impl OverlapSearch {
    fn error(&self, [of_unit, of_spread]: [f64; 2]) -> f64 {
        (of_unit * UNIT + of_spread * self.spread) * self.size
    }

    /// `None` where an axis of a box does not surely overlap.
    fn least(&self, axes: Axes) -> Option<Least> {
        let least = self.of_faces(axes);
        // False for NaN.
        if least.lower > 0.0 { Some(self.of_products(least, axes)) } else { None }
    }

    #[inline(always)]
    fn of_faces(&self, axes: Axes) -> Least {
        let Self { half_a, half_b, along_a, along_b, cosines: c, .. } = self;
        let mut least =
            Least { axis: Axis::OfA(0), value: f64::INFINITY, error: self.error(FACE), lower: 0.0 };
        let mut offer = |value: f64, axis, number| {
            if axes.has(number) && value < least.value {
                (least.value, least.axis) = (value, axis);
            }
        };
        for k in 0..3 {
            let reach =
                half_b[0] * c[0][k].abs() + half_b[1] * c[1][k].abs() + half_b[2] * c[2][k].abs();
            offer((half_a[k] + reach) - along_a[k].abs(), Axis::OfA(k), k);
        }
        for k in 0..3 {
            let reach =
                half_a[0] * c[k][0].abs() + half_a[1] * c[k][1].abs() + half_a[2] * c[k][2].abs();
            offer((half_b[k] + reach) - along_b[k].abs(), Axis::OfB(k), 3 + k);
        }
        Least { lower: least.value - least.error, ..least }
    }

    /// The axis of the least overlap, or of the widest gap, and that overlap; products of nearly parallel edges left
    /// out. Proves nothing.
    pub(super) fn widest(&self) -> (Axis, f64) {
        let Least { mut axis, mut value, .. } = self.of_faces(Axes::ALL);
        for k in 0..3 {
            for j in 0..3 {
                let (along, squared) = self.of_product(j, k);
                let along = along / squared.sqrt();
                if squared >= PARALLEL && along < value {
                    (axis, value) = (Axis::Product(j, k), along);
                }
            }
        }
        (axis, value)
    }

    /// The overlap along the product of axis `j` of a and axis `k` of b, times its length; the length squared.
    #[inline(always)]
    fn of_product(&self, j: usize, k: usize) -> (f64, f64) {
        let Self { half_a, half_b, along_a, cosines: c, .. } = self;
        let (next, last) = ((k + 1) % 3, (k + 2) % 3);
        let (p, q) = ((j + 1) % 3, (j + 2) % 3);
        let between = (along_a[q] * c[k][p] - along_a[p] * c[k][q]).abs();
        let reach_a = half_a[p] * c[k][q].abs() + half_a[q] * c[k][p].abs();
        let reach_b = half_b[next] * c[last][j].abs() + half_b[last] * c[next][j].abs();
        ((reach_a + reach_b) - between, c[k][p] * c[k][p] + c[k][q] * c[k][q])
    }

    fn of_products(&self, least: Least, axes: Axes) -> Least {
        if axes.0 >> 6 == 0 {
            return least;
        }
        let error = self.error(CROSS);
        let mut products =
            Products { search: self, axes, error, least, short: [[0.0; 3]; 9], count: 0 };
        // One by one: with the axes known the compiler leaves no index to compute.
        products.look_at(0, 0);
        products.look_at(1, 0);
        products.look_at(2, 0);
        products.look_at(0, 1);
        products.look_at(1, 1);
        products.look_at(2, 1);
        products.look_at(0, 2);
        products.look_at(1, 2);
        products.look_at(2, 2);
        products.with_short()
    }
}

/// The least overlap of the products looked at so far.
struct Products<'a> {
    search: &'a OverlapSearch,
    axes: Axes,
    error: f64,
    least: Least,
    /// Products too short to be the least: a lower bound, a length, and the shorter of the two half edges.
    short: [[f64; 3]; 9],
    count: usize,
}

impl Products<'_> {
    /// The product of axis `j` of a and axis `k` of b.
    #[inline(always)]
    fn look_at(&mut self, j: usize, k: usize) {
        let Self { search, axes, error, least, .. } = self;
        if !axes.has(6 + 3 * j + k) {
            return;
        }
        let (value, squared) = search.of_product(j, k);
        let surely = value - *error;
        // Not less than another: a root and a quotient saved.
        if surely > 0.0 && surely * surely >= least.value * least.value * squared {
            return;
        }
        let length = squared.sqrt();
        if squared < PARALLEL {
            let half = search.half_a[j].min(search.half_b[k]);
            self.short[self.count] = [surely / length, length, half];
            self.count += 1;
            return;
        }
        let (value, error) = (value / length, *error / length);
        least.lower = least.lower.min(value - error);
        // An axis of a box where rounding leaves both possible.
        if value + error < least.value {
            (least.axis, least.value, least.error) = (Axis::Product(j, k), value, error);
        }
    }

    /// Of nearly parallel edges j, k: without the part of edge k that is square to edge j, the other axes in the
    /// plane square to it are the least there, and none of these is short.
    fn with_short(self) -> Least {
        let Self { search, mut least, short, count, .. } = self;
        let others = least.lower;
        let slack = search.error(SINE) / search.size;
        for &[surely, length, half] in &short[..count] {
            let as_others = others - (length + slack) * half;
            // A quotient of zeros proves nothing.
            least.lower = least.lower.min(as_others.max(surely));
        }
        least
    }
}

impl Placed {
    /// The point farthest along a direction: all signs of the half edges.
    pub(super) fn farthest(&self, direction: DVec3) -> DVec3 {
        let signed =
            |k: usize| self.half[k] * if self.axes[k].dot(direction) < 0.0 { -1.0 } else { 1.0 };
        self.centre + self.axes[0] * signed(0) + self.axes[1] * signed(1) + self.axes[2] * signed(2)
    }

    /// The deepest point of another box under the face of axis `k` that looks along `outward`; `None` where rounding
    /// puts it beside the face.
    fn meets(&self, k: usize, other: &Self, outward: DVec3, slack: f64) -> Option<DVec3> {
        let sides = [(k + 1) % 3, (k + 2) % 3];
        let place = |point: DVec3| sides.map(|side| self.axes[side].dot(point - self.centre));
        let is_inside = |place: [f64; 2]| {
            (0..2).all(|side| place[side].abs() <= self.half[sides[side]] + slack)
        };
        let corner = other.farthest(-outward);
        if is_inside(place(corner)) {
            return Some(corner);
        }
        // Along edges that are level any point is as deep: the middle of them, then from face to face the nearest.
        let is_level =
            [0, 1, 2].map(|j| (other.axes[j].dot(outward) * other.half[j]).abs() <= slack);
        let level =
            |j: usize, place: f64| if is_level[j] { other.axes[j] * place } else { DVec3::ZERO };
        let from_centre = |j: usize, point: DVec3| other.axes[j].dot(point - other.centre);
        let middle = corner - (0..3).map(|j| level(j, from_centre(j, corner))).sum::<DVec3>();
        let mut point = middle;
        for _ in 0..NEARER {
            let here = place(point);
            if is_inside(here) {
                return Some(point);
            }
            let along = |side: usize| {
                let half = self.half[sides[side]];
                self.axes[sides[side]] * here[side].clamp(-half, half)
            };
            let target = self.centre + along(0) + along(1);
            let nearest = |j: usize| from_centre(j, target).clamp(-other.half[j], other.half[j]);
            point = middle + (0..3).map(|j| level(j, nearest(j))).sum::<DVec3>();
        }
        None
    }
}

/// The nearest points of an edge of each box; `None` where rounding puts one beyond its edge's end.
pub(super) fn crossing(
    [a, b]: [&Placed; 2],
    [j, k]: [usize; 2],
    normal: DVec3,
    slack: f64,
) -> Option<[DVec3; 2]> {
    let without = |side: &Placed, axis: usize, direction: DVec3| {
        let corner = side.farthest(direction);
        let along = side.axes[axis];
        corner - along * along.dot(corner - side.centre)
    };
    let (middle_a, middle_b) = (without(a, j, normal), without(b, k, -normal));
    let (e, f) = (a.axes[j], b.axes[k]);
    let between = middle_b - middle_a;
    let (cosine, along_e, along_f) = (e.dot(f), e.dot(between), f.dot(between));
    let squared = e.cross(f).length_squared();
    let s = (along_e - cosine * along_f) / squared;
    let r = (cosine * along_e - along_f) / squared;
    let is_on = |x: f64, half: f64| x.abs() <= half + slack;
    let are_on = is_on(s, a.half[j]) && is_on(r, b.half[k]);
    are_on.then(|| [middle_a + e * s, middle_b + f * r])
}

#[cfg(test)]
mod tests;
