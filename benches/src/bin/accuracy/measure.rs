//! The precisions interleaved on a subject's pairs: times, and what is wrong.

use std::time::Duration;

use dcd_benches::{Options, timing};
use dcd_gjk::epa::Scratch;
use serde::{Deserialize, Serialize};

use crate::precision::{Precision, Query, Ready, Said};
use crate::subject::{Known, Subject};
use crate::tally::{Errors, Group, Tally};

/// What was seen of all precisions on a subject and a query.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Measured {
    pub(crate) subject: String,
    pub(crate) query: Query,
    /// How many pairs were queried.
    pub(crate) pairs: usize,
    /// Those beyond the range of f32 AABBs, which no scene takes.
    pub(crate) beyond: usize,
    /// Pairs on which some precision differs from the truth as known: the exact judge decided those.
    pub(crate) doubted: usize,
    /// Of them, those on which the judge sides against the truth as known.
    pub(crate) overruled: usize,
    pub(crate) precisions: Vec<OfPrecision>,
}

/// What was seen of a precision.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct OfPrecision {
    pub(crate) precision: Precision,
    /// A pair, the least of the rounds.
    pub(crate) ns: f64,
    pub(crate) wrong_yes: usize,
    pub(crate) wrong_no: usize,
    pub(crate) undecided: usize,
    /// Of the numbers, where it gave any.
    pub(crate) errors: Option<Errors>,
    /// By category and by decade, on the suite.
    pub(crate) groups: Vec<Group>,
}

impl OfPrecision {
    pub(crate) fn wrong(&self) -> usize {
        self.wrong_yes + self.wrong_no
    }
}

impl Measured {
    /// What a precision promised and did not keep, a sentence each.
    pub(crate) fn broken_promises(&self) -> Vec<String> {
        let mut broken = Vec::new();
        for of in &self.precisions {
            let wrong = match of.precision {
                precision if precision.is_certified() => of.wrong(),
                precision if precision.is_conservative() => of.wrong_no,
                _ => 0,
            };
            // Pairs beyond the range of f32 AABBs have no place in a scene.
            let open = of.precision == Precision::Certified && of.undecided > 0;
            if wrong > 0 || open {
                let (name, query) = (of.precision.name(), self.query.name());
                let (subject, open) = (&self.subject, of.undecided);
                broken.push(format!("{subject}, {query}: {name} has {wrong} wrong, {open} open"));
            }
        }
        if self.overruled > 0 {
            broken
                .push(format!("{}: the judge overrules {} answers", self.subject, self.overruled));
        }
        broken
    }
}

/// The precisions take turns on so many pairs, less than a scheduler's slice. The least time of the rounds
/// counts, slice by slice, so that whatever else the machine does falls out of the sum.
const CHUNK: usize = 512;
/// Rounds of a full run and of a quick one.
const ROUNDS: [usize; 2] = [5, 3];
/// The most pairs of a scene queried for distance and depth, in a full run and in a quick one.
const NUMBERS: [usize; 2] = [100_000, 5_000];
/// No more doubts of a query are handed to the judge: some milliseconds each on large hulls.
const MAX_DOUBTS: usize = 2_000;

/// Runs every precision that supports the query, interleaved.
pub(crate) fn measure(subject: &Subject, query: Query, options: &Options) -> Measured {
    let quick = usize::from(options.quick);
    let pairs = selected(subject, query, NUMBERS[quick]);
    let precisions = Precision::answering(query);
    let turn = |&precision: &Precision| Turn::new((precision, query), subject);
    let mut turns: Vec<Turn<'_>> = precisions.iter().map(turn).collect();
    take_turns(&mut turns, query, &pairs, options);

    let mut scratch = Scratch::default();
    let values: Vec<f64> = match query {
        Query::YesNo => Vec::new(),
        _ => pairs.iter().map(|&k| subject.value(k, &mut scratch)).collect(),
    };
    let (doubted, overruled) = judge_doubts(subject, &pairs, &turns);
    let of_precision = |turn: &Turn<'_>| {
        let mut tally = Tally::new(subject);
        for (index, (&pair, &said)) in pairs.iter().zip(&turn.said).enumerate() {
            tally.book(pair, said, values.get(index).copied());
        }
        tally.into_precision(turn.precision, turn.nanoseconds(&pairs))
    };
    Measured {
        subject: subject.name.clone(),
        query,
        pairs: pairs.len(),
        beyond: pairs.iter().filter(|&&k| subject.in_scene[k as usize].is_none()).count(),
        doubted,
        overruled,
        precisions: turns.iter().map(of_precision).collect(),
    }
}

/// All pairs for yes or no, those apart for a distance, those that touch for a depth; spread evenly
/// over the subject where there are more than `most`.
fn selected(subject: &Subject, query: Query, most: usize) -> Vec<u32> {
    let all = 0..subject.pairs.len() as u32;
    let fit: Vec<u32> = match query {
        Query::YesNo => return all.collect(),
        Query::Distance => all.filter(|&k| !subject.touches(k)).collect(),
        Query::Depth | Query::Manifold => all.filter(|&k| subject.touches(k)).collect(),
    };
    let step = fit.len().div_ceil(most).max(1);
    fit.into_iter().step_by(step).collect()
}

/// A precision on its turns.
pub(crate) struct Turn<'s> {
    precision: Precision,
    subject: &'s Subject,
    ready: Ready<'s>,
    least: Duration,
    /// What it said, in the order of the pairs.
    pub(crate) said: Vec<Said>,
}

impl<'s> Turn<'s> {
    pub(crate) fn new((precision, query): (Precision, Query), subject: &'s Subject) -> Self {
        let ready = Ready::new((precision, query), subject);
        Self { precision, subject, ready, least: Duration::ZERO, said: Vec::new() }
    }

    /// What a pair took.
    pub(crate) fn nanoseconds(&self, pairs: &[u32]) -> f64 {
        let in_scene = |&&k: &&u32| self.subject.in_scene[k as usize].is_some();
        let count = if self.precision.is_in_packets() {
            pairs.iter().filter(in_scene).count()
        } else {
            pairs.len()
        };
        self.least.as_secs_f64() * 1e9 / count.max(1) as f64
    }
}

/// Runs all on the same pairs, interleaved slice by slice.
pub(crate) fn take_turns(turns: &mut [Turn<'_>], query: Query, pairs: &[u32], options: &Options) {
    let rounds = ROUNDS[usize::from(options.quick)];
    let mut answers = Vec::with_capacity(CHUNK);
    for pairs in pairs.chunks(CHUNK) {
        let mut times = vec![Duration::MAX; turns.len()];
        // The first round warms up and does not count.
        for round in 0..=rounds {
            for (turn, least) in turns.iter_mut().zip(&mut times) {
                let Turn { precision, subject, ready, said, .. } = turn;
                let run = || ready.run((*precision, query), subject, pairs, &mut answers);
                let (time, ()) = timing::time(run);
                if round == 0 {
                    said.extend_from_slice(&answers);
                } else {
                    *least = time.min(*least);
                }
            }
        }
        for (turn, time) in turns.iter_mut().zip(times) {
            turn.least += time;
        }
    }
}

/// The pairs on which a precision that means to be right differs from the truth of a scene, and on how
/// many of them the exact judge differs from it too. The truth of a suite is exact as it is.
fn judge_doubts(subject: &Subject, pairs: &[u32], turns: &[Turn<'_>]) -> (usize, usize) {
    if matches!(subject.truth, Known::Exactly(..)) {
        return (0, 0);
    }
    let mut doubts = Vec::new();
    for (index, &k) in pairs.iter().enumerate() {
        let touches = subject.touches(k);
        // AABBs and spheres, the first two, say "touching" of most that are near.
        let differs = |turn: &Turn<'_>| match turn.said[index] {
            Said::Apart => touches,
            Said::Touching => !touches,
            Said::Measured(_) | Said::Open => false,
        };
        if turns.iter().skip(2).any(differs) {
            doubts.push(k);
        }
    }
    let judged = doubts.iter().take(MAX_DOUBTS);
    let overruled = judged.filter(|&&k| subject.judged(k).is_some_and(|t| t != subject.touches(k)));
    (doubts.len(), overruled.count())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::subject::Recipe;
    use dcd_scenes::SceneSpec;
    use dcd_scenes::conformance::{Category, suite};

    fn quick() -> Options {
        Options { quick: true, ..Options::default() }
    }

    fn of(measured: &Measured, precision: Precision) -> &OfPrecision {
        measured.precisions.iter().find(|of| of.precision == precision).unwrap()
    }

    #[test]
    fn every_method_that_has_an_answer_is_timed_on_a_scene_and_none_breaks_its_promise() {
        let spec = SceneSpec::paper().with_objects(60);
        let subject = Recipe::Scene { spec, seed: 3 }.subject().unwrap();
        for query in Query::ALL {
            let measured = measure(&subject, query, &quick());
            assert!(measured.pairs > 10 && measured.overruled == 0);
            assert_eq!(measured.broken_promises(), Vec::<String>::new());
            assert_eq!(measured.precisions.len(), Precision::answering(query).len());
            assert!(measured.precisions.iter().all(|of| of.ns > 0.0));
        }
    }

    #[test]
    fn what_a_plain_method_cannot_decide_is_counted_by_category() {
        let cases = suite(5, &|_| false);
        let aligned = |case: &dcd_scenes::conformance::Case| case.category == Category::Aligned;
        let cases: Vec<_> = cases.into_iter().filter(aligned).collect();
        let subject = Subject::of_cases("aligned", &cases).unwrap();
        let measured = measure(&subject, Query::YesNo, &quick());
        assert_eq!(measured.broken_promises(), Vec::<String>::new());
        let f32 = of(&measured, Precision::F32);
        assert!(f32.undecided > 0 && f32.wrong_yes + f32.wrong_no == 0);
        let group = f32.groups.iter().find(|group| group.name == "aligned").unwrap();
        assert_eq!((group.pairs, group.undecided), (cases.len(), f32.undecided));
        assert_eq!(of(&measured, Precision::Certified).undecided, 0);
    }

    #[test]
    fn a_wrong_answer_of_a_certified_method_is_a_broken_promise() {
        let spec = SceneSpec::paper().with_objects(20);
        let subject = Recipe::Scene { spec, seed: 1 }.subject().unwrap();
        let mut measured = measure(&subject, Query::YesNo, &quick());
        for of in &mut measured.precisions {
            of.wrong_no += 1;
        }
        // Two conservative precisions and two certified ones.
        assert_eq!(measured.broken_promises().len(), 4);
    }
}
