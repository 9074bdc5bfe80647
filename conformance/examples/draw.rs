//! (scratch)
use std::io::Write;
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let scene = match args[1].as_str() {
        "near" => conformance::scenes::teapot_through_near_plane(),
        "inside" => conformance::scenes::teapot_from_inside(),
        "layers" => conformance::scenes::layers(),
        "ground" => conformance::scenes::ground(),
        "coplanar" => conformance::scenes::coplanar(),
        _ => conformance::scenes::teapot(),
    };
    let settings = olema::Settings {
        resolution: [args[2].parse().unwrap(), args[3].parse().unwrap()],
        threads: 1,
        ..Default::default()
    };
    let t0 = std::time::Instant::now();
    let clock = move || t0.elapsed().as_secs_f64();
    let hooks = olema::Hooks { clock: Some(&clock), ..Default::default() };
    let frame = olema::Renderer::new(settings).unwrap().render(&scene, &hooks).unwrap();
    println!("{:#?}", frame.stats);
    let img = &frame.image;
    let mut out = std::fs::File::create("/tmp/out.ppm").unwrap();
    write!(out, "P6 {} {} 255\n", img.width(), img.height()).unwrap();
    let mut bytes = vec![];
    for i in 0..img.width() * img.height() {
        for c in 0..3 {
            bytes.push(
                (olema::image::srgb_encode(img.channels[c].values[i]) * 255.0).round().clamp(0.0, 255.0)
                    as u8,
            );
        }
    }
    out.write_all(&bytes).unwrap();
}
