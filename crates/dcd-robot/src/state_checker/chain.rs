//! Where the links of sixteen states are, in f32, and how far from the frames of [`Robot::place`] that is at most
//! (docs/numerics/proofs.md, "states in lanes").

// In kernels: an iterator that is left out of line costs more than the loop.
#![allow(clippy::needless_range_loop)]

use super::links::LinkSpheres;
use super::rounded_links::RoundedLink;
use crate::kinematics::{JointFrame, quaternion};
use crate::model::Drive;
use crate::{Joint, Motion, Robot};
use dcd_simd::{Lanes, Row, WIDTH};
use glam::{DMat3, DVec3};

/// What rounding to f32 loses of a number.
const ROUNDING: f64 = 1.0 / (1 << 24) as f64;

/// How far from 0 an angle may be, rad. Larger: rounding it to f32 loses more. Smaller: more states are placed one by
/// one.
const MOST_TURNED: f64 = 8.0;

/// How far a joint may slide, and a link be at rest, metres: so that no number is infinite. Smaller: more states are
/// placed one by one.
const FARTHEST: f64 = 1e6;

/// What the sine and the cosine of an angle up to [`MOST_TURNED`] may be off, the angle's rounding included.
const SINE_ERROR: f64 = 8.0 * ROUNDING;

/// What a computed rotation may be off for the rest of the bounds to hold.
const MOST_OFF: f64 = 1e-3;

/// The largest norm of anything that stands for a rotation, true or computed.
const NORM: f64 = 1.01;

/// Entries of a matrix below that are left out.
const NOTHING: f64 = 1.0 / (1u64 << 36) as f64;

/// How far a computed frame may be from the one of [`Robot::place`]: a point p of the link is off by
/// `turn`·|p| + `shift` + `per_slid`·(what the joints slide in all), metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct FrameError {
    pub(super) turn: f64,
    pub(super) shift: f64,
    pub(super) per_slid: f64,
    /// How far the link's origin may be from the world's, with what the joints slide left out, metres.
    reach: f64,
}

/// A column of a joint's rotation at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Column {
    /// A column of the parent's frame, or its negative.
    Of(usize, Sign),
    Mixed([f32; 3]),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sign {
    Plus,
    Minus,
}

/// What moves a link against its frame at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Moves {
    Never,
    /// About an axis of its own frame, or its negative, by the angle of a row.
    About(usize, Sign, usize),
    /// About any axis.
    Turns([f32; 3], usize),
    Slides([f32; 3], usize),
    /// By a rotation of [`Drives::turns`].
    Orients(usize),
}

/// A link's frame from another's.
#[derive(Clone, Debug)]
struct Step {
    /// Places among the frames.
    parent: usize,
    child: usize,
    turned: Option<[Column; 3]>,
    by: [f32; 3],
    moves: Moves,
}

/// The joints that move anything with a shape, those that are fixed to each other as one.
#[derive(Clone, Debug)]
pub(super) struct Chain {
    pub(super) base: JointFrame,
    root: usize,
    steps: Vec<Step>,
    /// How many frames there are: first those of the links with spheres.
    frames: usize,
    /// What moves joints, and how far each may.
    drives: Vec<(Drive, f64)>,
    /// Where quaternions begin in a state.
    quaternions: Vec<usize>,
    /// For each link with spheres.
    pub(super) errors: Vec<FrameError>,
    /// Whether the bounds hold.
    is_bounded: bool,
}

/// What moves the joints of sixteen states.
#[derive(Clone, Debug, Default)]
pub(super) struct Drives {
    rows: Vec<Row>,
    turns: Vec<[Row; 9]>,
}

impl Chain {
    pub(super) fn of(robot: &Robot, links: &[LinkSpheres]) -> Self {
        let mut frames = Frames::of(robot, links);
        let root = frames.place(robot.root);
        let mut chain = Self {
            base: robot.base,
            root,
            steps: Vec::new(),
            frames: 0,
            drives: Vec::new(),
            quaternions: Vec::new(),
            errors: Vec::new(),
            is_bounded: true,
        };
        let mut errors = vec![FrameError::default(); robot.links.len()];
        errors[robot.root] = FrameError::of_base(&robot.base);
        // For each link the nearest above it that has a frame, and its own frame there.
        let mut above: Vec<(usize, JointFrame)> =
            (0..robot.links.len()).map(|link| (link, JointFrame::IDENTITY)).collect();
        for joint in &robot.joints {
            let moves = chain.moves(joint);
            let (parent, origin) = above[joint.parent];
            let origin = origin.then(&joint.origin);
            if moves == Moves::Never && !frames.is_link(joint.child) {
                above[joint.child] = (parent, origin);
                continue;
            }
            let (turned, lost) = columns(&origin.rotation);
            let by = origin.translation.as_vec3().to_array();
            let error = errors[parent].at_rest(&origin, (turned.is_some(), lost));
            errors[joint.child] = error.moved(&moves);
            if frames.carries[joint.child] {
                let (parent, child) = (frames.place(parent), frames.place(joint.child));
                chain.steps.push(Step { parent, child, turned, by, moves });
            }
        }
        chain.frames = frames.count;
        chain.is_bounded = errors.iter().all(FrameError::is_bounded);
        // Without bounds every state is placed as [`Robot::place`] does it.
        let error =
            |link: usize| if chain.is_bounded { errors[link] } else { FrameError::default() };
        chain.errors = links.iter().map(|link| error(link.link)).collect();
        chain
    }

    /// How a joint moves, and by which row.
    fn moves(&mut self, joint: &Joint) -> Moves {
        let mut row = |by: Drive, most: f64| {
            self.drives.push((by, most));
            self.drives.len() - 1
        };
        match joint.motion {
            Motion::Fixed => Moves::Never,
            Motion::Turns { axis, by } => {
                let row = row(by, MOST_TURNED);
                match unit(axis) {
                    Some((k, sign)) => Moves::About(k, sign, row),
                    None => Moves::Turns(axis.as_vec3().to_array(), row),
                }
            }
            Motion::Slides { axis, by } => {
                Moves::Slides(axis.as_vec3().to_array(), row(by, FARTHEST))
            }
            Motion::Orients { first } => {
                self.quaternions.push(first);
                Moves::Orients(self.quaternions.len() - 1)
            }
        }
    }

    /// Takes what moves the joints in at most sixteen states. Returns those that the bounds do not cover, or that are
    /// no states of the robot, a bit each.
    pub(super) fn read(&self, robot: &Robot, states: &[impl AsRef<[f64]>], to: &mut Drives) -> u32 {
        to.rows.resize(self.drives.len(), Row::default());
        to.turns.resize(self.quaternions.len(), [Row::default(); 9]);
        let mut open = 0;
        for (lane, state) in states.iter().take(WIDTH).enumerate() {
            let state = state.as_ref();
            if state.len() != robot.moved.len() {
                open |= 1 << lane;
                continue;
            }
            // What moves nothing has to be a number too.
            let mut is_known = self.is_bounded;
            for value in state {
                is_known &= value.is_finite();
            }
            for ((by, most), row) in self.drives.iter().zip(&mut to.rows) {
                let value = state[by.value] * by.factor + by.offset;
                is_known &= value.abs() <= *most;
                row.0[lane] = value as f32;
            }
            for (&first, rows) in self.quaternions.iter().zip(&mut to.turns) {
                is_known &= robot.check_state(state).is_ok();
                let turn = DMat3::from_quat(quaternion(state, first).normalize());
                for (row, number) in rows.iter_mut().zip(turn.to_cols_array()) {
                    row.0[lane] = number as f32;
                }
            }
            if !is_known {
                open |= 1 << lane;
                to.rows.iter_mut().for_each(|row| row.0[lane] = 0.0);
            }
        }
        open
    }

    /// Places the links: `to` has a frame for each. Returns what all joints slide together, metres.
    #[inline(always)]
    pub(super) fn place<L: Lanes>(&self, l: L, drives: &Drives, to: &mut Vec<RoundedLink>) -> L::F {
        if to.len() != self.frames {
            to.resize(self.frames, RoundedLink::default());
        }
        let base = self.base.rotation.to_cols_array();
        for k in 0..9 {
            l.store(l.splat(base[k] as f32), &mut to[self.root].frame[k]);
        }
        let at = self.base.translation.to_array();
        for k in 0..3 {
            l.store(l.splat(at[k] as f32), &mut to[self.root].frame[9 + k]);
        }
        let mut slid = l.splat(0.0);
        for step in &self.steps {
            let parent = loaded(l, &to[step.parent].frame);
            let mut frame = parent;
            if let Some(columns) = &step.turned {
                for k in 0..3 {
                    set_column(&mut frame, k, turned(l, &parent, &columns[k]));
                }
            }
            shift(l, &parent, step.by, &mut frame);
            match step.moves {
                Moves::Never => {}
                Moves::About(axis, sign, row) => {
                    let sines = sin_cos(l, l.load(&drives.rows[row]));
                    turn_about(l, (axis, sign), sines, &mut frame);
                }
                Moves::Turns(axis, row) => {
                    let rotation = rotation(l, axis, sin_cos(l, l.load(&drives.rows[row])));
                    turn(l, &rotation, &mut frame);
                }
                Moves::Slides(axis, row) => {
                    let far = l.load(&drives.rows[row]);
                    slid = l.add(slid, l.abs(far));
                    for k in 0..3 {
                        if axis[k] != 0.0 {
                            let along = l.mul(l.splat(axis[k]), far);
                            for axis in 0..3 {
                                frame[9 + axis] =
                                    l.mul_add(frame[3 * k + axis], along, frame[9 + axis]);
                            }
                        }
                    }
                }
                Moves::Orients(number) => {
                    let mut rotation = [l.splat(0.0); 9];
                    for k in 0..9 {
                        rotation[k] = l.load(&drives.turns[number][k]);
                    }
                    turn(l, &rotation, &mut frame);
                }
            }
            let child = &mut to[step.child].frame;
            for k in 0..12 {
                l.store(frame[k], &mut child[k]);
            }
        }
        slid
    }
}

/// Which links have a frame of their own, and where.
struct Frames {
    /// Whether a link or one that it moves has spheres.
    carries: Vec<bool>,
    places: Vec<Option<usize>>,
    links: usize,
    count: usize,
}

impl Frames {
    fn of(robot: &Robot, links: &[LinkSpheres]) -> Self {
        let mut carries = vec![false; robot.links.len()];
        let mut places = vec![None; robot.links.len()];
        for (place, link) in links.iter().enumerate() {
            (carries[link.link], places[link.link]) = (true, Some(place));
        }
        for joint in robot.joints.iter().rev() {
            carries[joint.parent] |= carries[joint.child];
        }
        Self { carries, places, links: links.len(), count: links.len() }
    }

    /// Whether the link has spheres.
    fn is_link(&self, link: usize) -> bool {
        self.places[link].is_some_and(|place| place < self.links)
    }

    fn place(&mut self, link: usize) -> usize {
        let Self { places, count, .. } = self;
        *places[link].get_or_insert_with(|| {
            *count += 1;
            *count - 1
        })
    }
}

impl FrameError {
    fn of_base(base: &JointFrame) -> Self {
        let at = base.translation;
        Self {
            turn: lost(&base.rotation),
            shift: at.distance(at.as_vec3().as_dvec3()),
            per_slid: 0.0,
            reach: at.length(),
        }
    }

    fn is_bounded(&self) -> bool {
        self.turn <= MOST_OFF && self.shift <= FARTHEST && self.reach <= FARTHEST
    }

    /// Of a joint's frame at rest: where it is turned, three products of an entry lose 3u of 1 each, all nine 9u;
    /// where it is shifted, a coordinate loses at most six times u of what is summed, which is below the two
    /// lengths.
    fn at_rest(mut self, origin: &JointFrame, (is_turned, lost): (bool, f64)) -> Self {
        let by = origin.translation;
        if by != DVec3::ZERO {
            let far = by.length();
            let rounded = by.distance(by.as_vec3().as_dvec3());
            self.shift += NORM * (self.turn * far + rounded);
            self.shift += SUMS * (far + self.reach);
            self.per_slid += SUMS;
            self.reach += NORM * far;
        }
        if is_turned {
            self.turn = NORM * (self.turn + lost + 12.0 * ROUNDING);
        } else {
            // Entries so small that they were left out.
            self.turn += NORM * lost;
        }
        self
    }

    /// After what moves the joint.
    fn moved(mut self, moves: &Moves) -> Self {
        match moves {
            Moves::Never => {}
            // Four entries are off; six are sums of two products.
            Moves::About(..) => {
                self.turn = NORM * (self.turn + 2.0 * SINE_ERROR + 6.0 * ROUNDING);
            }
            // Nine entries are off by two sines and eight roundings each; nine are sums of three products.
            Moves::Turns(..) => {
                self.turn = NORM * (self.turn + 6.0 * SINE_ERROR + 36.0 * ROUNDING);
            }
            Moves::Orients(_) => self.turn = NORM * (self.turn + 14.0 * ROUNDING),
            Moves::Slides(..) => {
                self.shift += SUMS * self.reach;
                self.per_slid += NORM * (self.turn + 4.0 * ROUNDING) + 2.0 * SUMS;
            }
        }
        self
    }

    /// What a comparison of anything within `size` of the link's origin may be off, metres, without what slides; and
    /// that for each metre that joints slide.
    pub(super) fn of_size(&self, size: f32) -> [f32; 2] {
        let sum = NORM * (self.shift + self.turn * f64::from(size));
        [sum as f32 + f32::MIN_POSITIVE, (NORM * self.per_slid) as f32]
    }
}

/// What a rotated and shifted vector loses: six roundings of each coordinate, √3 times that for the three.
const SUMS: f64 = 11.0 * ROUNDING;

/// What rounding to f32 takes off a rotation: the root of the sum of the squares, and what is left out as nothing.
fn lost(rotation: &DMat3) -> f64 {
    let off = |x: f64| if x.abs() < NOTHING { x } else { x - f64::from(x as f32) };
    let squares = rotation.to_cols_array().map(|x| off(x) * off(x));
    squares.iter().sum::<f64>().sqrt()
}

/// The columns of a rotation that turns, and what they are off.
fn columns(rotation: &DMat3) -> (Option<[Column; 3]>, f64) {
    let numbers = |k: usize| {
        let column = rotation.col(k).to_array();
        column.map(|x| if x.abs() < NOTHING { 0.0 } else { x as f32 })
    };
    let column = |k: usize| match numbers(k) {
        [x, 0.0, 0.0] if x.abs() == 1.0 => Column::Of(0, Sign::of(x)),
        [0.0, y, 0.0] if y.abs() == 1.0 => Column::Of(1, Sign::of(y)),
        [0.0, 0.0, z] if z.abs() == 1.0 => Column::Of(2, Sign::of(z)),
        mixed => Column::Mixed(mixed),
    };
    let columns = [column(0), column(1), column(2)];
    let stays = columns == [0, 1, 2].map(|k| Column::Of(k, Sign::Plus));
    ((!stays).then_some(columns), lost(rotation))
}

/// The axis of a frame that a vector is, or the negative of.
fn unit(axis: DVec3) -> Option<(usize, Sign)> {
    match axis.to_array() {
        [x, 0.0, 0.0] if x.abs() == 1.0 => Some((0, Sign::of(x as f32))),
        [0.0, y, 0.0] if y.abs() == 1.0 => Some((1, Sign::of(y as f32))),
        [0.0, 0.0, z] if z.abs() == 1.0 => Some((2, Sign::of(z as f32))),
        _ => None,
    }
}

impl Sign {
    fn of(x: f32) -> Self {
        if x < 0.0 { Self::Minus } else { Self::Plus }
    }
}

#[inline(always)]
pub(super) fn loaded<L: Lanes>(l: L, rows: &[Row; 12]) -> [L::F; 12] {
    let mut frame = [l.splat(0.0); 12];
    for k in 0..12 {
        frame[k] = l.load(&rows[k]);
    }
    frame
}

/// Number by number: a slice would be copied by a call.
#[inline(always)]
fn set_column<F: Copy>(frame: &mut [F; 12], k: usize, [x, y, z]: [F; 3]) {
    (frame[3 * k], frame[3 * k + 1], frame[3 * k + 2]) = (x, y, z);
}

/// The frame's rotation times a column.
#[inline(always)]
fn turned<L: Lanes>(l: L, frame: &[L::F; 12], column: &Column) -> [L::F; 3] {
    let mut result = [l.splat(0.0); 3];
    match *column {
        Column::Of(k, sign) => {
            for axis in 0..3 {
                let number = frame[3 * k + axis];
                result[axis] = if sign == Sign::Plus { number } else { l.neg(number) };
            }
        }
        Column::Mixed(numbers) => {
            for k in 0..3 {
                if numbers[k] != 0.0 {
                    let number = l.splat(numbers[k]);
                    for axis in 0..3 {
                        result[axis] = l.mul_add(frame[3 * k + axis], number, result[axis]);
                    }
                }
            }
        }
    }
    result
}

/// Adds the parent's rotation times a vector to a frame's translation.
#[inline(always)]
fn shift<L: Lanes>(l: L, parent: &[L::F; 12], by: [f32; 3], frame: &mut [L::F; 12]) {
    for k in 0..3 {
        if by[k] != 0.0 {
            let far = l.splat(by[k]);
            for axis in 0..3 {
                frame[9 + axis] = l.mul_add(parent[3 * k + axis], far, frame[9 + axis]);
            }
        }
    }
}

/// Turns a frame about an axis of its own: the other two columns are mixed.
#[inline(always)]
fn turn_about<L: Lanes>(
    l: L,
    (axis, sign): (usize, Sign),
    [sin, cos]: [L::F; 2],
    frame: &mut [L::F; 12],
) {
    let sin = if sign == Sign::Plus { sin } else { l.neg(sin) };
    // Written out, so that no number of the frame has an index that is known at run time alone.
    match axis {
        0 => mix::<L, 3, 6>(l, [sin, cos], frame),
        1 => mix::<L, 6, 0>(l, [sin, cos], frame),
        _ => mix::<L, 0, 3>(l, [sin, cos], frame),
    }
}

#[inline(always)]
fn mix<L: Lanes, const U: usize, const V: usize>(
    l: L,
    [sin, cos]: [L::F; 2],
    frame: &mut [L::F; 12],
) {
    for k in 0..3 {
        let (u, v) = (frame[U + k], frame[V + k]);
        frame[U + k] = l.mul_add(u, cos, l.mul(v, sin));
        frame[V + k] = l.sub(l.mul(v, cos), l.mul(u, sin));
    }
}

/// Turns a frame by a rotation, column by column.
#[inline(always)]
fn turn<L: Lanes>(l: L, rotation: &[L::F; 9], frame: &mut [L::F; 12]) {
    let rest = *frame;
    for column in 0..3 {
        for axis in 0..3 {
            let sum = l.mul(rest[axis], rotation[3 * column]);
            let sum = l.mul_add(rest[3 + axis], rotation[3 * column + 1], sum);
            frame[3 * column + axis] = l.mul_add(rest[6 + axis], rotation[3 * column + 2], sum);
        }
    }
}

/// The rotation about an axis of unit length, by columns.
#[inline(always)]
fn rotation<L: Lanes>(l: L, [x, y, z]: [f32; 3], [sin, cos]: [L::F; 2]) -> [L::F; 9] {
    let versine = l.sub(l.splat(1.0), cos);
    let axis = [x, y, z];
    let mut result = [cos; 9];
    for i in 0..3 {
        let along = l.mul(l.splat(axis[i]), versine);
        for j in 0..3 {
            let start = if i == j { cos } else { l.splat(0.0) };
            result[3 * i + j] = l.mul_add(l.splat(axis[j]), along, start);
        }
    }
    let (x, y, z) = (l.mul(l.splat(x), sin), l.mul(l.splat(y), sin), l.mul(l.splat(z), sin));
    result[1] = l.add(result[1], z);
    result[2] = l.sub(result[2], y);
    result[3] = l.sub(result[3], z);
    result[5] = l.add(result[5], x);
    result[6] = l.add(result[6], y);
    result[7] = l.sub(result[7], x);
    result
}

/// π/2 to 17 bits, so that it times a small whole number is exact, and the rest.
const QUARTER: [f32; 2] = [1.570_785_5, 1.080_433_4e-5];

/// What added and subtracted rounds to a whole number: 1.5 · 2²³.
const WHOLE: f32 = 12_582_912.0;

/// The sine and the cosine of an angle up to [`MOST_TURNED`] from 0, within three roundings of those of the angle in
/// f32: by Taylor's series of what it is beyond a multiple of a right angle.
#[inline(always)]
fn sin_cos<L: Lanes>(l: L, angle: L::F) -> [L::F; 2] {
    let quarters = whole(l, l.mul(angle, l.splat(std::f32::consts::FRAC_2_PI)));
    let x = l.mul_add(quarters, l.splat(-QUARTER[0]), angle);
    let x = l.mul_add(quarters, l.splat(-QUARTER[1]), x);
    let square = l.mul(x, x);
    let mut sine = l.splat(1.0 / 362_880.0);
    for term in [-1.0 / 5040.0, 1.0 / 120.0, -1.0 / 6.0] {
        sine = l.mul_add(sine, square, l.splat(term));
    }
    let sine = l.mul_add(l.mul(x, square), sine, x);
    let mut cosine = l.splat(1.0 / 40_320.0);
    for term in [-1.0 / 720.0, 1.0 / 24.0, -0.5] {
        cosine = l.mul_add(cosine, square, l.splat(term));
    }
    let cosine = l.mul_add(square, cosine, l.splat(1.0));
    // quarters = 2·halves + odd, halves = 2·turns + flipped.
    let halves = whole(l, l.mul_add(quarters, l.splat(0.5), l.splat(-0.25)));
    let turns = whole(l, l.mul_add(halves, l.splat(0.5), l.splat(-0.25)));
    let is_odd = l.lt(l.add(halves, halves), quarters);
    let is_flipped = l.lt(l.add(turns, turns), halves);
    let sign = l.select(is_flipped, l.splat(-1.0), l.splat(1.0));
    [
        l.mul(sign, l.select(is_odd, cosine, sine)),
        l.mul(sign, l.select(is_odd, l.neg(sine), cosine)),
    ]
}

/// To the nearest whole number, of what is small.
#[inline(always)]
fn whole<L: Lanes>(l: L, x: L::F) -> L::F {
    l.sub(l.add(x, l.splat(WHOLE)), l.splat(WHOLE))
}
