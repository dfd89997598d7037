//! The command `dcd`: touching pairs of a scene, and answers on single pairs, from files.
//!
//! It reads, calls the libraries and prints. Deliberately absent: any solver, any tolerance, any
//! seeded scene of its own.
//!
//! The whole program is this library, which compiles as soon as the signatures of what it calls are known; the binary
//! `dcd` only calls [`run`]. A program waits for the last instruction of every crate before it is compiled at all.
#![forbid(unsafe_code)]

mod capture;
mod count;
mod detect;
mod failure;
mod making;
mod memory;
mod output;
mod pairs;
mod precision;
mod progress;
mod quiet;
mod reported;
mod robot;
mod stepper;

use clap::{Parser, Subcommand};
use dcd_simd::Path;
use std::process::ExitCode;

const EXIT_CODES: &str = "\
Exit codes: 0 done; 2 bad input or usage, with the index and the value on standard error, or more \
of something than memory can hold, with an estimate; 1 an answer could not be written.

A file that is written appears whole or not at all, also where the run is interrupted; it must be \
none of the inputs and none of the other outputs. Text may begin with a byte order mark.";

/// Finds touching pairs of convex shapes, provably and repeatably.
#[derive(Parser)]
#[command(name = "dcd", version, after_help = EXIT_CODES)]
struct Cli {
    /// Run the kernels on this instruction set, avx512, avx2 or portable [default: the widest of this CPU]
    #[arg(long, value_name = "PATH", global = true, value_parser = force_path)]
    simd: Option<Path>,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Capture(capture::Capture),
    Detect(detect::Detect),
    Pairs(pairs::Pairs),
    Robot(robot::Robot),
}

/// The path of that name, which the whole process runs on from here.
fn force_path(name: &str) -> Result<Path, String> {
    let path: Path = name.parse()?;
    path.force().map_err(|error| error.to_string())?;
    Ok(path)
}

/// Reads the command line, does what it says and reports what went wrong on standard error.
pub fn run() -> ExitCode {
    quiet::about_parry();
    let Cli { command, .. } = Cli::parse();
    let done = match command {
        Command::Capture(capture) => capture.run(),
        Command::Detect(detect) => detect.run(),
        Command::Pairs(pairs) => pairs.run(),
        Command::Robot(robot) => robot.run(),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
