//! How far two pictures are apart, until the library says it (`olema::image::compare`, same names).

/// A picture of 8 bits a channel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture8 {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Red, green, blue, alpha of each pixel, rows from the top: `4 * width * height` bytes.
    pub rgba: Vec<u8>,
}

/// The difference of two pictures in steps of 1/255.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Largest difference of a channel's value.
    pub max: f64,
    /// Peak signal to noise ratio in decibels over all pixels and channels; infinite for equal pictures.
    pub psnr: f64,
    /// Pixels that differ in any channel.
    pub differing_pixels: u64,
    /// Pixels in all.
    pub num_pixels: u64,
}

/// Compares two pictures of bytes.
///
/// # Errors
/// Where the sizes differ.
pub fn compare(a: &Picture8, b: &Picture8) -> Result<Difference, String> {
    check_sizes(a, b)?;
    let (mut max, mut squares, mut differing_pixels) = (0u8, 0u64, 0);
    for (p, q) in a.rgba.chunks_exact(4).zip(b.rgba.chunks_exact(4)) {
        differing_pixels += u64::from(p != q);
        for (p, q) in p.iter().zip(q) {
            let step = p.abs_diff(*q);
            max = max.max(step);
            squares += u64::from(step) * u64::from(step);
        }
    }
    let mean = squares as f64 / a.rgba.len().max(1) as f64;
    let psnr = if squares == 0 { f64::INFINITY } else { 10.0 * (255.0 * 255.0 / mean).log10() };
    let num_pixels = u64::from(a.width) * u64::from(a.height);
    Ok(Difference { max: f64::from(max), psnr, differing_pixels, num_pixels })
}

/// A picture of the difference: each colour channel `gain` times the bytes' difference, at most 255. A
/// difference of alpha is added to all three; the picture itself is opaque.
///
/// # Errors
/// Where the sizes differ.
pub fn difference_picture(a: &Picture8, b: &Picture8, gain: u32) -> Result<Picture8, String> {
    check_sizes(a, b)?;
    let mut rgba = Vec::with_capacity(a.rgba.len());
    for (p, q) in a.rgba.chunks_exact(4).zip(b.rgba.chunks_exact(4)) {
        let step = |channel: usize| u32::from(p[channel].abs_diff(q[channel]));
        rgba.extend((0..3).map(|channel| ((step(channel) + step(3)) * gain).min(255) as u8));
        rgba.push(255);
    }
    Ok(Picture8 { width: a.width, height: a.height, rgba })
}

fn check_sizes(a: &Picture8, b: &Picture8) -> Result<(), String> {
    if [a.width, a.height] == [b.width, b.height] {
        return Ok(());
    }
    Err(format!("the pictures differ in size: {}x{} and {}x{} pixels", a.width, a.height, b.width, b.height))
}
