//! A part of a grid for one tuple: places, boxes, and the pixels to test.

use super::listed::{Listed, MOST_LISTED, list};
use super::part::{OfShape, Part};
use crate::math::lanes::{Lanes, pair};
use crate::math::simd::LANES;
use crate::sampling::draw::{MovingDraw, Reach};
use crate::sampling::interleave;
use crate::sampling::moving::{Extent, LocalTime};
use crate::sampling::nomotion::{HitSink, SampleCounts};
use crate::sampling::packed::{Frame, PackedSegment};
use crate::sampling::pattern::Tuple;
use crate::sampling::rows::{TupleRows, WORD_PX, WORD_STEP_PX};
use crate::sampling::test_lanes::depth_between;

/// 1 in both halves.
const ONE: i32 = 0x1_0001;
/// The sign bits of pairs.
const SIGNS: i32 = 0x8000_8000_u32 as i32;

/// What is kept between the steps.
#[derive(Default)]
pub(super) struct Scratch {
    /// Where vertices are for a tuple, with room for a vector and a row.
    pub(super) at: Vec<i32>,
    /// The same in 32 bits, where it takes these.
    pub(super) wide: [Vec<i32>; 2],
    /// Their depths.
    pub(super) depth: Vec<f32>,
    pub(super) listed: Listed,
}

impl Scratch {
    pub(super) fn renew(&mut self, part: &Part) {
        let len = part.num + part.m + 2 + 2 * LANES;
        self.at.resize(len, 0);
        self.wide.iter_mut().for_each(|wide| wide.resize(len, 0));
        self.depth.resize(len, 0.0);
    }
}
/// What a part is for one tuple.
pub(super) struct OfTuple<'a> {
    pub(super) draw: &'a MovingDraw<'a>,
    rows: &'a TupleRows,
    pub(super) part: &'a Part,
    pub(super) of_shape: &'a OfShape,
    pub(super) segment: &'a PackedSegment,
    /// Where positions are packed; of the segment, or of this tuple.
    pub(super) frame: Frame,
    tuple_ix: u32,
    pub(super) tuple: Tuple,
    pub(super) time: LocalTime,
    /// In the order of time.
    place_in_time: usize,
    pub(super) stratum: i32,
}

/// 16 quads.
struct Boxed<L: Lanes> {
    /// First vertex of the first one.
    first: usize,
    /// Lanes that are looked at.
    active: u32,
    /// Least and greatest position of the corners.
    least: L::I,
    most: L::I,
    /// First and last pixel that the box overlaps, within the region.
    first_px: L::I,
    last_px: L::I,
}

/// Pixels whose place for the tuple is in a box: the first, and how many more there are along x and y.
#[derive(Clone, Copy)]
struct Pixels<L: Lanes> {
    first: L::I,
    steps: L::I,
    /// Lanes in which there are any.
    some: u32,
}

/// The bits of 16 rows of 32 pixels from `corner` on, a pair.
#[derive(Clone, Copy)]
struct Held<L: Lanes> {
    words: L::I,
    corner: i32,
}

impl<'a> OfTuple<'a> {
    pub(super) fn new(
        draw: &'a MovingDraw<'a>,
        rows: &'a TupleRows,
        part: &'a Part,
        of_shape: &'a OfShape,
        tuple_ix: u32,
        place_in_time: usize,
    ) -> Self {
        let time = draw.grid.times.of_tuple(tuple_ix);
        OfTuple {
            draw,
            rows,
            part,
            of_shape,
            segment: &part.packed.segments[usize::from(time.segment)],
            frame: part.packed.segments[usize::from(time.segment)].frame,
            tuple_ix,
            tuple: draw.pattern.tuples()[tuple_ix as usize],
            time,
            place_in_time,
            stratum: (tuple_ix / (draw.pattern.tile() * draw.pattern.tile())) as i32,
        }
    }

    #[inline(always)]
    pub(super) fn draw<L: Lanes, S: HitSink>(
        &mut self,
        lanes: L,
        scratch: &mut Scratch,
        counts: &mut SampleCounts,
        sink: &mut S,
    ) {
        let (least, most) = match &self.segment.wide {
            Some(wide) => self.place_wide(lanes, wide, scratch),
            None => self.place(lanes, scratch),
        };
        // Pixels that the part can overlap.
        let [x0, x1] = [lanes.least(lanes.shl(least, 16)) >> 24, lanes.greatest(lanes.shl(most, 16)) >> 24];
        let [y0, y1] = [lanes.least(least) >> 24, lanes.greatest(most) >> 24];
        if self.misses([x0, x1, y0, y1]) {
            return;
        }
        self.place_depth(lanes, scratch);
        let held = self.held(lanes, [x0, x1, y0, y1]);
        let is_cut = !self.is_whole([x0, x1, y0, y1]);
        let mut tests = lanes.splat(0);
        for (ix, &some) in self.of_shape.some.iter().enumerate().filter(|(_, some)| **some != 0) {
            let boxed = self.boxed(lanes, scratch, ix * LANES, some);
            tests = lanes.add(tests, self.count(lanes, &boxed, is_cut, counts));
            let pixels = self.narrow(lanes, &boxed);
            if pixels.some == 0 {
                continue;
            }
            let is_wide = lanes.gt(lanes.and(pixels.steps, lanes.splat(0x7ff0)), lanes.splat(0));
            let is_wide = lanes.bits(is_wide) & pixels.some != 0;
            let held = if held.is_some() { held } else { self.held_of(lanes, &pixels) };
            match held.filter(|_| !is_wide) {
                Some(held) => self.find(lanes, &boxed, &pixels, held, scratch, counts, sink),
                None => self.find_one_by_one(lanes, &boxed, &pixels, scratch, counts, sink),
            }
        }
        self.test(lanes, scratch, counts, sink);
        counts.tests += u64::from(lanes.sum(tests) as u32);
    }

    /// Places the vertices; least and greatest of the positions.
    #[inline(always)]
    fn place<L: Lanes>(&self, lanes: L, scratch: &mut Scratch) -> (L::I, L::I) {
        let PackedSegment { place, motion, coc, coc_change, .. } = self.segment;
        let t15 = i32::from(self.time.t15);
        let time = lanes.splat(pair(t15, t15));
        let lens = lanes.splat(pair(self.tuple.u15.into(), self.tuple.v15.into()));
        let mut least = lanes.splat(pair(i32::from(i16::MAX), i32::from(i16::MAX)));
        let mut most = lanes.splat(pair(i32::from(i16::MIN), i32::from(i16::MIN)));
        // All of the same length: nothing is checked within the loops.
        let len = self.part.num.next_multiple_of(LANES);
        let out = scratch.at[..len].chunks_exact_mut(LANES);
        let from = place[..len].chunks_exact(LANES).zip(motion[..len].chunks_exact(LANES));
        if self.segment.is_sharp {
            for (out, (place, motion)) in out.zip(from) {
                let at = lanes.add2(lanes.load(place, 0), lanes.scale2(time, lanes.load(motion, 0)));
                lanes.store(at, out, 0);
                (least, most) = (lanes.min2(least, at), lanes.max2(most, at));
            }
        } else {
            let cocs = coc[..len].chunks_exact(LANES).zip(coc_change[..len].chunks_exact(LANES));
            for ((out, (place, motion)), (coc, change)) in out.zip(from).zip(cocs) {
                let at = lanes.add2(lanes.load(place, 0), lanes.scale2(time, lanes.load(motion, 0)));
                let coc = lanes.add2(lanes.load(coc, 0), lanes.scale2(time, lanes.load(change, 0)));
                let at = lanes.add2(at, lanes.scale2(lens, coc));
                lanes.store(at, out, 0);
                (least, most) = (lanes.min2(least, at), lanes.max2(most, at));
            }
        }
        (least, most)
    }

    /// Depths of the vertices.
    #[inline(always)]
    fn place_depth<L: Lanes>(&self, lanes: L, scratch: &mut Scratch) {
        let t = lanes.splat_f(f32::from(self.time.t15) * (1.0 / 32_768.0));
        let (len, depth) = (self.part.num.next_multiple_of(LANES), &self.segment.depth);
        let from = depth[0][..len].chunks_exact(LANES).zip(depth[1][..len].chunks_exact(LANES));
        for (out, (z0, z1)) in scratch.depth[..len].chunks_exact_mut(LANES).zip(from) {
            lanes.store_f(depth_between(lanes, lanes.load_f(z0, 0), lanes.load_f(z1, 0), t), out, 0);
        }
    }

    /// The rows of pixels `[x0, x1, y0, y1]`, both ends inclusive, as far as these are in the region; nothing where they
    /// are too many for a vector.
    #[inline(always)]
    fn held<L: Lanes>(&self, lanes: L, [x0, x1, y0, y1]: [i32; 4]) -> Option<Held<L>> {
        let (region, [ox, oy]) = (self.draw.samples.region, self.frame.offset);
        let [x0, y0] = [(x0 + ox).max(0), (y0 + oy).max(0)];
        let [x1, y1] = [(x1 + ox).min(region.width() as i32 - 1), (y1 + oy).min(region.height() as i32 - 1)];
        let corner_x = x0 & -WORD_STEP_PX;
        if x0 > x1 || y0 > y1 || x1 - corner_x >= WORD_PX || y1 - y0 >= LANES as i32 {
            return None;
        }
        let words = self.rows.column(self.place_in_time, (corner_x / WORD_STEP_PX) as usize);
        Some(Held { words: lanes.load(words, y0 as usize), corner: pair(corner_x - ox, y0 - oy) })
    }

    /// The rows of some pixels.
    #[inline(always)]
    fn held_of<L: Lanes>(&self, lanes: L, pixels: &Pixels<L>) -> Option<Held<L>> {
        let some = lanes.mask(pixels.some);
        let last = lanes.add2(pixels.first, pixels.steps);
        let (high, low) = (lanes.splat(i32::MAX), lanes.splat(i32::MIN));
        let x0 = lanes.least(lanes.select(some, lanes.shl(pixels.first, 16), high)) >> 16;
        let x1 = lanes.greatest(lanes.select(some, lanes.shl(last, 16), low)) >> 16;
        let y0 = lanes.least(lanes.select(some, pixels.first, high)) >> 16;
        let y1 = lanes.greatest(lanes.select(some, last, low)) >> 16;
        self.held(lanes, [x0, x1, y0, y1])
    }

    /// Whether none of the pixels `[x0, x1, y0, y1]` is in the region.
    fn misses(&self, [x0, x1, y0, y1]: [i32; 4]) -> bool {
        let (region, [ox, oy]) = (self.draw.samples.region, self.frame.offset);
        x1 + ox < 0 || y1 + oy < 0 || x0 + ox >= region.width() as i32 || y0 + oy >= region.height() as i32
    }

    /// Whether no tile that pixels `[x0, x1, y0, y1]` overlap is cut by the border of the region.
    fn is_whole(&self, [x0, x1, y0, y1]: [i32; 4]) -> bool {
        let (region, [ox, oy]) = (self.draw.samples.region, self.frame.offset);
        let k = self.draw.pattern.tile() as i32;
        // In the full frame. A border between tiles cuts none.
        let whole = |first: i32, last: i32, start: i32, end: i32| {
            (start & (k - 1) == 0 || (first & -k) >= start) && (end & (k - 1) == 0 || (last | (k - 1)) < end)
        };
        whole(x0 + ox + region.x0, x1 + ox + region.x0, region.x0, region.x1)
            && whole(y0 + oy + region.y0, y1 + oy + region.y0, region.y0, region.y1)
    }

    /// The boxes of the quads from `first` on.
    #[inline(always)]
    fn boxed<L: Lanes>(&self, lanes: L, scratch: &Scratch, first: usize, active: u32) -> Boxed<L> {
        let mut at = [lanes.splat(0); 4];
        for (at, corner) in at.iter_mut().zip(self.of_shape.corners) {
            *at = lanes.load(&scratch.at, first + corner);
        }
        let least = lanes.min2(lanes.min2(at[0], at[1]), lanes.min2(at[2], at[3]));
        let most = lanes.max2(lanes.max2(at[0], at[1]), lanes.max2(at[2], at[3]));
        let frame = &self.frame;
        let first_px = lanes.max2(lanes.shr2(least, 8), lanes.splat(frame.first_px));
        let last_px = lanes.shr2(lanes.sub2(most, lanes.splat(ONE)), 8);
        let last_px = lanes.min2(last_px, lanes.splat(frame.last_px));
        Boxed { first, active, least, most, first_px, last_px }
    }

    /// Number of samples that the twin tests in each lane: one for each tile that the box overlaps.
    ///
    /// Where a tile is cut by the border of the region its sample may lie beyond: such lanes are counted one by one.
    #[inline(always)]
    fn count<L: Lanes>(&self, lanes: L, boxed: &Boxed<L>, is_cut: bool, counts: &mut SampleCounts) -> L::I {
        let (zero, one) = (lanes.splat(0), lanes.splat(ONE));
        let k = self.draw.pattern.tile() as i32;
        let log = k.trailing_zeros();
        let (first, last) = (lanes.shr2(boxed.first_px, log), lanes.shr2(boxed.last_px, log));
        let num_px = lanes.add2(lanes.sub2(boxed.last_px, boxed.first_px), one);
        let num = lanes.add2(lanes.sub2(last, first), one);
        // None where the box is empty or misses the region; else there are no more tiles than pixels than positions.
        let num = lanes.min2(num, lanes.min2(num_px, lanes.sub2(boxed.most, boxed.least)));
        let num = lanes.max2(num, zero);
        let product = lanes.dot2(num, lanes.and(lanes.shr(num, 16), lanes.splat(0xffff)));
        let mut counted = boxed.active;
        if is_cut && log > 0 {
            // Tiles that lie in the region as a whole; origins are whole tiles.
            let frame = &self.frame;
            let whole_first = lanes.add2(lanes.splat(frame.first_px), lanes.splat((k - 1) * ONE));
            let whole_last = lanes.add2(lanes.splat(frame.last_px), one);
            let whole_first = lanes.shr2(whole_first, log);
            let whole_last = lanes.sub2(lanes.shr2(whole_last, log), one);
            let before = lanes.xor(first, lanes.max2(first, whole_first));
            let after = lanes.xor(last, lanes.min2(last, whole_last));
            let cut = !lanes.bits(lanes.eq(lanes.or(before, after), zero));
            let mut apart = cut & counted & lanes.bits(lanes.gt(product, zero));
            counted &= !apart;
            while apart != 0 {
                let quad = self.part.quads[boxed.first + apart.trailing_zeros() as usize] as usize;
                counts.tests += tests_of_tuple(self.draw, quad, self.of_shape.number, self.tuple_ix);
                apart &= apart - 1;
            }
        }
        lanes.select(lanes.mask(counted), product, zero)
    }

    /// The pixels whose place for the tuple is in the boxes.
    #[inline(always)]
    fn narrow<L: Lanes>(&self, lanes: L, boxed: &Boxed<L>) -> Pixels<L> {
        let place = pair(self.tuple.x.into(), self.tuple.y.into());
        // Not before the least, before the greatest position.
        let to_first = pair(255 - i32::from(self.tuple.x), 255 - i32::from(self.tuple.y));
        let first = lanes.shr2(lanes.add2(boxed.least, lanes.splat(to_first)), 8);
        let first = lanes.max2(first, boxed.first_px);
        let last = lanes.shr2(lanes.sub2(boxed.most, lanes.splat(place + ONE)), 8);
        let steps = lanes.sub2(lanes.min2(last, boxed.last_px), first);
        let has_pixels = lanes.eq(lanes.and(steps, lanes.splat(SIGNS)), lanes.splat(0));
        Pixels { first, steps, some: lanes.bits(has_pixels) & boxed.active }
    }

    /// Lists those of the pixels that hold the tuple.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    fn find<L: Lanes, S: HitSink>(
        &self,
        lanes: L,
        boxed: &Boxed<L>,
        pixels: &Pixels<L>,
        held: Held<L>,
        scratch: &mut Scratch,
        counts: &mut SampleCounts,
        sink: &mut S,
    ) {
        let (zero, low) = (lanes.splat(0), lanes.splat(0xffff));
        let some = lanes.mask(pixels.some);
        let from = lanes.sub2(pixels.first, lanes.splat(held.corner));
        let (from_x, from_y) = (lanes.and(from, low), lanes.shr(from, 16));
        let steps = lanes.select(some, pixels.steps, zero);
        let (steps_x, steps_y) = (lanes.and(steps, low), lanes.shr(steps, 16));
        let columns = lanes.sub(lanes.shl_each(lanes.splat(2), steps_x), lanes.splat(1));
        let columns = lanes.select(some, columns, zero);
        // Two rows of up to 16 pixels at a time.
        let mut y = 0;
        loop {
            let row = lanes.add(from_y, lanes.splat(y));
            let here = lanes.and(lanes.shr_each(lanes.lookup(held.words, row), from_x), columns);
            let here = lanes.select(lanes.gt(steps_y, lanes.splat(y - 1)), here, zero);
            let row = lanes.add(row, lanes.splat(1));
            let below = lanes.and(lanes.shr_each(lanes.lookup(held.words, row), from_x), columns);
            let below = lanes.select(lanes.gt(steps_y, lanes.splat(y)), below, zero);
            let mut left = lanes.or(here, lanes.shl(below, 16));
            loop {
                let none = lanes.bits(lanes.eq(left, zero));
                if none == 0xffff {
                    break;
                }
                let lowest = lanes.and(left, lanes.sub(zero, left));
                left = lanes.xor(left, lowest);
                // The number of a bit is the exponent of its value.
                let exponent = lanes.shr(lanes.bits_of(lanes.to_f(lowest)), 23);
                let number = lanes.sub(lanes.and(exponent, lanes.splat(0xff)), lanes.splat(127));
                let (x, is_below) = (lanes.and(number, lanes.splat(15)), lanes.and(number, lanes.splat(16)));
                let pixel = lanes.add2(pixels.first, lanes.or(x, lanes.shl(is_below, 12)));
                let pixel = lanes.add2(pixel, lanes.splat(y << 16));
                list(lanes, boxed.first, pixel, 0xffff & !none, &mut scratch.listed);
                if scratch.listed.len > MOST_LISTED - LANES {
                    self.test(lanes, scratch, counts, sink);
                }
            }
            y += 2;
            if lanes.bits(lanes.gt(steps_y, lanes.splat(y - 1))) == 0 {
                return;
            }
        }
    }

    /// As [`Self::find`], pixel by pixel, where these are too far from each other.
    #[inline(always)]
    fn find_one_by_one<L: Lanes, S: HitSink>(
        &self,
        lanes: L,
        boxed: &Boxed<L>,
        pixels: &Pixels<L>,
        scratch: &mut Scratch,
        counts: &mut SampleCounts,
        sink: &mut S,
    ) {
        let (mut first, mut steps) = ([0; LANES], [0; LANES]);
        lanes.store(pixels.first, &mut first, 0);
        lanes.store(pixels.steps, &mut steps, 0);
        let halves = |v: i32| [i32::from(v as i16), v >> 16];
        let [ox, oy] = self.frame.offset;
        let mut some = pixels.some;
        while some != 0 {
            let lane = some.trailing_zeros() as usize & (LANES - 1);
            some &= some - 1;
            let ([x0, y0], [steps_x, steps_y]) = (halves(first[lane]), halves(steps[lane]));
            for (y, x) in (y0..=y0 + steps_y).flat_map(|y| (x0..=x0 + steps_x).map(move |x| (y, x))) {
                let [column, bit] = [(x + ox) / WORD_STEP_PX, (x + ox) % WORD_STEP_PX];
                let word = self.rows.column(self.place_in_time, column as usize)[(y + oy) as usize];
                if word >> bit & 1 == 0 {
                    continue;
                }
                list(lanes, boxed.first, lanes.splat(pair(x, y)), 1 << lane, &mut scratch.listed);
                if scratch.listed.len > MOST_LISTED - LANES {
                    self.test(lanes, scratch, counts, sink);
                }
            }
        }
    }
}

/// Number of samples of one tuple that the twin tests, for micropolygon `number` of a quad.
#[inline(never)]
fn tests_of_tuple(draw: &MovingDraw, quad: usize, number: usize, tuple_ix: u32) -> u64 {
    let corners = draw.grid.corners(quad % draw.grid.m, quad / draw.grid.m);
    let Some(micropolygon) = draw.of_quad(corners)[number] else { return 0 };
    let reach = Reach::of(&Extent::around(&micropolygon.place(tuple_ix)));
    let mut tests = 0;
    interleave::each_sample(draw.pattern, draw.samples, tuple_ix, reach, |_, _| tests += 1);
    tests
}
