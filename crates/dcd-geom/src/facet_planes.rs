//! The planes of a polytope's faces, with what is proved of them: what a line is clipped against.

use crate::{FLATNESS, Polytope};
use dcd_simd::{Row, WIDTH, prefetch_few};
use glam::DVec3;
use std::collections::BTreeMap;

/// Half-spaces round a polytope's core, and half-spaces whose common points are inside it; the swept radius is not
/// counted. In the shape's own frame.
///
/// Outer plane k is n·x ≤ `outer[k]`, which every vertex satisfies with rounding. The inner planes n·x < `inner[k]`
/// hold for a point only if it is inside the core, where [`FacetPlanes::has_inside`] says so: each face lies
/// wholly beyond its inner plane, so that a segment from the centre of the inscribed sphere to a point before all
/// of them crosses no face; the faces are a closed surface all of which sees that centre on its inner side, and a
/// point with the centre's winding number is in the hull (docs/numerics/proofs.md, "inner spheres").
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FacetPlanes {
    /// The normals, component by component, of unit length but for rounding.
    pub normals: [Vec<f64>; 3],
    /// The offsets of planes outside of which nothing of the core is, metres.
    pub outer: Vec<f64>,
    /// The offsets of planes that no face crosses, metres.
    pub inner: Vec<f64>,
    has_inside: bool,
    rows: Vec<PlaneRow>,
    largest: f64,
    thickest: f64,
}

/// Sixteen planes in f32: normals and outer offsets, each rounded. The last row is filled up with the last plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlaneRow {
    /// x, y and z of the normals.
    pub normals: [Row; 3],
    /// The outer offsets, metres.
    pub outer: Row,
}

/// What a product of a unit normal and a vertex loses: three products and two sums, and a margin. Unit: 2⁻⁵³ of the
/// largest length of a vertex.
const PRODUCT: f64 = 8.0;

/// How far the square of a normal's length may be from 1: far above rounding. Larger: heights over planes that are not theirs.
const UNIT_LENGTH: f64 = 1e-14;

impl FacetPlanes {
    pub(crate) fn of(polytope: &Polytope) -> Self {
        let facets = polytope.facets();
        let (vertices, centre) = (polytope.vertices(), polytope.inner().centre);
        let slack = PRODUCT * (f64::EPSILON / 2.0) * polytope.reach();
        let mut planes = Self { has_inside: polytope.inner().radius > 0.0, ..Self::default() };
        let extent = polytope.outer_radius() * 2.0;
        let mut edges: BTreeMap<(u32, u32), i32> = BTreeMap::new();
        for facet in facets.facets() {
            let normal = facet.normal;
            // One of a face so small that squares underflow is none.
            if !((normal.length_squared() - 1.0).abs() < UNIT_LENGTH) {
                planes.has_inside = false;
                continue;
            }
            let corners = facets.corners(facet);
            let largest = vertices.iter().map(|v| normal.dot(*v)).fold(f64::NEG_INFINITY, f64::max);
            // Whatever was merged into the face, or dropped from its edges, lies within its flatness.
            let near = largest - 4.0 * FLATNESS * extent;
            let level = |v: &DVec3| Some(normal.dot(*v)).filter(|&along| along >= near);
            let corners_least = corners
                .iter()
                .map(|&k| normal.dot(vertices[k as usize]))
                .fold(f64::INFINITY, f64::min);
            let least = vertices.iter().filter_map(level).fold(corners_least, f64::min) - slack;
            for (axis, list) in planes.normals.iter_mut().enumerate() {
                list.push(normal[axis]);
            }
            planes.outer.push(largest + slack);
            planes.inner.push(least);
            planes.has_inside &= normal.dot(centre) + slack < least && corners.len() >= 3;
            for (k, &from) in corners.iter().enumerate() {
                let to = corners[(k + 1) % corners.len()];
                let (key, sign) = if from < to { ((from, to), 1) } else { ((to, from), -1) };
                *edges.entry(key).or_default() += sign;
            }
        }
        planes.has_inside &= !planes.outer.is_empty() && edges.values().all(|&sum| sum == 0);
        let largest = |most: f64, x: f64| most.max(x);
        planes.largest = planes.outer.iter().map(|x| x.abs()).fold(0.0, largest);
        let thickness = planes.outer.iter().zip(&planes.inner).map(|(outer, inner)| outer - inner);
        planes.thickest = thickness.fold(0.0, largest);
        planes.rows = (0..planes.len()).step_by(WIDTH).map(|first| planes.row(first)).collect();
        planes
    }

    /// The planes from that one on.
    fn row(&self, first: usize) -> PlaneRow {
        let mut row = PlaneRow::default();
        for lane in 0..WIDTH {
            let k = (first + lane).min(self.len() - 1);
            for (row, normals) in row.normals.iter_mut().zip(&self.normals) {
                row.0[lane] = normals[k] as f32;
            }
            row.outer.0[lane] = self.outer[k] as f32;
        }
        row
    }

    /// Prefetches all that is in f64: as many cache lines as hulls of some twenty vertices have.
    #[inline]
    pub(crate) fn prefetch(&self) {
        for numbers in self.normals.iter().chain([&self.outer, &self.inner]) {
            prefetch_few::<5, _>(numbers);
        }
    }

    /// The planes for lanes, sixteen a row.
    pub fn rows(&self) -> &[PlaneRow] {
        &self.rows
    }

    /// The largest outer offset in size, metres.
    pub fn largest_offset(&self) -> f64 {
        self.largest
    }

    /// The largest difference of a plane's outer and inner offset, metres.
    pub fn thickness(&self) -> f64 {
        self.thickest
    }

    /// How many planes there are.
    pub fn len(&self) -> usize {
        self.outer.len()
    }

    /// Whether there is none: of a segment or a point.
    pub fn is_empty(&self) -> bool {
        self.outer.is_empty()
    }

    /// Whether what is before all inner planes is proved to be inside the core.
    pub fn has_inside(&self) -> bool {
        self.has_inside
    }

    /// The normal of plane k, which must be below [`FacetPlanes::len`].
    pub fn normal(&self, k: usize) -> DVec3 {
        let [x, y, z] = &self.normals;
        DVec3::new(x[k], y[k], z[k])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sphere_points(count: u32) -> Vec<DVec3> {
        (0..count)
            .map(|k| {
                // A spiral of equal steps in height.
                let z = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(count);
                let (r, angle) = ((1.0 - z * z).sqrt(), f64::from(k) * 2.399963);
                DVec3::new(r * angle.cos(), r * angle.sin(), z)
            })
            .collect()
    }

    #[test]
    fn normals_are_of_unit_length_or_left_out() {
        for exponent in -150..=70 {
            let size = 10f64.powi(exponent);
            let corner = |k: u32| DVec3::new(1.0, 0.7, 0.3) * size * sign(k);
            let hull = Polytope::hull((0..8).map(corner).collect()).unwrap();
            let planes = hull.planes();
            let normals = (0..planes.len()).map(|k| planes.normal(k));
            assert!(normals.clone().all(|n| (n.length() - 1.0).abs() < 1e-12), "{size:e}");
            assert!(planes.len() == 6 || exponent < -70, "{size:e}: {}", planes.len());
        }
    }

    fn sign(k: u32) -> DVec3 {
        DVec3::from_array([0, 1, 2].map(|axis| if k >> axis & 1 == 0 { -1.0 } else { 1.0 }))
    }

    #[test]
    fn planes_of_a_solid_hold_its_vertices_and_leave_its_inside() {
        for (count, scale) in [(4, 1.0), (20, 1e-6), (60, 1e6), (200, 1.0)] {
            let points: Vec<_> = sphere_points(count).into_iter().map(|p| p * scale).collect();
            let hull = Polytope::hull(points.clone()).unwrap();
            let planes = hull.planes();
            assert!(planes.has_inside() && planes.len() >= 4, "{count}");
            for k in 0..planes.len() {
                let along = |p: &DVec3| planes.normal(k).dot(*p);
                assert!(points.iter().all(|p| along(p) <= planes.outer[k]));
                assert!(planes.outer[k] - planes.inner[k] <= 1e-13 * scale);
                assert!(planes.normal(k).dot(hull.inner().centre) < planes.inner[k]);
            }
        }
    }

    #[test]
    fn what_is_flat_has_no_inside() {
        let square = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X + DVec3::Y];
        let planes = Polytope::hull(square).unwrap().planes().clone();
        assert!(planes.len() == 2 && !planes.has_inside());
        let point = Polytope::sphere(1.0).unwrap();
        assert!(point.planes().is_empty() && !point.planes().has_inside());
    }

    #[test]
    fn a_box_with_points_in_its_faces_has_six_planes_and_an_inside() {
        let mut points = Polytope::cuboid(DVec3::new(1.0, 2.0, 3.0)).unwrap().vertices().to_vec();
        points.push(DVec3::new(1.0, 0.3, 0.4));
        points.push(DVec3::new(0.2, 2.0, 3.0));
        let hull = Polytope::hull(points).unwrap();
        assert!(hull.planes().len() == 6 && hull.planes().has_inside());
    }
}
