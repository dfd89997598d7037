//! How many supports a pair takes until it is known whether it touches.

use std::hint::black_box;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use anyhow::{Context, Result};
use dcd_benches::{Column, Report, Table, Units};
use dcd_broad::{BroadPhase, WideTree};
use dcd_exec::{Par, Segments};
use dcd_geom::glam::DVec3;
use dcd_geom::{Aabb, Pair, Polytope, Pose, Scene, Shape, Support, SupportMap};
use dcd_gjk::{Gjk, PairSolver, PosedShape, Verdict, distance};
use serde::{Deserialize, Serialize};

use crate::case::{Setting, spec};

/// Objects of the scene whose candidates are counted over.
const OBJECTS: usize = 1_000;

const KEY: &str = "claims/supports";

/// Pairs of one verdict, and the supports of A − B that they took.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Tally {
    pairs: u64,
    /// Until it was known whether they touch.
    supports: u64,
    most: u64,
    /// Until the distance was known.
    to_distance: u64,
}

#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Counted {
    apart: Tally,
    touching: Tally,
    undecided: u64,
}

impl Tally {
    fn add(&mut self, supports: u64, to_distance: u64) {
        self.pairs += 1;
        self.supports += supports;
        self.most = self.most.max(supports);
        self.to_distance += to_distance;
    }
}

/// A polytope that counts its support queries.
struct Counting {
    shape: Polytope,
    calls: Arc<AtomicU64>,
}

impl SupportMap<f64> for Counting {
    fn support(&self, direction: DVec3) -> Support<f64> {
        self.calls.fetch_add(1, Ordering::Relaxed);
        self.shape.support(direction)
    }

    fn radius(&self) -> f64 {
        self.shape.swept_radius()
    }
}

pub(super) fn plan() -> Vec<String> {
    vec![KEY.to_owned()]
}

pub(super) fn measure(setting: &Setting, units: &mut Units) -> Result<()> {
    units.run(KEY, || count(&spec(setting.seed, OBJECTS).scene()?))?;
    Ok(())
}

fn count(scene: &Scene) -> Result<Counted> {
    let calls = Arc::new(AtomicU64::new(0));
    let objects = (0..scene.len()).map(|i| counting(scene, i, &calls));
    let objects: Vec<(Shape, Pose)> = objects.collect::<Result<_>>()?;
    // A foreign shape computes its reach before a search begins.
    let reaches = |a: PosedShape, b: PosedShape| (a.shape.reach(), b.shape.reach());
    let supports = |work: &dyn Fn()| {
        calls.store(0, Ordering::Relaxed);
        work();
        calls.load(Ordering::Relaxed)
    };
    let mut counted = Counted::default();
    for pair in candidates(scene) {
        let [a, b] = [pair.i, pair.j].map(|i| {
            let (shape, pose) = &objects[i as usize];
            PosedShape { shape, pose }
        });
        let before = supports(&|| _ = black_box(reaches(a, b)));
        // Each vertex of A − B is a support of A and one of B.
        let of_difference = |all: u64| all.saturating_sub(before) / 2;
        let solver = Gjk::<f64>::default();
        let to_verdict = of_difference(supports(&|| _ = black_box(solver.solve(a, b, &mut ()))));
        let to_distance = of_difference(supports(&|| _ = black_box(distance::in_f64(a, b))));
        match solver.solve(a, b, &mut ()) {
            Verdict::Apart => counted.apart.add(to_verdict, to_distance),
            Verdict::Touching(()) => counted.touching.add(to_verdict, to_distance),
            Verdict::Undecided(_) => counted.undecided += 1,
        }
    }
    Ok(counted)
}

/// Object `i` as a foreign shape that counts, moved to its centre: that is where searches for
/// foreign shapes start.
fn counting(scene: &Scene, i: usize, calls: &Arc<AtomicU64>) -> Result<(Shape, Pose)> {
    let polytope = scene.shape(i).as_polytope().context("a hull of the paper's scene")?;
    let centre = polytope.inner().centre;
    let vertices = polytope.vertices().iter().map(|&vertex| vertex - centre).collect();
    let counting = Counting { shape: Polytope::hull(vertices)?, calls: Arc::clone(calls) };
    let pose = &scene.poses()[i];
    let pose = Pose::from_matrix(*pose.rotation(), pose.apply(centre))?;
    Ok((Shape::custom(Arc::new(counting))?, pose))
}

/// The pairs whose AABBs overlap.
fn candidates(scene: &Scene) -> Vec<Pair> {
    let aabbs: Vec<Aabb> = (0..scene.len()).map(|i| scene.aabb(i)).collect();
    let (mut broad, mut found) = (WideTree::default(), Segments::default());
    broad.build(&aabbs, Par::Serial.into());
    broad.pairs(&aabbs, |_, _| true, Par::Serial.into(), &mut found);
    found.iter().flatten().copied().collect()
}

pub(super) fn draw(units: &Units, report: &mut Report) -> Result<()> {
    let columns = [
        Column::new("pairs that are"),
        Column::new("pairs"),
        Column::new("supports to know it").decimals(2),
        Column::new("at most"),
        Column::new("supports to know the distance").decimals(2),
    ];
    let title = format!("Supports of our GJK in f64, candidates of N = {OBJECTS}");
    let mut table = Table::new("supports", title, columns);
    let counted: Option<Counted> = units.get(KEY);
    let tallies = [("apart", counted.map(|c| c.apart)), ("touching", counted.map(|c| c.touching))];
    for (name, tally) in tallies {
        let each = |of: fn(&Tally) -> u64| tally.map(|t| of(&t) as f64 / t.pairs as f64).into();
        table.push([
            name.into(),
            tally.map(|tally| tally.pairs).into(),
            each(|tally| tally.supports),
            tally.map(|tally| tally.most).into(),
            each(|tally| tally.to_distance),
        ])?;
    }
    report.note(
        "The paper's GJK goes on until the distance of a pair is known, where the question was yes \
         or no. Ours stops at the first axis or simplex that proves the answer; our distance search \
         is beside it.",
    );
    report.table(table);
    Ok(())
}
