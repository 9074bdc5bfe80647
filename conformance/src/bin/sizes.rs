//! How large micropolygons are, for docs/performance.md.
//!
//! `cargo run --release -p conformance --bin sizes` prints for smooth scenes, and for squares that face the camera, how many
//! micropolygons there are for each that the projected area asks for at several shading rates, and after it the part that
//! is due to sides that do not meet at right angles.

use conformance::scenes::small;
use conformance::sizes::{Sizes, facing_square, smooth_scenes};
use olema::{Error, Scene, Settings};

const RATES: [f32; 4] = [0.25, 0.5, 1.0, 4.0];

fn main() -> Result<(), Error> {
    println!("micropolygons over area / shading rate, and of it by slant; 320 x 240");
    print!("{:<32}", "shading rate");
    RATES.iter().for_each(|rate| print!(" {rate:>13}"));
    println!();
    for (name, scene) in smooth_scenes() {
        row(name, &scene)?;
    }
    for side in [2.5, 4.6, 7.3, 20.2, 60.7, 150.0] {
        row(&format!("facing square of {side} px"), &facing_square(side, 0.3))?;
    }
    Ok(())
}

fn row(name: &str, scene: &Scene) -> Result<(), Error> {
    print!("{name:<32}");
    for rate in RATES {
        let settings = Settings { shading_rate_scale: rate, ..small(320, 240, [1, 1]) };
        let sizes = Sizes::of(scene, &settings)?;
        print!("  {:.3} ({:.3})", sizes.ratio(rate.into()), sizes.upright / sizes.area);
    }
    println!();
    Ok(())
}
