//! The last method: yes or no for two polytopes, rounded or not, in exact integers; and before it
//! what is cheaper and proved as well, a closed form for parallel boxes and double-double.
//!
//! World vertices R·v + t are dyadic numbers, so on a fine enough grid they are integers, and so
//! are the radii. GJK runs on them without rounding. Each step computes the point nearest to the
//! origin from its simplex alone, so numbers do not grow with the steps. It ends: a step that
//! proves nothing finds a vertex strictly beyond the plane through the nearest point, so the next
//! nearest point is strictly nearer, no simplex comes twice, and there are finitely many
//! (docs/numerics/proofs.md, "the exact method").

pub(crate) mod boxes;
mod close;
pub(crate) mod double_double;
mod expansion;
pub(crate) mod grid;
mod integer;
pub(crate) mod nearest_point;
pub(crate) mod resting;

use crate::simplex::{Nearest, Triple, dot, nearest};
use crate::{Difference, PosedSupport};
use dcd_geom::Polytope;
use grid::{Extent, Grid};
use integer::Small;
use std::cmp::Ordering;

pub(crate) use integer::{Integer, Large, Number};
pub(crate) use nearest_point::{Exact, closest};

/// Whether the two share a point, touching included.
///
/// `hint` names vertices of a simplex to begin with, by their indices in A and B; any do, or none.
pub(crate) fn touches(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    hint: &[[u32; 2]],
) -> bool {
    let extent = Extent::of(a, b);
    if extent.is_small() {
        ExactGjk::<Small>::new(Grid::new(a, b, &extent), hint).run()
    } else if let Some(touch) = close_call(a, b, hint) {
        touch
    } else {
        ExactGjk::<Large>::new(Grid::new(a, b, &extent), hint).run()
    }
}

/// The verdict in double-double. `None` where it has none, for cores outside the range of its bounds, and
/// without a simplex to begin with.
fn close_call(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    hint: &[[u32; 2]],
) -> Option<bool> {
    let swept = a.map.swept_radius() > 0.0 || b.map.swept_radius() > 0.0;
    if swept || hint.is_empty() {
        return None;
    }
    let scale = Difference::<f64, _, _>::new(a, b)?.scale();
    // The scale is a power of two.
    close::touch(a, b, 1023 - (scale.to_bits() >> 52) as i32, hint)
}

struct ExactGjk<'a, T> {
    grid: Grid<'a, T>,
    radius_squared: T,
    /// The simplex, and which vertices its points stem from.
    points: Vec<Triple<T>>,
    pairs: Vec<[usize; 2]>,
}

impl<'a, T: Integer> ExactGjk<'a, T> {
    fn new(grid: Grid<'a, T>, hint: &[[u32; 2]]) -> Self {
        // Three at most, so that no tetrahedron of the search is flat.
        let hint = hint.iter().take(3).map(|pair| pair.map(|k| k as usize));
        let mut pairs: Vec<[usize; 2]> = hint.collect();
        if pairs.is_empty() {
            pairs.push([0, 0]);
        }
        let points = pairs.iter().map(|&pair| grid.point(pair)).collect();
        let radius_squared = grid.radius().times(grid.radius());
        Self { grid, radius_squared, points, pairs }
    }

    fn run(mut self) -> bool {
        // Empty never, by construction; then nothing is known to touch.
        while let Some(near) = nearest(&self.points) {
            if self.is_within_radius(&near) {
                return true;
            }
            let pair = self.grid.lowest(&near.direction);
            let vertex = self.grid.point(pair);
            if self.separates(&near.direction, &vertex) {
                return false;
            }
            self.step(&near, pair, vertex);
        }
        false
    }

    /// Keeps what spans the nearest point, and adds a vertex.
    fn step(&mut self, near: &Nearest<T>, pair: [usize; 2], vertex: Triple<T>) {
        let kept = &near.kept[..near.count];
        self.points = kept.iter().map(|&k| self.points[k].clone()).collect();
        self.pairs = kept.iter().map(|&k| self.pairs[k]).collect();
        self.points.push(vertex);
        self.pairs.push(pair);
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
