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
mod worlds;

use std::process::ExitCode;

use anyhow::{Result, ensure};
use clap::{Parser, ValueEnum};
use dcd_benches::{Header, Options, Print, Units, exit_code};

use data::{Data, Geometry, Setting};

/// The Panda on the problems of MotionBenchMaker: states as spheres, hulls and meshes beside Parry in f64, straight edges
/// beside samples, grazing edges, clearances, certificates and worlds that change. Skips, and says so, where the data is absent.
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
    /// One part alone [default: all]
    #[arg(long, value_name = "PART")]
    only: Option<Part>,
    #[command(flatten)]
    print: Print,
}

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Part {
    States,
    Edges,
    Grazing,
    Clearance,
    Worlds,
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

/// The keys of what is measured once.
const GRAZING: &str = "grazing, hulls";
const CLEARANCE: &str = "clearance, hulls";
const WORLDS: &str = "worlds that change, hulls";

fn of_states(geometry: Geometry, threads: usize) -> String {
    format!("states, {}, {threads} threads", geometry.name())
}

fn of_edges(geometry: Geometry) -> String {
    format!("edges, {}", geometry.name())
}

/// All that is measured, with its keys.
fn plan(geometries: &[Geometry], threads: &[usize]) -> Vec<(Part, String)> {
    let mut plan = Vec::new();
    for &geometry in geometries {
        let states = threads.iter().map(|&threads| of_states(geometry, threads));
        plan.extend(states.map(|key| (Part::States, key)));
        plan.push((Part::Edges, of_edges(geometry)));
    }
    plan.push((Part::Grazing, GRAZING.to_owned()));
    plan.push((Part::Clearance, CLEARANCE.to_owned()));
    plan.push((Part::Worlds, WORLDS.to_owned()));
    plan
}

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
    let has = |part: Part| line.only.is_none_or(|only| only == part);
    let plan = plan(&geometries, &threads).into_iter().filter(|(part, _)| has(*part));
    let fingerprint = format!("{}, {} problems", header.fingerprint(), data.count());
    let mut units = Units::open(&dir, &fingerprint, plan.map(|(_, key)| key), options.start())?;
    let (mut states, mut edges) = (Vec::new(), Vec::new());
    for &geometry in geometries.iter().filter(|_| has(Part::States) || has(Part::Edges)) {
        let settings = data.settings(geometry)?;
        let some: Vec<&Setting> = settings.iter().step_by(amount.per_states).collect();
        for &threads in threads.iter().filter(|_| has(Part::States)) {
            let run = || states::run(geometry, &some, (threads, amount.rounds));
            states.push(units.run(&of_states(geometry, threads), run)?);
        }
        if has(Part::Edges) {
            let run = || edges::run(geometry, &settings, amount.edge_rounds);
            edges.push(units.run(&of_edges(geometry), run)?);
        }
    }
    let mut report = show::report(header, data.count());
    if has(Part::States) {
        show::states(&mut report, &states)?;
    }
    if has(Part::Edges) {
        show::edges(&mut report, &edges)?;
    }
    if has(Part::Grazing) {
        let found = units.run(GRAZING, || {
            let (robot, ends) = (data.robot(Geometry::Hulls)?, grazing::ends(&data)?);
            let amounts = (amount.grazing, amount.edge_rounds);
            grazing::run((&robot, data.allowed()), &ends, amounts, options.seed)
        })?;
        show::grazing(&mut report, &found)?;
    }
    if has(Part::Clearance) {
        let found = units.run(CLEARANCE, || {
            let [samples, edges] = amount.clearance;
            clearance::run(&data.settings(Geometry::Hulls)?, samples, edges)
        })?;
        show::clearance(&mut report, &found)?;
    }
    if has(Part::Worlds) {
        let found = units.run(WORLDS, || {
            let ends = data.ends()?;
            worlds::run((data.robot(Geometry::Hulls)?, data.allowed()), &ends, amount.rounds)
        })?;
        show::worlds(&mut report, &found)?;
    }
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
