//! Surfaces at lists of places.
//!
//! In: a patch, a motion key, lists of u and v. Out: positions and derivatives in camera space, place by place with the
//! bits that [`Surfaces::evaluate`] gives, however they are batched.

use std::ops::Range;

use crate::geometry::lanes::{self, SurfacePoints};
use crate::geometry::subdivision::{Evaluator, Part};
use crate::math::Vec3s;
use crate::math::simd::SimdLevel;

use super::limit::{Limit, PlacedSpline};
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
                None => limit.evaluate_parts(evaluator, key, self.level, uv, range, out),
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
                None => limit.part_positions(evaluator, key, self.level, uv, range, out),
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

/// Fewer points are evaluated one by one.
const FEWEST: usize = 12;

impl Limit {
    /// The points of a base quad that is no single spline: those of each spline in it are a list of their own.
    fn evaluate_parts(
        &self,
        evaluator: &mut Evaluator,
        key: usize,
        level: SimdLevel,
        uv: [&[f32]; 2],
        range: Range<usize>,
        out: &mut SurfacePoints,
    ) {
        if range.len() < FEWEST {
            for ix in range {
                out.set(ix, self.evaluate(evaluator, key, [uv[0][ix], uv[1][ix]]));
            }
            return;
        }
        let mut found = Vec::with_capacity(range.len());
        evaluator.parts([&uv[0][range.clone()], &uv[1][range.clone()]], &mut found);
        // Which of the parts each point is in, and how many come before that part's.
        let (mut parts, mut firsts): (Vec<Part>, Vec<usize>) = (Vec::new(), vec![0]);
        let mut numbers = Vec::with_capacity(found.len());
        for &(part, _) in found.iter().flatten() {
            let number = parts.iter().rposition(|&known| known == part).unwrap_or_else(|| {
                parts.push(part);
                firsts.push(0);
                parts.len() - 1
            });
            firsts[number + 1] += 1;
            numbers.push(number);
        }
        for number in 0..parts.len() {
            firsts[number + 1] += firsts[number];
        }
        let len = numbers.len() + lanes::SLACK;
        let (mut u, mut v, mut next) = (vec![0.0; len], vec![0.0; len], firsts.clone());
        for ((_, within), number) in found.iter().flatten().zip(&mut numbers) {
            let slot = next[*number];
            next[*number] += 1;
            [u[slot], v[slot]] = *within;
            *number = slot;
        }
        let mut at = SurfacePoints::default();
        at.resize(len);
        for (part, group) in parts.iter().zip(firsts.windows(2)) {
            if let Some(spline) = self.spline_of(evaluator, key, *part) {
                spline.evaluate_list(level, [&u, &v], group[0]..group[1], &mut at);
            }
        }
        let of_splines = range.clone().zip(&found).filter(|(_, found)| found.is_some());
        for ((ix, _), slot) in of_splines.zip(numbers) {
            out.set(ix, at.get(slot));
        }
        // What is asked next may forget the parts.
        for (ix, _) in range.zip(&found).filter(|(_, found)| found.is_none()) {
            out.set(ix, self.evaluate(evaluator, key, [uv[0][ix], uv[1][ix]]));
        }
    }

    /// See [`Self::evaluate_parts`].
    fn part_positions(
        &self,
        evaluator: &mut Evaluator,
        key: usize,
        level: SimdLevel,
        uv: [&[f32]; 2],
        range: Range<usize>,
        out: &mut Vec3s,
    ) {
        if range.len() < FEWEST {
            for ix in range {
                out.set(ix, self.evaluate(evaluator, key, [uv[0][ix], uv[1][ix]]).p);
            }
            return;
        }
        let len = range.len();
        let pad = |values: &[f32]| {
            let mut values = values[range.clone()].to_vec();
            values.resize(len + lanes::SLACK, 0.0);
            values
        };
        let (u, v) = (pad(uv[0]), pad(uv[1]));
        let mut at = SurfacePoints::default();
        at.resize(len + lanes::SLACK);
        self.evaluate_parts(evaluator, key, level, [&u, &v], 0..len, &mut at);
        out.copy(range.start, &at.p, 0..len);
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
