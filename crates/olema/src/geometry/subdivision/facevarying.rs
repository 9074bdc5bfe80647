//! Facevarying values as a mesh of their own: its vertices are the distinct values at each vertex.
//!
//! In: the topology of the positions, the values a face corner. Out: a [`ValueSheet`] whose borders are the
//! seams and whose sharpness encodes the [`FaceVaryingRule`]. Values at one vertex are one value if their
//! bits are equal. Inside a sheet the rule of the positions holds, creases and corners included. Exact are
//! `Linear`, `Smooth`, `CornersOnly` and `Boundaries`; the `CornersPlus` rules sharpen by counting values
//! and faces at a vertex as OpenSubdiv does, but do not tell a semi-sharp dart from a smooth one.

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
}

fn sharpen_values(values: &mut Topology, positions: &Topology, vertex_of: &[u32], rule: FaceVaryingRule) {
    let mut around = vec![AroundValue::default(); vertex_of.len()];
    let mut seen = vec![false; values.face.len()];
    let mut open_position = vec![false; positions.vertex_sharpness.len()];
    for c in 0..values.face.len() as u32 {
        let of = &mut around[values.vertex(c) as usize];
        of.faces += 1;
        for end in [c, positions.next(c)] {
            open_position[positions.vertex(end) as usize] |= positions.is_border(c);
        }
        if !seen[c as usize] {
            let fan = values.fan(c);
            fan.corners.iter().for_each(|&f| seen[f as usize] = true);
            of.fans += 1;
            of.open |= !fan.closed;
        }
    }
    let num_vertices = positions.vertex_sharpness.len();
    let (mut num_values, mut single) = (vec![0u32; num_vertices], vec![false; num_vertices]);
    for (of, &v) in around.iter().zip(vertex_of) {
        num_values[v as usize] += 1;
        single[v as usize] |= of.faces == 1;
    }
    for ((of, &v), sharpness) in around.iter().zip(vertex_of).zip(&mut values.vertex_sharpness) {
        let v = v as usize;
        let corner = of.open && of.faces == 1;
        let junction = num_values[v] > 2;
        let concave = num_values[v] == 2 && single[v];
        let dart = num_values[v] == 1 && of.open && !open_position[v];
        let sharp = of.fans > 1
            || match rule {
                FaceVaryingRule::Smooth | FaceVaryingRule::Linear => false,
                FaceVaryingRule::CornersOnly => corner,
                FaceVaryingRule::CornersPlus1 => corner || junction,
                FaceVaryingRule::CornersPlus2 => corner || junction || concave || dart,
                FaceVaryingRule::Boundaries => of.open,
            };
        *sharpness = if sharp { f32::INFINITY } else { positions.vertex_sharpness[v] };
    }
}
