//! Elementary functions in `f64`, for what is set up once: matrices, light cones, filter windows, figures.
//!
//! In and out: doubles. Only + - * /, comparisons and bit operations, so the bits are the same on every
//! machine. Errors over the whole range (measured, and held by tests): `sin64`, `cos64`, `exp64`, `ln64` and
//! `pow64` below 1 unit in the last place.

use super::reduce::{ROUND, reduce};

const LN_2_HI: f64 = 0.693_147_180_559_890_3; // 42 bits: exact times any exponent
const LN_2_LO: f64 = 5.497_923_018_708_371e-14;

/// `a * b` and what rounding took off it, exactly (Dekker 1971); |a| and |b| below 2^990.
pub(super) fn two_prod(a: f64, b: f64) -> (f64, f64) {
    let halves = |v: f64| {
        let c = v * 134_217_729.0; // 2^27 + 1
        let high = c - (c - v);
        (high, v - high)
    };
    let (ah, al) = halves(a);
    let (bh, bl) = halves(b);
    let p = a * b;
    (p, ((ah * bh - p) + ah * bl + al * bh) + al * bl)
}

/// `a + b` and what rounding took off it, exactly, for |a| >= |b| or a = 0.
fn two_sum_sorted(a: f64, b: f64) -> (f64, f64) {
    let s = a + b;
    (s, b - (s - a))
}

/// `a + b` and what rounding took off it, exactly (Knuth).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let s = a + b;
    let back = s - a;
    (s, (a - (s - back)) + (b - back))
}

/// Polynomial, coefficients from the highest power (Horner).
#[inline(always)]
fn poly<const N: usize>(x: f64, coefficients: [f64; N]) -> f64 {
    coefficients.into_iter().fold(0.0, |sum, c| sum * x + c)
}

/// Sine of `hi + lo` in [-pi/4, pi/4].
fn sin_rest(hi: f64, lo: f64) -> f64 {
    let z = hi * hi;
    let p = poly(
        z,
        [
            1.0 / 355_687_428_096_000.0,
            -1.0 / 1_307_674_368_000.0,
            1.0 / 6_227_020_800.0,
            -1.0 / 39_916_800.0,
            1.0 / 362_880.0,
            -1.0 / 5_040.0,
            1.0 / 120.0,
            -1.0 / 6.0,
        ],
    );
    hi + (z * hi * p + lo * (1.0 - 0.5 * z))
}

/// Cosine of `hi + lo` in [-pi/4, pi/4].
fn cos_rest(hi: f64, lo: f64) -> f64 {
    let z = hi * hi;
    let p = poly(
        z,
        [
            1.0 / 20_922_789_888_000.0,
            -1.0 / 87_178_291_200.0,
            1.0 / 479_001_600.0,
            -1.0 / 3_628_800.0,
            1.0 / 40_320.0,
            -1.0 / 720.0,
            1.0 / 24.0,
        ],
    );
    let half = 0.5 * z;
    let w = 1.0 - half;
    w + (((1.0 - w) - half) + (z * z * p - hi * lo))
}

/// Sine or cosine, by the quadrant: `turn` 0 gives the sine, 1 the cosine.
fn circular(x: f64, turn: u32) -> f64 {
    if !x.is_finite() {
        return f64::NAN;
    }
    let r = reduce(x);
    let q = r.quadrant + turn;
    let value = if q & 1 == 0 { sin_rest(r.hi, r.lo) } else { cos_rest(r.hi, r.lo) };
    if q & 2 == 0 { value } else { -value }
}

/// Sine of an angle in radians.
pub fn sin64(x: f64) -> f64 {
    // Below 2^-27 the angle is the nearest double to its sine; also keeps -0.
    if x.abs() < 7.450_580_596_923_828e-9 { x } else { circular(x, 0) }
}

/// Cosine of an angle in radians.
pub fn cos64(x: f64) -> f64 {
    circular(x, 1)
}

/// e^(x + tail) for a tail that is small beside x.
fn exp_sum(x: f64, tail: f64) -> f64 {
    if x.is_nan() {
        return x;
    }
    if x > 710.0 {
        return f64::INFINITY;
    }
    if x < -746.0 {
        return 0.0;
    }
    let biased = x * std::f64::consts::LOG2_E + ROUND;
    let n = biased - ROUND;
    let (r, err) = two_sum(x - n * LN_2_HI, tail - n * LN_2_LO);
    let p = poly(
        r,
        [
            1.0 / 6_227_020_800.0,
            1.0 / 479_001_600.0,
            1.0 / 39_916_800.0,
            1.0 / 3_628_800.0,
            1.0 / 362_880.0,
            1.0 / 40_320.0,
            1.0 / 5_040.0,
            1.0 / 720.0,
            1.0 / 120.0,
            1.0 / 24.0,
            1.0 / 6.0,
            0.5,
        ],
    );
    let value = 1.0 + (r + (err * (1.0 + r) + r * r * p));
    // Two steps, so that results below the smallest normal number round once more but never underflow early.
    let n = biased.to_bits() as i32;
    let power = |k: i32| f64::from_bits(((k + 1023) as u64) << 52);
    value * power(n / 2) * power(n - n / 2)
}

/// e^x.
pub fn exp64(x: f64) -> f64 {
    exp_sum(x, 0.0)
}

/// Natural logarithm of a positive finite number as an unevaluated sum, good to about 2^-63 of its size.
fn ln_sum(x: f64) -> (f64, f64) {
    let tiny = x < f64::MIN_POSITIVE;
    let scaled = if tiny { x * 18_014_398_509_481_984.0 } else { x };
    // m in [sqrt(1/2), sqrt(2)), x = m 2^k.
    let bits = scaled.to_bits();
    let shifted = bits.wrapping_sub(0x3fe6_a09e_667f_3bcd);
    let k = (shifted as i64 >> 52) - if tiny { 54 } else { 0 };
    let m = f64::from_bits(bits.wrapping_sub(shifted & 0xfff0_0000_0000_0000));

    // ln m = 2 atanh(s), s = (m - 1) / (m + 1), as a double and its rest.
    let f = m - 1.0;
    let (d, d_rest) = if m > 1.0 { two_sum_sorted(m, 1.0) } else { two_sum_sorted(1.0, m) };
    let s = f / d;
    let (p, p_rest) = two_prod(s, d);
    let s_rest = ((f - p) - p_rest - s * d_rest) / d;

    // 2 s (1 + w), w = s^2/3 + s^4/5 + ..., the first term of w to double length.
    let (z, z_rest) = two_prod(s, s);
    let z_rest = z_rest + 2.0 * s * s_rest;
    let tail = poly(
        z,
        [
            1.0 / 23.0,
            1.0 / 21.0,
            1.0 / 19.0,
            1.0 / 17.0,
            1.0 / 15.0,
            1.0 / 13.0,
            1.0 / 11.0,
            1.0 / 9.0,
            1.0 / 7.0,
            1.0 / 5.0,
            0.0,
        ],
    );
    let (third, third_rest) = two_sum_sorted(1.0 / 3.0, tail);
    let (w, w_rest) = two_prod(z, third);
    let w_rest = w_rest + z * (third_rest + 1.850371707708594e-17) + z_rest * third;
    let (sw, sw_rest) = two_prod(s, w);
    let (a, a_rest) = two_sum_sorted(s, sw);
    let a_rest = a_rest + sw_rest + s * w_rest + s_rest * (1.0 + w);

    let kf = k as f64;
    let (sum, sum_rest) = if k == 0 { (2.0 * a, 0.0) } else { two_sum_sorted(kf * LN_2_HI, 2.0 * a) };
    two_sum_sorted(sum, sum_rest + (2.0 * a_rest + kf * LN_2_LO))
}

/// Natural logarithm; -inf at 0, NaN below.
pub fn ln64(x: f64) -> f64 {
    if x.is_nan() || x < 0.0 {
        f64::NAN
    } else if x == 0.0 {
        f64::NEG_INFINITY
    } else if x == f64::INFINITY {
        x
    } else {
        ln_sum(x).0
    }
}

/// x^y, with std's answers for 0, 1, infinities, NaN and negative x.
pub fn pow64(x: f64, y: f64) -> f64 {
    if y == 0.0 || x == 1.0 {
        return 1.0;
    }
    if x.is_nan() || y.is_nan() {
        return f64::NAN;
    }
    // Doubles from 2^53 on are even integers.
    let whole = y.abs() >= 9_007_199_254_740_992.0 || (y as i64) as f64 == y;
    let odd = y.abs() < 9_007_199_254_740_992.0 && whole && (y as i64) & 1 == 1;
    let size = pow_of_size(x.abs(), y);
    if x.is_sign_negative() {
        if odd {
            return -size;
        }
        if !whole && x != 0.0 && x.is_finite() {
            return f64::NAN;
        }
    }
    size
}

/// x^y for x >= 0, y not 0, neither NaN.
fn pow_of_size(x: f64, y: f64) -> f64 {
    if x == 0.0 || x == f64::INFINITY {
        return if (x == 0.0) == (y > 0.0) { 0.0 } else { f64::INFINITY };
    }
    if x == 1.0 {
        return 1.0;
    }
    let (hi, lo) = ln_sum(x);
    let rough = hi * y;
    if rough > 720.0 {
        return f64::INFINITY;
    }
    if rough < -760.0 {
        return 0.0;
    }
    let (p, p_rest) = two_prod(hi, y);
    exp_sum(p, p_rest + lo * y)
}
