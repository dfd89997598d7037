//! A batch of a robot's configurations against obstacles that stand still: ours and Parry's.

#![forbid(unsafe_code)]

use std::process::ExitCode;

use anyhow::{Result, ensure};
use clap::Parser;
use dcd_benches::timing::{Pair, pairs_of, time};
use dcd_benches::{Header, Options};
use dcd_exec::{Exec, Par, Segments, with_threads};
use dcd_geom::{Pose, Scene, glam::DVec3};
use dcd_parry::{Hit, ParryWorld, Query, Until};
use dcd_pipeline::{Linkage, Other, Overlap, Probe, World};
use dcd_scenes::SceneSpec;

/// Configurations of ten hulls against a hundred, at random in two rooms, the first hit of each and
/// all hits: our time, Parry's in f32, and how many times as fast ours is.
#[derive(Parser)]
#[command(name = "one-against-many", version)]
struct Line {
    #[command(flatten)]
    options: Options,
}

const LINKS: usize = 10;
const OBSTACLES: usize = 100;

fn main() -> ExitCode {
    match run(&Line::parse().options) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: &Options) -> Result<()> {
    for (name, value) in Header::observe(options).lines() {
        println!("{name}: {value}");
    }
    let (configurations, rounds) = if options.quick { (1_000, 3) } else { (10_000, 10) };
    println!("{configurations} configurations of {LINKS} hulls against {OBSTACLES}");
    for half_width in [4.0, 8.0] {
        let case = Case::new(half_width, configurations, options.seed)?;
        for (threads, par) in [(1, Par::Serial), (options.threads(), Par::Pool)] {
            with_threads(threads, || case.race(par, rounds))
                .map_err(|error| anyhow::anyhow!("{threads} threads: {error}"))??;
        }
    }
    Ok(())
}

struct Case {
    half_width: f64,
    obstacles: Scene,
    /// The links' shapes, each at the origin.
    robot: Scene,
    poses: Vec<Pose>,
}

impl Case {
    /// Obstacles in a cube of that half-width; chains of links that start in it, half a metre from
    /// link to link.
    fn new(half_width: f64, configurations: usize, seed: u64) -> Result<Self> {
        let spread = |objects, seed| -> Result<Scene> {
            let spec = SceneSpec::parse("paper")?.with_objects(objects).with_seed(seed);
            Ok(spec.scene()?)
        };
        // The recipe's own cube has a half-width of 3.
        let scaled =
            |pose: &Pose, by: f64| Pose::from_matrix(*pose.rotation(), pose.translation() * by);
        let plain = spread(OBSTACLES, seed)?;
        let scale = half_width / 3.0;
        let places = plain.poses().iter().map(|pose| scaled(pose, scale));
        let obstacles =
            Scene::one_each(plain.shapes().to_vec(), places.collect::<Result<_, _>>()?)?;
        let robot = spread(LINKS, seed + 1)?;
        let random = spread(configurations * LINKS, seed + 2)?;
        let mut poses = Vec::with_capacity(random.len());
        let mut joint = DVec3::ZERO;
        for (k, pose) in random.poses().iter().enumerate() {
            joint = match k % LINKS {
                0 => pose.translation() * scale,
                _ => joint + pose.translation().normalize_or_zero() * 0.5,
            };
            poses.push(Pose::from_matrix(*pose.rotation(), joint)?);
        }
        Ok(Self { half_width, obstacles, robot, poses })
    }

    fn race(&self, par: Par, rounds: u32) -> Result<()> {
        let world = World::new(&self.obstacles, Overlap::default(), par)?;
        let mut probe = world.probe(Linkage::new(self.robot.shapes().to_vec()))?;
        let query = Query::DirectIntersectionTest;
        let rival = ParryWorld::<f32>::new(&self.obstacles, self.robot.shapes(), query)?;
        let posed = rival.place(&self.poses);
        let mut hits = Segments::default();
        for until in [Until::First, Until::Last] {
            let mut theirs = || rival.ask(&posed, until, Exec::from(par), &mut hits);
            let [pair] = pairs_of(
                rounds,
                || [time(|| ask(&mut probe, &self.poses, until, par)).0],
                || [time(&mut theirs).0],
            );
            let ours = touching(&mut probe, &self.poses, until, par)?;
            self.show(until, par, &pair, &ours, &hits)?;
        }
        Ok(())
    }

    fn show(
        &self,
        until: Until,
        par: Par,
        pair: &Pair,
        ours: &[Hit],
        theirs: &Segments<Hit>,
    ) -> Result<()> {
        let mut theirs: Vec<Hit> = theirs.iter().flatten().copied().collect();
        theirs.sort_unstable();
        let differing = match until {
            Until::Last => differing(ours, &theirs),
            // Parry's first hit is its tree's; that there is one must agree.
            Until::First => differing(&configurations(ours), &configurations(&theirs)),
        };
        ensure!(differing * 1000 <= ours.len().max(1000), "{differing} of {} differ", ours.len());
        println!(
            "half-width {}, {until:?} hit, {par:?}: ours {:.3} ms, Parry {:.3} ms, ratio {:.1} \
             ({:.1} to {:.1}); {} hits, {differing} differ",
            self.half_width,
            pair.a.median.as_secs_f64() * 1e3,
            pair.b.median.as_secs_f64() * 1e3,
            pair.ratio,
            pair.least,
            pair.most,
            ours.len(),
        );
        Ok(())
    }
}

/// What is timed: how many findings there are.
fn ask(probe: &mut Probe<'_>, poses: &[Pose], until: Until, par: Par) -> usize {
    match until {
        Until::First => probe.first(poses, par).map_or(0, |first| first.iter().flatten().count()),
        Until::Last => probe.all(poses, par).map_or(0, |all| all.len()),
    }
}

/// The same findings, sorted.
fn touching(probe: &mut Probe<'_>, poses: &[Pose], until: Until, par: Par) -> Result<Vec<Hit>> {
    let found: Vec<_> = match until {
        Until::First => probe.first(poses, par)?.iter().flatten().copied().collect(),
        Until::Last => probe.all(poses, par)?.iter().collect(),
    };
    let mut hits = Vec::new();
    for found in found {
        ensure!(found.touches(), "{found:?} is not settled");
        if let Other::Obstacle(obstacle) = found.other {
            hits.push(Hit { configuration: found.configuration, link: found.link, obstacle });
        }
    }
    hits.sort_unstable();
    Ok(hits)
}

fn configurations(hits: &[Hit]) -> Vec<u32> {
    hits.iter().map(|hit| hit.configuration).collect()
}

/// How many are in one of two sorted lists alone.
fn differing<T: Ord>(a: &[T], b: &[T]) -> usize {
    let missing = |a: &[T], b: &[T]| a.iter().filter(|x| b.binary_search(x).is_err()).count();
    missing(a, b) + missing(b, a)
}
