//! Which face, edge or corner of a triangle faces a direction.

use super::{FACING, FARTHEST, LEVEL, Part, larger};
use crate::query::Feature;
use dcd_geom::glam::DVec3;
use std::hint::select_unpredictable;

/// The area of a triangle beside the square of its longest edge below which its normal is left to the list of faces.
const NEEDLE: f64 = 1e-5;

/// The squares of lengths, metres², of which areas are compared by their squares: these stay in range. Others are left to the
/// list of faces.
const TRIANGLES: std::ops::Range<f64> = 1e-70..1e70;

/// The edges, in the order in which they are compared.
const EDGES: [[u32; 2]; 3] = [[0, 2], [0, 1], [1, 2]];

/// What a triangle can show: its edges, its corners, and its faces.
const FEATURES: [Feature; 8] = [
    Feature::Edge(0, 2),
    Feature::Edge(0, 1),
    Feature::Edge(1, 2),
    Feature::Vertex(0),
    Feature::Vertex(1),
    Feature::Vertex(2),
    Feature::Face(0),
    Feature::Face(1),
];

/// The number of the first corner, and of the first face, in their order.
const VERTEX: usize = 3;
const FACE: usize = 6;

/// A triangle that is no needle.
pub(super) struct Triangle {
    corners: [DVec3; 3],
    /// Counter-clockwise round it; and the square of its length.
    normal: DVec3,
    area: f64,
    /// Of the edges' lengths, in their order, and the longest.
    squares: [f64; 3],
    longest: f64,
}

impl Part<'_> {
    /// Which of three corners, counter-clockwise round the first face's normal, face a direction of their own axes, of unit
    /// length; `None` of a needle.
    #[inline(always)]
    pub(in super::super) fn of_triangle(
        corners: [DVec3; 3],
        direction: DVec3,
    ) -> Option<Part<'static>> {
        Some(Triangle::of(corners)?.part(direction))
    }
}

impl Triangle {
    /// By squares: no root is taken. `None` of a needle.
    #[inline(always)]
    pub(super) fn of(corners: [DVec3; 3]) -> Option<Self> {
        let [p, q, r] = corners;
        let (to_q, to_r) = (q - p, r - p);
        let normal = to_q.cross(to_r);
        let squares = [to_r.length_squared(), to_q.length_squared(), (r - q).length_squared()];
        let longest = larger(larger(squares[1], squares[0]), squares[2]);
        let area = normal.length_squared();
        // Written so that NaN, and what leaves the range, is a needle.
        let is_wide = area > NEEDLE * NEEDLE * (longest * longest);
        (is_wide && TRIANGLES.contains(&longest)).then_some(Self {
            corners,
            normal,
            area,
            squares,
            longest,
        })
    }

    #[inline(always)]
    pub(super) fn part(&self, direction: DVec3) -> Part<'static> {
        let facing = self.normal.dot(direction);
        if self.is_face(facing) {
            let unit = self.normal.normalize();
            return match facing > 0.0 {
                true => Part::Face { index: 0, normal: unit, corners: &[0, 1, 2] },
                false => Part::Face { index: 1, normal: -unit, corners: &[2, 1, 0] },
            };
        }
        match self.edge_or_corner(direction) {
            edge @ 0..VERTEX => Part::Edge(EDGES[edge]),
            corner => Part::Vertex((corner - VERTEX) as u32),
        }
    }

    /// The same by name alone. Selected: what a sphere touches cannot be predicted.
    #[inline(always)]
    pub(super) fn name(&self, direction: DVec3) -> Feature {
        let facing = self.normal.dot(direction);
        let face = FACE + usize::from(!(facing > 0.0));
        let other = self.edge_or_corner(direction);
        FEATURES[select_unpredictable(self.is_face(facing), face, other)]
    }

    #[inline(always)]
    fn is_face(&self, facing: f64) -> bool {
        facing * facing > FACING * FACING * self.area
    }

    /// The edge that rises least, if it rises little and an end is farthest, else the first corner that is, by their numbers.
    #[inline(always)]
    fn edge_or_corner(&self, direction: DVec3) -> usize {
        let [p, q, r] = self.corners;
        let along = [p.dot(direction), q.dot(direction), r.dot(direction)];
        let most = larger(larger(along[0], along[1]), along[2]);
        let near = FARTHEST * FARTHEST * self.longest;
        let mut is_farthest = [false; 3];
        for (is_farthest, along) in is_farthest.iter_mut().zip(along) {
            let below = most - along;
            *is_farthest = (below <= 0.0) | (below * below <= near);
        }
        let second = select_unpredictable(is_farthest[2], VERTEX + 2, VERTEX);
        let second = select_unpredictable(is_farthest[1], VERTEX + 1, second);
        let mut found = select_unpredictable(is_farthest[0], VERTEX, second);
        // The square of how much an edge rises relative to its length.
        let mut least = LEVEL * LEVEL;
        for (number, ([j, k], square)) in EDGES.into_iter().zip(self.squares).enumerate() {
            let (j, k) = (j as usize, k as usize);
            let rise = along[j] - along[k];
            let rise = rise * rise / square;
            let is_better = (rise < least) & (is_farthest[j] | is_farthest[k]);
            least = select_unpredictable(is_better, rise, least);
            found = select_unpredictable(is_better, number, found);
        }
        found
    }
}
