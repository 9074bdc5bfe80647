//! Boxes of quads for a tuple, and the pixels that have to be tested.

use super::listed::Listed;
use super::tuple::{OfTuple, Scratch};
use crate::math::lanes::{Lanes, pair};
use crate::math::simd::LANES;
use crate::sampling::rows::{WORD_PX, WORD_STEP_PX};

/// Pixels of a row that are looked up at once.
const MOST_COLUMNS: i32 = 16;
/// A step along x and one along y at most: boxes of micropolygons.
const SMALL: i32 = 0x1_0001;
/// Fewer than [`MOST_COLUMNS`] steps along x.
const WIDE: i32 = !0xffff | (MOST_COLUMNS - 1);
/// The pixel of the lowest of four bits, a pair: two in the first row and two in the next.
const LOWEST: [i32; LANES] = {
    let (right, below) = (1, 1 << 16);
    [0, 0, right, 0, below, 0, right, 0, right | below, 0, right, 0, below, 0, right, 0]
};
/// The sign bits of pairs.
const SIGNS: i32 = 0x8000_8000_u32 as i32;
const NUMBERS: [i32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// Pixels whose place for the tuple is in a box: the first, and how many more there are along x and y.
#[derive(Clone, Copy)]
struct Pixels<L: Lanes> {
    first: L::I,
    steps: L::I,
    /// Lanes in which there are any.
    some: u32,
}

/// The bits of up to 32 rows of 48 pixels from `corner` on, a pair: 16 rows of 32 pixels a vector.
#[derive(Clone, Copy)]
struct Held<L: Lanes> {
    /// From the corner on, and from [`WORD_STEP_PX`] pixels right of it.
    columns: [[L::I; 2]; 2],
    corner: i32,
    /// Whether there are pixels that the first column does not hold.
    is_wide: bool,
    /// Whether there are rows that the first vectors do not hold.
    is_tall: bool,
}

impl<L: Lanes> Held<L> {
    /// The bits of the pixels `x` to `x + 16` from the corner, in rows `y` and in the rows below.
    #[inline(always)]
    fn bits(&self, lanes: L, x: L::I, y: L::I) -> [L::I; 2] {
        let below = lanes.add(y, lanes.splat(1));
        let [mut here, mut there] = [self.row(lanes, 0, y), self.row(lanes, 0, below)];
        let mut x = x;
        if self.is_wide {
            let is_right = lanes.gt(x, lanes.splat(WORD_STEP_PX - 1));
            here = lanes.select(is_right, self.row(lanes, 1, y), here);
            there = lanes.select(is_right, self.row(lanes, 1, below), there);
            x = lanes.select(is_right, lanes.sub(x, lanes.splat(WORD_STEP_PX)), x);
        }
        [lanes.shr_each(here, x), lanes.shr_each(there, x)]
    }

    #[inline(always)]
    fn row(&self, lanes: L, column: usize, y: L::I) -> L::I {
        let [upper, lower] = self.columns[column];
        let row = lanes.lookup(upper, y);
        if !self.is_tall {
            return row;
        }
        lanes.select(lanes.gt(y, lanes.splat(LANES as i32 - 1)), lanes.lookup(lower, y), row)
    }
}

impl<L: Lanes> Pixels<L> {
    /// Whether there are no more steps than these bits of pairs hold, of any of them.
    #[inline(always)]
    fn are_within(&self, lanes: L, bits: i32) -> bool {
        let within = lanes.eq(lanes.and(self.steps, lanes.splat(!SIGNS & !bits)), lanes.splat(0));
        !lanes.bits(within) & self.some == 0
    }
}

impl OfTuple<'_> {
    /// Lists the pixels of `[x0, x1, y0, y1]`, both ends inclusive, that have to be tested, quad by quad.
    #[inline(always)]
    pub(super) fn find_all<L: Lanes>(&self, lanes: L, pixels: [i32; 4], scratch: &mut Scratch) {
        let held = self.held(lanes, pixels);
        let may_be_wide = pixels[1] - pixels[0] >= MOST_COLUMNS;
        let (of_shape, Scratch { at, listed, .. }) = (self.of_shape, scratch);
        let len = of_shape.some.len() * LANES;
        // All of the same length: nothing is checked within the loop.
        let [c0, c1, c2, c3] = of_shape.corners(self.part.m + 1);
        let upper = at[c0..][..len].chunks_exact(LANES).zip(at[c1..][..len].chunks_exact(LANES));
        let lower = at[c2..][..len].chunks_exact(LANES).zip(at[c3..][..len].chunks_exact(LANES));
        for (ix, (&some, ((a0, a1), (a2, a3)))) in of_shape.some.iter().zip(upper.zip(lower)).enumerate() {
            if some == 0 {
                continue;
            }
            let first = ix * LANES;
            let corners = [lanes.load(a0, 0), lanes.load(a1, 0), lanes.load(a2, 0), lanes.load(a3, 0)];
            let pixels = self.pixels(lanes, corners, some);
            if pixels.some == 0 {
                continue;
            }
            if let Some(held) = held
                && pixels.are_within(lanes, SMALL)
            {
                self.find_small(lanes, first, &pixels, held, listed);
                continue;
            }
            let is_wide = may_be_wide && !pixels.are_within(lanes, WIDE);
            let held = if held.is_some() { held } else { self.held_of(lanes, &pixels) };
            match held.filter(|_| !is_wide) {
                Some(held) => self.find(lanes, first, &pixels, held, listed),
                None => self.find_one_by_one(lanes, first, &pixels, listed),
            }
        }
    }

    /// The rows of pixels `[x0, x1, y0, y1]` of the region, both ends inclusive; nothing where they are too many.
    #[inline(always)]
    fn held<L: Lanes>(&self, lanes: L, [x0, x1, y0, y1]: [i32; 4]) -> Option<Held<L>> {
        let [ox, oy] = self.frame.offset;
        let corner_x = x0 & -WORD_STEP_PX;
        let (is_wide, is_tall) = (x1 - corner_x >= WORD_PX, y1 - y0 >= LANES as i32);
        if x1 - corner_x >= WORD_PX + WORD_STEP_PX || y1 - y0 >= 2 * LANES as i32 {
            return None;
        }
        let mut columns = [[lanes.splat(0); 2]; 2];
        let first = (corner_x / WORD_STEP_PX) as usize;
        for (ix, column) in columns.iter_mut().enumerate().take(1 + usize::from(is_wide)) {
            let words = self.rows.column(self.place_in_time, first + ix);
            column[0] = lanes.load(words, y0 as usize);
            if is_tall {
                column[1] = lanes.load(words, y0 as usize + LANES);
            }
        }
        Some(Held { columns, corner: pair(corner_x - ox, y0 - oy), is_wide, is_tall })
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
        let [ox, oy] = self.frame.offset;
        self.held(lanes, [x0 + ox, x1 + ox, y0 + oy, y1 + oy])
    }

    /// The pixels whose place for the tuple is in the boxes of quads with corners `at`, those that are `active`.
    #[inline(always)]
    fn pixels<L: Lanes>(&self, lanes: L, at: [L::I; 4], active: u32) -> Pixels<L> {
        let least = lanes.min2(lanes.min2(at[0], at[1]), lanes.min2(at[2], at[3]));
        let most = lanes.max2(lanes.max2(at[0], at[1]), lanes.max2(at[2], at[3]));
        // Not before the least, before the greatest position, in the region.
        let [x, y] = [i32::from(self.tuple.x), i32::from(self.tuple.y)];
        let first = lanes.shr2(lanes.add2(least, lanes.splat(pair(255 - x, 255 - y))), 8);
        let first = lanes.max2(first, lanes.splat(self.frame.first_px));
        let last = lanes.shr2(lanes.sub2(most, lanes.splat(pair(x + 1, y + 1))), 8);
        let steps = lanes.sub2(lanes.min2(last, lanes.splat(self.frame.last_px)), first);
        let has_pixels = lanes.eq(lanes.and(steps, lanes.splat(SIGNS)), lanes.splat(0));
        Pixels { first, steps, some: lanes.bits(has_pixels) & active }
    }

    /// As [`Self::find`], where no box has more than 2 x 2 pixels.
    #[inline(always)]
    fn find_small<L: Lanes>(
        &self,
        lanes: L,
        first: usize,
        pixels: &Pixels<L>,
        held: Held<L>,
        listed: &mut Listed,
    ) {
        let quads = numbered(lanes, first);
        let (zero, one, low) = (lanes.splat(0), lanes.splat(1), lanes.splat(0xffff));
        let from = lanes.sub2(pixels.first, lanes.splat(held.corner));
        let (from_x, from_y) = (lanes.and(from, low), lanes.shr(from, 16));
        let (steps_x, steps_y) = (lanes.and(pixels.steps, low), lanes.shr(pixels.steps, 16));
        let columns = lanes.or(lanes.add(steps_x, steps_x), one);
        let columns = lanes.select(lanes.mask(pixels.some), columns, zero);
        let [here, below] = held.bits(lanes, from_x, from_y);
        let here = lanes.and(here, columns);
        let below = lanes.and(lanes.and(below, columns), lanes.sub(zero, steps_y));
        let mut left = lanes.or(here, lanes.shl(below, 2));
        let table = lanes.load(&LOWEST, 0);
        let mut room = listed.room(4 * LANES);
        // Whether anything is found is hard to predict, so that nothing is left out the first time.
        loop {
            let found = 0xffff & !lanes.bits(lanes.eq(left, zero));
            let pixel = lanes.add2(pixels.first, lanes.lookup(table, left));
            room.add(lanes, quads, pixel, found);
            left = lanes.and(left, lanes.sub(left, one));
            if lanes.bits(lanes.eq(left, zero)) == 0xffff {
                break;
            }
        }
        listed.len = room.len;
    }

    /// Lists those of the pixels that hold the tuple.
    #[inline(always)]
    fn find<L: Lanes>(&self, lanes: L, first: usize, pixels: &Pixels<L>, held: Held<L>, listed: &mut Listed) {
        let quads = numbered(lanes, first);
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
            let [here, below] = held.bits(lanes, from_x, lanes.add(from_y, lanes.splat(y)));
            let (here, below) = (lanes.and(here, columns), lanes.and(below, columns));
            let here = lanes.select(lanes.gt(steps_y, lanes.splat(y - 1)), here, zero);
            let below = lanes.select(lanes.gt(steps_y, lanes.splat(y)), below, zero);
            let mut left = lanes.or(here, lanes.shl(below, 16));
            let mut room = listed.room(2 * MOST_COLUMNS as usize * LANES);
            // Whether anything is found is hard to predict, so that nothing is left out the first time.
            loop {
                let found = 0xffff & !lanes.bits(lanes.eq(left, zero));
                let lowest = lanes.and(left, lanes.sub(zero, left));
                left = lanes.xor(left, lowest);
                // The number of a bit is the exponent of its value.
                let exponent = lanes.shr(lanes.bits_of(lanes.to_f(lowest)), 23);
                let number = lanes.sub(lanes.and(exponent, lanes.splat(0xff)), lanes.splat(127));
                let (x, is_below) = (lanes.and(number, lanes.splat(15)), lanes.and(number, lanes.splat(16)));
                let pixel = lanes.add2(pixels.first, lanes.or(x, lanes.shl(is_below, 12)));
                let pixel = lanes.add2(pixel, lanes.splat(y << 16));
                room.add(lanes, quads, pixel, found);
                if lanes.bits(lanes.eq(left, zero)) == 0xffff {
                    break;
                }
            }
            listed.len = room.len;
            y += 2;
            if lanes.bits(lanes.gt(steps_y, lanes.splat(y - 1))) == 0 {
                return;
            }
        }
    }

    /// As [`Self::find`], pixel by pixel, where these are too far from each other.
    #[inline(always)]
    fn find_one_by_one<L: Lanes>(&self, lanes: L, first: usize, pixels: &Pixels<L>, listed: &mut Listed) {
        let quads = numbered(lanes, first);
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
                if word >> bit & 1 != 0 {
                    let mut room = listed.room(1);
                    room.add(lanes, quads, lanes.splat(pair(x, y)), 1 << lane);
                    listed.len = room.len;
                }
            }
        }
    }
}

/// 16 numbers from `first` on.
#[inline(always)]
fn numbered<L: Lanes>(lanes: L, first: usize) -> L::I {
    lanes.add(lanes.load(&NUMBERS, 0), lanes.splat(first as i32))
}
