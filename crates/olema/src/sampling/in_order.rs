//! Tuples in the order of time, as lists: what [`TupleTimes`](super::TupleTimes) knows of them, to be loaded 16 at a time.
//!
//! In: a pattern and the local times of its tuples. Out: local times and lens places side by side, halves of a lane being
//! pairs as in [`crate::math::lanes`], and which of them are in a motion segment and in a part of the shutter.

use std::ops::Range;

use super::moving::LocalTime;
use super::pattern::SamplePattern;
use crate::math::lanes::pair;
use crate::math::simd::LANES;

/// Tuples by their place in [`SamplePattern::by_time`].
#[derive(Debug, Clone, Default)]
pub(super) struct InOrder {
    /// The first place of each segment, and one after the last.
    segments: Vec<usize>,
    /// Times of the shutter.
    shutter: Vec<i16>,
    /// Local times, in both halves, with room for a vector.
    pub time: Vec<i32>,
    /// Lens places, u and v, likewise.
    pub lens: Vec<i32>,
}

impl InOrder {
    /// Of a pattern whose tuples have local times among `num_segments`.
    pub fn new(pattern: &SamplePattern, num_segments: usize, times: &[LocalTime]) -> Self {
        let all = || pattern.by_time().iter().map(|&ix| (pattern.tuples()[ix as usize], times[ix as usize]));
        let before = |segment| all().filter(|(_, time)| usize::from(time.segment) < segment).count();
        let padded = |values: &mut dyn Iterator<Item = i32>| {
            values.chain(std::iter::repeat_n(0, LANES)).collect::<Vec<_>>()
        };
        InOrder {
            segments: (0..=num_segments).map(before).collect(),
            shutter: all().map(|(tuple, _)| tuple.t15).collect(),
            time: padded(&mut all().map(|(_, time)| pair(time.t15.into(), time.t15.into()))),
            lens: padded(&mut all().map(|(tuple, _)| pair(tuple.u15.into(), tuple.v15.into()))),
        }
    }

    /// Places of the tuples of a segment whose times of the shutter are `from` to `to`.
    pub fn places(&self, segment: usize, [from, to]: [i16; 2]) -> Range<usize> {
        let start = self.shutter.partition_point(|&time| time < from).max(self.segments[segment]);
        let end = self.shutter.partition_point(|&time| time <= to).min(self.segments[segment + 1]);
        start..end.max(start)
    }
}

#[cfg(test)]
mod tests {
    use super::super::TupleTimes;
    use super::super::pattern::PatternSpec;
    use super::*;

    #[test]
    fn places_of_a_segment_are_its_tuples_of_these_times() {
        let pattern = SamplePattern::new(PatternSpec { samples: [4, 3], tile: 3, ..PatternSpec::default() });
        for key_times in [&[0.0][..], &[0.0, 1.0], &[0.0, 0.001, 0.3, 1.0]] {
            let times = TupleTimes::new(&pattern, key_times);
            for range in [[0, i16::MAX], [0, 9_000], [9_000, 20_000], [31_000, 3]] {
                let mut seen = Vec::new();
                for segment in 0..(key_times.len() - 1).max(1) {
                    for place in times.in_order().places(segment, range) {
                        let ix = pattern.by_time()[place];
                        let (tuple, time) = (pattern.tuples()[ix as usize], times.of_tuple(ix));
                        assert_eq!(usize::from(time.segment), segment);
                        let (t15, lens) = (pair(time.t15.into(), time.t15.into()), [tuple.u15, tuple.v15]);
                        assert_eq!(times.in_order().time[place], t15);
                        assert_eq!(times.in_order().lens[place], pair(lens[0].into(), lens[1].into()));
                        seen.push(ix);
                    }
                }
                let is_seen = |&ix: &u32| (range[0]..=range[1]).contains(&pattern.tuples()[ix as usize].t15);
                let expected: Vec<u32> = pattern.by_time().iter().copied().filter(is_seen).collect();
                assert_eq!(seen, expected, "{key_times:?} {range:?}");
            }
        }
    }
}
