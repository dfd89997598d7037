//! Whose contact set is right, pair by pair.
//!
//! Pairs that all agree on are taken as they are. Every other is decided by exact integers, never
//! by a majority; so is every pair with an object that Parry has no shape for.

use anyhow::{Context, Result};
use dcd_benches::agreement;
use dcd_geom::{Pair, Scene};
use dcd_gjk::Report;
use dcd_parry::ParryStep;
use dcd_pipeline::Step;
use serde::{Deserialize, Serialize};

/// What a rival said of a scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct Answers {
    candidates: usize,
    /// Sorted, each once.
    contacts: Vec<Pair>,
    /// How many contacts were listed once more.
    repeated: usize,
    /// Sorted.
    undecided: Vec<Pair>,
    /// Objects that the rival has no shape for. Sorted.
    refused: Vec<u32>,
}

/// What was said by each.
#[derive(Clone, Debug, Default)]
pub(crate) struct Said {
    pub(crate) ours: Answers,
    pub(crate) parry_f32: Answers,
    pub(crate) parry_f64: Answers,
}

/// How a rival's answers compare with the proved truth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Account {
    /// Pairs whose boxes overlap, by the rival's own boxes.
    pub(crate) candidates: usize,
    /// Pairs that it says touch.
    pub(crate) contacts: usize,
    /// Those of them that do not.
    pub(crate) false_contacts: usize,
    /// Pairs that it lists again, counted each time but the first.
    pub(crate) repeated: usize,
    /// Touching pairs that it says are apart.
    pub(crate) missed: usize,
    /// Pairs that it leaves undecided.
    pub(crate) undecided: usize,
    /// Objects that it has no shape for; their pairs do not count for it.
    pub(crate) refused: usize,
}

/// A pair on which we and Parry in f64 differ, judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Difference {
    /// The first object.
    pub(crate) i: u32,
    /// The second object.
    pub(crate) j: u32,
    /// The truth.
    pub(crate) touching: bool,
    /// Who is wrong.
    pub(crate) wrong: Wrong,
}

/// Who is wrong on a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Wrong {
    /// We are.
    Ours,
    /// Parry in f64 is.
    ParryF64,
}

/// The proved truth of a scene and what each said of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Judged {
    /// Pairs that truly touch.
    pub(crate) contacts: usize,
    /// Pairs that exact arithmetic decided.
    pub(crate) judged_exactly: usize,
    /// Ours.
    pub(crate) ours: Account,
    /// Parry in f32, which is timed.
    pub(crate) parry_f32: Account,
    /// Parry in f64, our judge but for the differences.
    pub(crate) parry_f64: Account,
    /// The first pairs on which we and Parry in f64 differ.
    pub(crate) differences: Vec<Difference>,
}

/// More differences than this are counted but not listed.
const LISTED: usize = 20;

impl Answers {
    /// Ours.
    pub(crate) fn ours(step: &Step<'_, ()>) -> Self {
        let contacts = step.contacts().map(|(i, j)| Pair { i, j }).collect();
        Self::new(step.candidate_count(), contacts, step.report(), &[])
    }

    /// Parry's.
    pub(crate) fn parry(step: &ParryStep<'_>) -> Self {
        let (candidates, contacts) = (step.candidates().len(), step.contacts().collect());
        Self::new(candidates, contacts, step.report(), step.refused())
    }

    fn new(candidates: usize, mut contacts: Vec<Pair>, report: &Report, refused: &[u32]) -> Self {
        let listed = contacts.len();
        contacts.sort_unstable();
        contacts.dedup();
        let repeated = listed - contacts.len();
        let mut undecided: Vec<Pair> = report.undecided().iter().map(|open| open.pair).collect();
        undecided.sort_unstable();
        Self { candidates, contacts, repeated, undecided, refused: refused.to_vec() }
    }

    fn says(&self, pair: Pair) -> Option<bool> {
        let refused = |object: u32| self.refused.binary_search(&object).is_ok();
        if self.contacts.binary_search(&pair).is_ok() {
            Some(true)
        } else if self.undecided.binary_search(&pair).is_ok() || refused(pair.i) || refused(pair.j)
        {
            None
        } else {
            Some(false)
        }
    }

    fn account(&self) -> Account {
        Account {
            candidates: self.candidates,
            contacts: self.contacts.len(),
            repeated: self.repeated,
            undecided: self.undecided.len(),
            refused: self.refused.len(),
            ..Account::default()
        }
    }
}

impl Account {
    /// Pairs of which it said what is not so, or said it again.
    pub(crate) fn wrong(&self) -> usize {
        self.false_contacts + self.missed + self.repeated
    }

    fn book(&mut self, said: Option<bool>, touching: bool) {
        match said {
            Some(true) if !touching => self.false_contacts += 1,
            Some(false) if touching => self.missed += 1,
            _ => {}
        }
    }
}

/// Judges every pair on which the three differ, and those that Parry in f64 has no say on.
pub(crate) fn judge(scene: &Scene, said: &Said) -> Result<Judged> {
    let Said { ours, parry_f32, parry_f64 } = said;
    let mut disputed = pairs_without_judge(scene, &parry_f64.refused);
    disputed.extend(&parry_f64.undecided);
    let unanimous = sort_out([ours, parry_f32, parry_f64], &mut disputed);
    let mut judged = Judged {
        contacts: unanimous,
        judged_exactly: disputed.len(),
        ours: ours.account(),
        parry_f32: parry_f32.account(),
        parry_f64: parry_f64.account(),
        differences: Vec::new(),
    };
    for pair in disputed {
        let touching = agreement::touches(scene, pair);
        let touching = touching.with_context(|| format!("{pair:?} has no exact judge"))?;
        judged.contacts += usize::from(touching);
        judged.ours.book(ours.says(pair), touching);
        judged.parry_f32.book(parry_f32.says(pair), touching);
        judged.parry_f64.book(parry_f64.says(pair), touching);
        let wrong = match (ours.says(pair), parry_f64.says(pair)) {
            (Some(ours), Some(theirs)) if ours != theirs => {
                if ours == touching {
                    Wrong::ParryF64
                } else {
                    Wrong::Ours
                }
            }
            (Some(ours), None) if ours != touching => Wrong::Ours,
            _ => continue,
        };
        if judged.differences.len() < LISTED {
            let Pair { i, j } = pair;
            judged.differences.push(Difference { i, j, touching, wrong });
        }
    }
    Ok(judged)
}

/// Adds the pairs that some list as touching and others do not to `disputed`, which is then sorted
/// without repetition, and counts the pairs that all list and nobody doubts.
fn sort_out(said: [&Answers; 3], disputed: &mut Vec<Pair>) -> usize {
    disputed.sort_unstable();
    disputed.dedup();
    let mut listed: Vec<Pair> = Vec::new();
    said.iter().for_each(|answers| listed.extend(&answers.contacts));
    listed.sort_unstable();
    let doubted = disputed.len();
    let mut unanimous = 0;
    for same in listed.chunk_by(|a, b| a == b) {
        if disputed[..doubted].binary_search(&same[0]).is_ok() {
            continue;
        }
        if same.len() == said.len() {
            unanimous += 1;
        } else {
            disputed.push(same[0]);
        }
    }
    disputed.sort_unstable();
    unanimous
}

/// Every pair of overlapping AABBs with one of these objects.
fn pairs_without_judge(scene: &Scene, refused: &[u32]) -> Vec<Pair> {
    if refused.is_empty() {
        return Vec::new();
    }
    let aabbs: Vec<_> = (0..scene.len()).map(|i| scene.aabb(i)).collect();
    let mut pairs = Vec::new();
    for &object in refused {
        for (other, aabb) in (0u32..).zip(&aabbs) {
            if other != object && aabb.overlaps(&aabbs[object as usize]) {
                pairs.push(Pair::new(object, other));
            }
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::glam::DVec3;
    use dcd_geom::{Pose, Shape};

    /// Unit cubes in a row: 0 and 1 share a face, 2 is apart by a gap, 3 overlaps 2.
    fn row() -> Scene {
        let cube = || Shape::cuboid(DVec3::splat(0.5)).unwrap();
        let at = |x: f64| Pose::from_translation(DVec3::new(x, 0.0, 0.0)).unwrap();
        let poses = [0.0, 1.0, 2.0 + 1e-15, 2.5].map(at).to_vec();
        Scene::one_each((0..4).map(|_| cube()).collect(), poses).unwrap()
    }

    const TRUTH: [Pair; 2] = [Pair { i: 0, j: 1 }, Pair { i: 2, j: 3 }];
    const APART: Pair = Pair { i: 1, j: 2 };

    fn answers(contacts: &[Pair]) -> Answers {
        Answers { contacts: contacts.to_vec(), ..Answers::default() }
    }

    #[test]
    fn what_all_agree_on_needs_no_exact_arithmetic() {
        let all = || answers(&TRUTH);
        let said = Said { ours: all(), parry_f32: all(), parry_f64: all() };
        let judged = judge(&row(), &said).unwrap();
        assert_eq!((judged.contacts, judged.judged_exactly), (2, 0));
        assert_eq!(judged.ours.wrong() + judged.parry_f32.wrong() + judged.parry_f64.wrong(), 0);
    }

    #[test]
    fn a_majority_does_not_decide_a_pair() {
        let wrong = || answers(&[TRUTH[0], APART, TRUTH[1]]);
        let said = Said { ours: answers(&TRUTH), parry_f32: wrong(), parry_f64: wrong() };
        let judged = judge(&row(), &said).unwrap();
        assert_eq!((judged.contacts, judged.judged_exactly), (2, 1));
        assert_eq!((judged.ours.wrong(), judged.parry_f32.false_contacts), (0, 1));
        let Pair { i, j } = APART;
        let expected = Difference { i, j, touching: false, wrong: Wrong::ParryF64 };
        assert_eq!(judged.differences, [expected]);
    }

    #[test]
    fn a_contact_that_we_miss_or_make_up_is_ours() {
        for (contacts, account) in [
            (&[TRUTH[1]][..], Account { contacts: 1, missed: 1, ..Account::default() }),
            (
                &[TRUTH[0], APART, TRUTH[1]][..],
                Account { contacts: 3, false_contacts: 1, ..Account::default() },
            ),
        ] {
            let theirs = || answers(&TRUTH);
            let said = Said { ours: answers(contacts), parry_f32: theirs(), parry_f64: theirs() };
            let judged = judge(&row(), &said).unwrap();
            assert_eq!(judged.ours, account);
            assert_eq!(judged.differences[0].wrong, Wrong::Ours);
        }
    }

    #[test]
    fn a_contact_that_is_listed_twice_is_wrong() {
        let twice = [TRUTH[1], TRUTH[0], TRUTH[1]].to_vec();
        let ours = Answers::new(2, twice, &Report::default(), &[]);
        let said = Said { ours, parry_f32: answers(&TRUTH), parry_f64: answers(&TRUTH) };
        let judged = judge(&row(), &said).unwrap();
        assert_eq!((judged.contacts, judged.judged_exactly, judged.ours.wrong()), (2, 0, 1));
    }

    #[test]
    fn what_is_left_undecided_is_not_wrong() {
        let ours = Answers { undecided: vec![TRUTH[0]], ..answers(&[TRUTH[1]]) };
        let said = Said { ours, parry_f32: answers(&TRUTH), parry_f64: answers(&TRUTH) };
        let judged = judge(&row(), &said).unwrap();
        assert_eq!((judged.ours.wrong(), judged.ours.undecided, judged.contacts), (0, 1, 2));
        assert!(judged.differences.is_empty());
    }

    #[test]
    fn what_parry_leaves_undecided_is_judged_exactly() {
        let none = || Answers { undecided: vec![TRUTH[0]], ..answers(&TRUTH[1..]) };
        let said = Said { ours: answers(&TRUTH[1..]), parry_f32: none(), parry_f64: none() };
        let judged = judge(&row(), &said).unwrap();
        assert_eq!((judged.contacts, judged.ours.missed, judged.parry_f64.wrong()), (2, 1, 0));
    }

    #[test]
    fn pairs_of_what_parry_refuses_are_judged_exactly_even_where_nobody_lists_them() {
        let theirs = || Answers { refused: vec![0], ..answers(&TRUTH[1..]) };
        let said = |ours| Said { ours, parry_f32: theirs(), parry_f64: theirs() };
        let right = judge(&row(), &said(answers(&TRUTH))).unwrap();
        assert_eq!((right.contacts, right.ours.wrong(), right.parry_f64.missed), (2, 0, 0));
        let missed = judge(&row(), &said(answers(&TRUTH[1..]))).unwrap();
        assert_eq!((missed.contacts, missed.ours.missed), (2, 1));
        assert_eq!(missed.differences[0].wrong, Wrong::Ours);
    }
}
