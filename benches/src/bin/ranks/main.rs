//! One scene over many ranks.
//!
//! [`spread`] runs the program under MPI at 1, 2, 4 and 8 ranks; [`speed`] sets two ranks beside two
//! threads; [`surface`] counts ghosts with ranks that are threads, beside a [`model`] of them; [`forecast`]
//! says by that model what thousands of ranks would take.

#![forbid(unsafe_code)]

mod forecast;
mod model;
mod program;
mod speed;
mod spread;
mod surface;

use std::process::ExitCode;

use anyhow::Result;
use clap::Parser;
use dcd_benches::{Header, Options, Print, Report, Units, exit_code};

use program::Program;

/// One scene over many ranks: objects, ghosts, bytes, balance and memory of each, two ranks beside two
/// threads, and a model of thousands. What runs under MPI needs mpirun; with --quick, or where it is absent,
/// ranks are threads alone.
#[derive(Parser)]
#[command(name = "ranks", version)]
struct Line {
    #[command(flatten)]
    options: Options,
    #[command(flatten)]
    print: Print,
}

fn main() -> ExitCode {
    exit_code(run(&Line::parse()))
}

fn run(line: &Line) -> Result<()> {
    let options = &line.options;
    let header = Header::observe(options);
    let dir = options.dir("ranks");
    let program = if options.quick { None } else { Program::build()? };
    let mut plan = surface::plan(options);
    if program.is_some() {
        plan.extend(spread::plan());
        plan.extend(speed::plan());
    }
    let mut units = Units::open(&dir, &header.fingerprint(), plan, options.start())?;
    surface::measure(options, &mut units)?;
    if let Some(program) = &program {
        spread::measure(program, options, &mut units)?;
        speed::measure(program, options, &mut units)?;
    }
    let mut report = Report::new("ranks", "One scene over many ranks", header);
    report.missing(&units);
    if program.is_none() {
        report.note(
            "Nothing was run under MPI: with `--quick` it is not built, and elsewhere `mpirun` and `mpicc` are absent.",
        );
    }
    spread::show(&units, &mut report)?;
    speed::show(&units, &mut report)?;
    let fitted = surface::show(options, &units, &mut report)?;
    if let Some((world, fitted)) = fitted {
        forecast::show(options, (world, fitted), &mut report)?;
    }
    report.hand_out(&dir, line.print)?;
    units.finish()?;
    Ok(())
}
