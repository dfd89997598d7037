//! Sixteen equal parts of a path together, in lanes: which pairs the spheres round their objects prove apart in which of them.
//!
//! Plain f64 without fused multiply-add: the same bits on every SIMD path.

mod kernels;
#[cfg(test)]
mod tests;

use super::super::bounding_volumes::BoundingVolumes;
use super::super::{EdgePair, Number, ROUNDED_UP};
use super::bounds::ROUNDING;
use super::{EdgeSearch, Mover, Node};
use crate::state_checker::link_frames::{HALF, LinkFrames, Numbers, PlaceFrames};
use dcd_geom::Pose;
use dcd_simd::{WIDTH, dispatch};
use glam::DVec3;
use kernels::{BetweenSpheres, Moved, PlaceSphere, ToSolid, Twists};

/// A number of each slice.
type Row = Numbers;

/// Coordinates, one row each.
type Points = [Row; 3];

const NONE: Row = [[0.0; HALF]; 2];

/// Four times what the way between two bodies may be off by, in units of their slack and of what their poses deviate by: it turns
/// the direction along which their speed counts (docs/numerics/proofs.md, "Slices"). No unit. Smaller: speeds below the truth.
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

    /// Whether a pair, or a group by its number behind theirs, is proved apart in all of those slices, which are one at least.
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
pub(super) struct Spheres {
    /// Where the last slice ends.
    end: f64,
    frames: LinkFrames,
    twists: Vec<TwistRow>,
    /// For each object that moves.
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
    pub(super) fn slice(&mut self, end: f64, nearest: f64) -> Option<Slices> {
        let asked = Asked { half: Self::half_slice(end), nearest };
        let mut spheres = match self.spheres.take().filter(|spheres| spheres.end == end) {
            Some(spheres) => spheres,
            None => self.spheres(end)?,
        };
        let mut open = vec![u16::MAX; self.pairs.len()];
        for &pair in &self.groups.single {
            let edge_pair = &self.pairs[pair as usize];
            open[pair as usize] = self.open_slices(&mut spheres, edge_pair, asked)?;
        }
        for group in &self.groups.groups {
            let of_group = self.open_slices(&mut spheres, &group.pair, asked)?;
            open.push(of_group);
            for &pair in self.groups.members_of(group) {
                let edge_pair = &self.pairs[pair as usize];
                open[pair as usize] = match of_group {
                    0 => 0,
                    _ => of_group & self.open_slices(&mut spheres, edge_pair, asked)?,
                };
            }
        }
        Some(Slices { end, open })
    }

    /// Where the links are; none where some are out of range.
    pub(super) fn spheres(&self, end: f64) -> Option<Spheres> {
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
        dispatch(PlaceFrames { robot, states: &states, to: &mut frames });
        let still = TwistRow { turn: [NONE; 3], at_base: [NONE; 3] };
        let mut twists = vec![still; robot.links().len()];
        let to = &mut twists[..];
        dispatch(Twists { robot, path: self.path, rates: &rates, frames: &frames, to });
        let rows = self.movers.iter().map(|_| None).collect();
        (0..WIDTH).all(|k| frames.is_finite(k)).then_some(Spheres { end, frames, twists, rows })
    }

    /// Finds the sphere of what moves; none where it cannot be placed.
    pub(super) fn place_sphere(&self, object: u32, spheres: &mut Spheres) -> Option<()> {
        let number = self.checker.number(object);
        let (Some((part, chain)), Number::Moves(number)) =
            (&self.checker.movers[object as usize], number)
        else {
            return Some(());
        };
        if spheres.rows[number].is_some() {
            return Some(());
        }
        let (robot, whole) = (self.checker.robot(), &self.checker.volumes[object as usize].whole);
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
            accelerations: self.movers[number].lengths.accelerations(),
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
        spheres.rows[number] = Some(row);
        is_placed.then_some(())
    }

    /// The sphere of what moves, once it is placed.
    fn row<'s>(&self, object: u32, spheres: &'s Spheres) -> Option<&'s SphereRow> {
        match self.checker.number(object) {
            Number::Moves(number) => spheres.rows[number].as_ref(),
            Number::Still(_) => None,
        }
    }

    /// A box round where an object's sphere is in any of the slices, grown by all that what it holds may be off by; none where it
    /// cannot be placed.
    pub(super) fn swept(&self, object: u32, spheres: &mut Spheres) -> Option<[DVec3; 2]> {
        self.place_sphere(object, spheres)?;
        let row = self.row(object, spheres)?;
        let Mover { length, turns, lengths, .. } = self.mover(object);
        let half = Self::half_slice(spheres.end);
        // As of a pair, of which the other one is where its box is.
        let relative = ROUNDING + lengths.turned + 4.0 * row.deviation;
        let slack = relative * length * (1.0 + half * (8.0 + turns));
        let off = 2.0 * lengths.deviation + slack;
        let change = 0.5 * half * half * row.accelerations.first()?;
        let [mut min, mut max] = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        for k in 0..WIDTH {
            let at = |row: &Row| row[k / HALF][k % HALF];
            let moved = (half * at(&row.speed) + change) * ROUNDED_UP;
            let reach = (row.radius + moved + off) * ROUNDED_UP;
            let [x, y, z] = &row.centre;
            let centre = DVec3::new(at(x), at(y), at(z));
            (min, max) = (min.min(centre - reach), max.max(centre + reach));
        }
        Some([min, max])
    }

    fn half_slice(end: f64) -> f64 {
        0.5 * end / WIDTH as f64 * ROUNDED_UP
    }

    /// The slices in which the spheres of a pair do not prove it apart.
    fn open_slices(&self, spheres: &mut Spheres, pair: &EdgePair, asked: Asked) -> Option<u16> {
        let [a, b] = pair.objects;
        self.place_sphere(a, spheres)?;
        self.place_sphere(b, spheres)?;
        let row = self.row(a, spheres)?;
        let other = self.row(b, spheres);
        let mut places = [a, b].map(|object| self.place_of(object));
        places[0].deviation = row.deviation;
        if let Some(other) = other {
            places[1].deviation = other.deviation;
        }
        let off = self.off(pair) + self.slack_of(pair, places, asked.half);
        let acceleration = |row: &SphereRow| row.accelerations.get(pair.common as usize).copied();
        let accelerations = acceleration(row)? + other.map_or(Some(0.0), acceleration)?;
        let change = 0.5 * asked.half * asked.half * accelerations;
        let lost = row.radius + off + asked.nearest;
        let moved = Moved { half: asked.half, change, off };
        if let Some(other) = other {
            let lost = lost + other.radius;
            return Some(dispatch(BetweenSpheres { row, other, moved, lost }));
        }
        let BoundingVolumes { whole, solid, .. } = &*self.checker.volumes[b as usize];
        if !whole.outer.is_finite() {
            // No solid is round it.
            return Some(u16::MAX);
        }
        let pose = self.pose(b);
        let (inverse, from) = (pose.rotation().transpose(), pose.translation());
        Some(dispatch(ToSolid { row, inverse, from, solid, moved, lost }))
    }
}
