//! Dice: a piece becomes a grid of vertices.
//!
//! In: `Piece` whose lattice is decided. Out: `Grid` (raster positions, depth) and the `ShadingPoints` of its
//! vertices. Points of the piece's sides come from the edges (through their owners), the others from the
//! patch. A side with fewer segments than the lattice has its vertices used more than once, so that the grid's
//! border is exactly the edge's polyline: some micropolygons collapse to triangles or to nothing, and no
//! T-junction opens. Source: Cook et al. 1987, section 3.

use glam::Vec3;

use crate::geometry::{RasterCamera, SurfacePoint};
use crate::math::Vec3s;
use crate::scene::{Between, Keyed, Primitive, Scene};
use crate::shading::{PointVar, ShadingPoints};

use super::displace::{DisplaceContext, Displacer, Query};
use super::grid::{Grid, GridKey, Look};
use super::motion::{placement, placements};
use super::patch::unit_normal;
use super::piece::{Piece, PieceKind, Sabotage, Side, quad_uv};
use super::primvar::{each_variable, texture_coordinates};
use super::split::SplitContext;

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

/// A grid that is diced and not shaded yet.
#[derive(Debug)]
pub struct Diced {
    /// Where its vertices are.
    pub grid: Grid,
    /// What shaders see of them.
    pub points: ShadingPoints,
}

/// Dices `piece`, whose kind is `PieceKind::Lattice`.
pub fn dice(context: &DisplaceContext, piece: &Piece) -> Diced {
    let DisplaceContext { frame, scene, infos, .. } = *context;
    let PieceKind::Lattice { m, n, i, j } = piece.kind else {
        unreachable!("only pieces with a lattice are diced");
    };
    let patch = &frame.patches.patches[piece.patch as usize];
    let primitive = &scene.primitives[patch.primitive as usize];
    let info = &infos[patch.primitive as usize];
    let columns = u32::from(i[1] - i[0]);
    let vertices = lattice_vertices(frame, piece, [m, n], i, j);
    let key =
        GridKey { primitive: patch.primitive, patch: piece.patch, path: piece.path, block: [i[0], j[0]] };
    let mut grid = Grid {
        m: columns,
        n: u32::from(j[1] - j[0]),
        motion: patch.motion,
        ..Grid::empty(key, info.look, vertices.len() * frame.patches.num_keys(piece.patch))
    };
    let uv: Vec<[f32; 2]> = vertices.iter().map(|v| v.uv).collect();
    let [from, to] = info.shading.keys;
    let mut ring: Option<Ring> = None;
    let mut shaded_at = Vec::new();
    for key in 0..frame.patches.num_keys(piece.patch) {
        let is_shaded = key == from || key == to && info.shading.part > 0.0;
        let of_key = info
            .displacement
            .as_ref()
            .filter(|_| is_shaded)
            .map(|displacer| (displacer.is_bump, Ring::new(context, piece, key)));
        // A bump shader's ring is where the surface would be, not where it is.
        let known = of_key.as_ref().filter(|(is_bump, _)| !is_bump).map(|(_, ring)| ring);
        let placed = vertex_positions(context, piece.patch, &vertices, key, known);
        place(&mut grid, frame.camera, &placed);
        if is_shaded {
            shaded_at = blend(shaded_at, placed, info.shading.part as f32);
        }
        if let Some((_, of_key)) = of_key {
            ring = Some(match ring {
                None => of_key,
                Some(first) => first.blend(of_key, info.shading.part as f32),
            });
        }
    }
    grid.close(frame.camera, &frame.patches.times.sets[patch.motion as usize]);
    let mut points = shading_points(frame, piece.patch, &uv, info, ring.as_ref());
    points.i = collect(shaded_at.iter().map(|&p| frame.camera.incident(p)));
    points.p = collect(shaded_at.into_iter());
    primitive_variables(frame, piece.patch, &mut points, &uv, primitive, info);
    if let Some(ring) = &ring {
        ring.set_normals(info.normal_sign, &mut points);
    }
    steps(&mut points, columns as usize);
    Diced { grid, points }
}

/// Vectors part of the way from some to others; the others where there are none before.
fn blend(from: Vec<Vec3>, to: Vec<Vec3>, part: f32) -> Vec<Vec3> {
    if from.is_empty() {
        return to;
    }
    from.into_iter().zip(to).map(|(from, to)| from + (to - from) * part).collect()
}

fn collect(values: impl ExactSizeIterator<Item = Vec3>) -> Vec3s {
    let mut all = Vec3s::with_capacity(values.len());
    values.for_each(|value| all.push(value));
    all
}

/// Where vertices are at a key: those on sides as the owners of these say. What a ring knows of the others is
/// taken from there.
fn vertex_positions(
    context: &DisplaceContext,
    patch: u32,
    vertices: &[LatticeVertex],
    key: usize,
    ring: Option<&Ring>,
) -> Vec<Vec3> {
    let frame = context.frame;
    if !context.is_displaced(patch) {
        let position = |vertex: &LatticeVertex| match vertex.border {
            Some(point) => frame.position(patch, point, key),
            None => frame.surfaces.evaluate(patch, key, vertex.uv).p,
        };
        return vertices.iter().map(position).collect();
    }
    let (mut asked, mut queries) = (Vec::new(), Vec::new());
    let mut placed = vec![Vec3::ZERO; vertices.len()];
    for (ix, vertex) in vertices.iter().enumerate() {
        match (vertex.border, ring) {
            (None, Some(ring)) => {
                placed[ix] = ring.of_vertex(ix);
                continue;
            }
            (None, None) => queries.push(context.inner(patch, key, vertex.uv)),
            (Some(point), _) => queries.push(context.border(patch, key, point, vertex.uv)),
        }
        asked.push(ix);
    }
    for (ix, p) in asked.into_iter().zip(context.positions(&queries, key, false)) {
        placed[ix] = p;
    }
    placed
}

/// A displaced lattice with a ring of ghost vertices around it, at a motion key or between two: shading normals from it agree
/// with those of the grid next to it on the same patch.
struct Ring {
    /// Vertices of a row, ghosts included.
    width: usize,
    height: usize,
    /// What was asked, vertex by vertex.
    queries: Vec<Query>,
    /// Where they are, displaced.
    placed: Vec<Vec3>,
    /// Whether a vertex lies on the patch.
    exists: Vec<bool>,
}

impl Ring {
    fn new(context: &DisplaceContext, piece: &Piece, key: usize) -> Self {
        let PieceKind::Lattice { m, n, i, j } = piece.kind else {
            unreachable!("only pieces with a lattice are diced");
        };
        let (width, height) = (usize::from(i[1] - i[0]) + 3, usize::from(j[1] - j[0]) + 3);
        let (mut queries, mut exists) = (Vec::new(), Vec::new());
        for row in 0..height {
            for column in 0..width {
                // The same quotients as the lattice's own vertices have.
                let a = (f32::from(i[0]) + column as f32 - 1.0) / f32::from(m);
                let b = (f32::from(j[0]) + row as f32 - 1.0) / f32::from(n);
                let [u, v] = quad_uv(&piece.uv, a, b);
                // Beyond the patch there is nothing to ask; a rounding beyond it still counts as on it.
                exists.push([u, v].iter().all(|&c| (-1e-5..=1.0 + 1e-5).contains(&c)));
                queries.push(context.inner(piece.patch, key, [u.clamp(0.0, 1.0), v.clamp(0.0, 1.0)]));
            }
        }
        let placed = context.positions(&queries, key, true);
        Ring { width, height, queries, placed, exists }
    }

    /// Part of the way to the ring of the next key.
    fn blend(mut self, next: Ring, part: f32) -> Ring {
        for (query, next) in self.queries.iter_mut().zip(&next.queries) {
            query.at = blend_points(&query.at, &next.at, part);
            query.normal = (query.normal + (next.normal - query.normal) * part).normalize_or(query.normal);
        }
        self.placed = blend(self.placed, next.placed, part);
        self
    }

    /// Place in the ring of vertex `vertex` of the grid.
    fn index(&self, vertex: usize) -> usize {
        (vertex / (self.width - 2) + 1) * self.width + vertex % (self.width - 2) + 1
    }

    fn of_vertex(&self, vertex: usize) -> Vec3 {
        self.placed[self.index(vertex)]
    }

    /// Normals by central differences, one-sided at the border of the patch.
    fn set_normals(&self, sign: f32, points: &mut ShadingPoints) {
        for vertex in 0..(self.width - 2) * (self.height - 2) {
            let at = self.index(vertex);
            let across = |step: usize| {
                let (before, after) = (at - step, at + step);
                let from = if self.exists[before] { before } else { at };
                let to = if self.exists[after] { after } else { at };
                self.placed[to] - self.placed[from]
            };
            let cross = across(1).cross(across(self.width)) * sign;
            let length = cross.length();
            // A grid that is folded to nothing keeps the normal of the surface below.
            if length.is_finite() && length > f32::MIN_POSITIVE {
                points.n.set(vertex, cross / length);
                points.ng.set(vertex, cross / length);
            }
        }
    }
}

struct LatticeVertex {
    uv: [f32; 2],
    /// Where it lies on a side of the quad.
    border: Option<super::piece::PointRef>,
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
        let keeps = context.sabotage != Some(Sabotage::Owner);
        LatticeVertex { uv, border: keeps.then_some(point) }
    };
    let snaps = context.sabotage != Some(Sabotage::Snap);
    let mut vertices = Vec::new();
    for b in j[0]..=j[1] {
        for a in i[0]..=i[1] {
            vertices.push(if b == 0 && snaps {
                on_side(0, a, m)
            } else if b == n && snaps {
                on_side(2, a, m)
            } else if a == 0 && snaps {
                on_side(3, b, n)
            } else if a == m && snaps {
                on_side(1, b, n)
            } else {
                let uv = quad_uv(&piece.uv, f32::from(a) / f32::from(m), f32::from(b) / f32::from(n));
                LatticeVertex { uv, border: None }
            });
        }
    }
    vertices
}

/// Puts the next key's vertices on the raster.
fn place(grid: &mut Grid, camera: &RasterCamera, placed: &[Vec3]) {
    for (ix, &p) in placed.iter().enumerate() {
        let fixed = camera.fixed(p);
        if fixed.is_none() {
            grid.slow.is_slow.resize(placed.len(), false);
            grid.slow.is_slow[ix] = true;
        }
        let [x, y] = fixed.unwrap_or([0, 0]);
        grid.x.push(x);
        grid.y.push(y);
        grid.depth.push(p.z);
        if camera.lens.is_some() {
            grid.coc.push(if fixed.is_some() { camera.coc(p.z) } else { 0 });
        }
    }
    grid.keys += 1;
    // A vertex may turn slow at a later key: positions of all keys are kept until that is known.
    grid.slow.p.extend_from_slice(placed);
}

/// A surface point part of the way between two.
fn blend_points(from: &SurfacePoint, to: &SurfacePoint, part: f32) -> SurfacePoint {
    let between = |from: Vec3, to: Vec3| from + (to - from) * part;
    SurfacePoint { p: between(from.p, to.p), du: between(from.du, to.du), dv: between(from.dv, to.dv) }
}

/// A patch and its unit normal at the time of shading.
fn shaded_surface(
    context: &SplitContext,
    patch: u32,
    uv: [f32; 2],
    shading: &Between,
) -> (SurfacePoint, Vec3) {
    let [from, to] = shading.keys;
    let mut at = context.surfaces.evaluate(patch, from, uv);
    if shading.part > 0.0 {
        at = blend_points(&at, &context.surfaces.evaluate(patch, to, uv), shading.part as f32);
    }
    let normal = unit_normal(&at).unwrap_or_else(|| context.surfaces.normal(patch, from, uv));
    (at, normal)
}

/// Normals, derivatives and parameters.
fn shading_points(
    context: &SplitContext,
    patch_ix: u32,
    uv: &[[f32; 2]],
    info: &PrimitiveInfo,
    ring: Option<&Ring>,
) -> ShadingPoints {
    let [u0, u1, v0, v1] = context.patches.patches[patch_ix as usize].params;
    let vectors = || Vec3s::with_capacity(uv.len());
    let floats = || Vec::with_capacity(uv.len());
    let mut points = ShadingPoints {
        dpdu: vectors(),
        dpdv: vectors(),
        ng: vectors(),
        u: floats(),
        v: floats(),
        ..ShadingPoints::default()
    };
    for (vertex, &[u, v]) in uv.iter().enumerate() {
        let (at, normal) = match ring {
            Some(ring) => {
                let query = &ring.queries[ring.index(vertex)];
                (query.at, query.normal)
            }
            None => {
                let (at, normal) = shaded_surface(context, patch_ix, [u, v], &info.shading);
                (at, normal * info.normal_sign)
            }
        };
        points.dpdu.push(at.du / (u1 - u0));
        points.dpdv.push(at.dv / (v1 - v0));
        points.ng.push(normal);
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
    (points.s, points.t) = texture_coordinates(context, patch_ix, uv, primitive, info);
    each_variable(
        context,
        patch_ix,
        uv,
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
    let three = || Vec3s { x: component(0), y: component(1), z: component(2) };
    match (name, num_floats) {
        ("Cs", 3) => points.cs = three(),
        ("Os", 3) => points.os = three(),
        ("s" | "t", 1) | ("st", 2) => {} // Texture coordinates have a rule of their own.
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
