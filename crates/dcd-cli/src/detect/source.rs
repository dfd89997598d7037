//! The source of the scene.

use crate::failure::Failure;
use crate::making::on_threads;
use crate::{count, memory};
use clap::Args;
use clap::builder::PossibleValuesParser;
use dcd_geom::Scene;
use dcd_io::{BuildError, CloudCensus, ReadError, data, read_clouds, read_hull_scene, shown};
use dcd_scenes::{GameHulls, GameSize, Run, SceneSpec};
use std::fs::File;
use std::io::stdin;
use std::path::{Path, PathBuf};

/// The file name that stands for standard input.
const STANDARD_INPUT: &str = "-";

/// Candidate pairs an object, of clouds.
const USUAL_DENSITY: f64 = 4.0;

/// What depends on --clouds conflicts with these too: clap does not insist on --clouds beside them.
const NOT_WITH_CLOUDS: [&str; 3] = ["file", "scene", "capture"];

#[derive(Args)]
pub(super) struct Source {
    /// A hull scene (format: see --help); `-` is standard input
    #[arg(
        required_unless_present_any = ["scene", "clouds", "capture"],
        conflicts_with_all = ["scene", "clouds", "capture", "n", "seed"]
    )]
    file: Option<PathBuf>,
    /// A seeded scene in place of a file
    #[arg(long, value_name = "NAME", conflicts_with = "clouds", value_parser = names())]
    scene: Option<String>,
    /// Point clouds in place of a file: u32 count, then count × 3 f32, little endian, again and
    /// again; their hulls are spread in a seeded scene
    #[arg(long, value_name = "FILE", conflicts_with_all = NOT_WITH_CLOUDS)]
    clouds: Option<PathBuf>,
    /// A capture in place of a file: a step for each of its frames (format: docs/captures.md)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["scene", "clouds", "n", "seed"])]
    pub(super) capture: Option<PathBuf>,
    /// How many objects [default: the scene's usual number; one for each cloud]
    #[arg(long, value_name = "N", value_parser = count::objects)]
    n: Option<u32>,
    /// The seed [default: 1]
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
    /// About how many candidate pairs there are for each object of --clouds [default: 4]
    #[arg(
        long,
        value_name = "D",
        requires = "clouds",
        conflicts_with_all = NOT_WITH_CLOUDS,
        value_parser = density
    )]
    density: Option<f64>,
    /// Leave the clouds as large as they are; otherwise each is scaled to unit size
    #[arg(long, requires = "clouds", conflicts_with_all = NOT_WITH_CLOUDS)]
    true_size: bool,
}

/// A checked scene, and what the clouds were if it was made from some.
pub(super) struct Loaded {
    pub(super) scene: Scene,
    pub(super) clouds: Option<CloudCensus>,
}

/// Bytes of an object of clouds, which share their shapes, at least.
const BYTES_A_CLOUD_OBJECT: f64 = 400.0;

impl Source {
    /// The input files.
    pub(super) fn inputs(&self) -> Vec<PathBuf> {
        let named = [&self.file, &self.clouds, &self.capture].into_iter().flatten().cloned();
        named.chain(data::file("hulls/convex_hulls.bin")).collect()
    }

    /// The scene, its shapes made on so many threads.
    pub(super) fn load(&self, threads: usize) -> Result<Loaded, Failure> {
        if let Some(name) = &self.scene {
            return self.seeded(name, threads).map(|scene| Loaded { scene, clouds: None });
        }
        if let Some(path) = &self.clouds {
            return self.spread_clouds(path, threads);
        }
        // clap has seen to it that there is one.
        let path = self.file.as_deref().unwrap_or(Path::new(STANDARD_INPUT));
        let raw = read(path, read_hull_scene)?;
        let scene = on_threads(threads, |run| raw.into_scene_by(run))?;
        let scene = scene.map_err(|error| refused(path, error))?;
        Ok(Loaded { scene, clouds: None })
    }

    fn seeded(&self, name: &str, threads: usize) -> Result<Scene, Failure> {
        let mut spec = SceneSpec::parse(name).map_err(|error| Failure::at("--scene", error))?;
        spec.objects = self.n.map_or(spec.objects, |n| n as usize);
        spec.seed = self.seed.unwrap_or(spec.seed);
        let what = format_args!("{} objects of {name:?}", spec.objects);
        memory::demand("--n", what, spec.least_bytes())?;
        let scene = on_threads(threads, |run| spec.scene_by(run))?;
        scene.map_err(|error| Failure::at(name, error))
    }

    fn spread_clouds(&self, path: &Path, threads: usize) -> Result<Loaded, Failure> {
        let clouds = read(path, read_clouds)?;
        let objects = self.n.map_or(clouds.len(), |n| n as usize);
        let bytes = BYTES_A_CLOUD_OBJECT * objects as f64;
        memory::demand("--n", format_args!("{objects} objects"), bytes)?;
        let game = GameHulls {
            size: if self.true_size { GameSize::True } else { GameSize::Unit },
            candidates: self.density.unwrap_or(USUAL_DENSITY),
        };
        let spread = (objects, self.seed.unwrap_or(1));
        let make = |run: &Run<'_>| game.raw_by(&clouds, spread, run).into_scene_by(run);
        let scene = on_threads(threads, make)?.map_err(|error| refused(path, error))?;
        let census = CloudCensus::of(clouds.iter().map(Vec::as_slice));
        Ok(Loaded { scene, clouds: Some(census) })
    }
}

/// The file or standard input, parsed.
fn read<T>(path: &Path, parse: fn(&[u8]) -> Result<T, ReadError>) -> Result<T, Failure> {
    let place = place(path);
    let bytes = if path.as_os_str() == STANDARD_INPUT {
        memory::read(&place, stdin())?
    } else {
        memory::read(&place, File::open(path).map_err(|error| Failure::at(&place, error))?)?
    };
    parse(&bytes).map_err(|error| Failure::at(&place, error))
}

fn place(path: &Path) -> String {
    if path.as_os_str() == STANDARD_INPUT { "standard input".into() } else { shown(path) }
}

fn refused(path: &Path, error: BuildError) -> Failure {
    Failure::at(place(path), error)
}

fn names() -> PossibleValuesParser {
    SceneSpec::all().iter().map(SceneSpec::name).collect::<Vec<_>>().into()
}

fn density(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "no number".to_owned())?;
    // Written so that NaN is refused.
    if value > 0.0 && value.is_finite() { Ok(value) } else { Err("not positive and finite".into()) }
}
