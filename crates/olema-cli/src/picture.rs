//! Pictures on disk: PNG with 8 bits a channel, colour and alpha.

use std::fs::File;
use std::io::{BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};

use olema::{Image, Settings};
use olema_formats::rib::Display;

use crate::compare::Picture8;
use crate::exit::{self, Failure};

/// Bytes of pixels that a PNG may unpack to: 16384 x 16384.
const LARGEST: usize = 4 << 28;

/// Writes a rendered picture under a temporary name and renames it.
///
/// # Errors
/// A render failure with the system's word; the temporary file is gone then.
pub fn write(
    path: &Path,
    image: &Image,
    _settings: &Settings,
    _display: Option<&Display>,
) -> Result<(), Failure> {
    let (width, height) = (image.width() as u32, image.height() as u32);
    let mut bytes = vec![0; 4 * image.width() * image.height()];
    for (ix, name) in ["r", "g", "b", "a"].into_iter().enumerate() {
        let values = image.channel(name).map(|c| c.values.as_slice()).unwrap_or_default();
        for (byte, value) in bytes.iter_mut().skip(ix).step_by(4).zip(values) {
            *byte = (value.clamp(0.0, 1.0) * 255.0).round() as u8;
        }
    }
    write_picture8(path, &Picture8 { width, height, rgba: bytes })
}

/// Writes 8-bit pixels under a temporary name and renames it.
///
/// # Errors
/// As [`write`].
pub fn write_picture8(path: &Path, picture: &Picture8) -> Result<(), Failure> {
    let temporary = temporary_name(path);
    let encode = || -> Result<(), Box<dyn std::error::Error>> {
        let mut file = BufWriter::new(File::create(&temporary)?);
        let mut encoder = png::Encoder::new(&mut file, picture.width, picture.height);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&picture.rgba)?;
        writer.finish()?;
        file.flush()?;
        drop(file);
        std::fs::rename(&temporary, path)?;
        Ok(())
    };
    encode().map_err(|error| {
        let _ = std::fs::remove_file(&temporary);
        Failure::new(exit::RENDER, format!("{}: {error}", path.display()))
    })
}

/// Reads a PNG of any depth and kind of colour as 8-bit RGBA.
///
/// # Errors
/// An asset failure that names the file.
pub fn read(path: &Path) -> Result<Picture8, Failure> {
    let decode = || -> Result<Picture8, Box<dyn std::error::Error>> {
        let mut decoder = png::Decoder::new(BufReader::new(File::open(path)?));
        decoder
            .set_transformations(png::Transformations::normalize_to_color8() | png::Transformations::ALPHA);
        decoder.set_limits(png::Limits { bytes: LARGEST });
        let mut reader = decoder.read_info()?;
        let size = reader.output_buffer_size().filter(|s| *s <= LARGEST).ok_or("the picture is too large")?;
        let mut data = vec![0; size];
        let info = reader.next_frame(&mut data)?;
        data.truncate(info.buffer_size());
        let rgba = match info.color_type {
            png::ColorType::Rgba => data,
            png::ColorType::GrayscaleAlpha => {
                data.chunks_exact(2).flat_map(|ga| [ga[0], ga[0], ga[0], ga[1]]).collect()
            }
            other => return Err(format!("expected colour or grey, found {other:?}").into()),
        };
        Ok(Picture8 { width: info.width, height: info.height, rgba })
    };
    decode().map_err(|error| {
        Failure::new(exit::SCENE, format!("{}: cannot be read as PNG: {error}", path.display()))
    })
}

/// Beside the picture, so that the rename stays on one file system.
fn temporary_name(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(format!(".{}.tmp", std::process::id()));
    PathBuf::from(name)
}
