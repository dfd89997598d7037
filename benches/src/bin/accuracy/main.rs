//! The trade of speed for accuracy: what each precision costs, and how often and how far it is wrong.
//!
//! [`subject`] holds pairs with their truth; [`precision`] answers; [`measure`] times the precisions
//! interleaved and counts what is wrong; [`show`] makes tables and pictures; [`tolerance`] simplifies hulls;
//! [`adversary`] is the long run between neighbouring floats, [`kinds`] its part for shapes of every kind.
//! The truth of the conformance suite is exact; that of a scene is the certified precision's, with the exact
//! judge on every pair that any other precision doubts.

#![forbid(unsafe_code)]

mod adversary;
mod kinds;
mod measure;
mod packets;
mod parry;
mod pictures;
mod precision;
mod show;
mod subject;
mod tally;
mod tolerance;

use std::process::ExitCode;

use anyhow::{Result, bail};
use clap::Parser;
use dcd_benches::{Header, Options, Print, Units, exit_code};

use measure::Measured;
use precision::Query;
use subject::{Recipe, Subject};

/// What each precision costs, and how often and how far it is wrong: nanoseconds a pair
/// beside wrong yes, wrong no, undecided, and the error of distance and depth against the truth.
///
/// A wrong or undecided answer of a certified precision makes the exit code 1.
#[derive(Parser)]
#[command(name = "accuracy", version)]
struct Line {
    #[command(flatten)]
    options: Options,
    /// In place of the report, judge so many answers at neighbouring floats; a stopped run goes on
    #[arg(long, value_name = "ANSWERS")]
    adversary: Option<u64>,
    #[command(flatten)]
    print: Print,
}

fn main() -> ExitCode {
    exit_code(run(&Line::parse()))
}

fn run(line: &Line) -> Result<()> {
    match line.adversary {
        Some(answers) => adversary::run(&line.options, answers, line.print),
        None => report(line),
    }
}

fn report(line: &Line) -> Result<()> {
    let options = &line.options;
    let (recipes, absent) = subject::recipes(options);
    let header = Header::observe(options);
    let dir = options.dir("accuracy");
    let key = |recipe: &Recipe, query: Query| format!("{}/{}", recipe.name(), query.name());
    let plan = recipes.iter().flat_map(|recipe| Query::ALL.map(|query| key(recipe, query)));
    let plan = plan.chain([tolerance::KEY.to_owned()]);
    let mut units = Units::open(&dir, &header.fingerprint(), plan, options.start())?;
    let mut found: Vec<Measured> = Vec::new();
    for recipe in &recipes {
        let mut subject = None;
        for query in Query::ALL {
            let measured = units.run(&key(recipe, query), || {
                let subject: &Subject = match &mut subject {
                    Some(made) => made,
                    none => none.insert(recipe.subject()?),
                };
                Ok(measure::measure(subject, query, options))
            })?;
            found.push(measured);
        }
    }

    let coarse = units.run(tolerance::KEY, || tolerance::measure(options))?;

    let mut report = show::report(header, &found)?;
    tolerance::show(&coarse, &mut report)?;
    absent.iter().for_each(|note| report.note(note));
    report.missing(&units);
    report.hand_out(&dir, line.print)?;
    units.finish()?;
    let mut broken: Vec<String> = found.iter().flat_map(Measured::broken_promises).collect();
    broken.extend(coarse.iter().filter_map(tolerance::Coarse::broken_promise));
    if !broken.is_empty() {
        bail!("{}", broken.join("\n"));
    }
    Ok(())
}
