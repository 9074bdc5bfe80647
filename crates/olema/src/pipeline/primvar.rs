//! Primitive variables at the vertices of a grid.
//!
//! In: the primitive's variables and a patch of it. Out: values at (u, v) of the patch. Every class is turned
//! into one of three forms per patch: one value, four corners, or sixteen Bezier points.

use glam::{DMat4, DVec3};

use crate::scene::{Class, Geometry, PatchKind, PatchMesh, PrimVar, Primitive, VarType, VarValues};

use super::dice::PrimitiveInfo;
use super::patchify::change_basis;
use super::split::SplitContext;

/// A variable of one patch, ready to evaluate.
#[derive(Debug, Clone)]
pub struct PatchVar {
    /// Floats a value.
    pub num_floats: usize,
    form: Form,
}

#[derive(Debug, Clone)]
enum Form {
    One(Vec<f32>),
    Corners([Vec<f32>; 4]),
    Bezier(Vec<[f64; 16]>),
}

impl PatchVar {
    /// Variable `var` of the patch at `cell` of `mesh`; points, vectors and normals go to camera space.
    /// `None` where it holds strings or too few values.
    pub fn new(mesh: &PatchMesh, var: &PrimVar, cell: [u32; 2], to_camera: &DMat4) -> Option<Self> {
        let VarValues::Floats(values) = &var.values else { return None };
        let num_floats = var.ty.num_floats() * var.array_len as usize;
        let value = |ix: usize| -> Option<Vec<f32>> {
            let raw = values.get(ix * num_floats..(ix + 1) * num_floats)?;
            Some(to_space(raw, var.ty, to_camera))
        };
        let [column, row] = cell.map(|c| c as usize);
        let [pu, _] = mesh.num_patches()?;
        let [cu, cv] = mesh.num_varying()?;
        let form = match var.class {
            Class::Constant => Form::One(value(0)?),
            Class::Uniform => Form::One(value(row * pu + column)?),
            Class::Varying => {
                let at = |i: usize, j: usize| value((j % cv) * cu + i % cu);
                Form::Corners([
                    at(column, row)?,
                    at(column + 1, row)?,
                    at(column, row + 1)?,
                    at(column + 1, row + 1)?,
                ])
            }
            Class::FaceVarying => {
                let first = (row * pu + column) * 4;
                Form::Corners([value(first)?, value(first + 1)?, value(first + 2)?, value(first + 3)?])
            }
            Class::Vertex => vertex_form(mesh, [column, row], num_floats, value)?,
        };
        Some(PatchVar { num_floats, form })
    }

    /// A variable that is bilinear between four corners.
    pub fn corners(corners: [Vec<f32>; 4]) -> Self {
        PatchVar { num_floats: corners[0].len(), form: Form::Corners(corners) }
    }

    /// Whether it is the same all over the patch.
    pub fn constant(&self) -> Option<&[f32]> {
        if let Form::One(value) = &self.form { Some(value) } else { None }
    }

    /// Float `component` at (u, v) of the patch.
    #[inline]
    pub fn evaluate(&self, component: usize, [u, v]: [f32; 2]) -> f32 {
        match &self.form {
            Form::One(value) => value[component],
            Form::Corners([a, b, c, d]) => {
                between_corners([a[component], b[component], c[component], d[component]], [u, v])
            }
            Form::Bezier(points) => bezier(&points[component], f64::from(u), f64::from(v)) as f32,
        }
    }
}

fn vertex_form(
    mesh: &PatchMesh,
    [column, row]: [usize; 2],
    num_floats: usize,
    value: impl Fn(usize) -> Option<Vec<f32>>,
) -> Option<Form> {
    let at = |i: usize, j: usize| value((j % mesh.nv) * mesh.nu + i % mesh.nu);
    match *mesh.kind {
        PatchKind::Bilinear => Some(Form::Corners([
            at(column, row)?,
            at(column + 1, row)?,
            at(column, row + 1)?,
            at(column + 1, row + 1)?,
        ])),
        PatchKind::Bicubic { u, v } => {
            let (i0, j0) = (column * u.step as usize, row * v.step as usize);
            let control: Vec<Vec<f32>> =
                (0..16).map(|ix| at(i0 + ix % 4, j0 + ix / 4)).collect::<Option<_>>()?;
            let component = |c: usize| {
                let points: [f64; 16] = std::array::from_fn(|ix| f64::from(control[ix][c]));
                change_basis(points, &u, &v)
            };
            Some(Form::Bezier((0..num_floats).map(component).collect()))
        }
    }
}

fn bezier(points: &[f64; 16], u: f64, v: f64) -> f64 {
    let weights = |t: f64| {
        let s = 1.0 - t;
        [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t]
    };
    let (bu, bv) = (weights(u), weights(v));
    let row = |j: usize| {
        points[4 * j] * bu[0]
            + points[4 * j + 1] * bu[1]
            + points[4 * j + 2] * bu[2]
            + points[4 * j + 3] * bu[3]
    };
    row(0) * bv[0] + row(1) * bv[1] + row(2) * bv[2] + row(3) * bv[3]
}

/// Carries points, vectors and normals to camera space; everything else stays.
fn to_space(raw: &[f32], ty: VarType, to_camera: &DMat4) -> Vec<f32> {
    let each = |f: &dyn Fn(DVec3) -> DVec3| {
        raw.chunks_exact(3)
            .flat_map(|c| f(DVec3::new(c[0].into(), c[1].into(), c[2].into())).as_vec3().to_array())
            .collect()
    };
    match ty {
        VarType::Point => each(&|p| to_camera.transform_point3(p)),
        VarType::Vector => each(&|p| to_camera.transform_vector3(p)),
        VarType::Normal => {
            let normal_matrix = to_camera.inverse().transpose();
            each(&|p| normal_matrix.transform_vector3(p))
        }
        _ => raw.to_vec(),
    }
}

/// s or t between those of a primitive's corners, which span all of it: at its own (u, v).
#[inline(always)]
pub fn spanned([a, b, c, d]: &[[f32; 2]; 4], component: usize, [u, v]: [f32; 2]) -> f32 {
    let pick = [a[component], b[component], c[component], d[component]];
    between_corners(pick, [u, v])
}

/// What lies between four corners.
#[inline(always)]
fn between_corners([a, b, c, d]: [f32; 4], [u, v]: [f32; 2]) -> f32 {
    let along_u = [a * (1.0 - u) + b * u, c * (1.0 - u) + d * u];
    along_u[0] * (1.0 - v) + along_u[1] * v
}

/// Texture coordinates s and t at places of a patch: the primitive's "st", or "s" and "t", or what its attributes
/// span over its own (u, v).
pub fn texture_coordinates(
    context: &SplitContext,
    patch_ix: u32,
    uv: &[[f32; 2]],
    primitive: &Primitive,
    info: &PrimitiveInfo,
) -> (Vec<f32>, Vec<f32>) {
    let patch = &context.patches.patches[patch_ix as usize];
    let [u0, u1, v0, v1] = patch.params;
    let corners = &primitive.attributes.texture_coordinates;
    let own = |component: usize| -> Vec<f32> {
        let whole = |[u, v]: [f32; 2]| [u0 + (u1 - u0) * u, v0 + (v1 - v0) * v];
        uv.iter().map(|&at| spanned(corners, component, whole(at))).collect()
    };
    let mut st = [None, None];
    let wanted = |name: &str| matches!(name, "s" | "t" | "st");
    each_variable(context, patch_ix, uv, primitive, info, wanted, |name, num_floats, floats| {
        match (name, num_floats) {
            ("s", 1) => st[0] = Some(floats),
            ("t", 1) => st[1] = Some(floats),
            ("st", 2) => st = [0, 1].map(|c| Some(floats.iter().skip(c).step_by(2).copied().collect())),
            _ => {}
        }
    });
    let [s, t] = st;
    (s.unwrap_or_else(|| own(0)), t.unwrap_or_else(|| own(1)))
}

/// Whether a primitive has any variables.
pub fn has_variables(primitive: &Primitive) -> bool {
    match &primitive.geometry {
        Geometry::Patches(mesh) => !mesh.vars.is_empty(),
        Geometry::Subdivision(mesh) => !mesh.vars.is_empty(),
    }
}

/// Evaluates the primitive's float variables whose names are `wanted` at places of a patch, and hands each to
/// `take` with its name, floats a place, and values place after place.
pub fn each_variable(
    context: &SplitContext,
    patch_ix: u32,
    uv: &[[f32; 2]],
    primitive: &Primitive,
    info: &PrimitiveInfo,
    wanted: impl Fn(&str) -> bool,
    mut take: impl FnMut(&str, usize, Vec<f32>),
) {
    match &primitive.geometry {
        Geometry::Patches(mesh) => {
            let cell = context.patches.patches[patch_ix as usize].cell;
            for var in mesh.vars.iter().filter(|var| wanted(&var.name)) {
                let Some(values) = PatchVar::new(mesh, var, cell, &info.to_camera) else { continue };
                let all = uv.iter().flat_map(|&at| (0..values.num_floats).map(move |c| (c, at)));
                take(&var.name, values.num_floats, all.map(|(c, at)| values.evaluate(c, at)).collect());
            }
        }
        Geometry::Subdivision(mesh) => {
            for (ix, var) in mesh.vars.iter().enumerate().filter(|(_, var)| wanted(&var.name)) {
                let num_floats = var.ty.num_floats() * var.array_len as usize;
                let mut floats = vec![0.0; uv.len() * num_floats];
                let mut values = uv.iter().zip(floats.chunks_exact_mut(num_floats.max(1)));
                if num_floats > 0
                    && values.all(|(&at, out)| context.surfaces.limit_var(patch_ix, ix, at, out))
                {
                    take(&var.name, num_floats, to_space(&floats, var.ty, &info.to_camera));
                }
            }
        }
    }
}
