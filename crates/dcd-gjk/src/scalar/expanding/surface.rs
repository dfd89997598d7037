//! A closed surface of triangles that grows point by point, with rounded planes.

use super::confirm::NearFace;
use crate::UNIT;
use crate::{PosedSupport, Vertex};
use dcd_geom::SupportMap;
use dcd_geom::glam::DVec3;

/// The cosine below which a face is seen edge on: 2⁻²⁰. A direction of depth leaves by a face whose cosine is near 1.
/// Smaller: witnesses whose weights are rounding. Larger: searches that ended early find none.
const EDGE_ON: f64 = 1.0 / (1u64 << 20) as f64;

/// A triangle, counter-clockwise seen from outside.
#[derive(Clone, Copy, Debug)]
struct Face {
    vertices: [u32; 3],
    /// The face across the edge from vertex k to vertex k + 1.
    neighbours: [u32; 3],
    /// Outward, of unit length but for rounding.
    normal: DVec3,
}

/// An edge between what a new vertex sees and what it does not, as the seen face runs along it.
#[derive(Clone, Copy, Debug)]
struct Edge {
    from: u32,
    to: u32,
    hidden: u32,
}

/// The surface, and memory that one search leaves to the next.
#[derive(Debug, Default)]
pub(crate) struct Surface {
    vertices: Vec<Vertex<f64>>,
    faces: Vec<Face>,
    /// normal·w on each face; [`GONE`] of what is no part of the surface. Beside the faces: to look through all for the
    /// nearest takes less than to keep them in order.
    distances: Vec<f64>,
    /// What is no part of the surface: its places are taken by the faces that come next.
    gone: Vec<u32>,
    horizon: Vec<Edge>,
    /// Of a vertex on the horizon: the new face whose horizon edge starts there.
    starting: Vec<u32>,
}

/// Farther than any face.
const GONE: f64 = f64::INFINITY;

/// The length of a product of two edges below which a face is a line: no square of more underflows, lengths below 1.
const LINE: f64 = 1e-150;

/// No face starts here.
const NONE: u32 = u32::MAX;

impl Surface {
    /// Leaves no surface.
    pub(super) fn clear(&mut self) {
        self.vertices.clear();
        self.faces.clear();
        self.distances.clear();
        self.gone.clear();
        self.starting.clear();
    }

    /// Leaves no surface, and none to go on with: what is not closed bounds nothing.
    pub(super) fn forget(&mut self) -> Option<()> {
        self.clear();
        None
    }

    /// Starts with a tetrahedron of four points that are not in one plane, where there was no surface.
    pub(super) fn start(&mut self, mut corners: [Vertex<f64>; 4]) -> Option<()> {
        let [v0, v1, v2, v3] = corners.map(|vertex| vertex.w);
        if (v1 - v0).cross(v2 - v0).dot(v3 - v0) < 0.0 {
            corners.swap(1, 2);
        }
        self.vertices.extend(corners);
        self.starting.resize(4, NONE);
        // Each face, and across each of its edges the face that runs along it the other way.
        for (vertices, neighbours) in [
            ([0, 2, 1], [2, 3, 1]),
            ([0, 1, 3], [0, 3, 2]),
            ([0, 3, 2], [1, 3, 0]),
            ([1, 2, 3], [0, 2, 1]),
        ] {
            let place = self.place();
            self.set(place, vertices, neighbours)?;
        }
        Some(())
    }

    /// The face whose plane is nearest along its normal: the smallest signed distance, the first
    /// among equals.
    pub(super) fn nearest(&self) -> u32 {
        let (eights, rest) = self.distances.as_chunks::<8>();
        // Side by side: as many comparisons wait for none of the others.
        let mut nearest = [GONE; 8];
        for eight in eights {
            for (least, &distance) in nearest.iter_mut().zip(eight) {
                *least = smaller(*least, distance);
            }
        }
        let least = nearest.iter().chain(rest).fold(GONE, |least, &other| smaller(least, other));
        let has_it =
            |eight: &[f64; 8]| eight.iter().fold(false, |has, &other| has | (other == least));
        let before = 8 * eights.iter().position(has_it).unwrap_or(eights.len());
        let after = self.distances[before..].iter().position(|&distance| distance == least);
        after.map_or(0, |after| (before + after) as u32)
    }

    /// A face's normal and distance.
    pub(super) fn plane(&self, face: u32) -> (DVec3, f64) {
        (self.faces[face as usize].normal, self.distances[face as usize])
    }

    /// Whether the surface has the vertex.
    pub(super) fn holds(&self, vertex: &Vertex<f64>) -> bool {
        self.vertices.iter().any(|other| other.is_same(vertex) || other.w == vertex.w)
    }

    /// Takes away the faces that the vertex sees, `seen` among them, and adds the cone over their
    /// boundary. `None` where rounding makes that boundary more than one simple cycle, or a face a line.
    pub(super) fn insert(&mut self, vertex: Vertex<f64>, seen: u32) -> Option<()> {
        let new = self.vertices.len() as u32;
        self.vertices.push(vertex);
        self.starting.push(NONE);
        self.find_horizon(vertex.w, seen);
        self.starting.fill(NONE);
        for k in 0..self.horizon.len() {
            let from = self.horizon[k].from as usize;
            if self.starting[from] != NONE {
                return None;
            }
            self.starting[from] = self.place();
        }
        for k in 0..self.horizon.len() {
            let Edge { from, to, hidden } = self.horizon[k];
            let [place, after] = [from, to].map(|vertex| self.starting[vertex as usize]);
            if after == NONE {
                return None;
            }
            self.reconnect(hidden, (to, from), place);
            // The face before this one on the cycle is known when all are made.
            self.set(place, [from, to, new], [hidden, after, NONE])?;
        }
        for edge in &self.horizon {
            let [place, after] = [edge.from, edge.to].map(|vertex| self.starting[vertex as usize]);
            self.faces[after as usize].neighbours[2] = place;
        }
        (self.horizon.len() >= 3).then_some(())
    }

    /// Marks what the vertex sees as gone and collects the edges round it.
    fn find_horizon(&mut self, point: DVec3, seen: u32) {
        self.horizon.clear();
        let mut next = self.gone.len();
        self.take_away(seen);
        while let Some(&index) = self.gone.get(next) {
            next += 1;
            let Face { vertices, neighbours, .. } = self.faces[index as usize];
            for (k, &other) in neighbours.iter().enumerate() {
                let (normal, distance) = self.plane(other);
                if distance == GONE {
                    continue;
                }
                // Barely seen is not seen: a cone over such a face would have a sliver.
                if normal.dot(point) > distance + 16.0 * UNIT {
                    self.take_away(other);
                } else {
                    let (from, to) = (vertices[k], vertices[(k + 1) % 3]);
                    self.horizon.push(Edge { from, to, hidden: other });
                }
            }
        }
    }

    /// Makes a face no part of the surface.
    fn take_away(&mut self, face: u32) {
        self.distances[face as usize] = GONE;
        self.gone.push(face);
    }

    /// A place for a face.
    fn place(&mut self) -> u32 {
        self.gone.pop().unwrap_or_else(|| {
            self.faces.push(Face { vertices: [0; 3], neighbours: [NONE; 3], normal: DVec3::ZERO });
            self.distances.push(GONE);
            (self.faces.len() - 1) as u32
        })
    }

    /// Makes `neighbour` the one across an edge of `face`.
    fn reconnect(&mut self, face: u32, edge: (u32, u32), neighbour: u32) {
        let face = &mut self.faces[face as usize];
        // Which of the three it is cannot be predicted: no branch depends on it.
        for k in 0..3 {
            let is_there = (face.vertices[k] == edge.0) & (face.vertices[(k + 1) % 3] == edge.1);
            face.neighbours[k] = if is_there { neighbour } else { face.neighbours[k] };
        }
    }

    /// Makes a face in a place that is free; `None` of a line.
    fn set(&mut self, place: u32, vertices: [u32; 3], neighbours: [u32; 3]) -> Option<()> {
        let [p, q, r] = self.corners(&vertices);
        let normal = (q - p).cross(r - p);
        let length = normal.length();
        if !(length > LINE) {
            return None;
        }
        let normal = normal / length;
        self.distances[place as usize] = normal.dot(p);
        self.faces[place as usize] = Face { vertices, neighbours, normal };
        Some(())
    }

    fn corners(&self, &[p, q, r]: &[u32; 3]) -> [DVec3; 3] {
        [self.vertices[p as usize].w, self.vertices[q as usize].w, self.vertices[r as usize].w]
    }

    /// The faces of the surface.
    fn alive(&self) -> impl Iterator<Item = &Face> + Clone {
        let all = self.faces.iter().zip(&self.distances);
        all.filter(|(_, distance)| **distance < GONE).map(|(face, _)| face)
    }

    /// The radius of a sphere round the origin that is surely inside of what the surface bounds, for the
    /// vertices as they stand; 0 where the origin may be outside.
    pub(super) fn inner_radius(&self) -> f64 {
        let mut least = f64::INFINITY;
        for Face { vertices, normal, .. } in self.alive() {
            let corners = self.corners(vertices);
            if !is_inside_within_one(corners) {
                return 0.0;
            }
            least = least.min(clearance(*normal, corners));
        }
        if least < f64::INFINITY { least.max(0.0) } else { 0.0 }
    }

    /// How far from a unit direction others are along which the surface may not reach so far, as a sum of two chords of the unit
    /// sphere: 0 where it does along all. `None` where the origin may be outside, and above a limit.
    ///
    /// Along such a direction a ray from the origin leaves by a triangle, before that reach: the plane of the triangle is nearer,
    /// and the direction no farther from its normal than where the sphere of that radius meets the plane.
    pub(super) fn beyond(&self, reach: f64, direction: DVec3, limit: f64) -> Option<f64> {
        let mut most = 0.0f64;
        for Face { vertices, normal, .. } in self.alive() {
            let corners = self.corners(vertices);
            if !is_inside_within_one(corners) {
                return None;
            }
            let cosine = clearance(*normal, corners) / reach;
            if cosine < 1.0 {
                most = most.max(normal.distance(direction) + (2.0 * (1.0 - cosine)).sqrt());
                if most > limit {
                    return None;
                }
            }
        }
        Some(most)
    }

    /// The corners of a face.
    pub(super) fn vertices(&self, face: u32) -> [Vertex<f64>; 3] {
        self.faces[face as usize].vertices.map(|k| self.vertices[k as usize])
    }

    /// Each face.
    pub(super) fn faces(&self) -> impl Iterator<Item = NearFace> + Clone {
        self.alive().map(|face| NearFace {
            clearance: clearance(face.normal, self.corners(&face.vertices)),
            corners: face.vertices.map(|k| self.vertices[k as usize]),
        })
    }

    /// The points of the two cores where a direction from the origin leaves the surface; world, metres.
    pub(super) fn witnesses<S: SupportMap<f64>>(
        &self,
        direction: DVec3,
        [a, b]: [PosedSupport<'_, S>; 2],
    ) -> [DVec3; 2] {
        let (vertices, weights) = self.leaving(direction);
        let corners = vertices.map(|k| &self.vertices[k as usize]);
        let sum = |point: fn(&Vertex<f64>) -> DVec3| {
            let terms = corners.iter().zip(weights).map(|(&vertex, w)| point(vertex) * w);
            terms.sum::<DVec3>()
        };
        [a.pose.apply(sum(|v| v.a.point)), b.pose.apply(sum(|v| v.b.point))]
    }

    /// The triangle that a ray from the origin leaves by, and the weights of its corners there: the one
    /// that it passes by the least, where rounding lets it slip between all. The nearest is looked at first: mostly the ray is
    /// its normal.
    fn leaving(&self, direction: DVec3) -> ([u32; 3], [f64; 3]) {
        let mut best = (f64::NEG_INFINITY, [0; 3], DVec3::X);
        let first = self.faces.get(self.nearest() as usize);
        for Face { vertices, normal, .. } in first.into_iter().chain(self.alive()) {
            if normal.dot(direction) <= EDGE_ON * direction.length() {
                continue;
            }
            let [p, q, r] = self.corners(vertices);
            let volume = |n: DVec3| n.dot(direction);
            let volumes = DVec3::new(volume(q.cross(r)), volume(r.cross(p)), volume(p.cross(q)));
            let total = volumes.x + volumes.y + volumes.z;
            let weights = volumes / total;
            let least = weights.x.min(weights.y).min(weights.z);
            if total > 0.0 && least > best.0 {
                best = (least, *vertices, weights);
            }
            if best.0 > 0.0 {
                break;
            }
        }
        let (_, vertices, weights) = best;
        let weights = weights.max(DVec3::ZERO);
        let total = weights.x + weights.y + weights.z;
        (vertices, (weights / total).to_array())
    }
}

/// The smaller; the first where the second is NaN.
fn smaller(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

/// Whether the origin is surely on the inner side of a triangle: det(p, q, r) beyond 16u of its permanent,
/// of which the determinant loses 5u and the permanent 5u of itself. Underflow proves nothing.
pub(crate) fn is_inside(corners: [DVec3; 3]) -> bool {
    let [p, q, r] = corners;
    let [p_abs, q_abs, r_abs] = [p.abs(), q.abs(), r.abs()];
    let permanent = p_abs.x * (q_abs.y * r_abs.z + q_abs.z * r_abs.y)
        + p_abs.y * (q_abs.z * r_abs.x + q_abs.x * r_abs.z)
        + p_abs.z * (q_abs.x * r_abs.y + q_abs.y * r_abs.x);
    p.dot(q.cross(r)) > 16.0 * UNIT * permanent + f64::MIN_POSITIVE
}

/// The same of corners whose coordinates are at most 1 but for rounding, with a first look at the determinant alone: the permanent
/// is then at most 6.
fn is_inside_within_one(corners: [DVec3; 3]) -> bool {
    let [p, q, r] = corners;
    p.dot(q.cross(r)) > 16.0 * UNIT * 6.5 || is_inside(corners)
}

/// At most the distance of a triangle from the origin: its lowest corner along any direction. The
/// direction's length is off by at most 8u, a product of it with a corner, all within 1 of the origin but for
/// rounding, by 5u.
pub(super) fn clearance(normal: DVec3, corners: [DVec3; 3]) -> f64 {
    let [p, q, r] = corners;
    let [p, q, r] = [normal.dot(p), normal.dot(q), normal.dot(r)];
    p.min(q).min(r) * (1.0 - 16.0 * UNIT) - 8.0 * UNIT
}

#[cfg(test)]
mod tests;
