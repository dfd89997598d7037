//! In which order many queries are answered: neighbours after each other, for they meet the same objects while these are
//! in the cache. No answer depends on it.

use dcd_exec::{Exec, Segments};
use dcd_geom::Aabb;
use dcd_geom::glam::DVec3;
use dcd_gjk::motion::MovingShape;
use dcd_gjk::query::ray::Ray;

/// From how many queries on they have an order. Larger: batches that meet objects that are no longer in the cache. Smaller:
/// batches for which the box round the scene costs more than it saves.
const ORDERED: usize = 512;

/// How many bits of a key say where a query begins to meet the scene, along each axis.
const BITS: u32 = 9;

/// The largest number of a cell.
const LAST: f64 = ((1 << BITS) - 1) as f64;

/// Metres: a box that reaches so far is of a shape without an end.
const ENDLESS: f64 = 0.5 * Aabb::LIMIT;

/// Replaces `answers` by those of that many queries, query k's at place k, in tasks of `grain` queries.
pub(super) fn answer_each<A: Clone + Default + Send>(
    (exec, grain): (Exec<'_>, usize),
    (count, order): (usize, Option<Vec<u32>>),
    answers: &mut Vec<A>,
    answer: impl Fn(usize) -> A + Sync,
) {
    answers.clear();
    answers.resize(count, A::default());
    let Some(order) = order else {
        exec.divide(&mut answers[..], grain, |first, answers| {
            for (k, slot) in answers.iter_mut().enumerate() {
                *slot = answer(first + k);
            }
        });
        return;
    };
    let mut found = vec![A::default(); count];
    exec.divide(&mut found[..], grain, |first, found| {
        for (slot, &k) in found.iter_mut().zip(&order[first..]) {
            *slot = answer(k as usize);
        }
    });
    for (found, &k) in found.into_iter().zip(&order) {
        answers[k as usize] = found;
    }
}

/// The same of queries with many answers each: `list` appends those of query k to a list, where they are segment k.
pub(super) fn list_each<A: Send>(
    how: (Exec<'_>, usize),
    queries: (usize, Option<Vec<u32>>),
    answers: &mut Segments<A>,
    list: impl Fn(usize, &mut Vec<A>) + Sync,
) {
    answers.gather(|filler| {
        let mut spans = Vec::new();
        answer_each(how, queries, &mut spans, |k| filler.segment(|to| list(k, to)));
        spans
    });
}

/// Rays by where they enter the box round those objects, and then by their directions' signs.
pub(super) fn of_rays(rays: &[Ray], aabbs: &[Aabb]) -> Option<Vec<u32>> {
    in_order(rays.len(), aabbs, |k, bounds| (entry(&rays[k], bounds), rays[k].direction()))
}

/// Points by their places.
pub(super) fn of_points(points: &[DVec3], aabbs: &[Aabb]) -> Option<Vec<u32>> {
    in_order(points.len(), aabbs, |k, _| (points[k], DVec3::ZERO))
}

/// Moving shapes by where they start, and then by their velocities' signs.
pub(super) fn of_motions(moving: &[MovingShape<'_>], aabbs: &[Aabb]) -> Option<Vec<u32>> {
    let start = |k: usize| (moving[k].motion.start.translation(), moving[k].motion.linear);
    in_order(moving.len(), aabbs, |k, _| start(k))
}

/// The numbers of queries by their place along a Morton curve through the box round those objects, then by the signs of
/// a direction, then by number; `None` of few.
fn in_order(
    count: usize,
    aabbs: &[Aabb],
    place: impl Fn(usize, [DVec3; 2]) -> (DVec3, DVec3),
) -> Option<Vec<u32>> {
    if count < ORDERED || u32::try_from(count).is_err() {
        return None;
    }
    let [low, high] = bounds(aabbs);
    // Of a box without width every place is in the first cell.
    let cells = DVec3::splat(LAST) / (high - low).max(DVec3::splat(f64::MIN_POSITIVE));
    let key = |number: usize| {
        let (at, direction) = place(number, [low, high]);
        let cell = (at - low) * cells;
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
    let mut keys: Vec<u64> = (0..count).map(key).collect();
    keys.sort_unstable();
    Some(keys.into_iter().map(|key| key as u32).collect())
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
        let four = [
            ray([20.0, 7.0, 7.0], [-1.0, 0.0, 0.0]),
            ray([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0]),
            ray([9.0, 7.0, 7.0], [-2.0, 0.0, 0.0]),
            ray([0.0, 0.5, -5.0], [0.0, 0.0, 1.0]),
        ];
        assert!(of_rays(&four, &boxes).is_none());
        let rays = four.repeat(ORDERED / 4);
        let order = of_rays(&rays, &boxes).unwrap();
        // The cells of the last two of the four come first; the others enter at one place.
        let which: Vec<u32> = order.iter().map(|k| k % 4).collect();
        let (near, far) = which.split_at(rays.len() / 2);
        assert!(near.is_sorted_by(|j, k| j >= k) && near.iter().all(|k| [1, 3].contains(k)));
        assert!(far.chunks(2).all(|pair| pair == [0, 2]));
        assert!(order[rays.len() / 2..].is_sorted());
    }

    #[test]
    fn every_query_has_its_place_whatever_the_scene_and_however_far_it_is() {
        let far = Aabb::LIMIT;
        let sign = |k: usize, bit: usize| if k >> bit & 1 == 0 { 1.0 } else { -1.0 };
        let origin = |k: usize| [sign(k, 0) * far, 0.0, sign(k, 1)];
        let along = |k: usize| [[1e100, -1e-100, 0.0, 1e-3][k % 4], sign(k, 2), 0.0];
        let rays: Vec<Ray> = (0..ORDERED).map(|k| ray(origin(k), along(k))).collect();
        let points: Vec<DVec3> = rays.iter().map(Ray::origin).collect();
        let one = Aabb { min: Vec3::ONE, max: Vec3::ONE };
        for aabbs in [&[][..], &[one], &[Aabb::EMPTY, one]] {
            for order in [of_rays(&rays, aabbs), of_points(&points, aabbs)] {
                let mut order = order.unwrap();
                order.sort_unstable();
                assert!(order.into_iter().eq(0..ORDERED as u32));
            }
        }
    }
}
