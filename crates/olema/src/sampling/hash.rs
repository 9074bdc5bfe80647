//! Hashes and computed permutations: the only source of chance in the sample pattern.
//!
//! In: integers (seed, tile, stratum, set). Out: integers that look random, the same on every machine.
//! Sources: the integer finaliser is C. Wellons' `lowbias32` (hash-prospector, public domain); permutations
//! that are computed instead of stored follow Kensler, "Correlated Multi-Jittered Sampling", 2013, with steps
//! that can be undone.

/// A bijection of the 32 bit integers whose output bits depend on every input bit.
#[inline]
pub fn mix(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// Hash of a list of words; the order matters.
#[inline]
pub fn hash(words: &[u32]) -> u32 {
    words.iter().fold(0x9e37_79b9, |h, &w| mix(h.wrapping_mul(0x85eb_ca6b) ^ mix(w ^ 0x5bd1_e995)))
}

/// The hash as a number in [0, 1), a multiple of 2^-32.
#[inline]
pub fn unit(hash: u32) -> f64 {
    f64::from(hash) * (1.0 / 4_294_967_296.0)
}

/// A stream of random words: the hash of a seed and a counter.
#[derive(Debug, Clone)]
pub struct Stream {
    seed: u32,
    count: u32,
}

impl Stream {
    /// The stream of `seed`.
    pub fn new(seed: u32) -> Self {
        Stream { seed: mix(seed ^ 0x2545_f491), count: 0 }
    }

    /// The next word.
    #[inline]
    pub fn next_word(&mut self) -> u32 {
        self.count = self.count.wrapping_add(1);
        mix(self.seed ^ mix(self.count))
    }

    /// The next number in [0, 1).
    #[inline]
    pub fn next_unit(&mut self) -> f64 {
        unit(self.next_word())
    }

    /// The next integer in 0..n, n at least 1.
    #[inline]
    pub fn below(&mut self, n: u32) -> u32 {
        ((u64::from(self.next_word()) * u64::from(n)) >> 32) as u32
    }
}

/// A permutation of `0..n` chosen by a key, computed element by element in both directions.
///
/// Rounds of (add, multiply by an odd number, xor with some of the upper half's bits) permute the next power
/// of two; elements that land at or beyond `n` are sent round again until they land below it. Which bits are
/// xored depends on the key: with all of them, some of the 24 permutations of 4 were a quarter too rare.
#[derive(Debug, Clone, Copy)]
pub struct Permutation {
    n: u32,
    mask: u32,
    shift: u32,
    adds: [u32; Self::ROUNDS],
    odds: [u32; Self::ROUNDS],
    xors: [u32; Self::ROUNDS],
}

impl Permutation {
    const ROUNDS: usize = 4;

    /// The permutation of `0..n` for `key`; `n` is 1 to 2^16.
    pub fn new(n: u32, key: u32) -> Self {
        debug_assert!((1..=1 << 16).contains(&n), "permutation of {n} elements");
        let bits = 32 - (n - 1).leading_zeros();
        let mut adds = [0; Self::ROUNDS];
        let mut odds = [1; Self::ROUNDS];
        let mut xors = [0; Self::ROUNDS];
        for round in 0..Self::ROUNDS {
            let word = mix(key.wrapping_add((round as u32).wrapping_mul(0x9e37_79b9)));
            adds[round] = word >> 16;
            odds[round] = (word & 0xffff) | 1;
            xors[round] = mix(!word);
        }
        // Twice the shift reaches all bits, so the xor is its own inverse.
        Permutation { n, mask: (1 << bits) - 1, shift: bits.div_ceil(2), adds, odds, xors }
    }

    /// Where `i` goes; `i` is in `0..n`.
    #[inline]
    pub fn forward(&self, i: u32) -> u32 {
        let mut x = i;
        loop {
            for round in 0..Self::ROUNDS {
                x = x.wrapping_add(self.adds[round]).wrapping_mul(self.odds[round]) & self.mask;
                x ^= (x >> self.shift) & self.xors[round];
            }
            if x < self.n {
                return x;
            }
        }
    }

    /// What goes to `i`; `i` is in `0..n`.
    #[inline]
    pub fn inverse(&self, i: u32) -> u32 {
        let mut x = i;
        loop {
            for round in (0..Self::ROUNDS).rev() {
                x ^= (x >> self.shift) & self.xors[round];
                x = x.wrapping_mul(inverse_of_odd(self.odds[round])).wrapping_sub(self.adds[round])
                    & self.mask;
            }
            if x < self.n {
                return x;
            }
        }
    }
}

/// The number whose product with `odd` is 1 modulo 2^32, by Newton's iteration (5 -> 10 -> 20 -> 40 bits).
#[inline]
fn inverse_of_odd(odd: u32) -> u32 {
    let mut inverse = odd.wrapping_mul(3) ^ 2;
    for _ in 0..3 {
        inverse = inverse.wrapping_mul(2u32.wrapping_sub(odd.wrapping_mul(inverse)));
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    #[test]
    fn permutations_are_bijections_and_undo_themselves() {
        for n in (1..=70).chain([81, 255, 256, 257, 4095, 4096, 65_536]) {
            for key in 0..8 {
                let permutation = Permutation::new(n, mix(key));
                let mut seen = vec![false; n as usize];
                for i in 0..n {
                    let to = permutation.forward(i);
                    assert!(!std::mem::replace(&mut seen[to as usize], true), "n {n} key {key}: {to} twice");
                    assert_eq!(permutation.inverse(to), i, "n {n} key {key}");
                }
            }
        }
    }

    #[test]
    fn all_24_permutations_of_four_are_about_as_frequent() {
        let mut counts: HashMap<[u32; 4], u32> = HashMap::new();
        let num_keys = 24_000;
        for key in 0..num_keys {
            let permutation = Permutation::new(4, hash(&[key, 17]));
            *counts.entry([0, 1, 2, 3].map(|i| permutation.forward(i))).or_default() += 1;
        }
        assert_eq!(counts.len(), 24);
        let expected = f64::from(num_keys) / 24.0;
        for (order, count) in counts {
            assert!((f64::from(count) - expected).abs() < 0.25 * expected, "{order:?}: {count}");
        }
    }

    #[test]
    fn every_pixel_of_an_odd_tile_gets_every_rank_about_as_often() {
        for n in [9u32, 16, 64] {
            let num_keys = 2000 * n;
            let mut counts = vec![0u32; (n * n) as usize];
            for key in 0..num_keys {
                let permutation = Permutation::new(n, hash(&[key, n]));
                for i in 0..n {
                    counts[(i * n + permutation.forward(i)) as usize] += 1;
                }
            }
            for count in counts {
                assert!((f64::from(count) - 2000.0).abs() < 300.0, "n {n}: {count}");
            }
        }
    }

    #[test]
    fn neighbouring_words_have_unrelated_hashes() {
        let flips: u32 = (0..4096u32).map(|i| (hash(&[i, 3]) ^ hash(&[i + 1, 3])).count_ones()).sum();
        let mean = f64::from(flips) / 4096.0;
        assert!((mean - 16.0).abs() < 0.2, "{mean} bits change");
    }
}
