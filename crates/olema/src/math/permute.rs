//! Looking up lanes of a vector by number: [`Lanes::lookup`](super::lanes::Lanes::lookup).
//!
//! In: a table of 16 lanes and 16 numbers. Out: the lane of that number, for each. One instruction with AVX-512, two and
//! a choice for each half with AVX2, which the crate of vectors offers for bytes only; elsewhere lane by lane.

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use fearless_simd::Level;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, i32x16};

use super::simd::LANES;

/// [`Lanes::lookup`](super::lanes::Lanes::lookup) of the crate's vectors.
#[inline(always)]
pub(super) fn lookup<S: Simd>(simd: S, table: i32x16<S>, ix: i32x16<S>) -> i32x16<S> {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    match simd.level() {
        Level::Avx512(token) => return x86::avx512(token, table.into(), ix.into()).simd_into(simd),
        Level::Avx2(token) => {
            let ((t0, t1), (i0, i1)) = (simd.split_i32x16(table), simd.split_i32x16(ix));
            let low = x86::avx2(token, t0.into(), t1.into(), i0.into()).simd_into(simd);
            let high = x86::avx2(token, t0.into(), t1.into(), i1.into()).simd_into(simd);
            return simd.combine_i32x8(low, high);
        }
        _ => {}
    }
    lookup_anywhere(simd, table, ix)
}

#[inline(always)]
fn lookup_anywhere<S: Simd>(simd: S, table: i32x16<S>, ix: i32x16<S>) -> i32x16<S> {
    let (mut values, mut numbers) = ([0; LANES], [0; LANES]);
    table.store_slice(&mut values);
    ix.store_slice(&mut numbers);
    for number in &mut numbers {
        *number = values[*number as usize % LANES];
    }
    i32x16::from_slice(simd, &numbers)
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
mod x86 {
    //! `vpermd`.

    #[cfg(target_arch = "x86")]
    use std::arch::x86::*;
    #[cfg(target_arch = "x86_64")]
    use std::arch::x86_64::*;

    fearless_simd::kernel!(
        #[inline(always)]
        pub fn avx512(token: Avx512, table: __m512i, ix: __m512i) -> __m512i {
            let _ = token;
            _mm512_permutexvar_epi32(ix, table)
        }
    );
    fearless_simd::kernel!(
        #[inline(always)]
        pub fn avx2(token: Avx2, first: __m256i, second: __m256i, ix: __m256i) -> __m256i {
            let _ = token;
            let (a, b) = (_mm256_permutevar8x32_epi32(first, ix), _mm256_permutevar8x32_epi32(second, ix));
            // Bit 3 of a number, where the choice looks for it: in the sign.
            let is_second = _mm256_slli_epi32::<28>(ix);
            _mm256_castps_si256(_mm256_blendv_ps(
                _mm256_castsi256_ps(a),
                _mm256_castsi256_ps(b),
                _mm256_castsi256_ps(is_second),
            ))
        }
    );
}
