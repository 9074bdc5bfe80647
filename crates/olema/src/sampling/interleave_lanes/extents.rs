//! For which tuples a part of a grid can be in the region, 16 at a time, and in which of its pixels.

use crate::math::lanes::{Lanes, pair};
use crate::math::simd::LANES;
use crate::sampling::draw::MovingDraw;
use crate::sampling::packed::PackedSegment;

/// Pixels of 16 tuples.
pub(super) struct Extents {
    /// Lanes in which there are any.
    pub some: u32,
    /// The first and the last of each, pairs.
    pixels: [[i32; LANES]; 2],
    /// From the region's corner to where they count from.
    offset: [i32; 2],
}

impl Extents {
    /// Of tuples of a segment, `first` on in the order of time, in lanes that are `active`.
    #[inline(always)]
    pub fn new<L: Lanes>(
        lanes: L,
        draw: &MovingDraw,
        segment: &PackedSegment,
        first: usize,
        active: u32,
    ) -> Self {
        if segment.wide.is_some() {
            return Extents::wide(draw, segment, first, active);
        }
        let in_order = draw.grid.times.in_order();
        let (time, lens) = (lanes.load(&in_order.time, first), lanes.load(&in_order.lens, first));
        let [least, most] = segment
            .corners
            .map(|[place, motion, coc]| [lanes.splat(place), lanes.splat(motion), lanes.splat(coc)]);
        // Rounded as vertices are, which are between these corners at both keys and so stay there.
        let (coc0, coc1) = (lanes.scale2(lens, least[2]), lanes.scale2(lens, most[2]));
        let least = lanes.add2(least[0], lanes.scale2(time, least[1]));
        let least = lanes.add2(least, lanes.min2(coc0, coc1));
        let most = lanes.add2(most[0], lanes.scale2(time, most[1]));
        let most = lanes.add2(most, lanes.max2(coc0, coc1));
        let first_px = lanes.max2(lanes.shr2(least, 8), lanes.splat(segment.frame.first_px));
        let last_px = lanes.min2(lanes.shr2(most, 8), lanes.splat(segment.frame.last_px));
        let signs =
            lanes.and(lanes.sub2(last_px, first_px), lanes.splat(pair(i16::MIN.into(), i16::MIN.into())));
        let some = lanes.bits(lanes.eq(signs, lanes.splat(0))) & active;
        let mut pixels = [[0; LANES]; 2];
        lanes.store(first_px, &mut pixels[0], 0);
        lanes.store(last_px, &mut pixels[1], 0);
        Extents { some, pixels, offset: segment.frame.offset }
    }

    /// Of a part that moves too far for 16 bits.
    #[inline(never)]
    fn wide(draw: &MovingDraw, segment: &PackedSegment, first: usize, active: u32) -> Self {
        let (region, in_order) = (draw.samples.region, draw.grid.times.in_order());
        let mut extents = Extents { some: 0, pixels: [[0; LANES]; 2], offset: [0; 2] };
        for lane in (0..LANES).filter(|lane| active >> lane & 1 != 0) {
            let extent = segment.spread.of_tuple(in_order.time[first + lane], in_order.lens[first + lane]);
            let first = [extent.least[0] >> 8, extent.least[1] >> 8];
            let last = [extent.most[0] >> 8, extent.most[1] >> 8];
            let first = [first[0].max(region.x0) - region.x0, first[1].max(region.y0) - region.y0];
            let last = [last[0].min(region.x1 - 1) - region.x0, last[1].min(region.y1 - 1) - region.y0];
            if first[0] <= last[0] && first[1] <= last[1] {
                extents.some |= 1 << lane;
                extents.pixels[0][lane] = pair(first[0], first[1]);
                extents.pixels[1][lane] = pair(last[0], last[1]);
            }
        }
        extents
    }

    /// For the tuple of a lane the first and the last along x and along y, from the region's corner.
    #[inline(always)]
    pub fn pixels(&self, lane: usize) -> [i32; 4] {
        let [first, last] = [self.pixels[0][lane & (LANES - 1)], self.pixels[1][lane & (LANES - 1)]];
        let [x, y] = self.offset;
        [x + i32::from(first as i16), x + i32::from(last as i16), y + (first >> 16), y + (last >> 16)]
    }
}
