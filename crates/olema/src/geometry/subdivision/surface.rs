//! The limit surface of a control mesh: its tables, made once and then only read.
//!
//! In: a [`SubdivisionMesh`]. Out: [`LimitSurface`], its base quads and, for one at a time, an
//! [`Evaluator`].

use std::sync::Arc;

use super::connect::{BaseQuad, base_quad};
use super::evaluator::Evaluator;
use super::faces;
use super::facevarying::{ValueSheet, value_sheet};
use super::hood::Channel;
use super::topology::Topology;
use super::warning::{MeshWarning, Warnings};
use crate::scene::{Class, FaceVaryingRule, PrimVar, Scheme, SubdivisionMesh, VarValues};

/// A subdivision surface, ready to be evaluated. Shared between threads; each makes its own evaluators.
#[derive(Debug, Clone)]
pub struct LimitSurface {
    pub(super) mesh: Arc<SubdivisionMesh>,
    pub(super) topology: Topology,
    /// Keys with as many points as the first.
    num_keys: usize,
    /// Face and corner of each base quad.
    quads: Vec<(u32, u32)>,
    pub(super) vars: Vec<Var>,
    /// Channels of the positions' tree: keys, then vertex variables.
    pub(super) num_channels: usize,
}

/// How a primitive variable is evaluated.
#[derive(Debug, Clone)]
pub(super) enum Var {
    /// Not at all: strings, and arrays of the wrong length.
    None,
    /// One value for the mesh.
    Constant,
    /// One value a face.
    Uniform,
    /// Bilinear between values at vertices.
    Varying,
    /// Like the position, from this channel of its tree on.
    Vertex(usize),
    /// Bilinear between values at face corners.
    FaceLinear,
    /// By rules of its own.
    FaceSmooth(Box<ValueSheet>),
}

impl LimitSurface {
    /// Makes the tables of `mesh`. What is wrong with it is said and left out.
    pub fn new(mesh: Arc<SubdivisionMesh>) -> (LimitSurface, Vec<MeshWarning>) {
        let mut warnings = Warnings::default();
        let num_vertices = mesh.points.first().len();
        let faces = faces::clean(&mesh, &mut warnings);
        let mut topology = Topology::connect(faces, num_vertices);
        topology.apply_tags(&mesh, &mut warnings);
        let num_keys = count_keys(&mesh, &mut warnings);
        let mut surface = LimitSurface {
            num_keys,
            quads: Vec::new(),
            vars: Vec::new(),
            num_channels: num_keys,
            topology,
            mesh: Arc::clone(&mesh),
        };
        surface.quads = surface.list_quads();
        for var in &mesh.vars {
            let var = surface.plan_var(var, &mut warnings);
            surface.vars.push(var);
        }
        (surface, warnings.finish())
    }

    /// The description that the surface was made from.
    pub fn mesh(&self) -> &SubdivisionMesh {
        &self.mesh
    }

    /// Number of keys that can be evaluated, at least 1; their times are the mesh's.
    pub fn num_keys(&self) -> usize {
        self.num_keys
    }

    /// Number of base quads; they are drawn in this order.
    pub fn num_quads(&self) -> usize {
        self.quads.len()
    }

    /// Number of edges of the mesh; inner edges of n-gons have ids from here on.
    pub fn num_mesh_edges(&self) -> usize {
        self.topology.edges.len()
    }

    /// Number of edge ids, inner ones included (not all of them are used).
    pub fn num_edge_ids(&self) -> usize {
        self.topology.edges.len() + self.topology.face.len()
    }

    /// A base quad's place in the mesh. `quad` below [`num_quads`](Self::num_quads).
    pub fn quad(&self, quad: u32) -> BaseQuad {
        let (face, corner) = self.quads[quad as usize];
        base_quad(&self.topology, face, corner, self.is_whole(face))
    }

    /// Begins to evaluate a base quad. `quad` below [`num_quads`](Self::num_quads).
    pub fn evaluator(&self, quad: u32) -> Evaluator<'_> {
        let (face, corner) = self.quads[quad as usize];
        Evaluator::new(self, face, corner)
    }

    /// Bytes of the tables (without the mesh itself).
    pub fn num_bytes(&self) -> usize {
        let sheets = self.vars.iter().map(|v| match v {
            Var::FaceSmooth(sheet) => sheet.topology.num_bytes() + 4 * sheet.source.len(),
            _ => 0,
        });
        self.topology.num_bytes() + 8 * self.quads.len() + sheets.sum::<usize>()
    }

    /// Whether the face is one base quad.
    pub(super) fn is_whole(&self, face: u32) -> bool {
        self.mesh.scheme != Scheme::Loop && self.topology.faces.vertices(face).len() == 4
    }

    /// Control values of the positions' tree.
    pub(super) fn channels(&self) -> Vec<Channel<'_>> {
        let keys = self.mesh.points.values[..self.num_keys].iter();
        let mut channels: Vec<_> = keys
            .map(|key| Channel { data: key.as_flattened(), stride: 3, offset: 0, width: 3, source: None })
            .collect();
        for (var, plan) in self.mesh.vars.iter().zip(&self.vars) {
            if let (VarValues::Floats(data), Var::Vertex(_)) = (&var.values, plan) {
                channels.extend(var_channels(data, var_width(var), None));
            }
        }
        channels
    }

    fn list_quads(&self) -> Vec<(u32, u32)> {
        let mut quads = Vec::new();
        for face in 0..self.topology.faces.len() as u32 {
            if self.topology.hidden[face as usize] {
                continue;
            }
            let n = if self.is_whole(face) { 1 } else { self.topology.faces.vertices(face).len() as u32 };
            quads.extend((0..n).map(|corner| (face, corner)));
        }
        quads
    }

    /// Checks a variable's length and decides how it is evaluated.
    fn plan_var(&mut self, var: &PrimVar, warnings: &mut Warnings) -> Var {
        let count = match var.class {
            Class::Constant => 1,
            Class::Uniform => self.mesh.face_vertex_counts.len(),
            Class::Varying | Class::Vertex => self.mesh.points.first().len(),
            Class::FaceVarying => self.mesh.indices.len(),
        };
        let (found, width) = match &var.values {
            VarValues::Floats(v) => (v.len(), var_width(var)),
            VarValues::Strings(v) => (v.len(), var.array_len as usize),
        };
        if found != count * width {
            let (name, expected) = (var.name.clone(), count * width);
            warnings.push(MeshWarning::VarLength { name, expected, found });
            return Var::None;
        }
        let VarValues::Floats(values) = &var.values else {
            return Var::None;
        };
        match (var.class, self.mesh.scheme) {
            (Class::Constant, _) => Var::Constant,
            (Class::Uniform, _) => Var::Uniform,
            (Class::Varying, _) | (Class::Vertex, Scheme::Bilinear) => Var::Varying,
            (Class::Vertex, _) => {
                let first = self.num_channels;
                self.num_channels += width.div_ceil(3);
                Var::Vertex(first)
            }
            (Class::FaceVarying, Scheme::Bilinear) => Var::FaceLinear,
            (Class::FaceVarying, _) if self.mesh.face_varying == FaceVaryingRule::Linear => Var::FaceLinear,
            (Class::FaceVarying, _) => {
                Var::FaceSmooth(Box::new(value_sheet(&self.topology, values, width, self.mesh.face_varying)))
            }
        }
    }
}

/// Floats a value.
pub(super) fn var_width(var: &PrimVar) -> usize {
    var.ty.num_floats() * var.array_len as usize
}

/// Channels of three floats that hold values of `width`.
pub(super) fn var_channels<'a>(
    data: &'a [f32],
    width: usize,
    source: Option<&'a [u32]>,
) -> impl Iterator<Item = Channel<'a>> {
    (0..width).step_by(3).map(move |offset| Channel {
        data,
        stride: width,
        offset,
        width: (width - offset).min(3),
        source,
    })
}

/// Keys up to the first that does not fit.
fn count_keys(mesh: &SubdivisionMesh, warnings: &mut Warnings) -> usize {
    let expected = mesh.points.first().len();
    match mesh.points.values.iter().position(|k| k.len() != expected) {
        None => mesh.points.values.len(),
        Some(key) => {
            let found = mesh.points.values[key].len();
            warnings.push(MeshWarning::KeyLength { key, expected, found });
            key
        }
    }
}
