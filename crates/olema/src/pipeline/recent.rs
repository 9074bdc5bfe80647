//! Recent: what was found out lately, for a worker that will ask again.
//!
//! In: keys and values. Out: the value of a key, if no other took its place. Blurred pieces are in many tiles, each of
//! which cuts them anew; the next tile mostly asks for what this one did.

use std::hash::{BuildHasher, Hash};

use crate::math::map::Mixing;

/// Values by the hashes of their keys, one a hash.
#[derive(Debug, Default)]
pub struct Recent<K, V> {
    /// A power of two of them, or none.
    slots: Vec<Option<(K, V)>>,
    mixing: Mixing,
}

impl<K: Hash + Eq, V> Recent<K, V> {
    /// Room for 2^`log` values.
    pub fn new(log: u32) -> Self {
        Recent { slots: (0..1usize << log).map(|_| None).collect(), mixing: Mixing::default() }
    }

    fn slot(&self, key: &K) -> usize {
        // The upper half of a hash is mixed best.
        (self.mixing.hash_one(key) >> 32) as usize & (self.slots.len() - 1)
    }

    /// The value of a key.
    pub fn get(&self, key: &K) -> Option<&V> {
        if self.slots.is_empty() {
            return None;
        }
        let (known, value) = self.slots[self.slot(key)].as_ref()?;
        (known == key).then_some(value)
    }

    /// Keeps a value, if there is room for any.
    pub fn put(&mut self, key: K, value: V) {
        if !self.slots.is_empty() {
            let slot = self.slot(&key);
            self.slots[slot] = Some((key, value));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_of_a_slot_is_known() {
        let mut recent = Recent::new(3);
        for key in 0..100u32 {
            recent.put(key, key * key);
            assert_eq!(recent.get(&key), Some(&(key * key)));
        }
        let known: Vec<u32> = (0..100).filter(|key| recent.get(key).is_some()).collect();
        assert!(known.len() <= 8 && known.iter().all(|key| recent.get(key) == Some(&(key * key))));
    }

    #[test]
    fn without_room_nothing_is_known() {
        let mut recent = Recent::default();
        recent.put(1u32, 2);
        assert_eq!(recent.get(&1), None);
    }
}
