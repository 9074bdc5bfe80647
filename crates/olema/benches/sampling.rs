//! Sampling: NoMotion on quads of 1 px, the pattern's set-up, a region's lay-out.
#![allow(missing_docs)] // criterion_group! makes a public function without them.

use std::cmp::Ordering;
use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use olema::sampling::inside::HitPoint;
use olema::sampling::nomotion::{Facing, GridView, HitSink, SampleCounts, rasterize_grid};
use olema::sampling::{PatternSpec, Payload, Record, Region, RegionSamples, SampleBuffer, SamplePattern};

/// Opaque hits of one grid into a buffer.
struct Opaque<'a> {
    buffer: &'a mut SampleBuffer,
    micropolygon: u32,
}

impl HitSink for Opaque<'_> {
    fn begin(&mut self, micropolygon: u32) {
        self.micropolygon = micropolygon;
    }

    fn hit(&mut self, sample_ix: usize, point: HitPoint, triangle: u8, _sign: i8) {
        let payload = Payload::new(0, self.micropolygon, triangle);
        self.buffer.offer(sample_ix, Record::new(point, payload), &|a: Payload, b: Payload| -> Ordering {
            a.0.cmp(&b.0)
        });
    }
}

fn pattern(side: u32) -> SamplePattern {
    SamplePattern::new(PatternSpec { samples: [side, side], ..PatternSpec::default() })
}

/// A grid of 56 x 56 quads of 1 px, turned a little, over a tile of 64 x 64 pixels.
fn nomotion(criterion: &mut Criterion) {
    let n = 56;
    let (mut x, mut y, mut depth) = (Vec::new(), Vec::new(), Vec::new());
    for j in 0..=n {
        for i in 0..=n {
            let (i, j) = (i as f32, j as f32);
            x.push(((7.3 + i * 0.995 - j * 0.0995) * 256.0) as i32);
            y.push(((1.1 + i * 0.0995 + j * 0.995) * 256.0) as i32);
            depth.push(10.0 + 0.01 * i + 0.02 * j);
        }
    }
    let mut group = criterion.benchmark_group("nomotion_1px_quads");
    group.throughput(Throughput::Elements((n * n) as u64));
    for side in [1, 2, 4] {
        let pattern = pattern(side);
        let region = Region::new(0, 64, 0, 64);
        let samples = RegionSamples::new(&pattern, region);
        let mut buffer = SampleBuffer::new(region, samples.samples_per_pixel());
        group.bench_function(BenchmarkId::from_parameter(side * side), |bencher| {
            bencher.iter(|| {
                let mut counts = SampleCounts::default();
                let mut sink = Opaque { buffer: &mut buffer, micropolygon: 0 };
                let grid = GridView { m: n, n, x: &x, y: &y, depth: &depth };
                rasterize_grid(black_box(grid), Facing::Any, None, &samples, &mut counts, &mut sink);
                counts
            });
        });
    }
    group.finish();
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
    targets = nomotion, set_up
}
criterion_main!(benches);
