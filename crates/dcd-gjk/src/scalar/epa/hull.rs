//! A convex polytope of lattice points that grows point by point, by exact predicates.

use super::lattice::{Normal, Vertex, cross, dot, length, minus, rounded};
use super::wide::Wide;
use dcd_geom::Vector;
use dcd_geom::glam::DVec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// A triangle of the surface, counter-clockwise seen from outside.
#[derive(Clone, Debug)]
pub(super) struct Face {
    pub(super) vertices: [u32; 3],
    /// The face across the edge from vertex k to vertex k + 1.
    pub(super) neighbours: [u32; 3],
    /// Outward; not of unit length.
    pub(super) normal: Normal,
    /// normal·w on the face.
    pub(super) offset: Wide,
    /// |normal|.
    pub(super) length: f64,
    /// Whether it is still a part of the surface.
    alive: bool,
}

impl Face {
    /// The plane's distance from the origin, units, negative where the origin is outside; to
    /// within 16·2⁻⁵³ of itself, its sign exact.
    pub(super) fn distance(&self) -> f64 {
        self.offset.to_f64() / self.length
    }
}

/// A face in the queue: the nearest plane first, the older face among equals.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Queued {
    distance: f64,
    face: u32,
}

impl Eq for Queued {}

impl Ord for Queued {
    fn cmp(&self, other: &Self) -> Ordering {
        other.distance.total_cmp(&self.distance).then(other.face.cmp(&self.face))
    }
}

impl PartialOrd for Queued {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// An edge between what a new vertex sees and what it does not, as the seen face runs along it.
#[derive(Clone, Copy, Debug)]
struct Edge {
    from: u32,
    to: u32,
    hidden: u32,
}

/// The surface of a convex polytope. Faces are never removed, only marked, so that an index
/// stays good.
#[derive(Debug, Default)]
pub(super) struct Hull {
    vertices: Vec<Vertex>,
    faces: Vec<Face>,
    queue: BinaryHeap<Queued>,
    stack: Vec<u32>,
    horizon: Vec<Edge>,
    /// Of a vertex on the horizon: the new face whose horizon edge starts there.
    starting: Vec<u32>,
}

impl Hull {
    /// Starts over with a tetrahedron of four points that are not in one plane.
    pub(super) fn start(&mut self, mut corners: [Vertex; 4]) {
        self.vertices.clear();
        self.faces.clear();
        self.queue.clear();
        self.starting.clear();
        let [v0, v1, v2, v3] = corners.map(|vertex| vertex.w);
        let up = dot(&cross(minus(v1, v0), minus(v2, v0)), minus(v3, v0));
        debug_assert_ne!(up, Wide::ZERO);
        if up < Wide::ZERO {
            corners.swap(1, 2);
        }
        self.vertices.extend(corners);
        self.starting.resize(4, 0);
        // Each face, and across each of its edges the face that runs along it the other way.
        for (vertices, neighbours) in [
            ([0, 2, 1], [2, 3, 1]),
            ([0, 1, 3], [0, 3, 2]),
            ([0, 3, 2], [1, 3, 0]),
            ([1, 2, 3], [0, 2, 1]),
        ] {
            self.push(vertices, neighbours);
        }
    }

    pub(super) fn vertex(&self, index: u32) -> &Vertex {
        &self.vertices[index as usize]
    }

    pub(super) fn face(&self, index: u32) -> &Face {
        &self.faces[index as usize]
    }

    pub(super) fn faces(&self) -> usize {
        self.faces.len()
    }

    /// The face of the surface whose normal is most along a direction, as f64 sees it.
    pub(super) fn facing(&self, direction: DVec3) -> &Face {
        let along = |face: &Face| Vector::dot(rounded(&face.normal), direction) / face.length;
        let mut best = (f64::NEG_INFINITY, 0);
        for (index, face) in self.faces.iter().enumerate().filter(|(_, face)| face.alive) {
            if along(face) > best.0 {
                best = (along(face), index);
            }
        }
        &self.faces[best.1]
    }

    /// The face of the surface whose plane is nearest along its normal: the smallest signed
    /// distance.
    pub(super) fn nearest(&mut self) -> u32 {
        while let Some(queued) = self.queue.peek() {
            if self.face(queued.face).alive {
                return queued.face;
            }
            self.queue.pop();
        }
        // A closed surface has faces.
        debug_assert!(false, "no face");
        0
    }

    /// Takes the next face out of the queue, nearest first; it stays a part of the surface.
    pub(super) fn take_nearest(&mut self) -> Option<u32> {
        while let Some(queued) = self.queue.pop() {
            if self.face(queued.face).alive {
                return Some(queued.face);
            }
        }
        None
    }

    /// The hull of itself and a point that lies strictly beyond the face `seen`.
    ///
    /// The faces that the point lies strictly beyond are connected and bounded by one simple
    /// cycle, faces in whose plane it lies being left alone; no new face is degenerate, for a
    /// point in line with an edge of the cycle would lie in the plane of the seen face there.
    pub(super) fn insert(&mut self, vertex: Vertex, seen: u32) {
        let new = self.vertices.len() as u32;
        self.vertices.push(vertex);
        self.starting.push(0);
        self.find_horizon(&vertex, seen);
        let first = self.faces.len() as u32;
        for (k, edge) in self.horizon.iter().enumerate() {
            self.starting[edge.from as usize] = first + k as u32;
        }
        for k in 0..self.horizon.len() {
            let Edge { from, to, hidden } = self.horizon[k];
            let face = first + k as u32;
            self.reconnect(hidden, (to, from), face);
            // The face before this one on the cycle learns of it when it is made, or now.
            self.push([from, to, new], [hidden, self.starting[to as usize], u32::MAX]);
        }
        for k in 0..self.horizon.len() as u32 {
            let [_, after, _] = self.faces[(first + k) as usize].neighbours;
            self.faces[after as usize].neighbours[2] = first + k;
        }
    }

    /// Marks what the vertex sees as gone and collects the edges round it.
    fn find_horizon(&mut self, vertex: &Vertex, seen: u32) {
        self.horizon.clear();
        self.stack.clear();
        self.faces[seen as usize].alive = false;
        self.stack.push(seen);
        while let Some(index) = self.stack.pop() {
            let Face { vertices, neighbours, .. } = *self.face(index);
            for (k, &other) in neighbours.iter().enumerate() {
                let neighbour = &mut self.faces[other as usize];
                if !neighbour.alive {
                    continue;
                }
                if dot(&neighbour.normal, vertex.w) > neighbour.offset {
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

    fn push(&mut self, vertices: [u32; 3], neighbours: [u32; 3]) {
        let [p, q, r] = vertices.map(|k| self.vertex(k).w);
        let normal = cross(minus(q, p), minus(r, p));
        let offset = dot(&normal, p);
        let face =
            Face { vertices, neighbours, normal, offset, length: length(&normal), alive: true };
        debug_assert!(face.length > 0.0);
        let queued = Queued { distance: face.distance(), face: self.faces.len() as u32 };
        self.queue.push(queued);
        self.faces.push(face);
    }

    /// That the surface is closed and convex.
    #[cfg(test)]
    pub(super) fn validate(&self) {
        let alive = || self.faces.iter().enumerate().filter(|(_, face)| face.alive);
        for (index, face) in alive() {
            for k in 0..3 {
                let edge = (face.vertices[(k + 1) % 3], face.vertices[k]);
                let other = self.face(face.neighbours[k]);
                let back = (0..3)
                    .find(|&j| (other.vertices[j], other.vertices[(j + 1) % 3]) == edge)
                    .unwrap_or_else(|| panic!("{index} has no neighbour at {k}"));
                assert!(other.alive && other.neighbours[back] == index as u32);
            }
            for vertex in &self.vertices {
                assert!(dot(&face.normal, vertex.w) <= face.offset);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn at(w: [i128; 3]) -> Vertex {
        Vertex { w, a: 0, b: 0 }
    }

    /// Inserts every point that is outside, nearest face first.
    fn grow(points: &[[i128; 3]]) -> Hull {
        let mut hull = Hull::default();
        hull.start([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]].map(at));
        for &p in points {
            let beyond = |f: &Face| f.alive && dot(&f.normal, p) > f.offset;
            if let Some(seen) = hull.faces.iter().position(beyond) {
                hull.insert(at(p), seen as u32);
                hull.validate();
            }
        }
        hull
    }

    proptest! {
        #[test]
        fn the_surface_stays_closed_and_convex_on_a_small_grid(
            // Few coordinates: most points are coplanar or collinear with others.
            points in prop::collection::vec(prop::array::uniform3(-2i128..=2), 0..40),
        ) {
            grow(&points);
        }

        #[test]
        fn the_surface_stays_closed_and_convex_at_the_largest_coordinates(
            points in prop::collection::vec(
                prop::array::uniform3(prop_oneof![
                    -(1i128 << 83) + 1..-(1i128 << 83) + 9, (1i128 << 83) - 9..1i128 << 83, -4i128..4
                ]), 0..30),
        ) {
            grow(&points);
        }
    }

    #[test]
    fn the_faces_of_a_cube_are_at_its_distance() {
        let corners: Vec<_> =
            (0..8).map(|k| [1, 2, 4].map(|bit| if k & bit == 0 { -5 } else { 5 })).collect();
        let mut hull = grow(&corners);
        assert_eq!(hull.faces.iter().filter(|f| f.alive).count(), 12);
        let nearest = hull.nearest();
        assert_eq!(hull.face(nearest).distance(), 5.0);
    }
}
