//! Displace: moves points along what a displacement shader says.
//!
//! In: points of patches. Out: their positions in camera space. A point on a welded edge or corner is asked for on its
//! owner, with inputs that are functions of the edge alone: the owner's texture coordinates, the sum of the normals of
//! all patches that meet there ([`border`](super::border); where all are the same, the owner's), and a filter width that
//! follows from the place and the edge's finest rate. Whoever dices it gets the same bits. The points go through the
//! shaders in [`moving`](super::moving).

use std::cell::RefCell;
use std::sync::Arc;

use glam::{DMat3, DMat4, Mat4};

use crate::scene::{Primitive, Scene};
use crate::shading::{DisplacementShader, largest_stretch};

use super::dice::PrimitiveInfo;
use super::edges::EdgeTable;
use super::patch::PatchTable;
use super::piece::{PointRef, Sabotage};
use super::split::SplitContext;
use super::workspace::Workspace;

/// A primitive's displacement, ready to use.
#[derive(Debug, Clone)]
pub struct Displacer {
    /// The shader.
    pub shader: Arc<dyn DisplacementShader>,
    /// At each motion key.
    pub spaces: Vec<Spaces>,
    /// Largest length of an offset that is let through, in object space.
    pub bound: f32,
    /// The same in camera space, at whichever key it is largest.
    pub bound_cam: f32,
    /// Only normals follow.
    pub is_bump: bool,
}

/// Object and camera space at a motion key. In single precision, as points are: what is displaced has a rounding or two of
/// where it is, as it has anyway.
#[derive(Debug, Clone, Copy)]
pub struct Spaces {
    /// Object to camera space.
    pub to_camera: Mat4,
    /// Camera to object space.
    pub to_object: Mat4,
    /// The same for normals, which become 1 long at most.
    pub normal_to_object: Mat4,
    /// Object-space length of a camera-space unit, about.
    pub shrink: f32,
    /// The same at most.
    pub most_shrink: f32,
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
        let stretch = |m: &DMat4| largest_stretch(&DMat3::from_mat4(*m));
        let spaces = |&to_camera: &DMat4| {
            let to_object = to_camera.inverse();
            let shrink = crate::math::function::pow64(to_object.determinant().abs(), 1.0 / 3.0) as f32;
            let most_shrink = stretch(&to_object) as f32;
            let normal_to_object = (to_camera.transpose() * stretch(&to_camera).recip()).as_mat4();
            let (to_camera, to_object) = (to_camera.as_mat4(), to_object.as_mat4());
            Spaces { to_camera, to_object, normal_to_object, shrink, most_shrink }
        };
        let spaces: Vec<Spaces> = to_camera.iter().map(spaces).collect();
        let exist = |s: &Spaces| s.to_object.is_finite() && s.to_camera.is_finite();
        if !spaces.iter().all(exist) || !bound.is_finite() {
            return None;
        }
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
    /// Notes a correction: the length that was asked for (0: within the bound), whether it was not finite.
    pub fn note(&mut self, primitive: u32, needed: f32, not_finite: bool) {
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
    pub fn warnings(&self, scene: &Scene, infos: &[Arc<PrimitiveInfo>]) -> Vec<String> {
        let mut entries = self.entries.clone();
        entries.sort_unstable_by_key(|(primitive, ..)| *primitive);
        let mut warnings = Vec::new();
        for (primitive, needed, not_finite) in entries {
            let ix = primitive as usize;
            let name = scene.primitives[ix].object_name(ix);
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

/// What displacing needs besides what splitting knows.
#[derive(Clone, Copy)]
pub struct DisplaceContext<'a, 'f> {
    /// The frame.
    pub frame: &'a SplitContext<'f>,
    /// The scene.
    pub scene: &'a Scene,
    /// All primitives.
    pub infos: &'a [Arc<PrimitiveInfo>],
    /// Where corrections are noted.
    pub corrections: &'a RefCell<Corrections>,
    /// Lists to work with.
    pub workspace: &'a RefCell<Workspace>,
}

impl DisplaceContext<'_, '_> {
    /// Number and facts of a patch's primitive.
    pub fn info(&self, patch: u32) -> (u32, &PrimitiveInfo) {
        let primitive = self.frame.patches.patches[patch as usize].primitive;
        (primitive, &self.infos[primitive as usize])
    }

    /// Whether any point of a patch, its border included, may move.
    pub fn is_displaced(&self, patch: u32) -> bool {
        self.frame.patches.patches[patch as usize].reach > 0.0
    }

    /// +1 where the normal of a patch is dPdu x dPdv, -1 where it is the opposite.
    pub fn normal_sign(&self, patch: u32) -> f32 {
        self.info(patch).1.normal_sign
    }

    /// Shading rate at a border point: the finest of all patches there.
    pub fn border_rate(&self, patch: u32, point: PointRef) -> f32 {
        let edges = self.frame.edges;
        match point {
            _ if self.frame.sabotage == Some(Sabotage::Width) => self.shading_rate(patch),
            PointRef::Inside(_) => self.shading_rate(patch),
            PointRef::Corner(corner) => edges.corners[corner as usize].shading_rate,
            PointRef::Edge { edge, .. } => edges.edges[edge as usize].fineness.shading_rate,
        }
    }

    /// Shading rate of a patch's primitive.
    pub fn shading_rate(&self, patch: u32) -> f32 {
        self.frame.fineness[self.info(patch).0 as usize].shading_rate
    }
}

/// Notes how far displacement may move the patches' points: by their own shaders, and by those of the patches that own
/// their borders.
pub fn widen(patches: &mut PatchTable, edges: &EdgeTable, infos: &[Arc<PrimitiveInfo>]) {
    if let [info] = infos {
        let reach = info.displacement.as_ref().map_or(0.0, |d| d.bound_cam);
        patches.patches.iter_mut().for_each(|patch| patch.reach = reach);
        return;
    }
    for ix in 0..patches.patches.len() {
        let patch = patches.patches[ix];
        let owners =
            patch.edges.iter().flat_map(|used| edges.edges[used.edge as usize].owners.map(|o| o.patch));
        let corners = patch.corners.iter().map(|&corner| edges.corners[corner as usize].owner);
        let (mut reach, mut moves_alone) = (0.0f32, true);
        for owner in owners.chain(corners).filter(|&owner| owner != u32::MAX).chain([ix as u32]) {
            let primitive = patches.patches[owner as usize].primitive;
            moves_alone &= primitive == patch.primitive;
            let displacement = &infos[primitive as usize].displacement;
            reach = reach.max(displacement.as_ref().map_or(0.0, |d| d.bound_cam));
        }
        let patch = &mut patches.patches[ix];
        (patch.reach, patch.moves_alone) = (reach, moves_alone);
    }
}
