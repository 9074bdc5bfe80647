//! What scenes are built with in few words: a camera, a sheet, two lights.
//!
//! In: numbers and names. Out: parts of a [`Scene`].

use std::sync::Arc;

use glam::{DMat4, DVec3};

use crate::sampling::hash::Stream;
use crate::scene::{
    Attributes, Camera, Geometry, Keyed, Light, Origin, PatchBasis, PatchKind, PatchMesh, Points, Primitive,
    Projection, Scene, Transform, VarType,
};
use crate::shading::{self, ParamValue, ShaderParam};

/// Numbers from a seed.
pub struct Random(Stream);

impl Random {
    /// Starts at `seed`.
    pub fn new(seed: u32) -> Self {
        Random(Stream::new(seed))
    }

    /// In [from, to).
    pub fn range(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.0.next_unit()
    }

    /// One of n.
    pub fn below(&mut self, n: u32) -> u32 {
        self.0.below(n)
    }

    /// A small random offset in each coordinate.
    pub fn jitter(&mut self, size: f64) -> [f64; 3] {
        std::array::from_fn(|_| self.range(-size, size))
    }
}

/// World to camera: at `eye`, looking at `target`, z up.
pub fn look_at(eye: [f64; 3], target: [f64; 3]) -> DMat4 {
    let (eye, target) = (DVec3::from_array(eye), DVec3::from_array(target));
    let forward = (target - eye).normalize();
    let right = forward.cross(DVec3::Z).normalize();
    let up = right.cross(forward);
    let rows = glam::DMat3::from_cols(right, up, forward).transpose();
    DMat4::from_mat3(rows) * DMat4::from_translation(-eye)
}

/// A perspective camera.
pub fn camera(eye: [f64; 3], target: [f64; 3], fov: f32) -> Camera {
    Camera {
        world_to_camera: Transform::still(look_at(eye, target)),
        projection: Projection::Perspective { fov },
        clipping: [0.01, 1000.0],
        ..Camera::default()
    }
}

/// A bicubic Bezier patch.
pub fn bicubic(points: [[f32; 3]; 16]) -> Geometry {
    sheet(PatchKind::Bicubic { u: PatchBasis::BEZIER, v: PatchBasis::BEZIER }, 4, 4, points.to_vec())
}

/// A bilinear patch with corners at (u, v) = (0,0), (1,0), (0,1), (1,1).
pub fn bilinear(corners: [[f32; 3]; 4]) -> Geometry {
    sheet(PatchKind::Bilinear, 2, 2, corners.to_vec())
}

/// A sheet that is not wrapped.
pub fn sheet(kind: PatchKind, nu: usize, nv: usize, points: Vec<[f32; 3]>) -> Geometry {
    Geometry::Patches(Arc::new(PatchMesh {
        kind: Arc::new(kind),
        nu,
        nv,
        wrap_u: false,
        wrap_v: false,
        points: Keyed::still(Points::P(points)),
        vars: Vec::new(),
    }))
}

/// Puts a shape into a scene.
pub fn add(scene: &mut Scene, geometry: Geometry, to_world: DMat4, attributes: &Arc<Attributes>) {
    scene.primitives.push(Primitive {
        geometry,
        to_world: Transform::still(to_world),
        attributes: Arc::clone(attributes),
        origin: Origin::default(),
    });
}

/// A parameter of floats.
pub fn floats(name: &str, ty: VarType, values: &[f32]) -> ShaderParam {
    ShaderParam { name: name.to_owned(), ty, values: ParamValue::Floats(values.to_vec()) }
}

/// A distant light shining from `from` to the origin, and an ambient one.
pub fn add_lights(scene: &mut Scene, from: [f32; 3]) -> Arc<[u32]> {
    let mut make = |name: &str, params: &[ShaderParam]| {
        let shader = shading::light(name, params).expect("a standard light").shader;
        scene.add_light(Light { shader, to_world: Transform::default() })
    };
    let ambient = make("ambientlight", &[floats("intensity", VarType::Float, &[0.15])]);
    let distant = make(
        "distantlight",
        &[
            floats("intensity", VarType::Float, &[0.9]),
            floats("from", VarType::Point, &from),
            floats("to", VarType::Point, &[0.0; 3]),
        ],
    );
    Arc::from([ambient, distant])
}

/// The surface of that name with its default parameters.
pub fn surface(name: &str) -> Arc<dyn crate::shading::SurfaceShader> {
    shading::surface(name, &[]).expect("a standard surface").shader
}
