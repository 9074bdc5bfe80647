//! What every displacement shader must hold for any input, and each shader's own sense.

use std::sync::Arc;

use glam::Vec3;
use proptest::prelude::*;

use super::super::octaves::CELLS_MEAN;
use super::super::{ShaderParam, TextureImage, displacement, displacement_with_images};
use super::*;
use crate::math::hash::{hash_all, unit};
use crate::scene::VarType;
use crate::shading::ParamValue;

fn checker() -> Arc<TextureImage> {
    let data: Vec<f32> = (0..64).map(|n| if (n + n / 8) % 2 == 0 { 1.0 } else { 0.0 }).collect();
    Arc::new(TextureImage::new(8, 8, &data).unwrap())
}

/// The shader of that name; those that need an image get a chess board.
fn made(name: &str, params: &[ShaderParam]) -> Arc<dyn DisplacementShader> {
    let mut params = params.to_vec();
    if matches!(name, "bumpy" | "image") {
        params.push(ShaderParam::string("texturename", "board"));
    }
    let made = displacement_with_images(name, &params, &|_| Ok(checker())).unwrap();
    assert_eq!(made.warnings, Vec::<String>::new());
    made.shader
}

#[derive(Debug, Clone, Copy)]
struct Point {
    p: Vec3,
    n: Vec3,
    st: [f32; 2],
    width: f32,
}

const POINT: Point = Point { p: Vec3::new(0.3, 1.7, -0.4), n: Vec3::Z, st: [0.3, 0.7], width: 1e-3 };

fn gather(given: &[Point]) -> DisplacementPoints {
    let mut points = DisplacementPoints::default();
    for Point { p, n, st, width } in given {
        points.p.push(*p);
        points.n.push(*n);
        points.s.push(st[0]);
        points.t.push(st[1]);
        points.width.push(*width);
        points.st_width.push(*width);
    }
    points
}

fn displace(shader: &dyn DisplacementShader, given: &[Point]) -> Vec<Vec3> {
    let mut offset = Vec3s::splat(Vec3::NAN, given.len());
    shader.displace(&gather(given), &mut offset);
    (0..given.len()).map(|ix| offset.get(ix)).collect()
}

fn one(shader: &dyn DisplacementShader, point: Point) -> Vec3 {
    displace(shader, &[point])[0]
}

fn any_coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![8 => -50.0f32..50.0, 1 => any::<f32>(), 1 => Just(f32::NAN)]
}

fn any_point() -> impl Strategy<Value = Point> {
    let vector = || [any_coordinate(), any_coordinate(), any_coordinate()];
    let normal = prop_oneof![
        (-1.0f32..1.0, 0.0f32..std::f32::consts::TAU).prop_map(|(z, a)| {
            let r = (1.0 - z * z).sqrt();
            Vec3::new(r * a.cos(), r * a.sin(), z)
        }),
        Just(Vec3::ZERO),
        vector().prop_map(Vec3::from),
    ];
    let width = prop_oneof![4 => 1e-4f32..2.0, 1 => any::<f32>(), 1 => Just(0.0), 1 => Just(f32::INFINITY)];
    (vector(), normal, [any_coordinate(), any_coordinate()], width).prop_map(|(p, n, st, width)| Point {
        p: p.into(),
        n,
        st,
        width,
    })
}

#[test]
fn no_offset_within_balls_is_longer_than_their_reach() {
    let random = |n: u32| 2.0 * unit(hash_all([n, 7])) - 1.0;
    let (mut sum, mut num) = (0.0, 0.0);
    for seed in 0..400u32 {
        let name = ["noise", "fractal", "cells", "vector"][seed as usize % 4];
        let params = [ShaderParam::float("amplitude", -0.5), ShaderParam::float("seed", (seed / 4) as f32)];
        let shader = made(name, &params);
        let random = |n: u32| random(seed * 1000 + n);
        let radius = 0.2 * random(999).abs();
        let mut balls = Balls { centers: [[0.0; LANES]; 3], radius };
        for (axis, centers) in balls.centers.iter_mut().enumerate() {
            let middle = 9.0 * random(axis as u32);
            (10..).zip(centers).for_each(|(n, center)| *center = middle + 0.2 * random(3 * n + axis as u32));
        }
        let reach = shader.reach(&balls).unwrap();
        assert!(reach <= shader.amplitude().unwrap());
        for n in 0..300 {
            let off = Vec3::new(random(100 + 3 * n), random(101 + 3 * n), random(102 + 3 * n));
            let center = Vec3::from([0, 1, 2].map(|axis| balls.centers[axis][n as usize % LANES]));
            let p = center + off.normalize() * radius;
            let moved = one(&*shader, Point { p, width: 0.0, ..POINT });
            assert!(moved.length() <= reach, "{name}: {moved} at {p}, {reach}");
        }
        if name == "noise" && radius < 0.05 {
            (sum, num) = (sum + reach, num + 1.0);
        }
    }
    assert!(sum / num < 0.4, "of an amplitude of 0.5: {}", sum / num);
}

proptest! {
    #[test]
    fn no_offset_exceeds_the_amplitude(
        given in prop::collection::vec(any_point(), 1..8),
        amplitude in prop_oneof![-3.0f32..3.0, Just(0.0), Just(1e30)],
        frequency in prop_oneof![0.0f32..20.0, Just(1e30)],
    ) {
        for name in DISPLACEMENTS {
            let params = [ShaderParam::float("amplitude", amplitude), ShaderParam::float("frequency", frequency)];
            let shader = made(name, &params);
            prop_assert_eq!(shader.amplitude(), Some(amplitude.abs()));
            for offset in displace(&*shader, &given) {
                prop_assert!(offset.is_finite(), "{}: {}", name, offset);
                prop_assert!(offset.as_dvec3().length() <= f64::from(amplitude.abs()), "{}: {}", name, offset);
            }
        }
    }

    #[test]
    fn an_offset_depends_on_its_own_point_alone(given in prop::collection::vec(any_point(), 2..9)) {
        for name in DISPLACEMENTS {
            let shader = made(name, &[]);
            let bits = |v: Vec3| v.to_array().map(f32::to_bits);
            for (point, together) in given.iter().zip(displace(&*shader, &given)) {
                prop_assert_eq!(bits(one(&*shader, *point)), bits(together), "{}", name);
            }
        }
    }

    #[test]
    fn a_small_step_moves_a_point_little(
        p in [-20.0f32..20.0, -20.0f32..20.0, -20.0f32..20.0], st in [0.0f32..1.0, 0.0f32..1.0],
        width in 1e-3f32..1.0, axis in 0usize..3,
    ) {
        let h = 1e-3;
        let here = Point { p: p.into(), n: Vec3::Y, st, width };
        let mut there = here;
        there.p[axis] += h;
        there.st[axis.min(1)] += h / 8.0;
        for name in DISPLACEMENTS {
            let shader = made(name, &[ShaderParam::float("amplitude", 1.0)]);
            let step = (one(&*shader, here) - one(&*shader, there)).length();
            // Six octaves with a gain of 1/2 at twice the frequency each add up to three times the slope of one.
            prop_assert!(step < 14.0 * h, "{}: {}", name, step);
            let mut wider = here;
            wider.width *= 1.001;
            let change = (one(&*shader, here) - one(&*shader, wider)).length();
            prop_assert!(change < 0.01, "{}: {} for a width of {}", name, change, width);
        }
    }
}

#[test]
fn heights_go_along_the_normal_and_need_one() {
    for name in DISPLACEMENTS.into_iter().filter(|n| *n != "vector") {
        let shader = made(name, &[]);
        let up = one(&*shader, POINT);
        assert!(up.z.abs() > 1e-4 && up.truncate() == glam::Vec2::ZERO, "{name}: {up}");
        let side = one(&*shader, Point { n: Vec3::NEG_X, ..POINT });
        assert_eq!(side, Vec3::new(-up.z, 0.0, 0.0), "{name}");
        assert_eq!(one(&*shader, Point { n: Vec3::ZERO, ..POINT }), Vec3::ZERO, "{name}");
    }
    let free = one(&*made("vector", &[]), Point { n: Vec3::ZERO, ..POINT });
    assert!(free.x != 0.0 && free.y != 0.0 && free.z != 0.0, "{free}");
}

#[test]
fn a_negative_amplitude_turns_the_offset_around() {
    for name in DISPLACEMENTS {
        let with = |a: f32| one(&*made(name, &[ShaderParam::float("amplitude", a)]), POINT);
        assert_eq!(with(0.5), -with(-0.5), "{name}");
    }
}

#[test]
fn what_is_too_fine_fades_to_its_mean() {
    for name in ["fractal", "noise", "vector", "waves"] {
        let shader = made(name, &[]);
        for width in [2.0, 100.0, f32::INFINITY] {
            assert_eq!(one(&*shader, Point { width, ..POINT }), Vec3::ZERO, "{name}");
        }
        // Nothing is lost where even the finest octave, 1/32 of the coarsest, is four widths long.
        let whole = one(&*shader, Point { width: 0.0, ..POINT });
        assert_eq!(one(&*shader, Point { width: 1.0 / 128.0, ..POINT }), whole, "{name}");
        assert_ne!(one(&*shader, Point { width: 0.4, ..POINT }), whole, "{name}");
    }
    let far = |name: &str| one(&*made(name, &[]), Point { width: 1e9, ..POINT }).z;
    assert!((far("image") - 0.05).abs() < 1e-6, "a chess board's mean, {}", far("image"));
    assert!((far("cells") - 0.1 * CELLS_MEAN).abs() < 1e-6);
}

#[test]
fn the_mean_of_cells_is_the_one_they_fade_to() {
    let shader = made("cells", &[ShaderParam::float("amplitude", 1.0)]);
    let place = |n: u32| Vec3::from([0, 1, 2].map(|a| 100.0 * unit(hash_all([n, a]))));
    let given: Vec<Point> = (0..100_000).map(|n| Point { p: place(n), ..POINT }).collect();
    let mean = displace(&*shader, &given).iter().map(|o| f64::from(o.z)).sum::<f64>() / 1e5;
    assert!((mean - f64::from(CELLS_MEAN)).abs() < 0.01, "{mean}");
}

#[test]
fn instructions_do_not_matter() {
    let place = |n: u32| Vec3::from([0, 1, 2].map(|a| 9.0 * unit(hash_all([n, a])) - 5.0));
    let given: Vec<Point> = (0..99)
        .map(|n| Point { p: place(n), n: place(n + 99).normalize(), width: 0.004 * n as f32, ..POINT })
        .collect();
    let all = |level: SimdLevel| {
        let mut params = Params::new("displacement", "any", &[]);
        let mut common = || Common { level, ..common("any", &mut params, 0.1, 0.0).unwrap() };
        let (a, b, c, d) = (common(), common(), common(), common());
        let mut octaves = || octaves(&mut params, 5.0).unwrap();
        let shaders: [Box<dyn DisplacementShader>; 4] = [
            Box::new(AlongNormal { common: a, height: Fractal(octaves()) }),
            Box::new(AlongNormal { common: b, height: Cells(octaves()) }),
            Box::new(NoiseVector { common: c, octaves: octaves() }),
            Box::new(AlongNormal {
                common: d,
                height: waves(&mut Params::new("displacement", "any", &[]), octaves()).unwrap(),
            }),
        ];
        shaders.map(|shader| {
            displace(&*shader, &given).into_iter().map(|v| v.to_array().map(f32::to_bits)).collect()
        })
    };
    let expected: [Vec<_>; 4] = all(SimdLevel::baseline());
    SimdLevel::all().into_iter().for_each(|level| assert_eq!(all(level), expected, "{level:?}"));
}

#[test]
fn parameters_are_heeded() {
    let vector = |name: &str, v: [f32; 3]| ShaderParam { ty: VarType::Vector, ..ShaderParam::point(name, v) };
    for name in ["cells", "fractal", "noise", "vector", "waves"] {
        let plain = one(&*made(name, &[]), POINT);
        for param in [
            ShaderParam::float("frequency", 2.0),
            ShaderParam::float("octaves", 3.0),
            ShaderParam::float("seed", 1.0),
            vector("offset", [0.1, 0.0, 0.0]),
        ] {
            assert_ne!(one(&*made(name, std::slice::from_ref(&param)), POINT), plain, "{name} {param:?}");
        }
        let moved = Point { p: POINT.p - Vec3::X, ..POINT };
        let back = one(&*made(name, &[vector("offset", [1.0, 0.0, 0.0])]), moved);
        assert!((back - plain).length() < 1e-5, "{name}: {back} and {plain}");
    }
    let along = made("waves", &[vector("direction", [0.0, 2.0, 0.0])]);
    assert_ne!(one(&*along, POINT), one(&*made("waves", &[]), POINT));
    let sunk = one(&*made("image", &[ShaderParam::float("zero", 1.0)]), POINT);
    assert!((sunk.z - (one(&*made("image", &[]), POINT).z - 0.1)).abs() < 1e-6);
}

#[test]
fn bump_mapping_is_asked_for_or_the_standards_bumpy() {
    for name in DISPLACEMENTS {
        assert_eq!(made(name, &[]).is_bump(), name == "bumpy");
        assert_eq!(made(name, &[]).name(), name);
        assert!(made(name, &[ShaderParam::float("bump", 1.0)]).is_bump());
    }
    assert_eq!(made("bumpy", &[]).amplitude(), Some(1.0));
}

#[test]
fn an_image_repeats_as_often_as_it_is_scaled() {
    let scaled = made("image", &[ShaderParam::float("sscale", 3.0), ShaderParam::float("frequency", 2.0)]);
    let at = |shader: &dyn DisplacementShader, st: [f32; 2]| one(shader, Point { st, width: 0.0, ..POINT }).z;
    assert!((at(&*scaled, [0.05, 0.1]) - at(&*made("image", &[]), [0.3, 0.2])).abs() < 1e-6);
    assert!((at(&*scaled, [0.05 + 1.0 / 6.0, 0.6]) - at(&*scaled, [0.05, 0.1])).abs() < 1e-5);
}

#[test]
fn wrong_names_and_values_are_told() {
    let told = |name: &str, params: &[ShaderParam]| displacement(name, params).unwrap_err().to_string();
    assert!(told("dents", &[]).contains("there is no displacement \"dents\": expected one of bumpy, cells"));
    assert!(told("noise", &[ShaderParam::string("amplitude", "big")]).contains("expected float"));
    let two = ShaderParam { values: ParamValue::Floats(vec![1.0, 2.0]), ..ShaderParam::float("seed", 0.0) };
    assert!(told("noise", &[two]).contains("expected float with 1 finite number"));
    assert!(told("noise", &[ShaderParam::float("amplitude", f32::NAN)]).contains("is NaN"));
    assert!(told("image", &[]).contains("expected the name of an image"));
    assert!(told("image", &[ShaderParam::string("texturename", "a.png")]).contains("\"a.png\""));
    let warned =
        displacement("noise", &[ShaderParam::float("octaves", 99.0), ShaderParam::float("Km", 1.0)]).unwrap();
    assert_eq!(warned.warnings.len(), 2, "{:?}", warned.warnings);
    assert!(warned.warnings[0].contains("octaves is 99: expected 1 to 16, taken as 16"));
    assert!(warned.warnings[1].contains("has no parameter \"Km\": it has"));
}

#[test]
fn known_values_stay() {
    // Changed displacement changes pictures.
    let bits = |name: &str| one(&*made(name, &[]), POINT).z.to_bits();
    assert_eq!(
        ["cells", "fractal", "image", "noise", "vector", "waves"].map(bits),
        [998_387_904, 3_158_799_827, 1_025_350_964, 3_162_924_818, 989_676_711, 3_172_413_843]
    );
}
