//! One tile: what may be seen in it is split, diced, shaded and drawn, nearest first, then resolved.

use std::cell::RefCell;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::sync::Arc;

use crate::error::Error;
use crate::pipeline::bound::{Bound, bound};
use crate::pipeline::dice::dice;
use crate::pipeline::displace::Corrections;
use crate::pipeline::piece::{Piece, PieceKind};
use crate::pipeline::resolve::{Pixel, SampleColor, composite_opaque, composite_pass, filter_pixels};
use crate::pipeline::sample::{GridSlots, TileBuffers};
use crate::pipeline::shade::shade;
use crate::pipeline::split::{Fate, SplitContext};
use crate::pipeline::workspace::Workspace;
use crate::pipeline::{Grid, GridKey};
use crate::sampling::nomotion::SampleCounts;
use crate::sampling::{Region, RegionSamples, SampleBuffer, TransparentRecords};
use crate::stats::Stats;

use super::cache::{GridCache, Lookup};
use super::frame::{Filed, FrameData, MOST_AT_EYE, Source, count_unseen, weight_at_eye};
use super::{Hooks, Stopwatch};

/// Grids drawn between two looks for grids that nothing needs any more.
const DRAWN_BETWEEN_CLEANUPS: usize = 4096;

/// A pixel whose filter finds nothing.
const EMPTY_PIXEL: Pixel = [0.0, 0.0, 0.0, 0.0, f32::INFINITY];

/// Draws tiles, one after the other, in the same memory.
pub(super) struct TileWorker<'a> {
    frame: &'a FrameData<'a>,
    context: SplitContext<'a>,
    filed: &'a Filed,
    cache: &'a GridCache,
    hooks: &'a Hooks<'a>,
    buffers: TileBuffers,
    colors: Vec<SampleColor>,
    pub corrections: RefCell<Corrections>,
    workspace: RefCell<Workspace>,
    pub stats: Stats,
}

/// Why a tile could not be drawn as a whole.
enum Stop {
    Cancelled,
    /// No slot left: its quarters have to be drawn.
    SlotsFull,
}

impl<'a> TileWorker<'a> {
    pub fn new(
        frame: &'a FrameData<'a>,
        filed: &'a Filed,
        cache: &'a GridCache,
        hooks: &'a Hooks<'a>,
    ) -> Self {
        let nothing = Region::new(0, 0, 0, 0);
        let samples_per_pixel = frame.pattern.samples_per_pixel() as usize;
        let buffers = TileBuffers {
            samples: RegionSamples::new(&frame.pattern, nothing),
            nearest: SampleBuffer::new(nothing, samples_per_pixel),
            transparent: TransparentRecords::new(frame.settings.transparency_records),
            slots: GridSlots::default(),
            counts: SampleCounts::default(),
        };
        TileWorker {
            frame,
            context: frame.context(),
            filed,
            cache,
            hooks,
            buffers,
            colors: Vec::new(),
            corrections: RefCell::default(),
            workspace: RefCell::default(),
            stats: Stats::default(),
        }
    }

    /// The finished pixels of a tile.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn draw(&mut self, tile: usize) -> Result<Vec<Pixel>, Error> {
        if self.hooks.is_cancelled() {
            return Err(Error::Cancelled);
        }
        let interior = self.frame.tiles.interior(tile);
        if self.filed.of_tile(tile).next().is_none() {
            let mut pixels = vec![EMPTY_PIXEL; interior.num_pixels()];
            self.finish(&mut pixels);
            return Ok(pixels);
        }
        self.draw_region(tile, interior)
    }

    /// Draws a part of a tile, in quarters where it has too many grids.
    fn draw_region(&mut self, tile: usize, interior: Region) -> Result<Vec<Pixel>, Error> {
        match self.passes(tile, interior) {
            Ok(()) => {
                let watch = Stopwatch::new(self.hooks);
                let mut pixels = Vec::with_capacity(interior.num_pixels());
                filter_pixels(&self.frame.filter, &self.buffers.samples, &self.colors, interior, &mut pixels);
                self.finish(&mut pixels);
                self.stats.seconds.resolve += watch.seconds();
                Ok(pixels)
            }
            Err(Stop::Cancelled) => Err(Error::Cancelled),
            Err(Stop::SlotsFull) if interior.num_pixels() > 1 => self.draw_halves(tile, interior),
            Err(Stop::SlotsFull) => Err(Error::Memory {
                what: "the grids of one pixel",
                needed: u64::from(crate::sampling::Payload::NUM_SLOTS) + 1,
                granted: u64::from(crate::sampling::Payload::NUM_SLOTS),
            }),
        }
    }

    fn draw_halves(&mut self, tile: usize, r: Region) -> Result<Vec<Pixel>, Error> {
        if r.height() > 1 {
            let middle = r.y0 + r.height() as i32 / 2;
            let mut pixels = self.draw_region(tile, Region::new(r.x0, r.x1, r.y0, middle))?;
            pixels.extend(self.draw_region(tile, Region::new(r.x0, r.x1, middle, r.y1))?);
            return Ok(pixels);
        }
        let middle = r.x0 + r.width() as i32 / 2;
        let mut pixels = self.draw_region(tile, Region::new(r.x0, middle, r.y0, r.y1))?;
        pixels.extend(self.draw_region(tile, Region::new(middle, r.x1, r.y0, r.y1))?);
        Ok(pixels)
    }

    /// Draws everything, again as long as transparent records did not fit.
    fn passes(&mut self, tile: usize, interior: Region) -> Result<(), Stop> {
        let region = self.frame.tiles.sample_region(interior);
        self.buffers.samples.renew(&self.frame.pattern, region);
        self.buffers.nearest.renew(region);
        self.buffers.transparent.renew();
        self.buffers.slots.clear();
        self.buffers.counts = SampleCounts::default();
        self.colors.clear();
        self.colors.resize(self.buffers.samples.len(), SampleColor::EMPTY);
        loop {
            self.buffers.transparent.begin_pass();
            self.pass(tile, region)?;
            let watch = Stopwatch::new(self.hooks);
            composite_pass(&self.frame.draw_context(), &mut self.buffers, &mut self.colors);
            self.stats.seconds.resolve += watch.seconds();
            if !self.buffers.transparent.needs_another_pass() {
                break;
            }
            self.stats.peels += 1;
        }
        let watch = Stopwatch::new(self.hooks);
        composite_opaque(&self.frame.draw_context(), &self.buffers, &mut self.colors);
        self.stats.seconds.resolve += watch.seconds();
        let counts = self.buffers.counts;
        self.stats.sample_tests += counts.tests;
        self.stats.sample_hits += counts.hits;
        self.stats.culled.backface += counts.backfacing;
        Ok(())
    }

    /// Takes the tile's pieces nearest first, and cuts or draws each.
    fn pass(&mut self, tile: usize, region: Region) -> Result<(), Stop> {
        let frame = self.frame;
        let mut queue = BinaryHeap::new();
        for entry in self.filed.of_tile(tile) {
            queue.push(Queued { near: entry.near, work: Work::Filed(entry.source) });
        }
        let (mut drawn, mut at_eye) = (0, 0);
        while let Some(Queued { work, .. }) = queue.pop() {
            if self.hooks.is_cancelled() {
                return Err(Stop::Cancelled);
            }
            let watch = Stopwatch::new(self.hooks);
            let piece = match work {
                Work::Filed(Source::Patch(patch)) => self.context.whole(patch),
                Work::Filed(Source::Piece(ix)) => self.filed.pieces[ix as usize],
                Work::Piece(piece) => *piece,
            };
            let Some(bounds) = count_unseen(bound(&self.context, &piece, &region), &mut self.stats) else {
                self.stats.seconds.split += watch.seconds();
                continue;
            };
            at_eye += weight_at_eye(&bounds);
            if at_eye > MOST_AT_EYE {
                let warning =
                    "too many pieces pass the eye in one tile; the rest of them is not drawn".to_owned();
                if !self.stats.warnings.contains(&warning) {
                    self.stats.warnings.push(warning);
                }
                continue;
            }
            match self.context.fate(&piece) {
                Fate::Split(halves) => {
                    self.stats.splits += 1;
                    for half in halves {
                        queue.push(Queued { near: bounds.depth[0], work: Work::Piece(Box::new(half)) });
                    }
                    self.stats.seconds.split += watch.seconds();
                }
                Fate::Dice(piece) => {
                    self.stats.seconds.split += watch.seconds();
                    let grid = self.grid(&piece, &bounds);
                    let watch = Stopwatch::new(self.hooks);
                    self.buffers.draw(&frame.draw_context(), &grid).map_err(|_| Stop::SlotsFull)?;
                    self.stats.seconds.sample += watch.seconds();
                    drawn += 1;
                    if drawn % DRAWN_BETWEEN_CLEANUPS == 0 {
                        self.buffers.drop_hidden_grids();
                    }
                }
            }
        }
        Ok(())
    }

    /// The grid of a piece, made here or by another tile.
    fn grid(&mut self, piece: &Piece, bounds: &Bound) -> Arc<Grid> {
        let PieceKind::Lattice { i, j, .. } = piece.kind else {
            unreachable!("only pieces with a lattice are diced");
        };
        let patch = &self.frame.patches.patches[piece.patch as usize];
        let key =
            GridKey { primitive: patch.primitive, patch: piece.patch, path: piece.path, block: [i[0], j[0]] };
        let num_vertices = (u64::from(i[1] - i[0]) + 1) * (u64::from(j[1] - j[0]) + 1);
        let num_keys = self.frame.patches.num_keys(piece.patch) as u64;
        let bytes = num_vertices * (24 + 16 * num_keys) + size_of::<Grid>() as u64;
        match self.cache.look_up(&key, self.frame.num_touched(bounds), bytes) {
            Lookup::Shared(shared) => Arc::clone(shared.get_or_init(|| self.make(piece))),
            Lookup::Alone { again } => {
                self.stats.grids_again += u64::from(again);
                self.make(piece)
            }
        }
    }

    fn make(&mut self, piece: &Piece) -> Arc<Grid> {
        let frame = self.frame;
        let watch = Stopwatch::new(self.hooks);
        let primitive_ix = frame.patches.patches[piece.patch as usize].primitive as usize;
        let primitive = &frame.scene.primitives[primitive_ix];
        let context = &self.context;
        let diced = dice(&frame.displace_context(context, &self.corrections, &self.workspace), piece);
        let stats = &mut self.stats;
        stats.grids += 1;
        stats.micropolygons += diced.grid.num_micropolygons() as u64;
        stats.diced_points += diced.grid.num_vertices() as u64;
        stats.eye_edges += piece.sides.iter().filter(|side| context.stops_at_eye(side)).count() as u64;
        count_areas(&diced.grid, &mut stats.area_histogram);
        stats.seconds.dice += watch.seconds();
        let watch = Stopwatch::new(self.hooks);
        if !diced.grid.look.matte {
            stats.shaded_points += diced.grid.num_vertices() as u64;
        }
        let grid = shade(diced, primitive.attributes.surface.as_ref(), &frame.lights[primitive_ix]);
        stats.seconds.shade += watch.seconds();
        Arc::new(grid)
    }

    /// Background, then exposure.
    fn finish(&self, pixels: &mut [Pixel]) {
        let settings = self.frame.settings;
        for pixel in pixels {
            let [r, g, b, a, z] = *pixel;
            let [r, g, b, a] =
                crate::image::finish_pixel([r, g, b, a], settings.background, settings.exposure);
            *pixel = [r, g, b, a, z];
        }
    }
}

/// Counts the areas of a grid's micropolygons, two triangles each.
fn count_areas(grid: &Grid, histogram: &mut [u64; 16]) {
    for micropolygon in (0..grid.num_micropolygons()).filter(|&mp| !grid.is_slow(mp)) {
        let [a, b, c, d] = grid.corners(micropolygon).map(|v| [i64::from(grid.x[v]), i64::from(grid.y[v])]);
        let twice = |p: [i64; 2], q: [i64; 2], r: [i64; 2]| {
            ((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])).unsigned_abs()
        };
        // Doubled areas in 1/65536 square pixels: bit 17 is one pixel.
        let doubled = twice(a, b, c) + twice(a, c, d);
        let bin = if doubled == 0 { 0 } else { (doubled.ilog2() as i32 - 17 + 8).clamp(0, 15) };
        histogram[bin as usize] += 1;
    }
}

/// Something to do, nearest first.
struct Queued {
    near: f32,
    work: Work,
}

enum Work {
    Filed(Source),
    Piece(Box<Piece>),
}

impl PartialEq for Queued {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Queued {}

impl PartialOrd for Queued {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Queued {
    fn cmp(&self, other: &Self) -> Ordering {
        // The heap's greatest is the nearest.
        other.near.total_cmp(&self.near)
    }
}
