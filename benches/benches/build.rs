//! The tree over all AABBs, built from nothing, per object.

#![allow(missing_docs)] // criterion's macros make undocumented functions

mod input;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use dcd_broad::{BroadPhase, WideTree};
use dcd_exec::Par;
use std::hint::black_box;

fn build(criterion: &mut Criterion) {
    let aabbs = input::aabbs(&input::scene());
    let mut tree = WideTree::default();
    let mut group = criterion.benchmark_group("build");
    group.throughput(Throughput::Elements(aabbs.len() as u64));
    group.bench_function("wide tree", |bencher| {
        bencher.iter(|| tree.build(black_box(&aabbs), Par::Serial.into()));
    });
    group.finish();
}

criterion_group!(benches, build);
criterion_main!(benches);
