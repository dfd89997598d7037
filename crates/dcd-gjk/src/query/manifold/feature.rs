//! What a polytope shows along a normal: a face, an edge or a vertex, seen from there.

use super::Feature;
use dcd_geom::glam::{DMat3, DVec2, DVec3};
use dcd_geom::{Facet, Facets, Polytope};

/// The least cosine between a face's normal and the contact's for the face to lie in it: 15
/// degrees. Larger: boxes that rock on two points. Smaller: points far from where shapes touch.
pub(super) const FACING: f64 = 0.966;

/// The most that an edge may rise along the contact's normal, relative to its length: 15 degrees.
const LEVEL: f64 = 0.259;

/// How far below the farthest a vertex may be to count as farthest, relative to the size.
const FARTHEST: f64 = 1e-9;

/// The plane that a normal looks at, and the height along it.
pub(super) struct View {
    x: DVec3,
    y: DVec3,
    normal: DVec3,
}

/// A feature as it is seen.
pub(super) struct Seen<'a> {
    view: &'a View,
    polytope: &'a Polytope,
    rotation: &'a DMat3,
    place: DVec3,
    part: Part<'a>,
}

/// What of the polytope it is.
enum Part<'a> {
    Vertex(u32),
    Edge([u32; 2]),
    Face {
        index: u32,
        facet: &'a Facet,
        corners: &'a [u32],
        /// Whether its corners go round clockwise: it looks against the normal.
        clockwise: bool,
    },
}

/// A corner of a feature: its index, its place in the plane, its height.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub(super) index: u32,
    pub(super) at: DVec2,
    pub(super) height: f64,
}

impl View {
    pub(super) fn along(normal: DVec3) -> Self {
        let (x, y) = normal.any_orthonormal_pair();
        Self { x, y, normal }
    }

    /// The place of a vector in the plane, and its height.
    pub(super) fn of(&self, v: DVec3) -> (DVec2, f64) {
        (DVec2::new(self.x.dot(v), self.y.dot(v)), self.normal.dot(v))
    }

    /// Back from the plane.
    pub(super) fn in_world(&self, at: DVec2, height: f64) -> DVec3 {
        self.x * at.x + self.y * at.y + self.normal * height
    }

    /// What a polytope, rotated and then moved, shows along the normal times `sense`, which is 1
    /// or −1.
    pub(super) fn seen<'a>(
        &'a self,
        polytope: &'a Polytope,
        rotation: &'a DMat3,
        place: DVec3,
        sense: f64,
    ) -> Seen<'a> {
        let direction = rotation.transpose() * (self.normal * sense);
        let part = Choice { polytope, direction }.part(sense < 0.0);
        Seen { view: self, polytope, rotation, place, part }
    }
}

impl Seen<'_> {
    /// What it is as a whole.
    pub(super) fn whole(&self) -> Feature {
        match self.part {
            Part::Vertex(index) => Feature::Vertex(index),
            Part::Edge([j, k]) => edge(j, k),
            Part::Face { index, .. } => Feature::Face(index),
        }
    }

    /// How many corners it has.
    pub(super) fn len(&self) -> usize {
        match self.part {
            Part::Vertex(_) => 1,
            Part::Edge(_) => 2,
            Part::Face { corners, .. } => corners.len(),
        }
    }

    /// Its corners, counter-clockwise as the normal looks back on them.
    pub(super) fn points(&self) -> impl Iterator<Item = Point> + '_ {
        (0..self.len()).map(|k| self.point(k))
    }

    fn point(&self, k: usize) -> Point {
        let index = match self.part {
            Part::Vertex(index) => index,
            Part::Edge(ends) => ends[k],
            Part::Face { corners, clockwise: false, .. } => corners[k],
            Part::Face { corners, .. } => corners[corners.len() - 1 - k],
        };
        let world = *self.rotation * self.polytope.vertices()[index as usize] + self.place;
        let (at, height) = self.view.of(world);
        Point { index, at, height }
    }

    /// How square to the normal its face is: the cosine between the two, 0 where it is no face.
    pub(super) fn facing(&self) -> f64 {
        match self.part {
            Part::Face { facet, .. } => (*self.rotation * facet.normal).dot(self.view.normal).abs(),
            _ => 0.0,
        }
    }

    /// The height of its face's plane above a place, or of its first corner where it is no face.
    pub(super) fn height(&self, at: DVec2) -> f64 {
        let base = self.point(0);
        let Part::Face { facet, .. } = self.part else { return base.height };
        let (slope, rise) = self.view.of(*self.rotation * facet.normal);
        base.height - slope.dot(at - base.at) / rise
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

impl<'a> Choice<'a> {
    fn part(&self, clockwise: bool) -> Part<'a> {
        let least = self.farthest() - FARTHEST * self.polytope.outer_radius();
        let is_farthest = |&k: &u32| self.along(k) >= least;
        let facets: &'a Facets = self.polytope.facets();
        let mut facing = FACING;
        let mut found = None;
        let mut level = LEVEL;
        let mut lying = None;
        for (index, facet) in (0u32..).zip(facets.facets()) {
            let corners = facets.corners(facet);
            if !corners.iter().any(is_farthest) {
                continue;
            }
            let cosine = facet.normal.dot(self.direction);
            if cosine > facing && corners.len() > 2 {
                facing = cosine;
                found = Some(Part::Face { index, facet, corners, clockwise });
            }
            let mut last = corners[corners.len() - 1];
            for &corner in corners {
                if is_farthest(&last) || is_farthest(&corner) {
                    let rise = self.rise(last, corner);
                    if rise < level {
                        level = rise;
                        lying = Some(Part::Edge([last.min(corner), last.max(corner)]));
                    }
                }
                last = corner;
            }
        }
        let vertices = 0..self.polytope.vertices().len() as u32;
        let vertex = || Part::Vertex(vertices.clone().find(is_farthest).unwrap_or(0));
        found.or(lying).unwrap_or_else(vertex)
    }

    fn along(&self, k: u32) -> f64 {
        self.direction.dot(self.polytope.vertices()[k as usize])
    }

    fn farthest(&self) -> f64 {
        let vertices = self.polytope.vertices().iter();
        vertices.map(|&v| self.direction.dot(v)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// How much an edge rises, relative to its length. Above any limit for one without length.
    fn rise(&self, j: u32, k: u32) -> f64 {
        let [v, w] = [j, k].map(|k| self.polytope.vertices()[k as usize]);
        let length = v.distance(w);
        if length > 0.0 { (self.along(j) - self.along(k)).abs() / length } else { f64::INFINITY }
    }
}
