//! Angle reduction: an angle to its quadrant and the rest within it.
//!
//! In: a finite angle in radians. Out: `quadrant` (0 to 3) and `hi + lo` in [-pi/4, pi/4] with
//! `x = (quadrant + 4 k) pi/2 + hi + lo`. Up to 2^20 quadrants by three-part subtraction (Cody and Waite
//! 1980), beyond by multiplication with the bits of 2/pi that matter (Payne and Hanek 1983).

/// Where an angle lies.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reduced {
    /// Quadrant, 0 to 3.
    pub quadrant: u32,
    /// The rest.
    pub hi: f64,
    /// What `hi` could not hold.
    pub lo: f64,
}

/// Adding and subtracting it rounds a double below 2^51 to an integer; the sum's low bits are the integer.
pub(super) const ROUND: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52

/// The integer that x is rounded down to, modulo 2^32 and as a double. x is below 2^51 either way; of anything else, any
/// number. A cast would go one lane after the other.
#[inline(always)]
pub(crate) fn floor(x: f64) -> (u32, f64) {
    let biased = x + ROUND;
    let nearest = biased - ROUND;
    let is_above = nearest > x;
    let floor = if is_above { nearest - 1.0 } else { nearest };
    ((biased.to_bits() as u32).wrapping_sub(u32::from(is_above)), floor)
}

const TWO_OVER_PI: f64 = std::f64::consts::FRAC_2_PI;
/// pi/2 in three parts, of 33 bits each but the last: products with integers up to 2^20 are exact.
pub(super) const HALF_PI_1: f64 = f64::from_bits(0x3ff9_21fb_5440_0000);
const HALF_PI_2: f64 = f64::from_bits(0x3dd0_b461_1a60_0000);
const HALF_PI_3: f64 = 2.0222662487959506e-21;
/// pi/2 - `HALF_PI_1` as one double.
pub(super) const HALF_PI_REST: f64 = 6.077100506506192e-11;
/// pi/2 as a double, and the rest of it.
const HALF_PI: f64 = std::f64::consts::FRAC_PI_2;
const HALF_PI_TAIL: f64 = 6.123233995736766e-17;

/// Angles below this take the three-part subtraction.
pub(super) const MEDIUM: f64 = 1_647_099.0; // 2^20 * pi/2

/// 64 zero bits, then the bits of 2/pi behind the binary point.
const TWO_OVER_PI_BITS: [u64; 21] = [
    0,
    0xa2f9_836e_4e44_1529,
    0xfc27_57d1_f534_ddc0,
    0xdb62_9599_3c43_9041,
    0xfe51_63ab_debb_c561,
    0xb724_6e3a_424d_d2e0,
    0x0649_2eea_09d1_921c,
    0xfe1d_eb1c_b129_a73e,
    0xe882_35f5_2ebb_4484,
    0xe99c_7026_b45f_7e41,
    0x3991_d639_8353_39f4,
    0x9c84_5f8b_bdf9_283b,
    0x1ff8_97ff_de05_980f,
    0xef2f_118b_5a0a_6d1f,
    0x6d36_7ecf_27cb_09b7,
    0x4f46_3f66_9e5f_ea2d,
    0x7527_bac7_ebe5_f17b,
    0x3d07_39f7_8a52_92ea,
    0x6bfb_5fb1_1f8d_5d08,
    0x5603_3046_fc7b_6bab,
    0xf0cf_bc20_9af4_361d,
];

/// Reduces a finite angle; `lo` is good to about 2^-85.
pub(super) fn reduce(x: f64) -> Reduced {
    if x.abs() >= MEDIUM {
        return reduce_large(x);
    }
    let biased = x * TWO_OVER_PI + ROUND;
    let n = biased - ROUND;
    let a = x - n * HALF_PI_1;
    let b = n * HALF_PI_2;
    let c = a - b;
    // What the subtraction lost, by Knuth's two-sum, and the third part.
    let back = a - c;
    let lost = (a - (c + back)) + (back - b) - n * HALF_PI_3;
    let hi = c + lost;
    Reduced { quadrant: biased.to_bits() as u32 & 3, hi, lo: (c - hi) + lost }
}

/// Reduces an angle of any finite size from 2^-9 on.
fn reduce_large(x: f64) -> Reduced {
    let bits = x.to_bits();
    let exponent = ((bits >> 52) & 0x7ff) as i32 - 1075;
    let mantissa = (bits & 0x000f_ffff_ffff_ffff) | 0x0010_0000_0000_0000;
    debug_assert!(exponent >= -62, "too small for this way: {x}");

    // |x| 2/pi / 4 = mantissa * (2/pi) * 2^(exponent - 2): bits of 2/pi above that only add whole turns.
    let start = (exponent - 2 + 64) as usize;
    let (word, shift) = (start / 64, start % 64);
    let window = |i: usize| {
        let w = TWO_OVER_PI_BITS[word + i];
        if shift == 0 { w } else { w << shift | TWO_OVER_PI_BITS[word + i + 1] >> (64 - shift) }
    };
    let m = u128::from(mantissa);
    let p2 = m * u128::from(window(2));
    let p1 = m * u128::from(window(1)) + (p2 >> 64);
    let p0 = mantissa.wrapping_mul(window(0)).wrapping_add((p1 >> 64) as u64);

    // 192 bits of the turn's fraction: two of quadrant, then 128 of the place within it.
    let quadrant = (p0 >> 62) as u32;
    let turn = u128::from(p0) << 64 | u128::from(p1 as u64);
    let place = turn << 2 | u128::from(p2 as u64 >> 62);
    let upper = place >> 127 == 1;
    let size = if upper { place.wrapping_neg() } else { place };
    let high = size as f64;
    let low = size.wrapping_sub(high as u128) as i128 as f64;
    let unit = f64::from_bits((1023 - 128) << 52);
    let sign = if upper != (x < 0.0) { -unit } else { unit };
    let (hi, err) = super::function64::two_prod(high * sign, HALF_PI);
    let lo = err + (high * sign * HALF_PI_TAIL + low * sign * HALF_PI);
    let quadrant = quadrant + u32::from(upper);
    let quadrant = if x < 0.0 { quadrant.wrapping_neg() } else { quadrant };
    Reduced { quadrant: quadrant & 3, hi: hi + lo, lo: (hi - (hi + lo)) + lo }
}
