//! Where two boxes touch: a rectangle clipped by a rectangle, in the frame of the one that clips.
//!
//! The same features and the same corners as those of any polytopes, from signs in place of lists of faces.

use super::CROSSING;
use super::Feature;
use super::clip::Corner;
use super::cuboid_polygon::{Line, Point, Points, features};
use super::facing::{FACING, LEVEL, edge};
use super::feature::View;
use crate::PosedShape;
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Kind, Polytope, Shape};

/// The largest deviation of a pose whose transpose may stand for its inverse: what that loses is far below the
/// manifold's own bound.
const DEVIATION: f64 = 1e-12;

/// The least half edge for a box to have six faces, relative to the largest.
const SOLID: f64 = 1e-6;

/// What two boxes show each other.
pub(super) struct Patch {
    /// What of a is seen, and what of b.
    pub(super) whole: [Feature; 2],
    /// How large the boxes are.
    pub(super) size: f64,
}

/// A box, and the direction in its own frame in which the other is.
#[derive(Clone, Copy)]
struct Side<'a> {
    polytope: &'a Polytope,
    half: [f64; 3],
    rotation: &'a DMat3,
    /// From a's origin, world axes.
    place: DVec3,
    towards: [f64; 3],
}

/// What a box shows: the axis that its face is normal to, that its edge is along, or its farthest corner.
#[derive(Clone, Copy, PartialEq)]
enum Seen {
    Face(usize),
    Edge(usize),
    Vertex,
}

/// What two boxes show each other, and the face that clips if one of them shows a face.
pub(super) struct Clipped<'a> {
    pub(super) patch: Patch,
    /// With the number of the box whose face it is, 0 or 1.
    pub(super) face: Option<(Clipping<'a>, usize)>,
    /// The swept radii.
    pub(super) radii: [f64; 2],
    /// See [`Corner::swept`].
    pub(super) level: [f64; 2],
}

/// Clips what two boxes have in common along a normal; `None` where the general way is needed: for other shapes, flat
/// boxes, and edges that are nearly parallel.
#[inline(always)]
pub(super) fn clipped<'a>(
    points: &mut Points,
    normal: DVec3,
    [a, b]: [PosedShape<'a>; 2],
) -> Option<Clipped<'a>> {
    let delta = b.pose.translation() - a.pose.translation();
    let side_a = Side::of(a, DVec3::ZERO, normal)?;
    let side_b = Side::of(b, delta, -normal)?;
    let (seen_a, seen_b) = (side_a.seen(), side_b.seen());
    let size = 2.0 * (side_a.polytope.outer_radius() + side_b.polytope.outer_radius());
    let whole = [side_a.feature(seen_a)?, side_b.feature(seen_b)?];
    let radii = [side_a.polytope.swept_radius(), side_b.polytope.swept_radius()];
    let level = [side_a.level(seen_a), side_b.level(seen_b)];
    let in_one_point = Clipped { patch: Patch { whole, size }, face: None, radii, level };
    let facing = |side: &Side<'_>, seen| match seen {
        Seen::Face(k) => side.towards[k].abs(),
        _ => 0.0,
    };
    // The face that is more square to the normal clips: its plane is the better known.
    let a_clips = facing(&side_a, seen_a) >= facing(&side_b, seen_b);
    let (k, other, number) = match (seen_a, seen_b) {
        (Seen::Vertex, _) | (_, Seen::Vertex) => return Some(in_one_point),
        (Seen::Edge(j), Seen::Edge(k)) => {
            let (e, f) = (side_a.rotation.col(j), side_b.rotation.col(k));
            return (e.cross(f).length_squared() > CROSSING * CROSSING).then_some(in_one_point);
        }
        (Seen::Face(k), other) if a_clips => (k, other, 0),
        (other, Seen::Face(k)) => (k, other, 1),
        (Seen::Face(k), other) => (k, other, 0),
    };
    let (clips, clipped) = if number == 0 { (side_a, side_b) } else { (side_b, side_a) };
    let clipping = Clipping::new(clips, k, clipped);
    clipping.points(other, points);
    clipping.clip(points, radii[0] + radii[1])?;
    Some(Clipped { face: Some((clipping, number)), ..in_one_point })
}

/// Adds the corners of what two boxes have in common along the view's normal; `None`, and no corner, where the general
/// way is needed.
pub(super) fn add(
    corners: &mut Vec<Corner>,
    points: &mut Points,
    view: &View,
    sides: [PosedShape<'_>; 2],
) -> Option<Patch> {
    let Clipped { patch, face, radii, level } = clipped(points, view.normal(), sides)?;
    let Some((clipping, number)) = face else { return Some(patch) };
    let of_each = [patch.whole[number], patch.whole[1 - number]];
    corners.reserve(points.list().len());
    for point in points.list() {
        let (at, height) = view.of(clipping.in_world(point.at));
        let [of_clips, of_clipped] = features(point.origin, of_each);
        let (heights, features) = match number {
            0 => ([height, height - point.depth], [of_clips, of_clipped]),
            _ => ([height + point.depth, height], [of_clipped, of_clips]),
        };
        corners.push(Corner::new(at, heights, features).swept(radii, level));
    }
    Some(patch)
}

/// What a box shows along a unit direction of its own frame; `None` for other shapes and flat boxes.
pub(super) fn feature(polytope: &Polytope, direction: DVec3) -> Option<Feature> {
    let Kind::Cuboid { half_extents: half } = polytope.kind() else { return None };
    if !is_solid(half) {
        return None;
    }
    let (half, towards) = (half.to_array(), direction.to_array());
    let side = Side { polytope, half, rotation: &DMat3::IDENTITY, place: DVec3::ZERO, towards };
    side.feature(side.seen())
}

/// What a box shows towards a direction of the world, of unit length, and along what that is if it is an edge; `None` where
/// the general way is needed.
#[inline(always)]
pub(super) fn shown(side: PosedShape<'_>, towards: DVec3) -> Option<(Feature, DVec3)> {
    let of_box = Side::of(side, DVec3::ZERO, towards)?;
    let seen = of_box.seen();
    let along = match seen {
        Seen::Edge(k) => of_box.rotation.col(k),
        Seen::Face(_) | Seen::Vertex => DVec3::ZERO,
    };
    Some((of_box.feature(seen)?, along))
}

pub(super) fn is_solid(half: DVec3) -> bool {
    half.min_element() > SOLID * half.max_element()
}

fn columns(m: &DMat3) -> [DVec3; 3] {
    [m.x_axis, m.y_axis, m.z_axis]
}

/// A vector's parts along the columns.
fn along(m: &DMat3, v: DVec3) -> [f64; 3] {
    [m.x_axis.dot(v), m.y_axis.dot(v), m.z_axis.dot(v)]
}

impl<'a> Side<'a> {
    #[inline]
    fn of(side: PosedShape<'a>, place: DVec3, towards: DVec3) -> Option<Self> {
        let Shape::Polytope(polytope) = side.shape else { return None };
        let Kind::Cuboid { half_extents: half } = polytope.kind() else { return None };
        let rotation = side.pose.rotation();
        if !(is_solid(half) && side.pose.deviation() <= DEVIATION) {
            return None;
        }
        let towards = along(rotation, towards);
        Some(Self { polytope, half: half.to_array(), rotation, place, towards })
    }

    fn seen(&self) -> Seen {
        let [x, y, z] = self.towards;
        let along = [x.abs(), y.abs(), z.abs()];
        let (mut most, mut least) = (0, 0);
        for k in 1..3 {
            most = if along[k] > along[most] { k } else { most };
            least = if along[k] < along[least] { k } else { least };
        }
        if along[most] > FACING {
            Seen::Face(most)
        } else if along[least] < LEVEL {
            Seen::Edge(least)
        } else {
            Seen::Vertex
        }
    }

    /// The cosine of the angle by which what is seen leans; 0 for a vertex.
    fn level(&self, seen: Seen) -> f64 {
        match seen {
            Seen::Face(k) => self.towards[k].abs(),
            Seen::Edge(k) => (1.0 - self.towards[k] * self.towards[k]).max(0.0).sqrt(),
            Seen::Vertex => 0.0,
        }
    }

    /// The number of the farthest corner: a bit for each axis.
    fn farthest(&self) -> u32 {
        let bit = |k: usize| u32::from(self.towards[k] >= 0.0) << k;
        bit(0) | bit(1) | bit(2)
    }

    /// `None` for a face that is not one of six.
    fn feature(&self, seen: Seen) -> Option<Feature> {
        let corner = self.farthest();
        Some(match seen {
            Seen::Vertex => Feature::Vertex(corner),
            Seen::Edge(k) => edge(corner & !(1 << k), corner | 1 << k),
            Seen::Face(k) => Feature::Face(self.face(k)?),
        })
    }

    /// The number of the face that is normal to axis `k`: its index into [`dcd_geom::Facets`].
    fn face(&self, k: usize) -> Option<u32> {
        face_number(self.polytope, self.half, k, self.towards[k] > 0.0)
    }

    /// The corner of that number, in its own frame.
    #[inline]
    fn corner(&self, number: u32) -> [f64; 3] {
        let signed = |k: usize| if number >> k & 1 == 1 { self.half[k] } else { -self.half[k] };
        [signed(0), signed(1), signed(2)]
    }
}

/// The number of a box's face along axis `k` or against it: its index into [`dcd_geom::Facets`]. `None` where it is not
/// one of six.
#[inline(always)]
pub(super) fn face_number(
    polytope: &Polytope,
    half: [f64; 3],
    k: usize,
    is_forward: bool,
) -> Option<u32> {
    case_of(half)
        .and_then(|case| number_in(case, k, is_forward))
        .or_else(|| listed_number(polytope, k, is_forward))
}

/// The same where it is known how the half edges compare: see [`case_of`]. `None` of a larger number.
#[inline(always)]
pub(super) fn number_in(case: u32, k: usize, is_forward: bool) -> Option<u32> {
    let numbers = NUMBERS.get(case as usize)?;
    Some(numbers[(2 * k + usize::from(is_forward)) % 8].into())
}

/// The same from the list of the faces.
#[cold]
fn listed_number(polytope: &Polytope, k: usize, is_forward: bool) -> Option<u32> {
    let facets = polytope.facets().facets();
    let sense = if is_forward { 1.0 } else { -1.0 };
    let found = (0u32..).zip(facets).find(|(_, facet)| facet.normal[k] * sense > FACING);
    Some(found?.0)
}

/// How far apart, relative to the largest, half edges must be for the order of the faces to be known, if they are not
/// equal; and the least half edge, relative to the largest.
const DISTINCT: [f64; 2] = [1e-6, 1e-3];

/// The largest half edges of boxes whose faces' order is known: squared areas stay clear of under- and overflow.
const SIZES: std::ops::Range<f64> = 1e-60..1e60;

/// How the half edges of a box compare, as the digits of [`NUMBERS`]: the order of its faces hangs on nothing else, which
/// saves a search for the hull. `None` where rounding could play a part.
#[inline(always)]
pub(crate) fn case_of([x, y, z]: [f64; 3]) -> Option<u32> {
    let larger = |v: f64, w: f64| if v > w { v } else { w };
    let smaller = |v: f64, w: f64| if v < w { v } else { w };
    let (most, least) = (larger(larger(x, y), z), smaller(smaller(x, y), z));
    let [apart, thin] = DISTINCT;
    let is_sure = |v: f64, w: f64| (v == w) | ((v - w).abs() > apart * most);
    // False for NaN.
    let is_known = SIZES.contains(&most) & (least > thin * most);
    if !(is_known & is_sure(x, y) & is_sure(x, z) & is_sure(y, z)) {
        return None;
    }
    let digit = |v: f64, w: f64| 1 + u32::from(v > w) - u32::from(v < w);
    Some(9 * digit(x, y) + 3 * digit(x, z) + digit(y, z))
}

/// The numbers of the faces against the first axis, along it, against the second, and so on; eight of six, so that no index
/// is too large. By how the half edges compare: x with y, x with z, y with z; 0 for less, 1 for equal, 2 for greater, as three
/// digits.
static NUMBERS: [[u8; 8]; 27] = {
    let mut numbers = [[0; 8]; 27];
    let mut case = 0;
    while case < 27 {
        let order = order_of([case / 9, case / 3 % 3, case % 3]);
        let mut number = 0;
        while number < 6 {
            let name = order[number];
            let axis = name.to_ascii_lowercase() - b'x';
            numbers[case][(2 * axis + name.is_ascii_uppercase() as u8) as usize] = number as u8;
            number += 1;
        }
        case += 1;
    }
    numbers
};

/// The order in which [`dcd_geom::Facets`] has the six faces: x is that against the first axis, X that along it. Of numbers that
/// cannot compare so, any.
const fn order_of(compared: [usize; 3]) -> &'static [u8; 6] {
    match compared {
        [0, 0, 0] => b"XxYyzZ",
        [0, 0, 1] => b"xXYzyZ",
        [0, 0, 2] => b"xXzZYy",
        [0, 1, 2] => b"xzXZYy",
        [0, 2, 2] => b"zZxXYy",
        [1, 0, 0] => b"YXyxzZ",
        [1, 1, 1] => b"XyzYxZ",
        [1, 2, 2] => b"zZXyYx",
        [2, 0, 0] => b"YyXxzZ",
        [2, 1, 0] => b"yYXzxZ",
        [2, 2, 0] => b"yYzZXx",
        [2, 2, 1] => b"yzYZXx",
        _ => b"zZyYXx",
    }
}

/// A face that clips what another box shows.
pub(super) struct Clipping<'a> {
    clips: Side<'a>,
    /// The axis that its face is normal to, and those of its sides.
    k: usize,
    sides: [usize; 2],
    clipped: Side<'a>,
    /// Where the face is along its axis.
    plane: f64,
    /// One over the normal's part square to the face.
    steepness: f64,
}

impl<'a> Clipping<'a> {
    fn new(clips: Side<'a>, k: usize, clipped: Side<'a>) -> Self {
        let plane = clips.half[k] * clips.towards[k].signum();
        let steepness = 1.0 / clips.towards[k];
        Self { clips, k, sides: [(k + 1) % 3, (k + 2) % 3], clipped, plane, steepness }
    }

    /// A point of the face from the first box's origin, world axes.
    #[inline]
    pub(super) fn in_world(&self, at: [f64; 2]) -> DVec3 {
        let columns = columns(self.clips.rotation);
        let middle = self.clips.place + columns[self.k] * self.plane;
        middle + (columns[self.sides[0]] * at[0] + columns[self.sides[1]] * at[1])
    }

    /// The normal's parts along the sides and square to the face.
    pub(super) fn normal(&self) -> [f64; 3] {
        let ([p, q], towards) = (self.sides, self.clips.towards);
        [towards[p], towards[q], towards[self.k]]
    }

    /// What is clipped: the corners of a face, or the ends of an edge.
    fn points(&self, seen: Seen, points: &mut Points) {
        let farthest = self.clipped.farthest();
        points.clear();
        let base = self.seen_from_face(self.middle_of(seen, farthest), self.plane);
        let edge = |k: usize| {
            let axis = columns(self.clipped.rotation)[k] * self.clipped.half[k];
            self.seen_from_face(along(self.clips.rotation, axis), 0.0)
        };
        let mut push = |[x, y, depth]: [f64; 3], number: u32, next: u32| {
            let line = Line::Clipped(number as u8, next as u8);
            points.push(Point { at: [x, y], depth, line, origin: [line; 2] });
        };
        let sum = |x: [f64; 3], y: [f64; 3]| [x[0] + y[0], x[1] + y[1], x[2] + y[2]];
        let difference = |x: [f64; 3], y: [f64; 3]| [x[0] - y[0], x[1] - y[1], x[2] - y[2]];
        match seen {
            Seen::Face(k) => {
                let (along_p, along_q) = ((k + 1) % 3, (k + 2) % 3);
                let (p, q) = (1 << along_p, 1 << along_q);
                let number = farthest & !(p | q);
                let (u, v) = (edge(along_p), edge(along_q));
                let (low, high) = (difference(base, u), sum(base, u));
                push(difference(low, v), number, number | p);
                push(difference(high, v), number | p, number | p | q);
                push(sum(high, v), number | p | q, number | q);
                push(sum(low, v), number | q, number);
            }
            Seen::Edge(k) => {
                let (low, high) = (farthest & !(1 << k), farthest | 1 << k);
                let u = edge(k);
                push(difference(base, u), low, high);
                push(sum(base, u), high, low);
            }
            Seen::Vertex => {}
        }
    }

    /// The middle of what is clipped, in the frame of the box that clips.
    #[inline]
    fn middle_of(&self, seen: Seen, farthest: u32) -> [f64; 3] {
        let mut middle = self.clipped.corner(farthest);
        match seen {
            Seen::Face(k) => (middle[(k + 1) % 3], middle[(k + 2) % 3]) = (0.0, 0.0),
            Seen::Edge(k) => middle[k] = 0.0,
            Seen::Vertex => {}
        }
        let [x, y, z] = columns(self.clipped.rotation);
        let between = self.clipped.place - self.clips.place;
        let in_world = x * middle[0] + y * middle[1] + z * middle[2] + between;
        along(self.clips.rotation, in_world)
    }

    /// A point moved along the normal into a plane, along the sides, and how far it was under it; for a plane at 0 the same of a
    /// direction.
    #[inline]
    fn seen_from_face(&self, point: [f64; 3], plane: f64) -> [f64; 3] {
        let (k, [p, q], towards) = (self.k, self.sides, &self.clips.towards);
        let above = (point[k] - plane) * self.steepness;
        [point[p] - above * towards[p], point[q] - above * towards[q], -above]
    }

    /// Cuts off what is beside the face, and what is less deep than the radii allow.
    fn clip(&self, points: &mut Points, radius: f64) -> Option<()> {
        let [p, q] = self.sides;
        let facing = u8::from(self.clips.towards[self.k] >= 0.0) << self.k;
        let (bit_p, bit_q) = (1u8 << p, 1u8 << q);
        let ends = [(bit_p, bit_q), (bit_q, bit_p)];
        for (side, (own, other)) in ends.into_iter().enumerate() {
            let half = self.clips.half[self.sides[side]];
            let line = |base: u8| Line::Clips(base, base | other);
            points.cut(|point| half - point.at[side], line(facing | own))?;
            points.cut(|point| half + point.at[side], line(facing))?;
        }
        points.cut(|point| point.depth + radius, Line::Surface)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Repeatable numbers from 0 to 1.
    pub(in super::super) struct Draw(pub(in super::super) u64);

    impl Draw {
        pub(in super::super) fn unit(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_041);
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        }

        fn below(&mut self, count: usize) -> usize {
            (self.unit() * count as f64) as usize
        }
    }

    /// Half edges that are equal, nearly equal or apart, thin or not, from tiny to huge.
    fn half_edges(draw: &mut Draw) -> [f64; 3] {
        let mut half = [(); 3].map(|()| 0.1 + draw.unit());
        let near = [1.0, 1.0 + 1e-15, 1.0 - 1e-9, 1.0 + 1.1e-6, 1.0 + 1e-4][draw.below(5)];
        let (j, k) = (draw.below(3), draw.below(3));
        match draw.below(4) {
            0 => half[j] = half[k] * near,
            1 => half = [half[0]; 3],
            _ => {}
        }
        half[draw.below(3)] *= [1.0, 1.0, 1e-2, 2e-3, 1e-5][draw.below(5)];
        half[draw.below(3)] *= [1.0, 1.0, 1e-2][draw.below(3)];
        let size = [1.0, 1e-5, 1e6, 1e-59, 1e58][draw.below(5)];
        half.map(|x| x * size)
    }

    #[test]
    fn faces_have_the_numbers_of_the_facets_of_the_hull() {
        let (mut draw, mut known) = (Draw(81), [0; 2]);
        for _ in 0..20_000 {
            let half = half_edges(&mut draw);
            let Some(case) = case_of(half) else {
                known[0] += 1;
                continue;
            };
            known[1] += 1;
            let cuboid = Polytope::cuboid(DVec3::from_array(half)).unwrap();
            let facets = cuboid.facets().facets();
            assert_eq!(facets.len(), 6, "{half:?}");
            for (k, is_forward) in (0..6).map(|k| (k / 2, k % 2 == 1)) {
                let sense = if is_forward { 1.0 } else { -1.0 };
                let number = number_in(case, k, is_forward).unwrap();
                let normal = facets[number as usize].normal;
                assert!(normal[k] * sense > 0.99, "{half:?} {facets:?} {k} {number}");
            }
        }
        assert!(known.into_iter().all(|count| count > 2000), "{known:?}");
    }
}
