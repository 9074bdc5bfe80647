//! The whole crack test: `cargo run --release -p conformance --bin cracks [SURFACES [FIRST_SEED]] [FILE.obj...]`.
//!
//! Draws random closed surfaces (1,000 unless told otherwise), half of them displaced, and the subdivision meshes
//! of the files (those that are closed, as they are and displaced), and counts signed hits. Ends with the counts on one line; exits with 1 where a crack was found.

use conformance::closed::{Random, crack_scene, displace, mesh_scene};
use conformance::cracks::{CrackReport, is_closed, signed_hits};
use conformance::scenes::small;
use olema::Scene;
use olema::scene::Scheme;
use olema_formats::{ReadError, obj};

fn main() -> std::process::ExitCode {
    let (files, numbers): (Vec<String>, Vec<String>) =
        std::env::args().skip(1).partition(|a| a.ends_with(".obj"));
    let numbers: Result<Vec<u32>, _> = numbers.iter().map(|n| n.parse()).collect();
    let Ok(numbers) = numbers else {
        eprintln!("usage: cracks [SURFACES [FIRST_SEED]] [FILE.obj...]");
        return std::process::ExitCode::from(2);
    };
    let (surfaces, first) = (numbers.first().copied().unwrap_or(1000), numbers.get(1).copied().unwrap_or(0));
    let mut total = CrackReport::default();
    let mut drawn = 0;
    let mut draw = |name: &str, scene: &Scene| match signed_hits(scene, &small(96, 96, [4, 4]), None) {
        Ok(report) => {
            if report.cracked > 0 {
                println!("{name}: {report:?}");
            }
            drawn += 1;
            total.add(&report);
            true
        }
        Err(error) => {
            println!("{name}: {error}");
            false
        }
    };
    let mut fine = true;
    for seed in first..first.saturating_add(surfaces) {
        fine &= draw(&format!("seed {seed}"), &crack_scene(seed));
    }
    for file in &files {
        fine &= draw_file(file, &mut draw);
    }
    let CrackReport { covered, cracked, grids, welds, unequal, extraordinary, creases, poles, blocks } =
        total;
    println!(
        "{drawn} surfaces, {covered} samples covered, {cracked} cracked; {grids} grids, {welds} welds, \
         {unequal} unequal k, {extraordinary} extraordinary points, {creases} creases, {poles} poles, {blocks} blocks"
    );
    if fine && cracked == 0 { std::process::ExitCode::SUCCESS } else { std::process::ExitCode::FAILURE }
}

/// Draws a file's mesh, if it is closed, as it is and displaced.
fn draw_file(file: &str, draw: &mut impl FnMut(&str, &Scene) -> bool) -> bool {
    let input = std::fs::File::open(file).map(std::io::BufReader::new);
    let input = input.map_err(|source| ReadError::Io { path: file.to_owned(), source });
    let mesh = match input.and_then(|input| obj::read(file, input, obj::MEMORY)) {
        Ok((obj, _)) => obj.subdivision_mesh(obj::scheme_of_name(file).unwrap_or(Scheme::CatmullClark)),
        Err(error) => {
            println!("{error}");
            return false;
        }
    };
    if !is_closed(&mesh) {
        println!("{file}: not closed; left out");
        return true;
    }
    let mut scene = mesh_scene(mesh, &mut Random::new(1));
    let still = draw(file, &scene);
    displace(&mut scene, 1, 0.2);
    draw(&format!("{file}, displaced"), &scene) && still
}
