//! How good a bound has to be: speed for accuracy.

use super::distances::are_within;
use super::few_parts::PartContact;
use crate::epa::Depth;
use crate::mesh::KnownParts;
use crate::simd::{CoreContact, CuboidPatch};
use crate::{Contact, ContactList, ContactsOf, Method, PairSolver, PosedShape, Verdict, certified};
use dcd_geom::Pair;
use dcd_simd::Path;

/// How good the bound of a distance or depth has to be. The bound is proved at every accuracy: a smaller
/// accuracy makes it wider, never false. Which pairs touch does not depend on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Accuracy {
    /// Some millionths of the pair's size, as f32 resolves it: at most 1e-5 of it for all but one in a
    /// hundred of the named scenes' pairs. Distances of whole scenes are [in lanes](crate::SimdDistances).
    F32,
    /// What f64 gives: 1e-10 of a depth, 1e-9 of that of a curved shape, or 3e-14 of the pair's size; some 3e-15 of the size for a
    /// distance, at most 3e-14 for one of spheres, 2e-14 or 1e-10 of itself for one of compounds; up to three times that
    /// of a compound with a part that is many times its size away from the compound's origin. Where edges are nearly parallel,
    /// those of capsules above all, up to 1e-8 of the size, where faces lean by some 1e-7 rad up to 1e-6, of spheres beside needles
    /// up to 1e-4, of cylinders and cones that all but meet up to 1e-11, for some in a thousand 1e-6; where poses are off rotations,
    /// by some of that times the size; of two curved shapes that have one axis, or nearly, up to some hundredths of a depth.
    F64,
    /// Twelve digits of a distance and nine of a depth, however small (but see [`super::Depths`]), by longer numbers where f64 has
    /// not as many: what the solvers give by themselves.
    #[default]
    Certified,
}

/// A solver that trades accuracy for speed: [`Distances`](super::Distances), [`Depths`](super::Depths),
/// [`Manifolds`](super::Manifolds), [`Proximities`](super::Proximities).
pub trait MeasureAt: PairSolver {
    /// [`PairSolver::measure`] with a bound as good as the accuracy requires, or better.
    fn measure_at(
        &self,
        accuracy: Accuracy,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut Self::Scratch,
    ) -> Verdict<Self::Answer>;
}

/// A solver whose answer is made of a pair's depth: [`Depths`](super::Depths), [`Manifolds`](super::Manifolds).
pub trait MeasureDepth: MeasureAt {
    /// The answer for two convex shapes whose depth is known.
    fn measure_depth(
        &self,
        depth: Depth,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut Self::Scratch,
    ) -> Verdict<Self::Answer>;

    /// The same for two spheres, of which nothing need be known but how far the depth's witnesses may be off them, metres: over
    /// a default answer.
    fn measure_spheres(&self, depth: &Depth, off_surface: f64, answer: &mut Self::Answer);

    /// Adds a contact with that answer.
    fn push_spheres(
        &self,
        pair: Pair,
        (depth, off_surface): (&Depth, f64),
        contacts: &mut ContactsOf<Self::Answer>,
    ) {
        let mut answer = Self::Answer::default();
        self.measure_spheres(depth, off_surface, &mut answer);
        contacts.push(Contact { pair, answer });
    }

    /// The same for up to [`MeasureDepth::TOGETHER`] pairs of polytopes, written as the answers of contacts, over default
    /// ones. Returns where nothing is written and [`MeasureDepth::measure_depth`] is needed, a bit for each pair. By
    /// default everywhere.
    fn measure_polytopes(
        &self,
        _path: Path,
        _pairs: &[FoundPair<'_>],
        _scratch: &mut Self::Scratch,
        _contacts: &mut ContactsOf<Self::Answer>,
    ) -> u32 {
        u32::MAX
    }

    /// The same for two cuboids of which the lanes found in f32 where they touch; false, and nothing written, where the depth is
    /// needed. By default always.
    fn measure_cuboids(
        &self,
        _patch: CuboidPatch<'_>,
        _sides: [PosedShape<'_>; 2],
        (_contacts, _number): (&mut ContactsOf<Self::Answer>, usize),
    ) -> bool {
        false
    }

    /// The same for two shapes of which the lanes found in f32 where their cores are nearest; false, and nothing written, where more
    /// has to be known. By default always.
    fn measure_cores(
        &self,
        _contact: &CoreContact<'_>,
        (_contacts, _number): (&mut ContactsOf<Self::Answer>, usize),
    ) -> bool {
        false
    }

    /// The same for two objects of which nothing is known but that they touch, written as the answer of a contact, over a default
    /// one. By default by [`MeasureAt::measure_at`].
    fn measure_alone(
        &self,
        accuracy: Accuracy,
        [a, b]: [PosedShape<'_>; 2],
        scratch: &mut Self::Scratch,
        (contacts, number): (&mut ContactsOf<Self::Answer>, usize),
    ) -> Verdict<()> {
        self.measure_at(accuracy, a, b, scratch).map(|answer| contacts.set(number, answer))
    }

    /// The same for a mesh and a polytope of which it is known which parts touch, over a default answer. By default by
    /// [`MeasureAt::measure_at`], which finds them again.
    fn measure_parts(
        &self,
        accuracy: Accuracy,
        _known: KnownParts<'_>,
        [a, b]: [PosedShape<'_>; 2],
        scratch: &mut Self::Scratch,
        answer: &mut Self::Answer,
    ) -> Verdict<()> {
        self.measure_at(accuracy, a, b, scratch).map(|found| *answer = found)
    }

    /// The same for two shapes of which one is a compound, and it is known which parts touch: all of them, in any order, in which
    /// the solver may leave them. By default by [`MeasureAt::measure_at`], which finds them again.
    fn measure_compounds(
        &self,
        accuracy: Accuracy,
        _known: &mut [PartContact<'_>],
        [a, b]: [PosedShape<'_>; 2],
        scratch: &mut Self::Scratch,
        answer: &mut Self::Answer,
    ) -> Verdict<()> {
        self.measure_at(accuracy, a, b, scratch).map(|found| *answer = found)
    }

    /// How many pairs [`MeasureDepth::measure_polytopes`] answers best: at most 8.
    const TOGETHER: usize = 1;

    /// Whether [`MeasureDepth::measure_polytopes`] reads the faces of the polytopes: these are prefetched then. No effect
    /// on any result.
    const READS_FACETS: bool = false;

    /// Whether [`MeasureDepth::measure_cuboids`] is of use: the lanes look for patches then, at [`Accuracy::F32`].
    const READS_PATCHES: bool = false;

    /// Whether [`MeasureDepth::measure_parts`] reads how deep each part is at most: that is found then.
    const READS_BOUNDS: bool = false;
}

/// The depth of two polytopes, and what else is known of them.
#[derive(Clone, Copy, Debug)]
pub struct FoundDepth {
    /// How deep they overlap.
    pub depth: Depth,
    /// By index a vertex of a that is farthest along the normal, and one of b that is farthest against it, up to rounding
    /// in f32, where these are known.
    pub farthest: Option<[u32; 2]>,
}

/// Two polytopes that touch, how deep, and where the answer goes: what [`MeasureDepth::measure_polytopes`] takes.
#[derive(Clone, Copy, Debug)]
pub struct FoundPair<'a> {
    /// How deep they overlap.
    pub found: FoundDepth,
    /// a and b.
    pub sides: [PosedShape<'a>; 2],
    /// The number of the contact whose answer theirs is.
    pub number: usize,
}

impl From<Depth> for FoundDepth {
    fn from(depth: Depth) -> Self {
        Self { depth, farthest: None }
    }
}

impl FoundDepth {
    /// The same with a and b exchanged.
    pub fn mirrored(self) -> Self {
        let farthest = self.farthest.map(|[a, b]| [b, a]);
        Self { depth: self.depth.mirrored(), farthest }
    }
}

/// A solver at an accuracy of the caller's choice.
///
/// ```
/// use dcd_gjk::{Accuracy, Depths, ThenMeasure, WithAccuracy};
/// let how_deep = ThenMeasure::new(WithAccuracy::new(Depths, Accuracy::F64))?;
/// # Ok::<(), dcd_geom::ShapeError>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct WithAccuracy<S> {
    solver: S,
    accuracy: Accuracy,
}

impl<S: MeasureAt> WithAccuracy<S> {
    /// That solver at that accuracy.
    pub fn new(solver: S, accuracy: Accuracy) -> Self {
        Self { solver, accuracy }
    }
}

impl<S: MeasureAt> PairSolver for WithAccuracy<S> {
    type Answer = S::Answer;
    type Scratch = S::Scratch;

    fn method(&self) -> Method {
        self.solver.method()
    }

    fn margin(&self) -> f64 {
        self.solver.margin()
    }

    fn may_leave_out(&self) -> bool {
        self.solver.may_leave_out()
    }

    fn solve(
        &self,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut S::Scratch,
    ) -> Verdict<S::Answer> {
        self.resolve(a, b, scratch).0
    }

    fn measure(
        &self,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut S::Scratch,
    ) -> Verdict<S::Answer> {
        self.solver.measure_at(self.accuracy, a, b, scratch)
    }

    /// Yes or no is proved first, whatever the accuracy.
    fn resolve(
        &self,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut S::Scratch,
    ) -> (Verdict<S::Answer>, Method) {
        let margin = self.margin();
        let (verdict, method) = if margin > 0.0 {
            (are_within(a, b, margin), Method::F64)
        } else {
            certified::overlap_of(a, b)
        };
        let verdict = match verdict {
            Verdict::Touching(()) => self.measure(a, b, scratch),
            Verdict::Apart => Verdict::Apart,
            Verdict::Undecided(reason) => Verdict::Undecided(reason),
        };
        (verdict, method)
    }
}
