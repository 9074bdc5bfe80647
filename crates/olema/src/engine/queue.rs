//! A tile's queue: what may be seen in it, nearest first.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::pipeline::Piece;
use crate::pipeline::bound::Bound;

use super::filed::Filed;

/// Pieces that wait in order of depth. Where there are more, new ones are taken first, so that the queue grows no longer
/// than one is deep: pictures do not depend on the order.
const MOST_WAITING: usize = 1 << 14;

/// What is to be done in a tile.
pub(super) struct Queue {
    waiting: BinaryHeap<Queued>,
    num_pieces: usize,
}

/// Something to do.
pub(super) enum Work {
    /// An entry as the front end filed it.
    Filed(u32),
    /// Cut here, and bounded.
    Piece(Box<(Piece, Bound)>),
}

impl Queue {
    /// A queue of what was filed for a tile.
    pub fn new(filed: &Filed, tile: usize) -> Self {
        let queued = |&ix: &u32| Queued { near: filed.entry(ix).near, work: Work::Filed(ix) };
        Queue { waiting: filed.of_tile(tile).iter().map(queued).collect(), num_pieces: 0 }
    }

    /// Adds a piece.
    pub fn push(&mut self, piece: Piece, bounds: Bound) {
        let near = if self.num_pieces < MOST_WAITING { bounds.near } else { f32::NEG_INFINITY };
        self.num_pieces += 1;
        self.waiting.push(Queued { near, work: Work::Piece(Box::new((piece, bounds))) });
    }

    /// The nearest.
    pub fn pop(&mut self) -> Option<Work> {
        let Queued { work, .. } = self.waiting.pop()?;
        self.num_pieces -= usize::from(matches!(work, Work::Piece(_)));
        Some(work)
    }
}

struct Queued {
    near: f32,
    work: Work,
}

impl PartialEq for Queued {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Queued {}

impl PartialOrd for Queued {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Queued {
    fn cmp(&self, other: &Self) -> Ordering {
        // The heap's greatest is the nearest.
        other.near.total_cmp(&self.near)
    }
}
