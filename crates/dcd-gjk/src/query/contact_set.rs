//! How many farthest points a shape has in a direction: a vertex, an edge or a face of them.

use crate::PosedShape;
use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, Shape};

/// How far from level a feature may be to be taken for level, relative to the shape's extent: a
/// tilt of a billionth. Larger: smooth points taken for kinks.
const LEVEL: f64 = 1e-9;

/// The farthest points of a core in some direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Extent {
    Point,
    /// Along a unit vector, world frame.
    Segment(DVec3),
    Face,
}

impl Extent {
    /// Along a unit direction in the world, for a half-space its normal. `None` for a shape that is
    /// neither that nor a polytope.
    pub(super) fn of(side: PosedShape<'_>, direction: DVec3) -> Option<Self> {
        let polytope = match side.shape {
            Shape::Polytope(polytope) => polytope,
            Shape::HalfSpace(_) => return Some(Self::Face),
            _ => return None,
        };
        let rotation = side.pose.rotation();
        let local = Self::in_own_frame(polytope, rotation.transpose() * direction);
        Some(match local {
            Self::Segment(along) => Self::Segment((*rotation * along).normalize_or_zero()),
            other => other,
        })
    }

    fn in_own_frame(polytope: &Polytope, direction: DVec3) -> Self {
        let size = 2.0 * polytope.outer_radius();
        let along = |v: DVec3| direction.dot(v);
        let most = polytope.vertices().iter().map(|&v| along(v)).fold(f64::MIN, f64::max);
        let level =
            || polytope.vertices().iter().copied().filter(|&v| along(v) >= most - LEVEL * size);
        let Some(first) = level().next() else { return Self::Point };
        let apart = |v: &DVec3| v.distance(first);
        let Some(second) = level().max_by(|v, w| apart(v).total_cmp(&apart(w))) else {
            return Self::Point;
        };
        let edge = second - first;
        if edge.length() <= LEVEL * size {
            return Self::Point;
        }
        let edge = edge.normalize();
        let off = |v: DVec3| (v - first).cross(edge).length();
        if level().any(|v| off(v) > LEVEL * size) { Self::Face } else { Self::Segment(edge) }
    }

    /// Whether two such sets that meet along their direction meet in one point alone.
    ///
    /// Where a face meets an edge or a face, that they meet in one point would be a coincidence
    /// that a tilt undoes; it is taken for more.
    pub(super) fn meets_in_one_point(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Point, _) | (_, Self::Point) => true,
            (Self::Segment(p), Self::Segment(q)) => p.cross(*q).length() > LEVEL,
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::Pose;

    #[test]
    fn a_cube_has_a_face_an_edge_and_a_vertex() {
        let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
        let of = |d: DVec3| {
            Extent::of(PosedShape { shape: &cube, pose: &Pose::IDENTITY }, d.normalize()).unwrap()
        };
        assert_eq!(of(DVec3::X), Extent::Face);
        assert!(matches!(of(DVec3::new(1.0, 1.0, 0.0)), Extent::Segment(e) if e.z.abs() == 1.0));
        assert_eq!(of(DVec3::ONE), Extent::Point);
        assert_eq!(of(DVec3::new(1.0, 1e-6, 1e-6)), Extent::Point);
    }

    #[test]
    fn crossing_edges_meet_in_a_point_and_parallel_ones_in_more() {
        let (x, y) = (Extent::Segment(DVec3::X), Extent::Segment(DVec3::Y));
        assert!(x.meets_in_one_point(&y) && !x.meets_in_one_point(&x));
        assert!(Extent::Face.meets_in_one_point(&Extent::Point));
        assert!(!Extent::Face.meets_in_one_point(&x));
    }
}
