//! A batch of a robot's configurations against static obstacles: ours beside Parry's.
//!
//! No time is shown before the answers are judged: [`setting`] has every hit that only one of us reports
//! judged by exact integers.

#![forbid(unsafe_code)]

mod setting;
mod show;

use std::process::ExitCode;

use anyhow::{Result, bail};
use clap::Parser;
use dcd_benches::{Header, Options, Print, Units, exit_code};
use dcd_exec::{Par, with_threads};
use dcd_parry::Until;

use setting::{Outcome, Setting, Size};

/// Configurations of ten hulls against random obstacles of several densities, the first hit of each and
/// all hits: our answers and times beside those of Parry in f32, interleaved in one process.
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

/// How many obstacles in a cube of which half-width, metres; from crowded to all but empty.
const SIZES: [Size; 6] = [
    Size { obstacles: 100, half_width: 2.5 },
    Size { obstacles: 100, half_width: 4.0 },
    Size { obstacles: 100, half_width: 8.0 },
    Size { obstacles: 100, half_width: 16.0 },
    Size { obstacles: 1000, half_width: 8.0 },
    Size { obstacles: 1000, half_width: 16.0 },
];

/// A setting and its query.
#[derive(Clone, Copy)]
struct Case {
    size: Size,
    until: Until,
    threads: usize,
}

impl Case {
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
    let cases = cases(options.threads());
    let fingerprint = format!("{}, {configurations} configurations", header.fingerprint());
    let plan = cases.iter().map(Case::key);
    let mut units = Units::open(&dir, &fingerprint, plan, options.start())?;
    let mut setting: Option<Setting> = None;
    let mut outcomes: Vec<(Case, Outcome)> = Vec::new();
    for case in cases {
        let outcome = units.run(&case.key(), || {
            let setting = match &setting {
                Some(setting) if setting.size == case.size => setting,
                _ => setting.insert(Setting::new(case.size, configurations, options.seed)?),
            };
            let par = if case.threads == 1 { Par::Serial } else { Par::WarmPool };
            let race = || setting.race(case.until, par, options.effort());
            with_threads(case.threads, race)
                .map_err(|error| anyhow::anyhow!("{} threads: {error}", case.threads))?
        })?;
        outcomes.push((case, outcome));
    }
    let report = show::report(header, configurations, &outcomes)?;
    report.hand_out(&dir, line.print)?;
    units.finish()?;
    if outcomes.iter().any(|(_, outcome)| outcome.ours_wrong > 0) {
        bail!("some of our answers are wrong");
    }
    Ok(())
}

/// Every size, first hit and all, on one thread and on so many.
fn cases(threads: usize) -> Vec<Case> {
    let mut counts = vec![1, threads];
    counts.dedup();
    let mut cases = Vec::new();
    for size in SIZES {
        for until in [Until::First, Until::Last] {
            cases.extend(counts.iter().map(|&threads| Case { size, until, threads }));
        }
    }
    cases
}
