//! The search for candidate pairs in a finished tree, per pair found.

#![allow(missing_docs)] // criterion's macros make undocumented functions

mod input;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use dcd_broad::{BroadPhase, WideTree};
use dcd_exec::{Par, Segments};
use std::hint::black_box;

fn pairs(criterion: &mut Criterion) {
    let scene = input::scene();
    let aabbs = input::aabbs(&scene);
    let mut tree = WideTree::default();
    tree.build(&aabbs, Par::Serial.into());
    let mut found = Segments::default();
    let mut group = criterion.benchmark_group("pairs");
    group.throughput(Throughput::Elements(input::candidates(&scene).len() as u64));
    group.bench_function("wide tree", |bencher| {
        bencher.iter(|| {
            tree.pairs(black_box(&aabbs), |_, _| true, Par::Serial.into(), &mut found);
            black_box(found.len())
        });
    });
    group.finish();
}

criterion_group!(benches, pairs);
criterion_main!(benches);
