//! The pyramid against oracles that look at every sample.

use std::sync::Arc;

use proptest::prelude::*;

use super::pyramid::NodeKind;
use super::*;
use crate::sampling::inside::Weights;
use crate::sampling::pattern::StratumBounds;
use crate::sampling::{
    PatternSpec, Payload, Record, Region, RegionSamples, SampleBuffer, SamplePattern, Tuple, hash::Stream,
};

/// A box that moves, comes nearer or goes away, and is out of focus: all linear, in whole numbers.
#[derive(Debug, Clone, Copy)]
struct Thing {
    /// Left, right, top, bottom pixel at time 0 for the lens's middle, inclusive.
    pixels: [i32; 4],
    /// Pixels that it goes in x and y.
    motion: [i32; 2],
    /// Pixels that it is shifted at the lens's border.
    blur: i32,
    /// Depth at times 0 and 1.
    depth: [i32; 2],
}

impl Thing {
    fn still(pixels: [i32; 4], depth: i32) -> Self {
        Thing { pixels, motion: [0; 2], blur: 0, depth: [depth; 2] }
    }

    /// `from + (t15 * by) / 2^15`, rounded down: monotonic in t15.
    fn moved(from: i32, by: i32, t15: i16) -> i32 {
        from + ((i64::from(t15) * i64::from(by)) >> 15) as i32
    }

    fn at(&self, tuple: &Tuple) -> ([i32; 4], f32) {
        let one = |value: i16| [value; 2];
        let span = StratumBounds { u15: one(tuple.u15), v15: one(tuple.v15), t15: one(tuple.t15) };
        let bounds = self.over(&span);
        (bounds.pixels, bounds.near)
    }

    fn over(&self, span: &StratumBounds) -> Bounds {
        let range = |by: i32, part: [i16; 2]| {
            let ends = part.map(|value| Self::moved(0, by, value));
            [ends[0].min(ends[1]), ends[0].max(ends[1])]
        };
        let (x, y) = (range(self.motion[0], span.t15), range(self.motion[1], span.t15));
        let (u, v) = (range(self.blur, span.u15), range(self.blur, span.v15));
        let depth = span.t15.map(|t15| Self::moved(self.depth[0], self.depth[1] - self.depth[0], t15));
        let [x0, x1, y0, y1] = self.pixels;
        Bounds {
            pixels: [x0 + x[0] + u[0], x1 + x[1] + u[1], y0 + y[0] + v[0], y1 + y[1] + v[1]],
            near: depth[0].min(depth[1]) as f32,
            still: self.motion == [0; 2] && self.blur == 0 && self.depth[0] == self.depth[1],
        }
    }
}

/// Samples of a region, what hit them, and how to cull.
struct Tile {
    pattern: SamplePattern,
    samples: RegionSamples,
    buffer: SampleBuffer,
}

impl Tile {
    fn new(samples: [u32; 2], tile: u32, region: Region) -> Self {
        let pattern = SamplePattern::new(PatternSpec { samples, tile, ..PatternSpec::default() });
        let samples = RegionSamples::new(&pattern, region);
        let buffer = SampleBuffer::new(region, samples.samples_per_pixel());
        Tile { pattern, samples, buffer }
    }

    fn tuple(&self, sample_ix: usize) -> &Tuple {
        &self.pattern.tuples()[self.samples.tuples[sample_ix] as usize]
    }

    fn pixel(&self, sample_ix: usize) -> [i32; 2] {
        self.samples.position(sample_ix).map(|c| c >> 8)
    }

    fn offer(&mut self, sample_ix: usize, depth: f32) {
        let hit = Record { depth, payload: Payload::new(1, 0, 0), weights: Weights(0) };
        self.buffer.offer(sample_ix, hit, &|_, _| std::cmp::Ordering::Equal);
    }

    /// Writes every record again, so that all are marked.
    fn mark_all(&mut self) {
        let records = self.buffer.records().collect::<Vec<_>>();
        self.buffer.renew(self.samples.region);
        for (ix, record) in records.iter().enumerate().filter(|(_, record)| !record.is_none()) {
            self.offer(ix, record.depth);
        }
    }

    /// Draws a thing exactly.
    fn draw(&mut self, thing: &Thing) {
        for ix in 0..self.samples.len() {
            let (pixels, depth) = thing.at(self.tuple(ix));
            if holds(pixels, self.pixel(ix)) {
                self.offer(ix, depth);
            }
        }
    }

    /// Hits `per_cent` of the samples in `pixels` at random depths in 1..=`deepest`.
    fn fill(&mut self, pixels: [i32; 4], per_cent: u32, deepest: u32, stream: &mut Stream) {
        for ix in 0..self.samples.len() {
            if holds(pixels, self.pixel(ix)) && stream.below(100) < per_cent {
                self.offer(ix, (1 + stream.below(deepest)) as f32);
            }
        }
    }

    fn pyramid(&self, kind: NodeKind, order: SliceOrder, leaf_px: u32, num_slices: u32) -> TzPyramid {
        let slices = Arc::new(Slices::new(&self.pattern, order, num_slices));
        let mut pyramid = TzPyramid::new(slices, kind, leaf_px);
        pyramid.renew(&self.samples);
        let Region { x0, x1, y0, y1 } = self.samples.region;
        pyramid.mark_all([x0, x1 - 1, y0, y1 - 1]);
        pyramid
    }

    fn drawn(&self) -> Drawn<'_> {
        Drawn { samples: &self.samples, buffer: &self.buffer }
    }

    fn ask(&self, pyramid: &mut TzPyramid, thing: &Thing) -> (bool, DepthReads) {
        let mut reads = DepthReads::default();
        let occluded = pyramid.is_occluded(self.drawn(), |span| thing.over(span), &mut reads);
        (occluded, reads)
    }

    /// Whether some sample that the thing may hit keeps nothing nearer.
    fn is_seen(&self, thing: &Thing) -> bool {
        (0..self.samples.len()).any(|ix| {
            let (pixels, near) = thing.at(self.tuple(ix));
            holds(pixels, self.pixel(ix)) && self.buffer.get(ix).depth >= near
        })
    }

    /// The same with the thing's box grown to whole leaves and slices.
    fn is_seen_by_leaf(&self, thing: &Thing, slices: &Slices, leaf_px: i32) -> bool {
        let leaf = |c: i32| c.div_euclid(leaf_px);
        let Region { x0, x1, y0, y1 } = self.samples.region;
        (0..self.samples.len()).any(|ix| {
            let slice = slices.of_tuple()[self.samples.tuples[ix] as usize];
            let span = slices.span(slices.num() + usize::from(slice)).expect("it holds this tuple");
            let Bounds { pixels: p, near, .. } = thing.over(span);
            let p = [p[0].max(x0), p[1].min(x1 - 1), p[2].max(y0), p[3].min(y1 - 1)];
            p[0] <= p[1]
                && p[2] <= p[3]
                && holds(p.map(leaf), self.pixel(ix).map(leaf))
                && self.buffer.get(ix).depth >= near
        })
    }
}

fn holds([x0, x1, y0, y1]: [i32; 4], [x, y]: [i32; 2]) -> bool {
    (x0..=x1).contains(&x) && (y0..=y1).contains(&y)
}

fn regions() -> impl Strategy<Value = Region> {
    let side = prop::sample::select(vec![1, 2, 3, 5, 7, 8, 11, 16, 17, 23]);
    (-9i32..9, -9i32..9, side.clone(), side).prop_map(|(x, y, w, h)| Region::new(x, x + w, y, y + h))
}

fn patterns() -> impl Strategy<Value = ([u32; 2], u32)> {
    prop::sample::select(vec![
        ([1, 1], 1),
        ([1, 1], 2),
        ([2, 1], 3),
        ([4, 4], 1),
        ([4, 4], 2),
        ([3, 3], 2),
        ([7, 1], 1),
        ([2, 2], 8),
        ([5, 4], 2),
    ])
}

fn things() -> impl Strategy<Value = Thing> {
    let corner = || -12i32..26;
    let still = prop::bool::weighted(0.3);
    (corner(), corner(), 0i32..9, 0i32..9, (-30i32..30, -30i32..30), 0i32..6, (0i32..14, 0i32..14), still)
        .prop_map(|(x, y, w, h, motion, blur, depth, still)| {
            let pixels = [x, x + w, y, y + h];
            if still {
                return Thing::still(pixels, depth.0);
            }
            Thing { pixels, motion: motion.into(), blur, depth: depth.into() }
        })
}

fn leaves() -> impl Strategy<Value = u32> {
    prop::sample::select(CullSettings::LEAVES_PX.to_vec())
}

fn slice_counts() -> impl Strategy<Value = u32> {
    prop::sample::select(CullSettings::SLICES.to_vec())
}

fn orders() -> impl Strategy<Value = SliceOrder> {
    prop::sample::select(vec![SliceOrder::Time, SliceOrder::Lens])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn trees_and_slices_answer_as_all_samples_do(
        region in regions(),
        (samples, tile) in patterns(),
        (leaf_px, num_slices, order) in (leaves(), slice_counts(), orders()),
        (per_cent, deepest, seed) in (90u32..=100, 1u32..12, 0u32..1000),
        queries in prop::collection::vec(things(), 1..20),
    ) {
        let mut drawn = Tile::new(samples, tile, region);
        drawn.fill([-50, 50, -50, 50], per_cent, deepest, &mut Stream::new(seed));
        let mut tree = drawn.pyramid(NodeKind::Tree, order, leaf_px, num_slices);
        let mut slices = drawn.pyramid(NodeKind::Slices, order, leaf_px, num_slices);
        let mut z = drawn.pyramid(NodeKind::Tree, order, leaf_px, 1);
        for thing in &queries {
            let (occluded, reads) = drawn.ask(&mut tree, thing);
            prop_assert!(!(occluded && drawn.is_seen(thing)), "culled though seen: {thing:?}");
            let by_leaf = drawn.is_seen_by_leaf(thing, tree.slices(), leaf_px as i32);
            prop_assert_eq!(occluded, !by_leaf, "{:?}", thing);
            prop_assert_eq!(occluded, drawn.ask(&mut slices, thing).0, "{:?}", thing);
            // No node is read twice at the same range: the walk ends.
            prop_assert!((reads.inner + reads.leaf) as usize <= 2 * tree.bytes() / 4, "{reads:?}");
            let (in_z, _) = drawn.ask(&mut z, thing);
            prop_assert!(occluded || !in_z, "one slice knows more than {num_slices}");
            let mut reads = DepthReads::default();
            let by_a_witness =
                tree.is_seen_by_a_witness(drawn.drawn(), &mut |s| thing.over(s), &mut reads);
            prop_assert!(!(occluded && by_a_witness), "{thing:?}");
        }
    }

    #[test]
    fn a_pyramid_equals_one_rebuilt_after_each_batch(
        region in regions(),
        (samples, tile) in patterns(),
        (leaf_px, num_slices, order) in (leaves(), slice_counts(), orders()),
        batches in prop::collection::vec((-10i32..25, 0i32..20, -10i32..25, 0i32..20, 1u32..40), 1..6),
        seed in 0u32..1000,
    ) {
        let mut drawn = Tile::new(samples, tile, region);
        let mut stream = Stream::new(seed);
        for kind in [NodeKind::Tree, NodeKind::Slices] {
            // Memory of another region is used again.
            let mut pyramid = Tile::new(samples, tile, Region::new(3, 12, -4, 40))
                .pyramid(kind, order, leaf_px, num_slices);
            pyramid.renew(&drawn.samples);
            let rebuilt = |drawn: &Tile| drawn.pyramid(kind, order, leaf_px, num_slices).all_values(drawn.drawn());
            prop_assert!(pyramid.all_values(drawn.drawn()) == rebuilt(&drawn), "when new");
            for &(x, width, y, height, deepest) in &batches {
                let pixels = [x, x + width, y, y + height];
                drawn.fill(pixels, 60, deepest, &mut stream);
                pyramid.update(&drawn.buffer, pixels);
                drawn.buffer.clear_written();
                // Some nodes are read now, others stay stale.
                drawn.ask(&mut pyramid, &Thing::still([x, x, y, y + 3], 1));
                if deepest % 3 > 0 {
                    let all = pyramid.all_values(drawn.drawn());
                    prop_assert!(all == rebuilt(&drawn), "{kind:?} after {pixels:?}");
                }
            }
            drawn.buffer.renew(region);
        }
    }
}

#[test]
fn random_queries_have_both_answers() {
    let (mut occluded, mut visible) = (0, 0);
    let mut stream = Stream::new(5);
    let mut drawn = Tile::new([4, 4], 2, Region::new(-3, 28, 2, 25));
    drawn.fill([-50, 50, -50, 50], 100, 6, &mut stream);
    let mut tree = drawn.pyramid(NodeKind::Tree, SliceOrder::Time, 2, 64);
    for _ in 0..500 {
        let [x, y, dx, dy] = std::array::from_fn(|_| stream.below(20) as i32);
        let depth = [1 + stream.below(11) as i32, 1 + stream.below(11) as i32];
        let thing = Thing { pixels: [x, x + 4, y, y + 3], motion: [dx - 10, dy - 10], blur: 1, depth };
        if drawn.ask(&mut tree, &thing).0 { occluded += 1 } else { visible += 1 }
    }
    assert!(occluded > 50 && visible > 50, "{occluded} occluded, {visible} visible");
}

/// Figure 3 of the paper: both move by more than the occluder's size, one always behind the other.
#[test]
fn what_moves_behind_an_occluder_is_hidden_from_the_tz_pyramid_only() {
    let mut drawn = Tile::new([4, 4], 2, Region::new(0, 64, 0, 32));
    drawn.draw(&Thing { pixels: [2, 21, 2, 25], motion: [40, 0], blur: 0, depth: [5, 5] });
    let behind = Thing { pixels: [8, 13, 8, 13], motion: [40, 0], blur: 0, depth: [7, 7] };
    let answer = |kind, num_slices, thing: &Thing| {
        drawn.ask(&mut drawn.pyramid(kind, SliceOrder::Time, 2, num_slices), thing).0
    };
    assert!(!answer(NodeKind::Tree, 1, &behind));
    for num_slices in [16, 64] {
        assert!(answer(NodeKind::Tree, num_slices, &behind));
        assert!(answer(NodeKind::Slices, num_slices, &behind));
    }
    let in_front = Thing { depth: [7, 4], ..behind };
    assert!(!answer(NodeKind::Tree, 64, &in_front));
    let slower = Thing { motion: [10, 0], ..behind };
    assert!(!answer(NodeKind::Tree, 64, &slower));
}

#[test]
fn what_is_blurred_behind_a_blurred_occluder_is_hidden_by_lens() {
    let mut blurred = Tile::new([4, 4], 2, Region::new(0, 64, 0, 64));
    blurred.draw(&Thing { pixels: [16, 45, 16, 45], motion: [0; 2], blur: 9, depth: [5, 5] });
    let behind = Thing { pixels: [29, 32, 29, 32], motion: [0; 2], blur: 9, depth: [7, 7] };
    let mut moving = Tile::new([4, 4], 2, Region::new(0, 64, 0, 64));
    moving.draw(&Thing { pixels: [2, 31, 2, 25], motion: [30, 0], blur: 0, depth: [5, 5] });
    let moves = Thing { pixels: [15, 18, 8, 13], motion: [30, 0], blur: 0, depth: [7, 7] };
    for (tile, thing, helps) in
        [(&mut blurred, &behind, CullOrder::Lens), (&mut moving, &moves, CullOrder::Time)]
    {
        for order in [CullOrder::Time, CullOrder::Lens, CullOrder::Auto] {
            let settings = CullSettings { slices: 4, leaf_px: 2, order, ..CullSettings::default() };
            let plan = CullPlan::new(settings, &tile.pattern, Blurred { moves: true, has_lens: true })
                .expect("it culls");
            let mut occluders = Occluders::new(&plan);
            occluders.renew(&tile.samples);
            let mut reads = DepthReads::default();
            let bounds_over = |span: &_| thing.over(span);
            // What was drawn is taken in only once it is said that something was.
            assert!(!occluders.is_occluded(&tile.samples, &mut tile.buffer, bounds_over, &mut reads));
            occluders.drew([0, 63, 0, 63]);
            tile.mark_all();
            let occluded = occluders.is_occluded(&tile.samples, &mut tile.buffer, bounds_over, &mut reads);
            assert_eq!(occluded, order == helps || order == CullOrder::Auto, "{order}: {thing:?}");
        }
    }
}

/// The box never leaves one leaf, so the printed algorithm never refines time there, and calls itself again.
#[test]
fn time_is_refined_where_nothing_is_seen_to_move() {
    let mut drawn = Tile::new([4, 4], 2, Region::new(0, 2, 0, 2));
    for ix in 0..drawn.samples.len() {
        let late = drawn.tuple(ix).t15 >= 1 << 14;
        drawn.offer(ix, if late { 20.0 } else { 10.0 });
    }
    let mut tree = drawn.pyramid(NodeKind::Tree, SliceOrder::Time, 2, 64);
    let away = Thing { pixels: [0, 1, 0, 1], motion: [0; 2], blur: 0, depth: [11, 32] };
    assert_eq!(drawn.ask(&mut tree, &away).0, !drawn.is_seen(&away));
    assert!(drawn.ask(&mut tree, &away).0);
    let later = Thing { depth: [11, 29], ..away };
    assert!(!drawn.ask(&mut tree, &later).0 && drawn.is_seen(&later));
}

#[test]
fn equal_depths_are_not_occluded() {
    for num_slices in [1, 64] {
        let mut drawn = Tile::new([4, 4], 2, Region::new(0, 8, 0, 8));
        drawn.draw(&Thing::still([0, 7, 0, 7], 5));
        for kind in [NodeKind::Tree, NodeKind::Slices] {
            let mut pyramid = drawn.pyramid(kind, SliceOrder::Time, 2, num_slices);
            for (depth, occluded) in [(4, false), (5, false), (6, true)] {
                assert_eq!(drawn.ask(&mut pyramid, &Thing::still([1, 5, 0, 6], depth)).0, occluded);
            }
            let nan = Bounds { pixels: [0, 7, 0, 7], near: f32::NAN, still: true };
            assert!(!pyramid.is_occluded(drawn.drawn(), |_| nan, &mut DepthReads::default()));
        }
    }
}

#[test]
fn still_things_cost_few_reads() {
    let mut drawn = Tile::new([4, 4], 2, Region::new(0, 64, 0, 64));
    drawn.draw(&Thing::still([0, 63, 0, 63], 5));
    let reads = |kind, depth| {
        let mut pyramid = drawn.pyramid(kind, SliceOrder::Time, 2, 64);
        drawn.ask(&mut pyramid, &Thing::still([17, 30, 17, 30], depth)).1
    };
    // One node of 16 x 16 pixels holds the box at all times.
    assert_eq!(reads(NodeKind::Tree, 6), DepthReads { inner: 1, leaf: 0, ..DepthReads::default() });
    assert_eq!(reads(NodeKind::Slices, 6), DepthReads { inner: 64, leaf: 0, ..DepthReads::default() });
    // In front of everything: the nearest depth says so without going down.
    assert_eq!(reads(NodeKind::Tree, 4), DepthReads { inner: 1, leaf: 0, nearest: 1, samples: 0 });
    assert_eq!(reads(NodeKind::Slices, 4), DepthReads { inner: 3, leaf: 1, ..DepthReads::default() });
}

#[test]
fn memory_is_eight_thirds_of_the_depth_samples() {
    let tile = Tile::new([4, 4], 2, Region::new(0, 128, 0, 128));
    let depths = (tile.samples.len() * size_of::<f32>()) as f64;
    let ratio = |kind, leaf_px, num_slices| {
        tile.pyramid(kind, SliceOrder::Time, leaf_px, num_slices).bytes() as f64 / depths
    };
    let close = |a: f64, b: f64| (a / b - 1.0).abs() < 0.01;
    assert!(close(ratio(NodeKind::Tree, 2, 64), 8.0 / 3.0));
    // The tree of time is a factor of 2, that of space one of 4/3; a step in either is a factor of 4.
    assert!(close(ratio(NodeKind::Slices, 2, 64), 4.0 / 3.0));
    assert!(close(ratio(NodeKind::Tree, 4, 64), 2.0 / 3.0));
    assert!(close(ratio(NodeKind::Tree, 2, 16), 2.0 / 3.0));
    // Cut leaves and odd levels cost some more.
    let odd = Tile::new([4, 4], 2, Region::new(-3, 64, 5, 66));
    let bytes = odd.pyramid(NodeKind::Tree, SliceOrder::Time, 2, 64).bytes() as f64;
    assert!(bytes < 1.15 * 8.0 / 3.0 * (odd.samples.len() * 4) as f64);
}

#[test]
fn nothing_is_seen_outside_the_region_or_in_none() {
    let drawn = Tile::new([4, 4], 2, Region::new(0, 9, 0, 9));
    for kind in [NodeKind::Tree, NodeKind::Slices] {
        let mut pyramid = drawn.pyramid(kind, SliceOrder::Time, 2, 64);
        for pixels in [[9, 20, 0, 5], [-7, -1, 0, 5], [3, 2, 0, 5], [i32::MIN, -1, i32::MIN, i32::MAX]] {
            assert!(drawn.ask(&mut pyramid, &Thing::still(pixels, 1)).0, "{pixels:?}");
        }
        assert!(!drawn.ask(&mut pyramid, &Thing::still([i32::MIN, i32::MAX, 0, 0], 1)).0);
        let empty = Tile::new([4, 4], 2, Region::new(4, 4, 0, 9));
        let mut pyramid = empty.pyramid(kind, SliceOrder::Time, 2, 64);
        assert!(empty.ask(&mut pyramid, &Thing::still([0, 9, 0, 9], 1)).0);
    }
}

#[test]
fn a_plan_keeps_as_many_pyramids_as_it_needs() {
    let pattern = SamplePattern::new(PatternSpec::default());
    let num = |kind, order, has_lens| {
        let settings = CullSettings { kind, order, ..CullSettings::default() };
        CullPlan::new(settings, &pattern, Blurred { moves: true, has_lens })
            .map_or(0, |plan| Occluders::new(&plan).num_pyramids())
    };
    assert_eq!(num(CullKind::None, CullOrder::Auto, true), 0);
    assert_eq!(num(CullKind::Z, CullOrder::Auto, true), 1);
    assert_eq!(num(CullKind::Tz, CullOrder::Auto, false), 1);
    assert_eq!(num(CullKind::Tz, CullOrder::Auto, true), 2);
    assert_eq!(num(CullKind::Slice, CullOrder::Lens, true), 1);
    let nowhere = CullPlaces { split: false, dice: false, shade: false };
    assert!(
        CullPlan::new(
            CullSettings { at: nowhere, ..CullSettings::default() },
            &pattern,
            Blurred { moves: true, has_lens: true }
        )
        .is_none()
    );
}
