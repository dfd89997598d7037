//! Sets of the configurations that are worked on at once.

use dcd_broad::{BoxRow, BoxSet};
use std::ops::{BitAnd, BitAndAssign, BitOr, BitOrAssign, Not};

/// How many configurations are worked on at once: enough for full lanes, even where few of them are
/// left, and few enough for the vertices of their links to stay near.
pub(super) const ROW: usize = WORDS * BoxRow::LENGTH;

/// How many [`BoxSet`]s a set is.
pub(super) const WORDS: usize = 4;

/// Some of a row of configurations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Set(pub(super) [BoxSet; WORDS]);

impl Set {
    /// The first `count` of a row.
    pub(super) fn first(count: usize) -> Self {
        let all = |word: usize| BoxRow::LENGTH.min(count.saturating_sub(word * BoxRow::LENGTH));
        Self(std::array::from_fn(|word| match all(word) {
            0 => 0,
            members => BoxSet::MAX >> (BoxRow::LENGTH - members),
        }))
    }

    #[inline]
    pub(super) fn is_empty(self) -> bool {
        self == Self::default()
    }

    /// How many members it has.
    pub(super) fn len(self) -> usize {
        self.0.iter().map(|word| word.count_ones() as usize).sum()
    }

    #[inline]
    pub(super) fn has(self, member: usize) -> bool {
        self.0[member / BoxRow::LENGTH] >> (member % BoxRow::LENGTH) & 1 == 1
    }

    #[inline]
    pub(super) fn add(&mut self, member: usize) {
        self.0[member / BoxRow::LENGTH] |= 1 << (member % BoxRow::LENGTH);
    }

    #[inline]
    pub(super) fn remove(&mut self, member: usize) {
        self.0[member / BoxRow::LENGTH] &= !(1 << (member % BoxRow::LENGTH));
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
pub(super) struct Members(pub(super) Set);

impl Iterator for Members {
    type Item = usize;

    #[inline]
    fn next(&mut self) -> Option<usize> {
        let words = &mut self.0.0;
        let word = words.iter().position(|&word| word != 0)?;
        let member = words[word].trailing_zeros() as usize;
        words[word] &= words[word] - 1;
        Some(word * BoxRow::LENGTH + member)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_are_told_once_and_ascending() {
        let mut set = Set::default();
        assert!(set.is_empty() && Members(set).count() == 0);
        for member in [ROW - 1, 3, 1, BoxRow::LENGTH] {
            set.add(member);
        }
        assert_eq!(Members(set).collect::<Vec<_>>(), [1, 3, BoxRow::LENGTH, ROW - 1]);
        assert!(set.has(3) && !set.has(2) && set.len() == 4);
        set.remove(3);
        assert_eq!(Members(set).collect::<Vec<_>>(), [1, BoxRow::LENGTH, ROW - 1]);
        assert!(Members(!Set::default()).eq(0..ROW));
    }

    #[test]
    fn the_first_of_a_row_are_as_many_as_asked_for() {
        for count in [0, 1, BoxRow::LENGTH - 1, BoxRow::LENGTH, BoxRow::LENGTH + 1, ROW] {
            assert!(Members(Set::first(count)).eq(0..count), "{count}");
        }
    }
}
