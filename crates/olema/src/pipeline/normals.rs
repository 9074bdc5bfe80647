//! Normals of lists of points and of lattices.
//!
//! In: derivatives, or a lattice of positions. Out: unit normals, place by place with the same bits however the list is
//! cut.

#![allow(clippy::needless_range_loop)] // A loop over lanes reads as what it becomes.

use std::ops::Range;

use glam::Vec3;

use crate::geometry::lanes::SurfacePoints;
use crate::math::Vec3s;
use crate::math::simd::{LANES, SimdLevel, load, store};

use super::patch::normal_or_zero;

/// Normals at a time.
const GROUP: usize = 8;

/// Writes the unit normals du x dv of the points `range`, times `sign`, to the same places of `to`; zero where du and dv
/// vanish or are parallel. Returns whether that may have happened. Up to eight normals behind the range are lost: whole
/// groups go through, since ranges are short.
pub fn surface_normals(
    level: SimdLevel,
    at: &SurfacePoints,
    range: Range<usize>,
    sign: f32,
    to: &mut Vec3s,
) -> bool {
    level.run(
        #[inline(always)]
        || {
            let len = range.len().next_multiple_of(GROUP);
            let range = range.start..range.start + len;
            let (du, dv) = (at.du.slice(range.clone()), at.dv.slice(range.clone()));
            let mut to = to.slice_mut(range);
            let mut missing = 0u32;
            for ix in 0..len {
                let normal = normal_or_zero(du.get(ix), dv.get(ix));
                missing |= u32::from((normal.x == 0.0) & (normal.y == 0.0) & (normal.z == 0.0));
                to.set(ix, normal * sign);
            }
            missing != 0
        },
    )
}

/// Makes sums of normals of unit length; zero those of next to nothing. Returns whether there are none of these. A single
/// normal keeps its bits.
pub fn unit_sums(level: SimdLevel, sums: &mut Vec3s) -> bool {
    level.run(
        #[inline(always)]
        || {
            let len = sums.len();
            let [x, y, z] = sums.groups_mut();
            let mut num_short = 0u32;
            for first in (0..x.len()).step_by(LANES) {
                let mut sum: [[f32; LANES]; 3] = [load(x, first), load(y, first), load(z, first)];
                let mut is_short = [0u32; LANES];
                for lane in 0..LANES {
                    let [x, y, z] = [sum[0][lane], sum[1][lane], sum[2][lane]];
                    let square = x * x + y * y + z * z;
                    // Also of a sum, whoever makes it: this depends on nothing else.
                    let is_unit = (square - 1.0).abs() < 1e-6;
                    let length = if is_unit { 1.0 } else { square.sqrt() };
                    let is_long = length > 1e-3;
                    is_short[lane] = u32::from(!is_long & (first + lane < len));
                    let unit = [x / length, y / length, z / length];
                    for axis in 0..3 {
                        sum[axis][lane] = if is_long { unit[axis] } else { 0.0 };
                    }
                }
                num_short += is_short.iter().sum::<u32>();
                store(x, first, &sum[0]);
                store(y, first, &sum[1]);
                store(z, first, &sum[2]);
            }
            num_short == 0
        },
    )
}

/// Writes what lies part of the way from one unit normal to another to `out`, of unit length; the first of them where the
/// two are opposite.
pub fn blend_normals(level: SimdLevel, [from, to]: [&Vec3s; 2], part: f32, len: usize, out: &mut Vec3s) {
    out.make_room(len);
    level.run(
        #[inline(always)]
        || {
            let (from, to, mut out) = (from.slice(0..len), to.slice(0..len), out.slice_mut(0..len));
            for ix in 0..len {
                let (from, to) = (from.get(ix), to.get(ix));
                let between = from + (to - from) * part;
                let inverse = 1.0 / between.length();
                let exists = (inverse > 0.0) & (inverse < f32::INFINITY);
                let unit = between * inverse;
                out.set(ix, if exists { unit } else { from });
            }
        },
    );
}

/// Unit normals of a lattice by central differences, times `sign`; zero where it is folded to nothing. Returns whether it
/// is somewhere.
///
/// In: `width` positions a row, row after row. Out: a normal for each of them, of which those of the first and last row
/// and column mean nothing.
pub fn lattice_normals(level: SimdLevel, lattice: &Vec3s, width: usize, sign: f32, to: &mut Vec3s) -> bool {
    to.resize(lattice.len());
    let Some(len) = lattice.len().checked_sub(2 * width).filter(|len| *len > 0) else { return false };
    level.run(
        #[inline(always)]
        || {
            let from = |first: usize| lattice.slice(first..first + len);
            // One list from the second row to the last but one: ends of rows are computed along, to go through in lanes.
            let (left, right) = (from(width - 1), from(width + 1));
            let (below, above) = (from(0), from(2 * width));
            let mut to = to.slice_mut(width..width + len);
            let mut num_folded = 0u32;
            for ix in 0..len {
                let cross = (right.get(ix) - left.get(ix)).cross(above.get(ix) - below.get(ix)) * sign;
                let length = cross.length();
                let has_area = (length > f32::MIN_POSITIVE) & (length < f32::INFINITY);
                let normal = cross / length;
                num_folded += u32::from(!has_area);
                to.set(ix, if has_area { normal } else { Vec3::ZERO });
            }
            num_folded > 0
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{hash32, signed_unit};

    #[test]
    fn sums_of_normals_are_the_twin_on_every_level() {
        for level in SimdLevel::all() {
            let mut sums = Vec3s::default();
            for n in 0..37 {
                let random = |axis: u32| signed_unit(hash32(3 * n + axis)) * 3.0;
                sums.push(Vec3::new(random(0), random(1), random(2)));
            }
            let single = Vec3::new(0.6, 0.0, -0.8);
            sums.set(20, single);
            let mut twins: Vec<Vec3> = (0..37).map(|ix| sums.get(ix) / sums.get(ix).length()).collect();
            twins[20] = single;
            assert!(unit_sums(level, &mut sums));
            (0..37).for_each(|ix| assert_eq!(sums.get(ix), twins[ix], "{level:?}"));
            sums.set(9, Vec3::splat(1e-4));
            assert!(!unit_sums(level, &mut sums));
            assert_eq!(sums.get(9), Vec3::ZERO, "sides that face each other");
        }
    }

    #[test]
    fn blended_normals_are_the_twin_on_every_level() {
        let list = |seed: u32| {
            let mut list = Vec3s::default();
            for n in 0..37 {
                let random = |axis: u32| signed_unit(hash32(seed + 3 * n + axis));
                list.push(Vec3::new(random(0), random(1), random(2)).normalize());
            }
            list
        };
        let (from, mut to) = (list(0), list(1000));
        to.set(5, -from.get(5));
        for level in SimdLevel::all() {
            let mut out = Vec3s::default();
            blend_normals(level, [&from, &to], 0.5, 37, &mut out);
            for ix in 0..37 {
                let between = from.get(ix) + (to.get(ix) - from.get(ix)) * 0.5;
                assert_eq!(out.get(ix), between.normalize_or(from.get(ix)), "{level:?}");
            }
            assert_eq!(out.get(5), from.get(5), "opposite ones");
        }
    }
}
