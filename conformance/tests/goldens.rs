//! Pictures of one feature each, compared with those that were looked at once.

use std::sync::Arc;

use conformance::goldens::{check, draw};
use conformance::scenes::{self, small};
use olema::image::{Filter, FilterKind};
use olema::scene::{Attributes, Projection, ShadingInterpolation, Sides};
use olema::shading::TextureImage;
use olema::{Scene, Settings};

fn golden(name: &str, scene: &Scene, settings: &Settings) {
    let image = draw(scene, settings).expect("a picture");
    check(name, &image).unwrap_or_else(|problem| panic!("{problem}"));
}

fn edit(scene: &mut Scene, mut change: impl FnMut(usize, &mut Attributes)) {
    for (ix, primitive) in scene.primitives.iter_mut().enumerate() {
        let mut attributes = (*primitive.attributes).clone();
        change(ix, &mut attributes);
        primitive.attributes = Arc::new(attributes);
    }
}

#[test]
fn teapot_from_several_sides() {
    let settings = small(96, 72, [4, 4]);
    golden("teapot", &scenes::teapot(), &settings);
    golden("teapot_top", &scenes::teapot_from([0.5, -0.5, 9.0], [0.3, 0.0, 1.0], 38.0), &settings);
    golden("teapot_below", &scenes::teapot_from([-3.0, 4.0, -6.0], [0.3, 0.0, 1.0], 38.0), &settings);
    golden("teapot_near_plane", &scenes::teapot_through_near_plane(), &settings);
    golden("teapot_inside", &scenes::teapot_from_inside(), &settings);
    golden("ground", &scenes::ground(), &settings);
    let mut orthographic = scenes::teapot();
    orthographic.camera.projection = Projection::Orthographic;
    orthographic.camera.screen_window = Some([-3.6, 3.6, -2.7, 2.7]);
    golden("teapot_orthographic", &orthographic, &settings);
}

#[test]
fn numbers_of_samples() {
    for [nx, ny] in [[1, 1], [2, 2], [7, 1], [8, 8]] {
        golden(&format!("teapot_{}_samples", nx * ny), &scenes::teapot(), &small(64, 48, [nx, ny]));
    }
    let centred = Settings { jitter: false, ..small(64, 48, [2, 2]) };
    golden("teapot_no_jitter", &scenes::teapot(), &centred);
}

#[test]
fn filters() {
    let kinds = [
        ("box", FilterKind::Box, [1.0, 1.0]),
        ("triangle", FilterKind::Triangle, [2.0, 2.0]),
        ("catmull_rom", FilterKind::CatmullRom, [4.0, 4.0]),
        ("gaussian", FilterKind::Gaussian, [2.0, 2.0]),
        ("sinc", FilterKind::Sinc, [4.0, 4.0]),
        ("mitchell", FilterKind::Mitchell, [4.0, 4.0]),
        ("blackman_harris", FilterKind::BlackmanHarris, [3.0, 3.0]),
        ("wide_box", FilterKind::Box, [9.0, 3.0]),
    ];
    for (name, kind, width) in kinds {
        let settings = Settings { filter: Filter { kind, width }, ..small(48, 36, [4, 4]) };
        golden(&format!("filter_{name}"), &scenes::teapot(), &settings);
    }
}

#[test]
fn transparency() {
    let settings = small(96, 72, [4, 4]);
    golden("layers", &scenes::layers(), &settings);
    golden("coplanar", &scenes::coplanar(), &settings);
    let mut glass = scenes::teapot();
    edit(&mut glass, |_, attributes| attributes.opacity = [0.3, 0.4, 0.5]);
    golden("teapot_transparent", &glass, &settings);
    let mut matte = scenes::layers();
    edit(&mut matte, |ix, attributes| attributes.matte = ix == 4);
    golden("layers_matte", &matte, &settings);
}

#[test]
fn shaders() {
    for name in ["constant", "matte", "metal", "shinymetal", "plastic", "paintedplastic", "defaultsurface"] {
        let mut scene = scenes::teapot();
        edit(&mut scene, |_, attributes| attributes.surface = scenes::surface(name));
        golden(&format!("shader_{name}"), &scene, &small(64, 48, [4, 4]));
    }
    let mut flat = scenes::teapot();
    edit(&mut flat, |_, attributes| {
        attributes.shading_interpolation = ShadingInterpolation::Constant;
        attributes.shading_rate = 64.0;
    });
    golden("shading_flat", &flat, &small(64, 48, [4, 4]));
    edit(&mut flat, |_, attributes| attributes.shading_interpolation = ShadingInterpolation::Smooth);
    golden("shading_smooth", &flat, &small(64, 48, [4, 4]));
}

#[test]
fn lights() {
    for name in ["ambientlight", "distantlight", "pointlight", "spotlight"] {
        golden(&format!("light_{name}"), &scenes::lit_by(name), &small(64, 48, [4, 4]));
    }
}

#[test]
fn sides_and_orientation() {
    let settings = small(64, 48, [4, 4]);
    let mut one_sided = scenes::teapot();
    edit(&mut one_sided, |_, attributes| attributes.sides = Sides::One);
    golden("sides_one", &one_sided, &settings);
    edit(&mut one_sided, |_, attributes| attributes.reverse_orientation = true);
    golden("sides_one_reversed", &one_sided, &settings);
    // A mirrored object keeps its outside.
    let mut mirrored = scenes::teapot();
    edit(&mut mirrored, |_, attributes| attributes.sides = Sides::One);
    for primitive in &mut mirrored.primitives {
        primitive.to_world =
            olema::scene::Transform::still(glam::DMat4::from_scale(glam::DVec3::new(-1.0, 1.0, 1.0)));
    }
    golden("sides_one_mirrored", &mirrored, &settings);
}

#[test]
fn subdivision_surfaces() {
    use conformance::shapes;
    use olema::scene::{BoundaryRule, Scheme};
    let settings = small(64, 48, [4, 4]);
    let meshes = [
        ("cube", shapes::cube()),
        ("pyramid_semi_sharp", shapes::pyramid(1.5)),
        ("pyramid_sharp", shapes::pyramid(10.0)),
        ("prism", shapes::prism(7)),
        ("loop_icosahedron", shapes::icosahedron(Scheme::Loop)),
        ("bilinear_tetrahedron", shapes::tetrahedron(Scheme::Bilinear)),
        ("poles", shapes::poles(50, Scheme::CatmullClark)),
        ("open_sheet", shapes::open_sheet(4, 4, BoundaryRule::EdgeAndCorner, Scheme::CatmullClark)),
    ];
    for (name, mesh) in meshes {
        golden(&format!("subdivision_{name}"), &scenes::mesh(mesh), &settings);
    }
    let mut hole = shapes::torus(8, 6);
    hole.holes = vec![3, 4, 20];
    golden("subdivision_holes", &scenes::mesh(hole), &settings);
}

#[test]
fn displacement() {
    use olema::shading::{DISPLACEMENTS, ShaderParam as Param, displacement_with_images};
    golden("displaced", &scenes::displaced(), &small(128, 96, [4, 4]));
    for name in DISPLACEMENTS.iter().filter(|name| **name != "bumpy") {
        for bump in [0.0, 1.0] {
            let mut scene = scenes::mesh(conformance::shapes::cube());
            let mut params = vec![Param::float("amplitude", 0.2), Param::float("bump", bump)];
            if *name == "image" {
                params.push(Param::string("texturename", "disc and stripes"));
            }
            let made = displacement_with_images(name, &params, &|_| Ok(disc_and_stripes()));
            let shader = made.expect("a standard displacement").shader;
            edit(&mut scene, |_, attributes| attributes.displacement = Some(shader.clone()));
            let suffix = if bump > 0.0 { "_bump" } else { "" };
            golden(&format!("displacement_{name}{suffix}"), &scene, &small(64, 48, [4, 4]));
        }
    }
}

/// An image that tells s from t and 0 from 1: a disc in one quarter, stripes in another. 256 x 128 texels are several for
/// each micropolygon of a small picture, so that it is filtered.
fn disc_and_stripes() -> Arc<TextureImage> {
    let height = |n: u16| {
        let (s, t) = (f32::from(n % 256) / 256.0, f32::from(n / 256) / 128.0);
        let is_disc = (s - 0.25).powi(2) + (t - 0.25).powi(2) < 0.04;
        let is_stripe = s > 0.5 && t > 0.5 && (s * 12.0) as u32 % 2 == 1;
        f32::from(u8::from(is_disc || is_stripe))
    };
    let texels: Vec<f32> = (0..256 * 128).map(height).collect();
    Arc::new(TextureImage::new(256, 128, &texels).expect("one value a texel"))
}

#[test]
fn background_and_exposure() {
    let base = small(64, 48, [4, 4]);
    let scene = scenes::teapot();
    golden("background", &scene, &Settings { background: Some([0.1, 0.2, 0.4]), ..base.clone() });
    golden("exposure", &scene, &Settings { exposure: [2.0, 2.2], ..base });
}

#[test]
fn a_changed_picture_does_not_pass() {
    if std::env::var_os("OLEMA_BLESS").is_some() {
        return;
    }
    let mut image = draw(&scenes::teapot(), &small(96, 72, [4, 4])).expect("a picture");
    assert!(check("teapot", &image).is_ok());
    image.channels[1].values[96 * 36 + 40] += 2.0 / 255.0;
    assert!(check("teapot", &image).is_err(), "the comparison cannot fail");
}
