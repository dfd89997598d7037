//! A short list in its place.

use std::fmt;
use std::mem::MaybeUninit;
use std::ops::{Deref, DerefMut};
use std::slice;

/// A list of at most `N` items in its own memory, of which nothing is written but the items that are there: an empty one
/// costs its length. A list of contacts is made of such, each of which has room for more than it mostly holds.
// In this order: the length is beside the first item.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct ArrayVec<T: Copy, const N: usize> {
    /// At most `N`.
    count: u8,
    /// Only the first `count` are initialized.
    items: MaybeUninit<[T; N]>,
}

impl<T: Copy, const N: usize> ArrayVec<T, N> {
    /// One without an item.
    #[inline(always)]
    pub const fn new() -> Self {
        const { assert!(N <= u8::MAX as usize, "its length is a byte") };
        Self { count: 0, items: MaybeUninit::uninit() }
    }

    /// Adds an item at the end; where there is room for no more, nothing.
    #[inline(always)]
    pub fn push(&mut self, item: T) {
        self.extend(std::iter::once(item));
    }

    /// Takes the last item away, if there is any.
    #[inline(always)]
    pub fn pop(&mut self) -> Option<T> {
        let last = self.last().copied()?;
        self.count -= 1;
        Some(last)
    }

    /// Adds items at the end, as many as there is room for: their number is kept in a register meanwhile.
    #[inline(always)]
    pub fn extend(&mut self, items: impl Iterator<Item = T>) {
        let mut count = usize::from(self.count);
        for item in items.take(N - count) {
            // SAFETY: `take` leaves no more than there are places from `count` on.
            unsafe { self.items.as_mut_ptr().cast::<T>().add(count).write(item) }
            count += 1;
        }
        self.count = count as u8;
    }
}

impl<T: Copy, const N: usize> Deref for ArrayVec<T, N> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        // SAFETY: the first `count` are initialized, and `count` is at most N.
        unsafe { slice::from_raw_parts(self.items.as_ptr().cast(), self.count.into()) }
    }
}

impl<T: Copy, const N: usize> DerefMut for ArrayVec<T, N> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        // SAFETY: the first `count` are initialized, and `count` is at most N.
        unsafe { slice::from_raw_parts_mut(self.items.as_mut_ptr().cast(), self.count.into()) }
    }
}

impl<T: Copy, const N: usize> Default for ArrayVec<T, N> {
    #[inline(always)]
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Copy + PartialEq, const N: usize> PartialEq for ArrayVec<T, N> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<T: Copy + fmt::Debug, const N: usize> fmt::Debug for ArrayVec<T, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(&**self).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_holds_what_was_pushed_and_no_more_than_it_has_room_for() {
        let mut list = ArrayVec::<u64, 3>::new();
        assert!(list.is_empty());
        for k in 0..5 {
            list.push(10 + k);
        }
        assert_eq!(*list, [10, 11, 12]);
        assert_eq!((list.pop(), &*list), (Some(12), &[10, 11][..]));
        list.push(12);
        list[1] = 7;
        list.count = 0;
        list.push(10);
        list.extend([7, 12, 13, 14].into_iter());
        let copy = list;
        list.count = 0;
        assert_eq!(list.pop(), None);
        assert_eq!((list.len(), &*copy), (0, &[10, 7, 12][..]));
    }

    #[test]
    fn lists_are_equal_by_what_they_hold_alone() {
        let (mut one, mut other) = (ArrayVec::<u64, 2>::new(), ArrayVec::new());
        one.push(1);
        one.push(2);
        one.count = 0;
        other.push(3);
        assert_ne!(one, other);
        one.push(3);
        assert_eq!(one, other);
        assert_eq!(format!("{one:?}"), "[3]");
    }
}
