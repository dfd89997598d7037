//! Sixteen equal parts of a path together, in lanes: which pairs the spheres round their objects prove apart in which of them.
//!
//! Plain f64 without fused multiply-add: the same bits on every SIMD path.

// In kernels: an iterator that is left out of line costs more than the loop.
#![allow(clippy::needless_range_loop)]

use super::super::bounding_volumes::{BoundingVolumes, Solid};
use super::super::path::JointPath;
use super::super::{EdgePair, ROUNDED_UP};
use super::{EdgeSearch, Node};
use crate::kinematics::JointFrame;
use crate::state_checker::link_frames::{FrameRow, HALF, LinkFrames, Numbers, Place};
use crate::{Drive, Motion, Robot};
use dcd_geom::Pose;
use dcd_simd::{Kernel, Lanes, WIDTH, dispatch};
use glam::{DMat3, DVec3};

/// A number of each slice.
type Row = Numbers;

/// Coordinates, one row each.
type Points = [Row; 3];

const NONE: Row = [[0.0; HALF]; 2];

/// What rounding may do to the way between two bodies, in units of what it may do to their distance: it turns the direction
/// along which their speed counts (docs/numerics/proofs.md, "edges"). No unit. Smaller: speeds below the truth.
const TURNED: f64 = 8.0;

/// What is known of the path's beginning, cut into sixteen slices of one length.
#[derive(Default)]
pub(super) struct Slices {
    /// Where the last one ends; 0 where nothing is known.
    pub(super) end: f64,
    /// For each pair, then for each group of pairs, a bit for each slice in which it is not proved apart.
    pub(super) open: Vec<u16>,
}

impl Slices {
    /// The slices that a node has a part of, a bit each.
    pub(super) fn of(&self, node: &Node) -> u16 {
        if self.end == 0.0 {
            return u16::MAX;
        }
        // Exact: a node is the whole, halved some times.
        let slice = |t: f64| t / self.end * WIDTH as f64;
        let (first, last) = (slice(node.from).floor() as u32, slice(node.to).ceil() as u32);
        let below = |k: u32| (1u32 << k.min(WIDTH as u32)) - 1;
        (below(last) & !below(first)) as u16
    }

    /// Whether a pair, or a group by its number behind theirs, is proved apart in all of those slices.
    pub(super) fn prove(&self, open: u32, slices: u16) -> bool {
        self.open.get(open as usize).is_some_and(|open| open & slices == 0)
    }
}

/// How the links move in each slice's middle: the turn, and how fast the point at the base would move.
#[derive(Clone, Copy)]
struct TwistRow {
    turn: Points,
    at_base: Points,
}

/// A sphere round an object in each slice's middle.
struct SphereRow {
    centre: Points,
    velocity: Points,
    speed: Row,
    radius: f64,
    /// [`Pose::deviation`], the largest of all slices.
    deviation: f64,
    /// How large the acceleration of its centre is at most, against the frames of the joints of its chain.
    accelerations: Vec<f64>,
}

/// The spheres of what moves, as they are needed.
struct Spheres {
    frames: LinkFrames,
    twists: Vec<TwistRow>,
    rows: Vec<Option<SphereRow>>,
}

/// What a pair is asked in all slices.
#[derive(Clone, Copy)]
struct Asked {
    /// How long a slice is, half.
    half: f64,
    /// By more than that a pair is to be apart.
    nearest: f64,
}

impl EdgeSearch<'_> {
    /// Compares all pairs in sixteen slices of the path until there: whether each is apart by more than `nearest`. None where
    /// some link is out of range.
    pub(super) fn slice(&self, end: f64, nearest: f64) -> Option<Slices> {
        let asked = Asked { half: 0.5 * end / WIDTH as f64 * ROUNDED_UP, nearest };
        let mut spheres = self.spheres(end)?;
        let checker = self.checker;
        let mut open = vec![u16::MAX; checker.pairs.len()];
        for &pair in &checker.groups.single {
            let edge_pair = &checker.pairs[pair as usize];
            open[pair as usize] = self.open_slices(&mut spheres, edge_pair, asked)?;
        }
        for group in &checker.groups.groups {
            let of_group = self.open_slices(&mut spheres, &group.pair, asked)?;
            open.push(of_group);
            for &pair in &group.members {
                let edge_pair = &checker.pairs[pair as usize];
                open[pair as usize] = match of_group {
                    0 => 0,
                    _ => of_group & self.open_slices(&mut spheres, edge_pair, asked)?,
                };
            }
        }
        Some(Slices { end, open })
    }

    /// Where the links are; none where some are out of range.
    fn spheres(&self, end: f64) -> Option<Spheres> {
        let robot = self.checker.robot();
        let (mut states, mut rates) = (Vec::with_capacity(WIDTH), Vec::new());
        let mut at_middle = Vec::new();
        for k in 0..WIDTH {
            let t = end * (k as f64 + 0.5) / WIDTH as f64;
            let mut state = Vec::new();
            self.path.state_at(robot, t, &mut state);
            robot.check_state(&state).ok()?;
            states.push(state);
            self.path.rates_at(t, &mut at_middle);
            rates.resize(at_middle.len(), NONE);
            for (row, &rate) in rates.iter_mut().zip(&at_middle) {
                row[k / HALF][k % HALF] = rate;
            }
        }
        let states: Vec<&[f64]> = states.iter().map(Vec::as_slice).collect();
        let mut frames = LinkFrames::default();
        frames.read(robot, &states);
        dispatch(Place { robot, states: &states, to: &mut frames });
        let still = TwistRow { turn: [NONE; 3], at_base: [NONE; 3] };
        let mut twists = vec![still; robot.links().len()];
        let to = &mut twists[..];
        dispatch(Twists { robot, path: self.path, rates: &rates, frames: &frames, to });
        let rows = self.movers.iter().map(|_| None).collect();
        (0..WIDTH).all(|k| frames.is_finite(k)).then_some(Spheres { frames, twists, rows })
    }

    /// Finds the sphere of what moves; none where it cannot be placed.
    fn place_sphere(&self, object: usize, spheres: &mut Spheres) -> Option<()> {
        let Some((part, chain)) = &self.checker.movers[object] else { return Some(()) };
        if spheres.rows[object].is_some() {
            return Some(());
        }
        let (robot, whole) = (self.checker.robot(), &self.checker.volumes[object].whole);
        let part = &robot.parts()[*part];
        // What bounds the object's points bounds the centre where it is no farther from the joints.
        let centre = part.origin.rotation * whole.centre + part.origin.translation;
        let is_bounded = centre.length() <= chain.extent();
        let mut row = SphereRow {
            centre: [NONE; 3],
            velocity: [NONE; 3],
            speed: NONE,
            radius: if is_bounded { whole.outer } else { f64::INFINITY },
            deviation: 0.0,
            accelerations: self.movers[object].lengths.accelerations(),
        };
        dispatch(PlaceSphere {
            frame: &spheres.frames.frames[part.link],
            origin: &part.origin,
            centre: whole.centre,
            twist: &spheres.twists[part.link],
            base: robot.base.translation,
            to: &mut row,
        });
        // Not NaN either.
        let is_placed = row.deviation <= Pose::UNIT_TOLERANCE;
        spheres.rows[object] = Some(row);
        is_placed.then_some(())
    }

    /// The slices in which the spheres of a pair do not prove it apart.
    fn open_slices(&self, spheres: &mut Spheres, pair: &EdgePair, asked: Asked) -> Option<u16> {
        let [a, b] = pair.objects.map(|object| object as usize);
        self.place_sphere(a, spheres)?;
        self.place_sphere(b, spheres)?;
        let row = spheres.rows[a].as_ref()?;
        let other = spheres.rows[b].as_ref();
        let deviations = [row.deviation, other.map_or(self.movers[b].deviation, |b| b.deviation)];
        let off = self.off(pair) + self.slack_of(pair, deviations, asked.half);
        let acceleration = |row: &SphereRow| row.accelerations.get(pair.common as usize).copied();
        let accelerations = acceleration(row)? + other.map_or(Some(0.0), acceleration)?;
        let change = 0.5 * asked.half * asked.half * accelerations;
        let lost = row.radius + off + asked.nearest;
        let moved = Moved { half: asked.half, change, off };
        if let Some(other) = other {
            let lost = lost + other.radius;
            return Some(dispatch(BetweenSpheres { row, other, moved, lost }));
        }
        let BoundingVolumes { whole, solid, .. } = &*self.checker.volumes[b];
        if !whole.outer.is_finite() {
            // No solid is round it.
            return Some(u16::MAX);
        }
        let pose = self.pose(b as u32);
        let (inverse, from) = (pose.rotation().transpose(), pose.translation());
        Some(dispatch(ToSolid { row, inverse, from, solid, moved, lost }))
    }
}

/// What bounds how two bodies close.
#[derive(Clone, Copy)]
struct Moved {
    half: f64,
    /// What both move by their accelerations.
    change: f64,
    /// What coordinates may be off by.
    off: f64,
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

struct Twists<'a> {
    robot: &'a Robot,
    path: &'a JointPath,
    /// For each value of a state.
    rates: &'a [Row],
    frames: &'a LinkFrames,
    to: &'a mut [TwistRow],
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

struct PlaceSphere<'a> {
    /// Of the link.
    frame: &'a FrameRow,
    /// Of the part in that.
    origin: &'a JointFrame,
    /// In the part's frame.
    centre: DVec3,
    twist: &'a TwistRow,
    base: DVec3,
    to: &'a mut SphereRow,
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
                let most = greater(square(0) + xy + xz, square(1) + xy + yz);
                deviations[h][k] = greater(most, square(2) + xz + yz);
            }
        }
        let largest = deviations.as_flattened().iter().fold(0.0, |a, &b| greater(a, b));
        // As a pose's is, for what these sums lose.
        to.deviation = largest + 24.0 * f64::EPSILON;
    }
}

struct BetweenSpheres<'a> {
    row: &'a SphereRow,
    other: &'a SphereRow,
    moved: Moved,
    /// Both radii, what coordinates may be off by, and how far apart both are to be.
    lost: f64,
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

struct ToSolid<'a> {
    row: &'a SphereRow,
    /// The solid's rotation, transposed, and its place.
    inverse: DMat3,
    from: DVec3,
    solid: &'a Solid,
    moved: Moved,
    /// The radius, what coordinates may be off by, and how far apart both are to be.
    lost: f64,
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
                        let (side, end) = (greater(flat - radius, 0.0), beyond(z, half));
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
    greater(x.abs() - half, 0.0).copysign(x)
}

/// The lanes in which a number is not above 0: so is none that is no number.
#[inline(always)]
fn not_positive<L: Lanes>(l: L, row: &Row) -> u16 {
    let zero = l.splat_d(0.0);
    let [first, second] = [l.lt_d(zero, l.load_d(&row[0])), l.lt_d(zero, l.load_d(&row[1]))];
    !(first | second << HALF) as u16
}

/// b where either is no number.
#[inline(always)]
fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::super::super::place::Twist;
    use super::super::super::tests::Draw;
    use super::*;
    use glam::DQuat;

    #[test]
    fn a_sphere_is_where_its_pose_puts_it_and_moves_as_its_link_does() {
        let mut draw = Draw::new();
        for k in 0..50 {
            let mut frame = || JointFrame {
                rotation: DMat3::from_quat(DQuat::from_scaled_axis(draw.vector() * 3.0)),
                translation: draw.vector(),
            };
            let (link, mut origin) = (frame(), frame());
            if k % 5 == 0 {
                origin.rotation = DMat3::IDENTITY;
            }
            let (centre, base) = (draw.vector(), draw.vector());
            let twist = Twist { turn: draw.vector(), at_base: draw.vector() };
            let row = |x: f64| [[x; HALF]; 2];
            let mut frame: FrameRow = [NONE; 12];
            let numbers = link.rotation.to_cols_array().into_iter();
            for (k, x) in numbers.chain(link.translation.to_array()).enumerate() {
                frame[k] = row(x);
            }
            let rows = |v: DVec3| v.to_array().map(row);
            let twist_row = TwistRow { turn: rows(twist.turn), at_base: rows(twist.at_base) };
            let mut to = SphereRow {
                centre: [NONE; 3],
                velocity: [NONE; 3],
                speed: NONE,
                radius: 0.0,
                deviation: 0.0,
                accelerations: Vec::new(),
            };
            let (origin, twist_row) = (&origin, &twist_row);
            let frame = &frame;
            dispatch(PlaceSphere { frame, origin, centre, twist: twist_row, base, to: &mut to });
            let pose = link.then(origin).pose().unwrap();
            let at = pose.apply(centre);
            let speed = twist.of(at - base);
            for lane in [0, WIDTH - 1] {
                let vector = |points: &Points| {
                    DVec3::from_array(points.map(|row| row[lane / HALF][lane % HALF]))
                };
                assert!(vector(&to.centre).distance(at) < 1e-14, "{lane}");
                assert!(vector(&to.velocity).distance(speed) < 1e-14, "{lane}");
                assert!((to.speed[lane / HALF][lane % HALF] - speed.length()).abs() < 1e-14);
            }
            let deviation = pose.deviation();
            assert!(to.deviation >= 0.9 * deviation && to.deviation < deviation + 1e-14);
        }
    }
}
