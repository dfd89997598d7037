//! States against what a sensor has seen: spheres of the links against points in their cells, planes between hulls
//! and points that those leave, and what is left decided pair by pair.

use super::links::BodyHull;
use super::one_link::{LinkPlace, LinkPlaces};
use super::prepared::Prepared;
use super::rounded_links::{Placed, Rounded, bits, stored};
use super::separate::{PlacedHull, Support, across_gap, unit};
use super::sift::is_alone;
use super::solids::{inside, margin_of, within};
use super::worker::{CHUNK, Refused, RefusedState, Worker, at, with_chunk};
use super::{FAR, Goal, MARGIN, StateChecker};
use crate::sensed::SensedError;
use crate::{RobotError, SensedWorld};
use dcd_exec::{Exec, Segments};
use dcd_geom::Pose;
use dcd_gjk::{Certified, PairSolver, PosedShape, Verdict};
use dcd_simd::{Kernel, Lanes, Path, WIDTH, dispatch_on};
use glam::Vec3;

/// A body of a state and a sensed point that are not known to be apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensedHit {
    /// Which state.
    pub state: u32,
    /// The object of [`Workcell::scene`](crate::Workcell::scene) that moves.
    pub object: u32,
    /// Which of [`SensedWorld::points`].
    pub point: u32,
    /// That they touch, or that the pair is undecided.
    pub verdict: Verdict<()>,
}

impl SensedHit {
    /// Whether it is a proved contact.
    pub fn touches(&self) -> bool {
        matches!(self.verdict, Verdict::Touching(()))
    }
}

/// What is checked against what is seen.
#[derive(Clone, Copy)]
struct SensedQuery<'a> {
    sensed: &'a SensedWorld,
    /// By how much what is seen is larger, metres.
    grown: f64,
    goal: Goal,
}

impl StateChecker {
    /// Every pair of a body that meets obstacles and of a sensed point or box that touches or is undecided:
    /// by states, then objects, then points. The checker's own obstacles and the robot itself are left to
    /// [`StateChecker::all`].
    ///
    /// A link that is a mesh is a surface: a point within it touches nothing.
    ///
    /// # Errors
    /// Those of [`StateChecker::collides`].
    pub fn sensed_hits<'e, S: AsRef<[f64]> + Sync>(
        &self,
        states: &[S],
        sensed: &SensedWorld,
        exec: impl Into<Exec<'e>>,
    ) -> Result<Vec<SensedHit>, RobotError> {
        self.sensed(states, SensedQuery { sensed, grown: 0.0, goal: Goal::All }, exec.into())
    }

    /// For each state whether it is not proved free of what is seen: see [`StateChecker::sensed_hits`].
    ///
    /// # Errors
    /// Those of [`StateChecker::collides`].
    pub fn collides_with_sensed<'e, S: AsRef<[f64]> + Sync>(
        &self,
        states: &[S],
        sensed: &SensedWorld,
        exec: impl Into<Exec<'e>>,
    ) -> Result<Vec<bool>, RobotError> {
        let query = SensedQuery { sensed, grown: 0.0, goal: Goal::One };
        let mut collides = vec![false; states.len()];
        for hit in self.sensed(states, query, exec.into())? {
            collides[hit.state as usize] = true;
        }
        Ok(collides)
    }

    /// The points that the robot itself may be, ascending: all that are not proved farther than a distance in metres
    /// from its bodies in a state. [`SensedWorld::remove`] takes them away.
    ///
    /// # Errors
    /// Those of [`StateChecker::collides`]; a distance that is no number or below 0.
    pub fn own_points(
        &self,
        state: &[f64],
        sensed: &SensedWorld,
        distance: f64,
    ) -> Result<Vec<u32>, RobotError> {
        if !(distance >= 0.0 && distance.is_finite()) {
            let (what, user) = ("distance", "own points".to_owned());
            return Err(RobotError::BadNumber { what, user, value: distance });
        }
        let query = SensedQuery { sensed, grown: distance, goal: Goal::All };
        let hits = self.sensed(&[state], query, dcd_exec::Par::Serial.into())?;
        let mut own: Vec<u32> = hits.iter().map(|hit| hit.point).collect();
        own.sort_unstable();
        own.dedup();
        Ok(own)
    }

    fn sensed<S: AsRef<[f64]> + Sync>(
        &self,
        states: &[S],
        query: SensedQuery<'_>,
        exec: Exec<'_>,
    ) -> Result<Vec<SensedHit>, RobotError> {
        let (count, refused) = (self.count(states)?, Refused::default());
        let mut all = Segments::default();
        all.fill(exec, count.div_ceil(CHUNK), |task, out| {
            self.workers.with(|worker| {
                let start = task * CHUNK;
                let states = &states[start..count.min(start + CHUNK)];
                let found = with_chunk(states, |states| {
                    worker.sensed(&self.prepared, (start, states), query, out)
                });
                found.unwrap_or_else(|(state, error)| refused.note(state, error));
            });
        });
        refused.check()?;
        Ok(all.iter().flatten().copied().collect())
    }
}

/// A body in one state near a point, by their spheres.
#[derive(Clone, Copy, Debug)]
struct Near {
    lane: u32,
    body: u32,
    /// In the order of the cells.
    place: u32,
    is_touching: bool,
    /// From the point to the body.
    towards: Vec3,
}

impl Worker {
    fn sensed(
        &mut self,
        prepared: &Prepared,
        (start, states): (usize, &[&[f64]]),
        query: SensedQuery<'_>,
        hits: &mut Vec<SensedHit>,
    ) -> Result<(), RefusedState> {
        self.read(prepared, states).map_err(|error| at(start, error))?;
        for (packet, states) in states.chunks(WIDTH).enumerate() {
            let open = (1 << states.len()) - 1;
            let placed = self.places[packet].placed(prepared);
            let rounded = &mut self.rounded;
            let near =
                dispatch_on(Path::best(), SiftSensed { prepared, placed, rounded, query, open });
            let open = near.iter().filter(|near| !near.is_touching);
            let lanes = open.fold(0, |lanes, near| lanes | 1 << near.lane);
            self.places[packet].place_exactly(prepared, states, lanes);
            self.decide_sensed(prepared, (packet, &near), (start, query), hits)
                .map_err(|error| at(start, error))?;
        }
        Ok(())
    }

    /// Decides what is left, each pair by itself.
    fn decide_sensed(
        &self,
        prepared: &Prepared,
        (packet, near): (usize, &[Near]),
        (start, query): (usize, SensedQuery<'_>),
        hits: &mut Vec<SensedHit>,
    ) -> Result<(), RefusedState> {
        let first = hits.len();
        let mut memory = Default::default();
        let mut posed: Option<((u32, u32), Pose)> = None;
        let mut done = None;
        for near in near {
            if query.goal == Goal::One && done == Some(near.lane) {
                continue;
            }
            let state = packet * WIDTH + near.lane as usize;
            let object = prepared.bodies[near.body as usize].0;
            let point = query.sensed.index(near.place as usize);
            let verdict = if near.is_touching {
                Verdict::Touching(())
            } else {
                let key = (near.lane, near.body);
                let pose = match posed {
                    Some((same, pose)) if same == key => pose,
                    _ => {
                        let (frames, body) = (&self.places[packet].frames, near.body as usize);
                        prepared.pose(frames, near.lane as usize, body).map_err(|e| (state, e))?
                    }
                };
                posed = Some((key, pose));
                let user = || format!("point {point}");
                let seen = query.sensed.shape(point as usize, query.grown);
                let (shape, place) = seen.map_err(|error| match error {
                    SensedError::Shape(error) => (state, RobotError::Shape { user: user(), error }),
                    SensedError::Pose(error) => (state, RobotError::Pose { user: user(), error }),
                })?;
                let body = prepared.cell.scene().shape(object as usize);
                let body = PosedShape { shape: body, pose: &pose };
                let seen = PosedShape { shape: &shape, pose: &place };
                match Certified.solve(body, seen, &mut memory) {
                    Verdict::Apart => continue,
                    Verdict::Touching(_) => Verdict::Touching(()),
                    Verdict::Undecided(why) => Verdict::Undecided(why),
                }
            };
            if matches!(verdict, Verdict::Touching(())) {
                done = Some(near.lane);
            }
            hits.push(SensedHit { state: (start + state) as u32, object, point, verdict });
        }
        hits[first..].sort_unstable_by_key(|hit| (hit.state, hit.object, hit.point));
        Ok(())
    }
}

/// Lists what spheres and planes leave of sixteen states, by lanes, bodies and places.
struct SiftSensed<'a> {
    prepared: &'a Prepared,
    placed: Placed<'a>,
    rounded: &'a mut Rounded,
    query: SensedQuery<'a>,
    open: u32,
}

impl Kernel for SiftSensed<'_> {
    type Output = Vec<Near>;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Vec<Near> {
        let Self { prepared, placed, rounded, query, open } = self;
        let SensedQuery { sensed, grown, goal } = query;
        let mut found = Vec::new();
        if sensed.is_empty() {
            return found;
        }
        let margin = margin_of(grown);
        // Within the margin of a radius, as all that is rounded here.
        let (largest, grown) = ((sensed.largest_reach() + grown) as f32, grown as f32);
        let seen = Seen { sensed, half: sensed.half_extents().as_vec3(), largest, margin, grown };
        let links = &*prepared.world_links;
        if is_alone(open) {
            let lane = open.trailing_zeros() as usize;
            placed.place_alone(l, (links, &prepared.world_rows, lane), &mut rounded.one);
            seen.of_state(l, (prepared, rounded.one.world()), (lane, goal), &mut found);
            return found;
        }
        placed.place(l, links, &mut rounded.world);
        for lane in bits(open) {
            seen.of_state(l, (prepared, (&*rounded.world, lane)), (lane, goal), &mut found);
        }
        found
    }
}

/// A sphere on a link in one state.
struct LinkSphere {
    centre: Vec3,
    outer: f32,
    inner: f32,
    margin: f32,
}

/// What is seen, rounded.
struct Seen<'a> {
    sensed: &'a SensedWorld,
    half: Vec3,
    /// How far any point's radius and box reach, metres.
    largest: f32,
    /// By how much a comparison with a point may be off, beside [`MARGIN`] times that point's size, metres.
    margin: f32,
    grown: f32,
}

/// [`MARGIN`] for what is compared.
const OF_SIZE: f32 = MARGIN as f32;

impl Seen<'_> {
    /// How far from a centre points are that may be within so much of it, their radii, boxes and margins, metres
    /// (docs/numerics/proofs.md, "Sensed points").
    #[inline(always)]
    fn search(&self, centre: Vec3, reach: f32) -> f32 {
        let size = centre.abs().max_element() + reach + 4.0 * self.largest;
        reach + self.largest + self.margin + 4.0 * OF_SIZE * size
    }

    /// Lists what spheres and planes leave of a state, by bodies and places.
    #[inline(always)]
    fn of_state<L: Lanes, P: LinkPlaces>(
        &self,
        l: L,
        (prepared, placed): (&Prepared, P),
        (lane, goal): (usize, Goal),
        found: &mut Vec<Near>,
    ) {
        let first = found.len();
        for (slot, link) in prepared.world_links.iter().enumerate() {
            let placed = placed.at(slot);
            let reach = self.search(placed.centre(), link.radius + placed.margin());
            if self.sensed.around(placed.centre(), reach).next().is_none() {
                continue;
            }
            for row in &link.rows {
                let spheres = placed.row(l, row);
                let centres = stored(l, spheres.centre);
                for k in bits(row.filled) {
                    let sphere = LinkSphere {
                        centre: centres.point(k),
                        outer: row.outer.0[k],
                        inner: row.inner.0[k],
                        margin: placed.margin(),
                    };
                    let before = found.len();
                    self.list(l, &sphere, (lane as u32, row.bodies[k]), found);
                    if goal == Goal::All {
                        continue;
                    }
                    // Always the same one: the first.
                    let hit = found[before..].iter().position(|near| near.is_touching);
                    if let Some(hit) = hit {
                        found.swap(first, before + hit);
                        found.truncate(first + 1);
                        return;
                    }
                }
            }
        }
        found[first..].sort_unstable_by_key(|n| (n.body, n.place, !n.is_touching));
        let mut kept = first;
        for k in first..found.len() {
            let near = found[k];
            let is_same = kept > first
                && (found[kept - 1].body, found[kept - 1].place) == (near.body, near.place);
            if !is_same {
                found[kept] = near;
                kept += 1;
            }
        }
        found.truncate(kept);
        self.part(l, (prepared, placed), (first, found));
    }

    /// Lists the points near a sphere, sixteen at a time.
    #[inline(always)]
    fn list<L: Lanes>(
        &self,
        l: L,
        sphere: &LinkSphere,
        (lane, body): (u32, u32),
        found: &mut Vec<Near>,
    ) {
        let margin = sphere.margin + self.margin;
        // A maximum may swallow a NaN: what is nowhere touches nothing. Nor is a contact proved of points so large that
        // squares overflow.
        let is_known = sphere.centre.is_finite() && self.largest <= FAR;
        let inner = if is_known { sphere.inner } else { f32::NEG_INFINITY };
        let [xs, ys, zs, radii, sizes] = self.sensed.rows();
        let reach = self.search(sphere.centre, sphere.outer + sphere.margin);
        for range in self.sensed.around(sphere.centre, reach) {
            for begin in range.clone().step_by(WIDTH) {
                let row = |numbers: &[f32]| numbers[begin..].first_chunk::<WIDTH>().copied();
                let (Some(x), Some(y), Some(z), Some(radius), Some(size)) =
                    (row(xs), row(ys), row(zs), row(radii), row(sizes))
                else {
                    continue;
                };
                let x = beyond(l, l.load_from(&x), sphere.centre.x, self.half.x);
                let y = beyond(l, l.load_from(&y), sphere.centre.y, self.half.y);
                let z = beyond(l, l.load_from(&z), sphere.centre.z, self.half.z);
                let radius = l.add(l.load_from(&radius), l.splat(self.grown));
                let square = l.mul_add(x, x, l.mul_add(y, y, l.mul(z, z)));
                let margin = l.mul_add(l.load_from(&size), l.splat(OF_SIZE), l.splat(margin));
                let outer = l.add(l.splat(sphere.outer), margin);
                let near = within(l, square, l.add(radius, outer));
                let touched = inside(l, square, l.add(radius, l.sub(l.splat(inner), margin)));
                let there = (1u32 << (range.end - begin).min(WIDTH)) - 1;
                for k in bits((near | touched) & there) {
                    let place = (begin + k) as u32;
                    let of = |numbers: &[f32]| numbers[begin + k];
                    let towards = sphere.centre - Vec3::new(of(xs), of(ys), of(zs));
                    let is_touching = touched >> k & 1 == 1;
                    found.push(Near { lane, body, place, is_touching, towards });
                }
            }
        }
    }

    /// Drops what a plane parts.
    #[inline(always)]
    fn part<L: Lanes, P: LinkPlaces>(
        &self,
        l: L,
        (prepared, placed): (&Prepared, P),
        (first, found): (usize, &mut Vec<Near>),
    ) {
        let [xs, ys, zs, radii, sizes] = self.sensed.rows();
        let mut kept = first;
        for k in first..found.len() {
            let near = found[k];
            let hull =
                if near.is_touching { None } else { prepared.hulls[near.body as usize].as_ref() };
            let parted = match hull.and_then(|hull| Some((hull, slot(prepared, hull)?))) {
                Some((hull, slot)) => {
                    let place = near.place as usize;
                    let still = SeenBox {
                        half: self.half,
                        centre: Vec3::new(xs[place], ys[place], zs[place]),
                        margin: radii[place] + self.grown + (OF_SIZE * sizes[place] + self.margin),
                    };
                    let hull = PlacedHull::on(hull, placed.at(slot));
                    let towards = unit(near.towards).unwrap_or(Vec3::X);
                    across_gap(l, &still, &hull, towards).is_some()
                }
                None => false,
            };
            if !parted {
                found[kept] = near;
                kept += 1;
            }
        }
        found.truncate(kept);
    }
}

/// A box along the world's axes, or a point; its margin contains its radius.
struct SeenBox {
    half: Vec3,
    centre: Vec3,
    margin: f32,
}

impl Support for SeenBox {
    #[inline(always)]
    fn reach<L: Lanes>(&self, _: L, direction: Vec3) -> f32 {
        self.half.dot(direction.abs())
    }

    #[inline(always)]
    fn point<L: Lanes>(&self, _: L, direction: Vec3) -> Vec3 {
        self.centre + self.half.copysign(direction)
    }

    fn origin(&self) -> Vec3 {
        self.centre
    }

    fn margin(&self) -> f32 {
        self.margin
    }
}

/// The place of a hull's link among those that meet obstacles.
fn slot(prepared: &Prepared, hull: &BodyHull) -> Option<usize> {
    prepared.world_links.binary_search_by_key(&hull.link, |link| link.link).ok()
}

/// How far a coordinate is beyond half an edge of what is centred at another.
#[inline(always)]
fn beyond<L: Lanes>(l: L, of: L::F, from: f32, half: f32) -> L::F {
    l.max(l.sub(l.abs(l.sub(of, l.splat(from))), l.splat(half)), l.splat(0.0))
}

#[cfg(test)]
mod tests;
