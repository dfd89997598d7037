//! A thread's work on some packets of states.

use super::places::{PlaceLinks, Places};
use super::prepared::Prepared;
use super::rounded_links::Rounded;
use super::separate::{Planes, Separate};
use super::sift::{Found, MOST_ALONE, Sift, SiftPacket, SiftState, is_alone, taken_up};
use super::{Goal, StateChecker, StateHit};
use crate::RobotError;
use dcd_geom::{Pose, SceneError};
use dcd_gjk::{Certified, PairSolver, PosedShape, Verdict};
use dcd_pipeline::{Candidate, Other};
use dcd_simd::{Path, WIDTH, dispatch_on};
use std::sync::Mutex;

/// How many packets of sixteen states are taken up together, so that what they leave fills the narrow
/// phase's lanes. Larger: more memory for a thread. No effect on any answer.
const PACKETS: usize = 4;

/// How many states those are.
pub(super) const CHUNK: usize = PACKETS * WIDTH;

/// Up to so many states are checked on the calling thread: a hundred of the Panda take fifteen to fifty microseconds as
/// spheres and hulls, and on two threads took longer. Larger: short batches of slow states on one thread. No effect on any
/// answer.
pub(super) const FEW: usize = 2 * CHUNK;

/// How many pairs of a state are decided first where one hit is enough; twice as many each time that none of them
/// touches. Larger: more is decided in vain. Smaller cannot be. No effect on any answer.
const AT_FIRST: usize = 1;

/// Up to how many pairs of polytopes are decided one by one; for more of them the links are prepared, and the lanes filled.
/// Larger: more work for each pair. Smaller: lanes are prepared that stay empty. No effect on any answer.
const FEW_PAIRS: usize = 4;

/// What a thread works with.
#[derive(Debug, Default)]
pub(super) struct Worker {
    pub(super) places: [Places; PACKETS],
    pub(super) rounded: Rounded,
    found: Found,
    planes: Planes,
    /// The pairs that are still to be decided, and those that are decided next.
    left: Vec<Candidate>,
    next: Vec<Candidate>,
    /// What of those is not apart.
    decided: Vec<(Candidate, Verdict<()>)>,
    pub(super) hits: Vec<StateHit>,
    unsorted: Vec<StateHit>,
}

/// Does what is done with the states of a chunk: what works on them takes slices, and so is compiled once, whatever type
/// they have.
#[inline]
pub(super) fn with_chunk<S: AsRef<[f64]>, R>(states: &[S], work: impl FnOnce(&[&[f64]]) -> R) -> R {
    // A state alone would wait for a list of many.
    if let [state] = states {
        return work(&[state.as_ref()]);
    }
    let mut chunk = [&[][..]; CHUNK];
    chunk.iter_mut().zip(states).for_each(|(to, state)| *to = state.as_ref());
    work(&chunk[..states.len()])
}

/// A state, counted from the first of those taken up, and why it was refused.
pub(super) type RefusedState = (usize, RobotError);

impl Worker {
    pub(super) fn first(
        &mut self,
        checker: &StateChecker,
        (start, states): (usize, &[&[f64]]),
        first: &mut [Option<StateHit>],
    ) -> Result<(), RefusedState> {
        self.sift(&checker.prepared, states, Goal::One).map_err(|e| at(start, e))?;
        let hit = |candidate: &Candidate, verdict| {
            let Candidate { configuration, link, other } = *candidate;
            let pair = checker.prepared.pair(link, other);
            StateHit { state: start as u32 + configuration, pair, verdict }
        };
        for candidate in &self.found.touching {
            let first = &mut first[candidate.configuration as usize];
            first.get_or_insert(hit(candidate, Verdict::Touching(())));
        }
        if self.found.candidates.is_empty() {
            return Ok(());
        }
        let (mut left, mut least) =
            (std::mem::take(&mut self.left), std::mem::take(&mut self.decided));
        left.clear();
        left.extend(self.found.candidates.iter().map(|&(candidate, _)| candidate));
        left.sort_unstable();
        left.dedup();
        let touches = |hit: &Option<StateHit>| hit.as_ref().is_some_and(StateHit::touches);
        let mut at_once = AT_FIRST;
        loop {
            // The next pairs of each state that has no contact yet.
            self.next.clear();
            let mut taken = (u32::MAX, 0);
            left.retain(|candidate| {
                let state = candidate.configuration;
                if touches(&first[state as usize]) {
                    return false;
                }
                taken = if taken.0 == state { (state, taken.1 + 1) } else { (state, 0) };
                let is_next = taken.1 < at_once;
                if is_next {
                    self.next.push(*candidate);
                }
                !is_next
            });
            if self.next.is_empty() {
                break;
            }
            at_once = at_once.saturating_mul(2);
            // Of a state's pairs the least that touches, so that it does not matter which were decided together.
            least.clear();
            self.decide((checker, states), |candidate, verdict| least.push((candidate, verdict)))
                .map_err(|e| at(start, e))?;
            least.sort_unstable_by_key(|&(candidate, verdict)| {
                (!matches!(verdict, Verdict::Touching(())), candidate)
            });
            for &(candidate, verdict) in &least {
                let first = &mut first[candidate.configuration as usize];
                let found = hit(&candidate, verdict);
                if found.touches() && !touches(first) {
                    *first = Some(found);
                }
                first.get_or_insert(found);
            }
        }
        (self.left, self.decided) = (left, least);
        Ok(())
    }

    pub(super) fn all(
        &mut self,
        checker: &StateChecker,
        (start, states): (usize, &[&[f64]]),
    ) -> Result<(), RefusedState> {
        self.hits.clear();
        self.sift(&checker.prepared, states, Goal::All).map_err(|e| at(start, e))?;
        let mut hits = std::mem::take(&mut self.hits);
        let mut note = |Candidate { configuration, link, other }, verdict| {
            let pair = checker.prepared.pair(link, other);
            hits.push(StateHit { state: start as u32 + configuration, pair, verdict });
        };
        for &candidate in &self.found.touching {
            note(candidate, Verdict::Touching(()));
        }
        self.next.clear();
        self.next.extend(self.found.candidates.iter().map(|&(candidate, _)| candidate));
        self.next.sort_unstable();
        self.next.dedup();
        let decided = self.decide((checker, states), note);
        sort(&mut hits, (start as u32, states.len()), &mut self.unsorted);
        hits.dedup_by_key(|hit| (hit.state, hit.pair));
        self.hits = hits;
        decided.map_err(|e| at(start, e))
    }

    /// Takes the states up.
    pub(super) fn read(
        &mut self,
        prepared: &Prepared,
        states: &[&[f64]],
    ) -> Result<(), RefusedState> {
        for (packet, (states, places)) in states.chunks(WIDTH).zip(&mut self.places).enumerate() {
            let refused = places.read(prepared, states);
            refused.map_err(|(lane, error)| (packet * WIDTH + lane, error))?;
        }
        Ok(())
    }

    /// Finds where the states' links are.
    pub(super) fn place(
        &mut self,
        prepared: &Prepared,
        states: &[&[f64]],
    ) -> Result<(), RefusedState> {
        self.read(prepared, states)?;
        for (states, places) in states.chunks(WIDTH).zip(&self.places) {
            let placed = places.placed(prepared);
            let (links, rows) = (&*prepared.world_links, &*prepared.world_rows);
            for open in taken_up(states.len()) {
                let to = &mut self.rounded;
                dispatch_on(Path::best(), PlaceLinks { placed, open, links, rows, to });
            }
        }
        Ok(())
    }

    /// Sorts the pairs by the spheres of the states' links: those that touch, and those left open.
    fn sift(
        &mut self,
        prepared: &Prepared,
        states: &[&[f64]],
        goal: Goal,
    ) -> Result<(), RefusedState> {
        if states.len() <= MOST_ALONE && self.sift_covered(prepared, states, goal) {
            return Ok(());
        }
        self.read(prepared, states)?;
        self.begin_sift(prepared, states.len());
        for (packet, states) in states.chunks(WIDTH).enumerate() {
            for open in taken_up(states.len()) {
                self.sift_some((prepared, goal), (packet, open), None);
            }
        }
        Ok(())
    }

    /// The same of few states, read where they are placed. Returns whether all are of those that can be.
    fn sift_covered(&mut self, prepared: &Prepared, states: &[&[f64]], goal: Goal) -> bool {
        self.begin_sift(prepared, states.len());
        self.places[0].take_covered();
        let mut states = states.iter().enumerate();
        states.all(|(lane, state)| {
            self.sift_some((prepared, goal), (0, 1 << lane), Some(*state)).is_some()
        })
    }

    fn begin_sift(&mut self, prepared: &Prepared, states: usize) {
        // Of a state alone there is no next one.
        self.planes.clear(if states > 1 { prepared.hulls.len() } else { 0 });
        self.found.touching.clear();
        self.found.candidates.clear();
    }

    /// Sorts the pairs of some states of a packet, or of one by its values, if it can be read where it is placed.
    fn sift_some(
        &mut self,
        (prepared, goal): (&Prepared, Goal),
        (packet, open): (usize, u32),
        values: Option<&[f64]>,
    ) -> Option<()> {
        let Self { places, rounded, found, planes, .. } = self;
        let (path, placed) = (Path::best(), places[packet].placed(prepared));
        let (first, from) = ((packet * WIDTH) as u32, found.candidates.len());
        let sift = Sift { prepared, placed, first, open, goal, found: &mut *found };
        let is_alone = is_alone(open);
        let open = if is_alone {
            dispatch_on(path, SiftState(sift, &mut *rounded, values))?
        } else {
            dispatch_on(path, SiftPacket(sift, &mut *rounded))
        };
        if found.candidates.len() > from {
            let rounded = &*rounded;
            let separate =
                Separate { prepared, rounded, first, open, is_alone, goal, found, planes, from };
            dispatch_on(path, separate);
        }
        Some(())
    }

    /// Finds where the links are of the states of the next pairs.
    fn place_exactly(&mut self, prepared: &Prepared, states: &[&[f64]]) {
        let mut lanes = [0; PACKETS];
        for candidate in &self.next {
            let state = candidate.configuration as usize;
            lanes[state / WIDTH] |= 1 << (state % WIDTH);
        }
        for (packet, states) in states.chunks(WIDTH).enumerate() {
            self.places[packet].place_exactly(prepared, states, lanes[packet]);
        }
    }

    /// Decides pairs of `next` one by one and takes them out: those that have a sphere on the robot's side, of which the
    /// lanes leave few, and polytopes where they are few.
    fn decide_one_by_one(
        &mut self,
        prepared: &Prepared,
        note: &mut impl FnMut(Candidate, Verdict<()>),
    ) {
        let scene = prepared.cell.scene();
        let mut memory = Default::default();
        let (places, are_few) = (&self.places, self.next.len() <= FEW_PAIRS);
        self.next.retain(|candidate| {
            let &Candidate { configuration, link, other } = candidate;
            let (places, lane) =
                (&places[configuration as usize / WIDTH], configuration as usize % WIDTH);
            // Polytopes are decided exactly, so that it does not matter how many there are.
            let is_alone = prepared.is_sphere_pair(link, other)
                || are_few && prepared.is_polytope_pair(link, other);
            // What may be out of range is refused where the pairs are prepared, as is what has no pose.
            if !is_alone || !places.covers(lane) {
                return true;
            }
            let posed = |body: u32| {
                let object = prepared.bodies[body as usize].0;
                let pose = prepared.pose(&places.frames, lane, body as usize);
                pose.map(|pose| (object, pose))
            };
            let other = match other {
                Other::Obstacle(_) => {
                    let object = prepared.object_of(other);
                    Ok((object, scene.poses()[object as usize]))
                }
                Other::Link(other) => posed(other),
            };
            let (Ok(link), Ok(other)) = (posed(link), other) else { return true };
            let [a, b] = [&link, &other]
                .map(|(object, pose)| PosedShape { shape: scene.shape(*object as usize), pose });
            match Certified.solve(a, b, &mut memory) {
                Verdict::Apart => {}
                Verdict::Touching(_) => note(*candidate, Verdict::Touching(())),
                Verdict::Undecided(why) => note(*candidate, Verdict::Undecided(why)),
            }
            false
        });
    }

    /// Decides the pairs of `next`.
    fn decide(
        &mut self,
        (checker, states): (&StateChecker, &[&[f64]]),
        mut note: impl FnMut(Candidate, Verdict<()>),
    ) -> Result<(), RefusedState> {
        if self.next.is_empty() {
            return Ok(());
        }
        let prepared = &checker.prepared;
        self.place_exactly(prepared, states);
        self.decide_one_by_one(prepared, &mut note);
        if self.next.is_empty() {
            return Ok(());
        }
        let decider = checker.decider(states.len());
        let (decider, world) = decider.map_err(|error| (0, RobotError::Scene(error)))?;
        let mut refused: Option<RefusedState> = None;
        let pose = |state: usize, body: usize| {
            let pose = prepared.pose(&self.places[state / WIDTH].frames, state % WIDTH, body);
            pose.unwrap_or_else(|error| {
                if refused.as_ref().is_none_or(|&(first, _)| state < first) {
                    refused = Some((state, error));
                }
                Pose::IDENTITY
            })
        };
        let decided = decider.decide(world, &self.next, pose, |hit| {
            let (configuration, link, other) = (hit.configuration, hit.link, hit.other);
            note(Candidate { configuration, link, other }, hit.verdict);
        });
        if let Some(refused) = refused {
            return Err(refused);
        }
        decided.map_err(|error| match error {
            SceneError::OutOfRange { object, reach } => {
                let (state, body) =
                    (object / prepared.bodies.len(), object % prepared.bodies.len());
                let object = prepared.bodies[body].0 as usize;
                let user = checker.cell().user(object);
                (state, RobotError::OutOfRange { user, reach })
            }
            other => (0, RobotError::Scene(other)),
        })
    }
}

/// Sorts hits by states, pairs and whether they touch, where the states, a chunk at most, begin with that one: by states
/// first, which leaves few to compare.
fn sort(hits: &mut [StateHit], (start, states): (u32, usize), unsorted: &mut Vec<StateHit>) {
    let by_pair = |hit: &StateHit| (hit.pair, !hit.touches());
    if states == 1 {
        return hits.sort_unstable_by_key(by_pair);
    }
    unsorted.clear();
    unsorted.extend_from_slice(hits);
    let mut ends = [0; CHUNK + 1];
    for hit in &*hits {
        ends[(hit.state - start) as usize + 1] += 1;
    }
    for state in 0..states {
        ends[state + 1] += ends[state];
    }
    // Filled from each state's first place on, which so becomes its end.
    for hit in &*unsorted {
        let next = &mut ends[(hit.state - start) as usize];
        hits[*next] = *hit;
        *next += 1;
    }
    let mut from = 0;
    for &end in &ends[..states] {
        hits[from..end].sort_unstable_by_key(by_pair);
        from = end;
    }
}

/// A refusal counted from the batch's first state on.
pub(super) fn at(start: usize, (state, error): RefusedState) -> RefusedState {
    (start + state, error)
}

/// Of a state counted from the batch's first one on.
#[cold]
pub(super) fn refused((state, error): RefusedState) -> RobotError {
    RobotError::AtState { state, error: Box::new(error) }
}

/// The first state that was refused, on any thread.
#[derive(Default)]
pub(super) struct Refused(Mutex<Option<RefusedState>>);

impl Refused {
    pub(super) fn note(&self, state: usize, error: RobotError) {
        let mut first = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if first.as_ref().is_none_or(|&(earlier, _)| state < earlier) {
            *first = Some((state, error));
        }
    }

    pub(super) fn check(self) -> Result<(), RobotError> {
        match self.0.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner) {
            Some(first) => Err(refused(first)),
            None => Ok(()),
        }
    }
}
