//! The cheapest method: boxes and spheres alone.

use crate::{Method, PairSolver, PosedShape, Verdict};
use dcd_geom::glam::DVec3;

/// Whether boxes and spheres round two objects leave it possible that they touch: "apart" is proved,
/// "touching" only means near.
///
/// The box is the one that the broad phase sees; the sphere is round the centre of the shape's inner
/// sphere, for polytopes, rounded or not. Wrap it in [`crate::Pairwise`] for a scene.
#[derive(Clone, Copy, Debug, Default)]
pub struct BoundsOnly;

/// How far the computed gap between two spheres may be off. Unit: 2⁻⁵³ of the centres' coordinates and
/// the reaches. Three products and three sums a coordinate, the difference, the norm and the sum of
/// the radii: 14, and a margin. Smaller: a false "apart".
const ROUNDING: f64 = 32.0;

impl PairSolver for BoundsOnly {
    type Answer = ();
    type Scratch = ();

    fn method(&self) -> Method {
        Method::Spheres
    }

    fn solve(&self, a: PosedShape<'_>, b: PosedShape<'_>, (): &mut ()) -> Verdict<()> {
        let boxes_meet = a.shape.aabb(a.pose).overlaps(&b.shape.aabb(b.pose));
        if boxes_meet && spheres_may_meet(a, b) { Verdict::Touching(()) } else { Verdict::Apart }
    }
}

fn spheres_may_meet(a: PosedShape<'_>, b: PosedShape<'_>) -> bool {
    let (Some((centre_a, radius_a, size_a)), Some((centre_b, radius_b, size_b))) =
        (sphere(a), sphere(b))
    else {
        return true;
    };
    let unit = f64::EPSILON / 2.0;
    let rounding = ROUNDING * unit * (size_a + size_b);
    // Written so that NaN and overflow leave it possible.
    !(centre_a.distance(centre_b) > radius_a + radius_b + rounding)
}

/// A sphere round a placed polytope, and the size of the numbers that it was computed from.
fn sphere(placed: PosedShape<'_>) -> Option<(DVec3, f64, f64)> {
    let polytope = placed.shape.as_polytope()?;
    let stretch = 1.0 + placed.pose.deviation();
    let radius = polytope.outer_radius() * stretch + polytope.swept_radius();
    let size = placed.pose.translation().abs().max_element() + polytope.reach() * stretch + radius;
    Some((placed.pose.apply(polytope.inner().centre), radius, size))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::{Pose, Shape};

    fn verdict(a: &Shape, b: &Shape, at: DVec3) -> Verdict<()> {
        let pose = Pose::from_translation(at).unwrap();
        let a = PosedShape { shape: a, pose: &Pose::IDENTITY };
        BoundsOnly.solve(a, PosedShape { shape: b, pose: &pose }, &mut ())
    }

    #[test]
    fn what_touches_is_never_called_apart_and_what_is_far_is() {
        let sphere = Shape::sphere(0.5).unwrap();
        let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
        assert_eq!(verdict(&sphere, &sphere, DVec3::X), Verdict::Touching(()));
        assert_eq!(verdict(&cube, &cube, DVec3::ONE), Verdict::Touching(()));
        assert_eq!(verdict(&cube, &cube, DVec3::X * 1.001), Verdict::Apart);
    }

    #[test]
    fn spheres_reject_where_boxes_meet() {
        let sphere = Shape::sphere(0.5).unwrap();
        assert_eq!(verdict(&sphere, &sphere, DVec3::splat(0.7)), Verdict::Apart);
    }

    #[test]
    fn a_shape_without_a_sphere_is_judged_by_its_box() {
        let (cone, sphere) = (Shape::cone(0.5, 0.5).unwrap(), Shape::sphere(0.5).unwrap());
        assert_eq!(verdict(&cone, &sphere, DVec3::X * 0.9), Verdict::Touching(()));
        assert_eq!(verdict(&cone, &sphere, DVec3::X * 1.1), Verdict::Apart);
    }
}
