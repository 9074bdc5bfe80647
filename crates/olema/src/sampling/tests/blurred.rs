//! Moving, defocused grids for tests, and the answer that every rasterizer must give.

use crate::sampling::hash::Stream;
use crate::sampling::inside::{HitPoint, point_at, triangle_hit};
use crate::sampling::nomotion::{Facing, HitSink, SampleCounts};
use crate::sampling::{
    Kernels, Micropolygons, MovingDraw, MovingGrid, Rasterizer, RegionSamples, SamplePattern, TupleTimes,
};

/// A grid that owns its vertices; places in 1/256 px.
#[derive(Debug, Clone)]
pub struct Blurred {
    pub m: usize,
    pub n: usize,
    pub key_times: Vec<f32>,
    pub x: Vec<i32>,
    pub y: Vec<i32>,
    pub depth: Vec<f32>,
    pub coc: Vec<i32>,
}

impl Blurred {
    /// A grid whose vertices come from a function of (key, i, j): x and y in pixels.
    pub fn from_fn(
        size: [usize; 2],
        key_times: &[f32],
        mut at: impl FnMut(usize, usize, usize) -> [f64; 2],
    ) -> Self {
        let [m, n] = size;
        let (mut x, mut y) = (Vec::new(), Vec::new());
        for key in 0..key_times.len() {
            for j in 0..=n {
                for i in 0..=m {
                    let place = at(key, i, j).map(|v| (v * 256.0).round() as i32);
                    x.push(place[0]);
                    y.push(place[1]);
                }
            }
        }
        let depth = vec![1.0; x.len()];
        Blurred { m, n, key_times: key_times.to_vec(), x, y, depth, coc: Vec::new() }
    }

    /// With one circle of confusion, radius in pixels, for all.
    pub fn defocused(mut self, radius: f64) -> Self {
        self.coc = vec![(radius * 256.0).round() as i32; self.x.len()];
        self
    }

    pub fn grid<'a>(&'a self, times: &'a TupleTimes) -> MovingGrid<'a> {
        let (x, y, depth, coc) = (&self.x, &self.y, &self.depth, &self.coc);
        MovingGrid { m: self.m, n: self.n, times, x, y, depth, coc }
    }

    pub fn draw(
        &self,
        how: How,
        pattern: &SamplePattern,
        samples: &RegionSamples,
        sink: &mut impl HitSink,
    ) -> SampleCounts {
        let times = TupleTimes::new(pattern, &self.key_times);
        let How { rasterizer, facing, micropolygons, kernels } = how;
        let draw = MovingDraw {
            grid: self.grid(&times),
            pattern,
            samples,
            facing,
            skip: None,
            micropolygons,
            times: MovingDraw::ALL_TIMES,
            kernels,
        };
        let mut counts = SampleCounts::default();
        rasterizer.rasterize(&draw, &mut counts, sink).expect("suited");
        counts
    }
}

/// How to draw.
#[derive(Debug, Clone, Copy)]
pub struct How {
    pub rasterizer: Rasterizer,
    pub facing: Facing,
    pub micropolygons: Micropolygons,
    pub kernels: Kernels,
}

pub fn with(rasterizer: Rasterizer) -> How {
    How { rasterizer, facing: Facing::Any, micropolygons: Micropolygons::Quads, kernels: Kernels::default() }
}

/// As [`with`], in scalar code: the paper's algorithm, whose tests are counted.
pub fn scalar(rasterizer: Rasterizer) -> How {
    How { kernels: Kernels::Scalar, ..with(rasterizer) }
}

/// All that is known of a hit: quad, sample, triangle, bits of the depth, sign, weights.
pub type FullHit = (u32, usize, u8, u32, i8, u32);

/// Keeps every hit.
#[derive(Debug, Default)]
pub struct AllHits {
    micropolygon: u32,
    pub hits: Vec<FullHit>,
}

impl AllHits {
    pub fn sorted(mut self) -> Vec<FullHit> {
        self.hits.sort_unstable();
        self.hits
    }
}

impl HitSink for AllHits {
    fn begin(&mut self, micropolygon: u32) {
        self.micropolygon = micropolygon;
    }

    fn hit(&mut self, sample_ix: usize, point: HitPoint, triangle: u8, sign: i8) {
        let HitPoint { depth, weights } = point;
        self.hits.push((self.micropolygon, sample_ix, triangle, depth.to_bits(), sign, weights.0));
    }
}

/// Counts hits and nothing else.
#[derive(Debug, Default)]
pub struct NoHits;

impl HitSink for NoHits {
    fn hit(&mut self, _sample_ix: usize, _point: HitPoint, _triangle: u8, _sign: i8) {}
}

/// Every sample of the region against every quad, with positions written out as the normative page has them.
pub fn brute_force(
    grid: &Blurred,
    facing: Facing,
    pattern: &SamplePattern,
    samples: &RegionSamples,
) -> Vec<FullHit> {
    let times = TupleTimes::new(pattern, &grid.key_times);
    let num = (grid.m + 1) * (grid.n + 1);
    let mut hits = Vec::new();
    for sample_ix in 0..samples.len() {
        let tuple = pattern.tuples()[samples.tuples[sample_ix] as usize];
        let time = times.locate(tuple.t15);
        let t15 = i128::from(time.t15);
        let round = |product: i128| (product + (1 << 14)) >> 15;
        let vertex = |ix: usize| {
            let from = usize::from(time.segment) * num + ix;
            let to = if grid.key_times.len() == 1 { from } else { from + num };
            let lerp =
                |v: &[i32]| i128::from(v[from]) + round(t15 * (i128::from(v[to]) - i128::from(v[from])));
            let c = if grid.coc.is_empty() { 0 } else { lerp(&grid.coc) };
            let xy = [
                lerp(&grid.x) + round(i128::from(tuple.u15) * c),
                lerp(&grid.y) + round(i128::from(tuple.v15) * c),
            ];
            let (z0, z1) = (grid.depth[from], grid.depth[to]);
            let z = (z0 + (f32::from(time.t15) / 32_768.0) * (z1 - z0)).clamp(z0.min(z1), z0.max(z1));
            (xy.map(|v| i32::try_from(v).expect("fits")), z)
        };
        for quad in 0..grid.m * grid.n {
            let v0 = quad / grid.m * (grid.m + 1) + quad % grid.m;
            let [v0, v1, v2, v3] = [v0, v0 + 1, v0 + grid.m + 2, v0 + grid.m + 1].map(vertex);
            for (number, triangle) in [[v0, v1, v2], [v0, v2, v3]].into_iter().enumerate() {
                let Some(hit) = triangle_hit(triangle.map(|v| v.0), samples.position(sample_ix)) else {
                    continue;
                };
                if facing == Facing::Any || facing == Facing::Only(hit.sign) {
                    let HitPoint { depth, weights } = point_at(&hit, triangle.map(|v| v.1));
                    hits.push((quad as u32, sample_ix, number as u8, depth.to_bits(), hit.sign, weights.0));
                }
            }
        }
    }
    hits.sort_unstable();
    hits
}

/// A random grid near pixel (0, 0): slow or fast, small or large, turning over, degenerate, in or out of focus.
pub fn random_grid(stream: &mut Stream) -> Blurred {
    let (m, n) = (1 + stream.below(3) as usize, 1 + stream.below(3) as usize);
    let mut key_times = vec![0.0];
    let num_keys = 1 + stream.below(4);
    for key in 1..num_keys {
        // Uneven steps.
        let within = (f64::from(key) - 0.9 * stream.next_unit()) / f64::from(num_keys - 1);
        key_times.push(if key + 1 == num_keys { 1.0 } else { within as f32 });
    }
    let size = [0.0, 0.02, 0.5, 1.0, 3.0, 14.0][stream.below(6) as usize];
    let speed = [0.0, 0.01, 0.3, 2.0, 9.0, 60.0][stream.below(6) as usize];
    let wobble = [0.0, 0.0, 0.2, 1.0, 3.0][stream.below(5) as usize];
    let flat = stream.below(6) == 0;
    let focus = [0.0, 0.0, 0.1, 1.0, 6.0][stream.below(5) as usize];
    let start = [(stream.next_unit() - 0.5) * 12.0, (stream.next_unit() - 0.5) * 10.0];
    let turn = stream.next_unit() * std::f64::consts::TAU;
    let mut at = start;
    let mut spin = turn;
    let mut last_key = 0;
    let mut values = stream.clone();
    let mut grid = Blurred::from_fn([m, n], &key_times, |key, i, j| {
        let mut random = || values.next_unit() * 2.0 - 1.0;
        if key != last_key {
            last_key = key;
            at = at.map(|v| v + random() * speed);
            spin += random() * wobble;
        }
        let (sin, cos) = spin.sin_cos();
        let [a, b] = [i as f64 * size, if flat { 0.0 } else { j as f64 * size * spin.cos().signum() }];
        let jitter = [random(), random()].map(|r| r * size * 0.4 * wobble.min(1.0));
        [at[0] + a * cos - b * sin + jitter[0], at[1] + a * sin + b * cos + jitter[1]]
    });
    *stream = values;
    for depth in &mut grid.depth {
        *depth = (1.0 + 4.0 * stream.next_unit()) as f32;
    }
    if focus > 0.0 {
        let base = (stream.next_unit() * 2.0 - 1.0) * focus;
        let spread = if stream.below(2) == 0 { 0.0 } else { focus };
        grid.coc = (0..grid.x.len())
            .map(|_| ((base + spread * (stream.next_unit() - 0.5)) * 256.0) as i32)
            .collect();
    }
    grid
}
