//! Parts of a grid that fit in 16 bits, and which of their micropolygons may be hit.

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
    /// Number in the grid of each quad, and room for a vector.
    pub(super) quads: Vec<i32>,
}

impl Part {
    /// Packs a rectangle; whether it fits.
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
        self.quads.clear();
        let of_row = |row: usize| (i[0]..=i[1]).map(move |column| (row * draw.grid.m + column) as i32);
        self.quads.extend((j[0]..=j[1]).flat_map(of_row));
        self.quads.resize(self.num + LANES, 0);
        true
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
            all.corners = [0, 1, step + 1, step];
            all.some.resize(self.num.div_ceil(LANES), 0);
            firsts.for_each(|first| all.some[first / LANES] |= 1 << (first % LANES));
            return;
        }
        for first in firsts {
            let quad = self.quads[first] as usize;
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
                of_shape.add(draw, &micropolygon, corners, [first, step]);
            }
        }
    }
}

/// Micropolygons that differ in nothing but their vertices: all quads, or all first or all second triangles.
#[derive(Default)]
pub(super) struct OfShape {
    /// `None` as long as there are no such micropolygons.
    pub(super) shape: Option<Shape>,
    /// What of [`MovingDraw::of_quad`] they are.
    pub(super) number: usize,
    /// Corners, from the first vertex on.
    pub(super) corners: [usize; 4],
    /// Which there are, 16 quads at a time.
    pub(super) some: Vec<u32>,
}

impl OfShape {
    /// Adds the micropolygon of the quad that begins at vertex `first`; a row of vertices has `step`.
    fn add(
        &mut self,
        draw: &MovingDraw,
        micropolygon: &Micropolygon,
        corners: [usize; 4],
        [first, step]: [usize; 2],
    ) {
        self.shape = Some(Shape::of(micropolygon.triangles, draw.facing));
        self.number = usize::from(micropolygon.triangles[0].0);
        let of_part = [0, 1, step + 1, step];
        self.corners = micropolygon
            .vertices
            .map(|vertex| of_part[corners.iter().position(|&corner| corner == vertex).unwrap_or(0)]);
        if self.some.len() <= first / LANES {
            self.some.resize(first / LANES + 1, 0);
        }
        self.some[first / LANES] |= 1 << (first % LANES);
    }
}
