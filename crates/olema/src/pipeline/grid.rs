//! Grids: diced rectangles of vertices, and what the samples need of them.

use std::cmp::Ordering;

use glam::Vec3;

use crate::math::Vec3s;
use crate::scene::{ShadingInterpolation, Sides};

/// Where a grid comes from. Its order is the canonical order that decides between equal depths.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct GridKey {
    /// Primitive in the scene.
    pub primitive: u32,
    /// Patch in the table.
    pub patch: u32,
    /// Halves taken, 0 or 1 a bit below a leading 1.
    pub path: u128,
    /// First column and row where the grid is a block of a larger lattice.
    pub block: [u16; 2],
}

/// A diced rectangle of (m + 1) x (n + 1) vertices, vertex (i, j) at `j * (m + 1) + i`, u along i.
///
/// Micropolygon (i, j) is number `j * m + i`, with corners v0 = (i, j), v1 = (i + 1, j), v2 = (i + 1, j + 1),
/// v3 = (i, j + 1). Arrays with motion hold key after key.
#[derive(Debug, Clone)]
pub struct Grid {
    /// Where it comes from.
    pub key: GridKey,
    /// Columns of micropolygons.
    pub m: u32,
    /// Rows of micropolygons.
    pub n: u32,
    /// Motion keys, at least 1.
    pub keys: u32,
    /// Raster x in 1/256 pixels, per key and vertex.
    pub x: Vec<i32>,
    /// Raster y, down.
    pub y: Vec<i32>,
    /// Depth in camera space.
    pub depth: Vec<f32>,
    /// Signed radius of the circle of confusion in 1/256 pixels; empty without a lens.
    pub coc: Vec<i32>,
    /// Camera-space positions per key and vertex, kept only where a vertex takes the slow path.
    pub slow: Option<SlowVertices>,
    /// Colour and opacity of the vertices, once shaded.
    pub color: Vec3s,
    /// Opacity; empty where all of it is 1.
    pub opacity: Vec3s,
    /// How its micropolygons are drawn.
    pub look: Look,
    /// Raster box of the fast vertices over all keys, `[x0, x1, y0, y1]` in 1/256 pixels, inclusive.
    pub raster: [i32; 4],
}

/// What the samples need to know of a primitive's attributes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// Flat or smooth.
    pub interpolation: ShadingInterpolation,
    /// Sides drawn.
    pub sides: Sides,
    /// Whether a positively oriented micropolygon (in raster space, y down) shows its front.
    pub front_is_positive: bool,
    /// Cuts a hole.
    pub matte: bool,
}

/// Vertices that cannot be placed in fixed point: near the eye plane, outside the guard band.
#[derive(Debug, Clone)]
pub struct SlowVertices {
    /// Position of every vertex in camera space, per key.
    pub p: Vec<Vec3>,
    /// Whether the vertex is slow (at any key).
    pub is_slow: Vec<bool>,
}

impl Grid {
    /// Number of vertices.
    pub fn num_vertices(&self) -> usize {
        (self.m as usize + 1) * (self.n as usize + 1)
    }

    /// Number of micropolygons.
    pub fn num_micropolygons(&self) -> usize {
        self.m as usize * self.n as usize
    }

    /// Vertices v0, v1, v2, v3 of a micropolygon.
    #[inline(always)]
    pub fn corners(&self, micropolygon: usize) -> [usize; 4] {
        let m = self.m as usize;
        let v0 = (micropolygon / m) * (m + 1) + micropolygon % m;
        [v0, v0 + 1, v0 + m + 2, v0 + m + 1]
    }

    /// Whether a micropolygon has a vertex on the slow path.
    #[inline(always)]
    pub fn is_slow(&self, micropolygon: usize) -> bool {
        match &self.slow {
            None => false,
            Some(slow) => self.corners(micropolygon).iter().any(|&v| slow.is_slow[v]),
        }
    }

    /// Whether every vertex is fully opaque.
    pub fn is_opaque(&self) -> bool {
        self.opacity.is_empty()
    }

    /// Canonical order of micropolygon `a` of this grid and `b` of `other`.
    pub fn order(&self, a: u32, other: &Grid, b: u32) -> Ordering {
        self.key.cmp(&other.key).then(a.cmp(&b))
    }
}
