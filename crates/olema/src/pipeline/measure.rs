//! Measure: how large lines and pieces are on the raster.
//!
//! In: a line of a patch, or a piece. Out: the rate of the one, the segments that the inside of the other asks for. Their
//! points are evaluated as lists; what is read off them is in [`rate`](super::rate).

use glam::Vec3;

use crate::geometry::lanes::SLACK;
use crate::math::Vec3s;

use super::patch::Surfaces;
use super::piece::{Line, Piece, Sabotage, quad_uv};
use super::rate::{Fineness, INNER_POINTS, MeasuredKeys, PROBES, Rate, inner_segments, rate};
use super::split::SplitContext;

/// Places on patches; used again for whatever is measured.
#[derive(Debug, Default)]
pub struct Places {
    u: Vec<f32>,
    v: Vec<f32>,
    /// Patch and first place of each run of places on one patch.
    runs: Vec<(u32, usize)>,
    p: Vec3s,
}

impl Places {
    fn clear(&mut self) {
        self.u.clear();
        self.v.clear();
        self.runs.clear();
    }

    fn push(&mut self, (patch, [u, v]): (u32, [f32; 2])) {
        if self.runs.last().is_none_or(|run| run.0 != patch) {
            self.runs.push((patch, self.u.len()));
        }
        self.u.push(u);
        self.v.push(v);
    }

    /// Calls `visit` with where the places, N of them, are at each of the keys.
    fn at_keys<const N: usize>(
        &mut self,
        surfaces: &Surfaces,
        keys: &MeasuredKeys,
        mut visit: impl FnMut(&[Vec3; N]),
    ) {
        debug_assert_eq!(self.u.len(), N, "as many places as are asked for");
        self.u.resize(N + SLACK, 0.0);
        self.v.resize(N + SLACK, 0.0);
        self.p.make_room(N + SLACK);
        for key in keys.keys() {
            let ends = self.runs.iter().skip(1).map(|run| run.1).chain([N]);
            for (&(patch, first), end) in self.runs.iter().zip(ends) {
                surfaces.list_positions(patch, key, [&self.u, &self.v], first..end, &mut self.p);
            }
            let (p, mut all) = (self.p.slice(0..N), [Vec3::ZERO; N]);
            for (ix, at) in all.iter_mut().enumerate() {
                *at = p.get(ix);
            }
            visit(&all);
        }
    }
}

impl SplitContext<'_> {
    /// The rate of a part of a line.
    pub(super) fn measure(&self, patch: u32, line: Line, [level, part]: [u32; 2]) -> Rate {
        let fineness = match line {
            Line::Border { edge, .. } if self.sabotage != Some(Sabotage::Rate) => {
                self.edges.edges[edge as usize].fineness
            }
            _ => self.fineness[self.patch(patch).primitive as usize],
        };
        let mut places = self.places.borrow_mut();
        places.clear();
        for probe in 0..=PROBES as u64 {
            // Exact: a multiple of 1/8 of 2^-level.
            let numerator = u64::from(part) * PROBES as u64 + probe;
            let point = self.point_on(patch, line, numerator, (PROBES as u64) << level);
            places.push(self.place(patch, point));
        }
        let keys = self.measured_keys(patch);
        let (mut probes, mut num) = ([[Vec3::ZERO; PROBES + 1]; MeasuredKeys::MOST], 0);
        places.at_keys(&self.surfaces, &keys, |points| {
            probes[num] = *points;
            num += 1;
        });
        rate(self.camera, self.scaled(fineness), &keys, &probes[..num])
    }

    /// Segments that the inside of a piece asks for.
    pub(super) fn inner_segments(&self, piece: &Piece) -> [u32; 2] {
        let fineness = self.scaled(self.fineness[self.patch(piece.patch).primitive as usize]);
        let keys = self.measured_keys(piece.patch);
        let mut places = self.places.borrow_mut();
        places.clear();
        for ix in 0..INNER_POINTS {
            let uv = quad_uv(&piece.uv, (ix % 5) as f32 / 4.0, (ix / 5) as f32 / 4.0);
            places.push((piece.patch, uv));
        }
        let (mut lattices, mut num) = ([[Vec3::ZERO; INNER_POINTS]; MeasuredKeys::MOST], 0);
        places.at_keys(&self.surfaces, &keys, |points| {
            lattices[num] = *points;
            num += 1;
        });
        inner_segments(self.camera, fineness, &keys, &lattices[..num])
    }

    fn measured_keys(&self, patch: u32) -> MeasuredKeys {
        MeasuredKeys::new(&self.patches.times.sets[self.patch(patch).motion as usize])
    }

    fn scaled(&self, fineness: Fineness) -> Fineness {
        Fineness { shading_rate: fineness.shading_rate * self.rate_scale, ..fineness }
    }
}
