//! InterleaveUvt in lanes: 16 tuples at a time, exact in 16 bits.
//!
//! In: a [`MovingDraw`] with K of 1, 2, 4 or 8. Out: the hits and counts of the scalar twin, [`super::interleave`], in
//! another order. Source: Fatahalian 2009, section 3.2.2.
//!
//! ```text
//! place      a lane per tuple: positions of the four vertices and their box
//! count      a lane per tuple: tiles that the box overlaps; they are not visited
//! list       for each pixel whose place for that tuple is within the box: sample, tuple, place
//! sift       scalar: keep what really is this pixel's tuple (1 in K^2)
//! test       a lane per kept sample (`super::test_lanes`); hits go to the sink
//! ```
//!
//! A tuple is at one place in a tile, but which of its K^2 pixels is up to the tile's permutation. Its place within the
//! pixel is not, so of the pixels in a box only those are looked up whose place for the tuple is in the box: 1.6 a tuple
//! for a quad of a pixel. What does not fit in 16 bits ([`super::packed`]) is drawn by the twin.

use super::draw::{Micropolygon, MovingDraw, Reach};
use super::interleave;
use super::moving::Extent;
use super::nomotion::{HitSink, SampleCounts};
use super::packed::{Packed, PackedQuad};
use super::region::held_log;
use super::test_lanes::{Depths, Kept, test_kept};
use super::tuple_lanes::{GROUPS, TupleGroup, TupleLanes};
use crate::math::lanes::Lanes;
use crate::math::simd::{LANES, LanesKernel, SimdLevel};

/// Entries of a list; it is sifted when fewer than [`LANES`] are free.
const LIST: usize = 256;
/// Room for the positions of a block; groups that are not full are followed by the next.
const PLACED: usize = 2 * GROUPS * LANES;
/// 1 in both halves.
const ONE: i32 = 0x1_0001;

/// Whether the kernel can draw with this pattern and region.
pub(super) fn takes(draw: &MovingDraw) -> bool {
    matches!(draw.pattern.tile(), 1 | 2 | 4 | 8)
        && draw.samples.region.width() < 1 << 15
        && draw.samples.region.num_pixels() << held_log(draw.pattern.tuples().len()) < 1 << 31
        && !draw.samples.held().is_empty()
}

/// Rasterizes a grid that [`takes`] allows.
pub(super) fn rasterize<S: HitSink>(
    level: SimdLevel,
    draw: &MovingDraw,
    counts: &mut SampleCounts,
    sink: &mut S,
) {
    let table = draw.grid.times.lanes();
    let held_log = held_log(draw.pattern.tuples().len());
    level.run_lanes(Kernel { draw, table, counts, sink, held_log, scratch: Scratch::new() });
}

/// What is kept between the steps. Lists are read by masked indices, so that none can be out of bounds.
struct Scratch {
    /// Positions of each vertex for the tuples of a block.
    placed: [[i32; PLACED]; 4],
    /// Pixel and tuple: the index of their bit in [`super::RegionSamples::held`].
    code: [i32; LIST],
    /// Place of the sample, as the vertices.
    place: [i32; LIST],
    len: usize,
    /// Entries of the lists that are kept.
    kept: [u32; LIST],
}

impl Scratch {
    fn new() -> Self {
        Scratch { placed: [[0; PLACED]; 4], code: [0; LIST], place: [0; LIST], len: 0, kept: [0; LIST] }
    }
}

struct Kernel<'a, S> {
    draw: &'a MovingDraw<'a>,
    table: &'a TupleLanes,
    counts: &'a mut SampleCounts,
    sink: &'a mut S,
    held_log: u32,
    scratch: Scratch,
}

impl<S: HitSink> LanesKernel for Kernel<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, lanes: L) {
        let draw = self.draw;
        let grid = &draw.grid;
        let (mut whole, mut apart) = (Packed::default(), Packed::default());
        let fits = whole.pack(draw, 0..grid.num_vertices());
        let tuples = interleave::tuples(draw);
        let mut tests = lanes.splat(0);
        for quad in 0..grid.m * grid.n {
            let corners = grid.corners(quad % grid.m, quad / grid.m);
            if draw.is_skipped(corners) {
                continue;
            }
            self.sink.begin(quad as u32);
            for micropolygon in draw.of_quad(corners).into_iter().flatten() {
                if micropolygon.faces_away() {
                    self.counts.backfacing += 1;
                } else if fits {
                    let packed = PackedQuad { packed: &whole, at: micropolygon.vertices };
                    tests = lanes.add(tests, self.draw_quad(lanes, &micropolygon, packed));
                } else if apart.pack(draw, micropolygon.vertices.into_iter()) {
                    let packed = PackedQuad { packed: &apart, at: [0, 1, 2, 3] };
                    tests = lanes.add(tests, self.draw_quad(lanes, &micropolygon, packed));
                } else {
                    let (counts, sink) = (&mut *self.counts, &mut *self.sink);
                    interleave::rasterize_micropolygon(draw, &micropolygon, &tuples, counts, sink);
                }
            }
        }
        self.counts.tests += u64::from(lanes.sum(tests) as u32);
    }
}

/// A group's boxes.
struct Boxed<L: Lanes> {
    /// Least and greatest position of the vertices.
    least: L::I,
    most: L::I,
    /// First and last pixel, within the region.
    first_px: L::I,
    last_px: L::I,
    /// Bits of the lanes that are looked at.
    active: u32,
}

impl<S: HitSink> Kernel<'_, S> {
    /// Draws a micropolygon; the tests of each lane, but for those that are counted one by one.
    #[inline(always)]
    fn draw_quad<L: Lanes>(&mut self, lanes: L, micropolygon: &Micropolygon, packed: PackedQuad) -> L::I {
        let table = self.table;
        let mut tests = lanes.splat(0);
        for block in &table.blocks {
            let first = table.groups[block.start].first;
            let depths = Depths::of(micropolygon, table.groups[block.start].segment);
            for group in &table.groups[block.clone()] {
                if group.times[1] < self.draw.times[0] || group.times[0] > self.draw.times[1] {
                    continue;
                }
                let boxed = self.place(lanes, packed, group, group.first - first);
                tests = lanes.add(tests, self.count(lanes, micropolygon, packed, group, &boxed));
                self.list(lanes, micropolygon, packed, [group, &table.groups[block.start]], &boxed, &depths);
            }
            self.sift_and_test(lanes, micropolygon, first, &depths);
        }
        tests
    }

    /// Positions and boxes for the tuples of a group.
    #[inline(always)]
    fn place<L: Lanes>(&mut self, lanes: L, packed: PackedQuad, group: &TupleGroup, slot: usize) -> Boxed<L> {
        let (time, lens) = (lanes.load(&group.time, 0), lanes.load(&group.lens, 0));
        let mut at = [lanes.splat(0); 4];
        for (corner, at) in at.iter_mut().enumerate() {
            let vertex = packed.vertex(group.segment, corner);
            let coc = lanes.add2(lanes.splat(vertex.coc), lanes.scale2(time, lanes.splat(vertex.coc_change)));
            let moved = lanes.add2(lanes.splat(vertex.place), lanes.scale2(time, lanes.splat(vertex.motion)));
            *at = lanes.add2(moved, lanes.scale2(lens, coc));
            lanes.store(*at, &mut self.scratch.placed[corner], slot);
        }
        let least = lanes.min2(lanes.min2(at[0], at[1]), lanes.min2(at[2], at[3]));
        let most = lanes.max2(lanes.max2(at[0], at[1]), lanes.max2(at[2], at[3]));
        let frame = packed.frame(group.segment);
        let first_px = lanes.max2(lanes.shr2(least, 8), lanes.splat(frame.first_px));
        let last_px = lanes.shr2(lanes.sub2(most, lanes.splat(ONE)), 8);
        let last_px = lanes.min2(last_px, lanes.splat(frame.last_px));
        let mut active = 0xffff >> (LANES as u32 - group.num);
        let [first, last] = self.draw.times;
        if group.times[0] < first || group.times[1] > last {
            let shutter = lanes.load(&group.shutter, 0);
            let before = lanes.gt(lanes.splat(first.into()), shutter);
            let after = lanes.gt(shutter, lanes.splat(last.into()));
            active &= !lanes.bits(lanes.either(before, after));
        }
        Boxed { least, most, first_px, last_px, active }
    }

    /// Number of samples that the twin tests in each lane: one for each tile that the box overlaps.
    ///
    /// Where a tile is cut by the border of the region its sample may lie beyond: such lanes are counted one by one.
    #[inline(always)]
    fn count<L: Lanes>(
        &mut self,
        lanes: L,
        micropolygon: &Micropolygon,
        packed: PackedQuad,
        group: &TupleGroup,
        boxed: &Boxed<L>,
    ) -> L::I {
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
        if log > 0 {
            // Tiles that lie in the region as a whole; origins are whole tiles.
            let frame = packed.frame(group.segment);
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
                let tuple_ix = self.draw.pattern.by_time()[group.first + apart.trailing_zeros() as usize];
                self.counts.tests += tests_of_tuple(self.draw, micropolygon, tuple_ix);
                apart &= apart - 1;
            }
        }
        lanes.select(lanes.mask(counted), product, zero)
    }

    /// Lists the pixels whose place for the tuple is within its box. The second group is the first of the
    /// block.
    #[inline(always)]
    fn list<L: Lanes>(
        &mut self,
        lanes: L,
        micropolygon: &Micropolygon,
        packed: PackedQuad,
        [group, first_group]: [&TupleGroup; 2],
        boxed: &Boxed<L>,
        depths: &Depths,
    ) {
        let place = lanes.load(&group.place, 0);
        // First and last pixel whose place is in the box: not before the least, before the greatest position.
        let first = lanes.sub2(lanes.add2(boxed.least, lanes.splat(255 * ONE)), place);
        let first = lanes.max2(lanes.shr2(first, 8), boxed.first_px);
        let last = lanes.sub2(lanes.sub2(boxed.most, lanes.splat(ONE)), place);
        let steps = lanes.sub2(lanes.min2(lanes.shr2(last, 8), boxed.last_px), first);
        let (steps_x, steps_y) = (lanes.shr(lanes.shl(steps, 16), 16), lanes.shr(steps, 16));
        let width = self.draw.samples.region.width() as i32;
        let pixel_ix = lanes.dot2(first, lanes.splat(1 | width << 16));
        let pixel_ix = lanes.add(pixel_ix, lanes.splat(packed.frame(group.segment).pixel_ix));
        let tuple = lanes.add(lanes.load(&FIRST, 0), lanes.splat(group.first as i32));
        let code = lanes.add(lanes.shl(pixel_ix, self.held_log), tuple);
        let place = lanes.add2(lanes.shl2(first, 8), place);
        let mut oy = 0;
        loop {
            let row = lanes.bits(lanes.gt(steps_y, lanes.splat(oy - 1))) & boxed.active;
            if row == 0 {
                break;
            }
            let mut ox = 0;
            loop {
                let found = lanes.bits(lanes.gt(steps_x, lanes.splat(ox - 1))) & row;
                if found == 0 {
                    break;
                }
                if self.scratch.len > LIST - LANES {
                    self.sift_and_test(lanes, micropolygon, first_group.first, depths);
                }
                let (mask, at) = (lanes.mask(found), self.scratch.len);
                let code = lanes.add(code, lanes.splat((oy * width + ox) << self.held_log));
                let place = lanes.add2(place, lanes.splat((ox << 8 & 0xffff) | oy << 24));
                lanes.store(lanes.compress(code, mask), &mut self.scratch.code, at);
                lanes.store(lanes.compress(place, mask), &mut self.scratch.place, at);
                self.scratch.len += found.count_ones() as usize;
                ox += 1;
            }
            oy += 1;
        }
    }

    /// Keeps what is listed of pixels that hold the tuple, tests it, and empties the list. The tuples of the block
    /// begin at `first_tuple`.
    #[inline(always)]
    fn sift_and_test<L: Lanes>(
        &mut self,
        lanes: L,
        micropolygon: &Micropolygon,
        first_tuple: usize,
        depths: &Depths,
    ) {
        let Scratch { placed, code, place, len, kept } = &mut self.scratch;
        let TupleLanes { t, stratum, .. } = self.table;
        let held = self.draw.samples.held();
        let mut num = 0;
        for i in 0..*len {
            let i = i & (LIST - 1);
            let code = code[i] as u32;
            kept[num & (LIST - 1)] = i as u32;
            num += (held[code as usize / 64] >> (code % 64) & 1) as usize;
        }
        *len = 0;
        let num_strata = self.draw.samples.samples_per_pixel();
        let mut first = 0;
        while first < num {
            let mut chunk = Kept::new((num - first).min(LANES));
            for lane in 0..chunk.num {
                let lane = lane & (LANES - 1);
                let i = kept[(first + lane) & (LIST - 1)] as usize & (LIST - 1);
                let pixel = code[i] as usize >> self.held_log;
                let tuple = code[i] as usize & ((1 << self.held_log) - 1);
                chunk.sample[lane] = (pixel * num_strata) as i32 + stratum[tuple];
                chunk.place[lane] = place[i];
                let slot = (tuple - first_tuple) & (PLACED - 1);
                for (at, placed) in chunk.at.iter_mut().zip(placed.iter()) {
                    at[lane] = placed[slot];
                }
                chunk.t[lane] = t[tuple];
            }
            test_kept(lanes, micropolygon, depths, &chunk, self.counts, self.sink);
            first += LANES;
        }
    }
}

const FIRST: [i32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// Number of samples of one tuple that the twin tests.
#[inline(never)]
fn tests_of_tuple(draw: &MovingDraw, micropolygon: &Micropolygon, tuple_ix: u32) -> u64 {
    let reach = Reach::of(&Extent::around(&micropolygon.place(tuple_ix)));
    let mut tests = 0;
    interleave::each_sample(draw.pattern, draw.samples, tuple_ix, reach, |_, _| tests += 1);
    tests
}
