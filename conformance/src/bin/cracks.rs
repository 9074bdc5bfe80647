//! The whole crack test: `cargo run --release -p conformance --bin cracks [SURFACES [FIRST_SEED]]`.
//!
//! Draws random closed surfaces (1,000 unless told otherwise), half of them displaced, and counts signed hits.
//! Ends with the counts on one line; exits with 1 where a crack was found.

use conformance::closed::crack_scene;
use conformance::cracks::{CrackReport, signed_hits};
use conformance::scenes::small;

fn main() -> std::process::ExitCode {
    let mut numbers = std::env::args().skip(1).map(|arg| arg.parse::<u32>());
    let (Ok(surfaces), Ok(first)) = (numbers.next().unwrap_or(Ok(1000)), numbers.next().unwrap_or(Ok(0)))
    else {
        eprintln!("usage: cracks [SURFACES [FIRST_SEED]]");
        return std::process::ExitCode::from(2);
    };
    let mut total = CrackReport::default();
    for seed in first..first.saturating_add(surfaces) {
        match signed_hits(&crack_scene(seed), &small(96, 96, [4, 4]), None) {
            Ok(report) => {
                if report.cracked > 0 {
                    println!("seed {seed}: {report:?}");
                }
                total.add(&report);
            }
            Err(error) => {
                println!("seed {seed}: {error}");
                return std::process::ExitCode::FAILURE;
            }
        }
    }
    let CrackReport { covered, cracked, grids, welds, unequal, extraordinary, creases, poles, blocks } =
        total;
    println!(
        "{surfaces} surfaces, {covered} samples covered, {cracked} cracked; {grids} grids, {welds} welds, \
         {unequal} unequal k, {extraordinary} extraordinary points, {creases} creases, {poles} poles, {blocks} blocks"
    );
    if cracked == 0 { std::process::ExitCode::SUCCESS } else { std::process::ExitCode::FAILURE }
}
