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
    /// Takes the values of the joints from at most sixteen states, which have been checked; past the last one
    /// that one again.
    pub(super) fn read(&mut self, robot: &Robot, states: &[impl AsRef<[f64]>]) {
        self.frames.resize(robot.links.len(), [[[0.0; HALF]; 2]; 12]);
        self.drives.resize(robot.joints.len(), [[[0.0; HALF]; 2]; 2]);
        for (joint, drive) in robot.joints.iter().zip(&mut self.drives) {
            let Some(by) = joint.motion.drive() else { continue };
            let turns = matches!(joint.motion, Motion::Turns { .. });
            for lane in 0..WIDTH {
                let state = states[lane.min(states.len() - 1)].as_ref();
                let value = by.of(state).unwrap_or_default();
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

    fn set_frame(&mut self, link: usize, lane: usize, frame: &JointFrame) {
        let numbers = frame.rotation.to_cols_array().into_iter();
        let numbers = numbers.chain(frame.translation.to_array());
        for (row, number) in self.frames[link].iter_mut().zip(numbers) {
            row[lane / HALF][lane % HALF] = number;
        }
    }
}

/// Moves the links: joint by joint, so that a parent's frame is there before its child's.
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
                for lane in 0..WIDTH {
                    let state = states[lane.min(states.len() - 1)].as_ref();
                    let rest = to.frame(joint.parent, lane).then(&joint.origin);
                    to.set_frame(joint.child, lane, &moved(&rest, joint, state));
                }
                continue;
            }
            let drive = &to.drives[number];
            for half in 0..2 {
                let parent = &to.frames[joint.parent];
                let frame = std::array::from_fn(
                    #[inline(always)]
                    |k| l.load_d(&parent[k][half]),
                );
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
            let column = [columns[3 * k], columns[3 * k + 1], columns[3 * k + 2]];
            let column = turned(
                l,
                &outer,
                [l.splat_d(column[0]), l.splat_d(column[1]), l.splat_d(column[2])],
            );
            frame[3 * k..3 * k + 3].copy_from_slice(&column);
        }
    }
    let [x, y, z] = inner.translation.to_array();
    let offset = turned(l, &outer, [l.splat_d(x), l.splat_d(y), l.splat_d(z)]);
    for k in 0..3 {
        frame[9 + k] = l.add_d(offset[k], outer[9 + k]);
    }
    frame
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
        Motion::Slides { axis, .. } => {
            let along = axis.to_array();
            let along = [0, 1, 2].map(
                #[inline(always)]
                |k| l.mul_d(l.splat_d(along[k]), drive[0]),
            );
            let offset = turned(l, &rest, along);
            for k in 0..3 {
                frame[9 + k] = l.add_d(offset[k], rest[9 + k]);
            }
        }
        Motion::Fixed | Motion::Orients { .. } => {}
    }
    frame
}

/// The frame's rotation times a vector, summed as glam sums it.
#[inline(always)]
fn turned<L: Lanes>(l: L, frame: &[L::D; 12], [x, y, z]: [L::D; 3]) -> [L::D; 3] {
    [0, 1, 2].map(
        #[inline(always)]
        |k| {
            let sum = l.add_d(l.mul_d(frame[k], x), l.mul_d(frame[3 + k], y));
            l.add_d(sum, l.mul_d(frame[6 + k], z))
        },
    )
}

/// [`dcd_gjk::motion::rotation_from_axis_angle`] by its columns.
#[inline(always)]
fn rotation<L: Lanes>(l: L, axis: DVec3, [sin, cos]: [L::D; 2]) -> [[L::D; 3]; 3] {
    let DVec3 { x, y, z } = axis;
    let (one, versine) = (l.splat_d(1.0), l.sub_d(l.splat_d(1.0), cos));
    let by_sine = |factor: f64| l.mul_d(l.splat_d(factor), sin);
    let by_versine = |factor: f64| l.mul_d(l.splat_d(factor), versine);
    let (xx, yy, zz) = (x * x, y * y, z * z);
    let (xy, xz, yz) = (by_versine(x * y), by_versine(x * z), by_versine(y * z));
    let diagonal = |others: f64| l.sub_d(one, by_versine(others));
    [
        [diagonal(zz + yy), l.add_d(by_sine(z), xy), l.add_d(by_sine(-y), xz)],
        [l.add_d(by_sine(-z), xy), diagonal(zz + xx), l.add_d(by_sine(x), yz)],
        [l.add_d(by_sine(y), xz), l.add_d(by_sine(-x), yz), diagonal(yy + xx)],
    ]
}
