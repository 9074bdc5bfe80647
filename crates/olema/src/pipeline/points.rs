//! Points: a lattice and its border, evaluated.
//!
//! In: the places of a lattice, and behind them those that its border has on other patches. Out: positions, derivatives
//! and exact normals of all of them at one motion key. Border vertices are then where their owners have them.

use std::ops::Range;

use glam::Vec3;

use crate::geometry::lanes::{SLACK, SurfacePoints};
use crate::math::Vec3s;

use super::border::Border;
use super::displace::DisplaceContext;
use super::lattice::Lattice;
use super::normals::{lattice_normals, surface_normals};
use super::piece::Sabotage;

/// What is asked of points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wanted {
    /// Derivatives of the lattice's own points.
    pub derivatives: bool,
    /// Their normals, which come from derivatives unless a broken rule estimates them.
    pub normals: bool,
    /// Normals at the time of shading.
    pub shaded_normals: bool,
    /// Derivatives and normals of the border's places on other patches.
    pub border_derivatives: bool,
    /// The normals that border points are displaced along.
    pub border_normals: bool,
}

/// A lattice's points; used again for every grid.
#[derive(Debug, Default)]
pub struct Points {
    /// Positions and derivatives, by place.
    pub at: SurfacePoints,
    /// Unit normals in camera space, turned by the orientation attribute; zero where the surface has no area.
    pub normal: Vec3s,
    /// A lattice with a ring around it.
    ring: Vec3s,
    ring_normal: Vec3s,
}

impl Points {
    /// Evaluates the places of `lattice` on `patch` and those of `border` on their patches, at motion key `key`.
    pub fn evaluate(
        &mut self,
        context: &DisplaceContext,
        [patch, key]: [u32; 2],
        lattice: &mut Lattice,
        border: &mut Border,
        wanted: Wanted,
    ) {
        let all = lattice.u.len();
        for &(_, [u, v]) in &lattice.snapped {
            lattice.u.push(u);
            lattice.v.push(v);
        }
        // What is written beyond a run's end.
        let len = lattice.u.len() + SLACK;
        lattice.u.resize(len, 0.0);
        lattice.v.resize(len, 0.0);
        if self.at.p.len() < len {
            self.at.resize(len);
            self.normal.resize(len);
        }
        self.evaluate_own(context, [patch, key], lattice, wanted);
        let uv = [&lattice.u[..], &lattice.v[..]];
        let surfaces = &context.frame.surfaces;
        for (patch, range) in border.runs(all) {
            if wanted.border_derivatives {
                surfaces.evaluate_list(patch, key as usize, uv, range, &mut self.at);
            } else {
                surfaces.list_positions(patch, key as usize, uv, range, &mut self.at.p);
            }
        }
        if wanted.border_derivatives {
            self.border_normals(context, border, key, uv, lattice.own..all);
        }
        lattice.u.truncate(all);
        lattice.v.truncate(all);
        if wanted.border_normals {
            border.sum_normals(context, &self.normal);
        }
    }

    fn evaluate_own(
        &mut self,
        context: &DisplaceContext,
        [patch, key]: [u32; 2],
        lattice: &Lattice,
        wanted: Wanted,
    ) {
        let surfaces = &context.frame.surfaces;
        let uv = [&lattice.u[..], &lattice.v[..]];
        let estimated = context.frame.sabotage == Some(Sabotage::EstimatedNormals) && lattice.has_ring();
        if !wanted.derivatives && (estimated || !wanted.normals) {
            surfaces.list_positions(patch, key as usize, uv, 0..lattice.own, &mut self.at.p);
        } else {
            let (key, at) = (key as usize, &mut self.at);
            let done = lattice
                .straight()
                .is_some_and(|straight| surfaces.evaluate_lattice(patch, key, lattice.columns, straight, at));
            let first = if done { lattice.num_vertices() } else { 0 };
            surfaces.evaluate_list(patch, key, uv, first..lattice.own, at);
            if done && !lattice.has_ring() {
                let num = lattice.snapped.len();
                let behind = uv[0].len() - SLACK - num;
                surfaces.evaluate_list(patch, key, uv, behind..behind + num, at);
                for (place, &(vertex, _)) in (behind..).zip(&lattice.snapped) {
                    at.set(vertex as usize, at.get(place));
                }
            }
        }
        let sign = context.normal_sign(patch);
        if estimated {
            self.estimate_normals(context, lattice, sign);
        } else if wanted.normals {
            self.exact_normals(context, [patch, key], uv, 0..lattice.own, sign);
        }
    }

    /// Normals of the places that a border has on other patches, not oriented.
    fn border_normals(
        &mut self,
        context: &DisplaceContext,
        border: &Border,
        key: u32,
        uv: [&[f32]; 2],
        places: Range<usize>,
    ) {
        let level = context.frame.surfaces.level;
        let end = places.end;
        if surface_normals(level, &self.at, places, 1.0, &mut self.normal) {
            for (patch, range) in border.runs(end) {
                self.missing_normals(context, [patch, key], uv, range, 1.0);
            }
        }
    }

    /// Normals of places of one patch; where the derivatives vanish, those from nearby.
    fn exact_normals(
        &mut self,
        context: &DisplaceContext,
        [patch, key]: [u32; 2],
        uv: [&[f32]; 2],
        range: Range<usize>,
        sign: f32,
    ) {
        let level = context.frame.surfaces.level;
        if surface_normals(level, &self.at, range.clone(), sign, &mut self.normal) {
            self.missing_normals(context, [patch, key], uv, range, sign);
        }
    }

    /// Takes normals from nearby where there are none.
    fn missing_normals(
        &mut self,
        context: &DisplaceContext,
        [patch, key]: [u32; 2],
        uv: [&[f32]; 2],
        range: Range<usize>,
        sign: f32,
    ) {
        for ix in range {
            if self.normal.get(ix) == Vec3::ZERO {
                let nearby = context.frame.surfaces.normal(patch, key as usize, [uv[0][ix], uv[1][ix]]);
                self.normal.set(ix, nearby * sign);
            }
        }
    }

    /// Normals from neighbouring points of the lattice, as a rule that is broken on purpose.
    fn estimate_normals(&mut self, context: &DisplaceContext, lattice: &Lattice, sign: f32) {
        lattice.ring(&self.at.p, &mut self.ring);
        let (level, width) = (context.frame.surfaces.level, lattice.columns + 2);
        lattice_normals(level, &self.ring, width, sign, &mut self.ring_normal);
        lattice.each_in_ring(|vertex, at| self.normal.set(vertex, self.ring_normal.get(at)));
        lattice.each_ghost(|vertex, place| self.normal.set(place, self.normal.get(vertex)));
    }

    /// Replaces the normals of vertices by those of the displaced surface, by where their neighbours on the lattice are, in
    /// each of the lists. Where it is folded to nothing, the normals stay.
    pub fn displaced_normals(
        &mut self,
        context: &DisplaceContext,
        patch: u32,
        lattice: &Lattice,
        placed: &Vec3s,
        normals: [&mut Vec3s; 2],
    ) {
        lattice.ring(placed, &mut self.ring);
        let (level, sign) = (context.frame.surfaces.level, context.normal_sign(patch));
        let has_gaps = lattice_normals(level, &self.ring, lattice.columns + 2, sign, &mut self.ring_normal);
        // A list that nobody asked for is empty.
        for list in normals.into_iter().filter(|list| !list.is_empty()) {
            if !has_gaps {
                lattice.without_ring(&self.ring_normal, list);
                continue;
            }
            lattice.each_in_ring(|vertex, at| {
                let normal = self.ring_normal.get(at);
                if normal != Vec3::ZERO {
                    list.set(vertex, normal);
                }
            });
        }
    }
}
