//! How the step scales: with threads, with workers that are not here, and with objects.
//!
//! [`threads`] measures; [`span`] records tasks on one thread and schedules them on many;
//! [`growth`] takes time and memory for each object; [`order`] what the fixed order costs;
//! [`limit`] what no step can do without.

#![forbid(unsafe_code)]

mod growth;
mod limit;
mod order;
mod record;
mod runner;
mod schedule;
mod span;
mod threads;

use std::process::ExitCode;

use anyhow::Result;
use clap::Parser;
use dcd_benches::{Header, Options, Print, Report, Units, exit_code};

use runner::Case;

/// How our default step scales: threads from one to all cores, tasks recorded on one thread and
/// scheduled on up to 128 workers, time and memory for each object, what the fixed order costs, and
/// how far the limit is.
#[derive(Parser)]
#[command(name = "scale", version)]
struct Line {
    #[command(flatten)]
    options: Options,
    /// No scene of more objects (boxes in the broad phase alone: ten times as many) [default:
    /// 1,000,000; 10,000 with --quick]
    #[arg(long, value_name = "N")]
    n_max: Option<usize>,
    #[command(flatten)]
    print: Print,
}

fn main() -> ExitCode {
    exit_code(run(&Line::parse()))
}

fn run(line: &Line) -> Result<()> {
    let options = &line.options;
    let most = line.n_max.unwrap_or(if options.quick { 10_000 } else { 1_000_000 });
    let (paper, sparse) = if options.quick { (2_000, 10_000) } else { (10_000, 100_000) };
    let cases = [("paper", paper), ("sparse", sparse)]
        .map(|(name, objects)| Case::new(name, objects.min(most), options.seed));
    let cases = cases.into_iter().collect::<Result<Vec<Case>>>()?;

    let header = Header::observe(options);
    let dir = options.dir("scale");
    let mut plan = growth::plan(most);
    plan.extend(
        [threads::plan(&cases), span::plan(&cases), order::plan(&cases), limit::plan(&cases)]
            .concat(),
    );
    let run = format!("{}n_max={most}", header.fingerprint());
    let mut units = Units::open(&dir, &run, plan, options.start())?;
    for case in &cases {
        threads::measure(case, options, &mut units)?;
        span::measure(case, options, &mut units)?;
        order::measure(case, options, &mut units)?;
        limit::measure(case, options, &mut units)?;
    }
    growth::measure(most, options, &mut units)?;

    let mut report = Report::new("scale", "How the step scales", header);
    report.missing(&units);
    threads::show(&cases, &units, &mut report)?;
    span::show(&cases, &units, &mut report)?;
    order::show(&cases, &units, &mut report)?;
    limit::show(&cases, &units, &mut report)?;
    growth::show(most, &units, &mut report)?;
    report.hand_out(&dir, line.print)?;
    units.finish()?;
    Ok(())
}

/// How often rivals take turns: an odd number, so that the median is one of the rounds.
fn rounds(options: &Options) -> u32 {
    if options.quick { 3 } else { 9 }
}
