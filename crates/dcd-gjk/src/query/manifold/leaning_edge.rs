//! How far inside a swept surface the points of an edge are that are moved along the contact's normal.

use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, SupportMap};

/// The cosine of the angle by which an edge leans from a direction of the polytope's own frame, of unit length: moved along
/// it by the swept radius r, a point of the edge is at most r·(1 − cosine) inside the surface. Smaller where the faces at
/// the edge look elsewhere; 0 where nothing less than r is known.
///
/// Proof: docs/numerics/proofs.md, "manifolds".
// Out of line: rounded polytopes alone need it.
#[inline(never)]
pub(super) fn level_of_edge(polytope: &Polytope, ends: [u32; 2], towards: DVec3) -> f64 {
    let radius = polytope.swept_radius();
    if radius == 0.0 {
        // Nothing is moved.
        return 1.0;
    }
    let [from, to] = ends.map(|k| polytope.vertices()[k as usize]);
    let along = to - from;
    let across = towards - along * (towards.dot(along) / along.length_squared());
    // False for NaN, of an edge without length.
    let cosine = across.length();
    if !(cosine > 0.0) {
        return 0.0;
    }
    if polytope.vertices().len() == 2 {
        return cosine;
    }
    let outward = across / cosine;
    let farthest = SupportMap::<f64>::support(polytope, outward).point;
    let beyond = outward.dot(farthest - from).max(outward.dot(farthest - to)).max(0.0);
    (towards.dot(outward) - beyond / radius).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::tests::Draw;
    use crate::query::manifold::facing::Part;
    use dcd_geom::{Pose, Shape};

    #[test]
    fn no_point_of_an_edge_is_farther_inside_the_surface() {
        let mut draw = Draw(71);
        let mut counts = [0; 2];
        for k in 0..4000 {
            let radius = [0.01, 0.1, 0.5][k % 3];
            let points = (0..4 + k % 20).map(|_| draw.vector()).collect();
            let core = match k % 4 {
                0 => Polytope::cuboid(draw.vector().abs() * 0.4 + 0.1).unwrap(),
                _ => Polytope::hull(points).unwrap(),
            };
            let rounded = core.clone().rounded(radius).unwrap();
            let towards = draw.vector().normalize();
            let Part::Edge(ends) = Part::facing(&rounded, towards) else { continue };
            let level = level_of_edge(&rounded, ends, towards);
            assert!((0.0..=1.0).contains(&level));
            let core = Shape::from(core);
            for share in [0.0, 0.3, 1.0] {
                let [from, to] = ends.map(|k| rounded.vertices()[k as usize]);
                let moved = from.lerp(to, share) + towards * radius;
                // How far inside is what the way back to the core lacks of the radius.
                let to_core = distance_of_point(&core, moved);
                assert!(radius - to_core <= radius * (1.0 - level) + 1e-9, "{k} {share} {level}");
            }
            counts[0] += 1;
            counts[1] += usize::from(level > 0.9);
        }
        assert!(counts[0] > 500 && counts[1] > 200, "{counts:?}");
    }

    /// By GJK; 0 inside.
    fn distance_of_point(shape: &Shape, point: DVec3) -> f64 {
        use crate::PosedShape;
        use crate::distance::{DistanceResult, distance};
        let ball = Shape::sphere(0.0).unwrap();
        let at = Pose::from_translation(point).unwrap();
        let sides =
            [PosedShape { shape, pose: &Pose::IDENTITY }, PosedShape { shape: &ball, pose: &at }];
        match distance(sides[0], sides[1]).0 {
            DistanceResult::Apart(found) => found.distance,
            _ => 0.0,
        }
    }
}
