//! Moving, defocused grids: where a vertex is for a tuple.
//!
//! In: vertices at motion keys in 1/256 px, their circles of confusion, and a tuple (u, v, t). Out: the exact
//! position and the depth that every rasterizer uses. Sources: the tuples are Fatahalian 2009, section 3.2.2;
//! moving a vertex by its circle of confusion is Sattlecker 2015, section 3.3.
//!
//! Time runs over *motion segments*: segment s lies between keys s and s + 1, with a local time t in [0, 1).
//! With t15, u15, v15 a local time and a lens place times 32768, all in integers,
//!
//! ```text
//! c = c0 + ((t15 * (c1 - c0) + 2^14) >> 15)
//! x = x0 + ((t15 * (x1 - x0) + 2^14) >> 15) + ((u15 * c + 2^14) >> 15)      y likewise, with v15
//! ```
//!
//! Each rounded term is monotone in t15 and, for a given c, in u15: a bound from the ends of a range of time
//! and lens is exact, with no margin for rounding.
//!
//! Limits: |x|, |y| at most [`GUARD_BAND`] = 2^29, |c| at most [`COC_LIMIT`] = 2^28. Then products are below
//! 2^46, positions within 3 * 2^28, and an edge function of such positions and samples within
//! 2 * (3 * 2^29)^2 = 9 * 2^59 < 2^63: nothing overflows an i64.

use std::ops::Range;

use super::in_order::InOrder;
use super::inside::{GUARD_BAND, greater, lesser};
use super::nomotion::GridView;
use super::pattern::{SamplePattern, StratumBounds, Tuple};
use super::stratum_lanes::{StratumGroup, stratum_groups};

/// Largest radius of a circle of confusion, in 1/256 px.
pub const COC_LIMIT: i32 = 1 << 28;

/// A time within a motion segment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct LocalTime {
    /// Key before; the next is the key after.
    pub segment: u16,
    /// Local time times 32768, in 0..=32767.
    pub t15: i16,
}

/// The local times of a pattern's tuples and strata for one set of key times, so that no inner loop divides.
///
/// All patches of a welded surface share one table, or shared edges would round differently.
#[derive(Debug, Clone)]
pub struct TupleTimes {
    key_times: Vec<f32>,
    tuples: Vec<LocalTime>,
    strata: Vec<[LocalTime; 2]>,
    lanes: Vec<StratumGroup>,
    in_order: InOrder,
}

impl TupleTimes {
    /// The table for keys at `key_times`, at least one; where there are more, they ascend strictly from 0 to 1
    /// (the shutter), in even steps or not.
    pub fn new(pattern: &SamplePattern, key_times: &[f32]) -> Self {
        let strictly = |w: &[f32]| w[0] < w[1];
        debug_assert!(
            key_times.len() == 1
                || (key_times.first() == Some(&0.0)
                    && key_times.last() == Some(&1.0)
                    && key_times.windows(2).all(strictly)),
            "key times {key_times:?}"
        );
        let mut times = TupleTimes {
            key_times: key_times.to_vec(),
            tuples: Vec::new(),
            strata: Vec::new(),
            lanes: stratum_groups(pattern, key_times.len().max(1)),
            in_order: InOrder::default(),
        };
        times.tuples = pattern.tuples().iter().map(|tuple| times.locate(tuple.t15)).collect();
        times.strata = (0..pattern.samples_per_pixel())
            .map(|stratum| pattern.stratum_bounds(stratum).t15.map(|t15| times.locate(t15)))
            .collect();
        times.in_order = InOrder::new(pattern, (times.num_keys() - 1).max(1), &times.tuples);
        times
    }

    /// The strata as vectors; none where there is more than one segment.
    pub(super) fn stratum_groups(&self) -> &[StratumGroup] {
        &self.lanes
    }

    /// The tuples as vectors, in the order of time.
    pub(super) fn in_order(&self) -> &InOrder {
        &self.in_order
    }

    /// Times of the keys.
    pub fn key_times(&self) -> &[f32] {
        &self.key_times
    }

    /// Number of keys, at least 1.
    #[inline(always)]
    pub fn num_keys(&self) -> usize {
        self.key_times.len().max(1)
    }

    /// Local time of a tuple.
    #[inline(always)]
    pub fn of_tuple(&self, tuple_ix: u32) -> LocalTime {
        self.tuples[tuple_ix as usize]
    }

    /// Local times of the earliest and the latest tuple of a stratum.
    #[inline(always)]
    pub fn of_stratum(&self, stratum: u32) -> [LocalTime; 2] {
        self.strata[stratum as usize]
    }

    /// Local time of shutter time `t15` / 32768; later times have later or equal local times.
    pub fn locate(&self, t15: i16) -> LocalTime {
        let num_keys = self.num_keys();
        if num_keys == 1 {
            return LocalTime::default();
        }
        let t = f64::from(t15) / 32_768.0;
        let before = self.key_times.partition_point(|&key| f64::from(key) <= t).clamp(1, num_keys - 1);
        let [from, to] = [before - 1, before].map(|key| f64::from(self.key_times[key]));
        let local = ((t - from) / (to - from) * 32_768.0) as i32;
        LocalTime { segment: (before - 1) as u16, t15: local.clamp(0, 32_767) as i16 }
    }
}

/// The vertices of a grid of m x n quads over time: vertex (i, j) at key k is at
/// `k * (m + 1) (n + 1) + j * (m + 1) + i`.
#[derive(Debug, Clone, Copy)]
pub struct MovingGrid<'a> {
    /// Quads along i.
    pub m: usize,
    /// Quads along j.
    pub n: usize,
    /// Local times of the tuples between the keys; also says how many keys there are.
    pub times: &'a TupleTimes,
    /// Raster x in 1/256 px.
    pub x: &'a [i32],
    /// Raster y in 1/256 px.
    pub y: &'a [i32],
    /// Depth.
    pub depth: &'a [f32],
    /// Signed radius of the circle of confusion in 1/256 px; empty where all is in focus.
    pub coc: &'a [i32],
}

/// A box on the raster: first and last 1/256 px along x and y, both inclusive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Extent {
    /// Least x and y.
    pub least: [i32; 2],
    /// Greatest x and y.
    pub most: [i32; 2],
}

impl Extent {
    /// Around nothing.
    pub const EMPTY: Extent = Extent { least: [i32::MAX; 2], most: [i32::MIN; 2] };

    /// Around points.
    #[inline(always)]
    pub fn around(points: &[[i32; 2]]) -> Self {
        let mut extent = Extent::EMPTY;
        for &point in points {
            extent.add(Extent { least: point, most: point });
        }
        extent
    }

    /// Grows to contain another.
    #[inline(always)]
    pub fn add(&mut self, other: Extent) {
        for axis in 0..2 {
            self.least[axis] = self.least[axis].min(other.least[axis]);
            self.most[axis] = self.most[axis].max(other.most[axis]);
        }
    }
}

impl<'a> MovingGrid<'a> {
    /// Number of vertices at each key.
    #[inline(always)]
    pub fn num_vertices(&self) -> usize {
        (self.m + 1) * (self.n + 1)
    }

    /// Number of keys.
    #[inline(always)]
    pub fn num_keys(&self) -> usize {
        self.times.num_keys()
    }

    /// Vertices v0 v1 v2 v3 of quad (i, j), see [`super::inside`].
    #[inline(always)]
    pub fn corners(&self, i: usize, j: usize) -> [usize; 4] {
        let v0 = j * (self.m + 1) + i;
        [v0, v0 + 1, v0 + self.m + 2, v0 + self.m + 1]
    }

    /// Indices of a vertex at the keys before and after a segment (one and the same with a single key).
    #[inline(always)]
    pub(crate) fn ends(&self, vertex: usize, segment: u16) -> [usize; 2] {
        let from = usize::from(segment) * self.num_vertices() + vertex;
        [from, if self.num_keys() == 1 { from } else { from + self.num_vertices() }]
    }

    /// Values of a range of vertices at the keys before and after a segment.
    #[inline(always)]
    pub(super) fn ends_of<'v, T>(
        &self,
        values: &'v [T],
        vertices: &Range<usize>,
        segment: usize,
    ) -> [&'v [T]; 2] {
        let [from, to] = self.ends(vertices.start, segment as u16);
        [&values[from..from + vertices.len()], &values[to..to + vertices.len()]]
    }

    /// Position of a vertex for a tuple, whose local time is `time`.
    #[inline(always)]
    pub fn position(&self, vertex: usize, tuple: &Tuple, time: LocalTime) -> [i32; 2] {
        let ends = self.ends(vertex, time.segment);
        let [x, y] = [between(self.x, ends, time.t15), between(self.y, ends, time.t15)];
        if self.coc.is_empty() {
            return [x, y];
        }
        let c = between(self.coc, ends, time.t15);
        [x + scaled(tuple.u15, c), y + scaled(tuple.v15, c)]
    }

    /// Depth of a vertex at a local time: in f32 and in this order `z0 + t (z1 - z0)`, t = t15 / 32768, then
    /// clamped to the range of z0 and z1.
    #[inline(always)]
    pub fn depth_at(&self, vertex: usize, time: LocalTime) -> f32 {
        let [z0, z1] = self.ends(vertex, time.segment).map(|ix| self.depth[ix]);
        let t = f32::from(time.t15) * (1.0 / 32_768.0);
        let depth = z0 + t * (z1 - z0);
        // The upper clamp last, and both keeping the bound on a tie: z0 = z1 gives the bits of z0.
        lesser(greater(depth, lesser(z0, z1)), greater(z0, z1))
    }

    /// Bound of a vertex over a range of local times and a cell of the lens.
    #[inline(always)]
    pub fn extent(&self, vertex: usize, times: [LocalTime; 2], lens: &StratumBounds) -> Extent {
        let [first, last] = times;
        let mut extent = Extent::EMPTY;
        for segment in first.segment..=last.segment {
            let from = if segment == first.segment { first.t15 } else { 0 };
            let to = if segment == last.segment { last.t15 } else { i16::MAX };
            let ends = self.ends(vertex, segment);
            let range = |values: &[i32]| sorted(between(values, ends, from), between(values, ends, to));
            let [x, y] = [range(self.x), range(self.y)];
            let [du, dv] = if self.coc.is_empty() {
                [[0; 2]; 2]
            } else {
                let c = range(self.coc);
                [products(lens.u15, c), products(lens.v15, c)]
            };
            extent.add(Extent { least: [x[0] + du[0], y[0] + dv[0]], most: [x[1] + du[1], y[1] + dv[1]] });
        }
        extent
    }

    /// The grid as NoMotion sees it, if it stands still and is in focus.
    pub fn still(&self) -> Option<GridView<'a>> {
        let num = self.num_vertices();
        let repeats = |values: &[i32]| values.chunks(num).skip(1).all(|key| key == &values[..num]);
        let depth_repeats = |values: &[f32]| {
            let bits = |v: &f32| v.to_bits();
            values.chunks(num).skip(1).all(|key| key.iter().map(bits).eq(values[..num].iter().map(bits)))
        };
        let is_still = self.coc.iter().all(|&c| c == 0)
            && repeats(self.x)
            && repeats(self.y)
            && depth_repeats(self.depth);
        is_still.then(|| GridView {
            m: self.m,
            n: self.n,
            x: &self.x[..num],
            y: &self.y[..num],
            depth: &self.depth[..num],
        })
    }

    /// Whether the arrays have the lengths, and the values the ranges, that they must have.
    pub fn is_well_formed(&self) -> bool {
        let len = self.num_keys() * self.num_vertices();
        let within = |values: &[i32], limit: i32| values.iter().all(|&v| (-limit..=limit).contains(&v));
        [self.x.len(), self.y.len(), self.depth.len()] == [len; 3]
            && (self.coc.is_empty() || self.coc.len() == len)
            && within(self.x, GUARD_BAND)
            && within(self.y, GUARD_BAND)
            && within(self.coc, COC_LIMIT)
    }
}

/// `values` between two entries.
#[inline(always)]
fn between(values: &[i32], [from, to]: [usize; 2], t15: i16) -> i32 {
    let [v0, v1] = [i64::from(values[from]), i64::from(values[to])];
    (v0 + ((i64::from(t15) * (v1 - v0) + (1 << 14)) >> 15)) as i32
}

/// `value` times a fraction of 2^15, rounded.
#[inline(always)]
pub fn scaled(fraction15: i16, value: i32) -> i32 {
    ((i64::from(fraction15) * i64::from(value) + (1 << 14)) >> 15) as i32
}

#[inline(always)]
fn sorted(a: i32, b: i32) -> [i32; 2] {
    [a.min(b), a.max(b)]
}

/// Range of the products of two ranges.
#[inline(always)]
fn products(fractions: [i16; 2], values: [i32; 2]) -> [i32; 2] {
    let [a, b] = fractions.map(|fraction| values.map(|value| scaled(fraction, value)));
    [a[0].min(a[1]).min(b[0].min(b[1])), a[0].max(a[1]).max(b[0].max(b[1]))]
}

#[cfg(test)]
mod tests {
    use super::super::pattern::PatternSpec;
    use super::*;
    use proptest::prelude::*;

    fn pattern() -> SamplePattern {
        SamplePattern::new(PatternSpec::default())
    }

    #[test]
    fn two_keys_take_the_tuple_s_time_and_one_key_takes_none() {
        let pattern = pattern();
        let [two, one] = [&[0.0, 1.0][..], &[0.0]].map(|keys| TupleTimes::new(&pattern, keys));
        for (ix, tuple) in pattern.tuples().iter().enumerate() {
            assert_eq!(two.of_tuple(ix as u32), LocalTime { segment: 0, t15: tuple.t15 });
            assert_eq!(one.of_tuple(ix as u32), LocalTime::default());
        }
    }

    #[test]
    fn a_key_belongs_to_the_segment_that_it_begins() {
        let times = TupleTimes::new(&pattern(), &[0.0, 0.25, 0.75, 1.0]);
        let at = |t15| {
            let LocalTime { segment, t15 } = times.locate(t15);
            (segment, t15)
        };
        assert_eq!(at(0), (0, 0));
        assert_eq!(at(8191), (0, 32_764));
        assert_eq!(at(8192), (1, 0));
        assert_eq!(at(16_384), (1, 16_384));
        assert_eq!(at(24_576), (2, 0));
        assert_eq!(at(32_767), (2, 32_764));
    }

    #[test]
    fn positions_worked_by_hand() {
        let times = TupleTimes::new(&pattern(), &[0.0, 1.0]);
        let (x, y, depth, coc) = ([0; 8], [0; 8], [1.0; 8], [0; 8]);
        let (mut x, mut coc) = (x, coc);
        (x[0], x[4], coc[0], coc[4]) = (100, 103, 10, -10);
        let grid = MovingGrid { m: 1, n: 1, times: &times, x: &x, y: &y, depth: &depth, coc: &coc };
        let at = |u15, v15, t15| {
            let tuple = Tuple { u15, v15, t15, x: 0, y: 0 };
            grid.position(0, &tuple, LocalTime { segment: 0, t15 })
        };
        assert_eq!(at(0, 0, 0), [100, 0]);
        // 1.5 rounds up to 2; the radius is 0 at the middle.
        assert_eq!(at(32_767, -32_767, 16_384), [102, 0]);
        // Half of 10 is 5, half of -10 is -5; just below half rounds to the same.
        assert_eq!(at(16_384, -16_384, 0), [105, -5]);
        assert_eq!(at(16_383, -16_383, 0), [105, -5]);
        // t = 3/4: 2.25 rounds to 2; the radius is -5, times 1/2 is -2.5, which rounds up to -2.
        assert_eq!(at(16_384, 0, 24_576), [100, 0]);
    }

    #[test]
    fn equal_depths_keep_their_bits() {
        let times = TupleTimes::new(&pattern(), &[0.0, 1.0]);
        for z in [0.1f32, -0.0, 0.0, 1e-40, 3e38, f32::INFINITY] {
            let grid = MovingGrid { m: 1, n: 1, times: &times, x: &[], y: &[], depth: &[z; 8], coc: &[] };
            let at = grid.depth_at(1, LocalTime { segment: 0, t15: 12_345 });
            assert_eq!(at.to_bits(), z.to_bits(), "{z}");
        }
    }

    proptest! {
        #[test]
        fn a_vertex_stays_within_its_extent(
            values in prop::collection::vec((-GUARD_BAND..=GUARD_BAND, -COC_LIMIT..=COC_LIMIT, 0u32..22), 12),
            stratum in 0u32..16,
            split in 1u32..1000,
        ) {
            let pattern = pattern();
            let times = TupleTimes::new(&pattern, &[0.0, split as f32 / 1000.0, 1.0]);
            let small: Vec<i32> = values.iter().map(|&(v, _, shift)| v >> shift).collect();
            let coc: Vec<i32> = values.iter().map(|&(_, c, shift)| c >> shift).collect();
            let grid = MovingGrid {
                m: 1, n: 1, times: &times, x: &small, y: &small, depth: &[0.0; 12], coc: &coc,
            };
            prop_assert!(grid.is_well_formed());
            let bounds = pattern.stratum_bounds(stratum);
            for vertex in 0..4 {
                let extent = grid.extent(vertex, times.of_stratum(stratum), &bounds);
                for rank in 0..4 {
                    let ix = stratum * 4 + rank;
                    let [x, y] =
                        grid.position(vertex, &pattern.tuples()[ix as usize], times.of_tuple(ix));
                    prop_assert!((extent.least[0]..=extent.most[0]).contains(&x));
                    prop_assert!((extent.least[1]..=extent.most[1]).contains(&y));
                }
            }
        }
    }
}
