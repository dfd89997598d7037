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

use contest::{Outcome, run_scene};
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

/// How far, how deep and where of whole scenes, at every accuracy: our narrow phase beside Parry's queries of the same
/// candidate pairs, and our step beside Parry's, interleaved in one process, on one thread.
#[derive(Parser)]
#[command(name = "questions", version)]
struct Line {
    #[command(flatten)]
    options: Options,
    /// One scene [default: eight]
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
    fn subjects(&self) -> Result<Vec<SceneSpec>> {
        let sized = |&(name, full, quick): &(&str, usize, usize)| (name.to_owned(), full, quick);
        if self.kinds.is_some() {
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
    let mut units = Units::open(&dir, &header.fingerprint(), keys, options.start())?;
    let mut outcomes: Vec<Outcome> = Vec::new();
    for spec in &specs {
        outcomes.push(units.run(&key(spec), || run_scene(spec, &draw(spec)?, options.effort()))?);
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
