//! A loop that depends on the processor alone, beside which `cargo xtask bench` sets what has no
//! peer: a hundred thousand multiplications and additions, each of the number before.
#![allow(missing_docs)]

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;

fn chain(first: f64) -> f64 {
    (0..100_000).fold(first, |x, _| x * 0.999 + 0.001)
}

fn reference(c: &mut Criterion) {
    let mut group = c.benchmark_group("reference");
    group.bench_function("loop", |b| b.iter(|| chain(black_box(0.5))));
    group.finish();
}

criterion_group!(benches, reference);
criterion_main!(benches);
