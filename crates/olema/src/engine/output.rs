//! The picture as it grows: tiles go in, finished output buckets come out.

use crate::error::Error;
use crate::image::Image;
use crate::pipeline::resolve::Pixel;
use crate::sampling::Region;
use crate::settings::Settings;

/// Channels of every picture.
pub(super) const CHANNELS: [&str; 5] = ["r", "g", "b", "a", "z"];

/// Collects tiles.
pub(super) struct Output {
    image: Image,
    bucket: [u32; 2],
    /// Pixels missing from each bucket, row by row.
    missing: Vec<u32>,
}

impl Output {
    /// An empty picture.
    ///
    /// # Errors
    /// [`Error::Memory`] where it does not fit what was granted.
    pub fn new(settings: &Settings) -> Result<Self, Error> {
        let window = settings.window_px();
        let [width, height] = [window[1] - window[0], window[3] - window[2]];
        let needed = u64::from(width) * u64::from(height) * 4 * CHANNELS.len() as u64;
        let granted = settings.picture_memory;
        if needed > granted {
            return Err(Error::Memory { what: "the picture", needed, granted });
        }
        let bucket = [settings.bucket[0].min(width), settings.bucket[1].min(height)];
        let mut output =
            Output { image: Image::new(settings.resolution, window, &CHANNELS), bucket, missing: Vec::new() };
        let [columns, rows] = output.num_buckets();
        for row in 0..rows {
            for column in 0..columns {
                let [x0, x1, y0, y1] = output.bucket_window(column, row);
                output.missing.push((x1 - x0) * (y1 - y0));
            }
        }
        Ok(output)
    }

    fn num_buckets(&self) -> [u32; 2] {
        let [x0, x1, y0, y1] = self.image.window_px;
        [(x1 - x0).div_ceil(self.bucket[0]), (y1 - y0).div_ceil(self.bucket[1])]
    }

    fn bucket_window(&self, column: u32, row: u32) -> [u32; 4] {
        let [x0, x1, y0, y1] = self.image.window_px;
        let (left, top) = (x0 + column * self.bucket[0], y0 + row * self.bucket[1]);
        [left, x1.min(left + self.bucket[0]), top, y1.min(top + self.bucket[1])]
    }

    /// Puts a tile's pixels in place and returns the buckets that are whole now.
    pub fn put(&mut self, tile: Region, pixels: &[Pixel]) -> Vec<Image> {
        let [wx0, _, wy0, _] = self.image.window_px;
        let width = self.image.width();
        for (row, line) in pixels.chunks_exact(tile.width()).enumerate() {
            let first = (tile.y0 as usize - wy0 as usize + row) * width + (tile.x0 as usize - wx0 as usize);
            for (c, channel) in self.image.channels.iter_mut().enumerate() {
                for (value, pixel) in channel.values[first..first + tile.width()].iter_mut().zip(line) {
                    *value = pixel[c];
                }
            }
        }
        self.finished_buckets(tile)
    }

    fn finished_buckets(&mut self, tile: Region) -> Vec<Image> {
        let [wx0, _, wy0, _] = self.image.window_px.map(|px| px as i32);
        let [bw, bh] = self.bucket.map(|px| px as i32);
        let columns = self.num_buckets()[0];
        let mut finished = Vec::new();
        for row in (tile.y0 - wy0) / bh..=(tile.y1 - 1 - wy0) / bh {
            for column in (tile.x0 - wx0) / bw..=(tile.x1 - 1 - wx0) / bw {
                let window = self.bucket_window(column as u32, row as u32);
                let [x0, x1, y0, y1] = window.map(|px| px as i32);
                let shared = (x1.min(tile.x1) - x0.max(tile.x0)) * (y1.min(tile.y1) - y0.max(tile.y0));
                let missing = &mut self.missing[(row as u32 * columns + column as u32) as usize];
                *missing -= shared as u32;
                if *missing == 0 {
                    finished.push(self.image.part(window));
                }
            }
        }
        finished
    }

    /// The whole picture.
    pub fn into_image(self) -> Image {
        self.image
    }
}
