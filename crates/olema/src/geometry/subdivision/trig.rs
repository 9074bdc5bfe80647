//! Sines and cosines of fractions of a turn, by polynomials: the same bits on every machine.

use std::f64::consts::PI;

/// (cos, sin) of the angle `numerator / denominator` of a half turn; `denominator` at least 1.
///
/// The angle is reduced in whole numbers, so the error stays near 1e-16 for any numerator.
pub(super) fn half_turn_fraction(numerator: i64, denominator: i64) -> (f64, f64) {
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
fn cos_sin_small(x: f64) -> (f64, f64) {
    let x2 = x * x;
    let (mut c, mut s) = (1.0, 1.0);
    for k in (1..=10).rev() {
        let even = (2 * k) as f64;
        c = 1.0 - x2 / (even * (even - 1.0)) * c;
        s = 1.0 - x2 / (even * (even + 1.0)) * s;
    }
    (c, x * s)
}

#[cfg(test)]
mod tests {
    use super::*;

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
