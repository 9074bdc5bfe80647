//! Noise of a small picture against a brute-force sampler: random quads of one grid, moving and out of focus.

use super::blurred::{Blurred, with};
use crate::sampling::hash::{Stream, hash, unit};
use crate::sampling::inside::{HitPoint, depth_at, triangle_hit};
use crate::sampling::nomotion::HitSink;
use crate::sampling::{
    MovingGrid, PatternSpec, Rasterizer, Region, RegionSamples, SamplePattern, ShutterShape, Tuple,
    TupleTimes,
};

const REGION: Region = Region { x0: 0, x1: 22, y0: 0, y1: 22 };

/// 7 x 7 quads of about 1.7 px that turn, drift by some 5 px and are out of focus by up to 2.5 px.
fn scene() -> Blurred {
    let mut grid = Blurred::from_fn([7, 7], &[0.0, 0.4, 1.0], |key, i, j| {
        let (sin, cos) = (0.3 + 0.2 * key as f64).sin_cos();
        let [a, b] = [i, j].map(|v| (v as f64 - 3.5) * 1.7);
        let drift = [0.0, 2.5, 5.0][key];
        [8.5 + drift + a * cos - b * sin, 11.5 - 0.4 * drift + a * sin + b * cos]
    });
    grid.coc = (0..grid.x.len()).map(|ix| 90 * (ix as i32 % 8)).collect();
    for (ix, depth) in grid.depth.iter_mut().enumerate() {
        *depth = 5.0 + (ix % 8) as f32;
    }
    grid
}

/// Coverage, and the colour of a quad.
fn value(quad: Option<u32>) -> [f64; 2] {
    quad.map_or([0.0; 2], |quad| [1.0, unit(hash(&[quad, 99]))])
}

/// The nearest quad at a place, for a lens place and a time.
fn trace(grid: &MovingGrid, place: [i32; 2], tuple: &Tuple) -> Option<u32> {
    let time = grid.times.locate(tuple.t15);
    let vertices: Vec<[i32; 2]> =
        (0..grid.num_vertices()).map(|vertex| grid.position(vertex, tuple, time)).collect();
    let mut nearest = (f32::INFINITY, None);
    for quad in 0..grid.m * grid.n {
        let [v0, v1, v2, v3] = grid.corners(quad % grid.m, quad / grid.m);
        for triangle in [[v0, v1, v2], [v0, v2, v3]] {
            let Some(hit) = triangle_hit(triangle.map(|v| vertices[v]), place) else { continue };
            let depth = depth_at(&hit, triangle.map(|v| grid.depth_at(v, time)));
            if depth < nearest.0 {
                nearest = (depth, Some(quad as u32));
            }
        }
    }
    nearest.1
}

type Picture = Vec<[f64; 2]>;

/// A picture by brute force: `samples` gives the samples of a pixel, in [0, 1): x, y, time, lens radius
/// squared and angle.
fn brute_force(mut samples: impl FnMut() -> Vec<[f64; 5]>) -> Picture {
    let pattern = super::pattern([1, 1], 1);
    let scene = scene();
    let times = TupleTimes::new(&pattern, &scene.key_times);
    let grid = scene.grid(&times);
    (0..REGION.num_pixels() as i32)
        .map(|pixel| {
            let mut sum = [0.0; 2];
            let points = samples();
            for [x, y, t, p, q] in &points {
                let (sin, cos) = (q * std::f64::consts::TAU).sin_cos();
                let lens = [cos, sin].map(|v| (p.sqrt() * v * 32_767.0) as i16);
                let tuple = Tuple { u15: lens[0], v15: lens[1], t15: (t * 32_768.0) as i16, x: 0, y: 0 };
                let place = [pixel % 22 * 256 + (x * 256.0) as i32, pixel / 22 * 256 + (y * 256.0) as i32];
                let found = value(trace(&grid, place, &tuple));
                sum = [sum[0] + found[0], sum[1] + found[1]];
            }
            sum.map(|v| v / points.len() as f64)
        })
        .collect()
}

/// Samples that know nothing of each other.
fn unstratified(num: u32, seed: u32) -> Picture {
    let mut stream = Stream::new(seed);
    brute_force(|| (0..num).map(|_| std::array::from_fn(|_| stream.next_unit())).collect())
}

/// 16 rays as a ray tracer stratifies them: a jittered 4 x 4 grid in the pixel; 16 jittered strata of time and
/// 4 x 4 of the lens, each dealt out at random.
fn stratified_rays(seed: u32) -> Picture {
    let mut stream = Stream::new(seed);
    brute_force(|| {
        let mut deal = || {
            let mut order: [u32; 16] = std::array::from_fn(|i| i as u32);
            for i in (1..16).rev() {
                order.swap(i, stream.below(i as u32 + 1) as usize);
            }
            order
        };
        let (times, lens) = (deal(), deal());
        (0..16)
            .map(|j| {
                let cells = [j % 4, j / 4, times[j as usize], lens[j as usize] % 4, lens[j as usize] / 4];
                let within = [4.0, 4.0, 16.0, 4.0, 4.0];
                std::array::from_fn(|dim| (f64::from(cells[dim]) + stream.next_unit()) / within[dim])
            })
            .collect()
    })
}

/// Nearest quad of each sample.
struct Nearest {
    quad: u32,
    found: Vec<(f32, Option<u32>)>,
}

impl HitSink for Nearest {
    fn begin(&mut self, quad: u32) {
        self.quad = quad;
    }

    fn hit(&mut self, sample_ix: usize, point: HitPoint, _triangle: u8, _sign: i8) {
        if point.depth < self.found[sample_ix].0 {
            self.found[sample_ix] = (point.depth, Some(self.quad));
        }
    }
}

/// The picture with 16 samples of the pattern.
fn rasterized(spec: PatternSpec) -> Picture {
    let pattern = SamplePattern::new(spec);
    let samples = RegionSamples::new(&pattern, REGION);
    let mut sink = Nearest { quad: 0, found: vec![(f32::INFINITY, None); samples.len()] };
    scene().draw(with(Rasterizer::Auto), &pattern, &samples, &mut sink);
    sink.found
        .chunks(16)
        .map(|pixel| {
            let sum =
                pixel.iter().map(|&(_, quad)| value(quad)).fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
            sum.map(|v| v / 16.0)
        })
        .collect()
}

/// PSNR of coverage and of colour, from the mean square error over some pictures.
fn psnr(pictures: &[Picture], reference: &Picture) -> [f64; 2] {
    let num = (pictures.len() * reference.len()) as f64;
    [0, 1].map(|of| {
        let square = |p: &Picture| p.iter().zip(reference).map(|(a, b)| (a[of] - b[of]).powi(2)).sum::<f64>();
        -10.0 * (pictures.iter().map(square).sum::<f64>() / num).log10()
    })
}

#[test]
fn a_blurred_picture_is_a_decibel_better_than_stratified_rays_and_a_biased_one_is_not() {
    let reference = unstratified(1024, 1000);
    let itself = psnr(&[unstratified(1024, 2000)], &reference);
    let rays = psnr(&[0, 1, 2, 3].map(stratified_rays), &reference);
    let of = |shutter, tile| {
        let spec = PatternSpec { shutter, tile, ..PatternSpec::default() };
        psnr(&[0, 1, 2, 3].map(|seed| rasterized(PatternSpec { seed, ..spec.clone() })), &reference)
    };
    let ours = of(ShutterShape::Box, 2);
    let biased = of(ShutterShape::Trapezoid { open: 1.0, close: 1.0 }, 2);
    eprintln!(
        "PSNR of coverage and colour in dB: reference against itself {itself:.1?}, 16 stratified rays {rays:.1?}, \
         16 samples K = 2 {ours:.1?}, K = 4 {:.1?}, K = 8 {:.1?}, biased {biased:.1?}",
        of(ShutterShape::Box, 4),
        of(ShutterShape::Box, 8)
    );
    for kind in 0..2 {
        assert!(itself[kind] > rays[kind] + 5.0, "the reference is no noisier than what it judges");
        assert!(ours[kind] > rays[kind] + 1.0, "{ours:?} {rays:?}");
        assert!(biased[kind] < rays[kind] + 1.0, "{biased:?} passes");
    }
}
