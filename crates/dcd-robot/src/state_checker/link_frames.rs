//! Where the links of sixteen states are: the operations of [`Robot::place`] in lanes, each rounded as it is
//! there, so that every frame is the same bit for bit.

// In kernels: an iterator that is left out of line costs more than the loop.
#![allow(clippy::needless_range_loop)]

use crate::angle::{FAR, InLanes, near_sin_cos, sin_cos};
use crate::kinematics::{JointFrame, moved};
use crate::{Joint, Motion, Robot};
use dcd_simd::{Kernel, Lanes, WIDTH};
use glam::{DMat3, DVec3};

/// How many f64 lanes there are.
pub(crate) const HALF: usize = WIDTH / 2;

/// A number of each of sixteen states.
pub(crate) type Numbers = [[f64; HALF]; 2];

/// A link's frame in each of sixteen states: the rotation's columns, x, y and z of each, then the translation.
pub(crate) type FrameRow = [Numbers; 12];

/// The frames of all links in sixteen states.
#[derive(Clone, Debug, Default)]
pub(crate) struct LinkFrames {
    pub(crate) frames: Vec<FrameRow>,
    /// Those of the state that was last placed alone: read there, they are next to each other.
    alone: Vec<JointFrame>,
    /// For each joint what it is moved by: an angle or a length.
    drives: Vec<Numbers>,
    /// Whether some angle is too far from 0 for lanes.
    has_far_angles: bool,
    /// Of all numbers of all frames of a state.
    sums: Numbers,
}

impl LinkFrames {
    /// Takes the values of the joints from at most sixteen states, which have been checked. Lanes past the last are
    /// left as they are.
    pub(crate) fn read(&mut self, robot: &Robot, states: &[&[f64]]) {
        self.frames.resize(robot.links.len(), [[[0.0; HALF]; 2]; 12]);
        self.drives.resize(robot.joints.len(), [[0.0; HALF]; 2]);
        let mut farthest = 0.0;
        for (joint, drive) in robot.joints.iter().zip(&mut self.drives) {
            let Some(by) = joint.motion.drive() else { continue };
            for (lane, state) in states.iter().take(WIDTH).enumerate() {
                let value = by.of(state).unwrap_or_default();
                drive[lane / HALF][lane % HALF] = value;
                farthest = if value.abs() > farthest { value.abs() } else { farthest };
            }
        }
        self.has_far_angles = farthest > FAR;
    }

    /// The frame of a link in one of the states.
    pub(super) fn frame(&self, link: usize, lane: usize) -> JointFrame {
        let row = &self.frames[link];
        let number = |k: usize| row[k][lane / HALF][lane % HALF];
        let column = |k: usize| DVec3::new(number(k), number(k + 1), number(k + 2));
        JointFrame {
            rotation: DMat3::from_cols(column(0), column(3), column(6)),
            translation: column(9),
        }
    }

    /// Whether all frames of one of the states are known to be numbers: their sums are, which infinite numbers and
    /// NaN make infinite or NaN. Sums of what is finite may be infinite too.
    pub(crate) fn is_finite(&self, lane: usize) -> bool {
        self.sums[lane / HALF][lane % HALF].is_finite()
    }

    /// Moves the links of one state alone, in its lane: the numbers of [`PlaceFrames`], without the cost of other lanes.
    /// The state has been checked.
    pub(super) fn place_alone(&mut self, robot: &Robot, state: &[f64], lane: usize) {
        self.frames.resize(robot.links.len(), [[[0.0; HALF]; 2]; 12]);
        self.alone.resize(robot.links.len(), JointFrame::IDENTITY);
        self.alone[robot.root] = robot.base;
        self.set_frame(robot.root, lane, &robot.base);
        let mut sum = 0.0;
        for joint in &robot.joints {
            let rest = self.alone[joint.parent].then(&joint.origin);
            let frame = moved(&rest, joint, state);
            self.alone[joint.child] = frame;
            self.set_frame(joint.child, lane, &frame);
            let columns = frame.rotation.x_axis + frame.rotation.y_axis + frame.rotation.z_axis;
            sum += (columns + frame.translation).element_sum();
        }
        self.sums[lane / HALF][lane % HALF] = sum;
    }

    fn set_frame(&mut self, link: usize, lane: usize, frame: &JointFrame) {
        let numbers = frame.rotation.to_cols_array().into_iter();
        let numbers = numbers.chain(frame.translation.to_array());
        for (row, number) in self.frames[link].iter_mut().zip(numbers) {
            row[lane / HALF][lane % HALF] = number;
        }
    }
}

/// Moves the links: joint by joint, so that a parent's frame is there before its child's. Lanes past the last state
/// mean nothing.
pub(crate) struct PlaceFrames<'a> {
    pub(crate) robot: &'a Robot,
    /// At most sixteen, those that were read.
    pub(crate) states: &'a [&'a [f64]],
    pub(crate) to: &'a mut LinkFrames,
}

impl Kernel for PlaceFrames<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self { robot, states, to } = self;
        let base = robot.base.rotation.to_cols_array();
        let DVec3 { x, y, z } = robot.base.translation;
        for (k, number) in base.into_iter().chain([x, y, z]).enumerate() {
            to.frames[robot.root][k] = [[number; HALF]; 2];
        }
        let (halves, mut sums) = (states.len().div_ceil(HALF), [l.splat_d(0.0); 2]);
        for (number, joint) in robot.joints.iter().enumerate() {
            if let Motion::Orients { .. } = joint.motion {
                for (lane, state) in states.iter().enumerate() {
                    let rest = to.frame(joint.parent, lane).then(&joint.origin);
                    to.set_frame(joint.child, lane, &moved(&rest, joint, state));
                }
                for half in 0..halves {
                    let frame = loaded(l, &to.frames[joint.child], half);
                    sums[half] = l.add_d(sums[half], sum(l, &frame));
                }
                continue;
            }
            let drive = &to.drives[number];
            for half in 0..halves {
                let frame = loaded(l, &to.frames[joint.parent], half);
                let drive = match joint.motion {
                    Motion::Turns { .. } if to.has_far_angles => {
                        let mut both = [[0.0; HALF]; 2];
                        for (lane, &angle) in drive[half].iter().enumerate() {
                            [both[0][lane], both[1][lane]] = sin_cos(angle);
                        }
                        both.map(
                            #[inline(always)]
                            |row| l.load_d(&row),
                        )
                    }
                    Motion::Turns { .. } => near_sin_cos(InLanes(l), l.load_d(&drive[half])),
                    _ => [l.load_d(&drive[half]); 2],
                };
                let frame = driven(l, then(l, frame, &joint.origin), joint, drive);
                let child = &mut to.frames[joint.child];
                for k in 0..12 {
                    l.store_d(frame[k], &mut child[k][half]);
                }
                sums[half] = l.add_d(sums[half], sum(l, &frame));
            }
        }
        for half in 0..halves {
            l.store_d(sums[half], &mut to.sums[half]);
        }
    }
}

#[inline(always)]
fn loaded<L: Lanes>(l: L, row: &FrameRow, half: usize) -> [L::D; 12] {
    let mut frame = [l.splat_d(0.0); 12];
    for k in 0..12 {
        frame[k] = l.load_d(&row[k][half]);
    }
    frame
}

#[inline(always)]
fn sum<L: Lanes>(l: L, frame: &[L::D; 12]) -> L::D {
    let mut sums = [frame[0], frame[1], frame[2]];
    for k in 3..12 {
        sums[k % 3] = l.add_d(sums[k % 3], frame[k]);
    }
    l.add_d(l.add_d(sums[0], sums[1]), sums[2])
}

/// [`JointFrame::then`].
#[inline(always)]
fn then<L: Lanes>(l: L, outer: [L::D; 12], inner: &JointFrame) -> [L::D; 12] {
    let mut frame = outer;
    if inner.rotation != DMat3::IDENTITY {
        let columns = inner.rotation.to_cols_array();
        for k in 0..3 {
            let column = vector(l, columns[3 * k], columns[3 * k + 1], columns[3 * k + 2]);
            set_column(&mut frame, k, turned(l, &outer, column));
        }
    }
    let DVec3 { x, y, z } = inner.translation;
    slid(l, &outer, vector(l, x, y, z), &mut frame);
    frame
}

/// Number by number: a slice would be copied by a call.
#[inline(always)]
fn set_column<D: Copy>(frame: &mut [D; 12], k: usize, [x, y, z]: [D; 3]) {
    (frame[3 * k], frame[3 * k + 1], frame[3 * k + 2]) = (x, y, z);
}

#[inline(always)]
fn vector<L: Lanes>(l: L, x: f64, y: f64, z: f64) -> [L::D; 3] {
    [l.splat_d(x), l.splat_d(y), l.splat_d(z)]
}

/// [`moved`] of what turns, slides or stays.
#[inline(always)]
fn driven<L: Lanes>(l: L, rest: [L::D; 12], joint: &Joint, drive: [L::D; 2]) -> [L::D; 12] {
    let mut frame = rest;
    match joint.motion {
        Motion::Turns { axis, .. } => {
            let rotation = rotation(l, axis, drive);
            for k in 0..3 {
                set_column(&mut frame, k, turned(l, &rest, rotation[k]));
            }
        }
        Motion::Slides { axis: DVec3 { x, y, z }, .. } => {
            let axis = vector(l, x, y, z);
            let along = [
                l.mul_d(axis[0], drive[0]),
                l.mul_d(axis[1], drive[0]),
                l.mul_d(axis[2], drive[0]),
            ];
            slid(l, &rest, along, &mut frame);
        }
        Motion::Fixed | Motion::Orients { .. } => {}
    }
    frame
}

/// The frame's rotation times a vector, and its translation added: the translation of another.
#[inline(always)]
fn slid<L: Lanes>(l: L, frame: &[L::D; 12], by: [L::D; 3], to: &mut [L::D; 12]) {
    let offset = turned(l, frame, by);
    for k in 0..3 {
        to[9 + k] = l.add_d(offset[k], frame[9 + k]);
    }
}

/// The frame's rotation times a vector, summed as glam sums it.
#[inline(always)]
fn turned<L: Lanes>(l: L, frame: &[L::D; 12], [x, y, z]: [L::D; 3]) -> [L::D; 3] {
    let mut sum = [x; 3];
    for k in 0..3 {
        let two = l.add_d(l.mul_d(frame[k], x), l.mul_d(frame[3 + k], y));
        sum[k] = l.add_d(two, l.mul_d(frame[6 + k], z));
    }
    sum
}

/// [`dcd_gjk::motion::rotation_from_axis_angle`] by its columns.
#[inline(always)]
fn rotation<L: Lanes>(l: L, axis: DVec3, [sin, cos]: [L::D; 2]) -> [[L::D; 3]; 3] {
    let DVec3 { x, y, z } = axis;
    let (one, versine) = (l.splat_d(1.0), l.sub_d(l.splat_d(1.0), cos));
    let (xx, yy, zz) = (x * x, y * y, z * z);
    let xy = times(l, x * y, versine);
    let xz = times(l, x * z, versine);
    let yz = times(l, y * z, versine);
    [
        [
            l.sub_d(one, times(l, zz + yy, versine)),
            l.add_d(times(l, z, sin), xy),
            l.add_d(times(l, -y, sin), xz),
        ],
        [
            l.add_d(times(l, -z, sin), xy),
            l.sub_d(one, times(l, zz + xx, versine)),
            l.add_d(times(l, x, sin), yz),
        ],
        [
            l.add_d(times(l, y, sin), xz),
            l.add_d(times(l, -x, sin), yz),
            l.sub_d(one, times(l, yy + xx, versine)),
        ],
    ]
}

#[inline(always)]
fn times<L: Lanes>(l: L, factor: f64, x: L::D) -> L::D {
    l.mul_d(l.splat_d(factor), x)
}
