//! Pictures: channels of floats, reconstruction filters, exposure and quantization.

pub mod compare;
mod filter;
mod finish;
mod picture;

pub use filter::{Filter, FilterKind};
pub use finish::{RowQuantize, dither_noise, finish_pixel, quantize, srgb_decode, srgb_encode};
pub use picture::Picture8;

/// A picture: planar channels over a window of the full frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Width and height of the full frame in pixels.
    pub frame_px: [u32; 2],
    /// The part that is here: `[x0, x1, y0, y1]`, end exclusive.
    pub window_px: [u32; 4],
    /// Channels, each of width * height values, rows from the top.
    pub channels: Vec<Channel>,
}

/// One channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// "r", "g", "b" (linear, multiplied by alpha), "a" (coverage, 0 to 1), "z" (depth in camera space of the
    /// nearest sample, infinite where nothing is).
    pub name: String,
    /// Values, row after row.
    pub values: Vec<f32>,
}

impl Image {
    /// A picture of that window with all channels 0.
    pub fn new(frame_px: [u32; 2], window_px: [u32; 4], names: &[&str]) -> Self {
        let [x0, x1, y0, y1] = window_px;
        let len = (x1 - x0) as usize * (y1 - y0) as usize;
        let channels =
            names.iter().map(|n| Channel { name: (*n).to_owned(), values: vec![0.0; len] }).collect();
        Image { frame_px, window_px, channels }
    }

    /// Width of the window in pixels.
    pub fn width(&self) -> usize {
        (self.window_px[1] - self.window_px[0]) as usize
    }

    /// Height of the window in pixels.
    pub fn height(&self) -> usize {
        (self.window_px[3] - self.window_px[2]) as usize
    }

    /// A copy of the part within `window_px`, which must lie in this picture's own window.
    pub fn part(&self, window_px: [u32; 4]) -> Image {
        let [x0, x1, y0, y1] = window_px;
        let width = self.width();
        let [own_x, _, own_y, _] = self.window_px;
        let copy = |channel: &Channel| Channel {
            name: channel.name.clone(),
            values: (y0..y1)
                .flat_map(|y| {
                    let first = (y - own_y) as usize * width + (x0 - own_x) as usize;
                    channel.values[first..first + (x1 - x0) as usize].iter().copied()
                })
                .collect(),
        };
        Image { frame_px: self.frame_px, window_px, channels: self.channels.iter().map(copy).collect() }
    }

    /// The channel of that name.
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|c| c.name == name)
    }
}
