//! Parts of a grid that fit in 16 bits, and which of their micropolygons may be hit.

use crate::math::lanes::Lanes;
use crate::math::simd::LANES;
use crate::sampling::draw::{Micropolygon, Micropolygons, MovingDraw};
use crate::sampling::nomotion::{Facing, SampleCounts};
use crate::sampling::packed::Packed;
use crate::sampling::test_lanes::Shape;

/// Quads along i and j, first and one after the last.
pub(super) type Rectangle = [[usize; 2]; 2];

/// A rectangle of quads whose vertices are packed. Quads are numbered as their first vertices, so that those from one on
/// have theirs side by side; the last number of a row is no quad.
#[derive(Default)]
pub(super) struct Part {
    pub(super) packed: Packed,
    /// Quads along i.
    pub(super) m: usize,
    /// Vertices.
    pub(super) num: usize,
    /// Number in the grid of the first quad.
    first: usize,
    /// From the number of a quad here to that in the grid, for each row before it.
    skip: i32,
}

impl Part {
    /// Packs a rectangle; whether it fits.
    #[inline(always)]
    pub(super) fn pack(&mut self, draw: &MovingDraw, [i, j]: Rectangle) -> bool {
        let stride = draw.grid.m + 1;
        let row_of = |row: usize| row * stride + i[0]..row * stride + i[1] + 1;
        let fits = if i == [0, draw.grid.m] {
            let all = row_of(j[0]).start..row_of(j[1]).end;
            self.packed.pack_any(draw, std::slice::from_ref(&all))
        } else {
            self.packed.pack_any(draw, &(j[0]..=j[1]).map(row_of).collect::<Vec<_>>())
        };
        if !fits {
            return false;
        }
        self.m = i[1] - i[0];
        self.num = (self.m + 1) * (j[1] - j[0] + 1);
        self.first = j[0] * draw.grid.m + i[0];
        self.skip = draw.grid.m as i32 - (self.m as i32 + 1);
        true
    }

    /// Numbers in the grid of quads.
    #[inline(always)]
    pub(super) fn numbers<L: Lanes>(&self, lanes: L, quad: L::I) -> L::I {
        // From the middle of a quad no rounding reaches the next row, of fewer than 2^20 quads.
        let middle = lanes.add_f(lanes.to_f(quad), lanes.splat_f(0.5));
        let row = lanes.truncated(lanes.mul_f(middle, lanes.splat_f(1.0 / (self.m + 1) as f32)));
        let skipped = lanes.mul(row, lanes.splat(self.skip));
        lanes.add(lanes.add(quad, lanes.splat(self.first as i32)), skipped)
    }

    /// The micropolygons that may be hit, of each shape.
    pub(super) fn micropolygons(
        &self,
        draw: &MovingDraw,
        counts: &mut SampleCounts,
        of_shapes: &mut [OfShape; 2],
    ) {
        for of_shape in of_shapes.iter_mut() {
            of_shape.shape = None;
            of_shape.some.clear();
        }
        let step = self.m + 1;
        let firsts = (0..self.num / step - 1).flat_map(|row| row * step..row * step + self.m);
        if draw.facing == Facing::Any && draw.skip.is_none() && draw.micropolygons == Micropolygons::Quads {
            let [all, _] = of_shapes;
            all.shape = Some(Shape::whole(Facing::Any));
            all.vertices = [0, 1, 2, 3];
            all.some.resize(self.num.div_ceil(LANES), 0);
            firsts.for_each(|first| all.some[first / LANES] |= 1 << (first % LANES));
            return;
        }
        for first in firsts {
            let quad = (self.first + first).wrapping_add_signed(self.skip as isize * (first / step) as isize);
            let corners = draw.grid.corners(quad % draw.grid.m, quad / draw.grid.m);
            if draw.is_skipped(corners) {
                continue;
            }
            for (of_shape, micropolygon) in of_shapes.iter_mut().zip(draw.of_quad(corners)) {
                let Some(micropolygon) = micropolygon else { continue };
                if micropolygon.faces_away() {
                    counts.backfacing += 1;
                    continue;
                }
                of_shape.add(draw, &micropolygon, corners, first);
            }
        }
    }
}

/// Micropolygons that differ in nothing but their vertices: all quads, or all first or all second triangles.
#[derive(Default)]
pub(super) struct OfShape {
    /// `None` as long as there are no such micropolygons.
    pub(super) shape: Option<Shape>,
    /// Which of the quad's vertices are its corners.
    pub(super) vertices: [usize; 4],
    /// Which there are, 16 quads at a time.
    pub(super) some: Vec<u32>,
}

impl OfShape {
    /// Corners, from the first vertex on; a row of vertices has `step`.
    #[inline(always)]
    pub(super) fn corners(&self, step: usize) -> [usize; 4] {
        let [a, b, c, d] = self.vertices;
        let of_quad = [0, 1, step + 1, step];
        [of_quad[a & 3], of_quad[b & 3], of_quad[c & 3], of_quad[d & 3]]
    }

    /// Adds the micropolygon of the quad that begins at vertex `first`.
    fn add(&mut self, draw: &MovingDraw, micropolygon: &Micropolygon, corners: [usize; 4], first: usize) {
        self.shape = Some(Shape::of(micropolygon.triangles, draw.facing));
        let number = |vertex| corners.iter().position(|&corner| corner == vertex).unwrap_or(0);
        self.vertices = micropolygon.vertices.map(number);
        if self.some.len() <= first / LANES {
            self.some.resize(first / LANES + 1, 0);
        }
        self.some[first / LANES] |= 1 << (first % LANES);
    }
}
