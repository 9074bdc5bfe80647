//! What the front end leaves for the tiles: pieces, and which tile each of them is in.

use crate::pipeline::Piece;

/// Where a filed piece is.
#[derive(Debug, Clone, Copy)]
pub(super) enum Source {
    /// A whole patch.
    Patch(u32),
    /// An entry of [`Filed::pieces`].
    Piece(u32),
}

/// A filed piece.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entry {
    pub source: Source,
    pub near: f32,
}

/// Pieces by tile.
#[derive(Debug, Default)]
pub(super) struct Filed {
    pub entries: Vec<Entry>,
    pub pieces: Vec<Piece>,
    /// Tiles and the entries that touch them.
    pub touches: Vec<(u32, u32)>,
    /// Where each tile's list starts; one more than tiles.
    starts: Vec<usize>,
    /// Indices into `entries`.
    lists: Vec<u32>,
}

impl Filed {
    /// Count, prefix sum, write.
    pub fn sort_into(&mut self, num_tiles: usize) {
        let touches = std::mem::take(&mut self.touches);
        let mut counts = vec![0usize; num_tiles + 1];
        touches.iter().for_each(|&(tile, _)| counts[tile as usize + 1] += 1);
        for tile in 0..num_tiles {
            counts[tile + 1] += counts[tile];
        }
        self.lists = vec![0; counts[num_tiles]];
        let mut next = counts.clone();
        for (tile, entry) in touches {
            self.lists[next[tile as usize]] = entry;
            next[tile as usize] += 1;
        }
        self.starts = counts;
    }

    /// What may be seen in a tile.
    pub fn of_tile(&self, tile: usize) -> impl Iterator<Item = &Entry> {
        self.lists[self.starts[tile]..self.starts[tile + 1]].iter().map(|&ix| &self.entries[ix as usize])
    }
}
