//! Occlusion culling on moving crowds: what is diced and shaded with each hierarchy, and what that costs and saves.
//!
//! ```text
//! cargo run --release -p conformance --bin occlusion [-- NAME ... [--leaf PX] [--all | --z] [--res WxH]]   army, sticks, city, rush, open
//! ```
//!
//! `--all` adds the hierarchies and ways of shading that lie between, `--z` leaves out the first, so that all is relative
//! to the z-pyramid. Grids are kept as long as they are wanted, so that
//! nothing is diced twice.
//!
//! Boulos 2010, figures 5 to 8: points diced and shaded relative to no culling, 1920 x 1080, 16 samples a pixel in tiles
//! of 2 x 2. `rush` is the army at 1300 pixels of motion; in `open` nothing hides anything. Seconds are of one thread,
//! of one run each, in turn.

use std::time::Instant;

use conformance::occlusion_scenes::{RESOLUTION, army, city, open, settings, sticks};
use olema::occlusion::{CullKind, CullSettings};
use olema::settings::Shade;
use olema::{Hooks, Renderer, Scene, Settings, Stats};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut names: Vec<String> = std::env::args().skip(1).collect();
    let mut resolution = RESOLUTION;
    if let Some(at) = names.iter().position(|name| name == "--res") {
        let sizes: Option<Vec<u32>> =
            names.get(at + 1).and_then(|size| size.split('x').map(|n| n.parse().ok()).collect());
        let Some([width, height]) = sizes.as_deref() else { return Err("--res: expected WxH".into()) };
        resolution = [*width, *height];
        names.truncate(at);
    }
    let all = names.iter().any(|name| name == "--all");
    let mut leaf_px = 2;
    if let Some(at) = names.iter().position(|name| name == "--leaf") {
        leaf_px = names.get(at + 1).and_then(|px| px.parse().ok()).ok_or("--leaf: expected 2, 4, 8 or 16")?;
        names.drain(at..at + 2);
    }
    let from_z = names.iter().any(|name| name == "--z");
    names.retain(|name| name != "--all" && name != "--z");
    if names.is_empty() {
        names = ["army", "sticks", "city", "rush", "open"].map(str::to_owned).into();
    }
    for name in names {
        let scene = match name.as_str() {
            "army" => army(350.0),
            "sticks" => sticks(40.0),
            "city" => city(10.0),
            "rush" => army(1300.0),
            "open" => open(),
            other => return Err(format!("there is no scene \"{other}\"").into()),
        };
        let mut settings = Settings { resolution, ..half_pixels(settings()) };
        settings.cull.leaf_px = leaf_px;
        report(&name, &scene, [all, from_z], &settings)?;
    }
    Ok(())
}

/// Kinds of culling, slices and ways of shading to compare, and whether that is done without `--all`; the first is what
/// the others are compared with.
const WAYS: [(&str, CullKind, u32, Shade, bool); 7] = [
    ("none", CullKind::None, 1, Shade::All, true),
    ("z", CullKind::Z, 1, Shade::All, true),
    ("tz, 16 slices", CullKind::Tz, 16, Shade::All, false),
    ("tz, 64 slices", CullKind::Tz, 64, Shade::All, true),
    ("slice, 64 slices", CullKind::Slice, 64, Shade::All, false),
    ("tz, gelato", CullKind::Tz, 64, Shade::Gelato, false),
    ("tz, visible", CullKind::Tz, 64, Shade::Visible, true),
];

fn report(
    name: &str,
    scene: &Scene,
    [all, from_z]: [bool; 2],
    settings: &Settings,
) -> Result<(), Box<dyn std::error::Error>> {
    let [width, height] = settings.resolution;
    println!("\n{name}, {width} x {height}");
    println!(
        "{:<18} {:>6} {:>6} {:>8} {:>6} {:>8} {:>8} {:>8} {:>9} {:>9} {:>7} {:>7} {:>6}",
        "",
        "diced",
        "shaded",
        "/visible",
        "again",
        "split",
        "dice",
        "shade",
        "inner",
        "leaf",
        "cull s",
        "s",
        "MB"
    );
    let mut none: Option<Stats> = None;
    for (way, kind, slices, shade, _) in WAYS.into_iter().skip(usize::from(from_z)).filter(|way| all || way.4)
    {
        let cull = CullSettings { kind, slices, ..settings.cull };
        let settings = Settings { cull, shade, threads: 1, ..settings.clone() };
        let started = Instant::now();
        let clock = || started.elapsed().as_secs_f64();
        let hooks = Hooks { clock: Some(&clock), ..Hooks::default() };
        let stats = Renderer::new(settings)?.render(scene, &hooks)?.stats;
        let none = none.get_or_insert_with(|| stats.clone());
        let part = |mine: u64, of: u64| mine as f64 / of as f64;
        let o = stats.occlusion;
        let reads = |of: fn(&olema::occlusion::DepthReads) -> u64| -> u64 {
            [o.split, o.dice, o.shade].iter().map(|at| of(&at.reads)).sum()
        };
        println!(
            "{way:<18} {:>6.3} {:>6.3} {:>8.3} {:>6.3} {:>8} {:>8} {:>8} {:>9} {:>9} {:>7.2} {:>7.2} {:>6.2}",
            part(stats.diced_points - stats.diced_points_again, none.diced_points),
            part(stats.shaded_points, none.shaded_points),
            part(stats.shaded_points, stats.visible_points),
            part(stats.diced_points_again, none.diced_points),
            o.split.hidden,
            o.dice.hidden,
            o.shade.hidden,
            reads(|r| r.inner + r.nearest),
            reads(|r| r.leaf + r.samples),
            stats.seconds.cull,
            stats.seconds.total,
            o.pyramid_bytes as f64 / 1e6,
        );
        let s = stats.seconds;
        let stages =
            [s.split, s.dice, s.cull, s.shade, s.sample, s.resolve].map(|t| format!("{t:.2}")).join(", ");
        println!(
            "    {:.1} M points; split, dice, cull, shade, sample, resolve: {stages} s",
            stats.diced_points as f64 / 1e6
        );
    }
    Ok(())
}

/// Micropolygons of half a pixel, as the paper has them; all grids are kept.
fn half_pixels(settings: Settings) -> Settings {
    Settings { shading_rate_scale: 0.5, grid_cache: 16 << 30, ..settings }
}
