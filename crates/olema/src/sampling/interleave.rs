//! InterleaveUvt: exact positions per tuple. Its cost hardly depends on the blur.
//!
//! In: a [`MovingDraw`] with K of at most [`MAX_TILE`]. Out: hits and counts. Source: Fatahalian 2009, section
//! 3.2.2, with the permutations of section 3.2.3.
//!
//! For each of the N tuples the micropolygon is where it is for that tuple, exactly. In each tile of K x K
//! pixels that its box overlaps, the one sample with that tuple is tested. A sample beyond the region is not:
//! the region that holds it does that. Twin in lanes: `interleave_lanes`.

use super::draw::{Micropolygon, MovingDraw, Placed, Reach};
use super::inside::{point_at, triangle_hit};
use super::moving::Extent;
use super::nomotion::{Facing, HitSink, SampleCounts};
use super::pattern::SamplePattern;
use super::region::RegionSamples;

/// Largest K: beyond it, N = M K^2 positions a micropolygon cost more than any other way.
pub const MAX_TILE: u32 = 8;

/// Rasterizes a grid; K must be at most [`MAX_TILE`] for this to be of use.
pub(super) fn rasterize<S: HitSink>(draw: &MovingDraw, counts: &mut SampleCounts, sink: &mut S) {
    let tuples = tuples(draw);
    draw.for_each(counts, sink, |micropolygon, counts, sink| {
        rasterize_micropolygon(draw, micropolygon, &tuples, counts, sink);
    });
}

/// The tuples that a draw looks at.
pub(super) fn tuples(draw: &MovingDraw) -> Vec<u32> {
    let all = 0..draw.pattern.tuples().len() as u32;
    all.filter(|&tuple_ix| draw.has_tuple(tuple_ix)).collect()
}

/// Tests a micropolygon with each of `tuples`.
#[inline(never)]
pub(super) fn rasterize_micropolygon(
    draw: &MovingDraw,
    micropolygon: &Micropolygon,
    tuples: &[u32],
    counts: &mut SampleCounts,
    sink: &mut impl HitSink,
) {
    for &tuple_ix in tuples {
        let placed = micropolygon.place(tuple_ix);
        test_tiles(draw, micropolygon, tuple_ix, &placed, counts, sink);
    }
}

/// Tests the tuple's sample of each tile.
fn test_tiles(
    draw: &MovingDraw,
    micropolygon: &Micropolygon,
    tuple_ix: u32,
    placed: &Placed,
    counts: &mut SampleCounts,
    sink: &mut impl HitSink,
) {
    let reach = Reach::of(&Extent::around(placed));
    each_sample(draw.pattern, draw.samples, tuple_ix, reach, |sample_ix, place| {
        micropolygon.test(placed, tuple_ix, sample_ix, place, counts, sink);
    });
}

/// The sample with a tuple in each tile that a box overlaps: its index and its raster position.
#[inline(always)]
pub(super) fn each_sample(
    pattern: &SamplePattern,
    samples: &RegionSamples,
    tuple_ix: u32,
    reach: Reach,
    mut visit: impl FnMut(usize, [i32; 2]),
) {
    let k = pattern.tile() as i32;
    let num_ranks = pattern.tile() * pattern.tile();
    let (stratum, rank) = (tuple_ix / num_ranks, tuple_ix % num_ranks);
    let tuple = pattern.tuples()[tuple_ix as usize];
    let [px_first, px_last] = reach.pixels(&samples.region, 0);
    let [py_first, py_last] = reach.pixels(&samples.region, 1);
    if px_first > px_last || py_first > py_last {
        return;
    }
    for ty in py_first.div_euclid(k)..=py_last.div_euclid(k) {
        for tx in px_first.div_euclid(k)..=px_last.div_euclid(k) {
            let pixel = pattern.pixel_of_rank(samples.set_of_tile(tx, ty), stratum, rank) as i32;
            let (px, py) = (tx * k + pixel % k, ty * k + pixel / k);
            if !samples.region.contains(px, py) {
                continue;
            }
            let sample_ix = samples.region.pixel_ix(px, py) * samples.samples_per_pixel() + stratum as usize;
            debug_assert_eq!(samples.tuples[sample_ix], tuple_ix, "region and pattern disagree");
            visit(sample_ix, [px * 256 + i32::from(tuple.x), py * 256 + i32::from(tuple.y)]);
        }
    }
}

/// Rasterizes a triangle that is placed for a tuple already: one that was clipped.
#[allow(clippy::too_many_arguments)]
pub fn rasterize_tuple<S: HitSink>(
    pattern: &SamplePattern,
    tuple_ix: u32,
    xy: [[i32; 2]; 3],
    depth: [f32; 3],
    facing: Facing,
    samples: &RegionSamples,
    counts: &mut SampleCounts,
    sink: &mut S,
) {
    let reach = Reach::of(&Extent::around(&xy));
    each_sample(pattern, samples, tuple_ix, reach, |sample_ix, place| {
        counts.tests += 1;
        let Some(hit) = triangle_hit(xy, place) else { return };
        if !matches!(facing, Facing::Only(side) if side != hit.sign) {
            counts.hits += 1;
            sink.hit(sample_ix, point_at(&hit, depth), 0, hit.sign);
        }
    });
}
