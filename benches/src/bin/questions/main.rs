//! Distance, depth and manifold of whole scenes at every accuracy, beside Parry's queries of the same pairs.
//!
//! No time is shown before the bounds are checked: the answers of a smaller accuracy have to be consistent with the
//! certified ones.

#![forbid(unsafe_code)]

mod contest;
mod kinds;
mod parry;
mod scattered;
mod show;
mod subject;

use std::process::ExitCode;

use anyhow::{Result, ensure};
use clap::Parser;
use dcd_benches::{Header, Options, Print, Units, exit_code};

use contest::{Outcome, run_scene};
use kinds::{Cross, run_kinds};
use subject::Subject;

/// How far, how deep and where of whole scenes, at every accuracy: our narrow phase beside Parry's queries of the same
/// candidate pairs, and our step beside Parry's, interleaved in one process, on one thread and on all that are asked for.
#[derive(Parser)]
#[command(name = "questions", version)]
struct Line {
    #[command(flatten)]
    options: Options,
    /// One scene [default: eleven; pile, hulls at rest on each other; terrain, a mesh under many bodies; and six
    /// of one kind of shape: capsules, cylinders, compounds, large-compounds, decompositions, meshes]
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
    /// What is measured, and a sentence for each scene that cannot be had.
    fn subjects(&self) -> Result<(Vec<Subject>, Vec<String>)> {
        Ok(match (&self.scene, &self.kinds) {
            (Some(name), _) => (vec![Subject::named(name, self.n, &self.options)?], Vec::new()),
            (None, Some(_)) => (Vec::new(), Vec::new()),
            (None, None) => Subject::all(&self.options),
        })
    }

    /// One, and how many there are.
    fn threads(&self) -> Vec<usize> {
        match self.options.threads() {
            1 => vec![1],
            more => vec![1, more],
        }
    }
}

fn main() -> ExitCode {
    exit_code(run(&Line::parse()))
}

fn run(line: &Line) -> Result<()> {
    let options = &line.options;
    let header = Header::observe(options);
    let dir = options.dir("questions");
    let (subjects, absent) = line.subjects()?;
    absent.iter().for_each(|note| eprintln!("{note}"));
    let crossed = match (&line.scene, &line.kinds) {
        (Some(_), _) => Vec::new(),
        (None, filter) => kinds::keys(filter.as_deref().unwrap_or("-")),
    };
    let of_kinds = crossed.iter().map(|&kinds| kinds::name(kinds));
    let keys = subjects.iter().map(Subject::key).chain(of_kinds);
    let mut units = Units::open(&dir, &header.fingerprint(), keys, options.start())?;
    let mut outcomes: Vec<Outcome> = Vec::new();
    for subject in &subjects {
        let run = || run_scene(subject, &line.threads(), options.effort());
        outcomes.push(units.run(&subject.key(), run)?);
    }
    let mut found: Vec<Cross> = Vec::new();
    for &pair in &crossed {
        let run = || run_kinds(pair, options.seed, options.effort());
        found.extend(units.run(&kinds::name(pair), run)?);
    }
    let mut report = show::report(header, &outcomes)?;
    absent.into_iter().for_each(|note| report.note(note));
    kinds::report(&mut report, &found)?;
    report.hand_out(&dir, line.print)?;
    units.finish()?;
    let beyond: usize =
        outcomes.iter().flat_map(|o| &o.measurements).map(|measured| measured.beyond).sum();
    ensure!(beyond == 0, "{beyond} answers are beyond their bounds");
    Ok(())
}
