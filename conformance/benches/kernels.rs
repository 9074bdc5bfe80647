//! Sampling kernels at each level of vector instructions, and their scalar twins.
#![allow(missing_docs)] // criterion_group! makes a public function without them.

use std::time::Duration;

use conformance::kernels::{ALL, Ready, SIDE};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use olema::math::simd::SimdLevel;
use olema::sampling::Kernels;

/// Scalar code and each level.
fn all_kernels() -> Vec<(String, Kernels)> {
    let mut all = vec![("scalar".to_owned(), Kernels::Scalar)];
    all.extend(SimdLevel::all().into_iter().map(|level| (level.name().to_owned(), Kernels::Lanes(level))));
    all
}

fn kernels(c: &mut Criterion) {
    for case in &ALL {
        let mut group = c.benchmark_group(case.name);
        group
            .sample_size(20)
            .warm_up_time(Duration::from_millis(150))
            .measurement_time(Duration::from_millis(500));
        group.throughput(Throughput::Elements((SIDE * SIDE) as u64));
        for (level, kernels) in all_kernels() {
            let mut ready = Ready::new(case);
            group.bench_function(BenchmarkId::from_parameter(level), |b| b.iter(|| ready.draw(kernels)));
        }
        group.finish();
    }
}

criterion_group!(benches, kernels);
criterion_main!(benches);
