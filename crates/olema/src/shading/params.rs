//! Parameters as a scene file gives them, read into a shader's fields.
//!
//! In: names, types and values. Out: the values a shader asks for, by name and type, or its defaults; an
//! error that says what was expected, or a warning for each parameter that nobody asked for.

use glam::Vec3;

use crate::error::Error;
use crate::scene::VarType;

/// A parameter given to a shader.
#[derive(Debug, Clone, PartialEq)]
pub struct ShaderParam {
    /// Its name, without class and type.
    pub name: String,
    /// Type of its value.
    pub ty: VarType,
    /// The value, or several for an array.
    pub values: ParamValue,
}

/// Values of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub enum ParamValue {
    /// Numbers, `num_floats` of the type a value.
    Floats(Vec<f32>),
    /// Strings.
    Strings(Vec<String>),
}

impl ShaderParam {
    /// A float.
    pub fn float(name: &str, value: f32) -> Self {
        ShaderParam { name: name.to_owned(), ty: VarType::Float, values: ParamValue::Floats(vec![value]) }
    }

    /// A linear colour.
    pub fn color(name: &str, value: [f32; 3]) -> Self {
        let values = ParamValue::Floats(value.to_vec());
        ShaderParam { name: name.to_owned(), ty: VarType::Color, values }
    }

    /// A point in the shader's space.
    pub fn point(name: &str, value: [f32; 3]) -> Self {
        let values = ParamValue::Floats(value.to_vec());
        ShaderParam { name: name.to_owned(), ty: VarType::Point, values }
    }

    /// A string.
    pub fn string(name: &str, value: &str) -> Self {
        let values = ParamValue::Strings(vec![value.to_owned()]);
        ShaderParam { name: name.to_owned(), ty: VarType::String, values }
    }
}

/// Hands out parameters and remembers which were asked for.
pub(super) struct Params<'a> {
    kind: &'static str,
    shader: &'a str,
    given: &'a [ShaderParam],
    taken: Vec<bool>,
    asked: Vec<&'static str>,
    warnings: Vec<String>,
}

impl<'a> Params<'a> {
    /// For a shader of that kind ("surface", "light") and name.
    pub fn new(kind: &'static str, shader: &'a str, given: &'a [ShaderParam]) -> Self {
        Params {
            kind,
            shader,
            given,
            taken: vec![false; given.len()],
            asked: Vec::new(),
            warnings: Vec::new(),
        }
    }

    /// The last parameter of that name: a later one replaces an earlier one.
    fn find(&mut self, name: &'static str) -> Option<&'a ShaderParam> {
        self.asked.push(name);
        let mut found = None;
        for (param, taken) in self.given.iter().zip(&mut self.taken) {
            if param.name == name {
                *taken = true;
                found = Some(param);
            }
        }
        found
    }

    fn wrong(&self, param: &ShaderParam, expected: &str) -> Error {
        let (count, unit) = match &param.values {
            ParamValue::Floats(v) => (v.len(), "number"),
            ParamValue::Strings(v) => (v.len(), "string"),
        };
        let plural = if count == 1 { "" } else { "s" };
        Error::Shader(format!(
            "{} \"{}\": parameter \"{}\" is {} with {count} {unit}{plural}: expected {expected}",
            self.kind,
            self.shader,
            param.name,
            type_name(param.ty),
        ))
    }

    /// `N` finite numbers of one of the types.
    fn floats<const N: usize>(
        &mut self,
        name: &'static str,
        types: &[VarType],
        expected: &str,
        default: [f32; N],
    ) -> Result<[f32; N], Error> {
        let Some(param) = self.find(name) else { return Ok(default) };
        let ParamValue::Floats(values) = &param.values else { return Err(self.wrong(param, expected)) };
        if !types.contains(&param.ty) {
            return Err(self.wrong(param, expected));
        }
        let values: [f32; N] = values.as_slice().try_into().map_err(|_| self.wrong(param, expected))?;
        if let Some(bad) = values.iter().find(|v| !v.is_finite()) {
            return Err(Error::Shader(format!(
                "{} \"{}\": parameter \"{name}\" is {bad}: expected {expected}",
                self.kind, self.shader
            )));
        }
        Ok(values)
    }

    /// A float.
    pub fn float(&mut self, name: &'static str, default: f32) -> Result<f32, Error> {
        let types = [VarType::Float, VarType::Integer];
        Ok(self.floats(name, &types, "float with 1 finite number", [default])?[0])
    }

    /// A float that is clamped to a range, with a warning.
    pub fn float_within(&mut self, name: &'static str, default: f32, range: [f32; 2]) -> Result<f32, Error> {
        let value = self.float(name, default)?;
        let [least, most] = range;
        let clamped = value.clamp(least, most);
        if clamped != value {
            self.warn(&format!("{name} is {value}: expected {least} to {most}, taken as {clamped}"));
        }
        Ok(clamped)
    }

    /// A colour, by default gray.
    pub fn color(&mut self, name: &'static str, default: f32) -> Result<Vec3, Error> {
        let expected = "color with 3 finite numbers";
        Ok(self.floats(name, &[VarType::Color], expected, [default; 3])?.into())
    }

    /// A point.
    pub fn point(&mut self, name: &'static str, default: Vec3) -> Result<Vec3, Error> {
        let expected = "point with 3 finite numbers";
        Ok(self.floats(name, &[VarType::Point], expected, default.to_array())?.into())
    }

    /// A vector, which may be declared as a point or normal too.
    pub fn vector(&mut self, name: &'static str, default: Vec3) -> Result<Vec3, Error> {
        let types = [VarType::Vector, VarType::Point, VarType::Normal];
        Ok(self.floats(name, &types, "vector with 3 finite numbers", default.to_array())?.into())
    }

    /// A string, by default empty.
    pub fn string(&mut self, name: &'static str) -> Result<&'a str, Error> {
        let Some(param) = self.find(name) else { return Ok("") };
        match &param.values {
            ParamValue::Strings(values) if param.ty == VarType::String && values.len() == 1 => Ok(&values[0]),
            _ => Err(self.wrong(param, "string with 1 string")),
        }
    }

    /// An error that names the shader.
    pub fn error(&self, text: &str) -> Error {
        Error::Shader(format!("{} \"{}\": {text}", self.kind, self.shader))
    }

    /// Notes something that the scene's author should know.
    pub fn warn(&mut self, text: &str) {
        self.warnings.push(format!("{} \"{}\": {text}", self.kind, self.shader));
    }

    /// All warnings, with one for each parameter that the shader does not have.
    pub fn finish(mut self) -> Vec<String> {
        let has = if self.asked.is_empty() {
            "it has none".to_owned()
        } else {
            format!("it has {}", self.asked.join(", "))
        };
        for (param, taken) in self.given.iter().zip(&self.taken) {
            if !taken {
                self.warnings.push(format!(
                    "{} \"{}\" has no parameter \"{}\": {has}",
                    self.kind, self.shader, param.name
                ));
            }
        }
        self.warnings
    }
}

/// The type as RenderMan spells it.
fn type_name(ty: VarType) -> &'static str {
    match ty {
        VarType::Float => "float",
        VarType::Integer => "integer",
        VarType::String => "string",
        VarType::Color => "color",
        VarType::Point => "point",
        VarType::Vector => "vector",
        VarType::Normal => "normal",
        VarType::HPoint => "hpoint",
        VarType::Matrix => "matrix",
    }
}
