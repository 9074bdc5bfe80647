//! Images at many places at a time.
//!
//! In: `LANES` places with their filter widths. Out: what [`TextureImage::sample`] gives at each, bit for bit; that is the
//! twin to read. Everything goes in lanes but the texels, which are looked up one by one.

#![allow(clippy::needless_range_loop)] // A loop over lanes reads as what it becomes.

use super::texture::{EDGE, Level, TextureImage, columns, fraction, level_of, texel, weights};
use crate::math::simd::LANES;

impl TextureImage {
    /// [`Self::sample`] in every lane, and what is no number where that gives nothing.
    #[inline(always)]
    pub(super) fn sample_lanes(&self, st: &[[f64; LANES]; 2], width: &[[f32; LANES]; 2]) -> [f32; LANES] {
        let [columns, rows] = self.size().map(|size| size as f32);
        let last = self.levels.len() as u32 - 1;
        // Of the finer and the coarser level, which are the same where nothing lies between.
        let (mut fine, mut coarse, mut part) = ([0u32; LANES], [0u32; LANES], [0.0f32; LANES]);
        let (mut first_level, mut last_level) = (u32::MAX, 0);
        for lane in 0..LANES {
            (fine[lane], part[lane]) = level_of((width[0][lane] * columns).max(width[1][lane] * rows), last);
            coarse[lane] = fine[lane] + u32::from(part[lane] > 0.0);
            first_level = first_level.min(fine[lane]);
            last_level = last_level.max(coarse[lane]);
        }
        let mut places = [[0u32; LANES]; 2];
        for (places, st) in places.iter_mut().zip(st) {
            for lane in 0..LANES {
                places[lane] = fraction(st[lane]);
            }
        }
        // Mostly two or three levels hold all lanes.
        let (mut finer, mut coarser) = ([0.0f32; LANES], [0.0f32; LANES]);
        for level in first_level..=last_level {
            let mut num_there = 0;
            for lane in 0..LANES {
                num_there += u32::from((fine[lane] == level) | (coarse[lane] == level));
            }
            if num_there == 0 {
                continue;
            }
            let there = self.levels[level as usize].at_lanes(&places);
            for lane in 0..LANES {
                finer[lane] = if fine[lane] == level { there[lane] } else { finer[lane] };
                coarser[lane] = if coarse[lane] == level { there[lane] } else { coarser[lane] };
            }
        }
        let [least, most] = self.range;
        let mut value = [0.0f32; LANES];
        for lane in 0..LANES {
            let between = finer[lane] + (coarser[lane] - finer[lane]) * part[lane];
            let between = if part[lane] > 0.0 { between } else { finer[lane] };
            let is_place = st[0][lane].is_finite() & st[1][lane].is_finite();
            let is_there = is_place & !width[0][lane].is_nan() & !width[1][lane].is_nan();
            // Not `clamp`, whose check of the range would end the loop early.
            let within = if between < least { least } else { between };
            let within = if within > most { most } else { within };
            value[lane] = if is_there { within } else { f32::NAN };
        }
        value
    }
}

impl Level {
    /// [`Self::at`] in every lane.
    #[inline(always)]
    fn at_lanes(&self, [s, t]: &[[u32; LANES]; 2]) -> [f32; LANES] {
        let (mut first, mut x, mut y) = ([0u32; LANES], [0.0f32; LANES], [0.0f32; LANES]);
        let (width, height, stride) = (self.width as u32, self.height as u32, (self.width + EDGE) as u32);
        for lane in 0..LANES {
            let ((column, along), (row, across)) = (texel(s[lane], width), texel(t[lane], height));
            (first[lane], x[lane], y[lane]) = (row * stride + column, along, across);
        }
        let mut across = [[0.0f32; LANES]; 3];
        for lane in 0..LANES {
            [across[0][lane], across[1][lane], across[2][lane]] = weights(y[lane]);
        }
        let mut sums = [[0.0f32; 4]; LANES];
        let rows = self.rows();
        for lane in 0..LANES {
            let weights = [across[0][lane], across[1][lane], across[2][lane]];
            sums[lane] = columns(rows, first[lane] as usize, weights);
        }
        let mut sum = [0.0f32; LANES];
        for lane in 0..LANES {
            let [a, b, c, _] = sums[lane];
            let along = weights(x[lane]);
            sum[lane] = along[0] * a + along[1] * b + along[2] * c;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{hash32, signed_unit, unit};
    use crate::math::simd::SimdLevel;

    #[test]
    fn lanes_are_the_twin_on_every_level() {
        for (columns, rows) in [(1, 1), (13, 6), (64, 32), (1, 9)] {
            let data: Vec<f32> = (0..columns * rows).map(|n| unit(hash32(n as u32))).collect();
            let image = TextureImage::new(columns, rows, &data).unwrap();
            for seed in 0..200 {
                let random = |n: usize| signed_unit(hash32(1000 * seed + n as u32));
                let mut st: [[f64; LANES]; 2] = std::array::from_fn(|axis| {
                    std::array::from_fn(|lane| 3.0 * f64::from(random(40 * axis + lane)))
                });
                let mut width: [[f32; LANES]; 2] =
                    std::array::from_fn(|axis| std::array::from_fn(|lane| random(100 + 40 * axis + lane)));
                if seed % 4 == 0 {
                    (st[0][1], st[1][2], st[0][3]) = (f64::NAN, f64::INFINITY, 5.0);
                    (width[0][4], width[1][5], width[0][6]) = (f32::NAN, f32::INFINITY, 0.0);
                    width[0].iter_mut().for_each(|width| *width *= 0.1);
                }
                for level in SimdLevel::all() {
                    let values = level.run(
                        #[inline(always)]
                        || image.sample_lanes(&st, &width),
                    );
                    for lane in 0..LANES {
                        let twin = image.sample([st[0][lane], st[1][lane]], [width[0][lane], width[1][lane]]);
                        match twin {
                            Some(twin) => assert_eq!(values[lane].to_bits(), twin.to_bits(), "{level:?}"),
                            None => assert!(values[lane].is_nan(), "{level:?}"),
                        }
                    }
                }
            }
        }
    }
}
