//! The trait for a narrow phase of one's own, and what an answer is.

use crate::{ContactAnswer, ContactList};
use dcd_geom::{Aabb, Pair, Scene, Splittable};

/// What is known of a pair: one of three, never a guess dressed as an answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict<A> {
    /// No common point.
    Apart,
    /// At least one common point, and the answer about it.
    Touching(A),
    /// Not known, and why.
    Undecided(Reason),
}

impl<A> Verdict<A> {
    /// The same with another answer, made of this one.
    #[inline(always)]
    pub fn map<B>(self, answer: impl FnOnce(A) -> B) -> Verdict<B> {
        match self {
            Self::Apart => Verdict::Apart,
            Self::Touching(found) => Verdict::Touching(answer(found)),
            Self::Undecided(reason) => Verdict::Undecided(reason),
        }
    }
}

/// Why a pair stayed undecided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Reason {
    /// The gap or overlap is smaller than the rounding of this method's arithmetic.
    WithinRounding,
    /// The documented bound on iterations was reached.
    Iterations,
    /// Simplified shapes differ here: the outer ones touch, the inner ones do not.
    WithinTolerance,
    /// The numbers leave the range in which this method's bounds hold.
    Range,
    /// A compound or a mesh, given to a solver that knows convex shapes alone.
    NotConvex,
    /// The foreign library behind the trait gave no answer.
    Foreign,
}

/// A touching pair and the answer about it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contact<A> {
    /// The objects.
    pub pair: Pair,
    /// Nothing (`()`), a distance, a depth, …
    pub answer: A,
}

/// A pair that stayed undecided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Undecided {
    /// The objects.
    pub pair: Pair,
    /// Why.
    pub reason: Reason,
}

/// The method that resolved a pair, from the cheapest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Method {
    /// An earlier step's proof, which still holds.
    Remembered,
    /// Inner and outer spheres, f32 lanes; in scenes of spheres alone these themselves, f64.
    Spheres,
    /// A box round and a box inside each shape, f32 lanes.
    Obbs,
    /// The axis between the centres, or one remembered from an earlier step, f32 lanes.
    CentreAxis,
    /// The inner sphere and one support point, f32 lanes.
    Cone,
    /// The inner sphere and two or three support points, or a later axis; of rounded shapes the nearest
    /// points of their cores. f32 lanes.
    Portal,
    /// A solver in plain f32.
    F32,
    /// A solver in f64.
    F64,
    /// Numbers longer than f64: double-double with its bound, exact sums, exact integers.
    Exact,
    /// A foreign library.
    Foreign,
}

impl Method {
    /// All, from the cheapest.
    pub const ALL: [Self; 10] = [
        Self::Remembered,
        Self::Spheres,
        Self::Obbs,
        Self::CentreAxis,
        Self::Cone,
        Self::Portal,
        Self::F32,
        Self::F64,
        Self::Exact,
        Self::Foreign,
    ];
}

/// How many pairs each method resolved, and the pairs that none did.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Report {
    resolved: [u64; Method::ALL.len()],
    undecided: Vec<Undecided>,
    /// How many of the undecided pairs are counted as resolved too.
    unmeasured: u64,
}

impl Report {
    /// How many pairs that method proved apart or touching.
    pub fn resolved(&self, method: Method) -> u64 {
        self.resolved[method as usize]
    }

    /// The pairs without an answer: no method resolved them, or the measurement of a touching pair
    /// failed.
    pub fn undecided(&self) -> &[Undecided] {
        &self.undecided
    }

    /// Counts `pairs` as resolved by that method.
    #[inline]
    pub fn count(&mut self, method: Method, pairs: u64) {
        self.resolved[method as usize] += pairs;
    }

    /// Adds a pair that stayed undecided.
    pub fn leave(&mut self, pair: Pair, reason: Reason) {
        self.undecided.push(Undecided { pair, reason });
    }

    /// Adds a pair that is counted as resolved, since a method proved that it touches, and whose measurement
    /// failed.
    pub(crate) fn leave_unmeasured(&mut self, pair: Pair, reason: Reason) {
        self.unmeasured += 1;
        self.leave(pair, reason);
    }

    /// Hands out the pairs without an answer and removes them from the report.
    pub(crate) fn take_undecided(&mut self) -> Vec<Undecided> {
        std::mem::take(&mut self.undecided)
    }

    /// How many pairs it covers: those resolved, and those that no method resolved.
    pub fn pair_count(&self) -> u64 {
        self.resolved.iter().sum::<u64>() + self.undecided.len() as u64 - self.unmeasured
    }

    /// Moves the other's counts and pairs here.
    pub fn absorb(&mut self, other: &mut Self) {
        for (sum, count) in self.resolved.iter_mut().zip(&mut other.resolved) {
            *sum += std::mem::take(count);
        }
        self.undecided.append(&mut other.undecided);
        self.unmeasured += std::mem::take(&mut other.unmeasured);
    }

    /// Sorts the undecided pairs, so that they do not depend on which thread met them.
    pub fn sort(&mut self) {
        self.undecided.sort_unstable_by_key(|undecided| undecided.pair);
    }

    /// Forgets all, and keeps the memory.
    pub fn clear(&mut self) {
        self.resolved = Default::default();
        self.undecided.clear();
        self.unmeasured = 0;
    }
}

/// How many pairs are worth a task: some fifty nanoseconds each. No effect on any answer.
pub(crate) const PAIRS_WORTH_A_TASK: usize = 2048;

/// Where [`NarrowPhase::decide`] writes.
#[derive(Debug)]
pub struct ContactSink<'a, A: ContactAnswer> {
    /// Touching pairs are appended here, in the order of the pairs given.
    pub contacts: &'a mut A::List,
    /// Everything else that a step reports.
    pub report: &'a mut Report,
}

impl<A: ContactAnswer> ContactSink<'_, A> {
    /// Files one verdict that `method` reached.
    pub fn file(&mut self, pair: Pair, method: Method, verdict: Verdict<A>) {
        match verdict {
            Verdict::Apart => self.report.count(method, 1),
            Verdict::Touching(answer) => {
                self.report.count(method, 1);
                self.contacts.push(Contact { pair, answer });
            }
            Verdict::Undecided(reason) => self.report.leave(pair, reason),
        }
    }
}

/// Objects of a scene and what was prepared of them: one side of the pairs that
/// [`NarrowPhase::decide`] is given.
#[derive(Debug)]
pub struct Prepared<'a, F> {
    /// The objects, as they were when they were prepared.
    pub scene: &'a Scene,
    /// The frame that they were prepared in.
    pub frame: &'a F,
}

impl<F> Clone for Prepared<'_, F> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<F> Copy for Prepared<'_, F> {}

/// Which pairs a frame is prepared for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Sides {
    /// Pairs of its own objects alone: what the scene does not require may be left out.
    #[default]
    One,
    /// Pairs with objects of other frames too.
    Two,
}

/// From candidate pairs to answers.
///
/// The pipeline drives it in three steps, so that it knows no threads: `layout` once, `prepare`
/// on disjoint ranges of the objects, `decide` on slices of the pairs with scratch memory of the
/// thread's own.
///
/// A pair's first object is one of side `a`, its second one of side `b`. A scene against itself passes one
/// side twice; obstacles that are prepared once, and links that move among them, are two.
///
/// # Contract
/// After `layout` and after `prepare` on parts that cover every object once, in any order and on any
/// threads, `decide` files every pair that it is given exactly once, contacts in the order of the pairs. A
/// verdict depends on the two objects alone: not on the other pairs, their order, the scratch memory, the
/// cut, or whether both are in one frame. (But the numbers that the lanes measure of a pose that departs from a rotation by 1e-9 or
/// more may be others, within their bounds, where the scene has other kinds of objects too.) The boxes that `prepare` writes contain the objects, and where
/// `aabb_margin` is known lie in the objects' bounds swept by it. Where a `constant_answer` is known it is
/// that of every two objects with a common point.
///
/// Objects in no pair need not be prepared. An object that has been prepared in a frame need not be
/// prepared again after `layout` if three things hold: the scene's [`Scene::layout`] and the sides are the same,
/// the object's pose is the same, and `keeps` returns that the frame has kept what it held.
/// `contract` tests it.
///
/// The frame stays from step to step: `prepare` finds there what it wrote of the object in that
/// slot before, perhaps for another object ([`Scene::generations`]) or another scene
/// ([`Scene::layout`]). Whatever is kept there may save work and never changes a verdict, an order
/// or an AABB. In particular, nothing that changes for all objects at once (a form that they share, a
/// copy that is made anew, sums that start again) may wait for `prepare`, which static objects do not
/// see: `layout` brings it to every object, or `keeps` returns `false`.
pub trait NarrowPhase: Send + Sync {
    /// The answer about a touching pair.
    type Answer: ContactAnswer;
    /// What is prepared once a step for all objects; kept by the pipeline and reused.
    type Frame: Default + Send + Sync;
    /// A frame's part for a range of the objects.
    type Part<'f>: Splittable
    where
        Self: 'f;
    /// Memory that a thread reuses from slice to slice.
    type Scratch: Default + Send;

    /// By how much, metres, the box of an object may reach beyond its [`dcd_geom::SphereBounds`]: half of a
    /// margin, for example. Objects whose bounds, so grown, are apart are never reported. A caller that needs
    /// few of many objects prepares only those whose bounds, so grown, reach something. `None`: not
    /// known, and every object must be prepared.
    fn aabb_margin(&self) -> Option<f64> {
        None
    }

    /// The fewest pairs of objects of a frame that are worth a task of their own: some tens of microseconds of work. No effect
    /// on any answer. Larger: threads that wait for the last one. Smaller: packets of lanes that are not full.
    fn fewest_pairs(&self, _frame: &Self::Frame) -> usize {
        PAIRS_WORTH_A_TASK
    }

    /// The answer for every touching pair, if it is the same for all. Lets a caller that has proved
    /// contact skip `decide`. `None`: each pair has its own answer.
    fn constant_answer(&self) -> Option<Self::Answer> {
        None
    }

    /// Assigns each object of the scene its range of the frame's buffers: offsets only. Two frames may be paired in `decide` if both
    /// were laid out for [`Sides::Two`].
    fn layout<'f>(&self, scene: &Scene, sides: Sides, frame: &'f mut Self::Frame)
    -> Self::Part<'f>;

    /// Whether the frame still holds, AABBs included, all that was prepared in it before it was laid
    /// out as this part. The caller queries the whole part, before it is cut. `false` is always safe and the
    /// default: then every object is prepared again.
    fn keeps(&self, _part: &Self::Part<'_>) -> bool {
        false
    }

    /// Prepares the objects of the part, the first of which is object `first`, and writes the box of each
    /// to `aabbs`, which has the part's length.
    fn prepare(&self, scene: &Scene, first: usize, part: Self::Part<'_>, aabbs: &mut [Aabb]);

    /// Receives all candidates between `prepare` and `decide`, slice by slice, for an implementation that
    /// keeps data for each of them. Does nothing by default. A caller may leave it out; the verdicts
    /// are the same.
    fn begin_pairs<'p>(
        &self,
        _frame: &mut Self::Frame,
        _candidates: impl Iterator<Item = &'p [Pair]> + Clone,
    ) {
    }

    /// Resolves the pairs: `i` is an object of `a`, `j` one of `b`. Where both are one side, i < j.
    fn decide(
        &self,
        a: Prepared<'_, Self::Frame>,
        b: Prepared<'_, Self::Frame>,
        pairs: &[Pair],
        scratch: &mut Self::Scratch,
        sink: &mut ContactSink<'_, Self::Answer>,
    );

    /// Decides whether the pairs touch, as `decide` does; the contacts' answers are not read. An
    /// implementation that measures touching pairs need not do so here. Calls `decide` by default.
    fn sense(
        &self,
        a: Prepared<'_, Self::Frame>,
        b: Prepared<'_, Self::Frame>,
        pairs: &[Pair],
        scratch: &mut Self::Scratch,
        sink: &mut ContactSink<'_, Self::Answer>,
    ) {
        self.decide(a, b, pairs, scratch, sink);
    }
}
