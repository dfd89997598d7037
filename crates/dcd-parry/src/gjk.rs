//! Parry's GJK on our support maps.

use crate::Library;
use crate::forms::{verdict, within_range};
use dcd_gjk::{Method, PairSolver, PosedShape, Reason, Verdict};
use std::marker::PhantomData;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Parry's algorithm, our shapes: its GJK, started and stopped as its `intersection_test` does,
/// calling our support maps in R.
///
/// Undecided where it runs out of its 100 iterations, where the pair is out of its range, and
/// where it panics. Its tolerances are absolute lengths (ten epsilons of R), so that shapes of
/// some millimetres and below get wrong answers; a support error is not accounted for.
#[derive(Clone, Copy, Debug, Default)]
pub struct ParryGjk<R>(PhantomData<R>);

impl<R: Library> PairSolver for ParryGjk<R> {
    type Answer = ();
    type Scratch = ();

    fn method(&self) -> Method {
        Method::Foreign
    }

    fn solve(&self, a: PosedShape<'_>, b: PosedShape<'_>, (): &mut ()) -> Verdict<()> {
        if !(a.shape.is_convex() && b.shape.is_convex()) {
            return Verdict::Undecided(Reason::NotConvex);
        }
        let [pose_a, pose_b] = [a.pose, b.pose].map(R::pose);
        let offset = R::translation(&pose_b) - R::translation(&pose_a);
        if !within_range::<R>([a.shape.reach(), b.shape.reach()], offset) {
            return Verdict::Undecided(Reason::Range);
        }
        // It asserts that what it computes on is finite and not degenerate. Nothing that the
        // closure reads can be left half changed.
        let solve = || R::gjk((a.shape, &pose_a), (b.shape, &pose_b));
        match catch_unwind(AssertUnwindSafe(solve)) {
            Ok(touching) => verdict(touching, Reason::Iterations),
            Err(_) => Verdict::Undecided(Reason::Foreign),
        }
    }
}
