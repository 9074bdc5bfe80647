//! The picture as it grows: tiles go in; finished output buckets and the picture come out, or its rows.

use std::collections::VecDeque;

use crate::error::Error;
use crate::image::Image;
use crate::pipeline::resolve::Pixel;
use crate::sampling::Region;
use crate::settings::Settings;

/// Channels of every picture.
pub(super) const CHANNELS: [&str; 5] = ["r", "g", "b", "a", "z"];

/// Where tiles go.
pub(super) enum Output<'a> {
    /// Into a picture.
    Whole(Whole),
    /// To someone who takes rows.
    Rows(Rows<'a>),
}

impl Output<'_> {
    /// Puts a tile's pixels in place and returns the output buckets that are whole now.
    pub fn put(&mut self, tile: Region, pixels: &[Pixel]) -> Vec<Image> {
        match self {
            Output::Whole(whole) => whole.put(tile, pixels),
            Output::Rows(rows) => {
                rows.put(tile, pixels);
                Vec::new()
            }
        }
    }
}

/// Writes a tile's pixels to an image that holds them.
fn place(image: &mut Image, tile: Region, pixels: &[Pixel]) {
    let [x0, _, y0, _] = image.window_px;
    let width = image.width();
    for (row, line) in pixels.chunks_exact(tile.width()).enumerate() {
        let first = (tile.y0 as usize - y0 as usize + row) * width + (tile.x0 as usize - x0 as usize);
        for (c, channel) in image.channels.iter_mut().enumerate() {
            for (value, pixel) in channel.values[first..first + tile.width()].iter_mut().zip(line) {
                *value = pixel[c];
            }
        }
    }
}

/// Hands out rows of the picture, from the top, as soon as those above them are. Tiles are taken in order, so that there
/// are never many rows of tiles that are not whole.
pub(super) struct Rows<'a> {
    frame_px: [u32; 2],
    window_px: [u32; 4],
    /// Rows of tiles from the first that was not handed out: as far as it is drawn, and how many pixels are missing.
    waiting: VecDeque<Option<(Image, usize)>>,
    /// First row of the first of them.
    next_row: u32,
    tile_side: u32,
    /// The last one that was handed out, to be used again.
    spare: Option<Image>,
    hand_out: &'a mut (dyn FnMut(&Image) + Send),
}

impl<'a> Rows<'a> {
    /// Nothing is drawn yet, of tiles with sides of `tile_side` pixels.
    pub fn new(settings: &Settings, tile_side: u32, hand_out: &'a mut (dyn FnMut(&Image) + Send)) -> Self {
        let window_px = settings.window_px();
        let waiting = VecDeque::new();
        Rows {
            frame_px: settings.resolution,
            window_px,
            waiting,
            next_row: window_px[2],
            tile_side,
            spare: None,
            hand_out,
        }
    }

    fn put(&mut self, tile: Region, pixels: &[Pixel]) {
        let [x0, x1, ..] = self.window_px;
        let ix = (tile.y0 as u32 / self.tile_side - self.next_row / self.tile_side) as usize;
        if self.waiting.len() <= ix {
            self.waiting.resize_with(ix + 1, || None);
        }
        let (frame_px, spare) = (self.frame_px, &mut self.spare);
        let (image, missing) = self.waiting[ix].get_or_insert_with(|| {
            let window_px = [x0, x1, tile.y0 as u32, tile.y1 as u32];
            let is_as_high = |image: &Image| image.height() == tile.height();
            let image = match spare.take().filter(is_as_high) {
                Some(image) => Image { window_px, ..image },
                None => Image::new(frame_px, window_px, &CHANNELS),
            };
            (image, (x1 - x0) as usize * tile.height())
        });
        place(image, tile, pixels);
        *missing -= pixels.len();
        while let Some(Some((image, 0))) = self.waiting.front() {
            (self.hand_out)(image);
            self.next_row = image.window_px[3];
            self.spare = self.waiting.pop_front().flatten().map(|(image, _)| image);
        }
    }
}

/// Collects tiles.
pub(super) struct Whole {
    image: Image,
    bucket: [u32; 2],
    /// Pixels missing from each bucket, row by row.
    missing: Vec<u32>,
}

impl Whole {
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
            Whole { image: Image::new(settings.resolution, window, &CHANNELS), bucket, missing: Vec::new() };
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

    fn put(&mut self, tile: Region, pixels: &[Pixel]) -> Vec<Image> {
        place(&mut self.image, tile, pixels);
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
