//! The precisions and their queries.

use dcd_geom::glam::DVec3;
use dcd_geom::{Aabb, Polytope, Shape};
use dcd_gjk::distance::{self, DistanceResult};
use dcd_gjk::epa::{self, Scratch};
use dcd_gjk::query::MeasureAt;
use dcd_gjk::{
    Accuracy, Certified, Depths, Gjk, ManifoldSet, Manifolds, PairSolver, PosedShape, PosedSupport,
    Verdict,
};
use serde::{Deserialize, Serialize};

use crate::packets::{self, Packets};
use crate::parry::Theirs;
use crate::subject::Subject;

/// What is computed for a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Query {
    YesNo,
    Distance,
    Depth,
    /// The depth at the deepest point of a manifold.
    Manifold,
}

/// Who answers, from the cheapest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Precision {
    /// World boxes: conservative.
    Boxes,
    /// Outer spheres: conservative.
    Spheres,
    /// The default: packets in f32 with certificates, then f64, then exact; distances, depths and manifolds of whole
    /// scenes at the accuracy that is certified.
    Lanes,
    /// The same packets in f32 without their certificates.
    Fast,
    /// Distances, depths and manifolds of whole scenes at [`Accuracy::F64`].
    LanesF64,
    /// The same at [`Accuracy::F32`].
    LanesF32,
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
    pub(crate) const ALL: [Self; 4] = [Self::YesNo, Self::Distance, Self::Depth, Self::Manifold];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::YesNo => "yes-no",
            Self::Distance => "distance",
            Self::Depth => "depth",
            Self::Manifold => "manifold",
        }
    }
}

impl Precision {
    pub(crate) const ALL: [Self; 11] = [
        Self::Boxes,
        Self::Spheres,
        Self::Fast,
        Self::LanesF32,
        Self::LanesF64,
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
            Self::Fast => "fast, packets",
            Self::LanesF32 => "f32, packets",
            Self::LanesF64 => "f64, packets",
            Self::Lanes => "certified, packets",
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

    /// Whether it resolves a scene's pairs in packets: not those beyond the range of f32 AABBs.
    pub(crate) fn is_in_packets(self) -> bool {
        matches!(self, Self::Lanes | Self::Fast | Self::LanesF32 | Self::LanesF64)
    }

    /// With what bound it measures.
    fn accuracy(self) -> Accuracy {
        match self {
            Self::F32 | Self::LanesF32 => Accuracy::F32,
            Self::F64 | Self::LanesF64 => Accuracy::F64,
            _ => Accuracy::Certified,
        }
    }

    /// Who has an answer to that query.
    pub(crate) fn answering(query: Query) -> Vec<Self> {
        let answers = |precision: &Self| match query {
            Query::YesNo => !matches!(precision, Self::LanesF32 | Self::LanesF64),
            Query::Distance | Query::Depth => *precision != Self::Fast,
            Query::Manifold => !matches!(precision, Self::Boxes | Self::Spheres | Self::Fast),
        };
        Self::ALL.into_iter().filter(answers).collect()
    }
}

/// A precision that is ready for a subject's pairs: whatever depends on the shapes or on
/// single objects alone is made.
pub(crate) enum Ready<'s> {
    Boxes(Vec<Aabb>),
    Packets(Box<dyn Packets>),
    ParryF32(Theirs<'s, f32>),
    ParryF64(Theirs<'s, f64>),
    /// Nothing to prepare but memory.
    Plain(Box<Memory>),
}

/// What the solvers of single pairs reuse.
#[derive(Default)]
pub(crate) struct Memory {
    depth: Scratch,
    manifold: <Manifolds as PairSolver>::Scratch,
}

impl<'s> Ready<'s> {
    pub(crate) fn new((precision, query): (Precision, Query), subject: &'s Subject) -> Self {
        match precision {
            Precision::Boxes => {
                let bodies = 0..subject.shapes.len();
                Self::Boxes(bodies.map(|i| subject.shapes[i].aabb(&subject.poses[i])).collect())
            }
            Precision::Fast => Self::Packets(packets::overlap(subject, false)),
            Precision::Lanes | Precision::LanesF32 | Precision::LanesF64 => {
                Self::Packets(packets::numbers(query, precision.accuracy(), subject))
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
            Self::Packets(packets) => packets.run(subject, pairs, said),
            Self::ParryF32(theirs) => theirs.run(query, subject, pairs, said),
            Self::ParryF64(theirs) => theirs.run(query, subject, pairs, said),
            Self::Plain(memory) => said.extend(pairs.iter().map(|&k| {
                let [a, b] = subject.placed(k);
                one(precision, query, [a, b], memory)
            })),
        }
    }
}

fn one(
    precision: Precision,
    query: Query,
    [a, b]: [PosedShape<'_>; 2],
    memory: &mut Memory,
) -> Said {
    let scratch = &mut memory.depth;
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
        (Query::Manifold, precision) => {
            match Manifolds::default().measure_at(precision.accuracy(), a, b, &mut memory.manifold)
            {
                Verdict::Touching(found) => deepest(&found),
                Verdict::Apart => Said::Apart,
                Verdict::Undecided(_) => Said::Open,
            }
        }
    }
}

/// The depth at the first point of the first manifold, the deepest.
pub(crate) fn deepest(found: &ManifoldSet) -> Said {
    let point = found.first().and_then(|manifold| manifold.points().first());
    point.map_or(Said::Open, |point| Said::Measured(point.depth))
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
        Query::Depth | Query::Manifold => Said::Measured(-largest.min(0.0)),
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
        Query::Depth | Query::Manifold => Said::Measured(-gap.min(0.0)),
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
