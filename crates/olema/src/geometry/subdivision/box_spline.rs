//! Quartic box splines over a triangle: Loop's surface where six triangles meet at every corner.
//!
//! In: 12 control points. Out: points and first derivatives, Bezier hulls. Source: Stam 1998, "Evaluation of
//! Loop subdivision surfaces", whose 12 polynomials are three kinds by symmetry.

use glam::DVec3;

use super::bicubic::Jet;

/// Control points by kind; edge k runs from corner k to the next.
///
/// ```text
///        o - o           0 1 2  `corner`
///       / \ / \          a      `across`: edge 0's below, edge 1's right, edge 2's left
///      a - 2 - a         o      `outer`: corner k's, first the one beside edge k's `a`, then the one
///     / \ / \ / \                beside that of the edge before
///    o - 0 - 1 - o
///     \ / \ / \ /
///      o - a - o
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BoxSpline {
    pub(super) corner: [DVec3; 3],
    pub(super) across: [DVec3; 3],
    pub(super) outer: [[DVec3; 2]; 3],
    /// What all of them are relative to.
    pub(super) origin: DVec3,
}

/// A weight and its derivatives by the three barycentric coordinates, taken as independent.
#[derive(Clone, Copy, Default)]
struct Weight {
    value: f64,
    d: [f64; 3],
}

impl BoxSpline {
    /// From the six neighbours of each corner, counter-clockwise from the next corner on.
    pub(super) fn from_rings(rings: [[DVec3; 6]; 3], corner: [DVec3; 3], origin: DVec3) -> BoxSpline {
        BoxSpline { corner, across: rings.map(|r| r[5]), outer: rings.map(|r| [r[4], r[3]]), origin }
    }

    /// Point at barycentric `b`, and derivatives along the directions `du` and `dv` (each of sum 0).
    pub(super) fn evaluate(&self, b: [f64; 3], du: [f64; 3], dv: [f64; 3]) -> Jet {
        let jet = self.form(b, du, dv);
        Jet { p: jet.p + self.origin, ..jet }
    }

    /// The quartic form, relative to the origin, and its derivatives.
    fn form(&self, b: [f64; 3], du: [f64; 3], dv: [f64; 3]) -> Jet {
        let mut jet = Jet::default();
        let mut add = |p: DVec3, w: Weight, order: [usize; 3]| {
            let along = |d: [f64; 3]| (0..3).map(|i| w.d[i] * d[order[i]]).sum::<f64>();
            jet.p += p * w.value;
            jet.du += p * along(du);
            jet.dv += p * along(dv);
        };
        for k in 0..3 {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            add(self.corner[k], corner_weight(b[k], b[i], b[j]), [k, i, j]);
            add(self.across[k], across_weight(b[k], b[i], b[j]), [k, i, j]);
            add(self.outer[k][0], outer_weight(b[k], b[i]), [k, i, j]);
            add(self.outer[k][1], outer_weight(b[k], b[j]), [k, j, i]);
        }
        jet
    }

    /// Bezier points of the part over the triangle with barycentric corners `t`: the part lies in their hull.
    ///
    /// The weights are homogeneous of degree 4 as written, so the polar form is a signed sum of values at
    /// sums of the corners (the polarization identity).
    pub(super) fn bezier(&self, t: [[f64; 3]; 3]) -> [DVec3; 15] {
        let mut values = [[[DVec3::ZERO; 5]; 5]; 5];
        for [a, b, c] in (0..=4).flat_map(of_sum) {
            let [x, y, z] = [a, b, c].map(|n| n as f64);
            let at = [0, 1, 2].map(|i| t[0][i] * x + t[1][i] * y + t[2][i] * z);
            values[a][b][c] = self.form(at, [0.0; 3], [0.0; 3]).p;
        }
        let mut out = [DVec3::ZERO; 15];
        for (point, [i, j, k]) in out.iter_mut().zip(of_sum(4)) {
            for (a, b, c) in (0..=i).flat_map(|a| (0..=j).flat_map(move |b| (0..=k).map(move |c| (a, b, c))))
            {
                let sign = if (a + b + c) % 2 == 0 { 1.0 } else { -1.0 };
                let ways = BINOMIAL[i][a] * BINOMIAL[j][b] * BINOMIAL[k][c];
                *point += values[a][b][c] * (sign * ways / 24.0);
            }
            *point += self.origin;
        }
        out
    }
}

/// `BINOMIAL[n][k]`.
const BINOMIAL: [[f64; 5]; 5] = [
    [1.0, 0.0, 0.0, 0.0, 0.0],
    [1.0, 1.0, 0.0, 0.0, 0.0],
    [1.0, 2.0, 1.0, 0.0, 0.0],
    [1.0, 3.0, 3.0, 1.0, 0.0],
    [1.0, 4.0, 6.0, 4.0, 1.0],
];

/// Triples of whole numbers of the given sum.
fn of_sum(sum: usize) -> impl Iterator<Item = [usize; 3]> {
    (0..=sum).flat_map(move |k| (0..=sum - k).map(move |j| [sum - j - k, j, k]))
}

/// 12 times the weight of the corner at u = 1; symmetric in v and w.
fn corner_weight(u: f64, v: f64, w: f64) -> Weight {
    let (u2, v2, w2) = (u * u, v * v, w * w);
    let (u3, v3, w3) = (u2 * u, v2 * v, w2 * w);
    let value = 6.0 * u2 * u2
        + 24.0 * u3 * (v + w)
        + 24.0 * u2 * (v2 + w2)
        + 60.0 * u2 * v * w
        + 8.0 * u * (v3 + w3)
        + 36.0 * u * v * w * (v + w)
        + v2 * v2
        + w2 * w2
        + 6.0 * v * w * (v2 + w2)
        + 12.0 * v2 * w2;
    let by_u = 24.0 * u3
        + 72.0 * u2 * (v + w)
        + 48.0 * u * (v2 + w2)
        + 120.0 * u * v * w
        + 8.0 * (v3 + w3)
        + 36.0 * v * w * (v + w);
    let by = |v: f64, w: f64| {
        24.0 * u3
            + 48.0 * u2 * v
            + 60.0 * u2 * w
            + 24.0 * u * v * v
            + 36.0 * u * w * (2.0 * v + w)
            + 4.0 * v * v * v
            + 6.0 * w * (3.0 * v * v + w * w)
            + 24.0 * v * w * w
    };
    scaled(value, [by_u, by(v, w), by(w, v)])
}

/// 12 times the weight of the point across the edge from u to v; symmetric in them.
fn across_weight(u: f64, v: f64, w: f64) -> Weight {
    let (u2, v2) = (u * u, v * v);
    let (u3, v3) = (u2 * u, v2 * v);
    let value = u2 * u2
        + v2 * v2
        + 6.0 * (u3 * v + u * v3)
        + 12.0 * u2 * v2
        + 2.0 * w * (u3 + v3)
        + 6.0 * w * u * v * (u + v);
    let by = |u: f64, v: f64| {
        4.0 * u * u * u
            + 6.0 * (3.0 * u * u * v + v * v * v)
            + 24.0 * u * v * v
            + 6.0 * w * u * u
            + 6.0 * w * v * (2.0 * u + v)
    };
    scaled(value, [by(u, v), by(v, u), 2.0 * (u3 + v3) + 6.0 * u * v * (u + v)])
}

/// 12 times the weight of the point beyond the corner at u = 1 that lies towards v.
fn outer_weight(u: f64, v: f64) -> Weight {
    let u2 = u * u;
    scaled(u2 * u * (u + 2.0 * v), [u2 * (4.0 * u + 6.0 * v), 2.0 * u2 * u, 0.0])
}

fn scaled(value: f64, d: [f64; 3]) -> Weight {
    Weight { value: value / 12.0, d: d.map(|d| d / 12.0) }
}
