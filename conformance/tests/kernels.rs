//! Colours of samples are the same bits from scalar code and from every level of vector instructions. (The sampling
//! kernels are held to their twins within the library, hit by hit and count by count.)

use conformance::moving::blurred;
use conformance::scenes::{self, small};
use olema::engine::Bench;
use olema::math::simd::SimdLevel;
use olema::sampling::Kernels;
use olema::{Scene, Settings};

/// Colours of a scene's samples from scalar code, and what else gives.
fn check(name: &str, scene: &Scene, settings: &Settings) {
    let bench = Bench::new(scene, settings).expect("a correct scene");
    let grids = bench.shade(bench.dice(&bench.split()));
    let buffers = bench.sample(&grids).expect("few enough grids");
    let expected = bench.composite(&buffers, Kernels::Scalar);
    let empty = [0.0f32, 0.0, 0.0, 1.0, 1.0, 1.0, f32::INFINITY].map(f32::to_bits);
    assert!(expected.iter().any(|sample| *sample != empty), "{name}: nothing is seen");
    for level in SimdLevel::all() {
        let found = bench.composite(&buffers, Kernels::Lanes(level));
        assert!(found == expected, "{name}, {:?}, {level:?}", settings.samples);
    }
}

#[test]
fn colours_are_the_same_at_every_level() {
    let still = [("teapot", scenes::teapot()), ("layers", scenes::layers())];
    let scenes: Vec<(String, Scene)> = still
        .into_iter()
        .map(|(name, scene)| (name.to_owned(), scene))
        .chain(blurred().into_iter().map(|(name, scene)| (name.to_string(), scene)))
        .collect();
    for (name, scene) in &scenes {
        for samples in [[1, 1], [2, 2], [7, 1], [4, 4]] {
            check(name, scene, &small(53, 37, samples));
        }
    }
}
