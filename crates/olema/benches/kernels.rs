//! Sampling kernels at each level of vector instructions, and their scalar twins: grids of 16 x 16 quads of 1 px, whose
//! hits compete in a sample buffer.
#![allow(missing_docs)] // criterion_group! makes a public function without them.

use std::cmp::Ordering;
use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use olema::math::lanes::Lanes;
use olema::math::simd::SimdLevel;
use olema::sampling::inside::HitPoint;
use olema::sampling::nomotion::{Facing, HitPoints, HitSink, SampleCounts};
use olema::sampling::{
    Kernels, Micropolygons, MovingDraw, MovingGrid, PatternSpec, Payload, Rasterizer, Record, Region,
    RegionSamples, SampleBuffer, SamplePattern, TupleTimes,
};

const SIDE: usize = 16;

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

    #[inline(always)]
    fn hits<L: Lanes>(
        &mut self,
        lanes: L,
        first: usize,
        hits: [u32; 2],
        points: HitPoints<L>,
        _negative: u32,
    ) {
        let payloads = [0, 1].map(|triangle| Payload::new(0, self.micropolygon, triangle));
        let order = |a: Payload, b: Payload| -> Ordering { a.0.cmp(&b.0) };
        self.buffer.offer_lanes(lanes, first, hits, points, payloads, &order);
    }
}

/// A turned square that moves by `motion` px at 30 degrees, and comes nearer.
struct Square {
    x: Vec<i32>,
    y: Vec<i32>,
    depth: Vec<f32>,
    coc: Vec<i32>,
}

fn square(motion: f64, coc: f64, keys: usize) -> Square {
    let (sin, cos) = 0.3f64.sin_cos();
    let mut square = Square { x: Vec::new(), y: Vec::new(), depth: Vec::new(), coc: Vec::new() };
    for key in 0..keys {
        let time = key as f64 - 0.5;
        for j in 0..=SIDE {
            for i in 0..=SIDE {
                let [a, b] = [i, j].map(|v| v as f64 - SIDE as f64 / 2.0);
                square.x.push(((a * cos - b * sin + 0.866 * motion * time) * 256.0).round() as i32);
                square.y.push(((a * sin + b * cos + 0.5 * motion * time) * 256.0).round() as i32);
                square.depth.push((10.0 + 0.01 * a + 0.02 * b - 0.1 * motion * time / 40.0) as f32);
                square.coc.push(((coc + 0.01 * b + 0.1 * time) * 256.0) as i32);
            }
        }
    }
    if coc == 0.0 {
        square.coc.clear();
    }
    square
}

/// Scalar code and each level.
fn all_kernels() -> Vec<(String, Kernels)> {
    let mut all = vec![("scalar".to_owned(), Kernels::Scalar)];
    all.extend(SimdLevel::all().into_iter().map(|level| (level.name().to_owned(), Kernels::Lanes(level))));
    all
}

fn bench(c: &mut Criterion, name: &str, square: &Square, rasterizer: Rasterizer, side: u32, keys: &[f32]) {
    let pattern = SamplePattern::new(PatternSpec { samples: [side, side], ..PatternSpec::default() });
    let times = TupleTimes::new(&pattern, keys);
    let region = Region::new(-48, 48, -48, 48);
    let samples = RegionSamples::new(&pattern, region);
    let mut buffer = SampleBuffer::new(region, samples.samples_per_pixel());
    let Square { x, y, depth, coc } = square;
    let mut depth = depth.clone();
    let mut group = c.benchmark_group(name);
    group
        .sample_size(20)
        .warm_up_time(Duration::from_millis(150))
        .measurement_time(Duration::from_millis(500));
    group.throughput(Throughput::Elements((SIDE * SIDE) as u64));
    for (level, kernels) in all_kernels() {
        group.bench_function(BenchmarkId::from_parameter(level), |b| {
            b.iter(|| {
                // Nearer each time, so that each hit is kept: equal depths are rare, and another path.
                depth.iter_mut().for_each(|z| *z -= 1e-4);
                let draw = MovingDraw {
                    grid: MovingGrid { m: SIDE, n: SIDE, times: &times, x, y, depth: &depth, coc },
                    pattern: &pattern,
                    samples: &samples,
                    facing: Facing::Any,
                    skip: None,
                    micropolygons: Micropolygons::Quads,
                    times: MovingDraw::ALL_TIMES,
                    kernels,
                };
                let mut counts = SampleCounts::default();
                let mut sink = Opaque { buffer: &mut buffer, micropolygon: 0 };
                rasterizer.rasterize(black_box(&draw), &mut counts, &mut sink).expect("suited");
                counts
            });
        });
        buffer.renew(region);
        depth.clone_from(&square.depth);
    }
    group.finish();
}

fn kernels(c: &mut Criterion) {
    for side in [1, 2, 4] {
        let name = format!("nomotion_{}spp", side * side);
        bench(c, &name, &square(0.0, 0.0, 1), Rasterizer::NoMotion, side, &[0.0]);
    }
    for (motion, coc) in [(0.0, 0.0), (10.0, 0.0), (40.0, 0.0), (0.0, 8.0), (40.0, 8.0)] {
        let name = format!("interleave_n64_{motion}px_coc{coc}px");
        bench(c, &name, &square(motion, coc, 2), Rasterizer::InterleaveUvt, 4, &[0.0, 1.0]);
    }
    for (motion, coc) in [(0.0, 0.0), (1.0, 0.0), (4.0, 0.0), (0.0, 2.0)] {
        let name = format!("interval_16spp_{motion}px_coc{coc}px");
        bench(c, &name, &square(motion, coc, 2), Rasterizer::Interval, 4, &[0.0, 1.0]);
    }
}

criterion_group!(benches, kernels);
criterion_main!(benches);
