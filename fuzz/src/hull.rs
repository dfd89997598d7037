//! Hulls of point clouds.

use crate::Input;
use dcd_geom::Polytope;
use dcd_io::convex_hull;

/// A hull keeps points of its cloud, is closed, and is a legal shape; nothing panics.
pub fn hull(bytes: &[u8]) {
    let mut input = Input(bytes);
    let mut cloud = Vec::new();
    while let Some(point) = input.vector() {
        cloud.push(point);
    }
    let Ok(hull) = convex_hull(&cloud) else { return };
    assert!(hull.vertices.iter().all(|vertex| cloud.contains(vertex)));
    let corners = hull.vertices.len();
    assert!(hull.triangles.iter().flatten().all(|&k| (k as usize) < corners));
    assert_eq!(hull.triangles.len() + 4, 2 * corners);
    assert!(Polytope::hull(hull.vertices).is_ok());
}
