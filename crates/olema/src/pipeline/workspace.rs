//! Workspace: a grid's places, evaluated and displaced, in lists that are used again for every grid.
//!
//! In: a lattice. Out: where its vertices are at a motion key, with their owners' bits, and what shading needs of them.

use glam::Vec3;

use crate::geometry::SurfacePoint;
use crate::math::Vec3s;
use crate::shading::Inputs;

use super::border::Border;
use super::displace::DisplaceContext;
use super::lattice::Lattice;
use super::moving::{Displaced, Moving, reads_coordinates};
use super::patch::unit_normal;
use super::piece::{Piece, Sabotage};
use super::points::{Points, Wanted};
use super::recall::Recall;

/// One worker's lists.
#[derive(Debug, Default)]
pub struct Workspace {
    /// Places on the grid's own patch.
    pub lattice: Lattice,
    /// Those on other patches.
    border: Border,
    /// All of them at one key.
    pub now: Placed,
    /// The same at the time of shading.
    pub shaded: Placed,
    /// Vertices at all keys, key after key.
    kept: Vec<Vec3>,
    recall: Recall,
    moving: Moving,
}

/// A lattice at a key or between two.
#[derive(Debug, Default)]
pub struct Placed {
    /// Its places, and those that the border needs, evaluated.
    pub points: Points,
    /// Where places are that a ring is made of, displaced; bump shaders count.
    pub ring: Vec3s,
    /// Where the vertices are; bump shaders count for nothing.
    pub vertices: Vec3s,
}

impl Workspace {
    /// Lists the places that a grid needs, and says what has to be known of them for a shader that reads `inputs`. A ring
    /// is for normals of the displaced surface.
    pub fn set(&mut self, context: &DisplaceContext, piece: &Piece, inputs: Inputs, ring: bool) -> Wanted {
        self.lattice.set(context.frame, piece, ring);
        let displaced = context.is_displaced(piece.patch);
        let recall = displaced.then_some(&mut self.recall);
        self.border.collect(context, piece.patch, &mut self.lattice, recall);
        let owners = self.border.points.iter().map(|point| point.owner).filter(|_| displaced);
        let mut all = std::iter::once(piece.patch).chain(owners);
        let reads = (displaced || ring) && all.any(|patch| reads_coordinates(context, patch));
        let estimated = context.frame.sabotage == Some(Sabotage::EstimatedNormals);
        Wanted {
            derivatives: inputs.derivatives || reads,
            normals: inputs.n || displaced || ring,
            border_derivatives: displaced && (reads || !estimated),
            border_normals: displaced,
        }
    }

    /// Finds where everything is at motion key `key`; the ring only where it `is_shaded`.
    pub fn place(
        &mut self,
        context: &DisplaceContext,
        [patch, key]: [u32; 2],
        wanted: Wanted,
        is_shaded: bool,
    ) {
        let Workspace { lattice, border, now: Placed { points, ring, vertices }, recall, moving, .. } = self;
        points.evaluate(context, [patch, key], lattice, border, wanted);
        let displaced = context.is_displaced(patch);
        let num = lattice.num_vertices();
        let of = Displaced { patch, key: key as usize, lattice, border, points };
        if displaced || is_shaded && lattice.has_ring() {
            moving.displace(context, of, ring);
        }
        let is_bump = context.info(patch).1.displacement.as_ref().is_some_and(|d| d.is_bump);
        vertices.assign(if displaced && !is_bump { ring } else { &points.at.p }, 0..num);
        for (ix, point) in border.points.iter().enumerate() {
            let p = if displaced { ring.get(of.slot(ix)) } else { points.at.p.get(point.place as usize) };
            vertices.set(point.vertex as usize, p);
        }
        if displaced {
            recall.exchange(key as usize, vertices);
        }
    }

    /// Keeps the vertices that were just placed: one may turn slow at a later key, which asks for all of them.
    pub fn keep_vertices(&mut self, key: usize) {
        if key == 0 {
            self.kept.clear();
        }
        let vertices = &self.now.vertices;
        self.kept.extend((0..self.lattice.num_vertices()).map(|ix| vertices.get(ix)));
    }

    /// What was kept, key after key.
    pub fn kept_vertices(&self) -> &[Vec3] {
        &self.kept
    }

    /// Hands the vertices whose displaced surface has a normal to `visit`, with these normals.
    pub fn displaced_normals(
        &mut self,
        context: &DisplaceContext,
        patch: u32,
        visit: impl FnMut(usize, Vec3),
    ) {
        let Placed { points, ring, .. } = &mut self.shaded;
        if self.lattice.has_ring() {
            points.displaced_normals(context, patch, &self.lattice, ring, visit);
        }
    }

    /// Notes what was just placed as what is shaded, `part` of the way there from what was noted before (none: all).
    /// `sign` turns normals.
    pub fn note_shaded(&mut self, part: Option<f32>, sign: f32) {
        match part {
            None => std::mem::swap(&mut self.now, &mut self.shaded),
            Some(part) => self.shaded.blend(&self.now, part, &self.lattice, sign),
        }
    }
}

impl Placed {
    /// Goes part of the way to where everything is at the next key.
    fn blend(&mut self, next: &Placed, part: f32, lattice: &Lattice, sign: f32) {
        let between = |from: Vec3, to: Vec3| from + (to - from) * part;
        for ix in 0..lattice.num_vertices() {
            let (from, to) = (self.points.at.get(ix), next.points.at.get(ix));
            let at = SurfacePoint {
                p: between(from.p, to.p),
                du: between(from.du, to.du),
                dv: between(from.dv, to.dv),
            };
            self.points.at.set(ix, at);
            let (from, to) = (self.points.normal.get(ix), next.points.normal.get(ix));
            let normal = if lattice.has_ring() {
                between(from, to).normalize_or(from)
            } else {
                unit_normal(&at).map_or(from, |normal| normal * sign)
            };
            self.points.normal.set(ix, normal);
            self.vertices.set(ix, between(self.vertices.get(ix), next.vertices.get(ix)));
        }
        if lattice.has_ring() {
            for ix in 0..lattice.own {
                self.ring.set(ix, between(self.ring.get(ix), next.ring.get(ix)));
            }
        }
    }
}
