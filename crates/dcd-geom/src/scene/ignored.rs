//! Pairs that are never told.

use crate::Pair;

/// A set of pairs of objects, as a sorted list for each object: most have none, and are told so by
/// one look.
#[derive(Clone, Debug, Default)]
pub(super) struct IgnoredPairs {
    /// For each object that has any, and for those before it, the others, ascending.
    partners: Vec<Vec<u32>>,
    count: usize,
}

impl IgnoredPairs {
    pub(super) fn is_empty(&self) -> bool {
        self.count == 0
    }

    #[inline]
    pub(super) fn contains(&self, i: u32, j: u32) -> bool {
        let partners = self.partners.get(i as usize).map_or(&[][..], Vec::as_slice);
        !partners.is_empty() && partners.binary_search(&j).is_ok()
    }

    /// All of them, once each, ascending.
    pub(super) fn iter(&self) -> impl Iterator<Item = Pair> {
        (0..).zip(&self.partners).flat_map(|(i, partners)| {
            let later = partners.partition_point(|&j| j < i);
            partners[later..].iter().map(move |&j| Pair { i, j })
        })
    }

    /// Adds the pair of two different objects.
    pub(super) fn insert(&mut self, i: u32, j: u32) {
        let objects = i.max(j) as usize + 1;
        if self.partners.len() < objects {
            self.partners.resize_with(objects, Vec::new);
        }
        for (own, other) in [(i, j), (j, i)] {
            let partners = &mut self.partners[own as usize];
            if let Err(place) = partners.binary_search(&other) {
                partners.insert(place, other);
                self.count += usize::from(own < other);
            }
        }
    }

    pub(super) fn remove(&mut self, i: u32, j: u32) {
        for (own, other) in [(i, j), (j, i)] {
            let Some(partners) = self.partners.get_mut(own as usize) else { continue };
            if let Ok(place) = partners.binary_search(&other) {
                partners.remove(place);
                self.count -= usize::from(own < other);
            }
        }
    }

    /// Removes every pair of object `i`.
    pub(super) fn forget(&mut self, i: u32) {
        let partners = self.partners.get_mut(i as usize).map(std::mem::take).unwrap_or_default();
        self.count -= partners.len();
        for other in partners {
            let others = &mut self.partners[other as usize];
            if let Ok(place) = others.binary_search(&i) {
                others.remove(place);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pair_is_known_in_both_orders_until_it_is_taken_back() {
        let mut ignored = IgnoredPairs::default();
        assert!(!ignored.contains(3, 1) && ignored.is_empty());
        ignored.insert(3, 1);
        ignored.insert(1, 3);
        ignored.insert(1, 7);
        assert!(ignored.contains(3, 1) && ignored.contains(1, 3) && ignored.contains(7, 1));
        assert!(!ignored.contains(3, 7) && !ignored.contains(1, 100));
        ignored.remove(1, 3);
        ignored.remove(1, 100);
        assert!(!ignored.contains(3, 1) && ignored.contains(1, 7) && !ignored.is_empty());
        ignored.remove(7, 1);
        assert!(ignored.is_empty());
    }

    #[test]
    fn an_object_forgotten_takes_all_its_pairs_along() {
        let mut ignored = IgnoredPairs::default();
        for other in [0, 2, 5] {
            ignored.insert(1, other);
        }
        ignored.insert(0, 2);
        ignored.forget(1);
        ignored.forget(9);
        assert!([0, 2, 5].iter().all(|&k| !ignored.contains(1, k) && !ignored.contains(k, 1)));
        assert!(ignored.contains(0, 2));
        ignored.forget(2);
        assert!(ignored.is_empty());
    }
}
