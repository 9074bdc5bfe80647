//! Hashes: random numbers as pure functions of their place.
//!
//! In: 32-bit integers (a pixel, a channel, a seed). Out: 32 well-mixed bits, or a float made from them.
//! Same bits on every machine; WGSL has the same operations. Source: the output permutation of PCG (O'Neill
//! 2014) as a hash, after Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 9 (3), 2020.

/// Mixes one integer; a bijection.
#[inline(always)]
pub fn hash32(x: u32) -> u32 {
    let state = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Mixes several integers; their order counts. With all but one held fixed, a bijection of that one.
#[inline(always)]
pub fn hash_all<const N: usize>(values: [u32; N]) -> u32 {
    // The multiplication keeps (a, b) apart from (a + 1, hash-neighbour of b): plain sums of hashes collide
    // along lines.
    values.into_iter().fold(0x9e37_79b9, |h, v| hash32(h.wrapping_mul(0x85eb_ca6b) ^ v))
}

/// A float in [0, 1) from the hash's upper 24 bits; every value is exact.
#[inline(always)]
pub fn unit(hash: u32) -> f32 {
    (hash >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// A float strictly between -1 and 1, symmetric about 0 and never 0; every value is exact.
#[inline(always)]
pub fn signed_unit(hash: u32) -> f32 {
    (2 * (hash >> 8) as i32 + 1 - 16_777_216) as f32 * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values_stay() {
        // A changed hash changes pictures: these are the published constants' values.
        assert_eq!([hash32(0), hash32(1), hash32(u32::MAX)], [129_708_002, 2_831_084_092, 3_861_530_882]);
    }

    #[test]
    fn one_flipped_bit_flips_half_the_bits() {
        let mut flips = [0u64; 32];
        let rounds = 4_000u32;
        for n in 0..rounds {
            for (bit, count) in flips.iter_mut().enumerate() {
                let (a, b) = (hash_all([n, 17, 3]), hash_all([n ^ 1 << bit, 17, 3]));
                *count += u64::from((a ^ b).count_ones());
            }
        }
        for (bit, count) in flips.iter().enumerate() {
            let mean = *count as f64 / f64::from(rounds);
            assert!((15.0..17.0).contains(&mean), "bit {bit} flips {mean} bits");
        }
    }

    #[test]
    fn order_counts_and_pixels_do_not_collide_more_than_chance() {
        assert_ne!(hash_all([1, 2]), hash_all([2, 1]));
        let mut seen: Vec<u32> = (0..65_536u32).map(|n| hash_all([n % 256, n / 256])).collect();
        seen.sort_unstable();
        seen.dedup();
        // 65,536 draws of 2^32: half a collision is expected.
        assert!(seen.len() >= 65_530, "{} distinct", seen.len());
    }

    #[test]
    fn floats_keep_their_bounds() {
        assert_eq!(unit(0), 0.0);
        assert!(unit(u32::MAX) < 1.0);
        assert!(signed_unit(0) > -1.0 && signed_unit(u32::MAX) < 1.0);
        assert_eq!(signed_unit(0), -signed_unit(u32::MAX));
        let mean = (0..100_000).map(|n| f64::from(signed_unit(hash32(n)))).sum::<f64>() / 1e5;
        assert!(mean.abs() < 0.01, "mean {mean}");
    }
}
