//! Samples that wait to be tested, of several tuples, and the tests.
//!
//! What a test needs is gathered vertex by vertex, and loaded by the vector when it has long been stored: a processor
//! waits for a vector that is loaded from what single stores have just written. Nothing branches on what is hit, which
//! cannot be guessed.

use super::part::{OfShape, Part};
use super::tuple::{OfTuple, Scratch};
use crate::math::lanes::{Lanes, pair};
use crate::math::simd::LANES;
use crate::sampling::nomotion::{HitSink, HitsApart, SampleCounts};
use crate::sampling::test_lanes::{Shape, test};

/// Samples that wait at most; what they need stays in the fastest cache.
const MOST: usize = 256;

/// What is known of two vertices.
const SIDE: usize = 4;

/// Samples to test. Lists have room for a vector.
#[derive(Default)]
pub(super) struct Pending {
    len: usize,
    /// Places, as the positions.
    place: Vec<i32>,
    /// Samples of the region.
    sample: Vec<i32>,
    /// First vertices of the quads.
    quad: Vec<i32>,
    /// Position and bits of the depth of a quad's first and second vertex, and of its fourth and third.
    sides: [Vec<i32>; 2],
    hits: Hits,
}

/// Hits, a list for each of what is known of them, with room for a vector.
#[derive(Default)]
struct Hits {
    len: usize,
    sample: Vec<i32>,
    code: Vec<i32>,
    depth: Vec<i32>,
    weights: Vec<i32>,
}

impl Pending {
    pub(super) fn renew(&mut self) {
        self.len = 0;
        let Pending { place, sample, quad, sides, hits, .. } = self;
        [place, sample, quad].into_iter().for_each(|list| list.resize(MOST + LANES, 0));
        sides.iter_mut().for_each(|list| list.resize(SIDE * (MOST + LANES), 0));
        // Both triangles of a folded quad may be hit.
        let Hits { sample, code, depth, weights, .. } = hits;
        [sample, code, depth, weights].into_iter().for_each(|list| list.resize(2 * MOST + LANES, 0));
    }
}

impl OfTuple<'_> {
    /// Gathers what it takes to test what is listed, and empties the list. Tests when too many wait.
    #[inline(always)]
    pub(super) fn gather<L: Lanes, S: HitSink>(
        &self,
        lanes: L,
        scratch: &mut Scratch,
        counts: &mut SampleCounts,
        sink: &mut S,
    ) {
        let mut from = 0;
        while from < scratch.listed.len {
            let num = (scratch.listed.len - from).min(MOST - scratch.pending.len);
            self.gather_some(lanes, scratch, from, num);
            from += num;
            if scratch.pending.len == MOST {
                scratch.pending.test(lanes, self.part, self.of_shape, counts, sink);
            }
        }
        scratch.listed.len = 0;
    }

    /// Gathers what it takes to test `num` of the list, `from` one on.
    #[inline(always)]
    fn gather_some<L: Lanes>(&self, lanes: L, scratch: &mut Scratch, from: usize, num: usize) {
        let Scratch { vertices, listed, pending, .. } = scratch;
        let samples = self.draw.samples;
        for first in (0..num).step_by(LANES) {
            let entry = lanes.load(&listed.entries, from + first);
            // Bytes with a sign.
            let (x, y) = (lanes.shr(lanes.shl(entry, 24), 24), lanes.shr(lanes.shl(entry, 16), 24));
            let corner = lanes.or(lanes.shl(lanes.and(x, lanes.splat(0xff)), 8), lanes.shl(y, 24));
            let place = lanes.or(corner, lanes.splat(pair(self.tuple.x.into(), self.tuple.y.into())));
            let row = lanes.mul(y, lanes.splat(samples.region.width() as i32));
            let pixel_ix = lanes.add(lanes.add(row, x), lanes.splat(self.frame.pixel_ix));
            let sample = lanes.mul(pixel_ix, lanes.splat(samples.samples_per_pixel() as i32));
            let sample = lanes.add(sample, lanes.splat(self.stratum));
            lanes.store(place, &mut pending.place, pending.len + first);
            lanes.store(sample, &mut pending.sample, pending.len + first);
            lanes.store(lanes.shr(entry, 16), &mut pending.quad, pending.len + first);
        }
        // Two vertices are one vector of 128 bits. All of the same length, so that a quad is checked once.
        let len = 2 * (self.part.num + 1);
        let (upper, lower) = (&vertices[..len], &vertices[2 * (self.part.m + 1)..][..len]);
        let range = SIDE * pending.len..SIDE * (pending.len + num);
        let [out0, out1] = &mut pending.sides;
        let out = out0[range.clone()].chunks_exact_mut(SIDE).zip(out1[range].chunks_exact_mut(SIDE));
        for (entry, (out0, out1)) in listed.entries[from..from + num].iter().zip(out) {
            let first = 2 * (entry >> 16) as usize;
            out0.copy_from_slice(&upper[first..first + SIDE]);
            out1.copy_from_slice(&lower[first..first + SIDE]);
        }
        pending.len += num;
    }
}

impl Pending {
    /// Tests all, and sends the hits.
    #[inline(always)]
    pub(super) fn test<L: Lanes, S: HitSink>(
        &mut self,
        lanes: L,
        part: &Part,
        of_shape: &OfShape,
        counts: &mut SampleCounts,
        sink: &mut S,
    ) {
        let Some(shape) = of_shape.shape else { return };
        counts.tests += self.len as u64;
        for first in (0..self.len).step_by(LANES) {
            let active = 0xffff_u32 >> (LANES - (self.len - first).min(LANES));
            counts.hits += u64::from(self.test_vector(lanes, part, of_shape, shape, first, active));
        }
        let Hits { len, sample, code, depth, weights } = &mut self.hits;
        sink.hits_apart(&HitsApart {
            samples: &sample[..*len],
            codes: &code[..*len],
            depth_bits: &depth[..*len],
            weights: &weights[..*len],
        });
        (self.len, *len) = (0, 0);
    }

    /// Tests those `first` on that are `active`, and keeps the hits; how many samples are hit.
    #[inline(always)]
    fn test_vector<L: Lanes>(
        &mut self,
        lanes: L,
        part: &Part,
        of_shape: &OfShape,
        shape: Shape,
        first: usize,
        active: u32,
    ) -> u32 {
        let (at, z_bits) = corners(lanes, &self.sides, first, of_shape);
        let mut z = [lanes.splat_f(0.0); 4];
        for (z, &bits) in z.iter_mut().zip(&z_bits) {
            *z = lanes.of_bits(bits);
        }
        let tested = test(lanes, shape, lanes.load(&self.place, first), &at, active);
        let sample = lanes.load(&self.sample, first);
        let code = lanes.shl(part.numbers(lanes, lanes.load(&self.quad, first)), 2);
        let [hit0, hit1] = tested.hit;
        let (zero, one, two) = (lanes.splat(0), lanes.splat(1), lanes.splat(2));
        // Where both triangles of a folded quad are hit, the second is for another turn.
        let mut turn = [hit0, hit1 & !hit0];
        loop {
            let (points, negative) = tested.points(lanes, z, turn[0]);
            let triangle = lanes.select(lanes.mask(turn[0]), zero, two);
            let side = lanes.select(lanes.mask(negative), one, zero);
            let code = lanes.or(code, lanes.or(triangle, side));
            let depth = lanes.bits_of(points.depth);
            self.hits.add(lanes, turn[0] | turn[1], [sample, code, depth, points.weights]);
            turn = [0, turn[0] & hit1];
            if turn[1] == 0 {
                return (hit0 | hit1).count_ones();
            }
        }
    }
}

/// Positions and bits of depths of the four corners of 16 micropolygons, from the sides of their quads.
#[inline(always)]
fn corners<L: Lanes>(
    lanes: L,
    [upper, lower]: &[Vec<i32>; 2],
    first: usize,
    of_shape: &OfShape,
) -> ([L::I; 4], [L::I; 4]) {
    let [[v0, v1], [z0, z1]] = side(lanes, upper, first);
    let [[v3, v2], [z3, z2]] = side(lanes, lower, first);
    let (at, z) = ([v0, v1, v2, v3], [z0, z1, z2, z3]);
    let [a, b, c, d] = of_shape.vertices;
    ([at[a & 3], at[b & 3], at[c & 3], at[d & 3]], [z[a & 3], z[b & 3], z[c & 3], z[d & 3]])
}

/// Positions and depths of the two vertices of 16 sides.
#[inline(always)]
fn side<L: Lanes>(lanes: L, sides: &[i32], first: usize) -> [[L::I; 2]; 2] {
    let sides = &sides[SIDE * first..][..SIDE * LANES];
    let (at, z) = lanes.deinterleave(lanes.load(sides, 0), lanes.load(sides, LANES));
    let (more_at, more_z) = lanes.deinterleave(lanes.load(sides, 2 * LANES), lanes.load(sides, 3 * LANES));
    let ((at0, at1), (z0, z1)) = (lanes.deinterleave(at, more_at), lanes.deinterleave(z, more_z));
    [[at0, at1], [z0, z1]]
}

impl Hits {
    /// Adds those in the lanes `found`: sample, code, depth and weights.
    #[inline(always)]
    fn add<L: Lanes>(&mut self, lanes: L, found: u32, values: [L::I; 4]) {
        let mask = lanes.mask(found);
        let lists = [&mut self.sample, &mut self.code, &mut self.depth, &mut self.weights];
        for (list, value) in lists.into_iter().zip(values) {
            lanes.store(lanes.compress(value, mask), list, self.len);
        }
        self.len += found.count_ones() as usize;
    }
}
