//! Noise at many points at a time.
//!
//! In: `LANES` points in cells of an integer lattice, and a seed. Out: what [`noise`](super::noise) gives at each, bit for
//! bit; that is the twin to read. Cells are found in a loop of their own: where doubles and floats meet in one loop, it
//! goes in as few lanes as doubles do.

#![allow(clippy::needless_range_loop)] // A loop over lanes reads as what it becomes.

use super::hash::hash32;
use super::noise::{STEP_Y, STEP_Z, cell, in_cell};
use super::simd::LANES;

/// Lattice cells of points, and places in them, by axis and lane.
#[derive(Debug, Clone, Copy)]
pub struct Cells {
    cell: [[u32; LANES]; 3],
    place: [[f32; LANES]; 3],
}

impl Cells {
    /// The cells of `point[axis][lane]`.
    #[inline(always)]
    pub fn of(point: &[[f64; LANES]; 3]) -> Self {
        let mut cells = Cells { cell: [[0; LANES]; 3], place: [[0.0; LANES]; 3] };
        for axis in 0..3 {
            for lane in 0..LANES {
                (cells.cell[axis][lane], cells.place[axis][lane]) = cell(point[axis][lane]);
            }
        }
        cells
    }
}

/// [`noise::gradient`](super::noise::gradient) in every lane.
#[inline(always)]
pub fn gradient(at: &Cells, seed: u32) -> [f32; LANES] {
    let mut out = [0.0; LANES];
    for (lane, out) in out.iter_mut().enumerate() {
        let cell = [at.cell[0][lane], at.cell[1][lane], at.cell[2][lane]];
        *out = in_cell(cell, [at.place[0][lane], at.place[1][lane], at.place[2][lane]], seed);
    }
    out
}

/// [`noise::cellular`](super::noise::cellular) in every lane. All 27 cells are looked at: leaving some out is for one
/// point at a time.
#[inline(always)]
pub fn cellular(at: &Cells, seed: u32) -> [f32; LANES] {
    let mut nearest = [1.0f32; LANES];
    for step_x in [0u32, u32::MAX, 1] {
        for step_y in [0u32, u32::MAX, 1] {
            let mut row = [0u32; LANES];
            for (lane, row) in row.iter_mut().enumerate() {
                let column = hash32(at.cell[0][lane].wrapping_add(step_x) ^ seed);
                *row = column.wrapping_add(at.cell[1][lane].wrapping_add(step_y).wrapping_mul(STEP_Y));
            }
            for step_z in [0u32, u32::MAX, 1] {
                look(at, &row, [step_x, step_y, step_z], &mut nearest);
            }
        }
    }
    nearest
}

/// Looks at the feature points of one neighbouring cell.
#[inline(always)]
fn look(at: &Cells, row: &[u32; LANES], step: [u32; 3], nearest: &mut [f32; LANES]) {
    let [x, y, z] = [step[0] as i32 as f32, step[1] as i32 as f32, step[2] as i32 as f32];
    for lane in 0..LANES {
        let cell_z = at.cell[2][lane].wrapping_add(step[2]);
        let hash = hash32(row[lane].wrapping_add(cell_z.wrapping_mul(STEP_Z)));
        let dx = (at.place[0][lane] - x) - feature(hash);
        let dy = (at.place[1][lane] - y) - feature(hash >> 10);
        let dz = (at.place[2][lane] - z) - feature(hash >> 20);
        nearest[lane] = nearest[lane].min(dx * dx + dy * dy + dz * dz);
    }
}

/// A coordinate of a feature point in its cell, from ten bits.
#[inline(always)]
fn feature(bits: u32) -> f32 {
    ((bits & 1023) as i32 as f32 + 0.5) * (1.0 / 1024.0)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::noise;
    use super::super::simd::SimdLevel;
    use super::*;

    fn any_coordinate() -> impl Strategy<Value = f64> {
        prop_oneof![8 => -1e4..1e4, 1 => (-9i32..9).prop_map(f64::from), 1 => any::<f64>(), 1 => Just(f64::NAN)]
    }

    proptest! {
        #[test]
        fn lanes_are_the_twin_on_every_level(point: [[f64; 3]; LANES], near in prop::collection::vec(
            [any_coordinate(), any_coordinate(), any_coordinate()], LANES..=LANES), seed: u32,
        ) {
            for points in [&point[..], &near[..]] {
                let mut lanes = [[0.0; LANES]; 3];
                for (lane, point) in points.iter().enumerate() {
                    (0..3).for_each(|axis| lanes[axis][lane] = point[axis]);
                }
                for level in SimdLevel::all() {
                    let both = level.run(#[inline(always)] || {
                        let cells = Cells::of(&lanes);
                        [gradient(&cells, seed), cellular(&cells, seed)]
                    });
                    for (lane, &point) in points.iter().enumerate() {
                        let twin = [noise::gradient(point, seed), noise::cellular(point, seed)];
                        let bits = twin.map(f32::to_bits);
                        prop_assert_eq!([both[0][lane].to_bits(), both[1][lane].to_bits()], bits, "{:?}", level);
                    }
                }
            }
        }
    }
}
