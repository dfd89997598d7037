//! Sets of the configurations that are worked on at once.

use dcd_broad::{Aabb128, Mask128};
use std::ops::{BitAnd, BitAndAssign, BitOr, BitOrAssign, Not};

/// How many configurations are worked on at once: enough for full lanes, even where few of them are
/// left, and few enough for the vertices of their links to stay near.
pub(super) const ROW: usize = WORDS * Aabb128::LENGTH;

/// How many [`Mask128`]s a set is.
pub(super) const WORDS: usize = 4;

/// Some of a row of configurations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Set(pub(super) [Mask128; WORDS]);

impl Set {
    /// The first so many, at most all.
    pub(super) fn first(count: usize) -> Self {
        let mut first = Self::default();
        (0..count).for_each(|member| first.add(member));
        first
    }

    #[inline]
    pub(super) fn is_empty(self) -> bool {
        self.0.iter().fold(0, |all, word| all | word) == 0
    }

    /// How many members it has.
    pub(super) fn len(self) -> usize {
        self.0.iter().map(|word| word.count_ones() as usize).sum()
    }

    #[inline]
    pub(super) fn has(self, member: usize) -> bool {
        self.0[member / Aabb128::LENGTH] >> (member % Aabb128::LENGTH) & 1 == 1
    }

    #[inline]
    pub(super) fn add(&mut self, member: usize) {
        self.0[member / Aabb128::LENGTH] |= 1 << (member % Aabb128::LENGTH);
    }

    #[inline]
    pub(super) fn remove(&mut self, member: usize) {
        self.0[member / Aabb128::LENGTH] &= !(1 << (member % Aabb128::LENGTH));
    }
}

impl BitAnd for Set {
    type Output = Self;

    #[inline]
    fn bitand(self, other: Self) -> Self {
        Self(std::array::from_fn(|word| self.0[word] & other.0[word]))
    }
}

impl BitOr for Set {
    type Output = Self;

    #[inline]
    fn bitor(self, other: Self) -> Self {
        Self(std::array::from_fn(|word| self.0[word] | other.0[word]))
    }
}

impl Not for Set {
    type Output = Self;

    #[inline]
    fn not(self) -> Self {
        Self(self.0.map(|word| !word))
    }
}

impl BitAndAssign for Set {
    #[inline]
    fn bitand_assign(&mut self, other: Self) {
        *self = *self & other;
    }
}

impl BitOrAssign for Set {
    #[inline]
    fn bitor_assign(&mut self, other: Self) {
        *self = *self | other;
    }
}

/// The members of a set, ascending.
pub(super) struct Members {
    set: Set,
    /// Those left of the machine word that begins with this member.
    bits: u64,
    first: usize,
}

impl Members {
    pub(super) fn of(set: Set) -> Self {
        Self { set, bits: set.0[0] as u64, first: 0 }
    }
}

impl Iterator for Members {
    type Item = usize;

    #[inline]
    fn next(&mut self) -> Option<usize> {
        while self.bits == 0 {
            self.first += HALF;
            let word = *self.set.0.get(self.first / Aabb128::LENGTH)?;
            self.bits = (word >> (self.first % Aabb128::LENGTH)) as u64;
        }
        let member = self.bits.trailing_zeros() as usize;
        self.bits &= self.bits - 1;
        Some(self.first + member)
    }
}

/// A set that comes together member by member, without a branch.
#[derive(Default)]
pub(super) struct Marks([u64; ROW / HALF]);

impl Marks {
    #[inline]
    pub(super) fn mark(&mut self, member: usize, is_one: bool) {
        self.0[member / HALF] |= u64::from(is_one) << (member % HALF);
    }

    pub(super) fn set(&self) -> Set {
        let word =
            |k: usize| Mask128::from(self.0[2 * k]) | Mask128::from(self.0[2 * k + 1]) << HALF;
        Set(std::array::from_fn(word))
    }
}

/// As many members as one machine word has.
const HALF: usize = u64::BITS as usize;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_are_listed_once_and_ascending() {
        let mut set = Set::default();
        assert!(set.is_empty() && Members::of(set).count() == 0);
        for member in [ROW - 1, 3, 1, Aabb128::LENGTH] {
            set.add(member);
        }
        assert_eq!(Members::of(set).collect::<Vec<_>>(), [1, 3, Aabb128::LENGTH, ROW - 1]);
        assert!(set.has(3) && !set.has(2) && set.len() == 4);
        set.remove(3);
        assert_eq!(Members::of(set).collect::<Vec<_>>(), [1, Aabb128::LENGTH, ROW - 1]);
        assert!(Members::of(!Set::default()).eq(0..ROW));
    }
}
