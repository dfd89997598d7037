//! The farthest vertex of a polytope, sixteen at a time in f32: the solver's own numbers compare what f32 leaves, most
//! often one, so that the answer has the same bits as without (docs/numerics/queries.md, "supports by lanes").

use super::{Support, farthest};
use crate::{Polytope, Real, Vector};
use dcd_simd::{Kernel, Lanes, WIDTH};
use std::ops::Range;

/// What a product of a direction and a vertex, both rounded to f32, loses, and half of what the threshold below it
/// does: five roundings and one half. Unit: 2⁻²⁴ of the direction's length by the outer radius. Smaller: another vertex
/// than the farthest. Larger: more vertices are compared again.
const LOST: f64 = 6.0;

/// What the same product loses in the solver's numbers. Unit: their roundoff of the direction's length by the reach.
const LOST_IN_REAL: f64 = 8.0;

/// The sums of a direction's absolute components for which no product comes near the ends of f32, where the outer radius is
/// within 2^±40 m.
const DIRECTIONS: Range<f64> = 1.0 / (1u64 << 40) as f64..(1u64 << 40) as f64;

/// How many blocks are searched in one loop over the vertices that f32 leaves: as many as fill a mask.
const BLOCKS_AT_ONCE: usize = u64::BITS as usize / WIDTH;

impl Polytope {
    /// [`SupportMap::support`](crate::SupportMap::support), bit for bit, by the lanes of a kernel. `near` is any vertex, by its
    /// number in [`Polytope::vertex_blocks`]: where it is near the farthest, half the work is saved.
    #[inline(always)]
    pub fn support_in_lanes<R: Real, L: Lanes>(
        &self,
        l: L,
        direction: R::Vec3,
        near: Option<u32>,
    ) -> Support<R> {
        let (blocks, vertices) = (self.vertex_blocks(), self.vertices());
        let size = direction.norm1().to_f64();
        let (first, rest) = match blocks.split_first() {
            Some(blocks) if DIRECTIONS.contains(&size) => blocks,
            _ => return farthest(vertices, direction),
        };
        let [x, y, z] = direction.to_dvec3().as_vec3().to_array();
        let d = [l.splat(x), l.splat(y), l.splat(z)];
        let known = near.and_then(|number| Some((blocks.get(number as usize / WIDTH)?, number)));
        let far = if let Some((block, number)) = known {
            // As the lanes do it.
            let point = block.point(number as usize % WIDTH);
            (point.x * x + point.y * y) + point.z * z
        } else {
            let mut most = first.along(l, &d);
            for block in rest {
                most = l.max(most, block.along(l, &d));
            }
            l.largest(most)
        };
        let lost = LOST * f64::from(f32::UNIT_ROUNDOFF) * self.outer_radius()
            + LOST_IN_REAL * R::UNIT_ROUNDOFF.to_f64() * self.reach();
        let least = f64::from(far) - 2.0 * size * lost;
        let least = l.splat(least as f32 - f32::MIN_POSITIVE);
        let (mut best, mut most) = (0, -R::MAX);
        for (number, blocks) in blocks.chunks(BLOCKS_AT_ONCE).enumerate() {
            // One loop for all of them: where it ends no branch predictor knows.
            let mut bits = 0u64;
            for block in blocks.iter().rev() {
                let left = l.bits(l.le(least, block.along(l, &d))) & 0xffff;
                bits = bits << WIDTH | u64::from(left);
            }
            while bits != 0 {
                let number = number * BLOCKS_AT_ONCE * WIDTH + bits.trailing_zeros() as usize;
                // The last block is filled up with the last vertex.
                let k = number.min(vertices.len() - 1);
                bits &= bits - 1;
                let along = R::Vec3::from_dvec3(vertices[k]).dot(direction);
                if along > most {
                    (best, most) = (k, along);
                }
            }
        }
        Support { point: R::Vec3::from_dvec3(vertices[best]), feature: best as u32 }
    }
}

/// One support, compiled once a path for all searches that take it.
pub(crate) struct FarthestVertex<'a, R: Real>(pub(crate) &'a Polytope, pub(crate) R::Vec3);

impl<R: Real> Kernel for FarthestVertex<'_, R> {
    type Output = Support<R>;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Support<R> {
        let Self(polytope, direction) = self;
        polytope.support_in_lanes(l, direction, None)
    }
}

#[cfg(test)]
mod tests;
