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
    /// Where `num` more can be added. The list grows here, so that loops that add to it call nothing.
    #[inline(always)]
    pub(super) fn room(&mut self, num: usize) -> Room<'_> {
        // One vector for the last that is stored, and one for the last that are loaded.
        let needed = self.len + num + 2 * LANES;
        if self.entries.len() < needed {
            self.grow(needed);
        }
        Room { entries: &mut self.entries, len: self.len }
    }

    #[cold]
    #[inline(never)]
    fn grow(&mut self, needed: usize) {
        self.entries.resize(2 * needed, 0);
    }
}

/// Room at the end of a list.
pub(super) struct Room<'a> {
    entries: &'a mut [i32],
    /// The list's length, to be given back to it.
    pub(super) len: usize,
}

impl Room<'_> {
    /// Lists pixels to test quads with, in the lanes `found`.
    #[inline(always)]
    pub(super) fn add<L: Lanes>(&mut self, lanes: L, quad: L::I, pixel: L::I, found: u32) {
        let x = lanes.and(pixel, lanes.splat(0xff));
        let y = lanes.and(lanes.shr(pixel, 8), lanes.splat(0xff00));
        let entry = lanes.or(lanes.shl(quad, 16), lanes.or(x, y));
        lanes.store(lanes.compress(entry, lanes.mask(found)), self.entries, self.len);
        self.len += found.count_ones() as usize;
    }
}
