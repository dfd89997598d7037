//! The first stage: rotated vertices for the lanes, spheres and world boxes, per object.

#![allow(missing_docs)] // criterion's macros make undocumented functions

mod input;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use dcd_geom::Aabb;
use dcd_gjk::simd::SimdFrame;
use dcd_gjk::{NarrowPhase, Overlap, Sides};
use std::hint::black_box;

fn boxes(criterion: &mut Criterion) {
    let scene = input::scene();
    let overlap = Overlap::default();
    let mut frame = SimdFrame::default();
    let mut aabbs = vec![Aabb::default(); scene.len()];
    let mut group = criterion.benchmark_group("boxes");
    group.throughput(Throughput::Elements(scene.len() as u64));
    group.bench_function("prepare", |bencher| {
        bencher.iter(|| {
            let part = overlap.layout(&scene, Sides::One, &mut frame);
            overlap.prepare(black_box(&scene), 0, part, black_box(&mut aabbs));
        });
    });
    group.finish();
}

criterion_group!(benches, boxes);
criterion_main!(benches);
