//! The exact test of up to 16 samples of a moving micropolygon, a lane each.
//!
//! In: positions of the vertices for each sample's tuple, and its place, as pairs of 16 bits ([`super::packed`]). Out:
//! which samples are hit, and where, as by [`super::inside`], bit for bit. Twin: [`Micropolygon::test`].

use super::draw::{Micropolygon, Triangle};
use super::inside::WEIGHT_PARTS;
use super::nomotion::{Facing, HitPoints};
use crate::math::lanes::Lanes;

/// What of a micropolygon can be hit.
#[derive(Clone, Copy)]
pub(super) struct Shape {
    /// All bits where it has the triangle.
    triangles: [u32; 2],
    facing: Facing,
}

impl Shape {
    /// A quad.
    #[inline(always)]
    pub fn whole(facing: Facing) -> Self {
        Shape { triangles: [u32::MAX; 2], facing }
    }

    #[inline(always)]
    pub fn of(triangles: &[Triangle], facing: Facing) -> Self {
        let mut shape = Shape { triangles: [0; 2], facing };
        for &(number, _) in triangles {
            shape.triangles[number as usize] = u32::MAX;
        }
        shape
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

    /// Depths of the vertices at local times `t`.
    #[inline(always)]
    pub fn all_at<L: Lanes>(&self, lanes: L, t: L::F) -> [L::F; 4] {
        [self.at(lanes, 0, t), self.at(lanes, 1, t), self.at(lanes, 2, t), self.at(lanes, 3, t)]
    }

    /// Depth of a vertex at local times `t`, as [`super::MovingGrid::depth_at`].
    #[inline(always)]
    fn at<L: Lanes>(&self, lanes: L, corner: usize, t: L::F) -> L::F {
        let [z0, z1] = self.ends[corner];
        if self.is_level {
            return lanes.splat_f(z0);
        }
        depth_between(lanes, lanes.splat_f(z0), lanes.splat_f(z1), t)
    }
}

/// Depth from those at the keys before and after, as [`super::MovingGrid::depth_at`].
#[inline(always)]
pub(super) fn depth_between<L: Lanes>(lanes: L, z0: L::F, z1: L::F, t: L::F) -> L::F {
    let (least, most) = (lanes.lesser(z0, z1), lanes.greater(z0, z1));
    let depth = lanes.add_f(z0, lanes.mul_f(t, lanes.sub_f(z1, z0)));
    lanes.lesser(lanes.greater(depth, least), most)
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
pub(super) fn test<L: Lanes>(lanes: L, shape: Shape, place: L::I, at: &[L::I; 4], active: u32) -> Tested<L> {
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
    let facing = shape.facing;
    let hit = [
        active & shape.triangles[0] & !((n01 ^ n12) | (n12 ^ n20)) & shown(lanes, area0, facing),
        active & shape.triangles[1] & !((n23 ^ n30) | (n30 ^ !n20)) & shown(lanes, area1, facing),
    ];
    Tested { hit, e01, e20, e30, area: [area0, area1] }
}

impl<L: Lanes> Tested<L> {
    /// The points that are hit, and bits of those that are seen from side -1: of the first triangle in the lanes `first`,
    /// else of the second; the vertices are at depths `z`.
    #[inline(always)]
    pub fn points(&self, lanes: L, z: [L::F; 4], first: u32) -> (HitPoints<L>, u32) {
        let (zero, first) = (lanes.splat(0), lanes.mask(first));
        let w1 = lanes.select(first, self.e20, self.e30);
        let w2 = lanes.select(first, self.e01, lanes.sub(zero, self.e20));
        let area = lanes.select(first, self.area[0], self.area[1]);
        let (za, zb) = (lanes.select_f(first, z[1], z[2]), lanes.select_f(first, z[2], z[3]));
        let upper = upper_weights(lanes, w1, w2, lanes.div_f(lanes.splat_f(1.0), lanes.to_f(area)));
        let depth = plane(lanes, upper, [z[0], za, zb]);
        (HitPoints { depth, weights: weights(lanes, upper) }, lanes.bits(lanes.gt(zero, area)))
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
    // A closure would not be inlined.
    let first = lanes.truncated(lanes.lesser(lanes.mul_f(b1, parts), most));
    let second = lanes.truncated(lanes.lesser(lanes.mul_f(b2, parts), most));
    lanes.or(first, lanes.shl(second, 16))
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
