//! Rows: which pixels hold a tuple, 32 pixels of a row a word.
//!
//! In: the samples of a region. Out: for each tuple a bit for every pixel, set where the pixel holds it. Words overlap by
//! half, so that any 17 pixels of a row lie in one of them; those of a column of words lie below each other, so that
//! 16 rows are one vector, in which a kernel looks up what it needs without leaving its registers.
//!
//! ```text
//! pixels  0 ............ 16 ............ 32 ............ 48
//! word 0  [-----------------------------)
//! word 1                 [-----------------------------)
//! ```

use super::pattern::SamplePattern;
use super::region::RegionSamples;
use crate::math::lanes::Lanes;
use crate::math::simd::{LANES, LanesKernel, SimdLevel};

/// Pixels of a word.
pub(super) const WORD_PX: i32 = 32;
/// Pixels from a word to the next.
pub(super) const WORD_STEP_PX: i32 = 16;

/// Words that are kept at most, 64 MiB; for larger regions there are none.
const MOST_WORDS: usize = 16 << 20;

/// Pixels of a row of [`TileRows`] at most.
const MOST_IN_ROW: u32 = 16;

/// Which pixels of a row of a pattern's tile hold which tuple, for all rows and permutation sets.
#[derive(Debug, Clone)]
pub(super) struct TileRows {
    /// From a row to the next: tuples, up to a whole vector.
    stride: usize,
    /// A bit for each pixel; row after row of each set, tuples in the order of time.
    bits: Vec<i32>,
}

impl TileRows {
    /// The rows of a pattern, unless they are too long.
    pub fn new(pattern: &SamplePattern) -> Option<Self> {
        let (k, num_ranks) = (pattern.tile(), pattern.tile() * pattern.tile());
        if k > MOST_IN_ROW {
            return None;
        }
        let stride = pattern.tuples().len().next_multiple_of(LANES);
        let num_sets = pattern.spec().permutations;
        let mut bits = vec![0; (num_sets * k) as usize * stride];
        for set in 0..num_sets {
            for (place, &tuple) in pattern.by_time().iter().enumerate() {
                let pixel = pattern.pixel_of_rank(set, tuple / num_ranks, tuple % num_ranks);
                bits[(set * k + pixel / k) as usize * stride + place] = 1 << (pixel % k);
            }
        }
        Some(TileRows { stride, bits })
    }

    /// The pixels of a row of a tile of side `k` under a set, for each tuple in the order of time.
    #[inline(always)]
    fn row(&self, set: u32, row: u32, k: u32) -> &[i32] {
        let first = (set * k + row) as usize * self.stride;
        &self.bits[first..first + self.stride]
    }
}

/// Which pixels of a region hold which tuple.
#[derive(Debug, Clone)]
pub(super) struct TupleRows {
    /// Words across.
    num_columns: usize,
    /// Words from a column to the next: rows, and [`LANES`] more without a bit.
    stride: usize,
    /// Column by column for each tuple, in the order of [`SamplePattern::by_time`].
    words: Vec<i32>,
}

impl TupleRows {
    /// The rows of the region of `samples`, unless they are too many. `words` is memory to use.
    pub fn new(pattern: &SamplePattern, samples: &RegionSamples, mut words: Vec<i32>) -> Option<Self> {
        let region = samples.region;
        let num_columns = region.width().div_ceil(WORD_STEP_PX as usize);
        let stride = region.height() + LANES;
        let of_tuple = num_columns * stride;
        let num_tuples = pattern.tuples().len();
        if of_tuple.checked_mul(num_tuples).is_none_or(|num| num > MOST_WORDS) {
            return None;
        }
        words.clear();
        words.resize(num_tuples * of_tuple, 0);
        let mut rows = TupleRows { num_columns, stride, words };
        match pattern.tile_rows() {
            Some(tile_rows) => {
                SimdLevel::best().run_lanes(FromTiles { tile_rows, pattern, samples, rows: &mut rows });
            }
            None => rows.add_samples(pattern, samples),
        }
        Some(rows)
    }

    /// Sets a bit for each sample.
    fn add_samples(&mut self, pattern: &SamplePattern, samples: &RegionSamples) {
        let (region, of_tuple) = (samples.region, self.num_columns * self.stride);
        let mut first_of_tuple = vec![0; pattern.tuples().len()];
        for (place, &ix) in pattern.by_time().iter().enumerate() {
            first_of_tuple[ix as usize] = place * of_tuple;
        }
        let pixels = (0..region.height()).flat_map(|y| (0..region.width()).map(move |x| (x, y)));
        for ((x, y), tuples) in pixels.zip(samples.tuples.chunks_exact(samples.samples_per_pixel())) {
            let column = x / WORD_STEP_PX as usize;
            let bit = 1 << (x % WORD_STEP_PX as usize);
            for &tuple in tuples {
                let word = first_of_tuple[tuple as usize] + column * self.stride + y;
                self.words[word] |= bit;
                if column > 0 {
                    self.words[word - self.stride] |= bit << WORD_STEP_PX;
                }
            }
        }
    }

    /// Its memory, for another region's.
    pub fn into_words(self) -> Vec<i32> {
        self.words
    }

    /// The words of a column, row by row, of the tuple at `place` in the order of time.
    #[inline(always)]
    pub fn column(&self, place: usize, column: usize) -> &[i32] {
        let first = (place * self.num_columns + column) * self.stride;
        &self.words[first..first + self.stride]
    }
}

/// Rows from those of the pattern's tiles, 16 tuples at a time.
struct FromTiles<'a> {
    tile_rows: &'a TileRows,
    pattern: &'a SamplePattern,
    samples: &'a RegionSamples,
    rows: &'a mut TupleRows,
}

impl LanesKernel for FromTiles<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let FromTiles { tile_rows, pattern, samples, rows } = self;
        let (region, k) = (samples.region, pattern.tile() as i32);
        let num_tuples = pattern.tuples().len();
        let of_tuple = rows.num_columns * rows.stride;
        let mut words = [0; LANES];
        for (y, py) in (region.y0..region.y1).enumerate() {
            let (ty, row) = (py.div_euclid(k), py.rem_euclid(k) as u32);
            for place in (0..num_tuples).step_by(LANES) {
                // From right to left: the upper half of a word is the lower one of the word to its right.
                let mut right = lanes.splat(0);
                for column in (0..rows.num_columns).rev() {
                    let px = region.x0 + column as i32 * WORD_STEP_PX;
                    let end = region.x1.min(px + WORD_STEP_PX);
                    let mut half = lanes.splat(0);
                    for tx in px.div_euclid(k)..=(end - 1).div_euclid(k) {
                        let bits =
                            lanes.load(tile_rows.row(samples.set_of_tile(tx, ty), row, k as u32), place);
                        let at = tx * k - px;
                        let moved =
                            if at < 0 { lanes.shr(bits, -at as u32) } else { lanes.shl(bits, at as u32) };
                        half = lanes.or(half, moved);
                    }
                    half = lanes.and(half, lanes.splat((1 << (end - px)) - 1));
                    lanes.store(lanes.or(half, lanes.shl(right, WORD_STEP_PX as u32)), &mut words, 0);
                    right = half;
                    let first = place * of_tuple + column * rows.stride + y;
                    let places = rows.words[first..].iter_mut().step_by(of_tuple);
                    places.zip(&words[..LANES.min(num_tuples - place)]).for_each(|(to, &word)| *to = word);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Region;
    use super::super::pattern::PatternSpec;
    use super::*;

    #[test]
    fn a_bit_tells_whether_a_pixel_holds_the_tuple() {
        for (samples, tile, region) in [
            ([4, 4], 2, Region::new(-3, 30, -1, 6)),
            ([1, 1], 1, Region::new(0, 1, 0, 1)),
            ([2, 2], 3, Region::new(5, 22, 2, 9)),
            ([3, 1], 8, Region::new(-9, 44, 0, 17)),
        ] {
            let pattern = SamplePattern::new(PatternSpec { samples, tile, ..PatternSpec::default() });
            let samples = RegionSamples::new(&pattern, region);
            let rows = TupleRows::new(&pattern, &samples, vec![-1; 9999]).expect("few");
            let mut by_samples = TupleRows { words: vec![0; rows.words.len()], ..rows };
            by_samples.add_samples(&pattern, &samples);
            assert_eq!(rows.words, by_samples.words);
            let m = samples.samples_per_pixel();
            for (place, &tuple) in pattern.by_time().iter().enumerate() {
                for column in 0..rows.num_columns {
                    let words = rows.column(place, column);
                    let holds = |x: usize, y: usize| {
                        let first = || (y * region.width() + x) * m;
                        x < region.width()
                            && y < region.height()
                            && samples.tuples[first()..first() + m].contains(&tuple)
                    };
                    for (y, &word) in words.iter().enumerate() {
                        let bits = (0..32).filter(|bit| holds(16 * column + bit, y)).map(|bit| 1u32 << bit);
                        assert_eq!(word as u32, bits.sum::<u32>(), "tuple {tuple}, column {column}, row {y}");
                    }
                }
            }
        }
    }
}
