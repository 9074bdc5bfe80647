//! Lights against values worked out by hand, placed by several matrices.

use super::super::{ShaderParam, light};
use super::*;

fn place(name: &str, params: &[ShaderParam], to_camera: &DMat4) -> Arc<dyn PlacedLight> {
    let made = light(name, params).unwrap();
    assert_eq!(made.warnings, Vec::<String>::new());
    assert_eq!(made.shader.name(), name);
    made.shader.place(to_camera)
}

#[track_caller]
fn assert_from(found: LightSample, l: [f32; 3], cl: [f32; 3]) {
    let LightSample::From { l: found_l, cl: found_cl } = found else { panic!("{found:?} has no direction") };
    let (dl, dcl) = ((found_l - Vec3::from(l)).abs(), (found_cl - Vec3::from(cl)).abs());
    assert!(dl.max_element() < 1e-6 && dcl.max_element() < 1e-6, "{found:?} is not {l:?} {cl:?}");
}

const COLORED: [f32; 3] = [1.0, 0.5, 0.0];

fn colored() -> [ShaderParam; 2] {
    [ShaderParam::float("intensity", 8.0), ShaderParam::color("lightcolor", COLORED)]
}

#[test]
fn ambient_light_is_everywhere() {
    let placed = place("ambientlight", &colored(), &DMat4::from_translation(DVec3::splat(9.0)));
    for p in [Vec3::ZERO, Vec3::splat(1e30), Vec3::NAN] {
        assert_eq!(placed.sample(p), LightSample::Ambient { cl: Vec3::new(8.0, 4.0, 0.0) });
    }
}

#[test]
fn distant_light_shines_from_from_towards_to() {
    // By default along +z, so the light is seen in -z.
    assert_from(
        place("distantlight", &[], &DMat4::IDENTITY).sample(Vec3::ZERO),
        [0.0, 0.0, -1.0],
        [1.0, 1.0, 1.0],
    );
    let given = [ShaderParam::point("from", [3.0, 0.0, 4.0]), ShaderParam::point("to", [0.0; 3])];
    let placed = place("distantlight", &given, &DMat4::IDENTITY);
    assert_from(placed.sample(Vec3::splat(100.0)), [0.6, 0.0, 0.8], [1.0; 3]);
}

#[test]
fn placing_turns_directions_and_moves_points() {
    // A quarter turn about y carries +z to +x; the translation must not touch a direction.
    let turn = DMat4::from_translation(DVec3::new(5.0, 6.0, 7.0))
        * DMat4::from_cols_array(&[
            0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0,
        ]);
    assert_from(place("distantlight", &[], &turn).sample(Vec3::ZERO), [-1.0, 0.0, 0.0], [1.0; 3]);
    // The point light sits at (5, 6, 7) then; seen from 2 below, a quarter of it arrives.
    assert_from(
        place("pointlight", &colored(), &turn).sample(Vec3::new(5.0, 4.0, 7.0)),
        [0.0, 1.0, 0.0],
        [2.0, 1.0, 0.0],
    );
    // The spot shines along +x there.
    assert_from(
        place("spotlight", &colored(), &turn).sample(Vec3::new(7.0, 6.0, 7.0)),
        [-1.0, 0.0, 0.0],
        [2.0, 1.0, 0.0],
    );
}

#[test]
fn point_light_falls_off_with_the_square() {
    let given = [ShaderParam::point("from", [1.0, 2.0, 3.0]), ShaderParam::float("intensity", 9.0)];
    let placed = place("pointlight", &given, &DMat4::IDENTITY);
    assert_from(placed.sample(Vec3::new(1.0, 2.0, 0.0)), [0.0, 0.0, 1.0], [1.0; 3]);
    assert_from(placed.sample(Vec3::new(0.0, 0.0, 1.0)), [1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0], [1.0; 3]);
}

/// Point at a distance of 1 from the origin, `degrees` off the z axis.
fn off_axis(degrees: f64) -> Vec3 {
    let angle = degrees.to_radians();
    Vec3::new(angle.sin() as f32, 0.0, angle.cos() as f32)
}

fn brightness(placed: &dyn PlacedLight, p: Vec3) -> f32 {
    let LightSample::From { cl, .. } = placed.sample(p) else { panic!("a light with direction") };
    cl.x
}

#[test]
fn spot_light_fades_between_its_cones() {
    let placed = place("spotlight", &[], &DMat4::IDENTITY);
    let wanted = |degrees: f64| {
        let cos = degrees.to_radians().cos();
        let (outer, inner) = (30f64.to_radians().cos(), 25f64.to_radians().cos());
        let t = ((cos - outer) / (inner - outer)).clamp(0.0, 1.0);
        cos * cos * t * t * (3.0 - 2.0 * t)
    };
    for degrees in [0.0, 10.0, 24.9, 25.1, 27.0, 27.5, 29.0, 29.9, 30.1, 45.0, 90.0, 135.0, 180.0] {
        let found = f64::from(brightness(&*placed, off_axis(degrees)));
        assert!((found - wanted(degrees)).abs() < 1e-5, "{degrees}: {found}, not {}", wanted(degrees));
    }
    // Twice as far, a quarter.
    let (near, far) = (brightness(&*placed, off_axis(10.0)), brightness(&*placed, 2.0 * off_axis(10.0)));
    assert!((near - 4.0 * far).abs() < 1e-6);
}

#[test]
fn spot_light_takes_wide_hard_and_even_beams() {
    let spot = |cone: f32, delta: f32, beam: f32| {
        let given = [
            ShaderParam::float("coneangle", cone),
            ShaderParam::float("conedeltaangle", delta),
            ShaderParam::float("beamdistribution", beam),
        ];
        place("spotlight", &given, &DMat4::IDENTITY)
    };
    // Nothing to fade over: all or nothing.
    let hard = spot(0.5, 0.0, 0.0);
    assert!((brightness(&*hard, off_axis(28.0)) - 1.0).abs() < 1e-6);
    assert_eq!(brightness(&*hard, off_axis(29.0)), 0.0);
    // Wider than a full sphere still lights what is behind, where the beam's power lets it.
    let all_around = spot(9.0, 0.0, 0.0);
    assert!((brightness(&*all_around, off_axis(179.0)) - 1.0).abs() < 1e-6);
    assert_eq!(brightness(&*spot(9.0, 0.0, 2.5), off_axis(120.0)), 0.0);
    let narrow = spot(1.0, 0.1, 32.0);
    let wanted = 20f64.to_radians().cos().powi(32) as f32;
    assert!((brightness(&*narrow, off_axis(20.0)) - wanted).abs() < 1e-5);
}

#[test]
fn lights_that_shine_nowhere_stay_dark() {
    let given = [ShaderParam::point("to", [0.0; 3])];
    for name in ["distantlight", "spotlight"] {
        let made = light(name, &given).unwrap();
        assert_eq!(made.warnings.len(), 1);
        assert!(made.warnings[0].contains("without direction"), "{:?}", made.warnings);
        assert_eq!(brightness(&*made.shader.place(&DMat4::IDENTITY), Vec3::Z), 0.0);
    }
    // Matrices that flatten everything, or leave no finite point.
    for matrix in [DMat4::ZERO, DMat4::from_scale(DVec3::splat(f64::NAN)), DMat4::from_scale(DVec3::MAX)] {
        for name in ["distantlight", "pointlight", "spotlight"] {
            let placed = place(name, &[ShaderParam::point("from", [2.0; 3])], &matrix);
            assert_eq!(brightness(&*placed, Vec3::Z), 0.0, "{name} {matrix}");
        }
    }
    // At the light itself there is no direction.
    let LightSample::From { l, cl } = place("pointlight", &[], &DMat4::IDENTITY).sample(Vec3::ZERO) else {
        panic!("a light with direction")
    };
    assert!(l == Vec3::ZERO && cl.is_finite());
}

#[test]
fn tiny_and_huge_scenes_keep_directions() {
    for size in [1e-25f32, 1e-18, 1e18, 1e25] {
        let given = [ShaderParam::point("from", [3.0 * size, 0.0, 0.0]), ShaderParam::point("to", [0.0; 3])];
        let placed = place("spotlight", &given, &DMat4::IDENTITY);
        let LightSample::From { l, cl } = placed.sample(Vec3::ZERO) else { panic!("a light with direction") };
        assert!((l - Vec3::X).abs().max_element() < 1e-6 && cl.is_finite(), "{size:e}: {l} {cl}");
    }
}

#[test]
fn every_name_makes_a_light_and_others_list_them() {
    for name in LIGHTS {
        place(name, &[], &DMat4::IDENTITY);
    }
    assert_eq!(
        light("envlight", &[]).unwrap_err().to_string(),
        "there is no light \"envlight\": expected one of ambientlight, distantlight, pointlight, spotlight"
    );
    let made = light("pointlight", &[ShaderParam::point("to", [0.0; 3])]).unwrap();
    assert_eq!(
        made.warnings,
        ["light \"pointlight\" has no parameter \"to\": it has intensity, lightcolor, from"]
    );
    let wrong = light("spotlight", &[ShaderParam::float("from", 1.0)]).unwrap_err().to_string();
    assert!(wrong.contains("expected point with 3 finite numbers"), "{wrong}");
}
