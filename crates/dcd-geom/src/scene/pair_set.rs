//! A set of pairs of objects.

/// A set of pairs of objects, as a sorted list for each object: most lists are empty, which one look finds.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct PairSet {
    /// For each object that has any, and for those before it, the others, ascending.
    partners: Vec<Vec<u32>>,
    count: usize,
}

impl PairSet {
    pub(super) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// One more than the largest object that has ever had a pair.
    pub(super) fn objects(&self) -> usize {
        self.partners.len()
    }

    /// The others that object `i` has pairs with, ascending.
    #[inline]
    pub(super) fn partners(&self, i: u32) -> &[u32] {
        self.partners.get(i as usize).map_or(&[][..], Vec::as_slice)
    }

    #[inline]
    pub(super) fn contains(&self, i: u32, j: u32) -> bool {
        let partners = self.partners(i);
        !partners.is_empty() && partners.binary_search(&j).is_ok()
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
