//! Normals of lists of points and of lattices.
//!
//! In: derivatives, or a lattice of positions. Out: unit normals, place by place with the same bits however the list is
//! cut.

use std::ops::Range;

use glam::Vec3;

use crate::geometry::lanes::{SLACK, SurfacePoints};
use crate::math::Vec3s;
use crate::math::simd::{SimdLevel, load, store};

use super::patch::normal_or_zero;

/// Normals at a time.
const GROUP: usize = SLACK;

/// Writes the unit normals du x dv of the points `range`, times `sign`, to the same places of `to`; zero where du and dv
/// vanish or are parallel. Returns whether that happened. Up to [`SLACK`] normals behind the range are overwritten.
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
            let mut missing = 0u32;
            for first in range.clone().step_by(GROUP) {
                let group = |all: &Vec3s| -> [[f32; GROUP]; 3] {
                    [load(&all.x, first), load(&all.y, first), load(&all.z, first)]
                };
                let (du, dv) = (group(&at.du), group(&at.dv));
                let mut normals = [[0.0; GROUP]; 3];
                for lane in 0..GROUP {
                    let du = Vec3::new(du[0][lane], du[1][lane], du[2][lane]);
                    let dv = Vec3::new(dv[0][lane], dv[1][lane], dv[2][lane]);
                    let normal = normal_or_zero(du, dv);
                    let is_missing = (normal.x == 0.0) & (normal.y == 0.0) & (normal.z == 0.0);
                    missing |= u32::from(is_missing & (first + lane < range.end));
                    let normal = normal * sign;
                    (normals[0][lane], normals[1][lane], normals[2][lane]) = (normal.x, normal.y, normal.z);
                }
                store(&mut to.x, first, &normals[0]);
                store(&mut to.y, first, &normals[1]);
                store(&mut to.z, first, &normals[2]);
            }
            missing != 0
        },
    )
}

/// Unit normals of a lattice by central differences, times `sign`; zero where it is folded to nothing.
///
/// In: `width` positions a row, row after row. Out: a normal for each of them, of which those of the first and last row
/// and column mean nothing.
pub fn lattice_normals(level: SimdLevel, lattice: &Vec3s, width: usize, sign: f32, to: &mut Vec3s) {
    to.resize(lattice.len());
    let Some(len) = lattice.len().checked_sub(2 * width).filter(|len| *len > 0) else { return };
    level.run(
        #[inline(always)]
        || {
            // One list from the second row to the last but one: ends of rows are computed along, to go through in lanes.
            for first in (0..len).step_by(GROUP) {
                let group = |by: usize| -> [[f32; GROUP]; 3] {
                    let first = first + by;
                    [load(&lattice.x, first), load(&lattice.y, first), load(&lattice.z, first)]
                };
                let (left, right) = (group(width - 1), group(width + 1));
                let (below, above) = (group(0), group(2 * width));
                let mut normals = [[0.0; GROUP]; 3];
                for lane in 0..GROUP {
                    let across = |from: &[[f32; GROUP]; 3], to: &[[f32; GROUP]; 3]| {
                        Vec3::new(to[0][lane], to[1][lane], to[2][lane])
                            - Vec3::new(from[0][lane], from[1][lane], from[2][lane])
                    };
                    let cross = across(&left, &right).cross(across(&below, &above)) * sign;
                    let length = cross.length();
                    let has_area = (length > f32::MIN_POSITIVE) & (length < f32::INFINITY);
                    let normal = cross / length;
                    let normal = if has_area { normal } else { Vec3::ZERO };
                    (normals[0][lane], normals[1][lane], normals[2][lane]) = (normal.x, normal.y, normal.z);
                }
                store(&mut to.x, first + width, &normals[0]);
                store(&mut to.y, first + width, &normals[1]);
                store(&mut to.z, first + width, &normals[2]);
            }
        },
    );
}
