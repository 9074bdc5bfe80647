//! Surfaces at lists of places.
//!
//! In: a patch, a motion key, lists of u and v. Out: positions and derivatives in camera space, place by place with the
//! bits that [`Surfaces::evaluate`] gives, however they are batched.

use std::ops::Range;

use crate::geometry::lanes::{self, SurfacePoints};
use crate::math::Vec3s;
use crate::math::simd::SimdLevel;

use super::limit::PlacedSpline;
use super::patch::{Loaded, Surface, Surfaces, at_key};

impl Surfaces<'_> {
    /// [`Self::evaluate`] at the places `range` of two lists, into the same places of `out`. All arrays are
    /// [`SLACK`](lanes::SLACK) longer than the range's end, and `out` is overwritten there.
    pub fn evaluate_list(
        &self,
        patch: u32,
        key: usize,
        uv: [&[f32]; 2],
        range: Range<usize>,
        out: &mut SurfacePoints,
    ) {
        self.with(patch, |loaded| match loaded {
            Loaded::Control(first, later) => {
                at_key(first, later, key).evaluate_list(self.level, uv, range, out);
            }
            Loaded::Limit(evaluator, limit) => match limit.spline(evaluator, key) {
                Some(spline) => spline.evaluate_list(self.level, uv, range, out),
                None => range.for_each(|ix| {
                    out.set(ix, limit.evaluate(evaluator, key, [uv[0][ix], uv[1][ix]]));
                }),
            },
        });
    }

    /// [`Self::position`] at the places `range` of two lists; otherwise as [`Self::evaluate_list`].
    pub fn list_positions(
        &self,
        patch: u32,
        key: usize,
        uv: [&[f32]; 2],
        range: Range<usize>,
        out: &mut Vec3s,
    ) {
        self.with(patch, |loaded| match loaded {
            Loaded::Control(first, later) => at_key(first, later, key).positions(self.level, uv, range, out),
            Loaded::Limit(evaluator, limit) => match limit.spline(evaluator, key) {
                Some(spline) => spline.positions(self.level, uv, range, out),
                None => range.for_each(|ix| {
                    out.set(ix, limit.evaluate(evaluator, key, [uv[0][ix], uv[1][ix]]).p);
                }),
            },
        });
    }

    /// [`Self::evaluate`] at all (u, v) of `columns` u and the v there are, row after row of constant v, if the patch
    /// has a fast way; `false` where it has none. `u` and `out` are [`SLACK`](lanes::SLACK) longer than they need be.
    pub fn evaluate_lattice(
        &self,
        patch: u32,
        key: usize,
        columns: usize,
        uv: [&[f32]; 2],
        out: &mut SurfacePoints,
    ) -> bool {
        self.with(patch, |loaded| match loaded {
            Loaded::Control(first, later) => match at_key(first, later, key) {
                Surface::Bicubic(surface) => {
                    lanes::bicubic_lattice(self.level, surface, columns, uv, out);
                    true
                }
                _ => false,
            },
            Loaded::Limit(..) => false,
        })
    }
}

impl PlacedSpline<'_> {
    /// See [`Surfaces::evaluate_list`].
    fn evaluate_list(&self, level: SimdLevel, uv: [&[f32]; 2], range: Range<usize>, out: &mut SurfacePoints) {
        match &self.next {
            None => lanes::evaluate(
                level,
                uv,
                range,
                out,
                #[inline(always)]
                |u, v| self.evaluate(u, v),
            ),
            Some(next) => lanes::evaluate(
                level,
                uv,
                range,
                out,
                #[inline(always)]
                |u, v| self.evaluate_between(next, u, v),
            ),
        }
    }

    /// See [`Surfaces::list_positions`].
    fn positions(&self, level: SimdLevel, uv: [&[f32]; 2], range: Range<usize>, out: &mut Vec3s) {
        match &self.next {
            None => lanes::positions(
                level,
                uv,
                range,
                out,
                #[inline(always)]
                |u, v| self.evaluate(u, v).p,
            ),
            Some(next) => lanes::positions(
                level,
                uv,
                range,
                out,
                #[inline(always)]
                |u, v| self.evaluate_between(next, u, v).p,
            ),
        }
    }
}

/// Calls `$run` with a function of (u, v) of each kind of surface: the loops are compiled apart for each.
macro_rules! run_on {
    ($run:path, $function:ident, $surface:expr, $level:expr, $uv:expr, $range:expr, $out:expr) => {
        match $surface {
            Surface::Bilinear(s) => run_on!(@ $run, $function, s, $level, $uv, $range, $out),
            Surface::RationalBilinear(s) => run_on!(@ $run, $function, s, $level, $uv, $range, $out),
            Surface::Bicubic(s) => run_on!(@ $run, $function, s, $level, $uv, $range, $out),
            Surface::RationalBicubic(s) => run_on!(@ $run, $function, s, $level, $uv, $range, $out),
        }
    };
    (@ $run:path, $function:ident, $s:ident, $level:expr, $uv:expr, $range:expr, $out:expr) => {
        $run(
            $level,
            $uv,
            $range,
            $out,
            #[inline(always)]
            |u, v| $s.$function(u, v),
        )
    };
}

impl Surface {
    /// See [`Surfaces::evaluate_list`].
    fn evaluate_list(&self, level: SimdLevel, uv: [&[f32]; 2], range: Range<usize>, out: &mut SurfacePoints) {
        run_on!(lanes::evaluate, evaluate, self, level, uv, range, out);
    }

    /// See [`Surfaces::list_positions`].
    fn positions(&self, level: SimdLevel, uv: [&[f32]; 2], range: Range<usize>, out: &mut Vec3s) {
        run_on!(lanes::positions, position, self, level, uv, range, out);
    }
}
