//! NoMotion in lanes: 16 samples side by side.
//!
//! In: a grid that stands still, and the samples of a region. Out: the hits and counts of the scalar twin,
//! [`super::nomotion`]. Source: Fatahalian 2009, section 4.1, turned: a lane per sample instead of per micropolygon, since
//! the samples of a row of pixels lie side by side and nothing has to be gathered or scattered. 16 samples a pixel are
//! one pixel a vector, 4 are four pixels of a row.
//!
//! Vertices and samples are taken relative to the first pixel of a micropolygon's box, in 16 bits; one of more than
//! [`MOST`] is drawn by the twin. The edge functions of both triangles are five, `A . s + C` with C lowered by 1 where a
//! sample on the edge counts as negative: then the sign bit alone decides. All samples of the pixels are tested; counted
//! are those of the cells that the box overlaps, as they are by the twin: no other can be hit.

use super::inside::{greater, lesser};
use super::nomotion::{Facing, GridView, HitPoints, HitSink, SampleCounts, rasterize_quad};
use super::region::{MOST_STEPS_PX, RegionSamples};
use super::test_lanes::{upper_weights, weights};
use crate::math::lanes::{Lanes, pair};
use crate::math::simd::{LANES, LanesKernel, SimdLevel};

/// Longest side of a box in 1/256 px.
const MOST: i32 = 256 * (MOST_STEPS_PX as i32 - 1);

/// Whether the kernel can draw into these samples.
pub(super) fn takes(samples: &RegionSamples) -> bool {
    samples.grid[0] <= 256 && samples.grid[1] <= 256
}

/// Rasterizes all quads of a grid, as [`super::nomotion::rasterize_grid`].
pub(super) fn rasterize_grid<S: HitSink>(
    level: SimdLevel,
    grid: GridView,
    facing: Facing,
    skip: Option<&[bool]>,
    samples: &RegionSamples,
    counts: &mut SampleCounts,
    sink: &mut S,
) {
    level.run_lanes(Kernel { grid, facing, skip, samples, counts, sink });
}

struct Kernel<'a, S> {
    grid: GridView<'a>,
    facing: Facing,
    skip: Option<&'a [bool]>,
    samples: &'a RegionSamples,
    counts: &'a mut SampleCounts,
    sink: &'a mut S,
}

impl<S: HitSink> LanesKernel for Kernel<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, lanes: L) {
        let grid = self.grid;
        for j in 0..grid.n {
            for i in 0..grid.m {
                let [v0, v1, v2, v3] = grid.corners(i, j);
                if self.skip.is_some_and(|skip| skip[v0] || skip[v1] || skip[v2] || skip[v3]) {
                    continue;
                }
                self.sink.begin((j * grid.m + i) as u32);
                let x = [grid.x[v0], grid.x[v1], grid.x[v2], grid.x[v3]];
                let y = [grid.y[v0], grid.y[v1], grid.y[v2], grid.y[v3]];
                let z = [grid.depth[v0], grid.depth[v1], grid.depth[v2], grid.depth[v3]];
                self.draw_quad(lanes, x, y, z);
            }
        }
    }
}

/// First and last sub-pixel position along an axis that can be hit, and first and last pixel, both within the region.
#[derive(Clone, Copy)]
struct Span {
    first: i32,
    last: i32,
}

impl Span {
    #[inline(always)]
    fn new(least: i32, most: i32, region: [i32; 2]) -> Self {
        Span { first: least.max(region[0] * 256), last: (most - 1).min(region[1] * 256 - 1) }
    }

    /// Cells that it overlaps, of `num` a pixel.
    #[inline(always)]
    fn num_cells(self, num: u32) -> u64 {
        let cell = |at: i32| (i64::from(at) * i64::from(num)) >> 8;
        (cell(self.last) - cell(self.first) + 1) as u64
    }
}

/// One of the two triangles of a quad.
#[derive(Clone, Copy)]
struct Half {
    area: i32,
    is_drawn: bool,
    /// 1 / area.
    r: f32,
    /// z1 - z0 and z2 - z0.
    rise: [f32; 2],
    /// Least and greatest depth.
    range: [f32; 2],
}

impl Half {
    #[inline(always)]
    fn new(area: i32, z: [f32; 3], facing: Facing) -> Self {
        let sign = area.signum() as i8;
        Half {
            area,
            is_drawn: sign != 0 && !matches!(facing, Facing::Only(side) if side != sign),
            r: 1.0 / area as f32,
            rise: [z[1] - z[0], z[2] - z[0]],
            range: [lesser(lesser(z[0], z[1]), z[2]), greater(greater(z[0], z[1]), z[2])],
        }
    }
}

impl<S: HitSink> Kernel<'_, S> {
    #[inline(always)]
    fn draw_quad<L: Lanes>(&mut self, lanes: L, x: [i32; 4], y: [i32; 4], z: [f32; 4]) {
        let range = |v: [i32; 4]| [v[0].min(v[1]).min(v[2].min(v[3])), v[0].max(v[1]).max(v[2].max(v[3]))];
        let ([x_least, x_most], [y_least, y_most]) = (range(x), range(y));
        if x_most - x_least > MOST || y_most - y_least > MOST {
            let (counts, sink) = (&mut *self.counts, &mut *self.sink);
            let xy = [[x[0], y[0]], [x[1], y[1]], [x[2], y[2]], [x[3], y[3]]];
            return draw_scalar(xy, z, self.facing, self.samples, counts, sink);
        }
        let cross =
            |a: usize, b: usize, c: usize| (x[b] - x[a]) * (y[c] - y[a]) - (y[b] - y[a]) * (x[c] - x[a]);
        let halves = [
            Half::new(cross(0, 1, 2), [z[0], z[1], z[2]], self.facing),
            Half::new(cross(0, 2, 3), [z[0], z[2], z[3]], self.facing),
        ];
        let region = self.samples.region;
        let (regions_x, regions_y) = ([region.x0, region.x1], [region.y0, region.y1]);
        let around = |v: [i32; 4], c: usize, region: [i32; 2]| {
            Span::new(v[0].min(v[c]).min(v[2]), v[0].max(v[c]).max(v[2]), region)
        };
        let (span_x, span_y) = match [halves[0].is_drawn, halves[1].is_drawn] {
            [true, true] => (Span::new(x_least, x_most, regions_x), Span::new(y_least, y_most, regions_y)),
            [true, false] => (around(x, 1, regions_x), around(y, 1, regions_y)),
            [false, true] => (around(x, 3, regions_x), around(y, 3, regions_y)),
            [false, false] => {
                self.counts.backfacing += u64::from(halves[0].area != 0 || halves[1].area != 0);
                return;
            }
        };
        if span_x.first > span_x.last || span_y.first > span_y.last {
            return;
        }
        let grid = self.samples.grid;
        self.counts.tests += span_x.num_cells(grid[0]) * span_y.num_cells(grid[1]);
        self.test_rows(lanes, [x, y], z[0], &halves, [span_x, span_y]);
    }

    /// Tests all samples of the pixels of a box, row by row.
    #[inline(always)]
    fn test_rows<L: Lanes>(
        &mut self,
        lanes: L,
        [x, y]: [[i32; 4]; 2],
        z0: f32,
        halves: &[Half; 2],
        [span_x, span_y]: [Span; 2],
    ) {
        let samples = self.samples;
        let num_strata = samples.samples_per_pixel();
        let (px, py) = (span_x.first >> 8, span_y.first >> 8);
        let num_rows = (span_y.last >> 8) - py + 1;
        let num = ((span_x.last >> 8) - px + 1) as usize * num_strata;
        let (ox, oy) = (px * 256, py * 256);
        let edge = |a: usize, b: usize| edge(x, y, a, b, [ox, oy]);
        let ((d01, c01, tie01), (d12, c12, _), (d20, c20, tie20)) = (edge(0, 1), edge(1, 2), edge(2, 0));
        let ((d23, c23, _), (d30, c30, tie30)) = (edge(2, 3), edge(3, 0));
        let (drawn0, drawn1) =
            (0u32.wrapping_sub(halves[0].is_drawn.into()), 0u32.wrapping_sub(halves[1].is_drawn.into()));
        let mut first_of_row = samples.region.pixel_ix(px, py) * num_strata;
        for row in 0..num_rows {
            for j in (0..num).step_by(LANES) {
                let first = first_of_row + j;
                let place = lanes.add(lanes.load(samples.places(), first), lanes.load(samples.steps(), j));
                let place = lanes.add2(place, lanes.splat(row << 24));
                let e01 = lanes.add(lanes.dot2(place, lanes.splat(d01)), lanes.splat(c01));
                let e12 = lanes.add(lanes.dot2(place, lanes.splat(d12)), lanes.splat(c12));
                let e20 = lanes.add(lanes.dot2(place, lanes.splat(d20)), lanes.splat(c20));
                let e23 = lanes.add(lanes.dot2(place, lanes.splat(d23)), lanes.splat(c23));
                let e30 = lanes.add(lanes.dot2(place, lanes.splat(d30)), lanes.splat(c30));
                let apart0 = lanes.or(lanes.xor(e01, e12), lanes.xor(e12, e20));
                let apart1 = lanes.or(lanes.xor(e23, e30), lanes.xor(e30, lanes.not(e20)));
                let zero = lanes.splat(0);
                let active = 0xffff_u32 >> (LANES - (num - j).min(LANES));
                let hit0 = !lanes.bits(lanes.gt(zero, apart0)) & active & drawn0;
                let hit1 = !lanes.bits(lanes.gt(zero, apart1)) & active & drawn1;
                if hit0 | hit1 == 0 {
                    continue;
                }
                self.counts.hits += u64::from((hit0 | hit1).count_ones());
                // Weights are those of the sample itself, on the edge where it is.
                let (w20, w01) = (lanes.add(e20, lanes.splat(tie20)), lanes.add(e01, lanes.splat(tie01)));
                let w30 = lanes.add(e30, lanes.splat(tie30));
                let points0 = points(lanes, &halves[0], z0, w20, w01);
                let points1 = points(lanes, &halves[1], z0, w30, lanes.sub(zero, w20));
                let turned = halves.map(|half| if half.area < 0 { 0xffff } else { 0 });
                let negative = (hit0 & turned[0]) | (hit1 & turned[1]);
                if hit0 & hit1 == 0 {
                    let mask = lanes.mask(hit0);
                    let points = HitPoints {
                        depth: lanes.select_f(mask, points0.depth, points1.depth),
                        weights: lanes.select(mask, points0.weights, points1.weights),
                    };
                    self.sink.hits(lanes, first, [hit0, hit1], points, negative);
                } else {
                    self.sink.hits(lanes, first, [hit0, 0], points0, hit0 & turned[0]);
                    self.sink.hits(lanes, first, [0, hit1], points1, hit1 & turned[1]);
                }
            }
            first_of_row += samples.region.width() * num_strata;
        }
    }
}

/// The edge function from vertex `a` to `b`, `A . s + C` for samples s relative to `origin`: A, C, and the 1 that C is
/// lowered by where a sample on the edge counts as negative.
#[inline(always)]
fn edge(x: [i32; 4], y: [i32; 4], a: usize, b: usize, [ox, oy]: [i32; 2]) -> (i32, i32, i32) {
    let (dx, dy) = (x[b] - x[a], y[b] - y[a]);
    let tie = i32::from(dy > 0 || (dy == 0 && dx < 0));
    (pair(-dy, dx), dy * (x[a] - ox) - dx * (y[a] - oy) - tie, tie)
}

/// Points from the weights of a triangle's second and third vertex, as [`super::inside::point_at`].
#[inline(always)]
fn points<L: Lanes>(lanes: L, half: &Half, z0: f32, w1: L::I, w2: L::I) -> HitPoints<L> {
    let [b1, b2] = upper_weights(lanes, w1, w2, lanes.splat_f(half.r));
    let first = lanes.add_f(lanes.splat_f(z0), lanes.mul_f(b1, lanes.splat_f(half.rise[0])));
    let depth = lanes.add_f(first, lanes.mul_f(b2, lanes.splat_f(half.rise[1])));
    let depth =
        lanes.lesser(lanes.greater(depth, lanes.splat_f(half.range[0])), lanes.splat_f(half.range[1]));
    HitPoints { depth, weights: weights(lanes, [b1, b2]) }
}

/// The twin, kept out of the kernel.
#[inline(never)]
fn draw_scalar<S: HitSink>(
    xy: [[i32; 2]; 4],
    z: [f32; 4],
    facing: Facing,
    samples: &RegionSamples,
    counts: &mut SampleCounts,
    sink: &mut S,
) {
    rasterize_quad(xy, z, facing, samples, counts, sink);
}
