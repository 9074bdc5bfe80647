//! Images as functions of (s, t), filtered by an explicit width.
//!
//! In: one number a texel. Out: its smooth, periodic continuation, averaged over about a width: trilinear between
//! the levels of a pyramid that is made once. Source: Williams, "Pyramidal Parametrics", SIGGRAPH 1983; between
//! texels biquadratic B-splines instead of bilinear ramps, because a height has to have a continuous slope.
//! Many places at a time: [`texture_lanes`](super::texture_lanes).

use crate::error::Error;
use crate::math::reduce;

/// One channel of an image, with its pyramid.
#[derive(Debug, Clone)]
pub struct TextureImage {
    pub(super) levels: Vec<Level>,
    pub(super) range: [f32; 2],
}

/// One size of the image. Around its texels are those of the other side, so that any three by three that follow each other
/// need no wrapping, and after each row one more, so that four can be read.
#[derive(Debug, Clone)]
pub(super) struct Level {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Row after row of `width + EDGE` texels, from the one before t = 0 to the one behind t = 1.
    pub(super) data: Vec<f32>,
}

/// Texels of a row besides its own: one before it, two behind.
pub(super) const EDGE: usize = 3;

impl TextureImage {
    /// An image of `width` x `height` texels, rows from t = 0 on, each from s = 0 on; texels are centred in their
    /// squares of the unit square.
    ///
    /// # Errors
    /// [`Error::Shader`] where there is no texel, not one value a texel, one that is not finite, or more than can be numbered
    /// in 32 bits.
    pub fn new(width: usize, height: usize, data: &[f32]) -> Result<Self, Error> {
        if width == 0 || height == 0 || width.checked_mul(height) != Some(data.len()) {
            let found = data.len();
            return Err(Error::Shader(format!(
                "an image of {width} x {height} texels has {found} values: expected one a texel, and at least one"
            )));
        }
        let mut range = [f32::INFINITY, f32::NEG_INFINITY];
        for value in data {
            if !value.is_finite() {
                return Err(Error::Shader(format!("a texel is {value}: expected finite values")));
            }
            range = [range[0].min(*value), range[1].max(*value)];
        }
        if (width + EDGE).saturating_mul(height + 2) > u32::MAX as usize {
            return Err(Error::Shader(format!(
                "an image of {width} x {height} texels is too large: expected fewer than 2^32"
            )));
        }
        let mut last = Level::new(width, height, data);
        let mut levels = Vec::new();
        while last.width > 1 || last.height > 1 {
            let next = last.halved();
            levels.push(std::mem::replace(&mut last, next));
        }
        levels.push(last);
        Ok(TextureImage { levels, range })
    }

    /// Width and height in texels.
    pub fn size(&self) -> [usize; 2] {
        [self.levels[0].width, self.levels[0].height]
    }

    /// Smallest and largest texel.
    pub fn range(&self) -> [f32; 2] {
        self.range
    }

    /// The value at (s, t), averaged over about `width` (in s and in t); the image repeats in both. Within
    /// [`Self::range`]. A width of 0 or below is none.
    ///
    /// `None` where s, t or a width is not a number, or s or t infinite.
    pub fn sample(&self, st: [f64; 2], width: [f32; 2]) -> Option<f32> {
        if !(st[0].is_finite() && st[1].is_finite()) || width[0].is_nan() || width[1].is_nan() {
            return None;
        }
        let [columns, rows] = self.size();
        let texels = (width[0] * columns as f32).max(width[1] * rows as f32);
        let (level, part) = level_of(texels, self.levels.len() as u32 - 1);
        let st = st.map(fraction);
        let fine = self.levels[level as usize].at(st);
        let value =
            if part > 0.0 { fine + (self.levels[level as usize + 1].at(st) - fine) * part } else { fine };
        Some(value.clamp(self.range[0], self.range[1]))
    }
}

impl Level {
    /// Of texels, row after row.
    fn new(width: usize, height: usize, texels: &[f32]) -> Self {
        let mut data = Vec::with_capacity((width + EDGE) * (height + 2));
        for y in 0..height + 2 {
            let row = &texels[(y + height - 1) % height * width..][..width];
            data.push(row[width - 1]);
            data.extend_from_slice(row);
            data.extend([row[0], row[1 % width]]);
        }
        Level { width, height, data }
    }

    /// A row of texels.
    fn row(&self, y: usize) -> &[f32] {
        &self.data[(y + 1) * (self.width + EDGE) + 1..][..self.width]
    }

    /// Half as wide and high, rounded down but at least 1: means over equal parts, also where a part is 2 + 1/n texels.
    fn halved(&self) -> Level {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let mut rows = Vec::with_capacity(width * self.height);
        for row in (0..self.height).map(|y| self.row(y)) {
            rows.extend((0..width).map(|x| mean(self.width, width, x, |j| row[j])));
        }
        let mut texels = Vec::with_capacity(width * height);
        for y in 0..height {
            texels.extend((0..width).map(|x| mean(self.height, height, y, |j| rows[j * width + x])));
        }
        Level::new(width, height, &texels)
    }

    /// The biquadratic B-spline of the texels at a [`fraction`] of either side.
    fn at(&self, [s, t]: [u32; 2]) -> f32 {
        let (x, y) = (texel(s, self.width as u32), texel(t, self.height as u32));
        let first = y.0 as usize * (self.width + EDGE) + x.0 as usize;
        let ([a, b, c, _], along) = (columns(self.rows(), first, weights(y.1)), weights(x.1));
        along[0] * a + along[1] * b + along[2] * c
    }

    /// All texels, those a row below and those two below: as many of each.
    #[inline(always)]
    pub(super) fn rows(&self) -> [&[f32]; 3] {
        let stride = self.width + EDGE;
        let len = self.data.len() - 2 * stride;
        [0, 1, 2].map(|row| &self.data[row * stride..][..len])
    }
}

/// Sums of three texels above each other with weights, for four columns from `first` on.
#[inline(always)]
pub(super) fn columns(rows: [&[f32]; 3], first: usize, weights: [f32; 3]) -> [f32; 4] {
    // Of one length, so that one look at it is enough.
    let [a, b, c] = rows.map(|row| &row[first..first + 4]);
    std::array::from_fn(|column| weights[0] * a[column] + weights[1] * b[column] + weights[2] * c[column])
}

/// Mean of part `ix` of `parts` equal parts of `len` values, `parts <= len`.
fn mean(len: usize, parts: usize, ix: usize, value: impl Fn(usize) -> f32) -> f32 {
    // In units of 1 / parts of a value, a value is `parts` long and a part `len`.
    let (start, end) = (ix * len, (ix + 1) * len);
    let mut sum = 0.0;
    for j in start / parts..end.div_ceil(parts) {
        let overlap = ((j + 1) * parts).min(end) - (j * parts).max(start);
        sum += value(j) * (overlap as f32 / len as f32);
    }
    sum
}

/// The level of a pyramid for a filter that is so many texels of the finest one wide, and how much of the next one is
/// mixed in, 0 to 1: in proportion to the width between the levels' own, the powers of 2. `last` is the coarsest one.
#[inline(always)]
pub(super) fn level_of(texels: f32, last: u32) -> (u32, f32) {
    let bits = if texels > 1.0 { texels.to_bits() } else { 1.0f32.to_bits() };
    let level = (bits >> 23) - 127;
    let part = f32::from_bits(bits & 0x007f_ffff | 1.0f32.to_bits()) - 1.0;
    if level < last { (level, part) } else { (last, 0.0) }
}

/// Where a place is within its repetition of an image, in 1/2^32 of its side.
#[inline(always)]
pub(super) fn fraction(place: f64) -> u32 {
    let within = place - reduce::floor(place).1;
    reduce::floor(within * 4_294_967_296.0).0
}

/// The first of the three texels around a [`fraction`] of a side of `len` texels, counted from the one before it, and
/// where it is between the middle one's ends, -0.5 to 0.5.
#[inline(always)]
pub(super) fn texel(fraction: u32, len: u32) -> (u32, f32) {
    let along = u64::from(fraction) * u64::from(len);
    // As many bits as a number of single precision holds.
    let part = (along as u32 >> 8) as i32 as f32 * (1.0 / 16_777_216.0);
    ((along >> 32) as u32, part - 0.5)
}

/// The weights of the three texels around a place in the middle one, -0.5 to 0.5.
#[inline(always)]
pub(super) fn weights(place: f32) -> [f32; 3] {
    let (a, b) = (0.5 - place, 0.5 + place);
    [0.5 * a * a, 0.75 - place * place, 0.5 * b * b]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::math::hash::{hash32, unit};

    fn random(width: usize, height: usize) -> TextureImage {
        let data: Vec<f32> = (0..width * height).map(|n| unit(hash32(n as u32))).collect();
        TextureImage::new(width, height, &data).unwrap()
    }

    fn mean_of(level: &Level) -> f64 {
        let texels = (0..level.height).flat_map(|y| level.row(y));
        texels.map(|v| f64::from(*v)).sum::<f64>() / (level.width * level.height) as f64
    }

    #[test]
    fn every_level_of_the_pyramid_keeps_the_mean() {
        for (width, height) in [(1, 1), (64, 32), (7, 13), (1, 9), (100, 3)] {
            let image = random(width, height);
            let sizes: Vec<_> = image.levels.iter().map(|l| (l.width, l.height)).collect();
            assert_eq!(sizes.last(), Some(&(1, 1)), "{sizes:?}");
            for level in &image.levels {
                assert!((mean_of(level) - mean_of(&image.levels[0])).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn a_wide_filter_gives_the_mean_and_a_ramp_stays_one() {
        let image = random(16, 8);
        let mean = image.sample([0.3, 0.8], [f32::INFINITY, 0.0]).unwrap();
        assert!((f64::from(mean) - mean_of(&image.levels[0])).abs() < 1e-5);
        let ramp = TextureImage::new(8, 1, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]).unwrap();
        let at = |s: f64| ramp.sample([s, 0.5], [0.0; 2]).unwrap();
        assert!((at(0.5) - 3.5).abs() < 1e-6 && (at(2.5 / 8.0) - 2.0).abs() < 1e-6);
        // Filtered, too: the levels of a ramp are ramps.
        let wide = ramp.sample([0.5, 0.5], [0.25, 0.0]).unwrap();
        assert!((wide - 3.5).abs() < 1e-6, "{wide}");
    }

    #[test]
    fn what_is_no_image_is_refused() {
        for (width, height, data) in [(0, 1, vec![]), (2, 2, vec![0.0; 3]), (1, 1, vec![f32::NAN])] {
            assert!(TextureImage::new(width, height, &data).is_err());
        }
        assert_eq!(random(2, 2).sample([f64::NAN, 0.0], [0.0; 2]), None);
    }

    proptest! {
        #[test]
        fn samples_stay_in_range_repeat_and_are_continuous(
            s in -3.0..3.0, t in -3.0..3.0, width in prop_oneof![Just(0.0f32), 0.0f32..2.0, Just(f32::INFINITY)],
        ) {
            let image = random(13, 6);
            let at = |s: f64, t: f64| image.sample([s, t], [width; 2]).unwrap();
            let [min, max] = image.range();
            prop_assert!((min..=max).contains(&at(s, t)));
            prop_assert!((at(s, t) - at(s + 1.0, t - 2.0)).abs() < 1e-5);
            prop_assert!((at(s, t) - at(s + 1e-5, t)).abs() < 1e-3);
            let (before, after) = (at(s.round() - 1e-9, t), at(s.round() + 1e-9, t));
            prop_assert!((before - after).abs() < 1e-5, "seam: {} and {}", before, after);
        }
    }
}
