//! Scenes built by code, small and each about one thing.

use std::sync::Arc;

use glam::{DMat4, DVec3};
use olema::scene::{Attributes, Camera, Geometry, Light, Projection, ShadingInterpolation, Transform};
use olema::shading;
pub use olema::standard::build::{
    add, add_lights, bicubic, bilinear, camera, floats, look_at, sheet, surface,
};
pub use olema::standard::teapot::{teapot, teapot_from};
use olema::{Scene, Settings};

/// Small settings for tests.
pub fn small(width: u32, height: u32, samples: [u32; 2]) -> Settings {
    Settings { resolution: [width, height], samples, threads: 1, ..Settings::default() }
}

/// The teapot's near half is cut off by the near plane.
pub fn teapot_through_near_plane() -> Scene {
    let mut scene = teapot_from([1.0, -5.0, 3.2], [0.2, 0.0, 1.4], 60.0);
    scene.camera.clipping = [4.6, 7.0];
    scene
}

/// From inside the teapot, looking at the spout: patches pass the eye on all sides.
pub fn teapot_from_inside() -> Scene {
    let mut scene = teapot_from([-0.6, 0.1, 1.1], [1.0, 0.0, 1.3], 100.0);
    scene.camera.clipping = [1e-10, f32::INFINITY];
    scene
}

/// Ground that passes under the eye and reaches to the horizon, with a wall on it.
pub fn ground() -> Scene {
    let mut scene = Scene::new(camera([0.0, 0.0, 1.0], [0.0, 10.0, 0.5], 70.0));
    let lights = add_lights(&mut scene, [1.0, -2.0, 3.0]);
    let attributes = |color| {
        Arc::new(Attributes {
            color,
            surface: surface("matte"),
            lights: Arc::clone(&lights),
            shading_interpolation: ShadingInterpolation::Smooth,
            ..Attributes::default()
        })
    };
    let far = 900.0;
    let corners = [[-far, -far, 0.0], [far, -far, 0.0], [-far, far, 0.0], [far, far, 0.0]];
    add(&mut scene, bilinear(corners), DMat4::IDENTITY, &attributes([0.3, 0.7, 0.3]));
    let wall = [[-2.0, 6.0, 0.0], [3.0, 8.0, 0.0], [-2.0, 6.0, 2.0], [3.0, 8.0, 2.0]];
    add(&mut scene, bilinear(wall), DMat4::IDENTITY, &attributes([0.7, 0.3, 0.3]));
    scene
}

/// Nine half transparent coloured squares behind one another, some crossing, before an opaque one.
pub fn layers() -> Scene {
    let mut scene = Scene::new(camera([0.0, -5.0, 0.0], [0.0; 3], 40.0));
    for layer in 0..10 {
        let hue = |shift: usize| [0.9, 0.5, 0.2][(layer + shift) % 3];
        let opacity = if layer == 9 { 1.0 } else { 0.2 + 0.07 * layer as f32 };
        let attributes = Arc::new(Attributes {
            color: [hue(0), hue(1), hue(2)],
            opacity: [opacity, opacity * 0.9 + 0.1, opacity],
            surface: surface("constant"),
            shading_interpolation: ShadingInterpolation::Smooth,
            ..Attributes::default()
        });
        let (x, y, tilt) = (layer as f32 * 0.17 - 0.8, layer as f32 * 0.12, (layer % 4) as f32 * 0.3);
        let corners =
            [[x - 0.7, y - tilt, -0.9], [x + 0.7, y + tilt, -0.8], [x - 0.7, y, 0.8], [x + 0.7, y, 0.9]];
        add(&mut scene, bilinear(corners), DMat4::IDENTITY, &attributes);
    }
    scene
}

/// Opaque and transparent squares in one plane: only the canonical order decides.
pub fn coplanar() -> Scene {
    let mut scene = Scene::new(Camera {
        projection: Projection::Orthographic,
        ..camera([0.0, -4.0, 0.0], [0.0; 3], 40.0)
    });
    for (ix, color) in [[0.9, 0.1, 0.1], [0.1, 0.9, 0.1], [0.1, 0.1, 0.9], [0.8, 0.8, 0.1]].iter().enumerate()
    {
        let opacity = if ix == 2 { 0.5 } else { 1.0 };
        let attributes = Arc::new(Attributes {
            color: *color,
            opacity: [opacity; 3],
            surface: surface("constant"),
            ..Attributes::default()
        });
        let (x, z) = (ix as f32 * 0.3 - 0.9, ix as f32 * 0.2 - 0.7);
        let corners = [[x, 0.0, z], [x + 1.2, 0.0, z], [x, 0.0, z + 0.9], [x + 1.2, 0.0, z + 0.9]];
        add(&mut scene, bilinear(corners), DMat4::IDENTITY, &attributes);
    }
    scene
}

/// A floor and a teapot lit by one light of that name.
pub fn lit_by(light: &str) -> Scene {
    use olema::shading::ShaderParam as Param;
    let mut scene = teapot_from([2.0, -7.5, 5.0], [0.2, 0.0, 1.0], 42.0);
    let params = match light {
        "distantlight" => vec![Param::point("from", [-2.0, -3.0, 4.0]), Param::point("to", [0.0; 3])],
        "pointlight" => vec![Param::point("from", [0.5, -2.5, 3.5]), Param::float("intensity", 9.0)],
        "spotlight" => vec![
            Param::point("from", [-2.0, -5.0, 5.0]),
            Param::point("to", [0.3, 0.0, 1.0]),
            Param::float("intensity", 50.0),
            Param::float("coneangle", 0.35),
            Param::float("conedeltaangle", 0.1),
        ],
        _ => vec![Param::float("intensity", 0.5)],
    };
    let shader = shading::light(light, &params).expect("a standard light").shader;
    let only = scene.add_light(Light { shader, to_world: Transform::default() });
    let floor = [[-6.0, -6.0, 0.0], [6.0, -6.0, 0.0], [-6.0, 6.0, 0.0], [6.0, 6.0, 0.0]];
    let attributes = Arc::new(Attributes { surface: surface("matte"), ..Attributes::default() });
    add(&mut scene, bilinear(floor), DMat4::IDENTITY, &attributes);
    for primitive in &mut scene.primitives {
        primitive.attributes =
            Arc::new(Attributes { lights: Arc::from([only]), ..(*primitive.attributes).clone() });
    }
    scene
}

/// A creased, displaced cube of a few quads and n-gons beside displaced patches that share their borders.
pub fn displaced() -> Scene {
    use olema::shading::{ShaderParam as Param, displacement};
    let mut scene = teapot_from([1.5, -7.0, 3.5], [0.6, 0.0, 0.9], 46.0);
    let bumps = displacement("fractal", &[Param::float("amplitude", 0.3), Param::float("frequency", 1.5)]);
    let bumps = bumps.expect("a standard displacement").shader;
    let lights = Arc::clone(&scene.primitives[0].attributes.lights);
    for primitive in &mut scene.primitives {
        let attributes = (*primitive.attributes).clone();
        primitive.attributes = Arc::new(Attributes { displacement: Some(Arc::clone(&bumps)), ..attributes });
    }
    let cells = displacement("cells", &[Param::float("amplitude", 0.25), Param::float("frequency", 2.0)]);
    let attributes = Arc::new(Attributes {
        name: "prism".to_owned(),
        color: [0.3, 0.5, 0.8],
        surface: surface("plastic"),
        displacement: Some(cells.expect("a standard displacement").shader),
        lights,
        shading_interpolation: ShadingInterpolation::Smooth,
        ..Attributes::default()
    });
    let mesh = Geometry::Subdivision(Arc::new(crate::shapes::prism(5)));
    let place = DMat4::from_translation(DVec3::new(3.2, -1.6, 0.6)) * DMat4::from_scale(DVec3::splat(1.1));
    add(&mut scene, mesh, place, &attributes);
    scene
}

/// A subdivision mesh in a shape's own colours, seen from the side.
pub fn mesh(mesh: olema::scene::SubdivisionMesh) -> Scene {
    let mut scene = Scene::new(camera([2.2, -4.6, 2.4], [0.0; 3], 38.0));
    let lights = add_lights(&mut scene, [3.0, -4.0, 6.0]);
    let attributes = Arc::new(Attributes {
        name: "mesh".to_owned(),
        color: [0.5, 0.65, 0.4],
        surface: surface("plastic"),
        lights,
        shading_interpolation: ShadingInterpolation::Smooth,
        ..Attributes::default()
    });
    add(&mut scene, Geometry::Subdivision(Arc::new(mesh)), DMat4::IDENTITY, &attributes);
    scene
}
