//! Prints what the scenes for occlusion culling are like: `cargo run --release --example occlusion_scenes`.

use conformance::occlusion_scenes::{army, city, measure, sticks};

fn main() -> Result<(), olema::Error> {
    for (name, scene) in [("army", army(350.0)), ("sticks", sticks(40.0)), ("city", city(10.0))] {
        println!("{name}: {:?}", measure(&scene, [240, 135])?);
    }
    Ok(())
}
