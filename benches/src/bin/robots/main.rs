//! A robot's states and edges on real problems: beside Parry in f64, and beside samples.
//!
//! Where an answer contradicts another (first hits and all hits, two batches, an edge and its samples, a certificate and the
//! judge) the run fails.

#![forbid(unsafe_code)]

mod clearance;
mod data;
mod edges;
mod grazing;
mod show;
mod states;

use std::process::ExitCode;

use anyhow::{Result, ensure};
use clap::Parser;
use dcd_benches::{Header, Options, Print, Units, exit_code};

use data::{Data, Geometry, Setting};

/// The Panda on the problems of MotionBenchMaker: states as spheres, hulls and meshes beside Parry in f64, straight edges
/// beside samples, grazing edges, clearances and certificates. Skips, and says so, where the data is absent.
#[derive(Parser)]
#[command(name = "robots", version)]
struct Line {
    #[command(flatten)]
    options: Options,
    /// Every so many problems [default: 1; 10 with --quick]
    #[arg(long, value_name = "N")]
    every: Option<usize>,
    /// The links as these alone [default: spheres, hulls and meshes]
    #[arg(long, value_name = "LINKS")]
    links: Option<Geometry>,
    #[command(flatten)]
    print: Print,
}

/// How much is measured.
struct Amount {
    /// Passes over the problems, and how many there are for one whose states are checked.
    rounds: usize,
    per_states: usize,
    /// Checks of an edge.
    edge_rounds: usize,
    /// Edges at each gap.
    grazing: usize,
    /// Samples of an edge, and edges.
    clearance: [usize; 2],
}

const FULL: Amount =
    Amount { rounds: 5, per_states: 1, edge_rounds: 5, grazing: 40, clearance: [100_000, 100] };
const QUICK: Amount =
    Amount { rounds: 1, per_states: 7, edge_rounds: 1, grazing: 2, clearance: [200, 2] };

fn main() -> ExitCode {
    exit_code(run(&Line::parse()))
}

fn run(line: &Line) -> Result<()> {
    let options = &line.options;
    let every = line.every.unwrap_or(if options.quick { 10 } else { 1 });
    let amount = if options.quick { QUICK } else { FULL };
    let data = match Data::load(every)? {
        Ok(data) => data,
        Err(file) => {
            println!("skipped: {file} is not there");
            return Ok(());
        }
    };
    let geometries: Vec<Geometry> = line.links.map_or(Geometry::ALL.to_vec(), |links| vec![links]);
    let mut threads = vec![1, options.threads()];
    threads.dedup();
    let header = Header::observe(options);
    let dir = options.dir("robots");
    let of_states = |geometry: Geometry, threads: usize| {
        format!("states, {}, {threads} threads", geometry.name())
    };
    let of_edges = |geometry: Geometry| format!("edges, {}", geometry.name());
    let all = geometries.iter().flat_map(|&geometry| {
        let states = threads.iter().map(move |&threads| of_states(geometry, threads));
        states.chain([of_edges(geometry)]).collect::<Vec<_>>()
    });
    let plan = all.chain(["grazing", "clearance"].map(str::to_owned));
    let fingerprint = format!("{}, {} problems", header.fingerprint(), data.count());
    let mut units = Units::open(&dir, &fingerprint, plan, options.start())?;
    let (mut states, mut edges) = (Vec::new(), Vec::new());
    for &geometry in &geometries {
        let settings = data.settings(geometry)?;
        let some: Vec<&Setting> = settings.iter().step_by(amount.per_states).collect();
        for &threads in &threads {
            let run = || states::run(geometry, &some, (threads, amount.rounds));
            states.push(units.run(&of_states(geometry, threads), run)?);
        }
        let run = || edges::run(geometry, &settings, amount.edge_rounds);
        edges.push(units.run(&of_edges(geometry), run)?);
    }
    let grazing = units.run("grazing", || {
        let (robot, ends) = (data.robot(Geometry::Hulls)?, grazing::ends(&data)?);
        let rounds = (amount.grazing, amount.edge_rounds);
        grazing::run((&robot, data.allowed()), &ends, rounds, options.seed)
    })?;
    let clearance = units.run("clearance", || {
        let [samples, edges] = amount.clearance;
        clearance::run(&data.settings(Geometry::Hulls)?, samples, edges)
    })?;
    let mut report = show::report(header, data.count());
    show::states(&mut report, &states)?;
    show::edges(&mut report, &edges)?;
    show::grazing(&mut report, &grazing)?;
    show::clearance(&mut report, &clearance)?;
    report.hand_out(&dir, line.print)?;
    units.finish()?;
    for outcome in &edges {
        let refused = &outcome.certificates.refused;
        ensure!(
            refused.is_empty(),
            "{}: {} certificates refused, first: {}",
            outcome.geometry,
            refused.len(),
            refused[0]
        );
    }
    Ok(())
}
