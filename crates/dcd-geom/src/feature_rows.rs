//! The faces and edges of a solid polytope as one closed surface, sixteen a row: what a triangle's separating axes are
//! made of.

use crate::{Kind, Polytope};
use dcd_simd::{Block, Row, WIDTH};
use glam::DVec3;
use std::collections::BTreeMap;

/// The most vertices of a polytope that has rows: a set of them is one u64. Larger: faces and edges that take longer
/// than a search.
const MOST: usize = 64;

/// Twice a face's area by the square of its longest edge below which its normal is rounding.
const NEEDLE: f64 = 1e-5;

/// How much a unit normal loses: two edges, their product, its length. Unit: 2⁻⁵³ of the square of the longest edge by
/// twice the area.
const TILT: f64 = 16.0;

/// The faces and edges of a polytope's core, in its own frame. The faces are flat polygons, each by itself, and together
/// an oriented closed surface: each edge is one of two faces, and leads once along it and once back. No claim is made
/// that the surface is convex.
#[derive(Clone, Debug)]
pub struct FeatureRows {
    /// Sixteen a row.
    pub faces: Vec<FaceRow>,
    /// Sixteen a row.
    pub edges: Vec<EdgeRow>,
    /// The corners and outward unit normals of the faces.
    outlines: Vec<(DVec3, Vec<u32>)>,
    /// The ends of the edges, by index into the vertices.
    ends: Vec<[u32; 2]>,
    tilt: f64,
}

/// Sixteen faces in f32, each number rounded. What fills the last row up is infinitely far.
#[derive(Clone, Copy, Debug, Default)]
pub struct FaceRow {
    /// Outward, of unit length.
    pub normals: Block,
    /// How far they are from the [centre](Polytope::inner), metres.
    pub offsets: Row,
}

/// Sixteen edges in f32, each number rounded. What fills the last row up has no length and two equal normals.
#[derive(Clone, Copy, Debug, Default)]
pub struct EdgeRow {
    /// Where they begin, from the [centre](Polytope::inner), metres.
    pub from: Block,
    /// From there to the other end.
    pub along: Block,
    /// At least how long they are.
    pub lengths: Row,
    /// The normals of the faces that they lead along, as [`FaceRow`] has them.
    pub left: Block,
    /// The same of those on the other side, along which they lead back.
    pub right: Block,
}

impl FeatureRows {
    /// `None` of what is no solid, has very many vertices, or faces too thin to have a normal.
    pub(crate) fn of(polytope: &Polytope) -> Option<Self> {
        let is_solid = polytope.inner().radius > 0.0;
        let has_kind = matches!(polytope.kind(), Kind::Hull | Kind::Cuboid { .. });
        if !is_solid || !has_kind || polytope.vertices().len() > MOST {
            return None;
        }
        let mut rows =
            Self { faces: vec![], edges: vec![], outlines: vec![], ends: vec![], tilt: 0.0 };
        let facets = polytope.facets();
        for facet in facets.facets() {
            rows.add_outlines(polytope.vertices(), facets.corners(facet))?;
        }
        let sides = rows.pair_edges()?;
        let centre = polytope.inner().centre;
        rows.faces = rows.outlines.chunks(WIDTH).map(|all| face_row(all, polytope)).collect();
        let edge = |(&[from, to], &[left, right]): (&[u32; 2], &[usize; 2])| Edge {
            from: polytope.vertices()[from as usize] - centre,
            along: polytope.vertices()[to as usize] - polytope.vertices()[from as usize],
            normals: [rows.outlines[left].0, rows.outlines[right].0],
        };
        let edges: Vec<Edge> = rows.ends.iter().zip(&sides).map(edge).collect();
        rows.edges = edges.chunks(WIDTH).map(edge_row).collect();
        Some(rows)
    }

    /// A face as it is if it is flat to the last bit, else as its triangles.
    fn add_outlines(&mut self, vertices: &[DVec3], corners: &[u32]) -> Option<()> {
        let (&first, others) = corners.split_first()?;
        let mut triangles = Vec::with_capacity(others.len());
        for pair in others.windows(2) {
            let corners = vec![first, pair[0], pair[1]];
            let (normal, tilt) = normal_of([0, 1, 2].map(|k| vertices[corners[k] as usize]))?;
            self.tilt = self.tilt.max(tilt);
            triangles.push((normal, corners));
        }
        let (normal, _) = *triangles.first().as_ref()?;
        if triangles.iter().all(|(other, _)| other == normal) {
            self.outlines.push((*normal, corners.to_vec()));
        } else {
            self.outlines.append(&mut triangles);
        }
        Some(())
    }

    /// Lists the edges, and returns the faces on both sides of each; `None` where the faces are no closed surface.
    fn pair_edges(&mut self) -> Option<Vec<[usize; 2]>> {
        let mut led: BTreeMap<[u32; 2], usize> = BTreeMap::new();
        for (face, (_, corners)) in self.outlines.iter().enumerate() {
            let mut from = *corners.last()?;
            for &to in corners {
                if led.insert([from, to], face).is_some() {
                    return None;
                }
                from = to;
            }
        }
        let mut sides = Vec::with_capacity(led.len() / 2);
        for (&[from, to], &left) in &led {
            let right = *led.get(&[to, from])?;
            if from < to {
                self.ends.push([from, to]);
                sides.push([left, right]);
            }
        }
        Some(sides)
    }

    /// The outward unit normal of a face, and its corners by index into the vertices, counter-clockwise seen from
    /// outside; `None` past the last.
    #[inline]
    pub fn face_polygon(&self, face: usize) -> Option<(DVec3, &[u32])> {
        self.outlines.get(face).map(|(normal, corners)| (*normal, &corners[..]))
    }

    /// Where an edge begins and ends, by index into the vertices; `None` past the last.
    #[inline]
    pub fn edge_vertices(&self, edge: usize) -> Option<[u32; 2]> {
        self.ends.get(edge).copied()
    }

    /// At least how much the faces' normals are off, radians.
    #[inline]
    pub fn normal_error(&self) -> f64 {
        self.tilt
    }
}

/// The unit normal of a triangle, and at least how much it is off; `None` of a needle.
fn normal_of([p, q, r]: [DVec3; 3]) -> Option<(DVec3, f64)> {
    let normal = (q - p).cross(r - p);
    let longest = (q - p).length_squared().max((r - p).length_squared());
    let longest = longest.max((r - q).length_squared());
    let area = normal.length();
    // Written so that NaN is a needle.
    if !(area > NEEDLE * longest && longest > 0.0) {
        return None;
    }
    Some((normal / area, TILT * (f64::EPSILON / 2.0) * longest / area))
}

fn face_row(faces: &[(DVec3, Vec<u32>)], polytope: &Polytope) -> FaceRow {
    let mut row = FaceRow { offsets: Row([f32::INFINITY; WIDTH]), ..FaceRow::default() };
    for (lane, (normal, corners)) in faces.iter().enumerate() {
        set(&mut row.normals, lane, *normal);
        let corner = polytope.vertices()[corners[0] as usize] - polytope.inner().centre;
        row.offsets.0[lane] = normal.dot(corner) as f32;
    }
    row
}

/// An edge from the centre, and the normals to its left and right.
struct Edge {
    from: DVec3,
    along: DVec3,
    normals: [DVec3; 2],
}

fn edge_row(edges: &[Edge]) -> EdgeRow {
    let mut row = EdgeRow::default();
    for (lane, &Edge { from, along, normals }) in edges.iter().enumerate() {
        set(&mut row.from, lane, from);
        set(&mut row.along, lane, along);
        row.lengths.0[lane] = (along.length() as f32).next_up();
        set(&mut row.left, lane, normals[0]);
        set(&mut row.right, lane, normals[1]);
    }
    row
}

fn set(block: &mut Block, lane: usize, vector: DVec3) {
    for (row, x) in block.0.iter_mut().zip(vector.as_vec3().to_array()) {
        row.0[lane] = x;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(count: u32) -> Vec<DVec3> {
        let point = |k: u32| {
            let z = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(count);
            let (r, angle) = ((1.0 - z * z).sqrt(), f64::from(k) * 2.399963);
            DVec3::new(r * angle.cos(), r * angle.sin(), z)
        };
        (0..count).map(point).collect()
    }

    #[test]
    fn a_cuboid_keeps_its_six_sides_and_a_solid_obeys_euler() {
        let cuboid = Polytope::cuboid(DVec3::new(0.3, 0.2, 0.15)).unwrap();
        let rows = cuboid.feature_rows().unwrap();
        assert_eq!((rows.outlines.len(), rows.ends.len()), (6, 12));
        for count in [4, 15, 64] {
            let hull = Polytope::hull(points(count)).unwrap();
            let rows = hull.feature_rows().unwrap();
            assert_eq!(count as usize + rows.outlines.len(), rows.ends.len() + 2, "{count}");
            assert!(rows.normal_error() < 1e-12);
            for (k, &[from, to]) in rows.ends.iter().enumerate() {
                let row = &rows.edges[k / WIDTH];
                let normals = [&row.left, &row.right].map(|block| block.point(k % WIDTH));
                let along = hull.vertices()[to as usize] - hull.vertices()[from as usize];
                // Convex: the way across the edge turns to the right of it.
                let turn = normals[0].cross(normals[1]).as_dvec3();
                assert!(turn.dot(along) > 0.0, "{count}: {k}");
            }
        }
    }

    #[test]
    fn what_is_flat_or_large_has_no_rows() {
        let square = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X + DVec3::Y];
        assert!(Polytope::hull(square).unwrap().feature_rows().is_none());
        assert!(Polytope::hull(points(65)).unwrap().feature_rows().is_none());
        assert!(Polytope::sphere(1.0).unwrap().feature_rows().is_none());
    }
}
