//! Shaders that only have a name: a stand-in until the reader is wired to the renderer's own.

use std::sync::Arc;

use glam::{DMat4, Vec3};
use olema::shading::{
    Inputs, LightSample, LightShader, OpacityUse, PlacedLight, ShadedPoints, ShaderTraits, ShadingPoints,
    SurfaceShader,
};

use super::shaders::{Made, ShaderLibrary, ShaderParam};

/// The library.
#[derive(Debug)]
pub struct Unwired;

#[derive(Debug)]
struct Named(String);

impl SurfaceShader for Named {
    fn name(&self) -> &str {
        &self.0
    }

    fn traits(&self) -> ShaderTraits {
        let inputs = Inputs::default();
        ShaderTraits { opacity: OpacityUse::Keeps, pure: true, needs_ring: false, inputs }
    }

    fn shade(
        &self,
        points: &ShadingPoints,
        vertices: &[u32],
        _: &[Arc<dyn PlacedLight>],
        out: &mut ShadedPoints,
    ) {
        for ix in vertices.iter().map(|v| *v as usize) {
            out.ci.set(ix, points.cs.get(ix) * points.os.get(ix));
            out.oi.set(ix, points.os.get(ix));
        }
    }
}

impl LightShader for Named {
    fn name(&self) -> &str {
        &self.0
    }

    fn place(&self, _: &DMat4) -> Arc<dyn PlacedLight> {
        Arc::new(Named(self.0.clone()))
    }
}

impl PlacedLight for Named {
    fn sample(&self, _: Vec3) -> LightSample {
        LightSample::Ambient { cl: Vec3::ZERO }
    }
}

impl ShaderLibrary for Unwired {
    fn surface(&self, name: &str, _: &[ShaderParam]) -> Result<Made<dyn SurfaceShader>, String> {
        const KNOWN: [&str; 7] =
            ["constant", "matte", "metal", "shinymetal", "plastic", "paintedplastic", "defaultsurface"];
        if !KNOWN.contains(&name) {
            return Err(format!("surface shader \"{name}\" is unknown: expected {}", KNOWN.join(", ")));
        }
        Ok(Made { shader: Arc::new(Named(name.to_owned())), warnings: Vec::new() })
    }

    fn light(&self, name: &str, _: &[ShaderParam]) -> Result<Made<dyn LightShader>, String> {
        const KNOWN: [&str; 4] = ["ambientlight", "distantlight", "pointlight", "spotlight"];
        if !KNOWN.contains(&name) {
            return Err(format!("light shader \"{name}\" is unknown: expected {}", KNOWN.join(", ")));
        }
        Ok(Made { shader: Arc::new(Named(name.to_owned())), warnings: Vec::new() })
    }

    fn default_surface(&self) -> Arc<dyn SurfaceShader> {
        Arc::new(Named("defaultsurface".to_owned()))
    }
}
