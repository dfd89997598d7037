use super::*;
use crate::{Polytope, SupportMap};
use glam::DVec3;

/// A number in [−1, 1).
fn number(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
    (*state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

fn vector(state: &mut u64) -> DVec3 {
    DVec3::new(number(state), number(state), number(state))
}

/// That both find the same vertex, the first among equals.
fn compare<R: Real>(hull: &Polytope, direction: DVec3, of: &str) {
    let direction = R::Vec3::from_dvec3(direction);
    let scanned: Support<R> = hull.support(direction);
    let (one, other) = (farthest(hull.vertices(), direction), scanned);
    assert_eq!(one, other, "{of}, along {direction:?}");
}

fn compare_all(points: Vec<DVec3>, normal: DVec3, state: &mut u64, of: &str) {
    let hull = Polytope::hull(points).unwrap();
    assert!(hull.vertex_blocks().len() > 1, "{of}");
    let around = |k: i32, state: &mut u64| normal + vector(state) * 0.1f64.powi(k);
    let mut directions: Vec<DVec3> = (0..12).map(|k| around(k, state)).collect();
    directions.extend([DVec3::X, -DVec3::Z, normal, -normal, normal * 1e-9, normal * 1e9]);
    directions.extend([normal * 1e-30, normal * 1e30, normal * 1e-44, DVec3::ZERO]);
    for direction in directions {
        compare::<f64>(&hull, direction, of);
        compare::<f32>(&hull, direction, of);
    }
}

#[test]
fn the_farthest_is_that_of_a_plain_search_bit_for_bit() {
    let mut state = 7;
    for count in [17, 31, 32, 33, 100, 300] {
        for (scale, far) in [(1.0, 0.0), (1e-6, 0.0), (1e6, 0.0), (1.0, 1e3), (1e-3, 1e6)] {
            let middle = vector(&mut state) * far;
            let normal = vector(&mut state).normalize();
            let name = |what: &str| format!("{what}: {count} points, {scale} m, {far} m off");
            let state = &mut state;
            let ball = (0..count).map(|_| middle + vector(state).normalize() * scale).collect();
            compare_all(ball, normal, state, &name("ball"));
            // Nearly all as far as each other along the normal: those that f32 cannot tell apart are decided.
            let (u, v) = normal.any_orthonormal_pair();
            let plane = |state: &mut u64, off: f64| {
                middle
                    + (u * number(state) + v * number(state) + normal * (number(state) * off))
                        * scale
            };
            for off in [0.0, 1e-8, 1e-15] {
                let flat = (0..count).map(|_| plane(state, off)).collect();
                compare_all(flat, normal, state, &name("flat"));
            }
            // Many equal ones, of which the first counts.
            let lattice = |state: &mut u64| middle + (vector(state) * 1.5).round() * scale;
            let equal = (0..count).map(|_| lattice(state)).collect();
            compare_all(equal, normal, state, &name("lattice"));
        }
    }
}
