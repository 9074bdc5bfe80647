//! The list of samples to test for a tuple.

use crate::math::lanes::Lanes;
use crate::math::simd::LANES;

/// Samples to test.
#[derive(Default)]
pub(super) struct Listed {
    pub(super) len: usize,
    /// First vertex of the quad in the upper half, the pixel's y and x from the origin in a byte each. With room for a
    /// vector.
    pub(super) entries: Vec<i32>,
}

impl Listed {
    #[cold]
    #[inline(never)]
    fn grow(&mut self) {
        self.entries.resize(2 * (self.len + 2 * LANES), 0);
    }

    /// Lists pixels to test quads with, in the lanes `found`.
    #[inline(always)]
    pub(super) fn add<L: Lanes>(&mut self, lanes: L, quad: L::I, pixel: L::I, found: u32) {
        let x = lanes.and(pixel, lanes.splat(0xff));
        let y = lanes.and(lanes.shr(pixel, 8), lanes.splat(0xff00));
        let entry = lanes.or(lanes.shl(quad, 16), lanes.or(x, y));
        // One for these, and one for the last that are loaded.
        if self.entries.len() < self.len + 2 * LANES {
            self.grow();
        }
        lanes.store(lanes.compress(entry, lanes.mask(found)), &mut self.entries, self.len);
        self.len += found.count_ones() as usize;
    }
}
