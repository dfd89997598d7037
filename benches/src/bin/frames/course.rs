//! A scene walks; everyone answers every frame, and is timed.

use std::time::Duration;

use anyhow::{Context, Result, ensure};
use dcd_benches::Effort;
use dcd_benches::timing::time;
use dcd_gjk::{Coherent, Method};
use dcd_parry::{ParryPipeline, Query, Upkeep};
use dcd_pipeline::{Par, Pipeline, WideTree};
use dcd_scenes::{RandomWalk, SceneSpec};
use serde::{Deserialize, Serialize};

/// Frames of a walk. Parry runs in the first [`OF_PARRY`] alone.
const FRAMES: usize = 8;
const OF_PARRY: usize = 3;

/// A scene, and how far its objects step from frame to frame.
pub(crate) struct Course {
    pub(crate) scene: &'static str,
    pub(crate) objects: usize,
    /// The standard deviation of a step along and about each axis, metres and rad.
    pub(crate) sigma: f64,
    pub(crate) seed: u64,
}

/// Medians over the walks; of `plain` over all frames but the first, of `later` over those from the
/// third on.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Outcome {
    pub(crate) scene: String,
    pub(crate) objects: usize,
    pub(crate) sigma: f64,
    pub(crate) walks: usize,
    pub(crate) plain: Duration,
    pub(crate) first: Duration,
    pub(crate) second: Duration,
    pub(crate) later: Duration,
    pub(crate) parry_second: Duration,
    /// The part of the candidates that was remembered, in the second frame and in the last.
    pub(crate) remembered: [f64; 2],
    /// Contacts of all frames that Parry ran in, and how many of them differ.
    pub(crate) contacts: usize,
    pub(crate) parry_differs: usize,
}

/// What the walks showed, frame upon frame.
#[derive(Default)]
struct Seen {
    plain: Vec<Duration>,
    first: Vec<Duration>,
    second: Vec<Duration>,
    later: Vec<Duration>,
    parry_second: Vec<Duration>,
    remembered: [f64; 2],
    contacts: usize,
    parry_differs: usize,
}

impl Course {
    pub(crate) fn key(&self) -> String {
        format!("{} {} at sigma {}", self.scene, self.objects, self.sigma)
    }

    pub(crate) fn run(&self, effort: Effort) -> Result<Outcome> {
        let walks = if effort == Effort::Quick { 1 } else { 3 };
        let mut seen = Seen::default();
        for _ in 0..walks {
            self.walk(&mut seen)?;
        }
        Ok(Outcome {
            scene: self.scene.to_owned(),
            objects: self.objects,
            sigma: self.sigma,
            walks,
            plain: median(seen.plain)?,
            first: median(seen.first)?,
            second: median(seen.second)?,
            later: median(seen.later)?,
            parry_second: median(seen.parry_second)?,
            remembered: seen.remembered,
            contacts: seen.contacts,
            parry_differs: seen.parry_differs,
        })
    }

    /// All pipelines are new, and so their first frame is.
    fn walk(&self, seen: &mut Seen) -> Result<()> {
        let spec = SceneSpec::parse(self.scene)?.with_objects(self.objects).with_seed(self.seed);
        let mut scene = dcd_benches::draw(&spec)?;
        let mut walk = match self.sigma {
            0.0 => None,
            sigma => Some(RandomWalk::new(sigma, self.seed)?),
        };
        let mut plain = Pipeline::new();
        let mut coherent = Pipeline::with(WideTree::default(), Coherent::default());
        let parry = ParryPipeline::<f32>::new(&scene, Query::DirectIntersectionTest);
        let mut parry = parry.with_upkeep(Upkeep::Refit);
        (seen.contacts, seen.parry_differs) = (0, 0);
        for frame in 0..FRAMES {
            let (of_plain, step) = time(|| plain.step(&scene, Par::Serial));
            let (of_coherent, remembering) = time(|| coherent.step(&scene, Par::Serial));
            ensure!(remembering.contacts().eq(step.contacts()), "frame {frame} differs");
            ensure!(step.report().undecided().is_empty(), "frame {frame} has undecided pairs");
            let known = remembering.report().resolved(Method::Remembered) as f64;
            let known = known / remembering.candidate_count().max(1) as f64;
            match frame {
                0 => seen.first.push(of_coherent),
                1 => {
                    seen.second.push(of_coherent);
                    seen.remembered[0] = known;
                }
                _ => {
                    seen.later.push(of_coherent);
                    seen.remembered[1] = known;
                }
            }
            if frame > 0 {
                seen.plain.push(of_plain);
            }
            if frame < OF_PARRY {
                let mut ready = parry.place(&scene);
                let (of_parry, answer) = time(|| ready.step(Par::Serial));
                if frame == 1 {
                    seen.parry_second.push(of_parry);
                }
                let mut ours: Vec<_> = step.answers().map(|contact| contact.pair).collect();
                ours.sort_unstable();
                seen.contacts += ours.len();
                seen.parry_differs += differing(&ours, &answer.sorted_contacts());
            }
            if let Some(walk) = &mut walk {
                walk.step(&mut scene)?;
            }
        }
        Ok(())
    }
}

/// How many are in one of two sorted lists alone.
fn differing<T: Ord>(a: &[T], b: &[T]) -> usize {
    let missing = |a: &[T], b: &[T]| a.iter().filter(|x| b.binary_search(x).is_err()).count();
    missing(a, b) + missing(b, a)
}

fn median(mut times: Vec<Duration>) -> Result<Duration> {
    times.sort_unstable();
    times.get(times.len() / 2).copied().context("no frame was timed")
}
