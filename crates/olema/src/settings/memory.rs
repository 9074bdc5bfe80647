//! One budget of memory, divided.
//!
//! In: bytes. Out: a limit for each that takes much of it, in [`Settings`] and for readers.
//!
//! | share | of | beyond it |
//! |---|---|---|
//! | 8/16 | what a reader holds of a scene | the scene is refused |
//! | 4/16 | the finished picture | the picture is refused |
//! | 3/16 | grids kept between tiles | grids are made again |
//! | 1/16 | transparent records of all workers | tiles are sampled again, nearest layers first |
//!
//! Not in it, so far: patches and edges, the pieces that are filed by tile, the buffers of the workers.

use crate::sampling::TransparentRecord;

use super::Settings;

/// Fewest records a worker gets: with less every tile would take many passes, for some kilobytes.
const LEAST_RECORDS: u64 = 1024;

/// Limits in bytes, which together are a budget.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Memory {
    /// What a reader may hold of a scene.
    pub reader: u64,
    /// The finished picture.
    pub picture: u64,
    /// Grids kept between tiles.
    pub grids: u64,
    /// Transparent records of all workers.
    pub transparency: u64,
}

impl Memory {
    /// The shares of a budget.
    pub fn divide(budget: u64) -> Self {
        let share = |parts: u64| budget / 16 * parts;
        Memory { reader: share(8), picture: share(4), grids: share(3), transparency: share(1) }
    }

    /// Puts the limits into settings; `workers` is the number of threads that will work.
    pub fn limit(&self, settings: &mut Settings, workers: usize) {
        // A vector that grows has twice the room that it needs.
        let a_record = 2 * size_of::<TransparentRecord>() as u64;
        let records = (self.transparency / workers.max(1) as u64 / a_record).max(LEAST_RECORDS);
        settings.picture_memory = self.picture;
        settings.grid_cache = self.grids;
        settings.transparency_records = usize::try_from(records).unwrap_or(usize::MAX);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_within_the_budget() {
        for budget in [0, 15, 1 << 20, (1 << 30) + 7, u64::MAX] {
            let Memory { reader, picture, grids, transparency } = Memory::divide(budget);
            assert!(reader.checked_add(picture + grids + transparency).expect("no overflow") <= budget);
        }
    }

    #[test]
    fn workers_share_the_records() {
        let of = |budget, workers| {
            let mut settings = Settings::default();
            Memory::divide(budget).limit(&mut settings, workers);
            (settings.grid_cache, settings.transparency_records as u64)
        };
        let (grids, records) = of(1 << 30, 4);
        assert_eq!(grids, 192 << 20);
        assert!(4 * records * size_of::<TransparentRecord>() as u64 <= 64 << 20 && records > 200_000);
        assert_eq!(of(0, 4), (0, LEAST_RECORDS));
    }
}
