//! A robot's mesh in many poses against that of its surroundings: ours beside Parry's.
//!
//! No time is shown before the answers are judged: [`contest`] runs everyone, and has every pose on which
//! two differ judged by exact integers on every pair of triangles near each other.

#![forbid(unsafe_code)]

mod contest;
mod show;

use std::process::ExitCode;

use anyhow::{Result, bail};
use clap::Parser;
use dcd_benches::{Header, Options, Print, Units, exit_code};
use dcd_io::data;

use contest::{Contest, Outcome};

/// Where the meshes are in the data folder: the surroundings and what moves in them.
const FILES: [&str; 2] = ["meshes/env.obj", "meshes/rob.obj"];

/// Two triangle meshes in seeded poses, yes or no, on one thread: our answers and times beside
/// those of Parry's triangle meshes in f32 and f64, interleaved in one process.
#[derive(Parser)]
#[command(name = "meshes", version)]
struct Line {
    #[command(flatten)]
    options: Options,
    /// Poses [default: 10,000; 500 with --quick]
    #[arg(long, value_name = "N")]
    n: Option<usize>,
    #[command(flatten)]
    print: Print,
}

fn main() -> ExitCode {
    exit_code(run(&Line::parse()))
}

fn run(line: &Line) -> Result<()> {
    let options = &line.options;
    let [Some(fixed), Some(moving)] = FILES.map(data::file) else {
        eprintln!("skipped: the data folder has no {}", FILES.join(" and "));
        return Ok(());
    };
    let count = line.n.unwrap_or(if options.quick { 500 } else { 10_000 });
    let header = Header::observe(options);
    let dir = options.dir("meshes");
    let key = format!("{count} poses");
    let mut units = Units::open(&dir, &header.fingerprint(), [key.clone()], options.start())?;
    let outcome: Outcome = units.run(&key, || {
        Contest::new([&fixed, &moving], options.seed, count)?.run(options.effort())
    })?;
    let report = show::report(header, &outcome)?;
    report.hand_out(&dir, line.print)?;
    units.finish()?;
    if outcome.ours.wrong > 0 {
        bail!("{} of our answers are wrong", outcome.ours.wrong);
    }
    Ok(())
}
