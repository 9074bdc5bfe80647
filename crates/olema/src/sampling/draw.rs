//! What the rasterizers of moving grids share: the loop over micropolygons, and the exact test of a sample.
//!
//! In: a [`MovingGrid`], the pattern and the samples of a region. Out: for each micropolygon that may be hit a
//! [`Micropolygon`], with which a rasterizer places vertices and tests samples of its choice. Source:
//! Fatahalian 2009, figure 8, of which the rasterizers' modules fill in the loops.

use super::cull::never_faces;
use super::inside::{point_at, triangle_hit};
use super::moving::{Extent, MovingGrid};
use super::nomotion::{Facing, HitSink, SampleCounts};
use super::pattern::SamplePattern;
use super::region::{Region, RegionSamples};
use crate::math::simd::SimdLevel;

/// What a micropolygon is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Micropolygons {
    /// A quad: a sample counts as one test of it.
    #[default]
    Quads,
    /// Each triangle of each quad, bounded and tested on its own.
    Triangles,
}

/// What does the work; the hits and the counts are the same.
#[derive(Debug, Clone, Copy)]
pub enum Kernels {
    /// Plain scalar code, to be read and to hold the others to.
    Scalar,
    /// Vector instructions where a rasterizer has a kernel for the pattern and the grid fits, else scalar code.
    Lanes(SimdLevel),
}

impl Default for Kernels {
    fn default() -> Self {
        Kernels::Lanes(SimdLevel::best())
    }
}

/// A grid to draw, and where and how.
#[derive(Debug, Clone, Copy)]
pub struct MovingDraw<'a> {
    /// The grid.
    pub grid: MovingGrid<'a>,
    /// The pattern; the grid's [`super::TupleTimes`] and the samples are made from it.
    pub pattern: &'a SamplePattern,
    /// Samples to test.
    pub samples: &'a RegionSamples,
    /// Sides that can be hit. A triangle may turn over in time: each sample sees it as it is for its tuple.
    pub facing: Facing,
    /// Vertices whose quads are left out, since they are drawn another way.
    pub skip: Option<&'a [bool]>,
    /// Quads or triangles; the hits are the same.
    pub micropolygons: Micropolygons,
    /// First and last time (t15 of [`super::Tuple`]) at which a sample of the region can be hit: others are not
    /// looked at.
    pub times: [i16; 2],
    /// What does the work.
    pub kernels: Kernels,
}

impl MovingDraw<'_> {
    /// The whole time.
    pub const ALL_TIMES: [i16; 2] = [0, i16::MAX];

    /// Whether a stratum has a tuple within [`Self::times`].
    #[inline(always)]
    pub(super) fn has_stratum(&self, stratum: u32) -> bool {
        let [first, last] = self.pattern.stratum_bounds(stratum).t15;
        last >= self.times[0] && first <= self.times[1]
    }

    /// Whether a tuple is within [`Self::times`].
    #[inline(always)]
    pub(super) fn has_tuple(&self, tuple_ix: u32) -> bool {
        (self.times[0]..=self.times[1]).contains(&self.pattern.tuples()[tuple_ix as usize].t15)
    }
}

/// A triangle of a quad: its number and its corners.
pub(super) type Triangle = (u8, [usize; 3]);
const FIRST: Triangle = (0, [0, 1, 2]);
const SECOND: Triangle = (1, [0, 2, 3]);

/// A quad or triangle of a grid.
#[derive(Debug, Clone, Copy)]
pub struct Micropolygon<'a> {
    draw: &'a MovingDraw<'a>,
    /// Its vertices; a triangle has one of them twice, in place of the corner that it lacks.
    pub vertices: [usize; 4],
    pub(super) triangles: &'static [Triangle],
}

impl<'a> MovingDraw<'a> {
    /// Calls `rasterize` with every micropolygon that may be hit; quad (i, j) is `j * m + i` for the sink.
    pub fn for_each<S: HitSink>(
        &'a self,
        counts: &mut SampleCounts,
        sink: &mut S,
        mut rasterize: impl FnMut(&Micropolygon<'a>, &mut SampleCounts, &mut S),
    ) {
        debug_assert!(self.grid.is_well_formed(), "grid outside its limits");
        debug_assert_eq!(self.samples.samples_per_pixel(), self.pattern.samples_per_pixel() as usize);
        for quad in 0..self.grid.m * self.grid.n {
            let corners = self.grid.corners(quad % self.grid.m, quad / self.grid.m);
            if self.is_skipped(corners) {
                continue;
            }
            sink.begin(quad as u32);
            for micropolygon in self.of_quad(corners).into_iter().flatten() {
                if micropolygon.faces_away() {
                    counts.backfacing += 1;
                } else {
                    rasterize(&micropolygon, counts, sink);
                }
            }
        }
    }

    /// Whether a quad is left out.
    pub(super) fn is_skipped(&self, corners: [usize; 4]) -> bool {
        self.skip.is_some_and(|skip| corners.iter().any(|&vertex| skip[vertex]))
    }

    /// The micropolygons of a quad.
    pub(super) fn of_quad(&'a self, corners: [usize; 4]) -> [Option<Micropolygon<'a>>; 2] {
        let [v0, v1, v2, v3] = corners;
        let of = |vertices, triangles| Some(Micropolygon { draw: self, vertices, triangles });
        match self.micropolygons {
            Micropolygons::Quads => [of(corners, &[FIRST, SECOND]), None],
            Micropolygons::Triangles => [of([v0, v1, v2, v0], &[FIRST]), of([v0, v0, v2, v3], &[SECOND])],
        }
    }
}

/// A micropolygon's vertices for one tuple.
pub type Placed = [[i32; 2]; 4];

impl Micropolygon<'_> {
    /// The grid that it is of.
    #[inline(always)]
    pub(super) fn grid(&self) -> &MovingGrid<'_> {
        &self.draw.grid
    }

    /// Whether no tuple can see a side of it that can be hit.
    pub(super) fn faces_away(&self) -> bool {
        let Facing::Only(side) = self.draw.facing else { return false };
        let away = |&(_, corners): &Triangle| {
            never_faces(&self.draw.grid, corners.map(|corner| self.vertices[corner]), side)
        };
        self.triangles.iter().all(away)
    }

    /// Positions of its vertices for a tuple.
    #[inline(always)]
    pub fn place(&self, tuple_ix: u32) -> Placed {
        let MovingDraw { grid, pattern, .. } = self.draw;
        let tuple = &pattern.tuples()[tuple_ix as usize];
        let time = grid.times.of_tuple(tuple_ix);
        self.vertices.map(|vertex| grid.position(vertex, tuple, time))
    }

    /// Tests sample `sample_ix`, at raster position `place`, whose tuple is `tuple_ix` and for which the
    /// vertices are `placed`. Counts one test, and one hit where a triangle is hit (or both of a folded quad).
    #[inline(always)]
    pub fn test(
        &self,
        placed: &Placed,
        tuple_ix: u32,
        sample_ix: usize,
        place: [i32; 2],
        counts: &mut SampleCounts,
        sink: &mut impl HitSink,
    ) {
        let mut is_hit = false;
        for &(number, corners) in self.triangles {
            let Some(hit) = triangle_hit(corners.map(|corner| placed[corner]), place) else { continue };
            if matches!(self.draw.facing, Facing::Only(side) if side != hit.sign) {
                continue;
            }
            let grid = &self.draw.grid;
            let time = grid.times.of_tuple(tuple_ix);
            let depth = corners.map(|corner| grid.depth_at(self.vertices[corner], time));
            sink.hit(sample_ix, point_at(&hit, depth), number, hit.sign);
            is_hit = true;
        }
        counts.tests += 1;
        counts.hits += u64::from(is_hit);
    }
}

/// Raster positions of samples that a box may cover, both inclusive, along x and y; first is above last where
/// there are none.
///
/// Samples are taken at (x + e, y + e^2), so one on the right or lower border of a box is beyond it: the last
/// position is one before the border.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach {
    pub first: [i32; 2],
    pub last: [i32; 2],
}

impl Reach {
    #[inline(always)]
    pub fn of(extent: &Extent) -> Self {
        Reach { first: extent.least, last: extent.most.map(|most| most.saturating_sub(1)) }
    }

    /// First and last pixel of the region that it overlaps along x (`axis` 0) or y; first above last where
    /// there is none.
    #[inline(always)]
    pub fn pixels(&self, region: &Region, axis: usize) -> [i32; 2] {
        if self.first[0] > self.last[0] || self.first[1] > self.last[1] {
            return [0, -1];
        }
        let [start, end] = [[region.x0, region.x1], [region.y0, region.y1]][axis];
        [(self.first[axis] >> 8).max(start), (self.last[axis] >> 8).min(end - 1)]
    }
}
