//! One frame on the CPU: everything that is decided before the first tile is drawn.
//!
//! The front end splits all patches, in parallel, until their pieces are about as large as a tile, and files
//! them by tile. Splitting never reads the tile size, only where it pauses does: the pieces that are diced in
//! the end are the same for every tiling.

use std::borrow::Cow;
use std::cell::RefCell;
use std::sync::Arc;

use crate::geometry::RasterCamera;
use crate::occlusion::{Blurred, CullPlan};
use crate::pipeline::bound::{Bound, Unseen, bound};
use crate::pipeline::connect::connect;
use crate::pipeline::dice::PrimitiveInfo;
use crate::pipeline::displace::{Corrections, DisplaceContext, widen};
use crate::pipeline::motion::{KeyTimes, own_times, scene_time, welded};
use crate::pipeline::patch::Surfaces;
use crate::pipeline::patchify::patchify;
use crate::pipeline::piece::Sabotage;
use crate::pipeline::rate::Fineness;
use crate::pipeline::resolve::FilterTable;
use crate::pipeline::sample::DrawContext;
use crate::pipeline::shade::Shader;
use crate::pipeline::split::{Fate, SplitContext};
use crate::pipeline::sweep::Sweep;
use crate::pipeline::workspace::Workspace;
use crate::pipeline::{EdgeTable, PatchTable};
use crate::sampling::{Kernels, LensShape, PatternSpec, Region, SamplePattern, ShutterShape, TupleTimes};
use crate::scene::{Primitive, Scene};
use crate::settings::Settings;
use crate::shading::PlacedLight;
use crate::stats::Stats;

use super::filed::Filed;
use super::tiles::Tiles;
use super::workers::Workers;
use super::{Hooks, Stopwatch};

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
    /// Without points that patches have been made of, if it was given away.
    pub scene: Cow<'a, Scene>,
    pub settings: &'a Settings,
    pub camera: RasterCamera,
    pub patches: PatchTable,
    pub edges: EdgeTable,
    /// What dicing knows of each primitive; neighbours that are alike share it.
    pub infos: Vec<Arc<PrimitiveInfo>>,
    pub fineness: Vec<Fineness>,
    /// Lights of each primitive, in camera space.
    pub lights: Vec<PlacedLights>,
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
        mut scene: Cow<'a, Scene>,
        settings: &'a Settings,
        sabotage: Option<Sabotage>,
        stats: &mut Stats,
    ) -> Self {
        let camera = RasterCamera::new(&scene.camera, settings.resolution);
        let fineness: Vec<Fineness> = scene.primitives.iter().map(|p| fineness(p, settings)).collect();
        let (mut patches, mut edges, warnings) = connected(&scene, &camera, settings, &fineness, sabotage);
        if let Cow::Owned(scene) = &mut scene {
            scene.let_go_of_points();
        }
        let infos = PrimitiveInfo::of_all(&scene, &camera, &patches.times, settings.shading_time);
        if infos.iter().any(|info| info.displacement.is_some()) {
            edges.list_users(&patches, |primitive| infos[primitive as usize].normal_sign);
            widen(&mut patches, &edges, &infos);
        }
        let shading_time = scene_time(&scene, settings.shading_time);
        let world_to_camera = scene.camera.world_to_camera.at(shading_time);
        let placed: Vec<Arc<dyn PlacedLight>> = scene
            .lights
            .iter()
            .map(|light| light.shader.place(&(world_to_camera * light.to_world.at(shading_time))))
            .collect();
        let pattern = SamplePattern::new(PatternSpec {
            samples: settings.samples,
            tile: settings.pattern_tile_side(),
            permutations: settings.permutations,
            seed: settings.seed,
            jitter: settings.jitter,
            lens: lens_shape(&scene),
            lens_scale: camera.lens_scale(),
            shutter: shutter_shape(&scene),
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
            lights: lights_of_primitives(&scene, &placed),
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
            infos: &self.infos,
            sabotage: self.sabotage,
            places: RefCell::default(),
            hulls: RefCell::default(),
            judged: RefCell::default(),
        }
    }

    /// What drawing reads.
    pub fn draw_context(&self) -> DrawContext<'_> {
        DrawContext {
            camera: &self.camera,
            pattern: &self.pattern,
            times: &self.times,
            rasterizer: self.settings.rasterizer,
            kernels: Kernels::default(),
        }
    }

    /// Whether anything moves or is out of focus.
    pub fn is_blurred(&self) -> bool {
        self.camera.lens.is_some() || self.patches.times.any_moves()
    }

    /// The last tile that something meets, if it meets several.
    pub fn last_of_several_tiles(&self, sweep: &Sweep) -> Option<usize> {
        let mut touched = self.tiles.touched(sweep);
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
        DisplaceContext { frame, scene: &self.scene, infos: &self.infos, corrections, workspace }
    }

    /// Splits all patches to about the size of a tile and files the pieces. `None` where it was cancelled.
    pub fn file(&self, workers: &Workers, hooks: &Hooks, stats: &mut Stats) -> Option<Filed> {
        let region = self.tiles.sample_region(self.tiles.window);
        let num_patches = self.patches.patches.len() as u32;
        const CHUNK: u32 = 64;
        let chunks: Vec<(Filed, Stats)> = workers.map(num_patches.div_ceil(CHUNK), |chunk| {
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
        });
        if hooks.is_cancelled() {
            return None;
        }
        let mut filed = Filed::with_room(chunks.iter().map(|chunk| &chunk.0));
        for (chunk, chunk_stats) in chunks {
            filed.append(chunk);
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
        let key_times = &self.patches.times.sets[self.patches.patches[patch as usize].motion as usize];
        let limit = self.tiles.side as f32;
        let mut stack = vec![context.whole(patch)];
        let before = filed.mark();
        let mut at_eye = 0;
        while let Some(piece) = stack.pop() {
            if at_eye > MOST_AT_EYE {
                filed.forget_since(before);
                let ix = self.patches.patches[patch as usize].primitive as usize;
                let name = self.scene.primitives[ix].object_name(ix);
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
            let small = bounds.size_px(&region).iter().all(|&size| size < limit);
            if !small && let Fate::Split(halves) = context.fate(&piece) {
                stats.splits += 1;
                stack.extend(halves);
                continue;
            }
            let tiles = self.tiles.touched(&bounds.sweep);
            filed.push(&piece, &bounds, key_times, context.is_surely_split(&piece), tiles);
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

/// Lights in camera space.
type PlacedLights = Arc<[Arc<dyn PlacedLight>]>;

/// The lights of each primitive; neighbours with the same list share theirs.
fn lights_of_primitives(scene: &Scene, placed: &[Arc<dyn PlacedLight>]) -> Vec<PlacedLights> {
    let mut lights: Vec<PlacedLights> = Vec::with_capacity(scene.primitives.len());
    for (ix, primitive) in scene.primitives.iter().enumerate() {
        let ixs = &primitive.attributes.lights;
        let is_like = |before: usize| Arc::ptr_eq(ixs, &scene.primitives[before].attributes.lights);
        lights.push(match ix.checked_sub(1).filter(|&before| is_like(before)) {
            Some(before) => Arc::clone(&lights[before]),
            None => ixs.iter().filter_map(|&ix| placed.get(ix as usize).cloned()).collect(),
        });
    }
    lights
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
    let own = own_times(scene);
    let mut times = KeyTimes::of_file(&own, &alone);
    if times.of_primitive.windows(2).any(|pair| pair[0] != pair[1]) {
        // Different times: what touches as the shutter opens may be welded, and is given the times of both.
        let (mut patches, _) = patchify(scene, &KeyTimes::still(scene));
        let edges = connect(&mut patches, fineness);
        times = KeyTimes::of_file(&own, &welded(&patches, &edges));
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
    let (refined, coarse) = KeyTimes::of_file(&own, &welded).refined(scene, camera, settings, &welded);
    for (primitive, error) in coarse {
        let name = scene.primitives[primitive as usize].object_name(primitive as usize);
        warnings.push(format!(
            "{name}: its path is so curved that it is drawn up to {error} pixels off; more key times would help"
        ));
    }
    if refined == times {
        return (patches, edges, warnings);
    }
    // Two lists of all points are more than a frame needs at any other time.
    (patches.floats, patches.bends) = (Vec::new(), Vec::new());
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
