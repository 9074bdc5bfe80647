//! Faces: the control mesh's face lists with everything undefined taken out.
//!
//! In: a [`SubdivisionMesh`]. Out: [`Faces`], every one a simple polygon of at least three distinct, finite
//! vertices, and where each came from.

use std::collections::HashMap;

use glam::DVec3;

use super::warning::{MeshWarning, Warnings};
use crate::scene::{Scheme, SubdivisionMesh};

/// Faces as lists of vertices. Corner c of face f is `start[f] + c`.
#[derive(Debug, Clone, Default)]
pub(super) struct Faces {
    /// First corner of each face, and the number of corners.
    pub(super) start: Vec<u32>,
    /// Vertex of each corner.
    pub(super) vertex: Vec<u32>,
    /// The mesh's face behind each face.
    pub(super) source_face: Vec<u32>,
    /// The mesh's corner (place in `indices`) behind each corner.
    pub(super) source_corner: Vec<u32>,
}

impl Faces {
    pub(super) fn len(&self) -> usize {
        self.source_face.len()
    }

    /// Corners of a face.
    pub(super) fn corners(&self, face: u32) -> std::ops::Range<u32> {
        self.start[face as usize]..self.start[face as usize + 1]
    }

    /// Vertices of a face.
    pub(super) fn vertices(&self, face: u32) -> &[u32] {
        let c = self.corners(face);
        &self.vertex[c.start as usize..c.end as usize]
    }

    fn push(&mut self, source: u32, corners: &[(u32, u32)]) {
        self.source_face.push(source);
        self.vertex.extend(corners.iter().map(|c| c.0));
        self.source_corner.extend(corners.iter().map(|c| c.1));
        self.start.push(self.vertex.len() as u32);
    }
}

/// Takes the faces of `mesh` that are defined.
pub(super) fn clean(mesh: &SubdivisionMesh, warnings: &mut Warnings) -> Faces {
    let mut faces = Faces { start: vec![0], ..Faces::default() };
    let mut seen = HashMap::new();
    let mut next = 0usize;
    let mut corners = Vec::new();
    for (face, &count) in mesh.face_vertex_counts.iter().enumerate() {
        let face = face as u32;
        let count = count.max(0) as usize;
        let Some(indices) = mesh.indices.get(next..next + count) else {
            let found = mesh.indices.len() - next;
            warnings.push(MeshWarning::MissingIndices { face, expected: count, found });
            break;
        };
        corners.clear();
        corners.extend(indices.iter().zip(next as u32..).map(|(&v, c)| (v as u32, c)));
        next += count;
        if !is_defined(mesh, face, &mut corners, warnings) {
            continue;
        }
        if let Some(&of) = seen.get(&canonical(&corners)) {
            warnings.push(MeshWarning::DuplicateFace { face, of });
            continue;
        }
        seen.insert(canonical(&corners), face);
        if has_no_area(mesh, &corners) {
            warnings.push(MeshWarning::ZeroArea { face });
        }
        if mesh.scheme == Scheme::Loop && corners.len() > 3 {
            warnings.push(MeshWarning::NotATriangle { face, count });
            for i in 1..corners.len() - 1 {
                faces.push(face, &[corners[0], corners[i], corners[i + 1]]);
            }
        } else {
            faces.push(face, &corners);
        }
    }
    faces
}

/// Whether a face can be drawn; merges vertices that follow themselves.
fn is_defined(
    mesh: &SubdivisionMesh,
    face: u32,
    corners: &mut Vec<(u32, u32)>,
    warnings: &mut Warnings,
) -> bool {
    let num_vertices = mesh.points.first().len();
    if let Some(&(v, _)) = corners.iter().find(|c| c.0 as usize >= num_vertices) {
        warnings.push(MeshWarning::FaceIndex { face, index: v as i32, num_vertices });
        return false;
    }
    let finite = |v: u32| {
        let key = |k: &Vec<[f32; 3]>| k.get(v as usize).is_none_or(|p| p.iter().all(|x| x.is_finite()));
        mesh.points.values.iter().all(key)
    };
    if let Some(&(vertex, _)) = corners.iter().find(|c| !finite(c.0)) {
        warnings.push(MeshWarning::NonFinite { face, vertex });
        return false;
    }
    let mut sorted: Vec<u32> = corners.iter().map(|c| c.0).collect();
    sorted.sort_unstable();
    let twice = sorted.windows(2).find(|w| w[0] == w[1]).map(|w| w[0]);
    sorted.dedup();
    if sorted.len() < 3 {
        warnings.push(MeshWarning::DegenerateFace { face, distinct: sorted.len() });
        return false;
    }
    if let Some(vertex) = twice {
        corners.dedup_by_key(|c| c.0);
        if corners[0].0 == corners[corners.len() - 1].0 {
            corners.pop();
        }
        let merged = corners.len() == sorted.len();
        warnings.push(MeshWarning::RepeatedVertex { face, vertex, merged });
        return merged;
    }
    true
}

/// The vertices of a face from its lowest one on: the same for the same face.
fn canonical(corners: &[(u32, u32)]) -> Box<[u32]> {
    let n = corners.len();
    let first = (0..n).min_by_key(|&i| corners[i].0).unwrap_or(0);
    (0..n).map(|i| corners[(first + i) % n].0).collect()
}

/// Whether the polygon of the first key spans no area (Newell's normal is nothing against its edges).
fn has_no_area(mesh: &SubdivisionMesh, corners: &[(u32, u32)]) -> bool {
    let points = mesh.points.first();
    let at = |i: usize| DVec3::from(points[corners[i % corners.len()].0 as usize].map(f64::from));
    let (mut area, mut longest) = (DVec3::ZERO, 0.0f64);
    for i in 0..corners.len() {
        area += (at(i) - at(0)).cross(at(i + 1) - at(0));
        longest = longest.max((at(i + 1) - at(i)).length_squared());
    }
    area.length() <= 1e-10 * longest
}
