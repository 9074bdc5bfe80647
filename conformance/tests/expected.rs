//! Pictures and counts whose values are known without the renderer.

use std::sync::Arc;

use conformance::bad_shaders::{BadDisplacement, Fault};
use conformance::closed::Random;
use conformance::scenes::{self, add, bilinear, small};
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

#[test]
fn micropolygons_are_about_as_large_as_the_shading_rate_says() {
    let spheres = [scenes::teapot(), scenes::mesh(conformance::shapes::torus(8, 6))];
    for (ix, scene) in spheres.iter().enumerate() {
        for rate in [0.5f32, 1.0, 4.0] {
            let settings = Settings { shading_rate_scale: rate, ..small(320, 240, [1, 1]) };
            let (mut area, mut count) = (0.0, 0u64);
            olema::engine::grids(scene, &settings, None, |_, grid, _, _| {
                for mp in 0..grid.num_micropolygons() {
                    let [a, b, c, d] = grid.corners(mp).map(|v| [f64::from(grid.x[v]), f64::from(grid.y[v])]);
                    let twice = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
                        ((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])).abs()
                    };
                    area += (twice(a, b, c) + twice(a, c, d)) / 2.0 / 65536.0;
                    count += 1;
                }
            })
            .expect("a correct scene");
            let wanted = area / f64::from(rate);
            let ratio = count as f64 / wanted;
            println!("scene {ix}, rate {rate}: {count} micropolygons, {ratio:.3} of area / rate");
            // Seen edge on, a surface needs more than its area on the screen asks for.
            assert!(ratio < 2.0, "scene {ix}, rate {rate}: {count} micropolygons for an area of {area}");
        }
    }
}

#[test]
fn displacement_that_goes_wrong_is_corrected_and_named() {
    for (fault, word) in [
        (Fault::NotANumber, "finite"),
        (Fault::Infinite, "finite"),
        (Fault::Beyond(3.0), "needed"),
        (Fault::Huge, "needed"),
    ] {
        let mut scene = scenes::mesh(conformance::shapes::cube());
        let mut attributes = (*scene.primitives[0].attributes).clone();
        attributes.displacement_bound = 0.1;
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
