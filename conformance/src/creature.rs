//! A model of about ten thousand bicubic patches: what displacement and reading are measured on.

use std::sync::Arc;

use glam::DMat4;
use olema::Scene;
use olema::scene::{Attributes, Geometry, Keyed, PatchKind, PatchMesh, Points, ShadingInterpolation};

use crate::closed::B_SPLINE;
use crate::scenes::{add, add_lights, camera, surface};

/// A knotted tube of `nu` x `nv` bicubic patches, wrapped both ways, that fills most of the picture.
pub fn tube(nu: usize, nv: usize) -> Scene {
    let mut scene = Scene::new(camera([0.0, -8.0, 3.0], [0.0; 3], 40.0));
    let lights = add_lights(&mut scene, [3.0, -4.0, 6.0]);
    let turn = |steps: f64| (steps * std::f64::consts::TAU).sin_cos();
    let mut points = Vec::with_capacity(nu * nv);
    for j in 0..nv {
        let (sv, cv) = turn(j as f64 / nv as f64);
        for i in 0..nu {
            let along = i as f64 / nu as f64;
            let ((s2, c2), (s3, c3)) = (turn(2.0 * along), turn(3.0 * along));
            let swell = 0.45 + 0.08 * turn(11.0 * along).0;
            let r = 1.7 + 0.6 * c3 + swell * cv;
            points.push([r * c2, r * s2, 0.6 * s3 + swell * sv].map(|c| c as f32));
        }
    }
    let mesh = PatchMesh {
        kind: Arc::new(PatchKind::Bicubic { u: B_SPLINE, v: B_SPLINE }),
        nu,
        nv,
        wrap_u: true,
        wrap_v: true,
        points: Keyed::still(Points::P(points)),
        vars: Vec::new(),
    };
    let attributes = Arc::new(Attributes {
        name: "tube".to_owned(),
        color: [0.7, 0.6, 0.5],
        surface: surface("plastic"),
        lights,
        shading_interpolation: ShadingInterpolation::Smooth,
        ..Attributes::default()
    });
    add(&mut scene, Geometry::Patches(Arc::new(mesh)), DMat4::IDENTITY, &attributes);
    scene
}
