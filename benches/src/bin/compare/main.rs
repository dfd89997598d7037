//! Our default pipeline beside Parry's best one: interleaved in one process, per stage and whole.
//!
//! No time is shown before the answers are judged: [`judge`] compares whole contact sets and has
//! exact arithmetic judge every difference; [`race`] takes turns; [`show`] makes the tables.

#![forbid(unsafe_code)]

mod json;
mod judge;
mod race;
mod rivals;
mod show;
mod subject;

use std::process::ExitCode;

use anyhow::{Result, bail};
use clap::Parser;
use dcd_benches::{Header, Options, Units};

use race::{Comparison, Course, ParryQuery};
use subject::Subject;

/// Our default pipeline and Parry's best one in f32, interleaved in one process: the median of the
/// ratios per stage and for the whole step.
///
/// Our contact set must equal that of Parry in f64, each difference judged by exact arithmetic:
/// a time for a wrong set is never shown, and the exit code is 1.
#[derive(Parser)]
#[command(name = "compare", version)]
struct Line {
    #[command(flatten)]
    options: Options,
    /// A scene by name, or a hull scene in a file; `all` is --all
    #[arg(long, value_name = "NAME|FILE|all", default_value = "paper", conflicts_with = "all")]
    scene: String,
    /// Objects of a named scene [default: what the scene has]
    #[arg(long, value_name = "N", conflicts_with = "all")]
    n: Option<usize>,
    /// Every named scene, at one thread and at two (or --threads)
    #[arg(long)]
    all: bool,
    /// Leaves out named scenes of more objects
    #[arg(long, value_name = "N")]
    n_max: Option<usize>,
    /// Which of Parry's queries decides whether a candidate touches
    #[arg(long, value_enum, default_value_t)]
    query: ParryQuery,
    /// Print one JSON object a line for each scene and number of threads, in place of tables
    #[arg(long)]
    json: bool,
}

fn main() -> ExitCode {
    match run(&Line::parse().with_all_by_name()) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

impl Line {
    /// `--scene all` says `--all`.
    fn with_all_by_name(self) -> Self {
        let all = self.all || (self.scene == subject::ALL && self.n.is_none());
        Self { all, ..self }
    }
}

fn run(line: &Line) -> Result<ExitCode> {
    let options = &line.options;
    let course =
        Course { query: line.query, threads: thread_counts(line), effort: options.effort() };
    let subjects = if line.all {
        subject::all(options.seed, options.effort())
    } else {
        vec![Subject::parse(&line.scene, line.n, options.seed)?]
    };
    let within = |subject: &Subject| line.n_max.is_none_or(|most| subject.objects() <= Some(most));
    let (subjects, left_out): (Vec<_>, Vec<_>) = subjects.into_iter().partition(within);

    let header = Header::observe(options);
    let dir = options.dir("compare");
    let keys: Vec<String> = subjects.iter().map(|subject| course.key(subject)).collect();
    let mut units =
        Units::open(&dir, &header.fingerprint(), keys.iter().cloned(), options.start())?;
    let mut comparisons: Vec<Comparison> = Vec::new();
    let mut failures = Vec::new();
    for (subject, key) in subjects.iter().zip(&keys) {
        match units.run(key, || race::compare(subject, &course)) {
            Ok(comparison) => comparisons.push(comparison),
            Err(error) => failures.push(format!("{error:#}")),
        }
    }

    if comparisons.is_empty() {
        bail!("{}", failures.join("\n"));
    }
    let mut report = show::report(header, &comparisons)?;
    report.missing(&units);
    for subject in &left_out {
        report.note(format!("{}: left out by --n-max.", subject.key()));
    }
    let pages = report.write(&dir)?;
    units.finish()?;
    if line.json {
        comparisons.iter().flat_map(json::objects).for_each(|object| println!("{object}"));
    } else {
        println!("{}", show::terminal(&comparisons)?);
        pages.iter().for_each(|page| println!("{}", page.display()));
    }
    let wrong = comparisons.iter().filter(|comparison| comparison.judged.ours.wrong() > 0);
    failures.extend(
        wrong.map(|comparison| format!("{}: our contact set is wrong", comparison.label())),
    );
    if !failures.is_empty() {
        bail!("{}", failures.join("\n"));
    }
    Ok(ExitCode::SUCCESS)
}

/// As requested; else one thread, and beside it all cores, or two where every scene is run.
fn thread_counts(line: &Line) -> Vec<usize> {
    let threads = line.options.threads.map(std::num::NonZeroUsize::get);
    match (threads, line.all) {
        (Some(threads), false) => vec![threads],
        (None, true) => vec![1, 2],
        _ => {
            let mut counts = vec![1, line.options.threads()];
            counts.dedup();
            counts
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_thread_stands_beside_all_unless_a_number_is_given() {
        let counts = |arguments: &[&str]| {
            let line = ["compare"].iter().chain(arguments);
            thread_counts(&Line::parse_from(line).with_all_by_name())
        };
        assert_eq!(counts(&["--threads", "3"]), [3]);
        assert_eq!(counts(&["--all"]), [1, 2]);
        assert_eq!(counts(&["--scene", "all"]), [1, 2]);
        assert_eq!(counts(&["--all", "--threads", "3"]), [1, 3]);
        assert_eq!(counts(&["--all", "--threads", "1"]), [1]);
        assert_eq!(counts(&[])[0], 1);
    }
}
