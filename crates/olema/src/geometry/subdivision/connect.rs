//! Base quads and how they hang together: what the pipeline welds by.
//!
//! Out: for each base quad its four edges and corners by id. An edge of the mesh has one id for all faces
//! along it. Where one of them is no quad the edge is split at its middle: the n-gon's quads name its
//! halves, a quad beside it names the whole, and [`EdgeRef::split`] tells it of the middle.

use super::topology::Topology;

/// How much of its edge a base quad runs along.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Piece {
    /// All of it.
    Whole,
    /// From the edge's beginning to its middle.
    FirstHalf,
    /// From the edge's middle to its end.
    SecondHalf,
}

/// One side of a base quad.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EdgeRef {
    /// The edge: below [`LimitSurface::num_mesh_edges`](super::LimitSurface::num_mesh_edges) an edge of the
    /// mesh, which begins at its lower vertex; from there on an inner edge of an n-gon, from the middle of a
    /// side to the middle of the face.
    pub edge: u32,
    /// Part of the edge.
    pub piece: Piece,
    /// The base quad's side runs against the edge's direction. Sides run as the corners follow each other:
    /// (0, 0), (1, 0), (1, 1), (0, 1) and back.
    pub reversed: bool,
    /// Another face needs a vertex at the edge's middle.
    pub split: bool,
    /// Faces on both sides may have normals of their own here: a border, or an edge with some sharpness
    /// (semi-sharp ones are smooth in the limit).
    pub kind: EdgeKind,
    /// Faces along the edge, drawn or not.
    pub num_faces: u32,
}

/// Whether the surface has a fold along an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EdgeKind {
    /// Not sharp at all.
    Smooth,
    /// Semi-sharp: tangents agree across it in the limit.
    SemiSharp,
    /// Infinitely sharp.
    Infinite,
    /// Border of the surface, or an edge that is not manifold.
    Border,
}

/// Where a base quad's corner lies on the control mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum CornerId {
    /// A vertex.
    Vertex(u32),
    /// The middle of an edge.
    EdgeMiddle(u32),
    /// The middle of a face, counted as the surface's faces are ([`BaseQuad::face`]).
    FaceMiddle(u32),
}

/// A base quad: the domain that is split and diced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BaseQuad {
    /// Face of the surface: faces of the mesh that are drawn or shape others, in their order; under Loop,
    /// triangles.
    pub face: u32,
    /// Corner of the face that the quad's (0, 0) lies at; always 0 for a quad.
    pub corner: u32,
    /// Face of the mesh as given, for uniform values.
    pub source_face: u32,
    /// Sides from (0, 0) to (1, 0), (1, 0) to (1, 1), (1, 1) to (0, 1), (0, 1) to (0, 0).
    pub edges: [EdgeRef; 4],
    /// Corners at (0, 0), (1, 0), (1, 1), (0, 1).
    pub corners: [CornerId; 4],
    /// Whether the surface has a tip there: the corner is a vertex that is infinitely sharp.
    pub tips: [bool; 4],
}

/// The base quad at corner `corner` of `face`; `whole` where the face is a base quad itself.
pub(super) fn base_quad(topology: &Topology, face: u32, corner: u32, whole: bool) -> BaseQuad {
    let corners = topology.faces.corners(face);
    let source_face = topology.faces.source_face[face as usize];
    if whole {
        let at = |i: u32| corners.start + i;
        return BaseQuad {
            face,
            corner,
            source_face,
            edges: [0, 1, 2, 3].map(|i| mesh_edge(topology, at(i), Piece::Whole)),
            corners: [0, 1, 2, 3].map(|i| CornerId::Vertex(topology.vertex(at(i)))),
            tips: [0, 1, 2, 3].map(|i| is_tip(topology, at(i))),
        };
    }
    let own = corners.start + corner;
    let prev = topology.prev(own);
    let middle = |c: u32| CornerId::EdgeMiddle(topology.edge[c as usize]);
    BaseQuad {
        face,
        corner,
        source_face,
        edges: [
            mesh_edge(topology, own, Piece::FirstHalf),
            inner_edge(topology, own, false),
            inner_edge(topology, prev, true),
            mesh_edge(topology, prev, Piece::SecondHalf),
        ],
        corners: [
            CornerId::Vertex(topology.vertex(own)),
            middle(own),
            CornerId::FaceMiddle(face),
            middle(prev),
        ],
        tips: [is_tip(topology, own), false, false, false],
    }
}

/// Whether the vertex at a corner is infinitely sharp.
fn is_tip(topology: &Topology, corner: u32) -> bool {
    topology.vertex_sharpness[topology.vertex(corner) as usize] == f32::INFINITY
}

/// The edge that leaves a corner; `piece` as seen along the face.
fn mesh_edge(topology: &Topology, corner: u32, piece: Piece) -> EdgeRef {
    let id = topology.edge[corner as usize];
    let edge = topology.edges[id as usize];
    let reversed = topology.vertex(corner) != edge.vertices[0];
    let piece = match piece {
        Piece::FirstHalf if reversed => Piece::SecondHalf,
        Piece::SecondHalf if reversed => Piece::FirstHalf,
        piece => piece,
    };
    let kind = match edge.sharpness {
        _ if !edge.joined => EdgeKind::Border,
        f32::INFINITY => EdgeKind::Infinite,
        s if s > 0.0 => EdgeKind::SemiSharp,
        _ => EdgeKind::Smooth,
    };
    EdgeRef { edge: id, piece, reversed, split: edge.split, kind, num_faces: edge.num_faces }
}

/// The inner edge of an n-gon that begins in the middle of the side leaving `corner`.
fn inner_edge(topology: &Topology, corner: u32, reversed: bool) -> EdgeRef {
    EdgeRef {
        edge: topology.edges.len() as u32 + corner,
        piece: Piece::Whole,
        reversed,
        split: false,
        kind: EdgeKind::Smooth,
        num_faces: 2,
    }
}
