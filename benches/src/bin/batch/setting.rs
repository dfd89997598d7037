//! Runs both, judges, and takes times.

use std::collections::BTreeSet;

use anyhow::{Context, Result, ensure};
use dcd_benches::Effort;
use dcd_benches::timing::{Pair, pairs_of, time};
use dcd_exec::{Exec, Par, Segments};
use dcd_geom::{Pose, Scene, Shape};
use dcd_gjk::{PosedSupport, certified};
use dcd_parry::{Hit, ParryWorld, Query, Until};
use dcd_pipeline::{BatchChecker, LinkSet, Other, Overlap, StaticWorld};
use dcd_scenes::{SceneSpec, poses_in};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// How many hulls are posed together.
pub(crate) const LINKS: usize = 10;

/// From joint to joint, metres: so that neighbouring links, each about a metre, overlap.
const STRIDE: f64 = 0.5;

/// How many obstacles stand in a cube of which half-width, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Size {
    pub(crate) obstacles: usize,
    pub(crate) half_width: f64,
}

/// Obstacles, and configurations of a chain of links that starts somewhere among them.
pub(crate) struct Setting {
    pub(crate) size: Size,
    obstacles: Scene,
    links: Vec<Shape>,
    poses: Vec<Pose>,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Outcome {
    /// Our hits: configurations that touch, or links and obstacles that do.
    pub(crate) hits: usize,
    /// Hits that exact integers say are wrong or missing.
    pub(crate) ours_wrong: usize,
    pub(crate) parry_wrong: usize,
    pub(crate) pair: Pair,
}

impl Setting {
    /// The paper's hulls; each joint a stride from the one before in a random direction.
    pub(crate) fn new(size: Size, configurations: usize, seed: u64) -> Result<Self> {
        let shapes = |objects, seed| -> Result<Vec<Shape>> {
            let spec = SceneSpec::paper().with_objects(objects).with_seed(seed);
            Ok(spec.scene()?.shapes().to_vec())
        };
        let wide = DVec3::splat(size.half_width);
        let places = poses_in(-wide, wide, seed).take(size.obstacles).collect();
        let obstacles = Scene::one_each(shapes(size.obstacles, seed)?, places)?;
        let links = shapes(LINKS, seed + 1)?;
        let mut poses: Vec<Pose> =
            poses_in(-wide, wide, seed + 2).take(configurations * LINKS).collect();
        let mut joint = DVec3::ZERO;
        for (k, pose) in poses.iter_mut().enumerate() {
            joint = match k % LINKS {
                0 => pose.translation(),
                _ => joint + pose.translation().normalize_or_zero() * STRIDE,
            };
            *pose = Pose::from_matrix(*pose.rotation(), joint)?;
        }
        Ok(Self { size, obstacles, links, poses })
    }

    /// Takes turns with Parry.
    pub(crate) fn race(&self, until: Until, par: Par, effort: Effort) -> Result<Outcome> {
        let world = StaticWorld::new(&self.obstacles, Overlap::default(), par)?;
        let mut checker = world.checker(LinkSet::new(self.links.clone()))?;
        let query = Query::DirectIntersectionTest;
        let rival = ParryWorld::<f32>::new(&self.obstacles, &self.links, query)?;
        let posed = rival.place(&self.poses);
        let (mut hits, mut unanswered) = (Segments::default(), 0);
        let rounds = if effort == Effort::Quick { 3 } else { 10 };
        let [pair] = pairs_of(
            rounds,
            || [time(|| count(&mut checker, &self.poses, until, par)).0],
            || [time(|| unanswered = rival.query(&posed, until, Exec::from(par), &mut hits)).0],
        );
        let refused = rival.refused_links().chain(rival.refused_obstacles()).count();
        ensure!(unanswered == 0 && refused == 0, "Parry does not answer all");
        let ours = touching(&mut checker, &self.poses, until, par)?;
        let parrys: BTreeSet<Hit> = hits.iter().flatten().copied().collect();
        let (ours_wrong, parry_wrong) = match until {
            Until::Last => self.judge(&ours, &parrys, |hit| self.touch(hit)),
            // Parry's first hit is its tree's; that there is one must agree.
            Until::First => {
                self.judge(&configurations(&ours), &configurations(&parrys), |&configuration| {
                    let link = |link| (0..self.size.obstacles as u32).map(move |o| (link, o));
                    (0..LINKS as u32)
                        .flat_map(link)
                        .any(|(link, obstacle)| self.touch(&Hit { configuration, link, obstacle }))
                })
            }
        };
        Ok(Outcome { hits: ours.len(), ours_wrong, parry_wrong, pair })
    }

    /// How many of our hits and of Parry's are wrong or missing, where they differ.
    fn judge<T: Ord>(
        &self,
        ours: &BTreeSet<T>,
        parrys: &BTreeSet<T>,
        truth: impl Fn(&T) -> bool,
    ) -> (usize, usize) {
        let yes = ours.symmetric_difference(parrys).map(|t| (ours.contains(t), truth(t)));
        yes.fold((0, 0), |(ours, parrys), (we_say, truth)| match we_say == truth {
            true => (ours, parrys + 1),
            false => (ours + 1, parrys),
        })
    }

    /// Whether the two touch, by exact integers.
    fn touch(&self, hit: &Hit) -> bool {
        let obstacle = hit.obstacle as usize;
        let pose = &self.poses[hit.configuration as usize * LINKS + hit.link as usize];
        let link = self.links[hit.link as usize].as_polytope();
        let (Some(link), Some(other)) = (link, self.obstacles.shape(obstacle).as_polytope()) else {
            return false;
        };
        let other = PosedSupport::polytope(other, &self.obstacles.poses()[obstacle]);
        certified::overlap_exactly(PosedSupport::polytope(link, pose), other)
    }
}

/// What is timed: how many hits there are.
fn count(checker: &mut BatchChecker, poses: &[Pose], until: Until, par: Par) -> usize {
    match until {
        Until::First => checker.first(poses, par).map_or(0, |first| first.iter().flatten().count()),
        Until::Last => checker.all(poses, par).map_or(0, |all| all.len()),
    }
}

/// The same hits.
fn touching(
    checker: &mut BatchChecker,
    poses: &[Pose],
    until: Until,
    par: Par,
) -> Result<BTreeSet<Hit>> {
    let found: Vec<_> = match until {
        Until::First => checker.first(poses, par)?.iter().flatten().copied().collect(),
        Until::Last => checker.all(poses, par)?.iter().collect(),
    };
    let hit = |found: &dcd_pipeline::Hit<()>| {
        ensure!(found.touches(), "{found:?} is undecided");
        let Other::Obstacle(obstacle) = found.other else { return Ok(None) };
        Ok(Some(Hit { configuration: found.configuration, link: found.link, obstacle }))
    };
    let hits: Result<Vec<Option<Hit>>> = found.iter().map(hit).collect();
    Ok(hits.context("a finding")?.into_iter().flatten().collect())
}

fn configurations(hits: &BTreeSet<Hit>) -> BTreeSet<u32> {
    hits.iter().map(|hit| hit.configuration).collect()
}
