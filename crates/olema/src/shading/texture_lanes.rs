//! Images at many places at a time.
//!
//! In: `LANES` places with their filter widths. Out: what [`TextureImage::sample`] gives at each, bit for bit; that is the
//! twin to read. Everything goes in lanes but the texels, which are looked up one by one.

#![allow(clippy::needless_range_loop)] // A loop over lanes reads as what it becomes.

use super::texture::{EDGE, Level, TextureImage};
use crate::math::function;
use crate::math::reduce::floor;
use crate::math::simd::LANES;

/// The first of three texels around a place along one side, and their weights, by number and lane.
struct Taps {
    first: [u32; LANES],
    weight: [[f32; LANES]; 3],
}

impl TextureImage {
    /// [`Self::sample`] in every lane, and what is no number where that gives nothing.
    #[inline(always)]
    pub(super) fn sample_lanes(&self, st: &[[f64; LANES]; 2], width: &[[f32; LANES]; 2]) -> [f32; LANES] {
        let [columns, rows] = self.size().map(|size| size as f32);
        let last = (self.levels.len() - 1) as f32;
        let (mut level, mut part) = ([0u32; LANES], [0.0f32; LANES]);
        let mut is_between = false;
        for lane in 0..LANES {
            let texels = (width[0][lane] * columns).max(width[1][lane] * rows);
            let log = function::log2(texels).min(last);
            let lod = if texels > 1.0 { log } else { 0.0 };
            level[lane] = floor(f64::from(lod)).0;
            part[lane] = lod - level[lane] as i32 as f32;
            is_between |= part[lane] > 0.0;
        }
        let mut value = self.at_levels(&level, st);
        if is_between {
            for level in &mut level {
                *level = (*level + 1).min(self.levels.len() as u32 - 1);
            }
            let coarse = self.at_levels(&level, st);
            for lane in 0..LANES {
                let fine = value[lane];
                let between = fine + (coarse[lane] - fine) * part[lane];
                value[lane] = if part[lane] > 0.0 { between } else { fine };
            }
        }
        let [least, most] = self.range;
        for lane in 0..LANES {
            let is_place = st[0][lane].is_finite() & st[1][lane].is_finite();
            let is_there = is_place & !width[0][lane].is_nan() & !width[1][lane].is_nan();
            value[lane] = if is_there { value[lane].clamp(least, most) } else { f32::NAN };
        }
        value
    }

    /// [`Level::at`] in every lane, each at a level of its own: mostly there are one or two of them.
    #[inline(always)]
    fn at_levels(&self, level: &[u32; LANES], st: &[[f64; LANES]; 2]) -> [f32; LANES] {
        let mut value = [0.0f32; LANES];
        let mut least = level.iter().fold(u32::MAX, |least, &level| least.min(level));
        while least < u32::MAX {
            let there = self.levels[least as usize].at_lanes(st);
            let mut next = u32::MAX;
            for lane in 0..LANES {
                value[lane] = if level[lane] == least { there[lane] } else { value[lane] };
                next = next.min(if level[lane] > least { level[lane] } else { u32::MAX });
            }
            least = next;
        }
        value
    }
}

impl Level {
    /// [`Self::at`] in every lane.
    #[inline(always)]
    fn at_lanes(&self, [s, t]: &[[f64; LANES]; 2]) -> [f32; LANES] {
        let (x, y) = (Taps::new(s, self.width as u32), Taps::new(t, self.height as u32));
        let mut first = [0u32; LANES];
        for lane in 0..LANES {
            first[lane] = y.first[lane] * (self.width + EDGE) as u32 + x.first[lane];
        }
        let mut columns = [[0.0f32; 4]; LANES];
        for lane in 0..LANES {
            let weights = [y.weight[0][lane], y.weight[1][lane], y.weight[2][lane]];
            columns[lane] = self.columns(first[lane] as usize, weights);
        }
        let mut sum = [0.0f32; LANES];
        for lane in 0..LANES {
            let [a, b, c, _] = columns[lane];
            sum[lane] = x.weight[0][lane] * a + x.weight[1][lane] * b + x.weight[2][lane] * c;
        }
        sum
    }
}

impl Taps {
    /// The texels around places along a side of `len` texels.
    #[inline(always)]
    fn new(place: &[f64; LANES], len: u32) -> Self {
        let mut taps = Taps { first: [0; LANES], weight: [[0.0; LANES]; 3] };
        let mut f = [0.0f32; LANES];
        for lane in 0..LANES {
            let along = (place[lane] - place[lane].floor()) * f64::from(len);
            // 0 for what is no number.
            let along = if along > 0.0 { along } else { 0.0 };
            let ix = (floor(along).0 as i32).min(len as i32 - 1);
            taps.first[lane] = ix as u32;
            f[lane] = (along - f64::from(ix)) as f32 - 0.5;
        }
        for lane in 0..LANES {
            let f = f[lane];
            let (a, b) = (0.5 - f, 0.5 + f);
            (taps.weight[0][lane], taps.weight[1][lane], taps.weight[2][lane]) =
                (0.5 * a * a, 0.75 - f * f, 0.5 * b * b);
        }
        taps
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
            let data = (0..columns * rows).map(|n| unit(hash32(n as u32))).collect();
            let image = TextureImage::new(columns, rows, data).unwrap();
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
