//! Where the scene comes from.

use crate::failure::Failure;
use crate::making::on_threads;
use clap::Args;
use clap::builder::PossibleValuesParser;
use dcd_geom::Scene;
use dcd_scenes::{
    BuildError, CloudCensus, GameHulls, GameSize, ReadError, Run, SceneSpec, load_clouds,
    load_hull_scene, read_clouds, read_hull_scene,
};
use std::fmt::Display;
use std::io::{Read, stdin};
use std::path::{Path, PathBuf};

/// The file name that stands for standard input.
const STANDARD_INPUT: &str = "-";

/// Candidate pairs an object, of clouds.
const USUAL_DENSITY: f64 = 4.0;

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
    #[arg(long, value_name = "FILE")]
    clouds: Option<PathBuf>,
    /// A capture in place of a file: a step for each of its frames (format: docs/captures.md)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["scene", "clouds", "n", "seed"])]
    pub(super) capture: Option<PathBuf>,
    /// How many objects [default: the scene's usual number; one for each cloud]
    #[arg(long, value_name = "N")]
    n: Option<u32>,
    /// The seed [default: 1]
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
    /// About how many candidate pairs there are for each object of --clouds [default: 4]
    #[arg(
        long,
        value_name = "D",
        requires = "clouds",
        conflicts_with_all = ["file", "scene"],
        value_parser = density
    )]
    density: Option<f64>,
    /// Leave the clouds as large as they are; otherwise each is scaled to unit size
    #[arg(long, requires = "clouds", conflicts_with_all = ["file", "scene"])]
    true_size: bool,
}

/// A checked scene, and what the clouds were if it was made from some.
pub(super) struct Loaded {
    pub(super) scene: Scene,
    pub(super) clouds: Option<CloudCensus>,
}

impl Source {
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
        let raw = read(path, load_hull_scene, read_hull_scene)?;
        let scene = on_threads(threads, |run| raw.into_scene_by(run))?;
        let scene = scene.map_err(|error| refused(path, error))?;
        Ok(Loaded { scene, clouds: None })
    }

    fn seeded(&self, name: &str, threads: usize) -> Result<Scene, Failure> {
        let mut spec = SceneSpec::parse(name).map_err(|error| Failure::at("--scene", error))?;
        spec.objects = self.n.map_or(spec.objects, |n| n as usize);
        spec.seed = self.seed.unwrap_or(spec.seed);
        let scene = on_threads(threads, |run| spec.scene_by(run))?;
        scene.map_err(|error| Failure::at(name, error))
    }

    fn spread_clouds(&self, path: &Path, threads: usize) -> Result<Loaded, Failure> {
        let clouds = read(path, load_clouds, read_clouds)?;
        let objects = self.n.map_or(clouds.len(), |n| n as usize);
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

/// From the file by `load`, from standard input by `parse`.
fn read<T>(
    path: &Path,
    load: fn(&Path) -> Result<T, ReadError>,
    parse: fn(&[u8]) -> Result<T, ReadError>,
) -> Result<T, Failure> {
    if path.as_os_str() != STANDARD_INPUT {
        // The error names the file.
        return load(path).map_err(|error| Failure::Input(error.to_string()));
    }
    let refused = |error: &dyn Display| Failure::at("standard input", error);
    let mut bytes = Vec::new();
    stdin().read_to_end(&mut bytes).map_err(|error| refused(&error))?;
    parse(&bytes).map_err(|error| refused(&error))
}

fn refused(path: &Path, error: BuildError) -> Failure {
    if path.as_os_str() == STANDARD_INPUT {
        Failure::at("standard input", error)
    } else {
        Failure::at(path.display(), error)
    }
}

fn names() -> PossibleValuesParser {
    SceneSpec::all().iter().map(SceneSpec::name).collect::<Vec<_>>().into()
}

fn density(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "no number".to_owned())?;
    // Written so that NaN is refused.
    if value > 0.0 && value.is_finite() { Ok(value) } else { Err("not positive and finite".into()) }
}
