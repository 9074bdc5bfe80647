//! Sample: draw a grid's micropolygons into a tile's buffers.
//!
//! In: `Grid`, the tile's samples. Out: visibility records. Opaque micropolygons compete in the `SampleBuffer`;
//! those that are not quite opaque add to the `TransparentRecords`. Colours are not touched.

use std::cmp::Ordering;
use std::collections::HashMap;
use std::sync::Arc;

use crate::geometry::RasterCamera;
use crate::sampling::nomotion::{
    Facing, GridView, HitSink, SampleCounts, rasterize_grid, rasterize_triangle,
};
use crate::sampling::{Payload, Region, RegionSamples, SampleBuffer, TransparentRecord, TransparentRecords};
use crate::scene::Sides;

use super::clip::clip_triangle;
use super::grid::{Grid, GridKey};

/// Grids of a tile, by the slot that records name them with.
#[derive(Debug, Default)]
pub struct GridSlots {
    slots: Vec<(GridKey, Option<Arc<Grid>>)>,
    known: HashMap<GridKey, u32>,
}

/// All slots of a tile are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SlotsFull;

impl GridSlots {
    /// Forgets everything.
    pub fn clear(&mut self) {
        self.slots.clear();
        self.known.clear();
    }

    /// Gives `grid` a slot, the one it had in an earlier pass if it was drawn in one.
    ///
    /// # Errors
    /// [`SlotsFull`] where the payload has no number left for it.
    pub fn insert(&mut self, grid: Arc<Grid>) -> Result<u32, SlotsFull> {
        let next = self.slots.len() as u32;
        if let Some(&slot) = self.known.get(&grid.key) {
            self.slots[slot as usize].1 = Some(grid);
            return Ok(slot);
        }
        if next >= Payload::NUM_SLOTS {
            return Err(SlotsFull);
        }
        self.known.insert(grid.key, next);
        self.slots.push((grid.key, Some(grid)));
        Ok(next)
    }

    /// The grid of a record.
    pub fn grid(&self, payload: Payload) -> Option<&Grid> {
        self.slots.get(payload.slot() as usize).and_then(|(_, grid)| grid.as_deref())
    }

    /// Number of slots taken.
    pub fn len(&self) -> usize {
        self.slots.len()
    }

    /// Whether no slot is taken.
    pub fn is_empty(&self) -> bool {
        self.slots.is_empty()
    }

    /// Lets go of grids that no record names any more; their slots stay taken, so that payloads keep their
    /// meaning.
    pub fn retain_used(&mut self, used: impl Iterator<Item = Payload>) {
        let mut is_used = vec![false; self.slots.len()];
        for payload in used {
            if let Some(flag) = is_used.get_mut(payload.slot() as usize) {
                *flag = true;
            }
        }
        for ((_, grid), used) in self.slots.iter_mut().zip(is_used) {
            if !used {
                *grid = None;
            }
        }
    }

    /// Canonical order of two hits, for equal depths.
    pub fn order(&self, a: Payload, b: Payload) -> Ordering {
        let key = |p: Payload| self.slots.get(p.slot() as usize).map(|(key, _)| *key);
        key(a)
            .cmp(&key(b))
            .then(a.micropolygon().cmp(&b.micropolygon()))
            .then(a.triangle().cmp(&b.triangle()))
    }
}

/// Where a tile's hits are kept.
#[derive(Debug)]
pub struct TileBuffers {
    /// Places of the samples.
    pub samples: RegionSamples,
    /// Nearest opaque hits.
    pub nearest: SampleBuffer,
    /// Hits of what is not quite opaque.
    pub transparent: TransparentRecords,
    /// What payloads mean.
    pub slots: GridSlots,
    /// Work done.
    pub counts: SampleCounts,
}

impl TileBuffers {
    /// Draws `grid`.
    ///
    /// # Errors
    /// [`SlotsFull`] where the tile has no slot left; nothing was drawn then.
    pub fn draw(&mut self, camera: &RasterCamera, grid: &Arc<Grid>) -> Result<(), SlotsFull> {
        if !touches(grid, self.samples.region) {
            return Ok(());
        }
        let slot = self.slots.insert(Arc::clone(grid))?;
        let facing = match (grid.look.sides, grid.look.front_is_positive) {
            (Sides::Two, _) => Facing::Any,
            (Sides::One, true) => Facing::Only(1),
            (Sides::One, false) => Facing::Only(-1),
        };
        let mut sink = Sink {
            grid,
            slot,
            micropolygon: 0,
            triangle: None,
            opaque: true,
            nearest: &mut self.nearest,
            transparent: &mut self.transparent,
            slots: &self.slots,
        };
        let view =
            GridView { m: grid.m as usize, n: grid.n as usize, x: &grid.x, y: &grid.y, depth: &grid.depth };
        let skip = grid.slow.as_ref().map(|slow| slow.is_slow.as_slice());
        rasterize_grid(view, facing, skip, &self.samples, &mut self.counts, &mut sink);
        if grid.slow.is_some() {
            draw_slow(camera, grid, facing, &self.samples, &mut self.counts, &mut sink);
        }
        Ok(())
    }
}

impl TileBuffers {
    /// Lets go of grids that no record names any more, so that memory does not grow with depth complexity.
    pub fn drop_hidden_grids(&mut self) {
        let opaque = self.nearest.records().iter().filter(|r| !r.is_none()).map(|r| r.payload);
        let transparent = self.transparent.records().iter().map(|r| r.payload);
        self.slots.retain_used(opaque.chain(transparent));
    }
}

/// Whether a grid's raster box meets the region; a grid with slow vertices may be anywhere.
fn touches(grid: &Grid, region: Region) -> bool {
    if grid.slow.is_some() {
        return true;
    }
    let [x0, x1, y0, y1] = grid.raster.map(|c| c >> 8);
    x1 >= region.x0 && x0 < region.x1 && y1 >= region.y0 && y0 < region.y1
}

/// Draws the micropolygons that have a vertex on the slow path, clipped.
fn draw_slow(
    camera: &RasterCamera,
    grid: &Grid,
    facing: Facing,
    samples: &RegionSamples,
    counts: &mut SampleCounts,
    sink: &mut Sink,
) {
    for micropolygon in (0..grid.num_micropolygons()).filter(|&mp| grid.is_slow(mp)) {
        sink.begin(micropolygon as u32);
        for (number, triangle) in triangles(grid, micropolygon).into_iter().enumerate() {
            sink.triangle = Some(number as u8);
            for part in clip_slow(camera, grid, triangle).triangles() {
                rasterize_triangle(
                    part.map(|v| v.raster),
                    part.map(|v| v.depth),
                    facing,
                    samples,
                    counts,
                    sink,
                );
            }
        }
        sink.triangle = None;
    }
}

/// The two triangles of a micropolygon, as vertices of its grid.
pub fn triangles(grid: &Grid, micropolygon: usize) -> [[usize; 3]; 2] {
    let [v0, v1, v2, v3] = grid.corners(micropolygon);
    [[v0, v1, v2], [v0, v2, v3]]
}

/// A triangle of a grid with slow vertices, clipped.
pub fn clip_slow(camera: &RasterCamera, grid: &Grid, triangle: [usize; 3]) -> super::clip::Clipped {
    let slow = grid.slow.as_ref();
    let position = |v: usize| slow.map_or(glam::Vec3::ZERO, |slow| slow.p[v]);
    let fixed = |v: usize| {
        let is_slow = slow.is_some_and(|slow| slow.is_slow[v]);
        (!is_slow).then(|| [grid.x[v], grid.y[v]])
    };
    clip_triangle(camera, triangle.map(position), triangle.map(fixed))
}

/// Sends hits where they belong.
struct Sink<'a> {
    grid: &'a Grid,
    slot: u32,
    micropolygon: u32,
    /// Number of the triangle where a part of one is drawn.
    triangle: Option<u8>,
    opaque: bool,
    nearest: &'a mut SampleBuffer,
    transparent: &'a mut TransparentRecords,
    slots: &'a GridSlots,
}

impl HitSink for Sink<'_> {
    fn begin(&mut self, micropolygon: u32) {
        self.micropolygon = micropolygon;
        self.opaque = self.grid.is_opaque() || {
            let o = &self.grid.opacity;
            let corners = self.grid.corners(micropolygon as usize);
            corners.iter().all(|&v| o.x[v] >= 1.0 && o.y[v] >= 1.0 && o.z[v] >= 1.0)
        };
    }

    fn hit(&mut self, sample_ix: usize, depth: f32, triangle: u8, _sign: i8) {
        let payload = Payload::new(self.slot, self.micropolygon, self.triangle.unwrap_or(triangle));
        let order = |a, b| self.slots.order(a, b);
        if self.opaque {
            self.nearest.offer(sample_ix, depth, payload, &order);
        } else {
            let record = TransparentRecord { sample_ix: sample_ix as u32, depth, payload };
            self.transparent.push(record, self.nearest, &order);
        }
    }
}
