//! The certified narrow phase on a fixed list of candidates, per pair.

#![allow(missing_docs)] // criterion's macros make undocumented functions

mod input;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use dcd_geom::Aabb;
use dcd_gjk::simd::{Scratch, SimdFrame};
use dcd_gjk::{ContactSink, NarrowPhase, Overlap, Prepared, Report, Sides};
use std::hint::black_box;

/// As many as a task of the pipeline judges.
const SLICE: usize = 2048;

fn narrow(criterion: &mut Criterion) {
    let scene = input::scene();
    let pairs = input::candidates(&scene);
    let overlap = Overlap::default();
    let mut frame = SimdFrame::default();
    let part = overlap.layout(&scene, Sides::One, &mut frame);
    overlap.prepare(&scene, 0, part, &mut vec![Aabb::default(); scene.len()]);

    let (mut scratch, mut contacts, mut report) =
        (Scratch::default(), Vec::new(), Report::default());
    let mut group = criterion.benchmark_group("narrow");
    group.throughput(Throughput::Elements(pairs.len() as u64));
    group.bench_function("overlap in lanes", |bencher| {
        bencher.iter(|| {
            contacts.clear();
            report.clear();
            for slice in black_box(&pairs).chunks(SLICE) {
                let mut sink = ContactSink { contacts: &mut contacts, report: &mut report };
                let side = Prepared { scene: &scene, frame: &frame };
                overlap.decide(side, side, slice, &mut scratch, &mut sink);
            }
            black_box(contacts.len())
        });
    });
    group.finish();
}

criterion_group!(benches, narrow);
criterion_main!(benches);
