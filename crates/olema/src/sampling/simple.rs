//! Simple: accumulation, for K = 1 alone.
//!
//! In: a [`MovingDraw`] with K = 1. Out: hits and counts. Source: Sattlecker 2015, section 3.3 (Simple UVT
//! Sampling), after the accumulation buffer of Haeberli and Akeley 1990.
//!
//! With K = 1 there are M tuples, and tuple j is sample j of every pixel: for each tuple the micropolygon is
//! placed and drawn as one that stands still, into sample j of the pixels that its box overlaps. The fastest
//! way, and the one that shows ghosts where M is small. In lanes it is InterleaveUvt's kernel that draws it.

use super::draw::{MovingDraw, Reach};
use super::moving::Extent;
use super::nomotion::{HitSink, SampleCounts};

/// Rasterizes a grid; K must be 1.
pub(super) fn rasterize<S: HitSink>(draw: &MovingDraw, counts: &mut SampleCounts, sink: &mut S) {
    let MovingDraw { pattern, samples, .. } = draw;
    debug_assert_eq!(pattern.tile(), 1);
    draw.for_each(counts, sink, |micropolygon, counts, sink| {
        for (j, tuple) in pattern.tuples().iter().enumerate().filter(|&(j, _)| draw.has_tuple(j as u32)) {
            let placed = micropolygon.place(j as u32);
            let reach = Reach::of(&Extent::around(&placed));
            let [px_first, px_last] = reach.pixels(&samples.region, 0);
            let [py_first, py_last] = reach.pixels(&samples.region, 1);
            for py in py_first..=py_last {
                for px in px_first..=px_last {
                    let sample_ix = samples.region.pixel_ix(px, py) * samples.samples_per_pixel() + j;
                    let place = [px * 256 + i32::from(tuple.x), py * 256 + i32::from(tuple.y)];
                    micropolygon.test(&placed, j as u32, sample_ix, place, counts, sink);
                }
            }
        }
    });
}
