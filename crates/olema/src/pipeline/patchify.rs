//! Patchify: primitives become patches in camera space.
//!
//! In: `Scene` and the key times of its primitives. Out: `PatchTable` without connections, and warnings about what cannot be drawn. Every cubic
//! basis becomes Bezier, whose control points bound the surface closely.

use std::sync::Arc;

use glam::DVec4;

use crate::geometry::bezier::to_bezier;
use crate::geometry::subdivision::LimitSurface;
use crate::scene::{Between, Geometry, Keyed, PatchBasis, PatchKind, PatchMesh, Points, Scene};

use super::edges::EdgeUse;
use super::limit::Limit;
use super::motion::{KeyTimes, Placement, Placer, blend_point};
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
    let (mut placer, mut points) = (Placer::new(scene), Vec::new());
    for (ix, primitive) in scene.primitives.iter().enumerate() {
        let placements = times.of(ix as u32).iter().map(|&t| placer.place(primitive, t));
        let mut warn = |problem: &dyn std::fmt::Display| {
            warnings.push(format!("{}: {problem}", primitive.object_name(ix)));
        };
        match &primitive.geometry {
            Geometry::Patches(mesh) => {
                if let Err(problem) = sheet(mesh, ix as u32, placements, &mut points, &mut table) {
                    warn(&problem);
                }
            }
            Geometry::Subdivision(mesh) => {
                let (surface, problems) = LimitSurface::new(Arc::clone(mesh));
                problems.iter().for_each(|problem| warn(problem));
                base_quads(surface, ix as u32, placements.collect(), &mut table);
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

/// The patches of a sheet; `points` is room for its control points.
fn sheet(
    mesh: &PatchMesh,
    primitive: u32,
    placements: impl ExactSizeIterator<Item = Placement>,
    points: &mut Vec<DVec4>,
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
    points.clear();
    points.reserve_exact(expected * placements.len());
    placements.for_each(|placement| camera_points(&mesh.points, expected, &placement, points));
    let num_keys = points.len() / expected.max(1);
    let mut dropped = 0usize;
    for (row, column) in (0..pv).flat_map(|row| (0..pu).map(move |column| (row, column))) {
        let first_float = table.floats.len();
        if first_float > u32::MAX as usize - 64 * num_keys {
            return Err("too many control points in one frame; the rest is not drawn".to_owned());
        }
        let control = Control::new(mesh, column, row);
        let is_usable = points.chunks_exact(expected.max(1)).all(|points| {
            let (points, len) = control.bezier_points(mesh, points);
            match rational {
                true => push_points::<4>(&points[..len], &mut table.floats),
                false => push_points::<3>(&points[..len], &mut table.floats),
            }
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

/// Appends control points in camera space at a key, homogeneous.
fn camera_points(points: &Keyed<Points>, len: usize, placement: &Placement, out: &mut Vec<DVec4>) {
    let Placement { points: between, to_camera } = placement;
    out.extend((0..len).map(|ix| {
        let p = blend_point(points, between, ix);
        if p.w == 1.0 { to_camera.transform_point3(p.truncate()).extend(1.0) } else { *to_camera * p }
    }));
}

/// Appends the first `W` floats of each of at most 16 points; whether all of them are finite, with a weight above 0.
fn push_points<const W: usize>(points: &[DVec4], floats: &mut Vec<f32>) -> bool {
    let (mut all, mut is_usable) = ([[0.0f32; W]; 16], true);
    for (to, p) in all.iter_mut().zip(points) {
        let single = p.as_vec4();
        is_usable &= single.is_finite() && p.w.is_finite() && p.w > 0.0;
        to.copy_from_slice(&single.to_array()[..W]);
    }
    floats.extend_from_slice(all[..points.len()].as_flattened());
    is_usable
}

/// Which of a sheet's points are a patch's.
struct Control {
    columns: [usize; 4],
    /// Number of the first point of each row.
    rows: [usize; 4],
}

impl Control {
    fn new(mesh: &PatchMesh, column: usize, row: usize) -> Self {
        let [u, v] = match &*mesh.kind {
            PatchKind::Bilinear => [1, 1],
            PatchKind::Bicubic { u, v } => [u.step as usize, v.step as usize],
        };
        Control {
            columns: [0, 1, 2, 3].map(|i| (column * u + i) % mesh.nu),
            rows: [0, 1, 2, 3].map(|j| (row * v + j) % mesh.nv * mesh.nu),
        }
    }

    /// The Bezier points (or corners) of the patch, and how many they are.
    fn bezier_points(&self, mesh: &PatchMesh, points: &[DVec4]) -> ([DVec4; 16], usize) {
        let side = if matches!(*mesh.kind, PatchKind::Bilinear) { 2 } else { 4 };
        let mut control = [DVec4::ZERO; 16];
        for j in 0..side {
            for i in 0..side {
                control[side * j + i] = points[self.rows[j] + self.columns[i]];
            }
        }
        match &*mesh.kind {
            PatchKind::Bilinear => (control, 4),
            PatchKind::Bicubic { u, v } => (change_basis(control, u, v), 16),
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
