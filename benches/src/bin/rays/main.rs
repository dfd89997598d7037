//! Rays, nearest points and moving shapes beside Parry's: answers compared, then times, interleaved.

#![forbid(unsafe_code)]

mod contest;
mod parry;
mod show;

use std::process::ExitCode;

use anyhow::{Result, bail};
use clap::Parser;
use dcd_benches::{Header, Options, Print, Units, exit_code};

use contest::{Outcome, Work};

/// Rays against 10,000 hulls and against a mesh, nearest objects, shape casts and times of impact, on one thread:
/// our answers and times beside those of Parry in f32 and f64, interleaved in one process.
#[derive(Parser)]
#[command(name = "rays", version)]
struct Line {
    #[command(flatten)]
    options: Options,
    /// Rays and points [default: 10,000; 1,000 with --quick]
    #[arg(long, value_name = "N")]
    n: Option<usize>,
    /// Hulls [default: 10,000; 1,000 with --quick]
    #[arg(long, value_name = "N")]
    objects: Option<usize>,
    #[command(flatten)]
    print: Print,
}

fn main() -> ExitCode {
    exit_code(run(&Line::parse()))
}

fn run(line: &Line) -> Result<()> {
    let options = &line.options;
    let default = if options.quick { 1_000 } else { 10_000 };
    let (count, objects) = (line.n.unwrap_or(default), line.objects.unwrap_or(default));
    let header = Header::observe(options);
    let dir = options.dir("rays");
    let key = format!("{count} of {objects}");
    let mut units = Units::open(&dir, &header.fingerprint(), [key.clone()], options.start())?;
    let outcome: Outcome =
        units.run(&key, || Work::new(options.seed, [count, objects])?.run(options.effort()))?;
    let report = show::report(header, &outcome)?;
    report.hand_out(&dir, line.print)?;
    units.finish()?;
    let wrong: usize = outcome.rows.iter().map(|row| row.wrong).sum();
    if wrong > 0 {
        bail!("{wrong} of our answers contradict Parry's in f64 beyond any rounding");
    }
    Ok(())
}
