//! Which face, edge or vertex of a polytope faces a direction.

mod triangle;

use super::{Feature, cuboids};
use dcd_geom::glam::DVec3;
use dcd_geom::{Facets, HalfEdge, Kind, Polytope};
use dcd_simd::larger;
use std::hint::select_unpredictable;
use triangle::Triangle;

/// The least cosine between a face's normal and the contact's for the face to lie in it: 15
/// degrees. Larger: boxes that rock on two points. Smaller: points far from where shapes touch.
pub(crate) const FACING: f64 = 0.966;

/// The most that an edge may rise along the contact's normal, relative to its length: 15 degrees.
pub(crate) const LEVEL: f64 = 0.259;

/// How far below the farthest a vertex may be to count as farthest, relative to the size.
const FARTHEST: f64 = 1e-9;

/// A face, an edge or a vertex of a shape.
#[derive(Clone, Copy)]
pub(super) enum Part<'a> {
    Vertex(u32),
    Edge([u32; 2]),
    Face { index: u32, normal: DVec3, corners: &'a [u32] },
}

/// What a polytope shows along a unit direction of its own frame, by name alone.
#[inline]
pub(super) fn name(polytope: &Polytope, direction: DVec3) -> Feature {
    let choice = Choice { polytope, direction };
    let at_once = match polytope.kind() {
        Kind::Point => Some(Feature::Vertex(0)),
        Kind::Segment => choice.of_segment().map(|part| part.name()),
        Kind::Triangle => choice.triangle().map(|triangle| triangle.name(direction)),
        _ => cuboids::feature(polytope, direction),
    };
    at_once.unwrap_or_else(|| choice.searched().name())
}

impl<'a> Part<'a> {
    /// Which of a polytope faces a direction of its own frame, of unit length.
    #[inline]
    pub(super) fn facing(polytope: &'a Polytope, direction: DVec3) -> Self {
        Self::round(polytope, direction, None)
    }

    /// The same, where a vertex is known that is farthest along the direction, up to rounding in f32.
    // Inlined: the direction has just been computed. Read back from memory as pairs of numbers, where it was written one
    // by one, it would wait for all that is before it.
    #[inline(always)]
    pub(super) fn round(polytope: &'a Polytope, direction: DVec3, farthest: Option<u32>) -> Self {
        let choice = Choice { polytope, direction };
        match farthest.and_then(|vertex| choice.corner(vertex)) {
            Some(corner) => choice.round_corner(corner),
            None => choice.part(),
        }
    }

    /// What a segment shows, given its edge from the first vertex to the second: itself, or the end that is farther. `None`
    /// of one without length.
    #[inline(always)]
    pub(super) fn of_edge(edge: DVec3, direction: DVec3) -> Option<Part<'static>> {
        let (rise, square) = (direction.dot(edge), edge.length_squared());
        // By squares, which take neither a root nor a quotient. False for one without length, and for NaN.
        let has_length = square > 0.0 && square.is_finite();
        has_length.then(|| match rise * rise < LEVEL * LEVEL * square {
            true => Part::Edge([0, 1]),
            false => Part::Vertex(u32::from(rise > 0.0)),
        })
    }

    /// Its name.
    pub(super) fn name(&self) -> Feature {
        match *self {
            Part::Vertex(index) => Feature::Vertex(index),
            Part::Edge([j, k]) => edge(j, k),
            Part::Face { index, .. } => Feature::Face(index),
        }
    }
}

/// An edge of two vertices, whichever way it is walked.
pub(super) fn edge(j: u32, k: u32) -> Feature {
    Feature::Edge(j.min(k), j.max(k))
}

/// Which part of a polytope faces a direction of its own frame, of unit length.
struct Choice<'a> {
    polytope: &'a Polytope,
    direction: DVec3,
}

/// A vertex of a hull, and the half-edges that leave it.
struct HullCorner<'a> {
    vertex: u32,
    half_edges: &'a [HalfEdge],
}

/// How many faces round the farthest vertices are listed; of more, all of the polytope's are looked at.
const LISTED: usize = 64;

/// What is no face's number.
const NO_FACE: u32 = u32::MAX;

/// What is no half-edge's number.
const NONE: usize = usize::MAX;

/// Of how many vertices the heights are kept; those of others are computed again.
const KEPT: usize = 64;

/// The vertices that count as farthest.
enum Farthest {
    One(u32),
    Two([u32; 2]),
    /// More, one of which is that.
    More(u32),
}

/// The cosine from which on a face looks along the direction but for rounding, so that none looks more. Larger: faces that are
/// looked for round every farthest vertex. Smaller: a face in place of another that looks more.
const LEVEL_FACE: f64 = 1.0 - 1e-12;

impl<'a> Choice<'a> {
    #[inline(always)]
    fn part(&self) -> Part<'a> {
        match self.polytope.kind() {
            Kind::Point => Some(Part::Vertex(0)),
            Kind::Segment => self.of_segment(),
            Kind::Triangle => self.of_triangle(),
            Kind::Cuboid { .. } => self.of_cuboid(),
            _ => None,
        }
        .unwrap_or_else(|| self.searched())
    }

    /// A vertex with what is round it, where the list of faces is what shows it.
    #[inline(always)]
    fn corner(&self, vertex: u32) -> Option<HullCorner<'a>> {
        if self.polytope.kind() != Kind::Hull {
            return None;
        }
        let half_edges = self.polytope.contact_facets().half_edges_from(vertex);
        // A point that is inside of a face or repeated has no faces.
        (!half_edges.is_empty()).then_some(HullCorner { vertex, half_edges })
    }

    /// What a segment shows, without its list of faces.
    #[inline(always)]
    fn of_segment(&self) -> Option<Part<'a>> {
        let &[start, end] = self.polytope.vertices() else { return None };
        Part::of_edge(end - start, self.direction)
    }

    /// What a box that is not flat shows, by the signs of the direction.
    fn of_cuboid(&self) -> Option<Part<'a>> {
        Some(match cuboids::feature(self.polytope, self.direction)? {
            Feature::Face(index) => {
                let facets: &'a Facets = self.polytope.contact_facets();
                let facet = facets.facets().get(index as usize)?;
                Part::Face { index, normal: facet.normal, corners: facets.corners(facet) }
            }
            Feature::Edge(j, k) => Part::Edge([j, k]),
            Feature::Vertex(k) => Part::Vertex(k),
            Feature::Surface => return None,
        })
    }

    /// What of a triangle that is no needle faces the direction, as its list of faces has it, without the list.
    #[inline(always)]
    fn of_triangle(&self) -> Option<Part<'a>> {
        Some(self.triangle()?.part(self.direction))
    }

    #[inline(always)]
    fn triangle(&self) -> Option<Triangle> {
        let &[p, q, r] = self.polytope.vertices() else { return None };
        Triangle::of([p, q, r])
    }

    // Out of line: the heights that it keeps are more than all else that a part takes.
    #[inline(never)]
    fn searched(&self) -> Part<'a> {
        let mut kept = [0.0; KEPT];
        let (kept, farthest) = self.heights(&mut kept);
        let uneven = self.polytope.contact_facets().unevenness();
        let least = farthest - FARTHEST * self.polytope.outer_radius() - 2.0 * uneven;
        let found = match self.farthest_of(kept, least) {
            Some(Farthest::One(only)) => {
                let half_edges = self.polytope.contact_facets().half_edges_from(only);
                Some(self.round_corner(HullCorner { vertex: only, half_edges }))
            }
            Some(Farthest::Two(ends)) => self.round_edge(ends),
            Some(Farthest::More(one)) => self.level_face(one),
            None => None,
        };
        found.unwrap_or_else(|| self.round_vertices(kept, least))
    }

    /// The vertices that count as farthest, of those whose heights are all kept.
    fn farthest_of(&self, kept: &[f64], least: f64) -> Option<Farthest> {
        if self.polytope.vertices().len() > KEPT {
            return None;
        }
        let (mut count, mut found) = (0, [0; 2]);
        let (fours, rest) = kept.as_chunks::<4>();
        let mut note = |k: usize, along: f64| {
            if along >= least {
                count += 1;
                found = [found[1], k as u32];
            }
        };
        for (j, four) in fours.iter().enumerate() {
            let [p, q, r, s] = *four;
            // Nearly always: one comparison in place of four.
            if larger(larger(p, q), larger(r, s)) >= least {
                four.iter().enumerate().for_each(|(k, &along)| note(4 * j + k, along));
            }
        }
        let after = kept.len() - rest.len();
        rest.iter().enumerate().for_each(|(k, &along)| note(after + k, along));
        match count {
            1 => Some(Farthest::One(found[1])),
            2 => Some(Farthest::Two(found)),
            3.. => Some(Farthest::More(found[1])),
            _ => None,
        }
    }

    /// The face round a vertex that looks along the direction, if one does: several vertices are farthest where it is theirs.
    #[inline(always)]
    fn level_face(&self, vertex: u32) -> Option<Part<'a>> {
        let half_edges = self.polytope.contact_facets().half_edges_from(vertex);
        let (mut cosine, mut face) = (LEVEL_FACE, NONE);
        for (k, half_edge) in half_edges.iter().enumerate() {
            let facing = half_edge.normal.dot(self.direction);
            let is_better = facing > cosine;
            cosine = select_unpredictable(is_better, facing, cosine);
            face = select_unpredictable(is_better, k, face);
        }
        half_edges.get(face).map(|half_edge| self.face_along(half_edge))
    }

    /// What is there round the only farthest vertex. Faces and edges are looked through at once: a branch on what is found
    /// could not be predicted.
    #[inline(always)]
    fn round_corner(&self, HullCorner { vertex: only, half_edges }: HullCorner<'_>) -> Part<'a> {
        let vertices = self.polytope.vertices();
        let at = vertices[only as usize];
        // The face that looks most along the direction; and the edge that rises least, by the square of how much relative to
        // its length, and where it ends. In the order of the faces: the first among equals.
        let (mut cosine, mut face) = (FACING, NONE);
        let (mut slope, mut end) = (LEVEL * LEVEL, only);
        for (k, half_edge) in half_edges.iter().enumerate() {
            let facing = half_edge.normal.dot(self.direction);
            let is_better = facing > cosine;
            cosine = select_unpredictable(is_better, facing, cosine);
            face = select_unpredictable(is_better, k, face);
            let edge = vertices[half_edge.to as usize] - at;
            let rise = self.direction.dot(edge);
            let rising = rise * rise / edge.length_squared();
            // False for an edge without length, and for NaN.
            let is_better = rising < slope;
            slope = select_unpredictable(is_better, rising, slope);
            end = select_unpredictable(is_better, half_edge.to, end);
        }
        if let Some(half_edge) = half_edges.get(face) {
            return self.face_along(half_edge);
        }
        if end == only { Part::Vertex(only) } else { Part::Edge([only.min(end), only.max(end)]) }
    }

    /// What is there round two farthest vertices, in their order: the face that looks most along the direction, else the edge
    /// between them, which rises by rounding alone. `None` where there is neither.
    #[inline(always)]
    fn round_edge(&self, [j, k]: [u32; 2]) -> Option<Part<'a>> {
        let facets: &'a Facets = self.polytope.contact_facets();
        let (mut cosine, mut face) = (FACING, NO_FACE);
        for vertex in [j, k] {
            for half_edge in facets.half_edges_from(vertex) {
                let facing = half_edge.normal.dot(self.direction);
                // The first in their order among equals.
                let is_first = (facing == cosine) & (face != NO_FACE) & (half_edge.face < face);
                let is_better = (facing > cosine) | is_first;
                cosine = if is_better { facing } else { cosine };
                face = if is_better { half_edge.face } else { face };
            }
        }
        if face != NO_FACE {
            return Some(self.face(face));
        }
        let vertices = self.polytope.vertices();
        let edge = vertices[k as usize] - vertices[j as usize];
        let rise = self.direction.dot(edge);
        // False for an edge without length.
        let is_level = rise * rise < LEVEL * LEVEL * edge.length_squared();
        let is_edge = facets.half_edges_from(j).iter().any(|half_edge| half_edge.to == k);
        (is_level && is_edge).then_some(Part::Edge([j, k]))
    }

    /// The face of a half-edge.
    #[inline(always)]
    fn face_along(&self, half_edge: &HalfEdge) -> Part<'a> {
        let facets: &'a Facets = self.polytope.contact_facets();
        let &HalfEdge { face: index, normal, .. } = half_edge;
        Part::Face { index, normal, corners: facets.face_corners(half_edge) }
    }

    fn face(&self, index: u32) -> Part<'a> {
        let facets: &'a Facets = self.polytope.contact_facets();
        let facet = &facets.facets()[index as usize];
        Part::Face { index, normal: facet.normal, corners: facets.corners(facet) }
    }

    /// What is there round several farthest vertices, or one of very many.
    #[inline(never)]
    fn round_vertices(&self, kept: &[f64], least: f64) -> Part<'a> {
        let is_farthest = |k: u32| match kept.get(k as usize) {
            Some(&along) => along >= least,
            None => self.along(k) >= least,
        };
        let facets: &'a Facets = self.polytope.contact_facets();
        let mut listed = [0; LISTED];
        let mut count = 0;
        let mut first = None;
        let mut list = |k: u32| {
            first = first.or(Some(k));
            for half_edge in facets.half_edges_from(k) {
                if let Some(slot) = listed.get_mut(count) {
                    *slot = half_edge.face;
                }
                count += 1;
            }
        };
        let (fours, rest) = kept.as_chunks::<4>();
        for (j, four) in fours.iter().enumerate() {
            let [p, q, r, s] = *four;
            // Nearly always: one comparison in place of four.
            if larger(larger(p, q), larger(r, s)) < least {
                continue;
            }
            for (k, &along) in four.iter().enumerate() {
                if along >= least {
                    list((4 * j + k) as u32);
                }
            }
        }
        let after = (kept.len() - rest.len()) as u32;
        (after..self.polytope.vertices().len() as u32).filter(|&k| is_farthest(k)).for_each(list);
        let found = if let Some(listed) = listed.get_mut(..count) {
            self.face_of(listed.iter().copied()).or_else(|| {
                // In the order of the faces, whoever lists them.
                listed.sort_unstable();
                let is_new = |&k: &usize| k == 0 || listed[k - 1] != listed[k];
                self.edge_of((0..count).filter(is_new).map(|k| listed[k]), is_farthest)
            })
        } else {
            let has_farthest = |&index: &u32| {
                let corners = facets.corners(&facets.facets()[index as usize]);
                corners.iter().any(|&corner| is_farthest(corner))
            };
            let all = || (0..facets.facets().len() as u32).filter(has_farthest);
            self.face_of(all()).or_else(|| self.edge_of(all(), is_farthest))
        };
        found.unwrap_or(Part::Vertex(first.unwrap_or(0)))
    }

    /// How far vertices are along the direction, as many as are kept; and how far the farthest of all is.
    fn heights<'k>(&self, kept: &'k mut [f64; KEPT]) -> (&'k [f64], f64) {
        let vertices = self.polytope.vertices();
        let few = vertices.len().min(KEPT);
        let (fours, rest) = vertices[..few].as_chunks::<4>();
        let mut most = [f64::NEG_INFINITY; 4];
        for (to, [p, q, r, s]) in kept.as_chunks_mut::<4>().0.iter_mut().zip(fours) {
            let d = self.direction;
            *to = [d.dot(*p), d.dot(*q), d.dot(*r), d.dot(*s)];
            most = [
                larger(most[0], to[0]),
                larger(most[1], to[1]),
                larger(most[2], to[2]),
                larger(most[3], to[3]),
            ];
        }
        let mut farthest = larger(larger(most[0], most[1]), larger(most[2], most[3]));
        for (to, &vertex) in kept[few - rest.len()..].iter_mut().zip(rest) {
            *to = self.direction.dot(vertex);
            farthest = larger(farthest, *to);
        }
        for &vertex in &vertices[few..] {
            farthest = larger(farthest, self.direction.dot(vertex));
        }
        (&kept[..few], farthest)
    }

    /// The face that looks most along the direction, of those that look almost that way: the first in their order among
    /// equals, and it comes before any edge.
    fn face_of(&self, faces: impl Iterator<Item = u32>) -> Option<Part<'a>> {
        let facets: &'a Facets = self.polytope.contact_facets();
        let mut best = FACING;
        let mut face: Option<u32> = None;
        for index in faces {
            let facet = &facets.facets()[index as usize];
            let cosine = facet.normal.dot(self.direction);
            let is_first = || cosine == best && face.is_some_and(|other| index < other);
            if (cosine > best || is_first()) && facets.corners(facet).len() > 2 {
                best = cosine;
                face = Some(index);
            }
        }
        face.map(|index| self.face(index))
    }

    /// The edge that rises least, of those of these faces that have a farthest end: the first among equals.
    fn edge_of(
        &self,
        faces: impl Iterator<Item = u32>,
        is_farthest: impl Fn(u32) -> bool,
    ) -> Option<Part<'a>> {
        let facets: &'a Facets = self.polytope.contact_facets();
        let mut best = LEVEL;
        let mut edge = None;
        for index in faces {
            let corners = facets.corners(&facets.facets()[index as usize]);
            let mut last = corners[corners.len() - 1];
            for &corner in corners {
                if is_farthest(last) || is_farthest(corner) {
                    let rise = self.rise(last, corner);
                    if rise < best {
                        best = rise;
                        edge = Some(Part::Edge([last.min(corner), last.max(corner)]));
                    }
                }
                last = corner;
            }
        }
        edge
    }

    fn along(&self, k: u32) -> f64 {
        self.direction.dot(self.polytope.vertices()[k as usize])
    }

    /// How much an edge rises, relative to its length. Above any limit for one without length.
    fn rise(&self, j: u32, k: u32) -> f64 {
        let vertices = self.polytope.vertices();
        let (v, w) = (vertices[j as usize], vertices[k as usize]);
        let length = v.distance(w);
        if length > 0.0 { (self.along(j) - self.along(k)).abs() / length } else { f64::INFINITY }
    }
}

#[cfg(test)]
mod tests;
