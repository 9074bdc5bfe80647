//! Resolve in lanes: colours of the nearest opaque surfaces, 16 samples at a time.
//!
//! In: a tile's records. Out: what [`super::resolve::composite_one`], the scalar twin, gives for each, bit for bit. The
//! samples of a row lie side by side; those that hit the same triangle are interpolated together, a lane each. What does
//! not fit in 16 bits around the samples, moves over more than one segment or was clipped goes to the twin.

use crate::math::lanes::{Lanes, pair};
use crate::math::simd::{LANES, LanesKernel, SimdLevel};
use crate::sampling::Payload;
use crate::scene::ShadingInterpolation;

use super::grid::{Grid, triangles};
use super::resolve::{SampleColor, composite_one, flat, opacity};
use super::sample::{DrawContext, TileBuffers};
use super::shade::Colors;

/// Farthest that a vertex may be from the first pixel of 16 samples, in 1/256 px, circle of confusion included.
const MOST: i32 = 16_000;

/// As [`super::resolve::composite_opaque`].
pub(super) fn composite_opaque(
    level: SimdLevel,
    context: &DrawContext,
    buffers: &TileBuffers,
    colors: &mut [SampleColor],
) {
    level.run_lanes(Kernel { context, buffers, colors });
}

struct Kernel<'a> {
    context: &'a DrawContext<'a>,
    buffers: &'a TileBuffers,
    colors: &'a mut [SampleColor],
}

impl LanesKernel for Kernel<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, lanes: L) {
        let samples = &self.buffers.samples;
        let num = samples.region.width() * samples.samples_per_pixel();
        for row in 0..samples.region.height() {
            for j in (0..num).step_by(LANES) {
                self.composite(lanes, row, j, num);
            }
        }
    }
}

/// Up to 16 samples of a row.
struct Chunk<L: Lanes> {
    /// Index of the first one.
    first: usize,
    /// Its pixel in 1/256 px.
    origin: [i32; 2],
    /// Places of the samples from there.
    place: L::I,
    /// Local times and lens places, once a grid needs them, for this set of key times.
    moving: Option<(u32, L::I, L::I)>,
}

/// Colours by channel and lane.
type ByLane = [[f32; LANES]; 3];

impl Kernel<'_> {
    /// Samples `j..j + 16` of a row that has `num`.
    #[inline(always)]
    fn composite<L: Lanes>(&mut self, lanes: L, row: usize, j: usize, num: usize) {
        let TileBuffers { samples, nearest, slots, .. } = self.buffers;
        let first = row * num + j;
        let payloads = &nearest.payloads()[first..first + LANES];
        let payload = lanes.load(payloads, 0);
        let none = lanes.bits(lanes.eq(payload, lanes.splat(Payload::NONE.0 as i32)));
        let mut left = 0xffff_u32 >> (LANES - (num - j).min(LANES)) & !none;
        if left == 0 {
            return;
        }
        let px = j / samples.samples_per_pixel();
        let step = lanes.load(samples.steps(), j - px * samples.samples_per_pixel());
        let mut chunk = Chunk {
            first,
            origin: [(samples.region.x0 + px as i32) * 256, (samples.region.y0 + row as i32) * 256],
            place: lanes.add(lanes.load(samples.places(), first), step),
            moving: None,
        };
        let mut out: ByLane = [[0.0; LANES]; 3];
        while left != 0 {
            let of_first = payloads[left.trailing_zeros() as usize & (LANES - 1)];
            let same = lanes.bits(lanes.eq(payload, lanes.splat(of_first))) & left;
            left &= !same;
            let of_first = Payload(of_first as u32);
            let Some(surface) = slots.surface(of_first) else { continue };
            let grid = surface.0;
            let done = if grid.look.interpolation == ShadingInterpolation::Constant {
                let (color, _) = flat(surface, of_first);
                out = color.map(|c| [c; LANES]);
                true
            } else {
                self.interpolate(lanes, surface, of_first, &mut chunk, &mut out)
            };
            let opacity = opacity(grid);
            let mut bits = same;
            while bits != 0 {
                let lane = bits.trailing_zeros() as usize & (LANES - 1);
                bits &= bits - 1;
                let ix = first + lane;
                if done {
                    let color = [out[0][lane], out[1][lane], out[2][lane]];
                    self.colors[ix].behind(color, opacity, nearest.get(ix).depth);
                } else {
                    composite_one(self.context, self.buffers, ix, &mut self.colors[ix]);
                }
            }
        }
    }

    /// Colours of a micropolygon at all samples of a chunk, those that hit it being right; false where it does not fit.
    #[inline(always)]
    fn interpolate<L: Lanes>(
        &self,
        lanes: L,
        (grid, colors): (&Grid, &Colors),
        payload: Payload,
        chunk: &mut Chunk<L>,
        out: &mut ByLane,
    ) -> bool {
        let micropolygon = payload.micropolygon() as usize;
        if grid.is_slow(micropolygon) {
            return false;
        }
        let triangle = triangles(grid, micropolygon)[payload.triangle() as usize];
        let weights = if grid.is_blurred() {
            self.moving_weights(lanes, grid, triangle, chunk)
        } else {
            still_weights(lanes, grid, triangle, chunk)
        };
        let Some([w1, w2, r]) = weights else { return false };
        let (b1, b2) = (lanes.mul_f(w1, r), lanes.mul_f(w2, r));
        let b0 = lanes.sub_f(lanes.sub_f(lanes.splat_f(1.0), b1), b2);
        let b0 = lanes.greater(b0, lanes.splat_f(0.0));
        for (out, values) in out.iter_mut().zip(colors.color.axes()) {
            let part = |corner: usize| lanes.splat_f(values[triangle[corner]]);
            let sum = lanes.add_f(lanes.mul_f(part(0), b0), lanes.mul_f(part(1), b1));
            lanes.store_f(lanes.add_f(sum, lanes.mul_f(part(2), b2)), out, 0);
        }
        true
    }

    /// Weights of the second and the third vertex, and 1 / area, of a triangle that moves or is out of focus.
    #[inline(always)]
    fn moving_weights<L: Lanes>(
        &self,
        lanes: L,
        grid: &Grid,
        triangle: [usize; 3],
        chunk: &mut Chunk<L>,
    ) -> Option<[L::F; 3]> {
        if grid.keys > 2 {
            return None;
        }
        let (time, lens) = self.moving(lanes, grid, chunk);
        let after = if grid.keys == 1 { 0 } else { grid.num_vertices() };
        let mut rel = [lanes.splat(0); 3];
        for (corner, rel) in rel.iter_mut().enumerate() {
            let (from, to) = (triangle[corner], triangle[corner] + after);
            let [x0, x1] = [grid.x[from] - chunk.origin[0], grid.x[to] - chunk.origin[0]];
            let [y0, y1] = [grid.y[from] - chunk.origin[1], grid.y[to] - chunk.origin[1]];
            let [c0, c1] = if grid.coc.is_empty() { [0; 2] } else { [grid.coc[from], grid.coc[to]] };
            let farthest = x0.abs().max(x1.abs()).max(y0.abs().max(y1.abs()));
            if farthest > MOST || c0.abs().max(c1.abs()) > MOST - farthest {
                return None;
            }
            let moved = lanes.scale2(time, lanes.splat(pair(x1 - x0, y1 - y0)));
            let coc = lanes.scale2(time, lanes.splat(pair(c1 - c0, c1 - c0)));
            let coc = lanes.add2(lanes.splat(pair(c0, c0)), coc);
            let at = lanes.add2(lanes.add2(lanes.splat(pair(x0, y0)), moved), lanes.scale2(lens, coc));
            *rel = lanes.sub2(at, chunk.place);
        }
        let turned0 = lanes.turned(rel[0]);
        let w1 = lanes.dot2(rel[2], turned0);
        let w2 = lanes.dot2(rel[0], lanes.turned(rel[1]));
        let w0 = lanes.dot2(rel[1], lanes.turned(rel[2]));
        let area = lanes.add(lanes.add(w0, w1), w2);
        let r = lanes.div_f(lanes.splat_f(1.0), lanes.to_f(area));
        Some([lanes.to_f(w1), lanes.to_f(w2), r])
    }

    /// Local times, in both halves, and lens places of a chunk's tuples.
    #[inline(always)]
    fn moving<L: Lanes>(&self, lanes: L, grid: &Grid, chunk: &mut Chunk<L>) -> (L::I, L::I) {
        if let Some((motion, time, lens)) = chunk.moving
            && motion == grid.motion
        {
            return (time, lens);
        }
        let tuples = &self.buffers.samples.tuples;
        let times = &self.context.times[grid.motion as usize];
        let (mut time, mut lens) = ([0; LANES], [0; LANES]);
        let last = (chunk.first + LANES).min(tuples.len());
        for (lane, &ix) in tuples[chunk.first..last].iter().enumerate() {
            let (tuple, t15) = (&self.context.pattern.tuples()[ix as usize], times.of_tuple(ix).t15);
            time[lane] = pair(t15.into(), t15.into());
            lens[lane] = pair(tuple.u15.into(), tuple.v15.into());
        }
        let (time, lens) = (lanes.load(&time, 0), lanes.load(&lens, 0));
        chunk.moving = Some((grid.motion, time, lens));
        (time, lens)
    }
}

/// The same for a triangle that stands still in focus: edge functions are `A . s + C`.
#[inline(always)]
fn still_weights<L: Lanes>(
    lanes: L,
    grid: &Grid,
    triangle: [usize; 3],
    chunk: &Chunk<L>,
) -> Option<[L::F; 3]> {
    let at = |corner: usize| {
        let vertex = triangle[corner];
        [grid.x[vertex] - chunk.origin[0], grid.y[vertex] - chunk.origin[1]]
    };
    let [a, b, c] = [at(0), at(1), at(2)];
    if [a, b, c].iter().any(|v| v[0].abs() > MOST / 2 || v[1].abs() > MOST / 2) {
        return None;
    }
    let edge = |a: [i32; 2], b: [i32; 2]| {
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        (pair(-dy, dx), dy * a[0] - dx * a[1])
    };
    let ((d1, c1), (d2, c2)) = (edge(c, a), edge(a, b));
    let w1 = lanes.add(lanes.dot2(chunk.place, lanes.splat(d1)), lanes.splat(c1));
    let w2 = lanes.add(lanes.dot2(chunk.place, lanes.splat(d2)), lanes.splat(c2));
    let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    Some([lanes.to_f(w1), lanes.to_f(w2), lanes.splat_f(1.0 / area as f32)])
}
