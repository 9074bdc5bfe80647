//! Closed surfaces that move and are out of focus: at every sample the signed count of hits is zero.

use proptest::prelude::*;

use super::SignedHits;
use super::blurred::{Blurred, with};
use crate::sampling::hash::Stream;
use crate::sampling::{Rasterizer, Region, RegionSamples, SamplePattern};

/// A torus of `around` x `along` vertices, its raster places per key: the grids that it is cut into share rows
/// and columns of vertices, and its seams close.
struct Torus {
    around: usize,
    along: usize,
    key_times: Vec<f32>,
    /// x, y and circle of confusion in 1/256 px, at `(key * along + j) * around + i`.
    vertices: Vec<[i32; 3]>,
}

impl Torus {
    /// A torus that tumbles, grows or shrinks, flies and is noisy: turning over, folding and crossing itself.
    fn random(stream: &mut Stream, num_keys: usize) -> Self {
        let (around, along) = (9, 6);
        let mut key_times: Vec<f32> = vec![0.0];
        for key in 1..num_keys {
            let at = (key as f64 - 0.8 * stream.next_unit()) / (num_keys - 1) as f64;
            key_times.push(if key + 1 == num_keys { 1.0 } else { at as f32 });
        }
        let rough = [0.0, 0.3, 2.0][stream.below(3) as usize];
        let focus = [0.0, 0.4, 5.0][stream.below(3) as usize];
        let speed = [0.0, 1.0, 20.0][stream.below(3) as usize];
        let mut vertices = Vec::new();
        for _ in 0..num_keys {
            let mut random = || 2.0 * stream.next_unit() - 1.0;
            let (yaw, tilt) = (random() * 3.1, random() * 3.1);
            let centre = [random() * speed, random() * speed];
            let size = 1.5 + random();
            for j in 0..along {
                for i in 0..around {
                    let [a, b] = [i as f64 / around as f64, j as f64 / along as f64]
                        .map(|turn| turn * std::f64::consts::TAU);
                    let ring = 2.0 + b.cos();
                    let [x, y, z] = [ring * a.cos(), ring * a.sin(), b.sin()];
                    let [x, z] = [x * yaw.cos() - z * yaw.sin(), x * yaw.sin() + z * yaw.cos()];
                    let [y, z] = [y * tilt.cos() - z * tilt.sin(), y * tilt.sin() + z * tilt.cos()];
                    let place = [x, y].map(|v| v * size + rough * random());
                    let c = focus * (z / 3.0 + 0.2 * random());
                    vertices
                        .push([place[0] + centre[0], place[1] + centre[1], c].map(|v| (v * 256.0) as i32));
                }
            }
        }
        Torus { around, along, key_times, vertices }
    }

    /// The grids: cut into blocks of 4 x 2 quads at most.
    fn grids(&self) -> Vec<Blurred> {
        let mut grids = Vec::new();
        for j0 in (0..self.along).step_by(2) {
            for i0 in (0..self.around).step_by(4) {
                let size = [(self.around - i0).min(4), (self.along - j0).min(2)];
                let mut coc = Vec::new();
                let mut grid = Blurred::from_fn(size, &self.key_times, |_, _, _| [0.0; 2]);
                for (ix, (x, y)) in grid.x.iter_mut().zip(&mut grid.y).enumerate() {
                    let num = (size[0] + 1) * (size[1] + 1);
                    let (key, i, j) = (ix / num, ix % num % (size[0] + 1), ix % num / (size[0] + 1));
                    let at =
                        (key * self.along + (j0 + j) % self.along) * self.around + (i0 + i) % self.around;
                    let vertex = self.vertices[at];
                    (*x, *y) = (vertex[0], vertex[1]);
                    coc.push(vertex[2]);
                }
                grid.coc = coc;
                grids.push(grid);
            }
        }
        grids
    }
}

/// Hits, and samples at which fronts and backs differ in number.
fn draw(
    grids: &[Blurred],
    rasterizer: Rasterizer,
    pattern: &SamplePattern,
    samples: &RegionSamples,
) -> (u32, usize) {
    let mut sink = SignedHits::new(samples.len());
    for grid in grids {
        grid.draw(with(rasterizer), pattern, samples, &mut sink);
    }
    (sink.counts.iter().sum(), sink.sums.iter().filter(|&&sum| sum != 0).count())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]
    #[test]
    fn a_moving_closed_surface_has_as_many_fronts_as_backs_at_every_sample(
        seed in any::<u32>(),
        num_keys in 1usize..5,
        which in 0usize..4,
    ) {
        let (samples, tile) = [([4, 4], 2), ([2, 2], 4), ([8, 8], 1), ([3, 3], 3)][which];
        let pattern = super::pattern(samples, tile);
        let samples = RegionSamples::new(&pattern, Region::new(-11, 11, -9, 9));
        let grids = Torus::random(&mut Stream::new(seed), num_keys).grids();
        let mut all_hits = Vec::new();
        for rasterizer in [Rasterizer::Interval, Rasterizer::InterleaveUvt, Rasterizer::Auto] {
            let (hits, cracks) = draw(&grids, rasterizer, &pattern, &samples);
            prop_assert_eq!(cracks, 0, "{:?}: {} hits", rasterizer, hits);
            all_hits.push(hits);
        }
        prop_assert!(all_hits.iter().all(|&hits| hits == all_hits[0]));
    }
}

#[test]
fn a_vertex_out_of_place_or_other_key_times_open_cracks() {
    let pattern = super::pattern([4, 4], 2);
    let samples = RegionSamples::new(&pattern, Region::new(-11, 11, -9, 9));
    let whole = Torus::random(&mut Stream::new(8), 3).grids();
    let (hits, cracks) = draw(&whole, Rasterizer::Auto, &pattern, &samples);
    assert!(hits > 1000 && cracks == 0, "{hits} hits, {cracks} cracks");
    let cracks_of = |sabotage: fn(&mut Blurred)| {
        let mut grids = whole.clone();
        sabotage(&mut grids[3]);
        draw(&grids, Rasterizer::Auto, &pattern, &samples).1
    };
    assert!(cracks_of(|grid| grid.x[2] += 128) > 0);
    assert!(cracks_of(|grid| grid.coc[2] += 256) > 0);
    assert!(cracks_of(|grid| grid.key_times[1] *= 0.9) > 0);
}
