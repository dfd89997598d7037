//! Ignored pairs, which are never reported.

use crate::Pair;

/// In place of a group's number.
const NO_GROUP: u32 = u32::MAX;

/// A set of pairs of objects, as a sorted list for each object: most lists are empty, which one look finds.
/// Objects that are all ignored with each other are a group, which takes a number an object however large
/// it is.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct IgnoredPairs {
    /// For each object its group; shorter than the scene where none has one.
    group_of: Vec<u32>,
    /// How many objects each group has.
    group_sizes: Vec<u32>,
    /// For each object that has any, and for those before it, the others, ascending.
    partners: Vec<Vec<u32>>,
    count: usize,
}

impl IgnoredPairs {
    pub(super) fn is_empty(&self) -> bool {
        self.count == 0 && self.group_of.is_empty()
    }

    /// Makes these objects a group. They leave the groups that they were in.
    pub(super) fn group(&mut self, objects: &[u32]) {
        // A scene has fewer objects than a u32 counts, and groups are not used again.
        let group = self.group_sizes.len() as u32;
        self.group_sizes.push(0);
        for &object in objects {
            self.leave(object);
            let end = object as usize + 1;
            if self.group_of.len() < end {
                self.group_of.resize(end, NO_GROUP);
            }
            self.group_of[object as usize] = group;
            self.group_sizes[group as usize] += 1;
        }
    }

    fn leave(&mut self, object: u32) {
        if let Some(group) = self.group_of.get_mut(object as usize)
            && let Some(size) = self.group_sizes.get_mut(*group as usize)
        {
            *size -= 1;
            *group = NO_GROUP;
        }
    }

    /// The object's group.
    #[inline]
    fn group_at(&self, object: u32) -> u32 {
        self.group_of.get(object as usize).copied().unwrap_or(NO_GROUP)
    }

    #[inline]
    pub(super) fn contains(&self, i: u32, j: u32) -> bool {
        let group = self.group_at(i);
        if group != NO_GROUP && group == self.group_at(j) {
            return true;
        }
        let partners = self.partners.get(i as usize).map_or(&[][..], Vec::as_slice);
        !partners.is_empty() && partners.binary_search(&j).is_ok()
    }

    /// All of them, once each, ascending.
    pub(super) fn iter(&self) -> impl Iterator<Item = Pair> {
        let mut members: Vec<Vec<u32>> = vec![Vec::new(); self.group_sizes.len()];
        for (object, &group) in (0..).zip(&self.group_of) {
            if let Some(members) = members.get_mut(group as usize) {
                members.push(object);
            }
        }
        let objects = self.partners.len().max(self.group_of.len()) as u32;
        (0..objects).flat_map(move |i| {
            let later = |all: &[u32]| all[all.partition_point(|&j| j <= i)..].to_vec();
            let mut others = later(self.partners.get(i as usize).map_or(&[][..], Vec::as_slice));
            if let Some(members) = members.get(self.group_at(i) as usize) {
                others.extend(later(members));
                others.sort_unstable();
                others.dedup();
            }
            others.into_iter().map(move |j| Pair { i, j })
        })
    }

    /// Makes the pairs of the group that both are in, if there is one, pairs by themselves.
    fn ungroup(&mut self, i: u32, j: u32) {
        let group = self.group_at(i);
        if group == NO_GROUP || group != self.group_at(j) {
            return;
        }
        let members: Vec<u32> =
            (0..).zip(&self.group_of).filter(|(_, of)| **of == group).map(|(k, _)| k).collect();
        members.iter().for_each(|&k| self.leave(k));
        for (at, &a) in members.iter().enumerate() {
            members[at + 1..].iter().for_each(|&b| self.insert(a, b));
        }
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
        self.ungroup(i, j);
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
        self.leave(i);
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

    #[test]
    fn a_group_is_all_of_its_pairs_and_takes_a_number_an_object() {
        let mut ignored = IgnoredPairs::default();
        ignored.insert(2, 3);
        ignored.group(&[1, 4, 2]);
        let pairs =
            |ignored: &IgnoredPairs| ignored.iter().map(<(u32, u32)>::from).collect::<Vec<_>>();
        assert_eq!(pairs(&ignored), [(1, 2), (1, 4), (2, 3), (2, 4)]);
        assert!(ignored.contains(4, 1) && !ignored.contains(1, 3) && !ignored.contains(0, 5));
        // One pair taken back, the others stay.
        ignored.remove(1, 4);
        assert_eq!(pairs(&ignored), [(1, 2), (2, 3), (2, 4)]);
        ignored.group(&[0, 1, 2]);
        ignored.forget(1);
        assert_eq!(pairs(&ignored), [(0, 2), (2, 3), (2, 4)]);
        let all: Vec<u32> = (0..100_000).collect();
        ignored.group(&all);
        assert!(ignored.contains(5, 99_999) && ignored.partners.len() < 10);
    }
}
