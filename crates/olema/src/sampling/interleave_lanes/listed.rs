//! The list of samples to test, and the tests.

use super::tuple::{OfTuple, Scratch};
use crate::math::lanes::{Lanes, pair};
use crate::math::simd::LANES;
use crate::sampling::nomotion::{HitSink, HitsApart, SampleCounts};
use crate::sampling::test_lanes::{depth_between, test};

/// Samples to test.
#[derive(Default)]
pub(super) struct Listed {
    pub(super) len: usize,
    /// First vertex of the quad in the upper half, the pixel's y and x from the origin in a byte each. With room for a
    /// vector.
    entries: Vec<i32>,
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

impl OfTuple<'_> {
    /// Tests what is listed, and empties the list.
    #[inline(always)]
    pub(super) fn test<L: Lanes, S: HitSink>(
        &self,
        lanes: L,
        scratch: &mut Scratch,
        counts: &mut SampleCounts,
        sink: &mut S,
    ) {
        let Some(shape) = self.of_shape.shape else { return };
        let Scratch { at, listed, .. } = scratch;
        counts.tests += listed.len as u64;
        // Those of each corner are as many as of the others, so that a quad is checked once.
        let (num, [c0, c1, c2, c3]) = (self.part.num, self.of_shape.corners);
        let (a0, a1, a2, a3) = (&at[c0..][..num], &at[c1..][..num], &at[c2..][..num], &at[c3..][..num]);
        let [from, to] = &self.segment.depth;
        let t = lanes.splat_f(f32::from(self.time.t15) * (1.0 / 32_768.0));
        let samples = self.draw.samples;
        let low = lanes.splat(0xff);
        for first in (0..listed.len).step_by(LANES) {
            let num = (listed.len - first).min(LANES);
            let entry = lanes.load(&listed.entries, first);
            // Bytes with a sign.
            let (x, y) = (lanes.shr(lanes.shl(entry, 24), 24), lanes.shr(lanes.shl(entry, 16), 24));
            let corner = lanes.or(lanes.shl(lanes.and(x, low), 8), lanes.shl(y, 24));
            let place = lanes.or(corner, lanes.splat(pair(self.tuple.x.into(), self.tuple.y.into())));
            let row = lanes.mul(y, lanes.splat(samples.region.width() as i32));
            let pixel_ix = lanes.add(lanes.add(row, x), lanes.splat(self.frame.pixel_ix));
            let sample = lanes.mul(pixel_ix, lanes.splat(samples.samples_per_pixel() as i32));
            let sample = lanes.add(sample, lanes.splat(self.stratum));
            let mut quads = [0; LANES];
            lanes.store(lanes.shr(entry, 16), &mut quads, 0);
            let mut corners = [[0; LANES]; 4];
            for lane in 0..num {
                let quad = quads[lane] as usize;
                corners[0][lane] = a0[quad];
                corners[1][lane] = a1[quad];
                corners[2][lane] = a2[quad];
                corners[3][lane] = a3[quad];
            }
            let mut at_lanes = [lanes.splat(0); 4];
            for (at, corners) in at_lanes.iter_mut().zip(&corners) {
                *at = lanes.load(corners, 0);
            }
            let tested = test(lanes, shape, place, &at_lanes, 0xffff_u32 >> (LANES - num));
            let hit = tested.hit[0] | tested.hit[1];
            if hit == 0 {
                continue;
            }
            counts.hits += u64::from(hit.count_ones());
            let (mut z, mut micropolygons, mut sample_ix) = ([[[0.0; LANES]; 2]; 4], [0; LANES], [0; LANES]);
            lanes.store(sample, &mut sample_ix, 0);
            for lane in bits(hit) {
                let quad = quads[lane] as usize;
                for (z, corner) in z.iter_mut().zip(self.of_shape.corners) {
                    (z[0][lane], z[1][lane]) = (from[quad + corner], to[quad + corner]);
                }
                micropolygons[lane] = self.part.quads[quad];
            }
            let mut z_lanes = [lanes.splat_f(0.0); 4];
            for (at, [z0, z1]) in z_lanes.iter_mut().zip(&z) {
                *at = depth_between(lanes, lanes.load_f(z0, 0), lanes.load_f(z1, 0), t);
            }
            // Where both triangles of a folded quad are hit, the second is for another turn.
            let mut turn = [tested.hit[0], tested.hit[1] & !tested.hit[0]];
            while turn[0] | turn[1] != 0 {
                let (points, negative) = tested.points(lanes, z_lanes, turn[0]);
                let (mut depth, mut weights) = ([0.0; LANES], [0; LANES]);
                lanes.store_f(points.depth, &mut depth, 0);
                lanes.store(points.weights, &mut weights, 0);
                sink.hits_apart(&HitsApart {
                    hits: turn,
                    negative,
                    samples: &sample_ix,
                    micropolygons: &micropolygons,
                    depth: &depth,
                    weights: &weights,
                });
                turn = [0, turn[0] & tested.hit[1]];
            }
        }
        listed.len = 0;
    }
}

/// Numbers of the bits that are set, of 16.
#[inline(always)]
fn bits(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(
        #[inline(always)]
        move || {
            let lane = bits.trailing_zeros() as usize;
            bits &= bits.wrapping_sub(1);
            (lane < LANES).then_some(lane)
        },
    )
}
