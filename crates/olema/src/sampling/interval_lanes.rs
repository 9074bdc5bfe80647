//! Interval and BoundingBox in lanes: bounds of 16 strata at a time or of all, then 16 samples side by side.
//!
//! In: a [`MovingDraw`] of one motion segment. Out: the hits and counts of the scalar twins, [`super::interval`] and
//! [`super::boundingbox`], in another order. Sources: Fatahalian 2009, section 3.2.1; Sattlecker 2015, section 3.3.
//!
//! ```text
//! bound   Interval: a lane per stratum, box over its time and lens; samples in it are counted
//!         BoundingBox: the twin's box
//! test    a lane per sample, over the rows of the union of these boxes: position for its tuple, exact test
//! ```
//!
//! The samples of a row lie side by side and know their time and lens place, so nothing is gathered. A sample that is
//! outside of its own stratum's box costs a lane and cannot be hit. What does not fit in 16 bits with all of its path and
//! circles of confusion, or has longer rows than [`MOST_STEPS_PX`] pixels, is drawn by the twin.

use super::draw::{Micropolygon, MovingDraw, Reach};
use super::nomotion::{HitSink, SampleCounts};
use super::packed::{Packed, PackedQuad, PackedVertex};
use super::region::MOST_STEPS_PX;
use super::stratum_lanes::StratumGroup;
use super::test_lanes::{Depths, Shape, test};
use super::{boundingbox, interval};
use crate::math::lanes::{Lanes, pair};
use crate::math::simd::{LANES, LanesKernel, SimdLevel};

/// 1 in both halves.
const ONE: i32 = 0x1_0001;

/// Whether the kernel can draw this grid.
pub(super) fn takes(draw: &MovingDraw) -> bool {
    !draw.grid.times.stratum_groups().is_empty()
}

/// Rasterizes a grid that [`takes`] allows.
pub(super) fn rasterize<S: HitSink>(
    level: SimdLevel,
    draw: &MovingDraw,
    bounds: Bounds,
    counts: &mut SampleCounts,
    sink: &mut S,
) {
    let num_strata = draw.pattern.samples_per_pixel();
    let mut looked_at = Vec::new();
    if bounds == Bounds::Strata && !(0..num_strata).all(|stratum| draw.has_stratum(stratum)) {
        let num = MOST_STEPS_PX * num_strata as usize + LANES;
        looked_at.extend((0..num).map(|j| i32::from(draw.has_stratum(j as u32 % num_strata))));
    }
    level.run_lanes(Kernel { draw, bounds, counts, sink, looked_at });
}

/// What is bounded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Bounds {
    /// Each stratum: Interval.
    Strata,
    /// The whole shutter and lens: BoundingBox.
    Whole,
}

/// Pixels relative to the origin of a packed grid, both ends inclusive, and how many samples of them the twin tests.
struct Boxed {
    first_px: [i32; 2],
    last_px: [i32; 2],
    tests: u64,
}

struct Kernel<'a, S> {
    draw: &'a MovingDraw<'a>,
    bounds: Bounds,
    counts: &'a mut SampleCounts,
    sink: &'a mut S,
    /// For the samples of a row of pixels 1 where the stratum is looked at; empty where all are.
    looked_at: Vec<i32>,
}

impl<S: HitSink> LanesKernel for Kernel<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, lanes: L) {
        let draw = self.draw;
        let grid = &draw.grid;
        let (mut whole, mut apart) = (Packed::default(), Packed::default());
        // All samples in a box are tested, also those of tuples that see the micropolygon at its other end.
        let fits = whole.pack(draw, std::iter::once(0..grid.num_vertices())) && whole.stays_near();
        for quad in 0..grid.m * grid.n {
            let corners = grid.corners(quad % grid.m, quad / grid.m);
            if draw.is_skipped(corners) {
                continue;
            }
            self.sink.begin(quad as u32);
            for micropolygon in draw.of_quad(corners).into_iter().flatten() {
                if micropolygon.faces_away() {
                    self.counts.backfacing += 1;
                    continue;
                }
                let is_drawn = if fits {
                    self.draw_quad(
                        lanes,
                        &micropolygon,
                        PackedQuad { packed: &whole, at: micropolygon.vertices },
                    )
                } else {
                    apart.pack(draw, micropolygon.vertices.into_iter().map(|vertex| vertex..vertex + 1))
                        && apart.stays_near()
                        && self.draw_quad(
                            lanes,
                            &micropolygon,
                            PackedQuad { packed: &apart, at: [0, 1, 2, 3] },
                        )
                };
                if is_drawn {
                    continue;
                }
                match self.bounds {
                    Bounds::Strata => {
                        interval::rasterize_micropolygon(draw, &micropolygon, self.counts, self.sink);
                    }
                    Bounds::Whole => {
                        boundingbox::rasterize_micropolygon(draw, &micropolygon, self.counts, self.sink);
                    }
                }
            }
        }
    }
}

impl<S: HitSink> Kernel<'_, S> {
    /// Draws a micropolygon, unless its rows are too long.
    #[inline(always)]
    fn draw_quad<L: Lanes>(&mut self, lanes: L, micropolygon: &Micropolygon, packed: PackedQuad) -> bool {
        let boxed = match self.bounds {
            Bounds::Strata => self.box_of_strata(lanes, packed),
            Bounds::Whole => self.whole_box(micropolygon, packed),
        };
        let Boxed { first_px, last_px, tests } = boxed;
        if tests == 0 {
            return true;
        }
        if last_px[0] - first_px[0] >= MOST_STEPS_PX as i32 {
            return false;
        }
        self.counts.tests += tests;
        self.test_rows(lanes, micropolygon, packed, first_px, last_px);
        true
    }

    /// The box of BoundingBox.
    #[inline(never)]
    fn whole_box(&self, micropolygon: &Micropolygon, packed: PackedQuad) -> Boxed {
        let region = &self.draw.samples.region;
        let reach = Reach::of(&boundingbox::bound(self.draw, micropolygon));
        let [ox, oy] = packed.frame(0).offset;
        let [px, py] = [0, 1].map(|axis| reach.pixels(region, axis));
        let (x, y) = (region.x0 + ox, region.y0 + oy);
        Boxed {
            first_px: [px[0] - x, py[0] - y],
            last_px: [px[1] - x, py[1] - y],
            tests: boundingbox::num_samples(self.draw.samples, reach),
        }
    }

    /// The union of the boxes of strata.
    #[inline(always)]
    fn box_of_strata<L: Lanes>(&self, lanes: L, packed: PackedQuad) -> Boxed {
        let mut boxed = Boxed { first_px: [i32::MAX; 2], last_px: [i32::MIN; 2], tests: 0 };
        for group in self.draw.grid.times.stratum_groups() {
            let (first, last, num) = self.bound(lanes, packed, group);
            let sums = lanes.sum(num) as u32;
            if sums == 0 {
                continue;
            }
            boxed.tests += u64::from(sums);
            let some = lanes.gt(num, lanes.splat(0));
            let (high, low) = (lanes.splat(i32::from(i16::MAX)), lanes.splat(i32::from(i16::MIN)));
            let halves = |v: L::I| [lanes.shr(lanes.shl(v, 16), 16), lanes.shr(v, 16)];
            let (first, last) = (halves(first), halves(last));
            for axis in 0..2 {
                let least = lanes.least(lanes.select(some, first[axis], high));
                let most = lanes.greatest(lanes.select(some, last[axis], low));
                boxed.first_px[axis] = boxed.first_px[axis].min(least);
                boxed.last_px[axis] = boxed.last_px[axis].max(most);
            }
        }
        boxed
    }

    /// First and last pixel of the boxes of 16 strata, and how many pixels they hold.
    #[inline(always)]
    fn bound<L: Lanes>(&self, lanes: L, packed: PackedQuad, group: &StratumGroup) -> (L::I, L::I, L::I) {
        let (t0, t1) = (lanes.load(&group.time[0], 0), lanes.load(&group.time[1], 0));
        let (lens0, lens1) = (lanes.load(&group.lens[0], 0), lanes.load(&group.lens[1], 0));
        let is_sharp = self.draw.grid.coc.is_empty();
        let mut least = lanes.splat(pair(i32::from(i16::MAX), i32::from(i16::MAX)));
        let mut most = lanes.splat(pair(i32::from(i16::MIN), i32::from(i16::MIN)));
        for corner in 0..4 {
            let vertex = packed.vertex(0, corner);
            let (place, motion) = (lanes.splat(vertex.place), lanes.splat(vertex.motion));
            let (a, b) = (lanes.scale2(t0, motion), lanes.scale2(t1, motion));
            let (mut low, mut high) = (lanes.min2(a, b), lanes.max2(a, b));
            if !is_sharp {
                let (coc, change) = (lanes.splat(vertex.coc), lanes.splat(vertex.coc_change));
                let c0 = lanes.add2(coc, lanes.scale2(t0, change));
                let c1 = lanes.add2(coc, lanes.scale2(t1, change));
                let (a, b) = (lanes.scale2(lens0, c0), lanes.scale2(lens1, c0));
                let (c, d) = (lanes.scale2(lens0, c1), lanes.scale2(lens1, c1));
                low = lanes.add2(low, lanes.min2(lanes.min2(a, b), lanes.min2(c, d)));
                high = lanes.add2(high, lanes.max2(lanes.max2(a, b), lanes.max2(c, d)));
            }
            least = lanes.min2(least, lanes.add2(place, low));
            most = lanes.max2(most, lanes.add2(place, high));
        }
        let frame = packed.frame(0);
        let first = lanes.max2(lanes.shr2(least, 8), lanes.splat(frame.first_px));
        let last = lanes.shr2(lanes.sub2(most, lanes.splat(ONE)), 8);
        let last = lanes.min2(last, lanes.splat(frame.last_px));
        // None where the box is empty or misses the region; else no more than there are positions.
        let num = lanes.add2(lanes.sub2(last, first), lanes.splat(ONE));
        // Up to 64,000: what 16 bits make negative of that is turned into something that is larger than any number of pixels.
        let positions = lanes.sub2(most, least);
        let positions = lanes.max2(positions, lanes.not(positions));
        let num = lanes.max2(lanes.min2(num, positions), lanes.splat(0));
        let num = lanes.dot2(num, lanes.and(lanes.shr(num, 16), lanes.splat(0xffff)));
        let [from, to] = self.draw.times;
        let early = lanes.gt(lanes.splat(from.into()), lanes.load(&group.shutter[1], 0));
        let late = lanes.gt(lanes.load(&group.shutter[0], 0), lanes.splat(to.into()));
        let unused = !(0xffff >> (LANES as u32 - group.num));
        let left_out = lanes.either(lanes.either(early, late), lanes.mask(unused & 0xffff));
        (first, last, lanes.select(left_out, lanes.splat(0), num))
    }

    /// Tests all samples of the pixels of a box, which are relative to the origin, row by row.
    #[inline(always)]
    fn test_rows<L: Lanes>(
        &mut self,
        lanes: L,
        micropolygon: &Micropolygon,
        packed: PackedQuad,
        first_px: [i32; 2],
        last_px: [i32; 2],
    ) {
        let samples = self.draw.samples;
        let [times, lens] = samples.times_and_lens(self.draw.pattern);
        let num_strata = samples.samples_per_pixel();
        let num = (last_px[0] - first_px[0] + 1) as usize * num_strata;
        let width = samples.region.width() as i32;
        let depths = Depths::of(micropolygon, 0);
        let shape = Shape::of(micropolygon.triangles, self.draw.facing);
        let is_still = self.draw.grid.num_keys() == 1;
        let mut vertices = [PackedVertex::default(); 4];
        for (corner, vertex) in vertices.iter_mut().enumerate() {
            *vertex = packed.vertex(0, corner);
        }
        for row in first_px[1]..=last_px[1] {
            let first_of_row = (packed.frame(0).pixel_ix + row * width + first_px[0]) as usize * num_strata;
            let corner_of_row = lanes.splat(pair(first_px[0] * 256, row * 256));
            for j in (0..num).step_by(LANES) {
                let first = first_of_row + j;
                let place = lanes.add2(lanes.load(samples.places(), first), lanes.load(samples.steps(), j));
                let place = lanes.add2(place, corner_of_row);
                let (time, lens) = (lanes.load(times, first), lanes.load(lens, first));
                let local = if is_still { lanes.splat(0) } else { time };
                let mut at = [lanes.splat(0); 4];
                for (at, vertex) in at.iter_mut().zip(&vertices) {
                    *at = position(lanes, vertex, local, lens);
                }
                let mut active = 0xffff_u32 >> (LANES - (num - j).min(LANES));
                if !self.looked_at.is_empty() {
                    active &= lanes.bits(lanes.gt(lanes.load(&self.looked_at, j), lanes.splat(0)));
                }
                let tested = test(lanes, shape, place, &at, active);
                let [hit0, hit1] = tested.hit;
                if hit0 | hit1 == 0 {
                    continue;
                }
                self.counts.hits += u64::from((hit0 | hit1).count_ones());
                let t = lanes.mul_f(lanes.to_f(lanes.shr(local, 16)), lanes.splat_f(1.0 / 32_768.0));
                let z = depths.all_at(lanes, t);
                let (points, negative) = tested.points(lanes, z, hit0);
                self.sink.hits(lanes, first, [hit0, hit1 & !hit0], points, negative);
                if hit0 & hit1 != 0 {
                    let (points, negative) = tested.points(lanes, z, 0);
                    self.sink.hits(lanes, first, [0, hit0 & hit1], points, negative);
                }
            }
        }
    }
}

/// Position of a vertex at local times, in both halves, and lens places.
#[inline(always)]
pub(super) fn position<L: Lanes>(lanes: L, vertex: &PackedVertex, time: L::I, lens: L::I) -> L::I {
    let moved = lanes.add2(lanes.splat(vertex.place), lanes.scale2(time, lanes.splat(vertex.motion)));
    if vertex.coc == 0 && vertex.coc_change == 0 {
        return moved;
    }
    let coc = lanes.add2(lanes.splat(vertex.coc), lanes.scale2(time, lanes.splat(vertex.coc_change)));
    lanes.add2(moved, lanes.scale2(lens, coc))
}
