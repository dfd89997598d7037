//! The convex hull of a point cloud, if it has a volume worth the name.

use crate::CloudKind;
use dcd_geom::{ConvexHull, Dimension, HullError};
use glam::DVec3;
use std::fmt;

/// A hull: the shape is by definition the hull of these vertices.
#[derive(Clone, Debug, PartialEq)]
pub struct Hull {
    /// The cloud's points that are not in the hull of the others, each once, bit for bit and in the
    /// cloud's order.
    pub vertices: Vec<DVec3>,
    /// The surface, closed, counter-clockwise seen from outside, by index into `vertices`.
    pub triangles: Vec<[u32; 3]>,
}

/// Why a cloud has no hull here and stays a point set, which is a legal shape.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum HullRefusal {
    /// It is empty, or holds NaN or infinity.
    Invalid,
    /// It has no volume, or next to none.
    NotSolid(CloudKind),
    /// It has more points than a u32 counts, or numbers too far apart.
    Refused(HullError),
}

impl fmt::Display for HullRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Invalid => write!(f, "the cloud is empty or not finite"),
            Self::NotSolid(kind) => write!(f, "the cloud has no volume: {kind:?}"),
            Self::Refused(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for HullRefusal {}

/// The convex hull of a cloud, its inner points dropped. Exact: see [`ConvexHull`].
///
/// # Errors
/// A cloud without volume as [`CloudKind`] defines it, or one that [`ConvexHull::of`] refuses.
pub fn convex_hull(points: &[DVec3]) -> Result<Hull, HullRefusal> {
    match CloudKind::of(points) {
        None => return Err(HullRefusal::Invalid),
        Some(CloudKind::Solid) => {}
        Some(kind) => return Err(HullRefusal::NotSolid(kind)),
    }
    let hull = ConvexHull::of(points).map_err(HullRefusal::Refused)?;
    // The kind is rounded, so that it may take the noise of points far from the origin for more.
    match hull.dimension() {
        Dimension::Point => return Err(HullRefusal::NotSolid(CloudKind::Point)),
        Dimension::Line => return Err(HullRefusal::NotSolid(CloudKind::Needle)),
        Dimension::Plane => return Err(HullRefusal::NotSolid(CloudKind::Flat)),
        Dimension::Solid => {}
    }
    let vertices = hull.corners().iter().map(|&k| points[k as usize]).collect();
    Ok(Hull { vertices, triangles: hull.triangles().to_vec() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(n: u32) -> Vec<DVec3> {
        (0..n * n * n)
            .map(|k| DVec3::new((k % n).into(), (k / n % n).into(), (k / n / n).into()))
            .collect()
    }

    #[test]
    fn a_cube_with_points_inside_keeps_its_corners_in_order() {
        let mut cloud = grid(2);
        cloud.insert(3, DVec3::splat(0.5));
        cloud.push(cloud[2]);
        let hull = convex_hull(&cloud).unwrap();
        assert_eq!(hull.vertices, grid(2));
        assert_eq!(hull.triangles.len(), 12);
    }

    #[test]
    fn the_surface_looks_outward() {
        let cloud = grid(2);
        let hull = convex_hull(&cloud).unwrap();
        let volume: f64 = hull
            .triangles
            .iter()
            .map(|t| t.map(|k| hull.vertices[k as usize]))
            .map(|[a, b, c]| a.dot(b.cross(c)) / 6.0)
            .sum();
        assert!((volume - 1.0).abs() < 1e-15);
    }

    #[test]
    fn clouds_without_volume_are_refused_with_their_kind() {
        let flat: Vec<_> = grid(3).into_iter().map(|p| p * DVec3::new(1.0, 1.0, 0.0)).collect();
        let needle: Vec<_> = (0..7).map(|k| DVec3::new(0.3, 0.1, -0.7) * f64::from(k)).collect();
        for (cloud, kind) in [
            (flat, CloudKind::Flat),
            (needle, CloudKind::Needle),
            (vec![DVec3::ONE; 9], CloudKind::Point),
        ] {
            assert_eq!(convex_hull(&cloud), Err(HullRefusal::NotSolid(kind)));
        }
    }

    #[test]
    fn invalid_clouds_are_refused() {
        assert_eq!(convex_hull(&[]), Err(HullRefusal::Invalid));
        assert_eq!(convex_hull(&[DVec3::NAN; 5]), Err(HullRefusal::Invalid));
    }

    #[test]
    fn huge_and_tiny_clouds_and_those_of_many_points_have_their_hulls() {
        for scale in [5e-324, 1e-300, 1e-100, 1e100, 8e307] {
            let cloud: Vec<_> = grid(3).into_iter().map(|p| p * scale).collect();
            let corners: Vec<_> = grid(2).into_iter().map(|p| p * 2.0 * scale).collect();
            assert_eq!(convex_hull(&cloud).unwrap().vertices, corners, "{scale:e}");
        }
        assert_eq!(convex_hull(&grid(40)).unwrap().vertices.len(), 8);
    }

    #[test]
    fn numbers_too_far_apart_to_be_exact_are_refused() {
        let mut cloud = grid(2);
        cloud[0].x = 1e-250;
        assert_eq!(convex_hull(&cloud), Err(HullRefusal::Refused(HullError::TooWide)));
    }

    #[test]
    fn a_slab_keeps_both_its_sides_however_thin() {
        for thickness in [1e-2, 1e-3, 1e-4, 1e-5] {
            let flatten = DVec3::new(1.0, 1.0, thickness);
            let cloud: Vec<_> = grid(2).into_iter().map(|p| p * flatten).collect();
            assert_eq!(convex_hull(&cloud).unwrap().vertices, cloud, "{thickness:e}");
        }
    }
}
