//! Noise: smooth random functions of a point in space.
//!
//! In: a point in cells of an integer lattice, and a seed. Out: a number with known bounds. Lattice values come from
//! integer hashes, the rest is + - * and comparisons: same bits on every machine, and WGSL has the same operations.
//! Sources: Perlin, "Improving Noise", SIGGRAPH 2002 (gradients along edges of a cube, quintic ease curve); Worley,
//! "A Cellular Texture Basis Function", SIGGRAPH 1996.

use super::hash::hash32;
use super::reduce::floor;

/// Points beyond this many cells from the origin are taken as this far: one cell is still told from the next.
const FARTHEST: f64 = (1u64 << 50) as f64;

/// Steps of the hash's argument along y and z. Odd, and far from rational in each other (powers of the inverse of
/// x^3 = x + 1), so that within a plane of equal x no vector shorter than about 2^16 cells repeats the noise.
pub(super) const STEP_Y: u32 = 0xc13f_a9a9;
/// See `STEP_Y`.
pub(super) const STEP_Z: u32 = 0x91e1_0da5;

/// 1 / 1.0364, the largest sum that these gradients can make.
const TO_UNIT: f32 = 0.9649;

/// The lattice cell of a coordinate, modulo 2^32, and the place in it, 0 to 1.
#[inline(always)]
#[allow(clippy::manual_clamp)] // In this order not-a-number becomes a number too.
pub(super) fn cell(x: f64) -> (u32, f32) {
    let x = x.max(-FARTHEST).min(FARTHEST);
    let (ix, floor) = floor(x);
    (ix, (x - floor) as f32)
}

/// Hash of a lattice point, of which x and the seed were hashed already.
#[inline(always)]
fn lattice(hashed_x: u32, y: u32, z: u32) -> u32 {
    hash32(hashed_x.wrapping_add(y.wrapping_mul(STEP_Y)).wrapping_add(z.wrapping_mul(STEP_Z)))
}

/// From 0 to 1 with first and second derivative 0 at both.
#[inline(always)]
fn ease(t: f32) -> f32 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

#[inline(always)]
fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// Scalar product of (x, y, z) with one of the midpoints of a cube's edges, four of which come twice: by the hash's upper
/// four bits.
#[inline(always)]
fn slope(hash: u32, x: f32, y: f32, z: f32) -> f32 {
    // 0 to 3 and 12, 13: +-x +-y; 4 to 7: +-x +-z; the others: +-y +-z.
    let kind = hash >> 28;
    let wraps = kind & 14 == 12;
    let first = if (kind < 8) | wraps { x } else { y };
    let second = if (kind < 4) | wraps { y } else { z };
    // 14 has the signs of 13.
    let signs = if kind == 14 { 1 } else { kind };
    let first = f32::from_bits(first.to_bits() ^ (signs << 31));
    let second = f32::from_bits(second.to_bits() ^ ((signs >> 1) << 31));
    first + second
}

/// Gradient noise in a cell, at a place in it.
#[inline(always)]
pub(super) fn in_cell([ix, iy, iz]: [u32; 3], [fx, fy, fz]: [f32; 3], seed: u32) -> f32 {
    let (x0, x1) = (hash32(ix ^ seed), hash32(ix.wrapping_add(1) ^ seed));
    let (y1, z1) = (iy.wrapping_add(1), iz.wrapping_add(1));
    let (gx, gy, gz) = (fx - 1.0, fy - 1.0, fz - 1.0);
    let u = ease(fx);
    let near_low = mix(slope(lattice(x0, iy, iz), fx, fy, fz), slope(lattice(x1, iy, iz), gx, fy, fz), u);
    let near_high = mix(slope(lattice(x0, y1, iz), fx, gy, fz), slope(lattice(x1, y1, iz), gx, gy, fz), u);
    let far_low = mix(slope(lattice(x0, iy, z1), fx, fy, gz), slope(lattice(x1, iy, z1), gx, fy, gz), u);
    let far_high = mix(slope(lattice(x0, y1, z1), fx, gy, gz), slope(lattice(x1, y1, z1), gx, gy, gz), u);
    let v = ease(fy);
    let sum = mix(mix(near_low, near_high, v), mix(far_low, far_high, v), ease(fz));
    (TO_UNIT * sum).clamp(-1.0, 1.0)
}

/// Gradient noise: -1 to 1 (both within reach only in theory; the usual size is 0.3), 0 at all lattice points, twice
/// continuously differentiable. Any point is allowed; one with a coordinate that is no number gives some value.
#[inline]
pub fn gradient(point: [f64; 3], seed: u32) -> f32 {
    let at = point.map(cell);
    in_cell(at.map(|(ix, _)| ix), at.map(|(_, f)| f), seed)
}

/// Square of the distance to the nearest feature point, one of which lies in every cell; at most 1. Continuous.
#[inline]
pub fn cellular(point: [f64; 3], seed: u32) -> f32 {
    let at = point.map(cell);
    // What a neighbour's points are away at least along each axis; the own cell goes first. Points two cells away are
    // farther than 1, which the result never exceeds.
    let steps = at.map(|(ix, f)| {
        [(ix, 0.0, f), (ix.wrapping_sub(1), f, f + 1.0), (ix.wrapping_add(1), 1.0 - f, f - 1.0)]
    });
    let mut nearest = 1.0f32;
    for (x, gap_x, fx) in steps[0] {
        let column = hash32(x ^ seed);
        for (y, gap_y, fy) in steps[1] {
            for (z, gap_z, fz) in steps[2] {
                if gap_x * gap_x + gap_y * gap_y + gap_z * gap_z >= nearest {
                    continue;
                }
                let hash = lattice(column, y, z);
                let place = |shift: u32| ((hash >> shift & 1023) as f32 + 0.5) * (1.0 / 1024.0);
                let (dx, dy, dz) = (fx - place(0), fy - place(10), fz - place(20));
                nearest = nearest.min(dx * dx + dy * dy + dz * dz);
            }
        }
    }
    nearest
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn any_point() -> impl Strategy<Value = [f64; 3]> {
        let coordinate = prop_oneof![-100.0..100.0, any::<f64>(), (-50i32..50).prop_map(f64::from)];
        [coordinate.clone(), coordinate.clone(), coordinate]
    }

    proptest! {
        #[test]
        fn bounds_hold_for_any_point(p in any_point(), seed: u32) {
            prop_assert!((-1.0..=1.0).contains(&gradient(p, seed)));
            prop_assert!((0.0..=1.0).contains(&cellular(p, seed)));
        }

        #[test]
        fn a_small_step_changes_little(p in [-1e4..1e4, -1e4..1e4, -1e4..1e4], axis in 0usize..3, seed: u32) {
            let h = 1e-3;
            let mut q = p;
            q[axis] += h;
            prop_assert!((gradient(p, seed) - gradient(q, seed)).abs() < 4.0 * h as f32);
            prop_assert!((cellular(p, seed) - cellular(q, seed)).abs() < 2.1 * h as f32);
        }

        #[test]
        fn no_step_at_a_lattice_plane(i in -1000i32..1000, y in -9.0..9.0, z in -9.0..9.0, axis in 0usize..3) {
            let at = |x: f64| {
                let mut p = [x, y, z];
                p.rotate_right(axis);
                p
            };
            let (below, above) = (f64::from(i) - 1e-6, f64::from(i) + 1e-6);
            prop_assert!((gradient(at(below), 7) - gradient(at(above), 7)).abs() < 1e-5);
            prop_assert!((cellular(at(below), 7) - cellular(at(above), 7)).abs() < 1e-5);
        }

        #[test]
        fn cells_are_those_of_the_floor(x in prop_oneof![-1e9..1e9, (-1_000_000i32..1_000_000).prop_map(f64::from)]) {
            let (ix, f) = cell(x);
            prop_assert_eq!(ix, x.floor() as i64 as u32);
            prop_assert_eq!(f, (x - x.floor()) as f32);
        }

        #[test]
        fn the_lattice_wraps_only_after_all_integers(p in [-9i32..9, -9i32..9, -9i32..9], axis in 0usize..3) {
            // 2^32 cells on, the same noise again: exact in doubles on a grid of sixteenths.
            let near = p.map(|c| f64::from(c) + 0.3125);
            let mut far = near;
            far[axis] += 4_294_967_296.0;
            prop_assert_eq!(gradient(near, 5), gradient(far, 5));
            prop_assert_eq!(cellular(near, 5), cellular(far, 5));
        }
    }

    #[test]
    fn gradient_noise_vanishes_at_lattice_points_and_else_has_mean_0() {
        assert_eq!(gradient([3.0, -7.0, 1e6], 1), 0.0);
        let n = 60;
        let place = |i: i32| f64::from(i) * 0.37 + 0.11;
        let (mut sum, mut square, mut least, mut most) = (0.0, 0.0, 0.0f32, 0.0f32);
        for ix in 0..n * n * n {
            let value = gradient([place(ix % n), place(ix / n % n), place(ix / n / n)], 9);
            (sum, square) = (sum + f64::from(value), square + f64::from(value * value));
            (least, most) = (least.min(value), most.max(value));
        }
        let count = f64::from(n * n * n);
        assert!((sum / count).abs() < 0.01, "mean {}", sum / count);
        let size = (square / count).sqrt();
        assert!((0.2..0.35).contains(&size), "usual size {size}");
        assert!(least < -0.7 && most > 0.7, "{least} to {most}");
    }

    #[test]
    fn the_nearest_feature_is_the_nearest_of_all_cells_around() {
        // Without leaving any cell out.
        let brute = |p: [f64; 3], seed: u32| {
            let mut nearest = 1.0f32;
            for n in 0..125 {
                let d = [n % 5 - 2, n / 5 % 5 - 2, n / 25 - 2];
                let at = p.map(cell);
                let [x, y, z] = [0, 1, 2].map(|a| at[a].0.wrapping_add(d[a] as u32));
                let hash = lattice(hash32(x ^ seed), y, z);
                let gap = |a: usize| {
                    let place = ((hash >> (10 * a) & 1023) as f32 + 0.5) * (1.0 / 1024.0);
                    at[a].1 - d[a] as f32 - place
                };
                nearest = nearest.min(gap(0) * gap(0) + gap(1) * gap(1) + gap(2) * gap(2));
            }
            nearest
        };
        for n in 0..3000u32 {
            let p = [0, 1, 2].map(|a| f64::from(hash32(3 * n + a)) / 1e8);
            assert!((brute(p, n) - cellular(p, n)).abs() < 1e-6, "{p:?}");
        }
    }

    #[test]
    fn known_values_stay() {
        // Changed noise changes pictures.
        let p = [1.25, -3.5, 0.75];
        assert_eq!([gradient(p, 0).to_bits(), cellular(p, 0).to_bits()], [1_046_628_850, 1_060_813_452]);
    }
}
