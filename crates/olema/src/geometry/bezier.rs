//! Bezier patches: bilinear and bicubic, rational or not.
//!
//! Control point (i, j) of a bicubic patch stands at `j * 4 + i`, u along i, v along j:
//!
//! ```text
//!  v   12 13 14 15
//!  ^    8  9 10 11
//!  |    4  5  6  7
//!       0  1  2  3   -> u
//! ```
//!
//! Every formula is a fixed sequence of single-precision operations, so that a point has the same bits on
//! every machine. Source: Farin, Curves and Surfaces for CAGD; Cook et al. 1987.

use glam::{Vec3, Vec4};

use crate::scene::PatchBasis;

/// A point of a surface with its parametric derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Position.
    pub p: Vec3,
    /// Derivative along u.
    pub du: Vec3,
    /// Derivative along v.
    pub dv: Vec3,
}

/// What a Bezier patch is made of: `Vec3`, or `Vec4` (x w, y w, z w, w) for a rational one.
pub trait ControlPoint: Copy {
    /// a + (b - a) t, component by component.
    fn lerp(a: Self, b: Self, t: f32) -> Self;
    /// a (1 - t) + b t, component by component: next to a huge point a small one keeps its digits.
    fn mix(a: Self, b: Self, t: f32) -> Self;
    /// Weighted sum, in the order of the arguments.
    fn blend(points: [Self; 4], weights: [f32; 4]) -> Self;
    /// The point in space.
    fn position(self) -> Vec3;
    /// Position and derivatives of the quotient, given the homogeneous ones.
    fn surface_point(p: Self, du: Self, dv: Self) -> SurfacePoint;
}

impl ControlPoint for Vec3 {
    #[inline(always)]
    fn lerp(a: Self, b: Self, t: f32) -> Self {
        a + (b - a) * t
    }

    #[inline(always)]
    fn mix(a: Self, b: Self, t: f32) -> Self {
        a * (1.0 - t) + b * t
    }

    #[inline(always)]
    fn blend(p: [Self; 4], w: [f32; 4]) -> Self {
        p[0] * w[0] + p[1] * w[1] + p[2] * w[2] + p[3] * w[3]
    }

    #[inline(always)]
    fn position(self) -> Vec3 {
        self
    }

    #[inline(always)]
    fn surface_point(p: Self, du: Self, dv: Self) -> SurfacePoint {
        SurfacePoint { p, du, dv }
    }
}

impl ControlPoint for Vec4 {
    #[inline(always)]
    fn lerp(a: Self, b: Self, t: f32) -> Self {
        a + (b - a) * t
    }

    #[inline(always)]
    fn mix(a: Self, b: Self, t: f32) -> Self {
        a * (1.0 - t) + b * t
    }

    #[inline(always)]
    fn blend(p: [Self; 4], w: [f32; 4]) -> Self {
        p[0] * w[0] + p[1] * w[1] + p[2] * w[2] + p[3] * w[3]
    }

    #[inline(always)]
    fn position(self) -> Vec3 {
        Vec3::new(self.x / self.w, self.y / self.w, self.z / self.w)
    }

    #[inline(always)]
    fn surface_point(p: Self, du: Self, dv: Self) -> SurfacePoint {
        let position = p.position();
        // Quotient rule: (x / w)' = (x' - (x / w) w') / w.
        let quotient = |d: Vec4| {
            Vec3::new(
                (d.x - position.x * d.w) / p.w,
                (d.y - position.y * d.w) / p.w,
                (d.z - position.z * d.w) / p.w,
            )
        };
        SurfacePoint { p: position, du: quotient(du), dv: quotient(dv) }
    }
}

/// Cubic Bernstein polynomials at t.
#[inline(always)]
fn bernstein(t: f32) -> [f32; 4] {
    let s = 1.0 - t;
    [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t]
}

/// Their derivatives.
#[inline(always)]
fn bernstein_derivative(t: f32) -> [f32; 4] {
    let s = 1.0 - t;
    [-3.0 * s * s, 3.0 * s * s - 6.0 * s * t, 6.0 * s * t - 3.0 * t * t, 3.0 * t * t]
}

/// The point of a cubic curve at t in [0, 1].
#[inline(always)]
pub fn curve_point<P: ControlPoint>(points: [P; 4], t: f32) -> P {
    P::blend(points, bernstein(t))
}

/// A bicubic Bezier patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bicubic<P>(pub [P; 16]);

impl<P: ControlPoint> Bicubic<P> {
    /// Position and derivatives at (u, v) in [0, 1]^2.
    #[inline(always)]
    pub fn evaluate(&self, u: f32, v: f32) -> SurfacePoint {
        self.column(u).evaluate(v)
    }

    /// The curve of constant u.
    #[inline(always)]
    pub fn column(&self, u: f32) -> Column<P> {
        let (bu, du) = (bernstein(u), bernstein_derivative(u));
        let [r0, r1, r2, r3] = self.rows();
        Column {
            points: [P::blend(r0, bu), P::blend(r1, bu), P::blend(r2, bu), P::blend(r3, bu)],
            du: [P::blend(r0, du), P::blend(r1, du), P::blend(r2, du), P::blend(r3, du)],
        }
    }

    /// The position alone, with the same bits.
    #[inline(always)]
    pub fn position(&self, u: f32, v: f32) -> Vec3 {
        let (bu, bv) = (bernstein(u), bernstein(v));
        let [r0, r1, r2, r3] = self.rows();
        P::blend([P::blend(r0, bu), P::blend(r1, bu), P::blend(r2, bu), P::blend(r3, bu)], bv).position()
    }

    /// Control points, row after row.
    #[inline(always)]
    fn rows(&self) -> [[P; 4]; 4] {
        let p = &self.0;
        [
            [p[0], p[1], p[2], p[3]],
            [p[4], p[5], p[6], p[7]],
            [p[8], p[9], p[10], p[11]],
            [p[12], p[13], p[14], p[15]],
        ]
    }

    /// Control points of the curve along a side: 0: v = 0, 1: u = 1, 2: v = 1, 3: u = 0; u or v ascending.
    pub fn side(&self, side: usize) -> [P; 4] {
        let p = &self.0;
        match side {
            0 => [p[0], p[1], p[2], p[3]],
            1 => [p[3], p[7], p[11], p[15]],
            2 => [p[12], p[13], p[14], p[15]],
            _ => [p[0], p[4], p[8], p[12]],
        }
    }

    /// The same surface over `[u0, u1] x [v0, v1]`: its control points are a hull of that part.
    pub fn restrict(&self, u: [f32; 2], v: [f32; 2]) -> Self {
        let mut p = self.0;
        if u != [0.0, 1.0] {
            for j in 0..4 {
                let row = restrict_curve([p[4 * j], p[4 * j + 1], p[4 * j + 2], p[4 * j + 3]], u, P::mix);
                p[4 * j..4 * j + 4].copy_from_slice(&row);
            }
        }
        if v != [0.0, 1.0] {
            for i in 0..4 {
                let column = restrict_curve([p[i], p[4 + i], p[8 + i], p[12 + i]], v, P::mix);
                for (j, point) in column.into_iter().enumerate() {
                    p[4 * j + i] = point;
                }
            }
        }
        Bicubic(p)
    }
}

/// A bicubic patch's curve of constant u: a cubic in v.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Column<P> {
    /// Its control points.
    pub points: [P; 4],
    /// Their derivatives along u.
    pub du: [P; 4],
}

impl<P: ControlPoint> Column<P> {
    /// Position and derivatives at v in [0, 1].
    #[inline(always)]
    pub fn evaluate(&self, v: f32) -> SurfacePoint {
        let (bv, dv) = (bernstein(v), bernstein_derivative(v));
        P::surface_point(P::blend(self.points, bv), P::blend(self.du, bv), P::blend(self.points, dv))
    }
}

/// Control points of a cubic over `[t0, t1]` (its blossom at the new ends).
#[inline(always)]
pub(super) fn restrict_curve<P: Copy>(p: [P; 4], [t0, t1]: [f32; 2], mix: impl Fn(P, P, f32) -> P) -> [P; 4] {
    let near = [mix(p[0], p[1], t0), mix(p[1], p[2], t0), mix(p[2], p[3], t0)];
    let far = [mix(p[0], p[1], t1), mix(p[1], p[2], t1), mix(p[2], p[3], t1)];
    let middle = [mix(near[0], near[1], t1), mix(near[1], near[2], t1)];
    let near = [mix(near[0], near[1], t0), mix(near[1], near[2], t0)];
    let far = [mix(far[0], far[1], t1), mix(far[1], far[2], t1)];
    [
        mix(near[0], near[1], t0),
        mix(near[0], near[1], t1),
        mix(middle[0], middle[1], t1),
        mix(far[0], far[1], t1),
    ]
}

/// A bilinear patch with corners at (u, v) = (0,0), (1,0), (0,1), (1,1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bilinear<P>(pub [P; 4]);

impl<P: ControlPoint> Bilinear<P> {
    /// Position and derivatives at (u, v) in [0, 1]^2.
    #[inline(always)]
    pub fn evaluate(&self, u: f32, v: f32) -> SurfacePoint {
        let [a, b, c, d] = self.0;
        // Differences, not weights: a coordinate that all corners share is kept exactly, so that squares in
        // one plane are equally deep and the canonical order decides between them.
        let p = P::lerp(P::lerp(a, b, u), P::lerp(c, d, u), v);
        let du = P::blend([a, b, c, d], [v - 1.0, 1.0 - v, -v, v]);
        let dv = P::blend([a, b, c, d], [u - 1.0, -u, 1.0 - u, u]);
        P::surface_point(p, du, dv)
    }

    /// The position alone, with the same bits.
    #[inline(always)]
    pub fn position(&self, u: f32, v: f32) -> Vec3 {
        let [a, b, c, d] = self.0;
        P::lerp(P::lerp(a, b, u), P::lerp(c, d, u), v).position()
    }

    /// The same curve as [`Bicubic::side`] gives, raised to a cubic, for comparison.
    pub fn side(&self, side: usize) -> [P; 4] {
        let [a, b, c, d] = self.0;
        let (from, to) = match side {
            0 => (a, b),
            1 => (b, d),
            2 => (c, d),
            _ => (a, c),
        };
        [from, P::lerp(from, to, 1.0 / 3.0), P::lerp(from, to, 2.0 / 3.0), to]
    }

    /// Corners over `[u0, u1] x [v0, v1]`; homogeneous ones stay homogeneous.
    pub fn restrict(&self, u: [f32; 2], v: [f32; 2]) -> Self {
        let [a, b, c, d] = self.0;
        let at = |u: f32, v: f32| P::lerp(P::lerp(a, b, u), P::lerp(c, d, u), v);
        Bilinear([at(u[0], v[0]), at(u[1], v[0]), at(u[0], v[1]), at(u[1], v[1])])
    }
}

/// Matrix that turns four control points of `basis` into four of the Bezier basis, `result[new][old]`.
///
/// The coefficients of t^3..1 are `basis.matrix * points`; the Bezier points of a polynomial
/// a t^3 + b t^2 + c t + d are d, d + c/3, d + 2c/3 + b/3, a + b + c + d.
pub fn to_bezier(basis: &PatchBasis) -> [[f64; 4]; 4] {
    let m = basis.matrix.map(|row| row.map(f64::from));
    let mut result = [[0.0; 4]; 4];
    for old in 0..4 {
        let (a, b, c, d) = (m[0][old], m[1][old], m[2][old], m[3][old]);
        result[0][old] = d;
        result[1][old] = d + c / 3.0;
        result[2][old] = d + 2.0 * c / 3.0 + b / 3.0;
        result[3][old] = a + b + c + d;
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn patch(seed: u32) -> Bicubic<Vec3> {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        Bicubic(std::array::from_fn(|_| Vec3::new(next(), next(), next())))
    }

    proptest! {
        #[test]
        fn restricted_patch_is_the_same_surface(
            seed: u32, u0 in 0.0f32..0.5, u1 in 0.5f32..1.0, v0 in 0.0f32..0.5, v1 in 0.5f32..1.0,
            s in 0.0f32..1.0, t in 0.0f32..1.0,
        ) {
            let whole = patch(seed);
            let part = whole.restrict([u0, u1], [v0, v1]);
            let a = part.evaluate(s, t).p;
            let b = whole.evaluate(u0 + (u1 - u0) * s, v0 + (v1 - v0) * t).p;
            prop_assert!((a - b).length() < 1e-5, "{a} {b}");
        }

        #[test]
        fn derivatives_are_those_of_differences(seed: u32, u in 0.1f32..0.9, v in 0.1f32..0.9) {
            let patch = patch(seed);
            let h = 1e-2;
            let at = patch.evaluate(u, v);
            let du = (patch.evaluate(u + h, v).p - patch.evaluate(u - h, v).p) / (2.0 * h);
            let dv = (patch.evaluate(u, v + h).p - patch.evaluate(u, v - h).p) / (2.0 * h);
            prop_assert!((at.du - du).length() < 1e-2 && (at.dv - dv).length() < 1e-2);
        }
    }

    #[test]
    fn rational_quarter_circle_is_round() {
        // Degree-raised quarter circle in u, extruded in v.
        let h = std::f32::consts::FRAC_1_SQRT_2;
        let raise = |a: Vec4, b: Vec4, t: f32| a * (1.0 - t) + b * t;
        let (a, b, c) =
            (Vec4::new(1.0, 0.0, 0.0, 1.0), Vec4::new(h, h, 0.0, h), Vec4::new(0.0, 1.0, 0.0, 1.0));
        let curve = [a, raise(a, b, 2.0 / 3.0), raise(b, c, 1.0 / 3.0), c];
        let points = std::array::from_fn(|ix| curve[ix % 4] + Vec4::Z * ((ix / 4) as f32 * curve[ix % 4].w));
        let patch = Bicubic(points);
        for step in 0..=10 {
            let at = patch.evaluate(step as f32 / 10.0, 0.3);
            assert!((at.p.truncate().length() - 1.0).abs() < 1e-6);
            assert!(at.du.truncate().dot(at.p.truncate()).abs() < 1e-5, "the tangent is across the radius");
        }
    }

    #[test]
    fn power_basis_becomes_bezier() {
        let power = PatchBasis {
            matrix: std::array::from_fn(|r| std::array::from_fn(|c| if r == c { 1.0 } else { 0.0 })),
            step: 4,
        };
        // t^3 has Bezier points 0, 0, 0, 1; the constant 1 has 1, 1, 1, 1.
        let m = to_bezier(&power);
        assert_eq!(m.map(|row| row[0]), [0.0, 0.0, 0.0, 1.0]);
        assert_eq!(m.map(|row| row[3]), [1.0; 4]);
        let same = to_bezier(&PatchBasis::BEZIER);
        for (i, row) in same.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                assert!((value - f64::from(u8::from(i == j))).abs() < 1e-15);
            }
        }
    }
}
