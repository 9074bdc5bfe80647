//! What `olema bench` prints.
//!
//! In: runs. Out: their median, as a line of a table or as JSON.

use olema::stats::Seconds;
use olema::{Settings, Stats};
use serde::{Deserialize, Serialize};

use crate::exit::{self, Failure};

/// What a run took, or the median of several.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Name of the scene.
    pub scene: String,
    /// Width and height in pixels.
    pub resolution: [u32; 2],
    /// Samples a pixel.
    pub samples_per_pixel: u32,
    /// Worker threads.
    pub threads: usize,
    /// Patches.
    pub patches: u64,
    /// Grids diced.
    pub grids: u64,
    /// Of these, grids made again.
    pub grids_again: u64,
    /// Micropolygons in the grids.
    pub micropolygons: u64,
    /// Samples of the picture.
    pub samples: u64,
    /// Sample positions tested.
    pub sample_tests: u64,
    /// Tests that hit.
    pub sample_hits: u64,
    /// Hits over tests.
    pub ste: f64,
    /// Micropolygons over the whole time.
    pub micropolygons_per_second: f64,
    /// Samples over the whole time.
    pub samples_per_second: f64,
    /// Seconds: of stages summed over the threads; `total` is wall time, reading included.
    pub seconds: Seconds,
    /// Most resident memory of the process in bytes; the largest of all runs.
    pub peak_memory: u64,
}

impl Run {
    /// What a render took.
    pub fn new(name: &str, settings: &Settings, stats: &Stats) -> Self {
        let [width, height] = settings.resolution.map(u64::from);
        let mut run = Run {
            scene: name.to_owned(),
            resolution: settings.resolution,
            samples_per_pixel: settings.samples_per_pixel(),
            threads: settings.threads,
            patches: stats.patches,
            grids: stats.grids,
            grids_again: stats.grids_again,
            micropolygons: stats.micropolygons,
            samples: width * height * u64::from(settings.samples_per_pixel()),
            sample_tests: stats.sample_tests,
            sample_hits: stats.sample_hits,
            ste: stats.ste,
            micropolygons_per_second: 0.0,
            samples_per_second: 0.0,
            seconds: Seconds { total: stats.seconds.read + stats.seconds.total, ..stats.seconds },
            peak_memory: stats.peak_memory,
        };
        run.rate();
        run
    }

    /// Renews what is a count over the whole time.
    fn rate(&mut self) {
        let per_second =
            |count: u64| if self.seconds.total > 0.0 { count as f64 / self.seconds.total } else { 0.0 };
        (self.micropolygons_per_second, self.samples_per_second) =
            (per_second(self.micropolygons), per_second(self.samples));
    }
}

/// The middle of several runs, one time at a time; counts are those of the first, as they are of all.
pub fn median(runs: &[Run]) -> Run {
    let middle = |of: fn(&Seconds) -> f64| {
        let mut values: Vec<f64> = runs.iter().map(|run| of(&run.seconds)).collect();
        values.sort_by(f64::total_cmp);
        let half = values.len() / 2;
        if values.len().is_multiple_of(2) { (values[half - 1] + values[half]) / 2.0 } else { values[half] }
    };
    let seconds = Seconds {
        read: middle(|s| s.read),
        connect: middle(|s| s.connect),
        split: middle(|s| s.split),
        dice: middle(|s| s.dice),
        cull: middle(|s| s.cull),
        shade: middle(|s| s.shade),
        sample: middle(|s| s.sample),
        resolve: middle(|s| s.resolve),
        total: middle(|s| s.total),
    };
    let peak_memory = runs.iter().map(|run| run.peak_memory).max().unwrap_or(0);
    let mut run = Run { seconds, peak_memory, ..runs[0].clone() };
    run.rate();
    run
}

/// A run as a line that [`from_line`] reads.
///
/// # Errors
/// A render failure; none is known.
pub fn to_line(run: &Run) -> Result<String, Failure> {
    serde_json::to_string(run).map_err(|error| Failure::new(exit::RENDER, error.to_string()))
}

/// The run that a line holds.
///
/// # Errors
/// A render failure where it holds none.
pub fn from_line(line: &str) -> Result<Run, Failure> {
    serde_json::from_str(line).map_err(|error| Failure::new(exit::RENDER, error.to_string()))
}

/// All of it as JSON.
///
/// # Errors
/// A render failure; none is known.
pub fn json(runs: u32, results: &[Run]) -> Result<String, Failure> {
    let all = serde_json::json!({ "olema": env!("CARGO_PKG_VERSION"), "runs": runs, "scenes": results });
    let text = serde_json::to_string_pretty(&all);
    text.map(|text| text + "\n").map_err(|error| Failure::new(exit::RENDER, error.to_string()))
}

/// The head of the table.
pub fn header() -> String {
    format!(
        "{:<20} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6} {:>7} {:>7} {:>7} {:>8} {:>6} {:>7}\n",
        "seconds of",
        "read",
        "conn.",
        "split",
        "dice",
        "cull",
        "shade",
        "sample",
        "resol.",
        "total",
        "M mp",
        "M mp/s",
        "M spl/s",
        "STE",
        "peak MB",
    )
}

/// A line of the table.
pub fn row(run: &Run) -> String {
    let s = &run.seconds;
    let stages = [s.read, s.connect, s.split, s.dice, s.cull, s.shade, s.sample, s.resolve];
    let stages: String = stages.iter().map(|seconds| format!(" {seconds:>6.3}")).collect();
    format!(
        "{:<20}{stages} {:>7.3} {:>7.3} {:>7.3} {:>8.2} {:>6.3} {:>7.1}\n",
        run.scene,
        s.total,
        run.micropolygons as f64 / 1e6,
        run.micropolygons_per_second / 1e6,
        run.samples_per_second / 1e6,
        run.ste,
        run.peak_memory as f64 / 1e6,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn taking(total: f64, peak_memory: u64) -> Run {
        let seconds = Seconds { total, sample: total / 2.0, ..Seconds::default() };
        let stats = Stats { micropolygons: 600, seconds, peak_memory, ..Stats::default() };
        Run::new("x", &Settings::default(), &stats)
    }

    #[test]
    fn the_median_is_the_middle_and_the_peak_the_most() {
        let odd = median(&[taking(3.0, 5), taking(1.0, 9), taking(2.0, 7)]);
        assert_eq!((odd.seconds.total, odd.seconds.sample, odd.peak_memory), (2.0, 1.0, 9));
        assert_eq!(odd.micropolygons_per_second, 300.0);
        assert_eq!(median(&[taking(1.0, 1), taking(2.0, 1)]).seconds.total, 1.5);
    }

    #[test]
    fn a_line_is_read_as_it_was_written() {
        let run = taking(1.25, 4);
        assert_eq!(from_line(&to_line(&run).expect("a line")).expect("a run"), run);
        assert!(from_line("teapot").is_err());
    }

    #[test]
    fn columns_stand_below_their_heads() {
        assert_eq!(header().len(), row(&taking(1.0, 4)).len());
    }
}
