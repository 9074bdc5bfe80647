//! The sample pattern: M samples a pixel, dealt out from N = M K^2 tuples over tiles of K x K pixels.
//!
//! In: a [`PatternSpec`]. Out: a [`SamplePattern`], data that never changes. Sources: Fatahalian 2009,
//! sections 3.2.1 (strata), 3.2.2 (interleaving) and 3.2.3 (permutations).
//!
//! ```text
//! tuple = stratum * K^2 + rank        sub-pixel cells of a pixel, a x b = 4 x 2:
//! stratum j: 0..M, rank: 0..K^2         0 1 2 3
//!                                       4 5 6 7      sample j of a pixel is in cell j
//! ```
//!
//! - Every pixel of a tile holds one tuple of each stratum, so x, y, time and lens are stratified in each
//!   pixel, and each tuple is used once a tile. Which pixel holds which rank is, stratum by stratum, a
//!   permutation computed from a hash of (set, stratum); the set is a hash of the tile and the seed.
//! - The cells of a stratum are those of [`Strata`]. Within its column of x and y, its interval of time and its
//!   cell of the lens the K^2 tuples of a stratum are a Sobol sequence in (x, y, t, p, q), Owen-scrambled by hash
//!   (Burley, "Practical Hash-based Owen Scrambling", 2020), of which the order in each dimension is kept and the
//!   rest jittered. So time takes N different intervals over a tile, and the lens is filled all over: a
//!   highlight out of focus is a disk, and not M spots.
//! - How well that spreads: coverage by edges of random place and direction, 16 samples, box of 1 pixel, root
//!   mean square error below that of independent samples, and of a jittered grid with shuffled jittered time
//!   and lens strata (test `moving_edges_are_less_noisy_than_random_samples`): still 8.1 and 1.7 dB, moving by
//!   4 px 7.9 and 1.9 dB, 2 px out of focus 6.4 and 2.3 dB, both 5.2 and 1.3 dB. With the tuples of a stratum in its
//!   columns of the lens, too, defocused edges gain 1.4 dB, and a highlight falls apart into M spots.
//!
//! [`default_tile`] says which K is used where none is asked for.

use super::hash::{Permutation, hash, unit};
use super::lens::LensShape;
use super::rows::TileRows;
use super::shutter::ShutterShape;
use super::sobol::scrambled_order;
use super::strata::{P, Q, Strata, T, X, Y, positions_of_cell};
use crate::math::lanes::pair;

/// What a pattern is made from.
#[derive(Debug, Clone, PartialEq)]
pub struct PatternSpec {
    /// Sub-pixel cells across and down; the product M is 1 to 1024.
    pub samples: [u32; 2],
    /// Side K of the pixel tile: 1 to 64.
    pub tile: u32,
    /// Number P of permutation sets, at least 1; 1 repeats the same tile over the picture.
    pub permutations: u32,
    /// Another seed is another pattern of the same kind.
    pub seed: u32,
    /// Off: sub-pixel places are the centres of their cells, and times and lens places those of their parts.
    pub jitter: bool,
    /// Shape of the lens.
    pub lens: LensShape,
    /// Factors on lens places along u and v, each above 0 and at most 1. Where pixels are not square, circles of
    /// confusion are ellipses on the raster: their radius is that along the longer axis, with factor 1.
    pub lens_scale: [f64; 2],
    /// Shape of the shutter.
    pub shutter: ShutterShape,
    /// How a tile picks its set.
    pub set_rule: SetRule,
}

impl Default for PatternSpec {
    fn default() -> Self {
        PatternSpec {
            samples: [4, 4],
            tile: 2,
            permutations: 64,
            seed: 0,
            jitter: true,
            lens: LensShape::Round,
            lens_scale: [1.0; 2],
            shutter: ShutterShape::Box,
            set_rule: SetRule::Hashed,
        }
    }
}

/// How a tile picks its permutation set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SetRule {
    /// A hash of tile and seed, modulo P.
    #[default]
    Hashed,
    /// (n + tx + ty) mod P with n = ty * floor(width / K) + tx, as Sattlecker 2015 prints it.
    Published {
        /// Width of the full frame in pixels.
        width: u32,
    },
}

/// The K that is used by default for M samples a pixel.
///
/// 2 up to 256 samples: N = 4 M tuples hide the tile, and InterleaveUvt, which tests each micropolygon at
/// least N times, stays affordable. Above that 1: M tuples alone put ghosts less than 1/256 of the blur apart,
/// which is below a pixel for all but the longest paths, and more would only cost tests.
pub fn default_tile(samples_per_pixel: u32) -> u32 {
    if samples_per_pixel <= 256 { 2 } else { 1 }
}

/// One of the N places in time, lens and pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tuple {
    /// Lens place times 32768, in -32767..=32767, within the unit disk; to the right, as raster x.
    pub u15: i16,
    /// See `u15`; down, as raster y. [`LensShape`] has v up: this is -v.
    pub v15: i16,
    /// Time within the shutter times 32768, in 0..=32767.
    pub t15: i16,
    /// Place in the pixel in 1/256 px, from its left border.
    pub x: u8,
    /// Place in the pixel in 1/256 px, from its upper border.
    pub y: u8,
}

/// What the tuples of one stratum span; both ends inclusive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StratumBounds {
    /// `[least, greatest]` lens place.
    pub u15: [i16; 2],
    /// See `u15`.
    pub v15: [i16; 2],
    /// Time.
    pub t15: [i16; 2],
}

/// A sample pattern.
#[derive(Debug, Clone)]
pub struct SamplePattern {
    spec: PatternSpec,
    strata: Strata,
    tuples: Vec<Tuple>,
    bounds: Vec<StratumBounds>,
    permutations: Permutations,
    by_time: Vec<u32>,
    /// Tuples of the samples of a tile's pixels under each set, and their places in the pixel as pairs of 16 bits, at
    /// ((set * K^2 + pixel) * M + j); none where they are too many.
    laid: (Vec<u32>, Vec<i32>),
    /// `None` where they are too many.
    tile_rows: Option<TileRows>,
}

/// Samples of pixels that are laid out at most (512 KiB).
const MOST_LAID: u64 = 1 << 16;

/// Entries up to which permutations are stored instead of computed (1 MiB in both directions together).
const STORED: u64 = 1 << 18;

/// Copies a list into one of the same length. There are many of them, of a few lengths: a call for each costs more than
/// copying it.
#[inline(always)]
fn copy_short<T: Copy>(from: &[T], to: &mut [T]) {
    fn copy<T: Copy, const N: usize>(from: &[T], to: &mut [T]) -> Option<()> {
        *to.first_chunk_mut::<N>()? = *from.first_chunk::<N>()?;
        Some(())
    }
    let copied = match to.len() {
        8 => copy::<T, 8>(from, to),
        16 => copy::<T, 16>(from, to),
        32 => copy::<T, 32>(from, to),
        _ => None,
    };
    if copied.is_none() {
        to.copy_from_slice(from);
    }
}

#[derive(Debug, Clone)]
enum Permutations {
    /// At ((set * M + stratum) * K^2 + i): `[rank of pixel i, pixel of rank i]`.
    Stored(Vec<[u16; 2]>),
    Computed,
}

impl SamplePattern {
    /// Builds the pattern. Values outside the ranges of [`PatternSpec`] are clamped to them (settings are
    /// checked, with a message, where they come in).
    pub fn new(spec: PatternSpec) -> Self {
        let a = spec.samples[0].clamp(1, 1024);
        let b = spec.samples[1].clamp(1, 1024 / a);
        let strata = Strata::new([a, b], hash(&[spec.seed, 1]));
        Self::with_strata(spec, strata)
    }

    /// The pattern on given strata, which take the place of `spec.samples`.
    pub fn with_strata(mut spec: PatternSpec, strata: Strata) -> Self {
        spec.samples = strata.grid;
        spec.tile = spec.tile.clamp(1, 64);
        spec.permutations = spec.permutations.max(1);
        let num_ranks = spec.tile * spec.tile;
        let mut tuples = Vec::with_capacity((strata.num() * num_ranks) as usize);
        for stratum in 0..strata.num() {
            append_stratum(&spec, &strata, stratum, &mut tuples);
        }
        let bounds = tuples.chunks(num_ranks as usize).map(bounds_of).collect();
        let mut by_time: Vec<u32> = (0..tuples.len() as u32).collect();
        by_time.sort_by_key(|&ix| (tuples[ix as usize].t15, ix));
        let permutations = Permutations::Computed;
        let laid = Default::default();
        let tile_rows = None;
        let mut pattern =
            SamplePattern { spec, strata, tuples, bounds, permutations, by_time, laid, tile_rows };
        let num_entries = u64::from(pattern.spec.permutations) * pattern.tuples.len() as u64;
        if num_entries <= STORED {
            pattern.permutations = Permutations::Stored(pattern.all_permutations());
        }
        if num_entries <= MOST_LAID {
            let pixels = (0..pattern.spec.permutations)
                .flat_map(|set| (0..pattern.num_ranks()).map(move |pixel| [set, pixel]));
            pattern.laid = pixels.flat_map(|[set, pixel]| pattern.lay_out(set, pixel)).unzip();
            pattern.tile_rows = TileRows::new(&pattern);
        }
        pattern
    }

    /// What it was made from.
    pub fn spec(&self) -> &PatternSpec {
        &self.spec
    }

    /// The strata.
    pub fn strata(&self) -> &Strata {
        &self.strata
    }

    /// Samples a pixel, M.
    #[inline(always)]
    pub fn samples_per_pixel(&self) -> u32 {
        self.bounds.len() as u32
    }

    /// Side K of the pixel tile.
    #[inline(always)]
    pub fn tile(&self) -> u32 {
        self.spec.tile
    }

    /// All N tuples; those of stratum j are `j * K^2 .. (j + 1) * K^2`.
    #[inline(always)]
    pub fn tuples(&self) -> &[Tuple] {
        &self.tuples
    }

    /// All tuples in order of time, equal times in order of their number.
    pub fn by_time(&self) -> &[u32] {
        &self.by_time
    }

    /// What the tuples of stratum j span in time and lens.
    #[inline(always)]
    pub fn stratum_bounds(&self, stratum: u32) -> StratumBounds {
        self.bounds[stratum as usize]
    }

    /// The permutation set of tile (tx, ty); tiles count from full-frame pixel (0, 0) and may be negative.
    #[inline]
    pub fn set_of_tile(&self, tx: i32, ty: i32) -> u32 {
        let num_sets = self.spec.permutations;
        match self.spec.set_rule {
            SetRule::Hashed => hash(&[tx as u32, ty as u32, self.spec.seed, 2]) % num_sets,
            SetRule::Published { width } => {
                let n = i64::from(ty) * i64::from(width / self.spec.tile) + i64::from(tx);
                (n + i64::from(tx) + i64::from(ty)).rem_euclid(i64::from(num_sets)) as u32
            }
        }
    }

    /// The rank that pixel `pixel` (row by row in its tile, 0..K^2) holds of a stratum, under a set.
    #[inline]
    pub fn rank_of_pixel(&self, set: u32, stratum: u32, pixel: u32) -> u32 {
        match &self.permutations {
            Permutations::Stored(entries) => u32::from(entries[self.entry(set, stratum, pixel)][0]),
            Permutations::Computed => self.permutation(set, stratum).forward(pixel),
        }
    }

    /// The pixel that holds a rank: the inverse of [`Self::rank_of_pixel`].
    #[inline]
    pub fn pixel_of_rank(&self, set: u32, stratum: u32, rank: u32) -> u32 {
        match &self.permutations {
            Permutations::Stored(entries) => u32::from(entries[self.entry(set, stratum, rank)][1]),
            Permutations::Computed => self.permutation(set, stratum).inverse(rank),
        }
    }

    /// The tuple (index into [`Self::tuples`]) of sample `j` of full-frame pixel (px, py).
    #[inline]
    pub fn tuple_at(&self, px: i32, py: i32, j: u32) -> u32 {
        let k = self.spec.tile as i32;
        let set = self.set_of_tile(px.div_euclid(k), py.div_euclid(k));
        let pixel = (py.rem_euclid(k) * k + px.rem_euclid(k)) as u32;
        j * self.num_ranks() + self.rank_of_pixel(set, j, pixel)
    }

    /// The place of sample `j` of full-frame pixel (px, py), in 1/256 px of raster space.
    #[inline]
    pub fn position(&self, px: i32, py: i32, j: u32) -> (i32, i32) {
        let tuple = self.tuples[self.tuple_at(px, py, j) as usize];
        (px * 256 + i32::from(tuple.x), py * 256 + i32::from(tuple.y))
    }

    /// Tuples of the samples of a pixel of a tile under a set, and of the next ones in its row, and their places as pairs
    /// of 16 bits: of as many pixels as the lists have room for.
    #[inline(always)]
    pub(super) fn lay_pixels(&self, [set, pixel]: [u32; 2], tuples: &mut [u32], places: &mut [i32]) {
        let first = (set * self.num_ranks() + pixel) as usize * self.samples_per_pixel() as usize;
        let laid = first..first + tuples.len();
        if let (Some(of), Some(at)) = (self.laid.0.get(laid.clone()), self.laid.1.get(laid)) {
            copy_short(of, tuples);
            copy_short(at, places);
        } else {
            let laid = (pixel..).flat_map(|pixel| self.lay_out(set, pixel));
            let to = tuples.iter_mut().zip(places);
            to.zip(laid).for_each(|((tuple, place), laid)| (*tuple, *place) = laid);
        }
    }

    /// See [`TileRows`].
    #[inline(always)]
    pub(super) fn tile_rows(&self) -> Option<&TileRows> {
        self.tile_rows.as_ref()
    }

    fn lay_out(&self, set: u32, pixel: u32) -> impl Iterator<Item = (u32, i32)> {
        (0..self.samples_per_pixel()).map(move |stratum| {
            let ix = stratum * self.num_ranks() + self.rank_of_pixel(set, stratum, pixel);
            let Tuple { x, y, .. } = self.tuples[ix as usize];
            (ix, pair(x.into(), y.into()))
        })
    }

    #[inline(always)]
    fn num_ranks(&self) -> u32 {
        self.spec.tile * self.spec.tile
    }

    #[inline(always)]
    fn entry(&self, set: u32, stratum: u32, i: u32) -> usize {
        ((set * self.samples_per_pixel() + stratum) * self.num_ranks() + i) as usize
    }

    fn permutation(&self, set: u32, stratum: u32) -> Permutation {
        Permutation::new(self.num_ranks(), hash(&[set, stratum, 3]))
    }

    fn all_permutations(&self) -> Vec<[u16; 2]> {
        let mut entries = Vec::with_capacity(self.spec.permutations as usize * self.tuples.len());
        for set in 0..self.spec.permutations {
            for stratum in 0..self.samples_per_pixel() {
                let permutation = self.permutation(set, stratum);
                entries.extend(
                    (0..self.num_ranks())
                        .map(|i| [permutation.forward(i) as u16, permutation.inverse(i) as u16]),
                );
            }
        }
        entries
    }
}

/// Appends the K^2 tuples of a stratum.
fn append_stratum(spec: &PatternSpec, strata: &Strata, stratum: u32, tuples: &mut Vec<Tuple>) {
    let num_ranks = spec.tile * spec.tile;
    let m = strata.num();
    let columns = strata.columns[stratum as usize];
    let parts: [Vec<u32>; 5] = std::array::from_fn(|dim| {
        scrambled_order(num_ranks, dim, hash(&[spec.seed, stratum, dim as u32, 4]))
    });
    for rank in 0..num_ranks {
        let jitter = |dim: usize| {
            if spec.jitter { unit(hash(&[spec.seed, stratum, rank, dim as u32, 5])) } else { 0.5 }
        };
        let place = |dim: usize| {
            let in_column = (f64::from(parts[dim][rank as usize]) + jitter(dim)) / f64::from(num_ranks);
            (f64::from(columns[dim]) + in_column) / f64::from(m)
        };
        // A cell of the lens and of time is cut before shape and shutter warp it.
        let [p, q] = [P, Q].map(|dim| {
            // Along each axis the N tuples take the N intervals of width 1/N, one each; with K = 1 these are the
            // strata's columns.
            let (width, column) = (strata.columns_of_cell(dim), u32::from(columns[dim]));
            let part = (column / width) * num_ranks + parts[dim][rank as usize];
            (f64::from(part * width + column % width) + jitter(dim)) / f64::from(m * num_ranks)
        });
        let [u, v] = spec.lens.place(strata.to_disk(p, q));
        let [u15, v15] = [lens15(u * spec.lens_scale[0]), lens15(-v * spec.lens_scale[1])];
        let t_cell = positions_of_cell(strata.time_cell(stratum), m, 32_768);
        let t15 = ((place(T) * 32_768.0) as u32).clamp(t_cell.0, t_cell.1);
        let t15 = match spec.shutter {
            ShutterShape::Box => t15,
            shape => (shape.warp((f64::from(t15) + 0.5) / 32_768.0) * 32_768.0) as u32,
        };
        let sub_pixel = |dim: usize, cell: u32| {
            let num_cells = strata.grid[dim];
            if !spec.jitter {
                let (first, last) = positions_of_cell(cell, num_cells, 256);
                return (first + last).div_ceil(2) as u8;
            }
            // Rounding must leave neither the cell nor, where 1/256 px resolves it, the column.
            let (first, last) = if m <= 256 {
                positions_of_cell(u32::from(columns[dim]), m, 256)
            } else {
                positions_of_cell(cell, num_cells, 256)
            };
            ((place(dim) * 256.0) as u32).clamp(first, last) as u8
        };
        let x = sub_pixel(X, stratum % strata.grid[0]);
        let y = sub_pixel(Y, stratum / strata.grid[0]);
        tuples.push(Tuple { u15, v15, t15: t15.min(32_767) as i16, x, y });
    }
}

/// A lens place times 32768, rounded towards zero so that it stays within the disk.
fn lens15(place: f64) -> i16 {
    (place * 32_768.0).clamp(-32_767.0, 32_767.0) as i16
}

fn bounds_of(tuples: &[Tuple]) -> StratumBounds {
    let span = |of: fn(&Tuple) -> i16| {
        tuples.iter().map(of).fold([i16::MAX, i16::MIN], |[least, most], v| [least.min(v), most.max(v)])
    };
    StratumBounds { u15: span(|t| t.u15), v15: span(|t| t.v15), t15: span(|t| t.t15) }
}
