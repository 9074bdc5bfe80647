//! Kernels over slices: plain loops, compiled once for each set of vector instructions.
//!
//! In: a loop body written for one value. Out: the same loop in as many lanes as the processor has. The body is scalar
//! Rust without branches, so the scalar function and the kernel are one text and give the same bits on every level:
//! lanes do not change the order of operations within a value, and nothing is fused.

use fearless_simd::{Level, Simd, dispatch};

use super::lanes::Lanes;

/// Values that a kernel handles at a time. Lists are padded to a multiple of it, since a rest that is done value by
/// value costs more than lanes that nobody reads.
pub const LANES: usize = 16;

/// Which vector instructions kernels may use. It changes speed alone.
#[derive(Debug, Clone, Copy)]
pub struct SimdLevel(Level);

impl SimdLevel {
    /// The widest that this processor has.
    pub fn best() -> Self {
        SimdLevel(Level::new())
    }

    /// What every processor of this architecture has.
    pub fn baseline() -> Self {
        SimdLevel(Level::baseline())
    }

    /// All that this processor has, for tests and benches.
    pub fn all() -> Vec<Self> {
        let levels = vec![SimdLevel::baseline()];
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        let levels = {
            let best = Level::new();
            let more = [best.as_sse4_2().map(|s| s.level()), best.as_avx2().map(|s| s.level()), Some(best)];
            levels.into_iter().chain(more.into_iter().flatten().map(SimdLevel)).collect()
        };
        levels
    }

    /// What it is called.
    pub fn name(self) -> &'static str {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        match self.0 {
            Level::Avx512(_) => return "avx512",
            Level::Avx2(_) => return "avx2",
            Level::Sse4_2(_) => return "sse4.2",
            _ => {}
        }
        "baseline"
    }

    /// Runs `kernel` with these instructions. They reach only what is inlined into it: it has to be a closure with
    /// `#[inline(always)]`, and so has everything that it calls.
    #[inline(always)]
    pub fn run<R>(self, kernel: impl FnOnce() -> R) -> R {
        dispatch!(self.0, _ => kernel())
    }

    /// Runs a kernel that is written in [`Lanes`] with these instructions. What it calls has to be
    /// `#[inline(always)]`, as in [`Self::run`].
    #[inline(always)]
    pub fn run_lanes<K: LanesKernel>(self, kernel: K) -> K::Output {
        dispatch!(self.0, simd => kernel.run(simd))
    }
}

/// A kernel written once for every level; its arguments are its fields.
pub trait LanesKernel {
    /// What it gives.
    type Output;

    /// Runs it; has to be `#[inline(always)]`.
    fn run<L: Lanes>(self, lanes: L) -> Self::Output;
}

/// `values[first..first + N]`; zeros beyond the end.
#[inline(always)]
pub fn load<const N: usize>(values: &[f32], first: usize) -> [f32; N] {
    let values = &values[first..];
    match values.first_chunk() {
        Some(all) => *all,
        None => {
            let mut padded = [0.0; N];
            padded[..values.len()].copy_from_slice(values);
            padded
        }
    }
}

/// Writes `values` to `to[first..first + N]`, as far as there is room.
#[inline(always)]
pub fn store<const N: usize>(to: &mut [f32], first: usize, values: &[f32; N]) {
    let to = &mut to[first..];
    match to.first_chunk_mut() {
        Some(all) => *all = *values,
        None => to.copy_from_slice(&values[..to.len()]),
    }
}

impl Default for SimdLevel {
    fn default() -> Self {
        SimdLevel::best()
    }
}
