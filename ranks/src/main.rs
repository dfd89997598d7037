//! The program `dcd-mpi`: what `dcd detect` does, over many processes.
#![forbid(unsafe_code)]

mod detect;
mod memory;
mod output;
mod source;
mod summary;

use clap::{Parser, Subcommand};
use dcd_mpi::Mpi;
use dcd_ranks::Transport;
use std::process::ExitCode;

/// Finds touching pairs of convex shapes over many processes, provably and repeatably: to be started by mpirun.
#[derive(Parser)]
#[command(name = "dcd-mpi", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Detect(detect::Detect),
}

fn main() -> ExitCode {
    let Some(mpi) = Mpi::start() else {
        eprintln!("dcd-mpi: MPI could not be started");
        return ExitCode::from(2);
    };
    // One of them speaks.
    let speaks = mpi.rank() == 0;
    let Command::Detect(detect) = match Cli::try_parse() {
        Ok(cli) => cli.command,
        Err(refused) => {
            if speaks {
                let _ = refused.print();
            }
            return ExitCode::from(refused.exit_code() as u8);
        }
    };
    match detect.run(&mpi) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if speaks {
                eprintln!("dcd-mpi: {}", failure.message);
            }
            ExitCode::from(failure.code)
        }
    }
}
