//! Reach: how far displacement may move the points of a piece.
//!
//! In: a piece and the control points that hold it. Out: a length in camera space. What a shader says of its amplitude is
//! for all of space; where the piece is, it is often half of that, and much more of the piece is known to be hidden or
//! beside a tile before it is diced. It decides what is skipped, never where anything is.

use glam::Vec3;

use crate::geometry::hull::Hull;
use crate::math::simd::LANES;
use crate::shading::Balls;

use super::displace::Displacer;
use super::piece::{Piece, PieceKind};
use super::split::SplitContext;

impl SplitContext<'_> {
    /// How far displacement may move the points of `piece`, in camera space. `hulls` holds it at each key, but for what is
    /// `apart` from it.
    pub(super) fn reach(&self, piece: &Piece, hulls: &[Hull], apart: f32) -> f32 {
        let patch = self.patch(piece.patch);
        let displacer = self.infos[patch.primitive as usize].displacement.as_ref();
        match displacer {
            // A block of a lattice has vertices on the whole of its quad's sides.
            Some(displacer) if patch.reach > 0.0 && patch.moves_alone && piece.kind == PieceKind::Quad => {
                let measure = || most_of_keys(displacer, hulls, apart);
                if piece.path == 1 { self.edges.known.reach(piece.patch, measure) } else { measure() }
            }
            _ => patch.reach,
        }
    }
}

/// The most at any key.
fn most_of_keys(displacer: &Displacer, hulls: &[Hull], apart: f32) -> f32 {
    let mut part = 0.0f32;
    for (hull, spaces) in hulls.iter().zip(&displacer.spaces) {
        let balls = balls(hull, apart).moved(&spaces.to_object, spaces.most_shrink);
        part = part.max(displacer.shader.reach(&balls).map_or(1.0, |reach| reach / displacer.bound));
    }
    displacer.bound_cam * part.min(1.0)
}

/// Balls that hold the hull, and what is `apart` from it: around the parts of a box that lies as the hull does.
fn balls(hull: &Hull, apart: f32) -> Balls {
    let [x, y, z] = &hull.points;
    let first = Vec3::new(x[0], y[0], z[0]);
    let at = |ix: usize| Vec3::new(x[ix], y[ix], z[ix]) - first;
    let mut along = Vec3::ZERO;
    for ix in 1..LANES {
        along = if at(ix).length_squared() > along.length_squared() { at(ix) } else { along };
    }
    let along = along.normalize_or(Vec3::X);
    let mut across = Vec3::ZERO;
    for ix in 1..LANES {
        let off = at(ix) - along * along.dot(at(ix));
        across = if off.length_squared() > across.length_squared() { off } else { across };
    }
    let across = across.normalize_or(along.any_orthonormal_vector());
    let axes = [along, across, along.cross(across)];
    let (mut from, mut to) = ([0.0f32; 3], [0.0f32; 3]);
    for ix in 1..LANES {
        for axis in 0..3 {
            let place = axes[axis].dot(at(ix));
            (from[axis], to[axis]) = (from[axis].min(place), to[axis].max(place));
        }
    }
    // 16 parts: the longest side is halved four times.
    let mut size = [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
    let mut count = [1; 3];
    for _ in 0..LANES.ilog2() {
        let longest = if size[0] >= size[1].max(size[2]) { 0 } else { 1 + usize::from(size[2] > size[1]) };
        size[longest] *= 0.5;
        count[longest] *= 2;
    }
    let mut balls = Balls { centers: [[0.0; LANES]; 3], radius: 0.0 };
    for ball in 0..LANES {
        let part = [ball % count[0], ball / count[0] % count[1], ball / (count[0] * count[1])];
        let mut center = first;
        for axis in 0..3 {
            center += axes[axis] * (from[axis] + size[axis] * (part[axis] as f32 + 0.5));
        }
        (balls.centers[0][ball], balls.centers[1][ball], balls.centers[2][ball]) =
            (center.x, center.y, center.z);
    }
    let radius = 0.5 * Vec3::from(size).length() * 1.0001 + apart;
    balls.radius = if radius.is_finite() { radius } else { f32::INFINITY };
    balls
}
