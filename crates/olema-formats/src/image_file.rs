//! Image files: PNG with 8 bits a channel.
//!
//! In: an [`Image`] after exposure (colour multiplied by alpha). Out: a file that is whole or not there. And
//! back: a file as a [`Picture8`](olema::image::Picture8), or as [`Heights`]. Sources: PNG specification, third edition, sections 6.2 (alpha) and 11.3
//! (colour); RenderMan Interface 3.2, section 4.2 (`Quantize`).
//!
//! **Which curve the bytes are on.** PNG viewers take bytes as sRGB. Where `Exposure` has gamma 1 the image is
//! linear: bytes get the sRGB curve, and the file says so (`sRGB` chunk). Where `Exposure` applies a gamma of
//! its own, a second curve would brighten the picture twice: bytes are the values as they are, and the file
//! carries `gAMA` = 1/gamma, which is what they are. A viewer that heeds it shows the scene's light, one that
//! ignores it shows the bytes as the scene's author prepared them for a display; either way one curve is
//! undone once.
//!
//! **Alpha.** PNG holds colour that is not multiplied by alpha, so each colour is divided by it in linear light:
//! with a gamma g that is a division by alpha^(1/g) (see [`finish_pixel`](olema::image::finish_pixel)). Without
//! an alpha channel, colours stay multiplied: the picture over black.

mod read;

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use olema::Image;
use olema::image::RowQuantize;
use olema::math::function;

use crate::rib::Quantize;
pub use read::{Heights, MAX_INTERLACED_PIXELS, MAX_PIXELS, read_png, read_png_heights};

/// An image file could not be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The file system says no.
    #[error("{}: cannot {action}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What was tried: "create", "write", "rename", "open", "read".
        action: &'static str,
        /// The system's word.
        source: io::Error,
    },
    /// The bytes are not a PNG that can be read.
    #[error("{}: not a readable PNG file: {source}", path.display())]
    Decode {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: png::DecodingError,
    },
    /// The picture cannot be held by a PNG file.
    #[error("{}: cannot encode: {source}", path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: png::EncodingError,
    },
    /// The file claims to be larger than what is read.
    #[error("{}: {width}x{height} pixels are too many: expected at most {limit}", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Width it claims.
        width: u32,
        /// Height it claims.
        height: u32,
        /// Most pixels.
        limit: u64,
    },
    /// The image lacks a channel that the file needs, or has not as many values as pixels.
    #[error("{}: the image has no channel \"{channel}\" of {expected} values", path.display())]
    Channel {
        /// The file.
        path: PathBuf,
        /// The channel.
        channel: &'static str,
        /// Pixels of the window.
        expected: usize,
    },
}

/// Channels of a PNG file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PngMode {
    /// Red, green, blue: the picture over black.
    Rgb,
    /// Red, green, blue, alpha; colour not multiplied by alpha.
    #[default]
    Rgba,
}

/// How a PNG file is written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PngOptions {
    /// Channels.
    pub mode: PngMode,
    /// Quantization. A file of 8 bits holds no more than 0 to 255: where `one` is 0 (floats) or `max` above
    /// 255, one 255 and the range 0 to 255 are used instead, with the same dither.
    pub quantize: Quantize,
    /// Gamma that `Exposure` applied to the image; 1 is linear.
    pub gamma: f32,
}

impl Default for PngOptions {
    fn default() -> Self {
        let quantize = Quantize { one: 255, min: 0, max: 255, dither: 0.5 };
        PngOptions { mode: PngMode::default(), quantize, gamma: 1.0 }
    }
}

/// Writes the window of an image as a PNG file.
///
/// The file is written under a temporary name in the same directory and then renamed: it is never half there,
/// and an older one of that name stays until then. Where `path` is a link, the file it leads to is replaced;
/// where it is a device or a pipe, it is written to directly. Negative values become 0, not-a-number 0,
/// infinity 255. The dither depends on the place in the full frame only.
///
/// # Errors
/// [`ImageError`]; the temporary file is removed then.
pub fn write_png(path: &Path, image: &Image, options: &PngOptions) -> Result<(), ImageError> {
    let mut picture = PngPicture::new(path, image.window_px, options);
    picture.push(image)?;
    picture.write()
}

/// A PNG file on its way: takes rows as they come, as bytes.
#[derive(Debug)]
pub struct PngPicture {
    path: PathBuf,
    size: [u32; 2],
    options: PngOptions,
    bytes: Vec<u8>,
}

impl PngPicture {
    /// A picture of the window `[x0, x1, y0, y1]` that is to be at `path`, without rows yet.
    pub fn new(path: &Path, window_px: [u32; 4], options: &PngOptions) -> Self {
        let [x0, x1, y0, y1] = window_px;
        PngPicture { path: path.to_owned(), size: [x1 - x0, y1 - y0], options: *options, bytes: Vec::new() }
    }

    /// Bytes of the whole picture.
    pub fn num_bytes(&self) -> u64 {
        let channels = if self.options.mode == PngMode::Rgba { 4 } else { 3 };
        u64::from(self.size[0]) * u64::from(self.size[1]) * channels
    }

    /// Appends the next rows, from the top.
    ///
    /// # Errors
    /// [`ImageError::Channel`].
    pub fn push(&mut self, rows: &Image) -> Result<(), ImageError> {
        self.bytes.reserve_exact((self.num_bytes() as usize).saturating_sub(self.bytes.len()));
        append_bytes(&self.path, rows, &self.options, &mut self.bytes)
    }

    /// Writes the file, as [`write_png`] says.
    ///
    /// # Errors
    /// [`ImageError`]; the temporary file is removed then.
    pub fn write(&self) -> Result<(), ImageError> {
        let PngPicture { path, size, options, bytes } = self;
        replace_file(path, |file| encode(path, file, *size, bytes, options))
    }
}

/// Appends the file's samples, rows from the top.
fn append_bytes(
    path: &Path,
    image: &Image,
    options: &PngOptions,
    bytes: &mut Vec<u8>,
) -> Result<(), ImageError> {
    let expected = image.width() * image.height();
    let channel = |channel: &'static str| {
        let found = image.channel(channel).filter(|c| c.values.len() == expected);
        found.map(|c| c.values.as_slice()).ok_or_else(|| ImageError::Channel {
            path: path.to_owned(),
            channel,
            expected,
        })
    };
    let rgb = [channel("r")?, channel("g")?, channel("b")?];
    let alpha = match options.mode {
        PngMode::Rgb => None,
        PngMode::Rgba => Some(channel("a")?),
    };
    if expected == 0 {
        return Ok(());
    }
    let quantize = row_quantize(options);
    let num_channels = if alpha.is_some() { 4 } else { 3 };
    let mut straight = vec![0.0; image.width()];
    let [mut integers, mut coverage] = [(); 2].map(|()| vec![0; image.width()]);
    for (y, start) in (image.window_px[2]..).zip((0..expected).step_by(image.width())) {
        let row = start..start + image.width();
        let first_byte = bytes.len();
        bytes.resize(first_byte + num_channels * image.width(), 0);
        let pixel = [image.window_px[0], y];
        let mut put = |channel: usize, integers: &[i32]| {
            let of_channel = bytes[first_byte + channel..].iter_mut().step_by(num_channels);
            of_channel.zip(integers).for_each(|(byte, integer)| *byte = *integer as u8);
        };
        let alpha = alpha.map(|alpha| &alpha[row.clone()]);
        if let Some(alpha) = alpha {
            RowQuantize { srgb: false, ..quantize }.run(alpha, pixel, 3, &mut coverage);
            put(3, &coverage);
        }
        for (channel, values) in rgb.iter().enumerate() {
            let values = &values[row.clone()];
            let values = match alpha {
                None => values,
                Some(alpha) => {
                    unmultiply(values, alpha, &coverage, options.gamma, &mut straight);
                    &straight
                }
            };
            quantize.run(values, pixel, channel as u32, &mut integers);
            put(channel, &integers);
        }
    }
    Ok(())
}

/// Values of bytes.
fn row_quantize(options: &PngOptions) -> RowQuantize {
    let given = options.quantize;
    let is_bytes = given.one != 0 && given.max <= 255;
    let (one, range) = if is_bytes { (given.one, [given.min, given.max]) } else { (255, [0, 255]) };
    RowQuantize {
        one,
        range: range.map(|end| end.clamp(0, 255)),
        dither: given.dither,
        srgb: options.gamma == 1.0,
    }
}

/// Colour that is not multiplied by alpha any more; `coverage` is the byte of alpha.
fn unmultiply(values: &[f32], alpha: &[f32], coverage: &[i32], gamma: f32, straight: &mut [f32]) {
    for (((straight, value), &alpha), &byte) in straight.iter_mut().zip(values).zip(alpha).zip(coverage) {
        *straight = match byte {
            // Nothing can be seen of it, and dividing would only magnify rounding.
            0 => 0.0,
            _ if gamma == 1.0 => value / alpha,
            _ => value / function::pow(alpha, 1.0 / gamma),
        };
    }
}

fn encode(
    path: &Path,
    file: &mut dyn Write,
    [width, height]: [u32; 2],
    bytes: &[u8],
    options: &PngOptions,
) -> Result<(), ImageError> {
    let mut encoder = png::Encoder::new(BufWriter::new(file), width, height);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_color(match options.mode {
        PngMode::Rgb => png::ColorType::Rgb,
        PngMode::Rgba => png::ColorType::Rgba,
    });
    let file_gamma = 1.0 / options.gamma;
    if options.gamma == 1.0 {
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    } else if (1e-4..1e4).contains(&file_gamma) {
        encoder.set_source_gamma(png::ScaledFloat::new(file_gamma));
    }
    // The default takes ten times as long, for files a seventh to a quarter smaller.
    encoder.set_compression(png::Compression::Fast);
    encoder
        .write_header()
        .and_then(|mut writer| {
            writer.write_image_data(bytes)?;
            writer.finish()
        })
        .map_err(|source| match source {
            png::EncodingError::IoError(source) => {
                ImageError::Io { path: path.to_owned(), action: "write", source }
            }
            source => ImageError::Encode { path: path.to_owned(), source },
        })
}

/// Has `write` fill a temporary file beside `path`, then gives it that name.
fn replace_file(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> Result<(), ImageError>,
) -> Result<(), ImageError> {
    let failed = |action| move |source| ImageError::Io { path: path.to_owned(), action, source };
    let target = match fs::metadata(path) {
        Ok(found) if found.is_file() => fs::canonicalize(path).map_err(failed("open"))?,
        Ok(found) if found.is_dir() => {
            return Err(failed("write")(io::ErrorKind::IsADirectory.into()));
        }
        Ok(_) => return write(&mut OpenOptions::new().write(true).open(path).map_err(failed("open"))?),
        Err(_) => path.to_owned(),
    };
    let (temporary, mut file) = create_beside(&target).map_err(failed("create"))?;
    let result = write(&mut file)
        .and_then(|()| file.sync_all().map_err(failed("write")))
        .and_then(|()| fs::rename(&temporary, &target).map_err(failed("rename")));
    if result.is_err() {
        // The first error is the one to tell; a file that cannot be removed either adds nothing to it.
        let _ = fs::remove_file(&temporary);
    }
    result
}

/// Creates a new file in the directory of `target`, under a short name that does not depend on it: one made
/// longer might be too long for the file system.
fn create_beside(target: &Path) -> io::Result<(PathBuf, File)> {
    let mut number = 0;
    loop {
        let path = target.with_file_name(format!(".olema-{}-{number}.part", std::process::id()));
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(file) => return Ok((path, file)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && number < 10_000 => number += 1,
            Err(error) => return Err(error),
        }
    }
}

#[cfg(test)]
#[path = "image_file_tests.rs"]
mod tests;
