//! Hulls of point clouds, whose library is not ours.

use crate::Input;
use dcd_geom::Polytope;
use dcd_scenes::convex_hull;

/// A hull keeps points of its cloud, and is a legal shape; whatever the library does, nothing
/// panics past the reader.
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
    assert!(Polytope::hull(hull.vertices).is_ok());
}
