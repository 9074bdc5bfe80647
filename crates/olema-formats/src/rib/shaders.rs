//! The seam between the reader and the shaders: names and parameters in, shaders out.

use std::fmt::Debug;
use std::sync::Arc;

use olema::scene::VarType;
use olema::shading::{LightShader, SurfaceShader};

/// A parameter given to a shader.
#[derive(Debug, Clone, PartialEq)]
pub struct ShaderParam {
    /// Its name, without class and type.
    pub name: String,
    /// Type of its value.
    pub ty: VarType,
    /// The value.
    pub values: ParamValue,
}

/// Values of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub enum ParamValue {
    /// Numbers, as many a value as the type has.
    Floats(Vec<f32>),
    /// Strings.
    Strings(Vec<String>),
}

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

    /// The surface where none is given or the given one cannot be made.
    fn default_surface(&self) -> Arc<dyn SurfaceShader>;
}
