//! What the front end leaves for the tiles: pieces, where each of them can be, and which tiles it is in.

use crate::pipeline::Piece;
use crate::pipeline::bound::Bound;
use crate::pipeline::sweep::{Extent, Sweep};

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
    /// Nearest depth.
    pub near: f32,
    /// Whether it is known to be cut before it is diced.
    pub is_surely_split: bool,
    /// First of its extents, as many as its patch has keys; `None` where they do not tell where it can be.
    first_extent: Option<u32>,
}

/// Pieces by tile.
#[derive(Debug, Default)]
pub(super) struct Filed {
    entries: Vec<Entry>,
    pub pieces: Vec<Piece>,
    /// Tiles and the entries that touch them.
    touches: Vec<(u32, u32)>,
    /// Where pieces are at the keys. A tile would find the same as the front end did, and most pieces are in several.
    extents: Vec<Extent>,
    /// Where each tile's list starts; one more than tiles.
    starts: Vec<usize>,
    /// Indices into `entries`.
    lists: Vec<u32>,
}

/// Numbers of what was filed before something.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mark([usize; 4]);

impl Filed {
    /// Has room for all of these and no more: lists that grow by doubling leave memory behind.
    pub fn with_room<'a>(all: impl Iterator<Item = &'a Filed>) -> Self {
        let add = |sum: [usize; 4], filed: &Filed| {
            let Mark(more) = filed.mark();
            [0, 1, 2, 3].map(|list| sum[list] + more[list])
        };
        let [entries, pieces, touches, extents] = all.fold([0; 4], add);
        Filed {
            entries: Vec::with_capacity(entries),
            pieces: Vec::with_capacity(pieces),
            touches: Vec::with_capacity(touches),
            extents: Vec::with_capacity(extents),
            ..Filed::default()
        }
    }

    /// Files a piece of a patch with these key times in some tiles.
    pub fn push(
        &mut self,
        piece: &Piece,
        bounds: &Bound,
        key_times: &[f32],
        is_surely_split: bool,
        tiles: impl Iterator<Item = usize>,
    ) {
        let source = if piece.path == 1 {
            Source::Patch(piece.patch)
        } else {
            self.pieces.push(*piece);
            Source::Piece(self.pieces.len() as u32 - 1)
        };
        let first = self.extents.len() as u32;
        let tells = bounds.is_for_all_regions() && bounds.sweep.list_keys(key_times, &mut self.extents);
        let (entry, first_extent) = (self.entries.len() as u32, tells.then_some(first));
        self.touches.extend(tiles.map(|tile| (tile as u32, entry)));
        self.entries.push(Entry { source, near: bounds.near, is_surely_split, first_extent });
    }

    /// What is filed by now.
    pub fn mark(&self) -> Mark {
        Mark([self.entries.len(), self.pieces.len(), self.touches.len(), self.extents.len()])
    }

    /// Forgets what was filed since.
    pub fn forget_since(&mut self, Mark([entries, pieces, touches, extents]): Mark) {
        self.entries.truncate(entries);
        self.pieces.truncate(pieces);
        self.touches.truncate(touches);
        self.extents.truncate(extents);
    }

    /// Adds what was filed apart.
    pub fn append(&mut self, other: Filed) {
        let Mark([first_entry, first_piece, _, first_extent]) = self.mark();
        self.pieces.extend(other.pieces);
        self.extents.extend(other.extents);
        let touches = other.touches.into_iter();
        self.touches.extend(touches.map(|(tile, entry)| (tile, entry + first_entry as u32)));
        self.entries.extend(other.entries.into_iter().map(|entry| Entry {
            source: match entry.source {
                Source::Piece(ix) => Source::Piece(ix + first_piece as u32),
                whole => whole,
            },
            first_extent: entry.first_extent.map(|first| first + first_extent as u32),
            ..entry
        }));
    }

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

    /// What may be seen in a tile: numbers of entries.
    pub fn of_tile(&self, tile: usize) -> &[u32] {
        &self.lists[self.starts[tile]..self.starts[tile + 1]]
    }

    /// An entry.
    pub fn entry(&self, ix: u32) -> &Entry {
        &self.entries[ix as usize]
    }

    /// Where a piece of a patch with these key times can be; `None` where that has to be found out.
    pub fn sweep(&self, entry: &Entry, key_times: &[f32]) -> Option<Sweep> {
        let first = entry.first_extent? as usize;
        Some(Sweep::of_keys(&self.extents[first..first + key_times.len()], key_times))
    }
}
