//! Patchify: primitives become patches in camera space.
//!
//! In: `Scene` and the key times of its primitives. Out: `PatchTable` without connections, and warnings about what cannot be drawn. Every cubic
//! basis becomes Bezier, whose control points bound the surface closely.

use std::sync::Arc;

use glam::DVec4;

use crate::geometry::bezier::to_bezier;
use crate::geometry::subdivision::LimitSurface;
use crate::scene::{Between, Geometry, Keyed, PatchBasis, PatchKind, PatchMesh, Points, Scene};

use super::connect::EdgeUse;
use super::limit::Limit;
use super::motion::{KeyTimes, Placement, blend_point, placements};
use super::patch::{Patch, PatchTable, Shape};

/// Turns all primitives of `scene` into patches, placed at their key times. Warnings name the object.
pub fn patchify(scene: &Scene, times: &KeyTimes) -> (PatchTable, Vec<String>) {
    let [num_patches, num_floats] = sizes(scene, times);
    let mut table = PatchTable {
        patches: Vec::with_capacity(num_patches),
        floats: Vec::with_capacity(num_floats),
        limits: Vec::new(),
        times: times.clone(),
    };
    let mut warnings = Vec::new();
    for (ix, primitive) in scene.primitives.iter().enumerate() {
        let placements = placements(scene, primitive, times.of(ix as u32));
        let mut warn = |problem: &dyn std::fmt::Display| {
            warnings.push(format!("{}: {problem}", primitive.object_name(ix)));
        };
        match &primitive.geometry {
            Geometry::Patches(mesh) => {
                if let Err(problem) = sheet(mesh, ix as u32, &placements, &mut table) {
                    warn(&problem);
                }
            }
            Geometry::Subdivision(mesh) => {
                let (surface, problems) = LimitSurface::new(Arc::clone(mesh));
                problems.iter().for_each(|problem| warn(problem));
                base_quads(surface, ix as u32, placements, &mut table);
            }
        }
    }
    (table, warnings)
}

/// Patches that sheets become, and floats of their control points, unless these are rational or not all are drawn: lists
/// that grow by doubling leave as much memory behind as they take.
fn sizes(scene: &Scene, times: &KeyTimes) -> [usize; 2] {
    let mut sizes = [0; 2];
    for (ix, primitive) in (0u32..).zip(&scene.primitives) {
        let Geometry::Patches(mesh) = &primitive.geometry else { continue };
        let Some([pu, pv]) = mesh.num_patches() else { continue };
        if mesh.points.values.iter().all(|points| Some(points.len()) == mesh.nu.checked_mul(mesh.nv)) {
            let num_points = if *mesh.kind == PatchKind::Bilinear { 4 } else { 16 };
            sizes[0] += pu * pv;
            sizes[1] += pu * pv * times.of(ix).len() * num_points * 3;
        }
    }
    sizes
}

/// One patch for each base quad of a limit surface.
fn base_quads(surface: LimitSurface, primitive: u32, placements: Vec<Placement>, table: &mut PatchTable) {
    let limit = table.limits.len() as u32;
    let motion = table.times.of_primitive[primitive as usize];
    for quad in 0..surface.num_quads() as u32 {
        table.patches.push(Patch {
            primitive,
            cell: [surface.quad(quad).source_face, 0],
            shape: Shape::Subdivision { limit, quad },
            rational: false,
            first_float: 0,
            motion,
            edges: [EdgeUse::default(); 4],
            corners: [0; 4],
            params: [0.0, 1.0, 0.0, 1.0],
            slack: 0.0,
            reach: 0.0,
            moves_alone: true,
        });
    }
    // A mesh whose keys differ in more than their places has fewer of them.
    let last = surface.num_keys() - 1;
    let within = |placement: Placement| {
        let Between { keys, part } = placement.points;
        Placement { points: Between { keys: keys.map(|key| key.min(last)), part }, ..placement }
    };
    table.limits.push(Limit { surface, placements: placements.into_iter().map(within).collect() });
}

fn sheet(
    mesh: &PatchMesh,
    primitive: u32,
    placements: &[Placement],
    table: &mut PatchTable,
) -> Result<(), String> {
    let Some([pu, pv]) = mesh.num_patches() else {
        return Err(format!("{} x {} control points do not fit the basis; not drawn", mesh.nu, mesh.nv));
    };
    let expected = mesh.nu * mesh.nv;
    if let Some(points) = mesh.points.values.iter().find(|points| points.len() != expected) {
        return Err(format!("{} control points where {expected} were expected; not drawn", points.len()));
    }
    let rational = mesh.points.values.iter().any(is_rational);
    let width = if rational { 4 } else { 3 };
    let keys: Vec<Vec<DVec4>> =
        placements.iter().map(|placement| camera_points(&mesh.points, expected, placement)).collect();
    let mut dropped = 0usize;
    for (row, column) in (0..pv).flat_map(|row| (0..pu).map(move |column| (row, column))) {
        let first_float = table.floats.len();
        if first_float > u32::MAX as usize - 64 * keys.len() {
            return Err("too many control points in one frame; the rest is not drawn".to_owned());
        }
        let usable = |p: &DVec4| p.as_vec4().is_finite() && p.w.is_finite() && p.w > 0.0;
        let is_usable = keys.iter().all(|points| {
            let (points, len) = bezier_points(mesh, points, column, row);
            points[..len].iter().all(|p| {
                table.floats.extend_from_slice(&p.as_vec4().to_array()[..width]);
                usable(p)
            })
        });
        if !is_usable {
            table.floats.truncate(first_float);
            dropped += 1;
            continue;
        }
        let span = |ix: usize, n: usize| [ix as f32 / n as f32, (ix + 1) as f32 / n as f32];
        let ([u0, u1], [v0, v1]) = (span(column, pu), span(row, pv));
        table.patches.push(Patch {
            primitive,
            cell: [column as u32, row as u32],
            shape: if *mesh.kind == PatchKind::Bilinear { Shape::Bilinear } else { Shape::Bicubic },
            rational,
            first_float: first_float as u32,
            motion: table.times.of_primitive[primitive as usize],
            edges: [EdgeUse::default(); 4],
            corners: [0; 4],
            params: [u0, u1, v0, v1],
            slack: 0.0,
            reach: 0.0,
            moves_alone: true,
        });
    }
    if dropped > 0 {
        return Err(format!(
            "{dropped} of {} patches have a control point that is not finite or a weight that is not above 0; \
             they are not drawn",
            pu * pv
        ));
    }
    Ok(())
}

/// Whether any weight differs from 1.
fn is_rational(points: &Points) -> bool {
    matches!(points, Points::Pw(p) if p.iter().any(|p| p[3] != 1.0))
}

/// Control points in camera space at a key, homogeneous.
fn camera_points(points: &Keyed<Points>, len: usize, placement: &Placement) -> Vec<DVec4> {
    let Placement { points: between, to_camera } = placement;
    let place = |ix: usize| {
        let p = blend_point(points, between, ix);
        if p.w == 1.0 { to_camera.transform_point3(p.truncate()).extend(1.0) } else { *to_camera * p }
    };
    (0..len).map(place).collect()
}

/// The Bezier points (or corners) of the patch at `column`, `row` of the sheet, and how many they are.
fn bezier_points(mesh: &PatchMesh, points: &[DVec4], column: usize, row: usize) -> ([DVec4; 16], usize) {
    let at = |i: usize, j: usize| points[(j % mesh.nv) * mesh.nu + i % mesh.nu];
    match *mesh.kind {
        PatchKind::Bilinear => {
            let corners =
                [at(column, row), at(column + 1, row), at(column, row + 1), at(column + 1, row + 1)];
            (std::array::from_fn(|ix| corners[ix % 4]), 4)
        }
        PatchKind::Bicubic { u, v } => {
            let (i0, j0) = (column * u.step as usize, row * v.step as usize);
            let control: [DVec4; 16] = std::array::from_fn(|ix| at(i0 + ix % 4, j0 + ix / 4));
            (change_basis(control, &u, &v), 16)
        }
    }
}

/// Sixteen control points from bases `u` and `v` to Bezier; exact where a basis is Bezier already.
pub fn change_basis<T>(mut p: [T; 16], u: &PatchBasis, v: &PatchBasis) -> [T; 16]
where
    T: Copy + std::ops::Mul<f64, Output = T> + std::ops::Add<Output = T>,
{
    let blend = |m: &[f64; 4], q: [T; 4]| q[0] * m[0] + q[1] * m[1] + q[2] * m[2] + q[3] * m[3];
    if u.matrix != PatchBasis::BEZIER.matrix {
        let m = to_bezier(u);
        for j in 0..4 {
            let q: [T; 4] = std::array::from_fn(|i| p[4 * j + i]);
            m.iter().enumerate().for_each(|(i, row)| p[4 * j + i] = blend(row, q));
        }
    }
    if v.matrix != PatchBasis::BEZIER.matrix {
        let m = to_bezier(v);
        for i in 0..4 {
            let q: [T; 4] = std::array::from_fn(|j| p[4 * j + i]);
            m.iter().enumerate().for_each(|(j, row)| p[4 * j + i] = blend(row, q));
        }
    }
    p
}
