//! Shapes as the scene holds them: object space, a key per shutter time, primitive variables beside them.

use std::sync::Arc;

use super::{Keyed, SubdivisionMesh};

/// A shape.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Geometry {
    /// A patch or a sheet of patches.
    Patches(Arc<PatchMesh>),
    /// A subdivision surface.
    Subdivision(Arc<SubdivisionMesh>),
}

/// Control points of a sheet.
#[derive(Debug, Clone, PartialEq)]
pub enum Points {
    /// x, y, z.
    P(Vec<[f32; 3]>),
    /// Homogeneous: x w, y w, z w, w; w above 0 for a rational surface.
    Pw(Vec<[f32; 4]>),
}

impl Points {
    /// Number of control points.
    pub fn len(&self) -> usize {
        match self {
            Points::P(p) => p.len(),
            Points::Pw(p) => p.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A cubic basis: rows of the matrix give the coefficients of t^3, t^2, t, 1 from the four control points,
/// as RenderMan's `Basis` writes them, and the step to the next segment's first point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PatchBasis {
    /// `matrix[power][point]`, powers descending from t^3.
    pub matrix: [[f32; 4]; 4],
    /// Control points from one segment to the next, 1 to 4.
    pub step: u32,
}

impl PatchBasis {
    /// Bezier, step 3.
    pub const BEZIER: PatchBasis = PatchBasis {
        matrix: [[-1.0, 3.0, -3.0, 1.0], [3.0, -6.0, 3.0, 0.0], [-3.0, 3.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]],
        step: 3,
    };
}

/// Degree of a sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PatchKind {
    /// Four corners each.
    Bilinear,
    /// Sixteen points each, in a basis per direction.
    Bicubic {
        /// Basis in u.
        u: PatchBasis,
        /// Basis in v.
        v: PatchBasis,
    },
}

/// A sheet of patches: `nu` x `nv` control points, point (i, j) at `j * nu + i`, u along i.
///
/// ```text
///  v  j=1  P4 P5 P6 P7
///  ^  j=0  P0 P1 P2 P3   -> u
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct PatchMesh {
    /// Degree and basis, shared by the many patches of a file.
    pub kind: Arc<PatchKind>,
    /// Control points along u.
    pub nu: usize,
    /// Control points along v.
    pub nv: usize,
    /// Whether the last column continues with the first.
    pub wrap_u: bool,
    /// Whether the last row continues with the first.
    pub wrap_v: bool,
    /// Control points; every key has `nu * nv` of the same kind.
    pub points: Keyed<Points>,
    /// Primitive variables other than the position, "Cs", "Os", "s", "t", "st" and "N" among them.
    pub vars: Vec<PrimVar>,
}

impl PatchMesh {
    /// Patches along u and v: (n - 1) each way for a bilinear sheet (n if wrapped), (n - 4) / step + 1 for a
    /// bicubic one (n / step if wrapped). `None` where the counts do not fit the basis.
    pub fn num_patches(&self) -> Option<[usize; 2]> {
        let along = |n: usize, wrap: bool, basis: Option<PatchBasis>| match basis {
            None if wrap => (n >= 2).then_some(n),
            None => (n >= 2).then(|| n - 1),
            Some(b) => {
                let step = b.step as usize;
                if step == 0 || step > 4 || n < 4 && !(wrap && n >= step) {
                    None
                } else if wrap {
                    n.is_multiple_of(step).then_some(n / step)
                } else {
                    (n - 4).is_multiple_of(step).then(|| (n - 4) / step + 1)
                }
            }
        };
        let (bu, bv) = match *self.kind {
            PatchKind::Bilinear => (None, None),
            PatchKind::Bicubic { u, v } => (Some(u), Some(v)),
        };
        Some([along(self.nu, self.wrap_u, bu)?, along(self.nv, self.wrap_v, bv)?])
    }

    /// The same sheet without its control points.
    pub(super) fn without_points(&self) -> PatchMesh {
        PatchMesh {
            kind: Arc::clone(&self.kind),
            points: Keyed::still(Points::P(Vec::new())),
            vars: self.vars.clone(),
            ..*self
        }
    }

    /// Whether `other` is known to be this without its control points.
    pub(super) fn is_like_without_points(&self, other: &PatchMesh) -> bool {
        Arc::ptr_eq(&self.kind, &other.kind)
            && (self.nu, self.nv, self.wrap_u, self.wrap_v)
                == (other.nu, other.nv, other.wrap_u, other.wrap_v)
            && self.vars.is_empty()
            && other.vars.is_empty()
    }

    /// Varying corners along u and v: one more than patches, as many where wrapped.
    pub fn num_varying(&self) -> Option<[usize; 2]> {
        let [pu, pv] = self.num_patches()?;
        Some([if self.wrap_u { pu } else { pu + 1 }, if self.wrap_v { pv } else { pv + 1 }])
    }
}

/// Storage class of a primitive variable: how many values a primitive has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Class {
    /// One.
    Constant,
    /// One a patch or face.
    Uniform,
    /// One a parametric corner, bilinear between.
    Varying,
    /// One a control point, interpolated like the position.
    Vertex,
    /// One a corner of each face.
    FaceVarying,
}

/// Type of a primitive variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VarType {
    /// One float.
    Float,
    /// One integer, kept as a float.
    Integer,
    /// A string.
    String,
    /// Three floats, linear.
    Color,
    /// Three floats, moved by transforms.
    Point,
    /// Three floats, turned and scaled by transforms.
    Vector,
    /// Three floats, turned by the inverse transpose.
    Normal,
    /// Four floats, homogeneous.
    HPoint,
    /// Sixteen floats.
    Matrix,
}

impl VarType {
    /// Floats a value; 0 for strings.
    pub fn num_floats(self) -> usize {
        match self {
            VarType::Float | VarType::Integer => 1,
            VarType::String => 0,
            VarType::Color | VarType::Point | VarType::Vector | VarType::Normal => 3,
            VarType::HPoint => 4,
            VarType::Matrix => 16,
        }
    }
}

/// Values of a primitive variable.
#[derive(Debug, Clone, PartialEq)]
pub enum VarValues {
    /// Numbers, `num_floats * array_len` a value.
    Floats(Arc<[f32]>),
    /// Strings, `array_len` a value.
    Strings(Arc<[String]>),
}

/// A primitive variable.
#[derive(Debug, Clone, PartialEq)]
pub struct PrimVar {
    /// Its name, without class and type.
    pub name: String,
    /// Storage class.
    pub class: Class,
    /// Type of one element.
    pub ty: VarType,
    /// Elements a value (`float[3]` has 3), at least 1.
    pub array_len: u32,
    /// The values.
    pub values: VarValues,
}
