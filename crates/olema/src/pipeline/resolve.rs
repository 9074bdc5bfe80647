//! Resolve: visibility records become pixels.
//!
//! In: a tile's buffers. Out: colour and alpha of each sample (opaque and transparent records composited in
//! depth order), then filtered pixels. A record knows its place on its triangle, so that nothing is placed or tested
//! again, and a sample of a blurred surface costs what one of a still surface does. Every sum runs over rows, columns and
//! samples in this order, whatever the tile, so that a pixel has the same bits in every tiling.

use std::ops::Range;

use glam::Vec4;

use crate::image::Filter;
use crate::math::simd::SimdLevel;
use crate::sampling::inside::Weights;
use crate::sampling::{Payload, Record, Region, RegionSamples, SamplePattern};
use crate::scene::ShadingInterpolation;

use super::grid::{Grid, triangles};
use super::sample::TileBuffers;
use super::shade::Colors;

/// Colour (multiplied by opacity), transmittance per channel.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SampleColor {
    /// Light that reaches the eye.
    color: [f32; 3],
    /// Part of the light from behind that still passes.
    transmittance: [f32; 3],
    /// Depth of the nearest surface, infinite where none is.
    depth: f32,
}

impl SampleColor {
    /// Nothing was hit.
    const EMPTY: SampleColor = SampleColor { color: [0.0; 3], transmittance: [1.0; 3], depth: f32::INFINITY };

    /// Puts a surface behind all that is here already.
    #[inline(always)]
    fn behind(&mut self, color: [f32; 3], opacity: [f32; 3], depth: f32) {
        for c in 0..3 {
            self.color[c] += self.transmittance[c] * color[c];
            self.transmittance[c] *= 1.0 - opacity[c];
        }
        if depth < self.depth {
            self.depth = depth;
        }
    }

    /// Colour, and coverage: the mean of the channels' opacities.
    #[inline(always)]
    fn rgba(&self) -> [f32; 4] {
        let ([r, g, b], t) = (self.color, self.transmittance);
        [r, g, b, 1.0 - (t[0] + t[1] + t[2]) * (1.0 / 3.0)]
    }
}

/// The samples of a tile on their way to pixels.
#[derive(Debug, Default)]
pub struct SampleColors {
    /// What is in front of the nearest opaque surfaces; empty where nothing is.
    in_front: Vec<SampleColor>,
    /// Colour and alpha, of rows of pixels that are filtered now: those of a tile would fill the cache.
    rgba: Vec<Vec4>,
    /// The first of these samples, and the one behind the last one.
    held: Range<usize>,
    /// Depth of the nearest surface of any kind, where something is in front.
    depth: Vec<f32>,
    /// Whether anything was hit in each pixel.
    is_hit: Vec<bool>,
}

impl SampleColors {
    /// Forgets all, for another tile.
    pub fn renew(&mut self) {
        self.in_front.clear();
    }

    /// Composites the transparent records of one pass behind those of earlier passes.
    pub fn composite_pass(&mut self, buffers: &mut TileBuffers) {
        let TileBuffers { samples, nearest, transparent, slots, used, .. } = buffers;
        let order = |a, b| slots.order(a, b);
        let records = transparent.sorted(nearest, &order);
        if !records.is_empty() && self.in_front.is_empty() {
            self.in_front.resize(samples.len(), SampleColor::EMPTY);
        }
        for record in records {
            let Some((grid, colors)) = slots.surface(record.hit.payload) else { continue };
            used.insert(grid, record.hit.payload);
            let color = SlotColors::of(Some((grid, colors))).at(record.hit.payload, record.hit.weights.get());
            let opacity = &colors.opacity;
            let opacity = if opacity.is_empty() { [1.0; 3] } else { mix(grid, opacity.axes(), &record.hit) };
            let sample = &mut self.in_front[record.sample_ix as usize];
            sample.behind(color.truncate().to_array(), opacity, record.hit.depth);
        }
    }

    /// The pixels of `interior`, once all passes are composited: the nearest opaque surfaces are put behind everything,
    /// and samples are filtered.
    pub fn resolve(
        &mut self,
        buffers: &TileBuffers,
        table: &FilterTable,
        interior: Region,
        pixels: &mut Vec<Pixel>,
    ) {
        let looked_up: Vec<SlotColors> = buffers.slots.surfaces().map(SlotColors::of).collect();
        if self.in_front.is_empty() && table.is_mean {
            return mean_pixels(buffers, &looked_up, interior, pixels);
        }
        self.renew_rows(buffers);
        let region = buffers.nearest.region();
        let row = |y: i32| (y - region.y0) as usize * region.width() * buffers.nearest.samples_per_pixel();
        for first in (interior.y0..interior.y1).step_by(ROWS as usize) {
            let rows = Region { y0: first, y1: (first + ROWS).min(interior.y1), ..interior };
            self.hold(buffers, &looked_up, row(rows.y0 - table.radius[1])..row(rows.y1 + table.radius[1]));
            self.filter(table, buffers, rows, pixels);
        }
    }

    /// Holds no rows.
    fn renew_rows(&mut self, buffers: &TileBuffers) {
        self.rgba.clear();
        self.held = 0..0;
        let len = buffers.nearest.len();
        self.is_hit.clear();
        self.is_hit.resize(len / buffers.nearest.samples_per_pixel(), !self.in_front.is_empty());
        self.depth.clear();
        if !self.in_front.is_empty() {
            self.depth.extend_from_slice(buffers.nearest.depths());
        }
    }

    /// Composites samples of whole rows up to the last one wanted, and lets go of those before the first. Rows come in
    /// order, each once.
    fn hold(&mut self, buffers: &TileBuffers, looked_up: &[SlotColors], wanted: Range<usize>) {
        let num_gone = (wanted.start - self.held.start).min(self.rgba.len());
        self.rgba.drain(..num_gone);
        let new = self.held.end.max(wanted.start)..wanted.end;
        self.held = wanted;
        self.composite_opaque(buffers, looked_up, new);
    }

    /// Puts the nearest opaque surfaces behind everything, for samples behind those that are held.
    fn composite_opaque(&mut self, buffers: &TileBuffers, looked_up: &[SlotColors], new: Range<usize>) {
        let (_, payloads, weights) = buffers.nearest.lists(new.clone());
        let per_pixel = buffers.nearest.samples_per_pixel();
        let is_hit = |pixel: &[i32]| pixel.iter().any(|&payload| Payload(payload as u32) != Payload::NONE);
        let pixels = self.is_hit[new.start / per_pixel..].iter_mut().zip(payloads.chunks_exact(per_pixel));
        pixels.for_each(|(to, pixel)| *to |= is_hit(pixel));
        let first = self.rgba.len();
        self.rgba.resize(first + payloads.len(), Vec4::ZERO);
        let rgba = &mut self.rgba[first..];
        let samples = rgba.chunks_mut(UNPACKED).zip(payloads.chunks(UNPACKED)).zip(weights.chunks(UNPACKED));
        SimdLevel::best().run(
            #[inline(always)]
            || {
                let mut unpacked = [[0.0f32; 3]; UNPACKED];
                for ((rgba, payloads), weights) in samples {
                    unpack(weights, &mut unpacked);
                    for ((rgba, &payload), &weights) in rgba.iter_mut().zip(payloads).zip(&unpacked) {
                        let payload = Payload(payload as u32);
                        if payload != Payload::NONE {
                            let slot = &looked_up[payload.slot() as usize];
                            *rgba = slot.at(payload, weights).with_w(slot.covers as f32);
                        }
                    }
                }
            },
        );
        if self.in_front.is_empty() {
            return;
        }
        let in_front = self.in_front[new.clone()].iter_mut();
        for ((sample, rgba), depth) in in_front.zip(&mut self.rgba[first..]).zip(&mut self.depth[new]) {
            sample.behind(rgba.truncate().to_array(), [rgba.w; 3], *depth);
            *depth = sample.depth;
            *rgba = Vec4::from_array(sample.rgba());
        }
    }

    /// Filters the pixels of `interior`, all of whose samples are held.
    fn filter(&self, table: &FilterTable, buffers: &TileBuffers, interior: Region, pixels: &mut Vec<Pixel>) {
        let depth = if self.in_front.is_empty() { buffers.nearest.depths() } else { &self.depth };
        let (samples, is_hit) = (&buffers.samples, &self.is_hit[..]);
        let filtered = Filtered { table, samples, depth, rgba: &self.rgba, first: self.held.start, is_hit };
        SimdLevel::best().run(
            #[inline(always)]
            || {
                for py in interior.y0..interior.y1 {
                    let mut px = interior.x0;
                    while px + TOGETHER as i32 <= interior.x1 {
                        pixels.extend_from_slice(&filtered.pixels::<TOGETHER>(px, py));
                        px += TOGETHER as i32;
                    }
                    for px in px..interior.x1 {
                        pixels.extend_from_slice(&filtered.pixels::<1>(px, py));
                    }
                }
            },
        );
    }
}

/// Pixels of a filter that counts a pixel's own samples alike, where nothing transparent is in front: the same sums as
/// [`Filtered::pixels`], without a list of colours in between.
fn mean_pixels(buffers: &TileBuffers, looked_up: &[SlotColors], interior: Region, pixels: &mut Vec<Pixel>) {
    let nearest = &buffers.nearest;
    let per_pixel = nearest.samples_per_pixel();
    let scale = 1.0 / per_pixel as f32;
    let some = (UNPACKED / per_pixel).max(1) * per_pixel;
    let mut unpacked = vec![[0.0f32; 3]; some];
    SimdLevel::best().run(
        #[inline(always)]
        || {
            for py in interior.y0..interior.y1 {
                let first = nearest.region().pixel_ix(interior.x0, py) * per_pixel;
                let (depths, payloads, weights) = nearest.lists(first..first + interior.width() * per_pixel);
                let row = payloads.chunks(some).zip(weights.chunks(some)).zip(depths.chunks(some));
                for ((payloads, packed), depths) in row {
                    unpack(packed, &mut unpacked);
                    let samples = payloads.chunks_exact(per_pixel).zip(unpacked.chunks_exact(per_pixel));
                    for ((payloads, weights), depths) in samples.zip(depths.chunks_exact(per_pixel)) {
                        let (mut sum, mut covered) = (Vec4::ZERO, 0);
                        for (&payload, &weights) in payloads.iter().zip(weights) {
                            let payload = Payload(payload as u32);
                            // Nothing adds nothing.
                            if payload != Payload::NONE {
                                let slot = &looked_up[payload.slot() as usize];
                                sum += slot.at(payload, weights);
                                covered += slot.covers;
                            }
                        }
                        let [r, g, b, _] = (sum * scale).to_array();
                        pixels.push([r, g, b, covered as f32 * scale, least(depths)]);
                    }
                }
            }
        },
    );
}

/// Samples whose weights are unpacked at a time, about: that goes in lanes, while their colours are looked up one by one.
const UNPACKED: usize = 256;

/// Unpacks weights, of at most as many as there is room for.
#[inline(always)]
fn unpack(packed: &[i32], unpacked: &mut [[f32; 3]]) {
    for (to, &packed) in unpacked.iter_mut().zip(packed) {
        *to = Weights(packed as u32).get();
    }
}

/// The least of depths; infinite where there is none.
#[inline(always)]
fn least(depths: &[f32]) -> f32 {
    depths.iter().fold(f32::INFINITY, |least, &depth| if depth < least { depth } else { least })
}

/// A slot's grid as far as colours at its hits are concerned: what each of them reads, and no more.
#[derive(Debug, Clone, Copy)]
struct SlotColors<'a> {
    /// At the vertices; none for a hole, and where nothing is looked up.
    colors: &'a [Vec4],
    /// Columns of micropolygons.
    columns: u32,
    /// 2^24 over the columns, rounded up: a product with it tells a micropolygon's row, without a division.
    rows: u32,
    /// 1 where it is opaque; 0 for a hole, which hides what is behind it and is nothing itself.
    covers: u32,
    /// Whether a micropolygon has the colour of its first vertex.
    is_flat: bool,
}

impl<'a> SlotColors<'a> {
    fn of(surface: Option<(&'a Grid, &'a Colors)>) -> Self {
        let Some((grid, colors)) = surface.filter(|(grid, _)| !grid.look.matte) else {
            return SlotColors { colors: &[], columns: 1, rows: 0, covers: 0, is_flat: true };
        };
        SlotColors {
            colors: &colors.color,
            columns: grid.m,
            rows: (1u32 << 24).div_ceil(grid.m),
            covers: 1,
            is_flat: grid.look.interpolation == ShadingInterpolation::Constant,
        }
    }

    /// The colour where a micropolygon was hit: that of its first vertex, or interpolated. Its fourth component is 0.
    #[inline(always)]
    fn at(&self, payload: Payload, [w0, w1, w2]: [f32; 3]) -> Vec4 {
        let micropolygon = payload.micropolygon();
        // Right for up to 2^12 micropolygons. Corners as in `Grid::corners` and `triangles`.
        let row = (u64::from(micropolygon) * u64::from(self.rows)) >> 24;
        let (v0, columns) = (micropolygon as usize + row as usize, self.columns as usize);
        if self.is_flat {
            return self.colors.get(v0).copied().unwrap_or(Vec4::ZERO);
        }
        // From the first corner to the one across; one check for all four.
        let (corners, across) = (&self.colors[v0..v0 + columns + 3], columns + 2);
        let [v1, v2] = if payload.triangle() == 0 { [1, across] } else { [across, across - 1] };
        corners[0] * w0 + corners[v1] * w1 + corners[v2] * w2
    }
}

/// What values at the vertices are where a micropolygon was hit: those of its first vertex, or interpolated.
fn mix(grid: &Grid, values: [&[f32]; 3], hit: &Record) -> [f32; 3] {
    let micropolygon = hit.payload.micropolygon() as usize;
    if grid.look.interpolation == ShadingInterpolation::Constant {
        let v0 = grid.corners(micropolygon)[0];
        return values.map(|values| values[v0]);
    }
    let v = triangles(grid, micropolygon)[hit.payload.triangle() as usize];
    let w = hit.weights.get();
    values.map(|values| values[v[0]] * w[0] + values[v[1]] * w[1] + values[v[2]] * w[2])
}

/// Weights of a filter at every place that a sample of the pattern can have.
#[derive(Debug)]
pub struct FilterTable {
    filter: Filter,
    /// Pixels to each side whose samples can count.
    pub radius: [i32; 2],
    /// Whether a pixel is the mean of its own samples.
    is_mean: bool,
    /// Whether no weight is below 0.
    is_positive: bool,
    /// For each offset the samples of a pixel that have a weight other than 0 for some tuple; where weights are tabulated.
    counted: Vec<Vec<u16>>,
    /// Weight of tuple `t` in the pixel at offset (x, y): `[((y + ry) * width + x + rx) * N + t]`; empty where that
    /// would be too large.
    weights: Vec<f32>,
    places: Vec<[u8; 2]>,
}

/// Weights that are tabulated at most (16 MiB).
const MOST_WEIGHTS: usize = 4 << 20;

impl FilterTable {
    /// Tabulates `filter` for `pattern`.
    pub fn new(filter: Filter, pattern: &SamplePattern) -> Self {
        let radius = filter.radius_px().map(|r| r as i32);
        let places: Vec<[u8; 2]> = pattern.tuples().iter().map(|t| [t.x, t.y]).collect();
        let mut table = FilterTable {
            filter,
            radius,
            is_mean: false,
            is_positive: false,
            counted: Vec::new(),
            weights: Vec::new(),
            places,
        };
        table.is_mean = radius == [0; 2]
            && (0..table.places.len() as u32).all(|tuple| table.compute(tuple, [0; 2]) == 1.0);
        let [width, height] = radius.map(|r| (2 * r + 1) as usize);
        if table.places.len().saturating_mul(width * height) <= MOST_WEIGHTS {
            let mut weights = Vec::with_capacity(table.places.len() * width * height);
            for y in -radius[1]..=radius[1] {
                for x in -radius[0]..=radius[0] {
                    weights.extend((0..table.places.len() as u32).map(|tuple| table.compute(tuple, [x, y])));
                }
            }
            table.is_positive = weights.iter().all(|&weight| weight >= 0.0);
            let num_ranks = (pattern.tile() * pattern.tile()) as usize;
            let counted = |of_offset: &[f32]| {
                let strata = (0u16..).zip(of_offset.chunks_exact(num_ranks));
                strata.filter(|(_, of)| of.iter().any(|&w| w != 0.0)).map(|(stratum, _)| stratum).collect()
            };
            table.counted = weights.chunks_exact(table.places.len()).map(counted).collect();
            table.weights = weights;
        }
        table
    }

    /// Weights of all tuples in the pixel `offset` away from the one that is filtered, and the samples of that pixel for
    /// which one of them is not 0, where they are tabulated.
    #[inline(always)]
    fn of_offset(&self, [x, y]: [i32; 2]) -> Option<(&[f32], &[u16])> {
        let (width, num) = (2 * self.radius[0] + 1, self.places.len());
        let row = ((y + self.radius[1]) * width + x + self.radius[0]) as usize;
        Some((self.weights.get(row * num..(row + 1) * num)?, self.counted.get(row)?))
    }

    fn compute(&self, tuple: u32, offset: [i32; 2]) -> f32 {
        let place = self.places[tuple as usize];
        // A sample stands for the 1/256 px to the right of and below its position.
        let from_center = |c: usize| offset[c] as f32 + (f32::from(place[c]) + 0.5) / 256.0 - 0.5;
        self.filter.weight(from_center(0), from_center(1))
    }
}

/// A filtered pixel: r, g, b, a and depth.
pub type Pixel = [f32; 5];

/// Rows of pixels that are filtered before the samples of the next ones are composited.
const ROWS: i32 = 8;

/// Pixels that are filtered together. Each is a sum in a fixed order, where every step waits for the one before.
const TOGETHER: usize = 4;

/// What pixels are filtered from.
struct Filtered<'a> {
    table: &'a FilterTable,
    samples: &'a RegionSamples,
    /// Depth of the samples.
    depth: &'a [f32],
    /// Colour and alpha of samples,
    rgba: &'a [Vec4],
    /// from this one on.
    first: usize,
    /// Whether anything was hit in each pixel.
    is_hit: &'a [bool],
}

impl Filtered<'_> {
    /// `NUM` pixels of a row from (px, py) on.
    #[inline(always)]
    fn pixels<const NUM: usize>(&self, px: i32, py: i32) -> [Pixel; NUM] {
        let Filtered { table, samples, depth, rgba, .. } = self;
        if table.is_positive && !self.is_any_hit(px, py, NUM) {
            return [[0.0, 0.0, 0.0, 0.0, f32::INFINITY]; NUM];
        }
        let per_pixel = samples.samples_per_pixel();
        let mut sums = [Vec4::ZERO; NUM];
        let mut totals = [0.0f32; NUM];
        for y in -table.radius[1]..=table.radius[1] {
            for x in -table.radius[0]..=table.radius[0] {
                let first = samples.region.pixel_ix(px + x, py + y) * per_pixel;
                let (tuples, rgba) = (&samples.tuples[first..], &rgba[first - self.first..]);
                // Of one length: a sample is checked once for all.
                let mut of_pixel = [(&tuples[..per_pixel], &rgba[..per_pixel]); NUM];
                for (i, of) in of_pixel.iter_mut().enumerate() {
                    let first = i * per_pixel;
                    *of = (&tuples[first..][..per_pixel], &rgba[first..][..per_pixel]);
                }
                if let Some((weights, counted)) = table.of_offset([x, y]) {
                    // What has no weight adds nothing.
                    for &j in counted {
                        for i in 0..NUM {
                            let (tuples, rgba) = of_pixel[i];
                            let weight = weights[tuples[usize::from(j)] as usize];
                            totals[i] += weight;
                            sums[i] += rgba[usize::from(j)] * weight;
                        }
                    }
                } else {
                    for j in 0..per_pixel {
                        for i in 0..NUM {
                            let (tuples, rgba) = of_pixel[i];
                            let weight = table.compute(tuples[j], [x, y]);
                            totals[i] += weight;
                            sums[i] += rgba[j] * weight;
                        }
                    }
                }
            }
        }
        let first = samples.region.pixel_ix(px, py) * per_pixel;
        let mut pixels = [[0.0; 5]; NUM];
        for (i, pixel) in pixels.iter_mut().enumerate() {
            let depth = least(&depth[first + i * per_pixel..first + (i + 1) * per_pixel]);
            let scale = if totals[i] == 0.0 { 0.0 } else { 1.0 / totals[i] };
            let [r, g, b, a] = (sums[i] * scale).to_array();
            *pixel = [r, g, b, a, depth];
        }
        pixels
    }

    /// Whether anything was hit in the pixels that `num` pixels of a row from (px, py) on are filtered from.
    fn is_any_hit(&self, px: i32, py: i32, num: usize) -> bool {
        let [rx, ry] = self.table.radius;
        (py - ry..=py + ry).any(|y| {
            let first = self.samples.region.pixel_ix(px - rx, y);
            self.is_hit[first..first + num + 2 * rx as usize].iter().any(|&is_hit| is_hit)
        })
    }
}
