//! A scene judged, then the rivals interleaved.

use std::time::Duration;

use anyhow::{Result, anyhow, ensure};
use clap::ValueEnum;
use dcd_benches::{Digest, Effort, Pair, Sample, timing};
use dcd_broad::{BroadPhase, BruteForce, WideTree};
use dcd_gjk::{Method, Overlap};
use dcd_parry::{ParryPipeline, Query, Ready};
use dcd_pipeline::{Par, Pipeline};
use dcd_simd::Path;
use serde::{Deserialize, Serialize};

use crate::judge::{self, Answers, Judged, Said};
use crate::rivals::{EveryPair, Ours, PARTS, Turn, WHOLE};
use crate::subject::Subject;

/// How long the rivals take turns on a scene at a number of threads, if they need no longer for
/// [`FEWEST`] rounds.
const LASTING: Duration = Duration::from_secs(10);
/// Rounds of a full run, of a quick one, and at most.
const FEWEST: u32 = 5;
const QUICK: u32 = 3;
const MOST: u32 = 501;
/// What one turn takes at least: `timing` repeats what is shorter.
const SHORTEST_TURN: Duration = Duration::from_millis(1);
/// Up to this many objects brute force is a rival too.
const BRUTE: usize = 1_000;

/// Which query of Parry in f32 decides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum ParryQuery {
    /// `query::intersection_test`, as its users call it
    #[default]
    IntersectionTest,
    /// The function that it ends up in, called directly for two polyhedra
    Direct,
}

impl From<ParryQuery> for Query {
    fn from(query: ParryQuery) -> Self {
        match query {
            ParryQuery::IntersectionTest => Self::IntersectionTest,
            ParryQuery::Direct => Self::DirectIntersectionTest,
        }
    }
}

/// How every scene is run.
#[derive(Clone, Debug)]
pub(crate) struct Course {
    pub(crate) query: ParryQuery,
    pub(crate) threads: Vec<usize>,
    pub(crate) effort: Effort,
}

impl Course {
    /// The name of a scene run in this way.
    pub(crate) fn key(&self, subject: &Subject) -> String {
        let threads: Vec<String> = self.threads.iter().map(ToString::to_string).collect();
        let query = match self.query {
            ParryQuery::IntersectionTest => "",
            ParryQuery::Direct => "/direct",
        };
        format!("{}/threads={}{query}", subject.key(), threads.join(","))
    }

    /// Rounds where a round takes that long.
    fn rounds(&self, round: Duration) -> u32 {
        match self.effort {
            Effort::Quick => QUICK,
            Effort::Full => {
                let fit = LASTING.as_secs_f64() / round.max(2 * SHORTEST_TURN).as_secs_f64();
                // A cast from f64 saturates.
                (fit as u32).clamp(FEWEST, MOST)
            }
        }
    }
}

/// Ours and a rival that took turns.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Beside {
    pub(crate) ours: Sample,
    pub(crate) rival: Sample,
    /// Median over the rounds of the rival's time by ours. None where one takes no time.
    pub(crate) ratio: Option<f64>,
    pub(crate) least: Option<f64>,
    pub(crate) most: Option<f64>,
}

impl From<Pair> for Beside {
    fn from(pair: Pair) -> Self {
        let known = |ratio: f64| Some(ratio).filter(|ratio| ratio.is_finite());
        let [ratio, least, most] = [pair.ratio, pair.least, pair.most].map(known);
        Self { ours: pair.a, rival: pair.b, ratio, least, most }
    }
}

/// The whole step beside the same on narrower registers.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Narrower {
    /// The name of their path.
    pub(crate) path: String,
    pub(crate) whole: Beside,
}

/// The times at a number of threads.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Race {
    pub(crate) threads: usize,
    pub(crate) rounds: u32,
    /// In the order of [`PARTS`].
    pub(crate) parts: [Beside; PARTS.len()],
    /// The whole step beside our narrow phase on every pair of overlapping AABBs, found without a
    /// tree. For small scenes.
    pub(crate) brute_force: Option<Beside>,
    /// The whole step beside our AABBs and our narrow phase on every pair there is. For small scenes.
    pub(crate) every_pair: Option<Beside>,
    /// The whole step on one thread beside each narrower path that this CPU has.
    pub(crate) narrower: Vec<Narrower>,
}

/// A scene, judged and timed.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Comparison {
    pub(crate) scene: String,
    pub(crate) objects: usize,
    pub(crate) seed: Option<u64>,
    pub(crate) query: String,
    /// Of our contacts in their order.
    pub(crate) digest: String,
    pub(crate) judged: Judged,
    /// How many candidates each method of ours decided, in the order of [`Method::ALL`].
    pub(crate) decided: Vec<u64>,
    /// The requested numbers of threads.
    pub(crate) threads: Vec<usize>,
    /// One for each of them; none where our set is wrong.
    pub(crate) races: Vec<Race>,
}

impl Comparison {
    /// Which scene.
    pub(crate) fn label(&self) -> String {
        format!("{}, N = {}", self.scene, self.objects)
    }
}

/// Judges a scene, and where our set is right times it.
pub(crate) fn compare(subject: &Subject, course: &Course) -> Result<Comparison> {
    let scene = subject.scene()?;
    let mut said = Said::default();
    let (digest, decided) = {
        let mut pipeline = Pipeline::with(WideTree::default(), Overlap::default());
        let step = pipeline.step(&scene, Par::WarmPool);
        said.ours = Answers::ours(&step);
        let digest = Digest::of(step.contacts().map(|(i, j)| dcd_geom::Pair { i, j }));
        (digest, Method::ALL.map(|method| step.report().resolved(method)).to_vec())
    };
    // Gone before the f32 shapes are made: at a million hulls both would not fit.
    said.parry_f64 = {
        let mut parry = ParryPipeline::<f64>::new(&scene, Query::IntersectionTest);
        Answers::parry(&parry.place(&scene).step(Par::WarmPool))
    };
    let mut parry = ParryPipeline::<f32>::new(&scene, course.query.into());
    let mut parry = parry.place(&scene);
    let parry_digest = {
        let step = Ready::step(&mut parry, Par::WarmPool);
        said.parry_f32 = Answers::parry(&step);
        Digest::of(step.contacts()).set
    };
    let judged = judge::judge(&scene, &said)?;
    drop(said);

    let mut races = Vec::new();
    if judged.ours.wrong() == 0 {
        let mut track = Track { scene: &scene, parry: &mut parry, digest, parry_digest };
        for &threads in &course.threads {
            races.push(track.race(threads, course)?);
        }
    }
    Ok(Comparison {
        scene: subject.name(),
        objects: scene.len(),
        seed: subject.seed(),
        query: course
            .query
            .to_possible_value()
            .map_or_else(String::new, |q| q.get_name().to_owned()),
        digest: format!("{:016x}", digest.list),
        judged,
        decided,
        threads: course.threads.clone(),
        races,
    })
}

/// What the rivals need to step through a scene, and what they must find.
struct Track<'t, 's> {
    scene: &'s dcd_geom::Scene,
    parry: &'t mut Ready<'s, f32>,
    digest: Digest,
    parry_digest: u64,
}

impl Track<'_, '_> {
    fn race(&mut self, threads: usize, course: &Course) -> Result<Race> {
        if threads == 1 {
            return self.race_here(Par::Serial, threads, course);
        }
        let race =
            dcd_exec::with_threads(threads, || self.race_here(Par::WarmPool, threads, course));
        race.map_err(|error| anyhow!(error))?
    }

    fn race_here(&mut self, par: Par, threads: usize, course: &Course) -> Result<Race> {
        let objects = self.scene.len();
        let pipeline = Pipeline::with(WideTree::default(), Overlap::default());
        let ours = Ours { pipeline, scene: self.scene, digest: |digest| digest.list };
        let mut ours = Turn::new(ours, par, objects, self.digest.list);
        let mut parry = Turn::new(&mut *self.parry, par, objects, self.parry_digest);
        let rounds = course.rounds(ours.times()[WHOLE] + parry.times()[WHOLE]);
        let parts = timing::pairs_of(rounds, || ours.times(), || parry.times());
        ensure!(!parry.has_strayed(), "Parry's contacts changed from step to step");

        let (mut brute_force, mut every_pair) = (None, None);
        if objects <= BRUTE {
            let mut brute = self.brute(BruteForce, par);
            let [whole] = timing::pairs_of(rounds, || ours.whole(), || brute.whole());
            ensure!(!brute.has_strayed(), "brute force finds other contacts than the tree");
            brute_force = Some(whole.into());
            let mut every = self.brute(EveryPair, par);
            let [whole] = timing::pairs_of(rounds, || ours.whole(), || every.whole());
            ensure!(!every.has_strayed(), "without AABBs other contacts are found");
            every_pair = Some(whole.into());
        }
        let narrower = if threads == 1 { self.race_paths(&mut ours, rounds)? } else { Vec::new() };
        ensure!(!ours.has_strayed(), "our contacts or their order changed from step to step");
        let parts = parts.map(Beside::from);
        Ok(Race { threads, rounds, parts, brute_force, every_pair, narrower })
    }

    /// Our step beside the same on each narrower path.
    fn race_paths(
        &self,
        ours: &mut Turn<Ours<'_, WideTree>>,
        rounds: u32,
    ) -> Result<Vec<Narrower>> {
        let widest = Path::best();
        let paths = Path::ALL.into_iter().skip_while(|&path| path != widest).skip(1);
        let mut narrower = Vec::new();
        for path in paths.filter(|path| path.is_available()) {
            let pipeline = Pipeline::with(WideTree::on(path), Overlap::on(path));
            let rival = Ours { pipeline, scene: self.scene, digest: |digest| digest.list };
            let mut rival = Turn::new(rival, Par::Serial, self.scene.len(), self.digest.list);
            let [whole] = timing::pairs_of(rounds, || ours.whole(), || rival.whole());
            ensure!(!rival.has_strayed(), "{}: other contacts or another order", path.name());
            narrower.push(Narrower { path: path.name().to_owned(), whole: whole.into() });
        }
        Ok(narrower)
    }

    /// Our step without a tree.
    fn brute<B: BroadPhase>(&self, broad: B, par: Par) -> Turn<Ours<'_, B>> {
        let pipeline = Pipeline::with(broad, Overlap::default());
        let ours = Ours { pipeline, scene: self.scene, digest: |digest: Digest| digest.set };
        Turn::new(ours, par, self.scene.len(), self.digest.set)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn course(effort: Effort) -> Course {
        Course { query: ParryQuery::default(), threads: vec![1, 2], effort }
    }

    #[test]
    fn the_shorter_a_round_the_more_rounds_within_bounds() {
        let full = course(Effort::Full);
        let seconds = Duration::from_secs_f64;
        let rounds = [100.0, 1.0, 0.1, 1e-6].map(|round| full.rounds(seconds(round)));
        assert_eq!(rounds, [5, 10, 100, 501]);
        assert_eq!(course(Effort::Quick).rounds(seconds(1e-6)), 3);
    }

    #[test]
    fn a_small_scene_is_judged_and_every_part_timed_at_both_thread_counts() {
        let subject = Subject::parse("paper", Some(60), 3).unwrap();
        let comparison = compare(&subject, &course(Effort::Quick)).unwrap();
        let judged = &comparison.judged;
        assert!(judged.contacts > 0 && judged.ours.wrong() == 0 && judged.ours.undecided == 0);
        assert_eq!(judged.ours.contacts, judged.contacts);
        assert!(judged.ours.candidates >= judged.contacts);
        assert_eq!(comparison.decided.iter().sum::<u64>(), judged.ours.candidates as u64);
        assert_eq!(comparison.races.iter().map(|race| race.threads).collect::<Vec<_>>(), [1, 2]);
        for race in &comparison.races {
            assert!(race.brute_force.is_some() && race.every_pair.is_some());
            let available = Path::ALL.into_iter().filter(|path| path.is_available()).count();
            assert_eq!(race.narrower.len(), if race.threads == 1 { available - 1 } else { 0 });
            assert!(race.parts.iter().all(|part| part.ours.runs == QUICK && part.ratio.is_some()));
        }
    }

    #[test]
    fn a_run_reads_back_from_its_unit() {
        let subject = Subject::parse("identical", Some(8), 1).unwrap();
        let one = Course { threads: vec![1], ..course(Effort::Quick) };
        let comparison = compare(&subject, &one).unwrap();
        assert_eq!(comparison.judged.contacts, 28);
        let text = serde_json::to_string(&comparison).unwrap();
        let back: Comparison = serde_json::from_str(&text).unwrap();
        assert_eq!(serde_json::to_string(&back).unwrap(), text);
    }
}
