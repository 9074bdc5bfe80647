//! Matrices times lists of vectors.
//!
//! In: single-precision vectors and a matrix in double. Out: single precision again, rounded once; the same bits as
//! glam's functions for one vector give, which are the twins to read.

use std::ops::Range;

use glam::{DMat4, DVec3, Vec3};

use super::Vec3s;
use super::simd::SimdLevel;

/// Replaces `to` by `each` of the vectors `range` of `from`.
#[inline(always)]
fn map(level: SimdLevel, from: &Vec3s, range: Range<usize>, to: &mut Vec3s, each: impl Fn(DVec3) -> Vec3) {
    let len = range.len();
    to.resize(len);
    level.run(
        #[inline(always)]
        || {
            let (from, mut to) = (from.slice(range), to.slice_mut(0..len));
            for ix in 0..len {
                to.set(ix, each(from.get(ix).as_dvec3()));
            }
        },
    );
}

/// Replaces `to` by `matrix` times the points `range` of `from`.
pub fn points(level: SimdLevel, matrix: &DMat4, from: &Vec3s, range: Range<usize>, to: &mut Vec3s) {
    map(
        level,
        from,
        range,
        to,
        #[inline(always)]
        |p| matrix.transform_point3(p).as_vec3(),
    );
}

/// Replaces `to` by `matrix` times the vectors `range` of `from`; its translation counts for nothing.
pub fn vectors(level: SimdLevel, matrix: &DMat4, from: &Vec3s, range: Range<usize>, to: &mut Vec3s) {
    map(
        level,
        from,
        range,
        to,
        #[inline(always)]
        |v| matrix.transform_vector3(v).as_vec3(),
    );
}

/// [`vectors`] of unit length; zero where they have no direction.
pub fn unit_vectors(level: SimdLevel, matrix: &DMat4, from: &Vec3s, range: Range<usize>, to: &mut Vec3s) {
    map(
        level,
        from,
        range,
        to,
        #[inline(always)]
        |v| unit(matrix.transform_vector3(v)),
    );
}

/// A vector of unit length; zero where it has no direction.
#[inline(always)]
fn unit(v: DVec3) -> Vec3 {
    let length = v.length();
    let has_direction = (length > 0.0) & (length < f64::INFINITY);
    let unit = v / length;
    if has_direction { unit.as_vec3() } else { Vec3::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{hash32, signed_unit};

    #[test]
    fn lists_are_the_twin_on_every_level() {
        let random = |n: u32| signed_unit(hash32(n));
        let matrix = DMat4::from_cols_array(&std::array::from_fn(|n| f64::from(random(n as u32)) * 3.0));
        let mut from = Vec3s::default();
        for n in 0..53 {
            from.push(Vec3::new(random(3 * n), random(3 * n + 1), random(3 * n + 2)) * 9.0);
        }
        from.set(7, Vec3::ZERO);
        from.set(9, Vec3::new(f32::INFINITY, 1.0, 0.0));
        from.set(20, Vec3::NAN);
        let affine = DMat4::from_cols(
            matrix.x_axis.truncate().extend(0.0),
            matrix.y_axis.truncate().extend(0.0),
            matrix.z_axis.truncate().extend(0.0),
            matrix.w_axis.truncate().extend(1.0),
        );
        let bits = |v: Vec3| v.to_array().map(f32::to_bits);
        for level in SimdLevel::all() {
            let mut to = [Vec3s::default(), Vec3s::default(), Vec3s::default()];
            points(level, &affine, &from, 3..50, &mut to[0]);
            vectors(level, &affine, &from, 3..50, &mut to[1]);
            unit_vectors(level, &affine, &from, 3..50, &mut to[2]);
            for ix in (3..50).filter(|ix| *ix != 20) {
                let wide = from.get(ix).as_dvec3();
                let v = affine.transform_vector3(wide);
                let unit = if v.is_finite() { v.normalize_or_zero().as_vec3() } else { Vec3::ZERO };
                let twin = [affine.transform_point3(wide).as_vec3(), v.as_vec3(), unit];
                assert_eq!(bits(to[0].get(ix - 3)), bits(twin[0]), "{level:?} {ix}");
                assert_eq!(bits(to[1].get(ix - 3)), bits(twin[1]), "{level:?} {ix}");
                assert!((to[2].get(ix - 3) - unit).length() < 1e-6, "{level:?} {ix}: {unit}");
            }
            assert_eq!(to[2].get(20 - 3), Vec3::ZERO);
        }
    }
}
