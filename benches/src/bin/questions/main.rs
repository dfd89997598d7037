//! Distance, depth and manifold of whole scenes at every accuracy, beside Parry's queries of the same pairs.
//!
//! No time is shown before the bounds are checked: the answers of a smaller accuracy have to be consistent with the
//! certified ones.

#![forbid(unsafe_code)]

mod contest;
mod kinds;
mod parry;
mod show;

use std::process::ExitCode;

use anyhow::{Result, ensure};
use clap::Parser;
use dcd_benches::{Header, Options, Print, Units, draw, exit_code};
use dcd_scenes::SceneSpec;

use contest::{Kind, Outcome, run_scene};
use kinds::{Cross, run_kinds};

/// The scenes, each with its objects in full and with --quick: those whose shapes Parry has too.
const SCENES: [(&str, usize, usize); 8] = [
    ("paper", 3000, 300),
    ("sparse", 10_000, 1000),
    ("boxes", 10_000, 1000),
    ("cuboids", 10_000, 1000),
    ("spheres", 10_000, 1000),
    ("plates", 5000, 500),
    ("needles", 5000, 500),
    ("clustered", 5000, 500),
];

/// A mesh under so many bodies: in full and with --quick.
const TERRAIN: (&str, usize, usize) = ("terrain", 2000, 500);

/// How far, how deep and where of whole scenes, at every accuracy: our narrow phase beside Parry's queries of the same
/// candidate pairs, and our step beside Parry's, interleaved in one process, on one thread.
#[derive(Parser)]
#[command(name = "questions", version)]
struct Line {
    #[command(flatten)]
    options: Options,
    /// One scene [default: eight and terrain, a mesh under many bodies]
    #[arg(long)]
    scene: Option<String>,
    /// Objects
    #[arg(long, value_name = "N", requires = "scene")]
    n: Option<usize>,
    /// No scenes, but pairs of kinds whose names hold this, like cylinder-cone; "-" for all
    #[arg(long, conflicts_with = "scene")]
    kinds: Option<String>,
    #[command(flatten)]
    print: Print,
}

impl Line {
    fn is_terrain(&self) -> bool {
        self.scene.as_deref() == Some(TERRAIN.0)
    }

    /// How many bodies lie on the terrain, if it is measured.
    fn bodies(&self) -> Option<usize> {
        let (_, full, quick) = TERRAIN;
        let is_default = self.scene.is_none() && self.kinds.is_none();
        let usual = if self.options.quick { quick } else { full };
        (is_default || self.is_terrain()).then(|| self.n.unwrap_or(usual))
    }

    fn subjects(&self) -> Result<Vec<SceneSpec>> {
        let sized = |&(name, full, quick): &(&str, usize, usize)| (name.to_owned(), full, quick);
        if self.kinds.is_some() || self.is_terrain() {
            return Ok(Vec::new());
        }
        let chosen: Vec<_> = match &self.scene {
            None => SCENES.iter().map(sized).collect(),
            Some(name) => {
                let objects = self.n.unwrap_or(SceneSpec::parse(name)?.objects);
                vec![(name.clone(), objects, objects)]
            }
        };
        let specs = chosen.into_iter().map(|(name, full, quick)| {
            let objects = if self.options.quick { quick } else { full };
            Ok(SceneSpec::parse(&name)?.with_objects(objects).with_seed(self.options.seed))
        });
        specs.collect()
    }
}

fn main() -> ExitCode {
    exit_code(run(&Line::parse()))
}

fn run(line: &Line) -> Result<()> {
    let options = &line.options;
    let header = Header::observe(options);
    let dir = options.dir("questions");
    let specs = line.subjects()?;
    let crossed = match (&line.scene, &line.kinds) {
        (Some(_), _) => Vec::new(),
        (None, filter) => kinds::keys(filter.as_deref().unwrap_or("-")),
    };
    let key = |spec: &SceneSpec| format!("{}/N={}", spec.name(), spec.objects);
    let keys = specs.iter().map(key).chain(crossed.iter().map(|&kinds| kinds::name(kinds)));
    let of_terrain = line.bodies().map(|bodies| (bodies, format!("{}/N={bodies}", TERRAIN.0)));
    let keys = keys.chain(of_terrain.iter().map(|(_, key)| key.clone()));
    let mut units = Units::open(&dir, &header.fingerprint(), keys, options.start())?;
    let mut outcomes: Vec<Outcome> = Vec::new();
    for spec in &specs {
        let run = || run_scene((spec.name(), &draw(spec)?), Kind::MEASURED, options.effort());
        outcomes.push(units.run(&key(spec), run)?);
    }
    if let Some((bodies, key)) = &of_terrain {
        let scene = || dcd_scenes::terrain(*bodies, options.seed);
        let run = || run_scene((TERRAIN.0, &scene()?), Kind::TERRAIN, options.effort());
        outcomes.push(units.run(key, run)?);
    }
    let mut found: Vec<Cross> = Vec::new();
    for &pair in &crossed {
        let run = || run_kinds(pair, options.seed, options.effort());
        found.extend(units.run(&kinds::name(pair), run)?);
    }
    let mut report = show::report(header, &outcomes)?;
    kinds::report(&mut report, &found)?;
    report.hand_out(&dir, line.print)?;
    units.finish()?;
    let beyond: usize =
        outcomes.iter().flat_map(|o| &o.measurements).map(|measured| measured.beyond).sum();
    ensure!(beyond == 0, "{beyond} answers are beyond their bounds");
    Ok(())
}
