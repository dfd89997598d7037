//! Where the links of sixteen states are, in f32, and how far from the frames of [`Robot::place`] that is at most
//! (docs/numerics/proofs.md, "states in lanes").

// In kernels: an iterator that is left out of line costs more than the loop.
#![allow(clippy::needless_range_loop)]

mod columns;
mod frame_error;
mod turns;
mod values;

use super::links::LinkSpheres;
use super::numbers::Numbers;
use super::rounded_links::RoundedLink;
use super::sift::MOST_ALONE;
use crate::kinematics::{JointFrame, quaternion};
use crate::model::Drive;
use crate::{Joint, Motion, Robot};
use columns::way;
use dcd_simd::{Row, WIDTH};
use frame_error::{NOTHING, lost};
use glam::{DMat3, DVec3};
use turns::{rotation, set_column, shift, turn, turn_about, turned};
use values::ValueRow;

pub(super) use frame_error::FrameError;
pub(super) use turns::loaded;

/// How far from 0 an angle may be, rad. Larger: rounding it to f32 loses more. Smaller: more states are placed one by
/// one.
const MOST_TURNED: f64 = 8.0;

/// How far a joint may slide, and a link be at rest, metres: so that no number is infinite. Smaller: more states are
/// placed one by one.
const FARTHEST: f64 = 1e6;

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
    /// Which of those are not 0, a bit each.
    along: u8,
    moves: Moves,
    /// Which of [`Chain::place_alone`]'s ways it takes there.
    way: u8,
}

/// A turn by a right angle about an axis of the frame, or back: what most joints at rest are turned by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Quarter {
    X(Sign),
    Y(Sign),
    Z(Sign),
}

impl Quarter {
    /// By the columns of a rotation.
    fn of(columns: &[Column; 3]) -> Option<Self> {
        use Sign::{Minus, Plus};
        let quarters = [Self::X, Self::Y, Self::Z].into_iter();
        let mut all = quarters.flat_map(|about| [about(Plus), about(Minus)]);
        all.find(|quarter| quarter.columns() == *columns)
    }

    fn columns(self) -> [Column; 3] {
        let sign = match self {
            Self::X(sign) | Self::Y(sign) | Self::Z(sign) => sign,
        };
        let (there, back) = (|k| Column::Of(k, sign), |k| Column::Of(k, sign.other()));
        match self {
            Self::X(_) => [Column::Of(0, Sign::Plus), there(2), back(1)],
            Self::Y(_) => [back(2), Column::Of(1, Sign::Plus), there(0)],
            Self::Z(_) => [there(1), back(0), Column::Of(2, Sign::Plus)],
        }
    }
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
    /// The values of a state that are none of those.
    idle: Vec<usize>,
    /// All values of a state that is taken up alone.
    values: ValueRow,
    /// For each link with spheres.
    pub(super) errors: Vec<FrameError>,
    /// Whether the bounds hold.
    is_bounded: bool,
}

/// What moves the joints of sixteen states.
#[derive(Clone, Debug, Default)]
pub(super) struct Drives {
    rows: Vec<Row>,
    /// Of each state that may be taken up alone its numbers of the first sixteen rows, side by side: gathered where their sines
    /// are found, the stores would be waited for.
    alone: [Row; MOST_ALONE],
    turns: Vec<[Row; 9]>,
}

impl Drives {
    /// The numbers of the first sixteen rows of a state that is taken up alone.
    #[inline(always)]
    pub(super) fn alone(&self, lane: usize) -> &Row {
        &self.alone[lane]
    }
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
            idle: Vec::new(),
            values: ValueRow::default(),
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
                let along = (0..3).map(|k| u8::from(by[k] != 0.0) << k).sum();
                let way = way(turned.as_ref(), &moves);
                chain.steps.push(Step { parent, child, turned, by, along, moves, way });
            }
        }
        chain.frames = frames.count;
        let is_driven = |value: &usize| chain.drives.iter().any(|(by, _)| by.value == *value);
        chain.idle = (0..robot.moved.len()).filter(|value| !is_driven(value)).collect();
        chain.is_bounded = errors.iter().all(FrameError::is_bounded);
        // Without bounds every state is placed as [`Robot::place`] does it.
        let error =
            |link: usize| if chain.is_bounded { errors[link] } else { FrameError::default() };
        chain.errors = links.iter().map(|link| error(link.link)).collect();
        chain.values = ValueRow::of(&chain, robot.moved.len());
        chain
    }

    /// Tells the links, of those with spheres, what the rounding of their places comes to.
    pub(super) fn bound(&self, links: &mut [LinkSpheres]) {
        for (link, error) in links.iter_mut().zip(&self.errors) {
            let [still, per_slid] = error.of_size(link.size);
            link.lost = [link.margin + still, per_slid];
        }
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
    pub(super) fn read(&self, robot: &Robot, states: &[&[f64]], to: &mut Drives) -> u32 {
        if (to.rows.len(), to.turns.len()) != (self.drives.len(), self.quaternions.len()) {
            to.rows.resize(self.drives.len(), Row::default());
            to.turns.resize(self.quaternions.len(), [Row::default(); 9]);
        }
        let mut open = 0;
        for (lane, &state) in states.iter().take(WIDTH).enumerate() {
            if !self.read_state(robot, state, lane, to) {
                open |= 1 << lane;
                to.rows.iter_mut().for_each(|row| row.0[lane] = 0.0);
                if let Some(alone) = to.alone.get_mut(lane) {
                    *alone = Row::default();
                }
            }
        }
        open
    }

    /// The same of one state. Returns whether the bounds cover it. A function of its own: around its loops the compiler would
    /// prepare more for sixteen states than one of them takes.
    #[inline(never)]
    fn read_state(&self, robot: &Robot, state: &[f64], lane: usize, to: &mut Drives) -> bool {
        if state.len() != robot.moved.len() {
            return false;
        }
        // What moves nothing has to be a number too.
        let mut is_known = self.is_bounded;
        for &value in &self.idle {
            is_known &= state[value].is_finite();
        }
        let alone = to.alone.get_mut(lane).map_or(&mut [][..], |row| &mut row.0);
        let mut alone = alone.iter_mut();
        for ((by, most), row) in self.drives.iter().zip(&mut to.rows) {
            let value = state[by.value] * by.factor + by.offset;
            is_known &= value.abs() <= *most;
            row.0[lane % WIDTH] = value as f32;
            if let Some(number) = alone.next() {
                *number = value as f32;
            }
        }
        if !self.quaternions.is_empty() {
            is_known &= robot.check_state(state).is_ok();
            self.read_turns(state, lane, to);
        }
        is_known
    }

    /// Takes the rotations of a state's quaternions.
    fn read_turns(&self, state: &[f64], lane: usize, to: &mut Drives) {
        for (&first, rows) in self.quaternions.iter().zip(&mut to.turns) {
            let turn = DMat3::from_quat(quaternion(state, first).normalize());
            for (row, number) in rows.iter_mut().zip(turn.to_cols_array()) {
                row.0[lane] = number as f32;
            }
        }
    }

    /// Places the links: `to` has a frame for each. Returns what all joints slide together, metres.
    #[inline(always)]
    pub(super) fn place<L: Numbers>(
        &self,
        l: L,
        drives: &Drives,
        to: &mut Vec<RoundedLink>,
    ) -> L::F {
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
                    let sines = l.sin_cos(&drives.rows, row);
                    turn_about(l, (axis, sign), sines, &mut frame);
                }
                Moves::Turns(axis, row) => {
                    let rotation = rotation(l, axis, l.sin_cos(&drives.rows, row));
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

    fn other(self) -> Self {
        match self {
            Self::Plus => Self::Minus,
            Self::Minus => Self::Plus,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn quarters_are_the_turns_by_right_angles() {
        type Quarters = fn(Sign) -> Quarter;
        let about: [(DVec3, Quarters); 3] =
            [(DVec3::X, Quarter::X), (DVec3::Y, Quarter::Y), (DVec3::Z, Quarter::Z)];
        for (axis, quarter) in about {
            for (angle, sign) in [(FRAC_PI_2, Sign::Plus), (-FRAC_PI_2, Sign::Minus)] {
                let (turned, _) = columns(&DMat3::from_axis_angle(axis, angle));
                assert_eq!(turned.as_ref().and_then(Quarter::of), Some(quarter(sign)));
            }
            let (half, _) = columns(&DMat3::from_axis_angle(axis, 2.0 * FRAC_PI_2));
            assert_eq!(half.as_ref().and_then(Quarter::of), None);
        }
    }
}
