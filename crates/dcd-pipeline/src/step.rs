//! One step, stage by stage.

use dcd_broad::{BroadPhase, WideTree};
use dcd_exec::{Cut, Exec, PerThread, Segments, Stage};
use dcd_geom::{Aabb, Pair, Scene};
use dcd_gjk::{Contact, Findings, NarrowPhase, Overlap, Report};

/// How many objects a task prepares. Larger: fewer tasks to share. Smaller: more overhead a task
/// (about a microsecond). A scene of at most this many objects is prepared without the pool.
const OBJECTS_PER_TASK: usize = 256;

/// How many candidate pairs a task judges, at most: some tens of microseconds. A scene of at most
/// this many candidates is judged without the pool.
const PAIRS_PER_TASK: usize = 2048;

/// Broad phase, narrow phase, and every buffer between them, kept from step to step.
#[derive(Debug, Default)]
pub struct Pipeline<B = WideTree, N: NarrowPhase = Overlap> {
    broad: B,
    narrow: N,
    frame: N::Frame,
    aabbs: Vec<Aabb>,
    candidates: Segments<Pair>,
    slices: Vec<Cut>,
    contacts: Segments<Contact<N::Answer>>,
    scratch: PerThread<N::Scratch>,
    reports: PerThread<Report>,
    report: Report,
}

impl<B: BroadPhase, N: NarrowPhase> Pipeline<B, N> {
    /// From the two phases, which may be anybody's.
    pub fn new(broad: B, narrow: N) -> Self {
        Self {
            broad,
            narrow,
            frame: N::Frame::default(),
            aabbs: Vec::new(),
            candidates: Segments::default(),
            slices: Vec::new(),
            contacts: Segments::default(),
            scratch: PerThread::default(),
            reports: PerThread::default(),
            report: Report::default(),
        }
    }

    /// Finds every touching pair of the scene as it stands. `exec` is a [`dcd_exec::Par`], or an
    /// [`Exec`] with an observer.
    ///
    /// The result, its order included, does not depend on `exec` or on earlier steps. Nothing can
    /// fail; a pair that could not be settled is listed as undecided. After the first steps a
    /// serial step of a like scene allocates nothing.
    pub fn step<'e>(&mut self, scene: &Scene, exec: impl Into<Exec<'e>>) -> Step<'_, N::Answer> {
        let exec = exec.into();
        exec.stage(Stage::Boxes, || self.prepare(scene, exec));
        exec.stage(Stage::Build, || self.broad.build(&self.aabbs, exec));
        exec.stage(Stage::Pairs, || self.find_candidates(scene, exec));
        exec.stage(Stage::Narrow, || self.judge(scene, exec));
        Step {
            aabbs: &self.aabbs,
            candidates: &self.candidates,
            contacts: &self.contacts,
            report: &self.report,
        }
    }

    fn prepare(&mut self, scene: &Scene, exec: Exec) {
        self.aabbs.resize(scene.len(), Aabb::default());
        let part = self.narrow.lay_out(scene, &mut self.frame);
        let narrow = &self.narrow;
        exec.divide((part, &mut self.aabbs[..]), OBJECTS_PER_TASK, |first, (part, aabbs)| {
            narrow.prepare(scene, first, part, aabbs);
        });
    }

    fn find_candidates(&mut self, scene: &Scene, exec: Exec) {
        if scene.is_filtered() {
            let keep = |i, j| scene.allows(i, j);
            self.broad.pairs(&self.aabbs, keep, exec, &mut self.candidates);
        } else {
            self.broad.pairs(&self.aabbs, |_, _| true, exec, &mut self.candidates);
        }
    }

    fn judge(&mut self, scene: &Scene, exec: Exec) {
        let Self { narrow, frame, candidates, slices, contacts, scratch, reports, report, .. } =
            self;
        candidates.cut(PAIRS_PER_TASK, slices);
        contacts.fill(exec, slices.len(), |k, contacts| {
            scratch.with(|scratch| {
                reports.with(|report| {
                    let pairs = candidates.slice(slices[k]);
                    narrow.decide(scene, frame, pairs, scratch, &mut Findings { contacts, report });
                });
            });
        });
        report.clear();
        reports.iter_mut().for_each(|part| report.absorb(part));
        report.sort();
    }
}

/// What a step found. Borrows the pipeline's buffers.
#[derive(Debug)]
pub struct Step<'p, A: Send> {
    aabbs: &'p [Aabb],
    candidates: &'p Segments<Pair>,
    contacts: &'p Segments<Contact<A>>,
    report: &'p Report,
}

impl<'p, A: Copy + Send> Step<'p, A> {
    /// The touching pairs (i, j), i < j, in an order that depends on the scene alone.
    pub fn contacts(&self) -> impl Iterator<Item = (u32, u32)> + use<'p, A> {
        self.answers().map(|contact| contact.pair.into())
    }

    /// The touching pairs with what was asked for about them, in the same order.
    pub fn answers(&self) -> impl Iterator<Item = Contact<A>> + use<'p, A> {
        self.contacts.iter().flatten().copied()
    }

    /// How many pairs touch.
    pub fn contact_count(&self) -> usize {
        self.contacts.len()
    }

    /// The pairs whose boxes overlap, in a fixed order.
    pub fn candidates(&self) -> impl Iterator<Item = Pair> + use<'p, A> {
        self.candidates.iter().flatten().copied()
    }

    /// How many candidate pairs there were.
    pub fn candidate_count(&self) -> usize {
        self.candidates.len()
    }

    /// The box of each object.
    pub fn aabbs(&self) -> &'p [Aabb] {
        self.aabbs
    }

    /// How many pairs each rung settled, and those that none did.
    pub fn report(&self) -> &'p Report {
        self.report
    }
}
