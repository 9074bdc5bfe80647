//! One frame on the CPU: everything that is decided before the first tile is drawn.
//!
//! The front end splits all patches, in parallel, until their pieces are about as large as a tile, and files
//! them by tile. Splitting never reads the tile size, only where it pauses does: the pieces that are diced in
//! the end are the same for every tiling.

use std::cell::RefCell;
use std::sync::Arc;

use rayon::prelude::*;

use crate::geometry::RasterCamera;
use crate::pipeline::bound::{Bound, Unseen, bound};
use crate::pipeline::connect::connect;
use crate::pipeline::dice::PrimitiveInfo;
use crate::pipeline::displace::{Corrections, DisplaceContext, widen};
use crate::pipeline::patch::Surfaces;
use crate::pipeline::patchify::patchify;
use crate::pipeline::piece::Piece;
use crate::pipeline::resolve::FilterTable;
use crate::pipeline::split::{Fate, SplitContext};
use crate::pipeline::{EdgeTable, PatchTable};
use crate::sampling::{PatternSpec, Region, SamplePattern};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::shading::PlacedLight;
use crate::stats::Stats;

use super::{Hooks, Stopwatch};

/// Bytes of sample records and colours that a tile may use, so that they stay in the second-level cache.
const TILE_BYTES: u64 = 768 << 10;

/// Pieces of one patch that may reach in front of the near plane; a surface that passes the eye has a few
/// thousand.
pub(super) const MOST_AT_EYE: u32 = 1 << 14;

/// What all tiles of a frame share.
pub(super) struct FrameData<'a> {
    pub scene: &'a Scene,
    pub settings: &'a Settings,
    pub camera: RasterCamera,
    pub patches: PatchTable,
    pub edges: EdgeTable,
    pub infos: Vec<PrimitiveInfo>,
    pub shading_rate: Vec<f32>,
    /// Lights of each primitive, in camera space.
    pub lights: Vec<Vec<Arc<dyn PlacedLight>>>,
    pub pattern: SamplePattern,
    pub filter: FilterTable,
    pub tiles: Tiles,
}

impl<'a> FrameData<'a> {
    /// Patchify and connect.
    pub fn new(scene: &'a Scene, settings: &'a Settings, stats: &mut Stats) -> Self {
        let camera = RasterCamera::new(&scene.camera, settings.resolution);
        let (mut patches, warnings) = patchify(scene);
        let shading_rate: Vec<f32> = scene.primitives.iter().map(|p| p.attributes.shading_rate).collect();
        let mut edges = connect(&mut patches, &shading_rate);
        let infos: Vec<PrimitiveInfo> =
            scene.primitives.iter().map(|p| PrimitiveInfo::new(scene, &camera, p)).collect();
        if infos.iter().any(|info| info.displacement.is_some()) {
            edges.list_users(&patches);
            widen(&mut patches, &edges, &infos);
        }
        let world_to_camera = scene.camera.world_to_camera.first();
        let placed: Vec<Arc<dyn PlacedLight>> = scene
            .lights
            .iter()
            .map(|light| light.shader.place(&(world_to_camera * light.to_world.first())))
            .collect();
        let lights_of = |ixs: &[u32]| ixs.iter().filter_map(|&ix| placed.get(ix as usize).cloned()).collect();
        let pattern = SamplePattern::new(PatternSpec {
            samples: settings.samples,
            tile: settings.pattern_tile_side(),
            permutations: settings.permutations,
            seed: settings.seed,
            jitter: settings.jitter,
            ..PatternSpec::default()
        });
        let filter = FilterTable::new(settings.filter, &pattern);
        stats.primitives = scene.primitives.len() as u64;
        stats.patches = patches.patches.len() as u64;
        stats.edges = edges.edges.len() as u64;
        stats.welds = edges.num_welds() as u64;
        stats.warnings.extend(warnings);
        FrameData {
            infos,
            lights: scene.primitives.iter().map(|p| lights_of(&p.attributes.lights)).collect(),
            tiles: Tiles::new(settings, &pattern, filter.radius),
            scene,
            settings,
            camera,
            patches,
            edges,
            shading_rate,
            pattern,
            filter,
        }
    }

    /// What splitting and dicing read.
    pub fn context(&self) -> SplitContext<'_> {
        SplitContext {
            patches: &self.patches,
            surfaces: Surfaces::new(&self.patches),
            edges: &self.edges,
            camera: &self.camera,
            rate_scale: self.settings.shading_rate_scale,
            grid_size: self.settings.grid_size,
            eye_splits: self.settings.eye_splits as u8,
            shading_rate: &self.shading_rate,
            sabotage: None,
        }
    }

    /// What dicing reads.
    pub fn displace_context<'b, 'f>(
        &'b self,
        frame: &'b SplitContext<'f>,
        corrections: &'b RefCell<Corrections>,
    ) -> DisplaceContext<'b, 'f> {
        DisplaceContext { frame, scene: self.scene, infos: &self.infos, corrections }
    }

    /// Splits all patches to about the size of a tile and files the pieces. `None` where it was cancelled.
    pub fn file(&self, hooks: &Hooks, stats: &mut Stats) -> Option<Filed> {
        let region = self.tiles.sample_region(self.tiles.window);
        let num_patches = self.patches.patches.len() as u32;
        const CHUNK: u32 = 64;
        let chunks: Vec<(Vec<Entry>, Vec<Piece>, Stats)> = (0..num_patches.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let watch = Stopwatch::new(hooks);
                let mut filed = (Vec::new(), Vec::new(), Stats::default());
                let context = self.context();
                for patch in chunk * CHUNK..num_patches.min((chunk + 1) * CHUNK) {
                    if hooks.is_cancelled() {
                        break;
                    }
                    self.file_patch(&context, patch, region, &mut filed);
                }
                filed.2.seconds.split += watch.seconds();
                filed
            })
            .collect();
        if hooks.is_cancelled() {
            return None;
        }
        let mut filed = Filed::default();
        for (entries, pieces, chunk_stats) in chunks {
            let first_piece = filed.pieces.len() as u32;
            filed.pieces.extend(pieces);
            filed.entries.extend(entries.into_iter().map(|entry| Entry {
                source: match entry.source {
                    Source::Piece(ix) => Source::Piece(ix + first_piece),
                    whole => whole,
                },
                ..entry
            }));
            stats.add(&chunk_stats);
        }
        filed.sort_into(&self.tiles);
        Some(filed)
    }

    fn file_patch(
        &self,
        context: &SplitContext,
        patch: u32,
        region: Region,
        filed: &mut (Vec<Entry>, Vec<Piece>, Stats),
    ) {
        let (entries, pieces, stats) = filed;
        let limit = self.tiles.side as i32;
        let mut stack = vec![context.whole(patch)];
        let (first_entry, first_piece) = (entries.len(), pieces.len());
        let mut at_eye = 0;
        while let Some(piece) = stack.pop() {
            if at_eye > MOST_AT_EYE {
                entries.truncate(first_entry);
                pieces.truncate(first_piece);
                let ix = self.patches.patches[patch as usize].primitive as usize;
                let name = self.scene.primitives[ix].attributes.object_name(ix);
                stats.warnings.push(format!(
                    "{name}: patch {patch} has control points so far apart that single precision cannot tell \
                     where it passes the eye; it is not drawn"
                ));
                return;
            }
            let Some(Bound { pixels, depth, crosses }) = count_unseen(bound(context, &piece, &region), stats)
            else {
                continue;
            };
            at_eye += u32::from(crosses);
            let small = pixels[1] - pixels[0] < limit && pixels[3] - pixels[2] < limit;
            if !small && let Fate::Split(halves) = context.fate(&piece) {
                stats.splits += 1;
                stack.extend(halves);
                continue;
            }
            let source = if piece.path == 1 {
                Source::Patch(patch)
            } else {
                pieces.push(piece);
                Source::Piece(pieces.len() as u32 - 1)
            };
            entries.push(Entry { source, pixels, near: depth[0] });
        }
    }
}

/// Counts what cannot be seen.
pub(super) fn count_unseen(result: Result<Bound, Unseen>, stats: &mut Stats) -> Option<Bound> {
    match result {
        Ok(bound) => Some(bound),
        Err(Unseen::Depth) => {
            stats.culled.depth += 1;
            None
        }
        Err(Unseen::Frustum) => {
            stats.culled.frustum += 1;
            None
        }
    }
}

/// Where a filed piece is.
#[derive(Debug, Clone, Copy)]
pub(super) enum Source {
    /// A whole patch.
    Patch(u32),
    /// An entry of [`Filed::pieces`].
    Piece(u32),
}

/// A filed piece.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entry {
    pub source: Source,
    pixels: [i32; 4],
    pub near: f32,
}

/// Pieces by tile.
#[derive(Debug, Default)]
pub(super) struct Filed {
    entries: Vec<Entry>,
    pub pieces: Vec<Piece>,
    /// Where each tile's list starts; one more than tiles.
    starts: Vec<usize>,
    /// Indices into `entries`.
    lists: Vec<u32>,
}

impl Filed {
    /// Count, prefix sum, write.
    fn sort_into(&mut self, tiles: &Tiles) {
        let mut counts = vec![0usize; tiles.len() + 1];
        for entry in &self.entries {
            tiles.touched(entry.pixels).for_each(|tile| counts[tile + 1] += 1);
        }
        for tile in 0..tiles.len() {
            counts[tile + 1] += counts[tile];
        }
        self.lists = vec![0; counts[tiles.len()]];
        let mut next = counts.clone();
        for (ix, entry) in self.entries.iter().enumerate() {
            for tile in tiles.touched(entry.pixels) {
                self.lists[next[tile]] = ix as u32;
                next[tile] += 1;
            }
        }
        self.starts = counts;
    }

    /// What may be seen in a tile.
    pub fn of_tile(&self, tile: usize) -> impl Iterator<Item = &Entry> {
        self.lists[self.starts[tile]..self.starts[tile + 1]].iter().map(|&ix| &self.entries[ix as usize])
    }
}

/// The raster tiles of a frame. They count from full-frame pixel (0, 0).
#[derive(Debug, Clone, Copy)]
pub(super) struct Tiles {
    /// Side in pixels.
    pub side: u32,
    /// Pixels to each side whose samples a pixel's filter reads.
    pub margin: [i32; 2],
    /// Pixels to render.
    pub window: Region,
    columns: usize,
    rows: usize,
}

impl Tiles {
    fn new(settings: &Settings, pattern: &SamplePattern, margin: [i32; 2]) -> Self {
        let k = pattern.tile();
        let side = settings.tile.unwrap_or_else(|| default_side(settings.samples_per_pixel(), k));
        let [x0, x1, y0, y1] = settings.window_px().map(|px| px as i32);
        let window = Region::new(x0, x1, y0, y1);
        let count = |from: i32, to: i32| ((to - 1) / side as i32 - from / side as i32 + 1) as usize;
        Tiles { side, margin, window, columns: count(x0, x1), rows: count(y0, y1) }
    }

    /// Number of tiles that hold pixels of the window.
    pub fn len(&self) -> usize {
        self.columns * self.rows
    }

    /// The window's pixels in a tile.
    pub fn interior(&self, tile: usize) -> Region {
        let side = self.side as i32;
        let column = self.window.x0 / side + (tile % self.columns) as i32;
        let row = self.window.y0 / side + (tile / self.columns) as i32;
        Region::new(
            (column * side).max(self.window.x0),
            ((column + 1) * side).min(self.window.x1),
            (row * side).max(self.window.y0),
            ((row + 1) * side).min(self.window.y1),
        )
    }

    /// The pixels whose samples those of `interior` read.
    pub fn sample_region(&self, interior: Region) -> Region {
        let [mx, my] = self.margin;
        Region::new(interior.x0 - mx, interior.x1 + mx, interior.y0 - my, interior.y1 + my)
    }

    /// Columns and rows of tiles whose sample regions meet a box of pixels (inclusive).
    fn range(&self, pixels: [i32; 4]) -> [std::ops::Range<usize>; 2] {
        let side = self.side as i32;
        let along = |from: i32, to: i32, margin: i32, first_px: i32, last_px: i32| {
            let first_tile = first_px / side;
            let clamp = |px: i32| (px.clamp(first_px, last_px) / side - first_tile) as usize;
            let (from, to) = (from.saturating_sub(margin), to.saturating_add(margin));
            if to < first_px || from > last_px { 0..0 } else { clamp(from)..clamp(to) + 1 }
        };
        [
            along(pixels[0], pixels[1], self.margin[0], self.window.x0, self.window.x1 - 1),
            along(pixels[2], pixels[3], self.margin[1], self.window.y0, self.window.y1 - 1),
        ]
    }

    fn touched(&self, pixels: [i32; 4]) -> impl Iterator<Item = usize> + use<> {
        let [columns, rows] = self.range(pixels);
        let width = self.columns;
        rows.flat_map(move |row| columns.clone().map(move |column| row * width + column))
    }

    /// How many tiles a box of pixels meets.
    pub fn num_touched(&self, pixels: [i32; 4]) -> u32 {
        let [columns, rows] = self.range(pixels);
        (columns.len() * rows.len()) as u32
    }
}

/// Largest multiple of K, at least 8 pixels, at most 64, whose records and colours fit the cache.
fn default_side(samples_per_pixel: u32, k: u32) -> u32 {
    let bytes_per_pixel = u64::from(samples_per_pixel) * 40;
    let mut side = 64;
    while side > 8 && u64::from(side * side) * bytes_per_pixel > 4 * TILE_BYTES {
        side /= 2;
    }
    (side / k).max(1) * k
}
