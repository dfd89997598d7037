//! Shapes that touch in the witnesses of their depth alone, as is known before anything is clipped: spheres, and capsules and
//! cuboids that show an end or a corner, or edges that cross.

use super::corners::{self, OfSphere};
use super::cuboids;
use super::facing::Part;
use super::feature::surely_cross;
use super::{Feature, Manifold, ManifoldPoint, ManifoldSet, bound_of, bound_of_witnesses};
use crate::closed::{self, is_sphere};
use crate::epa::Depth;
use crate::{PosedShape, Verdict};
use dcd_geom::glam::DVec3;
use dcd_geom::{Kind, Shape};
use dcd_simd::ArrayVec;

/// The features and the bound of two shapes that touch in the witnesses of their depth alone, as is known at once.
#[inline]
pub(super) fn in_one_point(
    depth: &Depth,
    [a, b]: [PosedShape<'_>; 2],
) -> Option<([Feature; 2], f64)> {
    if is_sphere(a) && is_sphere(b) {
        // As lanes have it, to the bit.
        let bound = match closed::two_spheres(a, b) {
            Some(spheres) => depth.error_bound + closed::off_surface(spheres),
            None => bound_of(depth, 0.0, [a, b]),
        };
        return Some(([Feature::Vertex(0); 2], bound));
    }
    of_sphere(depth, [a, b], None).or_else(|| of_capsule(depth, [a, b]))
}

/// The witnesses of the depth alone, with those features and that bound.
#[inline]
pub(super) fn of_one_point(
    &Depth { depth, normal, point_a, point_b, .. }: &Depth,
    (features, error_bound): ([Feature; 2], f64),
) -> Verdict<ManifoldSet> {
    // Written where it is returned: a copy of a manifold takes as long as the depth of spheres.
    let parts = [None; 2];
    let mut points = ArrayVec::new();
    points.push(ManifoldPoint { point_a, point_b, depth, features, parts });
    let found = Manifold { normal, points, error_bound, parts };
    Verdict::Touching(found.into())
}

/// The features and the bound of a capsule and a capsule or cuboid of which one shows an end or a corner, or both edges that
/// cross; `None` of others.
///
/// (a, b) and (b, a) give the same bits, mirrored: a normal that looks the other way changes signs alone.
#[inline]
fn of_capsule(depth: &Depth, [a, b]: [PosedShape<'_>; 2]) -> Option<([Feature; 2], f64)> {
    let (in_a, in_b) = (a.shape.as_polytope()?, b.shape.as_polytope()?);
    if !matches!(
        (in_a.kind(), in_b.kind()),
        (Kind::Segment, Kind::Segment | Kind::Cuboid { .. }) | (Kind::Cuboid { .. }, Kind::Segment)
    ) {
        return None;
    }
    let (of_a, of_b) = (shown(a, depth.normal)?, shown(b, -depth.normal)?);
    let is_one = match [of_a, of_b] {
        [(Feature::Vertex(_), _), _] | [_, (Feature::Vertex(_), _)] => true,
        [(Feature::Edge(..), e), (Feature::Edge(..), f)] => surely_cross(depth.normal, e, f),
        _ => false,
    };
    let size = 2.0 * (in_a.outer_radius() + in_b.outer_radius());
    let features = [of_a.0, of_b.0];
    is_one.then(|| (features, bound_of_witnesses(depth, size, [a, b])))
}

/// What a capsule or cuboid shows towards a direction of the world, of unit length, and along what that is if it is an edge.
/// `None` where the general way is needed.
#[inline(always)]
fn shown(side: PosedShape<'_>, towards: DVec3) -> Option<(Feature, DVec3)> {
    let core = side.shape.as_polytope()?;
    let &[start, end] = core.vertices() else { return cuboids::shown(side, towards) };
    let edge = *side.pose.rotation() * (end - start);
    Some((Part::of_edge(edge, towards)?.name(), edge))
}

/// The features and the bound of a sphere and another convex shape, which touch in the witnesses of their depth; `None` of
/// others. Where the sphere is from the other may be known in that one's frame.
#[inline(always)]
pub(super) fn of_sphere(
    depth: &Depth,
    [a, b]: [PosedShape<'_>; 2],
    outward: Option<DVec3>,
) -> Option<([Feature; 2], f64)> {
    let is_half_space = |side: PosedShape<'_>| matches!(side.shape, Shape::HalfSpace(_));
    match [is_sphere(a), is_sphere(b)] {
        [false, false] => None,
        [true, false] if is_half_space(b) => {
            Some(([Feature::Vertex(0), Feature::Surface], bound_of(depth, 0.0, [a, b])))
        }
        [false, true] if is_half_space(a) => {
            Some(([Feature::Surface, Feature::Vertex(0)], bound_of(depth, 0.0, [a, b])))
        }
        _ => {
            let OfSphere { features, size } = corners::of_sphere(depth.normal, [a, b], outward)?;
            Some((features, bound_of_witnesses(depth, size, [a, b])))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::corners::Corners;
    use super::super::write_in_order;
    use super::*;
    use crate::motion::tests::Draw;
    use crate::query::{Accuracy, Manifolds, MeasureAt, depths};
    use crate::{certified, closed, order};
    use dcd_geom::Pose;
    use dcd_geom::glam::DQuat;

    /// Two capsules, a capsule and a cuboid, or a cuboid and a capsule, turned alike, nearly so, or not.
    fn pair(draw: &mut Draw, k: usize) -> ([Shape; 2], [Pose; 2]) {
        let shapes = [1, 2].map(|cuboid| {
            let size = draw.vector().abs() * 0.5 + 0.05;
            match k / 4 % 3 == cuboid {
                true => Shape::cuboid(size).unwrap().rounded(0.05 * (k % 2) as f64).unwrap(),
                false => Shape::capsule(size.x, size.y).unwrap(),
            }
        });
        let turn = draw.vector() * 3.0;
        let tilt = draw.vector() * [0.0, 1e-7, 1e-3, 3.0][k % 4];
        let turns = [turn, turn + tilt].map(DQuat::from_scaled_axis);
        (shapes, turns.map(|turn| Pose::new(turn, draw.vector() * 0.4).unwrap()))
    }

    #[test]
    fn capsules_of_one_point_show_what_the_general_way_has() {
        let mut draw = Draw(41);
        // Of two capsules, and with a cuboid: edges that cross, other features, and those that are left open.
        let mut counts = [[0; 3]; 2];
        for k in 0..12_000 {
            let (shapes, poses) = pair(&mut draw, k);
            let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
            let Some(depth) = depths::by_frame(Accuracy::F32, a, b) else { continue };
            let [edges, corners, others] = &mut counts[usize::from(k / 4 % 3 > 0)];
            let Some((features, error_bound)) = of_capsule(&depth, [a, b]) else {
                *others += 1;
                continue;
            };
            let back = of_capsule(&depth.mirrored(), [b, a]);
            assert_eq!(back, Some(([features[1], features[0]], error_bound)), "{k}");
            let is_swapped = order::is_swapped(a, b);
            let (sides, depth) = match is_swapped {
                true => ([b, a], depth.mirrored()),
                false => ([a, b], depth),
            };
            let mut due = Manifold::default();
            write_in_order(&depth, sides, &mut Corners::default(), &mut due);
            let [only] = due.points() else { panic!("{k}: {due:?}") };
            let of_sides = if is_swapped { [features[1], features[0]] } else { features };
            assert_eq!((only.features, due.error_bound), (of_sides, error_bound), "{k}");
            assert_eq!((only.point_a, only.depth), (depth.point_a, depth.depth), "{k}");
            match features {
                [Feature::Edge(..), Feature::Edge(..)] => *edges += 1,
                _ => *corners += 1,
            }
        }
        assert!(counts.as_flattened().iter().all(|&count| count > 100), "{counts:?}");
    }

    #[test]
    fn single_points_far_from_the_origin_are_off_their_surfaces_by_no_more_than_the_bound() {
        let (mut draw, mut counts) = (Draw(43), [0; 2]);
        for k in 0..2000 {
            let far = draw.vector() * 3e8;
            let shapes = [
                Shape::hull(vec![DVec3::ZERO]).unwrap().swept(0.8).unwrap(),
                // Another hull of one point, or a capsule of no length.
                match k % 2 {
                    0 => Shape::hull(vec![DVec3::ZERO]).unwrap().swept(0.3).unwrap(),
                    _ => Shape::capsule(0.0, 0.3).unwrap(),
                },
            ];
            let poses = [0; 2].map(|_| Pose::from_translation(far + draw.vector() * 0.5).unwrap());
            let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
            if certified::overlap_of(a, b).0 != Verdict::Touching(()) {
                continue;
            }
            counts[k % 2] += 1;
            let found =
                Manifolds::default().measure_at(Accuracy::F64, a, b, &mut Default::default());
            let Verdict::Touching(found) = found else { panic!("{k}: {found:?}") };
            let [only] = found[0].points() else { panic!("{k}: {found:?}") };
            for (side, at, radius) in [(a, only.point_a, 0.8), (b, only.point_b, 0.3)] {
                let off = (at.distance(side.pose.translation()) - radius).abs();
                assert!(off <= found[0].error_bound, "{k}: {off} {found:?}");
            }
        }
        assert!(counts.iter().all(|&count| count > 500), "{counts:?}");
    }

    #[test]
    fn where_a_sphere_is_seen_from_shows_what_its_normal_does() {
        let mut draw = Draw(42);
        let mut counts = [0; 3];
        for k in 0..6000 {
            let half = draw.vector().abs() * 0.4 + 0.1;
            let other = match k % 4 {
                0 => Shape::triangle([0; 3].map(|_| draw.vector() * 0.5)),
                1 => Shape::hull((0..12).map(|_| draw.vector() * 0.5).collect()),
                2 => Shape::cuboid(half),
                _ => Shape::capsule(half.x, half.y),
            };
            let shapes = [Shape::sphere(0.3).unwrap(), other.unwrap()];
            let poses = [0; 2].map(|_| {
                let turn = DQuat::from_scaled_axis(draw.vector() * 3.0);
                Pose::new(turn, draw.vector() * 0.4).unwrap()
            });
            let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
            let seen = closed::centred::gap_and_outward(Accuracy::F32, a, b);
            let back = closed::centred::gap_and_outward(Accuracy::F32, b, a);
            assert_eq!(seen.as_ref().map(|seen| seen.1), back.map(|back| back.1), "{k}");
            let Some((gap, outward)) = seen else { continue };
            let Some(depth) = gap.depth() else { continue };
            let found = of_sphere(&depth, [a, b], Some(outward));
            assert_eq!(found, of_sphere(&depth, [a, b], None), "{k}");
            match found {
                Some(([_, Feature::Face(_)], _)) => counts[0] += 1,
                Some(([_, Feature::Edge(..)], _)) => counts[1] += 1,
                _ => counts[2] += 1,
            }
        }
        assert!(counts.iter().all(|&count| count > 200), "{counts:?}");
    }
}
