//! How far the points of a manifold may be off.

use crate::PosedShape;
use crate::epa::Depth;
use dcd_geom::{Kind, Polytope, Shape, SupportMap, Vector};

/// How flat the faces are, and how far two parallel edges may lean, as a part of the error bound;
/// relative to the shapes' size.
const FLAT: f64 = 1e-8;

/// How far a point may be off for the rounding of corners that are placed and seen along the normal, and of the point that is placed
/// back. Unit: of a corner's distance from the origin of its shape's own frame. Derived: 20u. Smaller: points of shapes far from
/// that origin off their surfaces by more than the bound. (docs/numerics/proofs.md, "manifolds")
const PLACED: f64 = 16.0 * f64::EPSILON;

/// How far points may be off for what the poses are off rotations by: planes that are turned as vectors are, and the angles by
/// which faces and edges lean. Unit: the deviations, times the size, the swept radii and the depth. Derived: 3.2. Smaller:
/// points off their surfaces by more than the bound. (docs/numerics/proofs.md, "manifolds")
pub(super) const TURNED: f64 = 4.0;

/// How far shapes are from the origins of their own frames, by their size, for the witnesses of a depth to be off their surfaces
/// by no more than it is: at f32 these are known as well as the frame's coordinates. Larger: points of shapes farther from there
/// off their surfaces by more than the bound.
const FAR: f64 = 8.0;

/// The bound of a manifold of shapes so large, without what is swept round them.
#[inline]
pub(super) fn bound_of(depth: &Depth, size: f64, [a, b]: [PosedShape<'_>; 2]) -> f64 {
    // At least their lengths, without roots.
    let far = a.pose.translation().norm1() + b.pose.translation().norm1();
    let deviation = a.pose.deviation() + b.pose.deviation();
    let ([reach_a, radius_a], [reach_b, radius_b]) = (extent(a.shape), extent(b.shape));
    // The radii first: in either order the same to the bit.
    let turned = TURNED * deviation * (size + (radius_a + radius_b) + depth.depth);
    let rounded = PLACED * (reach_a + reach_b) + 8.0 * f64::EPSILON * far;
    (depth.error_bound + FLAT * size + turned + rounded).min(f64::MAX)
}

/// How far points that are clipped by faces of two shapes may be off, and the deepest of them short of the depth, for what hulls show as one
/// face and is bent: metres.
#[inline]
pub(super) fn unevenness(shapes: [&Shape; 2]) -> f64 {
    let of = |shape: &Shape| shape.as_polytope().map_or(0.0, uneven_by);
    of(shapes[0]) + of(shapes[1])
}

/// The same of one: the faces' planes are off by that on either side.
#[inline]
pub(super) fn uneven_by(polytope: &Polytope) -> f64 {
    match polytope.kind() {
        Kind::Hull => 2.0 * polytope.contact_facets().unevenness(),
        _ => 0.0,
    }
}

/// How far a point of a shape may be from the origin of its own frame, of a half-space how far its plane is; and the largest
/// radius that is swept round the shape, or a part of it: metres.
#[inline(always)]
fn extent(shape: &Shape) -> [f64; 2] {
    match shape {
        Shape::Polytope(core) => [core.reach() + core.swept_radius(), core.swept_radius()],
        Shape::HalfSpace(half_space) => {
            let far = half_space.unit_offset().abs();
            [far + half_space.swept_radius(), half_space.swept_radius()]
        }
        Shape::Compound(compound) => [compound.reach(), compound.swept_radius()],
        // Round its own origin: what that costs is far below what its size does.
        Shape::Curved(curved) => [0.0, curved.swept_radius()],
        other => [other.reach(), other.radius()],
    }
}

/// How far points of a manifold may be off for what poses are off rotations by, the sum of both: metres.
#[inline]
pub(super) fn turned_by(
    deviation: f64,
    (depth, size, [a, b]): (&Depth, f64, [PosedShape<'_>; 2]),
) -> f64 {
    let [[_, radius_a], [_, radius_b]] = [extent(a.shape), extent(b.shape)];
    TURNED * deviation * (size + (radius_a + radius_b) + depth.depth)
}

/// The same of a manifold that is the witnesses of the depth alone, with what these miss of differing by it along the normal.
///
/// Those of polytopes are of their surfaces. Those of a cylinder, cone or foreign shape are on chords of its surface: inside by no
/// more than what their difference lacks of the depth, for all of a shape is on one side of its plane there.
pub(super) fn bound_of_witnesses(depth: &Depth, size: f64, sides: [PosedShape<'_>; 2]) -> f64 {
    let far = sides.iter().map(|side| extent(side.shape)[0]).sum::<f64>();
    let off = if far > FAR * size { 2.0 * depth.error_bound } else { 0.0 };
    (bound_of(depth, size, sides) + depth.missed() + off).min(f64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::tests::Draw;
    use dcd_geom::Pose;
    use dcd_geom::glam::DMat3;

    #[test]
    fn bounds_are_the_same_in_either_order_to_the_bit() {
        let mut draw = Draw(17);
        for k in 0..2000 {
            let shapes = [0.3, 0.7].map(|scale| {
                let radius = draw.vector().x.abs() * scale;
                Shape::cuboid(draw.vector().abs() * 0.4).unwrap().rounded(radius).unwrap()
            });
            let poses = [0; 2].map(|_| {
                let off = DMat3::from_cols(draw.vector(), draw.vector(), draw.vector()) * 1e-8;
                Pose::from_matrix(DMat3::IDENTITY + off, draw.vector()).unwrap()
            });
            let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
            let depth =
                Depth { depth: draw.vector().x.abs(), normal: draw.vector(), ..Depth::default() };
            let size = draw.vector().x.abs();
            let bounds = [(depth, [a, b]), (depth.mirrored(), [b, a])].map(|(depth, sides)| {
                let turned = turned_by(1e-8, (&depth, size, sides));
                [bound_of(&depth, size, sides), bound_of_witnesses(&depth, size, sides), turned]
            });
            assert_eq!(bounds[0], bounds[1], "{k}");
        }
    }
}
