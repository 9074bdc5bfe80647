//! Matrices times lists of vectors.
//!
//! In: vectors and a matrix. Out: vectors; the same bits as glam's functions for one vector give, which are the twins to
//! read.

#![allow(clippy::needless_range_loop)] // A loop over lanes reads as what it becomes.

use glam::Mat4;

use super::Vec3s;
use super::simd::{LANES, SimdLevel, load, store};

/// Replaces `to` by `each` group of the vectors of `from`, which are given by axis and lane.
#[inline(always)]
fn map(
    level: SimdLevel,
    from: &Vec3s,
    to: &mut Vec3s,
    each: impl Fn(&[[f32; LANES]; 3]) -> [[f32; LANES]; 3],
) {
    to.set_len(from.len());
    level.run(
        #[inline(always)]
        || {
            let ([x, y, z], [to_x, to_y, to_z]) = (from.groups(), to.groups_mut());
            for first in (0..x.len()).step_by(LANES) {
                let moved = each(&[load(x, first), load(y, first), load(z, first)]);
                store(to_x, first, &moved[0]);
                store(to_y, first, &moved[1]);
                store(to_z, first, &moved[2]);
            }
        },
    );
}

/// `matrix` times vectors; its translation counts for nothing.
#[inline(always)]
fn turned([x, y, z]: &[[f32; 4]; 3], from: &[[f32; LANES]; 3]) -> [[f32; LANES]; 3] {
    let mut to = [[0.0; LANES]; 3];
    for axis in 0..3 {
        for lane in 0..LANES {
            to[axis][lane] = x[axis] * from[0][lane] + y[axis] * from[1][lane] + z[axis] * from[2][lane];
        }
    }
    to
}

/// `matrix` times points.
#[inline(always)]
pub(crate) fn placed(matrix: &Mat4, from: &[[f32; LANES]; 3]) -> [[f32; LANES]; 3] {
    let (mut to, origin) = (turned(&columns(matrix), from), matrix.w_axis.to_array());
    for axis in 0..3 {
        for lane in 0..LANES {
            to[axis][lane] += origin[axis];
        }
    }
    to
}

/// Columns of a matrix, without its translation.
#[inline(always)]
fn columns(matrix: &Mat4) -> [[f32; 4]; 3] {
    [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.to_array())
}

/// Replaces `to` by `matrix` times the points `from`.
pub fn points(level: SimdLevel, matrix: &Mat4, from: &Vec3s, to: &mut Vec3s) {
    map(
        level,
        from,
        to,
        #[inline(always)]
        |from| placed(matrix, from),
    );
}

/// Replaces `to` by `matrix` times the vectors `from`; its translation counts for nothing.
pub fn vectors(level: SimdLevel, matrix: &Mat4, from: &Vec3s, to: &mut Vec3s) {
    let columns = columns(matrix);
    map(
        level,
        from,
        to,
        #[inline(always)]
        |from| turned(&columns, from),
    );
}

/// [`vectors`] of unit length; zero where they have no direction.
pub fn unit_vectors(level: SimdLevel, matrix: &Mat4, from: &Vec3s, to: &mut Vec3s) {
    let columns = columns(matrix);
    map(
        level,
        from,
        to,
        #[inline(always)]
        |from| {
            let mut to = turned(&columns, from);
            for lane in 0..LANES {
                let [x, y, z] = [to[0][lane], to[1][lane], to[2][lane]];
                let length = (x * x + y * y + z * z).sqrt();
                let has_direction = (length > 0.0) & (length < f32::INFINITY);
                let unit = [x / length, y / length, z / length];
                for axis in 0..3 {
                    to[axis][lane] = if has_direction { unit[axis] } else { 0.0 };
                }
            }
            to
        },
    );
}

/// Writes what lies part of the way from each of the first `len` vectors of one list to that of another to `out`, which is
/// made longer where it is too short.
pub fn between(level: SimdLevel, [from, to]: [&Vec3s; 2], part: f32, len: usize, out: &mut Vec3s) {
    out.make_room(len.next_multiple_of(LANES));
    let lists = from.axes().into_iter().zip(to.axes()).zip(out.axes_mut());
    level.run(
        #[inline(always)]
        || {
            for ((from, to), out) in lists {
                for ((from, to), out) in from[..len].iter().zip(&to[..len]).zip(&mut out[..len]) {
                    *out = from + (to - from) * part;
                }
            }
        },
    );
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::math::hash::{hash32, signed_unit};

    #[test]
    fn lists_are_the_twin_on_every_level() {
        let random = |n: u32| signed_unit(hash32(n));
        let mut matrix = Mat4::from_cols_array(&std::array::from_fn(|n| random(n as u32) * 3.0));
        (matrix.x_axis.w, matrix.y_axis.w, matrix.z_axis.w, matrix.w_axis.w) = (0.0, 0.0, 0.0, 1.0);
        let mut from = Vec3s::default();
        for n in 0..53 {
            from.push(Vec3::new(random(3 * n), random(3 * n + 1), random(3 * n + 2)) * 9.0);
        }
        from.set(7, Vec3::ZERO);
        from.set(9, Vec3::new(f32::INFINITY, 1.0, 0.0));
        from.set(20, Vec3::NAN);
        let bits = |v: Vec3| v.to_array().map(f32::to_bits);
        for level in SimdLevel::all() {
            let mut to = [Vec3s::default(), Vec3s::default(), Vec3s::default()];
            points(level, &matrix, &from, &mut to[0]);
            vectors(level, &matrix, &from, &mut to[1]);
            unit_vectors(level, &matrix, &from, &mut to[2]);
            for ix in (0..53).filter(|ix| *ix != 20) {
                let p = from.get(ix);
                let v = matrix.transform_vector3(p);
                let unit = if v.is_finite() { v.normalize_or_zero() } else { Vec3::ZERO };
                let twin = [matrix.transform_point3(p), v];
                if p.is_finite() {
                    assert_eq!(bits(to[0].get(ix)), bits(twin[0]), "{level:?} {ix}");
                    assert_eq!(bits(to[1].get(ix)), bits(twin[1]), "{level:?} {ix}");
                }
                assert!((to[2].get(ix) - unit).length() < 1e-6, "{level:?} {ix}: {unit}");
            }
            assert_eq!(to[2].get(20), Vec3::ZERO);
        }
    }

    #[test]
    fn what_lies_between_is_the_twin_on_every_level() {
        let list = |seed: u32| {
            let mut list = Vec3s::default();
            for n in 0..37 {
                let random = |axis: u32| signed_unit(hash32(seed + 3 * n + axis));
                list.push(Vec3::new(random(0), random(1), random(2)));
            }
            list
        };
        let (from, to) = (list(0), list(1000));
        for (level, len) in
            SimdLevel::all().into_iter().flat_map(|level| [1, 8, 16, 37].map(|len| (level, len)))
        {
            let mut out = Vec3s::default();
            between(level, [&from, &to], 0.3, len, &mut out);
            for ix in 0..len {
                let twin = from.get(ix) + (to.get(ix) - from.get(ix)) * 0.3;
                assert_eq!(out.get(ix), twin, "{level:?}");
            }
        }
    }
}
