//! Queries: is a sub-patch behind everything that was drawn, wherever and whenever it may be seen?
//!
//! In: bounds per range of tuples. Out: yes, or perhaps not. Source: Boulos 2010, section 3.2.2 (Algorithm 2).
//!
//! A sub-patch counts as visible if in some slice, in some leaf that its box of that slice touches, its
//! nearest depth of that slice is not beyond the farthest depth kept. The walk decides exactly that, from
//! coarse to fine, for trees and for slices alone: how it gets there changes only the number of reads.
//!
//! - It starts with the whole time, at the level of space where a node is as large as the box of all of it. The paper
//!   starts with the box of the first slice, at the coarsest level of time over whose first range that touches the
//!   same nodes; but most of what is hidden is behind all that is in its way, so that a few depths tell.
//! - It goes one level down in space wherever it cannot tell, and one level down in time where at the new
//!   level of space the box would be seen to move. At a spatial leaf the printed algorithm does not get on in
//!   time unless something moves there, and calls itself for ever; here it goes down in time then. Each step
//!   is down in one of the two, so it ends.
//! - Where nothing moves over a range, time is not refined at all.
//! - The nearest depth kept ends a walk early: what is not beyond it cannot be hidden by anything there.

use serde::Serialize;

use crate::sampling::pattern::StratumBounds;

use super::leaf::NodeRect;
use super::pyramid::{Drawn, NodeKind, TzPyramid};
use super::slices::Witness;

/// Where something can be over a range of time and lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Pixels, `[x0, x1, y0, y1]`, inclusive, in full-frame raster space; may reach beyond the region, and be
    /// empty.
    pub pixels: [i32; 4],
    /// Nearest depth. One that is not a number hides nothing.
    pub near: f32,
    /// Whether these are the bounds of every part of the range, too. It only saves work to say so.
    pub still: bool,
}

/// Depths read by queries.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct DepthReads {
    /// Farthest depths of inner nodes, of space or of time.
    pub inner: u64,
    /// Farthest depths of leaves of both.
    pub leaf: u64,
    /// Nearest depths.
    pub nearest: u64,
    /// Records of samples.
    pub samples: u64,
}

impl DepthReads {
    /// All of them.
    pub fn total(&self) -> u64 {
        self.inner + self.leaf + self.nearest + self.samples
    }
}

impl std::ops::AddAssign for DepthReads {
    fn add_assign(&mut self, other: Self) {
        self.inner += other.inner;
        self.leaf += other.leaf;
        self.nearest += other.nearest;
        self.samples += other.samples;
    }
}

/// Bounds that a query has asked for, so that it asks once.
#[derive(Debug, Clone)]
pub(super) struct Known {
    /// Bit i: node i of the tree of slices (at most 127) is known.
    nodes: u128,
    bounds: Vec<NodeBounds>,
}

/// [`Bounds`] in leaves of the region.
#[derive(Debug, Clone, Copy)]
struct NodeBounds {
    leaves: NodeRect,
    near: f32,
    still: bool,
}

impl Known {
    pub fn new(num_slices: usize) -> Self {
        let nothing = NodeBounds { leaves: NodeRect::EMPTY, near: f32::INFINITY, still: true };
        Known { nodes: 0, bounds: vec![nothing; 2 * num_slices] }
    }
}

impl TzPyramid {
    /// Whether at every sample something was drawn that is nearer than the thing that `bounds_over` bounds.
    ///
    /// `bounds_over` gets a range of time and lens places, both ends inclusive, and bounds the thing at all
    /// tuples in it: the pixels of all samples it can hit, and its nearest depth. Bounds of a part of a range
    /// have to lie within those of the range (in pixels and in depth), or the answer is still safe but may
    /// depend on the kind of the pyramid. At equal depth it is not occluded: the canonical order decides.
    pub fn is_occluded(
        &mut self,
        drawn: Drawn,
        bounds_over: impl FnMut(&StratumBounds) -> Bounds,
        reads: &mut DepthReads,
    ) -> bool {
        let mut known = std::mem::replace(&mut self.known, Known { nodes: 0, bounds: Vec::new() });
        known.nodes = 0;
        let mut walk = Walk { pyramid: self, drawn, bounds_over, known, reads: DepthReads::default() };
        let occluded = match walk.pyramid.kind {
            NodeKind::Tree => walk.tree(),
            NodeKind::Slices => walk.slices(),
        };
        let Walk { known, reads: of_walk, .. } = walk;
        *reads += of_walk;
        self.known = known;
        occluded
    }
}

impl TzPyramid {
    /// Whether a sample can be found at once that sees the thing, so that [`Self::is_occluded`] would say no.
    ///
    /// Looks at a few tuples, in the middle of the thing's box and in its corners, in the buffer itself:
    /// the pyramid need not know what was written. `false` says nothing.
    pub fn is_seen_by_a_witness(
        &self,
        drawn: Drawn,
        bounds_over: &mut impl FnMut(&StratumBounds) -> Bounds,
        reads: &mut DepthReads,
    ) -> bool {
        self.slices.witnesses().iter().any(|witness| {
            let bounds = bounds_over(&witness.place);
            is_seen_by(witness, drawn, &bounds, reads)
        })
    }
}

/// Whether one of the samples of a tuple that stand in the middle and in the corners of a box sees what is in it.
fn is_seen_by(witness: &Witness, drawn: Drawn, bounds: &Bounds, reads: &mut DepthReads) -> bool {
    let Bounds { pixels: [x0, x1, y0, y1], near, .. } = *bounds;
    let region = drawn.samples.region;
    let [x0, x1] = [x0.max(region.x0), x1.min(region.x1 - 1)];
    let [y0, y1] = [y0.max(region.y0), y1.min(region.y1 - 1)];
    if x0 > x1 || y0 > y1 || near.is_nan() {
        return false;
    }
    let middle = [x0 + (x1 - x0) / 2, y0 + (y1 - y0) / 2];
    [middle, [x0, y0], [x1, y1], [x1, y0], [x0, y1]].into_iter().any(|[x, y]| {
        // Two by two pixels hold each tuple of the usual pattern once.
        let pair = |c: i32, c0: i32, c1: i32| (c & !1).max(c0)..=(c | 1).min(c1);
        pair(y, y0, y1).any(|py| {
            pair(x, x0, x1).any(|px| {
                let sample_ix =
                    region.pixel_ix(px, py) * drawn.samples.samples_per_pixel() + witness.sample as usize;
                if drawn.samples.tuples[sample_ix] != witness.tuple {
                    return false;
                }
                reads.samples += 1;
                drawn.buffer.get(sample_ix).depth >= near
            })
        })
    })
}

struct Walk<'a, F> {
    pyramid: &'a mut TzPyramid,
    drawn: Drawn<'a>,
    bounds_over: F,
    known: Known,
    reads: DepthReads,
}

impl<F: FnMut(&StratumBounds) -> Bounds> Walk<'_, F> {
    /// Space alone, slice by slice.
    fn slices(&mut self) -> bool {
        let num = self.pyramid.slices.num();
        (num..2 * num).all(|slice| {
            let bounds = self.bounds(slice);
            let level = self.level_of(&bounds.leaves);
            self.is_hidden(level, slice, bounds.leaves.up(level))
        })
    }

    /// Space and time, from the whole time on.
    fn tree(&mut self) -> bool {
        let whole = self.bounds(1);
        if whole.leaves.is_empty() {
            return true;
        }
        let level = self.level_of(&whole.leaves);
        self.is_hidden(level, 1, whole.leaves.up(level))
    }

    /// Algorithm 2: the thing over the slices under `range`, in those of its nodes of `level` that are `within`.
    fn is_hidden(&mut self, level: usize, range: usize, within: NodeRect) -> bool {
        let bounds = self.bounds(range);
        let rect = bounds.leaves.up(level).intersect(&within);
        if rect.is_empty() {
            return true;
        }
        let is_slice = range >= self.pyramid.slices.num();
        for y in rect.y[0]..=rect.y[1] {
            for x in rect.x[0]..=rect.x[1] {
                if level == 0 && is_slice {
                    self.reads.leaf += 1;
                } else {
                    self.reads.inner += 1;
                }
                self.pyramid.refresh(self.drawn, level, x, y);
                let farthest = self.pyramid.farthest(level, x, y, range);
                if bounds.near > farthest {
                    continue;
                }
                if level == 0 && (is_slice || bounds.still) || self.is_in_front(level, range, x, y) {
                    return false;
                }
                if !self.is_hidden_below(level, range, x, y) {
                    return false;
                }
            }
        }
        true
    }

    /// The next step down from a node that cannot tell, in space, in time, or in both.
    fn is_hidden_below(&mut self, level: usize, range: usize, x: u32, y: u32) -> bool {
        let (below, within) = match level {
            0 => (0, NodeRect { x: [x; 2], y: [y; 2] }),
            _ => (level - 1, self.pyramid.children(level, x, y)),
        };
        if level == 0 || self.moves(below, range) {
            return (2 * range..2 * range + 2).all(|part| self.is_hidden(below, part, within));
        }
        self.is_hidden(below, range, within)
    }

    /// Whether the halves of a range touch other nodes of `level` than the whole does.
    fn moves(&mut self, level: usize, range: usize) -> bool {
        let bounds = self.bounds(range);
        if range >= self.pyramid.slices.num() || bounds.still {
            return false;
        }
        let whole = bounds.leaves.up(level);
        (2 * range..2 * range + 2).any(|part| self.bounds(part).leaves.up(level) != whole)
    }

    /// Whether the thing is seen for sure in a node, because nothing in it was hit nearer.
    fn is_in_front(&mut self, level: usize, range: usize, x: u32, y: u32) -> bool {
        if self.pyramid.kind == NodeKind::Slices {
            return false;
        }
        let bounds = self.bounds(range);
        self.reads.nearest += 1;
        // The negation also takes a depth that is not a number as visible.
        if bounds.near > self.pyramid.nearest(level, x, y) {
            return false;
        }
        if range == 1 && bounds.still {
            return true;
        }
        // A part of the range may be farther away or elsewhere: take the first slice as the witness.
        let num = self.pyramid.slices.num();
        let slice = range << (num.ilog2() - range.ilog2());
        let bounds = self.bounds(slice);
        let leaves = bounds.leaves;
        if leaves.is_empty() || leaves.up(level).intersect(&NodeRect { x: [x; 2], y: [y; 2] }).is_empty() {
            return false;
        }
        let corner = [leaves.x[0].max(x << level), leaves.y[0].max(y << level)];
        self.reads.leaf += 1;
        self.pyramid.refresh(self.drawn, 0, corner[0], corner[1]);
        let farthest = self.pyramid.farthest(0, corner[0], corner[1], slice);
        !(bounds.near > farthest || farthest == f32::NEG_INFINITY)
    }

    /// The level of space at which a node is as large as `leaves`.
    fn level_of(&self, leaves: &NodeRect) -> usize {
        let level = leaves.extent().max(1).next_power_of_two().trailing_zeros() as usize;
        level.min(self.pyramid.top())
    }

    /// Bounds over a node of the tree of slices.
    #[inline(always)]
    fn bounds(&mut self, range: usize) -> NodeBounds {
        if self.known.nodes >> range & 1 == 0 {
            self.known.nodes |= 1 << range;
            self.known.bounds[range] = self.ask(range);
        }
        self.known.bounds[range]
    }

    fn ask(&mut self, range: usize) -> NodeBounds {
        let Some(span) = self.pyramid.slices.span(range) else {
            return NodeBounds { leaves: NodeRect::EMPTY, near: f32::INFINITY, still: true };
        };
        let Bounds { pixels, near, still } = (self.bounds_over)(span);
        NodeBounds { leaves: self.pyramid.leaves_of(pixels), near, still }
    }
}
