//! Places of vertices that move too far for 16 bits: in 32, then in 16 from an origin that each tuple has for itself.

use super::tuple::{OfTuple, Scratch};
use crate::math::lanes::Lanes;
use crate::math::simd::LANES;
use crate::sampling::packed::{Frame, Wide, middle};

impl OfTuple<'_> {
    /// Places the vertices, and the frame with them.
    #[inline(always)]
    pub(super) fn place_wide<L: Lanes>(&mut self, lanes: L, wide: &Wide, scratch: &mut Scratch) {
        let in_order = self.draw.grid.times.in_order();
        let (time, lens) = (in_order.time[self.place_in_time], in_order.lens[self.place_in_time]);
        let origin = middle(&self.segment.spread.of_tuple(time, lens));
        self.frame = Frame::new(origin, &self.draw.samples.region);
        let [ox, oy] = [lanes.splat(origin[0] * 256), lanes.splat(origin[1] * 256)];
        let len = self.part.num.next_multiple_of(LANES);
        let time = lanes.splat(self.time.t15.into());
        let [u, v] = [lanes.splat(self.tuple.u15.into()), lanes.splat(self.tuple.v15.into())];
        for first in (0..len).step_by(LANES) {
            let mut at = [between(lanes, &wide.x, first, time), between(lanes, &wide.y, first, time)];
            if !self.segment.is_sharp {
                let coc = between(lanes, &wide.coc, first, time);
                at = [lanes.add(at[0], scaled(lanes, u, coc)), lanes.add(at[1], scaled(lanes, v, coc))];
            }
            let packed = packed(lanes, lanes.sub(at[0], ox), lanes.sub(at[1], oy));
            lanes.store(packed, &mut scratch.at, first);
        }
    }
}

/// x and y as a pair.
#[inline(always)]
fn packed<L: Lanes>(lanes: L, x: L::I, y: L::I) -> L::I {
    lanes.or(lanes.and(x, lanes.splat(0xffff)), lanes.shl(y, 16))
}

/// Values at a local time, from those at the first key and their changes.
#[inline(always)]
fn between<L: Lanes>(lanes: L, [from, change]: &[Vec<i32>; 2], first: usize, time: L::I) -> L::I {
    lanes.add(lanes.load(from, first), scaled(lanes, time, lanes.load(change, first)))
}

/// `(fraction value + 2^14) >> 15`, exact for values below 2^23.
#[inline(always)]
fn scaled<L: Lanes>(lanes: L, fraction: L::I, value: L::I) -> L::I {
    // The value as 256 high + low, of which low is never negative; rounding down twice is rounding down once.
    let (high, low) = (lanes.shr(value, 8), lanes.and(value, lanes.splat(0xff)));
    let low = lanes.add(lanes.mul(fraction, low), lanes.splat(1 << 14));
    lanes.shr(lanes.add(lanes.mul(fraction, high), lanes.shr(low, 8)), 7)
}
