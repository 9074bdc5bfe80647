//! Options of the command line that take the place of what a scene says.

use std::collections::HashMap;
use std::sync::Arc;

use olema::scene::Attributes;
use olema::{Scene, Settings};

use crate::args::RenderArgs;
use crate::exit::{self, Failure};
use crate::values::{self, ShadingTime, Shutter, Size};

/// The scene's settings with the options in their places.
///
/// # Errors
/// A usage failure where `--crop` leaves no pixel of the frame, or rasterizer and tile do not fit.
pub fn settings(args: &RenderArgs, scene: Settings) -> Result<Settings, Failure> {
    let mut settings = scene;
    if let Some(Size(resolution)) = args.res {
        settings.crop_px = settings.crop_px.map(|crop| scaled(crop, settings.resolution, resolution));
        settings.resolution = resolution;
    }
    if let Some(crop) = args.crop {
        let [w, h] = settings.resolution;
        let window = crop.pixels([w, h]);
        let problem = || format!("--crop: leaves no pixel of the frame, which has {w}x{h}");
        settings.crop_px = Some(window.ok_or_else(|| Failure::new(exit::USAGE, problem()))?);
    }
    if let Some(n) = args.spp {
        settings.samples = values::squarest(n);
    }
    if let Some(Size(samples)) = args.samples {
        settings.samples = samples;
    }
    if let Some(Size(bucket)) = args.bucket {
        settings.bucket = bucket;
    }
    settings.seed = args.seed.unwrap_or(settings.seed);
    settings.pattern_tile = args.tile.or(settings.pattern_tile);
    settings.permutations = args.permutations.unwrap_or(settings.permutations);
    settings.rasterizer = args.rasterizer.unwrap_or(settings.rasterizer);
    let cull = &mut settings.cull;
    cull.kind = args.cull.unwrap_or(cull.kind);
    cull.at = args.cull_at.unwrap_or(cull.at);
    cull.leaf_px = args.cull_leaf.unwrap_or(cull.leaf_px);
    cull.slices = args.cull_slices.unwrap_or(cull.slices);
    cull.order = args.cull_order.unwrap_or(cull.order);
    settings.shade = args.shade.unwrap_or(settings.shade);
    settings.motion_factor = args.motion_factor.or(settings.motion_factor);
    settings.focus_factor = args.focus_factor.or(settings.focus_factor);
    settings.shading_time = args.shading_time.map_or(settings.shading_time, ShadingTime::part);
    settings.tile = args.raster_tile.or(settings.tile);
    check_tile(&settings)?;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    settings.threads = values::threads(args.threads, cores);
    Ok(settings)
}

/// A scene alone never asks for a rasterizer and a tile that do not fit: its reader sees to that.
fn check_tile(settings: &Settings) -> Result<(), Failure> {
    let (tile, rasterizer) = (settings.pattern_tile_side(), settings.rasterizer);
    let most = rasterizer.greatest_tile();
    if tile <= most {
        return Ok(());
    }
    let problem = format!("--rasterizer {rasterizer} takes at most --tile {most}, not {tile}");
    Err(Failure::new(exit::USAGE, problem))
}

/// The scene's CropWindow in a frame of another size; at least a pixel is left.
fn scaled([x0, x1, y0, y1]: [u32; 4], from: [u32; 2], to: [u32; 2]) -> [u32; 4] {
    let scale = |c: u32, axis: usize| {
        let scaled = u64::from(c) * u64::from(to[axis]) / u64::from(from[axis].max(1));
        scaled.min(u64::from(to[axis])) as u32
    };
    let span = |c0: u32, c1: u32, axis: usize| {
        let start = scale(c0, axis).min(to[axis].saturating_sub(1));
        [start, scale(c1, axis).max(start + 1)]
    };
    let ([x0, x1], [y0, y1]) = (span(x0, x1, 0), span(y0, y1, 1));
    [x0, x1, y0, y1]
}

/// Puts the options that are about the scene itself in their places.
pub fn scene(args: &RenderArgs, scene: &mut Scene) {
    if let Some(rate) = args.shading_rate {
        shading_rate(scene, rate);
    }
    if let Some(Shutter(shutter)) = args.shutter {
        scene.camera.shutter = shutter;
    }
}

/// Gives every primitive this shading rate. Primitives that shared their attributes share them still.
fn shading_rate(scene: &mut Scene, rate: f32) {
    // Old and new by the old one's address; the old one is kept, so that no address comes back.
    let mut changed: HashMap<*const Attributes, [Arc<Attributes>; 2]> = HashMap::new();
    for primitive in &mut scene.primitives {
        let old = &primitive.attributes;
        let [_, new] = changed.entry(Arc::as_ptr(old)).or_insert_with(|| {
            let new = Attributes { shading_rate: rate, ..Attributes::clone(old) };
            [Arc::clone(old), Arc::new(new)]
        });
        primitive.attributes = Arc::clone(new);
    }
}

#[cfg(test)]
mod tests {
    use olema::sampling::Rasterizer;
    use olema::scene::Camera;

    use super::*;

    #[test]
    fn options_take_the_place_of_the_scene() {
        let args = RenderArgs {
            res: Some(Size([100, 50])),
            spp: Some(6),
            crop: "0.5,1,0,1".parse().ok(),
            seed: Some(7),
            bucket: Some(Size([16, 8])),
            threads: 3,
            rasterizer: Some(Rasterizer::Interval),
            motion_factor: Some(1.5),
            focus_factor: Some(0.0),
            shading_time: Some(ShadingTime::Close),
            ..RenderArgs::default()
        };
        let settings = settings(&args, Settings::default()).unwrap();
        assert_eq!((settings.motion_factor, settings.focus_factor), (Some(1.5), Some(0.0)));
        assert_eq!((settings.rasterizer, settings.shading_time), (Rasterizer::Interval, 1.0));
        assert_eq!(settings.resolution, [100, 50]);
        assert_eq!(settings.samples, [3, 2]);
        assert_eq!(settings.crop_px, Some([50, 100, 0, 50]));
        assert_eq!((settings.seed, settings.bucket, settings.threads), (7, [16, 8], 3));
    }

    #[test]
    fn without_options_the_scene_is_kept() {
        let scene =
            Settings { resolution: [32, 16], crop_px: Some([1, 5, 2, 6]), seed: 9, ..Settings::default() };
        assert_eq!(settings(&RenderArgs::default(), scene.clone()), Ok(scene));
    }

    #[test]
    fn the_shutter_takes_the_place_of_the_scenes() {
        let mut drawn = Scene::new(Camera { shutter: [0.0, 1.0], ..Camera::default() });
        scene(&RenderArgs::default(), &mut drawn);
        assert_eq!(drawn.camera.shutter, [0.0, 1.0]);
        scene(&RenderArgs { shutter: "2,2.5".parse().ok(), ..RenderArgs::default() }, &mut drawn);
        assert_eq!(drawn.camera.shutter, [2.0, 2.5]);
    }

    #[test]
    fn a_crop_outside_the_frame_is_a_usage_error() {
        let args = RenderArgs { crop: "700,800,0,5".parse().ok(), ..RenderArgs::default() };
        let failure = settings(&args, Settings::default()).unwrap_err();
        assert_eq!(failure.code, exit::USAGE);
        assert!(failure.message.contains("--crop") && failure.message.contains("640x480"));
    }

    #[test]
    fn a_tile_too_large_for_the_rasterizer_is_a_usage_error() {
        let args =
            |rasterizer, tile| RenderArgs { rasterizer: Some(rasterizer), tile, ..RenderArgs::default() };
        let failure = settings(&args(Rasterizer::InterleaveUvt, Some(64)), Settings::default()).unwrap_err();
        assert_eq!(failure.code, exit::USAGE);
        assert_eq!(failure.message, "--rasterizer interleave takes at most --tile 8, not 64");
        let simple = settings(&args(Rasterizer::Simple, None), Settings::default()).unwrap();
        assert_eq!(simple.pattern_tile_side(), 1);
    }

    #[test]
    fn a_new_resolution_scales_the_scenes_crop() {
        assert_eq!(scaled([320, 640, 0, 240], [640, 480], [64, 48]), [32, 64, 0, 24]);
        assert_eq!(scaled([639, 640, 479, 480], [640, 480], [1, 1]), [0, 1, 0, 1]);
    }
}
