//! InterleaveUvt in lanes: 16 micropolygons of a grid at a time, tuple after tuple, exact in 16 bits.
//!
//! In: a [`MovingDraw`]. Out: the hits and counts of the scalar twin, [`super::interleave`], in another order. Source:
//! Fatahalian 2009, section 3.2.2.
//!
//! ```text
//! for each tuple
//!     place    a lane per vertex: where it is, and its depth
//!     box      a lane per quad: its box, the tiles that it overlaps (counted, not visited), and the pixels whose place for
//!              the tuple is in it
//!     find     a lane per quad: such a pixel that holds the tuple (`super::rows`); what it takes to test it is listed
//!     test     a lane per entry of the list (`super::test_lanes`); hits go to the sink
//! ```
//!
//! A tuple is at one place in a tile, but which of its K^2 pixels is up to the tile's permutation. Its place within the
//! pixel is not. So of the pixels in a box only those count whose place for the tuple is in the box, and of these only
//! the ones that hold the tuple: no more is listed than has to be tested. Which pixels hold it is 16 rows of 32 pixels
//! in one vector, looked up without a load, as the quads of a grid are near each other for a given tuple. The other way
//! round (a lane per tuple, one quad after the other) each vertex was placed four times and every tuple's bits had to be
//! loaded lane by lane.
//!
//! What does not fit in 16 bits ([`super::packed`]) is halved until it does; a single quad that does not is drawn by the
//! twin.

use super::draw::{Micropolygon, Micropolygons, MovingDraw, Reach};
use super::interleave;
use super::moving::{Extent, LocalTime};
use super::nomotion::{Facing, HitSink, HitsApart, SampleCounts};
use super::packed::{Frame, Packed, PackedSegment};
use super::pattern::Tuple;
use super::rows::{TupleRows, WORD_PX, WORD_STEP_PX};
use super::test_lanes::{Shape, depth_between, test};
use crate::math::lanes::{Lanes, pair};
use crate::math::simd::{LANES, LanesKernel, SimdLevel};

/// 1 in both halves.
const ONE: i32 = 0x1_0001;
/// The sign bits of pairs.
const SIGNS: i32 = 0x8000_8000_u32 as i32;
const NUMBERS: [i32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// Whether the kernel can draw with this pattern and region.
pub(super) fn takes(draw: &MovingDraw) -> bool {
    // Counting takes K to be a power of two.
    matches!(draw.pattern.tile(), 1 | 2 | 4 | 8)
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
        let (mut part, mut scratch) = (Part::default(), Scratch::default());
        let mut rectangles = vec![[[0, draw.grid.m], [0, draw.grid.n]]];
        while let Some(rectangle) = rectangles.pop() {
            if !part.pack(draw, rectangle) {
                match halves(rectangle) {
                    Some(halves) => rectangles.extend(halves),
                    None => draw_scalar(draw, rectangle, counts, sink),
                }
                continue;
            }
            let micropolygons = part.micropolygons(draw, counts);
            for of_shape in micropolygons.iter().filter(|of_shape| of_shape.shape.is_some()) {
                scratch.renew(&part);
                for (place, &tuple_ix) in draw.pattern.by_time().iter().enumerate() {
                    if draw.has_tuple(tuple_ix) {
                        let mut tuple = OfTuple::new(draw, rows, &part, of_shape, tuple_ix, place);
                        tuple.draw(lanes, &mut scratch, counts, sink);
                    }
                }
            }
        }
    }
}

/// Quads along i and j, first and one after the last.
type Rectangle = [[usize; 2]; 2];

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

/// A rectangle of quads whose vertices are packed. Quads are numbered as their first vertices, so that those from one on
/// have theirs side by side; the last number of a row is no quad.
#[derive(Default)]
struct Part {
    packed: Packed,
    /// Quads along i.
    m: usize,
    /// Vertices.
    num: usize,
    /// Number in the grid of each quad, and room for a vector.
    quads: Vec<i32>,
}

impl Part {
    /// Packs a rectangle; whether it fits.
    fn pack(&mut self, draw: &MovingDraw, [i, j]: Rectangle) -> bool {
        let stride = draw.grid.m + 1;
        let row_of = |row: usize| row * stride + i[0]..row * stride + i[1] + 1;
        let fits = if i == [0, draw.grid.m] {
            self.packed.pack(draw, std::iter::once(row_of(j[0]).start..row_of(j[1]).end))
        } else {
            self.packed.pack(draw, (j[0]..=j[1]).map(row_of))
        };
        if !fits {
            return false;
        }
        self.m = i[1] - i[0];
        self.num = (self.m + 1) * (j[1] - j[0] + 1);
        self.quads.clear();
        let of_row = |row: usize| (i[0]..=i[1]).map(move |column| (row * draw.grid.m + column) as i32);
        self.quads.extend((j[0]..=j[1]).flat_map(of_row));
        self.quads.resize(self.num + LANES, 0);
        true
    }

    /// The micropolygons that may be hit, of each shape.
    fn micropolygons(&self, draw: &MovingDraw, counts: &mut SampleCounts) -> [OfShape; 2] {
        let mut of_shapes = [OfShape::default(), OfShape::default()];
        let step = self.m + 1;
        let firsts = (0..self.num / step - 1).flat_map(|row| row * step..row * step + self.m);
        if draw.facing == Facing::Any && draw.skip.is_none() && draw.micropolygons == Micropolygons::Quads {
            let [all, _] = &mut of_shapes;
            all.shape = Some(Shape::whole(Facing::Any));
            all.corners = [0, 1, step + 1, step];
            all.some.resize(self.num.div_ceil(LANES), 0);
            firsts.for_each(|first| all.some[first / LANES] |= 1 << (first % LANES));
            return of_shapes;
        }
        for first in firsts {
            let quad = self.quads[first] as usize;
            let corners = draw.grid.corners(quad % draw.grid.m, quad / draw.grid.m);
            if draw.is_skipped(corners) {
                continue;
            }
            for (of_shape, micropolygon) in of_shapes.iter_mut().zip(draw.of_quad(corners)) {
                let Some(micropolygon) = micropolygon else { continue };
                if micropolygon.faces_away() {
                    counts.backfacing += 1;
                    continue;
                }
                of_shape.add(draw, &micropolygon, corners, [first, step]);
            }
        }
        of_shapes
    }
}

/// Micropolygons that differ in nothing but their vertices: all quads, or all first or all second triangles.
#[derive(Default)]
struct OfShape {
    /// `None` as long as there are no such micropolygons.
    shape: Option<Shape>,
    /// What of [`MovingDraw::of_quad`] they are.
    number: usize,
    /// Corners, from the first vertex on.
    corners: [usize; 4],
    /// Which there are, 16 quads at a time.
    some: Vec<u32>,
}

impl OfShape {
    /// Adds the micropolygon of the quad that begins at vertex `first`; a row of vertices has `step`.
    fn add(
        &mut self,
        draw: &MovingDraw,
        micropolygon: &Micropolygon,
        corners: [usize; 4],
        [first, step]: [usize; 2],
    ) {
        self.shape = Some(Shape::of(micropolygon.triangles, draw.facing));
        self.number = usize::from(micropolygon.triangles[0].0);
        let of_part = [0, 1, step + 1, step];
        self.corners = micropolygon
            .vertices
            .map(|vertex| of_part[corners.iter().position(|&corner| corner == vertex).unwrap_or(0)]);
        if self.some.len() <= first / LANES {
            self.some.resize(first / LANES + 1, 0);
        }
        self.some[first / LANES] |= 1 << (first % LANES);
    }
}

/// What is kept between the steps.
#[derive(Default)]
struct Scratch {
    /// Where vertices are for a tuple, with room for a vector and a row.
    at: Vec<i32>,
    /// Their depths.
    depth: Vec<f32>,
    listed: Listed,
}

impl Scratch {
    fn renew(&mut self, part: &Part) {
        let len = part.num + part.m + 2 + 2 * LANES;
        self.at.resize(len, 0);
        self.depth.resize(len, 0.0);
    }
}

/// Room of [`Listed`].
const MOST_LISTED: usize = 64;

/// Samples to test.
struct Listed {
    len: usize,
    /// First vertex of the quad in the upper half, the pixel's y and x from the origin in a byte each.
    entries: [i32; MOST_LISTED],
}

impl Default for Listed {
    fn default() -> Self {
        Listed { len: 0, entries: [0; MOST_LISTED] }
    }
}

/// What a part is for one tuple.
struct OfTuple<'a> {
    draw: &'a MovingDraw<'a>,
    rows: &'a TupleRows,
    part: &'a Part,
    of_shape: &'a OfShape,
    segment: &'a PackedSegment,
    tuple_ix: u32,
    tuple: Tuple,
    time: LocalTime,
    /// In the order of time.
    place_in_time: usize,
    stratum: i32,
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
    fn new(
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
            tuple_ix,
            tuple: draw.pattern.tuples()[tuple_ix as usize],
            time,
            place_in_time,
            stratum: (tuple_ix / (draw.pattern.tile() * draw.pattern.tile())) as i32,
        }
    }

    fn frame(&self) -> &Frame {
        &self.segment.frame
    }

    #[inline(always)]
    fn draw<L: Lanes, S: HitSink>(
        &mut self,
        lanes: L,
        scratch: &mut Scratch,
        counts: &mut SampleCounts,
        sink: &mut S,
    ) {
        let (least, most) = self.place(lanes, scratch);
        // Pixels that the part can overlap.
        let [x0, x1] = [lanes.least(lanes.shl(least, 16)) >> 24, lanes.greatest(lanes.shl(most, 16)) >> 24];
        let [y0, y1] = [lanes.least(least) >> 24, lanes.greatest(most) >> 24];
        if self.misses([x0, x1, y0, y1]) {
            return;
        }
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
        let PackedSegment { place, motion, coc, coc_change, depth, .. } = self.segment;
        let t15 = i32::from(self.time.t15);
        let time = lanes.splat(pair(t15, t15));
        let lens = lanes.splat(pair(self.tuple.u15.into(), self.tuple.v15.into()));
        let t = lanes.splat_f(t15 as f32 * (1.0 / 32_768.0));
        let mut least = lanes.splat(pair(i32::from(i16::MAX), i32::from(i16::MAX)));
        let mut most = lanes.splat(pair(i32::from(i16::MIN), i32::from(i16::MIN)));
        for first in (0..self.part.num).step_by(LANES) {
            let moved = lanes.scale2(time, lanes.load(motion, first));
            let mut at = lanes.add2(lanes.load(place, first), moved);
            if !self.segment.is_sharp {
                let change = lanes.scale2(time, lanes.load(coc_change, first));
                let coc = lanes.add2(lanes.load(coc, first), change);
                at = lanes.add2(at, lanes.scale2(lens, coc));
            }
            lanes.store(at, &mut scratch.at, first);
            let [z0, z1] = [lanes.load_f(&depth[0], first), lanes.load_f(&depth[1], first)];
            lanes.store_f(depth_between(lanes, z0, z1, t), &mut scratch.depth, first);
            (least, most) = (lanes.min2(least, at), lanes.max2(most, at));
        }
        (least, most)
    }

    /// The rows of pixels `[x0, x1, y0, y1]`, both ends inclusive, as far as these are in the region; nothing where they
    /// are too many for a vector.
    #[inline(always)]
    fn held<L: Lanes>(&self, lanes: L, [x0, x1, y0, y1]: [i32; 4]) -> Option<Held<L>> {
        let (region, [ox, oy]) = (self.draw.samples.region, self.frame().offset);
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
        let (region, [ox, oy]) = (self.draw.samples.region, self.frame().offset);
        x1 + ox < 0 || y1 + oy < 0 || x0 + ox >= region.width() as i32 || y0 + oy >= region.height() as i32
    }

    /// Whether no tile that pixels `[x0, x1, y0, y1]` overlap is cut by the border of the region.
    fn is_whole(&self, [x0, x1, y0, y1]: [i32; 4]) -> bool {
        let (region, [ox, oy]) = (self.draw.samples.region, self.frame().offset);
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
        let frame = self.frame();
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
            let frame = self.frame();
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
        let [ox, oy] = self.frame().offset;
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

    /// Tests what is listed, and empties the list.
    #[inline(always)]
    fn test<L: Lanes, S: HitSink>(
        &self,
        lanes: L,
        scratch: &mut Scratch,
        counts: &mut SampleCounts,
        sink: &mut S,
    ) {
        let Some(shape) = self.of_shape.shape else { return };
        let Scratch { at, depth, listed } = scratch;
        let samples = self.draw.samples;
        let low = lanes.splat(0xff);
        for first in (0..listed.len).step_by(LANES) {
            let num = (listed.len - first).min(LANES);
            let entry = lanes.load(&listed.entries, first);
            // Bytes with a sign.
            let (x, y) = (lanes.shr(lanes.shl(entry, 24), 24), lanes.shr(lanes.shl(entry, 16), 24));
            let corner = lanes.or(lanes.shl(lanes.and(x, low), 8), lanes.shl(y, 24));
            let place = lanes.or(corner, lanes.splat(pair(self.tuple.x.into(), self.tuple.y.into())));
            let row = lanes.mul(y, lanes.splat(samples.region.width() as i32));
            let pixel_ix = lanes.add(lanes.add(row, x), lanes.splat(self.frame().pixel_ix));
            let sample = lanes.mul(pixel_ix, lanes.splat(samples.samples_per_pixel() as i32));
            let sample = lanes.add(sample, lanes.splat(self.stratum));
            let mut quads = [0; LANES];
            lanes.store(lanes.shr(entry, 16), &mut quads, 0);
            let mut corners = [[0; LANES]; 4];
            for lane in 0..num {
                for (corners, corner) in corners.iter_mut().zip(self.of_shape.corners) {
                    corners[lane] = at[quads[lane] as usize + corner];
                }
            }
            let mut at_lanes = [lanes.splat(0); 4];
            for (at, corners) in at_lanes.iter_mut().zip(&corners) {
                *at = lanes.load(corners, 0);
            }
            let tested = test(lanes, shape, place, &at_lanes, 0xffff_u32 >> (LANES - num));
            let hit = tested.hit[0] | tested.hit[1];
            if hit == 0 {
                continue;
            }
            counts.hits += u64::from(hit.count_ones());
            let (mut z, mut micropolygons, mut sample_ix) = ([[0.0; LANES]; 4], [0; LANES], [0; LANES]);
            lanes.store(sample, &mut sample_ix, 0);
            for lane in bits(hit) {
                let quad = quads[lane] as usize;
                for (z, corner) in z.iter_mut().zip(self.of_shape.corners) {
                    z[lane] = depth[quad + corner];
                }
                micropolygons[lane] = self.part.quads[quad];
            }
            let mut z_lanes = [lanes.splat_f(0.0); 4];
            for (lanes_of, z) in z_lanes.iter_mut().zip(&z) {
                *lanes_of = lanes.load_f(z, 0);
            }
            // Where both triangles of a folded quad are hit, the second is for another turn.
            let mut turn = [tested.hit[0], tested.hit[1] & !tested.hit[0]];
            while turn[0] | turn[1] != 0 {
                let (points, negative) = tested.points(lanes, z_lanes, turn[0]);
                let (mut depth, mut weights) = ([0.0; LANES], [0; LANES]);
                lanes.store_f(points.depth, &mut depth, 0);
                lanes.store(points.weights, &mut weights, 0);
                sink.hits_apart(&HitsApart {
                    hits: turn,
                    negative,
                    samples: &sample_ix,
                    micropolygons: &micropolygons,
                    depth: &depth,
                    weights: &weights,
                });
                turn = [0, turn[0] & tested.hit[1]];
            }
        }
        listed.len = 0;
    }
}

/// Lists pixels of the quads from vertex `first` on, in the lanes `found`.
#[inline(always)]
fn list<L: Lanes>(lanes: L, first: usize, pixel: L::I, found: u32, listed: &mut Listed) {
    let quad = lanes.add(lanes.load(&NUMBERS, 0), lanes.splat(first as i32));
    let x = lanes.and(pixel, lanes.splat(0xff));
    let y = lanes.and(lanes.shr(pixel, 8), lanes.splat(0xff00));
    let entry = lanes.or(lanes.shl(quad, 16), lanes.or(x, y));
    lanes.store(lanes.compress(entry, lanes.mask(found)), &mut listed.entries, listed.len);
    listed.len += found.count_ones() as usize;
}

/// Numbers of the bits that are set, of 16.
#[inline(always)]
fn bits(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(
        #[inline(always)]
        move || {
            let lane = bits.trailing_zeros() as usize;
            bits &= bits.wrapping_sub(1);
            (lane < LANES).then_some(lane)
        },
    )
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
