//! The exact test of up to 16 samples of a moving micropolygon, a lane each.
//!
//! In: positions of the vertices for each sample's tuple, and its place, as pairs of 16 bits ([`super::packed`]). Out:
//! hits with the depth of [`super::inside`], bit for bit, to the sink; counted. Twin: [`Micropolygon::test`].

use super::draw::Micropolygon;
use super::inside::{HitPoint, WEIGHT_PARTS, Weights};
use super::nomotion::{Facing, HitPoints, HitSink, SampleCounts};
use crate::math::lanes::Lanes;
use crate::math::simd::LANES;

/// Samples to test; those from `num` on are not looked at.
pub(super) struct Kept {
    /// Lanes in use, from the first.
    pub num: usize,
    /// Index in the region.
    pub sample: [i32; LANES],
    /// Place, as the vertices.
    pub place: [i32; LANES],
    /// Positions of the vertices.
    pub at: [[i32; LANES]; 4],
    /// Local time.
    pub t: [f32; LANES],
}

impl Kept {
    #[inline(always)]
    pub fn new(num: usize) -> Self {
        Kept { num, sample: [0; LANES], place: [0; LANES], at: [[0; LANES]; 4], t: [0.0; LANES] }
    }
}

/// Depths of a micropolygon's vertices at the keys before and after a segment.
pub(super) struct Depths {
    ends: [[f32; 2]; 4],
    /// Whether they are the same at both.
    is_level: bool,
}

impl Depths {
    #[inline(always)]
    pub fn of(micropolygon: &Micropolygon, segment: usize) -> Self {
        let grid = micropolygon.grid();
        let ends = micropolygon.vertices.map(|v| grid.ends(v, segment as u16).map(|ix| grid.depth[ix]));
        Depths { ends, is_level: ends.iter().all(|[z0, z1]| z0.to_bits() == z1.to_bits()) }
    }

    /// Depth of a vertex at local times `t`, as [`super::MovingGrid::depth_at`].
    #[inline(always)]
    fn at<L: Lanes>(&self, lanes: L, corner: usize, t: L::F) -> L::F {
        let [z0, z1] = self.ends[corner];
        if self.is_level {
            return lanes.splat_f(z0);
        }
        let (least, most) = (super::inside::lesser(z0, z1), super::inside::greater(z0, z1));
        let depth = lanes.add_f(lanes.splat_f(z0), lanes.mul_f(t, lanes.splat_f(z1 - z0)));
        lanes.lesser(lanes.greater(depth, lanes.splat_f(least)), lanes.splat_f(most))
    }
}

/// Where the perturbed sign of an edge function is negative; the edge runs between vertices with these keys.
#[inline(always)]
fn below<L: Lanes>(lanes: L, e: L::I, from: L::I, to: L::I) -> u32 {
    let zero = lanes.splat(0);
    let on = lanes.both(lanes.eq(e, zero), lanes.gt(to, from));
    lanes.bits(lanes.either(lanes.gt(zero, e), on))
}

/// Where a triangle of this area shows a side that can be hit. One without area shows none: that of three vertices in one
/// place would pass the test of signs.
#[inline(always)]
fn shown<L: Lanes>(lanes: L, area: L::I, facing: Facing) -> u32 {
    let zero = lanes.splat(0);
    match facing {
        Facing::Any => !lanes.bits(lanes.eq(area, zero)),
        Facing::Only(side) if side > 0 => lanes.bits(lanes.gt(area, zero)),
        Facing::Only(_) => lanes.bits(lanes.gt(zero, area)),
    }
}

/// What a test finds.
pub(super) struct Tested<L: Lanes> {
    /// Lanes in which each triangle is hit.
    pub hit: [u32; 2],
    /// Edge functions that are weights of depth: of v0 v1, v2 v0 and v3 v0.
    e01: L::I,
    e20: L::I,
    e30: L::I,
    area: [L::I; 2],
}

/// Tests samples at `place` against a micropolygon whose vertices are `at`, in the lanes that are `active`.
#[inline(always)]
pub(super) fn test<L: Lanes>(
    lanes: L,
    micropolygon: &Micropolygon,
    place: L::I,
    at: &[L::I; 4],
    active: u32,
) -> Tested<L> {
    let zero = lanes.splat(0);
    // `array::map` is not inlined.
    let (mut rel, mut turned, mut key) = ([zero; 4], [zero; 4], [zero; 4]);
    for corner in 0..4 {
        rel[corner] = lanes.sub2(at[corner], place);
        turned[corner] = lanes.turned(rel[corner]);
        // What decides where a sample is on an edge: y, then against x (see `inside`).
        key[corner] = lanes.xor(at[corner], lanes.splat(0x7fff));
    }
    let e01 = lanes.dot2(rel[0], turned[1]);
    let e12 = lanes.dot2(rel[1], turned[2]);
    let e20 = lanes.dot2(rel[2], turned[0]);
    let e23 = lanes.dot2(rel[2], turned[3]);
    let e30 = lanes.dot2(rel[3], turned[0]);
    let n01 = below(lanes, e01, key[0], key[1]);
    let n12 = below(lanes, e12, key[1], key[2]);
    let n20 = below(lanes, e20, key[2], key[0]);
    let n23 = below(lanes, e23, key[2], key[3]);
    let n30 = below(lanes, e30, key[3], key[0]);
    let area0 = lanes.add(lanes.add(e01, e12), e20);
    let area1 = lanes.sub(lanes.add(e23, e30), e20);
    let mut hit = [0; 2];
    for &(number, _) in micropolygon.triangles {
        hit[number as usize] = active;
    }
    let facing = micropolygon.facing();
    hit[0] &= !((n01 ^ n12) | (n12 ^ n20)) & shown(lanes, area0, facing);
    hit[1] &= !((n23 ^ n30) | (n30 ^ !n20)) & shown(lanes, area1, facing);
    Tested { hit, e01, e20, e30, area: [area0, area1] }
}

impl<L: Lanes> Tested<L> {
    /// The points that are hit, and bits of those that are seen from side -1: of the first triangle in the lanes `first`,
    /// else of the second; at local times `t`.
    #[inline(always)]
    pub fn points(&self, lanes: L, depths: &Depths, t: L::F, first: u32) -> (HitPoints<L>, u32) {
        let (zero, first) = (lanes.splat(0), lanes.mask(first));
        let w1 = lanes.select(first, self.e20, self.e30);
        let w2 = lanes.select(first, self.e01, lanes.sub(zero, self.e20));
        let area = lanes.select(first, self.area[0], self.area[1]);
        let z2 = depths.at(lanes, 2, t);
        let za = lanes.select_f(first, depths.at(lanes, 1, t), z2);
        let zb = lanes.select_f(first, z2, depths.at(lanes, 3, t));
        let upper = upper_weights(lanes, w1, w2, lanes.div_f(lanes.splat_f(1.0), lanes.to_f(area)));
        let depth = plane(lanes, upper, [depths.at(lanes, 0, t), za, zb]);
        (HitPoints { depth, weights: weights(lanes, upper) }, lanes.bits(lanes.gt(zero, area)))
    }
}

/// Tests samples that lie apart, and hands the hits to the sink.
#[inline(always)]
pub(super) fn test_kept<L: Lanes, S: HitSink>(
    lanes: L,
    micropolygon: &Micropolygon,
    depths: &Depths,
    kept: &Kept,
    counts: &mut SampleCounts,
    sink: &mut S,
) {
    let mut at = [lanes.splat(0); 4];
    for (at, kept) in at.iter_mut().zip(&kept.at) {
        *at = lanes.load(kept, 0);
    }
    let active = 0xffff_u32 >> (LANES - kept.num);
    let tested = test(lanes, micropolygon, lanes.load(&kept.place, 0), &at, active);
    let mut rest = tested.hit;
    counts.hits += u64::from((rest[0] | rest[1]).count_ones());
    while rest[0] | rest[1] != 0 {
        // Where both triangles of a folded quad are hit, the second is for another turn.
        let (points, negative) = tested.points(lanes, depths, lanes.load_f(&kept.t, 0), rest[0]);
        let (mut out, mut weights) = ([0.0; LANES], [0; LANES]);
        lanes.store_f(points.depth, &mut out, 0);
        lanes.store(points.weights, &mut weights, 0);
        let mut bits = rest[0] | rest[1];
        while bits != 0 {
            let lane = bits.trailing_zeros() as usize & (LANES - 1);
            let triangle = (rest[0] >> lane & 1 ^ 1) as u8;
            let sign = if negative >> lane & 1 == 1 { -1 } else { 1 };
            let point = HitPoint { depth: out[lane], weights: Weights(weights[lane] as u32) };
            sink.hit(kept.sample[lane] as usize, point, triangle, sign);
            bits &= bits - 1;
        }
        rest = [0, rest[0] & rest[1]];
    }
}

/// Weights of the second and the third vertex; `r` is 1 over the area.
#[inline(always)]
pub(super) fn upper_weights<L: Lanes>(lanes: L, w1: L::I, w2: L::I, r: L::F) -> [L::F; 2] {
    [lanes.mul_f(lanes.to_f(w1), r), lanes.mul_f(lanes.to_f(w2), r)]
}

/// As [`Weights::new`].
#[inline(always)]
pub(super) fn weights<L: Lanes>(lanes: L, [b1, b2]: [L::F; 2]) -> L::I {
    let (parts, most) = (lanes.splat_f(WEIGHT_PARTS), lanes.splat_f(65_535.0));
    let part = |b: L::F| lanes.truncated(lanes.lesser(lanes.mul_f(b, parts), most));
    lanes.or(part(b1), lanes.shl(part(b2), 16))
}

/// Depth from the weights of the second and third vertex, as [`super::inside::depth_at`].
#[inline(always)]
fn plane<L: Lanes>(lanes: L, [b1, b2]: [L::F; 2], z: [L::F; 3]) -> L::F {
    let first = lanes.add_f(z[0], lanes.mul_f(b1, lanes.sub_f(z[1], z[0])));
    let depth = lanes.add_f(first, lanes.mul_f(b2, lanes.sub_f(z[2], z[0])));
    let least = lanes.lesser(lanes.lesser(z[0], z[1]), z[2]);
    let most = lanes.greater(lanes.greater(z[0], z[1]), z[2]);
    lanes.lesser(lanes.greater(depth, least), most)
}
