//! From filtered pixels to values for a file: background, exposure, quantization, the sRGB curve.
//!
//! In: linear colours multiplied by alpha. Out: the same after the imager "background" and `Exposure`, and
//! integers after `Quantize`. Source: RenderMan Interface 3.2, sections 4.1 and 4.2 (imaging pipeline); IEC
//! 61966-2-1 for sRGB. Order: filter, background, exposure, then (by the file writer) the file's encoding,
//! quantization. The standard's figure 4.2 runs imagers after exposure; here the background is laid under
//! before, in linear light, so that edges against it blend and expose as edges within the scene do.

use crate::math::simd::SimdLevel;
use crate::math::{function, hash};

/// Finishes a filtered pixel `[r, g, b, a]`, the colour multiplied by alpha.
///
/// The background, if any, is laid under it, which makes alpha 1. Then each colour channel becomes
/// (gain * value)^(1 / gamma), `exposure` being `[gain, gamma]`; a negative value, as filters with negative
/// lobes give, keeps its sign. Alpha is coverage and is not exposed. The colour is exposed as it stands,
/// multiplied by alpha, as the standard has it; so c multiplied by alpha comes out as
/// (gain c)^(1/gamma) alpha^(1/gamma).
pub fn finish_pixel(rgba: [f32; 4], background: Option<[f32; 3]>, exposure: [f32; 2]) -> [f32; 4] {
    let [gain, gamma] = exposure;
    let alpha = rgba[3];
    let mut out = rgba;
    for (channel, value) in out[..3].iter_mut().enumerate() {
        if let Some(background) = background {
            *value += (1.0 - alpha) * background[channel];
        }
        *value *= gain;
        if gamma != 1.0 {
            *value = function::pow(value.abs(), 1.0 / gamma).copysign(*value);
        }
    }
    if background.is_some() {
        out[3] = 1.0;
    }
    out
}

/// `Quantize`: round(one * value + dither * noise), halves away from 0, clamped to [min, max]. `noise` is in
/// (-1, 1), from [`dither_noise`]. Not-a-number counts as 0, infinities as the ends of the range.
#[inline(always)]
pub fn quantize(value: f32, one: i32, [min, max]: [i32; 2], dither: f32, noise: f32) -> i32 {
    let value = if value.is_nan() { 0.0 } else { value };
    // In double: a float near 255 could not hold a small dither.
    let exact = f64::from(one) * f64::from(value) + f64::from(dither) * f64::from(noise);
    // Infinity times 0 is not a number, and the cast makes that 0.
    rounded(exact).max(min).min(max)
}

/// The nearest integer, halves away from 0, within 32 bits; 0 of not-a-number. A loop over lanes holds no call of it.
#[inline(always)]
fn rounded(x: f64) -> i32 {
    let x = x.clamp(i32::MIN.into(), i32::MAX.into());
    let whole = x as i32;
    let rest = x - f64::from(whole);
    whole + i32::from(rest >= 0.5) - i32::from(rest <= -0.5)
}

/// How a row of values becomes integers: [`quantize`] for each, with the noise of its place.
#[derive(Debug, Clone, Copy)]
pub struct RowQuantize {
    /// Value that 1.0 becomes.
    pub one: i32,
    /// Smallest and largest value.
    pub range: [i32; 2],
    /// Amplitude of the dither, 0 to 1.
    pub dither: f32,
    /// Whether values are encoded by [`srgb_encode`] before.
    pub srgb: bool,
}

impl RowQuantize {
    /// Writes the integers of a channel's `values`, in a row from `pixel` of the full frame on, into `out`, as many.
    pub fn run(&self, values: &[f32], [x, y]: [u32; 2], channel: u32, out: &mut [i32]) {
        let RowQuantize { one, range, dither, srgb } = *self;
        SimdLevel::best().run(
            #[inline(always)]
            || {
                for ((out, &value), x) in out.iter_mut().zip(values).zip(x..) {
                    let value = if srgb { srgb_encode(value) } else { value };
                    *out = quantize(value, one, range, dither, dither_noise([x, y], channel));
                }
            },
        );
    }
}

/// The random number of a pixel and channel for [`quantize`]: a hash of the place in the full frame, so it
/// does not depend on crops, buckets or order. Strictly between -1 and 1: with the usual dither of 0.5 a
/// whole value never changes, so full coverage stays full.
#[inline(always)]
pub fn dither_noise(pixel: [u32; 2], channel: u32) -> f32 {
    hash::signed_unit(hash::hash_all([pixel[0], pixel[1], channel]))
}

/// sRGB's curve from linear light, 0 to 1; linear below 0, going on above 1. Without branches, for loops over lanes.
#[inline(always)]
pub fn srgb_encode(linear: f32) -> f32 {
    let curve = 1.055 * function::pow_in_lanes(linear, 1.0 / 2.4) - 0.055;
    if linear > 0.003_130_8 { curve } else { 12.92 * linear }
}

/// Linear light from sRGB's curve, the inverse of [`srgb_encode`].
pub fn srgb_decode(encoded: f32) -> f32 {
    if encoded > 0.040_45 { function::pow((encoded + 0.055) / 1.055, 2.4) } else { encoded / 12.92 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn background_goes_under_then_exposure() {
        let half = [0.25, 0.0, 0.125, 0.5];
        assert_eq!(finish_pixel(half, None, [1.0, 1.0]), half);
        assert_eq!(finish_pixel(half, Some([1.0, 0.5, 0.0]), [1.0, 1.0]), [0.75, 0.25, 0.125, 1.0]);
        assert_eq!(finish_pixel(half, Some([0.0, 0.5, 0.0]), [4.0, 2.0]), [1.0, 1.0, 0.5f32.sqrt(), 1.0]);
        // Gain and gamma leave alpha alone; negative lobes stay negative.
        assert_eq!(finish_pixel([-0.25, 0.25, 0.0, 0.5], None, [1.0, 2.0]), [-0.5, 0.5, 0.0, 0.5]);
    }

    #[test]
    fn quantize_rounds_and_clamps() {
        let byte = |value| quantize(value, 255, [0, 255], 0.0, 0.0);
        assert_eq!([0.0, 0.5, 1.0, 2.0, -1.0].map(byte), [0, 128, 255, 255, 0]);
        assert_eq!([f32::NAN, f32::INFINITY, f32::NEG_INFINITY].map(byte), [0, 255, 0]);
        assert_eq!(quantize(0.7, 2048, [-1024, 3071], 0.0, 0.0), 1434);
        assert_eq!(quantize(-0.7, 2048, [-1024, 3071], 0.0, 0.0), -1024);
        assert_eq!(quantize(f32::INFINITY, 0, [0, 255], 0.5, 0.5), 0);
        assert_eq!(quantize(0.5, 255, [3, 2], 0.0, 0.0), 2);
    }

    #[test]
    fn rounding_is_that_of_the_standard_library() {
        let near = |x: f64| [x, f64::from_bits(x.to_bits() - 1), f64::from_bits(x.to_bits() + 1)];
        let halves = (1..2000).flat_map(|n| near(f64::from(n) * 0.5));
        let ends = [2_147_483_646.5, 2_147_483_647.0, 2_147_483_647.5, 2_147_483_648.0, 1e300, f64::INFINITY];
        for x in halves.chain(ends).chain([0.0, f64::NAN]) {
            assert_eq!((rounded(x), rounded(-x)), (x.round() as i32, (-x).round() as i32), "{x}");
        }
    }

    #[test]
    fn a_row_is_quantized_as_its_values_are() {
        let special = [0.0, 1.0, -0.5, 7.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.003_130_8];
        let values: Vec<f32> = (0..1000).map(|n| n as f32 / 997.0).chain(special).collect();
        for srgb in [false, true] {
            let row = RowQuantize { one: 255, range: [0, 255], dither: 0.5, srgb };
            let mut out = vec![-1; values.len()];
            row.run(&values, [3, 4], 2, &mut out);
            for ((&value, &out), x) in values.iter().zip(&out).zip(3..) {
                let encoded = if srgb { srgb_encode(value) } else { value };
                let wanted = quantize(encoded, 255, [0, 255], 0.5, dither_noise([x, 4], 2));
                assert_eq!(out, wanted, "{value}");
            }
        }
    }

    #[test]
    fn dither_keeps_whole_values_and_the_mean() {
        let draw =
            |value: f32, n: u32| quantize(value, 255, [0, 255], 0.5, dither_noise([n % 100, n / 100], 0));
        let mut sum = 0;
        for n in 0..10_000 {
            assert_eq!((draw(0.0, n), draw(1.0, n), draw(64.0 / 255.0, n)), (0, 255, 64));
            sum += draw(100.25 / 255.0, n);
        }
        let mean = f64::from(sum) / 1e4;
        assert!((mean - 100.25).abs() < 0.02, "mean {mean}");
        assert_ne!(dither_noise([1, 2], 0), dither_noise([1, 2], 1));
    }

    #[test]
    fn srgb_goes_there_and_back() {
        assert_eq!((srgb_encode(0.0), srgb_decode(0.0)), (0.0, 0.0));
        assert!((srgb_encode(1.0) - 1.0).abs() < 1e-6 && (srgb_decode(1.0) - 1.0).abs() < 1e-6);
        assert!((srgb_encode(0.214_041_14) - 0.5).abs() < 1e-6);
        for n in 0..=1000 {
            let value = n as f32 / 1000.0;
            assert!((srgb_decode(srgb_encode(value)) - value).abs() < 1e-6, "{value}");
        }
        for byte in 0..=255 {
            let linear = srgb_decode(byte as f32 / 255.0);
            assert_eq!(quantize(srgb_encode(linear), 255, [0, 255], 0.0, 0.0), byte);
        }
    }
}
