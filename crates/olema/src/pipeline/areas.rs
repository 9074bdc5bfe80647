//! Areas of a grid's micropolygons, counted for the statistics.
//!
//! In: `Grid`. Out: a histogram by powers of two. Two triangles each, so that one that is folded counts as large as it is.

use crate::math::lanes::Lanes;
use crate::math::simd::{LANES, LanesKernel, SimdLevel};

use super::grid::Grid;

/// Doubled areas in 1/65536 square pixels: bit 17 is one pixel, which is bin 8.
const FIRST_BIT: i32 = 9;

/// Doubled areas of a grid that is no larger than this have 31 bits.
const MOST_APART_PX: f32 = 64.0;

/// Counts the areas of a grid's micropolygons as the shutter opens. Bin b holds those of 2^(b - 8) up to 2^(b - 7) pixels;
/// the first and the last hold what is smaller and larger, too. What has a vertex on the slow path is not counted.
pub fn count_areas(level: SimdLevel, grid: &Grid, histogram: &mut [u64; 16]) {
    let num = grid.num_vertices();
    let [x0, x1, y0, y1] = grid.sweep.first();
    let fits = x1 - x0 < MOST_APART_PX && y1 - y0 < MOST_APART_PX;
    let num_corners = grid.n as usize * (grid.m as usize + 1) - 1;
    let (x, y) = (&grid.on_raster.x[..num], &grid.on_raster.y[..num]);
    if grid.has_slow() || num_corners < LANES || !fits {
        (0..grid.num_micropolygons()).for_each(|ix| count_area(grid, ix, histogram));
    } else {
        level.run_lanes(AreasKernel { x, y, row: grid.m as usize + 1, num_corners, histogram });
    }
}

/// Counts the area of one micropolygon.
fn count_area(grid: &Grid, micropolygon: usize, histogram: &mut [u64; 16]) {
    if grid.is_slow(micropolygon) {
        return;
    }
    let [a, b, c, d] =
        grid.corners(micropolygon).map(|v| [i64::from(grid.on_raster.x[v]), i64::from(grid.on_raster.y[v])]);
    let twice = |p: [i64; 2], q: [i64; 2], r: [i64; 2]| {
        ((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])).unsigned_abs()
    };
    histogram[bin(twice(a, b, c) + twice(a, c, d))] += 1;
}

/// The bin of a doubled area.
#[inline(always)]
fn bin(doubled: u64) -> usize {
    if doubled == 0 { 0 } else { (doubled.ilog2() as i32 - FIRST_BIT).clamp(0, 15) as usize }
}

struct AreasKernel<'a> {
    x: &'a [i32],
    y: &'a [i32],
    /// Vertices of a row.
    row: usize,
    /// Vertices that have one above and to the right of them in the list.
    num_corners: usize,
    histogram: &'a mut [u64; 16],
}

impl LanesKernel for AreasKernel<'_> {
    type Output = ();

    // One lane per vertex v0. The last vertex of a row is no v0 and is left out, as is what the last group holds again.
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let AreasKernel { x, y, row, num_corners, histogram } = self;
        let (mut first, mut end_of_row) = (0, row - 1);
        while first < num_corners {
            let at = first.min(num_corners - LANES);
            let mut counted = u32::MAX >> (32 - LANES) & u32::MAX << (first - at);
            while end_of_row < at + LANES {
                counted &= !(1 << (end_of_row - at));
                end_of_row += row;
            }
            let doubled = doubled_areas(lanes, [x, y], row, at);
            count(lanes, doubled, lanes.mask(counted), histogram);
            first += LANES;
        }
    }
}

/// Doubled areas of the micropolygons with v0 from `at` on.
#[inline(always)]
fn doubled_areas<L: Lanes>(lanes: L, [x, y]: [&[i32]; 2], row: usize, at: usize) -> L::I {
    let (ax, ay) = (lanes.load(x, at), lanes.load(y, at));
    let (bx, by) = (lanes.sub(lanes.load(x, at + 1), ax), lanes.sub(lanes.load(y, at + 1), ay));
    let (cx, cy) = (lanes.sub(lanes.load(x, at + row + 1), ax), lanes.sub(lanes.load(y, at + row + 1), ay));
    let (dx, dy) = (lanes.sub(lanes.load(x, at + row), ax), lanes.sub(lanes.load(y, at + row), ay));
    lanes.add(twice(lanes, [bx, by], [cx, cy]), twice(lanes, [cx, cy], [dx, dy]))
}

/// Doubled area of a triangle, given two of its sides.
#[inline(always)]
fn twice<L: Lanes>(lanes: L, [px, py]: [L::I; 2], [qx, qy]: [L::I; 2]) -> L::I {
    let cross = lanes.sub(lanes.mul(px, qy), lanes.mul(py, qx));
    lanes.max(cross, lanes.sub(lanes.splat(0), cross))
}

/// Counts those of `doubled` that are `counted`. Micropolygons that lie together are about as large, so few bins are met.
#[inline(always)]
fn count<L: Lanes>(lanes: L, doubled: L::I, counted: L::M, histogram: &mut [u64; 16]) {
    let least = bin(lanes.least(lanes.select(counted, doubled, lanes.splat(i32::MAX))) as u64);
    let greatest = bin(lanes.greatest(lanes.select(counted, doubled, lanes.splat(0))) as u64);
    let mut left = lanes.bits(counted);
    for (bin, number) in histogram.iter_mut().enumerate().take(greatest).skip(least) {
        let beyond = lanes.gt(doubled, lanes.splat((1 << (bin as i32 + FIRST_BIT + 1)) - 1));
        let larger = lanes.bits(lanes.both(beyond, counted));
        *number += u64::from((left & !larger).count_ones());
        left = larger;
    }
    histogram[greatest] += u64::from(left.count_ones());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::place_lanes::Reach;
    use crate::math::hash::hash32;
    use crate::pipeline::grid::{GridKey, Look, extent};
    use crate::pipeline::sweep::Sweep;
    use crate::scene::{ShadingInterpolation, Sides};

    fn grid(m: u32, n: u32, size: u32) -> Grid {
        let key = GridKey { primitive: 0, patch: 0, path: 1, block: [0; 2] };
        let look = Look {
            interpolation: ShadingInterpolation::Smooth,
            sides: Sides::Two,
            front_is_positive: true,
            matte: false,
        };
        let num = ((m + 1) * (n + 1)) as usize;
        let mut grid = Grid { m, n, keys: 1, ..Grid::empty(key, look, num) };
        for vertex in 0..num as u32 {
            let jitter = |n: u32| (hash32(2 * vertex + n) % (size + 1)) as i32;
            grid.on_raster.x.push((vertex % (m + 1) * size) as i32 + jitter(0) - 9_000);
            grid.on_raster.y.push((vertex / (m + 1) * size) as i32 + jitter(1) + 70_000);
        }
        grid.depth.resize(num, 1.0);
        let reach = |values: &[i32]| [*values.iter().min().unwrap(), *values.iter().max().unwrap()];
        let reach =
            Reach { x: reach(&grid.on_raster.x), y: reach(&grid.on_raster.y), coc: [0; 2], near: 1.0 };
        grid.sweep = Sweep::of_keys(&[extent(&reach)], &[0.0]);
        grid
    }

    #[test]
    fn counts_are_the_twins_on_every_level() {
        for (m, n) in [(1, 1), (2, 3), (15, 1), (1, 16), (16, 1), (3, 7), (13, 13), (20, 9)] {
            for size in [0, 1, 40, 256, 700, 90_000] {
                let grid = grid(m, n, size);
                let mut twin = [0; 16];
                (0..grid.num_micropolygons()).for_each(|ix| count_area(&grid, ix, &mut twin));
                assert_eq!(twin.iter().sum::<u64>(), u64::from(m * n));
                for level in SimdLevel::all() {
                    let mut histogram = [0; 16];
                    count_areas(level, &grid, &mut histogram);
                    assert_eq!(histogram, twin, "{m} x {n} of {size} {level:?}");
                }
            }
        }
    }
}
