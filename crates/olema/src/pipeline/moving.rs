//! Moving: a lattice's points through the displacement shaders.
//!
//! In: evaluated points with their normals and shading rates. Out: their positions in camera space, displaced. A point on
//! the border goes through its owner's shader, with the owner's texture coordinates, wherever it is asked for.
//!
//! The filter width is the side of a micropolygon at the point's depth. That needs no step along the edge, so corners need
//! no rule of their own, and a grid's own resolution never enters.

use glam::Vec3;

use crate::math::simd::{LANES, load, store};
use crate::math::{Vec3Slice, Vec3s, transform};
use crate::shading::{DisplacementPoints, surely_within};

use super::border::Border;
use super::displace::{DisplaceContext, Displacer};
use super::lattice::Lattice;
use super::points::Points;
use super::primvar::{has_variables, spanned, texture_coordinates};

/// Points as displacement needs them; used again for every grid.
#[derive(Debug, Default)]
struct Batch {
    p: Vec3s,
    normal: Vec3s,
    shading_rate: Vec<f32>,
    coordinates: Coordinates,
}

/// Parameters and texture coordinates of points; empty where no shader reads them.
#[derive(Debug, Default)]
struct Coordinates {
    u: Vec<f32>,
    v: Vec<f32>,
    s: Vec<f32>,
    t: Vec<f32>,
    /// Length of the longer derivative, in camera units a unit of the patch's parameters.
    stretch: Vec<f32>,
    /// The patch's part of the primitive's parameters.
    scale: Vec<f32>,
}

impl Coordinates {
    fn lists(&mut self) -> [&mut Vec<f32>; 6] {
        [&mut self.u, &mut self.v, &mut self.s, &mut self.t, &mut self.stretch, &mut self.scale]
    }
}

/// Lists that displacing works with; used again for every grid.
#[derive(Debug, Default)]
pub struct Moving {
    all: Batch,
    /// Those of one primitive, where several meet.
    picked: Batch,
    inputs: DisplacementPoints,
    offset: Vec3s,
    moved: Vec3s,
}

/// What is displaced: first the places of a lattice, each by the patch's own shader, then the border's points, each by its
/// owner's. Where no ring is asked for, a border point stands in its vertex's place.
#[derive(Clone, Copy)]
pub struct Displaced<'a> {
    /// Patch of the lattice.
    pub patch: u32,
    /// Motion key.
    pub key: usize,
    /// Its places.
    pub lattice: &'a Lattice,
    /// Those that other patches own.
    pub border: &'a Border,
    /// All of them, evaluated.
    pub points: &'a Points,
}

impl Displaced<'_> {
    /// Where a border point stands in the list.
    #[inline(always)]
    pub fn slot(&self, point: usize) -> usize {
        if self.lattice.has_ring() {
            self.lattice.own + point
        } else {
            self.border.points[point].vertex as usize
        }
    }

    /// Length of the list.
    fn len(&self) -> usize {
        self.lattice.own + if self.lattice.has_ring() { self.border.points.len() } else { 0 }
    }
}

impl Moving {
    /// Replaces `out` by where all are, displaced. The patch's own bump shader moves what the ring is made of.
    pub fn displace(&mut self, context: &DisplaceContext, of: Displaced, out: &mut Vec3s) {
        let displacer = |patch: u32| context.info(patch).1.displacement.as_ref();
        let primitive = |patch: u32| context.info(patch).0;
        let moves_border = |patch: u32| displacer(patch).is_some_and(|d| !d.is_bump);
        let moves_own = displacer(of.patch).is_some_and(|d| of.lattice.has_ring() || !d.is_bump);
        let owners = || of.border.points.iter().map(|point| point.owner);
        self.gather(context, of, any_reads_coordinates(context, of.patch, of.border));
        let border_alike = moves_own == moves_border(of.patch) || of.border.points.is_empty();
        if border_alike && moves_alone(context, of.patch, of.border) {
            if moves_own {
                self.run(context, of, of.patch, false);
                std::mem::swap(&mut self.moved, out);
            } else {
                out.assign(&self.all.p, 0..of.len());
            }
            return;
        }
        out.assign(&self.all.p, 0..of.len());
        // Who moves each entry.
        let mut mover = vec![moves_own.then_some(of.patch); of.len()];
        for (ix, owner) in owners().enumerate() {
            mover[of.slot(ix)] = moves_border(owner).then_some(owner);
        }
        let mut done: Vec<u32> = Vec::new();
        for patch in mover.iter().flatten().copied() {
            if done.contains(&primitive(patch)) {
                continue;
            }
            done.push(primitive(patch));
            let is_same = |ix: &usize| mover[*ix].is_some_and(|other| primitive(other) == primitive(patch));
            let picked: Vec<usize> = (0..of.len()).filter(is_same).collect();
            self.pick(&picked);
            self.run(context, of, patch, true);
            for (slot, ix) in picked.into_iter().enumerate() {
                out.set(ix, self.moved.get(slot));
            }
        }
    }

    /// What all points' displacement depends on.
    fn gather(&mut self, context: &DisplaceContext, of: Displaced, reads_coordinates: bool) {
        let Batch { p, normal, shading_rate, coordinates } = &mut self.all;
        for (to, from) in [(&mut *p, &of.points.at.p), (&mut *normal, &of.points.normal)] {
            to.set_len(of.len());
            to.copy(0, from, 0..of.lattice.own);
        }
        shading_rate.clear();
        shading_rate.resize(of.len(), context.shading_rate(of.patch));
        for (ix, point) in of.border.points.iter().enumerate() {
            let slot = of.slot(ix);
            p.set(slot, of.points.at.p.get(point.place as usize));
            // Where only normals follow, nothing moves the border, and nobody has summed what meets there.
            let sums = &of.border.normals;
            normal.set(slot, if sums.is_empty() { Vec3::ZERO } else { sums.get(ix) });
            shading_rate[slot] = point.shading_rate;
        }
        coordinates.lists().into_iter().for_each(Vec::clear);
        if reads_coordinates {
            coordinates.gather(context, of);
        }
    }

    /// Takes some of all points.
    fn pick(&mut self, picked: &[usize]) {
        let (from, to) = (&mut self.all, &mut self.picked);
        to.p.assign_picked(&from.p, picked);
        to.normal.assign_picked(&from.normal, picked);
        let pick = |from: &[f32], to: &mut Vec<f32>| {
            to.clear();
            to.extend(picked.iter().filter_map(|&ix| from.get(ix)));
        };
        pick(&from.shading_rate, &mut to.shading_rate);
        for (from, to) in from.coordinates.lists().into_iter().zip(to.coordinates.lists()) {
            pick(from, to);
        }
    }

    /// Puts points, all of one primitive, through its shader: replaces `moved` by where they are then, in camera space.
    fn run(&mut self, context: &DisplaceContext, of: Displaced, patch: u32, picked: bool) {
        let (primitive, info) = context.info(patch);
        let Some(displacer) = &info.displacement else { return };
        let spaces = &displacer.spaces[of.key];
        let Moving { all, picked: some, inputs, offset, moved } = self;
        let batch = if picked { some } else { all };
        let (level, len) = (context.frame.surfaces.level, batch.p.len());
        transform::points(level, &spaces.to_object, &batch.p, &mut inputs.p);
        transform::unit_vectors(level, &spaces.normal_to_object, &batch.normal, &mut inputs.n);
        batch.widths(context, spaces.shrink, inputs);
        let Coordinates { u, v, s, t, .. } = &mut batch.coordinates;
        for (from, to) in
            [u, v, s, t].into_iter().zip([&mut inputs.u, &mut inputs.v, &mut inputs.s, &mut inputs.t])
        {
            // A batch goes through once.
            std::mem::swap(from, to);
        }
        offset.resize(0);
        offset.resize(len);
        displacer.shader.displace(inputs, offset);
        context.check(primitive, displacer, offset);
        transform::vectors(level, &spaces.to_camera, offset, moved);
        moved.add(level, &batch.p);
    }
}

impl Batch {
    /// Filter widths: the side of a micropolygon at each point.
    fn widths(&self, context: &DisplaceContext, shrink: f32, inputs: &mut DisplacementPoints) {
        let frame = context.frame;
        let camera = frame.camera;
        let scale = camera.scale[0].abs().min(camera.scale[1].abs());
        let Coordinates { stretch, scale: part, .. } = &self.coordinates;
        let (len, num_read) = (self.p.len(), stretch.len());
        inputs.width.resize(len, 0.0);
        inputs.st_width.resize(num_read, 0.0);
        frame.surfaces.level.run(
            #[inline(always)]
            || {
                let (widths, depths, rates) =
                    (&mut inputs.width[..len], &self.p.z()[..len], &self.shading_rate[..len]);
                for ix in 0..len {
                    let depth = if camera.perspective { depths[ix].max(camera.near) } else { 1.0 };
                    widths[ix] = (rates[ix] * frame.rate_scale).sqrt() * depth / scale;
                }
                let (st_widths, part) = (&mut inputs.st_width[..num_read], &part[..num_read]);
                for ix in 0..num_read {
                    st_widths[ix] = (widths[ix] / stretch[ix] * part[ix]).min(1.0);
                }
                widths.iter_mut().for_each(|width| *width *= shrink);
            },
        );
    }
}

/// Whether a patch and the owners of its border are of one primitive.
fn moves_alone(context: &DisplaceContext, patch: u32, border: &Border) -> bool {
    let primitive = |patch: u32| context.info(patch).0;
    context.frame.patches.patches[patch as usize].moves_alone
        || border.points.iter().all(|point| primitive(point.owner) == primitive(patch))
}

/// Whether the displacement of a patch or of an owner of its border reads parameters or texture coordinates.
pub fn any_reads_coordinates(context: &DisplaceContext, patch: u32, border: &Border) -> bool {
    let reads = |patch: u32| {
        let displacer = context.info(patch).1.displacement.as_ref();
        displacer.is_some_and(|d| d.shader.reads_texture_coordinates() || d.shader.reads_parameters())
    };
    let moves_alone = context.frame.patches.patches[patch as usize].moves_alone;
    reads(patch) || !moves_alone && border.points.iter().any(|point| reads(point.owner))
}

impl Coordinates {
    /// Those of all points.
    fn gather(&mut self, context: &DisplaceContext, of: Displaced) {
        self.lists().into_iter().for_each(|list| list.resize(of.len(), 0.0));
        let own = of.lattice.own;
        let on_patch = OnPatch::new(context, of.patch);
        let uv = [&of.lattice.u[..own], &of.lattice.v[..own]];
        let derivatives = [of.points.at.du.slice(0..own), of.points.at.dv.slice(0..own)];
        let to = self.lists().map(|list| &mut list[..own]);
        context.frame.surfaces.level.run(
            #[inline(always)]
            || on_patch.put_all(uv, derivatives, to),
        );
        self.replace_by_variables(context, of, of.patch, (0..own).map(|ix| (ix, ix)));
        let mut first = 0;
        for run in of.border.points.chunk_by(|a, b| a.owner == b.owner) {
            let on_patch = OnPatch::new(context, run[0].owner);
            let places = (first..).zip(run).map(|(ix, point)| (of.slot(ix), point.place as usize));
            for (ix, place) in places.clone() {
                let at = of.points.at.get(place);
                let all = on_patch.at(of.lattice.place(place as u32), at.du, at.dv);
                self.lists().into_iter().zip(all).for_each(|(list, value)| list[ix] = value);
            }
            self.replace_by_variables(context, of, run[0].owner, places);
            first += run.len();
        }
    }

    /// Takes the texture coordinates of points on one patch, given as (entry, place), from its primitive's variables, if it
    /// has any.
    fn replace_by_variables(
        &mut self,
        context: &DisplaceContext,
        of: Displaced,
        patch: u32,
        points: impl Iterator<Item = (usize, usize)> + Clone,
    ) {
        let (primitive, info) = context.info(patch);
        let primitive = &context.scene.primitives[primitive as usize];
        if !has_variables(primitive) {
            return;
        }
        let uv: Vec<[f32; 2]> = points.clone().map(|(_, place)| of.lattice.place(place as u32)).collect();
        let (s, t) = texture_coordinates(context.frame, patch, &uv, primitive, info);
        for (slot, (ix, _)) in points.enumerate() {
            (self.s[ix], self.t[ix]) = (s[slot], t[slot]);
        }
    }
}

/// What the coordinates of points on a patch follow from.
struct OnPatch<'a> {
    params: [f32; 4],
    corners: &'a [[f32; 2]; 4],
    scale: f32,
}

impl<'a> OnPatch<'a> {
    fn new(context: &DisplaceContext<'a, '_>, patch: u32) -> Self {
        let [u0, u1, v0, v1] = context.frame.patches.patches[patch as usize].params;
        let primitive = &context.scene.primitives[context.info(patch).0 as usize];
        OnPatch {
            params: [u0, u1, v0, v1],
            corners: &primitive.attributes.texture_coordinates,
            scale: (u1 - u0).abs().max((v1 - v0).abs()),
        }
    }

    /// [`Self::at`] for a list of points.
    #[inline(always)]
    fn put_all(&self, [u, v]: [&[f32]; 2], [du, dv]: [Vec3Slice; 2], mut to: [&mut [f32]; 6]) {
        for first in (0..u.len()).step_by(LANES) {
            let (u, v): ([f32; LANES], [f32; LANES]) = (load(u, first), load(v, first));
            let du: [[f32; LANES]; 3] = [load(du.x, first), load(du.y, first), load(du.z, first)];
            let dv: [[f32; LANES]; 3] = [load(dv.x, first), load(dv.y, first), load(dv.z, first)];
            let mut all = [[0.0; LANES]; 6];
            for lane in 0..LANES {
                let along_u = Vec3::new(du[0][lane], du[1][lane], du[2][lane]);
                let along_v = Vec3::new(dv[0][lane], dv[1][lane], dv[2][lane]);
                let [u, v, s, t, stretch, scale] = self.at([u[lane], v[lane]], along_u, along_v);
                (all[0][lane], all[1][lane], all[2][lane]) = (u, v, s);
                (all[3][lane], all[4][lane], all[5][lane]) = (t, stretch, scale);
            }
            for (to, values) in to.iter_mut().zip(&all) {
                store(to, first, values);
            }
        }
    }

    /// u, v, s, t, stretch and scale of a point at (u, v) of the patch.
    #[inline(always)]
    fn at(&self, [u, v]: [f32; 2], du: Vec3, dv: Vec3) -> [f32; 6] {
        let [u0, u1, v0, v1] = self.params;
        let uv = [u0 + (u1 - u0) * u, v0 + (v1 - v0) * v];
        let [s, t] = [spanned(self.corners, 0, uv), spanned(self.corners, 1, uv)];
        let stretch = du.length_squared().max(dv.length_squared()).sqrt().max(f32::MIN_POSITIVE);
        [uv[0], uv[1], s, t, stretch, self.scale]
    }
}

impl DisplaceContext<'_, '_> {
    /// Makes offsets finite and keeps them within the bound.
    fn check(&self, primitive: u32, displacer: &Displacer, offsets: &mut Vec3s) {
        // A shader that keeps its word to the last bit may still be a rounding beyond it.
        let most = f64::from(displacer.bound) * 1.00001;
        // In single precision first.
        let surely = surely_within(most * most);
        let num_within = self.frame.surfaces.level.run(
            #[inline(always)]
            || {
                let all = offsets.slice(0..offsets.len());
                let is_within = |ix: usize| all.get(ix).length_squared() <= surely;
                (0..all.x.len()).fold(0, |num, ix| num + usize::from(is_within(ix)))
            },
        );
        if num_within == offsets.len() {
            return;
        }
        for ix in 0..offsets.len() {
            let offset = offsets.get(ix).as_dvec3();
            if offset.length_squared() <= most * most {
                continue;
            }
            let length = offset.length();
            let finite = length.is_finite();
            self.corrections.borrow_mut().note(primitive, if finite { length as f32 } else { 0.0 }, !finite);
            let within = offset * (f64::from(displacer.bound) / length);
            offsets.set(ix, if finite { within.as_vec3() } else { Vec3::ZERO });
        }
    }
}
