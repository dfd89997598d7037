//! How deep spheres, capsules and cuboids overlap by what is swept round them, as f32 has it: two straight cores that do not meet,
//! or one and a cuboid, sixteen pairs at a time.
//!
//! The lanes look for the nearest points of the cores, as yes or no does; f64 places them, and has the depth. What they do not know
//! well enough is left to the solver (docs/numerics/proofs.md, "Straight cores in lanes").

use super::super::bounds::{RADIUS, SIZE, STRAIGHT, U};
use super::super::closed::is_behind;
use super::super::frame::{BOX, FramePair, Record, SPHERE, SimdFrame};
use super::super::straight::{CoreForm, InFrame, NearestInFrame, NearestOfTwo};
use super::super::vector::V3;
use super::answers::Answers;
use super::formulas::Listed;
use crate::epa::Depth;
use crate::query::MeasureDepth;
use dcd_geom::glam::{DVec3, Vec3};
use dcd_geom::{Pair, Vector};
use dcd_simd::{Kernel, Lanes, Row, Unfused, WIDTH, dispatch_on};
use std::ops::Deref;

/// The most that the bound may be, relative to how far the cores are apart, and to the depth. No unit. Larger: normals that lean.
/// Smaller: more pairs are measured one by one, in f64.
const SURE: [f64; 2] = [1.0 / 256.0, 1.0];

/// The squared sine up to which two segments, or a segment and what it is beside of a cuboid, are nearly parallel: where between their
/// ends they are nearest f32 does not know well. No unit. Larger: more pairs are measured one by one. Smaller: points and normals
/// that are elsewhere, as near as the bound says.
const PARALLEL: f64 = 1e-4;

/// How much more than the distance the points of a cuboid may be off, whose edges are rounded to f32. Unit: u·m. Derived: 4.
const TURNED: f32 = 8.0;

/// Two shapes that touch by what is swept round their cores, which do not meet: a point or segment and another one, or a cuboid.
#[derive(Clone, Copy, Debug)]
pub struct CoreContact<'a> {
    pub(crate) depth: Depth,
    /// What a and b have inside.
    pub(crate) cores: [NearCore<'a>; 2],
}

/// A core.
#[derive(Clone, Copy, Debug)]
pub(crate) enum NearCore<'a> {
    Point,
    /// From the first vertex to the second, world axes.
    Segment(DVec3),
    Cuboid(NearCuboid<'a>),
}

/// A cuboid without a swept radius.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearCuboid<'a> {
    /// Where the other is, in the cuboid's own frame: of unit length.
    pub(crate) towards: DVec3,
    numbers: &'a Row,
}

impl NearCuboid<'_> {
    /// The direction of an edge in the world.
    #[inline(always)]
    pub(crate) fn edge(&self, axis: usize) -> DVec3 {
        Vec3::from_slice(&self.numbers.0[3 * axis % 9..][..3]).as_dvec3()
    }

    /// How long a vector is, squared, without its parts along the edges along which a point is no farther away than the cuboid
    /// reaches.
    #[inline(always)]
    fn rise(&self, away: DVec3, vector: DVec3) -> f64 {
        let mut squared = 0.0;
        for axis in 0..3 {
            let along = if away[axis] == 0.0 { 0.0 } else { self.edge(axis).dot(vector) };
            squared += along * along;
        }
        squared
    }

    /// See [`case_of`](crate::query::case_of); larger than any of a flat one, and where it is not known.
    #[inline(always)]
    pub(crate) fn case(&self) -> u32 {
        self.numbers.0[15] as u32
    }
}

impl CoreContact<'_> {
    /// Of the two in the other order.
    #[inline(always)]
    fn mirrored(self) -> Self {
        let Self { depth, cores: [a, b] } = self;
        Self { depth: depth.mirrored(), cores: [b, a] }
    }
}

/// What a thread reuses from slice to slice: pairs by their form.
#[derive(Debug, Default)]
pub(super) struct StraightPairs {
    two: Listed,
    beside_cuboid: Listed,
    packet: Packet,
}

impl StraightPairs {
    /// Forgets all.
    pub(super) fn begin(&mut self) {
        self.two.clear();
        self.beside_cuboid.clear();
    }

    /// Takes in the pair of that number among those that touch; false of one that the lanes do not know.
    #[inline(always)]
    pub(super) fn push(&mut self, frames: FramePair<'_>, (number, pair): (u32, Pair)) -> bool {
        let (a, b) = (frames.a.record(pair.i), frames.b.record(pair.j));
        let list = match CoreForm::of(a, b) {
            CoreForm::Straight => &mut self.two,
            CoreForm::AndCuboid => &mut self.beside_cuboid,
            CoreForm::Others => return false,
        };
        list.push(number, pair);
        true
    }

    /// Writes the answers of all that were taken in; what is not known well enough is left to the solver.
    pub(super) fn answer<S: MeasureDepth>(&mut self, answers: &mut Answers<'_, S>) {
        let Self { two, beside_cuboid, packet } = self;
        let path = answers.to.path;
        for (list, form) in [(two, Form::Two), (beside_cuboid, Form::BesideCuboid)] {
            if !list.pairs.is_empty() {
                dispatch_on(path, Unfused(Search { form, list, packet, answers }));
            }
        }
    }
}

/// What a pair is: two straight cores, or one and a cuboid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    Two,
    BesideCuboid,
}

/// Sixteen pairs as they are read, and what is found of them; kept, so that it need not be cleared.
#[derive(Debug, Default)]
struct Packet {
    /// From the centre of the second to that of the first; and from a cuboid's to the other's.
    between: [Row; 3],
    /// From the middle of a segment to an end: of the first and the second, or of the one that is no cuboid.
    ends: [[Row; 3]; 2],
    cuboids: [Row; WIDTH],
    /// Where on the segments the nearest points are, from −1 to 1.
    places: [Row; 2],
    /// From a cuboid, in its frame.
    away: [Row; 3],
}

/// Pairs of a form, and where their answers go.
struct Search<'a, 'b, S: MeasureDepth> {
    form: Form,
    list: &'a Listed,
    packet: &'a mut Packet,
    answers: &'a mut Answers<'b, S>,
}

impl<S: MeasureDepth> Kernel for Search<'_, '_, S> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self { form, list, packet, answers } = self;
        let frames = answers.objects.frames;
        for (pairs, numbers) in list.pairs.chunks(WIDTH).zip(list.numbers.chunks(WIDTH)) {
            for (lane, &pair) in pairs.iter().enumerate() {
                let (sides, _) = Side::both(form, frames, pair);
                packet.read(form, lane, &sides);
            }
            match form {
                Form::Two => packet.find_of_two(l),
                Form::BesideCuboid => packet.find_beside_cuboid(l),
            }
            for (lane, (&pair, &number)) in pairs.iter().zip(numbers).enumerate() {
                let (sides, swapped) = Side::both(form, frames, pair);
                let found = match form {
                    Form::Two => packet.contact_of_two(lane, &sides),
                    Form::BesideCuboid => packet.contact_beside_cuboid(lane, &sides),
                };
                answers.write_contact(number, found.map(|found| in_order(found, swapped)));
            }
        }
    }
}

#[inline(always)]
fn in_order(found: CoreContact<'_>, swapped: bool) -> CoreContact<'_> {
    if swapped { found.mirrored() } else { found }
}

/// An object of a pair.
struct Side<'a> {
    frame: &'a SimdFrame,
    object: u32,
    record: &'a Record,
}

impl Deref for Side<'_> {
    type Target = Record;

    #[inline(always)]
    fn deref(&self) -> &Record {
        self.record
    }
}

impl<'a> Side<'a> {
    /// The cuboid last, or two in the order of their centres; and whether that is not the pair's. Two centres that are one have no
    /// order, nor nearest points.
    #[inline(always)]
    fn both(form: Form, frames: FramePair<'a>, pair: Pair) -> ([Self; 2], bool) {
        let side =
            |frame: &'a SimdFrame, object| Self { frame, object, record: frame.record(object) };
        let (a, b) = (side(frames.a, pair.i), side(frames.b, pair.j));
        let swapped = match form {
            Form::Two => is_behind(a.record, b.record),
            Form::BesideCuboid => a.marks & BOX != 0,
        };
        (if swapped { [b, a] } else { [a, b] }, swapped)
    }

    #[inline(always)]
    fn place(&self) -> DVec3 {
        let [x, y, z, _] = self.centre;
        DVec3::new(x, y, z)
    }

    /// From the middle to the first vertex.
    #[inline(always)]
    fn end(&self) -> [f32; 3] {
        let [x, y, z] = &self.frame.blocks()[self.first as usize].0;
        [x.0[0], y.0[0], z.0[0]]
    }

    #[inline(always)]
    fn numbers(&self) -> &'a Row {
        &self.frame.boxes(self.object).numbers
    }

    /// What it has inside, given its end; `None` of a segment without length.
    #[inline(always)]
    fn straight(&self, end: DVec3) -> Option<NearCore<'a>> {
        if self.marks & SPHERE != 0 {
            return Some(NearCore::Point);
        }
        (end != DVec3::ZERO).then_some(NearCore::Segment(end * -2.0))
    }
}

/// How far the nearest points that f32 has found may be off their cores, and how far what they prove of the distance is: metres.
/// `None` of a size that is out of range.
#[inline(always)]
fn lost([first, second]: &[Side<'_>; 2], between: DVec3, unit: f32) -> Option<f64> {
    let number = |x: f32| f64::from(x);
    let size = number(first.size) + number(second.size) + between.norm1();
    let radius = number(first.radius) + number(second.radius);
    let far = first.place().norm1() + second.place().norm1();
    let error = number(U) * (number(unit) * size + number(RADIUS) * radius)
        + 2.0 * (number(first.slack) + number(second.slack))
        + 4.0 * f64::EPSILON * far;
    // False for NaN.
    (number(SIZE.start) < size && size < number(SIZE.end)).then_some(error)
}

/// How far past the point at t in [−1, 1] of a segment an end reaches, towards less, along a direction on which the half segment is
/// `rise` long.
#[inline(always)]
fn past_end(t: f64, rise: f64) -> f64 {
    ((t + 1.0) * rise).max((t - 1.0) * rise)
}

/// The depth of two shapes whose cores are `length` apart along the normal; `None` where that is not surely so.
#[inline(always)]
fn sure(depth: Depth, length: f64) -> Option<Depth> {
    let [of_length, of_depth] = SURE;
    // False for NaN.
    let is_sure =
        depth.error_bound <= of_length * length && depth.error_bound < of_depth * depth.depth;
    is_sure.then_some(depth)
}

impl Packet {
    #[inline(always)]
    fn read(&mut self, form: Form, lane: usize, [first, second]: &[Side<'_>; 2]) {
        let between = (first.place() - second.place()).to_array();
        for (row, between) in self.between.iter_mut().zip(between) {
            row.0[lane % WIDTH] = between as f32;
        }
        self.set_end(0, lane, first);
        match form {
            Form::Two => self.set_end(1, lane, second),
            Form::BesideCuboid => self.cuboids[lane % WIDTH] = *second.numbers(),
        }
    }

    #[inline(always)]
    fn set_end(&mut self, number: usize, lane: usize, side: &Side<'_>) {
        for (row, end) in self.ends[number].iter_mut().zip(side.end()) {
            row.0[lane % WIDTH] = end;
        }
    }

    #[inline(always)]
    fn find_of_two<L: Lanes>(&mut self, l: L) {
        let ends = [V3::load(l, &self.ends[0]), V3::load(l, &self.ends[1])];
        let NearestOfTwo { s, t, .. } = NearestOfTwo::of(l, V3::load(l, &self.between), ends);
        l.store(s, &mut self.places[0]);
        l.store(t, &mut self.places[1]);
    }

    #[inline(always)]
    fn find_beside_cuboid<L: Lanes>(&mut self, l: L) {
        let (middle, end) = (V3::load(l, &self.between), V3::load(l, &self.ends[0]));
        let NearestInFrame { t, away: [x, y, z], .. } =
            InFrame::of(l, &self.cuboids, middle, end).nearest(l);
        l.store(t, &mut self.places[0]);
        V3(x, y, z).store(l, &mut self.away);
    }

    #[inline(always)]
    fn at(row: &Row, lane: usize) -> f64 {
        row.0[lane % WIDTH].into()
    }

    #[inline(always)]
    fn vector_at(rows: &[Row; 3], lane: usize) -> DVec3 {
        let [x, y, z] = rows;
        DVec3::new(Self::at(x, lane), Self::at(y, lane), Self::at(z, lane))
    }

    /// From the first to the second.
    #[inline(always)]
    fn contact_of_two<'a>(&self, lane: usize, sides: &[Side<'a>; 2]) -> Option<CoreContact<'a>> {
        let [first, second] = sides;
        let ends = [Self::vector_at(&self.ends[0], lane), Self::vector_at(&self.ends[1], lane)];
        let [s, t] = [Self::at(&self.places[0], lane), Self::at(&self.places[1], lane)];
        let crossing = ends[0].cross(ends[1]).length_squared();
        let sizes = ends[0].length_squared() * ends[1].length_squared();
        if s.abs() < 1.0 && t.abs() < 1.0 && crossing < PARALLEL * sizes {
            return None;
        }
        let (in_first, in_second) = (ends[0] * s, ends[1] * t);
        let between = first.place() - second.place();
        let w = (between + in_first) - in_second;
        let length = w.length();
        let past = past_end(s, w.dot(ends[0])) + past_end(-t, w.dot(ends[1]));
        let normal = w / -length;
        let radii = [f64::from(first.radius), f64::from(second.radius)];
        let depth = Depth {
            depth: (radii[0] + radii[1]) - length,
            normal,
            point_a: (first.place() + in_first) + normal * radii[0],
            point_b: (second.place() + in_second) - normal * radii[1],
            error_bound: lost(sides, between, STRAIGHT)? + past / length,
        };
        let cores = [first.straight(ends[0])?, second.straight(ends[1])?];
        Some(CoreContact { depth: sure(depth, length)?, cores })
    }

    /// From the first to the cuboid.
    #[inline(always)]
    fn contact_beside_cuboid<'a>(
        &self,
        lane: usize,
        sides: &[Side<'a>; 2],
    ) -> Option<CoreContact<'a>> {
        let [first, second] = sides;
        let end = Self::vector_at(&self.ends[0], lane);
        let away = Self::vector_at(&self.away, lane);
        let towards = away / away.length();
        let cuboid = NearCuboid { towards, numbers: second.numbers() };
        let w = (cuboid.edge(0) * away.x + cuboid.edge(1) * away.y) + cuboid.edge(2) * away.z;
        let length = w.length();
        let normal = w / -length;
        let radius = f64::from(first.radius);
        let t = Self::at(&self.places[0], lane);
        if t.abs() < 1.0 && cuboid.rise(away, end) < PARALLEL * end.length_squared() {
            return None;
        }
        let place = first.place() + end * t;
        let between = first.place() - second.place();
        let depth = Depth {
            depth: radius - length,
            normal,
            point_a: place + normal * radius,
            point_b: place - w,
            error_bound: lost(sides, between, STRAIGHT + TURNED)?
                + past_end(t, w.dot(end)) / length,
        };
        let cores = [first.straight(end)?, NearCore::Cuboid(cuboid)];
        Some(CoreContact { depth: sure(depth, length)?, cores })
    }
}
