//! Options of the command line that take the place of what a scene says.

use std::collections::HashMap;
use std::sync::Arc;

use olema::scene::Attributes;
use olema::{Scene, Settings};

use crate::args::RenderArgs;
use crate::exit::{self, Failure};
use crate::values::{self, Size};

/// The scene's settings with the options in their places.
///
/// # Errors
/// A usage failure where `--crop` leaves no pixel of the frame.
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
    settings.tile = args.raster_tile.or(settings.tile);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    settings.threads = values::threads(args.threads, cores);
    Ok(settings)
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

/// Gives every primitive this shading rate. Primitives that shared their attributes share them still.
pub fn shading_rate(scene: &mut Scene, rate: f32) {
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
            ..RenderArgs::default()
        };
        let settings = settings(&args, Settings::default()).unwrap();
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
    fn a_crop_outside_the_frame_is_a_usage_error() {
        let args = RenderArgs { crop: "700,800,0,5".parse().ok(), ..RenderArgs::default() };
        let failure = settings(&args, Settings::default()).unwrap_err();
        assert_eq!(failure.code, exit::USAGE);
        assert!(failure.message.contains("--crop") && failure.message.contains("640x480"));
    }

    #[test]
    fn a_new_resolution_scales_the_scenes_crop() {
        assert_eq!(scaled([320, 640, 0, 240], [640, 480], [64, 48]), [32, 64, 0, 24]);
        assert_eq!(scaled([639, 640, 479, 480], [640, 480], [1, 1]), [0, 1, 0, 1]);
    }
}
