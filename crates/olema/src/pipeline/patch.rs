//! Patches: surfaces over the unit square in camera space, all of them in one table.
//!
//! In: made by `patchify`. Out: read by every later stage; never changed once `connect` is done.

use glam::{Vec3, Vec4};

use crate::geometry::SurfacePoint;
use crate::geometry::bezier::{Bicubic, Bilinear, ControlPoint};

use super::connect::EdgeUse;

/// What a patch's control points mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// Four corners: (0,0), (1,0), (0,1), (1,1).
    Bilinear,
    /// Sixteen Bezier points, u first.
    Bicubic,
}

impl Shape {
    /// Number of control points.
    pub fn num_points(self) -> usize {
        match self {
            Shape::Bilinear => 4,
            Shape::Bicubic => 16,
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
    /// First float of its control points; keys follow each other.
    pub first_float: u32,
    /// Sides 0: v = 0, 1: u = 1, 2: v = 1, 3: u = 0, each with u or v ascending.
    pub edges: [EdgeUse; 4],
    /// Welded corners at (u, v) = (0,0), (1,0), (0,1), (1,1).
    pub corners: [u32; 4],
    /// `[u0, u1, v0, v1]` in the primitive's parameters.
    pub params: [f32; 4],
    /// How far, in camera units, a welded neighbour's border may lie from this patch's own.
    pub slack: f32,
}

/// All patches of a frame.
#[derive(Debug, Clone, Default)]
pub struct PatchTable {
    /// In canonical order: by primitive, then by place in it.
    pub patches: Vec<Patch>,
    /// Control points, 3 or 4 floats each, in camera space.
    pub floats: Vec<f32>,
    /// Motion keys of every patch (1: still).
    pub num_keys: usize,
}

/// A patch's surface at one motion key, ready to evaluate.
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
    /// The surface of `patch` at motion key `key`.
    pub fn surface(&self, patch: &Patch, key: usize) -> Surface {
        let width = if patch.rational { 4 } else { 3 };
        let len = width * patch.shape.num_points();
        let first = patch.first_float as usize + key * len;
        let floats = &self.floats[first..first + len];
        let p3 = |ix: usize| Vec3::from_slice(&floats[3 * ix..]);
        let p4 = |ix: usize| Vec4::from_slice(&floats[4 * ix..]);
        match (patch.shape, patch.rational) {
            (Shape::Bilinear, false) => Surface::Bilinear(Bilinear(std::array::from_fn(p3))),
            (Shape::Bilinear, true) => Surface::RationalBilinear(Bilinear(std::array::from_fn(p4))),
            (Shape::Bicubic, false) => Surface::Bicubic(Bicubic(std::array::from_fn(p3))),
            (Shape::Bicubic, true) => Surface::RationalBicubic(Bicubic(std::array::from_fn(p4))),
        }
    }
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

    /// Calls `visit` with points whose convex hull holds the surface over `u` x `v`.
    pub fn hull(&self, u: [f32; 2], v: [f32; 2], mut visit: impl FnMut(Vec3)) {
        fn all<P: ControlPoint>(points: &[P], visit: &mut impl FnMut(Vec3)) {
            points.iter().for_each(|p| visit(p.position()));
        }
        match self {
            Surface::Bilinear(s) => all(&s.restrict(u, v).0, &mut visit),
            Surface::RationalBilinear(s) => all(&s.restrict(u, v).0, &mut visit),
            Surface::Bicubic(s) => all(&s.restrict(u, v).0, &mut visit),
            Surface::RationalBicubic(s) => all(&s.restrict(u, v).0, &mut visit),
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
