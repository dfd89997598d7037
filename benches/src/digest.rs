//! Digests of contact lists: that a step found the same again.

use dcd_geom::Pair;

/// A digest that distinguishes two lists of pairs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digest {
    /// Of the pairs in their order.
    pub list: u64,
    /// Of the pairs as a set.
    pub set: u64,
}

impl Digest {
    /// Of these pairs; one multiplication each, so that it does not outweigh a short step.
    #[must_use]
    pub fn of(pairs: impl Iterator<Item = Pair>) -> Self {
        pairs.fold(Self { list: 0, set: 0 }, |digest, pair| {
            let one = scrambled(u64::from(pair.i) << 32 | u64::from(pair.j));
            Self {
                list: (digest.list.rotate_left(5) ^ one).wrapping_mul(ODD),
                set: digest.set.wrapping_add(one),
            }
        })
    }
}

/// 2⁶⁴ over the golden ratio, made odd: spreads neighbouring numbers (Knuth, volume 3, section 6.4).
const ODD: u64 = 0x9e37_79b9_7f4a_7c15;

/// A bijection under which sums of pairs do not cancel by chance.
fn scrambled(x: u64) -> u64 {
    let x = (x ^ ODD).wrapping_mul(ODD);
    (x ^ x >> 32).wrapping_mul(ODD)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_changes_the_list_and_not_the_set() {
        let [a, b] = [Pair { i: 0, j: 1 }, Pair { i: 0, j: 2 }];
        let [ab, ba] = [[a, b], [b, a]].map(|pairs| Digest::of(pairs.into_iter()));
        assert_eq!(ab.set, ba.set);
        assert_ne!(ab.list, ba.list);
    }

    #[test]
    fn a_pair_more_or_another_one_changes_both() {
        let digest = |pairs: &[(u32, u32)]| Digest::of(pairs.iter().map(|&(i, j)| Pair { i, j }));
        let base = digest(&[(0, 1), (5, 9)]);
        for other in [digest(&[(0, 1)]), digest(&[(0, 1), (5, 8)]), digest(&[(0, 9), (5, 1)])] {
            assert!(base.set != other.set && base.list != other.list);
        }
    }
}
