//! Packed vertices: a grid in 16 bits, where it fits.
//!
//! In: vertices of a [`MovingGrid`] and a motion segment. Out: their positions from an origin near them, how far they
//! move and their circles of confusion, as pairs of 16 bits ([`crate::math::lanes`]); or nothing where 16 bits do not
//! hold all that can come of them, and a kernel leaves the grid to scalar code with the same bits.
//!
//! What fits: positions within [`MOST`] of the origin at both keys, circles of confusion included; motion below 2^15;
//! and vertices within [`MOST`] of each other at both keys, so that differences of positions and edge functions of
//! samples among them stay within 16 and 32 bits (see [`super::moving`]: rounded terms stay between the keys').

use std::ops::Range;

use super::draw::MovingDraw;
use super::moving::{Extent, MovingGrid};
use super::region::Region;
use crate::math::lanes::pair;
use crate::math::simd::LANES;

/// Greatest distance in 1/256 px: 125 px.
pub(super) const MOST: i32 = 32_000;

/// A vertex over a motion segment, each x and y.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PackedVertex {
    /// Position from the origin at the first key, in focus.
    pub place: i32,
    /// What it moves until the second key.
    pub motion: i32,
    /// Circle of confusion at the first key, in both halves.
    pub coc: i32,
    /// What it changes until the second key.
    pub coc_change: i32,
}

/// Where packed positions are.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Frame {
    /// First and last pixel of the region relative to it, as pairs; clamped to 16 bits.
    pub first_px: i32,
    /// See `first_px`.
    pub last_px: i32,
    /// Pixels from the region's corner to the origin.
    pub offset: [i32; 2],
    /// Index in the region of the origin's pixel, which may lie outside of it.
    pub pixel_ix: i32,
}

impl Frame {
    /// The frame around `origin`, a pixel.
    pub fn new(origin: [i32; 2], region: &Region) -> Self {
        let near = |px: i32, axis: usize| (px - origin[axis]).clamp(-1000, 1000);
        Frame {
            first_px: pair(near(region.x0, 0), near(region.y0, 1)),
            last_px: pair(near(region.x1 - 1, 0), near(region.y1 - 1, 1)),
            offset: [origin[0].wrapping_sub(region.x0), origin[1].wrapping_sub(region.y0)],
            pixel_ix: (origin[1].wrapping_sub(region.y0).wrapping_mul(region.width() as i32))
                .wrapping_add(origin[0].wrapping_sub(region.x0)),
        }
    }
}

/// Vertices over a motion segment, with room for a whole vector after the last one.
#[derive(Debug, Default)]
pub(super) struct PackedSegment {
    /// Where they are.
    pub frame: Frame,
    /// See [`PackedVertex`].
    pub place: Vec<i32>,
    /// See [`PackedVertex`].
    pub motion: Vec<i32>,
    /// See [`PackedVertex`].
    pub coc: Vec<i32>,
    /// See [`PackedVertex`].
    pub coc_change: Vec<i32>,
    /// Whether all are in focus.
    pub is_sharp: bool,
    /// Depths at the first and the second key.
    pub depth: [Vec<f32>; 2],
    /// How far they are from each other.
    pub spread: Spread,
    /// Least and greatest place, what these move until the second key, least and greatest circle of confusion: the corners
    /// of boxes around them, pairs.
    pub corners: [[i32; 3]; 2],
    /// What moves too far for 16 bits; the fields above but the depths are not filled then.
    pub wide: Option<Wide>,
}

/// Vertices in 32 bits, with room for a vector: x, y and the circle of confusion, each at the first key and what it
/// changes until the second.
#[derive(Debug, Default)]
pub(super) struct Wide {
    pub x: [Vec<i32>; 2],
    pub y: [Vec<i32>; 2],
    pub coc: [Vec<i32>; 2],
}

/// Changes must be below this in 32 bits.
const MOST_WIDE: i32 = 1 << 23;

impl PackedSegment {
    /// Packs ranges of vertices, one after the other; whether they fit.
    #[inline(always)]
    fn pack(
        &mut self,
        grid: &MovingGrid,
        segment: usize,
        vertices: impl Iterator<Item = Range<usize>> + Clone,
        region: &Region,
    ) -> bool {
        self.spread = Spread::of(grid, segment, vertices.clone());
        let Some(origin) = self.spread.origin() else { return false };
        let zero = origin.map(|px| px * 256);
        let mut len = 0;
        for range in vertices.clone() {
            len += range.len();
        }
        let PackedSegment { place, motion, coc, coc_change, depth, .. } = self;
        for list in [&mut *place, &mut *motion, &mut *coc, &mut *coc_change] {
            list.resize(len + LANES, 0);
        }
        depth.iter_mut().for_each(|depth| depth.resize(len + LANES, 0.0));
        let mut first = 0;
        for range in vertices {
            let (part, num) = (first..first + range.len(), range.len());
            // All of the same length, so that the loops need no checks and go in lanes.
            let ([x0, x1], [y0, y1]) =
                (grid.ends_of(grid.x, &range, segment), grid.ends_of(grid.y, &range, segment));
            let ends = x0[..num].iter().zip(&x1[..num]).zip(y0[..num].iter().zip(&y1[..num]));
            let out = place[part.clone()].iter_mut().zip(&mut motion[part.clone()]);
            for ((place, motion), ((x0, x1), (y0, y1))) in out.zip(ends) {
                *place = pair(x0 - zero[0], y0 - zero[1]);
                *motion = pair(x1 - x0, y1 - y0);
            }
            if !grid.coc.is_empty() {
                let [c0, c1] = grid.ends_of(grid.coc, &range, segment);
                let out = coc[part.clone()].iter_mut().zip(&mut coc_change[part.clone()]);
                for ((coc, change), (c0, c1)) in out.zip(c0[..num].iter().zip(&c1[..num])) {
                    *coc = pair(*c0, *c0);
                    *change = pair(c1 - c0, c1 - c0);
                }
            }
            let [z0, z1] = grid.ends_of(grid.depth, &range, segment);
            depth[0][part.clone()].copy_from_slice(z0);
            depth[1][part.clone()].copy_from_slice(z1);
            first = part.end;
        }
        self.is_sharp = self.spread.coc == [0; 2];
        if self.is_sharp {
            coc.fill(0);
            coc_change.fill(0);
        }
        for list in [place, motion, coc, coc_change] {
            let last = list[len - 1];
            list[len..].fill(last);
        }
        depth.iter_mut().for_each(|depth| depth[len..].fill(0.0));
        self.frame = Frame::new(origin, region);
        self.corners = self.spread.corners(zero);
        self.wide = None;
        true
    }

    /// Packs ranges of vertices that move too far for [`Self::pack`], which has measured how far they spread; whether those of each key fit around an origin.
    fn pack_wide(&mut self, grid: &MovingGrid, segment: usize, vertices: &[Range<usize>]) -> bool {
        let spread = &self.spread;
        if spread.most_coc > MOST / 4
            || spread.most_motion >= MOST_WIDE
            || !spread.boxes.iter().all(|extent| spread.is_small(extent, MOST))
        {
            return false;
        }
        let mut wide = self.wide.take().unwrap_or_default();
        let Wide { x, y, coc } = &mut wide;
        x.iter_mut().chain(y.iter_mut()).chain(coc.iter_mut()).for_each(Vec::clear);
        self.depth.iter_mut().for_each(Vec::clear);
        for range in vertices {
            for (out, values) in [(&mut *x, grid.x), (&mut *y, grid.y), (&mut *coc, grid.coc)] {
                if values.is_empty() {
                    continue;
                }
                let [from, to] = grid.ends_of(values, range, segment);
                out[0].extend_from_slice(from);
                out[1].extend(from.iter().zip(to).map(|(from, to)| to - from));
            }
            let z = grid.ends_of(grid.depth, range, segment);
            self.depth.iter_mut().zip(z).for_each(|(depth, z)| depth.extend_from_slice(z));
        }
        self.is_sharp = coc.iter().flatten().all(|&coc| coc == 0);
        let len = x[0].len() + LANES;
        for values in x.iter_mut().chain(y).chain(coc) {
            values.resize(len, values.last().copied().unwrap_or_default());
        }
        self.depth.iter_mut().for_each(|depth| depth.resize(len, 0.0));
        self.wide = Some(wide);
        true
    }

    /// A vertex.
    #[inline(always)]
    pub fn vertex(&self, ix: usize) -> PackedVertex {
        PackedVertex {
            place: self.place[ix],
            motion: self.motion[ix],
            coc: self.coc[ix],
            coc_change: self.coc_change[ix],
        }
    }
}

/// The pixel around which positions are packed.
pub(super) fn middle(extent: &Extent) -> [i32; 2] {
    [0, 1].map(|axis| (extent.least[axis] + extent.most[axis]) >> 9)
}

/// How far vertices are from each other, and how far they move.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spread {
    /// Around those of each key, in focus.
    pub boxes: [Extent; 2],
    /// Least and greatest circle of confusion.
    coc: [i32; 2],
    /// The greatest without its sign.
    most_coc: i32,
    most_motion: i32,
}

impl Default for Spread {
    fn default() -> Self {
        Spread { boxes: [Extent::EMPTY; 2], coc: [0; 2], most_coc: 0, most_motion: 0 }
    }
}

impl Spread {
    #[inline(always)]
    fn of(grid: &MovingGrid, segment: usize, vertices: impl Iterator<Item = Range<usize>>) -> Self {
        let mut boxes = [Extent::EMPTY; 2];
        let (mut coc, mut most_motion) = ([i32::MAX, i32::MIN], 0);
        for range in vertices {
            for (axis, values) in [grid.x, grid.y].into_iter().enumerate() {
                let [from, to] = grid.ends_of(values, &range, segment);
                for (extent, values) in boxes.iter_mut().zip([from, to]) {
                    [extent.least[axis], extent.most[axis]] =
                        widened([extent.least[axis], extent.most[axis]], values);
                }
                for (from, to) in from.iter().zip(to) {
                    most_motion = most_motion.max((to - from).abs());
                }
            }
            if !grid.coc.is_empty() {
                let [c0, c1] = grid.ends_of(grid.coc, &range, segment);
                coc = widened(widened(coc, c0), c1);
            } else {
                coc = [0; 2];
            }
        }
        Spread { boxes, coc, most_coc: coc[0].abs().max(coc[1].abs()), most_motion }
    }

    /// The pixel from which vertices are packed in 16 bits; nothing where they do not fit.
    fn origin(&self) -> Option<[i32; 2]> {
        let mut all = self.boxes[0];
        all.add(self.boxes[1]);
        // The middle is rounded down by less than a pixel.
        let fits = self.most_coc <= MOST / 4
            && self.most_motion <= MOST
            && self.boxes.iter().all(|extent| self.is_small(extent, MOST))
            && self.is_small(&all, 2 * (MOST - 256));
        fits.then(|| middle(&all))
    }

    /// See [`PackedSegment::corners`]; from `zero` on, which is near enough for 16 bits.
    fn corners(&self, zero: [i32; 2]) -> [[i32; 3]; 2] {
        let [from, to] = &self.boxes;
        let ends = [[from.least, to.least], [from.most, to.most]];
        [0, 1].map(|end| {
            let ([[x0, y0], [x1, y1]], coc) = (ends[end], self.coc[end]);
            [pair(x0 - zero[0], y0 - zero[1]), pair(x1 - x0, y1 - y0), pair(coc, coc)]
        })
    }

    /// A box around the vertices for a tuple, of which the local time and the lens place are pairs, in 1/256 px; what is
    /// rounded included.
    pub fn of_tuple(&self, time: i32, lens: i32) -> Extent {
        let fraction = |half: i32| f64::from(half) / 32_768.0;
        let (t, lens) = (fraction(time >> 16), [fraction((lens as i16).into()), fraction(lens >> 16)]);
        let [from, to] = &self.boxes;
        let mut extent = Extent::EMPTY;
        for (axis, lens) in lens.into_iter().enumerate() {
            let between = |a: i32, b: i32| f64::from(a) + t * (f64::from(b) - f64::from(a));
            let [a, b] = self.coc.map(|coc| lens * f64::from(coc));
            extent.least[axis] = (between(from.least[axis], to.least[axis]) + a.min(b) - 2.0) as i32;
            extent.most[axis] = (between(from.most[axis], to.most[axis]) + a.max(b) + 2.0) as i32;
        }
        extent
    }

    /// Whether a box is at most so large, circles of confusion included.
    fn is_small(&self, extent: &Extent, most: i32) -> bool {
        [0, 1].iter().all(|&axis| extent.most[axis] - extent.least[axis] <= most - 2 * self.most_coc)
    }
}

/// A range of values, widened by some more.
#[inline(always)]
fn widened([mut least, mut most]: [i32; 2], values: &[i32]) -> [i32; 2] {
    for &value in values {
        (least, most) = (least.min(value), most.max(value));
    }
    [least, most]
}

/// Vertices over all segments.
#[derive(Debug, Default)]
pub(super) struct Packed {
    /// One after the other.
    pub segments: Vec<PackedSegment>,
}

impl Packed {
    /// Packs ranges of vertices, one after the other; whether they fit in all segments.
    #[inline(always)]
    pub fn pack(&mut self, draw: &MovingDraw, vertices: impl Iterator<Item = Range<usize>> + Clone) -> bool {
        self.make_room(draw);
        for (ix, segment) in self.segments.iter_mut().enumerate() {
            if !segment.pack(&draw.grid, ix, vertices.clone(), &draw.samples.region) {
                return false;
            }
        }
        true
    }

    /// As [`Self::pack`], in 32 bits where vertices move too far.
    #[inline(always)]
    pub fn pack_any(&mut self, draw: &MovingDraw, vertices: &[Range<usize>]) -> bool {
        self.make_room(draw);
        for (ix, segment) in self.segments.iter_mut().enumerate() {
            let fits = segment.pack(&draw.grid, ix, vertices.iter().cloned(), &draw.samples.region);
            if !fits && !segment.pack_wide(&draw.grid, ix, vertices) {
                return false;
            }
        }
        true
    }

    /// Whether all vertices are within [`MOST`] of each other at any two times and lens places, so that a sample among them
    /// can be tested for a tuple for which the micropolygon is elsewhere.
    pub fn stays_near(&self) -> bool {
        self.segments.iter().all(|segment| {
            let [mut all, end] = segment.spread.boxes;
            all.add(end);
            segment.spread.is_small(&all, MOST)
        })
    }

    fn make_room(&mut self, draw: &MovingDraw) {
        let num_segments = (draw.grid.num_keys() - 1).max(1);
        self.segments.resize_with(num_segments, PackedSegment::default);
    }
}

/// Four of the vertices: a micropolygon.
#[derive(Clone, Copy)]
pub(super) struct PackedQuad<'a> {
    pub packed: &'a Packed,
    /// Which they are.
    pub at: [usize; 4],
}

impl PackedQuad<'_> {
    #[inline(always)]
    pub fn vertex(&self, segment: usize, corner: usize) -> PackedVertex {
        self.packed.segments[segment].vertex(self.at[corner])
    }

    #[inline(always)]
    pub fn frame(&self, segment: usize) -> &Frame {
        &self.packed.segments[segment].frame
    }
}
