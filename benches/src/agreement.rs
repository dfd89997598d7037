//! Contact sets compared as sets; the exact method judges each pair on which two differ.

use dcd_geom::{Pair, Scene};
use dcd_gjk::{PosedSupport, Undecided, certified};
use serde::{Deserialize, Serialize};

/// How many of the pairs that differ are kept as examples.
const MAX_EXAMPLES: usize = 8;

/// How one contact set stands to another, and who is right where they differ.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Agreement {
    /// Pairs found, counted as often as they were listed.
    pub found: u64,
    /// Pairs of the set that it is compared with.
    pub expected: u64,
    /// Pairs found that do not touch, exactly.
    pub false_contacts: u64,
    /// Pairs not found, nor left undecided, that touch, exactly.
    pub missed: u64,
    /// Pairs on which the exact method sides with what was found: the other set is wrong there.
    pub expected_wrong: u64,
    /// Pairs listed more than once, counted each time but the first.
    pub repeated: u64,
    /// Pairs left undecided: neither right nor wrong.
    pub undecided: u64,
    /// Pairs with a foreign shape, which no exact method can judge.
    pub unjudged: u64,
    /// Some of the pairs that differ.
    pub examples: Vec<(u32, u32)>,
}

impl Agreement {
    /// Of the contacts found in the scene, in any order, with those expected, in ascending order.
    #[must_use]
    pub fn of(
        scene: &Scene,
        mut found: Vec<Pair>,
        undecided: &[Undecided],
        expected: &[Pair],
    ) -> Self {
        let mut agreement = Self {
            found: found.len() as u64,
            undecided: undecided.len() as u64,
            ..Self::default()
        };
        agreement.expected = expected.len() as u64;
        found.sort_unstable();
        found.dedup();
        agreement.repeated = agreement.found - found.len() as u64;
        let mut open: Vec<Pair> = undecided.iter().map(|undecided| undecided.pair).collect();
        open.sort_unstable();

        let mut rest = expected;
        for pair in found {
            let before = rest.partition_point(|&other| other < pair);
            rest[..before].iter().for_each(|&other| agreement.judge_lost(scene, other, &open));
            rest = &rest[before..];
            if rest.first() == Some(&pair) {
                rest = &rest[1..];
            } else {
                agreement.judge_surplus(scene, pair);
            }
        }
        rest.iter().for_each(|&other| agreement.judge_lost(scene, other, &open));
        agreement
    }

    /// Whether both are one set, with nothing repeated or left open.
    #[must_use]
    pub fn is_equal(&self) -> bool {
        self.found == self.expected && self.differences() == 0 && self.undecided == 0
    }

    /// Pairs in one of the two sets alone, and repetitions.
    #[must_use]
    pub fn differences(&self) -> u64 {
        self.false_contacts + self.missed + self.expected_wrong + self.repeated + self.unjudged
    }

    /// A pair that is expected and was not found.
    fn judge_lost(&mut self, scene: &Scene, pair: Pair, open: &[Pair]) {
        if open.binary_search(&pair).is_ok() {
            return;
        }
        match touches(scene, pair) {
            Some(true) => self.missed += 1,
            Some(false) => self.expected_wrong += 1,
            None => self.unjudged += 1,
        }
        self.note(pair);
    }

    /// A pair that was found and is not expected.
    fn judge_surplus(&mut self, scene: &Scene, pair: Pair) {
        match touches(scene, pair) {
            Some(true) => self.expected_wrong += 1,
            Some(false) => self.false_contacts += 1,
            None => self.unjudged += 1,
        }
        self.note(pair);
    }

    fn note(&mut self, pair: Pair) {
        if self.examples.len() < MAX_EXAMPLES {
            self.examples.push(pair.into());
        }
    }
}

/// The truth about two objects, in exact integers. `None` for a foreign shape.
#[must_use]
pub fn touches(scene: &Scene, pair: Pair) -> Option<bool> {
    let [a, b] = [pair.i as usize, pair.j as usize].map(|i| {
        scene.shape(i).as_polytope().map(|shape| PosedSupport::polytope(shape, &scene.poses()[i]))
    });
    Some(certified::overlap_exactly(a?, b?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::glam::DVec3;
    use dcd_geom::{Pose, Shape};
    use dcd_gjk::Reason;

    /// Unit cubes in a row: neighbours touch, others do not.
    fn row(count: u32) -> Scene {
        let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
        let pose = |i| Pose::from_translation(DVec3::new(f64::from(i), 0.0, 0.0)).unwrap();
        let shapes = vec![cube; count as usize];
        Scene::one_each(shapes, (0..count).map(pose).collect()).unwrap()
    }

    fn pairs<const K: usize>(pairs: [(u32, u32); K]) -> Vec<Pair> {
        pairs.map(|(i, j)| Pair { i, j }).to_vec()
    }

    #[test]
    fn the_same_set_in_another_order_is_equal() {
        let expected = pairs([(0, 1), (1, 2)]);
        let agreement = Agreement::of(&row(3), pairs([(1, 2), (0, 1)]), &[], &expected);
        assert!(agreement.is_equal() && agreement.found == 2);
    }

    #[test]
    fn each_difference_is_judged_exactly_whoever_is_wrong() {
        let scene = row(5);
        let expected = pairs([(0, 1), (0, 4), (2, 3)]);
        let found = pairs([(0, 2), (1, 2), (2, 3)]);
        let agreement = Agreement::of(&scene, found, &[], &expected);
        let known = Agreement {
            found: 3,
            expected: 3,
            false_contacts: 1, // (0, 2)
            missed: 1,         // (0, 1)
            expected_wrong: 2, // (0, 4) and (1, 2)
            examples: vec![(0, 1), (0, 4), (0, 2), (1, 2)],
            ..Agreement::default()
        };
        assert!(!agreement.is_equal());
        assert_eq!(Agreement { examples: known.examples.clone(), ..agreement }, known);
    }

    #[test]
    fn a_list_that_repeats_a_pair_is_no_set_of_the_same_length() {
        let expected = pairs([(0, 1), (1, 2)]);
        let agreement = Agreement::of(&row(3), pairs([(0, 1), (0, 1)]), &[], &expected);
        assert_eq!((agreement.repeated, agreement.missed), (1, 1));
        assert!(!agreement.is_equal());
    }

    #[test]
    fn an_undecided_pair_is_neither_missed_nor_equal() {
        let pair = Pair { i: 0, j: 1 };
        let open = [Undecided { pair, reason: Reason::Foreign }];
        let agreement = Agreement::of(&row(2), Vec::new(), &open, &[pair]);
        assert_eq!((agreement.missed, agreement.undecided), (0, 1));
        assert!(!agreement.is_equal());
    }
}
