//! Pictures as files hold them: bytes, not multiplied by alpha.

/// A picture of 8 bits a channel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture8 {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Red, green, blue, alpha of each pixel, rows from the top: `4 * width * height` bytes. Encoded as the
    /// file says (sRGB as a rule), colour not multiplied by alpha.
    pub rgba: Vec<u8>,
}

impl Picture8 {
    /// A picture of that size in one colour.
    pub fn filled(width: u32, height: u32, rgba: [u8; 4]) -> Self {
        Picture8 { width, height, rgba: rgba.repeat(width as usize * height as usize) }
    }

    /// The pixel in that column and row.
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 4] {
        let start = 4 * (y as usize * self.width as usize + x as usize);
        [self.rgba[start], self.rgba[start + 1], self.rgba[start + 2], self.rgba[start + 3]]
    }
}
