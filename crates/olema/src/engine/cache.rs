//! Grids that reach into several tiles, made once and kept until the last of them has drawn it.
//!
//! A grid is a pure function of its piece, so it does not matter which tile makes it, and a grid that could not
//! be kept for want of memory is simply made again (and counted).

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::hash::{BuildHasherDefault, Hasher};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use crate::pipeline::{Grid, GridKey};

/// Locks that share the work; a grid is looked up once a tile, so that contention is rare.
const SHARDS: usize = 64;

/// Mixes keys with a product each word (Knuth, section 6.4): they come from splitting, which nobody can aim at one
/// bucket, and a hash that withstands that took half of a look-up.
#[derive(Debug, Default, Clone, Copy)]
struct Mix(u64);

impl Hasher for Mix {
    fn finish(&self) -> u64 {
        self.0 ^ (self.0 >> 32)
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.write_u64(byte.into()));
    }

    fn write_u32(&mut self, word: u32) {
        self.write_u64(word.into());
    }

    fn write_u64(&mut self, word: u64) {
        self.0 = (self.0.rotate_left(23) ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }

    fn write_u128(&mut self, word: u128) {
        self.write_u64(word as u64);
        self.write_u64((word >> 64) as u64);
    }
}

type Shard = HashMap<GridKey, Kept, BuildHasherDefault<Mix>>;

/// Shared by all workers of a frame.
pub(super) struct GridCache {
    shards: Vec<Mutex<Shard>>,
    used: AtomicU64,
    budget: u64,
}

enum Kept {
    /// In memory (or being made by the first tile that asked), wanted by so many more tiles.
    Here { grid: Arc<OnceLock<Arc<Grid>>>, wanted: u32, bytes: u64 },
    /// Made before, and not kept.
    NotKept,
}

/// What a tile finds.
pub(super) enum Lookup {
    /// Fill it (or take what another tile filled in).
    Shared(Arc<OnceLock<Arc<Grid>>>),
    /// Make it for this tile alone; the flag says whether it was made before.
    Alone {
        /// Made before.
        again: bool,
    },
}

impl GridCache {
    pub fn new(budget: u64) -> Self {
        let shards = (0..SHARDS).map(|_| Mutex::default()).collect();
        GridCache { shards, used: AtomicU64::new(0), budget }
    }

    /// Asks for the grid of about `bytes` that `num_tiles` tiles will ask for.
    pub fn look_up(&self, key: &GridKey, num_tiles: u32, bytes: u64) -> Lookup {
        if num_tiles <= 1 {
            return Lookup::Alone { again: false };
        }
        let shard = (key.patch as usize).wrapping_mul(31).wrapping_add(key.path as usize) % SHARDS;
        let mut kept = self.shards[shard].lock().unwrap_or_else(PoisonError::into_inner);
        match kept.entry(*key) {
            Entry::Vacant(place) => {
                if self.used.fetch_add(bytes, Ordering::Relaxed) + bytes > self.budget {
                    self.used.fetch_sub(bytes, Ordering::Relaxed);
                    place.insert(Kept::NotKept);
                    return Lookup::Alone { again: false };
                }
                let grid = Arc::new(OnceLock::new());
                place.insert(Kept::Here { grid: Arc::clone(&grid), wanted: num_tiles - 1, bytes });
                Lookup::Shared(grid)
            }
            Entry::Occupied(mut place) => match place.get_mut() {
                Kept::NotKept => Lookup::Alone { again: true },
                Kept::Here { grid, wanted, bytes } => {
                    let grid = Arc::clone(grid);
                    let bytes = *bytes;
                    *wanted = wanted.saturating_sub(1);
                    if *wanted == 0 {
                        // A tile that is drawn in several passes asks again: it makes the grid anew then.
                        place.insert(Kept::NotKept);
                        self.used.fetch_sub(bytes, Ordering::Relaxed);
                    }
                    Lookup::Shared(grid)
                }
            },
        }
    }
}
