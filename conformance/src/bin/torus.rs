//! Draws the torus of pixel-sized quads: `torus NU NV WIDTHxHEIGHT SPP [still] OUT.pgm`.
//!
//! Greys are hashes of the quads' numbers, box filter of 1 pixel: a picture to compare with those of other
//! renderers, quad by quad. Prints seconds and counts.

use std::time::Instant;

use conformance::torus::{hash, torus};
use olema::image::{Filter, FilterKind};
use olema::{Hooks, Renderer, Settings};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [nu, nv, size, spp, .., out] = args.as_slice() else {
        return Err("usage: torus NU NV WIDTHxHEIGHT SPP [still] OUT.pgm".into());
    };
    let (width, height) = size.split_once('x').ok_or("expected WIDTHxHEIGHT")?;
    let side =
        (1..=32).find(|n| n * n == spp.parse::<u32>().unwrap_or(0)).ok_or("expected a square number")?;
    let blurred = !args.iter().any(|arg| arg == "still");
    let scene = torus(nu.parse()?, nv.parse()?, blurred, |quad| (hash(quad) >> 24) as f32 / 255.0);
    let start = Instant::now();
    let clock = move || start.elapsed().as_secs_f64();
    let settings = Settings {
        resolution: [width.parse()?, height.parse()?],
        samples: [side; 2],
        filter: Filter { kind: FilterKind::Box, width: [1.0; 2] },
        shading_rate_scale: 4.0,
        threads: 1,
        ..Settings::default()
    };
    let frame =
        Renderer::new(settings)?.render(&scene, &Hooks { clock: Some(&clock), ..Hooks::default() })?;
    let stats = &frame.stats;
    println!("{:?}", stats.seconds);
    println!(
        "{} micropolygons, {} sample tests, STE {:.3}",
        stats.micropolygons, stats.sample_tests, stats.ste
    );
    let red = &frame.image.channels[0].values;
    let mut file = format!("P5\n{width} {height}\n255\n").into_bytes();
    file.extend(red.iter().map(|value| (value * 255.0 + 0.5) as u8));
    std::fs::write(out, file)?;
    Ok(())
}
