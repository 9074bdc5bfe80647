//! SubdivisionMesh and HierarchicalSubdivisionMesh: faces, points and variables to a control mesh.
//!
//! The counts of the statement's arrays are checked here, and each fault names its place. Indices are not: the
//! limit surface finds those that name nothing and draws the rest. Tags are read by `mesh_tags`. As the standard
//! has it, border faces are not drawn without `interpolateboundary`.

use std::sync::Arc;

use olema::scene::{BoundaryRule, Class, Geometry, Scheme, SubdivisionMesh, VarType};

use super::super::args::Args;
use super::super::fault::Fault;
use super::super::params;
use super::super::state::Sizes;
use super::surfaces::vars_bytes;
use super::undrawn::{expect_len, sum};
use super::{Call, Interp, mesh_tags};

impl Interp {
    /// The geometry of a subdivision mesh.
    pub(super) fn subdivision(&mut self, call: &Call<'_>) -> Result<Geometry, Fault> {
        let args = call.args;
        let scheme = scheme(args)?;
        let corners = sum(args, 1, 0)?;
        expect_len(args, 2, args.ints(2).len(), corners)?;
        let points = points(call)?;
        let (counts, indices) = (args.ints(1).to_vec(), args.ints(2).to_vec());
        let sizes = Sizes {
            uniform: counts.len(),
            varying: points.len(),
            vertex: points.len(),
            facevarying: corners,
        };
        let mut mesh = SubdivisionMesh::new(scheme, counts, indices, points);
        // A bilinear surface has its borders where its faces have them.
        mesh.boundary = match scheme {
            Scheme::Bilinear => BoundaryRule::EdgeAndCorner,
            _ => BoundaryRule::None,
        };
        mesh_tags::apply(args, &mut mesh, &mut self.said)?;
        mesh.vars = params::prim_vars(args, &sizes, &mut self.said);
        self.hold(call.site.pos, mesh_bytes(&mesh))?;
        Ok(Geometry::Subdivision(Arc::new(mesh)))
    }
}

fn scheme(args: &Args) -> Result<Scheme, Fault> {
    match args.text(0).unwrap_or_default() {
        "catmull-clark" | "catmull_clark" => Ok(Scheme::CatmullClark),
        "loop" => Ok(Scheme::Loop),
        "bilinear" => Ok(Scheme::Bilinear),
        other => {
            let message = format!("expected \"catmull-clark\", \"loop\" or \"bilinear\", found \"{other}\"");
            Err(Fault::error(args.pos(0), message))
        }
    }
}

/// The control points. How many there are, "P" tells: a file may hold points that no face uses.
fn points(call: &Call<'_>) -> Result<Vec<[f32; 3]>, Fault> {
    let args = call.args;
    let Some(param) = args.find("P") else {
        return Err(Fault::error(call.site.pos, "expected control points: \"P\""));
    };
    let decl = &param.decl;
    if decl.ty != VarType::Point || decl.width() != 3 || decl.class != Class::Vertex {
        let found = decl.describe();
        return Err(Fault::error(param.pos, format!("\"P\" is \"{found}\": expected \"vertex point\"")));
    }
    let (points, rest) = args.param_floats(param).as_chunks::<3>();
    if !rest.is_empty() {
        let found = args.param_len(param);
        let message = format!("\"P\" has {found} numbers: expected 3 a point");
        return Err(Fault::error(param.pos, message));
    }
    Ok(points.to_vec())
}

fn mesh_bytes(mesh: &SubdivisionMesh) -> u64 {
    let creases = mesh
        .creases
        .iter()
        .map(|c| size_of_val(c) + size_of_val(c.vertices.as_slice()) + size_of_val(c.sharpness.as_slice()));
    let bytes = size_of_val(mesh)
        + size_of_val(mesh.face_vertex_counts.as_slice())
        + size_of_val(mesh.indices.as_slice())
        + size_of_val(mesh.points.first().as_slice())
        + creases.sum::<usize>()
        + size_of_val(mesh.corners.as_slice())
        + size_of_val(mesh.holes.as_slice())
        + vars_bytes(&mesh.vars);
    bytes as u64
}
