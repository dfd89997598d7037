//! Whether states are free, sixteen at a time.
//!
//! Sixteen states go through the lanes together: where the links are (the frames of [`Robot::place`] bit for
//! bit), the spheres round and in what they carry against the obstacles and each other. Spheres prove most pairs
//! apart and many to touch; only the pairs that are left are posed, prepared and decided by the narrow phase. A
//! robot of spheres among boxes, cylinders and spheres is decided by the lanes but for what is within
//! [`MARGIN`].

mod covers;
mod link_frames;
mod links;
mod obstacle_tree;
mod separate;
mod sift;
mod solids;
#[cfg(test)]
mod tests;

use crate::kinematics::JointFrame;
use crate::{Joint, Motion, Robot, RobotError, Workcell};
use dcd_exec::{Exec, PerThread, Segments};
use dcd_geom::{Object, Pair, Pose, Scene, SceneError, Shape};
use dcd_gjk::{Overlap, Verdict};
use dcd_pipeline::{Candidate, LinkSet, Other, PairDecider, StaticWorld};
use dcd_simd::{Lanes, Path, WIDTH, dispatch_on};
use link_frames::{LinkFrames, Place};
use links::{Body, BodyHull, LinkSpheres, links};
use obstacle_tree::ObstacleTree;
use separate::Separate;
use sift::{Found, Rounded, Sift};
use solids::Solid;
use std::ops::Range;
use std::sync::{Arc, Mutex, OnceLock};

/// By how much spheres are compared larger, where they are to be apart, or smaller, where they are to touch. Unit:
/// metres a metre of the two sizes and places: 256 units of 2⁻²⁴, some four times what the roundings of frames,
/// centres and radii to f32 and the comparison itself come to (docs/numerics/proofs.md, "states in lanes").
/// Smaller: false answers. Larger: more is left to the narrow phase.
const MARGIN: f64 = 1.0 / (1 << 16) as f64;

/// How many packets of sixteen states are taken up together, so that what they leave fills the narrow phase's lanes.
/// Larger: more memory for a thread. No effect on any answer.
const PACKETS: usize = 4;

/// How many states those are.
const CHUNK: usize = PACKETS * WIDTH;

/// How many pairs of a state are decided at once where one hit is enough. Larger: more is decided in vain. Smaller:
/// lanes run empty.
const AT_ONCE: usize = 4;

/// How many configurations a [`PairDecider`] counts for each link.
const MOST_AT_ONCE: usize = 512;

/// Sixteen spheres, each metres.
struct Sixteen<L: Lanes> {
    centre: [L::F; 3],
    outer: L::F,
    inner: L::F,
    /// By how much a comparison may be off.
    margin: L::F,
}

impl<L: Lanes> Clone for Sixteen<L> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<L: Lanes> Copy for Sixteen<L> {}

/// What is asked for of each state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Goal {
    /// A hit.
    One,
    /// Every hit.
    All,
}

/// A pair of a state that is not known to be apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateHit {
    /// Which state.
    pub state: u32,
    /// The two objects of [`Workcell::scene`], i < j; [`Workcell::names_of`] has their names.
    pub pair: Pair,
    /// That they touch, or that it could not be settled.
    pub verdict: Verdict<()>,
}

impl StateHit {
    /// Whether it is a proved contact.
    pub fn touches(&self) -> bool {
        matches!(self.verdict, Verdict::Touching(()))
    }
}

/// Checks states of a robot in its world: the robot against the obstacles and against itself, with what it
/// carries, padded where it is padded; pairs that may touch are left out.
///
/// A planner's threads share one (`&self`); memory is kept for each thread. The answers do not depend on the
/// threads, nor on what else is asked.
///
/// ```
/// use dcd_robot::{AllowedPairs, LinkShapes, Robot, StateChecker, Workcell, World};
/// let urdf = r#"<robot name="pair">
///   <link name="base"><collision><geometry><sphere radius="0.2"/></geometry></collision></link>
///   <link name="hand"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
///   <joint name="slide" type="prismatic"><parent link="base"/><child link="hand"/><axis xyz="1 0 0"/>
///     <limit lower="0" upper="2" effort="1" velocity="1"/></joint></robot>"#;
/// let robot = Robot::read(urdf, std::path::Path::new("."), LinkShapes::Hulls)?;
/// let cell = Workcell::new(robot, &World::default(), &AllowedPairs::default())?;
/// let checker = StateChecker::new(cell)?;
/// assert_eq!(checker.collides(&[[0.25], [0.35]], dcd_pipeline::Par::Serial)?, [true, false]);
/// # Ok::<(), dcd_robot::RobotError>(())
/// ```
#[derive(Debug)]
pub struct StateChecker {
    prepared: Prepared,
    /// Made when the spheres first leave a pair to it, the obstacles' side for each cell.
    decider: OnceLock<PairDecider>,
    world: OnceLock<StaticWorld>,
    scratch: PerThread<Scratch>,
}

/// What does not depend on a state.
#[derive(Debug)]
struct Prepared {
    cell: Workcell,
    /// For each body its object in the scene and the part that moves it: the parts, then the padded ones.
    bodies: Vec<(u32, usize)>,
    /// For each body its vertices, if it is a hull.
    hulls: Vec<Option<BodyHull>>,
    solids: Vec<Solid>,
    /// Where there are many of them.
    tree: Option<ObstacleTree>,
    /// The spheres of what meets obstacles, link by link.
    world_links: Vec<LinkSpheres>,
    /// The spheres of what meets the robot, where they are not the same.
    own_links: Option<Vec<LinkSpheres>>,
    /// The links that may meet each other, by their places among those with spheres.
    link_pairs: Vec<[u32; 2]>,
    /// Whether some pair may touch, or does not meet.
    filtered: bool,
}

/// What a thread works with.
#[derive(Debug, Default)]
struct Scratch {
    frames: [LinkFrames; PACKETS],
    rounded: Rounded,
    found: Found,
    /// The pairs that are still to be decided, and those that are asked for now.
    left: Vec<Candidate>,
    asked: Vec<Candidate>,
    hits: Vec<StateHit>,
}

impl Prepared {
    fn of(cell: Workcell) -> Self {
        let parts = cell.robot().parts.len();
        let bodies = bodies(&cell);
        let is_padded = |part: usize| bodies[parts..].iter().any(|&(_, padded)| padded == part);
        let meets_world = |&number: &usize| number >= parts || !is_padded(number);
        let all = 0..bodies.len();
        let spheres = |numbers: &mut dyn Iterator<Item = usize>| {
            let shapes: Vec<Body<'_>> =
                numbers.map(|number| body(&cell, &bodies, number)).collect();
            links(cell.robot(), &shapes)
        };
        let world_links = spheres(&mut all.clone().filter(meets_world));
        let own_links = cell.is_padded().then(|| spheres(&mut (0..parts)));
        let hulls = all.clone().map(|number| BodyHull::of(&body(&cell, &bodies, number))).collect();
        let mut prepared = Self {
            bodies,
            hulls,
            solids: Vec::new(),
            tree: None,
            world_links,
            own_links,
            link_pairs: Vec::new(),
            filtered: false,
            cell,
        };
        prepared.take_obstacles();
        prepared.link_pairs = prepared.link_pairs();
        prepared
    }

    /// Whether a cell has the same robot, carrying the same.
    fn has_robot_of(&self, cell: &Workcell) -> bool {
        let (old, new) = (self.cell.robot(), cell.robot());
        bodies(cell) == self.bodies
            && old.links.len() == new.links.len()
            && old.joints.iter().map(kinematics).eq(new.joints.iter().map(kinematics))
            && (0..self.bodies.len()).all(|number| {
                let of = |cell| body(cell, &self.bodies, number);
                is_same_body(&of(&self.cell), &of(cell))
            })
    }

    /// Takes another cell of the same robot.
    fn exchange(&mut self, cell: Workcell) {
        let parts = 0..cell.robot().parts.len();
        let is_filtered_alike = self.cell.scene().has_same_filters(cell.scene(), parts);
        self.cell = cell;
        self.take_obstacles();
        if !is_filtered_alike {
            self.link_pairs = self.link_pairs();
        }
    }

    /// Takes the obstacles from the cell.
    fn take_obstacles(&mut self) {
        let scene = self.cell.scene();
        self.solids = self.obstacles().map(|i| Solid::of(scene, i)).collect();
        self.tree = ObstacleTree::of(scene, self.obstacles());
        self.filtered = scene.filters_movers();
    }

    fn robot(&self) -> &Robot {
        self.cell.robot()
    }

    fn obstacles(&self) -> Range<usize> {
        obstacles(&self.cell)
    }

    fn own_links(&self) -> &[LinkSpheres] {
        self.own_links.as_deref().unwrap_or(&self.world_links)
    }

    /// The pairs of links of which some bodies may not touch.
    fn link_pairs(&self) -> Vec<[u32; 2]> {
        let links = self.own_links();
        let bodies: Vec<Vec<u32>> = links.iter().map(LinkSpheres::bodies).collect();
        let mut pairs = Vec::new();
        for (b, of_b) in (0..).zip(&bodies) {
            for (a, of_a) in (0..b).zip(&bodies) {
                let meets = |&k: &u32| of_b.iter().any(|&other| self.allows(k, Other::Link(other)));
                if of_a.iter().any(meets) {
                    pairs.push([a, b]);
                }
            }
        }
        pairs
    }

    /// Whether a body is checked against an obstacle, by its number, or another body.
    #[inline]
    fn allows(&self, body: u32, other: Other) -> bool {
        if !self.filtered {
            return true;
        }
        let Pair { i, j } = self.pair(body, other);
        self.cell.scene().allows(i, j)
    }

    /// The objects of a pair.
    fn pair(&self, body: u32, other: Other) -> Pair {
        let object = |body: u32| self.bodies[body as usize].0;
        match other {
            Other::Obstacle(number) => {
                Pair::new(object(body), self.obstacles().start as u32 + number)
            }
            Other::Link(other) => Pair::new(object(body), object(other)),
        }
    }

    fn link_set(&self) -> LinkSet {
        let shape = |&(object, _): &(u32, usize)| self.cell.scene().shape(object as usize).clone();
        LinkSet::new(self.bodies.iter().map(shape).collect())
    }

    /// Where a body is.
    fn pose(&self, frames: &LinkFrames, lane: usize, body: usize) -> Result<Pose, RobotError> {
        let part = &self.robot().parts[self.bodies[body].1];
        let placed = frames.frame(part.link, lane).then(&part.origin);
        placed.pose().map_err(|error| {
            let user = format!("link {:?}", self.robot().links[part.link].name);
            RobotError::Pose { user, error }
        })
    }
}

/// For each body of a cell its object in the scene and the part that moves it: the parts, then the padded ones.
fn bodies(cell: &Workcell) -> Vec<(u32, usize)> {
    let moved = |i: usize| Some((i as u32, cell.part_of(i)?));
    (0..cell.scene().len()).filter_map(moved).collect()
}

/// The objects of the scene that stand still.
fn obstacles(cell: &Workcell) -> Range<usize> {
    let (first, end) = (cell.robot().parts.len(), cell.scene().len());
    first..(first..end).find(|&i| cell.part_of(i).is_some()).unwrap_or(end)
}

/// The obstacles as a world of their own, by their numbers.
fn world(cell: &Workcell) -> Result<StaticWorld, SceneError> {
    let (scene, obstacles) = (cell.scene(), obstacles(cell));
    let shapes: Vec<Shape> = obstacles.clone().map(|i| scene.shape(i).clone()).collect();
    let objects = (0..).zip(obstacles).map(|(s, i)| Object::new(s, scene.poses()[i]));
    let world = Scene::new(shapes, objects)?;
    StaticWorld::new(&world, Overlap::default(), dcd_pipeline::Par::Serial)
}

fn body<'a>(cell: &'a Workcell, bodies: &[(u32, usize)], number: usize) -> Body<'a> {
    let (object, part) = bodies[number];
    let part = &cell.robot().parts[part];
    let (link, shape, origin) = (part.link, cell.scene().shape(object as usize), part.origin);
    Body { number: number as u32, link, shape, origin }
}

/// Whether two bodies are placed alike and share their shape.
fn is_same_body(a: &Body<'_>, b: &Body<'_>) -> bool {
    let shapes_are_one = match (a.shape, b.shape) {
        (Shape::Polytope(a), Shape::Polytope(b)) => Arc::ptr_eq(a, b),
        (Shape::Mesh(a), Shape::Mesh(b)) => Arc::ptr_eq(a, b),
        (Shape::Compound(a), Shape::Compound(b)) => Arc::ptr_eq(a, b),
        (Shape::Curved(a), Shape::Curved(b)) => a == b,
        _ => false,
    };
    shapes_are_one && a.link == b.link && a.origin == b.origin
}

/// What a cell holds, made if it is the first to be asked for.
fn made<T>(
    cell: &OnceLock<T>,
    make: impl FnOnce() -> Result<T, SceneError>,
) -> Result<&T, SceneError> {
    match cell.get() {
        Some(held) => Ok(held),
        None => make().map(|new| cell.get_or_init(|| new)),
    }
}

/// What of a joint says where its child is.
fn kinematics(joint: &Joint) -> (usize, usize, &Motion, &JointFrame) {
    (joint.parent, joint.child, &joint.motion, &joint.origin)
}

impl StateChecker {
    /// For the robot of a work cell, with what it carries, among its obstacles.
    ///
    /// # Errors
    /// More than 2³² objects, each body counted 512 times.
    pub fn new(cell: Workcell) -> Result<Self, RobotError> {
        Self::check_count(&cell)?;
        Ok(Self {
            prepared: Prepared::of(cell),
            decider: OnceLock::new(),
            world: OnceLock::new(),
            scratch: PerThread::default(),
        })
    }

    /// Checks in another cell from now on. Where the robot and what it carries are clones of those that there
    /// were, padded alike, only the obstacles are prepared.
    ///
    /// # Errors
    /// Those of [`StateChecker::new`]; nothing is changed then.
    pub fn set_cell(&mut self, cell: Workcell) -> Result<(), RobotError> {
        Self::check_count(&cell)?;
        if self.prepared.has_robot_of(&cell) {
            self.prepared.exchange(cell);
            self.world = OnceLock::new();
        } else {
            *self = Self::new(cell)?;
        }
        Ok(())
    }

    /// That what the narrow phase counts is within a u32.
    fn check_count(cell: &Workcell) -> Result<(), RobotError> {
        let count = cell.scene().len().saturating_mul(MOST_AT_ONCE);
        let too_many = |_| RobotError::Scene(SceneError::TooMany { what: "objects", count });
        u32::try_from(count).map(drop).map_err(too_many)
    }

    /// What decides pairs, and the obstacles prepared for it.
    fn decider(&self) -> Result<(&PairDecider, &StaticWorld), SceneError> {
        let decider = || PairDecider::new(self.prepared.link_set(), CHUNK);
        let world = || world(&self.prepared.cell);
        Ok((made(&self.decider, decider)?, made(&self.world, world)?))
    }

    /// The cell, its robot in whatever state.
    pub fn cell(&self) -> &Workcell {
        &self.prepared.cell
    }

    /// Computes where the links are and nothing else: what every question begins with, for measurements.
    ///
    /// # Errors
    /// Those of [`StateChecker::collides`] but for links out of range.
    #[doc(hidden)]
    pub fn place_links<S: AsRef<[f64]>>(&self, states: &[S]) -> Result<(), RobotError> {
        let refused = |(state, error)| RobotError::AtState { state, error: Box::new(error) };
        self.scratch.with(|scratch| {
            let mut chunks = states.chunks(CHUNK).enumerate();
            chunks.try_for_each(|(chunk, states)| {
                let placed = scratch.place(&self.prepared, states);
                placed.map_err(|error| refused(at(chunk * CHUNK, error)))
            })
        })
    }

    /// For each state whether it is not proved free: whether something touches or could not be settled.
    ///
    /// # Errors
    /// A state with another number of values than the robot has, or that [`Robot::place`] refuses; a link out of
    /// range: by the state's index.
    pub fn collides<'e, S: AsRef<[f64]> + Sync>(
        &self,
        states: &[S],
        exec: impl Into<Exec<'e>>,
    ) -> Result<Vec<bool>, RobotError> {
        Ok(self.first(states, exec)?.iter().map(Option::is_some).collect())
    }

    /// For each state one contact, if it has any: the one that was found first, always the same. Where nothing is
    /// known to touch, a pair that could not be settled, if there is one.
    ///
    /// # Errors
    /// Those of [`StateChecker::collides`].
    pub fn first<'e, S: AsRef<[f64]> + Sync>(
        &self,
        states: &[S],
        exec: impl Into<Exec<'e>>,
    ) -> Result<Vec<Option<StateHit>>, RobotError> {
        let mut first = vec![None; self.count(states)?];
        let refused = Refused::default();
        exec.into().divide(&mut first[..], CHUNK, |start, first| {
            self.scratch.with(|scratch| {
                let states = &states[start..start + first.len()];
                let found = scratch.first(self, (start, states), first);
                found.unwrap_or_else(|(state, error)| refused.note(state, error));
            });
        });
        refused.check()?;
        Ok(first)
    }

    /// Every pair that touches or could not be settled, state by state, in the order of the objects.
    ///
    /// # Errors
    /// Those of [`StateChecker::collides`].
    pub fn all<'e, S: AsRef<[f64]> + Sync>(
        &self,
        states: &[S],
        exec: impl Into<Exec<'e>>,
    ) -> Result<Vec<StateHit>, RobotError> {
        let (count, refused) = (self.count(states)?, Refused::default());
        let mut all = Segments::default();
        all.fill(exec.into(), count.div_ceil(CHUNK), |task, out| {
            self.scratch.with(|scratch| {
                let start = task * CHUNK;
                let states = &states[start..count.min(start + CHUNK)];
                let found = scratch.all(self, (start, states));
                found.unwrap_or_else(|(state, error)| refused.note(state, error));
                out.append(&mut scratch.hits);
            });
        });
        refused.check()?;
        Ok(all.iter().flatten().copied().collect())
    }

    /// How many states there are.
    fn count<S>(&self, states: &[S]) -> Result<usize, RobotError> {
        let (what, count) = ("states", states.len());
        let too_many = |_| RobotError::Scene(SceneError::TooMany { what, count });
        u32::try_from(count).map(|_| count).map_err(too_many)
    }
}

/// A state, counted from the first of those taken up, and why it was refused.
type RefusedState = (usize, RobotError);

impl Scratch {
    fn first<S: AsRef<[f64]>>(
        &mut self,
        checker: &StateChecker,
        (start, states): (usize, &[S]),
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
        let mut left = std::mem::take(&mut self.left);
        left.clear();
        left.extend(self.found.candidates.iter().map(|&(candidate, _)| candidate));
        left.sort_unstable();
        left.dedup();
        let touches = |hit: &Option<StateHit>| hit.as_ref().is_some_and(StateHit::touches);
        loop {
            // The next pairs of each state that has no contact yet.
            self.asked.clear();
            let mut taken = (u32::MAX, 0);
            left.retain(|candidate| {
                let state = candidate.configuration;
                if touches(&first[state as usize]) {
                    return false;
                }
                taken = if taken.0 == state { (state, taken.1 + 1) } else { (state, 0) };
                let is_next = taken.1 < AT_ONCE;
                if is_next {
                    self.asked.push(*candidate);
                }
                !is_next
            });
            if self.asked.is_empty() {
                break;
            }
            self.decide(checker, |candidate, verdict| {
                let first = &mut first[candidate.configuration as usize];
                let found = hit(&candidate, verdict);
                if found.touches() && !touches(first) {
                    *first = Some(found);
                }
                first.get_or_insert(found);
            })
            .map_err(|e| at(start, e))?;
        }
        self.left = left;
        Ok(())
    }

    fn all<S: AsRef<[f64]>>(
        &mut self,
        checker: &StateChecker,
        (start, states): (usize, &[S]),
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
        self.asked.clear();
        self.asked.extend(self.found.candidates.iter().map(|&(candidate, _)| candidate));
        self.asked.sort_unstable();
        self.asked.dedup();
        let decided = self.decide(checker, note);
        hits.sort_unstable_by_key(|hit| (hit.state, hit.pair, !hit.touches()));
        hits.dedup_by_key(|hit| (hit.state, hit.pair));
        self.hits = hits;
        decided.map_err(|e| at(start, e))
    }

    /// Where the states' links are.
    fn place<S: AsRef<[f64]>>(
        &mut self,
        prepared: &Prepared,
        states: &[S],
    ) -> Result<(), RefusedState> {
        let robot = prepared.robot();
        for (k, state) in states.iter().enumerate() {
            robot.check_state(state.as_ref()).map_err(|error| (k, error))?;
        }
        for (packet, (states, frames)) in states.chunks(WIDTH).zip(&mut self.frames).enumerate() {
            frames.read(robot, states);
            dispatch_on(Path::best(), Place { robot, states, to: frames });
            // Refused even where no pair asks for the link.
            for (lane, state) in states.iter().enumerate().filter(|&(k, _)| !frames.is_finite(k)) {
                let placed = robot.place(state.as_ref(), &mut Vec::new());
                placed.map_err(|error| (packet * WIDTH + lane, error))?;
            }
        }
        Ok(())
    }

    /// What the spheres of the states' links tell.
    fn sift<S: AsRef<[f64]>>(
        &mut self,
        prepared: &Prepared,
        states: &[S],
        goal: Goal,
    ) -> Result<(), RefusedState> {
        self.place(prepared, states)?;
        let Self { frames, rounded, found, .. } = self;
        found.touching.clear();
        found.candidates.clear();
        for (packet, (states, frames)) in states.chunks(WIDTH).zip(frames).enumerate() {
            let (first, open) = ((packet * WIDTH) as u32, (1 << states.len()) - 1);
            let from = found.candidates.len();
            let (path, round) = (Path::best(), &mut *rounded);
            let left = &mut *found;
            let sift = Sift { prepared, frames, rounded: round, first, open, goal, found: left };
            let open = dispatch_on(path, sift);
            let (rounded, found) = (&*rounded, &mut *found);
            dispatch_on(path, Separate { prepared, rounded, first, open, goal, found, from });
        }
        Ok(())
    }

    /// Decides the pairs that are asked for.
    fn decide(
        &self,
        checker: &StateChecker,
        mut note: impl FnMut(Candidate, Verdict<()>),
    ) -> Result<(), RefusedState> {
        if self.asked.is_empty() {
            return Ok(());
        }
        let prepared = &checker.prepared;
        let (decider, world) = checker.decider().map_err(|error| (0, RobotError::Scene(error)))?;
        let mut refused: Option<RefusedState> = None;
        let pose = |state: usize, body: usize| {
            let pose = prepared.pose(&self.frames[state / WIDTH], state % WIDTH, body);
            pose.unwrap_or_else(|error| {
                if refused.as_ref().is_none_or(|&(first, _)| state < first) {
                    refused = Some((state, error));
                }
                Pose::IDENTITY
            })
        };
        let decided = decider.decide(world, &self.asked, pose, |hit| {
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
                (state, RobotError::Scene(SceneError::OutOfRange { object, reach }))
            }
            other => (0, RobotError::Scene(other)),
        })
    }
}

/// A refusal counted from the batch's first state on.
fn at(start: usize, (state, error): RefusedState) -> RefusedState {
    (start + state, error)
}

/// The first state that was refused, on any thread.
#[derive(Default)]
struct Refused(Mutex<Option<RefusedState>>);

impl Refused {
    fn note(&self, state: usize, error: RobotError) {
        let mut first = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if first.as_ref().is_none_or(|&(earlier, _)| state < earlier) {
            *first = Some((state, error));
        }
    }

    fn check(self) -> Result<(), RobotError> {
        match self.0.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner) {
            Some((state, error)) => Err(RobotError::AtState { state, error: Box::new(error) }),
            None => Ok(()),
        }
    }
}
