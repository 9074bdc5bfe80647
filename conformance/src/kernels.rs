//! The sampling kernels on a small grid: what their bench times, and whose instructions are counted.
//!
//! In: a name out of [`ALL`] and [`Kernels`]. Out: a grid of 16 x 16 quads of 1 px drawn into a sample buffer, all of its
//! hits being kept.

use std::cmp::Ordering;
use std::hint::black_box;

use olema::math::lanes::Lanes;
use olema::sampling::inside::HitPoint;
use olema::sampling::nomotion::{Facing, HitPoints, HitSink, SampleCounts};
use olema::sampling::{
    Kernels, Micropolygons, MovingDraw, MovingGrid, PatternSpec, Payload, Rasterizer, Record, Region,
    RegionSamples, SampleBuffer, SamplePattern, TupleTimes,
};

/// Quads along a side of the grid.
pub const SIDE: usize = 16;

/// What is drawn, and with which rasterizer.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// What benches and baselines call it.
    pub name: &'static str,
    /// The rasterizer.
    pub rasterizer: Rasterizer,
    /// Samples along a side of a pixel.
    pub samples: u32,
    /// Motion in pixels.
    pub motion: f64,
    /// Radius of the circles of confusion in pixels.
    pub coc: f64,
}

const fn case(name: &'static str, rasterizer: Rasterizer, samples: u32, motion: f64, coc: f64) -> Case {
    Case { name, rasterizer, samples, motion, coc }
}

/// All of them.
pub const ALL: [Case; 12] = [
    case("nomotion_1spp", Rasterizer::NoMotion, 1, 0.0, 0.0),
    case("nomotion_4spp", Rasterizer::NoMotion, 2, 0.0, 0.0),
    case("nomotion_16spp", Rasterizer::NoMotion, 4, 0.0, 0.0),
    case("interleave_0px_coc0px", Rasterizer::InterleaveUvt, 4, 0.0, 0.0),
    case("interleave_10px_coc0px", Rasterizer::InterleaveUvt, 4, 10.0, 0.0),
    case("interleave_40px_coc0px", Rasterizer::InterleaveUvt, 4, 40.0, 0.0),
    case("interleave_0px_coc8px", Rasterizer::InterleaveUvt, 4, 0.0, 8.0),
    case("interleave_40px_coc8px", Rasterizer::InterleaveUvt, 4, 40.0, 8.0),
    case("interval_0px_coc0px", Rasterizer::Interval, 4, 0.0, 0.0),
    case("interval_1px_coc0px", Rasterizer::Interval, 4, 1.0, 0.0),
    case("interval_4px_coc0px", Rasterizer::Interval, 4, 4.0, 0.0),
    case("interval_0px_coc2px", Rasterizer::Interval, 4, 0.0, 2.0),
];

/// Opaque hits of one grid into a buffer.
struct Opaque<'a> {
    buffer: &'a mut SampleBuffer,
    micropolygon: u32,
}

fn order(a: Payload, b: Payload) -> Ordering {
    a.0.cmp(&b.0)
}

impl HitSink for Opaque<'_> {
    fn begin(&mut self, micropolygon: u32) {
        self.micropolygon = micropolygon;
    }

    fn hit(&mut self, sample_ix: usize, point: HitPoint, triangle: u8, _sign: i8) {
        let payload = Payload::new(0, self.micropolygon, triangle);
        self.buffer.offer(sample_ix, Record::new(point, payload), &order);
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
        self.buffer.offer_lanes(lanes, first, hits, points, payloads, &order);
    }
}

/// A case made ready: a turned square that moves at 30 degrees, and comes nearer.
pub struct Ready {
    rasterizer: Rasterizer,
    pattern: SamplePattern,
    times: TupleTimes,
    samples: RegionSamples,
    buffer: SampleBuffer,
    x: Vec<i32>,
    y: Vec<i32>,
    depth: Vec<f32>,
    coc: Vec<i32>,
}

impl Ready {
    /// Makes `case` ready.
    pub fn new(case: &Case) -> Self {
        let Case { rasterizer, samples: side, motion, coc: radius, .. } = *case;
        let key_times: &[f32] = if rasterizer == Rasterizer::NoMotion { &[0.0] } else { &[0.0, 1.0] };
        let pattern = SamplePattern::new(PatternSpec { samples: [side, side], ..PatternSpec::default() });
        let region = Region::new(-48, 48, -48, 48);
        let samples = RegionSamples::new(&pattern, region);
        let mut ready = Ready {
            rasterizer,
            times: TupleTimes::new(&pattern, key_times),
            buffer: SampleBuffer::new(region, samples.samples_per_pixel()),
            pattern,
            samples,
            x: Vec::new(),
            y: Vec::new(),
            depth: Vec::new(),
            coc: Vec::new(),
        };
        let (sin, cos) = 0.3f64.sin_cos();
        for key in 0..key_times.len() {
            let time = key as f64 - 0.5;
            for (j, i) in (0..=SIDE).flat_map(|j| (0..=SIDE).map(move |i| (j, i))) {
                let [a, b] = [i, j].map(|v| v as f64 - SIDE as f64 / 2.0);
                ready.x.push(((a * cos - b * sin + 0.866 * motion * time) * 256.0).round() as i32);
                ready.y.push(((a * sin + b * cos + 0.5 * motion * time) * 256.0).round() as i32);
                ready.depth.push((10.0 + 0.01 * a + 0.02 * b - 0.1 * motion * time / 40.0) as f32);
                ready.coc.push(((radius + 0.01 * b + 0.1 * time) * 256.0) as i32);
            }
        }
        if radius == 0.0 {
            ready.coc.clear();
        }
        ready
    }

    /// Draws the square, nearer than the last time, so that every hit is kept: equal depths are rare, and another path.
    pub fn draw(&mut self, kernels: Kernels) -> SampleCounts {
        self.depth.iter_mut().for_each(|z| *z -= 1e-4);
        let (x, y, depth, coc) = (&self.x, &self.y, &self.depth, &self.coc);
        let draw = MovingDraw {
            grid: MovingGrid { m: SIDE, n: SIDE, times: &self.times, x, y, depth, coc },
            pattern: &self.pattern,
            samples: &self.samples,
            facing: Facing::Any,
            skip: None,
            micropolygons: Micropolygons::Quads,
            times: MovingDraw::ALL_TIMES,
            kernels,
        };
        let mut counts = SampleCounts::default();
        let mut sink = Opaque { buffer: &mut self.buffer, micropolygon: 0 };
        self.rasterizer.rasterize(black_box(&draw), &mut counts, &mut sink).expect("suited");
        counts
    }
}
