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

/// What a test finds.
pub(super) struct Tested<L: Lanes> {
    /// Lanes in which each triangle is hit.
    pub hit: [u32; 2],
    edges: Edges<L>,
}

/// Edge functions of v1 v0, v1 v2, v2 v0, v3 v2 and v3 v0: these need two turned vertices, not four.
#[derive(Clone, Copy)]
struct Edges<L: Lanes> {
    e10: L::I,
    e12: L::I,
    e20: L::I,
    e32: L::I,
    e30: L::I,
}

/// Tests samples at `place` against a micropolygon whose vertices are `at`, in the lanes that are `active`.
#[inline(always)]
pub(super) fn test<L: Lanes>(lanes: L, shape: Shape, place: L::I, at: &[L::I; 4], active: u32) -> Tested<L> {
    let zero = lanes.splat(0);
    // `array::map` is not inlined.
    let mut rel = [zero; 4];
    for corner in 0..4 {
        rel[corner] = lanes.sub2(at[corner], place);
    }
    let (turned0, turned2) = (lanes.turned(rel[0]), lanes.turned(rel[2]));
    let edges = Edges {
        e10: lanes.dot2(rel[1], turned0),
        e12: lanes.dot2(rel[1], turned2),
        e20: lanes.dot2(rel[2], turned0),
        e32: lanes.dot2(rel[3], turned2),
        e30: lanes.dot2(rel[3], turned0),
    };
    let on = lanes.either(lanes.eq(edges.e10, zero), lanes.eq(edges.e12, zero));
    let on = lanes.either(on, lanes.eq(edges.e20, zero));
    let on = lanes.either(on, lanes.either(lanes.eq(edges.e32, zero), lanes.eq(edges.e30, zero)));
    let is_on_an_edge = lanes.bits(on) & active != 0;
    let hit = if is_on_an_edge {
        edges.hit_perturbed(lanes, at, shape.facing)
    } else {
        edges.hit(lanes, shape.facing)
    };
    Tested { hit: [hit[0] & active & shape.triangles[0], hit[1] & active & shape.triangles[1]], edges }
}

impl<L: Lanes> Edges<L> {
    /// Where each triangle is hit, if no edge function is 0; then one that is hit has an area.
    #[inline(always)]
    fn hit(&self, lanes: L, facing: Facing) -> [u32; 2] {
        let Edges { e10, e12, e20, e32, e30 } = *self;
        // In the sign bits: e01, e12 and e20 are alike; e23, e30 and e02 are.
        let first = lanes.and(lanes.xor(e10, e12), lanes.not(lanes.xor(e12, e20)));
        let second = lanes.and(lanes.xor(e32, e30), lanes.xor(e30, e20));
        let zero = lanes.splat(0);
        let (first, second) = match facing {
            Facing::Any => (first, second),
            Facing::Only(side) if side > 0 => {
                (lanes.and(first, lanes.not(e12)), lanes.and(second, lanes.not(e30)))
            }
            Facing::Only(_) => (lanes.and(first, e12), lanes.and(second, e30)),
        };
        [lanes.bits(lanes.gt(zero, first)), lanes.bits(lanes.gt(zero, second))]
    }

    /// Where each triangle is hit.
    #[inline(always)]
    fn hit_perturbed(&self, lanes: L, at: &[L::I; 4], facing: Facing) -> [u32; 2] {
        // What decides where a sample is on an edge: y, then against x (see `inside`).
        let mut key = [lanes.splat(0); 4];
        for (key, &at) in key.iter_mut().zip(at) {
            *key = lanes.xor(at, lanes.splat(0x7fff));
        }
        let n10 = below(lanes, self.e10, key[1], key[0]);
        let n12 = below(lanes, self.e12, key[1], key[2]);
        let n20 = below(lanes, self.e20, key[2], key[0]);
        let n32 = below(lanes, self.e32, key[3], key[2]);
        let n30 = below(lanes, self.e30, key[3], key[0]);
        let area = self.areas(lanes);
        [
            (n10 ^ n12) & !(n12 ^ n20) & shown(lanes, area[0], facing),
            (n32 ^ n30) & (n30 ^ n20) & shown(lanes, area[1], facing),
        ]
    }

    /// Twice the area of each triangle.
    #[inline(always)]
    fn areas(&self, lanes: L) -> [L::I; 2] {
        let first = lanes.sub(lanes.add(self.e12, self.e20), self.e10);
        [first, lanes.sub(lanes.sub(self.e30, self.e32), self.e20)]
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

impl<L: Lanes> Tested<L> {
    /// The points that are hit, and bits of those that are seen from side -1: of the first triangle in the lanes `first`,
    /// else of the second; the vertices are at depths `z`.
    #[inline(always)]
    pub fn points(&self, lanes: L, z: [L::F; 4], first: u32) -> (HitPoints<L>, u32) {
        let (zero, first) = (lanes.splat(0), lanes.mask(first));
        let Edges { e10, e20, e30, .. } = self.edges;
        let areas = self.edges.areas(lanes);
        let w1 = lanes.select(first, e20, e30);
        let w2 = lanes.sub(zero, lanes.select(first, e10, e20));
        let area = lanes.select(first, areas[0], areas[1]);
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
