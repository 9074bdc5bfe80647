//! How a picture is made: everything that is not the scene.

mod memory;

use std::fmt;
use std::str::FromStr;

use crate::error::Error;
use crate::image::Filter;
use crate::occlusion::CullSettings;
use crate::occlusion::settings::{by_word, word_of};
use crate::sampling::Rasterizer;

pub use memory::Memory;

/// Which vertices of what is surely opaque are shaded; anything else is shaded before it is sampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Shade {
    /// Those that a visible micropolygon uses, once it is known which these are.
    #[default]
    Visible,
    /// All vertices of all grids, before they are sampled.
    All,
    /// All vertices of each grid of which any sample was kept when it was drawn: Gelato's way (Wexler et al. 2005).
    Gelato,
}

impl Shade {
    const WORDS: [(&'static str, Shade); 3] =
        [("visible", Shade::Visible), ("all", Shade::All), ("gelato", Shade::Gelato)];
}

impl fmt::Display for Shade {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(word_of(&Self::WORDS, self))
    }
}

impl FromStr for Shade {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        by_word(&Self::WORDS, s).ok_or_else(|| "expected visible, all or gelato".to_owned())
    }
}

/// Settings of one render. The picture depends on the fields of the first group; those of the second
/// change speed, memory and the order of delivery, never a bit of the picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    // -- The picture.
    /// Width and height of the full frame in pixels, each 1 to 65,535.
    pub resolution: [u32; 2],
    /// Pixels that are rendered: `[x0, x1, y0, y1]` in the full frame, end exclusive; `None` is all of it.
    pub crop_px: Option<[u32; 4]>,
    /// Samples a pixel as a grid `[nx, ny]`; their product M is 1 to 1024.
    pub samples: [u32; 2],
    /// Reconstruction filter.
    pub filter: Filter,
    /// Multiplies every primitive's shading rate (micropolygon area in pixels).
    pub shading_rate_scale: f32,
    /// Replaces every primitive's motion factor ([`crate::scene::Attributes::motion_factor`]).
    pub motion_factor: Option<f32>,
    /// Replaces every primitive's focus factor.
    pub focus_factor: Option<f32>,
    /// How far a vertex may be from its path, in pixels, above 0: where paths are curved, key times are added.
    pub motion_tolerance_px: f32,
    /// Time of shading within the shutter, 0 (open) to 1 (close).
    pub shading_time: f32,
    /// Gain and gamma: value -> (gain * value)^(1 / gamma), after filtering.
    pub exposure: [f32; 2],
    /// Colour behind everything (linear), as the imager "background" gives it; `None` leaves alpha.
    pub background: Option<[f32; 3]>,
    /// Seed of the sample pattern.
    pub seed: u32,
    /// Whether samples are placed at random within their cells; false puts them at the cells' middles.
    pub jitter: bool,
    /// Side K of the pattern's pixel tile; `None` takes [`crate::sampling::pattern::default_tile`], or the largest
    /// that the rasterizer can do with.
    pub pattern_tile: Option<u32>,
    /// Number P of permutation sets.
    pub permutations: u32,
    /// Most micropolygons in a grid.
    pub grid_size: u32,
    /// How often an edge through the eye plane is halved.
    pub eye_splits: u32,

    // -- Speed, memory, order.
    /// The way samples are found. [`Rasterizer::NoMotion`] refuses scenes that move or have a lens, and
    /// [`Rasterizer::Simple`] and [`Rasterizer::InterleaveUvt`] pattern tiles that are too large. The picture is the
    /// same with all that take its pattern tile.
    pub rasterizer: Rasterizer,
    /// Worker threads; 0 is one per core.
    pub threads: usize,
    /// Output buckets, in pixels, delivered as they are finished.
    pub bucket: [u32; 2],
    /// Side of a raster tile in pixels; `None` picks one whose samples stay in cache.
    pub tile: Option<u32>,
    /// Occlusion culling.
    pub cull: CullSettings,
    /// Which vertices are shaded.
    pub shade: Shade,
    /// Most transparent records kept for a tile before its samples are peeled by depth.
    pub transparency_records: usize,
    /// Bytes for grids kept between tiles; beyond it they are made again.
    pub grid_cache: u64,
    /// Most bytes for the finished picture; a larger one is refused.
    pub picture_memory: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            resolution: [640, 480],
            crop_px: None,
            samples: [4, 4],
            filter: Filter::default(),
            shading_rate_scale: 1.0,
            motion_factor: None,
            focus_factor: None,
            motion_tolerance_px: 0.125,
            shading_time: 0.5,
            exposure: [1.0, 1.0],
            background: None,
            seed: 0,
            jitter: true,
            pattern_tile: None,
            permutations: 64,
            grid_size: 256,
            eye_splits: 10,
            rasterizer: Rasterizer::Auto,
            threads: 0,
            bucket: [64, 64],
            tile: None,
            cull: CullSettings::default(),
            shade: Shade::default(),
            transparency_records: 1 << 20,
            grid_cache: 256 << 20,
            picture_memory: 8 << 30,
        }
    }
}

impl Settings {
    /// Samples a pixel, M = nx * ny.
    pub fn samples_per_pixel(&self) -> u32 {
        self.samples[0].saturating_mul(self.samples[1])
    }

    /// Side K of the pattern's pixel tile: the one asked for, or the default for the samples and the rasterizer.
    pub fn pattern_tile_side(&self) -> u32 {
        let default = crate::sampling::pattern::default_tile(self.samples_per_pixel());
        self.pattern_tile.unwrap_or(default.min(self.rasterizer.greatest_tile()))
    }

    /// The pixels to render, `[x0, x1, y0, y1]`, end exclusive.
    pub fn window_px(&self) -> [u32; 4] {
        self.crop_px.unwrap_or([0, self.resolution[0], 0, self.resolution[1]])
    }

    /// Checks every range.
    ///
    /// # Errors
    /// [`Error::Setting`] names the first field outside its range.
    pub fn validate(&self) -> Result<(), Error> {
        let fail = |what, found: String, expected: &str| {
            Err(Error::Setting { what, found, expected: expected.to_owned() })
        };
        let [w, h] = self.resolution;
        if w == 0 || h == 0 || w > 65_535 || h > 65_535 {
            return fail("resolution", format!("{w}x{h}"), "1 to 65535 pixels each way");
        }
        if let Some([x0, x1, y0, y1]) = self.crop_px
            && (x0 >= x1 || y0 >= y1 || x1 > w || y1 > h)
        {
            return fail(
                "crop",
                format!("{x0},{x1},{y0},{y1}"),
                "a part of the frame with at least one pixel",
            );
        }
        let m = self.samples_per_pixel();
        if m == 0 || m > 1024 {
            return fail("samples", format!("{}x{}", self.samples[0], self.samples[1]), "1 to 1024 a pixel");
        }
        if !self.filter.is_valid() {
            return fail("filter", format!("{:?}", self.filter), "widths above 0 and at most 64 pixels");
        }
        if !(self.shading_rate_scale > 0.0 && self.shading_rate_scale.is_finite()) {
            return fail("shading rate", self.shading_rate_scale.to_string(), "a finite number above 0");
        }
        for (what, factor) in [("motion factor", self.motion_factor), ("focus factor", self.focus_factor)] {
            if let Some(factor) = factor
                && !(factor >= 0.0 && factor.is_finite())
            {
                return fail(what, factor.to_string(), "a finite number of at least 0");
            }
        }
        if !(self.motion_tolerance_px > 0.0 && self.motion_tolerance_px.is_finite()) {
            let found = self.motion_tolerance_px.to_string();
            return fail("motion tolerance", found, "a finite number of pixels above 0");
        }
        if !(0.0..=1.0).contains(&self.shading_time) {
            return fail("shading time", self.shading_time.to_string(), "0 (shutter open) to 1 (closed)");
        }
        let [gain, gamma] = self.exposure;
        if !(gain.is_finite() && gamma.is_finite() && gamma > 0.0) {
            return fail("exposure", format!("{gain} {gamma}"), "a finite gain and a finite gamma above 0");
        }
        if let Some(k) = self.pattern_tile
            && !matches!(k, 1 | 2 | 3 | 4 | 8 | 64)
        {
            return fail("pattern tile", k.to_string(), "1, 2, 3, 4, 8 or 64");
        }
        if !(1..=65_536).contains(&self.permutations) {
            return fail("permutations", self.permutations.to_string(), "1 to 65536");
        }
        if !(1..=4096).contains(&self.grid_size) {
            return fail("grid size", self.grid_size.to_string(), "1 to 4096 micropolygons");
        }
        if self.eye_splits > 20 {
            return fail("eye splits", self.eye_splits.to_string(), "0 to 20");
        }
        if self.bucket.contains(&0) {
            return fail("bucket", format!("{}x{}", self.bucket[0], self.bucket[1]), "at least 1x1 pixel");
        }
        let k = self.pattern_tile_side();
        if k > self.rasterizer.greatest_tile() {
            let (most, rasterizer) = (self.rasterizer.greatest_tile(), self.rasterizer);
            return fail(
                "pattern tile",
                k.to_string(),
                &format!("at most {most} with rasterizer {rasterizer}"),
            );
        }
        self.cull.validate()?;
        if self.tile == Some(0) {
            return fail("tile", "0".to_owned(), "at least 1 pixel");
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_shading_are_read_as_they_are_written() {
        for (word, shade) in Shade::WORDS {
            assert_eq!((shade.to_string().as_str(), word.parse()), (word, Ok(shade)));
        }
        assert_eq!("none".parse::<Shade>(), Err("expected visible, all or gelato".to_owned()));
    }

    #[test]
    fn pattern_tiles_fit_the_rasterizer_or_both_are_named() {
        let of = |rasterizer, pattern_tile| Settings { rasterizer, pattern_tile, ..Settings::default() };
        assert_eq!(of(Rasterizer::Simple, None).pattern_tile_side(), 1);
        for rasterizer in Rasterizer::ALL {
            assert_eq!(of(rasterizer, None).validate(), Ok(()), "{rasterizer}");
            assert_eq!(of(rasterizer, Some(1)).validate(), Ok(()), "{rasterizer}");
        }
        for (rasterizer, tile, error) in [
            (
                Rasterizer::InterleaveUvt,
                64,
                "pattern tile is 64: expected at most 8 with rasterizer interleave",
            ),
            (Rasterizer::Simple, 2, "pattern tile is 2: expected at most 1 with rasterizer simple"),
        ] {
            assert_eq!(of(rasterizer, Some(tile)).validate().expect_err("too large").to_string(), error);
        }
    }
}
