//! Dice: a piece becomes a grid of vertices.
//!
//! In: `Piece` whose lattice is decided. Out: `Grid` (raster positions, depth) and the `ShadingPoints` of its
//! vertices. Points of the piece's sides come from the edges (through their owners), the others from the
//! patch: see [`lattice`](super::lattice). Source: Cook et al. 1987, section 3.

use std::sync::Arc;

use glam::Vec3;

use crate::geometry::RasterCamera;
use crate::math::Vec3s;
use crate::scene::{Between, Keyed, Primitive, Scene};
use crate::shading::{Inputs, PointVar, ShadingPoints};

use super::displace::{DisplaceContext, Displacer};
use super::grid::{Grid, GridKey, Look};
use super::lattice::Lattice;
use super::motion::{KeyTimes, placement, placements};
use super::piece::{Piece, PieceKind};
use super::primvar::{each_variable, has_variables, texture_coordinates};
use super::spare::{GridLists, Spare};
use super::split::SplitContext;
use super::workspace::Workspace;

/// What dicing needs to know of a primitive, the same for all its patches.
#[derive(Debug, Clone)]
pub struct PrimitiveInfo {
    /// Object to camera space at the time of shading.
    pub to_camera: glam::DMat4,
    /// Motion keys before and after the time of shading, and the part of the way between them.
    pub shading: Between,
    /// +1 where the shading normal is dPdu x dPdv in camera space, -1 where it is the opposite.
    pub normal_sign: f32,
    /// How micropolygons are drawn.
    pub look: Look,
    /// Displacement or bump mapping.
    pub displacement: Option<Displacer>,
}

impl PrimitiveInfo {
    /// Derives it from the primitive.
    pub fn new(
        scene: &Scene,
        camera: &RasterCamera,
        primitive: &Primitive,
        key_times: &[f32],
        shading_time: f32,
    ) -> Self {
        let moves = key_times.len() > 1;
        let time = if moves { shading_time } else { 0.0 };
        let to_camera = placement(scene, primitive, time).to_camera;
        let keys = Keyed { times: key_times.to_vec(), values: vec![(); key_times.len()] };
        let at_keys: Vec<_> =
            placements(scene, primitive, key_times).iter().map(|placement| placement.to_camera).collect();
        let attributes = &primitive.attributes;
        let turned = (to_camera.determinant() < 0.0) != attributes.reverse_orientation;
        let mirrored = camera.scale[0] * camera.scale[1] < 0.0;
        let look = Look {
            interpolation: attributes.shading_interpolation,
            sides: attributes.sides,
            // dPdu x dPdv towards the eye is a positive area in raster space (y down).
            front_is_positive: turned == mirrored,
            matte: attributes.matte,
        };
        let displacement = Displacer::new(primitive, &at_keys);
        let shading = keys.locate(f64::from(time));
        PrimitiveInfo { to_camera, shading, normal_sign: if turned { -1.0 } else { 1.0 }, look, displacement }
    }
}

impl PrimitiveInfo {
    /// Derives it from all primitives. A file may have one for each of its patches: those that follow each other with the
    /// same attributes, transformation and key times share it.
    pub fn of_all(
        scene: &Scene,
        camera: &RasterCamera,
        times: &KeyTimes,
        shading_time: f32,
    ) -> Vec<Arc<PrimitiveInfo>> {
        let mut infos: Vec<Arc<PrimitiveInfo>> = Vec::with_capacity(scene.primitives.len());
        for (ix, primitive) in scene.primitives.iter().enumerate() {
            let is_like = |before: usize| {
                let other = &scene.primitives[before];
                Arc::ptr_eq(&primitive.attributes, &other.attributes)
                    && primitive.to_world.is_shared_with(&other.to_world)
                    && times.of_primitive[before] == times.of_primitive[ix]
            };
            let info = match ix.checked_sub(1).filter(|&before| is_like(before)) {
                Some(before) => Arc::clone(&infos[before]),
                None => {
                    let times = times.of(ix as u32);
                    Arc::new(PrimitiveInfo::new(scene, camera, primitive, times, shading_time))
                }
            };
            infos.push(info);
        }
        infos
    }
}

/// A grid that is diced and not shaded yet.
#[derive(Debug)]
pub struct Diced {
    /// Where its vertices are.
    pub grid: Grid,
    /// What shaders see of them; lists that are [`Implied`] are empty.
    pub points: ShadingPoints,
    /// The rest of what shaders see.
    pub implied: Implied,
    /// Lists that are left for its shading.
    pub left: GridLists,
}

/// What shaders see of vertices where [`ShadingPoints`] has no list of it: most grids need no more of these lists than one
/// to be shaded with, and many grids live at a time. Ng without a list is N.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Implied {
    /// Colour of all vertices.
    pub cs: Vec3,
    /// Opacity of all vertices.
    pub os: Vec3,
    /// Whether I is the position; else it is along z.
    pub from_eye: bool,
}

/// Dices `piece`, whose kind is `PieceKind::Lattice`.
pub fn dice(context: &DisplaceContext, piece: &Piece) -> Diced {
    let frame = context.frame;
    let patch = &frame.patches.patches[piece.patch as usize];
    let primitive = &context.scene.primitives[patch.primitive as usize];
    let info = &context.infos[patch.primitive as usize];
    let inputs = primitive.attributes.surface.traits().inputs;
    let mut workspace = context.workspace.borrow_mut();
    let wanted = workspace.set(context, piece, inputs, info.displacement.is_some() && inputs.n);
    let (mut grid, mut lists) = empty_grid(frame, piece, info.look, &mut workspace.spare);
    let [from, to] = info.shading.keys;
    for key in 0..frame.patches.num_keys(piece.patch) {
        let is_shaded = key == from || key == to && info.shading.part > 0.0;
        workspace.place(context, [piece.patch, key as u32], wanted, is_shaded);
        workspace.put_on_raster(frame, &mut grid);
        if is_shaded {
            let before = (key != from).then_some(info.shading);
            workspace.note_shaded(context, piece.patch, wanted, before);
        }
    }
    workspace.close(frame, &mut grid);
    let mut points = shading_points(context, piece.patch, &workspace, inputs, &mut lists);
    primitive_variables(frame, piece.patch, &mut points, &workspace.lattice, primitive, info);
    workspace.displaced_normals(context, piece.patch, [&mut points.n, &mut points.ng]);
    let attributes = &primitive.attributes;
    let [cs, os] = [attributes.color, attributes.opacity].map(Vec3::from_array);
    Diced { grid, points, implied: Implied { cs, os, from_eye: frame.camera.perspective }, left: lists }
}

/// A grid without vertices yet, and lists for what shaders see of it.
fn empty_grid(frame: &SplitContext, piece: &Piece, look: Look, spare: &mut Spare) -> (Grid, GridLists) {
    let PieceKind::Lattice { i, j, .. } = piece.kind else {
        unreachable!("only pieces with a lattice are diced");
    };
    let patch = &frame.patches.patches[piece.patch as usize];
    let key =
        GridKey { primitive: patch.primitive, patch: piece.patch, path: piece.path, block: [i[0], j[0]] };
    let [m, n] = [i, j].map(|[from, to]| u32::from(to - from));
    let num_vertices = (m as usize + 1) * (n as usize + 1);
    let room = num_vertices * frame.patches.num_keys(piece.patch);
    let mut lists = spare.take(room);
    let mut grid = Grid { m, n, motion: patch.motion, ..Grid::empty(key, look, 0) };
    std::mem::swap(&mut grid.on_raster, &mut lists.on_raster);
    std::mem::swap(&mut grid.depth, &mut lists.depth);
    grid.on_raster.x.reserve_exact(room);
    grid.on_raster.y.reserve_exact(room);
    grid.depth.reserve_exact(room);
    if frame.camera.lens.is_some() {
        grid.on_raster.coc.reserve_exact(room);
    }
    (grid, lists)
}

/// What shaders see of a grid's vertices, with the normals of the surface before it is displaced; what `inputs` does not
/// ask for stays empty.
fn shading_points(
    context: &DisplaceContext,
    patch: u32,
    workspace: &Workspace,
    inputs: Inputs,
    lists: &mut GridLists,
) -> ShadingPoints {
    let (lattice, shaded) = (&workspace.lattice, &workspace.shaded);
    let vertices = 0..lattice.num_vertices();
    let copy = |all: &Vec3s| all.copied(vertices.clone());
    let mut points = ShadingPoints::default();
    std::mem::swap(&mut points.p, &mut lists.p);
    points.p.assign(&shaded.vertices, vertices.clone());
    if inputs.n {
        std::mem::swap(&mut points.n, &mut lists.n);
        points.n.assign(&shaded.points.normal, vertices.clone());
    }
    let [u0, u1, v0, v1] = context.frame.patches.patches[patch as usize].params;
    if inputs.derivatives {
        (points.dpdu, points.dpdv) = (copy(&shaded.points.at.du), copy(&shaded.points.at.dv));
        points.dpdu.each(|c| c / (u1 - u0));
        points.dpdv.each(|c| c / (v1 - v0));
    }
    if inputs.uv {
        let (u, v): (Vec<f32>, Vec<f32>) =
            lattice.vertex_uv().into_iter().map(|[u, v]| (u0 + (u1 - u0) * u, v0 + (v1 - v0) * v)).unzip();
        (points.u, points.v) = (u, v);
        steps(&mut points, lattice.columns);
    }
    points
}

/// Texture coordinates and the primitive's variables.
fn primitive_variables(
    context: &SplitContext,
    patch_ix: u32,
    points: &mut ShadingPoints,
    lattice: &Lattice,
    primitive: &Primitive,
    info: &PrimitiveInfo,
) {
    let attributes = &primitive.attributes;
    let reads_st = attributes.surface.traits().inputs.st;
    if !reads_st && !has_variables(primitive) {
        return;
    }
    let uv = lattice.vertex_uv();
    if reads_st {
        (points.s, points.t) = texture_coordinates(context, patch_ix, &uv, primitive, info);
    }
    each_variable(
        context,
        patch_ix,
        &uv,
        primitive,
        info,
        |_| true,
        |name, num_floats, floats| {
            assign(points, name, num_floats, floats);
        },
    );
}

/// Puts a variable, `num_floats` floats a vertex, where shaders look for it.
fn assign(points: &mut ShadingPoints, name: &str, num_floats: usize, floats: Vec<f32>) {
    let component = |c: usize| floats.iter().skip(c).step_by(num_floats).copied().collect::<Vec<f32>>();
    let three = || Vec3s::from_axes([&component(0), &component(1), &component(2)]);
    match (name, num_floats) {
        ("Cs", 3) => points.cs = three(),
        ("Os", 3) => points.os = three(),
        ("s" | "t", 1) | ("st", 2) => {} // Texture coordinates have a rule of their own.
        ("N", 3) => points.ng = std::mem::replace(&mut points.n, three()),
        _ => points.vars.push(PointVar { name: name.into(), num_floats, values: floats }),
    }
}

/// Steps of u and v between neighbouring vertices.
fn steps(points: &mut ShadingPoints, width: usize) {
    let len = points.u.len();
    let step = |values: &[f32], ix: usize, next: bool, by: usize| {
        let other = if next { ix + by } else { ix - by };
        (values[other] - values[ix]).abs()
    };
    points.du = (0..len).map(|ix| step(&points.u, ix, ix % width + 1 < width, 1)).collect();
    points.dv = (0..len).map(|ix| step(&points.v, ix, ix + width < len, width)).collect();
}
