//! Replays the certificates of a file, as `dcd robot --edges … --certificate FILE` writes them, and prints a line for each edge.
//!
//! `cargo run --release -p dcd-judge --bin dcd-replay -- FILE`
#![forbid(unsafe_code)]

use dcd_judge::{Replay, Replayed};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Write, stdout};
use std::process::ExitCode;

const USAGE: &str = "dcd-replay FILE
prints for each edge of a certificate whether it is accepted, and why not
exit code 0 if there are edges and every one that is called free is proved, else 2";

fn main() -> ExitCode {
    let paths: Vec<_> = std::env::args_os().skip(1).collect();
    let [path] = &paths[..] else {
        eprintln!("{USAGE}");
        return ExitCode::from(2);
    };
    let replayed = File::open(path).and_then(|file| replay(BufReader::new(file)));
    match replayed {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(2),
        Err(error) => {
            eprintln!("{}: {error}", path.display());
            ExitCode::from(2)
        }
    }
}

/// Whether every line holds, and there is an edge among them.
fn replay(file: impl BufRead) -> io::Result<bool> {
    let mut out = stdout().lock();
    let (mut replay, mut all_hold, mut edges) = (Replay::default(), true, 0);
    for (number, line) in (1..).zip(file.lines()) {
        let replayed = replay.line(&line?);
        edges += usize::from(!matches!(replayed, Ok(Replayed::Cell { .. }) | Err(_)));
        match replayed {
            Ok(Replayed::Cell { robot, bodies, pairs }) => {
                writeln!(out, "robot {robot:?}: {bodies} bodies, {pairs} pairs to prove")?;
            }
            Ok(Replayed::NotFree { edge, answer }) => {
                writeln!(out, "edge {edge}: {answer:?}, nothing to prove")?;
            }
            Ok(Replayed::Accepted { edge, pairs, planes, intervals, clearance }) => writeln!(
                out,
                "edge {edge}: accepted, {pairs} pairs, {planes} planes, {intervals} intervals, \
                 at least {clearance:e} m apart"
            )?,
            Ok(Replayed::Refused { edge, why }) => {
                all_hold = false;
                writeln!(out, "edge {edge}: refused: {why}")?;
            }
            Err(error) => {
                all_hold = false;
                writeln!(out, "line {number}: {error}")?;
            }
        }
    }
    Ok(all_hold && edges > 0)
}
