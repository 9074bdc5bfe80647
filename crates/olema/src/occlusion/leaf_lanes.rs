//! A spatial leaf from its samples: the farthest depth of each slice, and the nearest of all.
//!
//! In: the samples of a leaf, their tuples and records. Out: a node of [`TzPyramid`](super::TzPyramid). Written twice:
//! sample by sample (the oracle), and 16 samples at a time.
//!
//! ```text
//! M = 16, K = 2:  sample j of a pixel is one of the tuples 4 j .. 4 j + 3 of its stratum, j. So a vector of depths for
//!                 each of the four ranks takes the maximum over the leaf's pixels of those that have that rank, and
//!                 its lane j then is what tuple 4 j + rank keeps. A table puts that into the order of slices.
//! ```
//!
//! Sorting sample by sample into slices waits for stores that were just made: it took five times as long. With M
//! below 16 several pixels share a vector, beyond 16 a pixel has several. What fits neither (M = 9, cut leaves of few
//! samples, K above 2) goes to the oracle.

use crate::math::lanes::Lanes;
use crate::math::simd::{LANES, LanesKernel, SimdLevel};

use super::leaf::LeafRows;
use super::pyramid::{Drawn, farther};
use super::slices::Slices;

/// How the depths that are kept apart by lane go into slices.
#[derive(Debug, Clone)]
pub(super) struct LeafKernel {
    /// Ranks that are told apart, 1 or 4; 0 where lanes do not fit the pattern.
    num_ranks: usize,
    /// Vectors of samples a pixel, 1 for several pixels a vector.
    num_blocks: usize,
    /// For each slice the places (block, rank, lane) of its tuples, slice by slice; as many for each.
    places: Vec<u16>,
    /// Farthest depths at those places, on their way.
    kept: Vec<f32>,
}

impl LeafKernel {
    /// The kernel for a pattern's slices.
    pub fn new(slices: &Slices) -> Self {
        let all_ranks = (slices.tile() * slices.tile()) as usize;
        let samples_per_pixel = slices.of_tuple().len() / all_ranks;
        // Where all is one slice, ranks need not be told apart.
        let num_ranks = if slices.num() == 1 { 1 } else { all_ranks };
        let num_blocks = samples_per_pixel.div_ceil(LANES);
        let fits = LANES.is_multiple_of(samples_per_pixel) || samples_per_pixel.is_multiple_of(LANES);
        let mut kernel = LeafKernel { num_ranks, num_blocks, places: Vec::new(), kept: Vec::new() };
        let mut by_slice = vec![Vec::new(); slices.num()];
        for place in 0..num_blocks * num_ranks * LANES {
            let [block, rank, lane] = [place / LANES / num_ranks, place / LANES % num_ranks, place % LANES];
            let stratum = (block * LANES + lane) % samples_per_pixel;
            by_slice[usize::from(slices.of_tuple()[stratum * all_ranks + rank])].push(place as u16);
        }
        let most = by_slice.iter().map(Vec::len).max().unwrap_or(0);
        let all_have_some = by_slice.iter().all(|places| !places.is_empty());
        if !(fits && all_have_some && [1, 4].contains(&num_ranks)) {
            kernel.num_ranks = 0;
            return kernel;
        }
        // One that is taken twice changes no maximum.
        kernel.kept = vec![0.0; num_blocks * num_ranks * LANES];
        kernel.places =
            by_slice.iter().flat_map(|places| places.iter().cycle().take(most)).copied().collect();
        kernel
    }

    /// Computes the node of a leaf, whose slices begin at `first_slice`; the tree over them where there is room for it.
    pub fn compute(
        &mut self,
        level: SimdLevel,
        rows: &LeafRows,
        drawn: Drawn,
        slices: &Slices,
        node: &mut [f32],
        first_slice: usize,
    ) {
        let is_whole = rows.len.is_multiple_of(LANES * self.num_blocks);
        match self.num_ranks {
            1 if is_whole => level.run_lanes(InLanes::<1> { kernel: self, rows, drawn, node, first_slice }),
            4 if is_whole => level.run_lanes(InLanes::<4> { kernel: self, rows, drawn, node, first_slice }),
            _ => one_by_one(rows, drawn, slices, node, first_slice),
        }
    }
}

/// Sample by sample.
pub(super) fn one_by_one(
    rows: &LeafRows,
    drawn: Drawn,
    slices: &Slices,
    node: &mut [f32],
    first_slice: usize,
) {
    // A place for every value of a byte needs no check of bounds.
    let mut slots = [f32::NEG_INFINITY; 256];
    let mut nearest = f32::INFINITY;
    let of_tuple = slices.of_tuple();
    for row in rows.ranges() {
        let tuples = &drawn.samples.tuples[row.clone()];
        for (&tuple, record) in tuples.iter().zip(drawn.buffer.records_of(row)) {
            let slot = &mut slots[usize::from(of_tuple[tuple as usize])];
            *slot = farther(*slot, record.depth);
            nearest = if record.depth < nearest { record.depth } else { nearest };
        }
    }
    node[first_slice..].copy_from_slice(&slots[..slices.num()]);
    fill_tree(node, first_slice, nearest);
}

/// The nodes above the slices.
#[inline(always)]
fn fill_tree(node: &mut [f32], first_slice: usize, nearest: f32) {
    if first_slice == 0 {
        return;
    }
    node[0] = -nearest;
    let mut parents = first_slice / 2;
    while parents > 0 {
        let (above, below) = node.split_at_mut(2 * parents);
        for (parent, pair) in above[parents..].iter_mut().zip(below.chunks_exact(2)) {
            *parent = farther(pair[0], pair[1]);
        }
        parents /= 2;
    }
}

/// 16 samples at a time, `R` ranks apart.
struct InLanes<'a, const R: usize> {
    kernel: &'a mut LeafKernel,
    rows: &'a LeafRows,
    drawn: Drawn<'a>,
    node: &'a mut [f32],
    first_slice: usize,
}

impl<const R: usize> LanesKernel for InLanes<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let LeafKernel { num_blocks, places, kept, .. } = self.kernel;
        let mut nearest = f32::INFINITY;
        for (block, kept) in kept.chunks_exact_mut(R * LANES).enumerate() {
            let near = farthest::<L, R>(lanes, self.rows, self.drawn, [block, *num_blocks], kept);
            nearest = if near < nearest { near } else { nearest };
        }
        let slices = &mut self.node[self.first_slice..];
        let num_each = places.len() / slices.len();
        let kept_at = |place: u16| kept[usize::from(place)];
        if num_each == 1 {
            slices.iter_mut().zip(places.iter()).for_each(|(slice, &place)| *slice = kept_at(place));
        } else {
            for (slice, places) in slices.iter_mut().zip(places.chunks_exact(num_each)) {
                *slice = places.iter().fold(f32::NEG_INFINITY, |most, &place| farther(most, kept_at(place)));
            }
        }
        fill_tree(self.node, self.first_slice, nearest);
    }
}

/// Farthest depths of one block of every pixel's samples, of `[block, blocks]`, rank by rank and lane by lane, into
/// `kept`; the nearest of them.
#[inline(always)]
fn farthest<L: Lanes, const R: usize>(
    lanes: L,
    rows: &LeafRows,
    drawn: Drawn,
    [block, num_blocks]: [usize; 2],
    kept: &mut [f32],
) -> f32 {
    let mut farthest = [lanes.splat_f(f32::NEG_INFINITY); R];
    let mut nearest = lanes.splat_f(f32::INFINITY);
    let rank_bits = lanes.splat(R as i32 - 1);
    for row in rows.ranges() {
        for first in (row.start + block * LANES..row.end).step_by(LANES * num_blocks) {
            let depth = lanes.load_f(drawn.buffer.depths(), first);
            nearest = lanes.lesser(depth, nearest);
            if R == 1 {
                farthest[0] = lanes.greater(depth, farthest[0]);
                continue;
            }
            let mut tuples = [0; LANES];
            let of_samples = &drawn.samples.tuples[first..first + LANES];
            tuples.iter_mut().zip(of_samples).for_each(|(to, &tuple)| *to = tuple as i32);
            let ranks = lanes.and(lanes.load(&tuples, 0), rank_bits);
            for (rank, farthest) in farthest.iter_mut().enumerate() {
                let is_rank = lanes.eq(ranks, lanes.splat(rank as i32));
                let is_farther = lanes.both(is_rank, lanes.lt_f(*farthest, depth));
                *farthest = lanes.select_f(is_farther, depth, *farthest);
            }
        }
    }
    for (rank, &farthest) in farthest.iter().enumerate() {
        lanes.store_f(farthest, kept, rank * LANES);
    }
    least(lanes, nearest)
}

/// The least of all lanes.
#[inline(always)]
fn least<L: Lanes>(lanes: L, v: L::F) -> f32 {
    let mut each = [0.0; LANES];
    lanes.store_f(v, &mut each, 0);
    let mut half = LANES / 2;
    while half > 0 {
        let (low, high) = each.split_at_mut(half);
        for (low, &high) in low.iter_mut().zip(high.iter()) {
            *low = if high < *low { high } else { *low };
        }
        half /= 2;
    }
    each[0]
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::TzPyramid;
    use super::super::pyramid::NodeKind;
    use super::super::slices::SliceOrder;
    use super::*;
    use crate::sampling::hash::Stream;
    use crate::sampling::inside::Weights;
    use crate::sampling::{PatternSpec, Payload, Record, Region, RegionSamples, SampleBuffer, SamplePattern};

    /// A leaf of `rows` by a kernel and by the oracle.
    fn both(
        kernel: &mut LeafKernel,
        level: SimdLevel,
        rows: &LeafRows,
        drawn: Drawn,
        slices: &Slices,
    ) -> [Vec<f32>; 2] {
        let (mut found, mut expected) = (vec![0.0; 2 * slices.num()], vec![0.0; 2 * slices.num()]);
        kernel.compute(level, rows, drawn, slices, &mut found, slices.num());
        one_by_one(rows, drawn, slices, &mut expected, slices.num());
        [found, expected]
    }

    /// Leaves of 4 x 4 pixels in a region of 8 x 8.
    fn differing(
        samples: [u32; 2],
        tile: u32,
        num_slices: u32,
        spoil: impl Fn(&mut LeafKernel),
    ) -> (usize, bool) {
        let pattern = SamplePattern::new(PatternSpec { samples, tile, ..PatternSpec::default() });
        let region = Region::new(0, 8, 0, 8);
        let samples = RegionSamples::new(&pattern, region);
        let mut buffer = SampleBuffer::new(region, samples.samples_per_pixel());
        let mut stream = Stream::new(7);
        for ix in (0..samples.len()).filter(|_| stream.below(20) > 0).collect::<Vec<_>>() {
            let depth = stream.below(1000) as f32 - 300.0;
            let hit = Record { depth, payload: Payload::new(1, 0, 0), weights: Weights(0) };
            buffer.offer(ix, hit, &|_, _| std::cmp::Ordering::Equal);
        }
        let m = samples.samples_per_pixel();
        let drawn = Drawn { samples: &samples, buffer: &buffer };
        let (mut num, mut in_lanes) = (0, true);
        for order in [SliceOrder::Time, SliceOrder::Lens] {
            let slices = Slices::new(&pattern, order, num_slices);
            let mut kernel = LeafKernel::new(&slices);
            in_lanes &= kernel.num_ranks > 0;
            spoil(&mut kernel);
            for level in SimdLevel::all() {
                for (first, len) in [(0, 4), (4 * m, 4), (33 * m, 4), (2 * m, 3)] {
                    let rows = LeafRows { first, len: len * m, step: 8 * m, num: 4 };
                    let [found, expected] = both(&mut kernel, level, &rows, drawn, &slices);
                    num += usize::from(found != expected);
                }
            }
        }
        (num, in_lanes)
    }

    #[test]
    fn lanes_find_what_the_oracle_finds() {
        let cases =
            [([4, 4], 2), ([2, 2], 2), ([4, 4], 1), ([8, 8], 2), ([2, 1], 2), ([32, 32], 1), ([8, 4], 2)];
        for (samples, tile) in cases {
            for num_slices in [64, 16, 1] {
                let found = differing(samples, tile, num_slices, |_| {});
                assert_eq!(found, (0, true), "{samples:?} {tile} {num_slices}");
            }
        }
        for (samples, tile) in [([3, 3], 2), ([4, 4], 4), ([5, 4], 2), ([4, 4], 3)] {
            assert_eq!(differing(samples, tile, 64, |_| {}), (0, false), "{samples:?} {tile}");
        }
    }

    #[test]
    fn a_wrong_table_is_noticed() {
        let (num, _) = differing([4, 4], 2, 64, |kernel| kernel.places.swap(3, 40));
        assert!(num > 0);
    }

    #[test]
    fn pyramids_are_the_same_at_every_level() {
        let pattern = SamplePattern::new(PatternSpec::default());
        let region = Region::new(-3, 21, 2, 29);
        let samples = RegionSamples::new(&pattern, region);
        let mut buffer = SampleBuffer::new(region, samples.samples_per_pixel());
        let mut stream = Stream::new(3);
        for ix in 0..samples.len() {
            let depth = stream.below(1000) as f32;
            let hit = Record { depth, payload: Payload::new(1, 0, 0), weights: Weights(0) };
            buffer.offer(ix, hit, &|_, _| std::cmp::Ordering::Equal);
        }
        let slices = Arc::new(Slices::new(&pattern, SliceOrder::Time, 64));
        let values = |level| {
            let mut pyramid = TzPyramid::new(Arc::clone(&slices), NodeKind::Tree, 4).with_level(level);
            pyramid.renew(&samples);
            pyramid.mark_all([-3, 20, 2, 28]);
            pyramid.all_values(Drawn { samples: &samples, buffer: &buffer })
        };
        let all: Vec<_> = SimdLevel::all().into_iter().map(values).collect();
        assert!(all.iter().all(|values| *values == all[0]));
    }
}
