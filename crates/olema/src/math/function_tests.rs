//! Elementary functions against std's, which are good to about one unit in the last place (ulp) in double:
//! an almost exact yardstick for floats, and for doubles one that the bounds allow for.

use super::super::hash::hash_all;
use super::*;

/// Distance of `found` from the real number `wanted` in units in the last place of a float there.
fn ulps(found: f32, wanted: f64) -> f64 {
    let nearest = wanted as f32;
    if found.is_nan() || nearest.is_nan() {
        return if found.is_nan() && nearest.is_nan() { 0.0 } else { f64::INFINITY };
    }
    if found == nearest {
        return 0.0;
    }
    if found.is_infinite() || nearest.is_infinite() {
        return f64::INFINITY;
    }
    let size = nearest.abs();
    let step = f64::from(f32::from_bits(size.to_bits() + 1)) - f64::from(size);
    (f64::from(found) - wanted).abs() / step
}

/// As [`ulps`] for doubles, against std's double.
fn ulps64(found: f64, wanted: f64) -> f64 {
    if found == wanted || found.is_nan() && wanted.is_nan() {
        return 0.0;
    }
    if !found.is_finite() || !wanted.is_finite() {
        return f64::INFINITY;
    }
    (found - wanted).abs() / (f64::from_bits(wanted.abs().to_bits() + 1) - wanted.abs())
}

const BOUND: f64 = 0.51;
const BOUND_64: f64 = 2.0;

fn check(name: &str, x: f32, found: f32, wanted: f64) {
    let error = ulps(found, wanted);
    assert!(error <= BOUND, "{name}({x:e}) = {found:e}, not {wanted:e}: {error} ulp");
}

fn check_all(x: f32) {
    let wide = f64::from(x);
    check("sin", x, sin(x), wide.sin());
    check("cos", x, cos(x), wide.cos());
    check("tan", x, tan(x), wide.tan());
    check("exp", x, exp(x), wide.exp());
    check("exp2", x, exp2(x), wide.exp2());
    check("ln", x, ln(x), wide.ln());
    check("log2", x, log2(x), wide.log2());
}

#[test]
fn floats_of_every_size_are_within_the_bound() {
    // A prime stride visits every exponent, both signs, the numbers below normal, infinities and NaNs.
    for bits in (0..=u32::MAX).step_by(2_003) {
        check_all(f32::from_bits(bits));
    }
}

#[test]
fn floats_in_the_common_range_are_within_the_bound() {
    for n in -200_000..200_000 {
        check_all(n as f32 * 5.0e-4);
        check_all(1.0 + n as f32 * (1.0 / 16_777_216.0));
    }
}

#[test]
#[ignore = "all 2^32 floats: minutes"]
fn every_float_is_within_the_bound() {
    for bits in 0..=u32::MAX {
        check_all(f32::from_bits(bits));
    }
}

#[test]
fn multiples_of_a_quarter_turn_reduce_well() {
    for n in 1..200_000u32 {
        let x = (f64::from(n) * std::f64::consts::FRAC_PI_2) as f32;
        for x in [x, -x, f32::from_bits(x.to_bits() + 1), f32::from_bits(x.to_bits() - 1)] {
            check_all(x);
        }
    }
}

#[test]
fn powers_are_within_the_bound() {
    for n in 0..2_000_000u32 {
        let (a, b) = (hash_all([n, 1]), hash_all([n, 2]));
        // Bases near 1 and of any size, exponents that keep the result in range and any at all.
        let x = match n % 3 {
            0 => f32::from_bits(a & 0x7fff_ffff),
            1 => 0.5 + (a >> 8) as f32 / 16_777_216.0,
            _ => f32::from_bits(0x3f80_0000 ^ (a & 0x3ff)),
        };
        let y = if n % 2 == 0 {
            f32::from_bits(b)
        } else {
            (b as f32 / 4.0e9 - 0.5) * 300.0 / f64::from(x).log2() as f32
        };
        let wanted = f64::from(x).powf(f64::from(y));
        let error = ulps(pow(x, y), wanted);
        assert!(error <= BOUND, "pow({x:e}, {y:e}) = {:e}, not {wanted:e}: {error} ulp", pow(x, y));
    }
}

#[test]
fn edges_answer_as_std_does() {
    let special = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        2.0,
        -2.0,
        0.5,
        -0.5,
        3.0,
        -3.0,
        2.5,
        16_777_215.0,
        16_777_216.0,
        -16_777_217.0,
        1e-45,
        -1e-45,
        f32::MAX,
        f32::MIN,
        f32::MIN_POSITIVE,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
    ];
    let same = |a: f32, b: f32| a.is_nan() && b.is_nan() || a.to_bits() == b.to_bits();
    let same64 = |a: f64, b: f64| ulps64(a, b) <= BOUND_64 && (a.is_nan() || a.signum() == b.signum());
    for x in special {
        for y in special {
            let wanted = x.powf(y);
            assert!(same(pow(x, y), wanted), "pow({x:e}, {y:e}) = {:e}, not {wanted:e}", pow(x, y));
            let wanted = f64::from(x).powf(f64::from(y));
            let found = pow64(x.into(), y.into());
            assert!(same64(found, wanted), "pow64({x:e}, {y:e}) = {found:e}, not {wanted:e}");
        }
        let wide = f64::from(x);
        assert!(same64(sin64(wide), wide.sin()) && same64(cos64(wide), wide.cos()), "{x:e}");
        assert!(same64(exp64(wide), wide.exp()) && same64(ln64(wide), wide.ln()), "{x:e}");
    }
    assert!(sin(-0.0).is_sign_negative() && tan(-0.0).is_sign_negative());
    assert_eq!((exp(0.0), exp2(10.0), log2(1024.0), ln(1.0), cos(0.0)), (1.0, 1024.0, 10.0, 0.0, 1.0));
}

#[test]
fn doubles_are_within_the_bound() {
    let wide = |n: u32, salt: u32| u64::from(hash_all([n, salt])) << 32 | u64::from(hash_all([n, salt, 1]));
    for n in 0..400_000 {
        let any = f64::from_bits(wide(n, 3));
        let unit = wide(n, 4) as f64 / u64::MAX as f64;
        for x in [any, unit, unit * 100.0, 0.9 + unit * 0.2, (unit - 0.5) * 1_480.0, unit * 1e7] {
            for (name, found, wanted) in [
                ("sin", sin64(x), x.sin()),
                ("cos", cos64(x), x.cos()),
                ("exp", exp64(x), x.exp()),
                ("ln", ln64(x), x.ln()),
            ] {
                let error = ulps64(found, wanted);
                assert!(error <= BOUND_64, "{name}({x:e}) = {found:e}, not {wanted:e}: {error} ulp");
            }
        }
        let y = (wide(n, 5) as f64 / u64::MAX as f64 - 0.5) * 1_400.0 / any.abs().ln();
        let error = ulps64(pow64(any.abs(), y), any.abs().powf(y));
        assert!(error <= BOUND_64, "pow({:e}, {y:e}): {error} ulp", any.abs());
    }
}

#[test]
fn the_ruler_itself_finds_a_wrong_digit() {
    // Without this, a ruler that always says 0 would pass everything above.
    assert!(ulps(f32::from_bits(1.0f32.to_bits() + 1), 1.0) >= 1.0);
    assert!(ulps(1.0, 1.0 + 0.75 * f64::from(f32::EPSILON)) > BOUND);
    assert!(ulps64(f64::from_bits(1.0f64.to_bits() + 3), 1.0) > BOUND_64);
}
