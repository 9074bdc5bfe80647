//! What blur is known to go wrong with: borders of the frame, transparency, wheels.

use std::io::Cursor;
use std::sync::Arc;

use conformance::blur::{Stage, alpha, boxed, over_pixel};
use conformance::goldens::bits;
use conformance::moving::{defocused, moving};
use conformance::scenes::{self, small};
use glam::{DMat4, DVec3};
use olema::image::Image;
use olema::scene::{Attributes, Keyed, Transform};
use olema::{Hooks, Renderer, Scene, Settings};
use olema_formats::rib::{ReadOptions, RibReader};

fn draw(scene: &Scene, settings: &Settings) -> Image {
    let renderer = Renderer::new(settings.clone()).expect("valid settings");
    renderer.render(scene, &Hooks::default()).expect("a picture").image
}

/// A square of 8 px with its corner at (x, y), with a motion and a lens.
fn square(circle_px: f64, [x, y]: [f64; 2], at: impl Fn(f64, &Stage) -> DMat4) -> Scene {
    let stage = Stage { circle_px, ..Stage::sharp([32, 32]) };
    let mut scene = stage.scene();
    let corners = [[x, y], [x + 8.0, y], [x, y + 8.0], [x + 8.0, y + 8.0]];
    stage.add_quad(&mut scene, corners, 1.0);
    moving(scene, &[0.0, 1.0], |t| at(f64::from(t), &stage))
}

#[test]
fn what_is_beside_the_frame_blurs_into_it() {
    let by = |x: f64, y: f64| move |t: f64, stage: &Stage| stage.shift([x * t, y * t]);
    let swing = |t: f64, stage: &Stage| stage.turn([-16.0, 16.0], 2.5 * (t - 0.5));
    for (name, scene) in [
        ("flies in", square(0.0, [-28.0, 12.0], by(24.0, 3.0))),
        ("flies out", square(0.0, [20.0, 12.0], by(40.0, 0.0))),
        ("passes", square(0.0, [-20.0, -30.0], by(50.0, 90.0))),
        ("out of focus to the left", square(6.0, [-11.0, 10.0], by(0.0, 0.0))),
        ("out of focus below", square(-7.5, [12.0, 36.0], by(0.0, 0.0))),
        ("both", square(5.0, [-16.0, 36.0], by(14.0, -12.0))),
        ("swings in", square(0.0, [4.0, 12.0], swing)),
    ] {
        let narrow = Settings { permutations: 1, ..small(32, 32, [4, 4]) };
        let mut wide_scene = scene.clone();
        wide_scene.camera.screen_window = Some([-48.0, 48.0, -48.0, 48.0]);
        let wide = Settings { resolution: [96, 96], ..narrow.clone() };
        let (seen, all) = (draw(&scene, &narrow), draw(&wide_scene, &wide));
        let [inside, everything] = [&seen, &all].map(|image| {
            image.channel("a").expect("alpha").values.iter().map(|&a| f64::from(a)).sum::<f64>()
        });
        assert!(inside > 1.0 && everything > 1.1 * inside, "{name}: {inside} of {everything}");
        let part = all.part([32, 64, 32, 64]);
        let differing = bits(&seen).iter().zip(bits(&part)).filter(|(a, b)| **a != *b).count();
        assert_eq!(differing, 0, "{name}: the part of a wider frame differs");
        let cropped = draw(&wide_scene, &Settings { crop_px: Some([32, 64, 32, 64]), tile: Some(7), ..wide });
        assert!(bits(&cropped) == bits(&part), "{name}: a crop differs");
    }
}

#[test]
fn a_moving_transparent_sheet_has_no_holes() {
    let stage = Stage::sharp([24, 24]);
    let mut scene = stage.scene();
    stage.add_quad(&mut scene, [[-40.0, -40.0], [64.0, -40.0], [-40.0, 64.0], [64.0, 64.0]], 0.25);
    let scene = moving(scene, &[0.0, 1.0], |t| {
        stage.turn([3.0, 20.0], 0.8 * f64::from(t)) * stage.shift([5.0 * f64::from(t), 0.0])
    });
    for alpha in alpha(&scene, &boxed(stage.size, [4, 4])) {
        assert!((alpha - 0.25).abs() < 1e-6, "{alpha}");
    }
}

#[test]
fn a_moving_transparent_shell_is_seen_through_twice_everywhere() {
    let mut shell = scenes::mesh(conformance::shapes::cube());
    for primitive in &mut shell.primitives {
        let attributes = (*primitive.attributes).clone();
        primitive.attributes =
            Arc::new(Attributes { opacity: [0.5; 3], surface: scenes::surface("constant"), ..attributes });
    }
    let turned = |t: f64| DMat4::from_axis_angle(DVec3::new(0.2, 0.3, 1.0).normalize(), 1.5 * t);
    let moved = moving(shell, &[0.0, 1.0], |t| {
        DMat4::from_translation(DVec3::new(0.3, 0.0, 0.1) * f64::from(t)) * turned(f64::from(t))
    });
    for (name, scene) in [("moving", moved.clone()), ("moving and out of focus", defocused(moved, 3.0, 5.0))]
    {
        let alpha = alpha(&scene, &boxed([48, 48], [4, 4]));
        let inside = (20..28).flat_map(|y| (20..28).map(move |x| y * 48 + x));
        for pixel in inside {
            assert!((alpha[pixel] - 0.75).abs() < 1e-6, "{name}: {} at {pixel}", alpha[pixel]);
        }
        assert!(alpha.iter().any(|&a| a > 0.0 && a < 0.7), "{name}: it is blurred");
    }
}

/// A spoke of 14 x 4 pixels that turns about its end five times.
fn wheel() -> Scene {
    let text = "Format 32 32 1 Projection \"orthographic\" ScreenWindow -16 16 -16 16 Shutter 0 1 \
                WorldBegin Surface \"constant\" \
                MotionBegin [0 1] Rotate 0 0 0 1 Rotate 1800 0 0 1 MotionEnd \
                Patch \"bilinear\" \"P\" [0 -2 5 14 -2 5 0 2 5 14 2 5] WorldEnd";
    let mut reader = RibReader::from_stream("wheel.rib", Box::new(Cursor::new(text)), ReadOptions::default());
    let frame = reader.next_frame().expect("a correct file").expect("a frame");
    assert_eq!(reader.take_diagnostics(), []);
    frame.scene
}

/// Part of the time in which the spoke covers a place.
fn spoke(x: f64, y: f64) -> f64 {
    let r = (x - 16.0).hypot(y - 16.0);
    let past_side = if r > 2.0 { (2.0 / r).asin() } else { std::f64::consts::FRAC_PI_2 };
    let past_end = if r > 14.0 { (14.0 / r).acos() } else { 0.0 };
    (past_side - past_end).max(0.0) / std::f64::consts::PI
}

#[test]
fn a_wheel_that_spins_fast_stays_round() {
    let settings = boxed([32, 32], [32, 32]);
    let alpha = alpha(&wheel(), &settings);
    let (mut worst, mut found_spread, mut spread) = (0.0f64, 0.0, 0.0);
    for (ix, found) in alpha.iter().enumerate() {
        let (px, py) = (ix % 32, ix / 32);
        let expected = over_pixel([px, py], &spoke);
        worst = worst.max((found - expected).abs());
        let r = (px as f64 - 15.5).hypot(py as f64 - 15.5);
        found_spread += found * r * r;
        spread += expected * r * r;
        assert!((r < 12.5) <= (*found > 0.0), "a gap {r} px from the hub");
        assert!((r > 15.5) <= (*found == 0.0), "something {r} px from the hub");
    }
    println!(
        "spinning wheel: off by at most {worst:.4}, spread {:.4} of what it should be",
        found_spread / spread
    );
    // Vertices may be an eighth of a pixel off their circle.
    assert!(
        worst < 0.03 && (found_spread / spread - 1.0).abs() < 0.02,
        "{worst}, {found_spread} of {spread}"
    );
}

#[test]
fn a_wheel_on_keys_too_few_is_not_round() {
    // The same spoke with straight paths from quarter to quarter: what the comparison must not take for a wheel.
    let mut scene = wheel();
    let quarters = (0..=20).map(|q| f64::from(q) * std::f64::consts::FRAC_PI_2);
    let turned = |angle: f64| DMat4::from_rotation_z(angle);
    scene.primitives[0].to_world = Transform::from(Keyed {
        times: (0..=20).map(|q| q as f32 / 20.0).collect(),
        values: quarters.map(turned).collect(),
    });
    let settings = Settings { motion_tolerance_px: 100.0, ..boxed([32, 32], [8, 8]) };
    let alpha = alpha(&scene, &settings);
    let found: f64 = (0..1024)
        .map(|ix| alpha[ix] * ((ix % 32) as f64 - 15.5).hypot((ix / 32) as f64 - 15.5).powi(2))
        .sum();
    let expected: f64 = (0..1024)
        .map(|ix| {
            over_pixel([ix % 32, ix / 32], &spoke)
                * ((ix % 32) as f64 - 15.5).hypot((ix / 32) as f64 - 15.5).powi(2)
        })
        .sum();
    assert!(found / expected < 0.9, "{found} of {expected}");
}
