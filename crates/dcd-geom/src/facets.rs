//! The faces of a hull, coplanar triangles merged.

mod lattice;
mod ring;

use crate::hull::Triangle;
use dcd_simd::{prefetch_few, prefetch_lines};
use glam::DVec3;

/// How far a vertex may be from a face's plane to be a corner of it, relative to the largest
/// extent. Well above the lattice of 2⁻³⁸ on which the hull is found and the rounding of
/// coordinates, well below what a contact shows. Larger: faces that are not flat. Smaller: faces
/// left in triangles.
pub const FLATNESS: f64 = 1e-9;

/// The same for the faces that contacts show: what rounding to f32, or to six decimals, leaves of a flat face. Relative to the
/// largest extent. Larger: contacts that do not see what is bent so little, and wider bounds. Smaller: boxes of rounded corners that stand on
/// triangles.
const LEVELLED: f64 = 1e-5;

/// The least cosine between the normals of a contact face and of a triangle in it: what lies between flat triangles of a hull looks their
/// way. Larger: steps of a bent face that stay. Smaller: plates thinner than [`LEVELLED`] that lose their sides.
const ALIKE: f64 = 0.9;

/// The height of a triangle by its longest edge below which the search for hulls looks at it: it may be a segment.
const NEEDLE: f64 = 1e-5;

/// A squared length, square metres, below which squares of it could underflow.
const SHORTEST: f64 = 1e-140;

/// The faces of a polytope's core: convex polygons of its vertices. Faces that lie in one plane,
/// to within [`FLATNESS`] of the largest extent, are one.
///
/// A core that is flat has two faces, one for each side. One that is a segment or a point has one
/// "face" of two corners or one, whose normal is zero, so that its edge or vertex is found as well.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Facets {
    facets: Vec<Facet>,
    corners: Vec<u32>,
    /// The half-edges that leave each vertex, one vertex after the other.
    around: Vec<HalfEdge>,
    /// For each vertex where its half-edges end in `around`; they begin where the last vertex's end.
    ends: Vec<u32>,
    unevenness: f64,
}

/// A face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// Outward, of unit length, in the shape's own frame; zero for a segment and a point.
    pub normal: DVec3,
    first: u32,
    count: u32,
}

/// An edge as it leaves a vertex along one face: what a vertex shows of its surroundings, in memory of its own.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HalfEdge {
    /// Of the face: zero for one of fewer than three corners.
    pub normal: DVec3,
    /// The face, by index.
    pub face: u32,
    /// The face's corner behind the vertex, by index into the vertices.
    pub to: u32,
    /// Where the face's corners are: what is round a vertex is read without the faces.
    first: u32,
    count: u32,
}

/// The unit normal of a triangle that is no needle.
#[inline]
pub(crate) fn normal_of_triangle([a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    let normal = (b - a).cross(c - a);
    let longest = (b - a).length_squared().max((c - a).length_squared());
    let longest = longest.max((c - b).length_squared());
    // Twice the area by the longest edge is the height. False for NaN, and where squares overflow.
    let is_wide = normal.length() > NEEDLE * longest && longest > SHORTEST;
    (is_wide && longest < 1.0 / SHORTEST).then(|| normal.normalize())
}

/// The faces of a polytope, and those that contacts show.
#[derive(Clone, Debug)]
pub(crate) struct AllFacets {
    /// By value: read far more often.
    pub(crate) contact: Facets,
    /// Where they are others.
    exact: Option<Box<Facets>>,
}

impl AllFacets {
    /// Of the hull of the points.
    pub(crate) fn of_hull(vertices: &[DVec3]) -> Self {
        match Facets::with_levelled(vertices, true) {
            (exact, Some(contact)) => Self { contact, exact: Some(Box::new(exact)) },
            (exact, None) => Self::alike(exact),
        }
    }

    /// All of which contacts show.
    pub(crate) fn alike(facets: Facets) -> Self {
        Self { contact: facets, exact: None }
    }

    /// Those that are flat.
    #[inline]
    pub(crate) fn exact(&self) -> &Facets {
        self.exact.as_deref().unwrap_or(&self.contact)
    }
}

impl Facets {
    /// The faces of the hull of the points. Costs a microsecond a point; the same for the same points
    /// everywhere.
    pub fn of(vertices: &[DVec3]) -> Self {
        Self::with_levelled(vertices, false).0
    }

    /// The faces, and those of the same hull with what is hardly bent made level, where these are others and `levels` says so.
    fn with_levelled(vertices: &[DVec3], levels: bool) -> (Self, Option<Self>) {
        let mut facets = Self::default();
        let mut levelled = None;
        match lattice::hull(vertices) {
            lattice::Hull::Solid(triangles) => {
                facets.merge(vertices, &triangles, (FLATNESS, 0.0));
                levelled = levels.then(|| Self::levelled(vertices, &triangles));
            }
            lattice::Hull::Flat { normal } => {
                let all: Vec<u32> = (0..vertices.len() as u32).collect();
                let corners = ring::corners(vertices, &all, normal);
                let backwards: Vec<u32> = corners.iter().rev().copied().collect();
                facets.push(normal, &corners);
                facets.push(-normal, &backwards);
            }
            lattice::Hull::Segment(ends) => facets.push(DVec3::ZERO, &ends),
            lattice::Hull::Point(only) => facets.push(DVec3::ZERO, &[only]),
        }
        facets.link(vertices.len());
        levelled = levelled.filter(|levelled| levelled.facets.len() < facets.facets.len());
        (facets, levelled)
    }

    fn levelled(vertices: &[DVec3], triangles: &[Triangle]) -> Self {
        let mut levelled = Self::default();
        levelled.unevenness = levelled.merge(vertices, triangles, (LEVELLED, ALIKE));
        levelled.link(vertices.len());
        levelled
    }

    /// Of a triangle: without a search, if it is no needle.
    pub(crate) fn of_triangle(corners: [DVec3; 3]) -> Self {
        match normal_of_triangle(corners) {
            Some(normal) => Self::of_polygon(3, normal),
            None => Self::of(&corners),
        }
    }

    /// Of a convex polygon of so many corners, in their order round the normal; of a segment or a point.
    pub(crate) fn of_polygon(count: usize, normal: DVec3) -> Self {
        let mut facets = Self::default();
        let corners: Vec<u32> = (0..count as u32).collect();
        if count < 3 {
            facets.push(DVec3::ZERO, &corners);
        } else {
            let backwards: Vec<u32> = corners.iter().rev().copied().collect();
            facets.push(normal, &corners);
            facets.push(-normal, &backwards);
        }
        facets.link(count);
        facets
    }

    /// How far a vertex that was merged into a face may be from its plane, metres: of [`Polytope::contact_facets`](crate::Polytope::contact_facets)
    /// that are others than the faces; 0 where only [`FLATNESS`] is lost.
    pub fn unevenness(&self) -> f64 {
        self.unevenness
    }

    /// The faces, the largest triangles' first.
    pub fn facets(&self) -> &[Facet] {
        &self.facets
    }

    /// The corners of a face by index into the vertices, counter-clockwise seen from outside.
    #[inline]
    pub fn corners(&self, facet: &Facet) -> &[u32] {
        &self.corners[facet.first as usize..][..facet.count as usize]
    }

    /// The corners of a half-edge's face, as [`Facets::corners`] has them.
    #[inline]
    pub fn face_corners(&self, half_edge: &HalfEdge) -> &[u32] {
        &self.corners[half_edge.first as usize..][..half_edge.count as usize]
    }

    /// The half-edges that leave a vertex, in the order of their faces: none of a vertex that is no corner.
    #[inline]
    pub fn half_edges_from(&self, vertex: u32) -> &[HalfEdge] {
        let vertex = vertex as usize;
        let first = if vertex == 0 { 0 } else { self.ends[vertex - 1] };
        &self.around[first as usize..self.ends[vertex] as usize]
    }

    /// Prefetches all but the half-edges, of which mostly those of one vertex are read, and the faces of hulls, which these
    /// stand for: a hint. As many cache lines as hulls of some twenty vertices have.
    #[inline]
    pub(crate) fn prefetch(&self) {
        prefetch_lines::<3, _>(&self.facets);
        prefetch_few::<2, _>(&self.ends);
        prefetch_few::<6, _>(&self.corners);
    }

    /// Prefetches the half-edges that leave a vertex: a hint.
    #[inline]
    pub(crate) fn prefetch_half_edges(&self, vertex: u32) {
        prefetch_few::<4, _>(self.half_edges_from(vertex));
    }

    /// Lists the half-edges of each of so many vertices.
    fn link(&mut self, vertices: usize) {
        let mut ends = vec![0; vertices];
        for &corner in &self.corners {
            ends[corner as usize] += 1;
        }
        let mut total = 0;
        for end in &mut ends {
            // Where its half-edges begin; each that is listed moves it on, so that at last it is their end.
            total += std::mem::replace(end, total);
        }
        self.around.resize(self.corners.len(), HalfEdge::default());
        for (face, facet) in (0u32..).zip(&self.facets) {
            let corners = &self.corners[facet.first as usize..][..facet.count as usize];
            let normal = if corners.len() > 2 { facet.normal } else { DVec3::ZERO };
            for (k, &corner) in corners.iter().enumerate() {
                let to = *corners.get(k + 1).unwrap_or(&corners[0]);
                let next = &mut ends[corner as usize];
                let Facet { first, count, .. } = *facet;
                self.around[*next as usize] = HalfEdge { normal, face, to, first, count };
                *next += 1;
            }
        }
        self.ends = ends;
    }

    fn push(&mut self, normal: DVec3, corners: &[u32]) {
        let (first, count) = (self.corners.len() as u32, corners.len() as u32);
        self.corners.extend(corners);
        self.facets.push(Facet { normal, first, count });
    }

    /// Each face grows from the largest triangle that is left, over edges, as long as the
    /// corners stay in its plane, to within that part of the extent, and the normals within that cosine. Returns how far the farthest
    /// corner is from the plane, metres.
    fn merge(
        &mut self,
        vertices: &[DVec3],
        triangles: &[Triangle],
        (flatness, cosine): (f64, f64),
    ) -> f64 {
        let mut most = 0.0f64;
        let extent = vertices.iter().fold(0.0f64, |most, v| most.max(v.distance(vertices[0])));
        let weighted: Vec<DVec3> = triangles.iter().map(|t| weighted_normal(t, vertices)).collect();
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        let area = |t: u32| weighted[t as usize].length_squared();
        order.sort_by(|&s, &t| area(t).total_cmp(&area(s)).then(s.cmp(&t)));
        let mut taken = vec![false; triangles.len()];
        let (mut stack, mut members) = (Vec::new(), Vec::new());
        for seed in order {
            let normal = weighted[seed as usize].normalize_or_zero();
            if taken[seed as usize] || normal == DVec3::ZERO {
                continue;
            }
            let base = vertices[triangles[seed as usize].corners[0] as usize];
            let off = |corner: u32| (vertices[corner as usize] - base).dot(normal).abs();
            let is_level = |corner: u32| off(corner) <= flatness * extent;
            let is_alike = |t: u32| {
                let (along, weight) = (weighted[t as usize].dot(normal), weighted[t as usize]);
                along >= 0.0 && (cosine == 0.0 || along >= cosine * weight.length())
            };
            taken[seed as usize] = true;
            stack.push(seed);
            members.clear();
            while let Some(t) = stack.pop() {
                let triangle = &triangles[t as usize];
                members.extend(triangle.corners);
                for &next in &triangle.neighbours {
                    let joins = !taken[next as usize]
                        && is_alike(next)
                        && triangles[next as usize].corners.into_iter().all(is_level);
                    if joins {
                        taken[next as usize] = true;
                        stack.push(next);
                    }
                }
            }
            members.sort_unstable();
            members.dedup();
            most = members.iter().map(|&corner| off(corner)).fold(most, f64::max);
            let corners = ring::corners(vertices, &members, normal);
            self.push(normal, &corners);
        }
        most
    }
}

/// Along the outward normal, of twice the triangle's area.
fn weighted_normal(triangle: &Triangle, vertices: &[DVec3]) -> DVec3 {
    let [p, q, r] = triangle.corners.map(|k| vertices[k as usize]);
    (q - p).cross(r - p)
}

#[cfg(test)]
mod tests;
