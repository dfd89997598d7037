//! Axes that separated two objects in an earlier step, to be tried first.

use super::packet::PairPacket;
use super::vector::V3;
use dcd_geom::glam::Vec3;
use dcd_simd::{Block, Lanes, WIDTH};

/// A direction in the world from b to a, of any length, to one part in 2¹⁵; or none, all 0. A hint:
/// nothing is concluded from it without a certificate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Axis(pub(crate) [i16; 3]);

/// The largest component of a direction.
const LARGEST: f32 = i16::MAX as f32;

/// So that directions are about as long as 1 again.
const UNIT: f32 = 1.0 / LARGEST;

impl Axis {
    /// None where the direction is 0 or no number.
    #[inline(always)]
    pub(crate) fn along(direction: Vec3) -> Self {
        let scaled = direction * (LARGEST / direction.abs().max_element());
        // A number too large becomes the largest, and NaN 0.
        Self(scaled.to_array().map(|x| x as i16))
    }
}

/// For each of the first `used` lanes its pair's axis where there is one, else `otherwise`.
#[inline(always)]
pub(super) fn hinted<L: Lanes>(
    l: L,
    axes: &[Axis],
    (packet, used): (&PairPacket, usize),
    otherwise: V3<L>,
) -> V3<L> {
    let mut rows = Block::default();
    for lane in 0..used.min(WIDTH) {
        let Axis([x, y, z]) = axes.get(packet.number.0[lane] as usize).copied().unwrap_or_default();
        rows.0[0].0[lane] = f32::from(x) * UNIT;
        rows.0[1].0[lane] = f32::from(y) * UNIT;
        rows.0[2].0[lane] = f32::from(z) * UNIT;
    }
    let hint = V3::load(l, &rows.0);
    let some = l.lt(l.splat(0.0), hint.norm1(l));
    V3::select(l, some, hint, otherwise)
}
