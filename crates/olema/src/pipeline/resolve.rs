//! Resolve: visibility records become pixels.
//!
//! In: a tile's buffers. Out: colour and alpha of each sample (opaque and transparent records composited in
//! depth order), then filtered pixels. Every sum runs over rows, columns and samples in this order, whatever
//! the tile, so that a pixel has the same bits in every tiling. Opaque surfaces are composited in lanes by the twin
//! `resolve_lanes`.

use crate::image::Filter;
use crate::sampling::inside::{barycentric, triangle_hit};
use crate::sampling::{Kernels, Payload, Region, RegionSamples, SamplePattern};
use crate::scene::ShadingInterpolation;

use super::grid::{Grid, triangles};
use super::sample::{DrawContext, TileBuffers};
use super::shade::Colors;

/// Colour (multiplied by opacity), transmittance per channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampleColor {
    /// Light that reaches the eye.
    pub color: [f32; 3],
    /// Part of the light from behind that still passes.
    pub transmittance: [f32; 3],
    /// Depth of the nearest surface, infinite where none is.
    pub depth: f32,
}

impl SampleColor {
    /// Nothing was hit.
    pub const EMPTY: SampleColor =
        SampleColor { color: [0.0; 3], transmittance: [1.0; 3], depth: f32::INFINITY };

    /// Puts a surface behind all that is here already.
    #[inline(always)]
    pub(super) fn behind(&mut self, color: [f32; 3], opacity: [f32; 3], depth: f32) {
        for c in 0..3 {
            self.color[c] += self.transmittance[c] * color[c];
            self.transmittance[c] *= 1.0 - opacity[c];
        }
        if depth < self.depth {
            self.depth = depth;
        }
    }

    /// Coverage: the mean of the channels' opacities.
    #[inline(always)]
    fn alpha(&self) -> f32 {
        let t = self.transmittance;
        1.0 - (t[0] + t[1] + t[2]) * (1.0 / 3.0)
    }
}

/// Composites the transparent records of one pass behind those of earlier passes.
pub fn composite_pass(context: &DrawContext, buffers: &mut TileBuffers, colors: &mut [SampleColor]) {
    let TileBuffers { samples, nearest, transparent, slots, used, .. } = buffers;
    let order = |a, b| slots.order(a, b);
    for record in transparent.sorted(nearest, &order) {
        let Some(surface) = slots.surface(record.payload) else { continue };
        used.insert(surface.0, record.payload);
        let (color, opacity) =
            surface_at(context, surface, record.payload, samples, record.sample_ix as usize);
        colors[record.sample_ix as usize].behind(color, opacity, record.depth);
    }
}

/// Puts the nearest opaque surfaces behind everything.
pub fn composite_opaque(
    context: &DrawContext,
    buffers: &TileBuffers,
    kernels: Kernels,
    colors: &mut [SampleColor],
) {
    if let Kernels::Lanes(level) = kernels {
        return super::resolve_lanes::composite_opaque(level, context, buffers, colors);
    }
    for (ix, sample) in colors.iter_mut().enumerate() {
        composite_one(context, buffers, ix, sample);
    }
}

/// Puts the nearest opaque surface of one sample behind everything.
pub(super) fn composite_one(
    context: &DrawContext,
    buffers: &TileBuffers,
    ix: usize,
    sample: &mut SampleColor,
) {
    let record = buffers.nearest.get(ix);
    if record.is_none() {
        return;
    }
    let Some(surface) = buffers.slots.surface(record.payload) else { return };
    let (color, _) = surface_at(context, surface, record.payload, &buffers.samples, ix);
    sample.behind(color, opacity(surface.0), record.depth);
}

/// A hole hides what is behind it and is nothing itself.
#[inline(always)]
pub(super) fn opacity(grid: &Grid) -> [f32; 3] {
    if grid.look.matte { [0.0; 3] } else { [1.0; 3] }
}

/// Colour and opacity of a micropolygon where sample `sample_ix` hit it.
fn surface_at(
    context: &DrawContext,
    (grid, colors): (&Grid, &Colors),
    payload: Payload,
    samples: &RegionSamples,
    sample_ix: usize,
) -> ([f32; 3], [f32; 3]) {
    if grid.look.interpolation == ShadingInterpolation::Constant {
        return flat((grid, colors), payload);
    }
    let micropolygon = payload.micropolygon() as usize;
    let triangle = triangles(grid, micropolygon)[payload.triangle() as usize];
    let (place, tuple_ix) = (samples.position(sample_ix), samples.tuples[sample_ix]);
    let weights = if grid.is_slow(micropolygon) {
        slow_weights(context, grid, triangle, place, tuple_ix)
    } else {
        triangle_hit(context.place(grid, triangle, tuple_ix), place).map(|hit| barycentric(&hit))
    };
    let Some(w) = weights else {
        debug_assert!(false, "a record's triangle is hit again");
        return flat((grid, colors), payload);
    };
    let mix =
        |values: &[f32]| values[triangle[0]] * w[0] + values[triangle[1]] * w[1] + values[triangle[2]] * w[2];
    let (c, o) = (&colors.color, &colors.opacity);
    let color = [mix(c.x()), mix(c.y()), mix(c.z())];
    let opacity = if o.is_empty() { [1.0; 3] } else { [mix(o.x()), mix(o.y()), mix(o.z())] };
    (color, opacity)
}

/// Weights of a triangle's vertices at a sample that hit the clipped triangle.
fn slow_weights(
    context: &DrawContext,
    grid: &Grid,
    triangle: [usize; 3],
    place: [i32; 2],
    tuple_ix: u32,
) -> Option<[f32; 3]> {
    let clipped = context.clip(grid, triangle, tuple_ix);
    clipped.triangles().find_map(|part| {
        let hit = triangle_hit(part.map(|v| v.raster), place)?;
        let b = barycentric(&hit);
        Some(std::array::from_fn(|ix| {
            part[0].weights[ix] * b[0] + part[1].weights[ix] * b[1] + part[2].weights[ix] * b[2]
        }))
    })
}

/// Colour and opacity of a micropolygon's first vertex.
pub(super) fn flat((grid, colors): (&Grid, &Colors), payload: Payload) -> ([f32; 3], [f32; 3]) {
    let v0 = grid.corners(payload.micropolygon() as usize)[0];
    let opacity = &colors.opacity;
    let opacity = if opacity.is_empty() { [1.0; 3] } else { opacity.get(v0).to_array() };
    (colors.color.get(v0).to_array(), opacity)
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

/// Filters the pixels of `interior`; `colors` covers the larger region of `samples`.
pub fn filter_pixels(
    table: &FilterTable,
    samples: &RegionSamples,
    colors: &[SampleColor],
    interior: Region,
    pixels: &mut Vec<Pixel>,
) {
    let rgba: Vec<[f32; 4]> = colors
        .iter()
        .map(|sample| {
            let [r, g, b] = sample.color;
            [r, g, b, sample.alpha()]
        })
        .collect();
    let filtered = Filtered { table, samples, colors, rgba: &rgba };
    for py in interior.y0..interior.y1 {
        let mut px = interior.x0;
        while px + TOGETHER as i32 <= interior.x1 {
            pixels.extend(filtered.pixels::<TOGETHER>(px, py));
            px += TOGETHER as i32;
        }
        pixels.extend((px..interior.x1).flat_map(|px| filtered.pixels::<1>(px, py)));
    }
}

/// Pixels that are filtered together. Each is a sum in a fixed order, where every step waits for the one before.
const TOGETHER: usize = 4;

/// What pixels are filtered from.
struct Filtered<'a> {
    table: &'a FilterTable,
    samples: &'a RegionSamples,
    colors: &'a [SampleColor],
    /// Colour and alpha of the samples.
    rgba: &'a [[f32; 4]],
}

impl Filtered<'_> {
    /// `NUM` pixels of a row from (px, py) on.
    fn pixels<const NUM: usize>(&self, px: i32, py: i32) -> [Pixel; NUM] {
        let Filtered { table, samples, colors, rgba } = self;
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
            let of_pixel = &colors[first + i * per_pixel..first + (i + 1) * per_pixel];
            let depth = of_pixel.iter().fold(f32::INFINITY, |d, s| d.min(s.depth));
            let scale = if totals[i] == 0.0 { 0.0 } else { 1.0 / totals[i] };
            let sum = sums[i];
            [sum[0] * scale, sum[1] * scale, sum[2] * scale, sum[3] * scale, depth]
        })
    }
}
