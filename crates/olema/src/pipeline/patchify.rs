//! Patchify: primitives become patches in camera space.
//!
//! In: `Scene` and the key times of its primitives. Out: `PatchTable` without connections, and warnings about what cannot
//! be drawn. Every cubic basis becomes Bezier, whose control points bound the surface closely.

use std::sync::Arc;

use glam::DVec4;

use crate::geometry::bezier::to_bezier;
use crate::geometry::subdivision::LimitSurface;
use crate::math::simd::SimdLevel;
use crate::scene::{Between, Geometry, Keyed, PatchBasis, PatchKind, PatchMesh, Points, Scene, Scheme};

use super::bends::NOT_BENT;
use super::camera_points::{STEP, ToCamera};
use super::edges::EdgeUse;
use super::limit::Limit;
use super::motion::{KeyTimes, Placement, Placer, blend_point};
use super::patch::{Patch, PatchTable, Shape};
use super::smooth::{SheetSmooth, Smooth};

/// Turns all primitives of `scene` into patches, placed at their key times. Warnings name the object.
pub fn patchify(scene: &Scene, times: &KeyTimes) -> (PatchTable, Vec<String>) {
    let [num_patches, num_floats] = sizes(scene, times);
    let mut table = PatchTable {
        patches: Vec::with_capacity(num_patches),
        floats: Vec::with_capacity(num_floats),
        bends: Vec::new(),
        limits: Vec::new(),
        times: times.clone(),
    };
    let mut warnings = Vec::new();
    let (mut placer, mut placements) = (Placer::new(scene), Vec::new());
    let mut room = Room { level: SimdLevel::best(), points: Vec::new() };
    for (ix, primitive) in scene.primitives.iter().enumerate() {
        placements.clear();
        placements.extend(times.of(ix as u32).iter().map(|&t| placer.place(primitive, t)));
        let mut warn = |problem: &dyn std::fmt::Display| {
            warnings.push(format!("{}: {problem}", primitive.object_name(ix)));
        };
        match &primitive.geometry {
            Geometry::Patches(mesh) => {
                if let Err(problem) = sheet(mesh, ix as u32, &placements, &mut room, &mut table) {
                    warn(&problem);
                }
            }
            Geometry::Subdivision(mesh) => {
                let (surface, problems) = LimitSurface::new(Arc::clone(mesh));
                problems.iter().for_each(|problem| warn(problem));
                base_quads(surface, mesh.scheme, ix as u32, &placements, &mut table);
            }
        }
    }
    table.floats.shrink_to_fit();
    table.bends.shrink_to_fit();
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
fn base_quads(
    surface: LimitSurface,
    scheme: Scheme,
    primitive: u32,
    placements: &[Placement],
    table: &mut PatchTable,
) {
    let limit = table.limits.len() as u32;
    let motion = table.times.of_primitive[primitive as usize];
    for quad in 0..surface.num_quads() as u32 {
        let base = surface.quad(quad);
        table.patches.push(Patch {
            primitive,
            cell: [base.source_face, 0],
            shape: Shape::Subdivision { limit, quad },
            rational: false,
            first_float: 0,
            first_bend: NOT_BENT,
            motion,
            edges: [EdgeUse::default(); 4],
            corners: [0; 4],
            params: [0.0, 1.0, 0.0, 1.0],
            smooth: Smooth::of_quad(scheme, &base),
            slack: 0.0,
            reach: 0.0,
            moves_alone: true,
        });
    }
    // A mesh whose keys differ in more than their places has fewer of them.
    let last = surface.num_keys() - 1;
    let within = |placement: &Placement| {
        let Between { keys, part } = placement.points;
        Placement { points: Between { keys: keys.map(|key| key.min(last)), part }, ..*placement }
    };
    table.limits.push(Limit { surface, placements: placements.iter().map(within).collect() });
}

/// What sheets are placed with.
struct Room {
    level: SimdLevel,
    /// Control points of a sheet, key after key.
    points: Vec<DVec4>,
}

/// The patches of a sheet.
fn sheet(
    mesh: &PatchMesh,
    primitive: u32,
    placements: &[Placement],
    Room { level, points }: &mut Room,
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
    let is_single = is_bezier_patch(mesh);
    points.clear();
    if !is_single {
        points.reserve_exact(expected * placements.len());
        placements.iter().for_each(|at| camera_points(*level, &mesh.points, expected, at, points));
    }
    let (to_bezier, smooth) = (ToBezier::of_sheet(mesh), SheetSmooth::new(mesh, [pu, pv]));
    let mut dropped = 0usize;
    for (row, column) in (0..pv).flat_map(|row| (0..pu).map(move |column| (row, column))) {
        let first_float = table.floats.len();
        if first_float > u32::MAX as usize - 64 * placements.len() {
            return Err("too many control points in one frame; the rest is not drawn".to_owned());
        }
        let control = Control::new(mesh, column, row);
        let is_usable = if is_single {
            placements.iter().all(|at| push_single(*level, mesh, at, &mut table.floats))
        } else {
            points.chunks_exact(expected.max(1)).all(|points| {
                let (points, len) = control.bezier_points(mesh, &to_bezier, points);
                match rational {
                    true => push_points::<4>(&points[..len], &mut table.floats),
                    false => push_points::<3>(&points[..len], &mut table.floats),
                }
            })
        };
        if !is_usable {
            table.floats.truncate(first_float);
            dropped += 1;
            continue;
        }
        let shape = if *mesh.kind == PatchKind::Bilinear { Shape::Bilinear } else { Shape::Bicubic };
        let len = shape.num_points() * if rational { 4 } else { 3 };
        let first_bend = table.bend_last(first_float, len);
        let span = |ix: usize, n: usize| [ix as f32 / n as f32, (ix + 1) as f32 / n as f32];
        let ([u0, u1], [v0, v1]) = (span(column, pu), span(row, pv));
        table.patches.push(Patch {
            primitive,
            cell: [column as u32, row as u32],
            shape,
            rational,
            first_float: first_float as u32,
            first_bend,
            motion: table.times.of_primitive[primitive as usize],
            edges: [EdgeUse::default(); 4],
            corners: [0; 4],
            params: [u0, u1, v0, v1],
            smooth: smooth.of_patch([column, row]),
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
fn camera_points(
    level: SimdLevel,
    points: &Keyed<Points>,
    len: usize,
    placement: &Placement,
    out: &mut Vec<DVec4>,
) {
    let Placement { points: between, to_camera } = placement;
    let Some(placed) = ToCamera::of_sheet(points, between, to_camera) else {
        out.extend((0..len).map(|ix| {
            let p = blend_point(points, between, ix);
            if p.w == 1.0 { to_camera.transform_point3(p.truncate()).extend(1.0) } else { *to_camera * p }
        }));
        return;
    };
    for first in (0..len).step_by(STEP) {
        let [x, y, z] = level.run(
            #[inline(always)]
            || placed.step(first),
        );
        out.extend((0..STEP.min(len - first)).map(|ix| DVec4::new(x[ix], y[ix], z[ix], 1.0)));
    }
}

/// Whether a sheet is one patch whose control points are its Bezier points: nearly all of some files are.
fn is_bezier_patch(mesh: &PatchMesh) -> bool {
    let PatchKind::Bicubic { u, v } = &*mesh.kind else { return false };
    [mesh.nu, mesh.nv] == [4, 4]
        && !(mesh.wrap_u || mesh.wrap_v)
        && [u, v].iter().all(|basis| basis.matrix == PatchBasis::BEZIER.matrix)
        && mesh.points.values.iter().all(|points| matches!(points, Points::P(_)))
}

/// [`push_points`] for the points of such a sheet at a key.
fn push_single(level: SimdLevel, mesh: &PatchMesh, placement: &Placement, floats: &mut Vec<f32>) -> bool {
    let Some(placed) = ToCamera::of_sheet(&mesh.points, &placement.points, &placement.to_camera) else {
        return false;
    };
    let mut all = [[0.0f32; 3]; STEP];
    let is_usable = level.run(
        #[inline(always)]
        || {
            let [x, y, z] = placed.step(0);
            let mut is_usable = true;
            for (ix, point) in all.iter_mut().enumerate() {
                *point = [x[ix] as f32, y[ix] as f32, z[ix] as f32];
                is_usable &= point[0].is_finite() & point[1].is_finite() & point[2].is_finite();
            }
            is_usable
        },
    );
    floats.extend_from_slice(all.as_flattened());
    is_usable
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
    fn bezier_points(
        &self,
        mesh: &PatchMesh,
        to_bezier: &ToBezier,
        points: &[DVec4],
    ) -> ([DVec4; 16], usize) {
        let side = if matches!(*mesh.kind, PatchKind::Bilinear) { 2 } else { 4 };
        let mut control = [DVec4::ZERO; 16];
        for j in 0..side {
            for i in 0..side {
                control[side * j + i] = points[self.rows[j] + self.columns[i]];
            }
        }
        match &*mesh.kind {
            PatchKind::Bilinear => (control, 4),
            PatchKind::Bicubic { .. } => (to_bezier.apply(control), 16),
        }
    }
}

/// Sixteen control points from bases `u` and `v` to Bezier; exact where a basis is Bezier already.
pub fn change_basis<T>(p: [T; 16], u: &PatchBasis, v: &PatchBasis) -> [T; 16]
where
    T: Copy + std::ops::Mul<f64, Output = T> + std::ops::Add<Output = T>,
{
    ToBezier::new(u, v).apply(p)
}

/// The matrices of [`change_basis`] for u and v; none where the basis is Bezier already.
struct ToBezier([Option<[[f64; 4]; 4]>; 2]);

impl ToBezier {
    fn new(u: &PatchBasis, v: &PatchBasis) -> Self {
        ToBezier([u, v].map(|basis| (basis.matrix != PatchBasis::BEZIER.matrix).then(|| to_bezier(basis))))
    }

    fn of_sheet(mesh: &PatchMesh) -> Self {
        match &*mesh.kind {
            PatchKind::Bilinear => ToBezier([None; 2]),
            PatchKind::Bicubic { u, v } => ToBezier::new(u, v),
        }
    }

    fn apply<T>(&self, mut p: [T; 16]) -> [T; 16]
    where
        T: Copy + std::ops::Mul<f64, Output = T> + std::ops::Add<Output = T>,
    {
        let blend = |m: &[f64; 4], q: [T; 4]| q[0] * m[0] + q[1] * m[1] + q[2] * m[2] + q[3] * m[3];
        let ToBezier([u, v]) = self;
        for (m, j) in u.iter().flat_map(|m| (0..4).map(move |j| (m, j))) {
            let q: [T; 4] = std::array::from_fn(|i| p[4 * j + i]);
            m.iter().enumerate().for_each(|(i, row)| p[4 * j + i] = blend(row, q));
        }
        for (m, i) in v.iter().flat_map(|m| (0..4).map(move |i| (m, i))) {
            let q: [T; 4] = std::array::from_fn(|j| p[4 * j + i]);
            m.iter().enumerate().for_each(|(j, row)| p[4 * j + i] = blend(row, q));
        }
        p
    }
}
