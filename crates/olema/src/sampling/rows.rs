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
use crate::math::simd::LANES;

/// Pixels of a word.
pub(super) const WORD_PX: i32 = 32;
/// Pixels from a word to the next.
pub(super) const WORD_STEP_PX: i32 = 16;

/// Words that are kept at most, 64 MiB; for larger regions there are none.
const MOST_WORDS: usize = 16 << 20;

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
    /// The rows of the region of `samples`, unless they are too many.
    pub fn new(pattern: &SamplePattern, samples: &RegionSamples) -> Option<Self> {
        let region = samples.region;
        let num_columns = region.width().div_ceil(WORD_STEP_PX as usize);
        let stride = region.height() + LANES;
        let of_tuple = num_columns * stride;
        let num_tuples = pattern.tuples().len();
        if of_tuple.checked_mul(num_tuples).is_none_or(|num| num > MOST_WORDS) {
            return None;
        }
        let mut first_of_tuple = vec![0; num_tuples];
        for (place, &ix) in pattern.by_time().iter().enumerate() {
            first_of_tuple[ix as usize] = place * of_tuple;
        }
        let mut words = vec![0i32; num_tuples * of_tuple];
        let pixels = (0..region.height()).flat_map(|y| (0..region.width()).map(move |x| (x, y)));
        for ((x, y), tuples) in pixels.zip(samples.tuples.chunks_exact(samples.samples_per_pixel())) {
            let column = x / WORD_STEP_PX as usize;
            let bit = 1 << (x % WORD_STEP_PX as usize);
            for &tuple in tuples {
                let word = first_of_tuple[tuple as usize] + column * stride + y;
                words[word] |= bit;
                if column > 0 {
                    words[word - stride] |= bit << WORD_STEP_PX;
                }
            }
        }
        Some(TupleRows { num_columns, stride, words })
    }

    /// The words of a column, row by row, of the tuple at `place` in the order of time.
    #[inline(always)]
    pub fn column(&self, place: usize, column: usize) -> &[i32] {
        let first = (place * self.num_columns + column) * self.stride;
        &self.words[first..first + self.stride]
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
            let rows = TupleRows::new(&pattern, &samples).expect("few");
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
