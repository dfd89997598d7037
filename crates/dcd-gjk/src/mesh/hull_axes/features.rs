//! The vertices, edges and faces of a solid hull, from its centre.

use dcd_geom::glam::DVec3;
use dcd_geom::{FeatureRows, Polytope};

/// A hull that has rows.
#[derive(Clone, Copy)]
pub(super) struct HullFeatures<'a> {
    pub(super) hull: &'a Polytope,
    pub(super) rows: &'a FeatureRows,
}

impl<'a> HullFeatures<'a> {
    /// `None` of what is not solid, or has many vertices.
    pub(super) fn of(hull: &'a Polytope) -> Option<Self> {
        Some(Self { hull, rows: hull.feature_rows()? })
    }

    pub(super) fn vertex(&self, k: usize) -> DVec3 {
        self.hull.vertices()[k] - self.hull.inner().centre
    }

    /// Where an edge begins, and what leads to its end.
    pub(super) fn edge(&self, edge: usize) -> Option<[DVec3; 2]> {
        let [from, to] = self.rows.edge_vertices(edge)?.map(|end| end as usize);
        // Not from the centre: a short edge would lose more than u of its length.
        Some([self.vertex(from), self.hull.vertices()[to] - self.hull.vertices()[from]])
    }

    /// How far it reaches along a direction.
    pub(super) fn reach(&self, direction: DVec3) -> f64 {
        let mut most = f64::NEG_INFINITY;
        for vertex in self.hull.vertices() {
            let along = direction.dot(*vertex);
            most = if along > most { along } else { most };
        }
        most - direction.dot(self.hull.inner().centre)
    }

    /// Whether a point of the plane of a face with those corners is in it.
    pub(super) fn is_in_face(&self, corners: &[u32], normal: DVec3, at: DVec3) -> bool {
        let Some(&last) = corners.last() else { return false };
        let mut from = self.vertex(last as usize);
        corners.iter().all(|&corner| {
            let to = self.vertex(corner as usize);
            let right = (to - from).cross(normal).dot(at - from);
            from = to;
            right <= 0.0
        })
    }
}

/// Which shares of two vectors, from where they begin, lead to where the lines along them are nearest to each other.
pub(super) fn shares([from, along, on, across]: [DVec3; 4]) -> [f64; 2] {
    let product = along.cross(across);
    let (square, vector) = (product.length_squared(), from - on);
    [-vector.cross(across).dot(product) / square, -vector.cross(along).dot(product) / square]
}
