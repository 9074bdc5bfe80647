//! Grids: diced rectangles of vertices, and what the samples need of them.

use std::cmp::Ordering;

use glam::Vec3;

use crate::geometry::RasterCamera;
use crate::geometry::place_lanes::Reach;
use crate::sampling::Region;
use crate::scene::{ShadingInterpolation, Sides};

use super::key_extent::{KeyExtent, sweep};
use super::sweep::{Extent, Sweep, TimeRange};
use super::waiting::{Packed, RasterLists};

/// More than the rounding of positions: each of their terms is rounded to 1/256 of a pixel.
const ROUNDING_PX: f32 = 1.0 / 64.0;

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
    /// Its set of key times, of [`super::motion::KeyTimes::sets`].
    pub motion: u32,
    /// Where vertices are on the raster, and their circles of confusion, empty without a lens; nothing where that is packed.
    pub on_raster: RasterLists,
    /// The same, where the grid waits.
    pub packed: Option<Packed>,
    /// Depth in camera space.
    pub depth: Vec<f32>,
    /// Vertices on the slow path.
    pub slow: SlowVertices,
    /// How its micropolygons are drawn.
    pub look: Look,
    /// Where its vertices are when, circles of confusion included.
    pub sweep: Sweep,
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
#[derive(Debug, Clone, Default)]
pub struct SlowVertices {
    /// Position of every vertex in camera space, per key; empty where no vertex is slow.
    pub p: Vec<Vec3>,
    /// Whether the vertex is slow (at any key); empty where none is.
    pub is_slow: Vec<bool>,
}

/// Where vertices are that are within `reach` at a key.
pub fn extent(reach: &Reach) -> Extent {
    let pixels = |ends: [i32; 2]| ends.map(|end| end as f32 / 256.0);
    let ([x0, x1], [y0, y1]) = (pixels(reach.x), pixels(reach.y));
    Extent {
        in_focus: [x0 - ROUNDING_PX, x1 + ROUNDING_PX, y0 - ROUNDING_PX, y1 + ROUNDING_PX],
        coc: pixels(reach.coc),
        near: reach.near,
    }
}

impl Grid {
    /// A grid without vertices, with room for `capacity` of them over all keys.
    pub fn empty(key: GridKey, look: Look, capacity: usize) -> Self {
        Grid {
            key,
            m: 0,
            n: 0,
            keys: 0,
            motion: 0,
            on_raster: RasterLists {
                x: Vec::with_capacity(capacity),
                y: Vec::with_capacity(capacity),
                coc: Vec::new(),
            },
            packed: None,
            depth: Vec::with_capacity(capacity),
            slow: SlowVertices::default(),
            look,
            sweep: Sweep::default(),
        }
    }

    /// Once the vertices of all keys are placed: bounds them, and lets go of what is not needed. `keys` is where they are
    /// at each; it means nothing if any is slow.
    pub fn close(&mut self, camera: &RasterCamera, key_times: &[f32], keys: &[Extent]) {
        if self.has_slow() {
            let extent = |p: &[Vec3]| {
                let mut extent = KeyExtent::EMPTY;
                p.iter().for_each(|&p| extent.include(camera, p));
                extent
            };
            let keys: Vec<KeyExtent> = self.slow.p.chunks(self.num_vertices()).map(extent).collect();
            self.sweep = sweep(camera, &keys, key_times, ROUNDING_PX);
        } else {
            self.sweep = Sweep::of_keys(keys, key_times);
        }
        let coc = &mut self.on_raster.coc;
        if coc.iter().all(|&coc| coc == 0) {
            coc.clear();
        }
    }

    /// When a sample of `region` can see it; `None` where none can.
    pub fn meets(&self, region: Region) -> Option<TimeRange> {
        self.sweep.meets_region(&region)
    }

    /// Whether it moves or is out of focus.
    pub fn is_blurred(&self) -> bool {
        let is_sharp = self.packed.as_ref().map_or(self.on_raster.coc.is_empty(), |packed| packed.is_sharp());
        self.keys > 1 || !is_sharp
    }

    /// Whether any vertex takes the slow path.
    pub fn has_slow(&self) -> bool {
        !self.slow.is_slow.is_empty()
    }

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
        // Before it are a vertex for each micropolygon, and one more for each row.
        let (m, v0) = (self.m as usize, micropolygon + (micropolygon as u32 / self.m) as usize);
        [v0, v0 + 1, v0 + m + 2, v0 + m + 1]
    }

    /// Whether a micropolygon has a vertex on the slow path.
    #[inline(always)]
    pub fn is_slow(&self, micropolygon: usize) -> bool {
        self.has_slow() && self.corners(micropolygon).iter().any(|&v| self.slow.is_slow[v])
    }

    /// Canonical order of micropolygon `a` of this grid and `b` of `other`.
    pub fn order(&self, a: u32, other: &Grid, b: u32) -> Ordering {
        self.key.cmp(&other.key).then(a.cmp(&b))
    }
}

/// The two triangles of a micropolygon, as vertices of its grid.
#[inline(always)]
pub fn triangles(grid: &Grid, micropolygon: usize) -> [[usize; 3]; 2] {
    let [v0, v1, v2, v3] = grid.corners(micropolygon);
    [[v0, v1, v2], [v0, v2, v3]]
}
