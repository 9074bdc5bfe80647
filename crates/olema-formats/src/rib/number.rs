//! Numbers: decimal text to floats, rounded correctly.
//!
//! In: bytes that start at a number. Out: its value and length. Short numbers, which is nearly all of them, are
//! one exact integer and one division or multiplication by an exact power of ten (Clinger 1990, "How to read
//! floating point numbers accurately", the fast path); the others go to the standard library.

/// Longest number that is read, in bytes.
pub const MAX_LEN: usize = 400;

/// The characters of a number, taken apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decimal {
    negative: bool,
    /// All digits as one integer; meaningless where there are more than 18.
    mantissa: u64,
    /// Power of ten that `mantissa` is multiplied by.
    exponent: i32,
    /// Digits before and after the point, leading zeros among them.
    digits: usize,
    /// Bytes of the number.
    pub len: usize,
}

const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];

const POWERS_F32: [f32; 11] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10];

/// Takes the number at the start of `bytes` apart; `None` where there is none, or where something other than a
/// space, a bracket, a quote or a comment follows it.
#[inline(always)]
pub fn scan(bytes: &[u8]) -> Option<Decimal> {
    let at = |ix: usize| bytes.get(ix).copied().unwrap_or(b' ');
    let mut ix = 0;
    let negative = at(0) == b'-';
    if negative || at(0) == b'+' {
        ix = 1;
    }
    let mut mantissa = 0u64;
    let first = ix;
    ix = digits(bytes, ix, &mut mantissa);
    let mut digits_seen = ix - first;
    let mut exponent = 0;
    if at(ix) == b'.' {
        let fraction = ix + 1;
        ix = many_digits(bytes, fraction, &mut mantissa);
        digits_seen += ix - fraction;
        exponent = -((ix - fraction) as i32);
    }
    if digits_seen == 0 {
        return None;
    }
    if at(ix) | 0x20 == b'e' {
        let (value, end) = scan_exponent(bytes, ix + 1)?;
        exponent = exponent.saturating_add(value);
        ix = end;
    }
    let ends = matches!(at(ix), b' ' | b'\n' | b'\t' | b'\r' | b']' | b'[' | b'"' | b'#' | 0x0b | 0x0c);
    // "1.#INF" and "-1.#IND" are what some C libraries print for numbers that are none.
    let none = at(ix) == b'#' && bytes[ix - 1] == b'.' && at(ix + 1).is_ascii_uppercase();
    (ends && !none).then_some(Decimal { negative, mantissa, exponent, digits: digits_seen, len: ix })
}

#[inline(always)]
fn digits(bytes: &[u8], mut ix: usize, mantissa: &mut u64) -> usize {
    while let Some(&byte) = bytes.get(ix) {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            break;
        }
        *mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
        ix += 1;
    }
    ix
}

/// Eight characters less '0', and how many of them are digits before the first that is none.
#[inline(always)]
fn digits_of_eight(chunk: &[u8; 8]) -> (u64, usize) {
    const HIGH: u64 = 0x8080_8080_8080_8080;
    // Digits become 0 to 9. Adding 0x76 sets the high bit of all others; a carry only reaches bytes behind
    // the first that is no digit.
    let word = u64::from_le_bytes(*chunk) ^ 0x3030_3030_3030_3030;
    let others = (word.wrapping_add(0x7676_7676_7676_7676) | word) & HIGH;
    (word, (others.trailing_zeros() / 8) as usize)
}

/// The number that the first `count` of eight digits are, 1 to 8 of them.
#[inline(always)]
fn value_of_digits(word: u64, count: usize) -> u64 {
    const PAIRS: u64 = 0x0000_00ff_0000_00ff;
    // Zeros in front, then pairs, then fours, then all eight.
    let word = word << (64 - 8 * count);
    let word = word.wrapping_mul(10).wrapping_add(word >> 8);
    let high = (word & PAIRS).wrapping_mul(100 + (1_000_000 << 32));
    let low = (word >> 16 & PAIRS).wrapping_mul(1 + (10_000 << 32));
    high.wrapping_add(low) >> 32
}

/// Bytes that [`short`] looks at.
pub const SHORT: usize = 24;

/// The float at the start of `bytes` and its length, if it is of the kind that nearly all are: a point and up to eight
/// digits around it, then a space or a bracket. What it leaves to [`scan`] may be a number too.
#[inline(always)]
pub fn short(bytes: &[u8; SHORT]) -> Option<(f32, usize)> {
    let eight = |at: usize| bytes[at..].first_chunk::<8>();
    let negative = bytes[0] == b'-';
    let first = usize::from(negative);
    let (whole, num_whole) = digits_of_eight(eight(first)?);
    let point = first + num_whole;
    if num_whole > 7 || bytes[point] != b'.' {
        return None;
    }
    let (fraction, num_places) = digits_of_eight(eight(point + 1)?);
    let (num_digits, len) = (num_whole + num_places, point + 1 + num_places);
    if !(1..=8).contains(&num_digits) || !matches!(bytes[len], b' ' | b'\n' | b']') {
        return None;
    }
    let shift = 8 * num_whole;
    let mantissa = value_of_digits(whole & ((1 << shift) - 1) | fraction << shift, num_digits);
    if mantissa >= 1 << 24 {
        return None;
    }
    let value = mantissa as f32 / POWERS_F32[num_places];
    Some((if negative { -value } else { value }, len))
}

/// The same as [`digits`], eight at a time: a fraction has six or more as a rule.
#[inline(always)]
fn many_digits(bytes: &[u8], mut ix: usize, mantissa: &mut u64) -> usize {
    const TENS: [u64; 9] = [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000];
    while let Some(chunk) = bytes.get(ix..).and_then(<[u8]>::first_chunk::<8>) {
        let (word, count) = digits_of_eight(chunk);
        if count == 0 {
            return ix;
        }
        let value = value_of_digits(word, count);
        *mantissa = mantissa.wrapping_mul(TENS[count]).wrapping_add(value);
        ix += count;
        if count < 8 {
            return ix;
        }
    }
    digits(bytes, ix, mantissa)
}

fn scan_exponent(bytes: &[u8], mut ix: usize) -> Option<(i32, usize)> {
    let negative = bytes.get(ix) == Some(&b'-');
    if negative || bytes.get(ix) == Some(&b'+') {
        ix += 1;
    }
    let first = ix;
    let mut value = 0i32;
    while let Some(digit) = bytes.get(ix).map(|b| b.wrapping_sub(b'0')).filter(|d| *d <= 9) {
        value = (value * 10 + i32::from(digit)).min(99_999);
        ix += 1;
    }
    (ix > first).then_some((if negative { -value } else { value }, ix))
}

impl Decimal {
    /// The nearest double; infinite where it is out of range. `bytes` is what [`scan`] was given.
    #[inline]
    pub fn to_f64(self, bytes: &[u8]) -> f64 {
        if self.digits > 18 || self.mantissa >= 1 << 53 || self.exponent.unsigned_abs() > 22 {
            return slow(bytes, self.len);
        }
        let power = POWERS[self.exponent.unsigned_abs() as usize];
        let mantissa = self.mantissa as f64;
        let value = if self.exponent < 0 { mantissa / power } else { mantissa * power };
        if self.negative { -value } else { value }
    }

    /// The nearest float; infinite where it is out of range.
    #[inline]
    pub fn to_f32(self, bytes: &[u8]) -> f32 {
        let power = self.exponent.unsigned_abs() as usize;
        if self.digits <= 18 && self.mantissa < 1 << 24 && power <= 10 {
            let mantissa = self.mantissa as f32;
            let power = POWERS_F32[power];
            let value = if self.exponent < 0 { mantissa / power } else { mantissa * power };
            return if self.negative { -value } else { value };
        }
        let wide = self.to_f64(bytes);
        // Rounding twice goes wrong only where the double lies halfway between two floats, and below the
        // normal range, where halfway is elsewhere.
        let halfway = wide.to_bits() & 0x1fff_ffff == 0x1000_0000;
        if halfway || wide.abs() < f64::from(f32::MIN_POSITIVE) {
            return slow(bytes, self.len);
        }
        wide as f32
    }

    /// The value, if it is a whole number that an `i32` holds ("3" and "3.0" are).
    pub fn to_i32(self, bytes: &[u8]) -> Option<i32> {
        if self.exponent == 0 && self.digits <= 10 {
            let value = if self.negative { -(self.mantissa as i64) } else { self.mantissa as i64 };
            return i32::try_from(value).ok();
        }
        let value = self.to_f64(bytes);
        (value.fract() == 0.0 && value.abs() <= f64::from(i32::MAX)).then_some(value as i32)
    }
}

#[cold]
fn slow<T: std::str::FromStr + From<u8>>(bytes: &[u8], len: usize) -> T {
    // `scan` lets nothing through that the standard library refuses.
    let text = bytes.get(..len).and_then(|b| std::str::from_utf8(b).ok());
    text.and_then(|t| t.parse().ok()).unwrap_or_else(|| T::from(0))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn f32_of(text: &str) -> Option<f32> {
        scan(text.as_bytes()).map(|d| d.to_f32(text.as_bytes()))
    }

    #[test]
    fn every_spelling_of_a_number_is_read() {
        for text in [
            "1",
            "-1",
            "+1",
            "1.",
            ".5",
            "-.5",
            "1e3",
            "1E-3",
            "1.5e+2",
            "0",
            "00012",
            "1.000000000000000000000001",
        ] {
            assert_eq!(f32_of(text), text.parse().ok(), "{text}");
        }
    }

    #[test]
    fn what_is_no_number_is_refused() {
        for text in
            ["", "-", ".", "-.", "e5", "1e", "1e+", "12a", "1-2", "1.#INF", "-1.#IND", "1.2.3", "0x10"]
        {
            assert_eq!(scan(text.as_bytes()), None, "{text}");
        }
    }

    #[test]
    fn halfway_and_tiny_numbers_are_rounded_once() {
        for text in [
            "1.000000059604644775390625",
            "1.00000005960464477539062500001",
            "1e-45",
            "7.1e-46",
            "1.17549435e-38",
            "3.4028236e38",
            "16777217",
            "16777217.0000001",
            "9007199254740993",
        ] {
            assert_eq!(f32_of(text), text.parse().ok(), "{text}");
            let wide = scan(text.as_bytes()).map(|d| d.to_f64(text.as_bytes()));
            assert_eq!(wide, text.parse().ok(), "{text}");
        }
    }

    #[test]
    fn whole_numbers_only_are_integers() {
        let int = |t: &str| scan(t.as_bytes()).and_then(|d| d.to_i32(t.as_bytes()));
        assert_eq!(int("3"), Some(3));
        assert_eq!(int("-3.0"), Some(-3));
        assert_eq!(int("1e3"), Some(1000));
        assert_eq!(int("2.5"), None);
        assert_eq!(int("4000000000"), None);
        assert_eq!(int("99999999999999999999"), None);
    }

    #[test]
    fn short_numbers_are_read_as_others_are() {
        let mut num_short = 0;
        for value in [0u32, 1, 7, 42, 999_999, 1_234_567, 16_777_215, 16_777_216, 99_999_999, 123_456_789] {
            for (places, end) in
                (0..10).flat_map(|places| [' ', '\n', ']', 'e', '#'].map(|end| (places, end)))
            {
                for sign in ["", "-", "+"] {
                    let (whole, fraction) = (value / 10u32.pow(places), value % 10u32.pow(places));
                    let width = places as usize;
                    let fraction = if width > 0 { format!("{fraction:0width$}") } else { String::new() };
                    for number in
                        [format!("{sign}{whole}.{fraction}"), format!("{sign}.{fraction}"), whole.to_string()]
                    {
                        let mut text = format!("{number}{end}1.5 7.25 3 1e5 22 ").into_bytes();
                        text.resize(SHORT, b' ');
                        let Some((found, len)) = short(text.first_chunk().expect("long enough")) else {
                            continue;
                        };
                        let expected = scan(&text).map(|d| (d.to_f32(&text).to_bits(), d.len));
                        assert_eq!(Some((found.to_bits(), len)), expected, "{number}{end}");
                        num_short += 1;
                    }
                }
            }
        }
        assert!(num_short > 500, "{num_short}");
    }

    proptest! {
        #[test]
        fn floats_come_out_as_the_standard_library_reads_them(bits in any::<u32>(), places in 0usize..12) {
            let value = f32::from_bits(bits);
            prop_assume!(value.is_finite());
            for text in [format!("{value}"), format!("{value:e}"), format!("{value:.places$}"), format!("{value:.places$e}")] {
                prop_assume!(text.len() < MAX_LEN);
                prop_assert_eq!(f32_of(&text), text.parse().ok());
                let wide = scan(text.as_bytes()).map(|d| d.to_f64(text.as_bytes()));
                prop_assert_eq!(wide, text.parse().ok());
            }
        }
    }
}
