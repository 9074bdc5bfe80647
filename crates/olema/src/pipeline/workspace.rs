//! Workspace: a grid's places, evaluated and displaced, in lists that are used again for every grid.
//!
//! In: a lattice. Out: where its vertices are at a motion key, with their owners' bits, and what shading needs of them.

use std::sync::Arc;

use glam::Vec3;

use crate::geometry::lanes::SLACK;
use crate::geometry::place_lanes::OnRaster;
use crate::math::{Vec3s, transform};
use crate::scene::Between;
use crate::shading::Inputs;

use super::border::Border;
use super::displace::DisplaceContext;
use super::grid::{Grid, extent};
use super::lattice::Lattice;
use super::moving::{Displaced, Moving, any_reads_coordinates};
use super::normals::{blend_normals, surface_normals};
use super::piece::{Piece, Sabotage};
use super::points::{Points, Wanted};
use super::recall::Recall;
use super::shade::ShadedGrid;
use super::spare::Spare;
use super::split::SplitContext;
use super::sweep::Extent;
use super::waiting::RasterLists;

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
    /// What is between two keys, before it is what is shaded.
    between: Placed,
    /// Vertices at all keys, key after key: one may turn slow at a later key, which asks for all of them.
    kept: Vec3s,
    /// Where they are on the raster at each key.
    extents: Vec<Extent>,
    recall: Recall,
    moving: Moving,
    /// Lists for grids.
    pub spare: Spare,
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
    /// Keeps the lists of a grid, if nobody else needs it.
    pub fn let_go(&mut self, grid: Arc<ShadedGrid>) {
        if let Some(grid) = Arc::into_inner(grid) {
            self.spare.keep(grid.into_lists());
        }
    }

    /// Lists the places that a grid needs, and says what has to be known of them for a shader that reads `inputs`. A ring
    /// is for normals of the displaced surface.
    pub fn set(&mut self, context: &DisplaceContext, piece: &Piece, inputs: Inputs, ring: bool) -> Wanted {
        self.kept.resize(0);
        self.extents.clear();
        self.lattice.set(context.frame, piece, ring);
        let displaced = context.is_displaced(piece.patch);
        let recall = displaced.then_some(&mut self.recall);
        self.border.collect(context, piece.patch, &mut self.lattice, recall);
        let reads = (displaced || ring) && any_reads_coordinates(context, piece.patch, &self.border);
        let estimated = context.frame.sabotage == Some(Sabotage::EstimatedNormals);
        Wanted {
            derivatives: inputs.derivatives || inputs.n || reads,
            shaded_normals: inputs.n,
            // Between two keys they come from the derivatives there.
            normals: displaced || ring || inputs.n && context.info(piece.patch).1.shading.part == 0.0,
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

    /// Puts the vertices that were just placed on the raster, as the next key of `grid`.
    pub fn put_on_raster(&mut self, frame: &SplitContext, grid: &mut Grid) {
        let (camera, len) = (frame.camera, grid.num_vertices());
        let RasterLists { x, y, coc } = &mut grid.on_raster;
        let first = x.len();
        let placed = &self.now.vertices;
        self.kept.append(placed, 0..len);
        x.resize(first + len, 0);
        y.resize(first + len, 0);
        coc.resize(if camera.lens.is_some() { first + len } else { 0 }, 0);
        grid.depth.extend_from_slice(&placed.z()[..len]);
        grid.keys += 1;
        let to = OnRaster {
            x: &mut x[first..],
            y: &mut y[first..],
            coc: coc.get_mut(first..).unwrap_or_default(),
        };
        if let Some(reach) = camera.place_list(frame.surfaces.level, placed.slice(0..len), to) {
            self.extents.push(extent(&reach));
            return;
        }
        grid.slow.is_slow.resize(len, false);
        for ix in 0..len {
            let p = placed.get(ix);
            let (fixed, at) = (camera.fixed(p), first + ix);
            grid.slow.is_slow[ix] |= fixed.is_none();
            [x[at], y[at]] = fixed.unwrap_or_default();
            if camera.lens.is_some() {
                coc[at] = if fixed.is_some() { camera.coc(p.z) } else { 0 };
            }
        }
    }

    /// Once the vertices of all keys are on the raster.
    pub fn close(&mut self, frame: &SplitContext, grid: &mut Grid) {
        if grid.has_slow() {
            grid.slow.p = (0..self.kept.len()).map(|ix| self.kept.get(ix)).collect();
        }
        grid.close(frame.camera, &frame.patches.times.sets[grid.motion as usize], &self.extents);
    }

    /// Replaces the normals in each of the lists by those of the displaced surface, where it has any.
    pub fn displaced_normals(&mut self, context: &DisplaceContext, patch: u32, normals: [&mut Vec3s; 2]) {
        let Placed { points, ring, .. } = &mut self.shaded;
        if self.lattice.has_ring() {
            points.displaced_normals(context, patch, &self.lattice, ring, normals);
        }
    }

    /// Notes what was just placed as what is shaded: all of it, or what lies between it and what was noted `before`.
    pub fn note_shaded(
        &mut self,
        context: &DisplaceContext,
        patch: u32,
        wanted: Wanted,
        before: Option<Between>,
    ) {
        if let Some(between) = before {
            let ends = [&self.shaded, &self.now];
            self.between.blend(context, patch, ends, between, &self.lattice, wanted);
            std::mem::swap(&mut self.between, &mut self.shaded);
        } else {
            std::mem::swap(&mut self.now, &mut self.shaded);
        }
    }
}

impl Placed {
    /// What lies between two keys.
    fn blend(
        &mut self,
        context: &DisplaceContext,
        patch: u32,
        [from, to]: [&Placed; 2],
        between: Between,
        lattice: &Lattice,
        wanted: Wanted,
    ) {
        let surfaces = &context.frame.surfaces;
        let (level, len, part) = (surfaces.level, lattice.num_vertices(), between.part as f32);
        transform::between(level, [&from.vertices, &to.vertices], part, len, &mut self.vertices);
        let Points { at, normal, .. } = &mut self.points;
        if wanted.derivatives {
            transform::between(level, [&from.points.at.du, &to.points.at.du], part, len, &mut at.du);
            transform::between(level, [&from.points.at.dv, &to.points.at.dv], part, len, &mut at.dv);
        }
        if lattice.has_ring() {
            blend_normals(level, [&from.points.normal, &to.points.normal], part, len, normal);
            transform::between(level, [&from.ring, &to.ring], part, lattice.own, &mut self.ring);
        } else if wanted.shaded_normals {
            normal.make_room(len + SLACK);
            let sign = context.normal_sign(patch);
            if surface_normals(level, at, 0..len, sign, normal) {
                for ix in 0..len {
                    if normal.get(ix) == Vec3::ZERO {
                        let place = lattice.place(ix as u32);
                        normal.set(ix, surfaces.normal(patch, between.keys[0], place) * sign);
                    }
                }
            }
        }
    }
}
