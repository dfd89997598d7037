//! GJK in f64, one pair at a time, per pair.

#![allow(missing_docs)] // criterion's macros make undocumented functions

mod input;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use dcd_gjk::{Gjk, PairSolver, PosedShape, Verdict};
use std::hint::black_box;

/// Every tenth candidate: all distances occur, and an iteration stays short.
const EVERY: usize = 10;

fn gjk(criterion: &mut Criterion) {
    let scene = input::scene();
    let placed =
        |i: u32| PosedShape { shape: scene.shape(i as usize), pose: &scene.poses()[i as usize] };
    let candidates = input::candidates(&scene);
    let pairs: Vec<_> =
        candidates.iter().step_by(EVERY).map(|pair| (placed(pair.i), placed(pair.j))).collect();
    let solver = Gjk::<f64>::default();
    let mut group = criterion.benchmark_group("gjk");
    group.throughput(Throughput::Elements(pairs.len() as u64));
    group.bench_function("f64", |bencher| {
        bencher.iter(|| {
            let touching = black_box(&pairs)
                .iter()
                .filter(|&&(a, b)| matches!(solver.solve(a, b, &mut ()), Verdict::Touching(())));
            black_box(touching.count())
        });
    });
    group.finish();
}

criterion_group!(benches, gjk);
criterion_main!(benches);
