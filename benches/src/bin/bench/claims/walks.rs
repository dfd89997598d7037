//! The build's threshold, the traversal's visits, and what running on a pool costs by itself.

use std::time::Duration;

use anyhow::{Result, anyhow};
use dcd_benches::{Column, Pair, Report, Table, Units, timing};
use dcd_broad::{BroadPhase, LeafPairs, Traversal, TreePairs, Visits};
use dcd_bvh::{BuildThreshold, PaperTree};
use dcd_exec::{Par, Segments, with_threads};
use dcd_geom::Aabb;
use dcd_pipeline::Pipeline;
use serde::{Deserialize, Serialize};

use crate::case::{Case, Cases, Setting};
use crate::variant::double_phase;

/// One tree built and walked in one way.
#[derive(Clone, Copy, Debug)]
struct Way {
    name: &'static str,
    tree: PaperTree,
    traversal: Traversal,
}

const CODED_BY_THIRDS: PaperTree =
    PaperTree { parallel_above: BuildThreshold::ThirdOfObjects, ..PaperTree::as_coded() };
const WRITTEN_ABOVE_4096: PaperTree =
    PaperTree { parallel_above: BuildThreshold::Objects(4096), ..PaperTree::as_written() };
const ONCE: Traversal = Traversal { visits: Visits::Once, ..Traversal::PAPER };
const TESTED: Traversal = Traversal { leaf_pairs: LeafPairs::Tested, ..Traversal::PAPER };
const ONCE_TESTED: Traversal = Traversal { leaf_pairs: LeafPairs::Tested, ..ONCE };

const WAYS: [Way; 7] = [
    Way::new("as written", PaperTree::as_written(), Traversal::PAPER),
    Way::new("as coded", PaperTree::as_coded(), Traversal::PAPER),
    Way::new("as written, parallel above 4096", WRITTEN_ABOVE_4096, Traversal::PAPER),
    Way::new("as coded, parallel above N/3", CODED_BY_THIRDS, Traversal::PAPER),
    Way::new("as written, visited once", PaperTree::as_written(), ONCE),
    Way::new("as written, pairs tested", PaperTree::as_written(), TESTED),
    Way::new("as written, once and tested", PaperTree::as_written(), ONCE_TESTED),
];

impl Way {
    const fn new(name: &'static str, tree: PaperTree, traversal: Traversal) -> Self {
        Self { name, tree, traversal }
    }

    fn key(&self) -> String {
        format!("claims/walk/{}", self.name)
    }
}

/// Build and traversal, serial (`b`) beside parallel (`a`).
#[derive(Debug, Serialize, Deserialize)]
struct Walked {
    build: Pair,
    pairs: Pair,
    candidates: u64,
}

/// Serial (`b`) beside a pool of one thread (`a`).
const ONE_THREAD: [&str; 2] = ["as written", "our default"];

fn one_thread_key(name: &str) -> String {
    format!("claims/one thread/{name}")
}

pub(super) fn plan() -> Vec<String> {
    let ways = WAYS.iter().map(Way::key);
    ways.chain(ONE_THREAD.into_iter().map(one_thread_key)).collect()
}

pub(super) fn measure(setting: &Setting, units: &mut Units, cases: &mut Cases) -> Result<()> {
    let objects = setting.largest();
    for way in WAYS {
        units.run(&way.key(), || Ok(walked(setting, way, cases.get(objects)?)))?;
    }
    let [paper, ours] = ONE_THREAD.map(one_thread_key);
    units.run(&paper, || {
        let mut pipeline = double_phase(TreePairs::paper_as_written());
        let case = cases.get(objects)?;
        on_one_thread(setting, |par| pipeline.step(&case.scene, par).contact_count())
    })?;
    units.run(&ours, || {
        let mut pipeline = Pipeline::new();
        let case = cases.get(objects)?;
        on_one_thread(setting, |par| pipeline.step(&case.scene, par).contact_count())
    })?;
    Ok(())
}

fn walked(setting: &Setting, way: Way, case: &Case) -> Walked {
    let scene = &case.scene;
    let aabbs: Vec<Aabb> = (0..scene.len()).map(|i| scene.aabb(i)).collect();
    let mut found = Segments::default();
    let mut candidates = 0;
    let [mut serial, mut parallel] = [(); 2].map(|()| TreePairs::new(way.tree).with(way.traversal));
    let mut step = |broad: &mut TreePairs<PaperTree>, par: Par| -> [Duration; 2] {
        let (build, ()) = timing::time(|| broad.build(&aabbs, par.into()));
        let find = || broad.pairs(&aabbs, |_, _| true, par.into(), &mut found);
        let (pairs, ()) = timing::time(find);
        candidates = found.len() as u64;
        [build, pairs]
    };
    let rounds = setting.effort.runs(Duration::ZERO);
    // One closure fills one list, so that both rivals find its memory as warm.
    let step = std::cell::RefCell::new(&mut step);
    let [build, pairs] = timing::pairs_of(
        rounds,
        || step.borrow_mut()(&mut parallel, Par::WarmPool),
        || step.borrow_mut()(&mut serial, Par::Serial),
    );
    Walked { build, pairs, candidates }
}

/// One code path, on a pool of one thread and without a pool.
fn on_one_thread(setting: &Setting, mut step: impl FnMut(Par) -> usize + Send) -> Result<Pair> {
    let measured = with_threads(1, || {
        let (first, _) = timing::time(|| step(Par::Serial));
        let step = std::cell::RefCell::new(&mut step);
        let timed = |par| [timing::time(|| step.borrow_mut()(par)).0];
        let rounds = setting.effort.runs(first);
        let [pair] = timing::pairs_of(rounds, || timed(Par::WarmPool), || timed(Par::Serial));
        pair
    });
    measured.map_err(|error| anyhow!("{error}"))
}

pub(super) fn draw(setting: &Setting, units: &Units, report: &mut Report) -> Result<()> {
    let ms = |name: &str| Column::new(name).unit("ms");
    let columns = [
        Column::new("tree and traversal"),
        ms("build, serial"),
        ms("build, parallel"),
        ms("pairs, serial"),
        ms("pairs, parallel"),
        Column::new("candidates"),
    ];
    let title =
        format!("The paper's tree and traversal, knob by knob, at N = {}", setting.largest());
    let mut table = Table::new("walks", title, columns);
    for way in WAYS {
        let walked: Option<Walked> = units.get(&way.key());
        let time = |of: fn(&Walked) -> Duration| walked.as_ref().map(of).into();
        table.push([
            way.name.into(),
            time(|w| w.build.b.median),
            time(|w| w.build.a.median),
            time(|w| w.pairs.b.median),
            time(|w| w.pairs.a.median),
            walked.as_ref().map(|w| w.candidates).into(),
        ])?;
    }
    report.note(
        "The text builds in parallel above a third of the objects, the code above 4096. Both walk \
         the tree against itself and meet each two nodes in both orders; once gives the same pairs.",
    );
    report.table(table);

    let columns = [
        Column::new("pipeline"),
        ms("serial"),
        ms("pool of one thread"),
        Column::new("serial / pool").decimals(3),
        Column::new("runs"),
    ];
    let title = format!(
        "The same code without a pool and on one thread of a pool, N = {}",
        setting.largest()
    );
    let mut table = Table::new("one-thread", title, columns);
    for name in ONE_THREAD {
        let pair: Option<Pair> = units.get(&one_thread_key(name));
        table.push([
            name.into(),
            pair.map(|pair| pair.b.median).into(),
            pair.map(|pair| pair.a.median).into(),
            pair.map(|pair| pair.ratio).into(),
            pair.map(|pair| pair.a.runs).into(),
        ])?;
    }
    report.table(table);
    Ok(())
}
