//! Pictures and counts whose values are known without the renderer.

use std::sync::Arc;

use conformance::bad_shaders::{BadDisplacement, Fault};
use conformance::closed::Random;
use conformance::scenes::{self, add, bilinear, small};
use conformance::sizes::{Sizes, facing_square, smooth_scenes};
use glam::DMat4;
use olema::image::{Filter, FilterKind};
use olema::scene::{Attributes, Camera, Projection};
use olema::{Hooks, Renderer, Scene, Settings};

/// A square of side `side` pixels, turned by `angle`, in a picture of 64 x 64.
fn turned_square(side: f64, angle: f64, centre: [f64; 2]) -> Scene {
    let camera = Camera { projection: Projection::Orthographic, ..Camera::default() };
    let mut scene = Scene::new(camera);
    let (sin, cos) = angle.sin_cos();
    let corner = |a: f64, b: f64| {
        let (x, y) = (a * side / 2.0, b * side / 2.0);
        [(x * cos - y * sin + centre[0]) / 32.0, (x * sin + y * cos + centre[1]) / 32.0, 5.0]
            .map(|c| c as f32)
    };
    let square = bilinear([corner(-1.0, -1.0), corner(1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0)]);
    let attributes = Arc::new(Attributes { surface: scenes::surface("constant"), ..Attributes::default() });
    add(&mut scene, square, DMat4::IDENTITY, &attributes);
    scene
}

#[test]
fn a_square_covers_its_area_at_any_angle() {
    let filter = Filter { kind: FilterKind::Box, width: [1.0, 1.0] };
    let settings = Settings { filter, ..small(64, 64, [32, 32]) };
    let renderer = Renderer::new(settings).expect("valid settings");
    let mut random = Random::new(5);
    for step in 0..12 {
        let angle = f64::from(step) * std::f64::consts::PI / 24.0;
        let side = random.range(20.0, 40.0);
        let scene = turned_square(side, angle, [random.range(-2.0, 2.0), random.range(-2.0, 2.0)]);
        let frame = renderer.render(&scene, &Hooks::default()).expect("a picture");
        let alpha = frame.image.channel("a").expect("alpha");
        let covered: f64 = alpha.values.iter().map(|a| f64::from(*a)).sum();
        let error = (covered / (side * side) - 1.0).abs();
        assert!(error < 1e-3, "side {side}, step {step}: {covered}, off by {error}");
    }
}

/// Micropolygons over area / shading rate, for rates that give patches of more than a few micropolygons.
fn ratios(scene: &Scene, rates: &[f32]) -> Vec<f64> {
    let ratio = |&rate: &f32| {
        let settings = Settings { shading_rate_scale: rate, ..small(320, 240, [1, 1]) };
        Sizes::of(scene, &settings).expect("a correct scene").ratio(rate.into())
    };
    rates.iter().map(ratio).collect()
}

#[test]
fn micropolygons_are_about_as_large_as_the_shading_rate_says() {
    for (name, scene) in smooth_scenes() {
        // A patch has a micropolygon at least, and a piece is not cut any more to save a few.
        let rates: &[f32] = match name {
            "tube of 11,520 patches" => &[0.25, 0.5, 1.0],
            "subdivision icosahedron, Loop" => &[0.25, 0.5, 1.0],
            _ => &[0.25, 0.5, 1.0, 4.0],
        };
        let ratios = ratios(&scene, rates);
        println!("{name}: {ratios:.3?}");
        // Fewer than 1, and what is drawn is coarser than what was asked for.
        assert!(ratios.iter().all(|ratio| (1.0..1.3).contains(ratio)), "{name}: {ratios:?}");
    }
}

#[test]
fn what_faces_the_camera_has_micropolygons_little_larger_than_the_shading_rate() {
    for angle in [0.0, 0.3, 0.7] {
        let ratios = ratios(&facing_square(200.4, angle), &[0.25, 1.0, 4.0]);
        assert!(ratios.iter().all(|ratio| (0.81..0.86).contains(ratio)), "at {angle}: {ratios:?}");
    }
}

#[test]
fn displacement_that_goes_wrong_is_corrected_and_named() {
    for (fault, bound, word) in [
        (Fault::NotANumber, 0.1, "finite"),
        (Fault::Infinite, 0.1, "finite"),
        // A bound whose square is not finite in single precision.
        (Fault::Infinite, 1e25, "finite"),
        (Fault::Beyond(3.0), 0.1, "needed"),
        (Fault::Huge, 0.1, "needed"),
    ] {
        let mut scene = scenes::mesh(conformance::shapes::cube());
        let mut attributes = (*scene.primitives[0].attributes).clone();
        attributes.displacement_bound = bound;
        attributes.displacement = Some(Arc::new(BadDisplacement {
            fault,
            amplitude: 0.1,
            is_amplitude_known: false,
            one_in: 7,
            is_bump: false,
        }));
        scene.primitives[0].attributes = Arc::new(attributes);
        let renderer = Renderer::new(small(64, 48, [2, 2])).expect("valid settings");
        let frame = renderer.render(&scene, &Hooks::default()).expect("a picture all the same");
        let said = frame.stats.warnings.join("\n");
        assert!(said.contains(word) && said.contains("mesh"), "{fault:?}: {said}");
        let alpha = frame.image.channel("a").expect("alpha");
        assert!(alpha.values.iter().sum::<f32>() > 300.0, "{fault:?}: nothing is drawn");
        assert!(frame.image.channels[..4].iter().all(|c| c.values.iter().all(|v| v.is_finite())));
    }
}
