//! Sines and cosines of fractions of a turn, by polynomials: the same bits on every machine.

use std::f64::consts::PI;

/// (cos, sin) of the angle `numerator / denominator` of a half turn; `denominator` at least 1.
///
/// The angle is reduced in whole numbers, so the error stays near 1e-16 for any numerator.
pub(super) fn half_turn_fraction(numerator: i64, denominator: i64) -> (f64, f64) {
    if denominator <= MOST_KNOWN as i64 {
        return KNOWN[denominator as usize][numerator.rem_euclid(2 * denominator) as usize];
    }
    computed(numerator, denominator)
}

/// Larger denominators, which only vertices of more faces ask for, are computed when they are asked for.
const MOST_KNOWN: usize = 8;

/// By denominator and numerator. Limit masks ask for some dozens a point, and polynomials are ten divisions each.
static KNOWN: [[(f64, f64); 2 * MOST_KNOWN]; MOST_KNOWN + 1] = {
    let mut known = [[(0.0, 0.0); 2 * MOST_KNOWN]; MOST_KNOWN + 1];
    let mut denominator = 1;
    while denominator <= MOST_KNOWN {
        let mut numerator = 0;
        while numerator < 2 * denominator {
            known[denominator][numerator] = computed(numerator as i64, denominator as i64);
            numerator += 1;
        }
        denominator += 1;
    }
    known
};

const fn computed(numerator: i64, denominator: i64) -> (f64, f64) {
    let numerator = numerator.rem_euclid(2 * denominator);
    // Quarters of a turn, and a rest of at most half of one to either side.
    let quarters = (4 * numerator + denominator) / (2 * denominator);
    let rest = (2 * numerator - quarters * denominator) as f64 / (2 * denominator) as f64;
    let (c, s) = cos_sin_small(rest * PI);
    match quarters % 4 {
        0 => (c, s),
        1 => (-s, c),
        2 => (-c, -s),
        _ => (s, -c),
    }
}

/// Taylor polynomials, exact to rounding for |x| <= pi / 4.
const fn cos_sin_small(x: f64) -> (f64, f64) {
    let x2 = x * x;
    let (mut c, mut s) = (1.0, 1.0);
    let mut k = 10;
    while k > 0 {
        let even = (2 * k) as f64;
        c = 1.0 - x2 / (even * (even - 1.0)) * c;
        s = 1.0 - x2 / (even * (even + 1.0)) * s;
        k -= 1;
    }
    (c, x * s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_known_is_what_would_be_computed() {
        for d in 1..=MOST_KNOWN as i64 {
            for n in -40..40 {
                assert_eq!(half_turn_fraction(n, d), computed(n, d), "{n}/{d}");
            }
        }
    }

    #[test]
    fn agrees_with_the_standard_functions() {
        for d in 1..60 {
            for n in -130..130 {
                let (c, s) = half_turn_fraction(n, d);
                let angle = PI * n as f64 / d as f64;
                // The standard functions get a rounded angle.
                let tolerance = 1e-15 + 4e-16 * angle.abs();
                let error = (c - angle.cos()).abs().max((s - angle.sin()).abs());
                assert!(error < tolerance, "{n}/{d}: {error}");
            }
        }
    }
}
