//! Lanes: the few vector operations that sampling kernels are made of.
//!
//! In: vectors of [`LANES`] values of 32 bits; as integers, as floats, or as *pairs* of 16 bits, x in the lower half and
//! y in the upper. Out: the same bits at every level of instructions. A kernel is written once, generic over [`Lanes`],
//! and has to be inlined into [`SimdLevel::run_lanes`](super::simd::SimdLevel::run_lanes): it and all that it calls is
//! `#[inline(always)]`. Arithmetic wraps; floats are IEEE 754 single, nothing is fused or approximate.
//!
//! The trait is ours, and small, so that other vectors can stand in for those of the processor: one that counts.

use fearless_simd::prelude::*;
use fearless_simd::{Bytes, Simd, SimdBase, f32x16, i16x32, i32x16, mask32x16};

use super::permute::lookup;
use super::scale_pairs::scale_pairs;
use super::simd::LANES;

/// x and y, each in -2^15..2^15, as a pair.
#[inline(always)]
pub fn pair(x: i32, y: i32) -> i32 {
    (x & 0xffff) | y << 16
}

/// A set of vector instructions.
pub trait Lanes: Copy {
    /// 16 integers, or 16 pairs of 16 bits.
    type I: Copy;
    /// 16 floats.
    type F: Copy;
    /// 16 truth values.
    type M: Copy;

    /// The same integer in all lanes.
    fn splat(self, value: i32) -> Self::I;
    /// `values[at..at + 16]`.
    fn load(self, values: &[i32], at: usize) -> Self::I;
    /// Into `values[at..at + 16]`.
    fn store(self, v: Self::I, values: &mut [i32], at: usize);
    /// a + b.
    fn add(self, a: Self::I, b: Self::I) -> Self::I;
    /// a - b.
    fn sub(self, a: Self::I, b: Self::I) -> Self::I;
    /// a b.
    fn mul(self, a: Self::I, b: Self::I) -> Self::I;
    /// Bits in both.
    fn and(self, a: Self::I, b: Self::I) -> Self::I;
    /// Bits in either.
    fn or(self, a: Self::I, b: Self::I) -> Self::I;
    /// Bits in one of them.
    fn xor(self, a: Self::I, b: Self::I) -> Self::I;
    /// Bits that are not.
    fn not(self, a: Self::I) -> Self::I;
    /// Shifted left.
    fn shl(self, a: Self::I, by: u32) -> Self::I;
    /// Shifted right, sign kept.
    fn shr(self, a: Self::I, by: u32) -> Self::I;
    /// Each shifted left by what `by` says, 0 to 31.
    fn shl_each(self, a: Self::I, by: Self::I) -> Self::I;
    /// Each shifted right by what `by` says, 0 to 31, sign kept.
    fn shr_each(self, a: Self::I, by: Self::I) -> Self::I;
    /// The lanes of `table` whose numbers are the lowest four bits of `ix`.
    fn lookup(self, table: Self::I, ix: Self::I) -> Self::I;
    /// Where a > b.
    fn gt(self, a: Self::I, b: Self::I) -> Self::M;
    /// Where a = b.
    fn eq(self, a: Self::I, b: Self::I) -> Self::M;
    /// `a` where `m`, else `b`.
    fn select(self, m: Self::M, a: Self::I, b: Self::I) -> Self::I;
    /// Lesser of each.
    fn min(self, a: Self::I, b: Self::I) -> Self::I;
    /// Greater of each.
    fn max(self, a: Self::I, b: Self::I) -> Self::I;
    /// Sum of all lanes.
    fn sum(self, a: Self::I) -> i32;
    /// Least of all lanes.
    fn least(self, a: Self::I) -> i32;
    /// Greatest of all lanes.
    fn greatest(self, a: Self::I) -> i32;

    /// Where both.
    fn both(self, a: Self::M, b: Self::M) -> Self::M;
    /// Where either.
    fn either(self, a: Self::M, b: Self::M) -> Self::M;
    /// Where not.
    fn none(self, a: Self::M) -> Self::M;
    /// Bit i is lane i.
    fn bits(self, m: Self::M) -> u32;
    /// Lane i is bit i.
    fn mask(self, bits: u32) -> Self::M;
    /// The lanes where `m`, side by side; zeros after them.
    fn compress(self, a: Self::I, m: Self::M) -> Self::I;
    /// The lanes of `a`, then of `b`, that have even numbers; and those that have odd ones.
    fn deinterleave(self, a: Self::I, b: Self::I) -> (Self::I, Self::I);
    /// The lanes of `a` and `b` in turn, which [`Self::deinterleave`] takes apart.
    fn interleave(self, a: Self::I, b: Self::I) -> (Self::I, Self::I);

    /// a + b of pairs.
    fn add2(self, a: Self::I, b: Self::I) -> Self::I;
    /// a - b of pairs.
    fn sub2(self, a: Self::I, b: Self::I) -> Self::I;
    /// Lesser of pairs.
    fn min2(self, a: Self::I, b: Self::I) -> Self::I;
    /// Greater of pairs.
    fn max2(self, a: Self::I, b: Self::I) -> Self::I;
    /// Pairs shifted left.
    fn shl2(self, a: Self::I, by: u32) -> Self::I;
    /// Pairs shifted right, sign kept.
    fn shr2(self, a: Self::I, by: u32) -> Self::I;
    /// `(a b + 2^14) >> 15` of pairs; not both -32768.
    fn scale2(self, a: Self::I, b: Self::I) -> Self::I;
    /// a.x b.x + a.y b.y.
    fn dot2(self, a: Self::I, b: Self::I) -> Self::I;
    /// A pair turned to (y, -x): `dot2(b, turned(a))` is the cross product b x a.
    #[inline(always)]
    fn turned(self, a: Self::I) -> Self::I {
        let low = self.and(self.shr(a, 16), self.splat(0xffff));
        self.or(low, self.shl(self.sub(self.splat(0), a), 16))
    }

    /// The same float in all lanes.
    fn splat_f(self, value: f32) -> Self::F;
    /// `values[at..at + 16]`.
    fn load_f(self, values: &[f32], at: usize) -> Self::F;
    /// Into `values[at..at + 16]`.
    fn store_f(self, v: Self::F, values: &mut [f32], at: usize);
    /// Rounded to nearest even.
    fn to_f(self, a: Self::I) -> Self::F;
    /// The bits of floats.
    fn bits_of(self, a: Self::F) -> Self::I;
    /// Floats of these bits.
    fn of_bits(self, a: Self::I) -> Self::F;
    /// Towards 0; of any value where the result is outside of -2^31..2^31.
    fn truncated(self, a: Self::F) -> Self::I;
    /// a + b.
    fn add_f(self, a: Self::F, b: Self::F) -> Self::F;
    /// a - b.
    fn sub_f(self, a: Self::F, b: Self::F) -> Self::F;
    /// a b.
    fn mul_f(self, a: Self::F, b: Self::F) -> Self::F;
    /// a / b.
    fn div_f(self, a: Self::F, b: Self::F) -> Self::F;
    /// Square root, rounded to nearest even.
    fn sqrt_f(self, a: Self::F) -> Self::F;
    /// Without its sign.
    fn abs_f(self, a: Self::F) -> Self::F;
    /// The nearest integer, the even one of two.
    fn round_f(self, a: Self::F) -> Self::F;
    /// Integers as such; anything below 2^31.
    fn to_i(self, a: Self::F) -> Self::I;
    /// Least of all lanes, all of them numbers.
    fn least_f(self, a: Self::F) -> f32;
    /// Greatest of all lanes, all of them numbers.
    fn greatest_f(self, a: Self::F) -> f32;
    /// Where a <= b; not where either is no number.
    fn le_f(self, a: Self::F, b: Self::F) -> Self::M;
    /// Where a < b; not where either is no number.
    fn lt_f(self, a: Self::F, b: Self::F) -> Self::M;
    /// Where a = b.
    fn eq_f(self, a: Self::F, b: Self::F) -> Self::M;
    /// `a` where `m`, else `b`.
    fn select_f(self, m: Self::M, a: Self::F, b: Self::F) -> Self::F;
    /// `b` unless `a` is below it.
    #[inline(always)]
    fn lesser(self, a: Self::F, b: Self::F) -> Self::F {
        self.select_f(self.lt_f(a, b), a, b)
    }
    /// `b` unless `a` is above it.
    #[inline(always)]
    fn greater(self, a: Self::F, b: Self::F) -> Self::F {
        self.select_f(self.lt_f(b, a), a, b)
    }
}

impl<S: Simd> Lanes for S {
    type I = i32x16<S>;
    type F = f32x16<S>;
    type M = mask32x16<S>;

    #[inline(always)]
    fn splat(self, value: i32) -> Self::I {
        i32x16::splat(self, value)
    }
    #[inline(always)]
    fn load(self, values: &[i32], at: usize) -> Self::I {
        i32x16::from_slice(self, &values[at..at + LANES])
    }
    #[inline(always)]
    fn store(self, v: Self::I, values: &mut [i32], at: usize) {
        v.store_slice(&mut values[at..at + LANES]);
    }
    #[inline(always)]
    fn add(self, a: Self::I, b: Self::I) -> Self::I {
        a + b
    }
    #[inline(always)]
    fn sub(self, a: Self::I, b: Self::I) -> Self::I {
        a - b
    }
    #[inline(always)]
    fn mul(self, a: Self::I, b: Self::I) -> Self::I {
        a * b
    }
    #[inline(always)]
    fn and(self, a: Self::I, b: Self::I) -> Self::I {
        a & b
    }
    #[inline(always)]
    fn or(self, a: Self::I, b: Self::I) -> Self::I {
        a | b
    }
    #[inline(always)]
    fn xor(self, a: Self::I, b: Self::I) -> Self::I {
        a ^ b
    }
    #[inline(always)]
    fn not(self, a: Self::I) -> Self::I {
        !a
    }
    #[inline(always)]
    fn shl(self, a: Self::I, by: u32) -> Self::I {
        a << by
    }
    #[inline(always)]
    fn shr(self, a: Self::I, by: u32) -> Self::I {
        a >> by
    }
    #[inline(always)]
    fn shl_each(self, a: Self::I, by: Self::I) -> Self::I {
        self.shlv_i32x16(a, by)
    }
    #[inline(always)]
    fn shr_each(self, a: Self::I, by: Self::I) -> Self::I {
        self.shrv_i32x16(a, by)
    }
    #[inline(always)]
    fn lookup(self, table: Self::I, ix: Self::I) -> Self::I {
        lookup(self, table, ix)
    }
    #[inline(always)]
    fn gt(self, a: Self::I, b: Self::I) -> Self::M {
        a.simd_gt(b)
    }
    #[inline(always)]
    fn eq(self, a: Self::I, b: Self::I) -> Self::M {
        a.simd_eq(b)
    }
    #[inline(always)]
    fn select(self, m: Self::M, a: Self::I, b: Self::I) -> Self::I {
        m.select(a, b)
    }
    #[inline(always)]
    fn min(self, a: Self::I, b: Self::I) -> Self::I {
        a.min(b)
    }
    #[inline(always)]
    fn max(self, a: Self::I, b: Self::I) -> Self::I {
        a.max(b)
    }
    #[inline(always)]
    fn sum(self, a: Self::I) -> i32 {
        a.reduce_sum()
    }
    #[inline(always)]
    fn least(self, a: Self::I) -> i32 {
        a.reduce_min()
    }
    #[inline(always)]
    fn greatest(self, a: Self::I) -> i32 {
        a.reduce_max()
    }

    #[inline(always)]
    fn both(self, a: Self::M, b: Self::M) -> Self::M {
        a & b
    }
    #[inline(always)]
    fn either(self, a: Self::M, b: Self::M) -> Self::M {
        a | b
    }
    #[inline(always)]
    fn none(self, a: Self::M) -> Self::M {
        !a
    }
    #[inline(always)]
    fn bits(self, m: Self::M) -> u32 {
        m.to_bitmask() as u32
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> Self::M {
        mask32x16::from_bitmask(self, u64::from(bits))
    }
    #[inline(always)]
    fn compress(self, a: Self::I, m: Self::M) -> Self::I {
        a.compress(m)
    }
    #[inline(always)]
    fn deinterleave(self, a: Self::I, b: Self::I) -> (Self::I, Self::I) {
        self.deinterleave_i32x16(a, b)
    }
    #[inline(always)]
    fn interleave(self, a: Self::I, b: Self::I) -> (Self::I, Self::I) {
        self.interleave_i32x16(a, b)
    }

    #[inline(always)]
    fn add2(self, a: Self::I, b: Self::I) -> Self::I {
        (pairs(a) + pairs(b)).bitcast()
    }
    #[inline(always)]
    fn sub2(self, a: Self::I, b: Self::I) -> Self::I {
        (pairs(a) - pairs(b)).bitcast()
    }
    #[inline(always)]
    fn min2(self, a: Self::I, b: Self::I) -> Self::I {
        pairs(a).min(pairs(b)).bitcast()
    }
    #[inline(always)]
    fn max2(self, a: Self::I, b: Self::I) -> Self::I {
        pairs(a).max(pairs(b)).bitcast()
    }
    #[inline(always)]
    fn shl2(self, a: Self::I, by: u32) -> Self::I {
        (pairs(a) << by).bitcast()
    }
    #[inline(always)]
    fn shr2(self, a: Self::I, by: u32) -> Self::I {
        (pairs(a) >> by).bitcast()
    }
    #[inline(always)]
    fn scale2(self, a: Self::I, b: Self::I) -> Self::I {
        scale_pairs(self, a, b)
    }
    #[inline(always)]
    fn dot2(self, a: Self::I, b: Self::I) -> Self::I {
        self.pairwise_dot_product_i16x32(pairs(a), pairs(b))
    }

    #[inline(always)]
    fn splat_f(self, value: f32) -> Self::F {
        f32x16::splat(self, value)
    }
    #[inline(always)]
    fn load_f(self, values: &[f32], at: usize) -> Self::F {
        f32x16::from_slice(self, &values[at..at + LANES])
    }
    #[inline(always)]
    fn store_f(self, v: Self::F, values: &mut [f32], at: usize) {
        v.store_slice(&mut values[at..at + LANES]);
    }
    #[inline(always)]
    fn to_f(self, a: Self::I) -> Self::F {
        a.to_float()
    }
    #[inline(always)]
    fn bits_of(self, a: Self::F) -> Self::I {
        a.bitcast()
    }
    #[inline(always)]
    fn of_bits(self, a: Self::I) -> Self::F {
        a.bitcast()
    }
    #[inline(always)]
    fn truncated(self, a: Self::F) -> Self::I {
        a.to_int()
    }
    #[inline(always)]
    fn add_f(self, a: Self::F, b: Self::F) -> Self::F {
        a + b
    }
    #[inline(always)]
    fn sub_f(self, a: Self::F, b: Self::F) -> Self::F {
        a - b
    }
    #[inline(always)]
    fn mul_f(self, a: Self::F, b: Self::F) -> Self::F {
        a * b
    }
    #[inline(always)]
    fn div_f(self, a: Self::F, b: Self::F) -> Self::F {
        a / b
    }
    #[inline(always)]
    fn sqrt_f(self, a: Self::F) -> Self::F {
        a.sqrt()
    }
    #[inline(always)]
    fn abs_f(self, a: Self::F) -> Self::F {
        a.abs()
    }
    #[inline(always)]
    fn round_f(self, a: Self::F) -> Self::F {
        a.round_ties_even()
    }
    #[inline(always)]
    fn to_i(self, a: Self::F) -> Self::I {
        a.to_int()
    }
    #[inline(always)]
    fn least_f(self, a: Self::F) -> f32 {
        a.reduce_min()
    }
    #[inline(always)]
    fn greatest_f(self, a: Self::F) -> f32 {
        a.reduce_max()
    }
    #[inline(always)]
    fn le_f(self, a: Self::F, b: Self::F) -> Self::M {
        a.simd_le(b)
    }
    #[inline(always)]
    fn lt_f(self, a: Self::F, b: Self::F) -> Self::M {
        a.simd_lt(b)
    }
    #[inline(always)]
    fn eq_f(self, a: Self::F, b: Self::F) -> Self::M {
        a.simd_eq(b)
    }
    #[inline(always)]
    fn select_f(self, m: Self::M, a: Self::F, b: Self::F) -> Self::F {
        m.select(a, b)
    }
}

#[inline(always)]
fn pairs<S: Simd>(a: i32x16<S>) -> i16x32<S> {
    a.bitcast()
}

#[cfg(test)]
#[path = "lanes_tests.rs"]
mod tests;
