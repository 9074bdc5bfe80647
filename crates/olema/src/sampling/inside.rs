//! The exact inside test, and depth at a hit.
//!
//! In: a triangle and a sample in 1/256 px of raster space, each coordinate within +-2^29 (a guard band of
//! +-2^21 px). Out: whether it is hit, from which side, and the weights of its vertices. The functions here
//! are the rule that every rasterizer must keep, bit for bit. Source: watertight edge functions as in Pineda
//! 1988; the tie rule is a symbolic perturbation (Edelsbrunner and Muecke 1990).
//!
//! The edge function of an edge from A to B is twice the signed area of (A, B, sample):
//!
//! ```text
//! E = (Bx - Ax) (sy - Ay) - (By - Ay) (sx - Ax)
//! v0 ---- v1     v0 = (i, j)          E of each edge of (v0, v1, v2) is above 0 inside where, as drawn
//!    \     |     v1 = (i + 1, j)      here, i goes right and j goes down on the screen: sign +1.
//!      \   |     v2 = (i + 1, j + 1)  Seen from behind it is -1. What is front is up to the caller.
//! v3 ---- v2     v3 = (i, j + 1)      A quad is the triangles 0 = (v0, v1, v2) and 1 = (v0, v2, v3).
//! ```
//!
//! The sample is taken at (x + e, y + e^2) for an infinitesimal e > 0: E grows by (Bx - Ax) e^2 -
//! (By - Ay) e, so where E is 0 the sign is that of -(By - Ay), or where that is 0 too, of Bx - Ax. No sample
//! is then on any edge, and the two directions of an edge always have opposite signs: a sample of a shared
//! edge belongs to exactly one side. The perturbed E of a triangle's edges still sum to twice its area, so a
//! degenerate triangle is never hit. Differences need 31 bits and a sign, products 60 bits, E 61: all exact.

/// Largest absolute value of a coordinate, in 1/256 px.
pub const GUARD_BAND: i32 = 1 << 29;

/// A triangle that is hit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Hit {
    /// +1 or -1: the side it is seen from (the sign of its area).
    pub sign: i8,
    /// Twice the signed area of the sample with the edge opposite each vertex; the weight of that vertex.
    /// Unperturbed: 0 or of the sign of `area`.
    pub w: [i64; 3],
    /// Twice the signed area of the triangle, the sum of `w`; not 0.
    pub area: i64,
}

/// Where on its triangle a hit lies: the weights of the second and the third vertex in 1/65536, rounded down, in 16 bits
/// each. The first has the rest, which is never below 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Weights(pub u32);

/// Weights are kept in these parts of 1.
pub(crate) const WEIGHT_PARTS: f32 = 65_536.0;

impl Weights {
    /// Weights of the second and the third vertex, 0 to 1 but for rounding.
    #[inline(always)]
    pub fn new(upper: [f32; 2]) -> Self {
        let [b1, b2] = upper.map(|b| ((b * WEIGHT_PARTS) as u32).min(0xffff));
        Weights(b1 | b2 << 16)
    }

    /// Weights of the three vertices; their sum is exactly 1.
    #[inline(always)]
    pub fn get(self) -> [f32; 3] {
        let [b1, b2] = [self.0 & 0xffff, self.0 >> 16];
        [0x1_0000 - (b1 + b2).min(0x1_0000), b1, b2].map(|part| part as i32 as f32 * (1.0 / WEIGHT_PARTS))
    }
}

/// What a hit is kept as.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HitPoint {
    /// Depth.
    pub depth: f32,
    /// Place on the triangle.
    pub weights: Weights,
}

/// The edge function: twice the signed area of (a, b, s).
#[inline(always)]
pub fn edge(a: [i32; 2], b: [i32; 2], s: [i32; 2]) -> i64 {
    let [dx, dy] = [i64::from(b[0]) - i64::from(a[0]), i64::from(b[1]) - i64::from(a[1])];
    dx * (i64::from(s[1]) - i64::from(a[1])) - dy * (i64::from(s[0]) - i64::from(a[0]))
}

/// The sign, -1 or +1, of edge function value `e` of the edge from a to b at the perturbed sample; 0 where
/// a = b.
#[inline(always)]
pub fn perturbed_sign(e: i64, a: [i32; 2], b: [i32; 2]) -> i32 {
    if e != 0 {
        return if e > 0 { 1 } else { -1 };
    }
    if a[1] != b[1] {
        return if b[1] < a[1] { 1 } else { -1 };
    }
    (i32::from(b[0] > a[0])) - (i32::from(b[0] < a[0]))
}

/// Tests sample `s` against triangle `v`.
#[inline]
pub fn triangle_hit(v: [[i32; 2]; 3], s: [i32; 2]) -> Option<Hit> {
    let w = [edge(v[1], v[2], s), edge(v[2], v[0], s), edge(v[0], v[1], s)];
    let signs = perturbed_sign(w[0], v[1], v[2])
        + perturbed_sign(w[1], v[2], v[0])
        + perturbed_sign(w[2], v[0], v[1]);
    if signs.abs() != 3 {
        return None;
    }
    Some(Hit { sign: signs.signum() as i8, w, area: w[0] + w[1] + w[2] })
}

/// Twice the signed area of a triangle; its sign is that of every hit of it.
#[inline(always)]
pub fn signed_area(v: [[i32; 2]; 3]) -> i64 {
    edge(v[0], v[1], v[2])
}

/// Depth at a hit: the plane through the vertices' depths, within their range.
///
/// In f32, in this order, each step rounded: `r = 1 / area`, `b1 = w1 r`, `b2 = w2 r` (area and weights
/// rounded to f32 first), then `(z0 + b1 (z1 - z0)) + b2 (z2 - z0)`, then clamped. A kernel has to do the
/// same: one division a triangle, no fused multiply-add.
#[inline]
pub fn depth_at(hit: &Hit, z: [f32; 3]) -> f32 {
    let [b1, b2] = upper_weights(hit);
    let depth = (z[0] + b1 * (z[1] - z[0])) + b2 * (z[2] - z[0]);
    let least = lesser(lesser(z[0], z[1]), z[2]);
    let most = greater(greater(z[0], z[1]), z[2]);
    // A difference of infinite depths is not a number and becomes `least`.
    lesser(greater(depth, least), most)
}

/// `b` unless `a` is below it: the rule of SIMD minimum instructions, also for -0 and NaN.
#[inline(always)]
pub(super) fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// `b` unless `a` is above it.
#[inline(always)]
pub(super) fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Depth and place at a hit of a triangle whose vertices are at depths `z`.
#[inline]
pub fn point_at(hit: &Hit, z: [f32; 3]) -> HitPoint {
    HitPoint { depth: depth_at(hit, z), weights: Weights::new(upper_weights(hit)) }
}

#[inline(always)]
fn upper_weights(hit: &Hit) -> [f32; 2] {
    let r = 1.0 / hit.area as f32;
    [hit.w[1] as f32 * r, hit.w[2] as f32 * r]
}
