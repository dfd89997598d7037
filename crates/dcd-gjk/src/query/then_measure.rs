//! A solver for the pairs that a narrow phase has found.

use super::{FEWEST_MEASURED, Within};
use crate::{
    Contact, ContactList, ContactSink, ContactsOf, NarrowPhase, Overlap, PairSolver, PosedShape,
    Prepared, Reason, Sides, Verdict,
};
use dcd_geom::{Aabb, List, Pair, Scene, ShapeError};

/// Runs a solver on touching pairs alone. First the narrow phase decides yes or no for all pairs (by default
/// [`Overlap`], proved); then the solver measures those that touch.
///
/// For a solver with a [margin](PairSolver::margin), "touching" is "within the margin" (see
/// [`Within`]). A pair that the solver cannot measure is undecided, with the solver's reason.
/// The methods of a [`Report`](crate::Report) are those by which the narrow phase decided yes or no, also for
/// pairs that could not be measured.
///
/// ```
/// use dcd_pipeline::prelude::*;
/// let poses = [0.0, 0.9, 2.1].map(|x| Pose::from_translation(DVec3::X * x));
/// let poses = poses.into_iter().collect::<Result<Vec<_>, _>>()?;
/// let scene = Scene::one_each(vec![Shape::sphere(0.5)?; 3], poses)?;
/// let narrow = ThenMeasure::new(Proximities::within(0.25)?)?;
/// let mut pipeline = Pipeline::with(WideTree::default(), narrow);
/// let near: Vec<_> = pipeline.step(&scene, Par::Serial).answers().collect();
/// assert!((near[0].answer.signed_distance + 0.1).abs() <= near[0].answer.error_bound);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ThenMeasure<S, N = Overlap> {
    narrow: Within<N>,
    solver: S,
}

impl<S: PairSolver> ThenMeasure<S> {
    /// After the lanes.
    ///
    /// # Errors
    /// The solver's margin is negative, not a number, or above [`Aabb::LIMIT`].
    pub fn new(solver: S) -> Result<Self, ShapeError> {
        Self::after(Overlap::default(), solver)
    }
}

impl<S: PairSolver, N> ThenMeasure<S, N> {
    /// After that narrow phase.
    ///
    /// # Errors
    /// The solver's margin is negative, not a number, or above [`Aabb::LIMIT`].
    pub fn after(narrow: N, solver: S) -> Result<Self, ShapeError> {
        Ok(Self { narrow: Within::by(narrow, solver.margin())?, solver })
    }
}

/// One side, as the yes or no takes it.
type Side<'a, N> = Prepared<'a, <Within<N> as NarrowPhase>::Frame>;

/// What a thread reuses from slice to slice.
#[derive(Debug, Default)]
pub struct Scratch<N, C, S> {
    narrow: N,
    touching: C,
    solver: S,
}

impl<S: PairSolver + 'static, N: NarrowPhase> NarrowPhase for ThenMeasure<S, N> {
    type Answer = S::Answer;
    type Frame = <Within<N> as NarrowPhase>::Frame;
    type Part<'f>
        = <Within<N> as NarrowPhase>::Part<'f>
    where
        Self: 'f;
    type Scratch = Scratch<N::Scratch, ContactsOf<N::Answer>, S::Scratch>;

    fn aabb_margin(&self) -> Option<f64> {
        self.narrow.aabb_margin()
    }

    fn fewest_pairs(&self, _: &Self::Frame) -> usize {
        FEWEST_MEASURED
    }

    fn layout<'f>(
        &self,
        scene: &Scene,
        sides: Sides,
        frame: &'f mut Self::Frame,
    ) -> Self::Part<'f> {
        self.narrow.layout(scene, sides, frame)
    }

    fn keeps(&self, part: &Self::Part<'_>) -> bool {
        self.narrow.keeps(part)
    }

    fn prepare(&self, scene: &Scene, first: usize, part: Self::Part<'_>, aabbs: &mut [Aabb]) {
        self.narrow.prepare(scene, first, part, aabbs);
    }

    fn decide(
        &self,
        a: Prepared<'_, Self::Frame>,
        b: Prepared<'_, Self::Frame>,
        pairs: &[Pair],
        scratch: &mut Self::Scratch,
        sink: &mut ContactSink<'_, S::Answer>,
    ) {
        self.find_touching((a, b), pairs, scratch, sink);
        let Scratch { touching, solver, .. } = scratch;
        for pair in touching.pairs(0..touching.len()) {
            let (one, other) = (PosedShape::of(a.scene, pair.i), PosedShape::of(b.scene, pair.j));
            match self.solver.measure(one, other, solver) {
                Verdict::Touching(answer) => sink.contacts.push(Contact { pair, answer }),
                Verdict::Apart if self.solver.may_leave_out() => {}
                Verdict::Apart => sink.report.leave_unmeasured(pair, Reason::WithinRounding),
                Verdict::Undecided(reason) => sink.report.leave_unmeasured(pair, reason),
            }
        }
    }

    fn sense(
        &self,
        a: Prepared<'_, Self::Frame>,
        b: Prepared<'_, Self::Frame>,
        pairs: &[Pair],
        scratch: &mut Self::Scratch,
        sink: &mut ContactSink<'_, S::Answer>,
    ) {
        self.find_touching((a, b), pairs, scratch, sink);
        let touching = &scratch.touching;
        touching.pairs(0..touching.len()).for_each(|pair| sink.contacts.push_pair(pair));
    }
}

impl<S: PairSolver + 'static, N: NarrowPhase> ThenMeasure<S, N> {
    /// Lists the pairs that the narrow phase finds touching, in the scratch memory.
    fn find_touching(
        &self,
        (a, b): (Side<'_, N>, Side<'_, N>),
        pairs: &[Pair],
        scratch: &mut <Self as NarrowPhase>::Scratch,
        sink: &mut ContactSink<'_, S::Answer>,
    ) {
        scratch.touching.clear();
        let mut yes = ContactSink { contacts: &mut scratch.touching, report: sink.report };
        self.narrow.decide(a, b, pairs, &mut scratch.narrow, &mut yes);
    }
}
