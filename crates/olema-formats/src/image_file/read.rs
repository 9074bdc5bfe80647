//! PNG files as pictures of bytes, and as heights with all bits that a file has.

use std::collections::TryReserveError;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek};
use std::path::Path;

use olema::image::Picture8;
use png::{BitDepth, ColorType, Transformations};

use super::ImageError;

/// Most pixels of a file that is read; the picture takes four bytes for each.
pub const MAX_PIXELS: u64 = 1 << 28;

/// Most pixels of an interlaced file, which is held twice before its rows are all there.
pub const MAX_INTERLACED_PIXELS: u64 = 1 << 26;

/// A number a pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct Heights {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// From 0 to 1, rows from the top: `width * height` numbers.
    pub values: Vec<f32>,
}

/// Reads a PNG file of any colour type and depth, 16 bits cut to 8, gray and palettes as RGB, opaque where it
/// has no alpha. The bytes stay on the file's own curve.
///
/// # Errors
/// [`ImageError`] where the file cannot be opened, is not a whole PNG, or has more than [`MAX_PIXELS`] pixels
/// ([`MAX_INTERLACED_PIXELS`] if interlaced). Memory grows only with what the file really holds.
pub fn read_png(path: &Path) -> Result<Picture8, ImageError> {
    decode_picture(path, open(path)?)
}

/// Reads a PNG file of any colour type as heights, 8 or 16 bits as the file has them: gray, or the mean of red, green
/// and blue. A height is not a colour, so no curve is undone; alpha plays no part.
///
/// # Errors
/// As [`read_png`], and for more than `max_pixels` pixels.
pub fn read_png_heights(path: &Path, max_pixels: u64) -> Result<Heights, ImageError> {
    decode_heights(path, open(path)?, max_pixels)
}

fn open(path: &Path) -> Result<File, ImageError> {
    File::open(path).map_err(|source| ImageError::Io { path: path.to_owned(), action: "open", source })
}

fn decode_picture(path: &Path, input: impl Read + Seek) -> Result<Picture8, ImageError> {
    let mut rgba = Vec::new();
    let with_alpha = Transformations::EXPAND | Transformations::ALPHA | Transformations::STRIP_16;
    let [width, height] = decode(path, input, MAX_PIXELS, with_alpha, |pixels, (color, _)| {
        let is_gray = color == ColorType::GrayscaleAlpha;
        rgba.try_reserve(if is_gray { 2 * pixels.len() } else { pixels.len() })?;
        if is_gray {
            pixels.chunks_exact(2).for_each(|p| rgba.extend([p[0], p[0], p[0], p[1]]));
        } else {
            rgba.extend_from_slice(pixels);
        }
        Ok(())
    })?;
    Ok(Picture8 { width, height, rgba })
}

fn decode_heights(path: &Path, input: impl Read + Seek, max_pixels: u64) -> Result<Heights, ImageError> {
    let mut values = Vec::new();
    let [width, height] =
        decode(path, input, max_pixels, Transformations::EXPAND, |pixels, (color, depth)| {
            let (num_channels, num_bytes) = (color.samples(), if depth == BitDepth::Sixteen { 2 } else { 1 });
            let num_heights = if num_channels < 3 { 1 } else { 3 };
            values.try_reserve(pixels.len() / (num_channels * num_bytes))?;
            // Sums of whole numbers, so that gray is the same whether a file has one channel of it or three.
            let number = |bytes: &[u8]| bytes.iter().fold(0, |number, byte| number << 8 | u32::from(*byte));
            let one = num_heights as f32 * if num_bytes == 2 { 65_535.0 } else { 255.0 };
            values.extend(pixels.chunks_exact(num_channels * num_bytes).map(|pixel| {
                let channels = pixel[..num_heights * num_bytes].chunks_exact(num_bytes);
                channels.map(number).sum::<u32>() as f32 / one
            }));
            Ok(())
        })?;
    Ok(Heights { width, height, values })
}

/// Gives the pixels of a file to `take`, row after row or all at once, and returns width and height.
fn decode(
    path: &Path,
    input: impl Read + Seek,
    max_pixels: u64,
    transformations: Transformations,
    mut take: impl FnMut(&[u8], (ColorType, BitDepth)) -> Result<(), TryReserveError>,
) -> Result<[u32; 2], ImageError> {
    let failed = |source| match source {
        png::DecodingError::IoError(source) if source.kind() != io::ErrorKind::UnexpectedEof => {
            ImageError::Io { path: path.to_owned(), action: "read", source }
        }
        source => ImageError::Decode { path: path.to_owned(), source },
    };
    let mut decoder = png::Decoder::new(BufReader::new(input));
    decoder.set_transformations(transformations);
    decoder.set_ignore_text_chunk(true);
    let mut reader = decoder.read_info().map_err(failed)?;
    let info = reader.info();
    let (width, height, interlaced) = (info.width, info.height, info.interlaced);
    let limit = if interlaced { MAX_INTERLACED_PIXELS } else { MAX_PIXELS }.min(max_pixels);
    if u64::from(width) * u64::from(height) > limit {
        return Err(ImageError::TooLarge { path: path.to_owned(), width, height, limit });
    }
    let kind = reader.output_color_type();
    let full = |_| failed(png::DecodingError::LimitsExceeded);
    if interlaced {
        let mut frame = vec![0; reader.output_buffer_size().unwrap_or(0)];
        reader.next_frame(&mut frame).map_err(failed)?;
        take(&frame, kind).map_err(full)?;
    } else {
        while let Some(row) = reader.next_row().map_err(failed)? {
            take(row.data(), kind).map_err(full)?;
        }
    }
    reader.finish().map_err(failed)?;
    Ok([width, height])
}

#[cfg(test)]
#[path = "read_tests.rs"]
mod tests;
