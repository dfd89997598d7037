//! The kernels of [`Slices`](super::Slices): plain f64 without fused multiply-add.

// In kernels: an iterator that is left out of line costs more than the loop.
#![allow(clippy::needless_range_loop)]

use super::super::super::ROUNDED_UP;
use super::super::super::bounding_volumes::Solid;
use super::super::super::path::JointPath;
use super::{NONE, Row, SphereRow, TURNED, TwistRow};
use crate::kinematics::JointFrame;
use crate::state_checker::link_frames::{FrameRow, HALF, LinkFrames};
use crate::{Drive, Motion, Robot};
use dcd_simd::{Kernel, Lanes, larger};
use glam::{DMat3, DVec3};

/// What bounds how two bodies close.
#[derive(Clone, Copy)]
pub(super) struct Moved {
    pub(super) half: f64,
    /// What both move by their accelerations.
    pub(super) change: f64,
    /// What coordinates may be off by.
    pub(super) off: f64,
}

impl Moved {
    /// At most what a gap closes in half a slice: the speed along the way between both, a way of length `far` times that speed being
    /// `along`.
    #[inline(always)]
    fn closed(&self, along: f64, speed: f64, far: f64) -> f64 {
        let closing = (along + TURNED * self.off * speed) / far;
        // Where it is no number the speed itself.
        let closing = if closing < speed { closing } else { speed };
        (self.half * closing + self.change) * ROUNDED_UP
    }
}

pub(super) struct Twists<'a> {
    pub(super) robot: &'a Robot,
    pub(super) path: &'a JointPath,
    /// For each value of a state.
    pub(super) rates: &'a [Row],
    pub(super) frames: &'a LinkFrames,
    pub(super) to: &'a mut [TwistRow],
}

impl Kernel for Twists<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        let Self { robot, path, rates, frames, to } = self;
        let base = robot.base.translation;
        for joint in robot.joints() {
            let mut twist = to[joint.parent];
            let (parent, child) = (&frames.frames[joint.parent], &frames.frames[joint.child]);
            match joint.motion {
                Motion::Fixed => {}
                // Its own turn leaves its axis where it is.
                Motion::Turns { axis, by } => {
                    turn(&mut twist, (child, axis), driven(rates, by), (child, base));
                }
                Motion::Slides { axis, by } => {
                    let rate = driven(rates, by);
                    for h in 0..2 {
                        for k in 0..HALF {
                            let along = turned(child, axis, h, k);
                            for i in 0..3 {
                                twist.at_base[i][h][k] += along[i] * rate[h][k];
                            }
                        }
                    }
                }
                Motion::Orients { first } => {
                    let axis = joint.origin.rotation * path.turn(first);
                    turn(&mut twist, (parent, axis), [[1.0; HALF]; 2], (child, base));
                }
            }
            to[joint.child] = twist;
        }
    }
}

/// How fast a joint's value changes.
#[inline(always)]
fn driven(rates: &[Row], by: Drive) -> Row {
    let mut rate = rates[by.value];
    for h in 0..2 {
        for k in 0..HALF {
            rate[h][k] *= by.factor;
        }
    }
    rate
}

/// A vector of the frame, in the world.
#[inline(always)]
fn turned(frame: &FrameRow, v: DVec3, h: usize, k: usize) -> [f64; 3] {
    let at = |i: usize| frame[i][h][k] * v.x + frame[3 + i][h][k] * v.y + frame[6 + i][h][k] * v.z;
    [at(0), at(1), at(2)]
}

/// Adds a turn about an axis of a frame, at so many rad a unit of t, about the joint's own place.
#[inline(always)]
fn turn(
    twist: &mut TwistRow,
    (frame, axis): (&FrameRow, DVec3),
    rate: Row,
    (joint, base): (&FrameRow, DVec3),
) {
    for h in 0..2 {
        for k in 0..HALF {
            let [x, y, z] = turned(frame, axis, h, k);
            let (x, y, z) = (x * rate[h][k], y * rate[h][k], z * rate[h][k]);
            let (dx, dy) = (joint[9][h][k] - base.x, joint[10][h][k] - base.y);
            let dz = joint[11][h][k] - base.z;
            twist.turn[0][h][k] += x;
            twist.turn[1][h][k] += y;
            twist.turn[2][h][k] += z;
            twist.at_base[0][h][k] += dy * z - dz * y;
            twist.at_base[1][h][k] += dz * x - dx * z;
            twist.at_base[2][h][k] += dx * y - dy * x;
        }
    }
}

pub(super) struct PlaceSphere<'a> {
    /// Of the link.
    pub(super) frame: &'a FrameRow,
    /// Of the part in that.
    pub(super) origin: &'a JointFrame,
    /// In the part's frame.
    pub(super) centre: DVec3,
    pub(super) twist: &'a TwistRow,
    pub(super) base: DVec3,
    pub(super) to: &'a mut SphereRow,
}

impl Kernel for PlaceSphere<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        let Self { frame, origin, centre, twist, base, to } = self;
        let is_turned = origin.rotation != DMat3::IDENTITY;
        let columns = origin.rotation.to_cols_array_2d();
        let mut part = *frame;
        if is_turned {
            for j in 0..3 {
                let column = DVec3::from_array(columns[j]);
                for h in 0..2 {
                    for k in 0..HALF {
                        let column = turned(frame, column, h, k);
                        for i in 0..3 {
                            part[3 * j + i][h][k] = column[i];
                        }
                    }
                }
            }
        }
        let mut deviations = NONE;
        for h in 0..2 {
            for k in 0..HALF {
                let (c, o) = (turned(&part, centre, h, k), turned(frame, origin.translation, h, k));
                let at = |i: usize| c[i] + (o[i] + frame[9 + i][h][k]);
                let [x, y, z] = [at(0), at(1), at(2)];
                let (dx, dy, dz) = (x - base.x, y - base.y, z - base.z);
                let turn = |i: usize| twist.turn[i][h][k];
                let vx = twist.at_base[0][h][k] + (turn(1) * dz - turn(2) * dy);
                let vy = twist.at_base[1][h][k] + (turn(2) * dx - turn(0) * dz);
                let vz = twist.at_base[2][h][k] + (turn(0) * dy - turn(1) * dx);
                (to.centre[0][h][k], to.centre[1][h][k], to.centre[2][h][k]) = (x, y, z);
                (to.velocity[0][h][k], to.velocity[1][h][k], to.velocity[2][h][k]) = (vx, vy, vz);
                to.speed[h][k] = (vx * vx + vy * vy + vz * vz).sqrt();
                // Of the rows with each other.
                let dot = |i: usize, j: usize| {
                    part[i][h][k] * part[j][h][k]
                        + part[3 + i][h][k] * part[3 + j][h][k]
                        + part[6 + i][h][k] * part[6 + j][h][k]
                };
                let (xy, xz, yz) = (dot(0, 1).abs(), dot(0, 2).abs(), dot(1, 2).abs());
                let square = |i: usize| (dot(i, i) - 1.0).abs();
                let most = larger(square(1) + xy + yz, square(0) + xy + xz);
                deviations[h][k] = larger(square(2) + xz + yz, most);
            }
        }
        let largest = deviations.as_flattened().iter().fold(0.0, |a, &b| larger(b, a));
        // As a pose's is, for what these sums lose.
        to.deviation = largest + 24.0 * f64::EPSILON;
    }
}

pub(super) struct BetweenSpheres<'a> {
    pub(super) row: &'a SphereRow,
    pub(super) other: &'a SphereRow,
    pub(super) moved: Moved,
    /// Both radii, what coordinates may be off by, and how far apart both are to be.
    pub(super) lost: f64,
}

impl Kernel for BetweenSpheres<'_> {
    type Output = u16;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> u16 {
        let Self { row, other, moved, lost } = self;
        let mut margin = NONE;
        for h in 0..2 {
            for k in 0..HALF {
                let way = |i: usize| other.centre[i][h][k] - row.centre[i][h][k];
                let speed = |i: usize| other.velocity[i][h][k] - row.velocity[i][h][k];
                let ([x, y, z], [u, v, w]) =
                    ([way(0), way(1), way(2)], [speed(0), speed(1), speed(2)]);
                let far = (x * x + y * y + z * z).sqrt();
                let speed = (u * u + v * v + w * w).sqrt();
                let along = (x * u + y * v + z * w).abs();
                margin[h][k] = far - lost - moved.closed(along, speed, far);
            }
        }
        not_positive(l, &margin)
    }
}

pub(super) struct ToSolid<'a> {
    pub(super) row: &'a SphereRow,
    /// The solid's rotation, transposed, and its place.
    pub(super) inverse: DMat3,
    pub(super) from: DVec3,
    pub(super) solid: &'a Solid,
    pub(super) moved: Moved,
    /// The radius, what coordinates may be off by, and how far apart both are to be.
    pub(super) lost: f64,
}

impl Kernel for ToSolid<'_> {
    type Output = u16;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> u16 {
        let Self { row, inverse, from, solid, moved, lost } = self;
        let [mx, my, mz] = inverse.to_cols_array_2d();
        let within = |[x, y, z]: [f64; 3]| {
            let at = |i: usize| mx[i] * x + my[i] * y + mz[i] * z;
            [at(0), at(1), at(2)]
        };
        let (mut far, mut along) = (NONE, NONE);
        let at = |h: usize, k: usize| {
            let [x, y, z] = &row.centre;
            within([x[h][k] - from.x, y[h][k] - from.y, z[h][k] - from.z])
        };
        let speed = |h: usize, k: usize| {
            let [x, y, z] = &row.velocity;
            within([x[h][k], y[h][k], z[h][k]])
        };
        let swept = match *solid {
            Solid::Box { middle, half, swept } => {
                for h in 0..2 {
                    for k in 0..HALF {
                        let ([x, y, z], [u, v, w]) = (at(h, k), speed(h, k));
                        let x = beyond(x - middle.x, half.x);
                        let y = beyond(y - middle.y, half.y);
                        let z = beyond(z - middle.z, half.z);
                        far[h][k] = (x * x + y * y + z * z).sqrt();
                        along[h][k] = (x * u + y * v + z * w).abs();
                    }
                }
                swept
            }
            Solid::Cylinder { half, radius, swept } => {
                for h in 0..2 {
                    for k in 0..HALF {
                        let ([x, y, z], [u, v, w]) = (at(h, k), speed(h, k));
                        let flat = (x * x + y * y).sqrt();
                        let (side, end) = (larger(0.0, flat - radius), beyond(z, half));
                        far[h][k] = (side * side + end * end).sqrt();
                        let out = if side > 0.0 { side * (x * u + y * v) / flat } else { 0.0 };
                        along[h][k] = (out + end * w).abs();
                    }
                }
                swept
            }
        };
        let mut margin = NONE;
        for h in 0..2 {
            for k in 0..HALF {
                let closed = moved.closed(along[h][k], row.speed[h][k], far[h][k]);
                margin[h][k] = far[h][k] - swept - lost - closed;
            }
        }
        not_positive(l, &margin)
    }
}

/// How far x is beyond an end, with its sign; 0 between the ends.
#[inline(always)]
fn beyond(x: f64, half: f64) -> f64 {
    larger(0.0, x.abs() - half).copysign(x)
}

/// The lanes in which a number is not above 0: so is none that is no number.
#[inline(always)]
fn not_positive<L: Lanes>(l: L, row: &Row) -> u16 {
    let zero = l.splat_d(0.0);
    let [first, second] = [l.lt_d(zero, l.load_d(&row[0])), l.lt_d(zero, l.load_d(&row[1]))];
    !(first | second << HALF) as u16
}
