//! Pictures on disk, as the command asks for them.

use std::path::Path;

use olema::image::Picture8;
use olema::{Error, Image, Settings};
use olema_formats::image_file::{self, ImageError, PngMode, PngOptions, PngPicture};
use olema_formats::rib::{Display, Quantize};

use crate::exit::{self, Failure};

/// A picture that is to be at `path`, with the channels and the quantization of the scene's display.
///
/// # Errors
/// A memory failure where its bytes do not fit what was granted.
pub fn begin(path: &Path, settings: &Settings, display: Option<&Display>) -> Result<PngPicture, Failure> {
    let mut options = PngOptions { gamma: settings.exposure[1], ..PngOptions::default() };
    if let Some(display) = display {
        options.quantize = display.quantize;
        options.mode = if display.mode == "rgb" { PngMode::Rgb } else { PngMode::Rgba };
    }
    let picture = PngPicture::new(path, settings.window_px(), &options);
    let (needed, granted) = (picture.num_bytes(), settings.picture_memory);
    if needed > granted {
        return Err(Error::Memory { what: "the picture", needed, granted }.into());
    }
    Ok(picture)
}

/// Writes a picture whose rows were pushed, unless one of them could not be: `pushed` says so.
///
/// # Errors
/// A render failure that names the file.
pub fn finish(picture: &PngPicture, pushed: Result<(), ImageError>) -> Result<(), Failure> {
    pushed.and_then(|()| picture.write()).map_err(|e| failure(exit::RENDER, &e))
}

/// Writes opaque bytes as they are.
///
/// # Errors
/// A render failure that names the file.
pub fn write_bytes(path: &Path, picture: &Picture8) -> Result<(), Failure> {
    let frame = [picture.width, picture.height];
    let mut image = Image::new(frame, [0, frame[0], 0, frame[1]], &["r", "g", "b"]);
    for (ix, channel) in image.channels.iter_mut().enumerate() {
        let bytes = picture.rgba.iter().skip(ix).step_by(4);
        channel.values = bytes.map(|byte| f32::from(*byte) / 255.0).collect();
    }
    let quantize = Quantize { one: 255, min: 0, max: 255, dither: 0.0 };
    // Any gamma but 1 says that the values are on a display's curve already.
    let options = PngOptions { mode: PngMode::Rgb, quantize, gamma: 2.2 };
    image_file::write_png(path, &image, &options).map_err(|e| failure(exit::RENDER, &e))
}

/// Reads a picture.
///
/// # Errors
/// An asset failure that names the file.
pub fn read(path: &Path) -> Result<Picture8, Failure> {
    image_file::read_png(path).map_err(|e| failure(exit::SCENE, &e))
}

fn failure(code: u8, error: &ImageError) -> Failure {
    Failure::new(code, error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_back_as_they_were() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("all.png");
        let rgba = (0..=255).flat_map(|n: u8| [n, 255 - n, n / 2, 255]).collect();
        let picture = Picture8 { width: 16, height: 16, rgba };
        write_bytes(&path, &picture).unwrap();
        assert_eq!(read(&path).unwrap(), picture);
    }

    #[test]
    fn the_display_decides_on_alpha() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        let mut image = Image::new([1, 1], [0, 1, 0, 1], &["r", "g", "b", "a", "z"]);
        image.channels[3].values = vec![0.5];
        for (mode, alpha) in [("rgb", 255), ("rgba", 128)] {
            let quantize = Quantize { one: 255, min: 0, max: 255, dither: 0.0 };
            let display =
                Display { name: String::new(), driver: String::new(), mode: mode.to_owned(), quantize };
            let settings = Settings { resolution: [1, 1], ..Settings::default() };
            let mut picture = begin(&path, &settings, Some(&display)).unwrap();
            let pushed = picture.push(&image);
            finish(&picture, pushed).unwrap();
            assert_eq!(read(&path).unwrap().pixel(0, 0)[3], alpha);
        }
    }
}
