//! Hulls: control points of a part of a surface, in lanes.
//!
//! In: a surface and a part of its domain. Out: points whose convex hull holds that part. Twin:
//! [`Bicubic::restrict`](super::Bicubic::restrict).

use glam::Vec3;

use super::bezier::{Bicubic, restrict_curve};
use crate::math::simd::{LANES, SimdLevel};

/// Points, as many as there are lanes: where there are fewer, one of them is repeated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hull {
    /// By axis and number.
    pub points: [[f32; LANES]; 3],
}

impl Hull {
    /// Of at most 16 points.
    pub fn of<const N: usize>(points: [Vec3; N]) -> Self {
        const { assert!(N > 0 && N <= LANES) };
        let mut hull = Hull { points: [[points[0].x; LANES], [points[0].y; LANES], [points[0].z; LANES]] };
        let [x, y, z] = &mut hull.points;
        for (ix, p) in points.iter().enumerate() {
            (x[ix], y[ix], z[ix]) = (p.x, p.y, p.z);
        }
        hull
    }
}

/// Control points of a bicubic patch over `[u0, u1] x [v0, v1]`.
pub fn bicubic_hull(level: SimdLevel, surface: &Bicubic<Vec3>, u: [f32; 2], v: [f32; 2]) -> Hull {
    let p = &surface.0;
    if u == [0.0, 1.0] && v == [0.0, 1.0] {
        return Hull::of(*p);
    }
    level.run(
        #[inline(always)]
        || {
            // A curve of four points, each of which has a lane for each row and axis: u goes along the curve.
            let mut rows = [[0.0f32; LANES]; 4];
            for j in 0..4 {
                for i in 0..4 {
                    let p = p[4 * j + i];
                    (rows[i][j], rows[i][4 + j], rows[i][8 + j]) = (p.x, p.y, p.z);
                }
            }
            let rows = if u == [0.0, 1.0] { rows } else { restrict_curve(rows, u, mix) };
            // The same with a lane for each column and axis.
            let mut columns = [[0.0f32; LANES]; 4];
            for axis in 0..3 {
                for j in 0..4 {
                    for i in 0..4 {
                        columns[j][4 * axis + i] = rows[i][4 * axis + j];
                    }
                }
            }
            let columns = if v == [0.0, 1.0] { columns } else { restrict_curve(columns, v, mix) };
            let mut points = [[0.0f32; LANES]; 3];
            for axis in 0..3 {
                for j in 0..4 {
                    points[axis][4 * j..4 * j + 4].copy_from_slice(&columns[j][4 * axis..4 * axis + 4]);
                }
            }
            Hull { points }
        },
    )
}

/// [`ControlPoint::mix`](super::bezier::ControlPoint::mix) in every lane.
#[inline(always)]
fn mix(a: [f32; LANES], b: [f32; LANES], t: f32) -> [f32; LANES] {
    let mut mixed = [0.0; LANES];
    for lane in 0..LANES {
        mixed[lane] = a[lane] * (1.0 - t) + b[lane] * t;
    }
    mixed
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{hash32, signed_unit};

    #[test]
    fn hulls_are_the_twin_on_every_level() {
        let random = |n: u32| signed_unit(hash32(n));
        let surface =
            Bicubic(std::array::from_fn(|n| Vec3::from([0, 1, 2].map(|a| random(3 * n as u32 + a)))));
        for (u, v) in [
            ([0.0, 1.0], [0.0, 1.0]),
            ([0.0, 0.5], [0.0, 1.0]),
            ([0.0, 1.0], [0.3, 0.9]),
            ([0.25, 0.75], [0.125, 0.2]),
        ] {
            let twin = Hull::of(surface.restrict(u, v).0);
            for level in SimdLevel::all() {
                let hull = bicubic_hull(level, &surface, u, v);
                assert_eq!(
                    hull.points.map(|axis| axis.map(f32::to_bits)),
                    twin.points.map(|a| a.map(f32::to_bits))
                );
            }
        }
    }
}
