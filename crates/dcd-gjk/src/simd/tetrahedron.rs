//! Touching without a sphere: two flat shapes have none between them, and then four points of A − B
//! round the origin must do.

use super::bounds::{CORNER, DETERMINANT, EVALUATED, FLAT, U};
use super::certificate::ErrorBounds;
use super::packet::{Number, PairPacket};
use super::vector::V3;
use dcd_simd::Lanes;

/// Whether a sphere as small as the lane's is worth nothing beside rounding.
#[inline(always)]
pub(super) fn is_flat<L: Lanes>(l: L, packet: &PairPacket) -> L::M {
    let unit = packet.number(l, Number::Unit);
    l.lt(packet.number(l, Number::Inner), l.mul(unit, l.splat(FLAT)))
}

/// Whether the tetrahedron of c and three computed points surely holds the origin: if every point is
/// moved by what it may be off, it still does (docs/numerics/proofs.md, "four points in the lanes").
#[inline(always)]
pub(super) fn holds_origin<L: Lanes, T: ErrorBounds>(
    l: L,
    packet: &PairPacket,
    c: V3<L>,
    p: [V3<L>; 3],
) -> L::M {
    let unit = packet.number(l, Number::Unit);
    let off = l.mul_add(unit, l.splat(CORNER), packet.number(l, Number::Slack));
    // m³ times u² is beyond what underflow may take.
    let least = l.mul(l.mul(l.mul(unit, l.splat(1.0 / U)), unit), unit);
    let lengths = [p[0].norm1(l), p[1].norm1(l), p[2].norm1(l)];
    let from_c = [p[0].sub(l, c), p[1].sub(l, c), p[2].sub(l, c)];
    let edges = [from_c[0].norm1(l), from_c[1].norm1(l), from_c[2].norm1(l)];
    let c_length = c.norm1(l);

    let mut inside = l.mask(u32::MAX);
    let mut beyond = l.mask(u32::MAX);
    for k in 0..4 {
        // The three faces at c, seen from the origin, and the one across, the other way round.
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let (volume, product, area) = if k < 3 {
            let volume = l.neg(c.dot(l, p[i].cross(l, p[j])));
            let product = l.mul(c_length, l.mul(lengths[i], lengths[j]));
            (volume, product, l.mul(edges[i], edges[j]))
        } else {
            let volume = p[0].dot(l, p[1].cross(l, p[2]));
            let product = l.mul(lengths[0], l.mul(lengths[1], lengths[2]));
            let sides = [p[1].sub(l, p[0]).norm1(l), p[2].sub(l, p[0]).norm1(l)];
            (volume, product, l.mul(sides[0], sides[1]))
        };
        let rounding = l.mul(product, l.splat(DETERMINANT * U));
        let rounding = l.mul_add(l.mul(off, area), l.splat(EVALUATED), rounding);
        let rounding = T::rounding(l, l.add(rounding, least));
        inside = l.and(inside, l.lt(rounding, volume));
        beyond = l.and(beyond, l.lt(rounding, l.neg(volume)));
    }
    l.or(inside, beyond)
}

#[cfg(test)]
mod tests {
    use super::super::certificate::CertifiedBounds;
    use super::super::packet::Vector;
    use super::*;
    use dcd_geom::glam::DVec3;
    use dcd_simd::{Block, Kernel, Path, WIDTH, dispatch_on};

    /// Sixteen tetrahedra of a size m, by their corners.
    struct Holds<'a>(&'a [Block; 4], f32);

    impl Kernel for Holds<'_> {
        type Output = u32;

        #[inline(always)]
        fn run<L: Lanes>(self, l: L) -> u32 {
            let mut packet = PairPacket::default();
            packet.set_number(l, Number::Unit, l.splat(self.1 * U));
            packet.set_number(l, Number::Slack, l.splat(0.0));
            packet.set_vector(l, Vector::C, V3::load(l, &self.0[0].0));
            let [p, q, r] = [1, 2, 3].map(|k| V3::load(l, &self.0[k].0));
            let c = packet.vector(l, Vector::C);
            l.bits(holds_origin::<L, CertifiedBounds>(l, &packet, c, [p, q, r]))
        }
    }

    /// The scalar reference: by how much of m the least of the four heights exceeds 0, in f64; negative
    /// where the point is outside.
    fn depth(corners: [DVec3; 4], point: DVec3) -> f64 {
        let mut depth = f64::INFINITY;
        for k in 0..4 {
            let [a, b, c] = [1, 2, 3].map(|j| corners[(k + j) % 4]);
            let normal = (b - a).cross(c - a).normalize();
            let side = normal.dot(corners[k] - a).signum();
            depth = depth.min(side * normal.dot(point - a));
        }
        depth
    }

    #[test]
    fn a_tetrahedron_that_is_said_to_hold_the_origin_holds_all_that_it_may_be() {
        let mut state = 3u64;
        let mut next = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        };
        let (mut yes, mut clear) = (0, 0);
        for round in 0..2000 {
            // Round, flat and needle-like ones, some of them very small or large.
            let m = [1.0f32, 1e-6, 3e8][round % 3];
            let thin = [1.0, 1e-3, 1e-5, 1e-7][round % 4];
            let mut corners = [Block::default(); 4];
            let mut plain = [[DVec3::ZERO; 4]; WIDTH];
            for (lane, plain) in plain.iter_mut().enumerate() {
                let shift = next() * thin;
                for (corner, block) in plain.iter_mut().zip(&mut corners) {
                    let point = DVec3::new(next(), next() * 0.5, (next() + shift) * thin);
                    let point = (point * 0.3 * f64::from(m)).as_vec3();
                    *corner = point.as_dvec3();
                    for (row, x) in block.0.iter_mut().zip(point.to_array()) {
                        row.0[lane] = x;
                    }
                }
            }
            for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
                let held = dispatch_on(path, Holds(&corners, m));
                for (lane, &plain) in plain.iter().enumerate() {
                    let held = held >> lane & 1 == 1;
                    let off = f64::from(CORNER * U * m);
                    let worst = (0..8u32).map(|k| {
                        let sign = |bit: u32| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
                        depth(plain, DVec3::new(sign(0), sign(1), sign(2)) * off)
                    });
                    let worst = worst.fold(f64::INFINITY, f64::min);
                    assert!(!held || worst > 0.0, "{plain:?}: {worst}");
                    // Far inside of what is neither flat nor small it must say so.
                    let far = depth(plain, DVec3::ZERO) > 1e-3 * f64::from(m);
                    assert!(held || !far, "{plain:?}");
                    yes += usize::from(held);
                    clear += usize::from(held && far);
                }
            }
        }
        assert!(yes > 1000 && clear > 100 && clear < yes, "{yes}, {clear}");
    }
}
