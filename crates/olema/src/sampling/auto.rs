//! Auto: which rasterizer a grid should cost least with.
//!
//! In: a [`MovingDraw`]. Out: NoMotion for what stands still in focus, else Interval or InterleaveUvt. Sources:
//! Fatahalian 2009, figure 8 (operations); the expected numbers of tests are worked out here.
//!
//! Cost is in the paper's operations, over all micropolygons:
//!
//! ```text
//! Interval         70 M + 93 tests     a bound per stratum; sample 33, position 36, test 24 each
//! InterleaveUvt    63 N + 47 tests     position 36 and tile box 27 per tuple; sample 23, test 24 each
//! ```
//!
//! A box of w x h px at a random place overlaps (1 + w) (1 + h) pixels and (1 + w/K) (1 + h/K) tiles on
//! average. A stratum that spans dt of the shutter and du, dv of the lens widens the box by |vx| dt + |c| du
//! and |vy| dt + |c| dv, with speeds v and the circle of confusion c; the means of dt^2, dt du, ... over the
//! strata are the pattern's. A few quads of the grid stand for all of it, and of their path only the part
//! through the region counts. The error of all that matters where the two costs are alike, and there it is
//! cheap: `auto_costs_little_more_than_the_better_one` has the figures.
//!
//! The kernels in lanes do other work: Interval's tests all samples in the rows of the box that holds a micropolygon at
//! all times and lens places, and goes back to scalar code beyond two motion keys; InterleaveUvt's takes 16 quads of
//! a tuple at once. For them cost is in nanoseconds, fitted to the bench `kernels` with AVX-512 (docs/performance.md):
//!
//! ```text
//! Interval         200 + 2 M pixels of that box
//! InterleaveUvt    4.8 N + 0.8 tests
//! ```

use super::draw::{Kernels, MovingDraw};
use super::interleave::MAX_TILE;
use super::moving::{Extent, MovingGrid};
use super::pattern::SamplePattern;
use super::rasterizer::Rasterizer;
use super::region::Region;

/// Operations for a stratum's bound and for one sample test of Interval.
pub const INTERVAL_OPS: [f64; 2] = [70.0, 93.0];
/// Operations for a tuple's position and box and for one sample test of InterleaveUvt.
pub const INTERLEAVE_OPS: [f64; 2] = [63.0, 47.0];

/// Nanoseconds of Interval in lanes for a micropolygon, and for a sample in its box.
const INTERVAL_NS: [f64; 2] = [200.0, 2.0];
/// Nanoseconds of InterleaveUvt in lanes for a tuple and for one sample test.
const INTERLEAVE_NS: [f64; 2] = [4.8, 0.8];
/// How much longer scalar code takes.
const SCALAR: f64 = 7.0;

/// Quads that are looked at; grids of fewer are looked at whole.
const NUM_PROBES: usize = 16;
/// Of these so many at first, which is enough where one rasterizer costs so many times the other.
const FEW_PROBES: [(usize, f64); 2] = [(1, 4.0), (3, 1.5)];

/// What a micropolygon of a grid is expected to cost, in operations, or in nanoseconds of the kernels in lanes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// With Interval.
    pub interval: f64,
    /// With InterleaveUvt; infinite where K is too large for it.
    pub interleave: f64,
}

/// The rasterizer for a grid.
pub fn choose(draw: &MovingDraw) -> Rasterizer {
    if draw.grid.still().is_some() {
        return Rasterizer::NoMotion;
    }
    // One quad tells, or a few, unless they find both alike or are not in the region.
    let clear = FEW_PROBES.iter().find_map(|&(num_probes, clearly)| {
        let (few, is_any_seen) = estimate_from(draw, num_probes);
        let [least, most] = [few.interval.min(few.interleave), few.interval.max(few.interleave)];
        (is_any_seen && clearly * least < most).then_some(few)
    });
    let Estimate { interval, interleave } = clear.unwrap_or_else(|| estimate(draw));
    if interleave < interval { Rasterizer::InterleaveUvt } else { Rasterizer::Interval }
}

/// Expected costs, mean over the grid's quads.
pub fn estimate(draw: &MovingDraw) -> Estimate {
    estimate_from(draw, NUM_PROBES).0
}

/// The estimate from so many quads, and whether any of them may be in the region.
fn estimate_from(draw: &MovingDraw, num_probes: usize) -> (Estimate, bool) {
    let is_in_lanes = matches!(draw.kernels, Kernels::Lanes(_));
    // Only the scalar code's Interval bounds strata.
    let cells = (!is_in_lanes).then(|| Cells::of(draw.pattern));
    let k = f64::from(draw.pattern.tile());
    let (mut interval_tests, mut interleave_tests, mut boxes) = (0.0, 0.0, 0.0);
    let probes = Probes::of(&draw.grid, num_probes);
    let mut is_any_seen = false;
    for corners in (0..probes.num).map(|probe| probes.corners(&draw.grid, probe)) {
        for path in paths(&draw.grid, corners) {
            let seen = path.share_within(&draw.samples.region) * path.duration;
            is_any_seen |= seen > 0.0;
            interleave_tests += seen * path.tiles(k);
            match &cells {
                Some(cells) => interval_tests += seen * path.pixels_of_stratum(cells),
                None => boxes += path.pixels_in_all(&draw.samples.region),
            }
        }
    }
    let m = f64::from(draw.pattern.samples_per_pixel());
    let num_tuples = m * k * k;
    let mean = |tests: f64| tests / probes.num.max(1) as f64;
    // Strata and tuples of other times are not looked at.
    let [first, last] = draw.times.map(f64::from);
    let part = ((last + 1.0 - first) / 32_768.0).clamp(0.0, 1.0);
    let [interval, interleave] = if is_in_lanes {
        let interval = INTERVAL_NS[0] + INTERVAL_NS[1] * m * mean(boxes);
        let interval = if draw.grid.num_keys() > 2 { SCALAR * interval } else { interval };
        [interval, num_tuples * (INTERLEAVE_NS[0] * part + INTERLEAVE_NS[1] * mean(interleave_tests))]
    } else {
        let bounds = INTERVAL_OPS[0] * (part + 1.0 / m).min(1.0);
        let interval = m * (bounds + INTERVAL_OPS[1] * mean(interval_tests));
        [interval, num_tuples * (INTERLEAVE_OPS[0] * part + INTERLEAVE_OPS[1] * mean(interleave_tests))]
    };
    let fits = draw.pattern.tile() <= MAX_TILE;
    (Estimate { interval, interleave: if fits { interleave } else { f64::INFINITY } }, is_any_seen)
}

/// Quads to look at, spread over a grid.
struct Probes {
    num: usize,
    is_all: bool,
}

impl Probes {
    fn of(grid: &MovingGrid, most: usize) -> Self {
        let num_quads = grid.m * grid.n;
        Probes { num: num_quads.min(most), is_all: num_quads <= most }
    }

    fn corners(&self, grid: &MovingGrid, probe: usize) -> [usize; 4] {
        if self.is_all {
            return grid.corners(probe % grid.m, probe / grid.m);
        }
        // Rows in order, columns by the golden ratio.
        let at = |fraction: f64, num: usize| ((fraction * num as f64) as usize).min(num - 1);
        let along = (probe as f64 + 0.5) * 0.618_033_988_749_895;
        grid.corners(at(along - along.floor(), grid.m), at((probe as f64 + 0.5) / self.num as f64, grid.n))
    }
}

/// Means over the strata of what they span in time (of the shutter) and lens (of its radius).
struct Cells {
    t: f64,
    u: f64,
    v: f64,
    tt: f64,
    tu: f64,
    tv: f64,
    uv: f64,
}

impl Cells {
    fn of(pattern: &SamplePattern) -> Self {
        let mut sum = Cells { t: 0.0, u: 0.0, v: 0.0, tt: 0.0, tu: 0.0, tv: 0.0, uv: 0.0 };
        let m = pattern.samples_per_pixel();
        for bounds in (0..m).map(|stratum| pattern.stratum_bounds(stratum)) {
            let span = |[least, most]: [i16; 2]| (f64::from(most) - f64::from(least)) / 32_768.0;
            let [t, u, v] = [span(bounds.t15), span(bounds.u15), span(bounds.v15)];
            for (total, part) in [
                (&mut sum.t, t),
                (&mut sum.u, u),
                (&mut sum.v, v),
                (&mut sum.tt, t * t),
                (&mut sum.tu, t * u),
                (&mut sum.tv, t * v),
                (&mut sum.uv, u * v),
            ] {
                *total += part / f64::from(m);
            }
        }
        sum
    }
}

/// A quad over one motion segment, in pixels.
struct Path {
    /// Part of the shutter's time.
    duration: f64,
    /// Box at the segment's start, middle and end: least x, y and greatest x, y.
    boxes: [[[f64; 2]; 2]; 3],
    /// Mean speed of the vertices along x and y, a whole shutter.
    speed: [f64; 2],
    /// Mean radius of the circle of confusion, and mean of its square.
    coc: [f64; 2],
}

fn paths<'a>(grid: &'a MovingGrid, corners: [usize; 4]) -> impl Iterator<Item = Path> + 'a {
    let key_times = grid.times.key_times();
    (0..(grid.num_keys() - 1).max(1)).map(move |segment| {
        let duration = match key_times.get(segment + 1) {
            Some(to) => f64::from(*to) - f64::from(key_times[segment]),
            None => 1.0,
        };
        let ends = corners.map(|vertex| grid.ends(vertex, segment as u16));
        let at = |[from, to]: [usize; 2], half: i64| {
            [grid.x, grid.y].map(|v| ((i64::from(v[from]) * (2 - half) + i64::from(v[to]) * half) / 2) as i32)
        };
        let boxes = [0, 1, 2].map(|half| {
            let Extent { least, most } = Extent::around(&ends.map(|ends| at(ends, half)));
            [least, most].map(|corner| corner.map(|v| f64::from(v) / 256.0))
        });
        let mut path = Path { duration, boxes, speed: [0.0; 2], coc: [0.0; 2] };
        for ends in ends {
            for (speed, values) in path.speed.iter_mut().zip([grid.x, grid.y]) {
                let moved = f64::from(values[ends[1]]) - f64::from(values[ends[0]]);
                *speed += moved.abs() / (256.0 * 4.0 * duration);
            }
            if !grid.coc.is_empty() {
                let [c0, c1] = ends.map(|ix| f64::from(grid.coc[ix]) / 256.0);
                path.coc[0] += (c0.abs() + c1.abs()) / 8.0;
                path.coc[1] += (c0 * c0 + c0 * c1 + c1 * c1) / 12.0;
            }
        }
        path
    })
}

impl Path {
    /// Mean over the segment of a function of the box's width and height (Simpson's rule).
    fn mean(&self, of: impl Fn(f64, f64) -> f64) -> f64 {
        let [a, b, c] = self.boxes.map(|[least, most]| {
            // A box is half open on the raster: one position less.
            let size = [0, 1].map(|axis| (most[axis] - least[axis] - 1.0 / 256.0).max(0.0));
            of(size[0], size[1])
        });
        (a + 4.0 * b + c) / 6.0
    }

    /// Pixels that the box of a stratum overlaps.
    fn pixels_of_stratum(&self, cells: &Cells) -> f64 {
        let [vx, vy] = self.speed;
        let [c, cc] = self.coc;
        let grown = vx * vy * cells.tt + c * (vx * cells.tv + vy * cells.tu) + cc * cells.uv;
        self.mean(|w, h| {
            let (wide, high) = (1.0 + w, 1.0 + h);
            wide * high + wide * (vy * cells.t + c * cells.v) + high * (vx * cells.t + c * cells.u) + grown
        })
    }

    /// Pixels of a region that the box around the quad at all times and lens places overlaps.
    fn pixels_in_all(&self, region: &Region) -> f64 {
        let [first, _, last] = &self.boxes;
        let limits = [[region.x0, region.x1], [region.y0, region.y1]].map(|ends| ends.map(f64::from));
        let along = |axis: usize| {
            let blur = self.coc[0] * 2.0f64.sqrt();
            let least = (first[0][axis].min(last[0][axis]) - blur).max(limits[axis][0]);
            let most = (first[1][axis].max(last[1][axis]) + blur).min(limits[axis][1]);
            if most < least { 0.0 } else { 1.0 + most - least }
        };
        along(0) * along(1)
    }

    /// Tiles that the box of a tuple overlaps.
    fn tiles(&self, k: f64) -> f64 {
        self.mean(|w, h| (1.0 + w / k) * (1.0 + h / k))
    }

    /// Part of the segment's time in which the quad can be in the region.
    fn share_within(&self, region: &Region) -> f64 {
        let limits = [[region.x0, region.x1], [region.y0, region.y1]].map(|ends| ends.map(f64::from));
        let [first, _, last] = &self.boxes;
        let mut time = [0.0f64, 1.0];
        for axis in 0..2 {
            // Half of the circle is where it is on average.
            let spread = 0.5 * self.coc[0];
            let gap_after = [first, last].map(|b| limits[axis][1] - (b[0][axis] - spread));
            let gap_before = [first, last].map(|b| b[1][axis] + spread - limits[axis][0]);
            for [start, end] in [gap_after, gap_before] {
                clip(&mut time, start, end);
            }
        }
        (time[1] - time[0]).max(0.0)
    }
}

/// Clips a range of time to where a value that goes from `start` to `end` over [0, 1] is not below 0.
fn clip(time: &mut [f64; 2], start: f64, end: f64) {
    let zero = start / (start - end);
    match (start >= 0.0, end >= 0.0) {
        (true, true) => {}
        (true, false) => time[1] = time[1].min(zero),
        (false, true) => time[0] = time[0].max(zero),
        (false, false) => *time = [0.0, 0.0],
    }
}
