//! Products of pairs of 16 bits, rounded: [`Lanes::scale2`](super::lanes::Lanes::scale2).
//!
//! In: two vectors of pairs. Out: `(a b + 2^14) >> 15` of each. One instruction on x86 (`pmulhrsw`), which the crate of
//! vectors does not offer; elsewhere two dot products of pairs.

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use fearless_simd::prelude::*;
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use fearless_simd::{Level, i32x8};
use fearless_simd::{Simd, i32x16};

use super::lanes::Lanes;

/// [`Lanes::scale2`] of the crate's vectors.
#[inline(always)]
pub(super) fn scale_pairs<S: Simd>(simd: S, a: i32x16<S>, b: i32x16<S>) -> i32x16<S> {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    match simd.level() {
        Level::Avx512(token) => return x86::avx512(token, a.into(), b.into()).simd_into(simd),
        Level::Avx2(token) => {
            let ([a0, a1], [b0, b1]) = (halves(a), halves(b));
            let low = x86::avx2(token, a0.into(), b0.into()).simd_into(simd);
            let high = x86::avx2(token, a1.into(), b1.into()).simd_into(simd);
            return simd.combine_i32x8(low, high);
        }
        Level::Sse4_2(token) => {
            let ([a0, a1], [b0, b1]) = (halves(a), halves(b));
            return simd.combine_i32x8(quarters(token, a0, b0), quarters(token, a1, b1));
        }
        _ => {}
    }
    scale_pairs_anywhere(simd, a, b)
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
#[inline(always)]
fn halves<S: Simd>(a: i32x16<S>) -> [i32x8<S>; 2] {
    a.token().split_i32x16(a).into()
}

/// Eight lanes of [`Lanes::scale2`], four at a time.
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
#[inline(always)]
fn quarters<S: Simd>(token: fearless_simd::Sse4_2, a: i32x8<S>, b: i32x8<S>) -> i32x8<S> {
    let simd = a.token();
    let ((a0, a1), (b0, b1)) = (simd.split_i32x8(a), simd.split_i32x8(b));
    let low = x86::sse42(token, a0.into(), b0.into()).simd_into(simd);
    let high = x86::sse42(token, a1.into(), b1.into()).simd_into(simd);
    simd.combine_i32x4(low, high)
}

/// [`Lanes::scale2`] from products of pairs.
#[inline(always)]
fn scale_pairs_anywhere<S: Simd>(simd: S, a: i32x16<S>, b: i32x16<S>) -> i32x16<S> {
    let (low, half) = (simd.splat(0xffff), simd.splat(1 << 14));
    // A product of halves is a dot product whose other half is zero.
    let x = (simd.dot2(a & low, b) + half) << 1;
    let y = (simd.dot2(a & !low, b) + half) << 1;
    ((x >> 16) & low) | (y & !low)
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
mod x86 {
    //! Multiply, round, keep the high half: `pmulhrsw`.

    #[cfg(target_arch = "x86")]
    use std::arch::x86::*;
    #[cfg(target_arch = "x86_64")]
    use std::arch::x86_64::*;

    fearless_simd::kernel!(
        #[inline(always)]
        pub fn avx512(token: Avx512, a: __m512i, b: __m512i) -> __m512i {
            let _ = token;
            _mm512_mulhrs_epi16(a, b)
        }
    );
    fearless_simd::kernel!(
        #[inline(always)]
        pub fn avx2(token: Avx2, a: __m256i, b: __m256i) -> __m256i {
            let _ = token;
            _mm256_mulhrs_epi16(a, b)
        }
    );
    fearless_simd::kernel!(
        #[inline(always)]
        pub fn sse42(token: Sse4_2, a: __m128i, b: __m128i) -> __m128i {
            let _ = token;
            _mm_mulhrs_epi16(a, b)
        }
    );
}
