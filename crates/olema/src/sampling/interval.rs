//! Interval: bounds per stratum of time and lens. Best for little blur.
//!
//! In: a [`MovingDraw`]. Out: hits and counts. Source: Fatahalian 2009, section 3.2.1, after Cook, Porter and
//! Carpenter's patent of 1990.
//!
//! For each stratum the micropolygon is bounded over the stratum's range of time and its cell of the lens. In
//! each pixel that this box overlaps, the one sample of that stratum is tested exactly. Any K will do: how the
//! tuples of a stratum are dealt out to pixels does not matter. Twin in lanes: `interval_lanes`.

use super::draw::{Micropolygon, MovingDraw, Reach};
use super::moving::Extent;
use super::nomotion::{HitSink, SampleCounts};

/// Rasterizes a grid.
pub fn rasterize<S: HitSink>(draw: &MovingDraw, counts: &mut SampleCounts, sink: &mut S) {
    draw.for_each(counts, sink, |micropolygon, counts, sink| {
        rasterize_micropolygon(draw, micropolygon, counts, sink);
    });
}

/// Rasterizes a micropolygon.
#[inline(never)]
pub(super) fn rasterize_micropolygon(
    draw: &MovingDraw,
    micropolygon: &Micropolygon,
    counts: &mut SampleCounts,
    sink: &mut impl HitSink,
) {
    let strata = 0..draw.pattern.samples_per_pixel();
    for stratum in strata.filter(|&stratum| draw.has_stratum(stratum)) {
        let reach = Reach::of(&bound(draw, micropolygon, stratum));
        test_pixels(draw, micropolygon, stratum, reach, counts, sink);
    }
}

/// Bound of a micropolygon over a stratum.
fn bound(draw: &MovingDraw, micropolygon: &Micropolygon, stratum: u32) -> Extent {
    let cell = draw.pattern.stratum_bounds(stratum);
    let times = draw.grid.times.of_stratum(stratum);
    let mut bound = Extent::EMPTY;
    for vertex in micropolygon.vertices {
        bound.add(draw.grid.extent(vertex, times, &cell));
    }
    bound
}

/// Tests the stratum's sample of each pixel.
fn test_pixels(
    draw: &MovingDraw,
    micropolygon: &Micropolygon,
    stratum: u32,
    reach: Reach,
    counts: &mut SampleCounts,
    sink: &mut impl HitSink,
) {
    let samples = draw.samples;
    let [px_first, px_last] = reach.pixels(&samples.region, 0);
    let [py_first, py_last] = reach.pixels(&samples.region, 1);
    for py in py_first..=py_last {
        for px in px_first..=px_last {
            let sample_ix = samples.region.pixel_ix(px, py) * samples.samples_per_pixel() + stratum as usize;
            let tuple_ix = samples.tuples[sample_ix];
            let [x, y] = samples.offset(sample_ix);
            let place = [px * 256 + i32::from(x), py * 256 + i32::from(y)];
            let placed = micropolygon.place(tuple_ix);
            micropolygon.test(&placed, tuple_ix, sample_ix, place, counts, sink);
        }
    }
}
