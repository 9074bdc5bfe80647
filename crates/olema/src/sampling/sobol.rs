//! Owen-scrambled Sobol points in five dimensions.
//!
//! In: a number of points, a dimension, a seed. Out: their order in that dimension. Sources: direction numbers
//! of Joe and Kuo 2008; scrambling by hash is Burley, "Practical Hash-based Owen Scrambling", 2020.

use super::strata::ranks;

/// The order in dimension `dim` of the first `num` points of an Owen-scrambled Sobol sequence.
pub(super) fn scrambled_order(num: u32, dim: usize, seed: u32) -> Vec<u32> {
    let points = (0..num).map(|i| owen_scramble(sobol(i, dim), seed));
    if num.is_power_of_two() {
        // Then each of the `num` intervals holds one point.
        let shift = 32 - num.trailing_zeros();
        return points.map(|point| point.checked_shr(shift).unwrap_or(0)).collect();
    }
    ranks(&points.map(f64::from).collect::<Vec<_>>())
}

/// Point `i` (below 2^12) of the Sobol sequence in dimension 0 to 4, as a fraction of 2^32.
fn sobol(i: u32, dim: usize) -> u32 {
    /// Degree, inner coefficients and first direction numbers (Joe and Kuo, 2008).
    const DIRECTIONS: [(usize, u32, [u32; 3]); 5] =
        [(0, 0, [1, 1, 1]), (1, 0, [1, 1, 1]), (2, 1, [1, 3, 1]), (3, 1, [1, 3, 1]), (3, 2, [1, 1, 1])];
    let (degree, coefficients, start) = DIRECTIONS[dim];
    let mut m = [1u32; 12];
    let mut point = 0;
    for k in 0..12 {
        if degree > 0 && k < degree {
            m[k] = start[k];
        } else if degree > 0 {
            m[k] = m[k - degree] ^ (m[k - degree] << degree);
            for l in 1..degree {
                if coefficients >> (degree - 1 - l) & 1 == 1 {
                    m[k] ^= m[k - l] << l;
                }
            }
        }
        if i >> k & 1 == 1 {
            point ^= m[k] << (31 - k);
        }
    }
    point
}

/// Owen's nested scramble, by a hash in which each bit depends only on those above it.
fn owen_scramble(point: u32, seed: u32) -> u32 {
    let mut x = point.reverse_bits();
    x = x.wrapping_add(seed);
    for odd in [0x6c50_b47c, 0xb82f_1e52, 0xc7af_e638, 0x8d22_f6e6u32] {
        x ^= x.wrapping_mul(odd);
    }
    x.reverse_bits()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sobol_points_take_each_interval_of_a_power_of_two_once() {
        for dim in 0..5 {
            for bits in 0..=12 {
                let mut seen = vec![false; 1 << bits];
                for i in 0..1u32 << bits {
                    let order = owen_scramble(sobol(i, dim), 77).checked_shr(32 - bits).unwrap_or(0);
                    assert!(!std::mem::replace(&mut seen[order as usize], true), "dim {dim} of {bits} bits");
                }
            }
        }
    }

    #[test]
    fn the_first_two_sobol_dimensions_are_a_net() {
        for i in 0..16 {
            let cells = |width: u32| {
                (0..16u32)
                    .map(|i| {
                        let at = |dim| owen_scramble(sobol(i, dim), 5 + dim as u32);
                        (
                            at(0).checked_shr(32 - width).unwrap_or(0),
                            at(1).checked_shr(28 + width).unwrap_or(0),
                        )
                    })
                    .collect::<std::collections::HashSet<_>>()
                    .len()
            };
            assert_eq!(cells(i % 5), 16);
        }
    }
}
