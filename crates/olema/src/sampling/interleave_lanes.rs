//! InterleaveUvt in lanes: 16 micropolygons of a grid at a time, tuple after tuple, exact in 16 bits.
//!
//! In: a [`MovingDraw`]. Out: the hits of the scalar twin, [`super::interleave`], in another order, and its counts but for
//! tests that are left out. Source: Fatahalian 2009, section 3.2.2.
//!
//! ```text
//! for each tuple for which the part can be in the region, found 16 at a time
//!     place    a lane per vertex: where it is
//!     find     a lane per quad: the pixels whose place for the tuple is in its box, and of these the ones that hold the
//!              tuple (`super::rows`); what it takes to test them is listed
//!     gather   what it takes to test each of the list
//! now and then
//!     test     a lane per entry of all lists (`super::test_lanes`); hits go to the sink
//! ```
//!
//! A tuple is at one place in a tile, but which of its K^2 pixels is up to the tile's permutation. Its place within the
//! pixel is not. So of the pixels in a box only those are looked at whose place for the tuple is in the box, and of these
//! only the ones that hold the tuple: no more is listed than has to be tested, half of which hits; the twin tests one
//! sample in every tile that the box overlaps. Which pixels hold it is 16 rows of 32 pixels in one vector, looked up
//! without a load, as the quads of a grid are near each other for a given tuple. The other way round (a lane per tuple,
//! one quad after the other) each vertex was placed four times and every tuple's bits had to be loaded lane by lane.
//!
//! What moves too far for 16 bits ([`super::packed`]) is placed in 32 and has an origin for each tuple. What is too large
//! for 16 bits is halved until it is not; a single quad that is, is drawn by the twin.

mod boxes;
mod extents;
mod listed;
mod part;
mod pending;
mod tuple;
mod wide;

use std::cell::Cell;

use super::draw::MovingDraw;
use super::interleave;
use super::nomotion::{HitSink, SampleCounts};
use super::rows::TupleRows;
use crate::math::lanes::Lanes;
use crate::math::simd::{LANES, LanesKernel, SimdLevel};
use extents::Extents;
use part::{OfShape, Part, Rectangle};
use tuple::{OfTuple, Scratch};

/// Whether the kernel can draw with this pattern and region.
pub(super) fn takes(draw: &MovingDraw) -> bool {
    draw.pattern.tile() <= interleave::MAX_TILE
        && draw.samples.region.width() < 1 << 15
        && draw.samples.rows(draw.pattern).is_some()
}

/// Rasterizes a grid that [`takes`] allows.
pub(super) fn rasterize<S: HitSink>(
    level: SimdLevel,
    draw: &MovingDraw,
    counts: &mut SampleCounts,
    sink: &mut S,
) {
    let Some(rows) = draw.samples.rows(draw.pattern) else { return };
    level.run_lanes(Kernel { draw, rows, counts, sink });
}

/// Lists that a draw leaves to the next one of its thread: grids are many and small.
#[derive(Default)]
struct Memory {
    part: Part,
    micropolygons: [OfShape; 2],
    scratch: Scratch,
    rectangles: Vec<Rectangle>,
}

thread_local! {
    static MEMORY: Cell<Memory> = Cell::default();
}

struct Kernel<'a, S> {
    draw: &'a MovingDraw<'a>,
    rows: &'a TupleRows,
    counts: &'a mut SampleCounts,
    sink: &'a mut S,
}

impl<S: HitSink> LanesKernel for Kernel<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Kernel { draw, rows, counts, sink } = self;
        let mut memory = MEMORY.take();
        let Memory { part, micropolygons, scratch, rectangles } = &mut memory;
        rectangles.push([[0, draw.grid.m], [0, draw.grid.n]]);
        while let Some(rectangle) = rectangles.pop() {
            if !part.pack(draw, rectangle) {
                match halves(rectangle) {
                    Some(halves) => rectangles.extend(halves),
                    None => draw_scalar(draw, rectangle, counts, sink),
                }
                continue;
            }
            part.micropolygons(draw, counts, micropolygons);
            for of_shape in micropolygons.iter().filter(|of_shape| of_shape.shape.is_some()) {
                scratch.renew(part);
                for (ix, segment) in part.packed.segments.iter().enumerate() {
                    let places = draw.grid.times.in_order().places(ix, draw.times);
                    for first in places.clone().step_by(LANES) {
                        let active = 0xffff >> LANES.saturating_sub(places.end - first);
                        let mut extents = Extents::new(lanes, draw, segment, first, active);
                        while extents.some != 0 {
                            let lane = extents.some.trailing_zeros() as usize;
                            extents.some &= extents.some - 1;
                            let mut tuple = OfTuple::new(draw, rows, part, of_shape, segment, first + lane);
                            tuple.draw(lanes, extents.pixels(lane), scratch, counts, sink);
                        }
                    }
                }
                scratch.pending.test(lanes, part, of_shape, counts, sink);
            }
        }
        MEMORY.set(memory);
    }
}

/// Two halves of more than one quad, along its longer side.
fn halves([i, j]: Rectangle) -> Option<[Rectangle; 2]> {
    let (m, n) = (i[1] - i[0], j[1] - j[0]);
    if m * n <= 1 {
        return None;
    }
    Some(if m >= n {
        [[[i[0], i[0] + m / 2], j], [[i[0] + m / 2, i[1]], j]]
    } else {
        [[i, [j[0], j[0] + n / 2]], [i, [j[0] + n / 2, j[1]]]]
    })
}

/// The twin, for a single quad; kept out of the kernel.
#[inline(never)]
fn draw_scalar<S: HitSink>(draw: &MovingDraw, [i, j]: Rectangle, counts: &mut SampleCounts, sink: &mut S) {
    let corners = draw.grid.corners(i[0], j[0]);
    if draw.is_skipped(corners) {
        return;
    }
    sink.begin((j[0] * draw.grid.m + i[0]) as u32);
    let tuples = interleave::tuples(draw);
    for micropolygon in draw.of_quad(corners).into_iter().flatten() {
        if micropolygon.faces_away() {
            counts.backfacing += 1;
        } else {
            interleave::rasterize_micropolygon(draw, &micropolygon, &tuples, counts, sink);
        }
    }
}
