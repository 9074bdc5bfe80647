//! Elementary functions in `f32`, the ones that pictures are made with.
//!
//! In and out: floats. std and libm give other bits on other machines; these use only + - * /, comparisons
//! and bit operations (no fused multiply-add), so a picture is the same everywhere. They are
//! written without branches, choices by selects, so that a loop over lanes is their SIMD twin.
//!
//! They compute in double with polynomials just long enough and round once, which needs no split constants,
//! takes results below the normal range in its stride and leaves at most 0.51 units in the last place of
//! error for every argument (held by `tests.rs`). Not-a-number, infinities, zeros and negative bases answer
//! as std's do.

use super::reduce::{HALF_PI_1, HALF_PI_REST, MEDIUM, ROUND, reduce};

pub use super::function64::{cos64, exp64, ln64, pow64, sin64};

/// Polynomial, coefficients from the highest power: even and odd powers side by side, half the latency of
/// Horner's rule.
#[inline(always)]
fn poly<const N: usize>(x: f64, coefficients: [f64; N]) -> f64 {
    let square = x * x;
    let (mut same, mut other) = (coefficients[0], coefficients[1]);
    for ix in (2..N).step_by(2) {
        same = same * square + coefficients[ix];
        if ix + 1 < N {
            other = other * square + coefficients[ix + 1];
        }
    }
    // `same` holds the powers of the first coefficient's parity; the last coefficient is x^0.
    if N % 2 == 1 { other * x + same } else { same * x + other }
}

/// Sine of r in [-pi/4, pi/4]; relative error below 2^-36.
#[inline(always)]
fn sin_rest(r: f64) -> f64 {
    let z = r * r;
    let p = poly(z, [-1.0 / 39_916_800.0, 1.0 / 362_880.0, -1.0 / 5_040.0, 1.0 / 120.0, -1.0 / 6.0]);
    r + z * r * p
}

/// Cosine of r in [-pi/4, pi/4]; relative error below 2^-32.
#[inline(always)]
fn cos_rest(r: f64) -> f64 {
    let z = r * r;
    1.0 + z * poly(z, [-1.0 / 3_628_800.0, 1.0 / 40_320.0, -1.0 / 720.0, 1.0 / 24.0, -0.5])
}

/// Quadrant (only its low two bits count) and rest of an angle below [`MEDIUM`].
#[inline(always)]
fn near_quadrant(x: f64) -> (u32, f64) {
    let biased = x * std::f64::consts::FRAC_2_PI + ROUND;
    let n = biased - ROUND;
    (biased.to_bits() as u32, (x - n * HALF_PI_1) - n * HALF_PI_REST)
}

/// Quadrant and rest of a finite angle.
#[inline(always)]
fn quadrant(x: f64) -> (u32, f64) {
    if x.abs() < MEDIUM {
        near_quadrant(x)
    } else {
        let r = reduce(x);
        (r.quadrant, r.hi)
    }
}

/// Sine and cosine, in double, of a quadrant and the rest of an angle.
#[inline(always)]
fn sin_cos_rest((q, r): (u32, f64)) -> (f64, f64) {
    let (s, c) = (sin_rest(r), cos_rest(r));
    let (s, c) = if q & 1 == 0 { (s, c) } else { (c, -s) };
    if q & 2 == 0 { (s, c) } else { (-s, -c) }
}

/// Sine and cosine, in double, of an angle in radians.
#[inline(always)]
fn sin_cos_wide(x: f32) -> (f64, f64) {
    let finite = if x.is_finite() { f64::from(x) } else { 0.0 };
    let (s, c) = sin_cos_rest(quadrant(finite));
    if x.is_finite() { (s, c) } else { (f64::NAN, f64::NAN) }
}

/// Sine of an angle in radians.
#[inline]
pub fn sin(x: f32) -> f32 {
    // The reduction turns -0 into 0.
    if x == 0.0 { x } else { sin_cos_wide(x).0 as f32 }
}

/// [`sin`] of an angle below a million or not a number; without branches, so that it can go in lanes.
#[inline(always)]
pub fn sin_of_few_turns(x: f32) -> f32 {
    let sine = sin_cos_rest(near_quadrant(f64::from(x))).0 as f32;
    if x == 0.0 { x } else { sine }
}

/// Cosine of an angle in radians.
#[inline]
pub fn cos(x: f32) -> f32 {
    sin_cos_wide(x).1 as f32
}

/// Tangent of an angle in radians.
#[inline]
pub fn tan(x: f32) -> f32 {
    let (s, c) = sin_cos_wide(x);
    if x == 0.0 { x } else { (s / c) as f32 }
}

/// 2^x in double; relative error below 2^-32. Saturates at 2^-200 and 2^200, far outside the floats.
#[inline(always)]
fn exp2_wide(x: f64) -> f64 {
    let x = x.clamp(-200.0, 200.0);
    let biased = x + ROUND;
    let r = x - (biased - ROUND);
    // ln(2)^k / k!
    let p = poly(
        r,
        [
            1.321548679014431e-6,
            1.5252733804059841e-5,
            1.540353039338161e-4,
            1.3333558146428443e-3,
            9.618129107628477e-3,
            5.550410866482158e-2,
            2.402265069591007e-1,
            std::f64::consts::LN_2,
            1.0,
        ],
    );
    let power = f64::from_bits(biased.to_bits().wrapping_add(1023) << 52);
    p * power
}

/// 2^x.
#[inline]
pub fn exp2(x: f32) -> f32 {
    exp2_wide(f64::from(x)) as f32
}

/// e^x.
#[inline]
pub fn exp(x: f32) -> f32 {
    exp2_wide(f64::from(x) * std::f64::consts::LOG2_E) as f32
}

/// log2 of a positive finite double within the range of floats; relative error below 2^-44.
#[inline(always)]
fn log2_wide(x: f64) -> f64 {
    // x = m 2^k, m in [sqrt(1/2), sqrt(2)).
    let bits = x.to_bits();
    let shifted = bits.wrapping_sub(0x3fe6_a09e_667f_3bcd);
    let k = (shifted as i64 >> 52) as i32;
    let m = f64::from_bits(bits.wrapping_sub(shifted & 0xfff0_0000_0000_0000));
    // 2 / ln 2 * atanh(s), s = (m - 1) / (m + 1).
    let s = (m - 1.0) / (m + 1.0);
    let z = s * s;
    let p = poly(z, [1.0 / 15.0, 1.0 / 13.0, 1.0 / 11.0, 1.0 / 9.0, 1.0 / 7.0, 1.0 / 5.0, 1.0 / 3.0, 1.0]);
    f64::from(k) + 2.885_390_081_777_926_8 * s * p
}

/// `inside` for positive finite x; -inf at 0, inf at inf, NaN below 0 and for NaN.
#[inline(always)]
fn log_edges(x: f32, inside: f64) -> f64 {
    if x > 0.0 && x < f32::INFINITY {
        inside
    } else if x == 0.0 {
        f64::NEG_INFINITY
    } else if x == f32::INFINITY {
        f64::INFINITY
    } else {
        f64::NAN
    }
}

/// Logarithm to base 2; -inf at 0, NaN below.
#[inline(always)]
pub fn log2(x: f32) -> f32 {
    log_edges(x, log2_wide(f64::from(x))) as f32
}

/// Natural logarithm; -inf at 0, NaN below.
#[inline]
pub fn ln(x: f32) -> f32 {
    log_edges(x, log2_wide(f64::from(x)) * std::f64::consts::LN_2) as f32
}

/// x^y, with std's answers for 0, 1, infinities, NaN and negative x.
#[inline]
pub fn pow(x: f32, y: f32) -> f32 {
    pow_in_lanes(x, y)
}

/// [`pow`], always inlined, for loops over lanes.
#[inline(always)]
pub(crate) fn pow_in_lanes(x: f32, y: f32) -> f32 {
    let size = x.abs();
    let log = log_edges(size, log2_wide(f64::from(size)));
    let value = exp2_wide(f64::from(y) * log) as f32;
    // 0^inf and the like: y * log is an infinity or not a number, and clamping it answers right but for
    // |x| = 1 with y infinite, 0 * inf.
    let value = if size == 1.0 { 1.0 } else { value };
    // Floats from 2^24 on are even integers.
    let small = y.abs() < 16_777_216.0;
    let whole = !small || (y as i32) as f32 == y;
    let odd = small && whole && (y as i32) & 1 == 1;
    let negative = x.is_sign_negative();
    let value = if negative && odd { -value } else { value };
    let value = if negative && !whole && size > 0.0 && size < f32::INFINITY { f32::NAN } else { value };
    let value = if x.is_nan() || y.is_nan() { f32::NAN } else { value };
    if y == 0.0 || x == 1.0 { 1.0 } else { value }
}

#[cfg(test)]
#[path = "function_tests.rs"]
mod tests;
