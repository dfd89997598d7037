//! A batch of a robot's configurations against obstacles that stand still: ours beside Parry's.
//!
//! No time is shown before the answers are judged: [`room`] has every hit that only one of us tells
//! settled by exact integers.

#![forbid(unsafe_code)]

mod room;
mod show;

use std::process::ExitCode;

use anyhow::{Result, bail};
use clap::Parser;
use dcd_benches::{Header, Options, Print, Units, exit_code};
use dcd_exec::{Par, with_threads};
use dcd_parry::Until;

use room::{Outcome, Room, Size};

/// Configurations of ten hulls against obstacles at random in rooms of several densities, the first
/// hit of each and all hits: our answers and times beside those of Parry in f32, in turn in one
/// process.
#[derive(Parser)]
#[command(name = "batch", version)]
struct Line {
    #[command(flatten)]
    options: Options,
    /// Configurations [default: 10,000; 1,000 with --quick]
    #[arg(long, value_name = "N")]
    n: Option<usize>,
    #[command(flatten)]
    print: Print,
}

/// The rooms: how many obstacles in a cube of which half-width, metres; from crowded to all but
/// empty.
const ROOMS: [Size; 6] = [
    Size { obstacles: 100, half_width: 2.5 },
    Size { obstacles: 100, half_width: 4.0 },
    Size { obstacles: 100, half_width: 8.0 },
    Size { obstacles: 100, half_width: 16.0 },
    Size { obstacles: 1000, half_width: 8.0 },
    Size { obstacles: 1000, half_width: 16.0 },
];

/// A question to a room.
#[derive(Clone, Copy)]
struct Ask {
    size: Size,
    until: Until,
    threads: usize,
}

impl Ask {
    fn key(&self) -> String {
        let Self { size, until, threads } = self;
        let Size { obstacles, half_width } = size;
        format!("{obstacles} obstacles in {half_width} m, {until:?} hit, {threads} threads")
    }
}

fn main() -> ExitCode {
    exit_code(run(&Line::parse()))
}

fn run(line: &Line) -> Result<()> {
    let options = &line.options;
    let configurations = line.n.unwrap_or(if options.quick { 1_000 } else { 10_000 });
    let header = Header::observe(options);
    let dir = options.dir("batch");
    let asks = asks(options.threads());
    let fingerprint = format!("{}, {configurations} configurations", header.fingerprint());
    let plan = asks.iter().map(Ask::key);
    let mut units = Units::open(&dir, &fingerprint, plan, options.start())?;
    let mut room: Option<Room> = None;
    let mut outcomes: Vec<(Ask, Outcome)> = Vec::new();
    for ask in asks {
        let outcome = units.run(&ask.key(), || {
            let room = match &room {
                Some(room) if room.size == ask.size => room,
                _ => room.insert(Room::new(ask.size, configurations, options.seed)?),
            };
            let par = if ask.threads == 1 { Par::Serial } else { Par::WarmPool };
            let race = || room.race(ask.until, par, options.effort());
            with_threads(ask.threads, race)
                .map_err(|error| anyhow::anyhow!("{} threads: {error}", ask.threads))?
        })?;
        outcomes.push((ask, outcome));
    }
    let report = show::report(header, configurations, &outcomes)?;
    report.hand_out(&dir, line.print)?;
    units.finish()?;
    if outcomes.iter().any(|(_, outcome)| outcome.ours_wrong > 0) {
        bail!("some of our answers are wrong");
    }
    Ok(())
}

/// Every room, first hit and all, on one thread and on so many.
fn asks(threads: usize) -> Vec<Ask> {
    let mut counts = vec![1, threads];
    counts.dedup();
    let mut asks = Vec::new();
    for size in ROOMS {
        for until in [Until::First, Until::Last] {
            asks.extend(counts.iter().map(|&threads| Ask { size, until, threads }));
        }
    }
    asks
}
