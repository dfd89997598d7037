//! The verdict of our own solvers on a pair.

use super::Query;
use super::answer::{Answer, Way};
use crate::precision::{Accuracy, in_words};
use crate::reported::points;
use dcd_gjk::distance::{self, DistanceResult};
use dcd_gjk::query::MeasureAt;
use dcd_gjk::{
    Certified, Depths, Gjk, Manifolds, Method, PairSolver, PosedShape, Reason, Verdict, epa,
};
use dcd_pipeline::Precision;

/// The solvers' memory, from pair to pair.
#[derive(Default)]
pub(super) struct Solvers {
    depth: epa::Scratch,
    manifold: <Manifolds as PairSolver>::Scratch,
}

impl Solvers {
    /// The answer of that precision, one of ours, for a and b.
    pub(super) fn answer(
        &mut self,
        (precision, query, accuracy): (Precision, Query, Accuracy),
        a: PosedShape<'_>,
        b: PosedShape<'_>,
    ) -> Answer {
        if query == Query::Distance {
            return distance(accuracy, a, b);
        }
        let (verdict, method) = match precision {
            Precision::Fast => Gjk::<f32>::default().resolve(a, b, &mut ()),
            Precision::F64 => Gjk::<f64>::default().resolve(a, b, &mut ()),
            Precision::Certified => Certified.resolve(a, b, &mut Default::default()),
        };
        let mut answer = Answer::new(&verdict, name(method));
        match (query, verdict) {
            (Query::Depth, Verdict::Touching(())) => self.deepen(&mut answer, accuracy, a, b),
            (Query::Manifold, Verdict::Touching(())) => self.spread(&mut answer, accuracy, a, b),
            _ => {}
        }
        answer
    }

    fn spread(
        &mut self,
        answer: &mut Answer,
        accuracy: Accuracy,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
    ) {
        let found = Manifolds::default().measure_at(accuracy.into(), a, b, &mut self.manifold);
        let Verdict::Touching(found) = found else { return };
        // Two convex sets have one.
        let Some(found) = found.first() else { return };
        let Some(deepest) = found.points().first() else { return };
        answer.depth = Some(deepest.depth);
        answer.way = Some(Way::new(found.normal, deepest.point_a, deepest.point_b));
        answer.points = Some(points(found));
        answer.error_bound = Some(found.error_bound);
    }

    fn deepen(
        &mut self,
        answer: &mut Answer,
        accuracy: Accuracy,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
    ) {
        let found = Depths.measure_at(accuracy.into(), a, b, &mut self.depth);
        let Verdict::Touching(found) = found else { return };
        answer.depth = Some(found.depth);
        answer.way = Some(Way::new(found.normal, found.point_a, found.point_b));
        answer.error_bound = Some(found.error_bound);
    }
}

fn distance(accuracy: Accuracy, a: PosedShape<'_>, b: PosedShape<'_>) -> Answer {
    let (found, method) = distance::distance_at(accuracy.into(), a, b);
    let verdict = match found {
        DistanceResult::Apart(_) => Verdict::Apart,
        DistanceResult::Touching => Verdict::Touching(()),
        DistanceResult::Interval { reason, .. } | DistanceResult::Undecided(reason) => {
            Verdict::Undecided(reason)
        }
    };
    let mut answer = Answer::new(&verdict, name(method));
    match found {
        DistanceResult::Apart(found) | DistanceResult::Interval { within: found, .. } => {
            answer.distance = Some(found.distance);
            answer.way = Some(Way::new(found.normal, found.point_a, found.point_b));
            if found.is_saturated() {
                answer.reason = Some(in_words(Reason::Range));
            } else {
                answer.error_bound = Some(found.error_bound);
            }
        }
        DistanceResult::Touching => {
            answer.distance = Some(0.0);
            answer.error_bound = Some(0.0);
        }
        DistanceResult::Undecided(_) => {}
    }
    answer
}

fn name(method: Method) -> &'static str {
    match method {
        Method::Exact => "exact",
        Method::F64 => "f64",
        _ => "f32",
    }
}
