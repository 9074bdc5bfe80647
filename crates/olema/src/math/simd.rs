//! Kernels over slices: plain loops, compiled once for each set of vector instructions.
//!
//! In: a loop body written for one value. Out: the same loop in as many lanes as the processor has. The body is scalar
//! Rust without branches, so the scalar function and the kernel are one text and give the same bits on every level:
//! lanes do not change the order of operations within a value, and nothing is fused.

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use fearless_simd::Simd;
use fearless_simd::{Level, dispatch};

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
        #[cfg(target_arch = "aarch64")]
        if let Level::Neon(_) = self.0 {
            return "neon";
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

/// A group of [`LANES`] entries of lists of the same length.
///
/// The last group of a list ends with it, and so holds some entries again; that of a list shorter than a group holds its
/// last entry as often as there is room. So no lane holds anything but an entry.
#[derive(Debug, Clone, Copy)]
pub struct Group {
    first: usize,
    /// How many entries there are.
    len: usize,
}

/// Calls `visit` with the groups of lists of `len` entries.
#[inline(always)]
pub fn each_group(len: usize, mut visit: impl FnMut(Group)) {
    let mut first = 0;
    while first < len {
        visit(Group { first: first.min(len.saturating_sub(LANES)), len });
        first += LANES;
    }
}

impl Group {
    /// Its values.
    #[inline(always)]
    pub fn load_f<L: Lanes>(self, lanes: L, values: &[f32]) -> L::F {
        if self.len >= LANES {
            return lanes.load_f(values, self.first);
        }
        let mut all = [values[self.len - 1]; LANES];
        all[..self.len].copy_from_slice(&values[..self.len]);
        lanes.load_f(&all, 0)
    }

    /// Writes its values.
    #[inline(always)]
    pub fn store_f<L: Lanes>(self, lanes: L, v: L::F, values: &mut [f32]) {
        if self.len >= LANES {
            return lanes.store_f(v, values, self.first);
        }
        let mut all = [0.0; LANES];
        lanes.store_f(v, &mut all, 0);
        values[..self.len].copy_from_slice(&all[..self.len]);
    }

    /// Writes its values.
    #[inline(always)]
    pub fn store<L: Lanes>(self, lanes: L, v: L::I, values: &mut [i32]) {
        if self.len >= LANES {
            return lanes.store(v, values, self.first);
        }
        let mut all = [0; LANES];
        lanes.store(v, &mut all, 0);
        values[..self.len].copy_from_slice(&all[..self.len]);
    }
}

/// `values[first..first + N]`; zeros beyond the end.
#[inline(always)]
pub fn load<T: Copy + Default, const N: usize>(values: &[T], first: usize) -> [T; N] {
    let values = &values[first..];
    match values.first_chunk() {
        Some(all) => *all,
        None => {
            let mut padded = [T::default(); N];
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
