//! The sample buffer: for each sample of a region the nearest opaque thing that hit it.
//!
//! In: hits (sample, depth, payload), in any order. Out: one [`Record`] a sample, the same for every order.
//! A record is 8 bytes, so that a tile's buffer stays in cache: it names what was hit, colours are looked up
//! at resolve.

use std::cmp::Ordering;

use super::region::Region;

/// What was hit: grid slot, micropolygon and triangle in 32 bits.
///
/// ```text
/// bit  31 ........ 13 12 ........ 1 0
///      grid slot (19) micropolygon  triangle
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Payload(pub u32);

impl Payload {
    /// Nothing was hit. No hit has this value: the last grid slot is not used.
    pub const NONE: Payload = Payload(u32::MAX);
    /// Grid slots, 0..NUM_SLOTS.
    pub const NUM_SLOTS: u32 = (1 << 19) - 1;
    /// Micropolygons of a grid, 0..NUM_MICROPOLYGONS.
    pub const NUM_MICROPOLYGONS: u32 = 1 << 12;

    /// Packs; each part must be below its limit, and `triangle` 0 or 1.
    #[inline(always)]
    pub fn new(slot: u32, micropolygon: u32, triangle: u8) -> Self {
        debug_assert!(slot < Self::NUM_SLOTS, "grid slot {slot}");
        debug_assert!(micropolygon < Self::NUM_MICROPOLYGONS, "micropolygon {micropolygon}");
        debug_assert!(triangle < 2, "triangle {triangle}");
        Payload(slot << 13 | micropolygon << 1 | u32::from(triangle))
    }

    /// Grid slot.
    #[inline(always)]
    pub fn slot(self) -> u32 {
        self.0 >> 13
    }

    /// Micropolygon of the grid.
    #[inline(always)]
    pub fn micropolygon(self) -> u32 {
        self.0 >> 1 & 0xfff
    }

    /// Triangle of the quad: 0 is (v0, v1, v2), 1 is (v0, v2, v3).
    #[inline(always)]
    pub fn triangle(self) -> u8 {
        (self.0 & 1) as u8
    }
}

/// The nearest hit of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Record {
    /// Depth of the hit; infinite where nothing was hit.
    pub depth: f32,
    /// What was hit, or [`Payload::NONE`].
    pub payload: Payload,
}

impl Record {
    /// Nothing was hit.
    pub const NONE: Record = Record { depth: f32::INFINITY, payload: Payload::NONE };

    /// Whether nothing was hit.
    #[inline(always)]
    pub fn is_none(&self) -> bool {
        self.payload == Payload::NONE
    }

    /// Whether a hit (depth, payload) comes before this record: nearer, or as near and before it in canonical
    /// order. Everything comes before nothing.
    #[inline(always)]
    pub fn is_behind(
        &self,
        depth: f32,
        payload: Payload,
        order: &impl Fn(Payload, Payload) -> Ordering,
    ) -> bool {
        self.is_none()
            || depth < self.depth
            || (depth == self.depth && order(payload, self.payload) == Ordering::Less)
    }
}

/// Records of a region; sample j of pixel (px, py) is at `region.pixel_ix(px, py) * M + j`, as in
/// [`super::RegionSamples`].
#[derive(Debug, Clone)]
pub struct SampleBuffer {
    region: Region,
    samples_per_pixel: usize,
    records: Vec<Record>,
    /// Whether a record of each block was replaced since they were last cleared.
    written: Vec<bool>,
}

impl SampleBuffer {
    /// Records that share a mark in [`Self::written`].
    pub const BLOCK: usize = 16;

    /// An empty buffer of `samples_per_pixel` (M) records a pixel.
    pub fn new(region: Region, samples_per_pixel: usize) -> Self {
        let records = vec![Record::NONE; region.num_pixels() * samples_per_pixel];
        let written = vec![false; records.len().div_ceil(Self::BLOCK)];
        SampleBuffer { region, samples_per_pixel, records, written }
    }

    /// Empties the buffer for another region, in the same memory.
    pub fn renew(&mut self, region: Region) {
        self.region = region;
        self.records.clear();
        self.records.resize(region.num_pixels() * self.samples_per_pixel, Record::NONE);
        self.written.clear();
        self.written.resize(self.records.len().div_ceil(Self::BLOCK), false);
    }

    /// Whether a record was replaced, for each [`Self::BLOCK`] of them, since [`Self::clear_written`].
    pub fn written(&self) -> &[bool] {
        &self.written
    }

    /// Takes all marks away.
    pub fn clear_written(&mut self) {
        self.written.fill(false);
    }

    /// The pixels.
    pub fn region(&self) -> Region {
        self.region
    }

    /// Samples a pixel, M.
    pub fn samples_per_pixel(&self) -> usize {
        self.samples_per_pixel
    }

    /// All records.
    pub fn records(&self) -> &[Record] {
        &self.records
    }

    /// The record of a sample.
    #[inline(always)]
    pub fn get(&self, sample_ix: usize) -> Record {
        self.records[sample_ix]
    }

    /// The M records of a pixel of the region.
    pub fn pixel(&self, px: i32, py: i32) -> &[Record] {
        let start = self.region.pixel_ix(px, py) * self.samples_per_pixel;
        &self.records[start..start + self.samples_per_pixel]
    }

    /// Keeps the hit if it comes before what is there; returns whether it did.
    ///
    /// `order` is the canonical order of two hits of equal depth: a strict total order that does not depend
    /// on when they arrive. Depths that are not numbers are refused.
    #[inline(always)]
    pub fn offer(
        &mut self,
        sample_ix: usize,
        depth: f32,
        payload: Payload,
        order: &impl Fn(Payload, Payload) -> Ordering,
    ) -> bool {
        let record = &mut self.records[sample_ix];
        let nearer = !depth.is_nan() && record.is_behind(depth, payload, order);
        if nearer {
            *record = Record { depth, payload };
            self.written[sample_ix / Self::BLOCK] = true;
        }
        nearer
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A canonical order that is not the order of the bits.
    fn order(a: Payload, b: Payload) -> Ordering {
        super::super::hash::mix(a.0).cmp(&super::super::hash::mix(b.0))
    }

    #[test]
    fn a_record_is_eight_bytes() {
        assert_eq!(size_of::<Record>(), 8);
    }

    #[test]
    fn payloads_unpack_to_what_was_packed() {
        for slot in [0, 1, 77_777, Payload::NUM_SLOTS - 1] {
            for micropolygon in [0, 1, 255, 4095] {
                for triangle in 0..2 {
                    let payload = Payload::new(slot, micropolygon, triangle);
                    assert_ne!(payload, Payload::NONE);
                    assert_eq!(
                        (payload.slot(), payload.micropolygon(), payload.triangle()),
                        (slot, micropolygon, triangle)
                    );
                }
            }
        }
    }

    #[test]
    fn an_infinitely_far_hit_is_still_a_hit_and_nan_is_none() {
        let mut buffer = SampleBuffer::new(Region::new(-1, 0, 4, 5), 2);
        assert!(!buffer.offer(0, f32::NAN, Payload::new(1, 0, 0), &order));
        assert!(buffer.offer(0, f32::INFINITY, Payload::new(1, 0, 0), &order));
        assert!(buffer.offer(0, 3.0, Payload::new(2, 0, 0), &order));
        assert!(!buffer.offer(0, 3.0, Payload::new(2, 0, 0), &order));
        assert_eq!(
            buffer.pixel(-1, 4),
            [Record { depth: 3.0, payload: Payload::new(2, 0, 0) }, Record::NONE]
        );
    }

    proptest! {
        #[test]
        fn any_order_of_arrival_leaves_the_same_records(
            hits in prop::collection::vec((0usize..6, 0u8..4, 0u32..50), 0..60),
            swaps in prop::collection::vec((0usize..60, 0usize..60), 0..60),
        ) {
            let draw = |hits: &[(usize, u8, u32)]| {
                let mut buffer = SampleBuffer::new(Region::new(0, 3, 0, 1), 2);
                for &(sample_ix, depth, slot) in hits {
                    buffer.offer(sample_ix, f32::from(depth), Payload::new(slot, 0, 0), &order);
                }
                buffer.records().to_vec()
            };
            let mut shuffled = hits.clone();
            for (i, k) in swaps {
                if i < shuffled.len() && k < shuffled.len() {
                    shuffled.swap(i, k);
                }
            }
            prop_assert_eq!(draw(&hits), draw(&shuffled));
        }
    }
}
