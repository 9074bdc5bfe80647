//! The tz-pyramid: over a region's samples, the farthest of the depths kept, by space and slice of time.
//!
//! In: a region's samples and their records. Out: for each node the farthest record of each of its slices, and
//! of each node of the tree over its slices; and the nearest record of all. A sample that nothing hit is
//! infinitely far; a slice without samples is infinitely near, as nothing can be seen in it. Source: Boulos
//! 2010, sections 3.2 and 3.2.1 (Algorithm 1).
//!
//! ```text
//! space: leaves of leaf_px x leaf_px pixels from multiples of leaf_px in the full frame, then halves, up to
//!        one node; the region may be of any size and the leaves at its border be cut
//! node:  [-nearest, root, 2, 3, 4, 5, 6, 7, ...]      tree (z- and tz-pyramid), 2 T floats for T slices
//!        [slice 0, slice 1, ...]                      slices only (tz-slice), T floats
//! ```
//!
//! Algorithm 1 walks up once for each sample that is written. Here what is written only marks leaves, and all nodes
//! above them, as stale; a node that a query reads is computed then, from its samples (`leaf_lanes`) or from
//! its children: the same values, as maxima do not depend on the order. Of the leaves that are written most are never
//! read, or not before they were written again. A node under which nothing was hit yet is blank: it holds no
//! values and need not be filled. The nearest depth is kept with the sign turned, so that every float of a node is the
//! maximum of its children's.

use std::sync::Arc;

use crate::math::simd::SimdLevel;
use crate::sampling::{Region, RegionSamples, SampleBuffer};

use super::leaf::{LeafRows, NodeRect};
use super::leaf_lanes::LeafKernel;
use super::slices::Slices;
use super::written::WrittenLeaves;

/// What a node holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum NodeKind {
    /// A tree over the slices, and the nearest depth.
    Tree,
    /// The slices alone.
    Slices,
}

/// What pyramids are computed from: a region's samples and what hit them.
#[derive(Debug, Clone, Copy)]
pub struct Drawn<'a> {
    /// The samples, those of [`TzPyramid::renew`].
    pub samples: &'a RegionSamples,
    /// Their records.
    pub buffer: &'a SampleBuffer,
}

/// A hierarchy of depths over the samples of a region.
#[derive(Debug, Clone)]
pub struct TzPyramid {
    pub(super) slices: Arc<Slices>,
    pub(super) kind: NodeKind,
    leaf_px: i32,
    pub(super) region: Region,
    /// Raster position of the first leaf's corner.
    origin: [i32; 2],
    /// From the leaves to the root.
    levels: Vec<Level>,
    leaf: LeafKernel,
    simd: SimdLevel,
    pub(super) known: super::query::Known,
}

/// What is known of a node. Above a stale one all are stale.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// Nothing under it was hit, and every slice has a sample under it: infinitely far throughout.
    Blank,
    /// Something under it was written since it was computed.
    Stale,
    /// Its values are right.
    Fresh,
}

/// One level of space: `width` x `height` nodes of one [`TzPyramid::stride`] each, row by row.
#[derive(Debug, Clone, Default)]
struct Level {
    width: usize,
    height: usize,
    states: Vec<State>,
    /// Right where the state says so.
    values: Vec<f32>,
}

impl TzPyramid {
    /// A pyramid with spatial leaves of `leaf_px` (a power of two), over no samples yet.
    pub fn new(slices: Arc<Slices>, kind: NodeKind, leaf_px: u32) -> Self {
        debug_assert!(leaf_px.is_power_of_two() && leaf_px <= 1 << 16, "leaves of {leaf_px} pixels");
        let known = super::query::Known::new(slices.num());
        TzPyramid {
            leaf: LeafKernel::new(&slices),
            slices,
            kind,
            leaf_px: leaf_px as i32,
            region: Region::new(0, 0, 0, 0),
            origin: [0; 2],
            levels: Vec::new(),
            simd: SimdLevel::best(),
            known,
        }
    }

    /// Computes leaves with these instructions; the values are the same.
    #[must_use]
    pub fn with_level(mut self, level: SimdLevel) -> Self {
        self.simd = level;
        self
    }

    /// The slices.
    pub fn slices(&self) -> &Slices {
        &self.slices
    }

    /// Bytes of the nodes. With leaves as large as the pattern's tile and a slice for each tuple, the tree
    /// takes 8/3 of a float a sample, the leaves' finest slices included, as the paper counts.
    pub fn bytes(&self) -> usize {
        self.levels.iter().map(|level| level.values.len() * size_of::<f32>()).sum()
    }

    /// Begins anew for a region's samples, none of which was hit, in the same memory.
    pub fn renew(&mut self, samples: &RegionSamples) {
        self.region = samples.region;
        let leaf = self.leaf_px;
        self.origin = [samples.region.x0, samples.region.y0].map(|c| c.div_euclid(leaf) * leaf);
        self.lay_out_levels();
        self.mark_slices_without_samples();
    }

    fn lay_out_levels(&mut self) {
        let along = |from: i32, to: i32| ((to - from + self.leaf_px - 1) / self.leaf_px) as usize;
        let mut size = [along(self.origin[0], self.region.x1), along(self.origin[1], self.region.y1)];
        if self.region.num_pixels() == 0 {
            size = [0, 0];
        }
        let stride = self.stride();
        let num_levels = size[0].max(size[1]).next_power_of_two().trailing_zeros() as usize + 1;
        self.levels.resize_with(num_levels, Level::default);
        for level in &mut self.levels {
            [level.width, level.height] = size;
            level.values.resize(size[0] * size[1] * stride, 0.0);
            level.states.clear();
            level.states.resize(size[0] * size[1], State::Blank);
            size = size.map(|n| n.div_ceil(2));
        }
    }

    /// Whole leaves hold every tuple if the pattern's tile divides them; all others have to be looked at, and
    /// all leaves where there are fewer tuples than slices.
    fn mark_slices_without_samples(&mut self) {
        let Region { x0, x1, y0, y1 } = self.region;
        let tile_divides = self.leaf_px % self.slices.tile() as i32 == 0;
        let every_slice_has_a_tuple = self.slices.span(2 * self.slices.num() - 1).is_some();
        if !(tile_divides && every_slice_has_a_tuple) {
            return self.mark_all([x0, x1 - 1, y0, y1 - 1]);
        }
        let is_cut = |c: i32| c.rem_euclid(self.leaf_px) != 0;
        let cut = [is_cut(x0), is_cut(x1), is_cut(y0), is_cut(y1)];
        let borders = [
            [x0, x0, y0, y1 - 1],
            [x1 - 1, x1 - 1, y0, y1 - 1],
            [x0, x1 - 1, y0, y0],
            [x0, x1 - 1, y1 - 1, y1 - 1],
        ];
        for (border, is_cut) in borders.into_iter().zip(cut) {
            if is_cut {
                self.mark_all(border);
            }
        }
    }

    /// Marks all leaves of `pixels`, `[x0, x1, y0, y1]`, inclusive, as stale.
    pub fn mark_all(&mut self, pixels: [i32; 4]) {
        let rect = self.leaves_of(pixels);
        if !rect.is_empty() {
            rect.nodes().for_each(|leaf| self.mark(leaf));
        }
    }

    /// Marks a leaf and all above it as stale.
    #[inline(always)]
    pub(super) fn mark(&mut self, [mut x, mut y]: [u32; 2]) {
        for level in &mut self.levels {
            let state = &mut level.states[y as usize * level.width + x as usize];
            if *state == State::Stale {
                break;
            }
            *state = State::Stale;
            (x, y) = (x / 2, y / 2);
        }
    }

    /// Marks the leaves of `pixels`, inclusive, in which a record was written since the buffer's marks were cleared.
    pub fn update(&mut self, buffer: &SampleBuffer, pixels: [i32; 4]) {
        let mut written = WrittenLeaves::default();
        self.list_written(buffer, pixels, &mut written);
        written.leaves.into_iter().for_each(|leaf| self.mark(leaf));
    }

    /// Makes a node's values right.
    #[inline(always)]
    pub(super) fn refresh(&mut self, drawn: Drawn, level: usize, x: u32, y: u32) {
        let at = &self.levels[level];
        if at.states[y as usize * at.width + x as usize] == State::Stale {
            self.compute(drawn, level, x, y);
        }
    }

    fn compute(&mut self, drawn: Drawn, level: usize, x: u32, y: u32) {
        debug_assert_eq!(drawn.samples.region, self.region);
        let stride = self.stride();
        let first_slice = stride - self.slices.num();
        if level == 0 {
            let rows = self.samples_of_leaf([x, y], drawn.samples.samples_per_pixel());
            let leaves = &mut self.levels[0];
            let node = leaves.at_mut(x, y, stride);
            self.leaf.compute(self.simd, &rows, drawn, &self.slices, node, first_slice);
            leaves.set_fresh(x, y);
            return;
        }
        for [cx, cy] in self.children(level, x, y).nodes() {
            self.refresh(drawn, level - 1, cx, cy);
        }
        let (below, here) = self.levels.split_at_mut(level);
        let node = here[0].at_mut(x, y, stride);
        let has_nearest = self.kind == NodeKind::Tree;
        self.simd.run(
            #[inline(always)]
            || below[level - 1].farthest_of_children(x, y, node, has_nearest),
        );
        here[0].set_fresh(x, y);
    }

    /// Samples of a leaf, cut to the region.
    #[inline(always)]
    pub(super) fn samples_of_leaf(&self, leaf: [u32; 2], samples_per_pixel: usize) -> LeafRows {
        let [px, py] = leaf.map(|n| n as i32 * self.leaf_px);
        let [px, py] = [px + self.origin[0], py + self.origin[1]];
        let [px0, px1] = [px.max(self.region.x0), (px + self.leaf_px).min(self.region.x1)];
        let [py0, py1] = [py.max(self.region.y0), (py + self.leaf_px).min(self.region.y1)];
        LeafRows {
            first: self.region.pixel_ix(px0, py0) * samples_per_pixel,
            len: (px1 - px0) as usize * samples_per_pixel,
            step: self.region.width() * samples_per_pixel,
            num: (py1 - py0) as usize,
        }
    }

    /// Leaves that hold a pixel of the region in `[x0, x1, y0, y1]`, inclusive.
    #[inline(always)]
    pub(super) fn leaves_of(&self, [x0, x1, y0, y1]: [i32; 4]) -> NodeRect {
        let Region { x0: rx0, x1: rx1, y0: ry0, y1: ry1 } = self.region;
        let [x0, x1, y0, y1] = [x0.max(rx0), x1.min(rx1 - 1), y0.max(ry0), y1.min(ry1 - 1)];
        if x0 > x1 || y0 > y1 {
            return NodeRect::EMPTY;
        }
        let shift = self.leaf_px.trailing_zeros();
        let [ox, oy] = self.origin;
        NodeRect {
            x: [x0, x1].map(|x| (x - ox) as u32 >> shift),
            y: [y0, y1].map(|y| (y - oy) as u32 >> shift),
        }
    }

    /// The root's level; 0 where there is but one leaf.
    #[inline(always)]
    pub(super) fn top(&self) -> usize {
        self.levels.len().saturating_sub(1)
    }

    /// Children of a node of `level` (above 0), one level below.
    #[inline(always)]
    pub(super) fn children(&self, level: usize, x: u32, y: u32) -> NodeRect {
        let below = &self.levels[level - 1];
        NodeRect {
            x: [2 * x, (2 * x + 1).min(below.width as u32 - 1)],
            y: [2 * y, (2 * y + 1).min(below.height as u32 - 1)],
        }
    }

    /// Farthest depth kept at a spatial node, which was refreshed, in a node of the tree of slices.
    #[inline(always)]
    pub(super) fn farthest(&self, level: usize, x: u32, y: u32, slice_node: usize) -> f32 {
        let first = if self.kind == NodeKind::Tree { 0 } else { self.slices.num() };
        self.levels[level].at(x, y, self.stride()).map_or(f32::INFINITY, |node| node[slice_node - first])
    }

    /// Nearest depth kept at a spatial node, which was refreshed; infinite where nothing was hit. Trees only.
    #[inline(always)]
    pub(super) fn nearest(&self, level: usize, x: u32, y: u32) -> f32 {
        debug_assert_eq!(self.kind, NodeKind::Tree);
        self.levels[level].at(x, y, self.stride()).map_or(f32::INFINITY, |node| -node[0])
    }

    /// Floats a node.
    #[inline(always)]
    fn stride(&self) -> usize {
        match self.kind {
            NodeKind::Tree => 2 * self.slices.num(),
            NodeKind::Slices => self.slices.num(),
        }
    }

    /// The values of all nodes, blank ones too.
    #[cfg(test)]
    pub(super) fn all_values(&mut self, drawn: Drawn) -> Vec<f32> {
        let (mut all, stride) = (Vec::new(), self.stride());
        let blank =
            |ix| if ix == 0 && self.kind == NodeKind::Tree { f32::NEG_INFINITY } else { f32::INFINITY };
        let blank: Vec<f32> = (0..stride).map(blank).collect();
        for level in 0..self.levels.len() {
            let [width, height] = [self.levels[level].width as u32, self.levels[level].height as u32];
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                self.refresh(drawn, level, x, y);
                all.extend_from_slice(self.levels[level].at(x, y, stride).unwrap_or(&blank));
            }
        }
        all
    }
}

impl Level {
    /// The values of a node that is not stale; `None` for a blank one.
    #[inline(always)]
    fn at(&self, x: u32, y: u32, stride: usize) -> Option<&[f32]> {
        let ix = y as usize * self.width + x as usize;
        debug_assert_ne!(self.states[ix], State::Stale, "a node is refreshed before it is read");
        (self.states[ix] == State::Fresh).then(|| &self.values[ix * stride..(ix + 1) * stride])
    }

    #[inline(always)]
    fn at_mut(&mut self, x: u32, y: u32, stride: usize) -> &mut [f32] {
        let ix = y as usize * self.width + x as usize;
        &mut self.values[ix * stride..(ix + 1) * stride]
    }

    #[inline(always)]
    fn set_fresh(&mut self, x: u32, y: u32) {
        self.states[y as usize * self.width + x as usize] = State::Fresh;
    }

    /// What the parent (x, y) of nodes of this level holds.
    #[inline(always)]
    fn farthest_of_children(&self, x: u32, y: u32, node: &mut [f32], has_nearest: bool) {
        let stride = node.len();
        let columns = [2 * x, (2 * x + 1).min(self.width as u32 - 1)];
        let rows = [2 * y, (2 * y + 1).min(self.height as u32 - 1)];
        // A child counted twice, at the border, changes no maximum.
        let children =
            [[columns[0], rows[0]], [columns[1], rows[0]], [columns[0], rows[1]], [columns[1], rows[1]]]
                .map(|[cx, cy]| self.at(cx, cy, stride));
        if let [Some(a), Some(b), Some(c), Some(d)] = children {
            let (a, b, c, d) = (&a[..stride], &b[..stride], &c[..stride], &d[..stride]);
            for (ix, value) in node.iter_mut().enumerate() {
                *value = farther(farther(a[ix], b[ix]), farther(c[ix], d[ix]));
            }
            return;
        }
        // One that is blank is infinitely far.
        node.fill(f32::INFINITY);
        if has_nearest {
            node[0] =
                children.into_iter().flatten().fold(f32::NEG_INFINITY, |most, child| farther(most, child[0]));
        }
    }
}

#[inline(always)]
pub(super) fn farther(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}
