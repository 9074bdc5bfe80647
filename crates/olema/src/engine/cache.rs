//! Grids that reach into several tiles, made once and kept until the last of these tiles is done.
//!
//! A grid is a pure function of its piece, so it does not matter which tile makes it, and a grid that could not
//! be kept for want of memory is simply made again (and counted). A tile in which a grid is hidden never asks for it,
//! so nobody counts how many still will: tiles are taken in order, and once all up to a grid's last tile are done, the
//! grid is let go of.

use std::collections::hash_map::Entry;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use crate::math::map::Map;
use crate::pipeline::GridKey;
use crate::pipeline::shade::ShadedGrid;

/// Locks that share the work; a grid is looked up once a tile, so that contention is rare.
const SHARDS: usize = 64;

type Shard = Map<GridKey, Kept>;

/// Shared by all workers of a frame.
pub(super) struct GridCache {
    shards: Vec<Mutex<Shard>>,
    used: AtomicU64,
    budget: u64,
    done: Mutex<Done>,
}

/// Which tiles are done.
struct Done {
    /// All before this one are.
    before: usize,
    /// Those after it that are, too.
    early: Vec<bool>,
    /// Grids by their last tile.
    last_in: Vec<Vec<GridKey>>,
}

enum Kept {
    /// In memory, or being made by the first tile that asked.
    Here { grid: Arc<OnceLock<Arc<ShadedGrid>>>, bytes: u64 },
    /// Made before, and not kept.
    NotKept,
}

/// What a tile finds.
pub(super) enum Lookup {
    /// Fill it (or take what another tile filled in).
    Shared(Arc<OnceLock<Arc<ShadedGrid>>>),
    /// Make it for this tile alone; the flag says whether it was made before.
    Alone {
        /// Made before.
        again: bool,
    },
}

impl GridCache {
    pub fn new(budget: u64, num_tiles: usize) -> Self {
        let shards = (0..SHARDS).map(|_| Mutex::default()).collect();
        let done = Done { before: 0, early: vec![false; num_tiles], last_in: vec![Vec::new(); num_tiles] };
        GridCache { shards, used: AtomicU64::new(0), budget, done: Mutex::new(done) }
    }

    fn shard(&self, key: &GridKey) -> &Mutex<Shard> {
        &self.shards[(key.patch as usize).wrapping_mul(31).wrapping_add(key.path as usize) % SHARDS]
    }

    /// Asks for the grid of about `bytes` that several tiles may ask for, `last_tile` as the last.
    pub fn look_up(&self, key: &GridKey, last_tile: usize, bytes: u64) -> Lookup {
        let mut kept = self.shard(key).lock().unwrap_or_else(PoisonError::into_inner);
        match kept.entry(*key) {
            Entry::Vacant(place) => {
                let fits = self.used.fetch_add(bytes, Ordering::Relaxed) + bytes <= self.budget;
                let lookup = if fits {
                    let grid = Arc::new(OnceLock::new());
                    place.insert(Kept::Here { grid: Arc::clone(&grid), bytes });
                    Lookup::Shared(grid)
                } else {
                    self.used.fetch_sub(bytes, Ordering::Relaxed);
                    place.insert(Kept::NotKept);
                    Lookup::Alone { again: false }
                };
                drop(kept);
                let mut done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
                done.last_in[last_tile].push(*key);
                lookup
            }
            Entry::Occupied(place) => match place.get() {
                Kept::NotKept => Lookup::Alone { again: true },
                Kept::Here { grid, .. } => Lookup::Shared(Arc::clone(grid)),
            },
        }
    }

    /// Says that a tile is done.
    pub fn finished(&self, tile: usize) {
        let mut over = Vec::new();
        {
            let mut done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
            done.early[tile] = true;
            while done.early.get(done.before) == Some(&true) {
                let before = done.before;
                over.append(&mut done.last_in[before]);
                done.before += 1;
            }
        }
        for key in over {
            let kept = self.shard(&key).lock().unwrap_or_else(PoisonError::into_inner).remove(&key);
            if let Some(Kept::Here { bytes, .. }) = kept {
                self.used.fetch_sub(bytes, Ordering::Relaxed);
            }
        }
    }
}
