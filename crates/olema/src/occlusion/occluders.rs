//! Occluders: the pyramids of one tile, by time, by lens, or both.
//!
//! In: settings and the sample pattern, once a frame; a tile's samples; bounds. Out: what is hidden. Two
//! pyramids cost two updates; a query costs one walk, in the pyramid whose ranges make its box smaller.
//! Source: Boulos 2010, section 5, for why one hierarchy cannot serve time and lens at once.

use std::sync::Arc;

use crate::sampling::pattern::StratumBounds;
use crate::sampling::{RegionSamples, SampleBuffer, SamplePattern};

use super::pyramid::{Drawn, NodeKind, TzPyramid};
use super::query::{Bounds, DepthReads};
use super::settings::{CullKind, CullOrder, CullSettings};
use super::slices::{SliceOrder, Slices};
use super::written::WrittenLeaves;

/// Why something may be seen at different places by different samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Blurred {
    /// Something moves.
    pub moves: bool,
    /// The camera has a lens.
    pub has_lens: bool,
}

/// What all tiles of a frame share.
#[derive(Debug, Clone)]
pub struct CullPlan {
    settings: CullSettings,
    slices: Vec<Arc<Slices>>,
}

impl CullPlan {
    /// The plan; `None` where nothing is to be culled. Settings are taken to be valid. [`CullOrder::Auto`] orders by
    /// what blurs; where nothing does, one slice is as good as many.
    pub fn new(settings: CullSettings, pattern: &SamplePattern, blur: Blurred) -> Option<Self> {
        let places = settings.at;
        if settings.kind == CullKind::None || !(places.split || places.dice || places.shade) {
            return None;
        }
        let num_slices = if blur.moves || blur.has_lens { settings.num_slices() } else { 1 };
        let orders: &[SliceOrder] = match settings.order {
            _ if num_slices == 1 => &[SliceOrder::Time],
            CullOrder::Auto if blur.has_lens && blur.moves => &[SliceOrder::Time, SliceOrder::Lens],
            CullOrder::Auto if blur.has_lens => &[SliceOrder::Lens],
            CullOrder::Lens => &[SliceOrder::Lens],
            CullOrder::Time | CullOrder::Auto => &[SliceOrder::Time],
        };
        let slices = orders.iter().map(|&order| Arc::new(Slices::new(pattern, order, num_slices))).collect();
        Some(CullPlan { settings, slices })
    }

    /// What it was made from.
    pub fn settings(&self) -> &CullSettings {
        &self.settings
    }
}

/// One or two pyramids over the same samples, brought up to date when a query needs it.
#[derive(Debug, Clone)]
pub struct Occluders {
    pyramids: Vec<TzPyramid>,
    /// Leaves that were written, on their way from the buffer's marks to those of the pyramids.
    written: WrittenLeaves,
    /// Holds every pixel that was drawn to since the last update; empty where the first is beyond the last.
    drawn: [i32; 4],
}

/// Holds no pixel.
const NO_PIXELS: [i32; 4] = [i32::MAX, i32::MIN, i32::MAX, i32::MIN];

impl Occluders {
    /// Pyramids over no samples yet.
    pub fn new(plan: &CullPlan) -> Self {
        let kind = if plan.settings.kind == CullKind::Slice { NodeKind::Slices } else { NodeKind::Tree };
        let leaf_px = plan.settings.leaf_px;
        let pyramids =
            plan.slices.iter().map(|slices| TzPyramid::new(Arc::clone(slices), kind, leaf_px)).collect();
        Occluders { pyramids, written: WrittenLeaves::default(), drawn: NO_PIXELS }
    }

    /// Begins anew for a region's samples, none of which was hit.
    pub fn renew(&mut self, samples: &RegionSamples) {
        self.drawn = NO_PIXELS;
        self.pyramids.iter_mut().for_each(|pyramid| pyramid.renew(samples));
    }

    /// Something was drawn within `pixels`, `[x0, x1, y0, y1]`, inclusive.
    pub fn drew(&mut self, pixels: [i32; 4]) {
        let [x0, x1, y0, y1] = self.drawn;
        self.drawn = [x0.min(pixels[0]), x1.max(pixels[1]), y0.min(pixels[2]), y1.max(pixels[3])];
    }

    /// Tells the pyramids what was written, and clears the buffer's marks. What was written outside the boxes given to
    /// [`Self::drew`] stays unknown, which is safe.
    pub fn update(&mut self, buffer: &mut SampleBuffer) {
        if self.drawn[0] > self.drawn[1] || self.drawn[2] > self.drawn[3] {
            return;
        }
        // All have the same leaves.
        self.pyramids[0].list_written(buffer, self.drawn, &mut self.written);
        for pyramid in &mut self.pyramids {
            self.written.leaves.iter().for_each(|&leaf| pyramid.mark(leaf));
        }
        buffer.clear_written();
        self.drawn = NO_PIXELS;
    }

    /// Number of pyramids, 1 or 2.
    pub fn num_pyramids(&self) -> usize {
        self.pyramids.len()
    }

    /// Bytes of all nodes.
    pub fn bytes(&self) -> usize {
        self.pyramids.iter().map(TzPyramid::bytes).sum()
    }

    /// Whether the thing that `bounds_over` bounds is hidden, as [`TzPyramid::is_occluded`] says.
    ///
    /// First a sample is looked for that sees it: that answers most queries whose answer is no, and the pyramids need
    /// not be told of anything. Of two pyramids that one is asked in which the thing covers fewer leaves
    /// over a quarter of the slices (the first where it covers as many): there a walk gets along with coarser
    /// ranges. A quarter and not a slice, as slices of one tuple are equally small in both.
    pub fn is_occluded(
        &mut self,
        samples: &RegionSamples,
        buffer: &mut SampleBuffer,
        mut bounds_over: impl FnMut(&StratumBounds) -> Bounds,
        reads: &mut DepthReads,
    ) -> bool {
        let drawn = Drawn { samples, buffer };
        let is_seen = |pyramid: &TzPyramid| pyramid.is_seen_by_a_witness(drawn, &mut bounds_over, reads);
        if self.pyramids.first().is_none_or(is_seen) {
            return false;
        }
        let pick = match &self.pyramids[..] {
            [time, lens] => {
                let least = time.quarter_leaves(&mut bounds_over);
                usize::from(lens.quarter_leaves(&mut bounds_over) < least)
            }
            _ => 0,
        };
        self.update(buffer);
        self.pyramids[pick].is_occluded(Drawn { samples, buffer }, bounds_over, reads)
    }
}

impl TzPyramid {
    /// Leaves that a thing covers over the second quarter of the slices (over all, where there is one).
    fn quarter_leaves(&self, bounds_over: &mut impl FnMut(&StratumBounds) -> Bounds) -> u64 {
        let node = if self.slices.num() >= 4 { 5 } else { 1 };
        let Some(span) = self.slices.span(node) else { return u64::MAX };
        let leaves = self.leaves_of(bounds_over(span).pixels);
        if leaves.is_empty() {
            return 0;
        }
        u64::from(leaves.x[1] - leaves.x[0] + 1) * u64::from(leaves.y[1] - leaves.y[0] + 1)
    }
}
