//! A part of a grid for one tuple: which pixels it can overlap, and where its vertices are.

use super::listed::Listed;
use super::part::{OfShape, Part};
use super::pending::Pending;
use crate::math::lanes::{Lanes, pair};
use crate::math::simd::LANES;
use crate::sampling::draw::MovingDraw;
use crate::sampling::moving::LocalTime;
use crate::sampling::nomotion::{HitSink, SampleCounts};
use crate::sampling::packed::{Frame, PackedSegment};
use crate::sampling::pattern::Tuple;
use crate::sampling::rows::TupleRows;
use crate::sampling::test_lanes::depth_between;

/// What is kept between the steps.
#[derive(Default)]
pub(super) struct Scratch {
    /// Where vertices are for a tuple, with room for a vector and a row.
    pub(super) at: Vec<i32>,
    /// Of each in turn where it is and the bits of its depth, likewise.
    pub(super) vertices: Vec<i32>,
    pub(super) listed: Listed,
    pub(super) pending: Pending,
}

impl Scratch {
    pub(super) fn renew(&mut self, part: &Part) {
        let len = part.num + part.m + 2 + 2 * LANES;
        self.at.resize(len, 0);
        self.vertices.resize(2 * len, 0);
        self.pending.renew();
    }
}

/// What a part is for one tuple.
pub(super) struct OfTuple<'a> {
    pub(super) draw: &'a MovingDraw<'a>,
    pub(super) rows: &'a TupleRows,
    pub(super) part: &'a Part,
    pub(super) of_shape: &'a OfShape,
    pub(super) segment: &'a PackedSegment,
    /// Where positions are packed; of the segment, or of this tuple.
    pub(super) frame: Frame,
    pub(super) tuple: Tuple,
    pub(super) time: LocalTime,
    /// In the order of time.
    pub(super) place_in_time: usize,
    pub(super) stratum: i32,
}

impl<'a> OfTuple<'a> {
    pub(super) fn new(
        draw: &'a MovingDraw<'a>,
        rows: &'a TupleRows,
        part: &'a Part,
        of_shape: &'a OfShape,
        segment: &'a PackedSegment,
        place_in_time: usize,
    ) -> Self {
        let tuple_ix = draw.pattern.by_time()[place_in_time];
        OfTuple {
            draw,
            rows,
            part,
            of_shape,
            segment,
            frame: segment.frame,
            tuple: draw.pattern.tuples()[tuple_ix as usize],
            time: draw.grid.times.of_tuple(tuple_ix),
            place_in_time,
            stratum: (tuple_ix / (draw.pattern.tile() * draw.pattern.tile())) as i32,
        }
    }

    /// Tests the samples that hold the tuple, or leaves them to wait. The part is within `pixels` of the region, first and
    /// last along x and along y.
    #[inline(always)]
    pub(super) fn draw<L: Lanes, S: HitSink>(
        &mut self,
        lanes: L,
        pixels: [i32; 4],
        scratch: &mut Scratch,
        counts: &mut SampleCounts,
        sink: &mut S,
    ) {
        match &self.segment.wide {
            Some(wide) => self.place_wide(lanes, wide, scratch),
            None => self.place(lanes, scratch),
        }
        self.find_all(lanes, pixels, scratch);
        if scratch.listed.len > 0 {
            self.place_depths(lanes, scratch);
            self.gather(lanes, scratch, counts, sink);
        }
    }

    /// Puts the depths of the vertices beside their places.
    #[inline(always)]
    fn place_depths<L: Lanes>(&self, lanes: L, scratch: &mut Scratch) {
        let t = lanes.splat_f(f32::from(self.time.t15) * (1.0 / 32_768.0));
        let len = self.part.num.next_multiple_of(LANES);
        let [from, to] = &self.segment.depth;
        let ends = from[..len].chunks_exact(LANES).zip(to[..len].chunks_exact(LANES));
        let at = scratch.at[..len].chunks_exact(LANES);
        let out = scratch.vertices[..2 * len].chunks_exact_mut(2 * LANES);
        for ((out, at), (from, to)) in out.zip(at).zip(ends) {
            let depth = depth_between(lanes, lanes.load_f(from, 0), lanes.load_f(to, 0), t);
            let (low, high) = lanes.interleave(lanes.load(at, 0), lanes.bits_of(depth));
            lanes.store(low, out, 0);
            lanes.store(high, out, LANES);
        }
    }

    /// Places the vertices.
    #[inline(always)]
    fn place<L: Lanes>(&self, lanes: L, scratch: &mut Scratch) {
        let PackedSegment { place, motion, coc, coc_change, .. } = self.segment;
        let t15 = i32::from(self.time.t15);
        let time = lanes.splat(pair(t15, t15));
        let lens = lanes.splat(pair(self.tuple.u15.into(), self.tuple.v15.into()));
        // All of the same length: nothing is checked within the loops.
        let len = self.part.num.next_multiple_of(LANES);
        let out = scratch.at[..len].chunks_exact_mut(LANES);
        let from = place[..len].chunks_exact(LANES).zip(motion[..len].chunks_exact(LANES));
        if self.segment.is_sharp {
            for (out, (place, motion)) in out.zip(from) {
                let at = lanes.add2(lanes.load(place, 0), lanes.scale2(time, lanes.load(motion, 0)));
                lanes.store(at, out, 0);
            }
        } else {
            let cocs = coc[..len].chunks_exact(LANES).zip(coc_change[..len].chunks_exact(LANES));
            for ((out, (place, motion)), (coc, change)) in out.zip(from).zip(cocs) {
                let at = lanes.add2(lanes.load(place, 0), lanes.scale2(time, lanes.load(motion, 0)));
                let coc = lanes.add2(lanes.load(coc, 0), lanes.scale2(time, lanes.load(change, 0)));
                let at = lanes.add2(at, lanes.scale2(lens, coc));
                lanes.store(at, out, 0);
            }
        }
    }
}
