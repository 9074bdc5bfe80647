//! Tests of the sampling modules together.

mod agree;
mod blur_counts;
mod blur_work;
mod blurred;
mod expected;
mod inside;
mod kernels;
mod moving_cracks;
mod moving_noise;
mod noise;
mod nomotion;
mod pattern;

use super::inside::HitPoint;
use super::nomotion::HitSink;
use super::{PatternSpec, SamplePattern};

/// Sum of the signs of the hits of each sample, and their number.
pub struct SignedHits {
    pub sums: Vec<i32>,
    pub counts: Vec<u32>,
}

impl SignedHits {
    pub fn new(num_samples: usize) -> Self {
        SignedHits { sums: vec![0; num_samples], counts: vec![0; num_samples] }
    }
}

impl HitSink for SignedHits {
    fn hit(&mut self, sample_ix: usize, _point: HitPoint, _triangle: u8, sign: i8) {
        self.sums[sample_ix] += i32::from(sign);
        self.counts[sample_ix] += 1;
    }
}

pub fn pattern(samples: [u32; 2], tile: u32) -> SamplePattern {
    SamplePattern::new(PatternSpec { samples, tile, ..PatternSpec::default() })
}
