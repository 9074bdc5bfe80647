//! Surfaces at lists of points.
//!
//! In: a function of (u, v) without branches, and places. Out: what it gives at each, bit for bit, computed sixteen places
//! at a time; the function is the twin to read ([`super::bezier`]).

#![allow(clippy::needless_range_loop)] // A loop over lanes reads as what it becomes.

use std::ops::Range;

use glam::Vec3;

use super::SurfacePoint;
use super::bezier::{Bicubic, Column};
use crate::math::Vec3s;
use crate::math::simd::SimdLevel;

/// Places at a time; of what is left at the end of a list or a row, half as many.
const LANES: usize = 16;
const HALF: usize = LANES / 2;

/// Places that are written beyond a list's end.
pub const SLACK: usize = LANES;

/// Positions and derivatives, one entry a place in every array.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SurfacePoints {
    /// Positions.
    pub p: Vec3s,
    /// Derivatives along u.
    pub du: Vec3s,
    /// Derivatives along v.
    pub dv: Vec3s,
}

impl SurfacePoints {
    /// Makes room for `len` points, or forgets those from `len` on.
    pub fn resize(&mut self, len: usize) {
        [&mut self.p, &mut self.du, &mut self.dv].into_iter().for_each(|all| all.resize(len));
    }

    /// Point `ix`.
    #[inline(always)]
    pub fn get(&self, ix: usize) -> SurfacePoint {
        SurfacePoint { p: self.p.get(ix), du: self.du.get(ix), dv: self.dv.get(ix) }
    }

    /// Replaces point `ix`.
    #[inline(always)]
    pub fn set(&mut self, ix: usize, at: SurfacePoint) {
        self.p.set(ix, at.p);
        self.du.set(ix, at.du);
        self.dv.set(ix, at.dv);
    }
}

/// Writes `surface(u, v)` at the places of `range` to the same places of `out`. All arrays are at least [`SLACK`] longer
/// than the range's end; what is in `out` there is lost.
#[inline(always)]
pub fn evaluate(
    level: SimdLevel,
    [u, v]: [&[f32]; 2],
    range: Range<usize>,
    out: &mut SurfacePoints,
    surface: impl Fn(f32, f32) -> SurfacePoint,
) {
    level.run(
        #[inline(always)]
        || {
            let mut first = range.start;
            while first < range.end {
                if range.end - first > HALF {
                    evaluate_group::<LANES>([u, v], first, out, &surface);
                } else {
                    evaluate_group::<HALF>([u, v], first, out, &surface);
                }
                first += LANES;
            }
        },
    );
}

#[inline(always)]
fn evaluate_group<const N: usize>(
    [u, v]: [&[f32]; 2],
    first: usize,
    out: &mut SurfacePoints,
    surface: &impl Fn(f32, f32) -> SurfacePoint,
) {
    let (u, v) = (group::<N>(u, first), group::<N>(v, first));
    let (mut p, mut du, mut dv) = ([[0.0; N]; 3], [[0.0; N]; 3], [[0.0; N]; 3]);
    for lane in 0..N {
        let at = surface(u[lane], v[lane]);
        (p[0][lane], p[1][lane], p[2][lane]) = (at.p.x, at.p.y, at.p.z);
        (du[0][lane], du[1][lane], du[2][lane]) = (at.du.x, at.du.y, at.du.z);
        (dv[0][lane], dv[1][lane], dv[2][lane]) = (at.dv.x, at.dv.y, at.dv.z);
    }
    put(&mut out.p, first, &p);
    put(&mut out.du, first, &du);
    put(&mut out.dv, first, &dv);
}

/// [`evaluate`] for positions alone.
#[inline(always)]
pub fn positions(
    level: SimdLevel,
    [u, v]: [&[f32]; 2],
    range: Range<usize>,
    out: &mut Vec3s,
    surface: impl Fn(f32, f32) -> Vec3,
) {
    level.run(
        #[inline(always)]
        || {
            let mut first = range.start;
            while first < range.end {
                if range.end - first > HALF {
                    position_group::<LANES>([u, v], first, out, &surface);
                } else {
                    position_group::<HALF>([u, v], first, out, &surface);
                }
                first += LANES;
            }
        },
    );
}

#[inline(always)]
fn position_group<const N: usize>(
    [u, v]: [&[f32]; 2],
    first: usize,
    out: &mut Vec3s,
    surface: &impl Fn(f32, f32) -> Vec3,
) {
    let (u, v) = (group::<N>(u, first), group::<N>(v, first));
    let mut p = [[0.0; N]; 3];
    for lane in 0..N {
        let at = surface(u[lane], v[lane]);
        (p[0][lane], p[1][lane], p[2][lane]) = (at.x, at.y, at.z);
    }
    put(out, first, &p);
}

/// Writes a bicubic patch at all (u, v) to `out`, row after row of constant v: `evaluate` with the columns' curves
/// computed once for all rows. `u` is [`SLACK`] longer than there are `columns`, `out` than there are places.
#[inline(always)]
pub fn bicubic_lattice(
    level: SimdLevel,
    surface: &Bicubic<Vec3>,
    columns: usize,
    [u, v]: [&[f32]; 2],
    out: &mut SurfacePoints,
) {
    level.run(
        #[inline(always)]
        || {
            // From the right: what a group writes beyond the end of a row is the beginning of the next, which only the
            // leftmost group holds.
            let (mut first, rest) = (columns / LANES * LANES, columns % LANES);
            match rest {
                0 => {}
                1..=HALF => put_columns::<HALF>(surface, columns, [u, v], first, out),
                _ => put_columns::<LANES>(surface, columns, [u, v], first, out),
            }
            while first > 0 {
                first -= LANES;
                put_columns::<LANES>(surface, columns, [u, v], first, out);
            }
        },
    );
}

/// Writes the points of the columns from `first` on.
#[inline(always)]
fn put_columns<const N: usize>(
    surface: &Bicubic<Vec3>,
    columns: usize,
    [u, v]: [&[f32]; 2],
    first: usize,
    out: &mut SurfacePoints,
) {
    let curves = Columns::<N>::new(surface, &group(u, first));
    for (row, &v) in v.iter().enumerate() {
        curves.put(v, row * columns + first, out);
    }
}

/// Curves of constant u: control points and their derivatives, by number, axis and lane.
struct Columns<const N: usize> {
    points: [[[f32; N]; 3]; 4],
    du: [[[f32; N]; 3]; 4],
}

impl<const N: usize> Columns<N> {
    #[inline(always)]
    fn new(surface: &Bicubic<Vec3>, u: &[f32; N]) -> Self {
        let mut all = Columns { points: [[[0.0; N]; 3]; 4], du: [[[0.0; N]; 3]; 4] };
        for lane in 0..N {
            let column = surface.column(u[lane]);
            for point in 0..4 {
                let (p, du) = (column.points[point], column.du[point]);
                (all.points[point][0][lane], all.points[point][1][lane], all.points[point][2][lane]) =
                    (p.x, p.y, p.z);
                (all.du[point][0][lane], all.du[point][1][lane], all.du[point][2][lane]) = (du.x, du.y, du.z);
            }
        }
        all
    }

    /// Writes the points at v.
    #[inline(always)]
    fn put(&self, v: f32, first: usize, out: &mut SurfacePoints) {
        let (mut p, mut du, mut dv) = ([[0.0; N]; 3], [[0.0; N]; 3], [[0.0; N]; 3]);
        for lane in 0..N {
            let point = |all: &[[[f32; N]; 3]; 4], n: usize| {
                Vec3::new(all[n][0][lane], all[n][1][lane], all[n][2][lane])
            };
            let points = &self.points;
            let points = [point(points, 0), point(points, 1), point(points, 2), point(points, 3)];
            let along = [point(&self.du, 0), point(&self.du, 1), point(&self.du, 2), point(&self.du, 3)];
            let at = Column { points, du: along }.evaluate(v);
            (p[0][lane], p[1][lane], p[2][lane]) = (at.p.x, at.p.y, at.p.z);
            (du[0][lane], du[1][lane], du[2][lane]) = (at.du.x, at.du.y, at.du.z);
            (dv[0][lane], dv[1][lane], dv[2][lane]) = (at.dv.x, at.dv.y, at.dv.z);
        }
        put(&mut out.p, first, &p);
        put(&mut out.du, first, &du);
        put(&mut out.dv, first, &dv);
    }
}

/// `values[first..first + N]`.
#[inline(always)]
fn group<const N: usize>(values: &[f32], first: usize) -> [f32; N] {
    let mut all = [0.0; N];
    all.copy_from_slice(&values[first..first + N]);
    all
}

#[inline(always)]
fn put<const N: usize>(to: &mut Vec3s, first: usize, values: &[[f32; N]; 3]) {
    let [x, y, z] = to.axes_mut();
    x[first..first + N].copy_from_slice(&values[0]);
    y[first..first + N].copy_from_slice(&values[1]);
    z[first..first + N].copy_from_slice(&values[2]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{hash32, unit};

    fn bits(points: &SurfacePoints, len: usize) -> Vec<[u32; 9]> {
        let all = |at: SurfacePoint| {
            let mut nine = at.p.to_array().into_iter().chain(at.du.to_array()).chain(at.dv.to_array());
            std::array::from_fn(|_| nine.next().map_or(0, f32::to_bits))
        };
        (0..len).map(|ix| all(points.get(ix))).collect()
    }

    fn made(len: usize) -> SurfacePoints {
        let mut points = SurfacePoints::default();
        points.resize(len + SLACK);
        points
    }

    fn random(seed: u32) -> f32 {
        unit(hash32(seed))
    }

    #[test]
    fn lists_and_lattices_are_the_twin_on_every_level() {
        let surface =
            Bicubic(std::array::from_fn(|n| Vec3::from([0, 1, 2].map(|a| random(3 * n as u32 + a)))));
        let (u, v): (Vec<f32>, Vec<f32>) =
            (0..40 + SLACK as u32).map(|n| (random(n), random(n + 99))).unzip();
        for (columns, rows) in [(1, 1), (2, 9), (7, 7), (8, 3), (9, 4), (17, 17), (24, 2)] {
            let mut twin = made(columns * rows);
            for row in 0..rows {
                (0..columns)
                    .for_each(|column| twin.set(row * columns + column, surface.evaluate(u[column], v[row])));
            }
            for level in SimdLevel::all() {
                let mut lattice = made(columns * rows);
                bicubic_lattice(level, &surface, columns, [&u, &v[..rows]], &mut lattice);
                assert_eq!(
                    bits(&lattice, columns * rows),
                    bits(&twin, columns * rows),
                    "{columns} x {rows} {level:?}"
                );
            }
        }
        for (from, to) in [(0, 1), (3, 8), (0, 40), (11, 27)] {
            let mut twin = made(to);
            (from..to).for_each(|ix| twin.set(ix, surface.evaluate(u[ix], v[ix])));
            for level in SimdLevel::all() {
                let (mut list, mut alone) = (made(to), Vec3s::default());
                alone.resize(to + SLACK);
                evaluate(
                    level,
                    [&u, &v],
                    from..to,
                    &mut list,
                    #[inline(always)]
                    |u, v| surface.evaluate(u, v),
                );
                positions(
                    level,
                    [&u, &v],
                    from..to,
                    &mut alone,
                    #[inline(always)]
                    |u, v| surface.position(u, v),
                );
                assert_eq!(bits(&list, to), bits(&twin, to), "{from} to {to} {level:?}");
                (from..to).for_each(|ix| assert_eq!(alone.get(ix), twin.p.get(ix), "{level:?}"));
            }
        }
    }
}
