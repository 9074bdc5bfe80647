//! What the tz-pyramid costs: an update for a grid's raster box, and queries of still and moving boxes, on a
//! tile of 64 x 64 pixels with 16 samples each.

#![allow(missing_docs)] // `criterion_group!` makes a public function without any.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use olema::occlusion::{Blurred, Bounds, CullKind, CullPlan, CullSettings, DepthReads, Occluders};
use olema::sampling::inside::Weights;
use olema::sampling::pattern::StratumBounds;
use olema::sampling::{PatternSpec, Payload, Record, Region, RegionSamples, SampleBuffer, SamplePattern};

/// A tile all of whose samples were hit at depth `100 + sample % 8`.
struct Tile {
    pattern: SamplePattern,
    samples: RegionSamples,
    buffer: SampleBuffer,
}

impl Tile {
    fn new() -> Self {
        let pattern = SamplePattern::new(PatternSpec::default());
        let region = Region::new(0, 64, 0, 64);
        let samples = RegionSamples::new(&pattern, region);
        let mut buffer = SampleBuffer::new(region, samples.samples_per_pixel());
        for ix in 0..samples.len() {
            offer(&mut buffer, ix, 100.0 + (ix % 8) as f32);
        }
        Tile { pattern, samples, buffer }
    }

    /// Samples of a box.
    fn grid(&self, [x0, x1, y0, y1]: [i32; 4]) -> Vec<usize> {
        let inside = |&ix: &usize| {
            let [x, y] = self.samples.position(ix).map(|c| c >> 8);
            (x0..=x1).contains(&x) && (y0..=y1).contains(&y)
        };
        (0..self.samples.len()).filter(inside).collect()
    }

    fn occluders(&self, kind: CullKind, leaf_px: u32, slices: u32) -> Occluders {
        let settings = CullSettings { kind, leaf_px, slices, ..CullSettings::default() };
        let plan = CullPlan::new(settings, &self.pattern, Blurred { moves: true, has_lens: false })
            .expect("it culls");
        let mut occluders = Occluders::new(&plan);
        occluders.renew(&self.samples);
        occluders.drew([0, 63, 0, 63]);
        occluders.update(&mut self.buffer.clone());
        occluders
    }
}

fn offer(buffer: &mut SampleBuffer, ix: usize, depth: f32) {
    let hit = Record { depth, payload: Payload::new(0, 0, 0), weights: Weights(0) };
    buffer.offer(ix, hit, &|_, _| std::cmp::Ordering::Equal);
}

const KINDS: [(&str, CullKind, u32, u32); 6] = [
    ("z 2x2", CullKind::Z, 2, 1),
    ("tz 2x2 64", CullKind::Tz, 2, 64),
    ("tz 2x2 16", CullKind::Tz, 2, 16),
    ("tz 8x8 64", CullKind::Tz, 8, 64),
    ("tz 16x16 16", CullKind::Tz, 16, 16),
    ("slice 2x2 64", CullKind::Slice, 2, 64),
];

/// Updates for a box of 18 x 18 pixels, as a grid of 16 x 16 micropolygons draws it.
fn updates(c: &mut Criterion) {
    let mut group = c.benchmark_group("update");
    let grid = [21, 38, 9, 26];
    for (name, kind, leaf_px, slices) in KINDS {
        let mut tile = Tile::new();
        let mut occluders = tile.occluders(kind, leaf_px, slices);
        tile.buffer.clear_written();
        group.bench_function(format!("no sample was hit/{name}"), |b| {
            b.iter(|| {
                occluders.drew(black_box(grid));
                occluders.update(&mut tile.buffer);
            });
        });
        // One depth after the other, so that every leaf of the box changes each time.
        let mut depth = 50.0;
        let (draw, mut pair) = (tile.grid(grid), [tile.buffer.clone(), tile.buffer.clone()]);
        group.bench_function(format!("all samples were hit/{name}"), |b| {
            b.iter_batched_ref(
                || {
                    pair.swap(0, 1);
                    depth = 101.0 - depth;
                    pair[0].renew(tile.samples.region);
                    draw.iter().for_each(|&ix| offer(&mut pair[0], ix, depth));
                    pair[0].clone()
                },
                |buffer| {
                    occluders.drew(black_box(grid));
                    occluders.update(buffer);
                },
                criterion::BatchSize::SmallInput,
            );
        });
        group.bench_function(format!("renew/{name}"), |b| {
            b.iter(|| occluders.renew(black_box(&tile.samples)));
        });
    }
    group.finish();
}

/// A box of 14 x 14 pixels that moves by `motion` pixels in x, at a depth.
fn bounds(motion: i32, near: f32) -> impl Fn(&StratumBounds) -> Bounds {
    move |span| {
        let x = span.t15.map(|t15| (i32::from(t15) * motion) >> 15);
        Bounds { pixels: [9 + x[0], 22 + x[1], 17, 30], near, still: motion == 0 }
    }
}

fn queries(c: &mut Criterion) {
    let mut group = c.benchmark_group("query");
    let mut tile = Tile::new();
    let cases = [
        ("still, hidden", 0, 200.0),
        ("still, in front", 0, 50.0),
        ("still, among", 0, 103.0),
        ("moves 30 px, hidden", 30, 200.0),
        ("moves 30 px, in front", 30, 50.0),
        ("moves 30 px, among", 30, 103.0),
    ];
    for (name, kind, leaf_px, slices) in KINDS {
        let mut occluders = tile.occluders(kind, leaf_px, slices);
        for (case, motion, near) in cases {
            let bounds_over = bounds(motion, near);
            group.bench_function(format!("{case}/{name}"), |b| {
                let mut reads = DepthReads::default();
                b.iter(|| {
                    let bounds_over = black_box(&bounds_over);
                    occluders.is_occluded(&tile.samples, &mut tile.buffer, bounds_over, &mut reads)
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, updates, queries);
criterion_main!(benches);
