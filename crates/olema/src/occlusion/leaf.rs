//! Rectangles of nodes, and where the samples of a spatial leaf are.

/// Nodes of a level, both ends inclusive; empty where a first is beyond its last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct NodeRect {
    pub x: [u32; 2],
    pub y: [u32; 2],
}

impl NodeRect {
    pub const EMPTY: NodeRect = NodeRect { x: [1, 0], y: [1, 0] };

    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.x[0] > self.x[1] || self.y[0] > self.y[1]
    }

    /// The nodes `levels` up that hold these.
    #[inline(always)]
    pub fn up(&self, levels: usize) -> NodeRect {
        if self.is_empty() {
            return NodeRect::EMPTY;
        }
        NodeRect { x: self.x.map(|x| x >> levels), y: self.y.map(|y| y >> levels) }
    }

    #[inline(always)]
    pub fn intersect(&self, other: &NodeRect) -> NodeRect {
        NodeRect {
            x: [self.x[0].max(other.x[0]), self.x[1].min(other.x[1])],
            y: [self.y[0].max(other.y[0]), self.y[1].min(other.y[1])],
        }
    }

    /// Nodes along the longer side.
    #[inline(always)]
    pub fn extent(&self) -> u32 {
        if self.is_empty() { 0 } else { (self.x[1] - self.x[0]).max(self.y[1] - self.y[0]) + 1 }
    }

    pub fn nodes(self) -> impl Iterator<Item = [u32; 2]> {
        (self.y[0]..=self.y[1]).flat_map(move |y| (self.x[0]..=self.x[1]).map(move |x| [x, y]))
    }
}

/// Samples of a leaf: `num` ranges of `len`, `step` apart.
#[derive(Debug, Clone, Copy)]
pub(super) struct LeafRows {
    pub first: usize,
    pub len: usize,
    pub step: usize,
    pub num: usize,
}

impl LeafRows {
    #[inline(always)]
    pub fn ranges(self) -> impl Iterator<Item = std::ops::Range<usize>> {
        (0..self.num).map(move |row| {
            let start = self.first + row * self.step;
            start..start + self.len
        })
    }
}
