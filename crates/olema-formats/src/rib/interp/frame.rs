//! From the state to a frame: camera, settings, displays.

use std::sync::Arc;

use olema::sampling::Rasterizer;
use olema::scene::{Camera, Lens, Light, Projection};
use olema::{Scene, Settings};

use super::super::fault::Fault;
use super::super::state::{OptionState, Site};
use super::super::{Display, RibFrame};
use super::{Interp, World};

impl OptionState {
    /// Width and height in pixels: the largest part of the format that has the frame's aspect ratio.
    pub fn resolution(&self) -> [u32; 2] {
        let [width, height] = self.format.map(f64::from);
        let Some(aspect) = self.frame_aspect else { return self.format };
        let whole = |n: f64| (n.round() as u32).clamp(1, 65_535);
        if aspect >= width * self.pixel_aspect / height {
            [self.format[0], whole(width * self.pixel_aspect / aspect)]
        } else {
            [whole(height * aspect / self.pixel_aspect), self.format[1]]
        }
    }

    /// Left, right, bottom and top of the screen.
    pub fn screen(&self) -> [f64; 4] {
        let [width, height] = self.format.map(f64::from);
        let aspect = self.frame_aspect.unwrap_or(width * self.pixel_aspect / height);
        let [x, y] = if aspect >= 1.0 { [aspect, 1.0] } else { [1.0, 1.0 / aspect] };
        self.screen_window.unwrap_or([-x, x, -y, y])
    }

    /// The pixels of the crop window, `[x0, x1, y0, y1]`, end exclusive. The standard's rounding, in which windows
    /// that share a side share no pixel: from ceil(n * min) to ceil(n * max - 1), both inclusive.
    fn crop_px(&self) -> Option<[u32; 4]> {
        let [x0, x1, y0, y1] = self.crop?;
        let [width, height] = self.resolution();
        let edge = |n: u32, part: f64| (f64::from(n) * part).ceil().clamp(0.0, f64::from(n)) as u32;
        Some([edge(width, x0), edge(width, x1), edge(height, y0), edge(height, y1)])
    }

    fn settings(&self, said: &mut Vec<Fault>, site: &Site) -> Settings {
        let default = Settings::default();
        let mut crop_px = self.crop_px();
        if crop_px.is_some_and(|[x0, x1, y0, y1]| x0 >= x1 || y0 >= y1) {
            let message =
                "the crop window holds no pixel: expected one at least; the whole frame is rendered";
            said.push(Fault::warning(site.pos, message));
            crop_px = None;
        }
        let settings = Settings {
            resolution: self.resolution(),
            crop_px,
            samples: self.samples,
            filter: self.filter,
            exposure: self.exposure,
            background: self.background,
            jitter: self.jitter,
            pattern_tile: self.pattern_tile,
            permutations: self.permutations.unwrap_or(default.permutations),
            rasterizer: self.rasterizer,
            grid_size: self.grid_size.map_or(default.grid_size, |n| n.clamp(1, 4096)),
            eye_splits: self.eye_splits.map_or(default.eye_splits, |n| n.min(20)),
            bucket: self.bucket.map_or(default.bucket, |b| b.map(|n| n.max(1))),
            ..default
        };
        let (tile, rasterizer) = (settings.pattern_tile_side(), settings.rasterizer);
        let most = rasterizer.greatest_tile();
        if tile <= most {
            return settings;
        }
        let message = format!(
            "hider \"tile\" {tile}: expected at most {most} with rasterizer \"{rasterizer}\"; auto is used"
        );
        said.push(Fault::error(site.pos, message));
        Settings { rasterizer: Rasterizer::Auto, ..settings }
    }

    fn displays(&self) -> Vec<Display> {
        let quantize_of = |mode: &str| {
            let name = if matches!(mode, "rgb" | "a" | "rgbz" | "rgbaz") { "rgba" } else { mode };
            let find = |name: &str| self.quantize.iter().find(|q| q.0 == name).map(|q| q.1);
            find(name).or_else(|| find("rgba"))
        };
        let finish = |state: &super::super::state::DisplayState| {
            let mut display = state.display.clone();
            if let (false, Some(quantize)) = (state.own, quantize_of(&display.mode)) {
                display.quantize = quantize;
            }
            display.quantize.dither = state.dither.unwrap_or(display.quantize.dither);
            display
        };
        if self.displays.is_empty() {
            let quantize = super::super::Quantize { one: 255, min: 0, max: 255, dither: 0.5 };
            let quantize = quantize_of("rgba").unwrap_or(quantize);
            let [name, driver, mode] = ["ri.png", "file", "rgba"].map(str::to_owned);
            return vec![Display { name, driver, mode, quantize }];
        }
        self.displays.iter().map(finish).collect()
    }
}

impl Interp {
    /// The camera that the current transformation and options describe, for the WorldBegin at `site`.
    pub(super) fn camera(&mut self, site: &Site) -> Camera {
        let lens = self.lens(site);
        let options = &self.options;
        let explicit = options.screen_window.is_some() || options.frame_aspect.is_some();
        Camera {
            world_to_camera: self.ctm.clone(),
            projection: options.projection,
            screen_window: explicit.then(|| options.screen().map(|v| v as f32)),
            pixel_aspect: options.pixel_aspect as f32,
            clipping: options.clipping.map(|v| v as f32),
            shutter: options.shutter,
            shutter_opening: options.shutter_opening,
            lens,
        }
    }

    /// The lens with its aperture; none where rays are parallel.
    fn lens(&mut self, site: &Site) -> Option<Lens> {
        let (lens, stands) = self.options.lens.clone()?;
        if self.options.projection == Projection::Orthographic {
            let message =
                "DepthOfField has no effect with an orthographic projection: expected a perspective one";
            let pos = if stands.file == site.file { stands.pos } else { site.pos };
            self.say(Fault::warning(pos, message));
            return None;
        }
        let (blades, blade_angle) = self.options.aperture;
        Some(Lens { blades, blade_angle, ..lens })
    }

    /// The frame of a finished world.
    pub(super) fn frame(&mut self, world: World) -> RibFrame {
        let mut scene = world.scene;
        self.finish(&mut scene);
        let origin = self.blocks.last().map(|b| b.site.clone());
        let site = origin.unwrap_or(Site { file: Arc::from(""), pos: Default::default() });
        let settings = self.options.settings(&mut self.said, &site);
        RibFrame { number: self.frame_number, scene, settings, displays: self.options.displays() }
    }

    /// Adds the lights and named spaces, all of them from world.
    fn finish(&mut self, scene: &mut Scene) {
        let camera = &scene.camera.world_to_camera;
        let to_world = camera.inverse();
        let first = to_world.first();
        for light in &self.names.lights {
            // A light of the camera's space stands still there; where the camera moves, it is taken along.
            let to_world =
                if light.in_world { light.matrix.clone() } else { to_world.then_of(&light.matrix) };
            scene.lights.push(Light { shader: light.shader.clone(), to_world });
        }
        for space in &self.names.spaces {
            let matrix = if space.in_world { space.matrix } else { first * space.matrix };
            scene.coordinate_systems.push((space.name.clone(), matrix));
        }
    }
}
