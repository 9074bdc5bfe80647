//! How far two pictures are from each other.
//!
//! In: two pictures of one size. Out: the figures of their difference, or a picture of it. Bytes are compared
//! as bytes, floats as floats; no channel is weighted, and colour counts also where alpha is 0.

use super::{Channel, Image, Picture8};
use crate::math::function;

/// The difference of two pictures, in the unit of their values: steps of 1/255 for bytes, 1 for floats.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Largest difference of a channel's value.
    pub max: f64,
    /// Mean of the absolute differences over all pixels and channels.
    pub mean: f64,
    /// Peak signal to noise ratio in decibels over all pixels and channels, the peak being 255 for bytes and
    /// 1 for floats; infinite for equal pictures.
    pub psnr: f64,
    /// Pixels that differ in any channel.
    pub differing_pixels: u64,
    /// Pixels in all.
    pub num_pixels: u64,
}

/// Why two pictures cannot be compared.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CompareError {
    /// They have different sizes.
    #[error("the pictures differ in size: {}x{} and {}x{} pixels", a[0], a[1], b[0], b[1])]
    Size {
        /// Width and height of the first.
        a: [usize; 2],
        /// Of the second.
        b: [usize; 2],
    },
    /// One lacks a channel.
    #[error("a picture has no channel \"{0}\"")]
    Channel(String),
}

/// Running sums of a comparison.
#[derive(Default)]
struct Sums {
    max: f64,
    absolute: f64,
    squared: f64,
    values: u64,
}

impl Sums {
    /// Counts one value's difference; `f64::INFINITY` where only one is a number.
    fn add(&mut self, difference: f64) {
        self.max = self.max.max(difference);
        self.absolute += difference;
        self.squared += difference * difference;
        self.values += 1;
    }

    fn finish(self, peak: f64, differing_pixels: u64, num_pixels: u64) -> Difference {
        let values = self.values.max(1) as f64;
        let psnr = if self.squared == 0.0 {
            f64::INFINITY
        } else {
            10.0 / std::f64::consts::LN_10 * function::ln64(peak * peak * values / self.squared)
        };
        Difference { max: self.max, mean: self.absolute / values, psnr, differing_pixels, num_pixels }
    }
}

/// Compares two pictures of bytes.
///
/// # Errors
/// [`CompareError::Size`] where the sizes differ.
pub fn compare(a: &Picture8, b: &Picture8) -> Result<Difference, CompareError> {
    check_sizes(a, b)?;
    let mut sums = Sums::default();
    let mut differing = 0;
    for (pa, pb) in a.rgba.chunks_exact(4).zip(b.rgba.chunks_exact(4)) {
        differing += u64::from(pa != pb);
        pa.iter().zip(pb).for_each(|(va, vb)| sums.add(f64::from(va.abs_diff(*vb))));
    }
    Ok(sums.finish(255.0, differing, u64::from(a.width) * u64::from(a.height)))
}

/// Compares the named channels of two pictures of floats. Equal infinities and two not-a-numbers are no
/// difference; a value against an infinity or a not-a-number is an infinite one.
///
/// # Errors
/// [`CompareError`] where the windows' sizes differ or a channel is missing.
pub fn compare_images(a: &Image, b: &Image, channels: &[&str]) -> Result<Difference, CompareError> {
    let (size_a, size_b) = ([a.width(), a.height()], [b.width(), b.height()]);
    if size_a != size_b {
        return Err(CompareError::Size { a: size_a, b: size_b });
    }
    let pairs: Vec<(&Channel, &Channel)> = channels
        .iter()
        .map(|name| {
            a.channel(name).zip(b.channel(name)).ok_or_else(|| CompareError::Channel((*name).to_owned()))
        })
        .collect::<Result<_, _>>()?;
    let mut sums = Sums::default();
    let mut differing = 0;
    let num_pixels = size_a[0] * size_a[1];
    for ix in 0..num_pixels {
        let mut differs = false;
        for (ca, cb) in &pairs {
            let difference = distance(ca.values[ix], cb.values[ix]);
            differs |= difference != 0.0;
            sums.add(difference);
        }
        differing += u64::from(differs);
    }
    Ok(sums.finish(1.0, differing, num_pixels as u64))
}

fn distance(a: f32, b: f32) -> f64 {
    if a == b || a.is_nan() && b.is_nan() {
        0.0
    } else if a.is_finite() && b.is_finite() {
        (f64::from(a) - f64::from(b)).abs()
    } else {
        f64::INFINITY
    }
}

/// A picture of the difference: each colour channel `gain` times the bytes' difference, at most 255. A
/// difference of alpha is added to all three; the picture itself is opaque.
///
/// # Errors
/// [`CompareError::Size`] where the sizes differ.
pub fn difference_picture(a: &Picture8, b: &Picture8, gain: u32) -> Result<Picture8, CompareError> {
    check_sizes(a, b)?;
    let mut rgba = Vec::with_capacity(a.rgba.len());
    for (pa, pb) in a.rgba.chunks_exact(4).zip(b.rgba.chunks_exact(4)) {
        let step = |channel: usize| u32::from(pa[channel].abs_diff(pb[channel]));
        rgba.extend((0..3).map(|channel| (step(channel) + step(3)).saturating_mul(gain).min(255) as u8));
        rgba.push(255);
    }
    Ok(Picture8 { width: a.width, height: a.height, rgba })
}

fn check_sizes(a: &Picture8, b: &Picture8) -> Result<(), CompareError> {
    let size = |p: &Picture8| [p.width as usize, p.height as usize];
    if size(a) == size(b) && a.rgba.len() == b.rgba.len() {
        Ok(())
    } else {
        Err(CompareError::Size { a: size(a), b: size(b) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture() -> Picture8 {
        let mut picture = Picture8::filled(8, 4, [10, 20, 30, 255]);
        picture.rgba.iter_mut().enumerate().for_each(|(n, v)| *v = v.wrapping_add(n as u8));
        picture
    }

    #[test]
    fn equal_pictures_do_not_differ() {
        let wanted =
            Difference { max: 0.0, mean: 0.0, psnr: f64::INFINITY, differing_pixels: 0, num_pixels: 32 };
        assert_eq!(compare(&picture(), &picture()), Ok(wanted));
        assert_eq!(
            difference_picture(&picture(), &picture(), 16),
            Ok(Picture8::filled(8, 4, [0, 0, 0, 255]))
        );
    }

    #[test]
    fn one_step_in_one_channel_is_found_wherever_it_is() {
        // A comparison that never fails would pass every test that uses it.
        for ix in 0..picture().rgba.len() {
            let mut other = picture();
            other.rgba[ix] ^= 1;
            let found = compare(&picture(), &other).unwrap();
            assert_eq!((found.max, found.differing_pixels, found.mean), (1.0, 1, 1.0 / 128.0));
            assert!((found.psnr - 10.0 * (255.0f64 * 255.0 * 128.0).log10()).abs() < 1e-9);
            assert_eq!(compare(&other, &picture()), Ok(found));
            let marked = difference_picture(&picture(), &other, 16).unwrap();
            assert_eq!(marked.rgba.chunks_exact(4).filter(|p| p[..3] != [0; 3]).count(), 1);
        }
    }

    #[test]
    fn figures_are_the_definitions() {
        let (a, b) = (Picture8::filled(1, 2, [0, 0, 0, 255]), Picture8::filled(1, 2, [4, 0, 12, 255]));
        let found = compare(&a, &b).unwrap();
        assert_eq!((found.max, found.mean, found.differing_pixels, found.num_pixels), (12.0, 4.0, 2, 2));
        // Mean square 40.
        assert!((found.psnr - 10.0 * (65_025.0f64 / 40.0).log10()).abs() < 1e-9);
        assert_eq!(difference_picture(&a, &b, 30).unwrap().pixel(0, 1), [120, 0, 255, 255]);
    }

    #[test]
    fn floats_compare_with_infinities_and_lacking_channels() {
        let mut a = Image::new([4, 4], [1, 3, 1, 2], &["r", "z"]);
        a.channels[1].values = vec![f32::INFINITY, f32::NAN];
        let mut b = a.clone();
        assert_eq!(compare_images(&a, &b, &["r", "z"]).unwrap().max, 0.0);
        b.channels[0].values[1] = 0.5;
        let found = compare_images(&a, &b, &["r"]).unwrap();
        assert_eq!((found.max, found.mean, found.differing_pixels, found.num_pixels), (0.5, 0.25, 1, 2));
        assert!((found.psnr - 10.0 * 8f64.log10()).abs() < 1e-9);
        b.channels[1].values[0] = 1.0;
        let found = compare_images(&a, &b, &["r", "z"]).unwrap();
        assert_eq!((found.max, found.psnr, found.differing_pixels), (f64::INFINITY, f64::NEG_INFINITY, 2));
        assert_eq!(compare_images(&a, &b, &["g"]), Err(CompareError::Channel("g".to_owned())));
    }

    #[test]
    fn sizes_must_agree() {
        let (a, b) = (Picture8::filled(2, 3, [0; 4]), Picture8::filled(3, 2, [0; 4]));
        let error = compare(&a, &b).unwrap_err();
        assert_eq!(error.to_string(), "the pictures differ in size: 2x3 and 3x2 pixels");
        assert!(difference_picture(&a, &b, 1).is_err());
        let images = [[0, 2, 0, 3], [0, 3, 0, 2]].map(|window| Image::new([4, 4], window, &["r"]));
        assert!(compare_images(&images[0], &images[1], &["r"]).is_err());
    }
}
