//! A triangle that is a shape of its own, by the formulas of a mesh's triangles.

use super::cuboid::ByAxes;
use super::reach::Couple;
use super::side::Part;
use crate::PosedShape;
use crate::epa::Depth;
use dcd_geom::{Kind, Shape};

/// What a formula finds of a triangle and another convex shape.
pub(crate) enum OfTriangle {
    /// They are at least so far apart: metres, above 0.
    Apart(f64),
    Deep(Depth),
}

/// What is known of a triangle and another shape, from a to b: a depth within `relative` of itself or `of_size` of the
/// pair's size. `None` of others, and where no formula knows it.
///
/// (a, b) and (b, a) give the same bits, mirrored.
pub(crate) fn of_triangle(
    a: PosedShape<'_>,
    b: PosedShape<'_>,
    [relative, of_size]: [f64; 2],
) -> Option<OfTriangle> {
    let (triangle, other, swapped) = match [part(a), part(b)] {
        [Some(triangle), None] => (triangle, (b, a), false),
        [None, Some(triangle)] => (triangle, (a, b), true),
        _ => return None,
    };
    let (other, at) = other;
    let couple = Couple::of([triangle, Part::Shape(other.shape)], [at.pose, other.pose])?;
    let is_good =
        |found: &Depth| found.error_bound <= (relative * found.depth).max(of_size * couple.size());
    let found = match couple.by_axes() {
        Some(ByAxes::Apart(axis)) => {
            let gap = -couple.most_along(-axis);
            return (gap > 0.0).then_some(OfTriangle::Apart(gap));
        }
        Some(ByAxes::Touching(Some(found))) if is_good(&found) => found,
        _ => couple.pressed().filter(is_good)?,
    };
    Some(OfTriangle::Deep(if swapped { found.mirrored() } else { found }))
}

/// A triangle as one of a mesh.
fn part<'a>(side: PosedShape<'a>) -> Option<Part<'a>> {
    let Shape::Polytope(polytope) = side.shape else { return None };
    match (polytope.kind(), polytope.vertices()) {
        (Kind::Triangle, &[p, q, r]) => Some(Part::Triangle {
            corners: [p, q, r],
            reach: polytope.reach(),
            radius: polytope.swept_radius(),
        }),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::tests::Draw;
    use crate::query::{Accuracy, MeasureAt};
    use crate::{Depths, Verdict, distance::distance};
    use dcd_geom::Pose;
    use dcd_geom::glam::{DQuat, DVec3};

    fn body(draw: &mut Draw, k: usize) -> Shape {
        let half = draw.vector().abs() * 0.4 + 0.05;
        let made = match k % 6 {
            0 | 1 => Shape::cuboid(half),
            2 => Shape::cuboid(half).and_then(|cuboid| cuboid.rounded(0.1)),
            3 => Shape::hull((0..12).map(|_| draw.vector() * half).collect()),
            4 => Shape::cylinder(half.x, half.y),
            _ => Shape::capsule(half.x, half.y),
        };
        made.unwrap()
    }

    /// Needles among them, and corners in a plane of a cuboid.
    fn triangle(draw: &mut Draw, k: usize) -> Shape {
        let mut corners = [0; 3].map(|_| draw.vector() * [0.7, 0.2][k / 6 % 2]);
        match k % 7 {
            0 => corners[2] = corners[0].lerp(corners[1], 0.5) + draw.vector() * 1e-9,
            1 => corners.iter_mut().for_each(|corner| corner.z = 0.1),
            _ => {}
        }
        let swept = if k.is_multiple_of(5) { 0.05 } else { 0.0 };
        Shape::triangle(corners).and_then(|shape| shape.rounded(swept)).unwrap()
    }

    #[test]
    fn a_triangle_of_its_own_is_as_deep_or_as_far_as_the_certified_way_finds() {
        let mut draw = Draw(31);
        let [mut deep, mut apart] = [0; 2];
        for k in 0..6000 {
            let shapes = [triangle(&mut draw, k), body(&mut draw, k)];
            let far = draw.vector() * if k.is_multiple_of(11) { 1e4 } else { 0.0 };
            let mut pose = |is_turned: bool| {
                let turn = if is_turned { draw.vector() * 3.0 } else { DVec3::ZERO };
                Pose::new(DQuat::from_scaled_axis(turn), far + draw.vector() * 0.4).unwrap()
            };
            let poses = [pose(!k.is_multiple_of(3)), pose(!k.is_multiple_of(3))];
            let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
            let [found, back] = [of_triangle(a, b, [0.0, 1e-6]), of_triangle(b, a, [0.0, 1e-6])];
            match (found, back) {
                (Some(OfTriangle::Deep(found)), Some(OfTriangle::Deep(back))) => {
                    assert_eq!(found, back.mirrored(), "{k}");
                    let due = Depths.measure_at(Accuracy::Certified, a, b, &mut Default::default());
                    let Verdict::Touching(due) = due else { panic!("{k}: {found:?}") };
                    let off = (found.depth - due.depth).abs();
                    assert!(off <= found.error_bound + due.error_bound, "{k}: {found:?} {due:?}");
                    deep += 1;
                }
                (Some(OfTriangle::Apart(gap)), Some(OfTriangle::Apart(back))) => {
                    assert_eq!(gap, back, "{k}");
                    let crate::DistanceResult::Apart(due) = distance(a, b).0 else {
                        panic!("{k}: {gap}")
                    };
                    assert!(gap <= due.distance + due.error_bound, "{k}: {gap} {due:?}");
                    apart += 1;
                }
                (None, None) => {}
                _ => panic!("{k}: one way, and not the other"),
            }
        }
        assert!(deep > 500 && apart > 1000, "{deep} {apart}");
    }
}
