//! Declarations: what class and type a parameter's name stands for.
//!
//! In: "uniform color[2]" or "varying float foo". Out: [`Decl`]. The names that the standard declares are here.

use std::collections::HashMap;

use olema::scene::{Class, VarType};

/// What a name stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Decl {
    /// Storage class.
    pub class: Class,
    /// Type of one element.
    pub ty: VarType,
    /// Elements a value, at least 1.
    pub array_len: u32,
}

impl Decl {
    const fn new(class: Class, ty: VarType) -> Self {
        Decl { class, ty, array_len: 1 }
    }

    /// One float for the whole primitive.
    pub const FLOAT: Decl = Decl::new(Class::Uniform, VarType::Float);
    /// One string for the whole primitive.
    pub const STRING: Decl = Decl::new(Class::Uniform, VarType::String);

    /// Floats of one value (strings of one value for strings).
    pub fn width(&self) -> usize {
        self.ty.num_floats().max(1) * self.array_len as usize
    }

    /// The declaration in words.
    pub fn describe(&self) -> String {
        let class = match self.class {
            Class::Constant => "constant",
            Class::Uniform => "uniform",
            Class::Varying => "varying",
            Class::Vertex => "vertex",
            Class::FaceVarying => "facevarying",
        };
        let ty = match self.ty {
            VarType::Float => "float",
            VarType::Integer => "integer",
            VarType::String => "string",
            VarType::Color => "color",
            VarType::Point => "point",
            VarType::Vector => "vector",
            VarType::Normal => "normal",
            VarType::HPoint => "hpoint",
            VarType::Matrix => "matrix",
        };
        match self.array_len {
            1 => format!("{class} {ty}"),
            n => format!("{class} {ty}[{n}]"),
        }
    }
}

/// Names that have been declared.
#[derive(Debug, Clone, Default)]
pub struct Dictionary {
    names: HashMap<Box<str>, Decl>,
}

/// What a parameter's token says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Found<'a> {
    /// A declared name, or an inline declaration's.
    Known(&'a str, Decl),
    /// A name that nothing declares.
    Unknown(&'a str),
    /// An inline declaration that makes no sense, and why.
    Wrong(&'static str),
}

impl Dictionary {
    /// Declares a name. "" takes the declaration back.
    pub fn declare(&mut self, name: &str, declaration: &str) -> Result<(), &'static str> {
        if declaration.trim().is_empty() {
            self.names.remove(name);
            return Ok(());
        }
        match parse(declaration)? {
            (decl, None) => {
                self.names.insert(name.into(), decl);
                Ok(())
            }
            (_, Some(_)) => Err("expected a class and a type only"),
        }
    }

    /// Looks a parameter's token up.
    pub fn find<'a>(&self, token: &'a str) -> Found<'a> {
        if token.bytes().any(|b| b.is_ascii_whitespace()) {
            return match parse(token) {
                Ok((decl, Some(name))) => Found::Known(name, decl),
                Ok((_, None)) => Found::Wrong("expected a name after class and type"),
                Err(why) => Found::Wrong(why),
            };
        }
        let declared = self.names.get(token).copied().or_else(|| standard(token));
        declared.map_or(Found::Unknown(token), |decl| Found::Known(token, decl))
    }
}

/// Reads "[class] type[n] [name]" (the array length may also follow the name).
fn parse(text: &str) -> Result<(Decl, Option<&str>), &'static str> {
    let (mut class, mut ty, mut name, mut array_len) = (None, None, None, None);
    for word in text.split_ascii_whitespace() {
        let (stem, length) = match word.find('[') {
            Some(at) => (&word[..at], Some(&word[at..])),
            None => (word, None),
        };
        if let Some(length) = length {
            let number = length.strip_prefix('[').and_then(|l| l.strip_suffix(']'));
            let number = number.and_then(|n| n.parse().ok()).filter(|n| (1..=1 << 20).contains(n));
            array_len = Some(number.ok_or("expected an array length from 1 to 1048576 in brackets")?);
        }
        if stem.is_empty() {
            continue;
        }
        match (class_word(stem), type_word(stem)) {
            (Some(found), _) if class.is_none() && ty.is_none() && name.is_none() => class = Some(found),
            (_, Some(found)) if ty.is_none() && name.is_none() => ty = Some(found),
            _ if ty.is_some() && name.is_none() => name = Some(stem),
            _ => return Err("expected [class] type [name], such as \"uniform color[2] tints\""),
        }
    }
    let ty =
        ty.ok_or("expected a type: float, integer, string, color, point, vector, normal, hpoint or matrix")?;
    let decl = Decl { class: class.unwrap_or(Class::Uniform), ty, array_len: array_len.unwrap_or(1) };
    Ok((decl, name))
}

fn class_word(word: &str) -> Option<Class> {
    Some(match word {
        "constant" => Class::Constant,
        "uniform" => Class::Uniform,
        "varying" => Class::Varying,
        "vertex" => Class::Vertex,
        "facevarying" | "facevertex" => Class::FaceVarying,
        _ => return None,
    })
}

fn type_word(word: &str) -> Option<VarType> {
    Some(match word {
        "float" => VarType::Float,
        "integer" | "int" => VarType::Integer,
        "string" => VarType::String,
        "color" | "colour" => VarType::Color,
        "point" => VarType::Point,
        "vector" => VarType::Vector,
        "normal" => VarType::Normal,
        "hpoint" => VarType::HPoint,
        "matrix" | "mpoint" => VarType::Matrix,
        _ => return None,
    })
}

/// Names that need no declaration: those of the standard, and those that options and attributes of common
/// renderers use.
fn standard(name: &str) -> Option<Decl> {
    use Class::{Constant, Uniform, Varying, Vertex};
    use VarType::{Color, Float, HPoint, Integer, Matrix, Normal, Point, Vector};
    Some(match name {
        "P" => Decl::new(Vertex, Point),
        "Pz" => Decl::new(Vertex, Float),
        "Pw" => Decl::new(Vertex, HPoint),
        "N" => Decl::new(Varying, Normal),
        "Np" => Decl::new(Uniform, Normal),
        "Cs" | "Os" => Decl::new(Varying, Color),
        "s" | "t" | "width" => Decl::new(Varying, Float),
        "st" => Decl { class: Varying, ty: Float, array_len: 2 },
        "constantwidth" => Decl::new(Constant, Float),
        "constantnormal" => Decl::new(Constant, Normal),
        "Ka" | "Kd" | "Ks" | "Kr" | "roughness" | "intensity" | "coneangle" | "conedeltaangle"
        | "beamdistribution" | "amplitude" | "mindistance" | "maxdistance" | "distance" | "fov"
        | "jitter" | "maxdepth" | "bump" | "frequency" | "gain" | "lacunarity" | "octaves" | "seed"
        | "zero" | "sscale" | "tscale" | "dither" | "sphere" | "gamma" | "minwidth" => Decl::FLOAT,
        "specularcolor" | "lightcolor" | "bgcolor" | "background" | "color" => Decl::new(Uniform, Color),
        "from" | "to" => Decl::new(Uniform, Point),
        "texturename" | "shadowname" | "depthfilter" | "compression" | "coordinatesystem" | "name"
        | "shadows" | "shader" | "archive" | "texture" | "display" | "procedural" | "rib" | "resource"
        | "shadinggroup" | "transmission" => Decl::STRING,
        "origin" => Decl { class: Uniform, ty: Integer, array_len: 2 },
        "bucketsize" => Decl { class: Uniform, ty: Integer, array_len: 2 },
        "quantize" => Decl { class: Uniform, ty: Float, array_len: 4 },
        "gridsize" | "eyesplits" | "texturememory" | "endofframe" | "merge" | "binary" | "rasterorient"
        | "camera" | "trace" | "displacements" | "nsamples" | "subpixel" | "threads" => {
            Decl::new(Uniform, Integer)
        }
        "othreshold" => Decl::new(Uniform, Color),
        "__tocamera" => Decl::new(Uniform, Matrix),
        "dPdu" | "dPdv" => Decl::new(Varying, Vector),
        "direction" | "offset" => Decl::new(Uniform, Vector),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inline_declarations_name_class_type_and_length() {
        let dictionary = Dictionary::default();
        let found = |t| dictionary.find(t);
        let two = Decl { class: Class::Uniform, ty: VarType::Float, array_len: 2 };
        assert_eq!(found("uniform float[2] a"), Found::Known("a", two));
        assert_eq!(found("float a[2]"), Found::Known("a", two));
        assert_eq!(found("float[2] a"), Found::Known("a", two));
        assert_eq!(found("float [2] a"), Found::Known("a", two));
        let colour = Decl { class: Class::FaceVarying, ty: VarType::Color, array_len: 1 };
        assert_eq!(found("facevarying color Cs"), Found::Known("Cs", colour));
        // A name may be spelt like a type or a class.
        let named = Decl { class: Class::Uniform, ty: VarType::Color, array_len: 1 };
        assert_eq!(found("color color"), Found::Known("color", named));
        assert_eq!(found("color vertex"), Found::Known("vertex", named));
        for wrong in
            ["uniform a", "float", "float[0] a", "float[x] a", "float a b", "varying uniform float a"]
        {
            assert!(!matches!(found(wrong), Found::Known(..)), "{wrong}");
        }
    }

    #[test]
    fn declare_goes_before_the_standard_and_can_be_taken_back() {
        let mut dictionary = Dictionary::default();
        assert_eq!(dictionary.find("from"), Found::Known("from", Decl::new(Class::Uniform, VarType::Point)));
        dictionary.declare("from", "varying vector").expect("a declaration");
        assert_eq!(dictionary.find("from"), Found::Known("from", Decl::new(Class::Varying, VarType::Vector)));
        dictionary.declare("from", "").expect("a declaration");
        assert_eq!(dictionary.find("from"), Found::Known("from", Decl::new(Class::Uniform, VarType::Point)));
        assert_eq!(dictionary.find("blur"), Found::Unknown("blur"));
        assert!(dictionary.declare("a", "flaot").is_err());
        assert!(dictionary.declare("a", "float b").is_err());
    }
}
