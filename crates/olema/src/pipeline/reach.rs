//! Reach: how far displacement may move the points of a piece.
//!
//! In: a piece and the control points that hold it. Out: a length in camera space. What a shader says of its amplitude is
//! for all of space; where the piece is, it is often half of that, and much more of the piece is known to be hidden or
//! beside a tile before it is diced. It decides what is skipped, never where anything is.

#![allow(clippy::needless_range_loop)] // A loop over lanes reads as what it becomes.

use glam::Vec3;

use crate::geometry::hull::Hull;
use crate::math::simd::{LANES, SimdLevel};
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
                let measure = || most_of_keys(self.surfaces.level, displacer, hulls, apart);
                if piece.path == 1 { self.edges.known.reach(piece.patch, measure) } else { measure() }
            }
            _ => patch.reach,
        }
    }
}

/// The most at any key.
fn most_of_keys(level: SimdLevel, displacer: &Displacer, hulls: &[Hull], apart: f32) -> f32 {
    let mut part = 0.0f32;
    for (hull, spaces) in hulls.iter().zip(&displacer.spaces) {
        let balls = level.run(
            #[inline(always)]
            || balls(hull, apart).moved(&spaces.to_object, spaces.most_shrink),
        );
        part = part.max(displacer.shader.reach(&balls).map_or(1.0, |reach| reach / displacer.bound));
    }
    displacer.bound_cam * part.min(1.0)
}

/// Balls that hold the hull, and what is `apart` from it: around the parts of a box that lies as the hull does.
#[inline(always)]
fn balls(hull: &Hull, apart: f32) -> Balls {
    let first = Vec3::new(hull.points[0][0], hull.points[1][0], hull.points[2][0]);
    let mut at = hull.points;
    for lane in 0..LANES {
        at[0][lane] -= first.x;
        at[1][lane] -= first.y;
        at[2][lane] -= first.z;
    }
    // As the sides of a lattice of control points lie; any other axes hold the hull as well, if not as closely.
    let (diagonal, other) = (lane(&at, LANES - 1), lane(&at, 3) - lane(&at, LANES - 4));
    let sides = if diagonal == Vec3::ZERO { farthest_two(&at) } else { [diagonal + other, diagonal - other] };
    let is_longer = sides[0].length_squared() >= sides[1].length_squared();
    let [long, short] = if is_longer { sides } else { [sides[1], sides[0]] };
    let along = long.normalize_or(Vec3::X);
    let off = short - along * along.dot(short);
    let off = off - along * along.dot(off);
    let across = off.try_normalize().unwrap_or_else(
        #[inline(always)]
        || along.any_orthonormal_vector(),
    );
    let axes = [along, across, along.cross(across)];
    let (mut from, mut size) = ([0.0; 3], [0.0; 3]);
    for axis in 0..3 {
        let ends = ends(&at, axes[axis]);
        (from[axis], size[axis]) = (ends[0], ends[1] - ends[0]);
    }
    // 16 parts: the longest side is halved four times.
    let mut halved = [0u32; 3];
    for _ in 0..LANES.ilog2() {
        let [x, y, z] = size;
        let longest = if x >= y.max(z) { 0 } else { 1 + usize::from(z > y) };
        for axis in 0..3 {
            let is_longest = axis == longest;
            size[axis] *= if is_longest { 0.5 } else { 1.0 };
            halved[axis] += u32::from(is_longest);
        }
    }
    let radius = 0.5 * Vec3::from(size).length() * 1.0001 + apart;
    let radius = if radius.is_finite() { radius } else { f32::INFINITY };
    let mut balls = Balls { centers: [[first.x; LANES], [first.y; LANES], [first.z; LANES]], radius };
    let mut bit = 0;
    for axis in 0..3 {
        let (along, mask) = (axes[axis].to_array(), (1u32 << halved[axis]) - 1);
        for ball in 0..LANES {
            let part = (ball as u32 >> bit & mask) as i32 as f32 + 0.5;
            let place = from[axis] + size[axis] * part;
            balls.centers[0][ball] += along[0] * place;
            balls.centers[1][ball] += along[1] * place;
            balls.centers[2][ball] += along[2] * place;
        }
        bit += halved[axis];
    }
    balls
}

/// One of some vectors.
#[inline(always)]
fn lane([x, y, z]: &[[f32; LANES]; 3], lane: usize) -> Vec3 {
    Vec3::new(x[lane], y[lane], z[lane])
}

/// The longest of some vectors, and the one that is farthest off its direction.
#[inline(always)]
fn farthest_two(at: &[[f32; LANES]; 3]) -> [Vec3; 2] {
    let long = farthest(at);
    let along = long.normalize_or(Vec3::X);
    let mut off = *at;
    for lane in 0..LANES {
        let part = along.x * at[0][lane] + along.y * at[1][lane] + along.z * at[2][lane];
        off[0][lane] -= along.x * part;
        off[1][lane] -= along.y * part;
        off[2][lane] -= along.z * part;
    }
    [long, farthest(&off)]
}

/// The longest of some vectors.
#[inline(always)]
fn farthest([x, y, z]: &[[f32; LANES]; 3]) -> Vec3 {
    let mut squares = [0.0; LANES];
    for lane in 0..LANES {
        squares[lane] = x[lane] * x[lane] + y[lane] * y[lane] + z[lane] * z[lane];
    }
    let mut longest = 0;
    for lane in 1..LANES {
        longest = if squares[lane] > squares[longest] { lane } else { longest };
    }
    Vec3::new(x[longest], y[longest], z[longest])
}

/// How far vectors reach along an axis, both ways.
#[inline(always)]
fn ends([x, y, z]: &[[f32; LANES]; 3], axis: Vec3) -> [f32; 2] {
    let (mut least, mut most) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        least[lane] = axis.x * x[lane] + axis.y * y[lane] + axis.z * z[lane];
    }
    most.copy_from_slice(&least);
    let mut half = LANES / 2;
    while half > 0 {
        for lane in 0..half {
            least[lane] = if least[lane + half] < least[lane] { least[lane + half] } else { least[lane] };
            most[lane] = if most[lane + half] > most[lane] { most[lane + half] } else { most[lane] };
        }
        half /= 2;
    }
    [least[0], most[0]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{hash32, signed_unit};

    #[test]
    fn balls_hold_what_the_hull_holds() {
        for seed in 0..40 {
            let random = |n: u32| signed_unit(hash32(1000 * seed + n));
            let stretch = Vec3::new(1.0, random(900), random(901) * 0.1);
            let points: [Vec3; 16] = std::array::from_fn(|ix| {
                Vec3::from([0, 1, 2].map(|axis| random(3 * ix as u32 + axis))) * stretch + Vec3::splat(7.0)
            });
            let hull = Hull::of(points);
            for level in SimdLevel::all() {
                let balls = level.run(
                    #[inline(always)]
                    || balls(&hull, 1e-5),
                );
                for n in 0..200 {
                    let weights: [f32; 16] =
                        std::array::from_fn(|ix| random(n * 16 + ix as u32).abs().powi(8));
                    let sum: f32 = weights.iter().sum();
                    let p = points.iter().zip(weights).map(|(&p, weight)| p * (weight / sum)).sum::<Vec3>();
                    let is_in = |ball: usize| {
                        let center = Vec3::from([0, 1, 2].map(|axis| balls.centers[axis][ball]));
                        center.distance(p) <= balls.radius
                    };
                    assert!((0..LANES).any(is_in), "{p} {balls:?} {level:?}");
                }
                let size = points.iter().map(|p| p.distance(points[0])).fold(0.0, f32::max);
                assert!(balls.radius < 0.5 * size, "{balls:?}");
            }
        }
    }
}
