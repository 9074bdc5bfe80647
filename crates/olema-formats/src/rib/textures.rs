//! Images that shaders name: found along the search path, read once, charged to the memory account.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use olema::shading::TextureImage;

use crate::image_file::read_png_heights;

/// Most texels of an image.
const MAX_TEXELS: u64 = 1 << 26;

/// Bytes a texel while it is read: a height, at most eight of an interlaced file and, with the pyramid, four thirds of
/// a height.
const READ_COST: u64 = 18;

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
        let heights = read_png_heights(path, limit).map_err(|e| format!("image \"{name}\": {e}"))?;
        let num_texels = heights.values.len() as u64;
        let image = TextureImage::new(heights.width as usize, heights.height as usize, &heights.values);
        let image = Arc::new(image.map_err(|e| format!("image \"{name}\": {e}"))?);
        self.read.insert(path.clone(), image.clone());
        Ok((image, num_texels * KEPT_COST))
    }
}
