//! The whole crack test: `cargo run --release -p conformance --bin cracks [SURFACES [FIRST_SEED]] [FILE.obj...]`.
//!
//! Draws random closed surfaces (1,000 unless told otherwise), half of them displaced, as many that move or are out of
//! focus, and the subdivision meshes of the files (those that are closed, as they are and displaced), and counts
//! signed hits. Ends with the counts, a line for what stands still and one for what moves; exits with 1 where a crack
//! was found.

use conformance::closed::{Random, crack_scene, displace, mesh_scene};
use conformance::closed_moving::moving_crack_scene;
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
    let [mut still, mut moving] = [Totals::default(), Totals::default()];
    for seed in first..first.saturating_add(surfaces) {
        still.draw(&format!("seed {seed}"), &crack_scene(seed));
        moving.draw(&format!("moving, seed {seed}"), &moving_crack_scene(seed));
    }
    for file in &files {
        draw_file(file, &mut still);
    }
    let CrackReport { extraordinary, creases, poles, blocks, .. } = still.report;
    println!(
        "{still}, {extraordinary} extraordinary points, {creases} creases, {poles} poles, {blocks} blocks"
    );
    let CrackReport { moving: grids, keys, defocused, by_interval, by_interleave, .. } = moving.report;
    println!(
        "moving: {moving}, {grids} of the grids move on {keys} keys, {defocused} are out of focus; \
         {by_interval} by Interval, {by_interleave} by InterleaveUvt"
    );
    if still.is_fine() && moving.is_fine() {
        std::process::ExitCode::SUCCESS
    } else {
        std::process::ExitCode::FAILURE
    }
}

/// What was drawn so far.
#[derive(Default)]
struct Totals {
    surfaces: u64,
    errors: u64,
    report: CrackReport,
}

impl Totals {
    fn draw(&mut self, name: &str, scene: &Scene) {
        match signed_hits(scene, &small(96, 96, [4, 4]), None) {
            Ok(report) => {
                if report.cracked > 0 {
                    println!("{name}: {report:?}");
                }
                self.surfaces += 1;
                self.report.add(&report);
            }
            Err(error) => self.fail(&format!("{name}: {error}")),
        }
    }

    fn fail(&mut self, why: &str) {
        println!("{why}");
        self.errors += 1;
    }

    fn is_fine(&self) -> bool {
        self.errors == 0 && self.report.cracked == 0
    }
}

impl std::fmt::Display for Totals {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let CrackReport { covered, cracked, grids, welds, unequal, .. } = self.report;
        let surfaces = self.surfaces;
        write!(
            f,
            "{surfaces} surfaces, {covered} samples covered, {cracked} cracked; {grids} grids, {welds} welds, \
             {unequal} unequal k"
        )
    }
}

/// Draws a file's mesh, if it is closed, as it is and displaced.
fn draw_file(file: &str, totals: &mut Totals) {
    let input = std::fs::File::open(file).map(std::io::BufReader::new);
    let input = input.map_err(|source| ReadError::Io { path: file.to_owned(), source });
    let mesh = match input.and_then(|input| obj::read(file, input, obj::MEMORY)) {
        Ok((obj, _)) => obj.subdivision_mesh(obj::scheme_of_name(file).unwrap_or(Scheme::CatmullClark)),
        Err(error) => return totals.fail(&error.to_string()),
    };
    if !is_closed(&mesh) {
        println!("{file}: not closed; left out");
        return;
    }
    let mut scene = mesh_scene(mesh, &mut Random::new(1));
    totals.draw(file, &scene);
    displace(&mut scene, 1, 0.2);
    totals.draw(&format!("{file}, displaced"), &scene);
}
