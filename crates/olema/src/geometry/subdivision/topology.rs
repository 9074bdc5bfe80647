//! Topology: who touches whom, as tables that are made once and then never change.
//!
//! In: [`Faces`], tags. Out: [`Topology`], half-edge tables with sharpness. A half-edge is named by the
//! corner it leaves: corner c of a face stands for the edge from its vertex to the next corner's.
//!
//! Not manifold: an edge of three or more faces, or of two that run along it in the same direction, is
//! infinitely sharp and a border for each of its faces; faces are never neighbours across it. A vertex whose
//! faces form several fans is an infinitely sharp corner, but where the fans are all bounded by the same two
//! non-manifold edges and nothing else there is sharp, the crease runs smoothly through it. All faces of
//! such an edge so have one and the same curve.

use super::faces::Faces;
use super::warning::{MeshWarning, Warnings};
use crate::scene::{BoundaryRule, SubdivisionMesh};

/// No corner: the edge is a border.
pub(super) const NONE: u32 = u32::MAX;

/// Sharpness from which a crease or corner never rounds off.
const INFINITE_FROM: f32 = 10.0;

/// An edge of the mesh.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edge {
    /// Its vertices, ascending.
    pub(super) vertices: [u32; 2],
    /// Sharpness; infinite for borders, too.
    pub(super) sharpness: f32,
    /// Faces along it.
    pub(super) num_faces: u32,
    /// Whether two faces are neighbours across it; it is a border of each of its faces otherwise.
    pub(super) joined: bool,
    /// Whether one of its faces is no quad, so that it is split at its middle.
    pub(super) split: bool,
}

/// The tables.
#[derive(Debug, Clone)]
pub(super) struct Topology {
    pub(super) faces: Faces,
    /// Face of each corner.
    pub(super) face: Vec<u32>,
    /// The half-edge that runs the other way, or [`NONE`].
    pub(super) twin: Vec<u32>,
    /// Edge of each corner.
    pub(super) edge: Vec<u32>,
    /// Edges, ascending by their vertices.
    pub(super) edges: Vec<Edge>,
    /// Sharpness of each vertex.
    pub(super) vertex_sharpness: Vec<f32>,
    /// Faces that are not drawn.
    pub(super) hidden: Vec<bool>,
}

impl Topology {
    /// Connects faces along their common edges. Nothing but borders is sharp yet.
    pub(super) fn connect(faces: Faces, num_vertices: usize) -> Topology {
        let num_corners = faces.vertex.len();
        let mut t = Topology {
            face: vec![0; num_corners],
            twin: vec![NONE; num_corners],
            edge: vec![0; num_corners],
            edges: Vec::with_capacity(num_corners / 2 + 1),
            vertex_sharpness: vec![0.0; num_vertices],
            hidden: vec![false; faces.len()],
            faces,
        };
        let mut half_edges = Vec::with_capacity(num_corners);
        for face in 0..t.faces.len() as u32 {
            for c in t.faces.corners(face) {
                t.face[c as usize] = face;
                let (a, b) = (t.vertex(c), t.vertex(t.next(c)));
                half_edges.push((u64::from(a.min(b)) << 32 | u64::from(a.max(b)), c));
            }
        }
        half_edges.sort_unstable();
        for group in half_edges.chunk_by(|a, b| a.0 == b.0) {
            t.add_edge(group);
        }
        t
    }

    /// Adds the edge of all half-edges of one key.
    fn add_edge(&mut self, group: &[(u64, u32)]) {
        let id = self.edges.len() as u32;
        for &(_, c) in group {
            self.edge[c as usize] = id;
        }
        let mut joined = false;
        if let &[(_, a), (_, b)] = group
            && self.vertex(a) != self.vertex(b)
        {
            self.twin[a as usize] = b;
            self.twin[b as usize] = a;
            joined = true;
        }
        let sharpness = if joined { 0.0 } else { f32::INFINITY };
        let vertices = [(group[0].0 >> 32) as u32, group[0].0 as u32];
        let split = group.iter().any(|&(_, c)| self.faces.vertices(self.face[c as usize]).len() != 4);
        self.edges.push(Edge { vertices, sharpness, num_faces: group.len() as u32, joined, split });
    }

    /// Vertex of a corner.
    pub(super) fn vertex(&self, corner: u32) -> u32 {
        self.faces.vertex[corner as usize]
    }

    /// The corner after this one in its face.
    pub(super) fn next(&self, corner: u32) -> u32 {
        let c = self.faces.corners(self.face[corner as usize]);
        if corner + 1 == c.end { c.start } else { corner + 1 }
    }

    /// The corner before this one in its face.
    pub(super) fn prev(&self, corner: u32) -> u32 {
        let c = self.faces.corners(self.face[corner as usize]);
        if corner == c.start { c.end - 1 } else { corner - 1 }
    }

    /// Corners of the same vertex in the faces around it, counter-clockwise, from the border if there is
    /// one; whether they close; and the place of `corner` among them.
    pub(super) fn fan(&self, corner: u32) -> Fan {
        let mut corners = vec![corner];
        let mut at = 0;
        let mut c = corner;
        loop {
            c = self.twin[self.prev(c) as usize];
            if c == corner {
                return Fan { corners, closed: true, at };
            }
            if c == NONE {
                break;
            }
            corners.push(c);
        }
        // A border: what lies clockwise of `corner` comes first.
        let mut before = Vec::new();
        c = corner;
        while self.twin[c as usize] != NONE {
            c = self.next(self.twin[c as usize]);
            before.push(c);
        }
        at += before.len() as u32;
        before.reverse();
        before.append(&mut corners);
        Fan { corners: before, closed: false, at }
    }

    /// The edge between two vertices.
    pub(super) fn find_edge(&self, a: u32, b: u32) -> Option<u32> {
        let key = [a.min(b), a.max(b)];
        self.edges.binary_search_by_key(&key, |e| e.vertices).ok().map(|i| i as u32)
    }

    /// Whether no two faces are neighbours across the edge.
    pub(super) fn is_border(&self, corner: u32) -> bool {
        self.twin[corner as usize] == NONE
    }

    /// Bytes of the tables.
    pub(super) fn num_bytes(&self) -> usize {
        let corners = 5 * size_of::<u32>() * self.face.len();
        let faces = (2 * size_of::<u32>() + 1) * self.faces.len();
        corners + faces + size_of::<Edge>() * self.edges.len() + 4 * self.vertex_sharpness.len()
    }

    /// Sharpens edges and vertices by the mesh's tags and rules, and hides faces.
    pub(super) fn apply_tags(&mut self, mesh: &SubdivisionMesh, warnings: &mut Warnings) {
        // Which borders the mesh itself makes infinitely sharp, for the boundary rule 0.
        let mut tagged = vec![false; self.edges.len()];
        for (crease, chain) in mesh.creases.iter().enumerate() {
            self.apply_crease(crease as u32, chain, &mut tagged, warnings);
        }
        for (corner, &(vertex, sharpness)) in mesh.corners.iter().enumerate() {
            let corner = corner as u32;
            if !is_sharpness(sharpness) {
                warnings.push(MeshWarning::Sharpness { what: "corner", index: corner, sharpness });
            } else if let Some(s) = self.vertex_sharpness.get_mut(vertex as usize) {
                *s = as_infinite(sharpness);
            } else {
                warnings.push(MeshWarning::CornerIndex { corner, vertex });
            }
        }
        let mut hole = vec![false; mesh.face_vertex_counts.len()];
        for (ix, &face) in mesh.holes.iter().enumerate() {
            match hole.get_mut(face as usize) {
                Some(h) => *h = true,
                None => warnings.push(MeshWarning::HoleIndex { hole: ix as u32, face }),
            }
        }
        for (hidden, &source) in self.hidden.iter_mut().zip(&self.faces.source_face) {
            *hidden = hole[source as usize];
        }
        self.sharpen_vertices(mesh.boundary, warnings);
        if mesh.boundary == BoundaryRule::None {
            self.hide_border_faces(&tagged);
        }
    }

    fn apply_crease(
        &mut self,
        crease: u32,
        chain: &crate::scene::Crease,
        tagged: &mut [bool],
        warnings: &mut Warnings,
    ) {
        let (n, num_sharpness) = (chain.vertices.len(), chain.sharpness.len());
        if n < 2 || (num_sharpness != 1 && num_sharpness != n - 1) {
            warnings.push(MeshWarning::CreaseShape { crease, vertices: n, sharpness: num_sharpness });
            return;
        }
        for (i, pair) in chain.vertices.windows(2).enumerate() {
            let sharpness = chain.sharpness[if num_sharpness == 1 { 0 } else { i }];
            if !is_sharpness(sharpness) {
                warnings.push(MeshWarning::Sharpness { what: "crease", index: crease, sharpness });
                continue;
            }
            let Some(e) = self.find_edge(pair[0] as u32, pair[1] as u32) else {
                warnings.push(MeshWarning::CreaseEdge { crease, vertices: [pair[0], pair[1]] });
                continue;
            };
            tagged[e as usize] = as_infinite(sharpness) == f32::INFINITY;
            if self.edges[e as usize].joined {
                self.edges[e as usize].sharpness = as_infinite(sharpness);
            }
        }
    }

    /// Makes vertices that are not manifold sharp, and corners of the border where the rule says so.
    fn sharpen_vertices(&mut self, boundary: BoundaryRule, warnings: &mut Warnings) {
        for e in &self.edges {
            if e.num_faces > 1 && !e.joined {
                warnings.push(MeshWarning::NonManifoldEdge { vertices: e.vertices, faces: e.num_faces });
            }
        }
        let mut vertices = vec![AroundVertex::default(); self.vertex_sharpness.len()];
        self.count_fans(&mut vertices);
        self.count_sharp_edges(&mut vertices);
        for (v, around) in vertices.iter().enumerate() {
            if around.fans > 1 || around.non_manifold > 0 {
                let through =
                    around.non_manifold == 2 && around.sharp == 2 && !around.loops && around.closed == 0;
                if !through {
                    self.vertex_sharpness[v] = f32::INFINITY;
                    let (vertex, fans) = (v as u32, around.fans);
                    warnings.push(MeshWarning::NonManifoldVertex { vertex, fans });
                }
            } else if around.faces == 1 && boundary == BoundaryRule::EdgeAndCorner {
                self.vertex_sharpness[v] = f32::INFINITY;
            }
        }
    }

    fn count_fans(&self, vertices: &mut [AroundVertex]) {
        let mut seen = vec![false; self.face.len()];
        for c in 0..self.face.len() as u32 {
            let around = &mut vertices[self.vertex(c) as usize];
            around.faces += 1;
            if seen[c as usize] {
                continue;
            }
            let fan = self.fan(c);
            for &f in &fan.corners {
                seen[f as usize] = true;
            }
            around.fans += 1;
            around.closed += u32::from(fan.closed);
            let (first, last) = (fan.corners[0], self.prev(fan.corners[fan.corners.len() - 1]));
            around.loops |= !fan.closed && self.edge[first as usize] == self.edge[last as usize];
        }
    }

    fn count_sharp_edges(&self, vertices: &mut [AroundVertex]) {
        for e in &self.edges {
            for v in e.vertices {
                let around = &mut vertices[v as usize];
                around.sharp += u32::from(e.sharpness > 0.0);
                around.non_manifold += u32::from(e.num_faces > 1 && !e.joined);
            }
        }
    }

    /// Boundary rule 0: hides the faces of every vertex with a border edge that is no infinite crease.
    fn hide_border_faces(&mut self, tagged: &[bool]) {
        let mut open = vec![false; self.vertex_sharpness.len()];
        for c in 0..self.face.len() as u32 {
            if self.is_border(c) && !tagged[self.edge[c as usize] as usize] {
                open[self.vertex(c) as usize] = true;
                open[self.vertex(self.next(c)) as usize] = true;
            }
        }
        for face in 0..self.faces.len() as u32 {
            self.hidden[face as usize] |= self.faces.vertices(face).iter().any(|&v| open[v as usize]);
        }
    }
}

/// Faces around a vertex.
pub(super) struct Fan {
    /// The vertex's corner in each, counter-clockwise.
    pub(super) corners: Vec<u32>,
    /// Whether the last face touches the first.
    pub(super) closed: bool,
    /// Place of the corner that was asked for.
    pub(super) at: u32,
}

/// Counts about a vertex.
#[derive(Debug, Clone, Copy, Default)]
struct AroundVertex {
    faces: u32,
    fans: u32,
    closed: u32,
    non_manifold: u32,
    sharp: u32,
    /// An open fan begins and ends at the same edge.
    loops: bool,
}

fn is_sharpness(s: f32) -> bool {
    s >= 0.0
}

fn as_infinite(s: f32) -> f32 {
    if s >= INFINITE_FROM { f32::INFINITY } else { s }
}
