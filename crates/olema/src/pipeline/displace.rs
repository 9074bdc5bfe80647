//! Displace: moves points along what a displacement shader says.
//!
//! In: points of patches, as (patch, u, v) with the shading rate that holds there. Out: their positions in
//! camera space. A point on a welded edge or corner is asked for on its owner, with inputs that are functions of
//! the edge alone: the owner's texture coordinates, the sum of the normals of all patches that meet there, and a
//! filter width that follows from the place and the edge's finest rate. Whoever dices it gets the same bits.
//!
//! The filter width is the side of a micropolygon at the point's depth. That needs no step along the edge, so
//! corners need no rule of their own, and a grid's own resolution never enters.

use std::cell::RefCell;
use std::sync::Arc;

use glam::{DMat3, DMat4, DVec3, Vec3};

use crate::geometry::SurfacePoint;
use crate::math::Vec3s;
use crate::scene::{Primitive, Scene};
use crate::shading::{DisplacementPoints, DisplacementShader, largest_stretch};

use super::connect::EdgeTable;
use super::dice::PrimitiveInfo;
use super::patch::{CORNER_UV, PatchTable, side_uv, unit_normal};
use super::piece::{PointRef, Sabotage};
use super::primvar::texture_coordinates;
use super::split::SplitContext;

/// A primitive's displacement, ready to use.
#[derive(Debug, Clone)]
pub struct Displacer {
    shader: Arc<dyn DisplacementShader>,
    /// At each motion key.
    spaces: Vec<Spaces>,
    /// Largest length of an offset that is let through, in object space.
    pub bound: f32,
    /// The same in camera space, at whichever key it is largest.
    pub bound_cam: f32,
    /// Only normals follow.
    pub is_bump: bool,
}

/// Object and camera space at a motion key.
#[derive(Debug, Clone, Copy)]
struct Spaces {
    to_camera: DMat4,
    to_object: DMat4,
    /// Object-space length of a camera-space unit, about.
    shrink: f32,
}

impl Displacer {
    /// The displacement of `primitive`, if it has one. The bound is the shader's amplitude where it knows it,
    /// and the smaller of that and the file's where both are given. `to_camera` is object to camera space at each key.
    pub fn new(primitive: &Primitive, to_camera: &[DMat4]) -> Option<Self> {
        let attributes = &primitive.attributes;
        let shader = Arc::clone(attributes.displacement.as_ref()?);
        let given = attributes.displacement_bound;
        let bound = match shader.amplitude() {
            Some(known) if given > 0.0 => known.abs().min(given),
            Some(known) => known.abs(),
            None => given.max(0.0),
        };
        let spaces = |&to_camera: &DMat4| {
            let to_object = to_camera.inverse();
            let shrink = crate::math::function::pow64(to_object.determinant().abs(), 1.0 / 3.0) as f32;
            Spaces { to_camera, to_object, shrink }
        };
        let spaces: Vec<Spaces> = to_camera.iter().map(spaces).collect();
        if !spaces.iter().all(|s| s.to_object.is_finite()) || !bound.is_finite() {
            return None;
        }
        let stretch = |m: &DMat4| largest_stretch(&DMat3::from_mat4(*m));
        let stretch = to_camera.iter().map(stretch).fold(0.0, f64::max);
        let is_bump = shader.is_bump();
        let bound_cam = if is_bump { 0.0 } else { (f64::from(bound) * stretch * 1.0001) as f32 };
        Some(Displacer { shader, spaces, bound, bound_cam, is_bump })
    }
}

/// What displacement had to correct, per primitive.
#[derive(Debug, Clone, Default)]
pub struct Corrections {
    /// Primitive, largest length that was asked for beyond the bound (0: none), whether an offset was not finite.
    entries: Vec<(u32, f32, bool)>,
}

impl Corrections {
    fn note(&mut self, primitive: u32, needed: f32, not_finite: bool) {
        match self.entries.iter_mut().find(|(p, ..)| *p == primitive) {
            Some((_, most, bad)) => {
                *most = most.max(needed);
                *bad |= not_finite;
            }
            None => self.entries.push((primitive, needed, not_finite)),
        }
    }

    /// Adds another worker's.
    pub fn add(&mut self, other: &Corrections) {
        other.entries.iter().for_each(|&(primitive, needed, bad)| self.note(primitive, needed, bad));
    }

    /// A sentence for each primitive, in the scene's order.
    pub fn warnings(&self, scene: &Scene, infos: &[PrimitiveInfo]) -> Vec<String> {
        let mut entries = self.entries.clone();
        entries.sort_unstable_by_key(|(primitive, ..)| *primitive);
        let mut warnings = Vec::new();
        for (primitive, needed, not_finite) in entries {
            let ix = primitive as usize;
            let name = scene.primitives[ix].attributes.object_name(ix);
            let bound = infos[ix].displacement.as_ref().map_or(0.0, |d| d.bound);
            if needed > 0.0 {
                warnings.push(format!(
                    "{name}: displacement went beyond its bound of {bound} and was clamped; {needed} is needed"
                ));
            }
            if not_finite {
                warnings
                    .push(format!("{name}: displacement was not a finite number; 0 was taken in its place"));
            }
        }
        warnings
    }
}

/// A point to place: where, and how finely it is sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Query {
    /// The patch it is evaluated on.
    pub patch: u32,
    /// Where on the patch.
    pub uv: [f32; 2],
    /// The patch there, at the motion key that was asked for.
    pub at: SurfacePoint,
    /// Unit normal of the surface there in camera space, turned by the orientation attribute.
    pub normal: Vec3,
    /// Area of a micropolygon in pixels.
    pub shading_rate: f32,
}

/// What displacing needs besides what splitting knows.
#[derive(Clone, Copy)]
pub struct DisplaceContext<'a, 'f> {
    /// The frame.
    pub frame: &'a SplitContext<'f>,
    /// The scene.
    pub scene: &'a Scene,
    /// All primitives.
    pub infos: &'a [PrimitiveInfo],
    /// Where corrections are noted.
    pub corrections: &'a RefCell<Corrections>,
}

impl DisplaceContext<'_, '_> {
    fn info(&self, patch: u32) -> (u32, &PrimitiveInfo) {
        let primitive = self.frame.patches.patches[patch as usize].primitive;
        (primitive, &self.infos[primitive as usize])
    }

    /// Whether any point of a patch, its border included, may move.
    pub fn is_displaced(&self, patch: u32) -> bool {
        self.frame.patches.patches[patch as usize].is_displaced
    }

    /// The normal of one patch at (u, v), turned by its orientation.
    fn own_normal(&self, patch: u32, key: usize, uv: [f32; 2], at: &SurfacePoint) -> Vec3 {
        if self.frame.sabotage == Some(Sabotage::EstimatedNormals) {
            return self.estimated_normal(patch, key, uv, at.p);
        }
        let normal = unit_normal(at).unwrap_or_else(|| self.frame.surfaces.normal(patch, key, uv));
        normal * self.info(patch).1.normal_sign
    }

    /// The normal of the triangle to the next points of the patch, a sixteenth of it away.
    fn estimated_normal(&self, patch: u32, key: usize, [u, v]: [f32; 2], p: Vec3) -> Vec3 {
        let step = |c: f32| if c > 0.5 { -1.0 / 16.0 } else { 1.0 / 16.0 };
        let (du, dv) = (step(u), step(v));
        let along_u = (self.frame.surfaces.evaluate(patch, key, [u + du, v]).p - p) / du;
        let along_v = (self.frame.surfaces.evaluate(patch, key, [u, v + dv]).p - p) / dv;
        along_u.cross(along_v).normalize_or_zero() * self.info(patch).1.normal_sign
    }

    /// A point inside the patch, at a motion key.
    pub fn inner(&self, patch: u32, key: usize, uv: [f32; 2]) -> Query {
        let at = self.frame.surfaces.evaluate(patch, key, uv);
        let shading_rate = self.frame.fineness[self.info(patch).0 as usize].shading_rate;
        Query { patch, uv, at, normal: self.own_normal(patch, key, uv, &at), shading_rate }
    }

    /// A point of a side: on its owner, with the sum of all normals that meet there. `own_uv` is where it lies on
    /// the patch that asks.
    pub fn border(&self, patch: u32, key: usize, point: PointRef, own_uv: [f32; 2]) -> Query {
        let (owner, uv) = self.frame.place(patch, point);
        let mut query = self.inner(owner, key, uv);
        let edges = self.frame.edges;
        let sabotage = self.frame.sabotage;
        let normal_of = |patch: u32, uv: [f32; 2]| self.inner(patch, key, uv).normal;
        let sum: Vec3 = match point {
            PointRef::Inside(_) => return query,
            PointRef::Corner(corner) => {
                query.shading_rate = edges.corners[corner as usize].shading_rate;
                let users = edges.corner_users(corner).iter();
                users.map(|user| normal_of(user.patch, CORNER_UV[user.corner as usize])).sum()
            }
            PointRef::Edge { edge, numerator, denominator } => {
                query.shading_rate = edges.edges[edge as usize].fineness.shading_rate;
                let users =
                    edges.edge_users(edge).iter().filter(|user| user.along.has(numerator, denominator));
                users
                    .map(|user| {
                        let (numerator, denominator) = user.along.own(numerator, denominator);
                        let t = super::piece::parameter(numerator, denominator);
                        normal_of(user.patch, side_uv(user.side as usize, t))
                    })
                    .sum()
            }
        };
        let length = sum.length();
        if sabotage == Some(Sabotage::Width) {
            query.shading_rate = self.frame.fineness[self.info(patch).0 as usize].shading_rate;
        }
        if matches!(sabotage, Some(Sabotage::Normal | Sabotage::EstimatedNormals)) {
            return Query { normal: self.inner(patch, key, own_uv).normal, ..query };
        }
        // Sides that face each other leave nothing: the owner's normal stands then.
        if length > 1e-3 {
            query.normal = sum / length;
        }
        query
    }

    /// Positions in camera space, displaced, of what was asked for at motion key `key`; `bump` says whether by bump
    /// shaders too.
    pub fn positions(&self, queries: &[Query], key: usize, bump: bool) -> Vec<Vec3> {
        let mut placed = vec![Vec3::ZERO; queries.len()];
        let mut order: Vec<usize> = (0..queries.len()).collect();
        let primitive = |ix: usize| self.info(queries[ix].patch).0;
        order.sort_by_key(|&ix| (primitive(ix), queries[ix].patch));
        for group in order.chunk_by(|&a, &b| primitive(a) == primitive(b)) {
            self.displace_group(queries, group, key, bump, &mut placed);
        }
        placed
    }

    /// Displaces points of one primitive, sorted by patch.
    fn displace_group(
        &self,
        queries: &[Query],
        group: &[usize],
        key: usize,
        bump: bool,
        placed: &mut [Vec3],
    ) {
        let (primitive_ix, info) = self.info(queries[group[0]].patch);
        let Some(displacer) = info.displacement.as_ref().filter(|d| bump || !d.is_bump) else {
            group.iter().for_each(|&ix| placed[ix] = queries[ix].at.p);
            return;
        };
        let spaces = &displacer.spaces[key];
        let points = self.inputs(queries, group, displacer, spaces);
        let mut offset = Vec3s::splat(Vec3::ZERO, group.len());
        displacer.shader.displace(&points, &mut offset);
        for (slot, &ix) in group.iter().enumerate() {
            let offset = self.checked(primitive_ix, displacer, offset.get(slot));
            let moved = spaces.to_camera.transform_vector3(offset.as_dvec3()).as_vec3();
            placed[ix] = queries[ix].at.p + moved;
        }
    }

    /// What a displacement shader sees of points of one primitive, sorted by patch.
    fn inputs(
        &self,
        queries: &[Query],
        group: &[usize],
        displacer: &Displacer,
        spaces: &Spaces,
    ) -> DisplacementPoints {
        let len = group.len();
        let floats = || Vec::with_capacity(len);
        let mut points = DisplacementPoints {
            p: Vec3s::with_capacity(len),
            n: Vec3s::with_capacity(len),
            u: floats(),
            v: floats(),
            s: floats(),
            t: floats(),
            width: floats(),
            st_width: floats(),
        };
        for query in group.iter().map(|&ix| &queries[ix]) {
            let at = &query.at;
            let [u0, u1, v0, v1] = self.frame.patches.patches[query.patch as usize].params;
            let width_cam = self.width(at.p, query.shading_rate);
            let scale = (u1 - u0).abs().max((v1 - v0).abs());
            let stretch = at.du.length().max(at.dv.length()).max(f32::MIN_POSITIVE);
            points.p.push(spaces.to_object.transform_point3(at.p.as_dvec3()).as_vec3());
            points.n.push(object_normal(spaces, query.normal));
            points.u.push(u0 + (u1 - u0) * query.uv[0]);
            points.v.push(v0 + (v1 - v0) * query.uv[1]);
            points.width.push(width_cam * spaces.shrink);
            points.st_width.push((width_cam / stretch * scale).min(1.0));
        }
        if !displacer.shader.reads_texture_coordinates() {
            points.s.resize(len, 0.0);
            points.t.resize(len, 0.0);
            points.st_width.fill(0.0);
            return points;
        }
        for of_patch in group.chunk_by(|&a, &b| queries[a].patch == queries[b].patch) {
            let patch = queries[of_patch[0]].patch;
            let (primitive, info) = self.info(patch);
            let uv: Vec<[f32; 2]> = of_patch.iter().map(|&ix| queries[ix].uv).collect();
            let primitive = &self.scene.primitives[primitive as usize];
            let (s, t) = texture_coordinates(self.frame, patch, &uv, primitive, info);
            points.s.extend(s);
            points.t.extend(t);
        }
        points
    }

    /// The offset, finite and within the bound.
    fn checked(&self, primitive: u32, displacer: &Displacer, offset: Vec3) -> Vec3 {
        let length = offset.as_dvec3().length();
        if !length.is_finite() {
            self.corrections.borrow_mut().note(primitive, 0.0, true);
            return Vec3::ZERO;
        }
        // A shader that keeps its word to the last bit may still be a rounding beyond it.
        if length <= f64::from(displacer.bound) * 1.00001 {
            return offset;
        }
        self.corrections.borrow_mut().note(primitive, length as f32, false);
        (offset.as_dvec3() * (f64::from(displacer.bound) / length)).as_vec3()
    }

    /// Side of a micropolygon in camera units at a point.
    fn width(&self, p: Vec3, shading_rate: f32) -> f32 {
        let camera = self.frame.camera;
        let depth = if camera.perspective { p.z.max(camera.near) } else { 1.0 };
        let scale = camera.scale[0].abs().min(camera.scale[1].abs());
        (shading_rate * self.frame.rate_scale).sqrt() * depth / scale
    }
}

/// A camera-space normal as a unit normal of object space.
fn object_normal(spaces: &Spaces, normal: Vec3) -> Vec3 {
    let n = spaces.to_camera.transpose().transform_vector3(normal.as_dvec3());
    let length = n.length();
    if length > 0.0 && length.is_finite() { (n / length).as_vec3() } else { DVec3::ZERO.as_vec3() }
}

/// Makes room for displacement in the patches' bounds: their own, and that of the patches that own their borders.
pub fn widen(patches: &mut PatchTable, edges: &EdgeTable, infos: &[PrimitiveInfo]) {
    let reach_of = |patch: u32, patches: &PatchTable| {
        let info = &infos[patches.patches[patch as usize].primitive as usize];
        info.displacement.as_ref().map_or(0.0, |d| d.bound_cam)
    };
    for ix in 0..patches.patches.len() {
        let patch = patches.patches[ix];
        let owners =
            patch.edges.iter().flat_map(|used| edges.edges[used.edge as usize].owners.map(|o| o.patch));
        let corners = patch.corners.iter().map(|&corner| edges.corners[corner as usize].owner);
        let most = owners
            .chain(corners)
            .filter(|&owner| owner != u32::MAX)
            .map(|owner| reach_of(owner, patches))
            .fold(reach_of(ix as u32, patches), f32::max);
        patches.patches[ix].slack += most;
        patches.patches[ix].is_displaced = most > 0.0;
    }
}
