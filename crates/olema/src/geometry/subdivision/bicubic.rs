//! Uniform bicubic B-spline patches: evaluation and tight bounds of any part.
//!
//! In: 4 x 4 control points, row after row, u along the row. Out: points, first derivatives, Bezier hulls.

use glam::DVec3;

/// A point and its first derivatives.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Jet {
    pub(super) p: DVec3,
    pub(super) du: DVec3,
    pub(super) dv: DVec3,
}

/// Control points; the patch is the middle square, (u, v) from 0 to 1 from point 5 to point 10.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bicubic {
    /// Relative to the origin.
    pub(super) points: [DVec3; 16],
    pub(super) origin: DVec3,
}

impl Bicubic {
    /// A patch whose outer row or column at edge 0 (v = 0), 1 (u = 1), 2 (v = 1), 3 (u = 0) is undefined
    /// where `mirrored`: it becomes the mirror image of the one inside, which makes that edge the cubic
    /// B-spline of its own points alone.
    pub(super) fn mirrored(mut points: [DVec3; 16], mirrored: [bool; 4], origin: DVec3) -> Bicubic {
        for i in 0..4 {
            if mirrored[0] {
                points[i] = points[4 + i] * 2.0 - points[8 + i];
            }
            if mirrored[2] {
                points[12 + i] = points[8 + i] * 2.0 - points[4 + i];
            }
        }
        for row in points.chunks_exact_mut(4) {
            if mirrored[3] {
                row[0] = row[1] * 2.0 - row[2];
            }
            if mirrored[1] {
                row[3] = row[2] * 2.0 - row[1];
            }
        }
        Bicubic { points, origin }
    }

    /// Point and derivatives at (u, v) in the unit square.
    #[inline(always)]
    pub(super) fn evaluate(&self, u: f64, v: f64) -> Jet {
        let (bu, du) = basis(u);
        let (bv, dv) = basis(v);
        let p = &self.points;
        let jet = Jet::default();
        let jet = add_row(jet, [p[0], p[1], p[2], p[3]], [bu, du], bv[0], dv[0]);
        let jet = add_row(jet, [p[4], p[5], p[6], p[7]], [bu, du], bv[1], dv[1]);
        let jet = add_row(jet, [p[8], p[9], p[10], p[11]], [bu, du], bv[2], dv[2]);
        let jet = add_row(jet, [p[12], p[13], p[14], p[15]], [bu, du], bv[3], dv[3]);
        Jet { p: jet.p + self.origin, ..jet }
    }

    /// Bezier points of the part from (u0, v0) to (u1, v1): the part lies in their hull.
    pub(super) fn bezier(&self, [u0, u1]: [f64; 2], [v0, v1]: [f64; 2]) -> [DVec3; 16] {
        let mut out = [DVec3::ZERO; 16];
        for (to, from) in out.chunks_exact_mut(4).zip(self.points.chunks_exact(4)) {
            to.copy_from_slice(&bezier([from[0], from[1], from[2], from[3]], u0, u1));
        }
        for i in 0..4 {
            let column = bezier([out[i], out[4 + i], out[8 + i], out[12 + i]], v0, v1);
            for (j, p) in column.into_iter().enumerate() {
                out[j * 4 + i] = p + self.origin;
            }
        }
        out
    }
}

/// Adds what a row of control points contributes, given the weights along it and their derivatives.
#[inline(always)]
fn add_row(jet: Jet, row: [DVec3; 4], [bu, du]: [[f64; 4]; 2], bv: f64, dv: f64) -> Jet {
    let p = row[0] * bu[0] + row[1] * bu[1] + row[2] * bu[2] + row[3] * bu[3];
    let along = row[0] * du[0] + row[1] * du[1] + row[2] * du[2] + row[3] * du[3];
    Jet { p: jet.p + p * bv, du: jet.du + along * bv, dv: jet.dv + p * dv }
}

/// Cubic B-spline weights and their derivatives.
#[inline(always)]
fn basis(t: f64) -> ([f64; 4], [f64; 4]) {
    let s = 1.0 - t;
    let (t2, s2) = (t * t, s * s);
    let weights =
        [s2 * s / 6.0, (4.0 + t2 * (3.0 * t - 6.0)) / 6.0, (4.0 + s2 * (3.0 * s - 6.0)) / 6.0, t2 * t / 6.0];
    (weights, [-0.5 * s2, t * (1.5 * t - 2.0), s * (2.0 - 1.5 * s), 0.5 * t2])
}

/// Bezier points of the part from `a` to `b` of a cubic B-spline segment, by its polar form.
fn bezier(d: [DVec3; 4], a: f64, b: f64) -> [DVec3; 4] {
    [polar(&d, a, a, a), polar(&d, a, a, b), polar(&d, a, b, b), polar(&d, b, b, b)]
}

/// The polar form over the knots -2, -1, 0, 1, 2, 3 (de Boor's algorithm with an argument a step).
fn polar(d: &[DVec3; 4], a: f64, b: f64, c: f64) -> DVec3 {
    let third = 1.0 / 3.0;
    let p0 = d[0].lerp(d[1], (a + 2.0) * third);
    let p1 = d[1].lerp(d[2], (a + 1.0) * third);
    let p2 = d[2].lerp(d[3], a * third);
    let q0 = p0.lerp(p1, (b + 1.0) * 0.5);
    let q1 = p1.lerp(p2, b * 0.5);
    q0.lerp(q1, c)
}
