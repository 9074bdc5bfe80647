//! What displacement costs, and the pictures of Sattlecker 2015, section 3.2.
//!
//! `cargo run --release -p conformance --bin displacement -- [DIR]` renders a model of 11,500 bicubic patches with
//! and without displacement, in turn, and prints the medians of its stages, how much of a frame displacement takes, and how
//! much of it are the exact normals; with a folder it also writes there:
//!
//! - `exact-normals.png`, `estimated-normals.png`: displaced along exact normals, and along normals estimated from
//!   neighbouring points of each patch, which tears the surface open at the patches' borders;
//! - `exact-rasterization.png`, `nearest-pixel.png`: micropolygons rasterized, and their vertices put into the
//!   nearest pixel, which leaves holes.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use conformance::creature::tube;
use olema::math::noise;
use olema::pipeline::Grid;
use olema::pipeline::piece::Sabotage;
use olema::pipeline::shade::Colors;
use olema::sampling::inside::HitPoint;
use olema::sampling::nomotion::{Facing, GridView, HitSink, SampleCounts, rasterize_grid};
use olema::sampling::{PatternSpec, Region, RegionSamples, SamplePattern};
use olema::scene::Attributes;
use olema::shading::{ShaderParam as Param, TextureImage, displacement_with_images};
use olema::stats::Seconds;
use olema::{Hooks, Image, Renderer, Scene, Settings, Stats};
use olema_formats::image_file::{PngOptions, write_png};

const RUNS: usize = 9;

/// A stage's name and its seconds.
type Stage = (&'static str, fn(&Seconds) -> f64);

const STAGES: [Stage; 7] = [
    ("connect", |s| s.connect),
    ("split", |s| s.split),
    ("dice", |s| s.dice),
    ("shade", |s| s.shade),
    ("sample", |s| s.sample),
    ("resolve", |s| s.resolve),
    ("total", |s| s.total),
];
const DICE: usize = 2;
const TOTAL: usize = 6;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let plain = tube(144, 80);
    let variants: [(&str, Scene); 9] = [
        ("not displaced", plain.clone()),
        ("noise", displaced(&plain, "noise", 0.12, false)?),
        ("fractal", displaced(&plain, "fractal", 0.12, false)?),
        // Small details, of some two pixels, as in the paper's figure 5.
        ("noise, 0.02 high", displaced(&plain, "noise", 0.02, false)?),
        ("fractal, 0.02 high", displaced(&plain, "fractal", 0.02, false)?),
        // By an image along the normal, as the paper does.
        ("image, 0.02 high", displaced(&plain, "image", 0.02, false)?),
        // All the work, and the size and shape of what is not displaced.
        ("noise, 1e-5 as high", displaced(&plain, "noise", 0.12e-5, false)?),
        ("fractal, 1e-5 as high", displaced(&plain, "fractal", 0.12e-5, false)?),
        ("fractal, bump only", displaced(&plain, "fractal", 0.12, true)?),
    ];
    let mut runs: Vec<Vec<Stats>> = vec![Vec::new(); variants.len()];
    for _ in 0..RUNS {
        for (slot, (_, scene)) in runs.iter_mut().zip(&variants) {
            slot.push(render(scene)?);
        }
    }
    println!("800 x 600, 16 samples a pixel, one thread, medians of {RUNS} in turn, seconds");
    print!("{:<22}", "");
    STAGES.iter().for_each(|(name, _)| print!(" {name:>7}"));
    println!("   share of displacement, of dicing alone");
    let of = |runs: &[Stats]| STAGES.map(|(_, seconds)| median(runs, |stats| seconds(&stats.seconds)));
    let plain = of(&runs[0]);
    for ((name, scene), stats) in variants.iter().zip(&runs) {
        let seconds = of(stats);
        let total = seconds[TOTAL];
        print!("{name:<22}");
        seconds.iter().for_each(|seconds| print!(" {seconds:>7.3}"));
        let share = |stage: usize| 100.0 * (seconds[stage] - plain[stage]) / total;
        println!(" {:>7.1} % {:>6.1} %", share(TOTAL), share(DICE));
        if scene.primitives[0].attributes.displacement.as_ref().is_some_and(|shader| !shader.is_bump()) {
            println!("{:<22} {:.1} % of the frame", "  exact normals", 100.0 * exact_normals(scene)? / total);
        }
    }
    if let Some(dir) = std::env::args().nth(1) {
        pictures(Path::new(&dir))?;
    }
    Ok(())
}

fn displaced(plain: &Scene, name: &str, amplitude: f32, bump: bool) -> Result<Scene, olema::Error> {
    let mut scene = plain.clone();
    let mut params =
        vec![Param::float("amplitude", amplitude), Param::float("bump", f32::from(u8::from(bump)))];
    if name == "image" {
        // As often as its squares stay about square on the tube.
        let repeats = [("sscale", 24.0), ("tscale", 6.0), ("zero", 0.5)];
        params.extend(repeats.map(|(name, value)| Param::float(name, value)));
        params.push(Param::string("texturename", "bumps"));
    } else {
        params.push(Param::float("frequency", 3.0));
    }
    let shader = displacement_with_images(name, &params, &|_| bumps().map_err(|e| e.to_string()))?.shader;
    let attributes = (*scene.primitives[0].attributes).clone();
    scene.primitives[0].attributes = Arc::new(Attributes { displacement: Some(shader), ..attributes });
    Ok(scene)
}

/// An image of 128 x 128 texels of eight bits: gradient noise, sixteen cells wide.
fn bumps() -> Result<Arc<TextureImage>, olema::Error> {
    let height = |n: u32| {
        let place = [n % 128, n / 128].map(|c| f64::from(c) / 8.0);
        (128.0 + 127.0 * noise::gradient([place[0], place[1], 0.5], 0)).round() / 255.0
    };
    let texels: Vec<f32> = (0..128 * 128).map(height).collect();
    Ok(Arc::new(TextureImage::new(128, 128, texels.into())?))
}

fn settings() -> Settings {
    Settings { resolution: [800, 600], threads: 1, ..Settings::default() }
}

fn render(scene: &Scene) -> Result<Stats, olema::Error> {
    let start = Instant::now();
    let clock = || start.elapsed().as_secs_f64();
    let hooks = Hooks { clock: Some(&clock), ..Hooks::default() };
    Ok(Renderer::new(settings())?.render(scene, &hooks)?.stats)
}

/// Seconds by which dicing and shading all grids with exact normals takes longer than with normals that are estimated from
/// neighbouring points of a grid.
fn exact_normals(scene: &Scene) -> Result<f64, olema::Error> {
    let mut seconds = [Vec::new(), Vec::new()];
    for _ in 0..RUNS {
        for (seconds, sabotage) in seconds.iter_mut().zip([None, Some(Sabotage::EstimatedNormals)]) {
            let start = Instant::now();
            olema::engine::grids(scene, &settings(), sabotage, |_, _, _, _| {})?;
            seconds.push(start.elapsed().as_secs_f64());
        }
    }
    let [exact, estimated] = seconds.map(|seconds| median(&seconds, |&seconds| seconds));
    Ok(exact - estimated)
}

fn median<T>(all: &[T], value: impl Fn(&T) -> f64) -> f64 {
    let mut values: Vec<f64> = all.iter().map(value).collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// A plain z-buffer, one sample a pixel.
struct Canvas {
    size: [usize; 2],
    depth: Vec<f32>,
    image: Image,
    /// Colour of the micropolygon that is drawn.
    color: [f32; 3],
}

impl Canvas {
    fn new(size: [u32; 2]) -> Self {
        let pixels = size[0] as usize * size[1] as usize;
        let image = Image::new(size, [0, size[0], 0, size[1]], &["r", "g", "b", "a"]);
        Canvas { size: size.map(|s| s as usize), depth: vec![f32::INFINITY; pixels], image, color: [0.0; 3] }
    }

    fn put(&mut self, pixel: usize, depth: f32) {
        if depth < self.depth[pixel] {
            self.depth[pixel] = depth;
            for (channel, value) in self.image.channels.iter_mut().zip(self.color.into_iter().chain([1.0])) {
                channel.values[pixel] = value;
            }
        }
    }

    fn put_vertices(&mut self, grid: &Grid, colors: &Colors) {
        for v in 0..grid.num_vertices() {
            let [x, y] = [grid.x[v] >> 8, grid.y[v] >> 8];
            if (0..self.size[0] as i32).contains(&x) && (0..self.size[1] as i32).contains(&y) {
                self.color = colors.color[v].truncate().to_array();
                self.put(y as usize * self.size[0] + x as usize, grid.depth[v]);
            }
        }
    }
}

/// Draws micropolygons in the colour of their first vertex.
struct Sink<'a> {
    canvas: &'a mut Canvas,
    grid: &'a Grid,
    colors: &'a Colors,
}

impl HitSink for Sink<'_> {
    fn begin(&mut self, micropolygon: u32) {
        self.canvas.color =
            self.colors.color[self.grid.corners(micropolygon as usize)[0]].truncate().to_array();
    }

    fn hit(&mut self, sample_ix: usize, point: HitPoint, _triangle: u8, _sign: i8) {
        self.canvas.put(sample_ix, point.depth);
    }
}

fn pictures(dir: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let size = [400, 300];
    let settings = Settings { resolution: size, ..settings() };
    let scene = displaced(&tube(16, 5), "fractal", 0.6, false)?;
    let pattern =
        SamplePattern::new(PatternSpec { samples: [1, 1], jitter: false, ..PatternSpec::default() });
    let samples = RegionSamples::new(&pattern, Region::new(0, size[0] as i32, 0, size[1] as i32));
    let draw = |sabotage, nearest: bool| -> Result<Canvas, olema::Error> {
        let mut canvas = Canvas::new(size);
        olema::engine::grids(&scene, &settings, sabotage, |_, grid, colors, _| {
            if nearest {
                canvas.put_vertices(grid, colors);
                return;
            }
            let (m, n) = (grid.m as usize, grid.n as usize);
            let view = GridView { m, n, x: &grid.x, y: &grid.y, depth: &grid.depth };
            let mut sink = Sink { canvas: &mut canvas, grid, colors };
            rasterize_grid(view, Facing::Any, None, &samples, &mut SampleCounts::default(), &mut sink);
        })?;
        Ok(canvas)
    };
    for (name, sabotage, nearest) in [
        ("exact-normals", None, false),
        ("estimated-normals", Some(Sabotage::EstimatedNormals), false),
        ("exact-rasterization", None, false),
        ("nearest-pixel", None, true),
    ] {
        let path = dir.join(format!("{name}.png"));
        write_png(&path, &draw(sabotage, nearest)?.image, &PngOptions::default())?;
        println!("{}", path.display());
    }
    Ok(())
}
