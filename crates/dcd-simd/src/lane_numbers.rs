//! Numbers that some lanes have, one after the other.

use crate::{Lanes, WIDTH};
use std::ops::Deref;

/// Numbers of what lanes found, in order, to which those of sixteen lanes are added without a branch. `N` is how many there is
/// memory for, of which a list holds all but thirty-two.
#[derive(Clone, Debug)]
pub struct LaneNumbers<const N: usize> {
    numbers: [u32; N],
    count: usize,
}

impl<const N: usize> Default for LaneNumbers<N> {
    #[inline(always)]
    fn default() -> Self {
        const { assert!(N >= 2 * WIDTH, "what is written to is there") };
        Self { numbers: [0; N], count: 0 }
    }
}

impl<const N: usize> LaneNumbers<N> {
    /// Adds the numbers of the lanes whose bits `keep` has, counted from `first`; nothing where there
    /// [is no room](LaneNumbers::has_room). For kernels.
    #[inline(always)]
    pub fn push<L: Lanes>(&mut self, l: L, keep: u32, first: usize) {
        let numbers = l.add_u(l.lane_numbers(), l.splat_u(first as u32));
        if let Some(free) = self.numbers[self.count..].first_chunk_mut() {
            l.compress_to_u(keep, numbers, free, 0);
            self.count += (keep & 0xffff).count_ones() as usize;
        }
    }

    /// Whether there is room for the numbers of sixteen lanes.
    #[inline(always)]
    pub fn has_room(&self) -> bool {
        self.count + 2 * WIDTH <= N
    }

    /// Empties it.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.count = 0;
    }
}

impl<const N: usize> Deref for LaneNumbers<N> {
    type Target = [u32];

    #[inline(always)]
    fn deref(&self) -> &[u32] {
        &self.numbers[..self.count]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Kernel, Path, dispatch_on};

    /// Adds to a list until there is no room, and once more.
    struct Fill<'a>(&'a mut LaneNumbers<80>, &'a mut Vec<u32>);

    impl Kernel for Fill<'_> {
        type Output = ();

        #[inline(always)]
        fn run<L: Lanes>(self, l: L) {
            let Self(list, due) = self;
            let mut state = 7u32;
            while list.has_room() {
                // The generator of Numerical Recipes. Higher bits are ignored.
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let (keep, first) = (state >> 8, state >> 16 & 0xfff);
                list.push(l, keep, first as usize);
                due.extend((0..16).filter(|lane| keep >> lane & 1 == 1).map(|lane| first + lane));
            }
            list.push(l, 0xffff, 0);
        }
    }

    #[test]
    fn a_list_holds_the_numbers_of_the_lanes_that_are_kept_as_far_as_there_is_room() {
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            let (mut list, mut due) = (LaneNumbers::default(), Vec::new());
            for _ in 0..2 {
                dispatch_on(path, Fill(&mut list, &mut due));
                assert_eq!(*list, due, "{path:?}");
                assert!((49..=64).contains(&list.len()));
                list.clear();
                due.clear();
                assert!(list.is_empty());
            }
        }
    }
}
