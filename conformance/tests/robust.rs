//! Scenes that make no sense are drawn, or refused with a sentence: no panic, no hang.

use std::sync::Arc;

use conformance::closed::{Random, displace};
use conformance::moving::{camera_drives, defocused, deformed, moving};
use conformance::scenes::{add, bicubic, bilinear, camera, small};
use glam::{DMat4, DVec3};
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
    let wild = Random::new(seed ^ 0x5eed).below(3) > 0;
    points(seed, wild)
}

/// Patches with random control points, of all sizes or near the camera's middle.
fn points(seed: u32, wild: bool) -> Scene {
    let mut random = Random::new(seed);
    let mut scene = Scene::new(camera([0.0, -3.0, 0.5], [0.0; 3], 60.0));
    scene.camera.clipping = [[1e-10, f32::INFINITY], [0.01, 1000.0], [1.0, 1e30]][random.below(3) as usize];
    if random.below(4) == 0 {
        scene.camera.projection = Projection::Orthographic;
    }
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

/// Motions of all sizes: out of the frame, through the eye, by several turns, to a point.
fn wild_motion(scene: Scene, random: &mut Random) -> Scene {
    let times: &[f32] =
        [&[0.0, 1.0][..], &[0.0, 0.2, 1.0], &[-3.0, 0.5, 0.6, 40.0]][random.below(3) as usize];
    let reach = [0.0, 0.1, 3.0, 100.0, 1e5, 1e15, 1e30][random.below(7) as usize];
    let turn = [0.0, 1.0, 30.0][random.below(3) as usize];
    let mut part = || random.range(-1.0, 1.0);
    let offset = DVec3::new(part(), part(), part()) * reach;
    let (turn, shrunk) = (turn * part(), 10f64.powf(6.0 * part()));
    moving(scene, times, |t| {
        let t = f64::from(t);
        let size = 1.0 + (shrunk - 1.0) * t.clamp(0.0, 1.0);
        DMat4::from_translation(offset * t)
            * DMat4::from_rotation_y(turn * t)
            * DMat4::from_scale(DVec3::splat(size))
    })
}

#[test]
fn wild_motions_and_lenses_neither_panic_nor_hang() {
    let mut drawn = 0;
    for seed in 5..22 {
        let mut random = Random::new(seed);
        let mut wild = points(1000 + seed, false);
        wild.camera.clipping[0] = wild.camera.clipping[0].max([0.01, 0.5][random.below(2) as usize]);
        wild = wild_motion(wild, &mut random);
        if random.below(3) == 0 {
            wild = deformed(wild);
        }
        if random.below(3) == 0 {
            let far = [1.0, 1e3, 1e20][random.below(3) as usize];
            wild = camera_drives(
                wild,
                [random.range(-far, far), random.range(-3.0, 3.0), random.range(-far, far)],
            );
        }
        if random.below(2) == 0 {
            let fstop = [1e-3, 1.0, 64.0][random.below(3) as usize];
            wild = defocused(wild, fstop, [1e-5, 3.0, 1e9][random.below(3) as usize]);
        }
        let renderer = Renderer::new(small(24, 18, [2, 2])).expect("valid settings");
        if let Ok(frame) = renderer.render(&wild, &Hooks::default()) {
            drawn += u32::from(frame.stats.sample_hits > 0);
        }
    }
    assert!(drawn > 6, "{drawn} of 17 scenes show anything");
}
