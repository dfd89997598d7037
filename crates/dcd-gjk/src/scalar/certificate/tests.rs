use super::*;
use crate::PosedSupport;
use crate::exact::grid::{Extent, Grid};
use crate::exact::nearest_point::scaled;
use crate::exact::{Integer, Large, Number};
use crate::simplex::Scalar;
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Polytope, Pose};
use proptest::prelude::*;

/// Numbers with every exponent that matters beside 1, and exact small ones.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        -1.0f64..1.0,
        (-1.0f64..1.0, -40i32..0).prop_map(|(x, e)| x * 2f64.powi(e)),
        (-4i32..5).prop_map(|k| f64::from(k) / 4.0),
    ]
}

fn vector() -> impl Strategy<Value = DVec3> {
    (number(), number(), number()).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

fn pose(far: f64) -> impl Strategy<Value = Pose> {
    let turn = (vector(), -3.2f64..3.2).prop_map(|(axis, angle)| {
        DQuat::from_axis_angle(axis.try_normalize().unwrap_or(DVec3::X), angle)
    });
    (turn, vector()).prop_map(move |(q, t)| Pose::new(q, t + DVec3::splat(far)).unwrap())
}

fn exponent(scale: f64) -> i32 {
    1023 - (scale.to_bits() >> 52) as i32
}

/// x / 2^unit exactly, for an x that is far above the unit.
fn on(x: f64, unit: i32) -> Large {
    Number::on_grid(x, unit)
}

/// |x| as a number, to a few digits.
fn rough(x: &Large, unit: i32) -> f64 {
    let (mantissa, exponent) = x.to_float();
    scaled(mantissa, exponent + i64::from(unit)).abs()
}

/// How far the separation along `d` and the vertex are off, in their units: u·m·|d|₁ and u·m.
fn errors<R: Real>(a: (DVec3, Pose), b: (DVec3, Pose), d: DVec3) -> [f64; 2] {
    let (hull_a, hull_b) = (Polytope::hull(vec![a.0]).unwrap(), Polytope::hull(vec![b.0]).unwrap());
    let (body_a, body_b) =
        (PosedSupport::polytope(&hull_a, &a.1), PosedSupport::polytope(&hull_b, &b.1));
    let Some(difference) = Difference::<R, _, _>::new(body_a, body_b) else { return [0.0; 2] };
    let Some(d) = crate::gjk::unit::<R>(R::Vec3::from_dvec3(d).components()) else {
        return [0.0; 2];
    };
    let (vertex, separation) = difference.lowest(d);
    let extent = Extent::of(body_a, body_b);
    let exact = Grid::<Large>::new(body_a, body_b, &extent).point([0, 0]);
    // Everything in units of 2^-400 of the scaled pair.
    let to_scale = extent.unit() - exponent(difference.scale().to_f64());
    let fine = -400;
    let shifted = exact.map(|x| x.times(&Number::power_of_two((to_scale - fine) as u32)));
    let unit = R::UNIT_ROUNDOFF.to_f64() * difference.size().to_f64();
    let mut vertex_error = 0.0f64;
    let mut truth = Large::zero();
    for (k, x) in shifted.iter().enumerate() {
        let (w, direction) = (vertex.w.components()[k], d.components()[k]);
        vertex_error = vertex_error.max(rough(&x.minus(&on(w.to_f64(), fine)), fine) / unit);
        truth = truth.plus(&x.times(&on(direction.to_f64(), -300)));
    }
    let found = on(separation.to_f64(), fine - 300);
    let separation_error = rough(&truth.minus(&found), fine - 300);
    // The last sum's own rounding does not count against the sign.
    let last = R::UNIT_ROUNDOFF.to_f64() * separation.to_f64().abs();
    [(separation_error - last).max(0.0) / (unit * d.norm1().to_f64()), vertex_error]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn separations_and_vertices_are_no_further_off_than_derived(
        points in (vector(), vector()),
        poses in (pose(0.0), pose(0.0)),
        far in (pose(1000.0), pose(1000.0)),
        d in vector(),
    ) {
        for (pose_a, pose_b) in [poses, far] {
            let [apart, vertex] = errors::<f64>((points.0, pose_a), (points.1, pose_b), d);
            prop_assert!(apart <= F64.apart && vertex <= F64.vertex, "{apart} {vertex}");
            let [apart, vertex] = errors::<f32>((points.0, pose_a), (points.1, pose_b), d);
            prop_assert!(apart <= F32.apart && vertex <= F32.vertex, "{apart} {vertex}");
        }
    }

    #[test]
    fn four_points_near_a_plane_through_the_origin_are_accepted_only_if_they_hold_it(
        corners in (vector(), vector(), vector()),
        weights in (0.01f64..1.0, 0.01f64..1.0, 0.01f64..1.0),
        nudge in -30i32..30,
        error in prop_oneof![Just(0.0), Just(1e-16), Just(1e-12)],
    ) {
        let (p0, p1, p2) = corners;
        let (l0, l1, l2) = weights;
        let p3 = -(p0 * l0 + p1 * l1 + p2 * l2);
        let p3 = p3 * (1.0 + f64::from(nudge) * 1e-16);
        let points = [p0, p1, p2, p3].map(|p| p.to_array());
        if four_points_hold_origin(&points, error) {
            prop_assert!(truly_hold(&points, error), "{points:?}");
        }
    }
}

/// Whether every face sees the whole cube on its inner side, in integers.
fn truly_hold(points: &[Triple<f64>; 4], error: f64) -> bool {
    let unit = -200;
    let [p0, p1, p2, p3] = points.map(|p| p.map(|x| on(x, unit)));
    let error = on(error, unit);
    let faces = [[&p1, &p2, &p3], [&p0, &p3, &p2], [&p0, &p1, &p3], [&p0, &p2, &p1]];
    let volumes = faces.map(|[x, y, z]| determinant(x, y, z));
    let mirrored = volumes[0].is_negative();
    faces.iter().zip(volumes).all(|(&[x, y, z], volume)| {
        let volume = if mirrored { volume.negated() } else { volume };
        let normal = cross(&minus(y, x), &minus(z, x));
        let absolute = |x: &Large| if x.is_negative() { x.negated() } else { x.clone() };
        let length = absolute(&normal[0]).plus(&absolute(&normal[1])).plus(&absolute(&normal[2]));
        volume.minus(&error.times(&length)).is_positive()
    })
}

/// Two points, two poses and a direction as plain numbers, for the climb.
fn errors_of<R: Real>(x: &[f64; 23]) -> [f64; 2] {
    let at = |k: usize| DVec3::new(x[k], x[k + 1], x[k + 2]);
    let turn = |k: usize| DQuat::from_xyzw(x[k], x[k + 1], x[k + 2], x[k + 3]);
    let pose = |q: usize, t: usize| Pose::new(turn(q).normalize(), at(t));
    match (pose(9, 13), pose(16, 20)) {
        (Ok(a), Ok(b)) => errors::<R>((at(0), a), (at(3), b), at(6)),
        _ => [0.0; 2],
    }
}

/// The largest errors that a climb from random numbers finds by changing one number at a time.
fn climbed<R: Real>(which: usize) -> f64 {
    let mut state = 7u64;
    let mut draw = || {
        state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let mut largest = 0.0f64;
    for _ in 0..12 {
        // The bound is for the worst shape: one large vertex along the direction, alone.
        let mut best = [(); 23].map(|()| draw());
        let turn = DQuat::from_xyzw(best[9], best[10], best[11], best[12]).normalize();
        let d = if which == 0 { DVec3::new(best[6], best[7], best[8]) } else { DVec3::X };
        best[..3].copy_from_slice(&(turn.inverse() * d).to_array());
        for k in [3, 4, 5, 13, 14, 15, 20, 21, 22] {
            best[k] *= 1e-3;
        }
        let mut error = errors_of::<R>(&best)[which];
        for _ in 0..3000 {
            let mut next = best;
            let k = ((draw() + 1.0) * 11.5) as usize;
            let reach = 2f64.powi((draw() * 26.0) as i32 - 26);
            next[k] += draw() * reach;
            let found = errors_of::<R>(&next)[which];
            if found >= error {
                (best, error) = (next, found);
            }
        }
        largest = largest.max(error);
    }
    largest
}

#[test]
fn a_climb_comes_near_the_bounds_and_not_past_them() {
    for (name, found, bound) in [
        ("separation in f64", climbed::<f64>(0), F64.apart),
        ("vertex in f64", climbed::<f64>(1), F64.vertex),
        ("separation in f32", climbed::<f32>(0), F32.apart),
        ("vertex in f32", climbed::<f32>(1), F32.vertex),
    ] {
        println!("{name}: {found:.2} of {bound}");
        assert!(bound / 3.0 < found && found <= bound, "{name}: {found} of {bound}");
    }
}
