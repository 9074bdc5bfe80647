//! Facevarying values as a mesh of their own: its vertices are the distinct values at each vertex.
//!
//! In: the topology of the positions, the values a face corner. Out: a [`ValueSheet`] whose borders are the
//! seams and whose sharpness encodes the [`FaceVaryingRule`]. Values at one vertex are one value if their
//! bits are equal. Inside a sheet the rule of the positions holds, creases and corners included. What a rule
//! makes sharp is what OpenSubdiv 3 makes sharp, by counting values and faces at a vertex.

use super::topology::Topology;
use crate::scene::FaceVaryingRule;

/// The mesh of one variable's values.
#[derive(Debug, Clone)]
pub(super) struct ValueSheet {
    pub(super) topology: Topology,
    /// Place of each value in the variable's array (a corner of the mesh as given).
    pub(super) source: Vec<u32>,
}

/// Makes the sheet of a variable of `width` floats a corner.
pub(super) fn value_sheet(
    positions: &Topology,
    values: &[f32],
    width: usize,
    rule: FaceVaryingRule,
) -> ValueSheet {
    let mut faces = positions.faces.clone();
    let mut source: Vec<u32> = Vec::new();
    let mut vertex_of: Vec<u32> = Vec::new();
    // The values of a vertex are a chain from its last one.
    let mut last = vec![u32::MAX; positions.vertex_sharpness.len()];
    let mut before: Vec<u32> = Vec::new();
    let value = |corner: u32| {
        let first = corner as usize * width;
        values[first..first + width].iter().map(|x| x.to_bits())
    };
    for c in 0..faces.vertex.len() {
        let vertex = faces.vertex[c] as usize;
        let corner = faces.source_corner[c];
        let mut id = last[vertex];
        while id != u32::MAX && !value(source[id as usize]).eq(value(corner)) {
            id = before[id as usize];
        }
        if id == u32::MAX {
            id = source.len() as u32;
            source.push(corner);
            vertex_of.push(vertex as u32);
            before.push(last[vertex]);
            last[vertex] = id;
        }
        faces.vertex[c] = id;
    }
    let mut topology = Topology::connect(faces, source.len());
    for c in 0..topology.edge.len() {
        let sharpness = positions.edges[positions.edge[c] as usize].sharpness;
        let edge = &mut topology.edges[topology.edge[c] as usize];
        if edge.joined {
            edge.sharpness = sharpness;
        }
    }
    sharpen_values(&mut topology, positions, &vertex_of, rule);
    ValueSheet { topology, source }
}

/// What is known of a value.
#[derive(Debug, Clone, Copy, Default)]
struct AroundValue {
    faces: u32,
    fans: u32,
    open: bool,
    /// Whether an infinite crease runs into it.
    creased: bool,
    /// Semi-sharp creases that run into it, and the sharpest of them.
    num_semi: u32,
    semi: f32,
}

/// What is known of the values of a vertex, taken together.
#[derive(Debug, Clone, Copy, Default)]
struct AroundVertex {
    num_values: u32,
    /// A value has one face.
    single: bool,
    /// A value comes in several parts, or an infinite crease runs into it.
    parted: bool,
    /// Sharpness of the sharpest semi-sharp crease.
    semi: f32,
    /// The vertex is on a border of the positions.
    open: bool,
}

fn sharpen_values(values: &mut Topology, positions: &Topology, vertex_of: &[u32], rule: FaceVaryingRule) {
    let around = around_values(values, vertex_of.len());
    let mut vertices = vec![AroundVertex::default(); positions.vertex_sharpness.len()];
    for (of, &v) in around.iter().zip(vertex_of) {
        let vertex = &mut vertices[v as usize];
        vertex.num_values += 1;
        vertex.single |= of.faces == 1;
        vertex.parted |= of.fans > 1 || of.creased;
        vertex.semi = vertex.semi.max(of.semi);
    }
    for c in 0..positions.face.len() as u32 {
        for end in [c, positions.next(c)] {
            vertices[positions.vertex(end) as usize].open |= positions.is_border(c);
        }
    }
    for ((of, &v), sharpness) in around.iter().zip(vertex_of).zip(&mut values.vertex_sharpness) {
        let own = positions.vertex_sharpness[v as usize];
        *sharpness = own.max(sharpness_of(of, &vertices[v as usize], rule));
    }
}

fn around_values(values: &Topology, num_values: usize) -> Vec<AroundValue> {
    let mut around = vec![AroundValue::default(); num_values];
    let mut seen = vec![false; values.face.len()];
    for c in 0..values.face.len() as u32 {
        let of = &mut around[values.vertex(c) as usize];
        of.faces += 1;
        if !seen[c as usize] {
            let fan = values.fan(c);
            fan.corners.iter().for_each(|&f| seen[f as usize] = true);
            of.fans += 1;
            of.open |= !fan.closed;
        }
    }
    for edge in values.edges.iter().filter(|edge| edge.joined && edge.sharpness > 0.0) {
        for value in edge.vertices {
            let of = &mut around[value as usize];
            if edge.sharpness == f32::INFINITY {
                of.creased = true;
            } else {
                (of.num_semi, of.semi) = (of.num_semi + 1, of.semi.max(edge.sharpness));
            }
        }
    }
    around
}

/// How sharp the rule makes a value, whatever its position is.
fn sharpness_of(of: &AroundValue, vertex: &AroundVertex, rule: FaceVaryingRule) -> f32 {
    use FaceVaryingRule::{Boundaries, CornersOnly, CornersPlus1, CornersPlus2, Linear, Smooth};
    let is_plus = matches!(rule, CornersPlus1 | CornersPlus2);
    let corner = of.open && of.faces == 1;
    let junction = vertex.num_values > 2 || vertex.num_values == 2 && vertex.parted;
    let concave = vertex.num_values == 2 && vertex.single;
    let dart = vertex.num_values == 1 && of.open && !vertex.open;
    let sharp = of.fans > 1
        || match rule {
            Smooth | Linear => false,
            CornersOnly => corner,
            CornersPlus1 => corner || junction,
            CornersPlus2 => corner || junction || concave || dart,
            Boundaries => of.open,
        };
    if sharp {
        f32::INFINITY
    } else if is_plus && vertex.num_values == 2 && of.num_semi == 0 {
        // The other one is sharp for a while, and this one as long.
        vertex.semi
    } else {
        0.0
    }
}
