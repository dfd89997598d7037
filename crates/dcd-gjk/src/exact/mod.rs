//! The last rung: yes or no for two polytopes, rounded or not, in exact integers.
//!
//! World vertices R·v + t are dyadic numbers, so on a fine enough grid they are integers, and so
//! are the radii. GJK runs on them without rounding. Each step computes the point nearest to the
//! origin from its simplex alone, so numbers do not grow with the steps. It ends: a step that
//! proves nothing finds a vertex strictly beyond the plane through the nearest point, so the next
//! nearest point is strictly nearer, no simplex comes twice, and there are finitely many
//! (docs/numerics.md, "the exact rung").

mod grid;
mod integer;

use crate::Body;
use crate::simplex::{Nearest, Triple, dot, nearest};
use dcd_geom::Polytope;
use grid::{Extent, Grid};
use integer::{Integer, Large, Small};
use std::cmp::Ordering;

/// Whether the two share a point, touching included.
///
/// `hint` names vertices of a simplex to begin with, by their indices in A and B; any do, or none.
pub(crate) fn touches(a: Body<'_, Polytope>, b: Body<'_, Polytope>, hint: &[[u32; 2]]) -> bool {
    let extent = Extent::of(a, b);
    if extent.is_small() {
        Search::<Small>::new(Grid::new(a, b, &extent), hint).run()
    } else {
        Search::<Large>::new(Grid::new(a, b, &extent), hint).run()
    }
}

struct Search<'a, T> {
    grid: Grid<'a, T>,
    radius_squared: T,
    points: Vec<Triple<T>>,
}

impl<'a, T: Integer> Search<'a, T> {
    fn new(grid: Grid<'a, T>, hint: &[[u32; 2]]) -> Self {
        let mut points = Vec::with_capacity(4);
        for pair in hint.iter().take(3) {
            points.push(grid.point(pair.map(|k| k as usize)));
        }
        if points.is_empty() {
            points.push(grid.point([0, 0]));
        }
        let radius_squared = grid.radius().times(grid.radius());
        Self { grid, radius_squared, points }
    }

    fn run(mut self) -> bool {
        // Empty never, by construction; then nothing is known to touch.
        while let Some(near) = nearest(&self.points) {
            if self.is_within_radius(&near) {
                return true;
            }
            let vertex = self.grid.point(self.grid.lowest(&near.direction));
            if self.separates(&near.direction, &vertex) {
                return false;
            }
            self.points = near.kept[..near.count].iter().map(|&k| self.points[k].clone()).collect();
            self.points.push(vertex);
        }
        false
    }

    /// |v|² ≤ R².
    fn is_within_radius(&self, near: &Nearest<T>) -> bool {
        let [numerator, divisor] = &near.square;
        numerator.minus(&self.radius_squared.times(divisor)).sign() != Some(Ordering::Greater)
    }

    /// s > 0 and s² > R²·|d|², with s = d·w the separation.
    fn separates(&self, direction: &Triple<T>, vertex: &Triple<T>) -> bool {
        let separation = dot(direction, vertex);
        if !separation.is_positive() || !self.radius_squared.is_positive() {
            return separation.is_positive();
        }
        let swept = self.radius_squared.times(&dot(direction, direction));
        separation.times(&separation).minus(&swept).is_positive()
    }
}
