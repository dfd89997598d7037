//! Shapes that touch in the witnesses of their depth alone, as is known before anything is clipped: spheres, and capsules whose
//! edges cross.

use super::corners::{self, OfSphere};
use super::facing::Part;
use super::feature::surely_cross;
use super::{Feature, Manifold, ManifoldPoint, ManifoldSet, bound_of_witnesses};
use crate::epa::Depth;
use crate::{PosedShape, Verdict};
use dcd_geom::{Kind, Polytope, Shape};
use dcd_simd::ArrayVec;

/// The features and the bound of two shapes that touch in the witnesses of their depth alone, as is known at once.
#[inline]
pub(super) fn in_one_point(
    depth: &Depth,
    [a, b]: [PosedShape<'_>; 2],
) -> Option<([Feature; 2], f64)> {
    if corners::is_sphere(a) && corners::is_sphere(b) {
        return Some(([Feature::Vertex(0); 2], depth.error_bound));
    }
    of_sphere(depth, a, b).or_else(|| of_capsules(depth, [a, b]))
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

/// The features and the bound of two capsules that show an end, or edges that cross.
///
/// (a, b) and (b, a) give the same bits, mirrored: a normal that looks the other way changes signs alone.
#[inline]
fn of_capsules(depth: &Depth, [a, b]: [PosedShape<'_>; 2]) -> Option<([Feature; 2], f64)> {
    let (in_a, in_b) = (a.shape.as_polytope()?, b.shape.as_polytope()?);
    if [in_a.kind(), in_b.kind()] != [Kind::Segment; 2] {
        return None;
    }
    let edge = |core: &Polytope, side: PosedShape<'_>| {
        let &[start, end] = core.vertices() else { return None };
        Some(*side.pose.rotation() * (end - start))
    };
    let (e, f) = (edge(in_a, a)?, edge(in_b, b)?);
    let parts = [Part::of_edge(e, depth.normal)?, Part::of_edge(f, -depth.normal)?];
    if let [Part::Edge(_), Part::Edge(_)] = parts
        && !surely_cross(depth.normal, e, f)
    {
        return None;
    }
    let size = 2.0 * (in_a.outer_radius() + in_b.outer_radius());
    Some((parts.map(|part| part.name()), bound_of_witnesses(depth, size, [a, b])))
}

/// The features and the bound of a sphere and another convex shape, which touch in the witnesses of their depth; `None` of
/// others.
#[inline]
fn of_sphere(depth: &Depth, a: PosedShape<'_>, b: PosedShape<'_>) -> Option<([Feature; 2], f64)> {
    let is_half_space = |side: PosedShape<'_>| matches!(side.shape, Shape::HalfSpace(_));
    match [corners::is_sphere(a), corners::is_sphere(b)] {
        [false, false] => None,
        [true, false] if is_half_space(b) => {
            Some(([Feature::Vertex(0), Feature::Surface], depth.error_bound))
        }
        [false, true] if is_half_space(a) => {
            Some(([Feature::Surface, Feature::Vertex(0)], depth.error_bound))
        }
        _ => {
            let OfSphere { features, size } = corners::of_sphere(depth.normal, [a, b])?;
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
    use crate::order;
    use crate::query::{Accuracy, depths};
    use dcd_geom::Pose;
    use dcd_geom::glam::DQuat;

    #[test]
    fn capsules_of_one_point_show_what_the_general_way_has() {
        let mut draw = Draw(41);
        let (mut edges, mut ends, mut others) = (0, 0, 0);
        for k in 0..6000 {
            let shapes = [0; 2].map(|_| {
                let size = draw.vector().abs() * 0.5 + 0.05;
                Shape::capsule(size.x, size.y).unwrap()
            });
            let turn = draw.vector() * 3.0;
            let tilt = draw.vector() * [0.0, 1e-7, 1e-3, 3.0][k % 4];
            let turns = [turn, turn + tilt].map(DQuat::from_scaled_axis);
            let poses = turns.map(|turn| Pose::new(turn, draw.vector() * 0.3).unwrap());
            let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
            let Some(depth) = depths::by_frame(Accuracy::F32, a, b) else { continue };
            let Some((features, error_bound)) = of_capsules(&depth, [a, b]) else {
                others += 1;
                continue;
            };
            let back = of_capsules(&depth.mirrored(), [b, a]);
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
                [Feature::Edge(..), Feature::Edge(..)] => edges += 1,
                _ => ends += 1,
            }
        }
        assert!(edges > 300 && ends > 300 && others > 100, "{edges} {ends} {others}");
    }
}
