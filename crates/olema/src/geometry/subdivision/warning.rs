//! What can be wrong with a control mesh. None of it stops the rest from being drawn.

use std::fmt;

/// Something wrong or unusual in a [`SubdivisionMesh`](crate::scene::SubdivisionMesh), and what was done.
/// Faces, vertices and creases are counted from 0, as in the mesh; fields are named for what they count.
#[allow(missing_docs)]
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum MeshWarning {
    /// The face's vertex list is shorter than its count; it and all later faces were left out.
    MissingIndices { face: u32, expected: usize, found: usize },
    /// The face names a vertex that does not exist; it was left out.
    FaceIndex { face: u32, index: i32, num_vertices: usize },
    /// The face has fewer than 3 distinct vertices; it was left out.
    DegenerateFace { face: u32, distinct: usize },
    /// The face visits a vertex twice. Neighbouring repeats were merged; otherwise it was left out.
    RepeatedVertex { face: u32, vertex: u32, merged: bool },
    /// The face has the vertices of an earlier one in the same order; it was left out.
    DuplicateFace { face: u32, of: u32 },
    /// The face has no area; it was kept.
    ZeroArea { face: u32 },
    /// A coordinate of the vertex is not finite; the face that uses it was left out.
    NonFinite { face: u32, vertex: u32 },
    /// Under Loop, a face with more than 3 vertices was cut into triangles.
    NotATriangle { face: u32, count: usize },
    /// More than two faces share the edge, or two run along it in the same direction; it became an
    /// infinitely sharp crease with a border on each face's side.
    NonManifoldEdge { vertices: [u32; 2], faces: u32 },
    /// Several fans of faces meet in the vertex alone; it became an infinitely sharp corner.
    NonManifoldVertex { vertex: u32, fans: u32 },
    /// The crease runs along an edge that no face has; that edge was left out.
    CreaseEdge { crease: u32, vertices: [i32; 2] },
    /// The crease has too few vertices or a sharpness count that does not fit; it was left out.
    CreaseShape { crease: u32, vertices: usize, sharpness: usize },
    /// The sharpness is negative or no number; the crease or corner was left out.
    Sharpness { what: &'static str, index: u32, sharpness: f32 },
    /// The corner's vertex does not exist; it was left out.
    CornerIndex { corner: u32, vertex: i32 },
    /// The hole's face does not exist; it was left out.
    HoleIndex { hole: u32, face: i32 },
    /// A key has another number of points than the first; keys from there on were left out.
    KeyLength { key: usize, expected: usize, found: usize },
    /// The primitive variable has the wrong number of values; it was left out.
    VarLength { name: String, expected: usize, found: usize },
    /// More of the kind above were found than are kept.
    More { count: usize },
}

impl fmt::Display for MeshWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        use MeshWarning as W;
        match self {
            W::MissingIndices { face, expected, found } => {
                write!(
                    f,
                    "face {face} needs {expected} vertices, {found} are left; faces from here on left out"
                )
            }
            W::FaceIndex { face, index, num_vertices } => {
                write!(f, "face {face} names vertex {index} of {num_vertices}; face left out")
            }
            W::DegenerateFace { face, distinct } => {
                write!(f, "face {face} has {distinct} distinct vertices, expected at least 3; face left out")
            }
            W::RepeatedVertex { face, vertex, merged: true } => {
                write!(f, "face {face} repeats vertex {vertex}; merged")
            }
            W::RepeatedVertex { face, vertex, merged: false } => {
                write!(f, "face {face} visits vertex {vertex} twice; face left out")
            }
            W::DuplicateFace { face, of } => write!(f, "face {face} is face {of} again; left out"),
            W::ZeroArea { face } => write!(f, "face {face} has no area"),
            W::NonFinite { face, vertex } => {
                write!(f, "vertex {vertex} is not a finite point; face {face} left out")
            }
            W::NotATriangle { face, count } => {
                write!(f, "face {face} has {count} vertices, Loop takes 3; cut into triangles")
            }
            W::NonManifoldEdge { vertices: [a, b], faces } => {
                write!(f, "edge {a}-{b} is not manifold ({faces} faces); made infinitely sharp")
            }
            W::NonManifoldVertex { vertex, fans } => {
                write!(f, "vertex {vertex} is not manifold ({fans} fans of faces); made a sharp corner")
            }
            W::CreaseEdge { crease, vertices: [a, b] } => {
                write!(f, "crease {crease} names edge {a}-{b}, which no face has; ignored there")
            }
            W::CreaseShape { crease, vertices, sharpness } => {
                write!(
                    f,
                    "crease {crease} has {vertices} vertices and {sharpness} sharpness values, expected n and 1 or n - 1"
                )
            }
            W::Sharpness { what, index, sharpness } => {
                write!(f, "{what} {index} has sharpness {sharpness}, expected 0 or more; ignored")
            }
            W::CornerIndex { corner, vertex } => {
                write!(f, "corner {corner} names vertex {vertex}, which does not exist")
            }
            W::HoleIndex { hole, face } => write!(f, "hole {hole} names face {face}, which does not exist"),
            W::KeyLength { key, expected, found } => {
                write!(f, "key {key} has {found} points, expected {expected}; keys from here on left out")
            }
            W::VarLength { name, expected, found } => {
                write!(f, "variable \"{name}\" has {found} numbers, expected {expected}; left out")
            }
            W::More { count } => write!(f, "{count} more warnings about this mesh"),
        }
    }
}

/// Collects warnings up to a number that a message list can bear.
#[derive(Debug, Default)]
pub(super) struct Warnings {
    list: Vec<MeshWarning>,
    more: usize,
}

impl Warnings {
    /// Warnings kept.
    const MOST: usize = 1000;

    pub(super) fn push(&mut self, warning: MeshWarning) {
        if self.list.len() < Self::MOST {
            self.list.push(warning);
        } else {
            self.more += 1;
        }
    }

    pub(super) fn finish(mut self) -> Vec<MeshWarning> {
        if self.more > 0 {
            self.list.push(MeshWarning::More { count: self.more });
        }
        self.list
    }
}
