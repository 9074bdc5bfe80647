//! One frame on the CPU: everything that is decided before the first tile is drawn.
//!
//! The front end splits all patches, in parallel, until their pieces are about as large as a tile, and files
//! them by tile. Splitting never reads the tile size, only where it pauses does: the pieces that are diced in
//! the end are the same for every tiling.

use std::cell::RefCell;
use std::sync::Arc;

use rayon::prelude::*;

use crate::geometry::RasterCamera;
use crate::occlusion::{Blurred, CullPlan};
use crate::pipeline::bound::{Bound, Unseen, bound};
use crate::pipeline::connect::connect;
use crate::pipeline::dice::PrimitiveInfo;
use crate::pipeline::displace::{Corrections, DisplaceContext, widen};
use crate::pipeline::motion::{KeyTimes, scene_time, welded};
use crate::pipeline::patch::Surfaces;
use crate::pipeline::patchify::patchify;
use crate::pipeline::piece::{Piece, Sabotage};
use crate::pipeline::rate::Fineness;
use crate::pipeline::resolve::FilterTable;
use crate::pipeline::sample::DrawContext;
use crate::pipeline::shade::Shader;
use crate::pipeline::split::{Fate, SplitContext};
use crate::pipeline::workspace::Workspace;
use crate::pipeline::{EdgeTable, PatchTable};
use crate::sampling::{LensShape, PatternSpec, Region, SamplePattern, ShutterShape, TupleTimes};
use crate::scene::{Primitive, Scene};
use crate::settings::Settings;
use crate::shading::PlacedLight;
use crate::stats::Stats;

use super::{Hooks, Stopwatch};

/// Bytes of sample records and colours that a tile may use, so that they stay in the second-level cache.
const TILE_BYTES: u64 = 768 << 10;

/// Pieces of one patch that may reach in front of the near plane, weighted; a surface that passes the eye has a few
/// thousand that do so all the time, one that moves past it has many more that do for a moment.
pub(super) const MOST_AT_EYE: u32 = 1 << 18;

/// What a piece counts towards [`MOST_AT_EYE`].
pub(super) fn weight_at_eye(bounds: &Bound) -> u32 {
    match bounds.at_eye {
        [0, _] => 0,
        // Each key is work.
        [num, of] if num == of => 16 + 2 * of,
        [_, of] => 1 + of / 8,
    }
}

/// What all tiles of a frame share.
pub(super) struct FrameData<'a> {
    pub scene: &'a Scene,
    pub settings: &'a Settings,
    pub camera: RasterCamera,
    pub patches: PatchTable,
    pub edges: EdgeTable,
    pub infos: Vec<PrimitiveInfo>,
    pub fineness: Vec<Fineness>,
    /// Lights of each primitive, in camera space.
    pub lights: Vec<Vec<Arc<dyn PlacedLight>>>,
    pub pattern: SamplePattern,
    /// Local times of the pattern's tuples, for each set of key times.
    pub times: Vec<TupleTimes>,
    pub filter: FilterTable,
    pub tiles: Tiles,
    /// How what is hidden is found; `None` where it is not looked for.
    pub cull: Option<CullPlan>,
    /// A rule to break on purpose; `None` outside tests.
    sabotage: Option<Sabotage>,
}

impl<'a> FrameData<'a> {
    /// Patchify and connect.
    pub fn new(
        scene: &'a Scene,
        settings: &'a Settings,
        sabotage: Option<Sabotage>,
        stats: &mut Stats,
    ) -> Self {
        let camera = RasterCamera::new(&scene.camera, settings.resolution);
        let fineness: Vec<Fineness> = scene.primitives.iter().map(|p| fineness(p, settings)).collect();
        let (mut patches, mut edges, warnings) = connected(scene, &camera, settings, &fineness, sabotage);
        let info = |(ix, primitive)| {
            PrimitiveInfo::new(scene, &camera, primitive, patches.times.of(ix), settings.shading_time)
        };
        let infos: Vec<PrimitiveInfo> = (0u32..).zip(&scene.primitives).map(info).collect();
        if infos.iter().any(|info| info.displacement.is_some()) {
            edges.list_users(&patches);
            widen(&mut patches, &edges, &infos);
        }
        let shading_time = scene_time(scene, settings.shading_time);
        let world_to_camera = scene.camera.world_to_camera.at(shading_time);
        let placed: Vec<Arc<dyn PlacedLight>> = scene
            .lights
            .iter()
            .map(|light| light.shader.place(&(world_to_camera * light.to_world.at(shading_time))))
            .collect();
        let lights_of = |ixs: &[u32]| ixs.iter().filter_map(|&ix| placed.get(ix as usize).cloned()).collect();
        let pattern = SamplePattern::new(PatternSpec {
            samples: settings.samples,
            tile: settings.pattern_tile_side(),
            permutations: settings.permutations,
            seed: settings.seed,
            jitter: settings.jitter,
            lens: lens_shape(scene),
            lens_scale: camera.lens_scale(),
            shutter: shutter_shape(scene),
            ..PatternSpec::default()
        });
        let filter = FilterTable::new(settings.filter, &pattern);
        let blur = Blurred { moves: patches.times.any_moves(), has_lens: camera.lens.is_some() };
        let cull = CullPlan::new(settings.cull, &pattern, blur);
        let times = patches.times.sets.iter().map(|set| TupleTimes::new(&pattern, set)).collect();
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
            fineness,
            pattern,
            times,
            filter,
            cull,
            sabotage,
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
            fineness: &self.fineness,
            sabotage: self.sabotage,
        }
    }

    /// What drawing reads.
    pub fn draw_context(&self) -> DrawContext<'_> {
        DrawContext {
            camera: &self.camera,
            pattern: &self.pattern,
            times: &self.times,
            rasterizer: self.settings.rasterizer,
        }
    }

    /// Whether anything moves or is out of focus.
    pub fn is_blurred(&self) -> bool {
        self.camera.lens.is_some() || self.patches.times.any_moves()
    }

    /// The last tile that something that is bounded meets, if it meets several.
    pub fn last_of_several_tiles(&self, bounds: &Bound) -> Option<usize> {
        let mut touched = self.tiles.touched(bounds);
        touched.next()?;
        touched.last()
    }

    /// What shades a primitive.
    pub fn shader(&self, primitive_ix: usize) -> Shader<'_> {
        let surface = self.scene.primitives[primitive_ix].attributes.surface.as_ref();
        Shader { surface, lights: &self.lights[primitive_ix] }
    }

    /// What dicing reads.
    pub fn displace_context<'b, 'f>(
        &'b self,
        frame: &'b SplitContext<'f>,
        corrections: &'b RefCell<Corrections>,
        workspace: &'b RefCell<Workspace>,
    ) -> DisplaceContext<'b, 'f> {
        DisplaceContext { frame, scene: self.scene, infos: &self.infos, corrections, workspace }
    }

    /// Splits all patches to about the size of a tile and files the pieces. `None` where it was cancelled.
    pub fn file(&self, hooks: &Hooks, stats: &mut Stats) -> Option<Filed> {
        let region = self.tiles.sample_region(self.tiles.window);
        let num_patches = self.patches.patches.len() as u32;
        const CHUNK: u32 = 64;
        let chunks: Vec<(Filed, Stats)> = (0..num_patches.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let watch = Stopwatch::new(hooks);
                let mut filed = (Filed::default(), Stats::default());
                let context = self.context();
                for patch in chunk * CHUNK..num_patches.min((chunk + 1) * CHUNK) {
                    if hooks.is_cancelled() {
                        break;
                    }
                    self.file_patch(&context, patch, region, &mut filed);
                }
                filed.1.seconds.split += watch.seconds();
                filed
            })
            .collect();
        if hooks.is_cancelled() {
            return None;
        }
        let mut filed = Filed::default();
        for (chunk, chunk_stats) in chunks {
            let (first_piece, first_entry) = (filed.pieces.len() as u32, filed.entries.len() as u32);
            filed.pieces.extend(chunk.pieces);
            filed.touches.extend(chunk.touches.into_iter().map(|(tile, entry)| (tile, entry + first_entry)));
            filed.entries.extend(chunk.entries.into_iter().map(|entry| Entry {
                source: match entry.source {
                    Source::Piece(ix) => Source::Piece(ix + first_piece),
                    whole => whole,
                },
                ..entry
            }));
            stats.add(&chunk_stats);
        }
        filed.sort_into(self.tiles.len());
        Some(filed)
    }

    fn file_patch(
        &self,
        context: &SplitContext,
        patch: u32,
        region: Region,
        (filed, stats): &mut (Filed, Stats),
    ) {
        let Filed { entries, pieces, touches, .. } = filed;
        let limit = self.tiles.side as f32;
        let mut stack = vec![context.whole(patch)];
        let (first_entry, first_piece, first_touch) = (entries.len(), pieces.len(), touches.len());
        let mut at_eye = 0;
        while let Some(piece) = stack.pop() {
            if at_eye > MOST_AT_EYE {
                entries.truncate(first_entry);
                pieces.truncate(first_piece);
                touches.truncate(first_touch);
                let ix = self.patches.patches[patch as usize].primitive as usize;
                let name = self.scene.primitives[ix].attributes.object_name(ix);
                stats.warnings.push(format!(
                    "{name}: patch {patch} has control points so far apart that single precision cannot tell \
                     where it passes the eye; it is not drawn"
                ));
                return;
            }
            let Some(bounds) = count_unseen(bound(context, &piece, &region), stats) else {
                continue;
            };
            at_eye += weight_at_eye(&bounds);
            // Neither motion nor defocus is a reason to split.
            let small = bounds.size_px.iter().all(|&size| size < limit);
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
            let entry = entries.len() as u32;
            let tiles = self.tiles.touched(&bounds);
            touches.extend(tiles.map(|tile| (tile as u32, entry)));
            entries.push(Entry { source, near: bounds.depth[0] });
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
    pub near: f32,
}

/// Pieces by tile.
#[derive(Debug, Default)]
pub(super) struct Filed {
    entries: Vec<Entry>,
    pub pieces: Vec<Piece>,
    /// Tiles and the entries that touch them.
    touches: Vec<(u32, u32)>,
    /// Where each tile's list starts; one more than tiles.
    starts: Vec<usize>,
    /// Indices into `entries`.
    lists: Vec<u32>,
}

impl Filed {
    /// Count, prefix sum, write.
    fn sort_into(&mut self, num_tiles: usize) {
        let touches = std::mem::take(&mut self.touches);
        let mut counts = vec![0usize; num_tiles + 1];
        touches.iter().for_each(|&(tile, _)| counts[tile as usize + 1] += 1);
        for tile in 0..num_tiles {
            counts[tile + 1] += counts[tile];
        }
        self.lists = vec![0; counts[num_tiles]];
        let mut next = counts.clone();
        for (tile, entry) in touches {
            self.lists[next[tile as usize]] = entry;
            next[tile as usize] += 1;
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

    /// Tiles in which something that is bounded may be seen.
    fn touched(&self, bounds: &Bound) -> impl Iterator<Item = usize> {
        let [columns, rows] = self.range(bounds.pixels);
        let all = rows.flat_map(move |row| columns.clone().map(move |column| row * self.columns + column));
        all.filter(move |&tile| {
            let Region { x0, x1, y0, y1 } = self.sample_region(self.interior(tile));
            let rectangle = [x0, x1, y0, y1].map(|px| px as f32);
            bounds.sweep.meets(rectangle).is_some()
        })
    }
}

/// How finely a primitive is diced.
fn fineness(primitive: &Primitive, settings: &Settings) -> Fineness {
    let attributes = &primitive.attributes;
    Fineness {
        shading_rate: attributes.shading_rate,
        motion_factor: settings.motion_factor.unwrap_or(attributes.motion_factor),
        focus_factor: settings.focus_factor.unwrap_or(attributes.focus_factor),
    }
}

/// Patchifies and connects: where everything is as the shutter opens, which tells what may be welded and so has one
/// set of key times; then at these times, which tells what stays welded; then at as many more times as curved paths
/// need.
fn connected(
    scene: &Scene,
    camera: &RasterCamera,
    settings: &Settings,
    fineness: &[Fineness],
    sabotage: Option<Sabotage>,
) -> (PatchTable, EdgeTable, Vec<String>) {
    let alone: Vec<u32> = (0..scene.primitives.len() as u32).collect();
    let welded = |patches: &PatchTable, edges: &EdgeTable| match sabotage {
        Some(Sabotage::KeyTimes) => alone.clone(),
        _ => welded(scene, patches, edges),
    };
    let mut times = KeyTimes::of_file(scene, &alone);
    if times.of_primitive.windows(2).any(|pair| pair[0] != pair[1]) {
        // Different times: what touches as the shutter opens may be welded, and is given the times of both.
        let (mut patches, _) = patchify(scene, &KeyTimes::still(scene));
        let edges = connect(&mut patches, fineness);
        times = KeyTimes::of_file(scene, &welded(&patches, &edges));
    }
    let (mut patches, mut warnings) = patchify(scene, &times);
    let edges = connect(&mut patches, fineness);
    if scene.camera.lens.is_some() && !camera.perspective {
        warnings.push("an orthographic camera has no lens: everything is in focus".to_owned());
    }
    if !times.any_moves() {
        return (patches, edges, warnings);
    }
    let welded = welded(&patches, &edges);
    let (refined, coarse) = KeyTimes::of_file(scene, &welded).refined(scene, camera, settings, &welded);
    for (primitive, error) in coarse {
        let name = scene.primitives[primitive as usize].attributes.object_name(primitive as usize);
        warnings.push(format!(
            "{name}: its path is so curved that it is drawn up to {error} pixels off; more key times would help"
        ));
    }
    if refined == times {
        return (patches, edges, warnings);
    }
    let (mut finer, more) = patchify(scene, &refined);
    warnings.extend(more.into_iter().filter(|warning| !warnings.contains(warning)).collect::<Vec<_>>());
    // Points between keys agree where those at the keys do, as what is welded has the same.
    if sabotage == Some(Sabotage::KeyTimes) || !finer.take_connections(&patches) {
        let edges = connect(&mut finer, fineness);
        return (finer, edges, warnings);
    }
    (finer, edges, warnings)
}

fn lens_shape(scene: &Scene) -> LensShape {
    match scene.camera.lens {
        Some(lens) if lens.blades >= 3 => {
            LensShape::Blades { num: lens.blades, rotation: f64::from(lens.blade_angle) / 360.0 }
        }
        _ => LensShape::Round,
    }
}

fn shutter_shape(scene: &Scene) -> ShutterShape {
    match scene.camera.shutter_opening.map(f64::from) {
        [0.0, 1.0] => ShutterShape::Box,
        [open, close] => ShutterShape::Trapezoid { open, close },
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
