//! Slices: the tuples of a pattern in a binary tree of time, or of places on the lens.
//!
//! In: a [`SamplePattern`]. Out: [`Slices`], for each tuple its slice, and for each node of the tree what its
//! tuples span. A list of tuples is halved at its median until there are as many parts as asked for, so a
//! slice never holds many more tuples than another, whatever the shutter's shape or the number of samples.
//! Halving by time gives the slices of Boulos 2010, section 3.2. Halving the longer side of the lens gives
//! what its section 5 leaves open: neighbours in time are far apart on the lens and the other way round, so
//! the inner nodes of a tree serve one or the other. A slice of one stratum is small in both.
//!
//! ```text
//! tree, 4 slices          1
//!                     2       3
//!                   4   5   6   7     slice s is node num + s
//! ```

use crate::sampling::SamplePattern;
use crate::sampling::pattern::{StratumBounds, Tuple};

/// What a tree of slices orders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SliceOrder {
    /// Time.
    Time,
    /// Place on the lens.
    Lens,
}

/// A tree of slices.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Slices {
    num: usize,
    of_tuple: Vec<u8>,
    spans: Vec<Option<StratumBounds>>,
    witnesses: Vec<Witness>,
    tile: u32,
}

/// A tuple that is asked whether it sees something before anything else is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Witness {
    /// The number of the sample that it is in a pixel, if it is in that pixel.
    pub sample: u32,
    /// The number of the tuple.
    pub tuple: u32,
    /// Its time and lens place.
    pub place: StratumBounds,
}

impl Slices {
    /// Sorts the tuples of `pattern` into at most `num` slices (a power of two, at most 64); fewer where the
    /// pattern has fewer tuples.
    pub fn new(pattern: &SamplePattern, order: SliceOrder, num: u32) -> Self {
        debug_assert!(num.is_power_of_two() && num <= 64, "{num} slices");
        let tuples = pattern.tuples();
        let num = (num as usize).min(tuples.len().next_power_of_two());
        let mut slices = Slices {
            num,
            of_tuple: vec![0; tuples.len()],
            spans: vec![None; 2 * num],
            witnesses: witnesses(pattern),
            tile: pattern.tile(),
        };
        let mut members: Vec<u32> = (0..tuples.len() as u32).collect();
        slices.fill(tuples, order, 1, &mut members);
        slices
    }

    fn fill(&mut self, tuples: &[Tuple], order: SliceOrder, node: usize, members: &mut [u32]) {
        self.spans[node] = span(tuples, members);
        if node >= self.num {
            for &tuple in members.iter() {
                self.of_tuple[tuple as usize] = (node - self.num) as u8;
            }
            return;
        }
        let key = key_of(order, self.spans[node]);
        members.sort_unstable_by_key(|&tuple| (key(&tuples[tuple as usize]), tuple));
        let (early, late) = members.split_at_mut(members.len().div_ceil(2));
        self.fill(tuples, order, 2 * node, early);
        self.fill(tuples, order, 2 * node + 1, late);
    }

    /// Number of slices, a power of two.
    pub fn num(&self) -> usize {
        self.num
    }

    /// Slice of each tuple.
    #[inline(always)]
    pub fn of_tuple(&self) -> &[u8] {
        &self.of_tuple
    }

    /// What the tuples of a node span in time and lens, both ends inclusive; `None` where it has no tuple.
    #[inline(always)]
    pub fn span(&self, node: usize) -> Option<&StratumBounds> {
        self.spans[node].as_ref()
    }

    /// A few tuples, well spread over the time.
    #[inline(always)]
    pub(super) fn witnesses(&self) -> &[Witness] {
        &self.witnesses
    }

    /// Side of the pattern's pixel tile, K: K x K pixels from a multiple of K hold every tuple.
    pub fn tile(&self) -> u32 {
        self.tile
    }
}

fn witnesses(pattern: &SamplePattern) -> Vec<Witness> {
    let by_time = pattern.by_time();
    // The middle one, the ends, what is between these.
    let places = [8, 0, 16, 4, 12].map(|part| (by_time.len() - 1) * part / 16);
    let is_new = |&at: &usize| !places[..at].contains(&places[at]);
    let picked = (0..places.len()).filter(is_new).map(|at| by_time[places[at]]);
    let witness = |tuple: u32| {
        let Tuple { u15, v15, t15, .. } = pattern.tuples()[tuple as usize];
        let place = StratumBounds { u15: [u15; 2], v15: [v15; 2], t15: [t15; 2] };
        Witness { sample: tuple / (pattern.tile() * pattern.tile()), tuple, place }
    };
    picked.map(witness).collect()
}

/// The number by which a node's tuples are halved.
fn key_of(order: SliceOrder, span: Option<StratumBounds>) -> fn(&Tuple) -> i16 {
    let long = |[least, most]: [i16; 2]| i32::from(most) - i32::from(least);
    match (order, span) {
        (SliceOrder::Lens, Some(span)) if long(span.v15) > long(span.u15) => |tuple| tuple.v15,
        (SliceOrder::Lens, _) => |tuple| tuple.u15,
        (SliceOrder::Time, _) => |tuple| tuple.t15,
    }
}

fn span(tuples: &[Tuple], members: &[u32]) -> Option<StratumBounds> {
    let over = |of: fn(&Tuple) -> i16| {
        let values = members.iter().map(|&tuple| of(&tuples[tuple as usize]));
        Some([values.clone().min()?, values.max()?])
    };
    Some(StratumBounds { u15: over(|t| t.u15)?, v15: over(|t| t.v15)?, t15: over(|t| t.t15)? })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::PatternSpec;

    fn pattern(samples: [u32; 2], tile: u32) -> SamplePattern {
        SamplePattern::new(PatternSpec { samples, tile, ..PatternSpec::default() })
    }

    #[test]
    fn sixteen_samples_in_two_by_two_pixels_fill_64_slices_in_order_of_time() {
        let pattern = pattern([4, 4], 2);
        let slices = Slices::new(&pattern, SliceOrder::Time, 64);
        let mut seen = [false; 64];
        for &slice in slices.of_tuple() {
            assert!(!std::mem::replace(&mut seen[usize::from(slice)], true));
        }
        for slice in 1..64 {
            let [before, this] = [slice - 1, slice].map(|s| slices.span(64 + s).expect("a tuple").t15);
            assert!(before[1] < this[0]);
        }
    }

    #[test]
    fn spans_are_nested_and_hold_their_tuples() {
        for (samples, tile) in [([1, 1], 1), ([1, 1], 3), ([7, 1], 1), ([3, 5], 2), ([4, 4], 8)] {
            let pattern = pattern(samples, tile);
            for order in [SliceOrder::Time, SliceOrder::Lens] {
                for num in [1, 4, 16, 64] {
                    check_spans(&pattern, &Slices::new(&pattern, order, num));
                }
            }
        }
    }

    fn check_spans(pattern: &SamplePattern, slices: &Slices) {
        let within = |inner: [i16; 2], outer: [i16; 2]| outer[0] <= inner[0] && inner[1] <= outer[1];
        for (tuple, &slice) in pattern.tuples().iter().zip(slices.of_tuple()) {
            let mut node = slices.num() + usize::from(slice);
            while node > 0 {
                let span = slices.span(node).expect("it has a tuple");
                assert!(within([tuple.t15; 2], span.t15));
                assert!(within([tuple.u15; 2], span.u15) && within([tuple.v15; 2], span.v15));
                node /= 2;
            }
        }
        let mut counts = vec![0; slices.num()];
        slices.of_tuple().iter().for_each(|&slice| counts[usize::from(slice)] += 1);
        let most = counts.iter().max().expect("a slice");
        assert!(*most <= pattern.tuples().len().div_ceil(slices.num()), "{counts:?}");
    }

    /// Each stratum has one cell of time and one of the lens, so a slice of one stratum is small in both; only
    /// slices and nodes of several strata tell the orders apart.
    #[test]
    fn large_parts_are_small_in_what_they_order_and_small_parts_in_both() {
        let pattern = pattern([4, 4], 2);
        let mean = |order, num, size: fn(&StratumBounds) -> f64| {
            let slices = Slices::new(&pattern, order, num);
            let num = slices.num();
            (num..2 * num).filter_map(|node| slices.span(node)).map(size).sum::<f64>() / num as f64
        };
        fn length([least, most]: [i16; 2]) -> f64 {
            (f64::from(most) - f64::from(least)) / 32_768.0
        }
        let lens: fn(&StratumBounds) -> f64 = |span| length(span.u15) * length(span.v15) / 4.0;
        let time: fn(&StratumBounds) -> f64 = |span| length(span.t15);
        use SliceOrder::{Lens, Time};
        assert!(mean(Lens, 4, lens) < 0.25 && mean(Lens, 4, time) > 0.5);
        assert!(mean(Time, 4, lens) > 0.4 && mean(Time, 4, time) < 0.25);
        assert!(mean(Time, 16, lens) < 0.06 && mean(Time, 16, time) < 0.06);
    }
}
