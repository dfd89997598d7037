//! A scene walks; everyone answers every frame, and is timed.

use std::time::Duration;

use anyhow::{Context, Result, ensure};
use dcd_benches::timing::time;
use dcd_benches::{Effort, FallingPile};
use dcd_geom::Scene;
use dcd_gjk::{Coherent, Method};
use dcd_parry::{ParryPipeline, Query, Upkeep};
use dcd_pipeline::{Par, Pipeline, WideTree};
use dcd_scenes::{RandomWalk, SceneSpec};
use serde::{Deserialize, Serialize};

/// Frames of a course: a second of a game. Parry runs in the first [`OF_PARRY`] alone.
pub(crate) const FRAMES: usize = 60;
const OF_PARRY: usize = 3;

/// How long a pile falls before its course begins, frames.
const FALLING: usize = 180;

/// How the objects of a scene move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Motion {
    /// By random steps: their standard deviation along and about each axis, metres and rad. 0: not at all.
    Walk(f64),
    /// As hulls in a pile that comes to rest.
    Settle,
}

/// A scene, and how its objects move from frame to frame.
pub(crate) struct Course {
    pub(crate) scene: &'static str,
    pub(crate) objects: usize,
    pub(crate) motion: Motion,
    pub(crate) seed: u64,
}

/// Medians over the rounds.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Outcome {
    pub(crate) scene: String,
    pub(crate) objects: usize,
    /// None of a pile.
    pub(crate) sigma: Option<f64>,
    /// All frames of the pipeline that remembers nothing, and of the one that does.
    pub(crate) plain: Duration,
    pub(crate) coherent: Duration,
    /// Of the one that remembers: its first frame, and the median of those from the third on.
    pub(crate) first: Duration,
    pub(crate) later: Duration,
    pub(crate) parry_second: Duration,
    /// The part of the candidates that was remembered, in the second frame and in the last.
    pub(crate) remembered: [f64; 2],
    /// Contacts of all frames that Parry ran in, and how many of them differ.
    pub(crate) contacts: usize,
    pub(crate) parry_differs: usize,
}

/// What the rounds showed.
#[derive(Default)]
struct Seen {
    plain: Vec<Duration>,
    coherent: Vec<Duration>,
    first: Vec<Duration>,
    later: Vec<Duration>,
    parry_second: Vec<Duration>,
    remembered: [f64; 2],
    contacts: usize,
    parry_differs: usize,
}

/// A scene that walks, or stands still.
struct Walking {
    scene: Scene,
    walk: Option<RandomWalk>,
}

/// A scene that moves.
enum Moving {
    Walking(Box<Walking>),
    Falling(Box<FallingPile>),
}

impl Moving {
    fn scene(&self) -> &Scene {
        match self {
            Self::Walking(walking) => &walking.scene,
            Self::Falling(pile) => pile.scene(),
        }
    }

    fn advance(&mut self) -> Result<()> {
        match self {
            Self::Walking(walking) => {
                if let Some(walk) = &mut walking.walk {
                    walk.step(&mut walking.scene)?;
                }
            }
            Self::Falling(pile) => pile.advance()?,
        }
        Ok(())
    }
}

impl Course {
    pub(crate) fn key(&self) -> String {
        format!("{} {} {:?}", self.scene, self.objects, self.motion)
    }

    pub(crate) fn run(&self, effort: Effort) -> Result<Outcome> {
        let rounds = if effort == Effort::Quick { 1 } else { 3 };
        let mut seen = Seen::default();
        for _ in 0..rounds {
            self.go(&mut seen)?;
        }
        Ok(Outcome {
            scene: self.scene.to_owned(),
            objects: self.objects,
            sigma: match self.motion {
                Motion::Walk(sigma) => Some(sigma),
                Motion::Settle => None,
            },
            plain: median(seen.plain)?,
            coherent: median(seen.coherent)?,
            first: median(seen.first)?,
            later: median(seen.later)?,
            parry_second: median(seen.parry_second)?,
            remembered: seen.remembered,
            contacts: seen.contacts,
            parry_differs: seen.parry_differs,
        })
    }

    /// Where it begins.
    fn start(&self) -> Result<Moving> {
        let draw = || {
            let spec = SceneSpec::parse(self.scene)?.with_objects(self.objects);
            dcd_benches::draw(&spec.with_seed(self.seed))
        };
        Ok(match self.motion {
            Motion::Walk(sigma) => {
                let walk = || RandomWalk::new(sigma, self.seed);
                let walk = (sigma > 0.0).then(walk).transpose()?;
                Moving::Walking(Box::new(Walking { scene: draw()?, walk }))
            }
            Motion::Settle => {
                let pile = FallingPile::after(FALLING, self.objects, self.seed)?;
                Moving::Falling(Box::new(pile))
            }
        })
    }

    /// All pipelines are new, and so their first frame is.
    fn go(&self, seen: &mut Seen) -> Result<()> {
        let mut moving = self.start()?;
        let mut plain = Pipeline::new();
        let mut coherent = Pipeline::with(WideTree::default(), Coherent::default());
        let parry = ParryPipeline::<f32>::new(moving.scene(), Query::DirectIntersectionTest);
        let mut parry = parry.with_upkeep(Upkeep::Refit);
        (seen.contacts, seen.parry_differs) = (0, 0);
        let mut sums = [Duration::ZERO; 2];
        for frame in 0..FRAMES {
            let scene = moving.scene();
            // In turns: the second reads a scene that the first has just read.
            let ((of_plain, step), (of_coherent, remembering)) = if frame % 2 == 0 {
                let plain = time(|| plain.step(scene, Par::Serial));
                (plain, time(|| coherent.step(scene, Par::Serial)))
            } else {
                let coherent = time(|| coherent.step(scene, Par::Serial));
                (time(|| plain.step(scene, Par::Serial)), coherent)
            };
            ensure!(remembering.contacts().eq(step.contacts()), "frame {frame} differs");
            ensure!(step.report().undecided().is_empty(), "frame {frame} has undecided pairs");
            let known = remembering.report().resolved(Method::Remembered) as f64;
            let known = known / remembering.candidate_count().max(1) as f64;
            match frame {
                0 => seen.first.push(of_coherent),
                1 => seen.remembered[0] = known,
                _ => {
                    seen.later.push(of_coherent);
                    seen.remembered[1] = known;
                }
            }
            sums[0] += of_plain;
            sums[1] += of_coherent;
            if frame < OF_PARRY {
                let mut ready = parry.place(scene);
                let (of_parry, answer) = time(|| ready.step(Par::Serial));
                if frame == 1 {
                    seen.parry_second.push(of_parry);
                }
                let mut ours: Vec<_> = step.answers().map(|contact| contact.pair).collect();
                ours.sort_unstable();
                seen.contacts += ours.len();
                seen.parry_differs += differing(&ours, &answer.sorted_contacts());
            }
            moving.advance()?;
        }
        seen.plain.push(sums[0]);
        seen.coherent.push(sums[1]);
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
