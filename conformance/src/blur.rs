//! Flat shapes in pixel coordinates, and closed forms of what motion and lens make of them.
//!
//! A [`Stage`] is a plane that faces the camera at depth [`DEPTH`], as far out of focus as is asked for. Its shapes
//! are given in raster pixels, x right and y down; multiples of 1/256 px are kept to the bit.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DMat4, DVec3};
use olema::image::{Filter, FilterKind};
use olema::scene::{Attributes, Camera, Lens, PatchKind, Projection};
use olema::{Hooks, Renderer, Scene, Settings};

use crate::scenes::{add, bilinear, sheet, small, surface};

/// Where a stage is.
pub const DEPTH: f64 = 8.0;

/// A plane that faces the camera.
#[derive(Debug, Clone, Copy)]
pub struct Stage {
    /// The frame in pixels.
    pub size: [u32; 2],
    /// Signed radius of the circle of confusion in pixels, above 0 behind the focus.
    pub circle_px: f64,
}

impl Stage {
    /// In focus.
    pub fn sharp(size: [u32; 2]) -> Self {
        Stage { size, circle_px: 0.0 }
    }

    /// Nothing on it yet; the shutter is open from 0 to 1.
    pub fn scene(&self) -> Scene {
        let [w, h] = self.size.map(|size| size as f32 / 2.0);
        let (focus, radius) =
            if self.circle_px > 0.0 { (4.0, 8.0 * self.circle_px) } else { (16.0, -16.0 * self.circle_px) };
        let lens = Lens::new(1.0, 2.0 * radius as f32, focus);
        Scene::new(Camera {
            projection: Projection::Perspective { fov: 90.0 },
            screen_window: Some([-w, w, -h, h]),
            clipping: [0.01, 1000.0],
            shutter: [0.0, 1.0],
            lens: (self.circle_px != 0.0).then_some(lens),
            ..Camera::default()
        })
    }

    /// A raster place in camera space.
    pub fn point(&self, [x, y]: [f64; 2]) -> [f32; 3] {
        let [w, h] = self.size.map(|size| f64::from(size) / 2.0);
        [(x - w) * DEPTH, (h - y) * DEPTH, DEPTH].map(|c| c as f32)
    }

    /// The motion by so many pixels.
    pub fn shift(&self, [x, y]: [f64; 2]) -> DMat4 {
        DMat4::from_translation(DVec3::new(x * DEPTH, -y * DEPTH, 0.0))
    }

    /// The turn by `angle` radians about a raster place, clockwise as one sees it.
    pub fn turn(&self, about: [f64; 2], angle: f64) -> DMat4 {
        let hub = DMat4::from_translation(DVec3::from_array(self.point(about).map(f64::from)));
        hub * DMat4::from_rotation_z(-angle) * hub.inverse()
    }

    /// Puts a quad with corners (0,0), (1,0), (0,1), (1,1) on it, in one colour and opacity.
    pub fn add_quad(&self, scene: &mut Scene, corners: [[f64; 2]; 4], opacity: f32) {
        add(scene, bilinear(corners.map(|p| self.point(p))), DMat4::IDENTITY, &flat(opacity));
    }

    /// Puts a polygon of `sides` sides on it, with the area of a disk.
    pub fn add_disk(&self, scene: &mut Scene, centre: [f64; 2], radius: f64, sides: usize) {
        let step = 2.0 * PI / sides as f64;
        let rim = radius * (step / step.sin()).sqrt();
        let mut points = vec![self.point(centre); sides + 1];
        points.extend((0..=sides).map(|side| {
            let (sin, cos) = ((side % sides) as f64 * step).sin_cos();
            self.point([centre[0] + rim * cos, centre[1] + rim * sin])
        }));
        let disk = sheet(PatchKind::Bilinear, sides + 1, 2, points);
        add(scene, disk, DMat4::IDENTITY, &flat(1.0));
    }
}

fn flat(opacity: f32) -> Arc<Attributes> {
    Arc::new(Attributes { opacity: [opacity; 3], surface: surface("constant"), ..Attributes::default() })
}

/// A half plane to the left of the line through `through` along (-sin, cos) of `angle`, 60 px around.
pub fn half_plane(through: [f64; 2], angle: f64) -> [[f64; 2]; 4] {
    let (sin, cos) = angle.sin_cos();
    [[-60.0, -60.0], [0.0, -60.0], [-60.0, 60.0], [0.0, 60.0]]
        .map(|[a, b]| [through[0] + cos * a - sin * b, through[1] + sin * a + cos * b])
}

/// Settings with a box filter of one pixel.
pub fn boxed(size: [u32; 2], samples: [u32; 2]) -> Settings {
    let filter = Filter { kind: FilterKind::Box, width: [1.0, 1.0] };
    Settings { filter, ..small(size[0], size[1], samples) }
}

/// Alpha of all pixels.
pub fn alpha(scene: &Scene, settings: &Settings) -> Vec<f64> {
    let renderer = Renderer::new(settings.clone()).expect("valid settings");
    let frame = renderer.render(scene, &Hooks::default()).expect("a picture");
    let alpha = frame.image.channel("a").expect("alpha");
    alpha.values.iter().map(|&a| f64::from(a)).collect()
}

/// A seed and the cells of a pixel.
type Pattern = (u32, [u32; 2]);

/// 4096 samples a pixel: as many as one picture takes, four times.
const FULL: [Pattern; 4] = [(0, [32, 32]), (1, [64, 16]), (2, [16, 64]), (3, [128, 8])];

fn mean_alpha(scene: &Scene, settings: &Settings, patterns: &[Pattern]) -> Vec<f64> {
    let mut mean = vec![0.0; (settings.resolution[0] * settings.resolution[1]) as usize];
    for &(seed, samples) in patterns {
        for (sum, a) in mean.iter_mut().zip(alpha(scene, &Settings { seed, samples, ..settings.clone() })) {
            *sum += a / patterns.len() as f64;
        }
    }
    mean
}

/// How far pixels are from what is true.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// Of the worst pixel, in standard errors of 4096 independent samples.
    pub worst: f64,
    /// Root mean square of the same over the pixels that are covered in part.
    pub mean: f64,
}

impl Errors {
    /// Compares alpha over 4096 samples with the mean over each pixel of `truth` at (x, y).
    pub fn of(scene: &Scene, settings: &Settings, truth: impl Fn(f64, f64) -> f64) -> Self {
        Self::over(scene, settings, &FULL, truth)
    }

    /// The same for 256 pictures of 16 samples a pixel.
    pub fn of_few_samples(scene: &Scene, settings: &Settings, truth: impl Fn(f64, f64) -> f64) -> Self {
        let patterns: Vec<Pattern> = (0..256).map(|seed| (seed, [4, 4])).collect();
        Self::over(scene, settings, &patterns, truth)
    }

    fn over(
        scene: &Scene,
        settings: &Settings,
        patterns: &[Pattern],
        truth: impl Fn(f64, f64) -> f64,
    ) -> Self {
        let width = settings.resolution[0] as usize;
        let (mut worst, mut squares, mut num) = (0.0f64, 0.0, 0.0);
        for (ix, found) in mean_alpha(scene, settings, patterns).into_iter().enumerate() {
            let expected = over_pixel([ix % width, ix / width], &truth);
            let sigma = (expected * (1.0 - expected) / 4096.0).sqrt().max(1.0 / 4096.0);
            let error = (found - expected).abs() / sigma;
            worst = worst.max(error);
            if expected > 0.0 && expected < 1.0 {
                squares += error * error;
                num += 1.0;
            }
        }
        Errors { worst, mean: (squares / f64::max(num, 1.0)).sqrt() }
    }

    /// Whether independent samples would hardly do better.
    pub fn are_of_sampling(&self) -> bool {
        self.worst < 4.0 && self.mean < 1.2
    }
}

/// Mean of a function of raster x and y over a pixel.
pub fn over_pixel([px, py]: [usize; 2], of: &impl Fn(f64, f64) -> f64) -> f64 {
    let n = 24;
    let at = |i: usize, px: usize| px as f64 + (i as f64 + 0.5) / n as f64;
    (0..n * n).map(|i| of(at(i % n, px), at(i / n, py))).sum::<f64>() / (n * n) as f64
}

/// Mean of a function of time, from 0 to 1.
pub fn over_time(steps: u32, of: impl Fn(f64) -> f64) -> f64 {
    (0..steps).map(|step| of((f64::from(step) + 0.5) / f64::from(steps))).sum::<f64>() / f64::from(steps)
}

/// Part of the unit disk with u above `s`.
pub fn disk_beyond(s: f64) -> f64 {
    let s = s.clamp(-1.0, 1.0);
    0.5 - (s.asin() + s * (1.0 - s * s).sqrt()) / PI
}

/// Area that disks of radius a and b share, their centres d apart.
pub fn shared_area(a: f64, b: f64, d: f64) -> f64 {
    if d >= a + b {
        return 0.0;
    }
    if d <= (a - b).abs() {
        return PI * a.min(b).powi(2);
    }
    let angle = |a: f64, b: f64| ((d * d + a * a - b * b) / (2.0 * d * a)).clamp(-1.0, 1.0).acos();
    let segment = |a: f64, angle: f64| a * a * (angle - angle.sin() * angle.cos());
    segment(a, angle(a, b)) + segment(b, angle(b, a))
}

/// Light let through until time `t` by a shutter that opens until `open` and closes from `close` on, of all of it.
pub fn light_until(t: f64, open: f64, close: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    let opening = if open > 0.0 { t.min(open).powi(2) / (2.0 * open) } else { 0.0 };
    let full = (t.min(close) - open).max(0.0);
    let left = |t: f64| if close < 1.0 { (1.0 - t).powi(2) / (2.0 * (1.0 - close)) } else { 0.0 };
    let closing = if t > close { left(close) - left(t) } else { 0.0 };
    (opening + full + closing) / (0.5 * open + (close - open) + 0.5 * (1.0 - close))
}
