//! The crack test: on a closed surface every sample is hit from the front as often as from the back.
//!
//! In: a scene whose surfaces are closed and consistently oriented, in front of the camera. Out: for every
//! sample of the picture the signed count of hits, which must be zero. Folds, self-intersections and double
//! hits cannot fool it.

use olema::engine::grids;
use olema::sampling::nomotion::{Facing, GridView, HitSink, SampleCounts, rasterize_grid};
use olema::sampling::{PatternSpec, Region, RegionSamples, SamplePattern};
use olema::{Error, Scene, Settings};

/// What the test saw.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct CrackReport {
    /// Samples that something hit.
    pub covered: u64,
    /// Samples whose signed count is not zero.
    pub cracked: u64,
    /// Grids drawn.
    pub grids: u64,
    /// Edges that two patches share.
    pub welds: u64,
}

struct SignedCounts {
    sum: Vec<i32>,
    hits: Vec<u32>,
}

impl HitSink for SignedCounts {
    fn hit(&mut self, sample_ix: usize, _depth: f32, _triangle: u8, sign: i8) {
        self.sum[sample_ix] += i32::from(sign);
        self.hits[sample_ix] += 1;
    }
}

/// Draws all of `scene` without culling and counts signed hits.
///
/// # Errors
/// What the scene or the settings are wrong about.
pub fn signed_hits(scene: &Scene, settings: &Settings) -> Result<CrackReport, Error> {
    let pattern = SamplePattern::new(PatternSpec {
        samples: settings.samples,
        seed: settings.seed,
        ..PatternSpec::default()
    });
    let [width, height] = settings.resolution.map(|px| px as i32);
    let samples = RegionSamples::new(&pattern, Region::new(0, width, 0, height));
    let mut counts = SignedCounts { sum: vec![0; samples.len()], hits: vec![0; samples.len()] };
    let mut report = CrackReport::default();
    let stats = grids(scene, settings, |grid| {
        report.grids += 1;
        let view =
            GridView { m: grid.m as usize, n: grid.n as usize, x: &grid.x, y: &grid.y, depth: &grid.depth };
        rasterize_grid(view, Facing::Any, None, &samples, &mut SampleCounts::default(), &mut counts);
    })?;
    report.welds = stats.welds;
    report.covered = counts.hits.iter().filter(|&&h| h > 0).count() as u64;
    report.cracked = counts.sum.iter().filter(|&&s| s != 0).count() as u64;
    Ok(report)
}
