//! The command line, as clap reads it.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use olema::occlusion::{CullKind, CullOrder, CullPlaces};
use olema::sampling::Rasterizer;
use olema::settings::Shade;

use crate::model::ModelArgs;
use crate::values::{Crop, FrameSet, ShadingTime, Shutter, Size, Tolerance};

const EXIT_CODES: &str = "Exit codes: 0 ok, 1 render failed or pictures differ, 2 usage, 3 scene or asset, \
    4 out of memory, 130 interrupted, 143 terminated.";

/// Olema, a Reyes renderer.
#[derive(Debug, Parser)]
#[command(name = "olema", version, propagate_version = true, after_help = EXIT_CODES)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render scenes to pictures
    Render(Box<RenderArgs>),
    /// Tell what is in a scene
    Info(InfoArgs),
    /// Compare two pictures
    Diff(DiffArgs),
    /// Measure the standard scenes
    Bench(BenchArgs),
}

/// Options of `olema render`.
#[derive(Debug, Args, Default)]
#[command(after_help = EXIT_CODES)]
pub struct RenderArgs {
    /// Scenes (RIB, ASCII, may be gzipped) and models (.obj), or - for a scene from standard input
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,

    /// Picture to write (.png), or a directory; #### or %04d stands for the frame's number
    ///
    /// Without it the picture takes the scene's Display name or the model's file name, reduced to its file name and ending in .png, in
    /// the current directory: a scene never decides on a directory. An existing picture is replaced.
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,

    /// Size of the full frame in pixels, e.g. 640x480
    #[arg(long, value_name = "WxH")]
    pub res: Option<Size>,

    /// Samples a pixel, 1 to 1024, as the squarest grid that has this number
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024),
          conflicts_with = "samples")]
    pub spp: Option<u32>,

    /// Samples a pixel as a grid, e.g. 4x4; at most 1024 in all
    #[arg(long, value_name = "NxM", value_parser = crate::values::parse_samples)]
    pub samples: Option<Size>,

    /// Area of a micropolygon in pixels, for every surface, whatever the scene says
    #[arg(long, value_name = "R", value_parser = crate::values::parse_shading_rate)]
    pub shading_rate: Option<f32>,

    /// How much motion coarsens dicing, for every surface, whatever the scene says; 0 is not at all
    #[arg(long, value_name = "X", value_parser = crate::values::parse_factor)]
    pub motion_factor: Option<f32>,

    /// How much defocus coarsens dicing, for every surface, whatever the scene says; 0 is not at all
    #[arg(long, value_name = "X", value_parser = crate::values::parse_factor)]
    pub focus_factor: Option<f32>,

    /// Times at which the shutter opens and closes, whatever the scene says; 0,0 is a still picture of time 0
    #[arg(long, value_name = "OPEN,CLOSE", allow_hyphen_values = true)]
    pub shutter: Option<Shutter>,

    /// When within the shutter's time surfaces are shaded; without it in the middle
    #[arg(long, value_name = "WHEN", value_enum)]
    pub shading_time: Option<ShadingTime>,

    /// Part of the frame to render: fractions as in CropWindow if all are at most 1, else pixels
    #[arg(long, value_name = "X0,X1,Y0,Y1", allow_hyphen_values = true)]
    pub crop: Option<Crop>,

    /// Worker threads; 0 is one per core, -N is all cores but N
    #[arg(short, long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    pub threads: i32,

    /// Memory to use, e.g. 512M or 4G; half of the machine's without it; never changes the picture
    ///
    /// Beyond it grids are made again and transparent layers are drawn in turn, which takes time; what cannot be made
    /// again, the scene and the picture, is refused.
    #[arg(long, value_name = "SIZE", value_parser = crate::memory::parse)]
    pub memory: Option<u64>,

    /// Seed of the sample pattern
    #[arg(long, value_name = "S")]
    pub seed: Option<u32>,

    /// Size of the output buckets in pixels; never changes the picture
    #[arg(long, value_name = "N|NxM", value_parser = crate::values::parse_bucket)]
    pub bucket: Option<Size>,

    /// Side of the raster tiles in pixels; never changes the picture
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub raster_tile: Option<u32>,

    /// Side of the sample pattern's pixel tile: 1, 2, 3, 4, 8 or 64
    #[arg(long, value_name = "K", value_parser = crate::values::parse_pattern_tile)]
    pub tile: Option<u32>,

    /// Permutation sets of the sample pattern, 1 to 65536
    #[arg(long, value_name = "P", value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub permutations: Option<u32>,

    /// How samples are found: auto, nomotion, interval, interleave, boundingbox or simple
    ///
    /// The picture is the same with all of them, but nomotion refuses scenes that move or have a lens, interleave
    /// takes tiles of at most 8 pixels, and simple of 1, which it takes by itself.
    #[arg(long, value_name = "NAME")]
    pub rasterizer: Option<Rasterizer>,

    /// How what is hidden is found: none, z, tz or slice; never changes the picture
    ///
    /// tz is a pyramid of depths over space and time (or the lens), z one without time, slice one a slice of time.
    #[arg(long, value_name = "KIND", help_heading = "Culling")]
    pub cull: Option<CullKind>,

    /// Before which stages it is asked: split, dice and shade with commas between, or none
    #[arg(long, value_name = "STAGES", help_heading = "Culling")]
    pub cull_at: Option<CullPlaces>,

    /// Side of the pyramid's leaves in pixels: 2, 4, 8 or 16
    #[arg(long, value_name = "PX", value_parser = crate::values::parse_cull_leaf, help_heading = "Culling")]
    pub cull_leaf: Option<u32>,

    /// Slices of time or lens: 64, 16, 4 or 1
    #[arg(long, value_name = "T", value_parser = crate::values::parse_cull_slices, help_heading = "Culling")]
    pub cull_slices: Option<u32>,

    /// What the slices order: time, lens, or auto for what blurs
    #[arg(long, value_name = "WHAT", help_heading = "Culling")]
    pub cull_order: Option<CullOrder>,

    /// Which vertices of opaque surfaces are shaded: visible, all, or gelato (all of a grid that is seen when it is
    /// drawn); never changes the picture
    #[arg(long, value_name = "WHICH", help_heading = "Culling")]
    pub shade: Option<Shade>,

    /// Models.
    #[command(flatten)]
    pub model: ModelArgs,

    /// Frames to render, e.g. 1-7:2,20-25 (7:2 is every second one up to 7)
    #[arg(long, value_name = "LIST")]
    pub frames: Option<FrameSet>,

    /// Directory to search for archives; may be repeated
    #[arg(long, value_name = "DIR")]
    pub search_path: Vec<PathBuf>,

    /// Write counters and times as JSON (docs/stats.md says what each means)
    #[arg(long, value_name = "FILE")]
    pub stats: Option<PathBuf>,

    /// How to tell progress, on standard error: auto is a bar on a terminal and lines elsewhere
    #[arg(long, value_name = "HOW", value_enum, default_value_t)]
    pub progress: ProgressKind,

    /// Only errors: no progress, no warnings, no path of the picture
    #[arg(short, long, conflicts_with = "verbose")]
    pub quiet: bool,

    /// Every message, also those that repeat
    #[arg(short, long)]
    pub verbose: bool,
}

/// Options of `olema info`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct InfoArgs {
    /// Scene or model (.obj), or - for a scene from standard input
    #[arg(value_name = "FILE")]
    pub file: PathBuf,

    /// As JSON
    #[arg(long)]
    pub json: bool,

    /// Models.
    #[command(flatten)]
    pub model: ModelArgs,

    /// Directory to search for archives; may be repeated
    #[arg(long, value_name = "DIR")]
    pub search_path: Vec<PathBuf>,

    /// Only errors on standard error
    #[arg(short, long, conflicts_with = "verbose")]
    pub quiet: bool,

    /// Every message, also those that repeat
    #[arg(short, long)]
    pub verbose: bool,
}

/// Options of `olema diff`.
#[derive(Debug, Args)]
#[command(
    after_help = "Exit codes: 0 no channel of any pixel differs by more than the tolerance, 1 some do or \
    the sizes differ, 2 usage, 3 a picture cannot be read."
)]
pub struct DiffArgs {
    /// First picture (.png)
    #[arg(value_name = "A")]
    pub a: PathBuf,

    /// Second picture (.png)
    #[arg(value_name = "B")]
    pub b: PathBuf,

    /// Largest difference of a channel that passes, in steps of 8 bits (0 to 255)
    #[arg(long, value_name = "T", default_value = "0")]
    pub tolerance: Tolerance,

    /// Picture of the differences to write (.png), brightened so that the largest shows
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
}

/// Options of `olema bench`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct BenchArgs {
    /// Scenes, or how several of them begin, as torus does; all without any
    #[arg(value_name = "NAME")]
    pub names: Vec<String>,

    /// As JSON
    #[arg(long)]
    pub json: bool,

    /// Runs of each scene, of which the median is told
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub runs: u32,

    /// Worker threads; 0 is one per core, -N is all cores but N
    #[arg(short, long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    pub threads: i32,

    /// Small pictures, to see that all is well
    #[arg(long)]
    pub quick: bool,

    /// One run in this very process, as a line of JSON: what the command starts itself with
    #[arg(long, hide = true)]
    pub alone: bool,
}

/// How progress is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum ProgressKind {
    /// A bar on a terminal, lines elsewhere
    #[default]
    Auto,
    /// A line now and then
    Plain,
    /// A JSON object a line; messages too
    Json,
    /// Nothing
    None,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn readme_lists_every_option() {
        let readme = include_str!("../../../README.md");
        for sub in Cli::command().get_subcommands() {
            for arg in sub.get_arguments().filter(|a| !a.is_hide_set()).filter_map(|a| a.get_long()) {
                assert!(
                    readme.contains(&format!("`--{arg}")),
                    "README.md lacks --{arg} of {}",
                    sub.get_name()
                );
            }
        }
    }
}
