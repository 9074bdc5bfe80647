//! Surfaces, and Patch and PatchMesh among them: control points and variables to geometry.

use std::sync::Arc;

use glam::DMat4;
use olema::scene::{
    Attributes, Class, Geometry, Keyed, Origin, PatchKind, PatchMesh, Points, PrimVar, Primitive, VarType,
    VarValues,
};

use olema::shading::DisplacementShader;

use super::super::args::{Args, ParamItem};
use super::super::basis::linear_values;
use super::super::fault::Fault;
use super::super::params;
use super::super::state::{Site, Sizes};
use super::super::statements::Id;
use super::{Call, Interp};

impl Interp {
    /// A surface outside a motion block.
    pub(super) fn geometry(&mut self, call: &Call<'_>) -> Result<(), Fault> {
        if !self.attrs.is_detail_drawn() {
            return Ok(());
        }
        let bases = self.attrs.basis;
        let kept = call.geometries.and_then(|g| g.get()).filter(|g| g.0 == bases);
        let geometry = match kept {
            Some((_, geometry)) => geometry.clone(),
            None => self.geometry_of(call)?,
        };
        if let Some(cell) = call.geometries {
            cell.get_or_init(|| (bases, geometry.clone()));
        }
        self.emit(geometry, call.site)
    }

    /// Adds a primitive to the world.
    pub(super) fn emit(&mut self, geometry: Geometry, site: &Site) -> Result<(), Fault> {
        if !self.attrs.is_detail_drawn() {
            return Ok(());
        }
        if self.attrs.lights_changed {
            self.hold(site.pos, 4 * self.attrs.lights.len() as u64)?;
            let attrs = Arc::make_mut(&mut self.attrs);
            attrs.look.lights = Arc::from(attrs.lights.as_slice());
            attrs.lights_changed = false;
        }
        let attributes = self.look(site)?;
        // Factors that move are shared, and were charged where they were made.
        let factors = size_of_val(self.ctm.factors()) + size_of::<Keyed<DMat4>>() + size_of::<DMat4>();
        self.hold(site.pos, (size_of::<Primitive>() + factors) as u64)?;
        if let Some(world) = &mut self.world {
            let origin = Origin { file: Arc::clone(&site.file), line: site.pos.line };
            let to_world = self.ctm.clone();
            world.scene.primitives.push(Primitive { geometry, to_world, attributes, origin });
        }
        Ok(())
    }

    /// What a primitive that stands here carries: the same as the last one, where nothing was set since then.
    fn look(&mut self, site: &Site) -> Result<Arc<Attributes>, Fault> {
        let (displacement, displacement_bound) = self.displaced();
        if let Some((state, look)) = &self.last_look
            && std::ptr::eq(state.as_ptr(), Arc::as_ptr(&self.attrs))
            && look.displacement_bound == displacement_bound
            && is_same_shader(look.displacement.as_ref(), displacement.as_ref())
        {
            return Ok(Arc::clone(look));
        }
        let reverse_orientation = self.attrs.inside;
        let look =
            Attributes { reverse_orientation, displacement, displacement_bound, ..self.attrs.look.clone() };
        self.hold(site.pos, (size_of::<Attributes>() + look.name.len()) as u64)?;
        let look = Arc::new(look);
        self.last_look = Some((Arc::downgrade(&self.attrs), Arc::clone(&look)));
        Ok(look)
    }

    /// The geometry of a surface.
    pub(super) fn geometry_of(&mut self, call: &Call<'_>) -> Result<Geometry, Fault> {
        match call.statement.id {
            Id::SubdivisionMesh | Id::HierarchicalSubdivisionMesh => self.subdivision(call),
            _ => self.patches(call),
        }
    }

    /// The geometry of Patch or PatchMesh.
    fn patches(&mut self, call: &Call<'_>) -> Result<Geometry, Fault> {
        let mut mesh = self.sheet(call)?;
        let counts = mesh.num_patches().zip(mesh.num_varying());
        let Some(([pu, pv], [cu, cv])) = counts.filter(|(p, _)| p[0] > 0 && p[1] > 0) else {
            return Err(Fault::error(call.site.pos, wrong_counts(&mesh)));
        };
        let uniform = pu.saturating_mul(pv);
        let vertex = mesh.nu.saturating_mul(mesh.nv);
        let sizes =
            Sizes { uniform, varying: cu.saturating_mul(cv), vertex, facevarying: uniform.saturating_mul(4) };
        mesh.points = Keyed::still(control_points(call, &mesh, [pu, pv])?);
        mesh.vars = params::prim_vars(call.args, &sizes, &mut self.said);
        self.hold(call.site.pos, mesh_bytes(&mesh))?;
        Ok(Geometry::Patches(Arc::new(mesh)))
    }

    /// A sheet of the right shape, still without points.
    fn sheet(&mut self, call: &Call<'_>) -> Result<PatchMesh, Fault> {
        let args = call.args;
        let [u, v] = self.attrs.basis;
        let (kind, side) = match args.text(0).unwrap_or_default() {
            "bilinear" => (PatchKind::Bilinear, 2),
            "bicubic" => (PatchKind::Bicubic { u, v }, 4),
            other => {
                let message = format!("expected \"bilinear\" or \"bicubic\", found \"{other}\"");
                return Err(Fault::error(args.pos(0), message));
            }
        };
        let kind = match &self.last_kind {
            Some(last) if **last == kind => Arc::clone(last),
            _ => Arc::new(kind),
        };
        self.last_kind = Some(Arc::clone(&kind));
        let (points, vars) = (Keyed::still(Points::P(Vec::new())), Vec::new());
        let mut mesh = PatchMesh { kind, nu: side, nv: side, wrap_u: false, wrap_v: false, points, vars };
        if call.statement.id == Id::PatchMesh {
            (mesh.nu, mesh.wrap_u) = (count(args, 1)?, wraps(args, 2)?);
            (mesh.nv, mesh.wrap_v) = (count(args, 3)?, wraps(args, 4)?);
        }
        Ok(mesh)
    }
}

fn is_same_shader(
    one: Option<&Arc<dyn DisplacementShader>>,
    other: Option<&Arc<dyn DisplacementShader>>,
) -> bool {
    match (one, other) {
        (Some(one), Some(other)) => Arc::ptr_eq(one, other),
        (one, other) => one.is_none() && other.is_none(),
    }
}

fn count(args: &Args, ix: usize) -> Result<usize, Fault> {
    let found = args.int(ix);
    usize::try_from(found).map_err(|_| Fault::error(args.pos(ix), format!("expected a count, found {found}")))
}

fn wraps(args: &Args, ix: usize) -> Result<bool, Fault> {
    match args.text(ix).unwrap_or_default() {
        "periodic" => Ok(true),
        "nonperiodic" => Ok(false),
        other => {
            let message = format!("expected \"periodic\" or \"nonperiodic\", found \"{other}\"");
            Err(Fault::error(args.pos(ix), message))
        }
    }
}

fn wrong_counts(mesh: &PatchMesh) -> String {
    let (nu, nv) = (mesh.nu, mesh.nv);
    match *mesh.kind {
        PatchKind::Bilinear => format!("{nu} x {nv} control points: expected at least 2 each way"),
        PatchKind::Bicubic { u, v } => {
            let along = |step: u32, wrap: bool| match wrap {
                true => format!("a multiple of {step}"),
                false => format!("4 and then {step} for each further patch"),
            };
            let (u, v) = (along(u.step, mesh.wrap_u), along(v.step, mesh.wrap_v));
            format!("{nu} x {nv} control points: expected along u {u}, along v {v}")
        }
    }
}

/// The control points, from "P", "Pw" or "Pz".
fn control_points(call: &Call<'_>, mesh: &PatchMesh, patches: [usize; 2]) -> Result<Points, Fault> {
    let args = call.args;
    let mut positions = args.params.iter().filter(|p| matches!(args.param_name(p), "P" | "Pw" | "Pz"));
    let Some(param) = positions.next_back() else {
        return Err(Fault::error(call.site.pos, "expected control points: \"P\", \"Pw\" or \"Pz\""));
    };
    let name = args.param_name(param);
    let (ty, width) = match name {
        "P" => (VarType::Point, 3),
        "Pw" => (VarType::HPoint, 4),
        _ => (VarType::Float, 1),
    };
    if param.decl.ty != ty || param.decl.width() != width || param.decl.class != Class::Vertex {
        let found = param.decl.describe();
        let expected = if ty == VarType::Point {
            "vertex point"
        } else if width == 4 {
            "vertex hpoint"
        } else {
            "vertex float"
        };
        return Err(Fault::error(param.pos, format!("\"{name}\" is \"{found}\": expected \"{expected}\"")));
    }
    let expected = mesh.nu.saturating_mul(mesh.nv).saturating_mul(width);
    let values = args.param_floats(param);
    if values.len() != expected {
        let (found, nu, nv) = (values.len(), mesh.nu, mesh.nv);
        let message = format!("\"{name}\" has {found} numbers: expected {expected} ({nu} x {nv} points)");
        return Err(Fault::error(param.pos, message));
    }
    match name {
        "P" => Ok(Points::P(values.as_chunks().0.to_vec())),
        "Pw" if values.as_chunks::<4>().0.iter().any(|p| p[3] <= 0.0) => {
            Err(Fault::error(param.pos, "\"Pw\" has a weight that is not above 0: expected weights above 0"))
        }
        "Pw" => Ok(Points::Pw(values.as_chunks().0.to_vec())),
        _ => height_field(param, values, mesh, patches),
    }
}

/// Heights over the unit square, so that x = u and y = v.
fn height_field(
    param: &ParamItem,
    heights: &[f32],
    mesh: &PatchMesh,
    [pu, pv]: [usize; 2],
) -> Result<Points, Fault> {
    let (basis_u, basis_v) = match &*mesh.kind {
        PatchKind::Bilinear => (None, None),
        PatchKind::Bicubic { u, v } => (Some(u), Some(v)),
    };
    let x = linear_values(basis_u, mesh.nu, pu);
    let y = linear_values(basis_v, mesh.nv, pv);
    let Some((x, y)) = x.zip(y) else {
        return Err(Fault::error(param.pos, "\"Pz\" in a singular basis: expected one that can be inverted"));
    };
    let point = |(ix, z): (usize, &f32)| [x[ix % mesh.nu] as f32, y[ix / mesh.nu] as f32, *z];
    Ok(Points::P(heights.iter().enumerate().map(point).collect()))
}

fn mesh_bytes(mesh: &PatchMesh) -> u64 {
    let points = match mesh.points.first() {
        Points::P(p) => size_of_val(p.as_slice()),
        Points::Pw(p) => size_of_val(p.as_slice()),
    };
    (size_of::<PatchMesh>() + points + vars_bytes(&mesh.vars)) as u64
}

/// Bytes that primitive variables hold.
pub(super) fn vars_bytes(vars: &[PrimVar]) -> usize {
    let bytes = vars.iter().map(|v| {
        let values = match &v.values {
            VarValues::Floats(f) => size_of_val(&f[..]),
            VarValues::Strings(s) => s.iter().map(|s| s.len() + size_of::<String>()).sum(),
        };
        values + v.name.len() + size_of_val(v)
    });
    bytes.sum()
}
