//! BoundingBox: one box for the whole shutter and lens. The plainest way, and the dearest under blur.
//!
//! In: a [`MovingDraw`], any K. Out: hits and counts. Source: Sattlecker 2015, section 3.3, figure 3.
//!
//! The box of all vertices at all keys is grown by the largest circle of confusion of any of them; every
//! sample in a sub-pixel cell that it overlaps is tested. Where nothing moves these are the samples of
//! NoMotion. Twin in lanes: `interval_lanes`.

use super::draw::{Micropolygon, MovingDraw, Reach};
use super::moving::Extent;
use super::nomotion::{HitSink, SampleCounts, cells_in_pixel};
use super::region::RegionSamples;

/// Rasterizes a grid.
pub fn rasterize<S: HitSink>(draw: &MovingDraw, counts: &mut SampleCounts, sink: &mut S) {
    draw.for_each(counts, sink, |micropolygon, counts, sink| {
        rasterize_micropolygon(draw, micropolygon, counts, sink);
    });
}

/// Tests the samples in a micropolygon's box.
#[inline(never)]
pub(super) fn rasterize_micropolygon(
    draw: &MovingDraw,
    micropolygon: &Micropolygon,
    counts: &mut SampleCounts,
    sink: &mut impl HitSink,
) {
    test_cells(draw, micropolygon, Reach::of(&bound(draw, micropolygon)), counts, sink);
}

/// Samples in the cells that a box overlaps.
pub(super) fn num_samples(samples: &RegionSamples, reach: Reach) -> u64 {
    let along = |axis: usize| {
        let [first, last] = reach.pixels(&samples.region, axis);
        let of_pixel = |px| {
            let (first, last) = cells_in_pixel(reach.first[axis], reach.last[axis], px, samples.grid[axis]);
            u64::from(last + 1 - first)
        };
        (first..=last).map(of_pixel).sum::<u64>()
    };
    along(0) * along(1)
}

/// Bound of a micropolygon over the shutter and the lens.
pub(super) fn bound(draw: &MovingDraw, micropolygon: &Micropolygon) -> Extent {
    let grid = &draw.grid;
    let mut bound = Extent::EMPTY;
    let mut greatest_coc = 0;
    for key in 0..grid.num_keys() {
        for vertex in micropolygon.vertices.map(|vertex| key * grid.num_vertices() + vertex) {
            bound.add(Extent::around(&[[grid.x[vertex], grid.y[vertex]]]));
            greatest_coc = greatest_coc.max(grid.coc.get(vertex).map_or(0, |coc| coc.abs()));
        }
    }
    Extent {
        least: bound.least.map(|least| least - greatest_coc),
        most: bound.most.map(|most| most + greatest_coc),
    }
}

/// Tests every sample in the cells that a box overlaps.
fn test_cells(
    draw: &MovingDraw,
    micropolygon: &Micropolygon,
    reach: Reach,
    counts: &mut SampleCounts,
    sink: &mut impl HitSink,
) {
    let samples = draw.samples;
    let [px_first, px_last] = reach.pixels(&samples.region, 0);
    let [py_first, py_last] = reach.pixels(&samples.region, 1);
    for py in py_first..=py_last {
        let (cy_first, cy_last) = cells_in_pixel(reach.first[1], reach.last[1], py, samples.grid[1]);
        for px in px_first..=px_last {
            let (cx_first, cx_last) = cells_in_pixel(reach.first[0], reach.last[0], px, samples.grid[0]);
            let first_of_pixel = samples.region.pixel_ix(px, py) * samples.samples_per_pixel();
            for cy in cy_first..=cy_last {
                for cx in cx_first..=cx_last {
                    let sample_ix = first_of_pixel + (cy * samples.grid[0] + cx) as usize;
                    let tuple_ix = samples.tuples[sample_ix];
                    let [x, y] = samples.offset(sample_ix);
                    let place = [px * 256 + i32::from(x), py * 256 + i32::from(y)];
                    let placed = micropolygon.place(tuple_ix);
                    micropolygon.test(&placed, tuple_ix, sample_ix, place, counts, sink);
                }
            }
        }
    }
}
