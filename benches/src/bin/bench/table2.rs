//! Table 2: the leaf cutoff, really swept.

use std::num::NonZeroU32;

use anyhow::Result;
use dcd_benches::{Agreement, Column, Report, Table, Units};
use dcd_broad::{LeafPairs, Traversal, TreePairs};
use dcd_bvh::PaperTree;
use dcd_exec::Par;

use crate::case::{Cases, Setting};
use crate::published;
use crate::variant::{Job, Timed, double_phase};

/// A tree and a way to walk it, but for the leaf cutoff.
#[derive(Clone, Copy, Debug)]
struct Sweep {
    name: &'static str,
    tree: PaperTree,
    leaf_pairs: LeafPairs,
}

const SWEEPS: [Sweep; 3] = [
    Sweep { name: "as written", tree: PaperTree::as_written(), leaf_pairs: LeafPairs::Untested },
    Sweep { name: "as coded", tree: PaperTree::as_coded(), leaf_pairs: LeafPairs::Untested },
    Sweep {
        name: "each pair tested",
        tree: PaperTree::as_written(),
        leaf_pairs: LeafPairs::Tested,
    },
];

impl Sweep {
    fn key(&self, cutoff: u32) -> String {
        format!("table2/{}/{cutoff}", self.name)
    }

    fn broad_phase(&self, cutoff: u32) -> TreePairs<PaperTree> {
        let leaf_cutoff = NonZeroU32::new(cutoff).unwrap_or(NonZeroU32::MIN);
        let traversal = Traversal { leaf_pairs: self.leaf_pairs, ..Traversal::PAPER };
        TreePairs::new(PaperTree { leaf_cutoff, ..self.tree }).with(traversal)
    }
}

/// Every sweep at every cutoff.
fn all() -> impl Iterator<Item = (u32, Sweep)> {
    let cutoffs = published::TABLE_2.into_iter().map(|(cutoff, _)| cutoff);
    cutoffs.flat_map(|cutoff| SWEEPS.map(|sweep| (cutoff, sweep)))
}

pub(crate) fn plan() -> Vec<String> {
    all().map(|(cutoff, sweep)| sweep.key(cutoff)).collect()
}

pub(crate) fn measure(setting: &Setting, units: &mut Units, cases: &mut Cases) -> Result<()> {
    for (cutoff, sweep) in all() {
        units.run(&sweep.key(cutoff), || {
            let case = cases.get(setting.largest())?;
            let job = Job { setting, case, exec: Par::WarmPool.into() };
            Ok(job.pipeline(double_phase(sweep.broad_phase(cutoff))))
        })?;
    }
    Ok(())
}

pub(crate) fn draw(setting: &Setting, units: &Units, report: &mut Report) -> Result<()> {
    let objects = setting.largest();
    let times = SWEEPS.map(|sweep| Column::new(sweep.name).unit("ms").decimals(1));
    let counts = SWEEPS.map(|sweep| Column::new(format!("candidates, {}", sweep.name)));
    let own = [Column::new("leaf cutoff")].into_iter().chain(times).chain(counts);
    let published = Column::new("runtime").unit("ms").decimals(2).published();
    let title = format!("Table 2: the parallel double phase on leaf cutoffs at N = {objects}");
    let mut table = Table::new("table2", title, own.chain([published]));
    for (cutoff, runtime) in published::TABLE_2 {
        let timed = SWEEPS.map(|sweep| units.get::<Timed>(&sweep.key(cutoff)));
        let times = timed.iter().map(|timed| timed.as_ref().map(|t| t.sample.median).into());
        let counts = timed.iter().map(|timed| timed.as_ref().map(|t| t.candidates).into());
        let row = [cutoff.into()].into_iter().chain(times).chain(counts);
        table.push(row.chain([runtime.into()]))?;
    }
    report.heading("Table 2: the leaf cutoff");
    report.note(format!(
        "The paper's sweep names its output file by the cutoff but hands its pipeline the literal 4 \
         each time: hence its flat row (N = {}). Here the cutoff reaches the tree. A leaf's pairs \
         are all candidates in the paper's traversal, so larger leaves make more work for the narrow \
         phase; where each pair's own AABBs are compared, the candidates are the same at any cutoff.",
        published::OBJECTS
    ));
    report.table(table);
    Ok(())
}

/// How the contacts stand on every cutoff, as far as they are known.
pub(crate) fn agreements(units: &Units) -> Vec<(String, Agreement)> {
    let agreement = |key: String| {
        let timed: Timed = units.get(&key)?;
        Some((key, timed.agreement))
    };
    plan().into_iter().filter_map(agreement).collect()
}
