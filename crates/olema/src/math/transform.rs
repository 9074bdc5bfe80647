//! Matrices times lists of vectors.
//!
//! In: single-precision vectors and a matrix in double. Out: single precision again, rounded once; the same bits as
//! glam's functions for one vector give, which are the twins to read.

use glam::{DMat4, DVec3, Vec3};

use super::Vec3s;
use super::simd::SimdLevel;

/// Vectors at a time: their components are doubles within.
const GROUP: usize = 8;

/// Replaces `to` by `each` of the vectors of `from`, in whole groups.
#[inline(always)]
fn map(level: SimdLevel, from: &Vec3s, to: &mut Vec3s, each: impl Fn(DVec3) -> Vec3) {
    to.set_len(from.len());
    level.run(
        #[inline(always)]
        || {
            let ([x, y, z], [to_x, to_y, to_z]) = (from.groups(), to.groups_mut());
            let from = groups(x).iter().zip(groups(y)).zip(groups(z));
            let to = groups_mut(to_x).iter_mut().zip(groups_mut(to_y)).zip(groups_mut(to_z));
            for (((x, y), z), ((to_x, to_y), to_z)) in from.zip(to) {
                let mut moved = [[0.0; GROUP]; 3];
                for lane in 0..GROUP {
                    let at = each(Vec3::new(x[lane], y[lane], z[lane]).as_dvec3());
                    (moved[0][lane], moved[1][lane], moved[2][lane]) = (at.x, at.y, at.z);
                }
                (*to_x, *to_y, *to_z) = (moved[0], moved[1], moved[2]);
            }
        },
    );
}

/// Groups of a component.
#[inline(always)]
fn groups(axis: &[f32]) -> &[[f32; GROUP]] {
    axis.as_chunks().0
}

/// [`groups`], to write.
#[inline(always)]
fn groups_mut(axis: &mut [f32]) -> &mut [[f32; GROUP]] {
    axis.as_chunks_mut().0
}

/// Replaces `to` by `matrix` times the points `from`.
pub fn points(level: SimdLevel, matrix: &DMat4, from: &Vec3s, to: &mut Vec3s) {
    map(
        level,
        from,
        to,
        #[inline(always)]
        |p| matrix.transform_point3(p).as_vec3(),
    );
}

/// Replaces `to` by `matrix` times the vectors `from`; its translation counts for nothing.
pub fn vectors(level: SimdLevel, matrix: &DMat4, from: &Vec3s, to: &mut Vec3s) {
    map(
        level,
        from,
        to,
        #[inline(always)]
        |v| matrix.transform_vector3(v).as_vec3(),
    );
}

/// [`vectors`] of unit length; zero where they have no direction.
pub fn unit_vectors(level: SimdLevel, matrix: &DMat4, from: &Vec3s, to: &mut Vec3s) {
    map(
        level,
        from,
        to,
        #[inline(always)]
        |v| unit(matrix.transform_vector3(v)),
    );
}

/// Writes what lies part of the way from each of the first `len` vectors of one list to that of another to `out`, which is
/// made longer where it is too short.
pub fn between(level: SimdLevel, [from, to]: [&Vec3s; 2], part: f32, len: usize, out: &mut Vec3s) {
    out.make_room(len.next_multiple_of(GROUP));
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
            points(level, &affine, &from, &mut to[0]);
            vectors(level, &affine, &from, &mut to[1]);
            unit_vectors(level, &affine, &from, &mut to[2]);
            for ix in (0..53).filter(|ix| *ix != 20) {
                let wide = from.get(ix).as_dvec3();
                let v = affine.transform_vector3(wide);
                let unit = if v.is_finite() { v.normalize_or_zero().as_vec3() } else { Vec3::ZERO };
                let twin = [affine.transform_point3(wide).as_vec3(), v.as_vec3(), unit];
                assert_eq!(bits(to[0].get(ix)), bits(twin[0]), "{level:?} {ix}");
                assert_eq!(bits(to[1].get(ix)), bits(twin[1]), "{level:?} {ix}");
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
