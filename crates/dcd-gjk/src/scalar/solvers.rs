//! The ladder's rungs as solvers of single pairs: what a user picks and pays for.

use crate::{
    Body, Difference, PairSolver, Placed, Reason, Rung, Verdict, certified, gjk, order, parts,
};
use dcd_geom::glam::Vec3;
use dcd_geom::{Shape, Support, SupportMap, Vector};
use std::marker::PhantomData;

/// GJK in f32 or f64, yes or no: undecided where the gap or overlap is within that arithmetic's
/// rounding. The f64 one is scalar and never fuses: the same bits everywhere.
///
/// ```
/// use dcd_gjk::{EachPair, Gjk};
/// let narrow_phase = EachPair(Gjk::<f64>::default());
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Gjk<R>(PhantomData<R>);

impl PairSolver for Gjk<f64> {
    type Answer = ();
    type Scratch = ();

    fn rung(&self) -> Rung {
        Rung::F64
    }

    fn solve(&self, a: Placed<'_>, b: Placed<'_>, (): &mut ()) -> Verdict<()> {
        certified::overlap_in_f64(a, b)
    }
}

impl PairSolver for Gjk<f32> {
    type Answer = ();
    type Scratch = ();

    fn rung(&self) -> Rung {
        Rung::F32
    }

    fn solve(&self, a: Placed<'_>, b: Placed<'_>, (): &mut ()) -> Verdict<()> {
        if parts::are_asked(a.shape, b.shape) {
            return Verdict::Undecided(Reason::NotConvex);
        }
        let (a, b) = order::canonical(a, b);
        match (a.shape, b.shape) {
            (Shape::Polytope(in_a), Shape::Polytope(in_b)) => {
                overlap_in_f32(Body::polytope(in_a, a.pose), Body::polytope(in_b, b.pose))
            }
            _ => {
                let (map_a, map_b) = (Narrowed(a.shape), Narrowed(b.shape));
                overlap_in_f32(map_a.body(a), map_b.body(b))
            }
        }
    }
}

fn overlap_in_f32<S: SupportMap<f32>>(a: Body<'_, S>, b: Body<'_, S>) -> Verdict<()> {
    match Difference::<f32, _, _>::new(a, b) {
        Some(difference) => gjk::overlap(&difference),
        None => Verdict::Undecided(Reason::Range),
    }
}

/// A shape whose supports are rounded to f32: one rounding of a point, which the f32 bounds count.
struct Narrowed<'a>(&'a Shape);

impl Narrowed<'_> {
    fn body<'a>(&'a self, placed: Placed<'a>) -> Body<'a, Self> {
        let Body { pose, reach, centre, inner, .. } = Body::shape(placed.shape, placed.pose);
        Body { map: self, pose, reach, centre, inner }
    }
}

impl SupportMap<f32> for Narrowed<'_> {
    fn support(&self, direction: Vec3) -> Support<f32> {
        let Support { point, feature } = self.0.support(direction.to_dvec3());
        Support { point: point.as_vec3(), feature }
    }

    fn radius(&self) -> f32 {
        self.0.radius() as f32
    }

    fn support_error(&self) -> f32 {
        (self.0.support_error() as f32).next_up()
    }
}

/// The whole ladder for each pair: f64, then exact integers. Proved, and never undecided for
/// polytopes; the default where pairs are judged one at a time.
#[derive(Clone, Copy, Debug, Default)]
pub struct Certified;

impl PairSolver for Certified {
    type Answer = ();
    type Scratch = parts::Scratch;

    fn rung(&self) -> Rung {
        Rung::Exact
    }

    fn solve(&self, a: Placed<'_>, b: Placed<'_>, scratch: &mut parts::Scratch) -> Verdict<()> {
        self.settle(a, b, scratch).0
    }

    fn settle(
        &self,
        a: Placed<'_>,
        b: Placed<'_>,
        scratch: &mut parts::Scratch,
    ) -> (Verdict<()>, Rung) {
        certified::overlap_with(a, b, scratch)
    }
}
