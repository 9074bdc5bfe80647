//! Dice: a piece becomes a grid of vertices.
//!
//! In: `Piece` whose lattice is decided. Out: `Grid` (raster positions, depth) and the `ShadingPoints` of its
//! vertices. Points of the piece's sides come from the edges (through their owners), the others from the
//! patch. A side with fewer segments than the lattice has its vertices used more than once, so that the grid's
//! border is exactly the edge's polyline: some micropolygons collapse to triangles or to nothing, and no
//! T-junction opens. Source: Cook et al. 1987, section 3.

use glam::Vec3;

use crate::geometry::RasterCamera;
use crate::math::Vec3s;
use crate::scene::{Geometry, Primitive, Scene};
use crate::shading::{PointVar, ShadingPoints};

use super::grid::{Grid, GridKey, Look, SlowVertices};
use super::patch::unit_normal;
use super::primvar::{PatchVar, to_space};
use super::split::{Piece, PieceKind, Side, SplitContext, quad_uv};

/// What dicing needs to know of a primitive, the same for all its patches.
#[derive(Debug, Clone)]
pub struct PrimitiveInfo {
    /// Object to camera space.
    pub to_camera: glam::DMat4,
    /// +1 where the shading normal is dPdu x dPdv in camera space, -1 where it is the opposite.
    pub normal_sign: f32,
    /// How micropolygons are drawn.
    pub look: Look,
}

impl PrimitiveInfo {
    /// Derives it from the primitive.
    pub fn new(scene: &Scene, camera: &RasterCamera, primitive: &Primitive) -> Self {
        let to_camera = *scene.camera.world_to_camera.first() * *primitive.to_world.first();
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
        PrimitiveInfo { to_camera, normal_sign: if turned { -1.0 } else { 1.0 }, look }
    }
}

/// A grid that is diced and not shaded yet.
#[derive(Debug)]
pub struct Diced {
    /// Where its vertices are.
    pub grid: Grid,
    /// What shaders see of them.
    pub points: ShadingPoints,
}

/// Dices `piece`, whose kind is `PieceKind::Lattice`.
pub fn dice(context: &SplitContext, piece: &Piece, primitive: &Primitive, info: &PrimitiveInfo) -> Diced {
    let PieceKind::Lattice { m, n, i, j } = piece.kind else {
        unreachable!("only pieces with a lattice are diced");
    };
    let patch = &context.patches.patches[piece.patch as usize];
    let (columns, rows) = (u32::from(i[1] - i[0]), u32::from(j[1] - j[0]));
    let num_vertices = (columns as usize + 1) * (rows as usize + 1);
    let vertices = lattice_vertices(context, piece, [m, n], i, j);
    let mut grid = Grid {
        key: GridKey {
            primitive: patch.primitive,
            patch: piece.patch,
            path: piece.path,
            block: [i[0], j[0]],
        },
        m: columns,
        n: rows,
        keys: context.patches.num_keys as u32,
        x: Vec::with_capacity(num_vertices * context.patches.num_keys),
        y: Vec::new(),
        depth: Vec::new(),
        coc: Vec::new(),
        slow: None,
        color: Vec3s::default(),
        opacity: Vec3s::default(),
        look: info.look,
        raster: [i32::MAX, i32::MIN, i32::MAX, i32::MIN],
    };
    let uv: Vec<[f32; 2]> = vertices.iter().map(|v| v.uv).collect();
    let mut points = shading_points(context, piece.patch, &uv, info);
    for key in 0..context.patches.num_keys {
        let placed: Vec<Vec3> = vertices
            .iter()
            .map(|vertex| match vertex.border {
                Some(point) => context.position(piece.patch, point, key),
                None => context.surfaces.evaluate(piece.patch, key, vertex.uv).p,
            })
            .collect();
        place(&mut grid, context.camera, &placed, key);
        if key == 0 {
            points.p = placed.iter().fold(Vec3s::default(), |mut all, &p| {
                all.push(p);
                all
            });
            points.i = placed.iter().fold(Vec3s::default(), |mut all, &p| {
                all.push(context.camera.incident(p));
                all
            });
        }
    }
    primitive_variables(context, piece.patch, &mut points, &uv, primitive, info);
    steps(&mut points, columns as usize);
    Diced { grid, points }
}

struct LatticeVertex {
    uv: [f32; 2],
    /// Where it lies on a side of the quad.
    border: Option<super::split::PointRef>,
}

fn lattice_vertices(
    context: &SplitContext,
    piece: &Piece,
    [m, n]: [u16; 2],
    i: [u16; 2],
    j: [u16; 2],
) -> Vec<LatticeVertex> {
    let on_side = |side: usize, line: u16, lines: u16| {
        let side: &Side = &piece.sides[side];
        // Vertex round(line * segments / lines): every edge vertex is hit, in order, some of them twice.
        let (line, lines, segments) = (u64::from(line), u64::from(lines), u64::from(side.segments()));
        let step = ((2 * line * segments + lines) / (2 * lines)) as u32;
        let (point, uv) = context.side_vertex(piece.patch, side, step);
        LatticeVertex { uv, border: Some(point) }
    };
    let mut vertices = Vec::new();
    for b in j[0]..=j[1] {
        for a in i[0]..=i[1] {
            vertices.push(if b == 0 {
                on_side(0, a, m)
            } else if b == n {
                on_side(2, a, m)
            } else if a == 0 {
                on_side(3, b, n)
            } else if a == m {
                on_side(1, b, n)
            } else {
                let uv = quad_uv(&piece.uv, f32::from(a) / f32::from(m), f32::from(b) / f32::from(n));
                LatticeVertex { uv, border: None }
            });
        }
    }
    vertices
}

/// Puts one key's vertices on the raster.
fn place(grid: &mut Grid, camera: &RasterCamera, placed: &[Vec3], key: usize) {
    for (ix, &p) in placed.iter().enumerate() {
        let fixed = camera.fixed(p);
        if fixed.is_none() {
            let slow = grid
                .slow
                .get_or_insert_with(|| SlowVertices { p: Vec::new(), is_slow: vec![false; placed.len()] });
            slow.is_slow[ix] = true;
        }
        let [x, y] = fixed.unwrap_or([0, 0]);
        if fixed.is_some() {
            let r = &mut grid.raster;
            *r = [r[0].min(x), r[1].max(x), r[2].min(y), r[3].max(y)];
        }
        grid.x.push(x);
        grid.y.push(y);
        grid.depth.push(p.z);
    }
    if let Some(slow) = &mut grid.slow {
        // A vertex may turn slow at a later key: positions of all keys are kept then.
        debug_assert_eq!(key, 0, "motion keys are placed together");
        slow.p.extend_from_slice(placed);
    }
}

/// Normals, derivatives and parameters.
fn shading_points(
    context: &SplitContext,
    patch_ix: u32,
    uv: &[[f32; 2]],
    info: &PrimitiveInfo,
) -> ShadingPoints {
    let [u0, u1, v0, v1] = context.patches.patches[patch_ix as usize].params;
    let mut points = ShadingPoints::default();
    for &[u, v] in uv {
        let at = context.surfaces.evaluate(patch_ix, 0, [u, v]);
        points.dpdu.push(at.du / (u1 - u0));
        points.dpdv.push(at.dv / (v1 - v0));
        let normal = unit_normal(&at).unwrap_or_else(|| context.surfaces.normal(patch_ix, [u, v]));
        points.ng.push(normal * info.normal_sign);
        points.u.push(u0 + (u1 - u0) * u);
        points.v.push(v0 + (v1 - v0) * v);
    }
    points.n = points.ng.clone();
    points
}

/// Colour, opacity, texture coordinates and the rest of the primitive's variables.
fn primitive_variables(
    context: &SplitContext,
    patch_ix: u32,
    points: &mut ShadingPoints,
    uv: &[[f32; 2]],
    primitive: &Primitive,
    info: &PrimitiveInfo,
) {
    let attributes = &primitive.attributes;
    points.cs = Vec3s::splat(Vec3::from_array(attributes.color), uv.len());
    points.os = Vec3s::splat(Vec3::from_array(attributes.opacity), uv.len());
    let [a, b, c, d] = attributes.texture_coordinates;
    let texture = PatchVar::corners([a, b, c, d].map(|st| st.to_vec()));
    // Texture coordinates span the primitive, so they are read at its own (u, v).
    let whole: Vec<[f32; 2]> = points.u.iter().zip(&points.v).map(|(&u, &v)| [u, v]).collect();
    points.s = whole.iter().map(|&at| texture.evaluate(0, at)).collect();
    points.t = whole.iter().map(|&at| texture.evaluate(1, at)).collect();
    match &primitive.geometry {
        Geometry::Patches(mesh) => {
            let cell = context.patches.patches[patch_ix as usize].cell;
            for var in &mesh.vars {
                let Some(values) = PatchVar::new(mesh, var, cell, &info.to_camera) else { continue };
                let all = uv.iter().flat_map(|&at| (0..values.num_floats).map(move |c| (c, at)));
                let floats = all.map(|(c, at)| values.evaluate(c, at)).collect();
                assign(points, &var.name, values.num_floats, floats);
            }
        }
        Geometry::Subdivision(mesh) => {
            for (ix, var) in mesh.vars.iter().enumerate() {
                let num_floats = var.ty.num_floats() * var.array_len as usize;
                let mut floats = vec![0.0; uv.len() * num_floats];
                let mut values = uv.iter().zip(floats.chunks_exact_mut(num_floats.max(1)));
                if num_floats > 0
                    && values.all(|(&at, out)| context.surfaces.limit_var(patch_ix, ix, at, out))
                {
                    let floats = to_space(&floats, var.ty, &info.to_camera);
                    assign(points, &var.name, num_floats, floats);
                }
            }
        }
    }
}

/// Puts a variable, `num_floats` floats a vertex, where shaders look for it.
fn assign(points: &mut ShadingPoints, name: &str, num_floats: usize, floats: Vec<f32>) {
    let component = |c: usize| floats.iter().skip(c).step_by(num_floats).copied().collect::<Vec<f32>>();
    let three = || Vec3s { x: component(0), y: component(1), z: component(2) };
    match (name, num_floats) {
        ("Cs", 3) => points.cs = three(),
        ("Os", 3) => points.os = three(),
        ("s", 1) => points.s = floats,
        ("t", 1) => points.t = floats,
        ("st", 2) => (points.s, points.t) = (component(0), component(1)),
        ("N", 3) => points.n = three(),
        _ => points.vars.push(PointVar { name: name.into(), num_floats, values: floats }),
    }
}

/// Steps of u and v between neighbouring vertices.
fn steps(points: &mut ShadingPoints, columns: usize) {
    let width = columns + 1;
    let len = points.u.len();
    let step = |values: &[f32], ix: usize, next: bool, by: usize| {
        let other = if next { ix + by } else { ix - by };
        (values[other] - values[ix]).abs()
    };
    points.du = (0..len).map(|ix| step(&points.u, ix, ix % width + 1 < width, 1)).collect();
    points.dv = (0..len).map(|ix| step(&points.v, ix, ix + width < len, width)).collect();
}
