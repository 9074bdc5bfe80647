//! What NoMotion in lanes has to know of a micropolygon, for 16 of them at a time.
//!
//! In: vertices of a grid that stands still. Out: a [`Setup`], whose lists have an entry a quad: the pixels that its box
//! overlaps, the edge functions and the planes of depth of its two triangles.

use super::nomotion::{Facing, GridView, SampleCounts};
use super::nomotion_lanes::MOST;
use super::region::RegionSamples;
use crate::math::lanes::Lanes;
use crate::math::simd::{LANES, load};

/// The corners of 16 quads, whose first vertices are side by side.
pub(super) struct Quads<L: Lanes> {
    x: [L::I; 4],
    y: [L::I; 4],
    z: [L::F; 4],
}

impl<L: Lanes> Quads<L> {
    /// Those from vertex `first` on; anything where there are no more vertices.
    #[inline(always)]
    pub fn new(lanes: L, grid: &GridView, first: usize) -> Self {
        let corners = [first, first + 1, first + grid.m + 2, first + grid.m + 1];
        let (mut x, mut y, mut z) = ([lanes.splat(0); 4], [lanes.splat(0); 4], [lanes.splat_f(0.0); 4]);
        for (corner, &at) in corners.iter().enumerate() {
            x[corner] = lanes.load(&load::<_, LANES>(grid.x, at), 0);
            y[corner] = lanes.load(&load::<_, LANES>(grid.y, at), 0);
            z[corner] = lanes.load_f(&load::<_, LANES>(grid.depth, at), 0);
        }
        Quads { x, y, z }
    }
}

/// Edge functions, `d . s + c` for samples s from the first pixel of the box on.
#[derive(Default)]
pub(super) struct Edges {
    /// Minus the edge's y and its x, a pair.
    pub d: [i32; LANES],
    pub c: [i32; LANES],
    /// The 1 that `c` is lowered by where a sample on the edge counts as negative.
    pub tie: [i32; LANES],
}

/// One of the two triangles of each quad.
#[derive(Default)]
pub(super) struct Halves {
    /// 1 / area.
    pub r: [f32; LANES],
    /// z1 - z0 and z2 - z0.
    pub rise: [[f32; LANES]; 2],
    /// Least and greatest depth.
    pub range: [[f32; LANES]; 2],
}

/// 16 quads; lists have an entry each, of those that are `tested`.
#[derive(Default)]
pub(super) struct Setup {
    /// Bits of the quads that have samples to test.
    pub tested: u32,
    /// Bits of those that are too large for 16 bits.
    pub large: u32,
    /// Bits of those whose first and second triangle can be hit.
    pub drawn: [u32; 2],
    /// Bits of those whose first and second triangle have an area below 0.
    pub negative: [u32; 2],
    /// Index in the region of the first pixel.
    pub pixel_ix: [i32; LANES],
    /// Pixels along x and y.
    pub num_px: [[i32; LANES]; 2],
    /// Of v0 v1, v1 v2, v2 v0, v2 v3 and v3 v0.
    pub edges: [Edges; 5],
    /// Depth of v0.
    pub depth: [f32; LANES],
    pub halves: [Halves; 2],
}

impl Setup {
    /// Sets up the quads that there are `some` of, and counts their tests and those that face away.
    #[inline(always)]
    pub fn set<L: Lanes>(
        &mut self,
        lanes: L,
        quads: &Quads<L>,
        facing: Facing,
        samples: &RegionSamples,
        some: u32,
        counts: &mut SampleCounts,
    ) {
        let Quads { x, y, z } = quads;
        let zero = lanes.splat(0);
        let ([x_least, x_most], [y_least, y_most]) = (range(lanes, x), range(lanes, y));
        let most = lanes.splat(MOST);
        let large_x = lanes.gt(lanes.sub(x_most, x_least), most);
        let large_y = lanes.gt(lanes.sub(y_most, y_least), most);
        self.large = lanes.bits(lanes.either(large_x, large_y)) & some;
        let areas = [cross(lanes, x, y, [0, 1, 2]), cross(lanes, x, y, [0, 2, 3])];
        let mut has_area = 0;
        for (half, &area) in areas.iter().enumerate() {
            let (above, below) = (lanes.bits(lanes.gt(area, zero)), lanes.bits(lanes.gt(zero, area)));
            has_area |= above | below;
            self.negative[half] = below;
            self.drawn[half] = match facing {
                Facing::Any => above | below,
                Facing::Only(side) if side > 0 => above,
                Facing::Only(_) => below,
            };
        }
        let some = some & !self.large;
        let drawn = self.drawn[0] | self.drawn[1];
        counts.backfacing += u64::from((some & has_area & !drawn).count_ones());
        let region = samples.region;
        let (first_x, last_x) = span(lanes, x, self.drawn, [region.x0, region.x1]);
        let (first_y, last_y) = span(lanes, y, self.drawn, [region.y0, region.y1]);
        let missed = lanes.either(lanes.gt(first_x, last_x), lanes.gt(first_y, last_y));
        self.tested = some & drawn & !lanes.bits(missed);
        if self.tested == 0 {
            return;
        }
        let (px, py) = (lanes.shr(first_x, 8), lanes.shr(first_y, 8));
        let (ox, oy) = (lanes.shl(px, 8), lanes.shl(py, 8));
        let cells_x = cells(lanes, lanes.sub(first_x, ox), lanes.sub(last_x, ox), samples.grid[0]);
        let cells_y = cells(lanes, lanes.sub(first_y, oy), lanes.sub(last_y, oy), samples.grid[1]);
        let tests = lanes.select(lanes.mask(self.tested), lanes.mul(cells_x, cells_y), zero);
        counts.tests += u64::from(lanes.sum(tests) as u32);
        let row = lanes.mul(lanes.sub(py, lanes.splat(region.y0)), lanes.splat(region.width() as i32));
        let pixel_ix = lanes.add(row, lanes.sub(px, lanes.splat(region.x0)));
        lanes.store(pixel_ix, &mut self.pixel_ix, 0);
        let one = lanes.splat(1);
        lanes.store(lanes.add(lanes.sub(lanes.shr(last_x, 8), px), one), &mut self.num_px[0], 0);
        lanes.store(lanes.add(lanes.sub(lanes.shr(last_y, 8), py), one), &mut self.num_px[1], 0);
        for (edge, [a, b]) in self.edges.iter_mut().zip([[0, 1], [1, 2], [2, 0], [2, 3], [3, 0]]) {
            let (dx, dy) = (lanes.sub(x[b], x[a]), lanes.sub(y[b], y[a]));
            let level = lanes.both(lanes.eq(dy, zero), lanes.gt(zero, dx));
            let tie = lanes.select(lanes.either(lanes.gt(dy, zero), level), one, zero);
            let minus_dy = lanes.and(lanes.sub(zero, dy), lanes.splat(0xffff));
            let c = lanes
                .sub(lanes.mul(dy, lanes.sub(x[a], ox)), lanes.add(lanes.mul(dx, lanes.sub(y[a], oy)), tie));
            lanes.store(lanes.or(minus_dy, lanes.shl(dx, 16)), &mut edge.d, 0);
            lanes.store(c, &mut edge.c, 0);
            lanes.store(tie, &mut edge.tie, 0);
        }
        lanes.store_f(z[0], &mut self.depth, 0);
        for (half, (area, [a, b])) in self.halves.iter_mut().zip(areas.into_iter().zip([[1, 2], [2, 3]])) {
            lanes.store_f(lanes.div_f(lanes.splat_f(1.0), lanes.to_f(area)), &mut half.r, 0);
            lanes.store_f(lanes.sub_f(z[a], z[0]), &mut half.rise[0], 0);
            lanes.store_f(lanes.sub_f(z[b], z[0]), &mut half.rise[1], 0);
            lanes.store_f(lanes.lesser(lanes.lesser(z[0], z[a]), z[b]), &mut half.range[0], 0);
            lanes.store_f(lanes.greater(lanes.greater(z[0], z[a]), z[b]), &mut half.range[1], 0);
        }
    }
}

/// Least and greatest of the corners.
#[inline(always)]
fn range<L: Lanes>(lanes: L, v: &[L::I; 4]) -> [L::I; 2] {
    let least = lanes.min(lanes.min(v[0], v[1]), lanes.min(v[2], v[3]));
    [least, lanes.max(lanes.max(v[0], v[1]), lanes.max(v[2], v[3]))]
}

/// Twice the areas of triangles.
#[inline(always)]
fn cross<L: Lanes>(lanes: L, x: &[L::I; 4], y: &[L::I; 4], [a, b, c]: [usize; 3]) -> L::I {
    let (bx, by) = (lanes.sub(x[b], x[a]), lanes.sub(y[b], y[a]));
    let (cx, cy) = (lanes.sub(x[c], x[a]), lanes.sub(y[c], y[a]));
    lanes.sub(lanes.mul(bx, cy), lanes.mul(by, cx))
}

/// First and last sub-pixel position along an axis at which the triangles that are drawn can be hit, within the region.
#[inline(always)]
fn span<L: Lanes>(lanes: L, v: &[L::I; 4], drawn: [u32; 2], region: [i32; 2]) -> (L::I, L::I) {
    let (mut least, mut most) = (lanes.min(v[0], v[2]), lanes.max(v[0], v[2]));
    for (drawn, v) in drawn.into_iter().zip([v[1], v[3]]) {
        let is_drawn = lanes.mask(drawn & 0xffff);
        least = lanes.select(is_drawn, lanes.min(least, v), least);
        most = lanes.select(is_drawn, lanes.max(most, v), most);
    }
    let first = lanes.max(least, lanes.splat(region[0] * 256));
    (first, lanes.min(lanes.sub(most, lanes.splat(1)), lanes.splat(region[1] * 256 - 1)))
}

/// Cells that a span overlaps, of `num` a pixel; positions are from the corner of a pixel on.
#[inline(always)]
fn cells<L: Lanes>(lanes: L, first: L::I, last: L::I, num: u32) -> L::I {
    let num = lanes.splat(num as i32);
    let (first, last) = (lanes.shr(lanes.mul(first, num), 8), lanes.shr(lanes.mul(last, num), 8));
    lanes.add(lanes.sub(last, first), lanes.splat(1))
}
