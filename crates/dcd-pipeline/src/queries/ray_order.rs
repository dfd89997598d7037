//! In which order the rays of a batch are cast: those that enter the scene at neighbouring places after each other, for
//! they meet the same objects while these are in the cache.

use dcd_geom::Aabb;
use dcd_geom::glam::DVec3;
use dcd_gjk::query::ray::Ray;

/// How many bits of a key say where a ray enters the scene, along each axis.
const BITS: u32 = 9;

/// The largest number of a cell.
const LAST: f64 = ((1 << BITS) - 1) as f64;

/// Metres: a box that reaches so far is of a shape without an end.
const ENDLESS: f64 = 0.5 * Aabb::LIMIT;

/// The rays' numbers, by where they enter the box round those objects and then by their directions' signs; equal ones by
/// number. No answer depends on it.
pub(super) fn in_order(rays: &[Ray], aabbs: &[Aabb]) -> Vec<u32> {
    let [low, high] = bounds(aabbs);
    // Of a box without width every place is in the first cell.
    let cells = DVec3::splat(LAST) / (high - low).max(DVec3::splat(f64::MIN_POSITIVE));
    let key = |(number, ray): (usize, &Ray)| {
        let cell = (entry(ray, [low, high]) - low) * cells;
        let direction = ray.direction();
        let mut key = 0;
        for bit in (0..BITS).rev() {
            for axis in 0..3 {
                // What is not a number is in the first cell.
                key = key << 1 | (cell[axis].clamp(0.0, LAST) as u64 >> bit & 1);
            }
        }
        for axis in 0..3 {
            key = key << 1 | u64::from(direction[axis] < 0.0);
        }
        key << u32::BITS | number as u64
    };
    let mut keys: Vec<u64> = rays.iter().enumerate().map(key).collect();
    keys.sort_unstable();
    keys.into_iter().map(|key| key as u32).collect()
}

/// Two corners of the box round all objects that have an end; zero where there are none.
fn bounds(aabbs: &[Aabb]) -> [DVec3; 2] {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for aabb in aabbs {
        let (min, max) = (aabb.min.as_dvec3(), aabb.max.as_dvec3());
        let is_bounded = min.min_element() > -ENDLESS && max.max_element() < ENDLESS;
        if is_bounded && min.cmple(max).all() {
            (low, high) = (low.min(min), high.max(max));
        }
    }
    if low.cmple(high).all() { [low, high] } else { [DVec3::ZERO; 2] }
}

/// Where a ray enters a box, or is beside it.
fn entry(ray: &Ray, [low, high]: [DVec3; 2]) -> DVec3 {
    let (origin, direction) = (ray.origin(), ray.direction());
    let mut enter = 0.0f64;
    for axis in 0..3 {
        let side = if direction[axis] < 0.0 { high[axis] } else { low[axis] };
        // A NaN, where the ray lies in a side, is no later.
        enter = enter.max((side - origin[axis]) / direction[axis]);
    }
    let at = origin + direction * enter.min(ray.max_t());
    if at.is_finite() { at } else { origin }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::glam::Vec3;

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
        Ray::endless(DVec3::from_array(origin), DVec3::from_array(direction)).unwrap()
    }

    #[test]
    fn rays_are_in_the_order_of_where_they_enter_the_scene() {
        let boxes = [
            Aabb { min: Vec3::ZERO, max: Vec3::ONE },
            Aabb { min: Vec3::splat(7.0), max: Vec3::splat(8.0) },
            // A half-space.
            Aabb { min: Vec3::splat(-Aabb::LIMIT as f32), max: Vec3::splat(Aabb::LIMIT as f32) },
        ];
        assert_eq!(bounds(&boxes), [DVec3::ZERO, DVec3::splat(8.0)]);
        let enters = |ray: &Ray| entry(ray, bounds(&boxes)).to_array();
        assert_eq!(enters(&ray([-2.0, 1.0, 3.0], [0.5, 0.0, 0.0])), [0.0, 1.0, 3.0]);
        assert_eq!(enters(&ray([4.0, 5.0, 10.0], [1.0, 0.0, -2.0])), [5.0, 5.0, 8.0]);
        assert_eq!(enters(&ray([1.0, 2.0, 3.0], [-1.0, 0.0, 0.0])), [1.0, 2.0, 3.0]);
        let rays = [
            ray([20.0, 7.0, 7.0], [-1.0, 0.0, 0.0]),
            ray([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0]),
            ray([9.0, 7.0, 7.0], [-2.0, 0.0, 0.0]),
            ray([0.0, 0.5, -5.0], [0.0, 0.0, 1.0]),
        ];
        assert_eq!(in_order(&rays, &boxes), [1, 3, 0, 2]);
    }

    #[test]
    fn every_ray_has_its_place_whatever_the_scene_and_however_far_the_rays() {
        let far = Aabb::LIMIT;
        let rays: Vec<Ray> = (0..64)
            .map(|k| {
                let sign = |bit: u32| if k >> bit & 1 == 0 { 1.0 } else { -1.0 };
                let along = [1e100, -1e-100, 0.0, 1e-3][k % 4];
                ray([sign(0) * far, 0.0, sign(1)], [along, sign(2), 0.0])
            })
            .collect();
        let none: &[Aabb] = &[];
        let one = Aabb { min: Vec3::ONE, max: Vec3::ONE };
        for aabbs in [none, &[one], &[Aabb::EMPTY, one]] {
            let mut order = in_order(&rays, aabbs);
            order.sort_unstable();
            assert!(order.into_iter().eq(0..64));
        }
    }
}
