//! RenderMan's standard surfaces.
//!
//! In: a grid's variables and the lights. Out: Ci and Oi, vertex by vertex. Formulas and defaults are those
//! of RenderMan Interface 3.2, appendix A.2; "defaultsurface", which that leaves open, is the usual one that
//! needs no light. Colours are linear.

use std::sync::Arc;

use glam::Vec3;

use super::params::Params;
use super::reflect::{Facing, Mix, Wanted, finite3, normalize_or_zero, reflect};
use super::reflect_lanes;
use super::{Inputs, OpacityUse, PlacedLight, ShadedPoints, ShaderTraits, ShadingPoints, SurfaceShader};
use crate::error::Error;
use crate::math::simd::SimdLevel;

/// Names of the surfaces there are.
pub const SURFACES: [&str; 8] =
    ["constant", "default", "defaultsurface", "matte", "metal", "paintedplastic", "plastic", "shinymetal"];

/// Makes the surface of that name; `None` where there is none.
pub(super) fn make(name: &str, params: &mut Params) -> Result<Option<Arc<dyn SurfaceShader>>, Error> {
    Ok(Some(match name {
        "constant" => Arc::new(Constant),
        "matte" => Arc::new(Matte { ka: params.float("Ka", 1.0)?, kd: params.float("Kd", 1.0)? }),
        "metal" => Arc::new(metal("metal", params)?),
        "shinymetal" => {
            params.float("Kr", 1.0)?;
            if !params.string("texturename")?.is_empty() {
                params.warn("environment maps are not drawn yet: it looks like \"metal\"");
            }
            Arc::new(metal("shinymetal", params)?)
        }
        "plastic" => Arc::new(plastic("plastic", params)?),
        "paintedplastic" => {
            if !params.string("texturename")?.is_empty() {
                params.warn("textures are not drawn yet: it looks like \"plastic\"");
            }
            Arc::new(plastic("paintedplastic", params)?)
        }
        "default" => Arc::new(default_surface("default", params)?),
        "defaultsurface" => Arc::new(default_surface("defaultsurface", params)?),
        _ => return Ok(None),
    }))
}

fn metal(name: &'static str, params: &mut Params) -> Result<Metal, Error> {
    let (ka, ks) = (params.float("Ka", 1.0)?, params.float("Ks", 1.0)?);
    Ok(Metal { name, ka, ks, exponent: exponent(params)? })
}

fn plastic(name: &'static str, params: &mut Params) -> Result<Plastic, Error> {
    Ok(Plastic {
        name,
        ka: params.float("Ka", 1.0)?,
        kd: params.float("Kd", 0.5)?,
        ks: params.float("Ks", 0.5)?,
        exponent: exponent(params)?,
        specular_color: params.color("specularcolor", 1.0)?,
    })
}

/// "defaultsurface" as it comes.
pub(super) fn default() -> Arc<dyn SurfaceShader> {
    Arc::new(DefaultSurface { name: "defaultsurface", ka: 0.2, kd: 0.8 })
}

fn default_surface(name: &'static str, params: &mut Params) -> Result<DefaultSurface, Error> {
    Ok(DefaultSurface { name, ka: params.float("Ka", 0.2)?, kd: params.float("Kd", 0.8)? })
}

/// 1 / roughness, 0.1 by default. Roughness 0 is a highlight in one point only.
fn exponent(params: &mut Params) -> Result<f32, Error> {
    let roughness = params.float("roughness", 0.1)?;
    if roughness < 0.0 {
        params.warn(&format!("roughness is {roughness}: expected 0 or more, taken as 0"));
    }
    Ok(if roughness > 0.0 { 1.0 / roughness } else { f32::INFINITY })
}

const fn traits(inputs: Inputs) -> ShaderTraits {
    ShaderTraits { opacity: OpacityUse::Keeps, pure: true, needs_ring: false, inputs }
}

const LIT: Inputs = Inputs { n: true, lights: true, derivatives: false, uv: false, st: false };

/// Writes Oi = Os, Ci = Os * `color(vertex, Cs)`.
#[inline]
fn write(
    points: &ShadingPoints,
    vertices: &[u32],
    out: &mut ShadedPoints,
    mut color: impl FnMut(usize, Vec3) -> Vec3,
) {
    for &vertex in vertices {
        let ix = vertex as usize;
        let os = points.os.get(ix);
        out.oi.set(ix, os);
        out.ci.set(ix, os * finite3(color(ix, points.cs.get(ix))));
    }
}

/// Fewer vertices than this are shaded one by one: lanes that are left over cost as much as others.
const FEW: usize = 4;

/// Writes Oi = Os, Ci = Os * what `mix` makes of Cs and of what of the lights is reflected.
fn write_lit(
    points: &ShadingPoints,
    vertices: &[u32],
    (lights, wanted): (&[Arc<dyn PlacedLight>], Wanted),
    out: &mut ShadedPoints,
    mix: &Mix,
) {
    if vertices.len() < FEW {
        write(points, vertices, out, |ix, cs| {
            let reflected = reflect(Facing::new(points, ix), lights, wanted);
            Vec3::from_array([0, 1, 2].map(|c| mix.color(c, cs[c], reflected.channel(c))))
        });
    } else {
        reflect_lanes::write_lit(SimdLevel::best(), points, vertices, (lights, wanted), out, mix);
    }
}

/// Colour as it is: Ci = Os Cs.
#[derive(Debug)]
struct Constant;

impl SurfaceShader for Constant {
    fn name(&self) -> &str {
        "constant"
    }

    fn traits(&self) -> ShaderTraits {
        traits(Inputs { n: false, lights: false, ..LIT })
    }

    fn shade(&self, points: &ShadingPoints, at: &[u32], _: &[Arc<dyn PlacedLight>], out: &mut ShadedPoints) {
        write(points, at, out, |_, cs| cs);
    }
}

/// Ci = Os Cs (Ka ambient + Kd diffuse).
#[derive(Debug)]
struct Matte {
    ka: f32,
    kd: f32,
}

impl SurfaceShader for Matte {
    fn name(&self) -> &str {
        "matte"
    }

    fn traits(&self) -> ShaderTraits {
        traits(LIT)
    }

    fn shade(
        &self,
        points: &ShadingPoints,
        at: &[u32],
        lights: &[Arc<dyn PlacedLight>],
        out: &mut ShadedPoints,
    ) {
        let wanted = Wanted { diffuse: true, exponent: None };
        let mix = Mix { ambient: self.ka, diffuse: Some(self.kd), specular: None, highlight: None };
        write_lit(points, at, (lights, wanted), out, &mix);
    }
}

/// Ci = Os Cs (Ka ambient + Ks specular). Also shinymetal, while there are no environment maps.
#[derive(Debug)]
struct Metal {
    name: &'static str,
    ka: f32,
    ks: f32,
    exponent: f32,
}

impl SurfaceShader for Metal {
    fn name(&self) -> &str {
        self.name
    }

    fn traits(&self) -> ShaderTraits {
        traits(LIT)
    }

    fn shade(
        &self,
        points: &ShadingPoints,
        at: &[u32],
        lights: &[Arc<dyn PlacedLight>],
        out: &mut ShadedPoints,
    ) {
        let wanted = Wanted { diffuse: false, exponent: Some(self.exponent) };
        let mix = Mix { ambient: self.ka, diffuse: None, specular: Some(self.ks), highlight: None };
        write_lit(points, at, (lights, wanted), out, &mix);
    }
}

/// Ci = Os (Cs (Ka ambient + Kd diffuse) + specularcolor Ks specular). Also paintedplastic, untextured yet.
#[derive(Debug)]
struct Plastic {
    name: &'static str,
    ka: f32,
    kd: f32,
    ks: f32,
    exponent: f32,
    specular_color: Vec3,
}

impl SurfaceShader for Plastic {
    fn name(&self) -> &str {
        self.name
    }

    fn traits(&self) -> ShaderTraits {
        traits(LIT)
    }

    fn shade(
        &self,
        points: &ShadingPoints,
        at: &[u32],
        lights: &[Arc<dyn PlacedLight>],
        out: &mut ShadedPoints,
    ) {
        let wanted = Wanted { diffuse: true, exponent: (self.ks != 0.0).then_some(self.exponent) };
        let highlight = Some((self.ks, self.specular_color));
        let mix = Mix { ambient: self.ka, diffuse: Some(self.kd), specular: None, highlight };
        write_lit(points, at, (lights, wanted), out, &mix);
    }
}

/// Lit from the eye, without lights: Ci = Os Cs (Ka + Kd d^2), d the cosine between N and I.
#[derive(Debug)]
struct DefaultSurface {
    name: &'static str,
    ka: f32,
    kd: f32,
}

impl DefaultSurface {
    /// Ci / Os from the cosine.
    #[inline(always)]
    fn color(&self, cs: f32, d: f32) -> f32 {
        cs * (self.ka + self.kd * (d * d))
    }
}

impl SurfaceShader for DefaultSurface {
    fn name(&self) -> &str {
        self.name
    }

    fn traits(&self) -> ShaderTraits {
        traits(Inputs { lights: false, ..LIT })
    }

    fn shade(&self, points: &ShadingPoints, at: &[u32], _: &[Arc<dyn PlacedLight>], out: &mut ShadedPoints) {
        if at.len() < FEW {
            write(points, at, out, |ix, cs| {
                let d = normalize_or_zero(points.n.get(ix)).dot(normalize_or_zero(points.i.get(ix)));
                Vec3::from_array(cs.to_array().map(|cs| self.color(cs, d)))
            });
        } else {
            reflect_lanes::write_facing(SimdLevel::best(), points, at, out, [self.ka, self.kd]);
        }
    }
}

#[cfg(test)]
#[path = "surface_tests.rs"]
mod tests;
