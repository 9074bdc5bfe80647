//! Patches: surfaces over the unit square in camera space, all of them in one table.
//!
//! In: made by `patchify`. Out: read by every later stage; never changed once `connect` is done.

use std::cell::RefCell;

use glam::{Vec3, Vec4};

use crate::geometry::bezier::{Bicubic, Bilinear, ControlPoint};
use crate::geometry::hull::{Hull, bicubic_hull};
use crate::geometry::subdivision::Evaluator;
use crate::geometry::{Aabb, SurfacePoint};
use crate::math::simd::SimdLevel;

use super::bends::{MOST_FLOATS, NOT_BENT, bent};
use super::edges::EdgeUse;
use super::limit::Limit;
use super::motion::KeyTimes;
use super::smooth::Smooth;

/// What a patch's control points mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// Four corners: (0,0), (1,0), (0,1), (1,1).
    Bilinear,
    /// Sixteen Bezier points, u first.
    Bicubic,
    /// A base quad of a limit surface; it has no control points of its own.
    Subdivision {
        /// Entry of [`PatchTable::limits`].
        limit: u32,
        /// Base quad of that surface.
        quad: u32,
    },
}

impl Shape {
    /// Number of control points.
    pub fn num_points(self) -> usize {
        match self {
            Shape::Bilinear => 4,
            Shape::Bicubic => 16,
            Shape::Subdivision { .. } => 0,
        }
    }
}

/// A patch.
#[derive(Debug, Clone, Copy)]
pub struct Patch {
    /// Index of its primitive in the scene.
    pub primitive: u32,
    /// Column and row of the patch in the primitive's sheet.
    pub cell: [u32; 2],
    /// Kind of surface.
    pub shape: Shape,
    /// Whether points are homogeneous.
    pub rational: bool,
    /// First float of its control points; keys follow each other, every other one where the rest is in `bends`.
    pub first_float: u32,
    /// First of its [`PatchTable::bends`]; `u32::MAX` where it has none.
    pub first_bend: u32,
    /// Its set of key times, of [`KeyTimes::sets`].
    pub motion: u32,
    /// Sides 0: v = 0, 1: u = 1, 2: v = 1, 3: u = 0, each with u or v ascending.
    pub edges: [EdgeUse; 4],
    /// Welded corners at (u, v) = (0,0), (1,0), (0,1), (1,1).
    pub corners: [u32; 4],
    /// `[u0, u1, v0, v1]` in the primitive's parameters.
    pub params: [f32; 4],
    /// Where it goes on smoothly beyond its border.
    pub smooth: Smooth,
    /// How far, in camera units, a welded neighbour's border may lie from this patch's own.
    pub slack: f32,
    /// How far, in camera units, displacement may move points of the patch or of its border.
    pub reach: f32,
    /// Whether no other primitive's shader moves its border.
    pub moves_alone: bool,
}

/// All patches of a frame.
#[derive(Debug, Clone)]
pub struct PatchTable {
    /// In canonical order: by primitive, then by place in it.
    pub patches: Vec<Patch>,
    /// Control points, 3 or 4 floats each, in camera space.
    pub floats: Vec<f32>,
    /// Of every other key how far, in steps of a float, its floats are from the middle of those before and after. Keys that
    /// are added half-way between the file's are hardly off it, as control points move evenly, and take a quarter so.
    pub bends: Vec<i8>,
    /// Limit surfaces of subdivision meshes.
    pub limits: Vec<Limit>,
    /// Key times of all primitives.
    pub times: KeyTimes,
}

/// The surface of a patch with control points at one motion key, ready to evaluate.
#[derive(Debug, Clone, Copy)]
pub enum Surface {
    /// Bilinear.
    Bilinear(Bilinear<Vec3>),
    /// Rational bilinear.
    RationalBilinear(Bilinear<Vec4>),
    /// Bicubic.
    Bicubic(Bicubic<Vec3>),
    /// Rational bicubic.
    RationalBicubic(Bicubic<Vec4>),
}

impl PatchTable {
    /// Motion keys of a patch, at least 1.
    #[inline(always)]
    pub fn num_keys(&self, patch: u32) -> usize {
        self.times.sets[self.patches[patch as usize].motion as usize].len()
    }

    /// Takes the connections of the same patches at other key times; `false` where they are not the same.
    pub fn take_connections(&mut self, other: &PatchTable) -> bool {
        let is_same = |(mine, theirs): (&Patch, &Patch)| {
            (mine.primitive, mine.cell, mine.shape) == (theirs.primitive, theirs.cell, theirs.shape)
        };
        if self.patches.len() != other.patches.len() || !self.patches.iter().zip(&other.patches).all(is_same)
        {
            return false;
        }
        for (mine, theirs) in self.patches.iter_mut().zip(&other.patches) {
            (mine.edges, mine.corners, mine.slack) = (theirs.edges, theirs.corners, theirs.slack);
        }
        true
    }

    /// What [`Surface::side_curve`] says of a patch at motion key `key`; `None` without control points.
    pub fn side_curve(&self, patch: u32, key: usize, side: usize) -> Option<[Vec4; 4]> {
        let patch = &self.patches[patch as usize];
        if patch.shape != Shape::Bicubic || patch.rational || patch.first_bend != NOT_BENT {
            return Some(self.control_surface(patch, key)?.side_curve(side));
        }
        // Connecting asks for neighbours' sides alone. First point, and steps between points.
        const SIDES: [[usize; 2]; 4] = [[0, 1], [3, 4], [12, 1], [0, 4]];
        let [point, step] = SIDES[side];
        let (points, _) = self.floats[patch.first_float as usize + key * 48..][..48].as_chunks::<3>();
        Some(std::array::from_fn(|ix| Vec3::from_array(points[point + ix * step]).extend(1.0)))
    }

    /// A box around a patch's control points at the first key; empty without control points.
    pub fn extent(&self, patch: &Patch) -> Aabb {
        let (mut extent, num_points) = (Aabb::EMPTY, patch.shape.num_points());
        let floats = &self.floats[patch.first_float as usize..];
        if patch.rational {
            let points = floats[..4 * num_points].as_chunks().0.iter();
            points.for_each(|&p| extent.include(Vec4::from_array(p).position()));
        } else {
            let points = floats[..3 * num_points].as_chunks().0.iter();
            points.for_each(|&p| extent.include(Vec3::from_array(p)));
        }
        extent
    }

    /// The surface of a patch with control points at motion key `key`.
    pub fn control_surface(&self, patch: &Patch, key: usize) -> Option<Surface> {
        let width = if patch.rational { 4 } else { 3 };
        let len = width * patch.shape.num_points();
        let at_key = |key: usize| &self.floats[patch.first_float as usize + key * len..][..len];
        let mut between = [0.0; MOST_FLOATS];
        let floats = if patch.first_bend == NOT_BENT {
            at_key(key)
        } else if key.is_multiple_of(2) {
            at_key(key / 2)
        } else {
            let bends = &self.bends[patch.first_bend as usize + key / 2 * len..][..len];
            bent([at_key(key / 2), at_key(key / 2 + 1)], bends, &mut between);
            &between[..len]
        };
        Some(match (patch.shape, patch.rational) {
            (Shape::Bilinear, false) => Surface::Bilinear(Bilinear(points(floats, Vec3::from_array))),
            (Shape::Bilinear, true) => Surface::RationalBilinear(Bilinear(points(floats, Vec4::from_array))),
            (Shape::Bicubic, false) => Surface::Bicubic(Bicubic(points(floats, Vec3::from_array))),
            (Shape::Bicubic, true) => Surface::RationalBicubic(Bicubic(points(floats, Vec4::from_array))),
            (Shape::Subdivision { .. }, _) => return None,
        })
    }
}

/// The first N points of a list of their components.
fn points<P: Copy, const W: usize, const N: usize>(floats: &[f32], point: impl Fn([f32; W]) -> P) -> [P; N] {
    let (each, _) = floats.as_chunks::<W>();
    let each: &[[f32; W]; N] = each.first_chunk().expect("a patch has all its control points");
    // A loop, since `map` is a call for so many.
    let mut points = [point(each[0]); N];
    for (to, from) in points.iter_mut().zip(each) {
        *to = point(*from);
    }
    points
}

/// Patches that are kept ready at a time, as a power of two; neighbours are asked for in turn.
const KEPT_LOG: u32 = 7;

/// Evaluates patches. One worker's own: it keeps the last patches that were asked for ready.
pub struct Surfaces<'a> {
    table: &'a PatchTable,
    kept: RefCell<Vec<Option<(u32, Loaded<'a>)>>>,
    /// Instructions that lists are evaluated with.
    pub level: SimdLevel,
}

#[allow(clippy::large_enum_variant)] // Nearly always the large one, and a pointer less on its way.
pub(super) enum Loaded<'a> {
    /// One surface a key.
    Control(Surface, Vec<Surface>),
    Limit(Box<Evaluator<'a>>, &'a Limit),
}

/// The surface at motion key `key`.
#[inline(always)]
pub(super) fn at_key<'s>(first: &'s Surface, later: &'s [Surface], key: usize) -> &'s Surface {
    if key == 0 { first } else { &later[key - 1] }
}

impl<'a> Surfaces<'a> {
    /// Nothing is ready yet.
    pub fn new(table: &'a PatchTable) -> Self {
        let kept = RefCell::new((0..1 << KEPT_LOG).map(|_| None).collect());
        Surfaces { table, kept, level: SimdLevel::best() }
    }

    pub(super) fn with<R>(&self, patch: u32, ask: impl FnOnce(&mut Loaded<'a>) -> R) -> R {
        let mut kept = self.kept.borrow_mut();
        // Neighbours in a sheet are any number apart: a product spreads them whatever it is (Knuth, section 6.4).
        let slot = &mut kept[(patch.wrapping_mul(0x9e37_79b1) >> (32 - KEPT_LOG)) as usize];
        match slot {
            Some((known, loaded)) if *known == patch => ask(loaded),
            _ => ask(&mut slot.insert((patch, self.load(patch))).1),
        }
    }

    fn load(&self, patch: u32) -> Loaded<'a> {
        let table = self.table;
        let num_keys = table.num_keys(patch);
        let patch = &table.patches[patch as usize];
        if let Shape::Subdivision { limit, quad } = patch.shape {
            let limit = &table.limits[limit as usize];
            return Loaded::Limit(Box::new(limit.surface.evaluator(quad)), limit);
        }
        let surface = |key| table.control_surface(patch, key).expect("every other shape has control points");
        Loaded::Control(surface(0), (1..num_keys).map(surface).collect())
    }

    /// Position and derivatives of a patch at motion key `key` and (u, v) in [0, 1]^2, in camera space.
    pub fn evaluate(&self, patch: u32, key: usize, [u, v]: [f32; 2]) -> SurfacePoint {
        self.with(patch, |loaded| match loaded {
            Loaded::Control(first, later) => at_key(first, later, key).evaluate(u, v),
            Loaded::Limit(evaluator, limit) => limit.evaluate(evaluator, key, [u, v]),
        })
    }

    /// The position alone, with the same bits.
    pub fn position(&self, patch: u32, key: usize, [u, v]: [f32; 2]) -> Vec3 {
        self.with(patch, |loaded| match loaded {
            Loaded::Control(first, later) => at_key(first, later, key).position(u, v),
            Loaded::Limit(evaluator, limit) => limit.evaluate(evaluator, key, [u, v]).p,
        })
    }

    /// Appends points in camera space whose convex hull holds the patch over `u` x `v`, at each of `num_keys` keys.
    pub fn hulls(&self, patch: u32, num_keys: usize, u: [f32; 2], v: [f32; 2], out: &mut Vec<Hull>) {
        self.with(patch, |loaded| {
            for key in 0..num_keys {
                out.push(match loaded {
                    Loaded::Control(first, later) => at_key(first, later, key).hull(self.level, u, v),
                    Loaded::Limit(evaluator, limit) => limit.hull(evaluator, key, u, v),
                });
            }
        });
    }

    /// Unit normal dPdu x dPdv at a key. Where it vanishes (a pole, a collapsed side), that of the nearest place
    /// towards the middle of the patch where it does not; zero for a surface without area.
    pub fn normal(&self, patch: u32, key: usize, [u, v]: [f32; 2]) -> Vec3 {
        let mut step = 0.0f32;
        for _ in 0..12 {
            let at = self.evaluate(patch, key, [u + (0.5 - u) * step, v + (0.5 - v) * step]);
            if let Some(normal) = unit_normal(&at) {
                return normal;
            }
            step = if step == 0.0 { 1.0 / 2048.0 } else { step * 2.0 };
        }
        Vec3::ZERO
    }

    /// Variable `var` of a subdivision mesh at (u, v) of a base quad; `false` where it has no value there.
    pub fn limit_var(&self, patch: u32, var: usize, [u, v]: [f32; 2], out: &mut [f32]) -> bool {
        self.with(patch, |loaded| match loaded {
            Loaded::Control(..) => false,
            Loaded::Limit(evaluator, _) => evaluator.var(var, u, v, out),
        })
    }
}

/// Unit normal du x dv, unless one of them vanishes or they are parallel.
pub fn unit_normal(at: &SurfacePoint) -> Option<Vec3> {
    let normal = normal_or_zero(at.du, at.dv);
    (normal != Vec3::ZERO).then_some(normal)
}

/// Unit normal du x dv; zero where one of them vanishes or they are parallel.
#[inline(always)]
pub fn normal_or_zero(du: Vec3, dv: Vec3) -> Vec3 {
    // Derivatives smaller than this part of the other one are rounding.
    const DEGENERATE: f32 = 1e-6;
    let cross = du.cross(dv);
    let length = cross.length();
    let larger = du.length_squared().max(dv.length_squared());
    // No branches: lists of points go through here in lanes.
    let exists = (length < f32::INFINITY) & (length > DEGENERATE * larger) & (length > f32::MIN_POSITIVE);
    let normal = cross / length;
    if exists { normal } else { Vec3::ZERO }
}

impl Surface {
    /// Position and derivatives at (u, v) in [0, 1]^2.
    pub fn evaluate(&self, u: f32, v: f32) -> SurfacePoint {
        match self {
            Surface::Bilinear(s) => s.evaluate(u, v),
            Surface::RationalBilinear(s) => s.evaluate(u, v),
            Surface::Bicubic(s) => s.evaluate(u, v),
            Surface::RationalBicubic(s) => s.evaluate(u, v),
        }
    }

    /// The position alone, with the same bits.
    pub fn position(&self, u: f32, v: f32) -> Vec3 {
        match self {
            Surface::Bilinear(s) => s.position(u, v),
            Surface::RationalBilinear(s) => s.position(u, v),
            Surface::Bicubic(s) => s.position(u, v),
            Surface::RationalBicubic(s) => s.position(u, v),
        }
    }

    /// Points whose convex hull holds the surface over `u` x `v`.
    fn hull(&self, level: SimdLevel, u: [f32; 2], v: [f32; 2]) -> Hull {
        match self {
            Surface::Bilinear(s) => Hull::of(s.restrict(u, v).0),
            Surface::RationalBilinear(s) => Hull::of(s.restrict(u, v).0.map(ControlPoint::position)),
            Surface::Bicubic(s) => bicubic_hull(level, s, u, v),
            Surface::RationalBicubic(s) => Hull::of(s.restrict(u, v).0.map(ControlPoint::position)),
        }
    }

    /// A side's curve as a homogeneous cubic, weights scaled to sum to 2 at the ends, for comparison only.
    pub fn side_curve(&self, side: usize) -> [Vec4; 4] {
        let lift = |p: [Vec3; 4]| p.map(|p| p.extend(1.0));
        let curve = match self {
            Surface::Bilinear(s) => lift(s.side(side)),
            Surface::RationalBilinear(s) => s.side(side),
            Surface::Bicubic(s) => lift(s.side(side)),
            Surface::RationalBicubic(s) => s.side(side),
        };
        let scale = 2.0 / (curve[0].w + curve[3].w);
        curve.map(|p| p * scale)
    }
}

/// (u, v) on a side at parameter `t`.
#[inline(always)]
pub fn side_uv(side: usize, t: f32) -> [f32; 2] {
    match side {
        0 => [t, 0.0],
        1 => [1.0, t],
        2 => [t, 1.0],
        _ => [0.0, t],
    }
}

/// Corners (indices into [`Patch::corners`]) at the start and the end of a side.
pub const SIDE_CORNERS: [[usize; 2]; 4] = [[0, 1], [1, 3], [2, 3], [0, 2]];

/// (u, v) of a corner.
pub const CORNER_UV: [[f32; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::patchify::patchify;
    use crate::standard::teapot::teapot;

    #[test]
    fn a_side_alone_has_the_curve_that_the_whole_patch_has() {
        let scene = teapot();
        let (table, _) = patchify(&scene, &KeyTimes::still(&scene));
        for (patch, ix) in table.patches.iter().zip(0u32..) {
            let surface = table.control_surface(patch, 0).expect("control points");
            for side in 0..4 {
                assert_eq!(table.side_curve(ix, 0, side), Some(surface.side_curve(side)), "{ix} {side}");
            }
        }
    }
}
