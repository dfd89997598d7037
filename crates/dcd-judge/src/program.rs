//! Linear programming in whole numbers: the simplex method on a tableau with one common divisor,
//! which stays whole. It takes the steepest column, which is quick, and after some steps Bland's
//! rule, which ends.

use crate::world::Point;
use num_bigint::{BigInt, Sign};

/// Whether Σλa = Σμb, Σλ = 1, Σμ = 1 has a solution with λ, μ ≥ 0.
pub(crate) fn hulls_touch(a: &[Point], b: &[Point]) -> bool {
    let one = || BigInt::from(1);
    let mut rows: Vec<Vec<BigInt>> = (0..3)
        .map(|k| {
            let of_a = a.iter().map(|p| p[k].clone());
            of_a.chain(b.iter().map(|p| -&p[k])).chain([BigInt::ZERO]).collect()
        })
        .collect();
    let (zeros_a, zeros_b) = (vec![BigInt::ZERO; a.len()], vec![BigInt::ZERO; b.len()]);
    let (ones_a, ones_b) = (vec![one(); a.len()], vec![one(); b.len()]);
    rows.push([ones_a, zeros_b, vec![one()]].concat());
    rows.push([zeros_a, ones_b, vec![one()]].concat());
    is_feasible(rows)
}

/// Steps of the steepest column before Bland's rule. Any number ends; hulls need some ten.
const STEEPEST: usize = 40;

/// Whether rows·x = last column has a solution x ≥ 0; the last column must not be negative.
fn is_feasible(mut rows: Vec<Vec<BigInt>>) -> bool {
    let columns = rows[0].len() - 1;
    // The cost of the artificial variables that begin as the basis, one a row.
    let cost = (0..=columns).map(|c| -rows.iter().map(|row| &row[c]).sum::<BigInt>()).collect();
    let mut basis: Vec<usize> = (columns..columns + rows.len()).collect();
    rows.push(cost);
    let mut divisor = BigInt::from(1);
    let zero = BigInt::ZERO;
    let mut step = 0;
    loop {
        let (cost, constraints) = rows.split_last().unwrap();
        if cost[columns] == zero {
            return true;
        }
        let mut falling = (0..columns).filter(|&c| cost[c] < zero);
        let enters = match step {
            0..STEEPEST => falling.min_by_key(|&c| &cost[c]),
            _ => falling.next(),
        };
        let Some(enters) = enters else { return false };
        let candidates = (0..constraints.len()).filter(|&r| constraints[r][enters] > zero);
        let leaves = candidates.reduce(|best, r| {
            let (ours, theirs) = (&constraints[r], &constraints[best]);
            let (x, y) = (&ours[columns] * &theirs[enters], &theirs[columns] * &ours[enters]);
            if x < y || x == y && basis[r] < basis[best] { r } else { best }
        });
        // A cost that is bounded below by 0 always has one.
        let Some(leaves) = leaves else { return false };
        pivot(&mut rows, leaves, enters, &divisor);
        divisor = rows[leaves][enters].clone();
        basis[leaves] = enters;
        step += 1;
    }
}

fn pivot(rows: &mut [Vec<BigInt>], leaves: usize, enters: usize, divisor: &BigInt) {
    let with = rows[leaves].clone();
    for (r, row) in rows.iter_mut().enumerate() {
        if r != leaves {
            let factor = row[enters].clone();
            for (x, y) in row.iter_mut().zip(&with) {
                let is_zero = |x: &BigInt| x.sign() == Sign::NoSign;
                match (is_zero(x), is_zero(y) || is_zero(&factor)) {
                    (true, true) => {}
                    (false, true) => *x = &*x * &with[enters] / divisor,
                    (true, false) => *x = -(&factor * y / divisor),
                    (false, false) => *x = (&*x * &with[enters] - &factor * y) / divisor,
                }
            }
        }
    }
}
