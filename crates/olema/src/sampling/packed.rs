//! Packed vertices: a grid in 16 bits, where it fits.
//!
//! In: vertices of a [`MovingGrid`] and a motion segment. Out: their positions from an origin near them, how far they
//! move and their circles of confusion, as pairs of 16 bits ([`crate::math::lanes`]); or nothing where 16 bits do not
//! hold all that can come of them, and a kernel leaves the grid to scalar code with the same bits.
//!
//! What fits: positions within [`MOST`] of the origin at both keys, circles of confusion included; motion below 2^15;
//! and vertices within [`MOST`] of each other at both keys, so that differences of positions and edge functions of
//! samples among them stay within 16 and 32 bits (see [`super::moving`]: rounded terms stay between the keys').

use super::draw::MovingDraw;
use super::moving::{Extent, MovingGrid};
use super::region::Region;
use crate::math::lanes::pair;

/// Greatest distance in 1/256 px: 125 px.
pub(super) const MOST: i32 = 32_000;

/// Origins are multiples of so many pixels: of every K that kernels take.
const ALIGN: i32 = 8;

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
            pixel_ix: (origin[1].wrapping_sub(region.y0).wrapping_mul(region.width() as i32))
                .wrapping_add(origin[0].wrapping_sub(region.x0)),
        }
    }
}

/// Packs `vertices` over a segment into `packed`, one after the other; their frame, or nothing where they do not fit.
fn pack(
    grid: &MovingGrid,
    segment: usize,
    vertices: impl Iterator<Item = usize> + Clone,
    region: &Region,
    packed: &mut Vec<PackedVertex>,
) -> Option<Frame> {
    let at = |ix: usize| [grid.x[ix], grid.y[ix]];
    let coc = |ix: usize| if grid.coc.is_empty() { 0 } else { grid.coc[ix] };
    let mut boxes = [Extent::EMPTY; 2];
    let (mut most_coc, mut most_motion) = (0, 0);
    for ends in vertices.clone().map(|vertex| grid.ends(vertex, segment as u16)) {
        for (extent, end) in boxes.iter_mut().zip(ends) {
            extent.add(Extent { least: at(end), most: at(end) });
            most_coc = most_coc.max(coc(end).abs());
        }
        let [from, to] = ends.map(at);
        most_motion = most_motion.max((to[0] - from[0]).abs()).max((to[1] - from[1]).abs());
    }
    let mut all = boxes[0];
    all.add(boxes[1]);
    let is_small = |extent: &Extent, most: i32| {
        [0, 1].iter().all(|&axis| extent.most[axis] - extent.least[axis] <= most - 2 * most_coc)
    };
    if most_coc > MOST / 4 || most_motion > MOST || !boxes.iter().all(|extent| is_small(extent, MOST)) {
        return None;
    }
    let origin = [0, 1].map(|axis| ((all.least[axis] + all.most[axis]) >> 9) & -ALIGN);
    let zero = origin.map(|px| px * 256);
    // The middle is rounded down by less than 8 pixels.
    if !is_small(&all, 2 * (MOST - 256 * ALIGN)) {
        return None;
    }
    packed.extend(vertices.map(|vertex| {
        let ends = grid.ends(vertex, segment as u16);
        let ([from, to], [c0, c1]) = (ends.map(at), ends.map(coc));
        PackedVertex {
            place: pair(from[0] - zero[0], from[1] - zero[1]),
            motion: pair(to[0] - from[0], to[1] - from[1]),
            coc: pair(c0, c0),
            coc_change: pair(c1 - c0, c1 - c0),
        }
    }));
    Some(Frame::new(origin, region))
}

/// Vertices over all segments.
#[derive(Default)]
pub(super) struct Packed {
    vertices: Vec<Vec<PackedVertex>>,
    frames: Vec<Frame>,
}

impl Packed {
    /// Packs vertices; whether they fit in all segments.
    pub fn pack(&mut self, draw: &MovingDraw, vertices: impl Iterator<Item = usize> + Clone) -> bool {
        let num_segments = (draw.grid.num_keys() - 1).max(1);
        self.vertices.resize_with(num_segments, Vec::new);
        self.frames.clear();
        for (segment, packed) in self.vertices.iter_mut().enumerate() {
            packed.clear();
            let frame = pack(&draw.grid, segment, vertices.clone(), &draw.samples.region, packed);
            let Some(frame) = frame else { return false };
            self.frames.push(frame);
        }
        true
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
    pub fn vertex(&self, segment: usize, corner: usize) -> &PackedVertex {
        &self.packed.vertices[segment][self.at[corner]]
    }

    #[inline(always)]
    pub fn frame(&self, segment: usize) -> &Frame {
        &self.packed.frames[segment]
    }
}
