//! The command `cargo xtask`.
#![forbid(unsafe_code)]

use std::ffi::OsString;
use std::process::ExitCode;

use anyhow::Result;
use clap::{Args, Parser, Subcommand};
use xtask::{ci, measure, results};

/// Builds and runs what measures and checks this workspace.
///
/// The measuring commands build one binary of `benches/` in release and hand all their arguments on
/// to it: `cargo xtask bench --help` shows what it takes. Results go to `target/dcd/NAME/`.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version)]
struct Line {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// The paper's tables and figures, ours beside the published ones [--quick for a minute's run]
    #[command(disable_help_flag = true)]
    Bench(PassedOn),
    /// Our default pipeline beside Parry's best, interleaved in one process: ratios per stage and whole
    #[command(disable_help_flag = true)]
    Compare(PassedOn),
    /// Triangle meshes in many poses beside Parry's: answers judged, ratios of times
    #[command(disable_help_flag = true)]
    Meshes(PassedOn),
    /// Rays, nearest objects and moving shapes beside Parry's: answers compared, ratios of times
    #[command(disable_help_flag = true)]
    Rays(PassedOn),
    /// Batches of a robot's configurations against obstacles that stand still, beside Parry's
    #[command(disable_help_flag = true)]
    Batch(PassedOn),
    /// Scenes that walk, frame by frame: what remembering proofs saves, beside Parry's refitted tree
    #[command(disable_help_flag = true)]
    Frames(PassedOn),
    /// What each method of precision costs, and how often and how far it is wrong
    #[command(disable_help_flag = true)]
    Accuracy(PassedOn),
    /// Distance, depth and manifold at every accuracy, beside Parry's queries of the same pairs
    #[command(disable_help_flag = true)]
    Questions(PassedOn),
    /// One scene over many ranks: objects, ghosts, bytes and balance of each, two ranks beside two threads
    #[command(disable_help_flag = true)]
    Ranks(PassedOn),
    /// The Panda on 700 problems: states and edges, beside Parry and beside sampling [skips where the data is absent]
    #[command(disable_help_flag = true)]
    Robots(PassedOn),
    /// How the step scales with threads and with the number of objects
    #[command(disable_help_flag = true)]
    Scale(PassedOn),
    /// Takes what was measured in full into docs/results, and fills the tables of the documents
    Results,
    /// All checks in order, up to the first that fails: format, dependency policy, clippy, docs,
    /// every example, quick runs of the measuring binaries. The tests are `cargo test --workspace`
    Ci,
}

#[derive(Args)]
struct PassedOn {
    /// Handed on to the measuring binary as they are
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "ARGUMENTS")]
    arguments: Vec<OsString>,
}

fn main() -> ExitCode {
    match run(Line::parse().task) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// The exit code is that of the measuring binary, so that a script sees what it saw.
fn run(task: Task) -> Result<ExitCode> {
    match task {
        Task::Bench(passed) => measure::run("bench", &passed.arguments),
        Task::Compare(passed) => measure::run("compare", &passed.arguments),
        Task::Rays(passed) => measure::run("rays", &passed.arguments),
        Task::Meshes(passed) => measure::run("meshes", &passed.arguments),
        Task::Batch(passed) => measure::run("batch", &passed.arguments),
        Task::Frames(passed) => measure::run("frames", &passed.arguments),
        Task::Accuracy(passed) => measure::run("accuracy", &passed.arguments),
        Task::Questions(passed) => measure::run("questions", &passed.arguments),
        Task::Ranks(passed) => measure::run("ranks", &passed.arguments),
        Task::Robots(passed) => measure::run("robots", &passed.arguments),
        Task::Scale(passed) => measure::run("scale", &passed.arguments),
        Task::Results => results::take_in().map(|()| ExitCode::SUCCESS),
        Task::Ci => ci::run().map(|()| ExitCode::SUCCESS),
    }
}
