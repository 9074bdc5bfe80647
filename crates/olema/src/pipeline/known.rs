//! Known: what was measured of edges and patches, once a frame.
//!
//! In: measurements, each a function of its edge or patch alone. Out: the same again, for the patches that share an edge
//! and for all tiles that a patch reaches into. Two workers may measure the same thing at the same time; they find the
//! same number, so it does not matter whose is kept.

use std::sync::atomic::{AtomicU32, Ordering};

use super::rate::Rate;

/// Nothing was measured yet.
const UNKNOWN: u32 = 0;
const UNEVEN: u32 = 1;
const EYE: u32 = 2;
/// A rate of k segments is k more than this.
const EVEN: u32 = 2;

/// Measurements of a frame. Whatever was not made room for is measured anew each time.
#[derive(Debug, Default)]
pub struct Known {
    /// Two an edge: of the whole of it or its first half, and of its second half.
    rates: Vec<AtomicU32>,
    /// Segments that the inside of a patch asks for, one more along u in the upper 16 bits.
    inner: Vec<AtomicU32>,
    /// Bits of how far displacement moves the points of a patch, one more.
    reach: Vec<AtomicU32>,
}

impl Known {
    /// Room for edges and patches.
    pub fn new(num_edges: usize, num_patches: usize) -> Self {
        let unknown = |len: usize| (0..len).map(|_| AtomicU32::new(UNKNOWN)).collect();
        Known { rates: unknown(2 * num_edges), inner: unknown(num_patches), reach: unknown(num_patches) }
    }

    /// The rate of an edge, or of the half of one that is `halved`.
    pub fn rate(
        &self,
        edge: u32,
        halved: bool,
        [level, part]: [u32; 2],
        measure: impl FnOnce() -> Rate,
    ) -> Rate {
        let kept = level == u32::from(halved);
        let Some(slot) = self.rates.get(2 * edge as usize + part as usize).filter(|_| kept) else {
            return measure();
        };
        match slot.load(Ordering::Relaxed) {
            UNKNOWN => {}
            UNEVEN => return Rate::Uneven,
            EYE => return Rate::Eye,
            number => return Rate::Even(number - EVEN),
        }
        let rate = measure();
        let number = match rate {
            Rate::Uneven => UNEVEN,
            Rate::Eye => EYE,
            Rate::Even(k) => EVEN + k,
        };
        slot.store(number, Ordering::Relaxed);
        rate
    }

    /// The segments along u and v, below 65,535, that the inside of a patch asks for.
    pub fn inner_segments(&self, patch: u32, measure: impl FnOnce() -> [u32; 2]) -> [u32; 2] {
        let Some(slot) = self.inner.get(patch as usize) else {
            return measure();
        };
        let number = slot.load(Ordering::Relaxed);
        if number != UNKNOWN {
            return [(number >> 16) - 1, number & 0xffff];
        }
        let segments = measure();
        debug_assert!(segments.iter().all(|&s| s < 0xffff), "a lattice has 65,000 lines at most");
        slot.store((segments[0] + 1) << 16 | segments[1], Ordering::Relaxed);
        segments
    }
}

impl Known {
    /// How far displacement moves the points of a patch, at least 0.
    pub fn reach(&self, patch: u32, measure: impl FnOnce() -> f32) -> f32 {
        let Some(slot) = self.reach.get(patch as usize) else {
            return measure();
        };
        let number = slot.load(Ordering::Relaxed);
        if number != UNKNOWN {
            return f32::from_bits(number - 1);
        }
        let reach = measure();
        slot.store(reach.to_bits() + 1, Ordering::Relaxed);
        reach
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_measured_comes_back_unmeasured() {
        let known = Known::new(3, 1);
        for (edge, rate) in [(0, Rate::Even(7)), (1, Rate::Uneven), (2, Rate::Eye)] {
            assert_eq!(known.rate(edge, false, [0, 0], || rate), rate);
            assert_eq!(known.rate(edge, false, [0, 0], || unreachable!()), rate);
        }
        assert_eq!(known.inner_segments(0, || [0, 65_000]), [0, 65_000]);
        assert_eq!(known.inner_segments(0, || unreachable!()), [0, 65_000]);
    }

    #[test]
    fn halves_of_edges_are_kept_apart_and_smaller_parts_not_at_all() {
        let known = Known::new(1, 0);
        assert_eq!(known.rate(0, true, [1, 0], || Rate::Even(1)), Rate::Even(1));
        assert_eq!(known.rate(0, true, [1, 1], || Rate::Even(2)), Rate::Even(2));
        assert_eq!(known.rate(0, true, [1, 0], || unreachable!()), Rate::Even(1));
        assert_eq!(known.rate(0, true, [2, 1], || Rate::Even(3)), Rate::Even(3));
        assert_eq!(known.rate(0, true, [2, 1], || Rate::Even(4)), Rate::Even(4));
        assert_eq!(known.rate(9, false, [0, 0], || Rate::Even(5)), Rate::Even(5));
        assert_eq!(known.inner_segments(0, || [1, 2]), [1, 2]);
    }
}
