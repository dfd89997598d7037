//! The command-line options that all measuring binaries have.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::thread;

use dcd_simd::Path as SimdPath;

use crate::resume::Start;
use crate::timing::Effort;

/// The options that all measuring binaries have; a binary flattens them into its own.
// Without its own `about`, the comment above would stand in the help of the binary.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(about = None, long_about = None)]
pub struct Options {
    /// Smaller scenes and fewer repetitions: done within a minute
    #[arg(long)]
    pub quick: bool,
    /// Threads of the parallel runs [default: one for each core]
    #[arg(long, value_name = "T")]
    pub threads: Option<NonZeroUsize>,
    /// Seed of the scenes
    #[arg(long, value_name = "SEED", default_value_t = 0)]
    pub seed: u64,
    /// Measure everything anew, even what a stopped run of this build has finished
    #[arg(long)]
    pub fresh: bool,
    /// Run our kernels on this instruction set, avx512, avx2 or portable [default: the widest of this CPU]
    #[arg(long, value_name = "PATH", value_parser = force_path)]
    pub simd: Option<SimdPath>,
    /// Where the results go [default: target/dcd/NAME in the workspace]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

impl Options {
    /// How often a run is repeated.
    #[must_use]
    pub fn effort(&self) -> Effort {
        if self.quick { Effort::Quick } else { Effort::Full }
    }

    /// Whether what a stopped run has left counts.
    #[must_use]
    pub fn start(&self) -> Start {
        if self.fresh { Start::Anew } else { Start::Resume }
    }

    /// The number of threads of the parallel runs: as requested, else the cores of the machine.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.threads.map_or_else(cores, NonZeroUsize::get)
    }

    /// The folder for the results of the binary `name`.
    #[must_use]
    pub fn dir(&self, name: &str) -> PathBuf {
        self.out.clone().unwrap_or_else(|| workspace().join("target").join("dcd").join(name))
    }
}

/// What is printed of a report; a binary flattens it into its own options.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
#[command(about = None, long_about = None)]
pub struct Print {
    /// Print the whole as JSON, in place of the tables
    #[arg(long)]
    pub json: bool,
}

/// The path of that name, which the whole process runs on from here.
fn force_path(name: &str) -> Result<SimdPath, String> {
    let path: SimdPath = name.parse()?;
    path.force().map_err(|error| error.to_string())?;
    Ok(path)
}

/// What a binary ends with; an error is printed with all its causes.
#[must_use]
pub fn exit_code(result: anyhow::Result<()>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// Cores that the system lets this process use (hardware threads count), 1 if it does not say.
pub(crate) fn cores() -> usize {
    thread::available_parallelism().map_or(1, NonZeroUsize::get)
}

/// The root of the workspace that this package was built in.
pub(crate) fn workspace() -> &'static Path {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.parent().unwrap_or(package)
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        options: Options,
    }

    #[test]
    fn a_bare_command_line_means_a_full_run_on_all_cores_that_resumes() {
        let options = Line::parse_from(["bench"]).options;
        assert_eq!(options.effort(), Effort::Full);
        assert_eq!(options.start(), Start::Resume);
        assert_eq!(options.threads(), cores());
        assert!(options.dir("bench").ends_with("target/dcd/bench"));
    }

    #[test]
    fn zero_threads_are_refused() {
        assert!(Line::try_parse_from(["bench", "--threads", "0"]).is_err());
    }
}
