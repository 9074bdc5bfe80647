//! Pictures and figures of how motion and focus are sampled: `blur DIR` writes the pictures of docs/sampling.md.
//!
//! - `one-tuple.png`, `no-permutations.png`, `permutations.png`: a thin bar that moves by 80 px, at 16 samples, with
//!   K = 1, with K = 2 and a single permutation set, and with K = 2 and 64 sets. The spectra of what is wrong with
//!   them are printed: peak over mean of the power over all frequencies but 0.
//! - `highlights.png`: lights behind and in front of the focus through a lens of six blades.
//! - `teapots.png`: turning, out of focus, and both.

use std::path::Path;
use std::sync::Arc;

use conformance::moving::{defocused, driven};
use conformance::scenes::{add, bilinear, camera, surface, teapot_from};
use glam::{DMat4, DVec3};
use olema::image::{Filter, FilterKind};
use olema::scene::{Attributes, Keyed, Lens, Projection, Transform};
use olema::{Hooks, Image, Renderer, Scene, Settings};
use olema_formats::image_file::{PngOptions, write_png};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let dir = std::env::args().nth(1).ok_or("usage: blur DIR")?;
    let dir = Path::new(&dir);
    let moving = bar();
    for (name, tile, permutations) in
        [("one-tuple", 1, 64), ("no-permutations", 2, 1), ("permutations", 2, 64)]
    {
        let settings = Settings { pattern_tile: Some(tile), permutations, ..boxed(128, 96, 4) };
        let image = render(&moving, settings)?;
        let (peak, [fx, fy]) = spectrum(&image);
        println!(
            "{name}: K = {tile}, P = {permutations}: peak / mean power {peak:.1} at ({fx}, {fy}) / 64 cycles a pixel"
        );
        write(&dir.join(format!("{name}.png")), &enlarged(&brightened(&image, 6.0), 3))?;
    }
    write(&dir.join("highlights.png"), &render(&highlights(), boxed(480, 160, 16))?)?;
    let teapot = || teapot_from([0.0, -9.0, 4.0], [0.0, 0.0, 1.4], 34.0);
    let turning = driven(teapot(), [0.0; 3], 0.5);
    let scenes = [turning.clone(), defocused(teapot(), 1.0, 7.0), defocused(turning, 1.0, 7.0)];
    let settings = Settings {
        resolution: [320, 240],
        samples: [8, 8],
        background: Some([0.1, 0.13, 0.17]),
        ..Settings::default()
    };
    let images: Vec<Image> =
        scenes.iter().map(|scene| render(scene, settings.clone())).collect::<Result<_, _>>()?;
    write(&dir.join("teapots.png"), &beside(&images))?;
    Ok(())
}

fn boxed(width: u32, height: u32, samples: u32) -> Settings {
    Settings {
        resolution: [width, height],
        samples: [samples; 2],
        filter: Filter { kind: FilterKind::Box, width: [1.0; 2] },
        background: Some([0.0; 3]),
        ..Settings::default()
    }
}

fn render(scene: &Scene, settings: Settings) -> Result<Image, olema::Error> {
    Ok(Renderer::new(settings)?.render(scene, &Hooks::default())?.image)
}

fn write(path: &Path, image: &Image) -> Result<(), Box<dyn std::error::Error>> {
    Ok(write_png(path, image, &PngOptions::default())?)
}

/// A constant colour.
fn flat(color: [f32; 3]) -> Arc<Attributes> {
    Arc::new(Attributes { color, surface: surface("constant"), ..Attributes::default() })
}

/// A bar 5 px wide that moves by 80 px, seen without perspective: 1/16 is seen of it everywhere on its way.
fn bar() -> Scene {
    let mut scene = Scene::new(camera([0.0, -10.0, 0.0], [0.0; 3], 45.0));
    scene.camera.projection = Projection::Orthographic;
    scene.camera.screen_window = Some([-64.0, 64.0, -48.0, 48.0]);
    scene.camera.shutter = [0.0, 1.0];
    let [x0, x1] = [-45.0, -40.0];
    let geometry = bilinear([[x0, 0.0, -40.0], [x1, 0.0, -40.0], [x0, 0.0, 40.0], [x1, 0.0, 40.0]]);
    add(&mut scene, geometry, DMat4::IDENTITY, &flat([1.0; 3]));
    let at = |x: f64| DMat4::from_translation(DVec3::new(x, 0.0, 0.0));
    scene.primitives[0].to_world =
        Transform::from(Keyed { times: vec![0.0, 1.0], values: vec![at(0.0), at(80.0)] });
    scene
}

/// Small bright squares at several depths, the focus at that of the third.
fn highlights() -> Scene {
    let mut scene = Scene::new(camera([0.0, -10.0, 0.0], [0.0; 3], 40.0));
    scene.camera.lens = Some(Lens { blades: 6, blade_angle: 10.0, ..Lens::new(0.35, 1.0, 10.0) });
    for (ix, depth) in [5.5, 7.5, 10.0, 15.0, 40.0].into_iter().enumerate() {
        // Where it is seen does not depend on its depth, nor how large.
        let scale = depth / 10.0;
        let (x, side) = ((ix as f64 - 2.0) * 4.0 * scale, 0.08 * scale);
        let corner = |a: f64, b: f64| [(x + a * side) as f32, (depth - 10.0) as f32, (b * side) as f32];
        let geometry = bilinear([corner(-1.0, -1.0), corner(1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0)]);
        let bright = [1.0, 2.0, 3.0].map(|c: f32| 400.0 / (c + ix as f32));
        add(&mut scene, geometry, DMat4::IDENTITY, &flat(bright));
    }
    scene
}

/// Power of the frequencies of 64 x 64 pixels in the middle: the largest over the mean, and where it is.
fn spectrum(image: &Image) -> (f64, [usize; 2]) {
    const N: usize = 64;
    let red = &image.channels[0].values;
    let at = |x: usize, y: usize| f64::from(red[(y + 16) * 128 + x + 32]);
    let turn = |k: usize| (std::f64::consts::TAU * (k % N) as f64 / N as f64).sin_cos();
    // Rows, then columns; (sine, cosine) parts.
    let mut rows = vec![[0.0; 2]; N * N];
    for (y, f) in (0..N).flat_map(|y| (0..N).map(move |f| (y, f))) {
        for x in 0..N {
            let (sin, cos) = turn(f * x);
            rows[y * N + f][0] += cos * at(x, y);
            rows[y * N + f][1] -= sin * at(x, y);
        }
    }
    let (mut sum, mut peak, mut place) = (0.0, 0.0, [0, 0]);
    for (fx, fy) in (0..N).flat_map(|fx| (0..N).map(move |fy| (fx, fy))).filter(|f| *f != (0, 0)) {
        let (mut re, mut im) = (0.0, 0.0);
        for y in 0..N {
            let ((sin, cos), [a, b]) = (turn(fy * y), rows[y * N + fx]);
            re += a * cos + b * sin;
            im += b * cos - a * sin;
        }
        let power = re * re + im * im;
        sum += power;
        if power > peak {
            (peak, place) = (power, [fx.min(N - fx), fy.min(N - fy)]);
        }
    }
    (peak * (N * N - 1) as f64 / sum, place)
}

fn brightened(image: &Image, factor: f32) -> Image {
    let mut bright = image.clone();
    for channel in bright.channels.iter_mut().take(3) {
        channel.values.iter_mut().for_each(|value| *value *= factor);
    }
    bright
}

/// Each pixel as `n` x `n`.
fn enlarged(image: &Image, n: u32) -> Image {
    assembled(image.frame_px.map(|size| size * n), image, |x, y| (0, x / n, y / n), &[])
}

/// Images side by side.
fn beside(images: &[Image]) -> Image {
    let [width, height] = images[0].frame_px;
    let size = [width * images.len() as u32, height];
    assembled(size, &images[0], |x, y| ((x / width) as usize, x % width, y), images)
}

/// An image whose pixels are taken from others (or from `first` where there are none).
fn assembled(
    size: [u32; 2],
    first: &Image,
    from: impl Fn(u32, u32) -> (usize, u32, u32),
    images: &[Image],
) -> Image {
    let mut all = Image::new(size, [0, size[0], 0, size[1]], &["r", "g", "b", "a"]);
    for (y, x) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (y, x))) {
        let (image, px, py) = from(x, y);
        let image = images.get(image).unwrap_or(first);
        for c in 0..4 {
            let value = image.channels[c].values[(py * image.frame_px[0] + px) as usize];
            all.channels[c].values[(y * size[0] + x) as usize] = value;
        }
    }
    all
}
