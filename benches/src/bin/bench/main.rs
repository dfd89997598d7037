//! The paper, reproduced: its tables and figures, ours beside the published ones; that every way
//! finds one contact set; and what its text and its code disagree on, measured.
//!
//! Each part plans its units, measures those that are missing and draws what is there. Deliberately
//! absent: how a time is taken and how a report looks, which the library decides for every binary.
#![forbid(unsafe_code)]

mod case;
mod claims;
mod every_pair;
mod published;
mod runtimes;
mod sets;
mod survivors;
mod table1;
mod table2;
mod variant;

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use anyhow::{Result, anyhow, ensure};
use clap::{Parser, ValueEnum};
use dcd_benches::{Header, Options, Report, Units};

use case::{Cases, Setting};

/// The paper's tables and figures, ours beside the published ones.
#[derive(Parser)]
#[command(name = "bench")]
struct Line {
    #[command(flatten)]
    options: Options,
    /// Only these parts, separated by commas; they get a folder of results of their own
    #[arg(long, value_name = "PARTS", value_delimiter = ',')]
    only: Vec<Part>,
}

/// A part of the report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Part {
    Table1,
    Table2,
    Fig1,
    Fig2,
    Fig3,
    Sets,
    Claims,
}

impl Part {
    /// In the order of reading.
    const ALL: [Self; 7] =
        [Self::Table1, Self::Table2, Self::Fig1, Self::Fig2, Self::Fig3, Self::Sets, Self::Claims];
    /// The longest last, so that a run that is stopped has the most to show.
    const BY_COST: [Self; 7] =
        [Self::Table1, Self::Fig3, Self::Claims, Self::Table2, Self::Sets, Self::Fig1, Self::Fig2];

    fn plan(self, setting: &Setting) -> Vec<String> {
        match self {
            Self::Table1 => table1::plan(),
            Self::Table2 => table2::plan(),
            Self::Fig1 | Self::Fig2 => runtimes::plan(setting),
            Self::Fig3 => survivors::plan(setting),
            Self::Sets => sets::plan(setting),
            Self::Claims => claims::plan(),
        }
    }

    fn measure(self, setting: &Setting, units: &mut Units, cases: &mut Cases) -> Result<()> {
        match self {
            Self::Table1 => table1::measure(setting, units, cases),
            Self::Table2 => table2::measure(setting, units, cases),
            Self::Fig1 | Self::Fig2 => runtimes::measure(setting, units, cases),
            Self::Fig3 => survivors::measure(setting, units, cases),
            Self::Sets => sets::measure(setting, units, cases),
            Self::Claims => claims::measure(setting, units, cases),
        }
    }

    fn draw(self, setting: &Setting, units: &Units, report: &mut Report) -> Result<()> {
        match self {
            Self::Table1 => table1::draw(setting, units, report),
            Self::Table2 => table2::draw(setting, units, report),
            Self::Fig1 => runtimes::draw_figure_1(setting, units, report),
            Self::Fig2 => runtimes::draw_figure_2(setting, units, report),
            Self::Fig3 => survivors::draw(setting, units, report),
            Self::Sets => sets::draw(setting, units, report),
            Self::Claims => claims::draw(setting, units, report),
        }
    }
}

fn main() -> Result<()> {
    let line = Line::parse();
    // One pool for all; what is measured serially never touches it.
    let threads = line.options.threads();
    dcd_exec::with_threads(threads, || run(&line)).map_err(|error| anyhow!("{error}"))?
}

fn run(line: &Line) -> Result<()> {
    let is_chosen = |part: &Part| line.only.is_empty() || line.only.contains(part);
    let name = name(line);
    let dir = line.options.dir(&name);
    let page = Page {
        setting: Setting::of(&line.options),
        parts: Part::ALL.into_iter().filter(is_chosen).collect(),
        header: Header::observe(&line.options),
        name,
    };
    let mut planned = HashSet::new();
    let plan = page.parts.iter().flat_map(|part| part.plan(&page.setting));
    let plan: Vec<String> = plan.filter(|key| planned.insert(key.clone())).collect();
    let start = line.options.start();
    let mut units = Units::open(&dir, &page.header.fingerprint(), plan, start)?;

    let mut cases = Cases::of(&page.setting);
    for part in Part::BY_COST.into_iter().filter(is_chosen) {
        part.measure(&page.setting, &mut units, &mut cases)?;
        page.write(&units, &dir)?;
    }
    let pages = page.write(&units, &dir)?;
    let wrong = wrong(&page.setting, &units);
    units.finish()?;
    pages.iter().for_each(|page| println!("{}", page.display()));
    ensure!(wrong.is_empty(), "wrong contacts or an order that depends on the threads: {wrong:?}");
    Ok(())
}

/// The units of ours that found another set than the rest, left pairs undecided, or whose order
/// depends on the threads.
fn wrong(setting: &Setting, units: &Units) -> Vec<String> {
    let known = [
        table1::agreements(units),
        table2::agreements(units),
        runtimes::agreements(setting, units),
        sets::agreements(units),
        claims::agreements(units),
    ];
    let wrong = known.into_iter().flatten().filter(|(_, agreement)| !agreement.is_equal());
    wrong.map(|(key, _)| key).chain(sets::unordered(units)).collect()
}

/// Quick runs and parts have folders of their own, so that none overwrites a full run's report.
fn name(line: &Line) -> String {
    let mut name = String::from("bench");
    if line.options.quick {
        name.push_str("-quick");
    }
    for part in Part::ALL.iter().filter(|part| line.only.contains(part)) {
        name.push('-');
        name.push_str(&format!("{part:?}").to_lowercase());
    }
    name
}

/// The report, as far as its units are measured.
struct Page {
    name: String,
    header: Header,
    setting: Setting,
    parts: Vec<Part>,
}

impl Page {
    fn write(&self, units: &Units, dir: &Path) -> Result<Vec<PathBuf>> {
        let title = "Parallel double-phase collision detection: the paper, reproduced";
        let mut report = Report::new(&self.name, title, self.header.clone());
        report.missing(units);
        if self.setting.largest() != published::OBJECTS {
            report.note(format!(
                "A quick run: N = {} where the paper's tables have N = {}.",
                self.setting.largest(),
                published::OBJECTS
            ));
        }
        let wrong = wrong(&self.setting, units);
        if !wrong.is_empty() {
            report.note(format!(
                "Their times do not count, since what they found is wrong: {wrong:?}"
            ));
        }
        for part in &self.parts {
            part.draw(&self.setting, units, &mut report)?;
        }
        report.write(dir)
    }
}
