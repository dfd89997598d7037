//! Where two boxes touch: a rectangle clipped by a rectangle, in the frame of the one that clips.
//!
//! The same features and the same corners as those of any polytopes, from signs in place of lists of faces.

use super::CROSSING;
use super::Feature;
use super::clip::Corner;
use super::cuboid_faces::face_number;
use super::facing::{FACING, LEVEL, edge};
use super::feature::View;
use super::polygon::{Polygon, PolygonCorner, PolygonLine, features};
use crate::PosedShape;
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Kind, Polytope, Shape};

/// The largest deviation of a pose whose transpose may stand for its inverse: what that loses is far below the
/// manifold's own bound.
const DEVIATION: f64 = 1e-12;

/// The least half edge for a box to have six faces, relative to the largest.
const SOLID: f64 = 1e-6;

/// The most corners that a patch may have: four, and one more for each of five cuts; and spare ones for what rounding adds.
pub(super) const MOST: usize = 12;

/// The patch of two boxes.
pub(super) type CuboidPolygon = Polygon<MOST>;

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
pub(super) enum CuboidFeature {
    Face(usize),
    Edge(usize),
    Vertex,
}

impl CuboidFeature {
    /// What a box shows along a unit direction of its own frame.
    #[inline(always)]
    pub(super) fn towards(direction: [f64; 3]) -> Self {
        let [x, y, z] = direction;
        let along = [x.abs(), y.abs(), z.abs()];
        let (mut most, mut least) = (0, 0);
        for k in 1..3 {
            most = if along[k] > along[most] { k } else { most };
            least = if along[k] < along[least] { k } else { least };
        }
        if along[most] > FACING {
            CuboidFeature::Face(most)
        } else if along[least] < LEVEL {
            CuboidFeature::Edge(least)
        } else {
            CuboidFeature::Vertex
        }
    }

    /// Its name, given the number of the face that is normal to an axis.
    #[inline(always)]
    pub(super) fn feature(
        self,
        towards: [f64; 3],
        face: impl FnOnce(usize) -> Option<u32>,
    ) -> Option<Feature> {
        let corner = farthest(towards);
        Some(match self {
            Self::Vertex => Feature::Vertex(corner),
            Self::Edge(k) => edge(corner & !(1 << k), corner | 1 << k),
            Self::Face(k) => Feature::Face(face(k)?),
        })
    }
}

/// The number of the farthest corner along a direction: a bit for each axis.
#[inline(always)]
fn farthest(direction: [f64; 3]) -> u32 {
    let bit = |k: usize| u32::from(direction[k] >= 0.0) << k;
    bit(0) | bit(1) | bit(2)
}

/// What two boxes show each other, and the face that clips if one of them shows a face.
pub(super) struct Clipped<'a> {
    pub(super) patch: Patch,
    /// With the number of the box whose face it is, 0 or 1.
    pub(super) face: Option<(CuboidClipping<'a>, usize)>,
    /// The swept radii.
    pub(super) radii: [f64; 2],
    /// See [`Corner::swept`].
    pub(super) level: [f64; 2],
}

/// Clips what two boxes have in common along a normal; `None` where the general way is needed: for other shapes, flat
/// boxes, and edges that are nearly parallel.
#[inline(always)]
pub(super) fn clipped<'a>(
    points: &mut CuboidPolygon,
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
        CuboidFeature::Face(k) => side.towards[k].abs(),
        _ => 0.0,
    };
    // The face that is more square to the normal clips: its plane is the better known.
    let a_clips = facing(&side_a, seen_a) >= facing(&side_b, seen_b);
    let (k, other, number) = match (seen_a, seen_b) {
        (CuboidFeature::Vertex, _) | (_, CuboidFeature::Vertex) => return Some(in_one_point),
        (CuboidFeature::Edge(j), CuboidFeature::Edge(k)) => {
            let (e, f) = (side_a.rotation.col(j), side_b.rotation.col(k));
            return (e.cross(f).length_squared() > CROSSING * CROSSING).then_some(in_one_point);
        }
        (CuboidFeature::Face(k), other) if a_clips => (k, other, 0),
        (other, CuboidFeature::Face(k)) => (k, other, 1),
        (CuboidFeature::Face(k), other) => (k, other, 0),
    };
    let (clips, clipped) = if number == 0 { (side_a, side_b) } else { (side_b, side_a) };
    let clipping = CuboidClipping::new(clips, k, clipped);
    clipping.points(other, points);
    clipping.clip(points, radii[0] + radii[1])?;
    Some(Clipped { face: Some((clipping, number)), ..in_one_point })
}

/// Adds the corners of what two boxes have in common along the view's normal; `None`, and no corner, where the general
/// way is needed.
pub(super) fn add(
    corners: &mut Vec<Corner>,
    points: &mut CuboidPolygon,
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
        CuboidFeature::Edge(k) => of_box.rotation.col(k),
        CuboidFeature::Face(_) | CuboidFeature::Vertex => DVec3::ZERO,
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

    #[inline(always)]
    fn seen(&self) -> CuboidFeature {
        CuboidFeature::towards(self.towards)
    }

    /// The cosine of the angle by which what is seen leans; 0 for a vertex.
    fn level(&self, seen: CuboidFeature) -> f64 {
        match seen {
            CuboidFeature::Face(k) => self.towards[k].abs(),
            CuboidFeature::Edge(k) => (1.0 - self.towards[k] * self.towards[k]).max(0.0).sqrt(),
            CuboidFeature::Vertex => 0.0,
        }
    }

    /// `None` for a face that is not one of six.
    fn feature(&self, seen: CuboidFeature) -> Option<Feature> {
        seen.feature(self.towards, |k| self.face(k))
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

/// A face that clips what another box shows.
pub(super) struct CuboidClipping<'a> {
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

impl<'a> CuboidClipping<'a> {
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
    fn points(&self, seen: CuboidFeature, points: &mut CuboidPolygon) {
        let farthest = farthest(self.clipped.towards);
        points.clear();
        let base = self.seen_from_face(self.middle_of(seen, farthest), self.plane);
        let edge = |k: usize| {
            let axis = columns(self.clipped.rotation)[k] * self.clipped.half[k];
            self.seen_from_face(along(self.clips.rotation, axis), 0.0)
        };
        let mut push = |[x, y, depth]: [f64; 3], number: u32, next: u32| {
            let line = PolygonLine::Clipped(number as u8, next as u8);
            points.push(PolygonCorner { at: [x, y], depth, line, origin: [line; 2] });
        };
        let sum = |x: [f64; 3], y: [f64; 3]| [x[0] + y[0], x[1] + y[1], x[2] + y[2]];
        let difference = |x: [f64; 3], y: [f64; 3]| [x[0] - y[0], x[1] - y[1], x[2] - y[2]];
        match seen {
            CuboidFeature::Face(k) => {
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
            CuboidFeature::Edge(k) => {
                let (low, high) = (farthest & !(1 << k), farthest | 1 << k);
                let u = edge(k);
                push(difference(base, u), low, high);
                push(sum(base, u), high, low);
            }
            CuboidFeature::Vertex => {}
        }
    }

    /// The middle of what is clipped, in the frame of the box that clips.
    #[inline]
    fn middle_of(&self, seen: CuboidFeature, farthest: u32) -> [f64; 3] {
        let mut middle = self.clipped.corner(farthest);
        match seen {
            CuboidFeature::Face(k) => (middle[(k + 1) % 3], middle[(k + 2) % 3]) = (0.0, 0.0),
            CuboidFeature::Edge(k) => middle[k] = 0.0,
            CuboidFeature::Vertex => {}
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
    fn clip(&self, points: &mut CuboidPolygon, radius: f64) -> Option<()> {
        let [p, q] = self.sides;
        let facing = u8::from(self.clips.towards[self.k] >= 0.0) << self.k;
        let (bit_p, bit_q) = (1u8 << p, 1u8 << q);
        let ends = [(bit_p, bit_q), (bit_q, bit_p)];
        for (side, (own, other)) in ends.into_iter().enumerate() {
            let half = self.clips.half[self.sides[side]];
            let line = |base: u8| PolygonLine::Clips(base, base | other);
            points.cut(|point| half - point.at[side], line(facing | own))?;
            points.cut(|point| half + point.at[side], line(facing))?;
        }
        points.cut(|point| point.depth + radius, PolygonLine::Surface)
    }
}
