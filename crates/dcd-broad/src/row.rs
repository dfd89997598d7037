//! Boxes side by side.

use dcd_geom::lanes::{Kernel, Lanes, Path, WIDTH, dispatch_on};
use dcd_geom::{Aabb, Sixteen};

/// Which boxes of a [`BoxRow`], a bit each.
pub type BoxSet = u128;

/// Boxes side by side, coordinate by coordinate: as many as a [`BoxSet`] has bits.
#[derive(Clone, Debug)]
pub struct BoxRow {
    pub(crate) boxes: [Sixteen; Self::LENGTH / WIDTH],
}

impl Default for BoxRow {
    fn default() -> Self {
        Self { boxes: [Sixteen::EMPTY; Self::LENGTH / WIDTH] }
    }
}

impl BoxRow {
    /// How many there are.
    pub const LENGTH: usize = BoxSet::BITS as usize;

    /// Replaces box k, which must be below the length.
    #[inline]
    pub fn set(&mut self, k: usize, aabb: &Aabb) {
        self.boxes[k / WIDTH].set(k % WIDTH, aabb);
    }

    /// Which boxes overlap that of the same number in another row: touching counts.
    pub fn overlaps(&self, other: &Self) -> BoxSet {
        dispatch_on(Path::best(), Overlaps { rows: [self, other] })
    }
}

struct Overlaps<'a> {
    rows: [&'a BoxRow; 2],
}

impl Kernel for Overlaps<'_> {
    type Output = BoxSet;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> BoxSet {
        let mut all = 0;
        for k in 0..BoxRow::LENGTH / WIDTH {
            let [a, b] = [&self.rows[0].boxes[k], &self.rows[1].boxes[k]];
            let mut hits = l.le(l.load(&a.min[0]), l.load(&b.max[0]));
            hits = l.and(hits, l.le(l.load(&b.min[0]), l.load(&a.max[0])));
            for axis in 1..3 {
                hits = l.and(hits, l.le(l.load(&a.min[axis]), l.load(&b.max[axis])));
                hits = l.and(hits, l.le(l.load(&b.min[axis]), l.load(&a.max[axis])));
            }
            all |= BoxSet::from(l.bits(hits)) << (k * WIDTH);
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::glam::Vec3;

    #[test]
    fn boxes_are_compared_with_those_of_their_own_number() {
        let (mut a, mut b) = (BoxRow::default(), BoxRow::default());
        assert_eq!(a.overlaps(&b), 0, "empty boxes overlap nothing");
        for k in 0..BoxRow::LENGTH {
            let at = Vec3::splat(k as f32);
            a.set(k, &Aabb { min: at, max: at + 1.0 });
            // The first third touches, the rest is apart by as little as can be.
            let far = if k < 21 { at + 1.0 } else { (at + 1.0).map(f32::next_up) };
            b.set(k, &Aabb { min: far, max: far + 1.0 });
        }
        assert_eq!((a.overlaps(&b), b.overlaps(&a)), ((1 << 21) - 1, (1 << 21) - 1));
        a.set(40, &Aabb::EVERYTHING);
        assert_eq!(a.overlaps(&b), ((1 << 21) - 1) | (1 << 40));
    }
}
