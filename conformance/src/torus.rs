//! A bumpy torus of pixel-sized quads that turns and drifts, out of focus: the scene on which renderers are compared.
//!
//! In: how many quads around and across, and a colour for each. Out: a bilinear sheet with two motion keys, seen as
//! from (0, 0, 4) towards -z with a lens of radius 0.05 that is in focus at 4.

use std::sync::Arc;

use glam::{DMat4, DVec3};
use olema::Scene;
use olema::scene::{
    Attributes, Camera, Class, Geometry, Keyed, Lens, PatchKind, PatchMesh, Points, PrimVar, Projection,
    VarType, VarValues,
};
use olema::standard::torus::point;

use crate::scenes;

/// A hash of a quad's number.
pub fn hash(quad: u32) -> u32 {
    let state = quad.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// The scene of `nu` x `nv` quads, quad (i, j) of the grey `grey(j * nu + i)`.
pub fn torus(nu: usize, nv: usize, blurred: bool, grey: impl Fn(u32) -> f32) -> Scene {
    let turn = |ix: usize, n: usize| std::f64::consts::TAU * ix as f64 / n as f64;
    let at = |t: f64| {
        let all = (0..nv).flat_map(|j| (0..nu).map(move |i| point(turn(i, nu), turn(j, nv), t)));
        Points::P(all.collect())
    };
    let points = match blurred {
        true => Keyed { times: vec![0.0, 1.0], values: vec![at(0.0), at(1.0)] },
        false => Keyed::still(at(0.0)),
    };
    let colors = (0..(nu * nv) as u32).flat_map(|quad| [grey(quad); 3]).collect();
    let color = PrimVar {
        name: "Cs".into(),
        class: Class::Uniform,
        ty: VarType::Color,
        array_len: 1,
        values: VarValues::Floats(colors),
    };
    let mesh = PatchMesh {
        kind: Arc::new(PatchKind::Bilinear),
        nu,
        nv,
        wrap_u: true,
        wrap_v: true,
        points,
        vars: vec![color],
    };
    let to_camera =
        DMat4::from_translation(DVec3::new(0.0, 0.0, 4.0)) * DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0));
    let mut scene = Scene::new(Camera {
        world_to_camera: olema::scene::Transform::still(to_camera),
        projection: Projection::Perspective { fov: 90.0 },
        screen_window: Some([-0.4, 0.4, -0.3, 0.3]),
        clipping: [0.1, 100.0],
        shutter: [0.0, if blurred { 1.0 } else { 0.0 }],
        lens: blurred.then(|| Lens::new(1.0, 0.1, 4.0)),
        ..Camera::default()
    });
    let attributes = Arc::new(Attributes { surface: scenes::surface("constant"), ..Attributes::default() });
    scenes::add(&mut scene, Geometry::Patches(Arc::new(mesh)), DMat4::IDENTITY, &attributes);
    scene
}
