//! The keys of sixteen boxes against plain f64.

use super::*;
use crate::{Kernel, Path, dispatch_on};
use glam::Vec3;

struct Keys<'a, T>(&'a T, &'a Aabb16);

impl<T: BoxTest> Kernel for Keys<'_, T> {
    type Output = Row;
    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Row {
        let mut row = Row::default();
        l.store(self.0.keys(l, self.1), &mut row);
        row
    }
}

fn keys(test: &impl BoxTest, boxes: &Aabb16) -> [f32; WIDTH] {
    let row = dispatch_on(Path::Portable, Keys(test, boxes));
    for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
        assert_eq!(dispatch_on(path, Keys(test, boxes)).0, row.0, "{path:?}");
    }
    row.0
}

/// The generator of Numerical Recipes, within ±1, in sixteenths one time in three so that sides meet exactly.
fn random(state: &mut u32) -> f64 {
    let mut next = || {
        *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(*state >> 8) / f64::from(1 << 23) - 1.0
    };
    let (x, which) = (next(), next());
    if which < -0.3 { (x * 16.0).round() / 16.0 } else { x }
}

/// Whether the closed box holds a point of the ray exactly, and when at the earliest, by exact comparisons of
/// slabs on f64 quotients with a margin on neither side.
fn enters(aabb: &Aabb, origin: DVec3, direction: DVec3) -> Option<f64> {
    let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
    for k in 0..3 {
        let (min, max) = (f64::from(aabb.min[k]), f64::from(aabb.max[k]));
        if direction[k] == 0.0 {
            if origin[k] < min || origin[k] > max {
                return None;
            }
            continue;
        }
        let (s, t) = ((min - origin[k]) / direction[k], (max - origin[k]) / direction[k]);
        (enter, leave) = (enter.max(s.min(t)), leave.min(s.max(t)));
    }
    (enter <= leave).then_some(enter)
}

#[test]
fn a_corner_that_is_no_number_shuts_no_box_out() {
    let mut boxes = Aabb16::EMPTY;
    for k in 0..15 {
        let at = Vec3::new(k as f32, 100.0 * k as f32 - 700.0, -0.5);
        boxes.set(k, &Aabb { min: at, max: at + 1.0 });
    }
    let none = DVec3::splat(f64::NAN);
    for corners in [[none; 2], [none, DVec3::INFINITY], [DVec3::NEG_INFINITY, none]] {
        for direction in [DVec3::X, DVec3::NEG_Y, DVec3::new(0.3, -2.0, 1.0)] {
            let found = keys(&RaySlabs::swept(corners, direction), &boxes);
            assert!(found[..15].iter().all(|key| key.is_finite()), "{direction}: {found:?}");
        }
    }
}

#[test]
fn no_box_that_a_ray_meets_is_missed_and_far_ones_are() {
    let (mut state, mut met, mut missed, mut kept) = (1, 0, 0, 0);
    for round in 0..2_000 {
        let scale = [1.0, 1e-6, 1e6, 1e30][round % 4];
        let offset = if round % 5 == 0 { 1e6 } else { 0.0 };
        let mut boxes = Aabb16::EMPTY;
        for k in 0..15 {
            let corner = |state: &mut u32| {
                Vec3::from_array([0; 3].map(|_| (random(state) * scale + offset) as f32))
            };
            let (a, b) = (corner(&mut state), corner(&mut state));
            boxes.set(k, &Aabb { min: a.min(b), max: a.max(b) });
        }
        let point = |state: &mut u32| {
            DVec3::from_array([0; 3].map(|_| random(state) * scale * 2.0 + offset))
        };
        let origin = if round % 3 == 0 { boxes.get(3).min.as_dvec3() } else { point(&mut state) };
        let mut direction = point(&mut state) - offset;
        (0..3).filter(|k| round >> k & 1 == 1).take(2).for_each(|k| direction[k] = 0.0);
        if direction == DVec3::ZERO {
            continue;
        }
        let slabs = RaySlabs::new(origin, direction, 0.0);
        let found = keys(&slabs, &boxes);
        assert_eq!(found[15], f32::INFINITY);
        for (k, &key) in found[..15].iter().enumerate() {
            match enters(&boxes.get(k), origin, direction) {
                Some(t) => {
                    assert!(key <= slabs.key_of(t), "round {round} box {k}: {key} {t}");
                    met += 1;
                }
                None if key == f32::INFINITY => missed += 1,
                None => kept += 1,
            }
        }
    }
    assert!(met > 2_000 && missed > 3_000 && kept < missed, "{met} {missed} {kept}");
}

#[test]
fn a_key_of_distance_is_no_larger_than_that_of_a_point_inside() {
    let mut state = 7;
    for _ in 0..500 {
        let mut boxes = Aabb16::EMPTY;
        let vector = |state: &mut u32| DVec3::from_array([0; 3].map(|_| random(state)));
        for k in 0..15 {
            let (a, b) = (vector(&mut state).as_vec3(), vector(&mut state).as_vec3());
            boxes.set(k, &Aabb { min: a.min(b), max: a.max(b) });
        }
        let point = vector(&mut state) * 3.0;
        let test = PointDistance::new(point);
        let found = keys(&test, &boxes);
        assert_eq!(found[15], f32::INFINITY);
        for (k, &key) in found[..15].iter().enumerate() {
            let aabb = boxes.get(k);
            let nearest = point.clamp(aabb.min.as_dvec3(), aabb.max.as_dvec3());
            let distance = nearest.distance(point);
            assert!(
                key <= test.key_of(distance)
                    && f64::from(key) >= distance * distance * 0.99999 - 1e-6
            );
        }
    }
}

#[test]
fn a_box_is_outside_of_planes_only_where_all_its_corners_are() {
    let (mut state, mut out, mut inside) = (3, 0, 0);
    for _ in 0..500 {
        let vector = |state: &mut u32| DVec3::from_array([0; 3].map(|_| random(state)));
        let planes: Vec<_> = (0..4).map(|_| (vector(&mut state), random(&mut state))).collect();
        let mut boxes = Aabb16::EMPTY;
        for k in 0..15 {
            let (a, b) = (vector(&mut state).as_vec3(), vector(&mut state).as_vec3());
            boxes.set(k, &Aabb { min: a.min(b), max: a.max(b) });
        }
        let found = keys(&PlaneSet { planes: &planes }, &boxes);
        assert_eq!(found[15], f32::INFINITY);
        for (k, &key) in found[..15].iter().enumerate() {
            let aabb = boxes.get(k);
            let least = |n: DVec3| {
                let corner = |c: usize| {
                    DVec3::from_array(std::array::from_fn(|axis| {
                        f64::from(if c >> axis & 1 == 0 { aabb.min[axis] } else { aabb.max[axis] })
                    }))
                };
                (0..8).map(|c| n.dot(corner(c))).fold(f64::INFINITY, f64::min)
            };
            let excess =
                planes.iter().map(|&(n, d)| least(n) - d).fold(f64::NEG_INFINITY, f64::max);
            if excess <= 0.0 {
                assert_eq!(key, 0.0);
                inside += 1;
            } else if excess > 1e-4 {
                assert_eq!(key, f32::INFINITY);
                out += 1;
            }
        }
    }
    assert!(out > 500 && inside > 500, "{out} {inside}");
}

#[test]
fn components_below_the_least_f32_shut_no_box_out() {
    // Far from the origin they count, and an f32 holds none of them.
    let far = Vec3::new(0.0, 1e37, 0.0);
    let mut boxes = Aabb16::EMPTY;
    boxes.set(0, &Aabb { min: far, max: far });
    let normal = DVec3::new(1.0, -6e-46, 0.0);
    let height = normal.dot(far.as_dvec3());
    let planes = [(normal, height / 2.0)];
    assert_eq!(keys(&PlaneSet { planes: &planes }, &boxes)[0], 0.0);
    let test = HeightsAlong::new(normal, &boxes.union()).unwrap();
    assert!(keys(&test, &boxes)[0] <= test.key_of(height));
}

#[test]
fn no_box_is_higher_than_anything_in_it() {
    let (mut state, mut lower) = (5, 0);
    for round in 0..500 {
        let scale = [1.0, 1e-20, 1e20, 1e-40][round % 4];
        let vector = |state: &mut u32| DVec3::from_array([0; 3].map(|_| random(state)));
        let far = if round % 3 == 0 { vector(&mut state) * 1e4 } else { DVec3::ZERO };
        let mut boxes = Aabb16::EMPTY;
        for k in 0..15 {
            let corner = |state: &mut u32| ((vector(state) + far) * scale).as_vec3();
            let (a, b) = (corner(&mut state), corner(&mut state));
            boxes.set(k, &Aabb { min: a.min(b), max: a.max(b) });
        }
        let direction = if round % 5 == 0 { DVec3::Y } else { vector(&mut state) };
        let test = HeightsAlong::new(direction, &boxes.union()).unwrap();
        let found = keys(&test, &boxes);
        assert_eq!(found[15], f32::INFINITY);
        let mut heights = Vec::new();
        for (k, &key) in found[..15].iter().enumerate() {
            let aabb = boxes.get(k);
            let (min, max) = (aabb.min.as_dvec3(), aabb.max.as_dvec3());
            let height = (direction * min).min(direction * max).element_sum();
            assert!(key <= test.key_of(height), "{round}: {key} {height}");
            heights.push((height, key));
        }
        let first = heights.iter().fold(f64::INFINITY, |least, &(height, _)| least.min(height));
        let limit = test.key_of(first);
        let slack = (far.length() + 2.0) * scale * 1e-5 + 1e-29;
        for (height, key) in heights {
            let is_higher = key > limit;
            lower += usize::from(is_higher);
            assert!(is_higher || height <= first + slack, "{round}: {height} {first}");
        }
    }
    assert!(lower > 2000, "{lower}");
    let around = Aabb { min: Vec3::splat(-1e38), max: Vec3::splat(1e38) };
    assert!(HeightsAlong::new(DVec3::X, &around).is_none());
    assert!(HeightsAlong::new(DVec3::NAN, &Aabb { min: Vec3::ZERO, max: Vec3::ONE }).is_none());
}
