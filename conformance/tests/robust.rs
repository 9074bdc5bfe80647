//! Scenes that make no sense are drawn, or refused with a sentence: no panic, no hang.

use std::sync::Arc;

use conformance::closed::{Random, displace};
use conformance::scenes::{add, bicubic, bilinear, camera, small};
use glam::DMat4;
use olema::scene::{Attributes, Projection};
use olema::{Hooks, Renderer, Scene};

/// Numbers of all sizes, now and then the same one.
fn number(random: &mut Random) -> f32 {
    let size = [1e-30, 1e-6, 1.0, 1.0, 1.0, 30.0, 1e4, 1e15, 1e30, 3e38][random.below(10) as usize];
    let value = match random.below(8) {
        0 => 0.0,
        1 => 1.0,
        2 => -1.0,
        _ => random.range(-1.0, 1.0),
    };
    (value * size) as f32
}

fn scene(seed: u32) -> Scene {
    let mut random = Random::new(seed);
    let mut scene = Scene::new(camera([0.0, -3.0, 0.5], [0.0; 3], 60.0));
    scene.camera.clipping = [[1e-10, f32::INFINITY], [0.01, 1000.0], [1.0, 1e30]][random.below(3) as usize];
    if random.below(4) == 0 {
        scene.camera.projection = Projection::Orthographic;
    }
    let wild = random.below(3) > 0;
    for _ in 0..=random.below(3) {
        let mut point = || {
            if wild && random.below(3) == 0 {
                std::array::from_fn(|_| number(&mut random))
            } else {
                std::array::from_fn(|_| random.range(-3.0, 3.0) as f32)
            }
        };
        let geometry = if seed.is_multiple_of(2) {
            bicubic(std::array::from_fn(|_| point()))
        } else {
            bilinear(std::array::from_fn(|_| point()))
        };
        let attributes =
            Attributes { opacity: [0.5 + 0.5 * (seed % 3) as f32 / 2.0; 3], ..Attributes::default() };
        add(&mut scene, geometry, DMat4::IDENTITY, &Arc::new(attributes));
    }
    if seed.is_multiple_of(5) {
        displace(&mut scene, seed, 0.3);
    }
    scene
}

#[test]
fn wild_patches_neither_panic_nor_hang() {
    let mut drawn = 0;
    for seed in 0..30 {
        let renderer = Renderer::new(small(32, 24, [2, 2])).expect("valid settings");
        if let Ok(frame) = renderer.render(&scene(seed), &Hooks::default()) {
            drawn += u32::from(frame.stats.sample_hits > 0);
        }
    }
    assert!(drawn > 15, "{drawn} of 30 scenes show anything");
}
