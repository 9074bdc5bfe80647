//! NoMotion, scalar: the rasterizer for micropolygons that stand still and are in focus.
//!
//! In: micropolygons in 1/256 px of raster space and the samples of a region. Out: hits, to a [`HitSink`],
//! and [`SampleCounts`]. The oracle for faster rasterizers; twin in lanes: `nomotion_lanes`. Source: Fatahalian 2009,
//! sections 3.1 and 4.1.
//!
//! A micropolygon's bounding box is clamped to sub-pixel cells, not to pixels; the one sample in each cell
//! that the box overlaps is tested exactly ([`super::inside`]). A sample counts as one test of a quad, although
//! it may take both of its triangles; likewise it counts as one hit, also where a folded quad hits it twice.

use super::inside::{HitPoint, Weights, point_at, signed_area, triangle_hit};
use super::region::RegionSamples;
use super::strata::cells_of_positions;
use crate::math::lanes::Lanes;
use crate::math::simd::LANES;

/// Where hits go.
pub trait HitSink {
    /// The hits that follow are those of this micropolygon of the grid.
    fn begin(&mut self, _micropolygon: u32) {}

    /// Sample `sample_ix` of the region is hit at `point` of triangle 0 (v0, v1, v2) or 1 (v0, v2, v3), seen
    /// from side `sign` (see [`super::inside`]).
    fn hit(&mut self, sample_ix: usize, point: HitPoint, triangle: u8, sign: i8);

    /// Sample `first + i` is hit by triangle 0 where bit i of `hits[0]` is set, by triangle 1 where that of `hits[1]` is
    /// (not both), at the point in lane i; seen from side -1 where bit i of `negative` is set. Has to be `#[inline(always)]`.
    #[inline(always)]
    fn hits<L: Lanes>(
        &mut self,
        lanes: L,
        first: usize,
        hits: [u32; 2],
        points: HitPoints<L>,
        negative: u32,
    ) {
        each_hit(self, lanes, first, hits, points, negative);
    }

    /// Takes hits of several micropolygons; what comes after belongs to the last of them.
    #[inline(always)]
    fn hits_apart(&mut self, hits: &HitsApart) {
        each_hit_apart(self, hits);
    }
}

/// [`HitSink::hits_apart`] one by one.
#[inline(always)]
pub fn each_hit_apart(sink: &mut (impl HitSink + ?Sized), hits: &HitsApart) {
    for (micropolygon, sample_ix, point, triangle, sign) in hits.iter() {
        sink.begin(micropolygon);
        sink.hit(sample_ix, point, triangle, sign);
    }
}

/// Hits of samples and micropolygons that lie apart; lists of the same length.
pub struct HitsApart<'a> {
    /// Samples of the region.
    pub samples: &'a [i32],
    /// Micropolygon of the grid, triangle (a bit), and whether it is seen from side -1 (the lowest bit).
    pub codes: &'a [i32],
    /// The bits of depths.
    pub depth_bits: &'a [i32],
    /// The bits of [`Weights`].
    pub weights: &'a [i32],
}

impl HitsApart<'_> {
    /// Micropolygon, sample, point, triangle and sign of each.
    #[inline(always)]
    pub fn iter(&self) -> impl Iterator<Item = (u32, usize, HitPoint, u8, i8)> + '_ {
        let points = self.depth_bits.iter().zip(self.weights);
        self.samples.iter().zip(self.codes).zip(points).map(
            #[inline(always)]
            |((&sample, &code), (&depth, &weights))| {
                let point =
                    HitPoint { depth: f32::from_bits(depth as u32), weights: Weights(weights as u32) };
                let sign = if code & 1 == 1 { -1 } else { 1 };
                (code as u32 >> 2, sample as usize, point, (code >> 1 & 1) as u8, sign)
            },
        )
    }
}

/// A [`HitPoint`] a lane.
#[derive(Clone, Copy)]
pub struct HitPoints<L: Lanes> {
    /// Depths.
    pub depth: L::F,
    /// The bits of [`Weights`].
    pub weights: L::I,
}

/// [`HitSink::hits`] one by one.
#[inline(always)]
pub fn each_hit<L: Lanes>(
    sink: &mut (impl HitSink + ?Sized),
    lanes: L,
    first: usize,
    [hit0, hit1]: [u32; 2],
    points: HitPoints<L>,
    negative: u32,
) {
    let (mut depths, mut weights) = ([0.0; LANES], [0; LANES]);
    lanes.store_f(points.depth, &mut depths, 0);
    lanes.store(points.weights, &mut weights, 0);
    let mut bits = hit0 | hit1;
    while bits != 0 {
        let lane = bits.trailing_zeros() as usize & (LANES - 1);
        let triangle = hit1 >> lane & 1;
        let sign = if negative >> lane & 1 == 1 { -1 } else { 1 };
        let point = HitPoint { depth: depths[lane], weights: Weights(weights[lane] as u32) };
        sink.hit(first + lane, point, triangle as u8, sign);
        bits &= bits - 1;
    }
}

/// Work done.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SampleCounts {
    /// Samples tested against a micropolygon. InterleaveUvt in lanes tests only those that are in the micropolygon's box,
    /// which the paper's algorithm and the scalar twin find out by testing one a tile.
    pub tests: u64,
    /// Tests that hit.
    pub hits: u64,
    /// Micropolygons that were not tested since they face away.
    pub backfacing: u64,
}

impl SampleCounts {
    /// Sample test efficiency, hits / tests; 0 without tests.
    pub fn ste(&self) -> f64 {
        if self.tests == 0 { 0.0 } else { self.hits as f64 / self.tests as f64 }
    }

    /// Adds other counts to these.
    pub fn add(&mut self, other: SampleCounts) {
        self.tests += other.tests;
        self.hits += other.hits;
        self.backfacing += other.backfacing;
    }
}

/// Sides of triangles that can be hit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Facing {
    /// Both.
    #[default]
    Any,
    /// Only those with this sign, +1 or -1.
    Only(i8),
}

/// A triangle that may be hit, with its number in the quad.
#[derive(Clone, Copy)]
struct Candidate {
    xy: [[i32; 2]; 3],
    depth: [f32; 3],
    number: u8,
}

/// Rasterizes the quad v0 v1 v2 v3 (see [`super::inside`] for the corner order).
pub fn rasterize_quad(
    xy: [[i32; 2]; 4],
    depth: [f32; 4],
    facing: Facing,
    samples: &RegionSamples,
    counts: &mut SampleCounts,
    sink: &mut impl HitSink,
) {
    let [v0, v1, v2, v3] = xy;
    let [z0, z1, z2, z3] = depth;
    let both = [
        Candidate { xy: [v0, v1, v2], depth: [z0, z1, z2], number: 0 },
        Candidate { xy: [v0, v2, v3], depth: [z0, z2, z3], number: 1 },
    ];
    let kept = both.map(|triangle| faces(&triangle, facing));
    match kept {
        [Turn::Towards, Turn::Towards] => test_box(&both, samples, counts, sink),
        [Turn::Towards, _] => test_box(&both[..1], samples, counts, sink),
        [_, Turn::Towards] => test_box(&both[1..], samples, counts, sink),
        _ => counts.backfacing += u64::from(kept.contains(&Turn::Away)),
    }
}

/// Rasterizes a triangle.
pub fn rasterize_triangle(
    xy: [[i32; 2]; 3],
    depth: [f32; 3],
    facing: Facing,
    samples: &RegionSamples,
    counts: &mut SampleCounts,
    sink: &mut impl HitSink,
) {
    let triangle = Candidate { xy, depth, number: 0 };
    match faces(&triangle, facing) {
        Turn::Towards => test_box(&[triangle], samples, counts, sink),
        Turn::Away => counts.backfacing += 1,
        Turn::Degenerate => {}
    }
}

/// The vertices of a grid of m x n quads: vertex (i, j) is at `j * (m + 1) + i`, of (m + 1) (n + 1).
#[derive(Debug, Clone, Copy)]
pub struct GridView<'a> {
    /// Quads along i.
    pub m: usize,
    /// Quads along j.
    pub n: usize,
    /// Raster x in 1/256 px.
    pub x: &'a [i32],
    /// Raster y in 1/256 px.
    pub y: &'a [i32],
    /// Depth.
    pub depth: &'a [f32],
}

impl GridView<'_> {
    /// Vertices v0 v1 v2 v3 of quad (i, j).
    #[inline(always)]
    pub fn corners(&self, i: usize, j: usize) -> [usize; 4] {
        let v0 = j * (self.m + 1) + i;
        [v0, v0 + 1, v0 + self.m + 2, v0 + self.m + 1]
    }
}

/// Rasterizes all quads of a grid; quad (i, j) is micropolygon `j * m + i`.
///
/// Quads with a vertex for which `skip` is true are left out: they are drawn another way.
pub fn rasterize_grid(
    grid: GridView,
    facing: Facing,
    skip: Option<&[bool]>,
    samples: &RegionSamples,
    counts: &mut SampleCounts,
    sink: &mut impl HitSink,
) {
    for j in 0..grid.n {
        for i in 0..grid.m {
            let corners = grid.corners(i, j);
            if skip.is_some_and(|skip| corners.iter().any(|&ix| skip[ix])) {
                continue;
            }
            sink.begin((j * grid.m + i) as u32);
            let xy = corners.map(|ix| [grid.x[ix], grid.y[ix]]);
            let depth = corners.map(|ix| grid.depth[ix]);
            rasterize_quad(xy, depth, facing, samples, counts, sink);
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Turn {
    Towards,
    Away,
    Degenerate,
}

fn faces(triangle: &Candidate, facing: Facing) -> Turn {
    let sign = signed_area(triangle.xy).signum() as i8;
    match facing {
        _ if sign == 0 => Turn::Degenerate,
        Facing::Only(side) if side != sign => Turn::Away,
        _ => Turn::Towards,
    }
}

/// Tests the samples in all cells that the box of one or two triangles overlaps.
///
/// The box is half open: a sample on its right or lower border counts as beyond it (samples are taken at
/// (x + e, y + e^2)), so `last` is the last 1/256 px that can be hit.
fn test_box(
    triangles: &[Candidate],
    samples: &RegionSamples,
    counts: &mut SampleCounts,
    sink: &mut impl HitSink,
) {
    let region = samples.region;
    let [x_first, x_last] = span(triangles, 0);
    let [y_first, y_last] = span(triangles, 1);
    let num_strata = samples.samples_per_pixel();
    for py in (y_first >> 8).max(region.y0)..=(y_last >> 8).min(region.y1 - 1) {
        let (cy_first, cy_last) = cells_in_pixel(y_first, y_last, py, samples.grid[1]);
        for px in (x_first >> 8).max(region.x0)..=(x_last >> 8).min(region.x1 - 1) {
            let (cx_first, cx_last) = cells_in_pixel(x_first, x_last, px, samples.grid[0]);
            let first_of_pixel = region.pixel_ix(px, py) * num_strata;
            for cy in cy_first..=cy_last {
                for cx in cx_first..=cx_last {
                    let sample_ix = first_of_pixel + (cy * samples.grid[0] + cx) as usize;
                    let [x, y] = samples.offset(sample_ix);
                    let place = [px * 256 + i32::from(x), py * 256 + i32::from(y)];
                    counts.tests += 1;
                    counts.hits += u64::from(test_sample(triangles, place, sample_ix, sink));
                }
            }
        }
    }
}

/// Tests one sample against each triangle; returns whether any was hit.
#[inline]
fn test_sample(triangles: &[Candidate], place: [i32; 2], sample_ix: usize, sink: &mut impl HitSink) -> bool {
    let mut any = false;
    for triangle in triangles {
        if let Some(hit) = triangle_hit(triangle.xy, place) {
            sink.hit(sample_ix, point_at(&hit, triangle.depth), triangle.number, hit.sign);
            any = true;
        }
    }
    any
}

/// First and last 1/256 px along an axis that can be hit; empty (first above last) where there is none.
fn span(triangles: &[Candidate], axis: usize) -> [i32; 2] {
    let all = triangles.iter().flat_map(|t| t.xy.iter().map(|v| v[axis]));
    let [least, most] = all.fold([i32::MAX, i32::MIN], |[least, most], v| [least.min(v), most.max(v)]);
    [least, most - 1]
}

/// Cells of a pixel that the span `first..=last` overlaps.
#[inline(always)]
pub(super) fn cells_in_pixel(first: i32, last: i32, pixel: i32, num_cells: u32) -> (u32, u32) {
    let start = pixel * 256;
    cells_of_positions((first - start).max(0) as u32, (last - start).min(255) as u32, num_cells)
}
