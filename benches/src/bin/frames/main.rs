//! Frames that barely differ: what is remembered from one to the next, and what that saves.
//!
//! No time is shown before the answers are judged: in every frame [`course`] holds the contacts of
//! the pipeline that remembers, their order included, equal to those of the one that does not.

#![forbid(unsafe_code)]

mod course;
mod show;

use std::process::ExitCode;

use anyhow::Result;
use clap::Parser;
use dcd_benches::{Effort, Header, Options, Print, Units, exit_code};

use course::{Course, Motion, Outcome};

/// Scenes whose objects walk at random or fall, frame by frame on one thread: the default pipeline, the
/// one that remembers proofs, and Parry's in f32 with its tree refitted, interleaved in one process.
#[derive(Parser)]
#[command(name = "frames", version)]
struct Line {
    #[command(flatten)]
    options: Options,
    #[command(flatten)]
    print: Print,
}

/// The scenes that walk, their objects, and those of a quick run.
const SCENES: [(&str, usize, usize); 2] = [("paper", 10_000, 500), ("sparse", 100_000, 2_000)];

/// Standard deviations of a step along and about each axis, metres and rad: from rest on.
const SIGMAS: [f64; 5] = [0.0, 1e-4, 1e-3, 3e-3, 1e-2];

/// Hulls in the pile, and in that of a quick run.
const PILE: (usize, usize) = (2_000, 200);

fn main() -> ExitCode {
    exit_code(run(&Line::parse()))
}

fn run(line: &Line) -> Result<()> {
    let options = &line.options;
    let quick = options.effort() == Effort::Quick;
    let header = Header::observe(options);
    let dir = options.dir("frames");
    let objects = |(full, few)| if quick { few } else { full };
    let walks = SCENES.into_iter().flat_map(|(scene, full, few)| {
        SIGMAS.map(|sigma| (scene, objects((full, few)), Motion::Walk(sigma)))
    });
    let courses: Vec<Course> = walks
        .chain([("pile", objects(PILE), Motion::Settle)])
        .map(|(scene, objects, motion)| Course { scene, objects, motion, seed: options.seed })
        .collect();
    let plan = courses.iter().map(Course::key);
    let mut units = Units::open(&dir, &header.fingerprint(), plan, options.start())?;
    let mut outcomes: Vec<Outcome> = Vec::new();
    for course in &courses {
        outcomes.push(units.run(&course.key(), || course.run(options.effort()))?);
    }
    let report = show::report(header, &outcomes)?;
    report.hand_out(&dir, line.print)?;
    units.finish()?;
    Ok(())
}
