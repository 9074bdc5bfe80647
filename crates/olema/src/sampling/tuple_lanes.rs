//! Tuples as vectors: what [`TupleTimes`](super::TupleTimes) knows, 16 tuples side by side.
//!
//! In: the tuples of a pattern and their local times. Out: groups of up to 16 tuples of one motion segment, in order of
//! time. So a vertex has the same two keys for all lanes of a group, and what is hit in a part of the shutter alone
//! takes a part of the groups. Halves of a lane are pairs as in [`crate::math::lanes`].

use std::ops::Range;

use super::moving::LocalTime;
use super::pattern::{SamplePattern, StratumBounds};
use crate::math::lanes::pair;
use crate::math::simd::LANES;

/// Up to 16 tuples of one motion segment; what follows them in a last group is never looked at.
#[derive(Debug, Clone)]
pub(super) struct TupleGroup {
    /// The segment.
    pub segment: usize,
    /// Lanes in use, from the first.
    pub num: u32,
    /// The first one's place in [`SamplePattern::by_time`]; the others follow.
    pub first: usize,
    /// First and last time of the shutter.
    pub times: [i16; 2],
    /// Local time, in both halves.
    pub time: [i32; LANES],
    /// Lens place, u and v.
    pub lens: [i32; LANES],
    /// Place in the pixel in 1/256 px, x and y, each in 0..256.
    pub place: [i32; LANES],
    /// Time of the shutter.
    pub shutter: [i32; LANES],
}

/// Most groups of a block.
pub(super) const GROUPS: usize = 4;

/// The groups, and what is looked up tuple by tuple in the order of [`SamplePattern::by_time`].
#[derive(Debug, Clone)]
pub(super) struct TupleLanes {
    pub groups: Vec<TupleGroup>,
    /// Groups of one segment that a kernel takes together.
    pub blocks: Vec<Range<usize>>,
    /// Local time, in [0, 1).
    pub t: Vec<f32>,
    /// Stratum.
    pub stratum: Vec<i32>,
    /// All strata, 16 at a time; none where there is more than one motion segment.
    pub strata: Vec<StratumGroup>,
}

/// What up to 16 strata span: least and greatest.
#[derive(Debug, Clone)]
pub(super) struct StratumGroup {
    /// Lanes in use, from the first.
    pub num: u32,
    /// Local time, in both halves.
    pub time: [[i32; LANES]; 2],
    /// Lens place, u and v.
    pub lens: [[i32; LANES]; 2],
    /// Time of the shutter.
    pub shutter: [[i32; LANES]; 2],
}

impl StratumGroup {
    fn new(pattern: &SamplePattern, first: u32, num: u32, is_still: bool) -> Self {
        let each = |of: &dyn Fn(&StratumBounds) -> i32| {
            std::array::from_fn(|lane| of(&pattern.stratum_bounds(first + (lane as u32).min(num - 1))))
        };
        // With a single segment local times are those of the shutter; with a single key there are none.
        let local = |t15: i16| if is_still { 0 } else { t15.into() };
        StratumGroup {
            num,
            time: [0, 1].map(|end| each(&|s| pair(local(s.t15[end]), local(s.t15[end])))),
            lens: [0, 1].map(|end| each(&|s| pair(s.u15[end].into(), s.v15[end].into()))),
            shutter: [0, 1].map(|end| each(&|s| s.t15[end].into())),
        }
    }
}

impl TupleLanes {
    /// The tuples of `pattern`, whose local times are `times`.
    pub fn new(pattern: &SamplePattern, times: &[LocalTime], num_keys: usize) -> Self {
        let order = if times.is_empty() { &[] } else { pattern.by_time() };
        let num_ranks = pattern.tile() * pattern.tile();
        let mut lanes = TupleLanes {
            groups: Vec::new(),
            blocks: Vec::new(),
            t: order.iter().map(|&ix| f32::from(times[ix as usize].t15) * (1.0 / 32_768.0)).collect(),
            stratum: order.iter().map(|&ix| (ix / num_ranks) as i32).collect(),
            strata: Vec::new(),
        };
        if num_keys <= 2 {
            let num = pattern.samples_per_pixel();
            let groups = (0..num).step_by(LANES).map(|first| {
                StratumGroup::new(pattern, first, (num - first).min(LANES as u32), num_keys == 1)
            });
            lanes.strata.extend(groups);
        }
        let mut first = 0;
        for segment in order.chunk_by(|&a, &b| times[a as usize].segment == times[b as usize].segment) {
            for block in segment.chunks(GROUPS * LANES) {
                let first_group = lanes.groups.len();
                for tuples in block.chunks(LANES) {
                    lanes.push(pattern, times, tuples, first);
                    first += tuples.len();
                }
                lanes.blocks.push(first_group..lanes.groups.len());
            }
        }
        lanes
    }

    fn push(&mut self, pattern: &SamplePattern, times: &[LocalTime], tuples: &[u32], first: usize) {
        // Lanes that are not in use repeat the last tuple.
        let ix_of = |lane: usize| tuples[lane.min(tuples.len() - 1)];
        let each = |of: &dyn Fn(u32) -> i32| std::array::from_fn(|lane| of(ix_of(lane)));
        let tuple = |ix: u32| pattern.tuples()[ix as usize];
        let t15 = |ix: u32| i32::from(times[ix as usize].t15);
        let shutter = tuples.iter().map(|&ix| tuple(ix).t15);
        self.groups.push(TupleGroup {
            segment: usize::from(times[tuples[0] as usize].segment),
            num: tuples.len() as u32,
            first,
            times: shutter.fold([i16::MAX, i16::MIN], |[first, last], t| [first.min(t), last.max(t)]),
            time: each(&|ix| pair(t15(ix), t15(ix))),
            lens: each(&|ix| pair(tuple(ix).u15.into(), tuple(ix).v15.into())),
            place: each(&|ix| pair(tuple(ix).x.into(), tuple(ix).y.into())),
            shutter: each(&|ix| tuple(ix).t15.into()),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::super::pattern::PatternSpec;
    use super::super::{SamplePattern, TupleTimes};

    #[test]
    fn groups_hold_every_tuple_once_and_one_segment_each() {
        for (samples, tile, keys) in
            [([4, 4], 2, &[0.0, 1.0][..]), ([7, 1], 3, &[0.0, 0.3, 0.35, 1.0]), ([1, 1], 1, &[0.0])]
        {
            let pattern = SamplePattern::new(PatternSpec { samples, tile, ..PatternSpec::default() });
            let times = TupleTimes::new(&pattern, keys);
            let lanes = times.lanes();
            let mut seen = Vec::new();
            for group in &lanes.groups {
                for place in group.first..group.first + group.num as usize {
                    let ix = pattern.by_time()[place];
                    let local = times.of_tuple(ix);
                    assert_eq!(usize::from(local.segment), group.segment);
                    assert_eq!(lanes.t[place] * 32_768.0, f32::from(local.t15));
                    assert!((group.times[0]..=group.times[1]).contains(&pattern.tuples()[ix as usize].t15));
                    seen.push(ix);
                }
            }
            seen.sort_unstable();
            assert!(seen.iter().copied().eq(0..pattern.tuples().len() as u32));
        }
    }
}
