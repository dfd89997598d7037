//! Supports of many vertices, sixteen at a time in f32: the same bits as by comparing one vertex after the other.
//!
//! The lanes leave the vertices that may be farthest, most often one; those are compared in the arithmetic that the
//! caller computes in (docs/numerics/proofs.md, "supports by lanes").

use crate::{Real, Support, Vector};
use dcd_simd::{Block, Kernel, Lanes, WIDTH, dispatch};
use glam::DVec3;

/// Vertices about a centre, in f32.
#[derive(Clone, Debug)]
pub(crate) struct LaneSupports {
    /// The last one is filled up with the last vertex.
    blocks: Vec<Block>,
    /// The largest component of a vertex's difference from the centre, metres.
    extent: f64,
    /// The largest distance of a vertex from the origin, rounded up.
    reach: f64,
}

/// How far below the largest value in the lanes that of a farthest vertex may be. Unit: 2⁻²⁴ of |d|₁ times the extent,
/// and unit roundoffs of |d|₁ times the reach. Twice 5.1 for what a value loses, and 1.1 for the difference itself.
/// Smaller: another vertex than the farthest. Larger: more vertices are compared again.
const SLACK: f64 = 12.0;

/// Unit roundoff of f32.
const U: f64 = f32::EPSILON as f64 / 2.0;

/// The lengths and directions for which no product in f32 comes near its range's ends; from the reciprocal on.
const WIDEST: f64 = (1u64 << 40) as f64;

impl LaneSupports {
    /// `None` where f32 does not have the vertices' range, or there are so few that nothing is gained.
    pub(crate) fn of(vertices: &[DVec3], centre: DVec3, reach: f64) -> Option<Self> {
        let largest = |most: f64, v: &DVec3| most.max((*v - centre).abs().max_element());
        let extent = vertices.iter().fold(0.0, largest);
        let is_within = extent > WIDEST.recip() && reach < WIDEST;
        let blocks = || Block::relative(vertices, centre).collect();
        is_within.then(|| Self { blocks: blocks(), extent, reach })
    }

    /// The farthest of the vertices, the first among equals, as computed one by one. `None` for directions that f32
    /// does not have.
    #[inline]
    pub(crate) fn farthest<R: Real>(
        &self,
        vertices: &[DVec3],
        direction: R::Vec3,
    ) -> Option<Support<R>> {
        let [x, y, z] = direction.components().map(R::to_f64);
        let sum = x.abs() + y.abs() + z.abs();
        // Written so that NaN is none.
        if !(sum > WIDEST.recip() && sum < WIDEST) {
            return None;
        }
        let lost = U * self.extent + R::UNIT_ROUNDOFF.to_f64() * self.reach;
        let (d, slack) = ([x as f32, y as f32, z as f32], (SLACK * lost * sum) as f32);
        let best = dispatch(Farthest::<R> { blocks: &self.blocks, vertices, direction, d, slack });
        let point = R::Vec3::from_dvec3(*vertices.get(best)?);
        Some(Support { point, feature: best as u32 })
    }
}

struct Farthest<'a, R: Real> {
    blocks: &'a [Block],
    vertices: &'a [DVec3],
    direction: R::Vec3,
    d: [f32; 3],
    slack: f32,
}

impl<R: Real> Kernel for Farthest<'_, R> {
    type Output = usize;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> usize {
        let d = [l.splat(self.d[0]), l.splat(self.d[1]), l.splat(self.d[2])];
        let mut most = l.splat(f32::MIN);
        for block in self.blocks {
            most = l.max(most, along(l, block, d));
        }
        let least = l.splat(l.largest(most) - self.slack);
        let (mut best, mut farthest) = (0, -R::MAX);
        for (number, block) in self.blocks.iter().enumerate() {
            let mut near = l.bits(l.le(least, along(l, block, d)));
            while near != 0 {
                let k = number * WIDTH + near.trailing_zeros() as usize;
                near &= near - 1;
                // Past the last one the lanes hold it again.
                let Some(&vertex) = self.vertices.get(k) else { break };
                let value = R::Vec3::from_dvec3(vertex).dot(self.direction);
                if value > farthest {
                    (best, farthest) = (k, value);
                }
            }
        }
        best
    }
}

/// d·v of sixteen vertices.
#[inline(always)]
fn along<L: Lanes>(l: L, Block([x, y, z]): &Block, d: [L::F; 3]) -> L::F {
    let (x, y, z) = (l.load(x), l.load(y), l.load(z));
    l.mul_add(x, d[0], l.mul_add(y, d[1], l.mul(z, d[2])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::farthest;
    use glam::Vec3;

    /// In ±1, of splitmix64.
    struct Draw(u64);

    impl Draw {
        fn number(&mut self) -> f64 {
            self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ z >> 31) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }

        fn vector(&mut self) -> DVec3 {
            DVec3::new(self.number(), self.number(), self.number())
        }
    }

    /// Vertices that a direction can hardly tell apart: of a lattice, of a sphere, or all within some last bits.
    fn vertices(draw: &mut Draw, kind: usize, count: usize) -> Vec<DVec3> {
        let far = draw.vector() * [0.0, 1.0, 1e9][kind / 3 % 3];
        let scale = [1.0, 1e-6, 1e6][kind / 9 % 3];
        let point = |draw: &mut Draw| match kind % 3 {
            0 => (draw.vector() * 2.0).round(),
            1 => draw.vector().normalize_or(DVec3::X),
            _ => DVec3::X + draw.vector() * 1e-7,
        };
        (0..count).map(|_| (point(draw) + far) * scale).collect()
    }

    #[test]
    fn the_lanes_find_the_very_vertex_that_the_plain_loop_finds() {
        let seed = std::env::var("DCD_SEED").map_or(5, |seed| seed.parse().expect("a seed"));
        let mut draw = Draw(seed);
        let mut found = 0;
        for k in 0..3000 {
            let vertices = vertices(&mut draw, k, 1 + k * 7 % 61);
            let centre = vertices.iter().sum::<DVec3>() / vertices.len() as f64;
            let reach = vertices.iter().map(|v| v.length()).fold(0.0, f64::max).next_up();
            let Some(lanes) = LaneSupports::of(&vertices, centre, reach) else { continue };
            for j in 0..8 {
                let size = [1.0, 1e-9, 1e9, 1.0][j % 4];
                let d = if j < 4 { draw.vector() } else { (draw.vector() * 1.5).round() } * size;
                let expected = farthest::<f64>(&vertices, d);
                if let Some(support) = lanes.farthest::<f64>(&vertices, d) {
                    assert_eq!(support, expected, "{seed} {k}");
                    found += 1;
                }
                let rounded: Vec3 = d.as_vec3();
                if let Some(support) = lanes.farthest::<f32>(&vertices, rounded) {
                    assert_eq!(support, farthest::<f32>(&vertices, rounded), "{seed} {k}");
                }
            }
        }
        assert!(found > 10_000, "{found}");
    }

    #[test]
    fn what_f32_does_not_have_is_left_to_the_plain_loop() {
        let cube: Vec<DVec3> = (0..8)
            .map(|k| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)))
            .collect();
        let lanes = LaneSupports::of(&cube, DVec3::splat(0.5), 2.0).unwrap();
        for bad in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY, DVec3::X * 1e-20, DVec3::X * 1e20] {
            assert_eq!(lanes.farthest::<f64>(&cube, bad), None, "{bad}");
        }
        assert!(LaneSupports::of(&[DVec3::ONE; 3], DVec3::ONE, 2.0).is_none());
        assert!(LaneSupports::of(&[DVec3::ZERO, DVec3::X * 1e30], DVec3::ZERO, 1e30).is_none());
    }
}
