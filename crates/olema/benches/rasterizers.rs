//! What each rasterizer costs under motion and defocus: a grid of 16 x 16 quads of 1 px, 16 samples a pixel.
//!
//! Prints sample tests, hits and STE of each case besides its time. Simple has K = 1, the others K = 2 (N = 64).

#![allow(missing_docs)] // criterion_group! makes a public function without them.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use olema::sampling::inside::HitPoint;
use olema::sampling::nomotion::{Facing, HitSink, SampleCounts};
use olema::sampling::{
    Kernels, Micropolygons, MovingDraw, MovingGrid, PatternSpec, Rasterizer, Region, RegionSamples,
    SamplePattern, TupleTimes,
};

const SIDE: usize = 16;

/// Keeps the nearest depth of each sample.
struct Depths(Vec<f32>);

impl HitSink for Depths {
    fn hit(&mut self, sample_ix: usize, point: HitPoint, _triangle: u8, _sign: i8) {
        let nearest = &mut self.0[sample_ix];
        *nearest = nearest.min(point.depth);
    }
}

/// x and y at both keys in 1/256 px: a turned square that moves by `motion` px at 30 degrees.
fn places(motion: f64) -> [Vec<i32>; 2] {
    let (sin, cos) = 0.3f64.sin_cos();
    let mut places = [Vec::new(), Vec::new()];
    for key in [-0.5, 0.5] {
        for j in 0..=SIDE {
            for i in 0..=SIDE {
                let [a, b] = [i, j].map(|v| v as f64 - SIDE as f64 / 2.0);
                let at = [a * cos - b * sin + 0.866 * motion * key, a * sin + b * cos + 0.5 * motion * key];
                for (list, v) in places.iter_mut().zip(at) {
                    list.push((v * 256.0).round() as i32);
                }
            }
        }
    }
    places
}

fn rasterizers(c: &mut Criterion) {
    let spec = |tile| PatternSpec { samples: [4, 4], tile, ..PatternSpec::default() };
    let [one, two] = [1, 2].map(|tile| SamplePattern::new(spec(tile)));
    let region = Region::new(-90, 90, -90, 90);
    let mut group = c.benchmark_group("rasterizers");
    group.sample_size(10).warm_up_time(Duration::from_millis(100));
    group.measurement_time(Duration::from_millis(300)).throughput(Throughput::Elements((SIDE * SIDE) as u64));
    for motion in [0, 5, 20, 40, 100] {
        for focus in [0, 2, 10, 20] {
            let [x, y] = places(f64::from(motion));
            let (depth, coc) = (vec![1.0; x.len()], vec![focus * 256; x.len()]);
            for rasterizer in [
                Rasterizer::NoMotion,
                Rasterizer::Interval,
                Rasterizer::InterleaveUvt,
                Rasterizer::BoundingBox,
                Rasterizer::Simple,
                Rasterizer::Auto,
            ] {
                if rasterizer == Rasterizer::NoMotion && motion + focus > 0 {
                    continue;
                }
                let pattern = if rasterizer == Rasterizer::Simple { &one } else { &two };
                let times = TupleTimes::new(pattern, &[0.0, 1.0]);
                let samples = RegionSamples::new(pattern, region);
                let grid =
                    MovingGrid { m: SIDE, n: SIDE, times: &times, x: &x, y: &y, depth: &depth, coc: &coc };
                let (facing, micropolygons) = (Facing::Any, Micropolygons::Quads);
                let draw = MovingDraw {
                    grid,
                    pattern,
                    samples: &samples,
                    facing,
                    skip: None,
                    micropolygons,
                    times: MovingDraw::ALL_TIMES,
                    kernels: Kernels::default(),
                };
                let mut sink = Depths(vec![f32::INFINITY; samples.len()]);
                let mut run = || {
                    let mut counts = SampleCounts::default();
                    let used = rasterizer.rasterize(black_box(&draw), &mut counts, &mut sink);
                    (counts, used)
                };
                // The paper's counts: kernels in lanes leave tests out.
                let mut counts = SampleCounts::default();
                let scalar = MovingDraw { kernels: Kernels::Scalar, ..draw };
                let used = rasterizer.rasterize(
                    &scalar,
                    &mut counts,
                    &mut Depths(vec![f32::INFINITY; samples.len()]),
                );
                println!(
                    "{rasterizer:?} ({:?}), {motion} px of motion, {focus} px of defocus: {} tests, {} hits, STE {:.4}",
                    used.unwrap_or(rasterizer),
                    counts.tests,
                    counts.hits,
                    counts.ste()
                );
                let id = BenchmarkId::new(format!("{rasterizer:?}"), format!("{motion}px/{focus}px"));
                group.bench_function(id, |b| b.iter(&mut run));
            }
        }
    }
    group.finish();
}

criterion_group!(benches, rasterizers);
criterion_main!(benches);
