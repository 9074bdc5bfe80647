//! What displacement costs, and the pictures of Sattlecker 2015, section 3.2.
//!
//! `cargo run --release -p conformance --bin displacement -- [--size WIDTHxHEIGHT] [--blur]` renders a model of 11,500
//! bicubic patches with and without displacement, in turn, each frame in a process of its own as `olema render` draws it,
//! and prints the medians of its stages, how much of a frame displacement takes, and how much of it are the exact normals.
//! `--blur` moves the model in front of a lens. With a folder in their place it writes there:
//!
//! - `exact-normals.png`, `estimated-normals.png`: displaced along exact normals, and along normals estimated from
//!   neighbouring points of each patch, which tears the surface open at the patches' borders;
//! - `exact-rasterization.png`, `nearest-pixel.png`: micropolygons rasterized, and their vertices put into the
//!   nearest pixel, which leaves holes.

use std::error::Error;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::Instant;

use conformance::creature::tube;
use conformance::moving::{defocused, driven};
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
use olema::{Hooks, Image, Renderer, Scene, Settings};
use olema_formats::image_file::{PngOptions, write_png};

const RUNS: usize = 9;

const STAGES: [&str; 7] = ["connect", "split", "dice", "shade", "sample", "resolve", "total"];
const DICE: usize = 2;
const TOTAL: usize = 6;

/// Seconds of each stage, and those that the exact normals take.
type Measured = [f64; STAGES.len() + 1];
const NORMALS: usize = STAGES.len();

/// A displacement's name, shader, height, and whether only normals follow.
type Variant = (&'static str, Option<(&'static str, f32, bool)>);

const VARIANTS: [Variant; 9] = [
    ("not displaced", None),
    ("noise", Some(("noise", 0.12, false))),
    ("fractal", Some(("fractal", 0.12, false))),
    // Small details, of some two pixels, as in the paper's figure 5.
    ("noise, 0.02 high", Some(("noise", 0.02, false))),
    ("fractal, 0.02 high", Some(("fractal", 0.02, false))),
    // By an image along the normal, as the paper does.
    ("image, 0.02 high", Some(("image", 0.02, false))),
    // All the work, and the size and shape of what is not displaced.
    ("noise, 1e-5 as high", Some(("noise", 0.12e-5, false))),
    ("fractal, 1e-5 as high", Some(("fractal", 0.12e-5, false))),
    ("fractal, bump only", Some(("fractal", 0.12, true))),
];

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let mut view = View { size: [800, 600], blur: false };
    let mut rest = args.iter();
    while let Some(arg) = rest.next() {
        match arg.as_str() {
            "--size" => view.size = rest.next().and_then(|size| parse_size(size)).ok_or(USAGE)?,
            "--blur" => view.blur = true,
            "--alone" => {
                let variant =
                    rest.next().and_then(|ix| VARIANTS.get(ix.parse::<usize>().ok()?)).ok_or(USAGE)?;
                let line = measure(view, variant)?.map(|seconds| seconds.to_string()).join(" ");
                println!("{line}");
                return Ok(());
            }
            dir if !dir.starts_with('-') && args.len() == 1 => return pictures(Path::new(dir)),
            _ => return Err(USAGE.into()),
        }
    }
    compare(view)
}

const USAGE: &str = "usage: displacement [--size WIDTHxHEIGHT] [--blur], or displacement DIR";

fn parse_size(text: &str) -> Option<[u32; 2]> {
    let (width, height) = text.split_once('x')?;
    Some([width.parse().ok()?, height.parse().ok()?])
}

/// What is rendered.
#[derive(Debug, Clone, Copy)]
struct View {
    size: [u32; 2],
    blur: bool,
}

/// Prints a table of medians. Shares are medians of those of each turn, as the machine may change its speed between turns.
fn compare(view: View) -> Result<(), Box<dyn Error>> {
    let mut runs: Vec<Vec<Measured>> = vec![Vec::new(); VARIANTS.len()];
    for _ in 0..RUNS {
        for (ix, runs) in runs.iter_mut().enumerate() {
            runs.push(in_child(view, ix)?);
        }
    }
    let (View { size: [width, height], blur }, plain) = (view, &runs[0]);
    let kind = if blur { "motion and lens" } else { "still" };
    println!(
        "{width} x {height}, {kind}, 16 samples a pixel, one thread, medians of {RUNS} in turn, seconds"
    );
    print!("{:<22}", "");
    STAGES.iter().for_each(|name| print!(" {name:>7}"));
    println!("   share of displacement, of dicing alone, of exact normals");
    for ((name, _), runs) in VARIANTS.iter().zip(&runs) {
        print!("{name:<22}");
        (0..STAGES.len()).for_each(|stage| print!(" {:>7.3}", median(runs.iter().map(|run| run[stage]))));
        let share = |stage: usize| {
            let turns = runs.iter().zip(plain);
            100.0 * median(turns.map(|(run, plain)| (run[stage] - plain[stage]) / run[TOTAL]))
        };
        let normals = 100.0 * median(runs.iter().map(|run| run[NORMALS] / run[TOTAL]));
        println!(" {:>7.1} % {:>7.1} % {normals:>7.1} %", share(TOTAL), share(DICE));
    }
    Ok(())
}

/// Renders a frame in a process of its own.
fn in_child(View { size: [width, height], blur }: View, variant: usize) -> Result<Measured, Box<dyn Error>> {
    let mut command = Command::new(std::env::current_exe()?);
    command.args(blur.then_some("--blur")).args(["--size", &format!("{width}x{height}")]);
    command.args(["--alone", &variant.to_string()]);
    let output = command.stdin(Stdio::null()).stderr(Stdio::inherit()).output()?;
    let line = String::from_utf8(output.stdout)?;
    let numbers: Vec<f64> = line.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
    Measured::try_from(numbers).map_err(|_| format!("{}: {line:?}", output.status).into())
}

/// Renders a frame as `olema render` does, and asks what its exact normals cost.
fn measure(view: View, &(_, displacement): &Variant) -> Result<Measured, Box<dyn Error>> {
    let mut scene = tube(144, 80);
    if let Some((name, amplitude, bump)) = displacement {
        displace(&mut scene, name, amplitude, bump)?;
    }
    if view.blur {
        scene = defocused(driven(scene, [0.2, 0.0, 0.1], 0.1), 8.0, 8.0);
    }
    let settings = Settings { resolution: view.size, threads: 1, ..Settings::default() };
    let start = Instant::now();
    let clock = || start.elapsed().as_secs_f64();
    let hooks = Hooks { clock: Some(&clock), ..Hooks::default() };
    let Seconds { connect, split, dice, shade, sample, resolve, total, .. } =
        Renderer::new(settings.clone())?.render_rows(scene.clone(), &hooks, &mut |_| {})?.seconds;
    // After the frame, which finds the process as it begins, with displacement or without.
    let normals = match displacement {
        Some((.., false)) => exact_normals(&scene, &settings)?,
        _ => 0.0,
    };
    Ok([connect, split, dice, shade, sample, resolve, total, normals])
}

fn displace(scene: &mut Scene, name: &str, amplitude: f32, bump: bool) -> Result<(), olema::Error> {
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
    Ok(())
}

/// An image of 128 x 128 texels of eight bits: gradient noise, sixteen cells wide.
fn bumps() -> Result<Arc<TextureImage>, olema::Error> {
    let height = |n: u32| {
        let place = [n % 128, n / 128].map(|c| f64::from(c) / 8.0);
        (128.0 + 127.0 * noise::gradient([place[0], place[1], 0.5], 0)).round() / 255.0
    };
    let texels: Vec<f32> = (0..128 * 128).map(height).collect();
    Ok(Arc::new(TextureImage::new(128, 128, &texels)?))
}

/// Seconds by which dicing and shading all grids with exact normals takes longer than with normals that are estimated from
/// neighbouring points of a grid: a median of three of each, in turn.
fn exact_normals(scene: &Scene, settings: &Settings) -> Result<f64, olema::Error> {
    let mut longer = Vec::new();
    for _ in 0..3 {
        let mut seconds = [0.0; 2];
        for (seconds, sabotage) in seconds.iter_mut().zip([None, Some(Sabotage::EstimatedNormals)]) {
            let start = Instant::now();
            olema::engine::grids(scene, settings, sabotage, |_, _, _, _| {})?;
            *seconds = start.elapsed().as_secs_f64();
        }
        longer.push(seconds[0] - seconds[1]);
    }
    Ok(median(longer))
}

fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
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
            let [x, y] = [grid.on_raster.x[v] >> 8, grid.on_raster.y[v] >> 8];
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

fn pictures(dir: &Path) -> Result<(), Box<dyn Error>> {
    let size = [400, 300];
    let settings = Settings { resolution: size, threads: 1, ..Settings::default() };
    let mut scene = tube(16, 5);
    displace(&mut scene, "fractal", 0.6, false)?;
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
            let view = GridView { m, n, x: &grid.on_raster.x, y: &grid.on_raster.y, depth: &grid.depth };
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
