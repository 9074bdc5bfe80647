//! A rectangle of pixels and the samples in it, laid out for rasterizers.
//!
//! In: a [`SamplePattern`] and a [`Region`]. Out: [`RegionSamples`], the place and tuple of each sample in
//! one array, so that inner loops neither hash nor permute.

use std::cell::RefCell;
use std::sync::OnceLock;

use super::pattern::SamplePattern;
use super::rows::TupleRows;
use crate::math::lanes::pair;
use crate::math::simd::LANES;

/// Full-frame pixels `[x0, x1) x [y0, y1)`; they may be negative.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Region {
    /// First column.
    pub x0: i32,
    /// Column after the last.
    pub x1: i32,
    /// First row.
    pub y0: i32,
    /// Row after the last.
    pub y1: i32,
}

impl Region {
    /// The region `[x0, x1) x [y0, y1)`; empty where an end is not above its start.
    pub fn new(x0: i32, x1: i32, y0: i32, y1: i32) -> Self {
        Region { x0, x1: x1.max(x0), y0, y1: y1.max(y0) }
    }

    /// Width in pixels.
    pub fn width(&self) -> usize {
        (self.x1 - self.x0) as usize
    }

    /// Height in pixels.
    pub fn height(&self) -> usize {
        (self.y1 - self.y0) as usize
    }

    /// Number of pixels.
    pub fn num_pixels(&self) -> usize {
        self.width() * self.height()
    }

    /// Whether a pixel is in the region.
    pub fn contains(&self, px: i32, py: i32) -> bool {
        (self.x0..self.x1).contains(&px) && (self.y0..self.y1).contains(&py)
    }

    /// Index of a pixel of the region, row by row.
    #[inline(always)]
    pub fn pixel_ix(&self, px: i32, py: i32) -> usize {
        debug_assert!(self.contains(px, py), "pixel ({px}, {py}) outside {self:?}");
        (py - self.y0) as usize * self.width() + (px - self.x0) as usize
    }
}

/// Pixels of a row for which [`RegionSamples`] tells how far right of the first one they are.
pub(super) const MOST_STEPS_PX: usize = 32;

/// The samples of a region: sample j of pixel (px, py) has index `pixel_ix(px, py) * M + j`.
#[derive(Debug, Clone)]
pub struct RegionSamples {
    /// The pixels.
    pub region: Region,
    /// Sub-pixel cells across and down; their product is M.
    pub grid: [u32; 2],
    /// Tuple of each sample, an index into [`SamplePattern::tuples`].
    pub tuples: Vec<u32>,
    /// Made when they are first asked for.
    rows: OnceLock<Option<TupleRows>>,
    /// Memory of those of the last region.
    spare: RefCell<Vec<i32>>,
    /// Places in the pixel, with [`LANES`] more of any.
    places: Vec<i32>,
    /// Times and lens places, made when they are first asked for.
    blur: OnceLock<[Vec<i32>; 2]>,
    steps: Vec<i32>,
    /// Permutation sets of the pattern tiles that the region overlaps, row by row from tile `first_tile`.
    sets: Vec<u32>,
    first_tile: [i32; 2],
    tiles_across: usize,
}

impl RegionSamples {
    /// Lays out the samples of a region.
    pub fn new(pattern: &SamplePattern, region: Region) -> Self {
        let mut samples = RegionSamples {
            region,
            grid: pattern.strata().grid,
            tuples: Vec::new(),
            rows: OnceLock::new(),
            spare: RefCell::default(),
            places: Vec::new(),
            blur: OnceLock::new(),
            steps: Vec::new(),
            sets: Vec::new(),
            first_tile: [0; 2],
            tiles_across: 0,
        };
        samples.renew(pattern, region);
        samples
    }

    /// Lays out another region in the same memory.
    pub fn renew(&mut self, pattern: &SamplePattern, region: Region) {
        let num_strata = pattern.samples_per_pixel();
        let k = pattern.tile() as i32;
        self.region = region;
        self.grid = pattern.strata().grid;
        self.find_sets(pattern);
        let (len, num) = (region.num_pixels() * num_strata as usize, num_strata as usize);
        self.tuples.resize(len, 0);
        self.places.resize(len + LANES, 0);
        let row = (region.width() * num).max(1);
        let rows = self.tuples.chunks_exact_mut(row).zip(self.places.chunks_exact_mut(row));
        for (py, (mut tuples, mut places)) in (region.y0..region.y1).zip(rows) {
            let (ty, y) = (py.div_euclid(k), py.rem_euclid(k));
            let sets = &self.sets[(ty - self.first_tile[1]) as usize * self.tiles_across..];
            for (tx, &set) in (self.first_tile[0]..).zip(&sets[..self.tiles_across]) {
                // The pixels of the tile's row that are in the region.
                let (first, end) = ((tx * k).max(region.x0), ((tx + 1) * k).min(region.x1));
                let here = (end - first) as usize * num;
                let ((of, rest), (at, others)) = (tuples.split_at_mut(here), places.split_at_mut(here));
                pattern.lay_pixels([set, (y * k + first - tx * k) as u32], of, at);
                (tuples, places) = (rest, others);
            }
        }
        self.blur.take();
        self.steps.clear();
        let num_steps = MOST_STEPS_PX * num_strata as usize + LANES;
        self.steps.extend((0..num_steps).map(|j| pair((j / num_strata as usize) as i32 * 256, 0)));
        if let Some(rows) = self.rows.take().flatten() {
            self.spare.replace(rows.into_words());
        }
    }

    /// Place of each sample in its pixel as a pair of 16 bits, and 16 more of any.
    #[inline(always)]
    pub(super) fn places(&self) -> &[i32] {
        &self.places
    }

    /// Time of each sample's tuple in the shutter, in both halves, and its lens place as a pair; and 16 more of any of
    /// each. `pattern` is what these samples are of.
    #[inline(always)]
    pub(super) fn times_and_lens(&self, pattern: &SamplePattern) -> [&[i32]; 2] {
        let [times, lens] = self.blur.get_or_init(|| {
            let tuples = || self.tuples.iter().map(|&ix| pattern.tuples()[ix as usize]);
            let more = || std::iter::repeat_n(0, LANES);
            let times = tuples().map(|tuple| pair(tuple.t15.into(), tuple.t15.into()));
            let lens = tuples().map(|tuple| pair(tuple.u15.into(), tuple.v15.into()));
            [times.chain(more()).collect(), lens.chain(more()).collect()]
        });
        [times, lens]
    }

    /// For sample j of a row of pixels what its pixel is right of the first one, in 1/256 px as a pair of 16 bits; for
    /// [`MOST_STEPS_PX`] pixels and 16 samples more.
    #[inline(always)]
    pub(super) fn steps(&self) -> &[i32] {
        &self.steps
    }

    /// Which pixels hold which tuple of the pattern that these samples are of; nothing where the region is too large.
    #[inline(always)]
    pub(super) fn rows(&self, pattern: &SamplePattern) -> Option<&TupleRows> {
        self.rows.get_or_init(|| TupleRows::new(pattern, self, self.spare.take())).as_ref()
    }

    /// Looks up the set of each tile once.
    fn find_sets(&mut self, pattern: &SamplePattern) {
        let Region { x0, x1, y0, y1 } = self.region;
        let [tx, ty] = [[x0, x1], [y0, y1]].map(|ends| {
            let k = pattern.tile() as i32;
            ends[0].div_euclid(k)..(ends[1] - 1).div_euclid(k) + 1
        });
        self.first_tile = [tx.start, ty.start];
        self.tiles_across = tx.len();
        self.sets.clear();
        self.sets.extend(ty.flat_map(|y| tx.clone().map(move |x| pattern.set_of_tile(x, y))));
    }

    /// The permutation set of a pattern tile that the region overlaps.
    #[inline(always)]
    pub fn set_of_tile(&self, tx: i32, ty: i32) -> u32 {
        let [x, y] = [tx - self.first_tile[0], ty - self.first_tile[1]];
        self.sets[y as usize * self.tiles_across + x as usize]
    }

    /// Samples a pixel, M.
    #[inline(always)]
    pub fn samples_per_pixel(&self) -> usize {
        (self.grid[0] * self.grid[1]) as usize
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.tuples.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.tuples.is_empty()
    }

    /// Place of sample `ix` in its pixel, `[x, y]` in 1/256 px.
    #[inline(always)]
    pub fn offset(&self, ix: usize) -> [u8; 2] {
        let place = self.places[ix];
        [place as u8, (place >> 16) as u8]
    }

    /// Raster place of sample `ix` in 1/256 px.
    pub fn position(&self, ix: usize) -> [i32; 2] {
        let pixel = ix / self.samples_per_pixel();
        let px = self.region.x0 + (pixel % self.region.width()) as i32;
        let py = self.region.y0 + (pixel / self.region.width()) as i32;
        let [x, y] = self.offset(ix);
        [px * 256 + i32::from(x), py * 256 + i32::from(y)]
    }
}
