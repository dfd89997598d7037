//! The solvers of single pairs that a user chooses between.

use crate::{
    Difference, Method, PairSolver, PosedShape, PosedSupport, Reason, Verdict, certified, gjk,
    mesh, order,
};
use dcd_geom::glam::Vec3;
use dcd_geom::{Shape, Support, SupportMap, Vector};
use std::marker::PhantomData;

/// GJK in f32 or f64, yes or no: undecided where the gap or overlap is within that arithmetic's
/// rounding. The f64 one is scalar and never fuses: the same bits everywhere.
///
/// ```
/// use dcd_gjk::{Pairwise, Gjk};
/// let narrow_phase = Pairwise(Gjk::<f64>::default());
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Gjk<R>(PhantomData<R>);

impl PairSolver for Gjk<f64> {
    type Answer = ();
    type Scratch = ();

    fn method(&self) -> Method {
        Method::F64
    }

    fn solve(&self, a: PosedShape<'_>, b: PosedShape<'_>, (): &mut ()) -> Verdict<()> {
        certified::overlap_in_f64(a, b)
    }
}

impl PairSolver for Gjk<f32> {
    type Answer = ();
    type Scratch = ();

    fn method(&self) -> Method {
        Method::F32
    }

    fn solve(&self, a: PosedShape<'_>, b: PosedShape<'_>, (): &mut ()) -> Verdict<()> {
        if mesh::have_parts(a.shape, b.shape) {
            return Verdict::Undecided(Reason::NotConvex);
        }
        let (a, b) = order::canonical(a, b);
        match (a.shape, b.shape) {
            (Shape::Polytope(in_a), Shape::Polytope(in_b)) => overlap_in_f32(
                PosedSupport::polytope(in_a, a.pose),
                PosedSupport::polytope(in_b, b.pose),
            ),
            _ => {
                let (map_a, map_b) = (Narrowed(a.shape), Narrowed(b.shape));
                overlap_in_f32(map_a.body(a), map_b.body(b))
            }
        }
    }
}

fn overlap_in_f32<S: SupportMap<f32>>(
    a: PosedSupport<'_, S>,
    b: PosedSupport<'_, S>,
) -> Verdict<()> {
    match Difference::<f32, _, _>::new(a, b) {
        Some(difference) => gjk::overlap(&difference),
        None => Verdict::Undecided(Reason::Range),
    }
}

/// A shape whose supports are rounded to f32: one rounding of a point, which the f32 bounds count.
struct Narrowed<'a>(&'a Shape);

impl Narrowed<'_> {
    fn body<'a>(&'a self, placed: PosedShape<'a>) -> PosedSupport<'a, Self> {
        let PosedSupport { pose, reach, centre, inner, .. } =
            PosedSupport::shape(placed.shape, placed.pose);
        PosedSupport { map: self, pose, reach, centre, inner }
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

/// All methods for each pair: f64, then exact integers. Proved, and never undecided for
/// polytopes; the default where pairs are judged one at a time.
#[derive(Clone, Copy, Debug, Default)]
pub struct Certified;

impl PairSolver for Certified {
    type Answer = ();
    type Scratch = mesh::Scratch;

    fn method(&self) -> Method {
        Method::Exact
    }

    fn solve(
        &self,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut mesh::Scratch,
    ) -> Verdict<()> {
        self.resolve(a, b, scratch).0
    }

    fn resolve(
        &self,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut mesh::Scratch,
    ) -> (Verdict<()>, Method) {
        certified::overlap_with(a, b, scratch)
    }
}
