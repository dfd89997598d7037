//! A narrow phase from a solver that sees one pair at a time.

use crate::query::grown;
use crate::{ContactAnswer, ContactSink, Method, NarrowPhase, Prepared, Sides, Verdict};
use dcd_geom::{Aabb, Pair, Pose, Scene, Shape, Splittable};

/// Judges two placed shapes. The simplest way to bring one's own GJK: wrap it in [`Pairwise`].
///
/// ```
/// use dcd_geom::glam::DVec3;
/// use dcd_geom::{Pose, Shape};
/// use dcd_gjk::{Method, Pairwise, PairSolver, PosedShape, Reason, Verdict};
/// /// Spheres alone, in f64.
/// struct Spheres;
/// impl PairSolver for Spheres {
///     type Answer = ();
///     type Scratch = ();
///     fn method(&self) -> Method {
///         Method::F64
///     }
///     fn solve(&self, a: PosedShape<'_>, b: PosedShape<'_>, (): &mut ()) -> Verdict<()> {
///         let radius = |shape: &Shape| shape.as_polytope().map(|p| p.swept_radius());
///         let (Some(r), Some(s)) = (radius(a.shape), radius(b.shape)) else {
///             return Verdict::Undecided(Reason::NotConvex);
///         };
///         let gap = a.pose.translation().distance(b.pose.translation()) - (r + s);
///         if gap > 0.0 { Verdict::Apart } else { Verdict::Touching(()) }
///     }
/// }
/// let (shape, far) = (Shape::sphere(1.0)?, Pose::from_translation(DVec3::X * 3.0)?);
/// let posed = |pose| PosedShape { shape: &shape, pose };
/// assert_eq!(Spheres.solve(posed(&Pose::IDENTITY), posed(&far), &mut ()), Verdict::Apart);
/// let narrow = Pairwise(Spheres); // for a pipeline
/// # let _ = narrow;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait PairSolver: Send + Sync {
    /// The answer about a touching pair.
    type Answer: ContactAnswer;
    /// Memory that a thread reuses from pair to pair; `()` for a solver that needs none.
    type Scratch: Default + Send;

    /// Which method its verdicts count for.
    fn method(&self) -> Method;

    /// The verdict on one pair, a pure function of the two shapes and poses: whatever the scratch
    /// memory was used for before.
    fn solve(
        &self,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut Self::Scratch,
    ) -> Verdict<Self::Answer>;

    /// The verdict on a pair that is known to touch, or, with a [margin](Self::margin), to be
    /// within it: computes the answer without deciding contact again.
    fn measure(
        &self,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut Self::Scratch,
    ) -> Verdict<Self::Answer> {
        self.solve(a, b, scratch)
    }

    /// Within which distance a pair counts as touching, metres: finite, at least 0. Boxes are
    /// grown by half of it, so that a broad phase finds those pairs.
    fn margin(&self) -> f64 {
        0.0
    }

    /// Whether [`PairSolver::measure`] calls pairs apart on purpose that touch, as one-sided surfaces do. If it does not, a pair that
    /// was proved to touch, and which it calls apart, is reported as undecided.
    fn may_leave_out(&self) -> bool {
        false
    }

    /// The same verdict and the method that reached it. A solver of one method leaves this as it is.
    fn resolve(
        &self,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut Self::Scratch,
    ) -> (Verdict<Self::Answer>, Method) {
        (self.solve(a, b, scratch), self.method())
    }
}

/// A shape at a pose.
#[derive(Clone, Copy, Debug)]
pub struct PosedShape<'a> {
    /// The shape.
    pub shape: &'a Shape,
    /// Where it is.
    pub pose: &'a Pose,
}

impl<'a> PosedShape<'a> {
    /// That object of a scene, by its index, which must be below [`Scene::len`].
    #[inline]
    pub fn of(scene: &'a Scene, object: u32) -> Self {
        let object = object as usize;
        Self { shape: scene.shape(object), pose: &scene.poses()[object] }
    }
}

/// A solver of single pairs as a narrow phase: prepares nothing, solves pair by pair.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pairwise<G>(
    /// The solver.
    pub G,
);

/// Nothing prepared, for so many objects.
#[derive(Clone, Copy, Debug, Default)]
pub struct Empty(usize);

impl Empty {
    /// For so many objects.
    pub fn of(objects: usize) -> Self {
        Self(objects)
    }
}

impl Splittable for Empty {
    fn len(&self) -> usize {
        self.0
    }
    fn split_at(self, middle: usize) -> (Self, Self) {
        (Self(middle), Self(self.0 - middle))
    }
}

impl<G: PairSolver> NarrowPhase for Pairwise<G> {
    type Answer = G::Answer;
    type Frame = ();
    type Part<'f>
        = Empty
    where
        Self: 'f;
    type Scratch = G::Scratch;

    fn aabb_margin(&self) -> Option<f64> {
        Some(self.0.margin() / 2.0)
    }

    fn layout(&self, scene: &Scene, _: Sides, (): &mut ()) -> Empty {
        Empty(scene.len())
    }

    /// Nothing is held but AABBs, which are the scene's.
    fn keeps(&self, _: &Empty) -> bool {
        true
    }

    fn prepare(&self, scene: &Scene, first: usize, _: Empty, aabbs: &mut [Aabb]) {
        let half = self.0.margin() / 2.0;
        for (i, aabb) in (first..).zip(aabbs) {
            *aabb = grown(&scene.aabb(i), half);
        }
    }

    fn decide(
        &self,
        a: Prepared<'_, ()>,
        b: Prepared<'_, ()>,
        pairs: &[Pair],
        scratch: &mut G::Scratch,
        sink: &mut ContactSink<'_, G::Answer>,
    ) {
        for &pair in pairs {
            let (one, other) = (PosedShape::of(a.scene, pair.i), PosedShape::of(b.scene, pair.j));
            let (verdict, method) = self.0.resolve(one, other, scratch);
            sink.file(pair, method, verdict);
        }
    }
}
