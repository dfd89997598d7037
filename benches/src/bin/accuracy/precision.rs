//! The precisions and their queries.

use dcd_geom::glam::DVec3;
use dcd_geom::{Aabb, Pair, Polytope, Shape};
use dcd_gjk::distance::{self, DistanceResult};
use dcd_gjk::epa::{self, Scratch};
use dcd_gjk::query::MeasureAt;
use dcd_gjk::{
    Accuracy, Certified, ContactSink, Depths, Gjk, NarrowPhase, Overlap, OverlapUnchecked,
    PairSolver, PosedShape, PosedSupport, Prepared, Report, Sides, Verdict,
};
use serde::{Deserialize, Serialize};

use crate::parry::Theirs;
use crate::subject::Subject;

/// What is computed for a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Query {
    YesNo,
    Distance,
    Depth,
}

/// Who answers, from the cheapest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Precision {
    /// World boxes: conservative.
    Boxes,
    /// Outer spheres: conservative.
    Spheres,
    /// The default: lanes in f32 with certificates, then f64, then exact.
    Lanes,
    /// The same lanes in f32 without their certificates.
    Fast,
    /// GJK in f32, one pair at a time; distances and depths with the bound that f32 would resolve.
    F32,
    /// GJK in f64, one pair at a time; distances and depths with the bound that f64 gives.
    F64,
    /// f64, then exact, one pair at a time.
    Certified,
    ParryF32,
    ParryF64,
}

/// What a precision says of a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Said {
    Apart,
    Touching,
    /// Apart by so much, or so deep, as the query wants; metres.
    Measured(f64),
    /// Undecided.
    Open,
}

impl Query {
    pub(crate) const ALL: [Self; 3] = [Self::YesNo, Self::Distance, Self::Depth];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::YesNo => "yes-no",
            Self::Distance => "distance",
            Self::Depth => "depth",
        }
    }
}

impl Precision {
    pub(crate) const ALL: [Self; 9] = [
        Self::Boxes,
        Self::Spheres,
        Self::Fast,
        Self::Lanes,
        Self::F32,
        Self::F64,
        Self::Certified,
        Self::ParryF32,
        Self::ParryF64,
    ];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Boxes => "boxes",
            Self::Spheres => "spheres",
            Self::Fast => "fast, lanes",
            Self::Lanes => "certified, lanes",
            Self::F32 => "f32",
            Self::F64 => "f64",
            Self::Certified => "certified",
            Self::ParryF32 => "Parry f32",
            Self::ParryF64 => "Parry f64",
        }
    }

    /// Whether each of its answers is promised to be right, and none open.
    pub(crate) fn is_certified(self) -> bool {
        matches!(self, Self::Lanes | Self::Certified)
    }

    /// Whether "apart" is promised to be right, and nothing else.
    pub(crate) fn is_conservative(self) -> bool {
        matches!(self, Self::Boxes | Self::Spheres)
    }

    /// With what bound it measures.
    fn accuracy(self) -> Accuracy {
        match self {
            Self::F32 => Accuracy::F32,
            Self::F64 => Accuracy::F64,
            _ => Accuracy::Certified,
        }
    }

    /// Who has an answer to that query.
    pub(crate) fn answering(query: Query) -> Vec<Self> {
        let answers = |precision: &Self| match query {
            Query::YesNo => true,
            Query::Distance | Query::Depth => !matches!(precision, Self::Fast | Self::Lanes),
        };
        Self::ALL.into_iter().filter(answers).collect()
    }
}

/// A precision that is ready for a subject's pairs: whatever depends on the shapes or on
/// single objects alone is made.
pub(crate) enum Ready<'s> {
    Boxes(Vec<Aabb>),
    Fast(Box<SimdOverlap<OverlapUnchecked>>),
    Lanes(Box<SimdOverlap<Overlap>>),
    ParryF32(Theirs<'s, f32>),
    ParryF64(Theirs<'s, f64>),
    /// Nothing to prepare but memory.
    Plain(Box<Scratch>),
}

impl<'s> Ready<'s> {
    pub(crate) fn new(precision: Precision, subject: &'s Subject) -> Self {
        match precision {
            Precision::Boxes => {
                let bodies = 0..subject.shapes.len();
                Self::Boxes(bodies.map(|i| subject.shapes[i].aabb(&subject.poses[i])).collect())
            }
            Precision::Fast => {
                Self::Fast(Box::new(SimdOverlap::new(OverlapUnchecked::default(), subject)))
            }
            Precision::Lanes => {
                Self::Lanes(Box::new(SimdOverlap::new(Overlap::default(), subject)))
            }
            Precision::ParryF32 => Self::ParryF32(Theirs::new(subject)),
            Precision::ParryF64 => Self::ParryF64(Theirs::new(subject)),
            Precision::Spheres | Precision::F32 | Precision::F64 | Precision::Certified => {
                Self::Plain(Box::default())
            }
        }
    }

    /// What it says of the pairs, in their order.
    pub(crate) fn run(
        &mut self,
        (precision, query): (Precision, Query),
        subject: &Subject,
        pairs: &[u32],
        said: &mut Vec<Said>,
    ) {
        said.clear();
        match self {
            Self::Boxes(boxes) => said.extend(pairs.iter().map(|&k| {
                let [a, b] = subject.pairs[k as usize].map(|i| &boxes[i as usize]);
                of_boxes(query, a, b)
            })),
            Self::Fast(lanes) => lanes.run(subject, pairs, said),
            Self::Lanes(lanes) => lanes.run(subject, pairs, said),
            Self::ParryF32(theirs) => theirs.run(query, subject, pairs, said),
            Self::ParryF64(theirs) => theirs.run(query, subject, pairs, said),
            Self::Plain(scratch) => said.extend(pairs.iter().map(|&k| {
                let [a, b] = subject.placed(k);
                one(precision, query, [a, b], scratch)
            })),
        }
    }
}

/// A narrow phase that has its objects prepared.
pub(crate) struct SimdOverlap<N: NarrowPhase> {
    narrow: N,
    frame: N::Frame,
    scratch: N::Scratch,
}

impl<N: NarrowPhase<Answer = ()>> SimdOverlap<N> {
    fn new(narrow: N, subject: &Subject) -> Self {
        let mut frame = N::Frame::default();
        let scene = &subject.scene;
        let part = narrow.layout(scene, Sides::One, &mut frame);
        narrow.prepare(scene, 0, part, &mut vec![Aabb::default(); scene.len()]);
        Self { narrow, frame, scratch: N::Scratch::default() }
    }

    /// Pairs that no scene takes, since no f32 AABB holds them, are open.
    fn run(&mut self, subject: &Subject, pairs: &[u32], said: &mut Vec<Said>) {
        let in_scene: Vec<Pair> =
            pairs.iter().filter_map(|&k| subject.in_scene[k as usize]).collect();
        let (mut contacts, mut report) = (Vec::new(), Report::default());
        let sink = &mut ContactSink { contacts: &mut contacts, report: &mut report };
        let side = Prepared { scene: &subject.scene, frame: &self.frame };
        self.narrow.decide(side, side, &in_scene, &mut self.scratch, sink);
        let mut contacts = contacts.iter().map(|contact| contact.pair).peekable();
        let open: Vec<Pair> = report.undecided().iter().map(|open| open.pair).collect();
        said.extend(pairs.iter().map(|&k| match subject.in_scene[k as usize] {
            None => Said::Open,
            // Contacts come in the order of the pairs.
            Some(pair) if contacts.next_if_eq(&pair).is_some() => Said::Touching,
            Some(pair) if open.contains(&pair) => Said::Open,
            Some(_) => Said::Apart,
        }));
    }
}

fn one(
    precision: Precision,
    query: Query,
    [a, b]: [PosedShape<'_>; 2],
    scratch: &mut Scratch,
) -> Said {
    match (query, precision) {
        (_, Precision::Spheres) => of_spheres(query, a, b),
        (Query::YesNo, Precision::F32) => verdict(Gjk::<f32>::default().solve(a, b, &mut ())),
        (Query::YesNo, Precision::F64) => verdict(Gjk::<f64>::default().solve(a, b, &mut ())),
        (Query::YesNo, _) => verdict(Certified.solve(a, b, &mut Default::default())),
        (Query::Distance, precision) => {
            of_distance(distance::distance_at(precision.accuracy(), a, b).0)
        }
        (Query::Depth, Precision::F32 | Precision::F64) => {
            match Depths.measure_at(precision.accuracy(), a, b, scratch) {
                Verdict::Touching(found) => Said::Measured(found.depth),
                Verdict::Apart => Said::Apart,
                Verdict::Undecided(_) => Said::Open,
            }
        }
        (Query::Depth, _) => match [body(a), body(b)] {
            [Some(a), Some(b)] => match epa::depth(a, b, scratch) {
                Verdict::Touching(found) => Said::Measured(found.depth),
                Verdict::Apart => Said::Apart,
                Verdict::Undecided(_) => Said::Open,
            },
            _ => Said::Open,
        },
    }
}

pub(crate) fn body(side: PosedShape<'_>) -> Option<PosedSupport<'_, Polytope>> {
    Some(PosedSupport::polytope(side.shape.as_polytope()?, side.pose))
}

fn verdict(verdict: Verdict<()>) -> Said {
    match verdict {
        Verdict::Apart => Said::Apart,
        Verdict::Touching(()) => Said::Touching,
        Verdict::Undecided(_) => Said::Open,
    }
}

fn of_distance(result: DistanceResult) -> Said {
    match result {
        DistanceResult::Apart(found) => Said::Measured(found.distance),
        DistanceResult::Touching => Said::Touching,
        DistanceResult::Interval { .. } | DistanceResult::Undecided(_) => Said::Open,
    }
}

/// The gap of two AABBs is at most the shapes' distance, their overlap at least the depth.
fn of_boxes(query: Query, a: &Aabb, b: &Aabb) -> Said {
    let gaps = [0, 1, 2].map(|k| {
        let [low, high] = [a.min[k] - b.max[k], b.min[k] - a.max[k]].map(f64::from);
        low.max(high)
    });
    let largest = gaps.into_iter().fold(f64::NEG_INFINITY, f64::max);
    match query {
        Query::YesNo => {
            if largest > 0.0 {
                Said::Apart
            } else {
                Said::Touching
            }
        }
        Query::Distance if largest > 0.0 => {
            Said::Measured(gaps.map(|gap| gap.max(0.0).powi(2)).iter().sum::<f64>().sqrt())
        }
        Query::Distance => Said::Touching,
        Query::Depth => Said::Measured(-largest.min(0.0)),
    }
}

/// The same of the spheres that hold the shapes.
fn of_spheres(query: Query, a: PosedShape<'_>, b: PosedShape<'_>) -> Said {
    let [(centre_a, radius_a), (centre_b, radius_b)] = [a, b].map(sphere);
    let rounding = 16.0 * f64::EPSILON * (centre_a.abs() + centre_b.abs()).max_element();
    let gap = length(centre_a - centre_b) - (radius_a + radius_b) * (1.0 + 1e-14) - rounding;
    match query {
        Query::YesNo => {
            if gap > 0.0 {
                Said::Apart
            } else {
                Said::Touching
            }
        }
        Query::Distance if gap > 0.0 => Said::Measured(gap),
        Query::Distance => Said::Touching,
        Query::Depth => Said::Measured(-gap.min(0.0)),
    }
}

/// Without squares that overflow.
fn length(v: DVec3) -> f64 {
    let largest = v.abs().max_element();
    if largest > 0.0 { (v / largest).length() * largest } else { 0.0 }
}

fn sphere(side: PosedShape<'_>) -> (DVec3, f64) {
    match side.shape {
        Shape::Polytope(polytope) => {
            let outer = polytope.outer_radius() * (1.0 + side.pose.deviation());
            (side.pose.apply(polytope.inner().centre), outer + polytope.swept_radius())
        }
        shape => (side.pose.translation(), shape.reach() * (1.0 + side.pose.deviation())),
    }
}
