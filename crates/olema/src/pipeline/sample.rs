//! Sample: draw a grid's micropolygons into a tile's buffers.
//!
//! In: `Grid`, the tile's samples. Out: visibility records. Opaque micropolygons compete in the `SampleBuffer`;
//! those that are not quite opaque add to the `TransparentRecords`. Colours are not touched.

use std::sync::Arc;

use glam::Vec3;

use crate::geometry::RasterCamera;
use crate::math::Vec3s;
use crate::math::lanes::Lanes;
use crate::math::simd::SimdLevel;
use crate::sampling::inside::{HitPoint, Weights};
use crate::sampling::interleave::rasterize_tuple;
use crate::sampling::nomotion::{
    Facing, HitPoints, HitSink, HitsApart, SampleCounts, each_hit, each_hit_apart, rasterize_triangle,
};
use crate::sampling::{
    Kernels, Micropolygons, MovingDraw, MovingGrid, Payload, Rasterizer, Record, RegionSamples, SampleBuffer,
    SamplePattern, TransparentRecord, TransparentRecords, TupleTimes,
};
use crate::scene::Sides;

use super::clip::{Clipped, clip_triangle};
use super::grid::{Grid, triangles};
use super::shade::{Colors, ShadedGrid};
use super::slots::{GridSlots, SlotsFull, UsedVertices};
use super::sweep::TimeRange;
use super::waiting::RasterLists;

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
    /// Vertices that visible micropolygons use.
    pub used: UsedVertices,
    /// Work done.
    pub counts: SampleCounts,
    /// Where a grid is that was packed.
    pub room: RasterLists,
}

/// What all grids of a frame are drawn with.
#[derive(Debug, Clone, Copy)]
pub struct DrawContext<'a> {
    /// The camera.
    pub camera: &'a RasterCamera,
    /// The sample pattern.
    pub pattern: &'a SamplePattern,
    /// Local times of its tuples, for each set of key times.
    pub times: &'a [TupleTimes],
    /// The rasterizer that was asked for.
    pub rasterizer: Rasterizer,
    /// What does its work; the picture is the same.
    pub kernels: Kernels,
}

impl<'a> DrawContext<'a> {
    /// A grid as the rasterizers see it; `room` is for one that is packed.
    pub fn moving<'g>(&self, grid: &'g Grid, room: &'g mut RasterLists) -> MovingGrid<'g>
    where
        'a: 'g,
    {
        let RasterLists { x, y, coc } = grid.lists(SimdLevel::best(), room);
        MovingGrid {
            m: grid.m as usize,
            n: grid.n as usize,
            times: &self.times[grid.motion as usize],
            x,
            y,
            depth: &grid.depth,
            coc,
        }
    }

    /// A triangle of a grid with slow vertices, clipped as it is for a tuple.
    ///
    /// Vertices that are not slow are where the rasterizers see them; the others move on straight lines in camera
    /// space. Which of both a vertex does depends on the vertex alone.
    pub fn clip(&self, grid: &Grid, triangle: [usize; 3], tuple_ix: u32) -> Clipped {
        let mut room = RasterLists::default();
        let moving = self.moving(grid, &mut room);
        let (tuple, time) = (&self.pattern.tuples()[tuple_ix as usize], moving.times.of_tuple(tuple_ix));
        let position = |v: usize| -> Vec3 {
            let [from, to] = moving.ends(v, time.segment);
            let (from, to) = (grid.slow.p[from], grid.slow.p[to]);
            let t = f32::from(time.t15) * (1.0 / 32_768.0);
            let xy = from + (to - from) * t;
            Vec3::new(xy.x, xy.y, moving.depth_at(v, time))
        };
        let fixed = |v: usize| (!grid.slow.is_slow[v]).then(|| moving.position(v, tuple, time));
        clip_triangle(self.camera, triangle.map(position), triangle.map(fixed), [tuple.u15, tuple.v15])
    }
}

impl TileBuffers {
    /// Draws `shaded`, of which `colors` are known if it is not surely opaque. Its slot, if a
    /// sample keeps anything of it.
    ///
    /// # Errors
    /// [`SlotsFull`] where the tile has no slot left; nothing was drawn then.
    pub fn draw(
        &mut self,
        context: &DrawContext,
        shaded: &Arc<ShadedGrid>,
        colors: Option<&Arc<Colors>>,
    ) -> Result<Option<u32>, SlotsFull> {
        let grid = &shaded.grid;
        debug_assert!(shaded.surely_opaque || colors.is_some(), "opacity decides what is visible");
        let Some(times) = grid.meets(self.samples.region) else {
            return Ok(None);
        };
        let moving = context.moving(grid, &mut self.room);
        let (slot, is_new) = self.slots.insert(Arc::clone(shaded), colors.cloned())?;
        let facing = match (grid.look.sides, grid.look.front_is_positive) {
            (Sides::Two, _) => Facing::Any,
            (Sides::One, true) => Facing::Only(1),
            (Sides::One, false) => Facing::Only(-1),
        };
        let mut sink = Sink {
            grid,
            opacity: colors.map(|colors| &colors.opacity).filter(|opacity| !opacity.is_empty()),
            kept: false,
            slot,
            micropolygon: 0,
            part: None,
            opaque: true,
            nearest: &mut self.nearest,
            transparent: &mut self.transparent,
            slots: &self.slots,
        };
        let draw = MovingDraw {
            grid: moving,
            pattern: context.pattern,
            samples: &self.samples,
            facing,
            skip: grid.has_slow().then_some(grid.slow.is_slow.as_slice()),
            micropolygons: Micropolygons::Quads,
            // Parts of the shutter are grown by more than this rounds off.
            times: times.map(|t| (t * 32_768.0).clamp(0.0, 32_767.0) as i16),
            kernels: context.kernels,
        };
        let drawn = context.rasterizer.rasterize(&draw, &mut self.counts, &mut sink);
        debug_assert!(drawn.is_ok(), "settings were checked: {drawn:?}");
        if grid.has_slow() {
            draw_slow(context, grid, times, facing, &self.samples, &mut self.counts, &mut sink);
        }
        if sink.kept {
            return Ok(Some(slot));
        }
        // In a later pass, records of an earlier one may name it.
        if is_new {
            self.slots.take_back();
        }
        Ok(None)
    }

    /// Adds the vertices of the nearest opaque hits to [`Self::used`].
    pub fn note_used(&mut self) {
        let TileBuffers { nearest, slots, used, .. } = self;
        nearest.each_named(
            #[inline(always)]
            |payload| {
                if !used.insert_known(payload)
                    && let Some(shaded) = slots.grid(payload.slot())
                {
                    used.insert(&shaded.grid, payload);
                }
            },
        );
    }

    /// Lets go of grids that no record names any more, so that memory does not grow with depth complexity.
    pub fn drop_hidden_grids(&mut self) {
        let opaque = self.nearest.records().filter(|r| !r.is_none()).map(|r| r.payload);
        let transparent = self.transparent.records().iter().map(|r| r.hit.payload);
        self.slots.retain_used(opaque.chain(transparent));
    }
}

/// Draws the micropolygons that have a vertex on the slow path: clipped, once for each tuple where they are blurred.
fn draw_slow(
    context: &DrawContext,
    grid: &Grid,
    times: TimeRange,
    facing: Facing,
    samples: &RegionSamples,
    counts: &mut SampleCounts,
    sink: &mut Sink,
) {
    let is_blurred = grid.keys > 1 || context.camera.lens.is_some();
    let tuples = context.pattern.tuples().iter().zip(0u32..);
    let within = |t15: i16| (times[0]..=times[1]).contains(&(f32::from(t15) / 32_768.0));
    let tuples: Vec<u32> = match is_blurred {
        true => tuples.filter(|(tuple, _)| within(tuple.t15)).map(|(_, ix)| ix).collect(),
        false => vec![0],
    };
    for micropolygon in (0..grid.num_micropolygons()).filter(|&mp| grid.is_slow(mp)) {
        sink.begin(micropolygon as u32);
        for (number, triangle) in triangles(grid, micropolygon).into_iter().enumerate() {
            for &tuple_ix in &tuples {
                for part in context.clip(grid, triangle, tuple_ix).triangles() {
                    sink.part = Some(Part { triangle: number as u8, weights: part.map(|v| v.weights) });
                    let (raster, depth) = (part.map(|v| v.raster), part.map(|v| v.depth));
                    if is_blurred {
                        rasterize_tuple(
                            context.pattern,
                            tuple_ix,
                            raster,
                            depth,
                            facing,
                            samples,
                            counts,
                            sink,
                        );
                    } else {
                        rasterize_triangle(raster, depth, facing, samples, counts, sink);
                    }
                }
            }
        }
        sink.part = None;
    }
}

/// A part of a triangle that was clipped.
#[derive(Clone, Copy)]
struct Part {
    /// Number of the triangle.
    triangle: u8,
    /// Weights of the triangle's vertices in each of the part's.
    weights: [[f32; 3]; 3],
}

impl Part {
    /// Weights of the triangle's vertices from those of the part's.
    fn of_whole(&self, weights: Weights) -> Weights {
        let [w0, w1, w2] = weights.get();
        let [a, b, c] = self.weights;
        Weights::new([1, 2].map(|vertex| a[vertex] * w0 + b[vertex] * w1 + c[vertex] * w2))
    }
}

/// Sends hits where they belong.
struct Sink<'a> {
    grid: &'a Grid,
    /// Opacity of its vertices, if any is not opaque.
    opacity: Option<&'a Vec3s>,
    /// Whether a hit was kept.
    kept: bool,
    slot: u32,
    micropolygon: u32,
    /// Where a part of a triangle is drawn.
    part: Option<Part>,
    opaque: bool,
    nearest: &'a mut SampleBuffer,
    transparent: &'a mut TransparentRecords,
    slots: &'a GridSlots,
}

impl HitSink for Sink<'_> {
    fn begin(&mut self, micropolygon: u32) {
        self.micropolygon = micropolygon;
        self.opaque = self.opacity.is_none_or(|o| {
            let corners = self.grid.corners(micropolygon as usize);
            corners.iter().all(|&v| o.x()[v] >= 1.0 && o.y()[v] >= 1.0 && o.z()[v] >= 1.0)
        });
    }

    fn hit(&mut self, sample_ix: usize, point: HitPoint, triangle: u8, _sign: i8) {
        let (triangle, weights) = match &self.part {
            Some(part) => (part.triangle, part.of_whole(point.weights)),
            None => (triangle, point.weights),
        };
        let hit = Record {
            depth: point.depth,
            payload: Payload::new(self.slot, self.micropolygon, triangle),
            weights,
        };
        let order = |a, b| self.slots.order(a, b);
        if self.opaque {
            self.kept |= self.nearest.offer(sample_ix, hit, &order);
        } else {
            self.kept = true;
            let record = TransparentRecord { sample_ix: sample_ix as u32, hit };
            self.transparent.push(record, self.nearest, &order);
        }
    }

    #[inline(always)]
    fn hits<L: Lanes>(
        &mut self,
        lanes: L,
        first: usize,
        hits: [u32; 2],
        points: HitPoints<L>,
        negative: u32,
    ) {
        if !self.opaque || self.part.is_some() {
            return each_hit(self, lanes, first, hits, points, negative);
        }
        let payloads = [0, 1].map(|triangle| Payload::new(self.slot, self.micropolygon, triangle));
        let slots = self.slots;
        let order = |a, b| slots.order(a, b);
        self.kept |= self.nearest.offer_lanes(lanes, first, hits, points, payloads, &order);
    }

    #[inline(always)]
    fn hits_apart(&mut self, hits: &HitsApart) {
        if self.opacity.is_some() || self.part.is_some() {
            return each_hit_apart(self, hits);
        }
        let slots = self.slots;
        self.kept |= self.nearest.offer_apart(hits, self.slot, &|a, b| slots.order(a, b));
    }
}
