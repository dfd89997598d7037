//! The test of a query against sixteen boxes at once: how soon, or how near, something in each can be.

use crate::aabb::{above, round_down, round_up};
use crate::{Aabb, Aabb16, Lanes, Row, WIDTH};
use glam::{DVec3, Vec3};

/// A test of sixteen boxes.
///
/// # Contract
/// A box's key is at most the key of anything inside it, in the unit of the test; infinite where nothing inside
/// can be an answer, as for an empty box. Keys decide what is visited and in which order, never an answer.
pub trait BoxTest {
    /// The sixteen keys. To be marked `#[inline(always)]`.
    fn keys<L: Lanes>(&self, l: L, boxes: &Aabb16) -> L::F;
}

/// The lanes of `bits` by ascending key, lower lanes first among equals: how many there are, and which.
#[inline(always)]
pub fn nearest_first(keys: &Row, mut bits: u32, lanes: &mut [u8; WIDTH]) -> usize {
    let mut count = 0;
    while bits != 0 {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits - 1;
        let mut place = count;
        while place > 0 && keys.0[lane] < keys.0[lanes[place - 1] as usize] {
            lanes[place] = lanes[place - 1];
            place -= 1;
        }
        lanes[place] = lane as u8;
        count += 1;
    }
    count
}

/// What three roundings of f32 lose of a quotient from below and of one from above, doubled, with a margin. No unit.
/// (1 + γ₃)/(1 − γ₃) is 1 + 6.1·2⁻²⁴ (Ize 2013). Smaller: boxes missed through rounding.
const ROUNDING: f64 = 1.0 / (1 << 20) as f64;

/// More than the underflow of a product loses; no box is so near that it matters.
const UNDERFLOW: f32 = 1e-30;

/// What a component of a vector loses where it is rounded to an f32 below the least normal one, twice: what a coordinate times that
/// is, is not below [`UNDERFLOW`] far from the origin.
const LEAST: f32 = f32::from_bits(1);

/// Below which part of the largest component of a direction a component counts as none: its reciprocal and
/// products with it would leave the range of f32.
const PARALLEL: f64 = 1.0 / (1u128 << 80) as f64;

/// Metres times a direction's length: sums and products of twice that are in f32's range.
const LARGEST_HEIGHT: f64 = 1e36;

/// A ray against boxes by slabs, rounded so that no box is missed (T. Ize, "Robust BVH ray traversal", 2013).
/// The key is where the ray enters the box, in units of [`RaySlabs::key_of`].
#[derive(Clone, Copy, Debug)]
pub struct RaySlabs {
    low: [f32; 3],
    high: [f32; 3],
    /// Of the direction, scaled so that its largest component is within 1 to 2; 0 where it has none.
    inverse: [f32; 3],
    scale: f64,
}

impl RaySlabs {
    /// The ray from `origin` along `direction`, which is finite and not 0, and every ray that stays within `margin`
    /// metres of it.
    pub fn new(origin: DVec3, direction: DVec3, margin: f64) -> Self {
        Self::swept([origin - margin, origin + margin], direction)
    }

    /// All rays along `direction`, which is finite and not 0, from points of a box, by its corners.
    pub fn swept([low, high]: [DVec3; 2], direction: DVec3) -> Self {
        let largest = direction.abs().max_element();
        // A power of two, so that scaling is exact but for components that count as none.
        let exponent = ((largest.to_bits() >> 52) & 0x7ff) as i32 - 1023;
        let half = exponent / 2;
        let scaled = direction * power(-half) * power(half - exponent);
        let scale = power(half) * power(exponent - half);
        let inverse =
            scaled.to_array().map(|d| if d.abs() < PARALLEL { 0.0 } else { (1.0 / d) as f32 });
        let beyond = |x: f64| {
            let x = above(x.clamp(f64::MIN, f64::MAX)).clamp(f32::MIN, f32::MAX);
            // A corner that is no number bounds nothing.
            if x.is_nan() { f32::MAX } else { x }
        };
        let mut slabs = Self {
            low: low.to_array().map(|x| -beyond(-x)),
            high: high.to_array().map(beyond),
            inverse,
            scale,
        };
        for axis in 0..3 {
            // A component that is tiny and not 0 may leave any slab in time.
            if slabs.inverse[axis] == 0.0 && direction[axis] != 0.0 {
                (slabs.low[axis], slabs.high[axis]) = (f32::MIN, f32::MAX);
            }
        }
        slabs
    }

    /// The key of a time: what is entered at a later key is entered after it, with rounding.
    pub fn key_of(&self, t: f64) -> f32 {
        // A NaN prunes nothing.
        let key = t * self.scale * (1.0 + ROUNDING);
        if key <= f64::from(f32::MAX) { round_up(key) } else { f32::MAX }
    }
}

/// 2^e, of an exponent of a normal number.
fn power(e: i32) -> f64 {
    f64::from_bits(((e + 1023).clamp(1, 2046) as u64) << 52)
}

impl BoxTest for RaySlabs {
    #[inline(always)]
    fn keys<L: Lanes>(&self, l: L, boxes: &Aabb16) -> L::F {
        let (mut enter, mut leave) = (l.splat(0.0), l.splat(f32::MAX));
        let mut open = l.le(l.load(&boxes.min[0]), l.load(&boxes.max[0]));
        for axis in 0..3 {
            let (min, max) = (l.load(&boxes.min[axis]), l.load(&boxes.max[axis]));
            let (low, high) = (l.splat(self.low[axis]), l.splat(self.high[axis]));
            let inverse = self.inverse[axis];
            if inverse == 0.0 {
                open = l.and(open, l.and(l.le(min, high), l.le(low, max)));
                continue;
            }
            let (first, last) = (l.sub(min, high), l.sub(max, low));
            let inverse = l.splat(inverse);
            let (first, last) = (l.mul(first, inverse), l.mul(last, inverse));
            // Which of them is nearer is the direction's sign: the same for all boxes, another for each ray, so that a
            // branch on it would be mispredicted. Of an empty box neither counts.
            enter = l.max(enter, l.min(first, last));
            leave = l.min(leave, l.max(first, last));
        }
        let leave = l.add(l.mul(leave, l.splat(1.0 + ROUNDING as f32)), l.splat(UNDERFLOW));
        l.select(l.and(open, l.le(enter, leave)), enter, l.splat(f32::INFINITY))
    }
}

/// The distance of boxes from a point or another box. The key is at most the squared distance, square metres.
#[derive(Clone, Copy, Debug)]
pub struct PointDistance {
    low: [f32; 3],
    high: [f32; 3],
}

impl PointDistance {
    /// From a finite point.
    pub fn new(point: DVec3) -> Self {
        let bound = |x: f32| x.clamp(f32::MIN, f32::MAX);
        let coordinates = point.to_array();
        Self {
            low: coordinates.map(|x| bound(round_down(x))),
            high: coordinates.map(|x| bound(round_up(x))),
        }
    }

    /// From the nearest point of a box that is not empty.
    pub fn from_box(aabb: &Aabb) -> Self {
        let bound = |x: f32| x.clamp(f32::MIN, f32::MAX);
        Self { low: aabb.min.to_array().map(bound), high: aabb.max.to_array().map(bound) }
    }

    /// The key of a distance in metres: what has a larger one is farther, with rounding.
    pub fn key_of(&self, distance: f64) -> f32 {
        let key = distance * distance * (1.0 + ROUNDING) + f64::from(UNDERFLOW);
        if key <= f64::from(f32::MAX) { round_up(key) } else { f32::MAX }
    }
}

impl BoxTest for PointDistance {
    #[inline(always)]
    fn keys<L: Lanes>(&self, l: L, boxes: &Aabb16) -> L::F {
        let mut sum = l.splat(0.0);
        let mut open = l.le(l.load(&boxes.min[0]), l.load(&boxes.max[0]));
        for axis in 0..3 {
            let (min, max) = (l.load(&boxes.min[axis]), l.load(&boxes.max[axis]));
            open = l.and(open, l.le(min, max));
            let below = l.sub(min, l.splat(self.high[axis]));
            let above = l.sub(l.splat(self.low[axis]), max);
            let gap = l.max(l.splat(0.0), l.max(below, above));
            sum = l.add(sum, l.mul(gap, gap));
        }
        l.select(open, l.min(sum, l.splat(f32::MAX)), l.splat(f32::INFINITY))
    }
}

/// How high boxes are along a direction. The key is at most the height of anything in a box over the lowest of all, in
/// metres times the direction's length, but for less than a slack that [`HeightsAlong::key_of`] counts.
#[derive(Clone, Copy, Debug)]
pub struct HeightsAlong {
    direction: [f32; 3],
    /// At most the height of every box, but for the slack.
    base: f64,
    slack: f64,
}

impl HeightsAlong {
    /// Along a finite direction, of boxes that are in this one; `None` where products leave the range of f32.
    pub fn new(direction: DVec3, around: &Aabb) -> Option<Self> {
        let (min, max) = (around.min.as_dvec3(), around.max.as_dvec3());
        let size = direction.abs().dot(min.abs().max(max.abs()));
        let rounded = direction.as_vec3();
        // Written so that NaN is out of range.
        if !(size <= LARGEST_HEIGHT && rounded.is_finite()) {
            return None;
        }
        let base = (direction * min).min(direction * max).element_sum();
        // The direction and the base are rounded, 1 each; the products lose 1 together, three sums of at most twice the
        // size 2 each: 9 times 2⁻²⁴ of it, below ROUNDING.
        let far = min.abs().max(max.abs()).element_sum();
        let slack = size * ROUNDING + f64::from(LEAST) * far + f64::from(UNDERFLOW);
        Some(Self { direction: rounded.to_array(), base, slack })
    }

    /// The key of a height: what has a larger one is higher, with rounding.
    pub fn key_of(&self, height: f64) -> f32 {
        // Of a height below the base, and of NaN, that of the base.
        round_up((height - self.base).max(0.0) + 2.0 * self.slack)
    }
}

impl BoxTest for HeightsAlong {
    #[inline(always)]
    fn keys<L: Lanes>(&self, l: L, boxes: &Aabb16) -> L::F {
        let mut key = l.splat(-(self.base as f32));
        let mut open = l.mask(0xffff);
        for axis in 0..3 {
            let (min, max) = (l.load(&boxes.min[axis]), l.load(&boxes.max[axis]));
            open = l.and(open, l.le(min, max));
            let along = self.direction[axis];
            let lowest = if along < 0.0 { max } else { min };
            key = l.add(key, l.mul(l.splat(along), lowest));
        }
        l.select(open, key, l.splat(f32::INFINITY))
    }
}

/// Overlap with a box: a key of 0, or infinite.
impl BoxTest for Aabb {
    #[inline(always)]
    fn keys<L: Lanes>(&self, l: L, boxes: &Aabb16) -> L::F {
        // An infinite side would overlap the empty boxes that fill up a row.
        let finite = Self { min: self.min.max(Vec3::MIN), max: self.max.min(Vec3::MAX) };
        let hits = boxes.overlaps(l, &finite);
        l.select(l.mask(hits), l.splat(0.0), l.splat(f32::INFINITY))
    }
}

/// Half-spaces in common, a frustum for one: a key of 0 where no plane is proved to have all of a box outside,
/// else infinite.
#[derive(Clone, Copy, Debug)]
pub struct PlaneSet<'a> {
    /// Each a normal, outward, of any length within 1e±15, and its product with any point of the plane.
    pub planes: &'a [(DVec3, f64)],
}

impl BoxTest for PlaneSet<'_> {
    #[inline(always)]
    fn keys<L: Lanes>(&self, l: L, boxes: &Aabb16) -> L::F {
        let mut open = l.mask(0xffff);
        for axis in 0..3 {
            open = l.and(open, l.le(l.load(&boxes.min[axis]), l.load(&boxes.max[axis])));
        }
        for (normal, offset) in self.planes {
            let offset = *offset as f32;
            let (mut least, mut size) = (l.splat(-offset), l.splat(offset.abs()));
            let mut underflow = UNDERFLOW;
            for axis in 0..3 {
                let n = normal[axis] as f32;
                if n.abs() < f32::MIN_POSITIVE && normal[axis] != 0.0 {
                    underflow += LEAST * f32::MAX;
                }
                let corner = if n > 0.0 { &boxes.min[axis] } else { &boxes.max[axis] };
                let product = l.mul(l.splat(n), l.load(corner));
                least = l.add(least, product);
                size = l.add(size, l.abs(product));
            }
            // Seven roundings, and a margin.
            let slack = l.add(l.mul(size, l.splat(ROUNDING as f32)), l.splat(underflow));
            open = l.and_not(open, l.lt(slack, least));
        }
        l.select(open, l.splat(0.0), l.splat(f32::INFINITY))
    }
}

#[cfg(test)]
mod tests;
