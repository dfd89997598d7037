//! Supports of two polytopes, sixteen vertices at a time in f32.
//!
//! f64 compares those vertices that f32 leaves, most often one: the same bits as all vertices in f64
//! (docs/numerics/queries.md, "supports by lanes").

use crate::{Difference, Vertex};
use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, Shape, Support, SupportMap};
use dcd_simd::{Block, Kernel, Lanes, WIDTH, dispatch};

/// What a product of a direction and a vertex, both rounded to f32, loses, and half of what the threshold below it
/// does: five roundings and one half. Unit: 2⁻²⁴ of the direction's length by the outer radius. Smaller: another vertex
/// than the farthest. Larger: more vertices are compared in f64.
const LOST: f64 = 6.0 * (f32::EPSILON as f64 / 2.0);

/// What the same product loses in f64. Unit: 2⁻⁵³ of the direction's length by the reach.
const LOST_IN_F64: f64 = 8.0 * (f64::EPSILON / 2.0);

pub(crate) type Polytopes<'b> = Difference<'b, f64, Polytope, Polytope>;

/// A support map that may have its vertices in blocks.
pub(crate) trait InBlocks: SupportMap<f64> {
    /// The polytope that it is.
    fn polytope(&self) -> Option<&Polytope>;
}

impl InBlocks for Polytope {
    #[inline(always)]
    fn polytope(&self) -> Option<&Polytope> {
        Some(self)
    }
}

impl InBlocks for Shape {
    #[inline(always)]
    fn polytope(&self) -> Option<&Polytope> {
        match self {
            Self::Polytope(polytope) => Some(polytope),
            _ => None,
        }
    }
}

/// [`Difference::lowest`], by lanes where that is quicker.
pub(crate) fn lowest<A: InBlocks, B: InBlocks>(
    difference: &Difference<'_, f64, A, B>,
    direction: DVec3,
) -> (Vertex<f64>, f64) {
    let (a, b) = difference.maps();
    if has_blocks(a) || has_blocks(b) {
        dispatch(LowestVertex { difference, direction, near: None })
    } else {
        difference.lowest(direction)
    }
}

fn has_blocks(map: &impl InBlocks) -> bool {
    map.polytope().is_some_and(|polytope| !polytope.vertex_blocks().is_empty())
}

/// One support, compiled once a path for all searches that take it.
struct LowestVertex<'a, 'b, A, B> {
    difference: &'a Difference<'b, f64, A, B>,
    direction: DVec3,
    /// Vertices that may be near the farthest of either.
    near: Option<[u32; 2]>,
}

impl<A: InBlocks, B: InBlocks> Kernel for LowestVertex<'_, '_, A, B> {
    type Output = (Vertex<f64>, f64);

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Self::Output {
        let Self { difference, direction, near } = self;
        let (a, b) = difference.maps();
        let [in_a, in_b] = difference.to_local(direction);
        let [near_a, near_b] = near.map_or([None; 2], |near| near.map(Some));
        let (a, b) = (farthest(l, a, -in_a, near_a), farthest(l, b, in_b, near_b));
        let vertex = Vertex { w: difference.world(a.point, b.point), a, b };
        (vertex, difference.separation(direction, &vertex))
    }
}

/// Supports of one difference.
pub(crate) struct Exact<'a, 'b, L, A, B> {
    pub(crate) lanes: L,
    pub(crate) difference: &'a Difference<'b, f64, A, B>,
    /// Vertices of A and of B, by their numbers in the blocks: where they are near the farthest, half the work is saved.
    pub(crate) near: Option<[u32; 2]>,
}

impl<L: Lanes, A: InBlocks, B: InBlocks> Exact<'_, '_, L, A, B> {
    /// [`Difference::lowest`], bit for bit. The direction's largest component is 1.
    #[inline(always)]
    pub(crate) fn lowest(&self, direction: DVec3) -> (Vertex<f64>, f64) {
        let &Self { lanes, difference, near } = self;
        lanes.call(LowestVertex { difference, direction, near })
    }
}

/// Sixteen products of vertices and a direction, each rounded twice: the same bits on every path.
#[inline(always)]
pub(crate) fn along<L: Lanes>(l: L, block: &Block, d: &[L::F; 3]) -> L::F {
    let Block([x, y, z]) = block;
    let (x, y, z) = (l.mul(l.load(x), d[0]), l.mul(l.load(y), d[1]), l.mul(l.load(z), d[2]));
    l.add(l.add(x, y), z)
}

/// How many blocks are searched in one loop over the vertices that f32 leaves: as many as fill a mask.
const BLOCKS_AT_ONCE: usize = u64::BITS as usize / WIDTH;

/// The farthest vertex in f64, the first among equals. `near` is any vertex, by its number in the blocks.
#[inline(always)]
fn farthest<L: Lanes>(
    l: L,
    map: &impl InBlocks,
    direction: DVec3,
    near: Option<u32>,
) -> Support<f64> {
    let Some(polytope) = map.polytope() else { return map.support(direction) };
    let (blocks, vertices) = (polytope.vertex_blocks(), polytope.vertices());
    let Some((first, rest)) = blocks.split_first() else { return polytope.support(direction) };
    let [x, y, z] = direction.as_vec3().to_array();
    let d = [l.splat(x), l.splat(y), l.splat(z)];
    let known = near.and_then(|number| Some((blocks.get(number as usize / WIDTH)?, number)));
    let far = if let Some((block, number)) = known {
        // As the lanes do it.
        let point = block.point(number as usize % WIDTH);
        (point.x * x + point.y * y) + point.z * z
    } else {
        let mut most = along(l, first, &d);
        for block in rest {
            most = l.max(most, along(l, block, &d));
        }
        l.largest(most)
    };
    let size = direction.abs().element_sum();
    let lost = size * (LOST * polytope.outer_radius() + LOST_IN_F64 * polytope.reach());
    let least = f64::from(far) - 2.0 * lost;
    let least = l.splat(least as f32 - f32::MIN_POSITIVE);
    let (mut best, mut farthest) = (0, f64::MIN);
    for (number, blocks) in blocks.chunks(BLOCKS_AT_ONCE).enumerate() {
        // One loop for all of them: where it ends no branch predictor knows.
        let mut bits = 0u64;
        for block in blocks.iter().rev() {
            let left = l.bits(l.le(least, along(l, block, &d))) & 0xffff;
            bits = bits << WIDTH | u64::from(left);
        }
        while bits != 0 {
            let number = number * BLOCKS_AT_ONCE * WIDTH + bits.trailing_zeros() as usize;
            // The last block is filled up with the last vertex.
            let k = number.min(vertices.len() - 1);
            bits &= bits - 1;
            let along = vertices[k].dot(direction);
            if along > farthest {
                (best, farthest) = (k, along);
            }
        }
    }
    Support { point: vertices[best], feature: best as u32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PosedSupport;
    use crate::gjk::unit;
    use crate::motion::tests::Draw;
    use dcd_geom::Pose;
    use dcd_geom::glam::DQuat;
    use dcd_simd::{Path, dispatch_on};

    fn polytope(draw: &mut Draw, k: usize) -> Polytope {
        // Every other one with ties, a third far from its own origin, some without blocks.
        let from = [DVec3::ZERO, DVec3::ZERO, DVec3::splat(1e7)][k % 3];
        let scale = [1.0, 1e-4, 1e4][k / 2 % 3];
        let points = (0..4 + k % 90).map(|_| {
            let point = draw.vector();
            scale * (from + if k.is_multiple_of(2) { (point * 3.0).round() } else { point })
        });
        Polytope::hull(points.collect()).unwrap()
    }

    #[test]
    fn lanes_find_the_vertex_that_all_in_f64_would_and_the_same_one_on_every_path() {
        let seed = std::env::var("DCD_SEED").map_or(5, |seed| seed.parse().expect("a seed"));
        let mut draw = Draw(seed);
        for k in 0..1500 {
            let (a, b) = (polytope(&mut draw, k), polytope(&mut draw, k / 7));
            let turn = DQuat::from_scaled_axis(draw.vector() * f64::from(k as u32 % 4));
            let (pose_a, pose_b) = (
                Pose::new(turn.normalize(), draw.vector()).unwrap(),
                Pose::from_translation(draw.vector()).unwrap(),
            );
            let posed = (PosedSupport::polytope(&a, &pose_a), PosedSupport::polytope(&b, &pose_b));
            let difference = Difference::new(posed.0, posed.1).unwrap();
            for j in 0..6 {
                let along = if j == 0 { DVec3::Y } else { draw.vector() };
                let along = if j % 2 == 0 { turn * along.round() } else { along };
                let Some(direction) = unit::<f64>(along.to_array()) else { continue };
                let expected = difference.lowest(direction);
                // Any vertices may be given as near; a block's last number may be past the last vertex.
                let blocks = [a.vertex_blocks().len(), b.vertex_blocks().len()];
                let any = blocks.map(|blocks| (k * 7 + j) as u32 % (blocks * WIDTH).max(1) as u32);
                let found = [expected.0.a.feature, expected.0.b.feature];
                for path in Path::ALL {
                    for near in [None, Some(any), Some(found)] {
                        let kernel = LowestVertex { difference: &difference, direction, near };
                        assert_eq!(dispatch_on(path, kernel), expected, "{seed} {k} {path:?}");
                    }
                }
            }
        }
    }
}
