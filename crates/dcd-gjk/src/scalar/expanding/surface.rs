//! A closed surface of triangles that grows point by point, with rounded planes.

use super::confirm::Corners;
use crate::{PosedSupport, Vertex};
use dcd_geom::SupportMap;
use dcd_geom::glam::DVec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Unit roundoff.
const U: f64 = f64::EPSILON / 2.0;

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
    /// normal·w on the face.
    distance: f64,
    /// Whether it is a part of the surface.
    alive: bool,
}

/// An edge between what a new vertex sees and what it does not, as the seen face runs along it.
#[derive(Clone, Copy, Debug)]
struct Edge {
    from: u32,
    to: u32,
    hidden: u32,
}

/// A face by how far its plane is along its normal: the nearest is the greatest, the older one among equals.
type Candidate = Reverse<(i64, u32)>;

/// A number's place in the order of all numbers: of integers, which are compared at once.
fn rank(distance: f64) -> i64 {
    let bits = distance.to_bits() as i64;
    // All bits of a negative number but its sign run the other way.
    bits ^ ((bits >> 63) as u64 >> 1) as i64
}

/// The surface, and memory that one search leaves to the next.
#[derive(Debug, Default)]
pub(crate) struct Surface {
    vertices: Vec<Vertex<f64>>,
    faces: Vec<Face>,
    /// The faces by how far their planes are along their normals; those that are no part of the surface are taken
    /// away when they come first.
    queue: BinaryHeap<Candidate>,
    stack: Vec<u32>,
    horizon: Vec<Edge>,
    /// Of a vertex on the horizon: the new face whose horizon edge starts there.
    starting: Vec<u32>,
}

/// No face starts here.
const NONE: u32 = u32::MAX;

impl Surface {
    /// Leaves no surface.
    pub(super) fn clear(&mut self) {
        self.vertices.clear();
        self.faces.clear();
        self.queue.clear();
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
            self.push(vertices, neighbours)?;
        }
        Some(())
    }

    /// The face whose plane is nearest along its normal: the smallest signed distance, the older one
    /// among equals.
    pub(super) fn nearest(&mut self) -> u32 {
        while let Some(&Reverse((_, face))) = self.queue.peek() {
            if self.faces[face as usize].alive {
                return face;
            }
            self.queue.pop();
        }
        0
    }

    /// A face's normal and distance.
    pub(super) fn plane(&self, face: u32) -> (DVec3, f64) {
        let Face { normal, distance, .. } = self.faces[face as usize];
        (normal, distance)
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
        let first = self.faces.len() as u32;
        self.starting.fill(NONE);
        for (k, edge) in self.horizon.iter().enumerate() {
            let starting = &mut self.starting[edge.from as usize];
            if *starting != NONE {
                return None;
            }
            *starting = first + k as u32;
        }
        for k in 0..self.horizon.len() {
            let Edge { from, to, hidden } = self.horizon[k];
            let after = self.starting[to as usize];
            if after == NONE {
                return None;
            }
            self.reconnect(hidden, (to, from), first + k as u32);
            // The face before this one on the cycle learns of it when it is made, or now.
            self.push([from, to, new], [hidden, after, NONE])?;
        }
        for k in first..self.faces.len() as u32 {
            let [_, after, _] = self.faces[k as usize].neighbours;
            self.faces[after as usize].neighbours[2] = k;
        }
        (self.horizon.len() >= 3).then_some(())
    }

    /// Marks what the vertex sees as gone and collects the edges round it.
    fn find_horizon(&mut self, point: DVec3, seen: u32) {
        self.horizon.clear();
        self.stack.clear();
        self.faces[seen as usize].alive = false;
        self.stack.push(seen);
        while let Some(index) = self.stack.pop() {
            let Face { vertices, neighbours, .. } = self.faces[index as usize];
            for (k, &other) in neighbours.iter().enumerate() {
                let neighbour = &mut self.faces[other as usize];
                if !neighbour.alive {
                    continue;
                }
                // Barely seen is not seen: a cone over such a face would have a sliver.
                if neighbour.normal.dot(point) > neighbour.distance + 16.0 * U {
                    neighbour.alive = false;
                    self.stack.push(other);
                } else {
                    let (from, to) = (vertices[k], vertices[(k + 1) % 3]);
                    self.horizon.push(Edge { from, to, hidden: other });
                }
            }
        }
    }

    /// Makes `neighbour` the one across an edge of `face`.
    fn reconnect(&mut self, face: u32, edge: (u32, u32), neighbour: u32) {
        let face = &mut self.faces[face as usize];
        for k in 0..3 {
            if (face.vertices[k], face.vertices[(k + 1) % 3]) == edge {
                face.neighbours[k] = neighbour;
            }
        }
    }

    fn push(&mut self, vertices: [u32; 3], neighbours: [u32; 3]) -> Option<()> {
        let [p, q, r] = self.corners(&vertices);
        let normal = (q - p).cross(r - p);
        let length = normal.length();
        if !(length > 0.0) {
            return None;
        }
        let normal = normal / length;
        let distance = normal.dot(p);
        self.queue.push(Reverse((rank(distance), self.faces.len() as u32)));
        self.faces.push(Face { vertices, neighbours, normal, distance, alive: true });
        Some(())
    }

    fn corners(&self, &[p, q, r]: &[u32; 3]) -> [DVec3; 3] {
        [self.vertices[p as usize].w, self.vertices[q as usize].w, self.vertices[r as usize].w]
    }

    /// The radius of a sphere round the origin that is surely inside of what the surface bounds, for the
    /// vertices as they stand; 0 where the origin may be outside.
    pub(super) fn inner_radius(&self) -> f64 {
        let mut least = f64::INFINITY;
        for Face { vertices, normal, .. } in self.faces.iter().filter(|face| face.alive) {
            let corners = self.corners(vertices);
            if !is_inside(corners) {
                return 0.0;
            }
            least = least.min(clearance(*normal, corners));
        }
        if least < f64::INFINITY { least.max(0.0) } else { 0.0 }
    }

    /// Of each face at most its distance from the origin, and its corners by the features of a and of b.
    pub(super) fn faces(&self) -> impl Iterator<Item = (f64, Corners)> + Clone {
        let alive = self.faces.iter().filter(|face| face.alive);
        alive.map(|face| {
            let corners = face.vertices.map(|k| {
                let Vertex { a, b, .. } = &self.vertices[k as usize];
                [a.feature, b.feature]
            });
            (clearance(face.normal, self.corners(&face.vertices)), corners)
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
    /// that it passes by the least, where rounding lets it slip between all.
    fn leaving(&self, direction: DVec3) -> ([u32; 3], [f64; 3]) {
        let mut best = (f64::NEG_INFINITY, [0; 3], DVec3::X);
        for Face { vertices, normal, .. } in self.faces.iter().filter(|face| face.alive) {
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
        }
        let (_, vertices, weights) = best;
        let weights = weights.max(DVec3::ZERO);
        let total = weights.x + weights.y + weights.z;
        (vertices, (weights / total).to_array())
    }
}

/// Whether the origin is surely on the inner side of a triangle: det(p, q, r) beyond 16u of its permanent,
/// of which the determinant loses 5u and the permanent 5u of itself. Underflow proves nothing.
pub(crate) fn is_inside(corners: [DVec3; 3]) -> bool {
    let [p, q, r] = corners;
    let [p_abs, q_abs, r_abs] = [p.abs(), q.abs(), r.abs()];
    let permanent = p_abs.x * (q_abs.y * r_abs.z + q_abs.z * r_abs.y)
        + p_abs.y * (q_abs.z * r_abs.x + q_abs.x * r_abs.z)
        + p_abs.z * (q_abs.x * r_abs.y + q_abs.y * r_abs.x);
    p.dot(q.cross(r)) > 16.0 * U * permanent + f64::MIN_POSITIVE
}

/// At most the distance of a triangle from the origin: its lowest corner along any direction. The
/// direction's length is off by at most 8u, a product of it with a corner, all within 1 of the origin but for
/// rounding, by 5u.
pub(super) fn clearance(normal: DVec3, corners: [DVec3; 3]) -> f64 {
    let [p, q, r] = corners;
    let [p, q, r] = [normal.dot(p), normal.dot(q), normal.dot(r)];
    p.min(q).min(r) * (1.0 - 16.0 * U) - 8.0 * U
}
