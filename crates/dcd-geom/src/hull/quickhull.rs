//! The surface of a solid cloud in triangles: Quickhull (Barber, Dobkin, Huhdanpaa 1996).
//!
//! Every decision is the exact sign of a height above a plane, so the surface is closed and convex
//! at each step, coplanar, collinear and repeated points included, and nothing depends on a
//! tolerance. Only the choice of the next point is rounded, and any choice leads to the same hull.
//!
//! A point that is in a face's plane does not see it. So of coplanar points some may be in the
//! middle of a face or edge: [`corners`] removes them.

use super::orient::{ExactPoints, Plane};
use std::collections::VecDeque;

/// No point, or the end of a list.
const NONE: u32 = u32::MAX;

/// So many faces are reserved at once: the hull of a hundred points then allocates a few times, not at each
/// doubling.
const FEW: usize = 128;

/// A triangle of the surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Triangle {
    /// Counter-clockwise seen from outside.
    pub(crate) corners: [u32; 3],
    /// The triangle across the edge from corner k to corner k + 1.
    pub(crate) neighbours: [u32; 3],
}

impl Triangle {
    /// The corner of a neighbour that is not this one's.
    fn apex_of(&self, neighbour: &Self) -> Option<u32> {
        neighbour.corners.into_iter().find(|corner| !self.corners.contains(corner))
    }
}

/// The surface of the hull. The four points to begin with are corners of a solid, the fourth below
/// the plane of the others, which turn counter-clockwise seen from above. There are fewer points
/// than `u32::MAX`.
///
/// Takes O(n log n) for most clouds, O(n²) for the worst.
pub(crate) fn surface(points: &ExactPoints, start: [u32; 4]) -> Vec<Triangle> {
    let mut search = HullSearch {
        points,
        faces: Vec::with_capacity(points.len().min(FEW)),
        free: Vec::with_capacity(points.len().min(FEW)),
        pending: VecDeque::with_capacity(points.len().min(FEW)),
        next: vec![NONE; points.len()],
        starting: vec![NONE; points.len()],
    };
    search.start(start);
    let mut work = Work::for_few(points.len());
    while let Some(face) = search.pending.pop_front() {
        let apex = search.faces[face as usize].farthest;
        if apex != NONE {
            search.add(apex, face, &mut work);
        }
    }
    search.finish()
}

/// Which points are corners of the hull: those whose triangles lie in at least three planes. In
/// the middle of a face they lie in one, in the middle of an edge in two.
pub(crate) fn corners(points: &ExactPoints, triangles: &[Triangle]) -> Vec<bool> {
    if is_simplicial(points, triangles) {
        let mut corners = vec![false; points.len()];
        let all = triangles.iter().flat_map(|triangle| triangle.corners);
        all.for_each(|corner| corners[corner as usize] = true);
        return corners;
    }
    let planes = planes(points, triangles);
    let mut seen = vec![[NONE; 3]; points.len()];
    for (triangle, &plane) in triangles.iter().zip(&planes) {
        for corner in triangle.corners {
            let of_corner = &mut seen[corner as usize];
            if let Some(slot) = of_corner.iter_mut().find(|p| **p == NONE || **p == plane) {
                *slot = plane;
            }
        }
    }
    seen.into_iter().map(|planes| planes[2] != NONE).collect()
}

/// Whether no two neighbours lie in one plane.
fn is_simplicial(points: &ExactPoints, triangles: &[Triangle]) -> bool {
    triangles.iter().zip(0..).all(|(triangle, index)| {
        let plane = points.plane(triangle.corners);
        let others = triangle.neighbours.into_iter().filter(|&other| other > index);
        others.into_iter().all(|other| {
            let apex = triangle.apex_of(&triangles[other as usize]);
            apex.is_none_or(|apex| points.height(apex, &plane) != 0.0)
        })
    })
}

/// For each triangle the first one in its plane that is reached from it over edges: on a convex
/// surface those in one plane are connected.
fn planes(points: &ExactPoints, triangles: &[Triangle]) -> Vec<u32> {
    let mut planes = vec![NONE; triangles.len()];
    let mut stack = Vec::new();
    for first in 0..triangles.len() as u32 {
        if planes[first as usize] != NONE {
            continue;
        }
        planes[first as usize] = first;
        stack.push(first);
        while let Some(index) = stack.pop() {
            let triangle = triangles[index as usize];
            let plane = points.plane(triangle.corners);
            for other in triangle.neighbours {
                let apex = triangle.apex_of(&triangles[other as usize]);
                let is_level = apex.is_none_or(|apex| points.height(apex, &plane) == 0.0);
                if planes[other as usize] == NONE && is_level {
                    planes[other as usize] = first;
                    stack.push(other);
                }
            }
        }
    }
    planes
}

struct Face {
    triangle: Triangle,
    plane: Plane,
    /// The first of the points beyond it that no other face has; the rest follow in `next`.
    first: u32,
    /// The farthest of them, the first in the cloud among equals.
    farthest: u32,
    height: f64,
    alive: bool,
}

/// An edge between what a point sees and what it does not, as the seen face runs along it.
#[derive(Clone, Copy)]
struct Edge {
    from: u32,
    to: u32,
    hidden: u32,
}

/// Lists of one addition, kept for their memory.
struct Work {
    seen: Vec<u32>,
    horizon: Vec<Edge>,
    fresh: Vec<u32>,
    orphans: Vec<u32>,
}

impl Work {
    fn for_few(points: usize) -> Self {
        let few = points.min(FEW);
        Self {
            seen: Vec::with_capacity(few),
            horizon: Vec::with_capacity(few),
            fresh: Vec::with_capacity(few),
            orphans: Vec::with_capacity(few),
        }
    }
}

struct HullSearch<'a> {
    points: &'a ExactPoints,
    faces: Vec<Face>,
    /// Faces that are gone, to be used again: memory stays in proportion to the surface.
    free: Vec<u32>,
    /// Faces that had points beyond them when they were made; some are gone since.
    pending: VecDeque<u32>,
    /// For each point that is beyond a face the next of that face.
    next: Vec<u32>,
    /// For each point of a horizon the new face whose edge starts there.
    starting: Vec<u32>,
}

impl HullSearch<'_> {
    fn start(&mut self, [p, q, r, s]: [u32; 4]) {
        for (corners, neighbours) in [
            ([p, q, r], [1, 2, 3]),
            ([q, p, s], [0, 3, 2]),
            ([r, q, s], [0, 1, 3]),
            ([p, r, s], [0, 2, 1]),
        ] {
            self.make(Triangle { corners, neighbours });
        }
        let start = [p, q, r, s];
        for k in (0..self.points.len() as u32).filter(|k| !start.contains(k)) {
            self.hand_out(k, &[0, 1, 2, 3]);
        }
        self.enqueue(&[0, 1, 2, 3]);
    }

    /// Replaces what the apex sees, `first` among it, by triangles between it and the horizon.
    fn add(&mut self, apex: u32, first: u32, work: &mut Work) {
        self.find_horizon(apex, first, work);
        work.orphans.clear();
        for &gone in &work.seen {
            let face = &mut self.faces[gone as usize];
            let mut point = std::mem::replace(&mut face.first, NONE);
            face.farthest = NONE;
            while point != NONE {
                if point != apex {
                    work.orphans.push(point);
                }
                point = self.next[point as usize];
            }
        }
        self.free.extend(&work.seen);
        work.fresh.clear();
        for &Edge { from, to, hidden } in &work.horizon {
            let neighbours = [hidden, NONE, NONE];
            let face = self.make(Triangle { corners: [from, to, apex], neighbours });
            self.reconnect(hidden, (to, from), face);
            self.starting[from as usize] = face;
            work.fresh.push(face);
        }
        for (&face, edge) in work.fresh.iter().zip(&work.horizon) {
            let after = self.starting[edge.to as usize];
            self.faces[face as usize].triangle.neighbours[1] = after;
            self.faces[after as usize].triangle.neighbours[2] = face;
        }
        for &point in &work.orphans {
            self.hand_out(point, &work.fresh);
        }
        self.enqueue(&work.fresh);
    }

    /// Marks what the point sees as gone and collects the edges round it: one ring, since what is
    /// seen of a convex surface, faces taken whole, is a disc.
    fn find_horizon(&mut self, apex: u32, first: u32, work: &mut Work) {
        work.seen.clear();
        work.horizon.clear();
        self.faces[first as usize].alive = false;
        work.seen.push(first);
        let mut next = 0;
        while let Some(&index) = work.seen.get(next) {
            next += 1;
            let Triangle { corners, neighbours } = self.faces[index as usize].triangle;
            for (k, &other) in neighbours.iter().enumerate() {
                let neighbour = &mut self.faces[other as usize];
                if !neighbour.alive {
                    continue;
                }
                if self.points.height(apex, &neighbour.plane) > 0.0 {
                    neighbour.alive = false;
                    work.seen.push(other);
                } else {
                    let (from, to) = (corners[k], corners[(k + 1) % 3]);
                    work.horizon.push(Edge { from, to, hidden: other });
                }
            }
        }
    }

    /// Gives the point to the first of the faces that it is beyond, if any: else it is inside for
    /// good.
    #[inline(always)]
    fn hand_out(&mut self, point: u32, faces: &[u32]) {
        for &index in faces {
            let face = &mut self.faces[index as usize];
            let height = self.points.height(point, &face.plane);
            if height > 0.0 {
                self.next[point as usize] = face.first;
                face.first = point;
                let is_first = height == face.height && point < face.farthest;
                if height > face.height || is_first {
                    (face.farthest, face.height) = (point, height);
                }
                return;
            }
        }
    }

    fn enqueue(&mut self, faces: &[u32]) {
        let has_points = |&face: &u32| self.faces[face as usize].first != NONE;
        self.pending.extend(faces.iter().copied().filter(has_points));
    }

    /// Makes `neighbour` the one across an edge of `face`.
    fn reconnect(&mut self, face: u32, (from, to): (u32, u32), neighbour: u32) {
        let triangle = &mut self.faces[face as usize].triangle;
        for k in 0..3 {
            if (triangle.corners[k], triangle.corners[(k + 1) % 3]) == (from, to) {
                triangle.neighbours[k] = neighbour;
            }
        }
    }

    #[inline]
    fn make(&mut self, triangle: Triangle) -> u32 {
        let plane = self.points.plane(triangle.corners);
        let face = Face { triangle, plane, first: NONE, farthest: NONE, height: 0.0, alive: true };
        match self.free.pop() {
            Some(slot) => {
                self.faces[slot as usize] = face;
                slot
            }
            None => {
                self.faces.push(face);
                self.faces.len() as u32 - 1
            }
        }
    }

    /// The triangles that are there, numbered anew.
    fn finish(self) -> Vec<Triangle> {
        let mut number = 0;
        let numbers: Vec<u32> = self
            .faces
            .iter()
            .map(|face| {
                number += u32::from(face.alive);
                number.wrapping_sub(1)
            })
            .collect();
        let alive = self.faces.into_iter().filter(|face| face.alive);
        let renamed = |Triangle { corners, neighbours }| Triangle {
            corners,
            neighbours: neighbours.map(|k| numbers[k as usize]),
        };
        alive.map(|face| renamed(face.triangle)).collect()
    }
}
