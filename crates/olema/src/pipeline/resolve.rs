//! Resolve: visibility records become pixels.
//!
//! In: a tile's buffers. Out: colour and alpha of each sample (opaque and transparent records composited in
//! depth order), then filtered pixels. A record knows its place on its triangle, so that nothing is placed or tested
//! again, and a sample of a blurred surface costs what one of a still surface does. Every sum runs over rows, columns and
//! samples in this order, whatever the tile, so that a pixel has the same bits in every tiling.

use crate::image::Filter;
use crate::sampling::{Record, Region, RegionSamples, SamplePattern};
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
    /// Colour and alpha.
    rgba: Vec<[f32; 4]>,
    /// Depth of the nearest surface of any kind.
    depth: Vec<f32>,
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
            let Some(surface) = slots.surface(record.hit.payload) else { continue };
            used.insert(surface.0, record.hit.payload);
            let (color, opacity) = surface_at(surface, &record.hit);
            self.in_front[record.sample_ix as usize].behind(color, opacity, record.hit.depth);
        }
    }

    /// Puts the nearest opaque surfaces behind everything.
    pub fn composite_opaque(&mut self, buffers: &TileBuffers) {
        self.rgba.clear();
        self.depth.clear();
        self.depth.extend_from_slice(buffers.nearest.depths());
        // Samples next to each other are mostly of one grid.
        let mut last: Option<(u32, Option<(&Grid, &Colors)>)> = None;
        let opaque = buffers.nearest.records().map(|record| {
            if record.is_none() {
                return (SampleColor::EMPTY.color, [0.0; 3]);
            }
            let slot = record.payload.slot();
            let surface = match last {
                Some((known, surface)) if known == slot => surface,
                _ => buffers.slots.surface(record.payload),
            };
            last = Some((slot, surface));
            surface.map_or(([0.0; 3], [0.0; 3]), |surface| (color_at(surface, &record), opacity(surface.0)))
        });
        if self.in_front.is_empty() {
            self.rgba.extend(opaque.map(|([r, g, b], opacity)| [r, g, b, opacity[0]]));
            return;
        }
        let samples = self.in_front.iter_mut().zip(opaque).zip(&mut self.depth);
        self.rgba.extend(samples.map(|((sample, (color, opacity)), depth)| {
            sample.behind(color, opacity, *depth);
            *depth = sample.depth;
            sample.rgba()
        }));
    }

    /// Filters the pixels of `interior`, which lie in the larger region of `samples`.
    pub fn filter(
        &self,
        table: &FilterTable,
        samples: &RegionSamples,
        interior: Region,
        pixels: &mut Vec<Pixel>,
    ) {
        let filtered = Filtered { table, samples, depth: &self.depth, rgba: &self.rgba };
        for py in interior.y0..interior.y1 {
            let mut px = interior.x0;
            while px + TOGETHER as i32 <= interior.x1 {
                pixels.extend(filtered.pixels::<TOGETHER>(px, py));
                px += TOGETHER as i32;
            }
            pixels.extend((px..interior.x1).flat_map(|px| filtered.pixels::<1>(px, py)));
        }
    }
}

/// Opacity of an opaque surface. A hole hides what is behind it and is nothing itself.
#[inline(always)]
fn opacity(grid: &Grid) -> [f32; 3] {
    if grid.look.matte { [0.0; 3] } else { [1.0; 3] }
}

/// Colour and opacity of a surface where it was hit.
fn surface_at((grid, colors): (&Grid, &Colors), hit: &Record) -> ([f32; 3], [f32; 3]) {
    let opacity = &colors.opacity;
    let opacity = if opacity.is_empty() { [1.0; 3] } else { mix(grid, opacity.axes(), hit) };
    (color_at((grid, colors), hit), opacity)
}

#[inline(always)]
fn color_at((grid, colors): (&Grid, &Colors), hit: &Record) -> [f32; 3] {
    mix(grid, colors.color.axes(), hit)
}

/// What values at the vertices are where a micropolygon was hit: those of its first vertex, or interpolated.
#[inline(always)]
fn mix(grid: &Grid, values: [&[f32]; 3], hit: &Record) -> [f32; 3] {
    let micropolygon = hit.payload.micropolygon() as usize;
    let [x, y, z] = values;
    if grid.look.interpolation == ShadingInterpolation::Constant {
        let v0 = grid.corners(micropolygon)[0];
        return [x[v0], y[v0], z[v0]];
    }
    let v = triangles(grid, micropolygon)[hit.payload.triangle() as usize];
    let w = hit.weights.get();
    // Written out: `array::map` is a call for each.
    [between(x, v, w), between(y, v, w), between(z, v, w)]
}

#[inline(always)]
fn between(values: &[f32], v: [usize; 3], w: [f32; 3]) -> f32 {
    values[v[0]] * w[0] + values[v[1]] * w[1] + values[v[2]] * w[2]
}

/// Weights of a filter at every place that a sample of the pattern can have.
#[derive(Debug)]
pub struct FilterTable {
    filter: Filter,
    /// Pixels to each side whose samples can count.
    pub radius: [i32; 2],
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
        let mut table = FilterTable { filter, radius, weights: Vec::new(), places };
        let [width, height] = radius.map(|r| (2 * r + 1) as usize);
        if table.places.len().saturating_mul(width * height) <= MOST_WEIGHTS {
            let mut weights = Vec::with_capacity(table.places.len() * width * height);
            for y in -radius[1]..=radius[1] {
                for x in -radius[0]..=radius[0] {
                    weights.extend((0..table.places.len() as u32).map(|tuple| table.compute(tuple, [x, y])));
                }
            }
            table.weights = weights;
        }
        table
    }

    /// Weights of all tuples in the pixel `offset` away from the one that is filtered, where they are tabulated.
    #[inline(always)]
    fn of_offset(&self, [x, y]: [i32; 2]) -> Option<&[f32]> {
        let (width, num) = (2 * self.radius[0] + 1, self.places.len());
        let row = ((y + self.radius[1]) * width + x + self.radius[0]) as usize;
        self.weights.get(row * num..(row + 1) * num)
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

/// Pixels that are filtered together. Each is a sum in a fixed order, where every step waits for the one before.
const TOGETHER: usize = 4;

/// What pixels are filtered from.
struct Filtered<'a> {
    table: &'a FilterTable,
    samples: &'a RegionSamples,
    /// Depth of the samples.
    depth: &'a [f32],
    /// Colour and alpha of the samples.
    rgba: &'a [[f32; 4]],
}

impl Filtered<'_> {
    /// `NUM` pixels of a row from (px, py) on.
    fn pixels<const NUM: usize>(&self, px: i32, py: i32) -> [Pixel; NUM] {
        let Filtered { table, samples, depth, rgba } = self;
        let per_pixel = samples.samples_per_pixel();
        let mut sums = [[0.0f32; 4]; NUM];
        let mut totals = [0.0f32; NUM];
        for y in -table.radius[1]..=table.radius[1] {
            for x in -table.radius[0]..=table.radius[0] {
                let first = samples.region.pixel_ix(px + x, py + y) * per_pixel;
                let (tuples, rgba) = (&samples.tuples[first..], &rgba[first..]);
                let (tuples, rgba) = (&tuples[..NUM * per_pixel], &rgba[..NUM * per_pixel]);
                let weights = table.of_offset([x, y]);
                for j in 0..per_pixel {
                    for i in 0..NUM {
                        let (tuple, value) = (tuples[i * per_pixel + j], rgba[i * per_pixel + j]);
                        let weight = match weights {
                            Some(weights) => weights[tuple as usize],
                            None => table.compute(tuple, [x, y]),
                        };
                        totals[i] += weight;
                        for c in 0..4 {
                            sums[i][c] += weight * value[c];
                        }
                    }
                }
            }
        }
        let first = samples.region.pixel_ix(px, py) * per_pixel;
        std::array::from_fn(|i| {
            let of_pixel = &depth[first + i * per_pixel..first + (i + 1) * per_pixel];
            let depth = of_pixel.iter().fold(f32::INFINITY, |least, &depth| least.min(depth));
            let scale = if totals[i] == 0.0 { 0.0 } else { 1.0 / totals[i] };
            let sum = sums[i];
            [sum[0] * scale, sum[1] * scale, sum[2] * scale, sum[3] * scale, depth]
        })
    }
}
