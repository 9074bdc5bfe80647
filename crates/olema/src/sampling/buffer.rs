//! The sample buffer: for each sample of a region the nearest opaque thing that hit it.
//!
//! In: hits (sample, depth, payload), in any order. Out: one [`Record`] a sample, the same for every order.
//! A record is 12 bytes, so that a tile's buffer stays in cache: it names what was hit and where on it, colours are looked
//! up at resolve.

use std::cmp::Ordering;
use std::ops::Range;

use super::inside::{HitPoint, Weights};
use super::nomotion::{HitPoints, HitsApart};
use super::region::Region;
use crate::math::lanes::Lanes;
use crate::math::simd::{LANES, LanesKernel, SimdLevel};

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
    /// Where on it.
    pub weights: Weights,
}

impl Record {
    /// Nothing was hit.
    pub const NONE: Record = Record { depth: f32::INFINITY, payload: Payload::NONE, weights: Weights(0) };

    /// The hit of `payload` at a point.
    #[inline(always)]
    pub fn new(point: HitPoint, payload: Payload) -> Self {
        Record { depth: point.depth, payload, weights: point.weights }
    }

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
    len: usize,
    /// Depths, payloads and weights apart, so that kernels take 16 at a time; with 16 more that nobody reads.
    depths: Vec<f32>,
    payloads: Vec<i32>,
    weights: Vec<i32>,
    /// Whether a record of each block was replaced since they were last cleared.
    written: Vec<bool>,
}

impl SampleBuffer {
    /// Records that share a mark in [`Self::written`].
    pub const BLOCK: usize = 16;

    /// An empty buffer of `samples_per_pixel` (M) records a pixel.
    pub fn new(region: Region, samples_per_pixel: usize) -> Self {
        let mut buffer = SampleBuffer {
            region,
            samples_per_pixel,
            len: 0,
            depths: Vec::new(),
            payloads: Vec::new(),
            weights: Vec::new(),
            written: Vec::new(),
        };
        buffer.renew(region);
        buffer
    }

    /// Empties the buffer for another region, in the same memory.
    pub fn renew(&mut self, region: Region) {
        self.region = region;
        self.len = region.num_pixels() * self.samples_per_pixel;
        self.depths.clear();
        self.depths.resize(self.len + LANES, Record::NONE.depth);
        self.payloads.clear();
        self.payloads.resize(self.len + LANES, Record::NONE.payload.0 as i32);
        // What is left in them is not looked at where nothing was hit.
        self.weights.resize(self.len + LANES, 0);
        self.written.clear();
        self.written.resize(self.len.div_ceil(Self::BLOCK) + 1, false);
    }

    /// Whether a record was replaced, for each [`Self::BLOCK`] of them, since [`Self::clear_written`].
    pub fn written(&self) -> &[bool] {
        &self.written[..self.len.div_ceil(Self::BLOCK)]
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

    /// Number of records.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// All records.
    pub fn records(&self) -> impl ExactSizeIterator<Item = Record> + '_ {
        self.records_of(0..self.len)
    }

    /// The records of a range of samples.
    pub fn records_of(&self, samples: Range<usize>) -> impl ExactSizeIterator<Item = Record> + '_ {
        let depths = self.depths[samples.clone()].iter();
        let names = self.payloads[samples.clone()].iter().zip(&self.weights[samples]);
        depths.zip(names).map(|(&depth, (&payload, &weights))| record(depth, payload, weights))
    }

    /// Depths of all records.
    #[inline(always)]
    pub fn depths(&self) -> &[f32] {
        &self.depths[..self.len]
    }

    /// Depths, payloads and weights of a range of samples.
    #[inline(always)]
    pub fn lists(&self, samples: Range<usize>) -> (&[f32], &[i32], &[i32]) {
        (&self.depths[samples.clone()], &self.payloads[samples.clone()], &self.weights[samples])
    }

    /// The record of a sample.
    #[inline(always)]
    pub fn get(&self, sample_ix: usize) -> Record {
        record(self.depths[sample_ix], self.payloads[sample_ix], self.weights[sample_ix])
    }

    /// Calls `visit` with the payloads of all hits; those that are alike and near each other may be left out but for one.
    #[inline(always)]
    pub fn each_named(&self, visit: impl FnMut(Payload)) {
        SimdLevel::best().run_lanes(EachNamed { payloads: &self.payloads, len: self.len, visit });
    }

    /// The M records of a pixel of the region.
    pub fn pixel(&self, px: i32, py: i32) -> impl ExactSizeIterator<Item = Record> + '_ {
        let start = self.region.pixel_ix(px, py) * self.samples_per_pixel;
        self.records_of(start..start + self.samples_per_pixel)
    }

    /// Keeps the hit if it comes before what is there; returns whether it did.
    ///
    /// `order` is the canonical order of two hits of equal depth: a strict total order that does not depend
    /// on when they arrive. Depths that are not numbers are refused.
    #[inline(always)]
    pub fn offer(
        &mut self,
        sample_ix: usize,
        hit: Record,
        order: &impl Fn(Payload, Payload) -> Ordering,
    ) -> bool {
        let depth = self.depths[sample_ix];
        // Not where either is no number. As near is rare, and also the first one although infinitely far.
        let nearer = hit.depth < depth
            || (hit.depth == depth && self.get(sample_ix).is_behind(hit.depth, hit.payload, order));
        if nearer {
            self.depths[sample_ix] = hit.depth;
            self.payloads[sample_ix] = hit.payload.0 as i32;
            self.weights[sample_ix] = hit.weights.0 as i32;
            self.written[sample_ix / Self::BLOCK] = true;
        }
        nearer
    }

    /// [`Self::offer`] for hits of micropolygons of the grid in `slot`. Whether any of them was kept.
    #[inline(always)]
    pub fn offer_apart(
        &mut self,
        hits: &HitsApart,
        slot: u32,
        order: &impl Fn(Payload, Payload) -> Ordering,
    ) -> bool {
        let mut kept = false;
        let of_slot = Payload::new(slot, 0, 0).0 as i32;
        // All of the same length, so that a sample is checked once.
        let len = self.len;
        let SampleBuffer { depths, payloads, weights: all_weights, written, .. } = self;
        let (depths, payloads, all_weights) =
            (&mut depths[..len], &mut payloads[..len], &mut all_weights[..len]);
        let points = hits.depth_bits.iter().zip(hits.weights);
        for ((&sample, &code), (&bits, &weights)) in hits.samples.iter().zip(hits.codes).zip(points) {
            let sample = sample as usize;
            let (depth, payload) = (f32::from_bits(bits as u32), of_slot | (code >> 1));
            let old = depths[sample];
            let nearer = depth < old || {
                let there = record(old, payloads[sample], all_weights[sample]);
                depth == old && is_before(&there, depth, Payload(payload as u32), order)
            };
            if nearer {
                depths[sample] = depth;
                payloads[sample] = payload;
                all_weights[sample] = weights;
                written[sample / Self::BLOCK] = true;
                kept = true;
            }
        }
        kept
    }

    /// [`Self::offer`] for samples `first + i`, lane i of `points`: with `payloads[0]` where bit i of `hit0` is set, with
    /// `payloads[1]` where bit i of `hit1` is; not both. Whether any of them was kept.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    pub fn offer_lanes<L: Lanes>(
        &mut self,
        lanes: L,
        first: usize,
        [hit0, hit1]: [u32; 2],
        points: HitPoints<L>,
        payloads: [Payload; 2],
        order: &impl Fn(Payload, Payload) -> Ordering,
    ) -> bool {
        let (depth, old) = (points.depth, lanes.load_f(&self.depths, first));
        let hit = hit0 | hit1;
        let nearer = lanes.bits(lanes.lt_f(depth, old)) & hit;
        // As near, or the first one although infinitely far: one by one.
        let mut alike = lanes.bits(lanes.eq_f(depth, old)) & hit;
        let mut kept = nearer != 0;
        if kept {
            let mask = lanes.mask(nearer);
            let [payload0, payload1] = [lanes.splat(payloads[0].0 as i32), lanes.splat(payloads[1].0 as i32)];
            let payload = lanes.select(lanes.mask(hit0), payload0, payload1);
            let payload = lanes.select(mask, payload, lanes.load(&self.payloads, first));
            lanes.store_f(lanes.select_f(mask, depth, old), &mut self.depths, first);
            lanes.store(payload, &mut self.payloads, first);
            let weights = lanes.select(mask, points.weights, lanes.load(&self.weights, first));
            lanes.store(weights, &mut self.weights, first);
            let (block, marks) = (first / Self::BLOCK, nearer << (first % Self::BLOCK));
            self.written[block] |= marks & 0xffff != 0;
            self.written[block + 1] |= marks >> 16 != 0;
        }
        if alike != 0 {
            let (mut depths, mut weights) = ([0.0; LANES], [0; LANES]);
            lanes.store_f(depth, &mut depths, 0);
            lanes.store(points.weights, &mut weights, 0);
            while alike != 0 {
                let lane = alike.trailing_zeros() as usize & (LANES - 1);
                let payload = payloads[(hit1 >> lane & 1) as usize];
                let hit = Record { depth: depths[lane], payload, weights: Weights(weights[lane] as u32) };
                kept |= self.offer(first + lane, hit, order);
                alike &= alike - 1;
            }
        }
        kept
    }
}

struct EachNamed<'a, V> {
    /// With room for a vector.
    payloads: &'a [i32],
    len: usize,
    visit: V,
}

impl<V: FnMut(Payload)> LanesKernel for EachNamed<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, lanes: L) {
        let none = lanes.splat(Payload::NONE.0 as i32);
        let mut named = [0; LANES];
        for first in (0..self.len).step_by(LANES) {
            let payloads = lanes.load(self.payloads, first);
            let mut alike = lanes.eq(payloads, none);
            // The sample before, and the ones above and beside it where a pixel has four columns.
            for before in [1, 4, 5] {
                if first >= before {
                    alike =
                        lanes.either(alike, lanes.eq(payloads, lanes.load(self.payloads, first - before)));
                }
            }
            let some = 0xffff >> LANES.saturating_sub(self.len - first);
            let new = some & !lanes.bits(alike);
            lanes.store(lanes.compress(payloads, lanes.mask(new)), &mut named, 0);
            for &payload in &named[..new.count_ones() as usize] {
                (self.visit)(Payload(payload as u32));
            }
        }
    }
}

/// [`Record::is_behind`] where depths are alike, which is rare.
#[cold]
#[inline(never)]
fn is_before(
    there: &Record,
    depth: f32,
    payload: Payload,
    order: &impl Fn(Payload, Payload) -> Ordering,
) -> bool {
    there.is_behind(depth, payload, order)
}

#[inline(always)]
fn record(depth: f32, payload: i32, weights: i32) -> Record {
    Record { depth, payload: Payload(payload as u32), weights: Weights(weights as u32) }
}

#[cfg(test)]
#[path = "buffer_tests.rs"]
mod tests;
