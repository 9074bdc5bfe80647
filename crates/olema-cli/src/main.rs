//! The command `olema`: renders scenes, reports on them, compares pictures, measures itself.
//!
//! In: arguments, files, signals. Out: pictures, words on standard error, an exit code ([`exit`]). Everything
//! that the libraries leave to their caller is here: printing, the clock, the system, the choice of file names.

mod args;
mod bench;
mod diff;
mod exit;
mod info;
mod interrupt;
mod memory;
mod model;
mod output;
mod picture;
mod progress;
mod render;
mod report;
mod source;
mod stats_file;
mod values;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    // Usage errors end here with 2, help and version with 0.
    let cli = args::Cli::parse();
    let code = match cli.command {
        args::Command::Render(args) => render::run(&args),
        args::Command::Info(args) => info::run(&args),
        args::Command::Diff(args) => diff::run(&args),
        args::Command::Bench(args) => bench::run(&args),
    };
    ExitCode::from(code)
}
