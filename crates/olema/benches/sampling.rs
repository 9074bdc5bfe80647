//! Sampling: the pattern's set-up, a region's lay-out. (The rasterizers are in the benches `rasterizers` and, of the crate
//! `conformance`, `kernels`.)
#![allow(missing_docs)] // criterion_group! makes a public function without them.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use olema::sampling::{PatternSpec, Region, RegionSamples, SamplePattern};

fn pattern(side: u32) -> SamplePattern {
    SamplePattern::new(PatternSpec { samples: [side, side], ..PatternSpec::default() })
}

fn set_up(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("pattern");
    for side in [2, 4, 8, 16, 32] {
        group.bench_function(BenchmarkId::new("new", side * side), |bencher| {
            bencher.iter(|| pattern(black_box(side)));
        });
        let pattern = pattern(side);
        let mut samples = RegionSamples::new(&pattern, Region::new(0, 32, 0, 32));
        group.bench_function(BenchmarkId::new("lay_out_32x32", side * side), |bencher| {
            bencher.iter(|| samples.renew(&pattern, black_box(Region::new(-32, 0, 64, 96))));
        });
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).measurement_time(std::time::Duration::from_secs(2));
    targets = set_up
}
criterion_main!(benches);
