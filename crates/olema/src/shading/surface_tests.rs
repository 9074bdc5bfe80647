//! Surfaces against values worked out by hand, and what must hold for any input.

use glam::DMat4;
use proptest::prelude::*;

use super::super::{ShaderParam, default_surface, light, surface};
use super::*;
use crate::math::Vec3s;
use crate::scene::VarType;
use crate::shading::ParamValue;

/// Vertices with one normal and one direction from the eye each, at the end of that direction.
fn points(n: &[[f32; 3]], i: &[[f32; 3]]) -> ShadingPoints {
    let gather = |vectors: &[[f32; 3]]| {
        let mut all = Vec3s::default();
        vectors.iter().for_each(|v| all.push((*v).into()));
        all
    };
    ShadingPoints {
        p: gather(i),
        n: gather(n),
        ng: gather(n),
        i: gather(i),
        cs: Vec3s::splat(Vec3::new(1.0, 0.5, 0.25), n.len()),
        os: Vec3s::splat(Vec3::new(0.5, 1.0, 1.0), n.len()),
        ..ShadingPoints::default()
    }
}

fn lights(wanted: &[(&str, &[ShaderParam])]) -> Vec<Arc<dyn PlacedLight>> {
    wanted.iter().map(|(name, p)| light(name, p).unwrap().shader.place(&DMat4::IDENTITY)).collect()
}

/// Ci and Oi of every vertex.
fn shade(
    shader: &dyn SurfaceShader,
    points: &ShadingPoints,
    lights: &[Arc<dyn PlacedLight>],
) -> Vec<(Vec3, Vec3)> {
    let len = points.p.len();
    let all: Vec<u32> = (0..len as u32).collect();
    let mut out = ShadedPoints { ci: Vec3s::splat(Vec3::NAN, len), oi: Vec3s::splat(Vec3::NAN, len) };
    shader.shade(points, &all, lights, &mut out);
    (0..len).map(|ix| (out.ci.get(ix), out.oi.get(ix))).collect()
}

fn made(name: &str, params: &[ShaderParam]) -> Arc<dyn SurfaceShader> {
    let made = surface(name, params).unwrap();
    assert_eq!(made.warnings, Vec::<String>::new());
    made.shader
}

#[track_caller]
fn assert_near(found: Vec3, wanted: [f32; 3]) {
    let wanted = Vec3::from(wanted);
    assert!((found - wanted).abs().max_element() < 2e-6, "{found} is not {wanted}");
}

/// One vertex straight ahead, its normal 60 degrees off the eye, lit by ambient light of 0.1 and by a
/// distant light from the eye's direction with intensity 2: N.L = 1/2, H = L = V, so N.H = 1/2.
fn tilted() -> (ShadingPoints, Vec<Arc<dyn PlacedLight>>) {
    let n = [0.75f32.sqrt(), 0.0, -0.5];
    let ambient = [ShaderParam::float("intensity", 0.1)];
    let distant = [ShaderParam::float("intensity", 2.0)];
    (points(&[n], &[[0.0, 0.0, 4.0]]), lights(&[("ambientlight", &ambient), ("distantlight", &distant)]))
}

#[test]
fn constant_is_the_colour_times_opacity() {
    let (p, l) = tilted();
    let shaded = shade(&*made("constant", &[]), &p, &l)[0];
    assert_eq!(shaded, (Vec3::new(0.5, 0.5, 0.25), Vec3::new(0.5, 1.0, 1.0)));
}

#[test]
fn matte_is_ambient_and_cosine() {
    let (p, l) = tilted();
    // 0.1 + 2 * 1/2 = 1.1.
    assert_near(shade(&*made("matte", &[]), &p, &l)[0].0, [0.55, 0.55, 0.275]);
    // 2 * 0.1 + 0.5 * 1 = 0.7.
    let shader = made("matte", &[ShaderParam::float("Ka", 2.0), ShaderParam::float("Kd", 0.5)]);
    assert_near(shade(&*shader, &p, &l)[0].0, [0.35, 0.35, 0.175]);
}

#[test]
fn metal_is_ambient_and_highlight() {
    let (p, l) = tilted();
    // 0.1 + 2 * (1/2)^10.
    let wanted = 0.1 + 2.0 / 1024.0;
    for name in ["metal", "shinymetal"] {
        assert_near(shade(&*made(name, &[]), &p, &l)[0].0, [0.5 * wanted, 0.5 * wanted, 0.25 * wanted]);
    }
    // 0.1 + 3 * 2 * (1/2)^2.
    let shader = made("metal", &[ShaderParam::float("Ks", 3.0), ShaderParam::float("roughness", 0.5)]);
    assert_near(shade(&*shader, &p, &l)[0].0, [0.8, 0.8, 0.4]);
}

#[test]
fn plastic_adds_a_highlight_of_its_own_colour() {
    let (p, l) = tilted();
    let given = [
        ShaderParam::float("roughness", 0.25),
        ShaderParam::color("specularcolor", [0.0, 1.0, 2.0]),
        ShaderParam::float("Ka", 3.0),
    ];
    // Cs (3 * 0.1 + 0.5 * 1) + specularcolor * 0.5 * 2 * (1/2)^4, all times Os.
    let wanted = [0.5 * 0.8, 0.5 * 0.8 + 0.0625, 0.25 * 0.8 + 0.125];
    for name in ["plastic", "paintedplastic"] {
        assert_near(shade(&*made(name, &given), &p, &l)[0].0, wanted);
    }
    // Without a highlight it is matte with Kd 0.5.
    let dull = made("plastic", &[ShaderParam::float("Ks", 0.0)]);
    assert_near(shade(&*dull, &p, &l)[0].0, [0.5 * 0.6, 0.5 * 0.6, 0.25 * 0.6]);
}

#[test]
fn default_surface_is_lit_from_the_eye() {
    let (p, _) = tilted();
    // 0.2 + 0.8 * (1/2)^2 = 0.4.
    assert_near(shade(&*default_surface(), &p, &[])[0].0, [0.2, 0.2, 0.1]);
    assert_eq!(default_surface().name(), "defaultsurface");
}

#[test]
fn normals_turn_to_the_eye() {
    let n = [0.6, 0.0, -0.8];
    let p = points(&[n, n.map(|x| -x)], &[[0.0, 0.0, 1.0]; 2]);
    let l = lights(&[("distantlight", &[])]);
    for name in ["matte", "plastic", "metal", "defaultsurface"] {
        let shaded = shade(&*made(name, &[]), &p, &l);
        assert_eq!(shaded[0], shaded[1], "{name}");
    }
    // The geometric normal decides where the two disagree: this one is seen from behind, so its shading
    // normal is turned away from the light behind the eye.
    let mut p = points(&[n], &[[0.0, 0.0, 1.0]]);
    p.ng.set(0, Vec3::Z);
    assert_eq!(shade(&*made("matte", &[]), &p, &l)[0].0, Vec3::ZERO);
}

#[test]
fn light_behind_the_surface_does_not_count() {
    let p = points(&[[0.0, 0.0, -1.0]], &[[0.0, 0.0, 1.0]]);
    let from_behind = [ShaderParam::point("from", [0.0, 0.0, 9.0]), ShaderParam::point("to", [0.0; 3])];
    let l = lights(&[("distantlight", &from_behind)]);
    assert_eq!(shade(&*made("plastic", &[]), &p, &l)[0].0, Vec3::ZERO);
}

#[test]
fn a_zero_normal_gets_ambient_light_only() {
    let p = points(&[[0.0; 3], [f32::NAN, 0.0, 1.0]], &[[0.0, 0.0, 1.0]; 2]);
    let l = lights(&[("ambientlight", &[]), ("distantlight", &[]), ("pointlight", &[])]);
    for name in ["matte", "metal", "plastic"] {
        for (ci, _) in shade(&*made(name, &[]), &p, &l) {
            assert_near(ci, [0.5, 0.5, 0.25]);
        }
    }
    assert_near(shade(&*default_surface(), &p, &[])[0].0, [0.1, 0.1, 0.05]);
}

#[test]
fn roughness_zero_is_one_point_and_never_blows_up() {
    let p = points(&[[0.0, 0.0, -1.0], [0.6, 0.0, -0.8]], &[[0.0, 0.0, 1.0]; 2]);
    let l = lights(&[("distantlight", &[])]);
    let shaded = shade(&*made("metal", &[ShaderParam::float("roughness", 0.0)]), &p, &l);
    assert_eq!(shaded[0].0, Vec3::new(0.5, 0.5, 0.25));
    assert_eq!(shaded[1].0, Vec3::ZERO);
    let made = surface("metal", &[ShaderParam::float("roughness", -1.0)]).unwrap();
    assert_eq!(made.warnings, ["surface \"metal\": roughness is -1: expected 0 or more, taken as 0"]);
}

#[test]
fn traits_say_what_is_read() {
    for name in SURFACES {
        let shader = made(name, &[]);
        assert_eq!(shader.name(), name);
        let traits = shader.traits();
        assert_eq!((traits.opacity, traits.pure, traits.needs_ring), (OpacityUse::Keeps, true, false));
        assert_eq!(traits.inputs.n, name != "constant");
        assert_eq!(traits.inputs.lights, !["constant", "default", "defaultsurface"].contains(&name));
        // Arrays that the traits leave out may be empty.
        let mut p = points(&[[0.0, 0.0, -1.0]], &[[0.0, 0.0, 1.0]]);
        if !traits.inputs.n {
            (p.n, p.ng) = Default::default();
        }
        assert_eq!(shade(&*shader, &p, &[]).len(), 1);
    }
}

#[test]
fn only_the_listed_vertices_are_written() {
    let p = points(&[[0.0, 0.0, -1.0]; 4], &[[0.0, 0.0, 1.0]; 4]);
    let mut out = ShadedPoints { ci: Vec3s::splat(Vec3::NAN, 4), oi: Vec3s::splat(Vec3::NAN, 4) };
    made("matte", &[]).shade(&p, &[2], &[], &mut out);
    for ix in 0..4 {
        assert_eq!(out.ci.get(ix).is_nan(), ix != 2);
        assert_eq!(out.oi.get(ix).is_nan(), ix != 2);
    }
}

#[test]
fn wrong_parameters_are_told() {
    let said = |name: &str, param: ShaderParam| surface(name, &[param]).unwrap_err().to_string();
    assert_eq!(
        said("plastic", ShaderParam::color("Ks", [1.0; 3])),
        "surface \"plastic\": parameter \"Ks\" is color with 3 numbers: expected float with 1 finite number"
    );
    let two = ShaderParam {
        name: "specularcolor".to_owned(),
        ty: VarType::Color,
        values: ParamValue::Floats(vec![1.0, 2.0]),
    };
    assert_eq!(
        said("plastic", two),
        "surface \"plastic\": parameter \"specularcolor\" is color with 2 numbers: \
         expected color with 3 finite numbers"
    );
    assert!(
        said("matte", ShaderParam::string("Ka", "x")).contains("is string with 1 string: expected float")
    );
    assert!(said("matte", ShaderParam::float("Ka", f32::NAN)).contains("\"Ka\" is NaN: expected float"));
    assert!(said("shinymetal", ShaderParam::float("texturename", 1.0)).contains("expected string"));
    let unknown = surface("lumpy", &[]).unwrap_err().to_string();
    assert!(unknown.starts_with("there is no surface \"lumpy\": expected one of constant, default,"));
    let made = surface("matte", &[ShaderParam::float("Km", 1.0)]).unwrap();
    assert_eq!(made.warnings, ["surface \"matte\" has no parameter \"Km\": it has Ka, Kd"]);
}

#[test]
fn textures_that_are_not_drawn_warn() {
    for name in ["shinymetal", "paintedplastic"] {
        let made = surface(name, &[ShaderParam::string("texturename", "sky.tex")]).unwrap();
        assert_eq!(made.warnings.len(), 1, "{:?}", made.warnings);
        assert!(made.warnings[0].contains("not drawn yet"));
        assert!(surface(name, &[ShaderParam::string("texturename", "")]).unwrap().warnings.is_empty());
    }
}

fn any_vector() -> impl Strategy<Value = [f32; 3]> {
    prop_oneof![
        4 => prop::array::uniform3(-2.0f32..2.0),
        1 => prop::array::uniform3(prop::num::f32::ANY),
        1 => Just([0.0f32; 3]),
    ]
}

proptest! {
    #[test]
    fn any_geometry_gives_numbers(
        n in any_vector(), i in any_vector(), from in prop::array::uniform3(-1e30f32..1e30), near in any::<bool>(),
    ) {
        let from = ShaderParam::point("from", if near { i.map(|x| if x.is_finite() { x } else { 0.0 }) } else { from });
        let bright = ShaderParam::float("intensity", 1e30);
        let l = lights(&[
            ("ambientlight", &[]),
            ("distantlight", std::slice::from_ref(&from)),
            ("pointlight", &[from.clone(), bright.clone()]),
            ("spotlight", &[from.clone(), bright, ShaderParam::float("beamdistribution", -3.5)]),
        ]);
        let mut p = points(&[n], &[i]);
        p.cs = Vec3s::splat(Vec3::new(0.0, 1.0, 1e-3), 1);
        for name in SURFACES {
            let (ci, oi) = shade(&*made(name, &[]), &p, &l)[0];
            prop_assert!(ci.is_finite() && oi.is_finite(), "{name}: {ci} {oi}");
            prop_assert!(ci.min_element() >= 0.0, "{name}: {ci}");
        }
    }

    #[test]
    fn a_surface_gives_no_more_than_it_gets(n in any_vector(), i in any_vector(), to in any_vector()) {
        prop_assume!(to.iter().all(|x| x.is_finite()));
        let l = lights(&[("distantlight", &[ShaderParam::point("to", to)])]);
        let p = points(&[n], &[i]);
        for name in ["matte", "metal", "plastic", "defaultsurface"] {
            let (ci, oi) = shade(&*made(name, &[]), &p, &l)[0];
            // One unit of light, Kd + Ks = 1 (defaultsurface: Ka + Kd = 1).
            prop_assert!((oi - ci).min_element() >= -1e-5, "{name}: {ci} of {oi}");
        }
    }

    #[test]
    fn a_vertex_does_not_see_its_neighbours(n in prop::collection::vec(any_vector(), 2..20)) {
        let i: Vec<_> = n.iter().map(|v| [v[1], v[2], 1.0]).collect();
        let l = lights(&[("ambientlight", &[]), ("distantlight", &[]), ("spotlight", &[])]);
        let together = points(&n, &i);
        for name in SURFACES {
            let shader = made(name, &[]);
            let all = shade(&*shader, &together, &l);
            for (ix, shaded) in all.iter().enumerate() {
                let alone = shade(&*shader, &points(&n[ix..=ix], &i[ix..=ix]), &l)[0];
                prop_assert_eq!(shaded.0.to_array().map(f32::to_bits), alone.0.to_array().map(f32::to_bits));
            }
        }
    }
}
