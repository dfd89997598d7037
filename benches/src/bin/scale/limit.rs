//! How far a step is from what it cannot do without: one support of each object of a pair, and
//! writing the pairs.

use std::hint::black_box;
use std::ops::Range;

use anyhow::{Result, ensure};
use dcd_benches::{Cell, Column, Options, Report, Sample, Table, Units, timing};
use dcd_exec::Exec;
use dcd_geom::{Pair, Scene};
use dcd_pipeline::{Par, Pipeline, StageClock};
use dcd_simd::{Block, Kernel, Lanes, Row, WIDTH, dispatch};
use serde::{Deserialize, Serialize};

use crate::runner::Case;

/// The stages of a step beside what they cannot do without, on one thread.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Seen {
    candidates: usize,
    blocks_a_pair: f64,
    /// Finding the candidates, and only writing them.
    pairs: Sample,
    written: Sample,
    /// Deciding them, and evaluating only one support of both objects.
    narrow: Sample,
    supports: Sample,
}

fn key(case: &Case) -> String {
    format!("limit/{}", case.key())
}

/// The units of all cases.
pub(crate) fn plan(cases: &[Case]) -> Vec<String> {
    cases.iter().map(key).collect()
}

/// Measures a case.
pub(crate) fn measure(case: &Case, options: &Options, units: &mut Units) -> Result<()> {
    units.run(&key(case), || see(case.scene()?, super::rounds(options)))?;
    Ok(())
}

fn see(scene: &Scene, rounds: u32) -> Result<Seen> {
    let mut pipeline = Pipeline::new();
    let candidates: Vec<Pair> = pipeline.step(scene, Par::Serial).candidates().collect();
    let clock = StageClock::default();
    let mut step = || {
        pipeline.step(scene, Exec::observed(Par::Serial, &clock));
        let [.., pairs, narrow] = clock.take();
        [pairs, narrow]
    };
    let vertices = Vertices::of(scene);
    let (mut list, mut sum) = (Vec::new(), 0.0);
    let mut least = || {
        let (written, ()) = timing::time(|| {
            list.clear();
            list.extend_from_slice(black_box(&candidates));
        });
        let (supports, heights) =
            timing::time(|| dispatch(Supports { vertices: &vertices, pairs: &candidates }));
        sum += heights;
        [written, supports]
    };
    let [pairs, narrow] = timing::pairs_of(rounds, &mut step, &mut least);
    ensure!(list.len() == candidates.len() && !f32::is_nan(sum), "a support is no number");
    let blocks = |object| vertices.of_object(object).len();
    let blocks: usize = candidates.iter().map(|pair| blocks(pair.i) + blocks(pair.j)).sum();
    Ok(Seen {
        candidates: candidates.len(),
        blocks_a_pair: blocks as f64 / candidates.len().max(1) as f64,
        pairs: pairs.a,
        written: pairs.b,
        narrow: narrow.a,
        supports: narrow.b,
    })
}

/// The vertices of a scene's polytopes, sixteen a block, shape after shape.
struct Vertices {
    blocks: Vec<Block>,
    /// For each object its blocks.
    objects: Vec<Range<usize>>,
}

impl Vertices {
    fn of(scene: &Scene) -> Self {
        let mut blocks = Vec::new();
        let shapes = scene.shapes().iter().map(|shape| {
            let first = blocks.len();
            if let Some(polytope) = shape.as_polytope() {
                blocks.extend(Block::relative(polytope.vertices(), polytope.inner().centre));
            }
            first..blocks.len()
        });
        let shapes: Vec<Range<usize>> = shapes.collect();
        let objects = scene.shape_of().iter().map(|&shape| shapes[shape as usize].clone());
        Self { objects: objects.collect(), blocks }
    }

    #[inline(always)]
    fn of_object(&self, object: u32) -> &[Block] {
        &self.blocks[self.objects[object as usize].clone()]
    }
}

/// One support of each object of each pair, along one direction: every vertex is read, nothing is
/// done with the winner but to count it.
struct Supports<'a> {
    vertices: &'a Vertices,
    pairs: &'a [Pair],
}

impl Kernel for Supports<'_> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> f32 {
        let mut along = [Row::default(); WIDTH];
        let mut sum = l.splat(0.0);
        for pairs in self.pairs.chunks(WIDTH) {
            let live = l.mask((1 << pairs.len()) - 1);
            for side in 0..2 {
                for (lane, pair) in pairs.iter().enumerate() {
                    let object = if side == 0 { pair.i } else { pair.j };
                    let mut best = l.splat(f32::NEG_INFINITY);
                    for block in self.vertices.of_object(object) {
                        best = l.max(height(l, block), best);
                    }
                    l.store(best, &mut along[lane]);
                }
                let heights = l.largest_of_each(&along);
                sum = l.add(sum, l.select(live, heights, l.splat(0.0)));
            }
        }
        let mut sums = Row::default();
        l.store(sum, &mut sums);
        let mut total = 0.0;
        for height in sums.0 {
            total += height;
        }
        total
    }
}

/// How far sixteen vertices reach along a direction in general position.
#[inline(always)]
fn height<L: Lanes>(l: L, block: &Block) -> L::F {
    let [x, y, z] = [l.load(&block.0[0]), l.load(&block.0[1]), l.load(&block.0[2])];
    let [dx, dy, dz] = [l.splat(0.48), l.splat(0.6), l.splat(0.64)];
    l.mul_add(x, dx, l.mul_add(y, dy, l.mul(z, dz)))
}

/// Draws what is there.
pub(crate) fn show(cases: &[Case], units: &Units, report: &mut Report) -> Result<()> {
    report.heading("How far the limit is");
    report.note(
        "One thread, interleaved with the step. Whoever lists candidates writes them; whoever decides a \
         pair that no sphere decides reads every vertex of both objects once. `one support` does that \
         for every pair, on the step's own pairs in their order, and nothing else.",
    );
    let ns = |name: &str| Column::new(name).unit("ns/pair").decimals(2);
    let mut columns = ["scene", "N", "candidates"].map(Column::new).to_vec();
    columns.push(Column::new("blocks of 16 vertices").unit("a pair").decimals(2));
    columns.extend(["pairs", "writing them"].map(ns));
    columns.push(Column::new("ratio").unit("×").decimals(1));
    columns.extend(["narrow", "one support"].map(ns));
    columns.push(Column::new("ratio").unit("× of one support").decimals(2));
    let mut table = Table::new("limit", "The step beside what it cannot do without", columns);
    for case in cases {
        let Some(seen) = units.get::<Seen>(&key(case)) else { continue };
        let ns = |sample: Sample| sample.median.as_secs_f64() * 1e9 / seen.candidates as f64;
        let [pairs, written] = [ns(seen.pairs), ns(seen.written)];
        let [narrow, supports] = [ns(seen.narrow), ns(seen.supports)];
        let mut row = vec![Cell::from(case.name()), case.objects().into()];
        row.extend([seen.candidates.into(), seen.blocks_a_pair.into()]);
        row.extend([pairs, written, pairs / written].map(Cell::from));
        row.extend([narrow, supports, narrow / supports].map(Cell::from));
        table.push(row)?;
    }
    report.table(table);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_supports_reach_as_far_as_the_vertices() {
        let case = Case::new("paper", 40, 1).unwrap();
        let scene = case.scene().unwrap();
        let pairs: Vec<Pair> = (1..40).map(|j| Pair { i: 0, j }).collect();
        let vertices = Vertices::of(scene);
        let total = dispatch(Supports { vertices: &vertices, pairs: &pairs });
        let reach = |i: u32| {
            let d = [0.48, 0.6, 0.64];
            let rows = |block: &Block| {
                (0..WIDTH)
                    .map(|k| (0..3).map(|axis| block.0[axis].0[k] * d[axis]).sum::<f32>())
                    .fold(f32::NEG_INFINITY, f32::max)
            };
            vertices.of_object(i).iter().map(rows).fold(f32::NEG_INFINITY, f32::max)
        };
        let expected: f32 = pairs.iter().map(|pair| reach(pair.i) + reach(pair.j)).sum();
        assert!((total - expected).abs() < 1e-3, "{total} {expected}");
    }
}
