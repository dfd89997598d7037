//! Where the links of sixteen states are: the operations of [`Robot::place`] in lanes, each rounded as it is
//! there, so that every frame is the same bit for bit.

use crate::kinematics::{JointFrame, moved};
use crate::{Joint, Motion, Robot};
use dcd_simd::{Kernel, Lanes, WIDTH};
use glam::{DMat3, DVec3};

/// How many f64 lanes there are.
const HALF: usize = WIDTH / 2;

/// A number of each of sixteen states.
pub(super) type Numbers = [[f64; HALF]; 2];

/// A link's frame in each of sixteen states: the rotation's columns, x, y and z of each, then the translation.
pub(super) type FrameRow = [Numbers; 12];

/// The frames of all links in sixteen states.
#[derive(Clone, Debug, Default)]
pub(super) struct LinkFrames {
    pub(super) frames: Vec<FrameRow>,
    /// For each joint what it is moved by: the sine and cosine of an angle, or a length.
    drives: Vec<[Numbers; 2]>,
}

impl LinkFrames {
    /// Takes the values of the joints from at most sixteen states, which have been checked. Lanes past the last are
    /// left as they are.
    pub(super) fn read(&mut self, robot: &Robot, states: &[impl AsRef<[f64]>]) {
        self.frames.resize(robot.links.len(), [[[0.0; HALF]; 2]; 12]);
        self.drives.resize(robot.joints.len(), [[[0.0; HALF]; 2]; 2]);
        for (joint, drive) in robot.joints.iter().zip(&mut self.drives) {
            let Some(by) = joint.motion.drive() else { continue };
            let turns = matches!(joint.motion, Motion::Turns { .. });
            for (lane, state) in states.iter().take(WIDTH).enumerate() {
                let value = by.of(state.as_ref()).unwrap_or_default();
                let (a, b) = if turns { libm::sincos(value) } else { (value, 0.0) };
                drive[0][lane / HALF][lane % HALF] = a;
                drive[1][lane / HALF][lane % HALF] = b;
            }
        }
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

    /// Whether all frames of one of the states are numbers.
    pub(super) fn is_finite(&self, lane: usize) -> bool {
        // Zero times what is infinite or no number is no number.
        let zero = |row: &FrameRow| {
            row.iter().fold(0.0, |sum, numbers| sum + 0.0 * numbers[lane / HALF][lane % HALF])
        };
        self.frames.iter().fold(0.0, |sum, row| sum + zero(row)) == 0.0
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
pub(super) struct Place<'a, S> {
    pub(super) robot: &'a Robot,
    /// At most sixteen, those that were read.
    pub(super) states: &'a [S],
    pub(super) to: &'a mut LinkFrames,
}

impl<S: AsRef<[f64]>> Kernel for Place<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self { robot, states, to } = self;
        for lane in 0..WIDTH {
            to.set_frame(robot.root, lane, &robot.base);
        }
        for (number, joint) in robot.joints.iter().enumerate() {
            if let Motion::Orients { .. } = joint.motion {
                for (lane, state) in states.iter().enumerate() {
                    let rest = to.frame(joint.parent, lane).then(&joint.origin);
                    to.set_frame(joint.child, lane, &moved(&rest, joint, state.as_ref()));
                }
                continue;
            }
            let drive = &to.drives[number];
            for half in 0..states.len().div_ceil(HALF) {
                let parent = &to.frames[joint.parent];
                let mut frame = [l.splat_d(0.0); 12];
                for k in 0..12 {
                    frame[k] = l.load_d(&parent[k][half]);
                }
                let drive = [l.load_d(&drive[0][half]), l.load_d(&drive[1][half])];
                let frame = driven(l, then(l, frame, &joint.origin), joint, drive);
                let child = &mut to.frames[joint.child];
                for k in 0..12 {
                    l.store_d(frame[k], &mut child[k][half]);
                }
            }
        }
    }
}

/// [`JointFrame::then`].
#[inline(always)]
fn then<L: Lanes>(l: L, outer: [L::D; 12], inner: &JointFrame) -> [L::D; 12] {
    let mut frame = outer;
    if inner.rotation != DMat3::IDENTITY {
        let columns = inner.rotation.to_cols_array();
        for k in 0..3 {
            let column = vector(l, columns[3 * k], columns[3 * k + 1], columns[3 * k + 2]);
            let column = turned(l, &outer, column);
            frame[3 * k..3 * k + 3].copy_from_slice(&column);
        }
    }
    let DVec3 { x, y, z } = inner.translation;
    slid(l, &outer, vector(l, x, y, z), &mut frame);
    frame
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
                frame[3 * k..3 * k + 3].copy_from_slice(&turned(l, &rest, rotation[k]));
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
