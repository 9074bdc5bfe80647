//! The raster tiles of a frame: where they are, and which of them something meets.

use crate::pipeline::sweep::{Sweep, to_pixels};
use crate::sampling::{Region, SamplePattern};
use crate::settings::Settings;

/// Bytes of sample records and colours that a tile may use, so that they stay in the second-level cache.
const TILE_BYTES: u64 = 768 << 10;

/// The raster tiles of a frame. They count from full-frame pixel (0, 0).
#[derive(Debug, Clone, Copy)]
pub(super) struct Tiles {
    /// Side in pixels.
    pub side: u32,
    /// Pixels to each side whose samples a pixel's filter reads.
    pub margin: [i32; 2],
    /// Pixels to render.
    pub window: Region,
    columns: usize,
    rows: usize,
}

impl Tiles {
    pub fn new(settings: &Settings, pattern: &SamplePattern, margin: [i32; 2]) -> Self {
        let k = pattern.tile();
        let side = settings.tile.unwrap_or_else(|| default_side(settings.samples_per_pixel(), k));
        let [x0, x1, y0, y1] = settings.window_px().map(|px| px as i32);
        let window = Region::new(x0, x1, y0, y1);
        let count = |from: i32, to: i32| ((to - 1) / side as i32 - from / side as i32 + 1) as usize;
        Tiles { side, margin, window, columns: count(x0, x1), rows: count(y0, y1) }
    }

    /// Number of tiles that hold pixels of the window.
    pub fn len(&self) -> usize {
        self.columns * self.rows
    }

    /// The window's pixels in a tile.
    pub fn interior(&self, tile: usize) -> Region {
        let side = self.side as i32;
        let column = self.window.x0 / side + (tile % self.columns) as i32;
        let row = self.window.y0 / side + (tile / self.columns) as i32;
        Region::new(
            (column * side).max(self.window.x0),
            ((column + 1) * side).min(self.window.x1),
            (row * side).max(self.window.y0),
            ((row + 1) * side).min(self.window.y1),
        )
    }

    /// The pixels whose samples those of `interior` read.
    pub fn sample_region(&self, interior: Region) -> Region {
        let [mx, my] = self.margin;
        Region::new(interior.x0 - mx, interior.x1 + mx, interior.y0 - my, interior.y1 + my)
    }

    /// Columns and rows of tiles whose sample regions meet a box of pixels (inclusive).
    fn range(&self, pixels: [i32; 4]) -> [std::ops::Range<usize>; 2] {
        let side = self.side as i32;
        let along = |from: i32, to: i32, margin: i32, first_px: i32, last_px: i32| {
            let first_tile = first_px / side;
            let clamp = |px: i32| (px.clamp(first_px, last_px) / side - first_tile) as usize;
            let (from, to) = (from.saturating_sub(margin), to.saturating_add(margin));
            if to < first_px || from > last_px { 0..0 } else { clamp(from)..clamp(to) + 1 }
        };
        [
            along(pixels[0], pixels[1], self.margin[0], self.window.x0, self.window.x1 - 1),
            along(pixels[2], pixels[3], self.margin[1], self.window.y0, self.window.y1 - 1),
        ]
    }

    /// Tiles in which something may be seen.
    pub fn touched(&self, sweep: &Sweep) -> impl Iterator<Item = usize> {
        let [columns, rows] = self.range(to_pixels(sweep.whole()));
        let all = rows.flat_map(move |row| columns.clone().map(move |column| row * self.columns + column));
        all.filter(move |&tile| sweep.meets_region(&self.sample_region(self.interior(tile))).is_some())
    }
}

/// Largest multiple of K, at least 8 pixels, at most 64, whose records and colours fit the cache.
fn default_side(samples_per_pixel: u32, k: u32) -> u32 {
    let bytes_per_pixel = u64::from(samples_per_pixel) * 40;
    let mut side = 64;
    while side > 8 && u64::from(side * side) * bytes_per_pixel > 4 * TILE_BYTES {
        side /= 2;
    }
    (side / k).max(1) * k
}
