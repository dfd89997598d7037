//! Where two boxes touch: a rectangle clipped by a rectangle, in the frame of the one that clips.
//!
//! The same features and the same corners as those of any polytopes, from signs in place of lists of faces.

use super::Feature;
use super::clip::Corner;
use super::feature::{FACING, LEVEL, View, edge};
use crate::PosedShape;
use dcd_geom::glam::{DMat3, DVec2, DVec3};
use dcd_geom::{Kind, Polytope, Shape};

/// The largest deviation of a pose whose transpose may stand for its inverse: what that loses is far below the
/// manifold's own bound.
const DEVIATION: f64 = 1e-12;

/// The least half edge for a box to have six faces, relative to the largest.
const SOLID: f64 = 1e-6;

/// The sine above which two edges surely cross.
const CROSSING: f64 = 1e-6;

/// The most corners that a patch may have: four, and one more for each of five cuts; and room for what rounding adds.
const MOST: usize = 12;

/// What two boxes have in common.
pub(super) struct Patch {
    corners: [Corner; MOST],
    count: usize,
    /// What of a is seen, and what of b.
    pub(super) whole: [Feature; 2],
    /// How large the boxes are.
    pub(super) size: f64,
}

impl Patch {
    pub(super) fn corners(&self) -> &[Corner] {
        &self.corners[..self.count]
    }
}

/// A box, and the direction in its own frame in which the other is.
#[derive(Clone, Copy)]
struct Side<'a> {
    polytope: &'a Polytope,
    half: DVec3,
    rotation: &'a DMat3,
    /// From a's origin, world axes.
    place: DVec3,
    towards: DVec3,
}

/// What a box shows: the axis that its face is normal to, that its edge is along, or its farthest corner.
#[derive(Clone, Copy, PartialEq)]
enum Seen {
    Face(usize),
    Edge(usize),
    Vertex,
}

/// What the edge of a patch is a part of.
#[derive(Clone, Copy, Default)]
enum Line {
    /// The edge of the clipped box between two of its vertices.
    Clipped(u32, u32),
    /// That of the box that clips.
    Clips(u32, u32),
    /// Where the depth is 0.
    #[default]
    Surface,
}

/// A corner of the patch, in the frame of the box that clips.
#[derive(Clone, Copy, Default)]
struct Point {
    /// On the face, along its two sides.
    at: [f64; 2],
    /// How far the clipped box reaches under the face, along the normal.
    depth: f64,
    /// What the edge to the next corner is a part of.
    line: Line,
    features: [Feature; 2],
}

/// What two boxes have in common along the view's normal; `None` where the general way is needed: for other shapes,
/// flat boxes, and edges that are nearly parallel.
pub(super) fn patch(view: &View, normal: DVec3, [a, b]: [PosedShape<'_>; 2]) -> Option<Patch> {
    let delta = b.pose.translation() - a.pose.translation();
    let side_a = Side::of(a, DVec3::ZERO, normal)?;
    let side_b = Side::of(b, delta, -normal)?;
    let (seen_a, seen_b) = (side_a.seen(), side_b.seen());
    let size = 2.0 * (side_a.polytope.outer_radius() + side_b.polytope.outer_radius());
    let whole = [side_a.feature(seen_a)?, side_b.feature(seen_b)?];
    let mut patch =
        Patch { corners: [Corner::new(DVec2::ZERO, [0.0; 2], whole); MOST], count: 0, whole, size };
    let facing = |side: &Side<'_>, seen| match seen {
        Seen::Face(k) => side.towards[k].abs(),
        _ => 0.0,
    };
    // The face that is more square to the normal clips: its plane is the better known.
    let a_clips = facing(&side_a, seen_a) >= facing(&side_b, seen_b);
    let ((clips, k), (clipped, other), number) = match (seen_a, seen_b) {
        (Seen::Vertex, _) | (_, Seen::Vertex) => return Some(patch),
        (Seen::Edge(j), Seen::Edge(k)) => {
            let (e, f) = (side_a.rotation.col(j), side_b.rotation.col(k));
            return (e.cross(f).length_squared() > CROSSING * CROSSING).then_some(patch);
        }
        (Seen::Face(k), other) if a_clips => ((side_a, k), (side_b, other), 0),
        (other, Seen::Face(k)) => ((side_b, k), (side_a, other), 1),
        (Seen::Face(k), other) => ((side_a, k), (side_b, other), 0),
    };
    let clipping = Clipping { clips, k, clipped, whole: [whole[number], whole[1 - number]] };
    let mut points = clipping.points(other);
    clipping.clip(&mut points)?;
    let radius = side_a.polytope.swept_radius() + side_b.polytope.swept_radius();
    points.cut(|point| point.depth + radius, Line::Surface, &clipping)?;
    let radii = [side_a.polytope.swept_radius(), side_b.polytope.swept_radius()];
    for point in points.list() {
        let in_world = clips.place + *clips.rotation * clipping.on_face(point.at);
        let (at, height) = view.of(in_world);
        let (heights, features) = match number {
            0 => ([height, height - point.depth], point.features),
            _ => ([height + point.depth, height], [point.features[1], point.features[0]]),
        };
        patch.corners[patch.count] = Corner::new(at, heights, features).swept(radii);
        patch.count += 1;
    }
    Some(patch)
}

impl<'a> Side<'a> {
    fn of(side: PosedShape<'a>, place: DVec3, towards: DVec3) -> Option<Self> {
        let Shape::Polytope(polytope) = side.shape else { return None };
        let Kind::Cuboid { half_extents: half } = polytope.kind() else { return None };
        let rotation = side.pose.rotation();
        let is_solid = half.min_element() > SOLID * half.max_element();
        let towards = rotation.transpose() * towards;
        (is_solid && side.pose.deviation() <= DEVIATION).then_some(Self {
            polytope,
            half,
            rotation,
            place,
            towards,
        })
    }

    fn seen(&self) -> Seen {
        let along = self.towards.abs().to_array();
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
            Seen::Face(k) => {
                let facets = self.polytope.facets().facets();
                let sense = self.towards[k].signum();
                let found =
                    (0u32..).zip(facets).find(|(_, facet)| facet.normal[k] * sense > FACING);
                Feature::Face(found?.0)
            }
        })
    }

    /// The corner of that number, in its own frame.
    fn corner(&self, number: u32) -> DVec3 {
        let signed = |k: usize| if number >> k & 1 == 1 { self.half[k] } else { -self.half[k] };
        DVec3::new(signed(0), signed(1), signed(2))
    }
}

/// A face that clips what another box shows.
struct Clipping<'a> {
    clips: Side<'a>,
    /// The axis that its face is normal to.
    k: usize,
    clipped: Side<'a>,
    /// What is seen of the one that clips, and of the other.
    whole: [Feature; 2],
}

impl Clipping<'_> {
    fn sides(&self) -> [usize; 2] {
        [(self.k + 1) % 3, (self.k + 2) % 3]
    }

    /// A point of the face, in its box's frame.
    fn on_face(&self, at: [f64; 2]) -> DVec3 {
        let [p, q] = self.sides();
        let mut point = DVec3::ZERO;
        point[self.k] = self.clips.half[self.k] * self.clips.towards[self.k].signum();
        (point[p], point[q]) = (at[0], at[1]);
        point
    }

    /// What is clipped: the corners of a face, or the ends of an edge.
    fn points(&self, seen: Seen) -> Points {
        let farthest = self.clipped.farthest();
        let mut points = Points::default();
        let mut add = |number: u32, next: u32| {
            let _ = points.push(self.seen_from_face(number, next));
        };
        match seen {
            Seen::Face(k) => {
                let (p, q) = (1 << ((k + 1) % 3), 1 << ((k + 2) % 3));
                let base = farthest & !(p | q);
                let round = [base, base | p, base | p | q, base | q];
                for corner in 0..4 {
                    add(round[corner], round[(corner + 1) % 4]);
                }
            }
            Seen::Edge(k) => {
                let (low, high) = (farthest & !(1 << k), farthest | 1 << k);
                add(low, high);
                add(high, low);
            }
            Seen::Vertex => {}
        }
        points
    }

    /// A corner of the clipped box, moved along the normal into the face's plane.
    fn seen_from_face(&self, number: u32, next: u32) -> Point {
        let Self { clips, clipped, k, .. } = self;
        let in_world = *clipped.rotation * clipped.corner(number) + (clipped.place - clips.place);
        let point = clips.rotation.transpose() * in_world;
        let plane = clips.half[*k] * clips.towards[*k].signum();
        let above = (point[*k] - plane) / clips.towards[*k];
        let [p, q] = self.sides();
        let at = [p, q].map(|side| point[side] - above * clips.towards[side]);
        let features = [self.whole[0], Feature::Vertex(number)];
        Point { at, depth: -above, line: Line::Clipped(number, next), features }
    }

    /// Cuts off what is beside the face.
    fn clip(&self, points: &mut Points) -> Option<()> {
        let [p, q] = self.sides();
        let facing = u32::from(self.clips.towards[self.k] >= 0.0) << self.k;
        let (bit_p, bit_q) = (1u32 << p, 1u32 << q);
        let ends = [(bit_p, bit_q), (bit_q, bit_p)];
        for (side, (own, other)) in ends.into_iter().enumerate() {
            let half = self.clips.half[[p, q][side]];
            let line = |base: u32| Line::Clips(base, base | other);
            points.cut(|point| half - point.at[side], line(facing | own), self)?;
            points.cut(|point| half + point.at[side], line(facing), self)?;
        }
        Some(())
    }

    /// What a corner belongs to where an edge of the patch is cut by a line: of the one that clips, and of the other.
    fn features(&self, of_edge: Line, by: Line) -> [Feature; 2] {
        let [of_clips, of_clipped] = self.whole;
        match (of_edge, by) {
            (Line::Clipped(j, k), Line::Clips(l, m)) => [edge(l, m), edge(j, k)],
            (Line::Clipped(j, k), _) => [of_clips, edge(j, k)],
            (Line::Clips(l, m), Line::Clips(n, o)) => {
                let shared = [l, m].into_iter().find(|k| [n, o].contains(k));
                [shared.map_or(edge(n, o), Feature::Vertex), of_clipped]
            }
            (Line::Clips(l, m), _) | (Line::Surface, Line::Clips(l, m)) => [edge(l, m), of_clipped],
            (Line::Surface, _) => self.whole,
        }
    }
}

/// The corners of a patch, in order round it, and room for them after the next cut.
#[derive(Default)]
struct Points {
    rounds: [[Point; MOST]; 2],
    /// Which of the two holds them.
    now: usize,
    count: usize,
}

impl Points {
    fn list(&self) -> &[Point] {
        &self.rounds[self.now][..self.count]
    }

    /// `None` where there is no room: only what rounding has spoilt has so many corners.
    fn push(&mut self, point: Point) -> Option<()> {
        *self.rounds[self.now].get_mut(self.count)? = point;
        self.count += 1;
        Some(())
    }

    /// Keeps where a function that is linear over the patch is at least 0 (Sutherland and Hodgman 1974).
    #[inline(always)]
    fn cut(
        &mut self,
        value: impl Fn(&Point) -> f64,
        line: Line,
        clipping: &Clipping<'_>,
    ) -> Option<()> {
        let mut values = [0.0; MOST];
        let mut are_inside = true;
        for (value_of, point) in values.iter_mut().zip(self.list()) {
            *value_of = value(point);
            are_inside &= *value_of >= 0.0;
        }
        if are_inside {
            return Some(());
        }
        let [first, second] = &mut self.rounds;
        let (points, next) = if self.now == 0 { (first, second) } else { (second, first) };
        let mut kept = 0;
        for k in 0..self.count {
            let after = if k + 1 == self.count { 0 } else { k + 1 };
            let (from, to) = (&points[k], &points[after]);
            let (here, there) = (values[k], values[after]);
            if here >= 0.0 {
                *next.get_mut(kept)? = *from;
                kept += 1;
            }
            if (here >= 0.0) != (there >= 0.0) {
                let share = here / (here - there);
                let between = |x: f64, y: f64| x + (y - x) * share;
                *next.get_mut(kept)? = Point {
                    at: [between(from.at[0], to.at[0]), between(from.at[1], to.at[1])],
                    depth: between(from.depth, to.depth),
                    line: if here >= 0.0 { line } else { from.line },
                    features: clipping.features(from.line, line),
                };
                kept += 1;
            }
        }
        (self.now, self.count) = (1 - self.now, kept);
        Some(())
    }
}
