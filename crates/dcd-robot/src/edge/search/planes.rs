//! Separating planes for all pairs on all of a path: what a certificate is made of.

use super::super::certificate::{CertifiedPair, Pieces, SeparatingPlane};
use super::super::place::Twist;
use super::super::{EdgePair, ROUNDED_UP};
use super::bounds::ROUNDING;
use super::{EdgeSearch, SHORTEST};
use crate::RobotError;
use dcd_geom::Shape;
use dcd_gjk::PosedShape;
use dcd_gjk::distance::{DistanceResult, distance, in_f64};
use glam::{DMat3, DVec3};
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

/// What a plane's offset and a body's height over it lose in f64, here and in the intervals of whoever replays it, relative to
/// the lengths that go into them. No unit. Larger than half of [`ROUNDING`]: more than a pair that is proved free has to spare
/// (docs/numerics/proofs.md, "edges").
const LOST: f64 = 0.25 * ROUNDING;

/// By how much a gap at the middle of an interval has to exceed what is needed for shorter intervals to be tried before fewer
/// pieces. No unit. Smaller: many short intervals for pieces that hardly part. Larger: more pieces than need be.
const WORTH_HALVING: f64 = 1.5;

/// Some pieces of a pair, of which planes are wanted.
#[derive(Clone)]
struct Open {
    pair: u32,
    pieces: [Range<u32>; 2],
}

/// What is found of some pieces on an interval.
enum Found {
    Plane(SeparatingPlane),
    /// A plane parts them at the middle by enough: a shorter interval may do.
    ApartAtMiddle,
    /// None that was tried does.
    Close,
}

/// How the pieces lie along a direction if all keep their speeds, as heights over the robot's base, metres.
struct Heights {
    /// The highest points of the first body and the lowest of the second at the beginning of the interval.
    first: [f64; 2],
    /// At its end.
    last: [f64; 2],
}

/// Convex shapes about some pieces of an object.
type Hulls = HashMap<(u32, Range<u32>), Option<Arc<Shape>>>;

/// Planes for all of a path.
struct PathPlanes<'s, 'a> {
    search: EdgeSearch<'a>,
    pieces: &'s [Pieces],
    /// How far a body is from its plane at least, metres.
    needed: f64,
    hulls: Hulls,
    /// For each pair.
    found: Vec<Vec<SeparatingPlane>>,
}

impl<'a> EdgeSearch<'a> {
    /// Separating planes for all pairs, each body at least that far from them, metres.
    pub(in super::super) fn planes(
        self,
        pieces: &[Pieces],
        needed: f64,
    ) -> Result<Vec<CertifiedPair>, RobotError> {
        let pairs = self.pairs.len();
        let found = vec![Vec::new(); pairs];
        let mut search = self;
        search.begin_directions();
        let mut planes = PathPlanes { search, pieces, needed, hulls: Hulls::new(), found };
        planes.run()?;
        let PathPlanes { search, found, .. } = planes;
        let links = search.checker.robot().links();
        let certified = search.pairs.iter().zip(found).map(|(pair, planes)| CertifiedPair {
            objects: pair.objects,
            frame: search.common(pair).map(|link| links[link].name.clone()),
            planes,
        });
        Ok(certified.collect())
    }
}

impl PathPlanes<'_, '_> {
    fn run(&mut self) -> Result<(), RobotError> {
        let all = |pair: u32| {
            let objects = self.search.pairs[pair as usize].objects;
            Open { pair, pieces: objects.map(|i| self.pieces[i as usize].all()) }
        };
        let pairs = self.search.pairs.len() as u32;
        let mut stack = vec![([0.0, 1.0], (0..pairs).map(all).collect::<Vec<Open>>())];
        while let Some((t, open)) = stack.pop() {
            let Some(first) = open.first() else { continue };
            let is_spent = self.search.nodes >= self.search.budget;
            if is_spent || t[1] - t[0] <= SHORTEST {
                return Err(self.refused(first, t, is_spent));
            }
            self.search.nodes += 1;
            let middle = 0.5 * (t[0] + t[1]);
            self.search.at.go_to(self.search.checker, self.search.path, middle)?;
            self.search.half = 0.5 * (t[1] - t[0]);
            let left = self.left_of(open, t);
            stack.push(([middle, t[1]], left.clone()));
            stack.push(([t[0], middle], left));
        }
        Ok(())
    }

    fn refused(&self, open: &Open, t: [f64; 2], is_spent: bool) -> RobotError {
        let pair = self.search.pairs[open.pair as usize].objects;
        let [a, b] = self.search.checker.cell.names_of(pair.into());
        let why = if is_spent { "the budget of intervals is spent" } else { "no plane parts them" };
        let why = format!("{why}, t from {} to {}", t[0], t[1]);
        RobotError::Refused { user: format!("certificate of {a:?} and {b:?}"), why }
    }

    /// Finds planes for what is open, cut into fewer pieces where that may help; what is left.
    fn left_of(&mut self, open: Vec<Open>, t: [f64; 2]) -> Vec<Open> {
        let (mut left, mut open) = (Vec::new(), open);
        // The last is taken first.
        open.reverse();
        while let Some(next) = open.pop() {
            match self.plane(&next, t) {
                Found::Plane(plane) => self.found[next.pair as usize].push(plane),
                Found::Close if next.pieces.iter().any(|range| range.len() > 1) => {
                    let k = usize::from(next.pieces[1].len() > next.pieces[0].len());
                    let Range { start, end } = next.pieces[k];
                    let border = start + (end - start) / 2;
                    let mut halves = [next.clone(), next];
                    halves[0].pieces[k].end = border;
                    halves[1].pieces[k].start = border;
                    let [first, second] = halves;
                    open.extend([second, first]);
                }
                Found::ApartAtMiddle | Found::Close => left.push(next),
            }
        }
        left
    }

    fn plane(&mut self, open: &Open, t: [f64; 2]) -> Found {
        let edge_pair = self.search.pairs[open.pair as usize];
        let [a, b] = edge_pair.objects;
        self.search.update(a);
        self.search.update(b);
        let carried = self.search.common(&edge_pair).map(|link| *self.search.at.rotation(link));
        let last = self.search.directions[open.pair as usize];
        let last = carried.map_or(last, |rotation| rotation * last);
        let by_spheres = self.search.by_spheres(&edge_pair).direction;
        // Cheap ones first.
        for direction in [last, by_spheres] {
            if let Some(plane) = self.along(open, (&edge_pair, carried, direction), t) {
                return Found::Plane(plane);
            }
        }
        let Some(normal) = self.nearest(open, &edge_pair) else { return Found::Close };
        if let Some(plane) = self.along(open, (&edge_pair, carried, normal), t) {
            self.search.keep(open.pair, carried, normal);
            return Found::Plane(plane);
        }
        let half = std::mem::replace(&mut self.search.half, 0.0);
        let heights = self.heights(open, &edge_pair, normal);
        self.search.half = half;
        let gap = 0.5 * (heights.first[1] - heights.first[0]) - self.lost(&edge_pair);
        if gap > WORTH_HALVING * self.needed && gap > 0.0 {
            self.search.keep(open.pair, carried, normal);
            Found::ApartAtMiddle
        } else if gap > self.needed && open.pieces.iter().all(|range| range.len() == 1) {
            Found::ApartAtMiddle
        } else {
            Found::Close
        }
    }

    /// From one to the other where they are nearest.
    fn nearest(&mut self, open: &Open, edge_pair: &EdgePair) -> Option<DVec3> {
        let [in_a, in_b] = [0, 1].map(|k| self.hull(edge_pair.objects[k], &open.pieces[k]));
        let (in_a, in_b) = (in_a?, in_b?);
        let [a, b] = edge_pair.objects.map(|object| self.search.pose(object));
        let (a, b) = (PosedShape { shape: &in_a, pose: a }, PosedShape { shape: &in_b, pose: b });
        let mut found = in_f64(a, b);
        if !matches!(found, DistanceResult::Apart(_)) {
            found = distance(a, b).0;
        }
        match found {
            DistanceResult::Apart(found) => Some(found.normal),
            _ => None,
        }
    }

    /// A convex shape about some pieces: the object's own, where that is convex.
    fn hull(&mut self, object: u32, range: &Range<u32>) -> Option<Arc<Shape>> {
        let shape = self.search.checker.cell.scene().shape(object as usize);
        let pieces = &self.pieces[object as usize];
        let made = || {
            if shape.is_convex() { Some(shape.clone()) } else { pieces.hull(range) }.map(Arc::new)
        };
        self.hulls.entry((object, range.clone())).or_insert_with(made).clone()
    }

    /// A plane of that direction, in the world, if it parts the pieces on all of the interval by enough.
    fn along(
        &self,
        open: &Open,
        (edge_pair, carried, direction): (&EdgePair, Option<DMat3>, DVec3),
        t: [f64; 2],
    ) -> Option<SeparatingPlane> {
        let n = direction.try_normalize()?;
        let Heights { first, last } = self.heights(open, edge_pair, n);
        let half = self.search.half;
        let changes = edge_pair.objects.map(|object| {
            let local = &self.search.mover(object).local;
            let most = local.acceleration.get(edge_pair.common as usize).copied();
            0.5 * half * half * most.unwrap_or(0.0) * ROUNDED_UP
        });
        let lost = self.lost(edge_pair);
        // In the middle of what is left between both, at either end.
        let margin = |[high, low]: [f64; 2]| 0.5 * (low - high - changes[0] - changes[1]) - lost;
        let (at_first, at_last) = (margin(first), margin(last));
        // Not NaN either.
        if !(at_first > self.needed && at_last > self.needed) {
            return None;
        }
        let base = self.search.checker.robot().base.translation;
        let (normal, from) = match self.search.common(edge_pair) {
            Some(link) => (carried?.transpose() * n, self.search.at.place(link) - base),
            None => (n, -base),
        };
        let offset =
            |[high, _]: [f64; 2], margin: f64| high + changes[0] + lost + margin - n.dot(from);
        Some(SeparatingPlane {
            t,
            normal,
            offset: [offset(first, at_first), offset(last, at_last)],
            pieces: self.some(open, edge_pair),
        })
    }

    /// The pieces, if they are not all.
    fn some(&self, open: &Open, edge_pair: &EdgePair) -> Option<[Range<u32>; 2]> {
        let all = edge_pair.objects.map(|object| self.pieces[object as usize].all());
        (open.pieces != all).then(|| open.pieces.clone())
    }

    /// How far a body may be from where f64 has it, and what its height loses.
    fn lost(&self, edge_pair: &EdgePair) -> f64 {
        let of = |object: u32| {
            let deviation = self.search.mover(object).lengths.deviation;
            deviation + LOST * self.search.place_of(object).length
        };
        of(edge_pair.objects[0]) + of(edge_pair.objects[1])
    }

    /// Along n, of unit length in the world, as seen from what carries both.
    fn heights(&self, open: &Open, edge_pair: &EdgePair, n: DVec3) -> Heights {
        let search = &self.search;
        let base = search.checker.robot().base.translation;
        let carrier = search.carrier(edge_pair);
        let most = |k: usize, side: f64, s: f64| {
            let object = edge_pair.objects[k];
            let (pose, pieces) = (search.pose(object), &self.pieces[object as usize]);
            let twist = match &search.checker.movers[object as usize] {
                Some(_) => search.mover(object).twist.from(&carrier),
                None => Twist::default(),
            };
            // n·(ω × p) is p·(n × ω).
            let d = (n + s * n.cross(twist.turn)) * side;
            let local = pose.rotation().transpose() * d;
            (pose.translation() - base).dot(d)
                + pieces.along(&open.pieces[k], local)
                + s * side * n.dot(twist.at_base)
        };
        let at = |s: f64| [most(0, 1.0, s), -most(1, -1.0, s)];
        Heights { first: at(-search.half), last: at(search.half) }
    }
}
