//! What stands in the paper's text and is otherwise in its code, measured here.

mod slab;
mod supports;
mod tolerances;
mod walks;

use anyhow::Result;
use dcd_benches::{Agreement, Report, Units};

use crate::case::{Cases, Setting};

pub(crate) fn plan() -> Vec<String> {
    [walks::plan(), slab::plan(), supports::plan(), tolerances::plan()].concat()
}

pub(crate) fn measure(setting: &Setting, units: &mut Units, cases: &mut Cases) -> Result<()> {
    walks::measure(setting, units, cases)?;
    slab::measure(setting, units)?;
    supports::measure(setting, units)?;
    tolerances::measure(setting, units)
}

pub(crate) fn draw(setting: &Setting, units: &Units, report: &mut Report) -> Result<()> {
    report.heading("Where text and code disagree");
    report.note(
        "`docs/paper.md` lists the disagreements and says which table answers which. Those that are \
         not below are in the parts above: the leaf cutoff, candidates per leaf and per pair, the \
         growth with N, whole sets compared, the order.",
    );
    walks::draw(setting, units, report)?;
    slab::draw(setting, units, report)?;
    supports::draw(units, report)?;
    tolerances::draw(units, report)
}

/// How the contacts that are ours to answer for stand, as far as they are known.
pub(crate) fn agreements(units: &Units) -> Vec<(String, Agreement)> {
    [slab::agreements(units), tolerances::agreements(units)].concat()
}
