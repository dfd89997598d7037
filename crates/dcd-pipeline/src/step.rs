//! One step, stage by stage.

use crate::moving_ranges::{empty_free_slots, for_each_range, moving_ranges};
use crate::partition::{Boxed, CandidateSearch, Partition};
use crate::queries::{Queries, QueryError, Trees};
use dcd_broad::{BroadPhase, WideTree};
use dcd_exec::{Cut, Exec, PerThread, Segmented, Segments, Stage};
use dcd_geom::{Aabb, Pair, Revision, Scene};
use dcd_gjk::{
    Contact, ContactAnswer, ContactList, ContactSink, ContactsOf, NarrowPhase, Overlap, Prepared,
    Report, Sides,
};
use std::ops::Range;

/// How many objects a task prepares. Larger: fewer tasks to share. Smaller: more overhead a task
/// (about a microsecond). A scene of at most this many objects is prepared without the pool.
const OBJECTS_PER_TASK: usize = 256;

/// How many candidate pairs a task judges, at most. Smaller: the lanes' last packets, which are not full, are more of the
/// work. A scene of at most [`NarrowPhase::fewest_pairs`] candidates is judged without the pool.
const PAIRS_PER_TASK: usize = 2048;

/// Among how many tasks few pairs are shared, where each is worth one. Smaller: threads that wait for the last one.
const TASKS: usize = 16;

/// Candidate pairs, and which of them each task judges.
#[derive(Debug, Default)]
struct Candidates {
    /// Of two moving objects.
    among: Segments<Pair>,
    /// Of a moving and a static one.
    between: Segments<Pair>,
    slices: [Vec<Cut>; 2],
    /// The slices of each task, numbered through both lists.
    tasks: Vec<Range<usize>>,
    /// How many pairs a task has at most.
    per_task: usize,
}

impl Candidates {
    /// Cuts both lists anew, and shares the slices out, so many pairs a task or more where there are more than
    /// [`TASKS`] times as many.
    fn cut(&mut self, fewest: usize) {
        let all = self.among.len() + self.between.len();
        let per_task = (all / TASKS).clamp(fewest.clamp(1, PAIRS_PER_TASK), PAIRS_PER_TASK);
        self.per_task = per_task;
        self.among.cut(per_task, &mut self.slices[0]);
        self.between.cut(per_task, &mut self.slices[1]);
        self.tasks.clear();
        let mut pairs = 0;
        for k in 0..self.slices[0].len() + self.slices[1].len() {
            let more = self.slice(k).len();
            match self.tasks.last_mut() {
                Some(last) if pairs + more <= per_task => {
                    last.end = k + 1;
                    pairs += more;
                }
                _ => {
                    self.tasks.push(k..k + 1);
                    pairs = more;
                }
            }
        }
    }

    fn slice(&self, k: usize) -> &[Pair] {
        match k.checked_sub(self.slices[0].len()) {
            None => self.among.slice(self.slices[0][k]),
            Some(k) => self.between.slice(self.slices[1][k]),
        }
    }

    /// All slices, in order.
    fn slices(&self) -> impl Iterator<Item = &[Pair]> + Clone {
        (0..self.slices[0].len() + self.slices[1].len()).map(|k| self.slice(k))
    }

    /// The pairs of a task, in one piece: in `joined` where they lie in several.
    fn of_task<'a>(&'a self, task: usize, joined: &'a mut Vec<Pair>) -> &'a [Pair] {
        let slices = self.tasks[task].clone();
        if slices.len() == 1 {
            return self.slice(slices.start);
        }
        joined.clear();
        joined.reserve(self.per_task);
        slices.for_each(|k| joined.extend_from_slice(self.slice(k)));
        joined
    }

    /// Those of them that are wanted.
    fn of_task_where<'a>(
        &self,
        task: usize,
        is_wanted: impl Fn(Pair) -> bool,
        joined: &'a mut Vec<Pair>,
    ) -> &'a [Pair] {
        joined.clear();
        joined.reserve(self.per_task);
        for k in self.tasks[task].clone() {
            joined.extend(self.slice(k).iter().copied().filter(|&pair| is_wanted(pair)));
        }
        joined
    }
}

/// Whether an object of a pair is a sensor.
fn has_sensor(sensors: &[bool], pair: Pair) -> bool {
    sensors[pair.i as usize] || sensors[pair.j as usize]
}

/// What a thread reuses from task to task.
#[derive(Debug, Default)]
struct WorkerScratch<S> {
    scratch: S,
    joined: Vec<Pair>,
    report: Report,
}

/// Broad phase, narrow phase, and every buffer between them, kept from step to step.
///
/// ```
/// use dcd_pipeline::prelude::*;
/// let poses = [0.0, 0.9, 2.1].map(|x| Pose::from_translation(DVec3::X * x));
/// let poses = poses.into_iter().collect::<Result<Vec<_>, _>>()?;
/// let scene = Scene::one_each(vec![Shape::sphere(0.5)?; 3], poses)?;
/// let mut pipeline = Pipeline::new();
/// let step = pipeline.step(&scene, Par::Pool);
/// assert_eq!(step.contacts().collect::<Vec<_>>(), [(0, 1)]);
/// assert!(step.report().undecided().is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Default)]
pub struct Pipeline<B = WideTree, N: NarrowPhase = Overlap> {
    broad: B,
    narrow: N,
    frame: N::Frame,
    aabbs: Vec<Aabb>,
    partition: Partition,
    candidates: Candidates,
    contacts: Segmented<ContactsOf<N::Answer>>,
    /// The touching pairs of which one is a sensor; nobody reads their answers.
    sensor_pairs: Segmented<ContactsOf<N::Answer>>,
    workers: PerThread<WorkerScratch<N::Scratch>>,
    report: Report,
    stepped: Option<Stepped>,
}

/// Marks what a step has seen: layout, static objects, poses.
type Stepped = [Revision; 3];

fn revisions(scene: &Scene) -> Stepped {
    [scene.layout(), scene.statics(), scene.pose_revision()]
}

/// The predicate that keeps every pair. A function, since a closure's type would be another for every
/// pipeline, and the search would be compiled for each.
pub(crate) fn any(_: u32, _: u32) -> bool {
    true
}

impl Pipeline {
    /// The fastest tree and proved answers: [`WideTree`] and [`Overlap`].
    pub fn new() -> Self {
        Self::default()
    }
}

impl<B: BroadPhase, N: NarrowPhase> Pipeline<B, N> {
    /// A pipeline of these two phases, which may be the caller's own.
    pub fn with(broad: B, narrow: N) -> Self {
        Self {
            broad,
            narrow,
            frame: N::Frame::default(),
            aabbs: Vec::new(),
            partition: Partition::default(),
            candidates: Candidates::default(),
            contacts: Segmented::default(),
            sensor_pairs: Segmented::default(),
            workers: PerThread::default(),
            report: Report::default(),
            stepped: None,
        }
    }

    /// Derives what depends on the scene's shapes alone, and allocates for its objects: what a first step
    /// would do before anything else. No effect on any result.
    pub fn prepare_shapes(&mut self, scene: &Scene) {
        self.narrow.layout(scene, Sides::One, &mut self.frame);
    }

    /// Finds every touching pair of the scene as it stands. `exec` is a [`dcd_exec::Par`], or an
    /// [`Exec`] with an observer.
    ///
    /// The result, its order included, does not depend on `exec` or on earlier steps. Nothing can
    /// fail; a pair that could not be decided is listed as undecided. After the first steps a
    /// serial step of a like scene allocates nothing.
    ///
    /// What is prepared of the static objects is kept until one of them changes, any object comes or
    /// goes, or the narrow phase says that it has not kept it ([`NarrowPhase::keeps`]); the tree over
    /// them, for as long as their AABBs are the same bytes. Nothing else outlasts a step that could
    /// change a result or an order: what a step reports is a function of the scene, the predicate and the
    /// two phases.
    pub fn step<'e>(&mut self, scene: &Scene, exec: impl Into<Exec<'e>>) -> Step<'_, N::Answer> {
        self.step_where(scene, exec, any)
    }

    /// The same for the pairs i < j that also `may(i, j)`. It is called during the search, after the
    /// scene's own filters and before any narrow work, perhaps on many threads; it must answer
    /// the same for one pair in one step.
    pub fn step_where<'e>(
        &mut self,
        scene: &Scene,
        exec: impl Into<Exec<'e>>,
        may: impl Fn(u32, u32) -> bool + Sync,
    ) -> Step<'_, N::Answer> {
        let exec = exec.into();
        if scene.len() <= OBJECTS_PER_TASK {
            self.walk(scene, exec, &may);
        } else {
            exec.within_pool(|exec| self.walk(scene, exec, &may));
        }
        Step {
            layout: scene.layout(),
            aabbs: &self.aabbs,
            candidates: &self.candidates,
            contacts: &self.contacts,
            sensor_pairs: &self.sensor_pairs,
            report: &self.report,
        }
    }

    /// Queries of the scene as it stood at the last step, on that step's AABBs and trees: rays, points, regions,
    /// nearest objects, shapes that move. Nothing is built.
    ///
    /// # Errors
    /// There was no step, or the scene is another than at the last one: an object has moved, come or gone, or
    /// changed its shape. Filters, sensors and the caller's own numbers may have changed; they are read anew.
    pub fn queries<'a>(&'a self, scene: &'a Scene) -> Result<Queries<'a>, QueryError> {
        match self.stepped {
            None => Err(QueryError::NoStep),
            Some(stepped) if stepped != revisions(scene) => Err(QueryError::SceneChanged),
            Some(_) => {
                let trees = Trees {
                    movers: self.broad.tree(),
                    mover_slots: self.partition.mover_slots(scene),
                    statics: self.partition.statics(),
                };
                Ok(Queries::new(scene, &self.aabbs, trees))
            }
        }
    }

    /// All stages.
    fn walk(&mut self, scene: &Scene, exec: Exec, may: &(impl Fn(u32, u32) -> bool + Sync)) {
        // Known once all is done: a shape of the caller's own may panic, and what is prepared holds no longer.
        if self.stepped.take().is_none() {
            self.frame = N::Frame::default();
            self.partition.forget();
        }
        let prepared = exec.stage(Stage::Boxes, || self.prepare(scene, exec));
        exec.stage(Stage::Build, || {
            self.partition.build(scene, (&self.aabbs, prepared), &mut self.broad, exec);
        });
        exec.stage(Stage::Pairs, || {
            let Candidates { among, between, .. } = &mut self.candidates;
            let search = CandidateSearch { scene, may, exec, among, between };
            self.partition.find(&self.aabbs, &mut self.broad, search);
        });
        exec.stage(Stage::Narrow, || self.judge(scene, exec));
        self.stepped = Some(revisions(scene));
    }

    /// Prepares the objects. Skips static objects that are prepared already, where no moving one is between: if
    /// the scene says that they have not changed and the narrow phase that its frame has not.
    fn prepare(&mut self, scene: &Scene, exec: Exec) -> Boxed {
        self.aabbs.resize(scene.len(), Aabb::EMPTY);
        let has_free_slots = scene.object_count() < scene.len();
        let part = self.narrow.layout(scene, Sides::One, &mut self.frame);
        let may_rest = scene.static_count() > 0 && self.partition.still_holds(scene);
        let rest = may_rest && self.narrow.keeps(&part);
        let narrow = &self.narrow;
        exec.divide((part, &mut self.aabbs[..]), OBJECTS_PER_TASK, |first, objects| {
            let prepare = |slots: Range<usize>, (part, aabbs): (N::Part<'_>, &mut [Aabb])| {
                narrow.prepare(scene, slots.start, part, aabbs);
                if has_free_slots {
                    empty_free_slots(scene, slots.start, aabbs);
                }
            };
            let slots = first..first + objects.1.len();
            if rest {
                for_each_range(objects, first, moving_ranges(scene, slots), prepare);
            } else {
                prepare(slots, objects);
            }
        });
        if rest { Boxed::Moving } else { Boxed::All }
    }

    fn judge(&mut self, scene: &Scene, exec: Exec) {
        let Self { narrow, frame, candidates, contacts, sensor_pairs, workers, report, .. } = self;
        candidates.cut(narrow.fewest_pairs(frame));
        let candidates = &*candidates;
        narrow.begin_pairs(frame, candidates.slices());
        // Of a step that a panic has ended.
        workers.iter_mut().for_each(|worker| worker.report.clear());
        let side = Prepared { scene, frame: &*frame };
        let sensors = scene.has_sensors().then(|| scene.sensors());
        contacts.fill(exec, candidates.tasks.len(), |task, contacts| {
            workers.with(|WorkerScratch { scratch, joined, report }| {
                let pairs = match sensors {
                    None => candidates.of_task(task, joined),
                    Some(sensors) => {
                        candidates.of_task_where(task, |pair| !has_sensor(sensors, pair), joined)
                    }
                };
                let sink = &mut ContactSink { contacts, report };
                narrow.decide(side, side, pairs, scratch, sink);
            });
        });
        let sensing = if sensors.is_some() { candidates.tasks.len() } else { 0 };
        sensor_pairs.fill(exec, sensing, |task, contacts| {
            workers.with(|WorkerScratch { scratch, joined, report }| {
                let is_sensed = |pair| has_sensor(scene.sensors(), pair);
                let pairs = candidates.of_task_where(task, is_sensed, joined);
                let sink = &mut ContactSink { contacts, report };
                narrow.sense(side, side, pairs, scratch, sink);
            });
        });
        report.clear();
        workers.iter_mut().for_each(|worker| report.absorb(&mut worker.report));
        report.sort();
    }
}

/// What a step found. Borrows the pipeline's buffers.
#[derive(Debug)]
pub struct Step<'p, A: ContactAnswer> {
    /// Of the scene.
    layout: Revision,
    aabbs: &'p [Aabb],
    candidates: &'p Candidates,
    contacts: &'p Segmented<A::List>,
    sensor_pairs: &'p Segmented<A::List>,
    report: &'p Report,
}

impl<'p, A: ContactAnswer> Step<'p, A> {
    /// The touching pairs (i, j), i < j, in an order that depends on the scene alone; pairs with a sensor are
    /// not among them.
    pub fn contacts(&self) -> impl Iterator<Item = (u32, u32)> + use<'p, A> {
        pairs_of::<A>(self.contacts)
    }

    /// The touching pairs with their answers, in the same order.
    pub fn answers(&self) -> impl Iterator<Item = Contact<A>> + use<'p, A> {
        self.contacts.spans().flat_map(|(list, numbers)| list.contacts(numbers))
    }

    /// The touching pairs (i, j), i < j, of which at least one is a sensor ([`dcd_geom::Object::sensor`]), in a
    /// fixed order. Where the question has a margin, those within it.
    pub fn sensor_pairs(&self) -> impl Iterator<Item = (u32, u32)> + use<'p, A> {
        pairs_of::<A>(self.sensor_pairs)
    }

    /// How many pairs touch, sensors apart.
    pub fn contact_count(&self) -> usize {
        self.contacts.len()
    }

    /// The pairs whose AABBs overlap, in a fixed order: those of two moving objects first.
    pub fn candidates(&self) -> impl Iterator<Item = Pair> + use<'p, A> {
        let Candidates { among, between, .. } = self.candidates;
        among.iter().chain(between.iter()).flatten().copied()
    }

    /// How many candidate pairs there were.
    pub fn candidate_count(&self) -> usize {
        self.candidates.among.len() + self.candidates.between.len()
    }

    /// The AABB of each slot; empty where it is free.
    pub fn aabbs(&self) -> &'p [Aabb] {
        self.aabbs
    }

    /// How many pairs each method decided, and the undecided ones.
    pub fn report(&self) -> &'p Report {
        self.report
    }
}

/// A step whose pairs [`Events`](crate::Events) compare with those of the one before: a [`Step`] of any answers, or an
/// [`AnyStep`](crate::AnyStep).
pub trait StepPairs: Sealed {
    /// [`Step::contacts`].
    fn contact_pairs(&self) -> impl Iterator<Item = (u32, u32)>;

    /// [`Step::sensor_pairs`].
    fn pairs_with_sensors(&self) -> impl Iterator<Item = (u32, u32)>;

    /// [`Scene::layout`] at the step.
    fn layout(&self) -> Revision;
}

/// What keeps [`StepPairs`] to the types of this crate.
pub trait Sealed {}

impl<A: ContactAnswer> Sealed for Step<'_, A> {}

impl<A: ContactAnswer> StepPairs for Step<'_, A> {
    fn contact_pairs(&self) -> impl Iterator<Item = (u32, u32)> {
        self.contacts()
    }

    fn pairs_with_sensors(&self) -> impl Iterator<Item = (u32, u32)> {
        self.sensor_pairs()
    }

    fn layout(&self) -> Revision {
        self.layout
    }
}

/// The pairs of contacts.
fn pairs_of<A: ContactAnswer>(contacts: &Segmented<A::List>) -> impl Iterator<Item = (u32, u32)> {
    contacts.spans().flat_map(|(list, numbers)| list.pairs(numbers)).map(Pair::into)
}
