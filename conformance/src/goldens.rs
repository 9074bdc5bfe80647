//! Goldens: small pictures that a change must not alter unless it says why.
//!
//! `OLEMA_BLESS=1 cargo test -p conformance` writes the pictures anew; the commit that does so gives the reason.
//! Pictures are the same bits on every machine, so the comparison is exact.

use std::path::PathBuf;

use olema::image::compare::compare;
use olema::{Hooks, Image, Renderer, Scene, Settings};
use olema_formats::image_file::{PngOptions, read_png, write_png};

/// Where the pictures are kept.
fn path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("goldens").join(format!("{name}.png"))
}

/// Renders `scene`.
///
/// # Errors
/// What the renderer says.
pub fn draw(scene: &Scene, settings: &Settings) -> Result<Image, olema::Error> {
    Ok(Renderer::new(settings.clone())?.render(scene, &Hooks::default())?.image)
}

/// All numbers of a picture, bit for bit.
pub fn bits(image: &Image) -> Vec<u32> {
    image.channels.iter().flat_map(|c| c.values.iter().map(|v| v.to_bits())).collect()
}

/// Compares `image`, written as a PNG without dither, with the golden of that name.
///
/// # Errors
/// How they differ, and where the new picture was put.
pub fn check(name: &str, image: &Image) -> Result<(), String> {
    let golden = path(name);
    let mut options = PngOptions::default();
    options.quantize.dither = 0.0;
    if std::env::var_os("OLEMA_BLESS").is_some() {
        return write_png(&golden, image, &options).map_err(|e| e.to_string());
    }
    let new = std::env::temp_dir().join(format!("olema-golden-{}-{name}.png", std::process::id()));
    write_png(&new, image, &options).map_err(|e| e.to_string())?;
    let (expected, found) = (read_png(&golden), read_png(&new));
    let (expected, found) = (expected.map_err(|e| e.to_string())?, found.map_err(|e| e.to_string())?);
    let difference = compare(&expected, &found).map_err(|e| format!("{name}: {e:?}"))?;
    if difference.differing_pixels == 0 {
        // Only a picture that differs is worth keeping; a leftover in the temporary folder harms nobody.
        let _ = std::fs::remove_file(&new);
        return Ok(());
    }
    Err(format!("{name}: {difference:?}; the new picture is {}", new.display()))
}
