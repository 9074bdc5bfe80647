//! Pixels are the same bits from scalar code and from every level of vector instructions. (The sampling kernels are also
//! held to their twins within the library, hit by hit and count by count.)

use conformance::moving::blurred;
use conformance::scenes::{self, small};
use olema::engine::Bench;
use olema::math::simd::SimdLevel;
use olema::sampling::Kernels;
use olema::{Scene, Settings};

/// Pixels of a scene with scalar code, and with what else gives.
fn check(name: &str, scene: &Scene, settings: &Settings) {
    let bench = Bench::new(scene, settings).expect("a correct scene");
    let grids = bench.shade(bench.dice(&bench.split()));
    let draw = |kernels| -> Vec<[u32; 5]> {
        let buffers = bench.sample(&grids, kernels).expect("few enough grids");
        bench.resolve(&buffers).iter().map(|pixel| pixel.map(f32::to_bits)).collect()
    };
    let expected = draw(Kernels::Scalar);
    let empty = [0.0f32, 0.0, 0.0, 0.0, f32::INFINITY].map(f32::to_bits);
    assert!(expected.iter().any(|pixel| *pixel != empty), "{name}: nothing is seen");
    for level in SimdLevel::all() {
        assert!(draw(Kernels::Lanes(level)) == expected, "{name}, {:?}, {level:?}", settings.samples);
    }
}

#[test]
fn pixels_are_the_same_at_every_level() {
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
