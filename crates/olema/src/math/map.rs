//! Maps whose keys are mixed fast.
//!
//! In: keys made of words. Out: maps as std has them, whose answers do not depend on the hash. What withstands keys that
//! somebody chose to collide took half of a look-up; here every word goes through a product of 128 bits, both halves of
//! which count (as in wyhash, W. Yi), from a seed that is drawn for each map: keys that collide for one do not for another.

use std::collections::HashMap;
use std::hash::{BuildHasher, Hasher, RandomState};

/// A map with such keys.
pub type Map<K, V> = HashMap<K, V, Mixing>;

/// Makes hashers that start with the same seed.
#[derive(Debug, Clone, Copy)]
pub struct Mixing(u64);

impl Default for Mixing {
    fn default() -> Self {
        Mixing(RandomState::new().hash_one(0u32))
    }
}

impl BuildHasher for Mixing {
    type Hasher = Mix;

    fn build_hasher(&self) -> Mix {
        Mix(self.0)
    }
}

/// Mixes words.
#[derive(Debug, Clone, Copy)]
pub struct Mix(u64);

impl Hasher for Mix {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks::<8>();
        words.iter().for_each(|&word| self.write_u64(u64::from_le_bytes(word)));
        if !rest.is_empty() {
            let mut word = [0; 8];
            word[..rest.len()].copy_from_slice(rest);
            self.write_u64(u64::from_le_bytes(word));
        }
    }

    fn write_u32(&mut self, word: u32) {
        self.write_u64(word.into());
    }

    fn write_u64(&mut self, word: u64) {
        let product = u128::from(self.0 ^ word) * 0x9e37_79b9_7f4a_7c15;
        self.0 = (product as u64 ^ (product >> 64) as u64).wrapping_add(0x2545_f491_4f6c_dd1d);
    }

    fn write_u128(&mut self, word: u128) {
        self.write_u64(word as u64);
        self.write_u64((word >> 64) as u64);
    }

    fn write_usize(&mut self, word: usize) {
        self.write_u64(word as u64);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbouring_keys_are_spread_over_buckets() {
        let mixing = Mixing::default();
        let mut low = vec![0u32; 1 << 12];
        let mut high = vec![0u32; 1 << 7];
        for key in 0..1u32 << 14 {
            let hash = mixing.hash_one([key % 128, key / 128, 0]);
            low[hash as usize % (1 << 12)] += 1;
            high[(hash >> 57) as usize] += 1;
        }
        // Four a bucket and 128 a tag are expected.
        assert!(low.iter().all(|&num| num < 20), "{:?}", low.iter().max());
        assert!(high.iter().all(|&num| (64..256).contains(&num)), "{high:?}");
    }

    #[test]
    fn maps_differ_in_their_seeds() {
        let hashes: Vec<u64> = (0..8).map(|_| Mixing::default().hash_one(7u32)).collect();
        assert!(hashes.iter().any(|&hash| hash != hashes[0]));
    }
}
