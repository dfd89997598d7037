//! The expanding polytope of one pair in f32, support by support: many pairs are searched side by side.

use super::super::bounds::U;
use super::start::Extremes;
use super::surface::{Point, Surface};
use super::vectors::{bits, dot, load, splat};
use crate::Accuracy;
use dcd_geom::glam::Vec3;
use dcd_simd::{Block, Lanes, Row, WIDTH};

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

/// A − B of a pair as f32 has it, in the lengths of its difference: below 1 or not much above.
#[derive(Clone, Copy)]
pub(super) struct Cloud<'a> {
    /// The vertices of a and of b, turned into the world's axes, round their centres: metres.
    pub(super) blocks: [&'a [Block]; 2],
    /// The difference's lengths by metres: a power of two.
    pub(super) scale: f32,
    /// The difference of the two centres.
    pub(super) middle: Vec3,
    /// u·m: what every bound is a multiple of.
    pub(super) unit: f32,
}

impl Cloud<'_> {
    /// The point farthest along a direction, up to rounding.
    #[inline(always)]
    fn farthest<L: Lanes>(&self, l: L, direction: Vec3) -> Point {
        let (a, of_a) = farthest(l, self.blocks[0], direction);
        let (b, of_b) = farthest(l, self.blocks[1], -direction);
        self.difference([a, b], [of_a, of_b])
    }

    /// The point of two vertices.
    #[inline(always)]
    fn point(&self, [a, b]: [u8; 2]) -> Point {
        let [of_a, of_b] = [vertex(self.blocks[0], a), vertex(self.blocks[1], b)];
        self.difference([a.into(), b.into()], [of_a, of_b])
    }

    #[inline(always)]
    fn difference(&self, vertices: [u32; 2], [of_a, of_b]: [Vec3; 2]) -> Point {
        Point { at: (of_a - of_b) * self.scale + self.middle, vertices }
    }
}

/// The vertex of that number.
#[inline(always)]
fn vertex(blocks: &[Block], number: u8) -> Vec3 {
    let number = usize::from(number);
    blocks.get(number / WIDTH).map_or(Vec3::NAN, |block| block.point(number % WIDTH))
}

/// The first of the vertices that are farthest along a direction in the first lane that has one, and its number.
#[inline(always)]
fn farthest<L: Lanes>(l: L, blocks: &[Block], direction: Vec3) -> (u32, Vec3) {
    let d = splat(l, direction);
    let Some(first) = blocks.first() else { return (0, Vec3::NAN) };
    let mut best = dot(l, load(l, first), d);
    // Most hulls have one block or two, and which is not predicted: of one the first is looked at again.
    let second = usize::from(blocks.len() > 1);
    let along = dot(l, load(l, &blocks[second]), d);
    let mut of_block = l.select(l.lt(best, along), bits(l, second), bits(l, 0));
    best = l.max(best, along);
    for (number, block) in (2..).zip(blocks.get(2..).unwrap_or_default()) {
        let along = dot(l, load(l, block), d);
        of_block = l.select(l.lt(best, along), bits(l, number), of_block);
        best = l.max(best, along);
    }
    let top = l.splat(l.largest(best));
    let lane = l.bits(l.le(top, best)).trailing_zeros() as usize % WIDTH;
    let mut numbers = Row([0.0; WIDTH]);
    l.store(of_block, &mut numbers);
    let number = (numbers.0[lane].to_bits() as usize).min(blocks.len() - 1);
    ((number * WIDTH + lane) as u32, blocks[number].point(lane))
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
        extremes: [Extremes; 2],
        surface: &mut Surface,
    ) {
        let mut corners = [Point::default(); 6];
        for (k, corner) in corners.iter_mut().enumerate() {
            *corner = cloud.point([extremes[0][k], extremes[1][(k + 3) % 6]]);
        }
        if surface.start_round(l, &corners, self.clear).is_some() {
            self.look_beyond(surface, surface.nearest(l));
        }
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
            // Written so that NaN ends the search.
            if !(reach - distance > self.clear) {
                let is_end = reach.is_finite() && reach > 0.0;
                return if is_end { Next::Ended { nearest: face, reach } } else { Next::Failed };
            }
            // All of A − B is on the far side: the cores do not overlap, as far as f32 knows.
            if reach < 0.0 {
                return Next::Failed;
            }
            let Some(nearest) = surface.insert(l, point, (face, self.clear)) else {
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
