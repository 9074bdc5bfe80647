//! NoMotion in lanes: 16 samples side by side.
//!
//! In: a grid that stands still, and the samples of a region. Out: the hits and counts of the scalar twin,
//! [`super::nomotion`]. Source: Fatahalian 2009, section 4.1, turned: a lane per sample instead of per micropolygon, since
//! the samples of a row of pixels lie side by side and nothing has to be gathered or scattered. 16 samples a pixel are
//! one pixel a vector, 4 are four pixels of a row.
//!
//! What is known of a micropolygon before its samples are looked at is found for 16 of them at a time (`nomotion_setup`).
//! Vertices and samples are taken relative to the first pixel of a micropolygon's box, in 16 bits; one of more than
//! [`MOST`] is drawn by the twin. The edge functions of both triangles are five, `A . s + C` with C lowered by 1 where a
//! sample on the edge counts as negative: then the sign bit alone decides. All samples of the pixels are tested; counted
//! are those of the cells that the box overlaps, as they are by the twin: no other can be hit.

use super::nomotion::{Facing, GridView, HitPoints, HitSink, SampleCounts, rasterize_quad};
use super::nomotion_setup::{Quads, Setup};
use super::region::{MOST_STEPS_PX, RegionSamples};
use super::test_lanes::{upper_weights, weights};
use crate::math::lanes::Lanes;
use crate::math::simd::{LANES, LanesKernel, SimdLevel};

/// Longest side of a box in 1/256 px.
pub(super) const MOST: i32 = 256 * (MOST_STEPS_PX as i32 - 1);

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
        let step = grid.m + 1;
        let mut setup = Setup::default();
        // Those side by side begin at vertices that are; the last vertex of a row begins none.
        let num = grid.n * step - 1;
        let (mut column, mut row) = (0, 0);
        for first in (0..num).step_by(LANES) {
            let (mut some, mut numbers) = (0, [0; LANES]);
            for (lane, number) in numbers.iter_mut().enumerate().take(num - first) {
                let vertex = first + lane;
                *number = (vertex - row) as u32;
                if column == grid.m {
                    (column, row) = (0, row + 1);
                    continue;
                }
                column += 1;
                let skipped = |skip: &[bool]| {
                    skip[vertex] || skip[vertex + 1] || skip[vertex + step] || skip[vertex + step + 1]
                };
                some |= u32::from(!self.skip.is_some_and(skipped)) << lane;
            }
            let quads = Quads::new(lanes, &grid, first);
            setup.set(lanes, &quads, self.facing, self.samples, some, self.counts);
            let mut large = setup.large;
            while large != 0 {
                let lane = large.trailing_zeros() as usize & (LANES - 1);
                self.sink.begin(numbers[lane]);
                self.draw_scalar(first + lane);
                large &= large - 1;
            }
            let mut left = setup.tested;
            while left != 0 {
                let lane = left.trailing_zeros() as usize & (LANES - 1);
                self.sink.begin(numbers[lane]);
                self.test_rows(lanes, &setup, lane);
                left &= left - 1;
            }
        }
    }
}

impl<S: HitSink> Kernel<'_, S> {
    /// Tests all samples of the pixels of a box, row by row.
    #[inline(always)]
    fn test_rows<L: Lanes>(&mut self, lanes: L, setup: &Setup, lane: usize) {
        let samples = self.samples;
        let num_strata = samples.samples_per_pixel();
        let num = setup.num_px[0][lane] as usize * num_strata;
        let [e01, e12, e20, e23, e30] = &setup.edges;
        let drawn = setup.drawn.map(|drawn| 0u32.wrapping_sub(drawn >> lane & 1));
        let mut first_of_row = setup.pixel_ix[lane] as usize * num_strata;
        for row in 0..setup.num_px[1][lane] {
            for j in (0..num).step_by(LANES) {
                let first = first_of_row + j;
                let place = lanes.add(lanes.load(samples.places(), first), lanes.load(samples.steps(), j));
                let place = lanes.add2(place, lanes.splat(row << 24));
                let f01 = lanes.add(lanes.dot2(place, lanes.splat(e01.d[lane])), lanes.splat(e01.c[lane]));
                let f12 = lanes.add(lanes.dot2(place, lanes.splat(e12.d[lane])), lanes.splat(e12.c[lane]));
                let f20 = lanes.add(lanes.dot2(place, lanes.splat(e20.d[lane])), lanes.splat(e20.c[lane]));
                let f23 = lanes.add(lanes.dot2(place, lanes.splat(e23.d[lane])), lanes.splat(e23.c[lane]));
                let f30 = lanes.add(lanes.dot2(place, lanes.splat(e30.d[lane])), lanes.splat(e30.c[lane]));
                let apart0 = lanes.or(lanes.xor(f01, f12), lanes.xor(f12, f20));
                let apart1 = lanes.or(lanes.xor(f23, f30), lanes.xor(f30, lanes.not(f20)));
                let zero = lanes.splat(0);
                let active = 0xffff_u32 >> (LANES - (num - j).min(LANES));
                let hit0 = !lanes.bits(lanes.gt(zero, apart0)) & active & drawn[0];
                let hit1 = !lanes.bits(lanes.gt(zero, apart1)) & active & drawn[1];
                if hit0 | hit1 == 0 {
                    continue;
                }
                self.counts.hits += u64::from((hit0 | hit1).count_ones());
                // Weights are those of the sample itself, on the edge where it is.
                let w20 = lanes.add(f20, lanes.splat(e20.tie[lane]));
                let w01 = lanes.add(f01, lanes.splat(e01.tie[lane]));
                let w30 = lanes.add(f30, lanes.splat(e30.tie[lane]));
                let negative = setup.negative.map(|negative| 0u32.wrapping_sub(negative >> lane & 1));
                // Where both triangles of a folded quad are hit, the second is for another turn.
                let mut turn = [hit0, hit1 & !hit0];
                while turn[0] | turn[1] != 0 {
                    let is_first = lanes.mask(turn[0]);
                    let w1 = lanes.select(is_first, w20, w30);
                    let w2 = lanes.select(is_first, w01, lanes.sub(zero, w20));
                    let points = points(lanes, setup, lane, is_first, [w1, w2]);
                    let negative = (turn[0] & negative[0]) | (turn[1] & negative[1]);
                    self.sink.hits(lanes, first, turn, points, negative);
                    turn = [0, turn[0] & hit1];
                }
            }
            first_of_row += samples.region.width() * num_strata;
        }
    }

    /// The twin, for the quad of a first vertex; kept out of the kernel.
    #[inline(never)]
    fn draw_scalar(&mut self, vertex: usize) {
        let grid = self.grid;
        let corners = [vertex, vertex + 1, vertex + grid.m + 2, vertex + grid.m + 1];
        let xy = corners.map(|v| [grid.x[v], grid.y[v]]);
        let depth = corners.map(|v| grid.depth[v]);
        rasterize_quad(xy, depth, self.facing, self.samples, self.counts, self.sink);
    }
}

/// Points from the weights of a triangle's second and third vertex, of the first or the second triangle, as
/// [`super::inside::point_at`].
#[inline(always)]
fn points<L: Lanes>(
    lanes: L,
    setup: &Setup,
    lane: usize,
    is_first: L::M,
    [w1, w2]: [L::I; 2],
) -> HitPoints<L> {
    let [a, b] = &setup.halves;
    let r = lanes.select_f(is_first, lanes.splat_f(a.r[lane]), lanes.splat_f(b.r[lane]));
    let [b1, b2] = upper_weights(lanes, w1, w2, r);
    let rise0 = lanes.select_f(is_first, lanes.splat_f(a.rise[0][lane]), lanes.splat_f(b.rise[0][lane]));
    let rise1 = lanes.select_f(is_first, lanes.splat_f(a.rise[1][lane]), lanes.splat_f(b.rise[1][lane]));
    let least = lanes.select_f(is_first, lanes.splat_f(a.range[0][lane]), lanes.splat_f(b.range[0][lane]));
    let most = lanes.select_f(is_first, lanes.splat_f(a.range[1][lane]), lanes.splat_f(b.range[1][lane]));
    let depth = lanes.add_f(lanes.splat_f(setup.depth[lane]), lanes.mul_f(b1, rise0));
    let depth = lanes.add_f(depth, lanes.mul_f(b2, rise1));
    let depth = lanes.lesser(lanes.greater(depth, least), most);
    HitPoints { depth, weights: weights(lanes, [b1, b2]) }
}
