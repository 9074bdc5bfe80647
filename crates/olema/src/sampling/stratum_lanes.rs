//! Strata as vectors: what [`TupleTimes`](super::TupleTimes) knows of them, 16 side by side.
//!
//! In: the strata of a pattern. Out: what their tuples span in time and on the lens, halves of a lane being pairs as in
//! [`crate::math::lanes`].

use super::pattern::{SamplePattern, StratumBounds};
use crate::math::lanes::pair;
use crate::math::simd::LANES;

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

/// All strata of a pattern, 16 at a time; none where there is more than one motion segment.
pub(super) fn stratum_groups(pattern: &SamplePattern, num_keys: usize) -> Vec<StratumGroup> {
    if num_keys > 2 {
        return Vec::new();
    }
    let num = pattern.samples_per_pixel();
    let group = |first| StratumGroup::new(pattern, first, (num - first).min(LANES as u32), num_keys == 1);
    (0..num).step_by(LANES).map(group).collect()
}
