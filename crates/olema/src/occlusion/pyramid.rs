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
//! Algorithm 1 walks up once for each sample that is written. Here a leaf is computed from its samples once
//! for each grid that touched it, and a node from its children where one of them changed: the same values, as
//! maxima do not depend on the order. The nearest depth is kept with the sign turned, so that every float of a
//! node is the maximum of its children's.

use std::sync::Arc;

use crate::sampling::{Region, RegionSamples, SampleBuffer};

use super::leaf::{LeafRows, NodeRect, Source};
use super::slices::Slices;

/// What a node holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum NodeKind {
    /// A tree over the slices, and the nearest depth.
    Tree,
    /// The slices alone.
    Slices,
}

/// A hierarchy of depths over the samples of a region.
#[derive(Debug, Clone)]
pub struct TzPyramid {
    pub(super) slices: Arc<Slices>,
    pub(super) kind: NodeKind,
    leaf_px: i32,
    region: Region,
    /// Raster position of the first leaf's corner.
    origin: [i32; 2],
    /// From the leaves to the root.
    levels: Vec<Level>,
    /// A node's values on their way.
    node: Vec<f32>,
    /// Nodes of a rectangle that changed, of this level and of the next.
    changed: [Vec<bool>; 2],
    pub(super) known: super::query::Known,
}

/// One level of space: `width` x `height` nodes of one [`TzPyramid::stride`] each, row by row.
#[derive(Debug, Clone, Default, PartialEq)]
struct Level {
    width: usize,
    height: usize,
    values: Vec<f32>,
}

impl TzPyramid {
    /// A pyramid with spatial leaves of `leaf_px` (a power of two), over no samples yet.
    pub fn new(slices: Arc<Slices>, kind: NodeKind, leaf_px: u32) -> Self {
        debug_assert!(leaf_px.is_power_of_two() && leaf_px <= 1 << 16, "leaves of {leaf_px} pixels");
        let known = super::query::Known::new(slices.num());
        TzPyramid {
            slices,
            kind,
            leaf_px: leaf_px as i32,
            region: Region::new(0, 0, 0, 0),
            origin: [0; 2],
            levels: Vec::new(),
            node: Vec::new(),
            changed: [Vec::new(), Vec::new()],
            known,
        }
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
        let stride = self.stride();
        for level in &mut self.levels {
            level.values.fill(f32::INFINITY);
            if self.kind == NodeKind::Tree {
                level.values.iter_mut().step_by(stride).for_each(|nearest| *nearest = f32::NEG_INFINITY);
            }
        }
        self.empty_slices_without_samples(samples);
    }

    fn lay_out_levels(&mut self) {
        let along = |from: i32, to: i32| ((to - from + self.leaf_px - 1) / self.leaf_px) as usize;
        let mut size = [along(self.origin[0], self.region.x1), along(self.origin[1], self.region.y1)];
        if self.region.num_pixels() == 0 {
            size = [0, 0];
        }
        let stride = self.stride();
        let num_levels = size[0].max(size[1]).next_power_of_two().trailing_zeros() as usize + 1;
        self.levels.resize(num_levels, Level::default());
        for level in &mut self.levels {
            [level.width, level.height] = size;
            level.values.resize(size[0] * size[1] * stride, 0.0);
            size = size.map(|n| n.div_ceil(2));
        }
    }

    /// Whole leaves hold every tuple if the pattern's tile divides them; all others have to be looked at, and
    /// all leaves where there are fewer tuples than slices.
    fn empty_slices_without_samples(&mut self, samples: &RegionSamples) {
        let Region { x0, x1, y0, y1 } = self.region;
        let tile_divides = self.leaf_px % self.slices.tile() as i32 == 0;
        let every_slice_has_a_tuple = self.slices.span(2 * self.slices.num() - 1).is_some();
        let is_cut = |c: i32| c.rem_euclid(self.leaf_px) != 0;
        let cut = [is_cut(x0), is_cut(x1), is_cut(y0), is_cut(y1)];
        if !(tile_divides && every_slice_has_a_tuple) {
            self.refresh(samples, Source::Unhit, [x0, x1 - 1, y0, y1 - 1]);
            return;
        }
        let borders = [
            [x0, x0, y0, y1 - 1],
            [x1 - 1, x1 - 1, y0, y1 - 1],
            [x0, x1 - 1, y0, y0],
            [x0, x1 - 1, y1 - 1, y1 - 1],
        ];
        for (border, is_cut) in borders.into_iter().zip(cut) {
            if is_cut {
                self.refresh(samples, Source::Unhit, border);
            }
        }
    }

    /// Takes in what was drawn since the buffer's marks were cleared: leaves of `pixels`, `[x0, x1, y0, y1]`,
    /// inclusive, that hold a mark. The box may reach beyond the region. A large box costs little where few
    /// samples in it were hit, as those of fast things are.
    ///
    /// `samples` must be those of [`Self::renew`], `buffer` of the same region.
    pub fn update(&mut self, samples: &RegionSamples, buffer: &SampleBuffer, pixels: [i32; 4]) {
        debug_assert_eq!(buffer.region(), self.region);
        self.refresh(samples, Source::Written(buffer), pixels);
    }

    /// Takes in all records, marked or not.
    pub fn rebuild(&mut self, samples: &RegionSamples, buffer: &SampleBuffer) {
        debug_assert_eq!(buffer.region(), self.region);
        let Region { x0, x1, y0, y1 } = self.region;
        self.refresh(samples, Source::All(buffer), [x0, x1 - 1, y0, y1 - 1]);
    }

    fn refresh(&mut self, samples: &RegionSamples, source: Source, pixels: [i32; 4]) {
        debug_assert_eq!(samples.region, self.region);
        let mut rect = self.leaves_of(pixels);
        if rect.is_empty() {
            return;
        }
        let stride = self.stride();
        let mut node = std::mem::take(&mut self.node);
        let [mut changed, mut above] = std::mem::take(&mut self.changed);
        changed.clear();
        node.resize(stride, 0.0);
        for [x, y] in rect.nodes() {
            let rows = self.samples_of_leaf(x, y, samples.samples_per_pixel());
            let is_written = source.is_written(&rows);
            if is_written {
                self.compute_leaf(&rows, samples, source.buffer(), &mut node);
            }
            changed.push(is_written && self.levels[0].replace(x, y, &node));
        }
        for level in 1..self.levels.len() {
            if !changed.contains(&true) {
                break;
            }
            let parents = rect.up(1);
            flag_parents(&rect, &changed, &parents, &mut above);
            let (below, here) = self.levels.split_at_mut(level);
            for ([x, y], flag) in parents.nodes().zip(above.iter_mut()).filter(|(_, flag)| **flag) {
                below[level - 1].farthest_of_children(x, y, &mut node);
                *flag = here[0].replace(x, y, &node);
            }
            std::mem::swap(&mut changed, &mut above);
            rect = parents;
        }
        self.node = node;
        self.changed = [changed, above];
    }

    /// Samples of a leaf, cut to the region.
    #[inline(always)]
    fn samples_of_leaf(&self, x: u32, y: u32, samples_per_pixel: usize) -> LeafRows {
        let [px, py] = [x, y].map(|n| n as i32 * self.leaf_px);
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

    /// Scans the samples of a leaf; without a buffer, none was hit.
    fn compute_leaf(
        &self,
        rows: &LeafRows,
        samples: &RegionSamples,
        buffer: Option<&SampleBuffer>,
        node: &mut [f32],
    ) {
        // A place for every value of a byte needs no check of bounds.
        let mut slots = [f32::NEG_INFINITY; 256];
        let mut nearest = f32::INFINITY;
        let of_tuple = self.slices.of_tuple();
        for row in rows.ranges() {
            let tuples = &samples.tuples[row.clone()];
            let Some(buffer) = buffer else {
                for &tuple in tuples {
                    slots[usize::from(of_tuple[tuple as usize])] = f32::INFINITY;
                }
                continue;
            };
            for (&tuple, record) in tuples.iter().zip(buffer.records_of(row)) {
                let slot = &mut slots[usize::from(of_tuple[tuple as usize])];
                *slot = farther(*slot, record.depth);
                nearest = if record.depth < nearest { record.depth } else { nearest };
            }
        }
        let num_slices = self.slices.num();
        let first = node.len() - num_slices;
        node[first..].copy_from_slice(&slots[..num_slices]);
        if self.kind == NodeKind::Tree {
            node[0] = -nearest;
            let mut parents = num_slices / 2;
            while parents > 0 {
                let (above, below) = node.split_at_mut(2 * parents);
                for (parent, pair) in above[parents..].iter_mut().zip(below.chunks_exact(2)) {
                    *parent = farther(pair[0], pair[1]);
                }
                parents /= 2;
            }
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

    /// Farthest depth kept at a spatial node in a node of the tree of slices.
    #[inline(always)]
    pub(super) fn farthest(&self, level: usize, x: u32, y: u32, slice_node: usize) -> f32 {
        let first = if self.kind == NodeKind::Tree { 0 } else { self.slices.num() };
        self.levels[level].at(x, y, self.stride())[slice_node - first]
    }

    /// Nearest depth kept at a spatial node; infinite where nothing was hit. Trees only.
    #[inline(always)]
    pub(super) fn nearest(&self, level: usize, x: u32, y: u32) -> f32 {
        debug_assert_eq!(self.kind, NodeKind::Tree);
        -self.levels[level].at(x, y, self.stride())[0]
    }

    /// Floats a node.
    #[inline(always)]
    fn stride(&self) -> usize {
        match self.kind {
            NodeKind::Tree => 2 * self.slices.num(),
            NodeKind::Slices => self.slices.num(),
        }
    }

    /// Whether both hold the same values.
    #[cfg(test)]
    pub(super) fn same_values(&self, other: &TzPyramid) -> bool {
        self.origin == other.origin && self.levels == other.levels
    }
}

impl Level {
    #[inline(always)]
    fn at(&self, x: u32, y: u32, stride: usize) -> &[f32] {
        let start = (y as usize * self.width + x as usize) * stride;
        &self.values[start..start + stride]
    }

    /// Stores a node; whether that changed it.
    fn replace(&mut self, x: u32, y: u32, node: &[f32]) -> bool {
        let start = (y as usize * self.width + x as usize) * node.len();
        let stored = &mut self.values[start..start + node.len()];
        let differs = stored.iter().zip(node).fold(false, |differs, (a, b)| differs | (a != b));
        if differs {
            stored.copy_from_slice(node);
        }
        differs
    }

    /// What the parent (x, y) of nodes of this level holds.
    fn farthest_of_children(&self, x: u32, y: u32, node: &mut [f32]) {
        let stride = node.len();
        let columns = [2 * x, (2 * x + 1).min(self.width as u32 - 1)];
        let rows = [2 * y, (2 * y + 1).min(self.height as u32 - 1)];
        node.copy_from_slice(self.at(columns[0], rows[0], stride));
        // A child counted twice, at the border, changes no maximum.
        for [cx, cy] in [[columns[1], rows[0]], [columns[0], rows[1]], [columns[1], rows[1]]] {
            for (value, &child) in node.iter_mut().zip(self.at(cx, cy, stride)) {
                *value = farther(*value, child);
            }
        }
    }
}

/// Flags the parents of changed nodes; both rectangles row by row.
fn flag_parents(rect: &NodeRect, changed: &[bool], parents: &NodeRect, above: &mut Vec<bool>) {
    let width = (parents.x[1] - parents.x[0] + 1) as usize;
    let height = (parents.y[1] - parents.y[0] + 1) as usize;
    above.clear();
    above.resize(width * height, false);
    for ([x, y], _) in rect.nodes().zip(changed).filter(|(_, changed)| **changed) {
        let row = (y / 2 - parents.y[0]) as usize;
        above[row * width + (x / 2 - parents.x[0]) as usize] = true;
    }
}

#[inline(always)]
fn farther(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}
