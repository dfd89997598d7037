//! The distance of two shapes of which one is a cylinder or cone, by the vertices that the lanes found of the hull inside it.

use super::super::depths::Points;
use super::super::frame::SimdFrame;
use super::super::nearest_points::NearestPoints;
use super::super::scene_pairs::ScenePairs;
use crate::Accuracy;
use crate::body::Body;
use crate::distance::{DistanceResult, of_apart_cores};
use dcd_geom::Pair;

/// The distance from where the lanes came to, known as well as the accuracy requires; `None` of other shapes, and where it is not
/// found from there.
pub(super) fn distance_of(
    accuracy: Accuracy,
    points: &NearestPoints,
    (objects, pair): (ScenePairs<'_>, Pair),
) -> Option<DistanceResult> {
    let (sides, cores) = (objects.posed(pair), objects.cores(pair));
    let bodies = [Body::of(sides[0].shape)?, Body::of(sides[1].shape)?];
    matches!(bodies, [Body::Polytope(_), Body::Curved(_)] | [Body::Curved(_), Body::Polytope(_)])
        .then_some(())?;
    let [a, b] = [(objects.frames.a, pair.i), (objects.frames.b, pair.j)];
    let points_of = |side: usize, (frame, record): (&'_ SimdFrame, u32)| {
        let placed = (sides[side].pose.rotation(), cores[side].centre);
        let known = Points::of(bodies[side], placed, frame.blocks_of(frame.record(record)));
        points.corners.map(|corner| bodies[side].support(known.of_vertex(corner[side]).1))
    };
    let ([p, q, r], [s, t, u]) = (points_of(0, a), points_of(1, b));
    of_apart_cores(accuracy, sides, [[p, s], [q, t], [r, u]])
}
