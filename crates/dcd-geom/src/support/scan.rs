//! The farthest of many vertices, found in f32 and decided in the solver's own numbers.

use super::{Support, farthest};
use crate::{Real, Vector};
use dcd_simd::{Block, Kernel, Lanes, Path, WIDTH, dispatch_on};
use glam::{DVec3, Vec3};

/// What a product of a vertex, relative to the centre, and a direction may be off in f32, in units of 2⁻²⁴ · the
/// radius round the centre · the sum of the direction's absolute components: two roundings of what is multiplied, four
/// of products and sums, each times 1.01. Of two such products: 13. Smaller: another vertex than the farthest.
const PRODUCTS: f64 = 14.0;

/// The same of the vertex itself in the solver's numbers, in units of their roundoff: four roundings, of two products.
const ROUNDINGS: f64 = 9.0;

/// The smallest and the largest sum of a direction's absolute components for which no product comes near the ends of f32,
/// where the radius round the centre is within 2^±40.
const DIRECTIONS: std::ops::Range<f64> = 1.0 / (1u64 << 40) as f64..(1u64 << 40) as f64;

/// The vertices of a polytope, and the same in f32.
pub(crate) struct Vertices<'a> {
    pub(crate) points: &'a [DVec3],
    /// Relative to a centre, the last block filled up.
    pub(crate) blocks: &'a [Block],
    /// How far any is from that centre, and from the origin, metres.
    pub(crate) radius: f64,
    pub(crate) reach: f64,
}

impl Vertices<'_> {
    /// What [`farthest`] finds of the points, bit for bit: sixteen at a time are compared in f32, and those that may be
    /// the farthest as there.
    pub(crate) fn farthest<R: Real>(&self, direction: R::Vec3) -> Support<R> {
        let size = direction.norm1().to_f64();
        if !DIRECTIONS.contains(&size) {
            return farthest(self.points, direction);
        }
        let slack = PRODUCTS * self.radius * f64::from(f32::UNIT_ROUNDOFF)
            + ROUNDINGS * self.reach * R::UNIT_ROUNDOFF.to_f64();
        let rounded = direction.to_dvec3().as_vec3();
        let scan = Scan { blocks: self.blocks, direction: rounded, slack: slack * size };
        let (mut most, mut best) = (-R::MAX, 0);
        let visit = |index: usize| {
            let Some(&point) = self.points.get(index) else { return };
            let along = R::Vec3::from_dvec3(point).dot(direction);
            if along > most {
                (most, best) = (along, index);
            }
        };
        dispatch_on(Path::best(), Visit(scan, visit));
        Support { point: R::Vec3::from_dvec3(self.points[best]), feature: best as u32 }
    }
}

struct Scan<'a> {
    blocks: &'a [Block],
    direction: Vec3,
    /// How far below the largest product that of the farthest may be.
    slack: f64,
}

/// Visits the points that may be the farthest in their order.
struct Visit<'a, F>(Scan<'a>, F);

impl<F: FnMut(usize)> Kernel for Visit<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self(Scan { blocks, direction, slack }, mut visit) = self;
        let direction = [l.splat(direction.x), l.splat(direction.y), l.splat(direction.z)];
        let mut most = l.splat(f32::NEG_INFINITY);
        for block in blocks {
            most = l.max(most, along(l, block, direction));
        }
        let least = (f64::from(l.largest(most)) - slack) as f32;
        let least = l.splat(least.next_down());
        for (number, block) in blocks.iter().enumerate() {
            let mut close = l.bits(l.le(least, along(l, block, direction)));
            while close != 0 {
                visit(number * WIDTH + close.trailing_zeros() as usize);
                close &= close - 1;
            }
        }
    }
}

/// The products of sixteen points and a direction.
#[inline(always)]
fn along<L: Lanes>(l: L, Block(rows): &Block, [x, y, z]: [L::F; 3]) -> L::F {
    let sum = l.mul_add(l.load(&rows[1]), y, l.mul(l.load(&rows[0]), x));
    l.mul_add(l.load(&rows[2]), z, sum)
}

#[cfg(test)]
mod tests;
