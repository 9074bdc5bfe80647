//! Shading: what a shader sees, what it says of itself, and the shaders that RenderMan defines.
//!
//! A shader gets a list of vertex indices, not a rectangle, so that later only the vertices that can be seen
//! need be shaded. Everything is in camera space, the RenderMan "current" space: the eye is at the origin and
//! looks along +z.

mod displacement;
mod displacers;
mod light;
mod octaves;
mod params;
mod reflect;
mod reflect_lanes;
mod space;
mod surface;
mod texture;
mod texture_lanes;

use std::fmt::Debug;
use std::sync::Arc;

use glam::{DMat4, Vec3};

use crate::error::Error;
use crate::math::Vec3s;
use crate::math::simd::{LANES, SimdLevel};

pub(crate) use displacement::surely_within;
pub use displacement::{Balls, DisplacementPoints, DisplacementShader, ROUNDING};
pub use displacers::{DISPLACEMENTS, Images};
pub use light::LIGHTS;
pub use params::{ParamValue, ShaderParam};
pub use space::{displacement_in_space, largest_stretch};
pub use surface::SURFACES;
pub use texture::TextureImage;

use params::Params;

/// The variables of a grid's vertices, one entry a vertex in every array (structure of arrays).
#[derive(Debug, Clone, Default)]
pub struct ShadingPoints {
    /// Position.
    pub p: Vec3s,
    /// Shading normal, unit length, turned by the orientation attribute; not turned to face the eye.
    pub n: Vec3s,
    /// Geometric normal, as `n`.
    pub ng: Vec3s,
    /// Derivative of the position along u.
    pub dpdu: Vec3s,
    /// Derivative of the position along v.
    pub dpdv: Vec3s,
    /// From the eye to the position (not normalised); (0, 0, 1) in an orthographic picture.
    pub i: Vec3s,
    /// Surface parameters of the primitive, 0 to 1.
    pub u: Vec<f32>,
    /// See `u`.
    pub v: Vec<f32>,
    /// Step of u between neighbouring vertices.
    pub du: Vec<f32>,
    /// Step of v.
    pub dv: Vec<f32>,
    /// Texture coordinates.
    pub s: Vec<f32>,
    /// See `s`.
    pub t: Vec<f32>,
    /// Surface colour.
    pub cs: Vec3s,
    /// Surface opacity.
    pub os: Vec3s,
    /// Other primitive variables, by name.
    pub vars: Vec<PointVar>,
    /// Shading time within the shutter.
    pub time: f32,
}

/// A primitive variable at a grid's vertices.
#[derive(Debug, Clone)]
pub struct PointVar {
    /// Its name.
    pub name: Arc<str>,
    /// Floats a vertex.
    pub num_floats: usize,
    /// `num_floats` floats a vertex, vertex after vertex.
    pub values: Vec<f32>,
}

/// What a shader returns: one entry a vertex of the grid. Entries not in the index list are left alone.
#[derive(Debug, Clone, Default)]
pub struct ShadedPoints {
    /// Colour, multiplied by opacity (RenderMan's Ci).
    pub ci: Vec3s,
    /// Opacity (RenderMan's Oi), 0 to 1.
    pub oi: Vec3s,
}

/// Which inputs a shader reads; those it does not read need not be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Inputs {
    /// Reads N (and so needs surface normals).
    pub n: bool,
    /// Reads dPdu, dPdv.
    pub derivatives: bool,
    /// Reads u, v, du, dv.
    pub uv: bool,
    /// Reads s, t.
    pub st: bool,
    /// Reads lights.
    pub lights: bool,
}

/// What a shader does to opacity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OpacityUse {
    /// Oi = Os: opaque where the surface's opacity is 1.
    Keeps,
    /// May set anything.
    MayChange,
}

/// What a shader says of itself before it runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ShaderTraits {
    /// What it does to opacity.
    pub opacity: OpacityUse,
    /// The same inputs always give the same outputs, and nothing else happens.
    pub pure: bool,
    /// Takes Du or Dv of computed values, so a vertex needs its four neighbours shaded with it.
    pub needs_ring: bool,
    /// What it reads.
    pub inputs: Inputs,
}

/// A surface shader with its parameters.
pub trait SurfaceShader: Debug + Send + Sync {
    /// The name it was asked for by.
    fn name(&self) -> &str;
    /// What it says of itself.
    fn traits(&self) -> ShaderTraits;
    /// Computes colour and opacity at `points[vertices]` into the same places of `out`.
    ///
    /// `out` has as many entries as `points`. No value may depend on which other vertices are in the list,
    /// unless the traits ask for a ring.
    fn shade(
        &self,
        points: &ShadingPoints,
        vertices: &[u32],
        lights: &[Arc<dyn PlacedLight>],
        out: &mut ShadedPoints,
    );
}

/// What a light does at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LightSample {
    /// From everywhere alike.
    Ambient {
        /// Colour of the light.
        cl: Vec3,
    },
    /// From one direction.
    From {
        /// Unit vector from the point to the light.
        l: Vec3,
        /// Colour of the light at the point.
        cl: Vec3,
    },
}

/// A light shader with its parameters, in its own space.
pub trait LightShader: Debug + Send + Sync {
    /// The name it was asked for by.
    fn name(&self) -> &str;
    /// The same light in camera space.
    fn place(&self, to_camera: &DMat4) -> Arc<dyn PlacedLight>;
}

/// A light in camera space.
pub trait PlacedLight: Debug + Send + Sync {
    /// Light that arrives at `p` (camera space), shadowed by nothing.
    fn sample(&self, p: Vec3) -> LightSample;

    /// Whether [`Self::sample`] says the same wherever it is asked.
    fn is_alike_everywhere(&self) -> bool {
        false
    }

    /// [`Self::sample`] at points by component and lane, with the same bits: unit vectors towards the light, and its
    /// colours. `None` where it is to be asked point by point; a light that may be ambient is.
    fn sample_lanes(&self, _level: SimdLevel, _p: &Lanes3) -> Option<[Lanes3; 2]> {
        None
    }
}

/// Vectors by component and lane.
pub type Lanes3 = [[f32; LANES]; 3];

/// A surface shader and what its author should know.
#[derive(Debug, Clone)]
pub struct MadeSurface {
    /// The shader.
    pub shader: Arc<dyn SurfaceShader>,
    /// Parameters that it does not have, and what it cannot do yet.
    pub warnings: Vec<String>,
}

/// A light shader and what its author should know.
#[derive(Debug, Clone)]
pub struct MadeLight {
    /// The shader.
    pub shader: Arc<dyn LightShader>,
    /// Parameters that it does not have, and what it cannot do yet.
    pub warnings: Vec<String>,
}

/// A displacement shader and what its author should know.
#[derive(Debug, Clone)]
pub struct MadeDisplacement {
    /// The shader.
    pub shader: Arc<dyn DisplacementShader>,
    /// Parameters that it does not have or that were out of range.
    pub warnings: Vec<String>,
}

/// Makes a surface shader, one of [`SURFACES`].
///
/// # Errors
/// [`Error::Shader`] where there is none of that name (it lists those there are), or where a parameter has the
/// wrong type or count or is not finite (it says what was expected).
pub fn surface(name: &str, given: &[ShaderParam]) -> Result<MadeSurface, Error> {
    let mut params = Params::new("surface", name, given);
    let shader = surface::make(name, &mut params)?.ok_or_else(|| unknown("surface", name, &SURFACES))?;
    Ok(MadeSurface { shader, warnings: params.finish() })
}

/// Makes a light shader, one of [`LIGHTS`].
///
/// # Errors
/// As [`surface`].
pub fn light(name: &str, given: &[ShaderParam]) -> Result<MadeLight, Error> {
    let mut params = Params::new("light", name, given);
    let shader = light::make(name, &mut params)?.ok_or_else(|| unknown("light", name, &LIGHTS))?;
    Ok(MadeLight { shader, warnings: params.finish() })
}

/// Makes a displacement shader, one of [`DISPLACEMENTS`], without images: those that need one are refused.
///
/// # Errors
/// As [`surface`].
pub fn displacement(name: &str, given: &[ShaderParam]) -> Result<MadeDisplacement, Error> {
    displacement_with_images(name, given, &|image| Err(format!("image \"{image}\": no images are at hand")))
}

/// Makes a displacement shader, one of [`DISPLACEMENTS`]; `images` is asked for the images that it names.
///
/// # Errors
/// As [`surface`], and where an image that the shader needs is missing.
pub fn displacement_with_images(
    name: &str,
    given: &[ShaderParam],
    images: &Images,
) -> Result<MadeDisplacement, Error> {
    let mut params = Params::new("displacement", name, given);
    let made = displacers::make(name, &mut params, images)?;
    let shader = made.ok_or_else(|| unknown("displacement", name, &DISPLACEMENTS))?;
    Ok(MadeDisplacement { shader, warnings: params.finish() })
}

fn unknown(kind: &str, name: &str, known: &[&str]) -> Error {
    Error::Shader(format!("there is no {kind} \"{name}\": expected one of {}", known.join(", ")))
}

/// The surface that is used where none is given ("defaultsurface").
pub fn default_surface() -> Arc<dyn SurfaceShader> {
    surface::default()
}
