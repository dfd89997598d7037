//! The expanding polytope of one pair in f32, support by support: many pairs are searched side by side.

use super::super::bounds::U;
use super::points::Points;
use super::start::Extremes;
use super::surface::{Point, Surface};
use super::vectors::{farthest, splat, vertex};
use crate::Accuracy;
use dcd_geom::glam::Vec3;
use dcd_simd::Lanes;
use std::array;

/// How far from flat the first tetrahedron must be, relative to the pair's size: 2⁻¹². Smaller: slivers whose planes
/// f32 does not know. Larger: more thin pairs for the search in f64. Never an answer.
const FAT: f32 = 1.0 / 4096.0;

/// A support that is farther than the nearest face by no more than this is nothing new, and what a point is beyond
/// by no more it does not see. Unit: u·m. Decides how many supports are evaluated, never an answer.
const GAIN: f32 = 8.0;

/// The same where f32's bounds are good enough: a third of what these come to. Larger: wider bounds. Smaller: more
/// supports.
const GAIN_F32: f32 = 24.0;

/// How much nearer than computed the surface of the true vertices may be. Unit: u·m. 8 for each coordinate of a point
/// of A − B (`CORNER`), √3 of that; 3.1 for the products with the normal; and a margin. The normal's own length loses
/// [`LENGTH`]. Smaller: a bound that is none.
pub(super) const OFF: f64 = 24.0;

/// How much farther than computed A − B may reach along a direction. Unit: u·m. As for a separation (`SEPARATION`), √3
/// of it; and a margin. Smaller: a bound that is none.
pub(super) const REACH: f64 = 32.0;

/// What the length of a normal loses, relative. Unit: 1.
pub(super) const LENGTH: f64 = 1.0 - 16.0 * U as f64;

/// The opposite of each of the directions of [`Extremes`].
const OPPOSITE: [usize; 6] = [3, 4, 5, 0, 1, 2];

/// A − B of a pair as f32 has it, in the lengths of its difference: below 1 or not much above.
#[derive(Clone, Copy)]
pub(super) struct Cloud<'a> {
    /// The points of a and of b, turned into the world's axes, round their centres: metres.
    pub(super) points: [Points<'a>; 2],
    /// The difference's lengths by metres: a power of two.
    pub(super) scale: f32,
    /// The difference of the two centres.
    pub(super) middle: Vec3,
    /// u·m: what every bound is a multiple of.
    pub(super) unit: f32,
}

impl Cloud<'_> {
    /// Whether one of the two is a cylinder or cone.
    #[inline(always)]
    pub(super) fn is_round(&self) -> bool {
        self.points.iter().any(|points| matches!(points, Points::Rims(..)))
    }

    /// The point farthest along a direction, up to rounding.
    #[inline(always)]
    fn farthest<L: Lanes>(&self, l: L, direction: Vec3) -> Point {
        if let [Points::Vertices(of_a), Points::Vertices(of_b)] = &self.points {
            // Most pairs are of polytopes: asked of both at once, it takes 0.98 of the instructions.
            let a = farthest(l, of_a, &splat(l, direction));
            let b = farthest(l, of_b, &splat(l, -direction));
            return self.between((vertex(of_a, a), a as u32), (vertex(of_b, b), b as u32));
        }
        let [of_a, of_b] = &self.points;
        self.between(of_a.farthest(l, direction), of_b.farthest(l, -direction))
    }

    /// The point of these two, each with its number.
    #[inline(always)]
    fn between(&self, (a, of_a): (Vec3, u32), (b, of_b): (Vec3, u32)) -> Point {
        Point { at: (a - b) * self.scale + self.middle, numbers: [of_a, of_b] }
    }
}

/// What a search waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// The support towards the origin.
    First,
    /// The one beyond the origin.
    Second,
    /// One off the line through both, the second time on the other side.
    Third { again: bool },
    /// One off the plane through the three, the second time on the other side.
    Fourth { again: bool },
    /// One beyond the nearest face, of that number.
    Beyond(usize),
}

/// How a search goes on.
#[derive(Clone, Copy, Debug)]
pub(super) enum Next {
    /// It needs another support.
    Support,
    /// The face of that number is the nearest, and A − B reaches so far along its normal.
    Ended { nearest: usize, reach: f32 },
    /// f32 finds no end.
    Failed,
}

/// The search of one pair.
#[derive(Clone, Debug)]
pub(super) struct DepthSearch {
    stage: Stage,
    direction: Vec3,
    start: [Point; 4],
    clear: f32,
}

impl DepthSearch {
    pub(super) fn new(cloud: &Cloud<'_>, accuracy: Accuracy) -> Self {
        let gain = if accuracy == Accuracy::F32 { GAIN_F32 } else { GAIN };
        let direction = if cloud.middle == Vec3::ZERO { Vec3::X } else { -cloud.middle };
        let start = [Point::default(); 4];
        Self { stage: Stage::First, direction, start, clear: gain * cloud.unit }
    }

    /// Starts with the vertices farthest along the world's axes where they make a convex surface: four supports and more
    /// are left out.
    #[inline(always)]
    pub(super) fn start<L: Lanes>(
        &mut self,
        l: L,
        cloud: &Cloud<'_>,
        extremes: [&Extremes; 2],
        surface: &mut Surface,
    ) {
        let [a, b] = extremes;
        // What is farthest along a direction is so of a, and of b the other way.
        let middle = cloud.middle.extend(0.0);
        let corners =
            array::from_fn(|k| (a.points[k] - b.points[OPPOSITE[k]]) * cloud.scale + middle);
        if surface.start_round(l, &corners, self.clear).is_some() {
            let numbers = array::from_fn(|k| [a.numbers[k], b.numbers[OPPOSITE[k]]]);
            surface.set_numbers(numbers);
            self.look_beyond(surface, surface.nearest(l));
        }
    }

    /// Starts with a tetrahedron, of a triangle of points of A − B and what is farthest from it on the origin's side; false where
    /// that is flat. The triangle may be any.
    #[inline(always)]
    pub(super) fn start_proposed<L: Lanes>(
        &mut self,
        l: L,
        cloud: &Cloud<'_>,
        triangle: [[u32; 2]; 3],
        surface: &mut Surface,
    ) -> bool {
        let [of_a, of_b] = &cloud.points;
        let [p, mut q, mut r] =
            triangle.map(|[a, b]| cloud.between(of_a.of_vertex(a), of_b.of_vertex(b)));
        let mut inward = (q.at - p.at).cross(r.at - p.at);
        if inward.dot(p.at) > 0.0 {
            (q, r) = (r, q);
            inward = -inward;
        }
        let apex = cloud.farthest(l, inward);
        let height = inward.dot(apex.at - p.at);
        if !(height > FAT * inward.length()) || surface.start(l, [p, q, r, apex]).is_none() {
            return false;
        }
        self.look_beyond(surface, surface.nearest(l));
        true
    }

    /// The next support is the one beyond the nearest face.
    #[inline(always)]
    fn look_beyond(&mut self, surface: &Surface, nearest: usize) {
        self.stage = Stage::Beyond(nearest);
        self.direction = surface.normal(nearest);
    }

    /// The support that it waits for.
    #[inline(always)]
    pub(super) fn support<L: Lanes>(&self, l: L, cloud: &Cloud<'_>) -> Point {
        cloud.farthest(l, self.direction)
    }

    /// Takes that support.
    #[inline(always)]
    pub(super) fn take<L: Lanes>(&mut self, l: L, point: Point, surface: &mut Surface) -> Next {
        if let Stage::Beyond(face) = self.stage {
            let (normal, distance) = (self.direction, surface.distance(face));
            let reach = normal.dot(point.at);
            // As the surface sees its faces. Written so that NaN ends the search.
            if !(distance + self.clear < reach) {
                let is_end = reach.is_finite() && reach > 0.0;
                return if is_end { Next::Ended { nearest: face, reach } } else { Next::Failed };
            }
            // All of A − B is on the far side: the cores do not overlap, as far as f32 knows.
            if reach < 0.0 {
                return Next::Failed;
            }
            let Some(nearest) = surface.insert(l, point, self.clear) else {
                return Next::Failed;
            };
            self.look_beyond(surface, nearest);
            return Next::Support;
        } else {
            match self.begin(point) {
                Some(true) => {}
                Some(false) => return Next::Support,
                None => return Next::Failed,
            }
            if surface.start(l, self.start).is_none() {
                return Next::Failed;
            }
        }
        self.look_beyond(surface, surface.nearest(l));
        Next::Support
    }

    /// Takes one of the first four points, which are far from one plane, each a support towards the origin. Whether all
    /// are there; `None` where they are too flat.
    #[inline(always)]
    fn begin(&mut self, point: Point) -> Option<bool> {
        let [p0, p1, p2] = [self.start[0].at, self.start[1].at, self.start[2].at];
        let p = point.at;
        let retry = |again: bool| (!again).then_some(-self.direction);
        (self.stage, self.direction) = match self.stage {
            Stage::First => {
                self.start[0] = point;
                let back = if p == Vec3::ZERO { -self.direction } else { -p };
                (Stage::Second, back)
            }
            Stage::Second => {
                self.start[1] = point;
                let edge = p - p0;
                if !(edge.length_squared() > FAT * FAT) {
                    return None;
                }
                let off_line = edge.cross(p0).cross(edge);
                let square = FAT * edge.length_squared();
                let is_off = off_line.length_squared() > square * square;
                let square = if is_off { -off_line } else { edge.any_orthogonal_vector() };
                (Stage::Third { again: false }, square)
            }
            Stage::Third { again } => {
                self.start[2] = point;
                let edge = p1 - p0;
                let normal = edge.cross(p - p0);
                if normal.length_squared() > FAT * FAT * edge.length_squared() {
                    let inward = if normal.dot(p0) > 0.0 { -normal } else { normal };
                    (Stage::Fourth { again: false }, inward)
                } else {
                    (Stage::Third { again: true }, retry(again)?)
                }
            }
            Stage::Fourth { again } => {
                self.start[3] = point;
                let normal = (p1 - p0).cross(p2 - p0);
                let height = normal.dot(p - p0);
                if height.abs() > FAT * normal.length() {
                    if height < 0.0 {
                        self.start.swap(1, 2);
                    }
                    return Some(true);
                }
                (Stage::Fourth { again: true }, retry(again)?)
            }
            Stage::Beyond(_) => return None,
        };
        Some(false)
    }
}
