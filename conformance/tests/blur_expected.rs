//! Pictures of what moves or is out of focus, whose values are known without the renderer: 4096 samples a pixel must
//! come as near to them as 4096 samples can.

use conformance::blur::{Errors, Stage, boxed, disk_beyond, half_plane, light_until, over_time, shared_area};
use conformance::moving::moving;
use olema::scene::{Geometry, Keyed, Points};
use olema::{Scene, Settings};

fn settings(stage: &Stage) -> Settings {
    Settings { shading_rate_scale: 4.0, ..boxed(stage.size, [32, 32]) }
}

#[track_caller]
fn check(name: &str, scene: &Scene, settings: &Settings, truth: impl Fn(f64, f64) -> f64) {
    let errors = Errors::of(scene, settings, truth);
    println!("{name}: {errors:.2?} standard errors of 4096 samples");
    assert!(errors.are_of_sampling(), "{name}: {errors:?}");
}

/// An edge that goes from x = 4 1/8 to 9 3/8.
fn moving_edge(stage: &Stage) -> Scene {
    let mut scene = stage.scene();
    stage.add_quad(&mut scene, half_plane([4.125, 2.0], 0.0), 1.0);
    moving(scene, &[0.0, 1.0], |t| stage.shift([5.25 * f64::from(t), 0.0]))
}

fn moving_edge_truth(x: f64) -> f64 {
    1.0 - ((x - 4.125) / 5.25).clamp(0.0, 1.0)
}

#[test]
fn a_moving_edge_covers_pixels_for_its_share_of_time_and_a_biased_shutter_does_not() {
    let stage = Stage::sharp([16, 4]);
    let mut scene = moving_edge(&stage);
    check("moving edge", &scene, &settings(&stage), |x, _| moving_edge_truth(x));
    scene.camera.shutter_opening = [0.1, 1.0];
    let biased = Errors::of(&scene, &settings(&stage), |x, _| moving_edge_truth(x));
    assert!(!biased.are_of_sampling(), "the comparison cannot fail: {biased:?}");
}

#[test]
fn a_moving_edge_out_of_focus_is_the_convolution_of_both() {
    // Time and lens that were paired would give another profile: the wider or narrower one of a single ramp.
    for circle_px in [2.5, -2.5] {
        let stage = Stage { circle_px, ..Stage::sharp([16, 4]) };
        let scene = moving_edge(&stage);
        let at = |x: f64, t: f64| (x - 4.125 - 5.25 * t) / 2.5;
        let settings = settings(&stage);
        check("moving edge out of focus", &scene, &settings, |x, _| over_time(64, |t| disk_beyond(at(x, t))));
        let few = Errors::of_few_samples(&scene, &settings, |x, _| over_time(64, |t| disk_beyond(at(x, t))));
        println!("the same with 256 times 16 samples: {few:.2?}");
        assert!(few.are_of_sampling(), "{few:?}");
        let lens: Vec<f64> = (0..128).map(|step| inverse_disk_beyond((step as f64 + 0.5) / 128.0)).collect();
        for sign in [1.0, -1.0] {
            let paired =
                |x, _| over_time(128, |t| f64::from(u8::from(at(x, t) < sign * lens[(t * 128.0) as usize])));
            let errors = Errors::of(&scene, &settings, paired);
            assert!(!errors.are_of_sampling(), "the comparison cannot fail: {errors:?}");
        }
    }
}

/// The s for which a part `share` of the unit disk has u above s.
fn inverse_disk_beyond(share: f64) -> f64 {
    let (mut low, mut high) = (-1.0, 1.0);
    for _ in 0..40 {
        let middle = (low + high) / 2.0;
        if disk_beyond(middle) > share { low = middle } else { high = middle }
    }
    low
}

#[test]
fn uneven_keys_divide_the_time() {
    let stage = Stage::sharp([16, 4]);
    let mut scene = stage.scene();
    stage.add_quad(&mut scene, half_plane([4.0, 2.0], 0.0), 1.0);
    let Geometry::Patches(mesh) = &mut scene.primitives[0].geometry else { unreachable!("a quad") };
    let mesh = std::sync::Arc::make_mut(mesh);
    let (times, places) = ([0.0, 0.25, 1.0], [4.0, 9.5, 11.25]);
    let points = |x: f64| Points::P(half_plane([x, 2.0], 0.0).map(|p| stage.point(p)).to_vec());
    mesh.points = Keyed { times: times.to_vec(), values: places.map(points).to_vec() };
    check("edge on uneven keys", &scene, &settings(&stage), |x, _| {
        let share = |key: usize| ((x - places[key]) / (places[key + 1] - places[key])).clamp(0.0, 1.0);
        1.0 - 0.25 * share(0) - 0.75 * share(1)
    });
}

#[test]
fn a_rotating_square_covers_each_place_for_its_share_of_time() {
    let stage = Stage::sharp([28, 28]);
    let (half, [cx, cy], angle) = (8.0, [14.25, 13.75], 1.2);
    let mut scene = stage.scene();
    let corner = |a: f64, b: f64| [cx + a * half, cy + b * half];
    let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0)];
    stage.add_quad(&mut scene, corners, 1.0);
    let scene = moving(scene, &[0.0, 1.0], |t| stage.turn([cx, cy], angle * f64::from(t)));
    let settings = Settings { motion_tolerance_px: 1.0 / 256.0, ..settings(&stage) };
    check("rotating square", &scene, &settings, |x, y| {
        let (x, y) = (x - cx, y - cy);
        let r = x.hypot(y);
        if r <= half || r >= half * std::f64::consts::SQRT_2 {
            return f64::from(u8::from(r <= half));
        }
        over_time(256, |t| {
            let (sin, cos) = (angle * t).sin_cos();
            let inside = (x * cos + y * sin).abs() < half && (y * cos - x * sin).abs() < half;
            f64::from(u8::from(inside))
        })
    });
}

#[test]
fn what_turns_and_reaches_far_beyond_the_frame_keeps_its_path() {
    // A half plane that turns about the middle of the frame, as a camera that rolls sees the ground: all of its
    // corners are several frames away.
    let stage = Stage::sharp([16, 16]);
    let mut scene = stage.scene();
    stage.add_quad(&mut scene, half_plane([11.0, 8.0], 0.0), 1.0);
    let scene = moving(scene, &[0.0, 1.0], |t| stage.turn([8.0, 8.0], 1.2 * f64::from(t)));
    let settings = Settings { motion_tolerance_px: 1.0 / 256.0, ..settings(&stage) };
    check("turning half plane", &scene, &settings, |x, y| {
        over_time(256, |t| {
            let (sin, cos) = (1.2 * t).sin_cos();
            f64::from(u8::from((x - 8.0) * cos + (y - 8.0) * sin < 3.0))
        })
    });
}

#[test]
fn an_edge_out_of_focus_has_the_profile_of_the_disk() {
    for (circle_px, angle) in [(0.75, 0.0), (3.0, 0.0), (-3.0, 0.6), (3.0, 2.0)] {
        let stage = Stage { circle_px, ..Stage::sharp([12, 12]) };
        let mut scene = stage.scene();
        stage.add_quad(&mut scene, half_plane([6.25, 6.0], angle), 1.0);
        let (sin, cos) = angle.sin_cos();
        check(&format!("edge out of focus by {circle_px}"), &scene, &settings(&stage), |x, y| {
            disk_beyond(((x - 6.25) * cos + (y - 6.0) * sin) / circle_px.abs())
        });
    }
}

#[test]
fn a_disk_out_of_focus_has_the_profile_of_two_disks() {
    for (radius, circle_px) in [(0.75, 3.5), (1.5, 3.5), (1.5, -3.5), (4.0, 2.0)] {
        let stage = Stage { circle_px, ..Stage::sharp([16, 16]) };
        let mut scene = stage.scene();
        stage.add_disk(&mut scene, [8.2, 7.9], radius, 48);
        let circle = circle_px.abs();
        check(&format!("disk of {radius} out of focus by {circle_px}"), &scene, &settings(&stage), |x, y| {
            shared_area(radius, circle, (x - 8.2).hypot(y - 7.9)) / (std::f64::consts::PI * circle * circle)
        });
    }
}

#[test]
fn brightness_along_a_path_follows_the_opening_of_the_shutter() {
    let stage = Stage::sharp([48, 3]);
    let mut scene = stage.scene();
    stage.add_quad(&mut scene, [[4.0, -1.0], [8.0, -1.0], [4.0, 4.0], [8.0, 4.0]], 1.0);
    let mut scene = moving(scene, &[0.0, 1.0], |t| stage.shift([32.0 * f64::from(t), 0.0]));
    for [open, close] in [[0.0f32, 1.0], [0.25, 0.75], [0.5, 0.5], [0.0, 0.25], [1.0, 1.0]] {
        scene.camera.shutter_opening = [open, close];
        let light = |t: f64| light_until(t, f64::from(open), f64::from(close));
        check(&format!("shutter {open} {close}"), &scene, &settings(&stage), |x, _| {
            light((x - 4.0) / 32.0) - light((x - 8.0) / 32.0)
        });
    }
}
