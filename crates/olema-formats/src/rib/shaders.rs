//! The seam between the reader and the shaders: names and parameters in, shaders out.

use std::fmt::Debug;
use std::sync::Arc;

use olema::shading::{self, DisplacementShader, Images, LightShader, ShaderParam, SurfaceShader};

/// A shader, and what there is to say about its parameters.
#[derive(Debug)]
pub struct Made<T: ?Sized> {
    /// The shader.
    pub shader: Arc<T>,
    /// Parameters that were ignored and the like.
    pub warnings: Vec<String>,
}

/// Where shaders come from.
pub trait ShaderLibrary: Debug + Send + Sync {
    /// Makes a surface shader.
    ///
    /// # Errors
    /// A sentence, where the name is unknown or a parameter is wrong.
    fn surface(&self, name: &str, params: &[ShaderParam]) -> Result<Made<dyn SurfaceShader>, String>;

    /// Makes a light shader.
    ///
    /// # Errors
    /// As for [`Self::surface`].
    fn light(&self, name: &str, params: &[ShaderParam]) -> Result<Made<dyn LightShader>, String>;

    /// Makes a displacement shader; images that it names are asked of `images`.
    ///
    /// # Errors
    /// As for [`Self::surface`], and where an image is missing.
    fn displacement(
        &self,
        name: &str,
        params: &[ShaderParam],
        images: &Images,
    ) -> Result<Made<dyn DisplacementShader>, String>;

    /// The surface where none is given or the given one cannot be made.
    fn default_surface(&self) -> Arc<dyn SurfaceShader>;
}

/// The shaders that every renderer has.
#[derive(Debug)]
pub struct Standard;

impl ShaderLibrary for Standard {
    fn surface(&self, name: &str, params: &[ShaderParam]) -> Result<Made<dyn SurfaceShader>, String> {
        let made = shading::surface(name, params).map_err(|e| e.to_string())?;
        Ok(Made { shader: made.shader, warnings: made.warnings })
    }

    fn light(&self, name: &str, params: &[ShaderParam]) -> Result<Made<dyn LightShader>, String> {
        let made = shading::light(name, params).map_err(|e| e.to_string())?;
        Ok(Made { shader: made.shader, warnings: made.warnings })
    }

    fn displacement(
        &self,
        name: &str,
        params: &[ShaderParam],
        images: &Images,
    ) -> Result<Made<dyn DisplacementShader>, String> {
        let made = shading::displacement_with_images(name, params, images).map_err(|e| e.to_string())?;
        Ok(Made { shader: made.shader, warnings: made.warnings })
    }

    fn default_surface(&self) -> Arc<dyn SurfaceShader> {
        shading::default_surface()
    }
}
