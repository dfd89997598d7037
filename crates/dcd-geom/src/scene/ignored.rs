//! Ignored pairs, which are never reported.

use super::pair_set::PairSet;
use crate::Pair;

/// In place of a group's number.
const NO_GROUP: u32 = u32::MAX;

/// The ignored pairs of a scene. Objects that are all ignored with each other are a group, which takes a number an
/// object however large it is.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct IgnoredPairs {
    /// Those that are ignored by themselves, in whichever groups their objects are.
    pairs: PairSet,
    /// For each object its group; shorter than the scene where none has one.
    group_of: Vec<u32>,
    /// How many objects each group has.
    group_sizes: Vec<u32>,
    /// Pairs of one group that it does not ignore; each is forgotten when one of its objects leaves the group.
    exceptions: PairSet,
}

impl IgnoredPairs {
    pub(super) fn is_empty(&self) -> bool {
        self.pairs.is_empty() && self.group_of.is_empty()
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
            self.exceptions.forget(object);
        }
    }

    /// The object's group.
    #[inline]
    fn group_at(&self, object: u32) -> u32 {
        self.group_of.get(object as usize).copied().unwrap_or(NO_GROUP)
    }

    #[inline]
    fn are_of_one_group(&self, i: u32, j: u32) -> bool {
        let group = self.group_at(i);
        group != NO_GROUP && group == self.group_at(j)
    }

    #[inline]
    pub(super) fn contains(&self, i: u32, j: u32) -> bool {
        (self.are_of_one_group(i, j) && !self.exceptions.contains(i, j))
            || self.pairs.contains(i, j)
    }

    /// All of them, once each, ascending.
    pub(super) fn iter(&self) -> impl Iterator<Item = Pair> {
        let mut members: Vec<Vec<u32>> = vec![Vec::new(); self.group_sizes.len()];
        for (object, &group) in (0..).zip(&self.group_of) {
            if let Some(members) = members.get_mut(group as usize) {
                members.push(object);
            }
        }
        let objects = self.pairs.objects().max(self.group_of.len()) as u32;
        (0..objects).flat_map(move |i| {
            let later = |all: &[u32]| all[all.partition_point(|&j| j <= i)..].to_vec();
            let mut others = later(self.pairs.partners(i));
            if let Some(members) = members.get(self.group_at(i) as usize) {
                let members = later(members).into_iter();
                others.extend(members.filter(|&j| !self.exceptions.contains(i, j)));
                others.sort_unstable();
                others.dedup();
            }
            others.into_iter().map(move |j| Pair { i, j })
        })
    }

    /// Adds the pair of two different objects.
    pub(super) fn insert(&mut self, i: u32, j: u32) {
        self.pairs.insert(i, j);
    }

    /// Takes a pair out, and out of the group that both are in, if there is one.
    pub(super) fn remove(&mut self, i: u32, j: u32) {
        self.pairs.remove(i, j);
        if self.are_of_one_group(i, j) {
            self.exceptions.insert(i, j);
        }
    }

    /// Removes every pair of object `i`.
    pub(super) fn forget(&mut self, i: u32) {
        self.leave(i);
        self.pairs.forget(i);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

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
        // 2 leaves the group of 4; their pair stays, for it is ignored by itself too.
        ignored.insert(2, 4);
        ignored.group(&[0, 1, 2]);
        ignored.forget(1);
        assert_eq!(pairs(&ignored), [(0, 2), (2, 3), (2, 4)]);
        let all: Vec<u32> = (0..100_000).collect();
        ignored.group(&all);
        assert!(ignored.contains(5, 99_999) && ignored.pairs.objects() < 10);
    }

    /// The naive version: a set of the pairs that are ignored by themselves, then one of all pairs for each group.
    struct Listed(Vec<BTreeSet<(u32, u32)>>);

    impl Listed {
        fn keep(&mut self, skip: usize, stays: impl Fn(u32, u32) -> bool) {
            self.0.iter_mut().skip(skip).for_each(|set| set.retain(|&(i, j)| stays(i, j)));
        }

        fn group(&mut self, objects: &[u32]) {
            self.keep(1, |i, j| !objects.contains(&i) && !objects.contains(&j));
            let pairs = objects.iter().flat_map(|&i| objects.iter().map(move |&j| (i, j)));
            self.0.push(pairs.filter(|(i, j)| i < j).collect());
        }
    }

    #[test]
    fn random_calls_ignore_the_pairs_that_lists_of_them_have() {
        const OBJECTS: u32 = 7;
        for seed in 0..200u64 {
            let mut state = seed;
            let mut below = |count: u32| {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                (state >> 33) as u32 % count
            };
            let (mut ignored, mut listed) =
                (IgnoredPairs::default(), Listed(vec![BTreeSet::new()]));
            for _ in 0..60 {
                let (i, j) = (below(OBJECTS), below(OBJECTS));
                match below(6) {
                    0 => {
                        let objects: Vec<u32> = (0..2 + below(3)).map(|_| below(OBJECTS)).collect();
                        ignored.group(&objects);
                        listed.group(&objects);
                    }
                    1 => {
                        ignored.forget(i);
                        listed.keep(0, |a, b| a != i && b != i);
                    }
                    2 if i != j => {
                        ignored.insert(i, j);
                        listed.0[0].insert((i.min(j), i.max(j)));
                    }
                    _ if i != j => {
                        ignored.remove(i, j);
                        listed.keep(0, |a, b| (a, b) != (i.min(j), i.max(j)));
                    }
                    _ => {}
                }
                let due: BTreeSet<(u32, u32)> = listed.0.iter().flatten().copied().collect();
                assert!(ignored.iter().map(<(u32, u32)>::from).eq(due.iter().copied()), "{seed}");
                let known = |(i, j)| ignored.contains(i, j) && ignored.contains(j, i);
                assert!(
                    (0..OBJECTS).all(|i| (0..i).all(|j| known((j, i)) == due.contains(&(j, i))))
                );
            }
        }
    }
}
