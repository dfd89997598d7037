//! Close calls in double-double: the end of f64's search, with twice the digits.
//!
//! What f64 leaves open is rarely exact touching: mostly a gap or an overlap of some 1e-17 of the
//! pair's size, which 106 bits resolve at a tenth of the cost of integers. The search goes on where
//! f64's ended, and ends in a separating axis or four vertices round the origin, each with its
//! rounding bound (docs/numerics/proofs.md, "close calls").

use super::grid::{Extent, Grid};
use crate::PosedSupport;
use crate::double_double::{DoubleDouble, EPSILON};
use crate::simplex::{Triple, determinant, dot, minus, nearest, norm1};
use dcd_geom::Polytope;

/// How many steps the search may take. No unit. It starts where f64 ended: two are the rule.
/// Larger: what cycles in rounding costs more before it goes to integers.
const MAX_STEPS: usize = 6;

/// How far a computed separation d·w may be above the true one. Unit: ε·|d|₁, at m < 1. The vertex
/// loses 5.01 and the product with d 3; that the vertex is the lowest, 12. (docs/numerics/proofs.md, "close
/// calls")
const APART: f64 = 32.0;

/// How far a determinant of three points may be from that seen from any point of the true ones'
/// error cube. Unit: ε·(permanent + |e₁|₁·|e₂|₁), at m < 1: 6 of the first and 5.1 of the second.
const FACE: f64 = 8.0;

/// A simplex nearer to the origin than this counts as through it. Unit: ε, at m < 1. Decides which method
/// resolves a pair, never an answer.
const THROUGH: f64 = 64.0;

/// Whether two polytopes without radii touch, from a simplex of vertices by index; `None` where
/// 106 bits do not decide. `unit` is the exponent of a power of two above their size m.
pub(super) fn touch(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    unit: i32,
    hint: &[[u32; 2]],
) -> Option<bool> {
    let grid = Grid::<DoubleDouble>::new(a, b, &Extent::coarse(unit));
    let mut simplex = Simplex::default();
    for pair in hint.iter().take(3) {
        simplex.push(&grid, pair.map(|k| k as usize));
    }
    for _ in 0..MAX_STEPS {
        let near = nearest(simplex.points())?;
        if near.count == 4 {
            return holds_origin(&simplex.points).then_some(true);
        }
        let [squared, divisor] = near.square.map(DoubleDouble::to_f64);
        // Written so that NaN leaves the pair to integers.
        if !(squared > (THROUGH * EPSILON).powi(2) * divisor) {
            return None;
        }
        let pair = grid.lowest(&near.direction);
        let separation = dot(&near.direction, &grid.point(pair)).to_f64();
        if separation > APART * EPSILON * norm1(&near.direction.map(DoubleDouble::to_f64)) {
            return Some(false);
        }
        if simplex.pairs[..simplex.count].contains(&pair) {
            return None;
        }
        simplex.keep(&near.kept[..near.count]);
        simplex.push(&grid, pair);
    }
    None
}

/// Up to four vertices of a difference, and where they come from.
struct Simplex {
    points: [Triple<DoubleDouble>; 4],
    pairs: [[usize; 2]; 4],
    count: usize,
}

impl Default for Simplex {
    fn default() -> Self {
        let origin = [DoubleDouble::from(0.0); 3];
        Self { points: [origin; 4], pairs: [[0; 2]; 4], count: 0 }
    }
}

impl Simplex {
    fn points(&self) -> &[Triple<DoubleDouble>] {
        &self.points[..self.count]
    }

    /// Adds a vertex; a fifth is left out.
    fn push(&mut self, grid: &Grid<'_, DoubleDouble>, pair: [usize; 2]) {
        if self.count < 4 {
            self.points[self.count] = grid.point(pair);
            self.pairs[self.count] = pair;
            self.count += 1;
        }
    }

    fn keep(&mut self, kept: &[usize]) {
        let (points, pairs) = (self.points, self.pairs);
        for (to, &from) in kept.iter().enumerate() {
            (self.points[to], self.pairs[to]) = (points[from], pairs[from]);
        }
        self.count = kept.len();
    }
}

/// Whether the hull of four computed points surely holds the origin: each face sees the whole cube
/// of their errors on its inner side. False for NaN.
fn holds_origin(points: &[Triple<DoubleDouble>; 4]) -> bool {
    let [p0, p1, p2, p3] = points;
    let faces = [[p1, p2, p3], [p0, p3, p2], [p0, p1, p3], [p0, p2, p1]];
    let volumes = faces.map(|[x, y, z]| determinant(x, y, z).to_f64());
    let sign = volumes[0].signum();
    faces.iter().zip(volumes).all(|(&[x, y, z], volume)| volume * sign > face_error(x, y, z))
}

fn face_error(x: &Triple<DoubleDouble>, y: &Triple<DoubleDouble>, z: &Triple<DoubleDouble>) -> f64 {
    let size = |p: &Triple<DoubleDouble>| p.map(|c| c.to_f64().abs());
    let ([x0, x1, x2], [y0, y1, y2], [z0, z1, z2]) = (size(x), size(y), size(z));
    let permanent = x0 * (y1 * z2 + y2 * z1) + x1 * (y2 * z0 + y0 * z2) + x2 * (y0 * z1 + y1 * z0);
    let edge = |to: &Triple<DoubleDouble>| norm1(&size(&minus(to, x)));
    FACE * EPSILON * (permanent + edge(y) * edge(z)) + f64::MIN_POSITIVE
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::Pose;
    use dcd_geom::glam::{DQuat, DVec3};
    use proptest::prelude::*;

    /// The verdict in double-double from the end of f64's search, where it has one that of the exact integers.
    fn resolved(a: &(Polytope, Pose), b: &(Polytope, Pose)) -> Option<bool> {
        let (a, b) = (PosedSupport::polytope(&a.0, &a.1), PosedSupport::polytope(&b.0, &b.1));
        let difference = crate::Difference::<f64, _, _>::new(a, b).unwrap();
        let (_, simplex) = crate::gjk::overlap_with_simplex(&difference);
        let hint: Vec<_> = simplex.vertices().iter().map(|v| [v.a.feature, v.b.feature]).collect();
        let unit = 1023 - (difference.scale().to_bits() >> 52) as i32;
        let answer = touch(a, b, unit, &hint);
        let truth = crate::exact::touches(a, b, &[]);
        assert!(answer.is_none_or(|touches| touches == truth), "{a:?} {b:?}");
        answer
    }

    fn wedge(points: [[f64; 3]; 5]) -> Polytope {
        Polytope::hull(points.map(DVec3::from_array).to_vec()).unwrap()
    }

    #[test]
    fn gaps_far_below_an_ulp_are_resolved_and_exact_touching_is_left_open() {
        let square = Polytope::hull(vec![
            DVec3::new(-1.0, -1.0, 0.0),
            DVec3::new(1.0, -1.0, 0.0),
            DVec3::new(1.0, 1.0, 0.0),
            DVec3::new(-1.0, 1.0, 0.0),
        ])
        .unwrap();
        let roof = wedge([
            [0.25, 0.5, 0.0],
            [-0.5, 0.25, 0.0],
            [0.25, -0.5, 0.0],
            [0.0, 0.0, 1.0],
            [0.1, 0.0, 0.5],
        ]);
        let at = |z: f64| Pose::from_translation(DVec3::new(0.125, 0.0625, z)).unwrap();
        let floor = (square, at(0.0));
        assert_eq!(resolved(&floor, &(roof.clone(), at(1e-26))), Some(false));
        assert_eq!(resolved(&floor, &(roof.clone(), at(0.0))), None);
    }

    proptest! {
        #[test]
        fn every_verdict_is_that_of_the_integers(
            a in prop::array::uniform5(prop::array::uniform3(-1.0..1.0f64)),
            b in prop::array::uniform5(prop::array::uniform3(-1.0..1.0f64)),
            turn in prop::array::uniform3(-3.0..3.0f64), way in prop::array::uniform3(-1.0..1.0f64),
            shared in any::<bool>(),
        ) {
            let [x, y, z] = turn;
            let turn = DQuat::from_rotation_x(x) * DQuat::from_rotation_y(y) * DQuat::from_rotation_z(z);
            let way = DVec3::from_array(way);
            let here = (wedge(a), Pose::new(turn, way).unwrap());
            let other = wedge(if shared { a } else { b });
            let at = |way: DVec3| Pose::new(turn, way).unwrap();
            // To where the answer flips, between neighbouring multiples of `way`.
            let touches = |s: f64| {
                let there = at(way + way * s);
                crate::exact::touches(
                    PosedSupport::polytope(&here.0, &here.1), PosedSupport::polytope(&other, &there), &[])
            };
            let (mut low, mut high) = (0.0, 64.0);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                *(if touches(middle) { &mut low } else { &mut high }) = middle;
            }
            resolved(&here, &(other.clone(), at(way + way * low)));
            resolved(&here, &(other, at(way + way * high)));
        }
    }
}
