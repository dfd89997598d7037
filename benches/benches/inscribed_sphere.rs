//! The sphere inside a hull, found once a shape, per shape.

#![allow(missing_docs)] // criterion's macros make undocumented functions

mod input;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use dcd_geom::{Shape, Sphere};
use std::hint::black_box;

fn inner_sphere(criterion: &mut Criterion) {
    let scene = input::scene();
    let hulls: Vec<_> = scene.shapes().iter().filter_map(Shape::as_polytope).collect();
    let mut group = criterion.benchmark_group("inscribed sphere");
    group.throughput(Throughput::Elements(hulls.len() as u64));
    group.bench_function("paper's hulls", |bencher| {
        bencher.iter(|| {
            for hull in black_box(&hulls) {
                black_box(Sphere::inside(hull.vertices()));
            }
        });
    });
    group.finish();
}

criterion_group!(benches, inner_sphere);
criterion_main!(benches);
