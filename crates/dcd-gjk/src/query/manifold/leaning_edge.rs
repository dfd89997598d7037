//! How far inside a swept surface the points of an edge are that are moved along the contact's normal.

use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, SupportMap};

/// The cosine of the angle by which an edge leans from a direction of the polytope's own frame, of unit length: moved along
/// it by the swept radius r, a point of the edge is at most r·(1 − cosine) inside the surface. Smaller where the core
/// reaches beyond the plane through the edge; 0 where nothing less than r is known.
///
/// Proof: docs/numerics/proofs.md, "manifolds".
pub(super) fn level_of_edge(polytope: &Polytope, ends: [u32; 2], towards: DVec3) -> f64 {
    let vertices = polytope.vertices();
    let ends = ends.map(|k| vertices[k as usize]);
    let farthest = |outward| SupportMap::<f64>::support(polytope, outward).point;
    level(ends, towards, polytope.swept_radius(), farthest)
}

/// The same of an edge of a triangle with that radius.
pub(super) fn level_of_triangles_edge(
    corners: &[DVec3; 3],
    ends: [u32; 2],
    towards: DVec3,
    radius: f64,
) -> f64 {
    let farthest = |outward: DVec3| {
        let farther = |p: DVec3, q: DVec3| if outward.dot(q) > outward.dot(p) { q } else { p };
        farther(farther(corners[0], corners[1]), corners[2])
    };
    level(ends.map(|k| corners[k as usize]), towards, radius, farthest)
}

/// By the farthest point of the core along a direction.
#[inline(always)]
fn level(
    [from, to]: [DVec3; 2],
    towards: DVec3,
    radius: f64,
    farthest: impl FnOnce(DVec3) -> DVec3,
) -> f64 {
    if radius == 0.0 {
        // Nothing is moved.
        return 1.0;
    }
    let along = to - from;
    let across = towards - along * (towards.dot(along) / along.length_squared());
    let cosine = across.length();
    // False for NaN, of an edge without length.
    if !(cosine > 0.0) {
        return 0.0;
    }
    let outward = across / cosine;
    let farthest = farthest(outward);
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

    #[test]
    fn an_edge_of_a_triangle_leans_as_that_of_the_polytope_does() {
        let mut draw = Draw(72);
        for k in 0..600 {
            let radius = [0.0, 0.01, 0.3][k % 3];
            let corners = [0; 3].map(|_| draw.vector());
            let triangle = Polytope::mesh_triangle(corners).unwrap().rounded(radius).unwrap();
            let (towards, ends) = (draw.vector().normalize(), [0, 1 + k as u32 % 2]);
            let due = level_of_edge(&triangle, ends, towards);
            let found = level_of_triangles_edge(&corners, ends, towards, radius);
            assert!((found - due).abs() <= 1e-12, "{k}: {found} {due}");
        }
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
