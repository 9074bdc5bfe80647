//! One tile: what may be seen in it is split, diced, shaded and drawn, nearest first, then resolved.

mod pass;

use std::cell::RefCell;
use std::sync::Arc;

use crate::error::Error;
use crate::occlusion::Occluders;
use crate::pipeline::GridKey;
use crate::pipeline::areas::count_areas;
use crate::pipeline::dice::dice;
use crate::pipeline::displace::Corrections;
use crate::pipeline::piece::{Piece, PieceKind};
use crate::pipeline::recent::Recent;
use crate::pipeline::resolve::{Pixel, SampleColors};
use crate::pipeline::sample::TileBuffers;
use crate::pipeline::shade::{Colors, ShadeLists, ShadedCount, ShadedGrid, VertexSet};
use crate::pipeline::slots::{GridSlots, UsedVertices};
use crate::pipeline::split::{JUDGED_LOG, SplitContext};
use crate::pipeline::sweep::{Sweep, to_pixels};
use crate::pipeline::waiting::RasterLists;
use crate::pipeline::workspace::Workspace;
use crate::sampling::nomotion::SampleCounts;
use crate::sampling::{Region, RegionSamples, SampleBuffer, TransparentRecords};
use crate::settings::Shade;
use crate::stats::Stats;

use super::Hooks;
use super::cache::{GridCache, Lookup};
use super::filed::Filed;
use super::frame::FrameData;
use super::laps::{Laps, Stage};

/// Bytes of a vertex's shading variables and colours, and at most of its place at one motion key.
const VERTEX_BYTES: u64 = 4 * 12 + 6 * 4 + 16;
const KEY_BYTES: u64 = 16;

/// A pixel whose filter finds nothing.
const EMPTY_PIXEL: Pixel = [0.0, 0.0, 0.0, 0.0, f32::INFINITY];

/// Draws tiles, one after the other, in the same memory.
pub(super) struct TileWorker<'a> {
    frame: &'a FrameData<'a>,
    context: SplitContext<'a>,
    filed: &'a Filed,
    cache: &'a GridCache,
    hooks: &'a Hooks<'a>,
    laps: Laps<'a>,
    buffers: TileBuffers,
    /// What is known to be hidden; `None` where nobody asks.
    occluders: Option<Occluders>,
    colors: SampleColors,
    pub corrections: RefCell<Corrections>,
    workspace: RefCell<Workspace>,
    /// Vertices of a grid that are seen, and lists for shading them.
    seen: VertexSet,
    lists: ShadeLists,
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
            used: UsedVertices::default(),
            counts: SampleCounts::default(),
            room: RasterLists::default(),
        };
        TileWorker {
            frame,
            context: SplitContext { judged: RefCell::new(Recent::new(JUDGED_LOG)), ..frame.context() },
            filed,
            cache,
            hooks,
            laps: Laps::new(hooks),
            buffers,
            occluders: frame.cull.as_ref().map(Occluders::new),
            colors: SampleColors::default(),
            corrections: RefCell::default(),
            workspace: RefCell::default(),
            seen: VertexSet::default(),
            lists: ShadeLists::default(),
            stats: Stats::default(),
        }
    }

    /// Replaces `pixels` by the finished pixels of a tile.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn draw(&mut self, tile: usize, pixels: &mut Vec<Pixel>) -> Result<(), Error> {
        if self.hooks.is_cancelled() {
            return Err(Error::Cancelled);
        }
        let interior = self.frame.tiles.interior(tile);
        pixels.clear();
        let drawn = if self.filed.of_tile(tile).is_empty() {
            pixels.resize(interior.num_pixels(), EMPTY_PIXEL);
            Ok(())
        } else {
            pixels.reserve_exact(interior.num_pixels());
            self.draw_region(tile, interior, pixels)
        };
        self.finish(pixels);
        self.cache.finished(tile);
        self.enter(Stage::Other);
        drawn
    }

    fn enter(&mut self, stage: Stage) {
        self.laps.enter(stage, &mut self.stats.seconds);
    }

    /// Draws a part of a tile, in quarters where it has too many grids.
    fn draw_region(&mut self, tile: usize, interior: Region, pixels: &mut Vec<Pixel>) -> Result<(), Error> {
        match self.passes(tile, interior) {
            Ok(()) => {
                self.enter(Stage::Resolve);
                self.colors.resolve(&self.buffers, &self.frame.filter, interior, pixels);
                Ok(())
            }
            Err(Stop::Cancelled) => Err(Error::Cancelled),
            Err(Stop::SlotsFull) if interior.num_pixels() > 1 => self.draw_halves(tile, interior, pixels),
            Err(Stop::SlotsFull) => Err(Error::Memory {
                what: "the grids of one pixel",
                needed: u64::from(crate::sampling::Payload::NUM_SLOTS) + 1,
                granted: u64::from(crate::sampling::Payload::NUM_SLOTS),
            }),
        }
    }

    fn draw_halves(&mut self, tile: usize, r: Region, pixels: &mut Vec<Pixel>) -> Result<(), Error> {
        if r.height() > 1 {
            let middle = r.y0 + r.height() as i32 / 2;
            self.draw_region(tile, Region::new(r.x0, r.x1, r.y0, middle), pixels)?;
            return self.draw_region(tile, Region::new(r.x0, r.x1, middle, r.y1), pixels);
        }
        let middle = r.x0 + r.width() as i32 / 2;
        self.draw_region(tile, Region::new(r.x0, middle, r.y0, r.y1), pixels)?;
        self.draw_region(tile, Region::new(middle, r.x1, r.y0, r.y1), pixels)
    }

    /// Draws everything, again as long as transparent records did not fit.
    fn passes(&mut self, tile: usize, interior: Region) -> Result<(), Stop> {
        let region = self.frame.tiles.sample_region(interior);
        self.enter(Stage::Sample);
        self.buffers.samples.renew(&self.frame.pattern, region);
        self.buffers.nearest.renew(region);
        self.buffers.transparent.renew();
        let mut workspace = self.workspace.borrow_mut();
        self.buffers.slots.drain().for_each(|grid| workspace.let_go(grid));
        drop(workspace);
        self.buffers.used.clear();
        if let Some(occluders) = &mut self.occluders {
            occluders.renew(&self.buffers.samples);
            let most = &mut self.stats.occlusion.pyramid_bytes;
            *most = (*most).max(occluders.bytes() as u64);
        }
        self.buffers.counts = SampleCounts::default();
        self.colors.renew();
        loop {
            self.buffers.transparent.begin_pass();
            self.pass(tile, region)?;
            self.enter(Stage::Resolve);
            self.colors.composite_pass(&mut self.buffers);
            if !self.buffers.transparent.needs_another_pass() {
                break;
            }
            self.stats.peels += 1;
        }
        self.shade_used();
        let counts = self.buffers.counts;
        self.stats.sample_tests += counts.tests;
        self.stats.sample_hits += counts.hits;
        self.stats.culled.backface += counts.backfacing;
        Ok(())
    }

    /// Draws what a piece is diced to, shaded first where its opacity is not known without.
    fn draw_piece(&mut self, piece: &Piece, sweep: &Sweep) -> Result<(), Stop> {
        let grid = self.grid(piece, sweep);
        if self.is_hidden_before_shading(&grid.grid, sweep) {
            self.workspace.borrow_mut().let_go(grid);
            return Ok(());
        }
        let way = self.frame.settings.shade;
        let colors = (way == Shade::All || !grid.surely_opaque).then(|| self.shade_all(&grid));
        self.enter(Stage::Sample);
        let drawn = self.buffers.draw(&self.frame.draw_context(), &grid, colors.as_ref());
        let Some(slot) = drawn.map_err(|_| Stop::SlotsFull)? else {
            drop(colors);
            self.workspace.borrow_mut().let_go(grid);
            return Ok(());
        };
        if let Some(occluders) = &mut self.occluders {
            occluders.drew(to_pixels(grid.grid.sweep.whole()));
        }
        if way == Shade::Gelato && grid.surely_opaque {
            let colors = self.shade_all(&grid);
            self.buffers.slots.set_colors(slot, colors);
        }
        Ok(())
    }

    fn shade_all(&mut self, grid: &ShadedGrid) -> Arc<Colors> {
        self.enter(Stage::Shade);
        let (colors, count) = grid.shade_all(self.frame.shader(grid.grid.key.primitive as usize));
        self.count_shaded(count);
        colors
    }

    /// Shades what visible micropolygons use, as far as it is not yet.
    fn shade_used(&mut self) {
        self.enter(Stage::Shade);
        self.buffers.note_used();
        let used = std::mem::take(&mut self.buffers.used);
        for slot in used.slots() {
            let Some(grid) = self.buffers.slots.grid(slot).cloned() else { continue };
            used.find(slot, &grid.grid, &mut self.seen);
            if self.seen.is_empty() {
                continue;
            }
            self.stats.visible_points += grid.note_seen(&self.seen, &mut self.lists);
            if grid.surely_opaque && self.frame.settings.shade == Shade::Visible {
                let shader = self.frame.shader(grid.grid.key.primitive as usize);
                let (colors, count) = grid.shade_some(&self.seen, shader, &mut self.lists);
                self.count_shaded(count);
                self.buffers.slots.set_colors(slot, colors);
                // Beside the slot's and the one here.
                let waits = Arc::strong_count(&grid) > 2;
                if waits {
                    grid.let_go_of_points();
                }
            }
        }
        self.buffers.used = used;
    }

    fn count_shaded(&mut self, count: ShadedCount) {
        self.stats.shaded_points += count.points;
        self.stats.ring_points += count.ring;
    }

    /// The grid of a piece, made here or by another tile.
    fn grid(&mut self, piece: &Piece, sweep: &Sweep) -> Arc<ShadedGrid> {
        let PieceKind::Lattice { i, j, .. } = piece.kind else {
            unreachable!("only pieces with a lattice are diced");
        };
        self.enter(Stage::Dice);
        let Some(last_tile) = self.frame.last_of_several_tiles(sweep) else {
            return self.make(piece, false, false);
        };
        let patch = &self.frame.patches.patches[piece.patch as usize];
        let key =
            GridKey { primitive: patch.primitive, patch: piece.patch, path: piece.path, block: [i[0], j[0]] };
        let num_vertices = (u64::from(i[1] - i[0]) + 1) * (u64::from(j[1] - j[0]) + 1);
        let num_keys = self.frame.patches.num_keys(piece.patch) as u64;
        let bytes = num_vertices * (VERTEX_BYTES + KEY_BYTES * num_keys) + size_of::<ShadedGrid>() as u64;
        match self.cache.look_up(&key, last_tile, bytes) {
            Lookup::Shared(shared) => Arc::clone(shared.get_or_init(|| self.make(piece, false, true))),
            Lookup::Alone { again } => self.make(piece, again, false),
        }
    }

    /// Makes a grid: again or not, and for one tile or to wait for others.
    fn make(&mut self, piece: &Piece, again: bool, waits: bool) -> Arc<ShadedGrid> {
        let frame = self.frame;
        let primitive_ix = frame.patches.patches[piece.patch as usize].primitive as usize;
        let context = &self.context;
        let mut diced = dice(&frame.displace_context(context, &self.corrections, &self.workspace), piece);
        let stats = &mut self.stats;
        let num_vertices = diced.grid.num_vertices() as u64;
        stats.grids += 1;
        stats.micropolygons += diced.grid.num_micropolygons() as u64;
        stats.diced_points += num_vertices;
        stats.grids_again += u64::from(again);
        stats.diced_points_again += if again { num_vertices } else { 0 };
        stats.eye_edges += piece.sides.iter().filter(|side| context.stops_at_eye(side)).count() as u64;
        count_areas(context.surfaces.level, &diced.grid, &mut stats.area_histogram);
        if waits {
            let lists = diced.grid.pack(context.surfaces.level, std::mem::take(&mut diced.left.packed));
            self.workspace.borrow_mut().spare.keep_on_raster(lists);
        }
        let grid = ShadedGrid::new(diced, frame.shader(primitive_ix).surface);
        Arc::new(grid)
    }

    /// Background, then exposure.
    fn finish(&self, pixels: &mut [Pixel]) {
        let settings = self.frame.settings;
        if settings.background.is_none() && settings.exposure == [1.0; 2] {
            return;
        }
        for pixel in pixels {
            let [r, g, b, a, z] = *pixel;
            let [r, g, b, a] =
                crate::image::finish_pixel([r, g, b, a], settings.background, settings.exposure);
            *pixel = [r, g, b, a, z];
        }
    }
}
