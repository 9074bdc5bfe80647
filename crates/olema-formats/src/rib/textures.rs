//! Images that shaders name: found along the search path, read once, charged to the memory account.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use olema::image::Picture8;
use olema::shading::TextureImage;

use crate::image_file::read_png_within;

/// Most texels of an image.
const MAX_TEXELS: u64 = 1 << 26;

/// Bytes a texel while it is read: four of the file and, with the pyramid, four thirds of four.
const READ_COST: u64 = 10;

/// Bytes a texel afterwards.
const KEPT_COST: u64 = 6;

/// The images read so far.
#[derive(Debug, Default)]
pub struct Textures {
    read: HashMap<PathBuf, Arc<TextureImage>>,
}

impl Textures {
    /// The image `name`, which is the first of the files `tried` that there is, and the bytes that it takes up anew;
    /// `room` bytes are left.
    ///
    /// # Errors
    /// A sentence.
    pub fn find(
        &mut self,
        name: &str,
        tried: &[PathBuf],
        room: u64,
    ) -> Result<(Arc<TextureImage>, u64), String> {
        let Some(path) = tried.iter().find(|p| p.is_file()) else {
            return Err(format!("image \"{name}\" is not in any of the {} places searched", tried.len()));
        };
        if let Some(image) = self.read.get(path) {
            return Ok((image.clone(), 0));
        }
        let limit = MAX_TEXELS.min(room / READ_COST);
        let picture = read_png_within(path, limit).map_err(|e| format!("image \"{name}\": {e}"))?;
        let texels = u64::from(picture.width) * u64::from(picture.height);
        let image = Arc::new(heights(&picture).map_err(|e| format!("image \"{name}\": {e}"))?);
        self.read.insert(path.clone(), image.clone());
        Ok((image, texels * KEPT_COST))
    }
}

/// Bytes as heights, 0 to 1: the mean of red, green and blue. A height is not a colour, so no curve is undone; alpha
/// plays no part.
fn heights(picture: &Picture8) -> Result<TextureImage, olema::Error> {
    let height = |p: &[u8; 4]| (u16::from(p[0]) + u16::from(p[1]) + u16::from(p[2])) as f32 / 765.0;
    let texels = picture.rgba.as_chunks().0.iter().map(height).collect();
    TextureImage::new(picture.width as usize, picture.height as usize, texels)
}
