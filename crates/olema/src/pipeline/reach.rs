//! Reach: how far displacement may move the points of a piece.
//!
//! In: a piece and the control points that hold it. Out: a length in camera space. What a shader says of its amplitude is
//! for all of space; where the piece is, it is often half of that, and much more of the piece is known to be hidden or
//! beside a tile before it is diced. It decides what is skipped, never where anything is.

use glam::Vec3;

use crate::geometry::hull::Hull;
use crate::math::lanes::Lanes;
use crate::math::simd::{LANES, LanesKernel, SimdLevel};
use crate::shading::{Balls, ROUNDING};

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
            Some(displacer)
                if patch.reach > 0.0
                    && patch.moves_alone
                    && piece.kind == PieceKind::Quad
                    && displacer.shader.knows_reach() =>
            {
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
        let balls = level.run_lanes(BallsKernel { hull, apart });
        let balls = level.run(
            #[inline(always)]
            || balls.moved(&spaces.to_object, spaces.most_shrink),
        );
        part = part.max(displacer.shader.reach(&balls).map_or(1.0, |reach| reach / displacer.bound));
    }
    displacer.bound_cam * part.min(1.0)
}

/// Finds balls that hold the hull, and what is `apart` from it: around the parts of a box that lies as the hull does.
struct BallsKernel<'a> {
    hull: &'a Hull,
    apart: f32,
}

impl LanesKernel for BallsKernel<'_> {
    type Output = Balls;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Balls {
        let points = &self.hull.points;
        let first = point(points, 0);
        let [mut x, mut y, mut z] = [lanes.splat_f(0.0); 3];
        let mut is_number = lanes.mask(0xffff);
        for (axis, (to, first)) in [&mut x, &mut y, &mut z].into_iter().zip(first.to_array()).enumerate() {
            *to = lanes.sub_f(lanes.load_f(&points[axis], 0), lanes.splat_f(first));
            is_number = lanes.both(is_number, lanes.le_f(lanes.abs_f(*to), lanes.splat_f(f32::MAX)));
        }
        let axes = axes(points);
        let (mut from, mut size) = ([0.0; 3], [0.0; 3]);
        for ((from, size), axis) in from.iter_mut().zip(&mut size).zip(axes) {
            let [ax, ay, az] = [lanes.splat_f(axis.x), lanes.splat_f(axis.y), lanes.splat_f(axis.z)];
            let along = lanes.add_f(lanes.mul_f(ax, x), lanes.mul_f(ay, y));
            let along = lanes.add_f(along, lanes.mul_f(az, z));
            *from = lanes.least_f(along);
            *size = lanes.greatest_f(along) - *from;
        }
        // Roundings of where points and centres are, by how far they may be from the origin.
        let rounding = ROUNDING * (first.length() + 2.0 * Vec3::from(size).length());
        // 16 parts: the longest side is halved four times.
        let mut halved = [0u32; 3];
        for _ in 0..LANES.ilog2() {
            let [x, y, z] = size;
            let longest = if x >= y.max(z) { 0 } else { 1 + usize::from(z > y) };
            size[longest] *= 0.5;
            halved[longest] += 1;
        }
        let radius = 0.5 * Vec3::from(size).length() * 1.0001 + self.apart + rounding;
        let exists = lanes.bits(is_number) == 0xffff && radius.is_finite();
        let mut centers = [lanes.splat_f(first.x), lanes.splat_f(first.y), lanes.splat_f(first.z)];
        let numbers = lanes.load(&NUMBERS, 0);
        let mut bit = 0;
        for axis in 0..3 {
            // The bits of a ball's number that tell its part of this side.
            let part = lanes.shr_each(numbers, lanes.splat(bit));
            let part = lanes.to_f(lanes.and(part, lanes.splat((1 << halved[axis]) - 1)));
            let part = lanes.add_f(part, lanes.splat_f(0.5));
            let place = lanes.add_f(lanes.splat_f(from[axis]), lanes.mul_f(lanes.splat_f(size[axis]), part));
            for (center, along) in centers.iter_mut().zip(axes[axis].to_array()) {
                *center = lanes.add_f(*center, lanes.mul_f(lanes.splat_f(along), place));
            }
            bit += halved[axis] as i32;
        }
        let radius = if exists { radius } else { f32::INFINITY };
        let mut balls = Balls { centers: [[0.0; LANES]; 3], radius };
        for (to, center) in balls.centers.iter_mut().zip(centers) {
            lanes.store_f(center, to, 0);
        }
        balls
    }
}

/// Numbers of lanes.
const NUMBERS: [i32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// Axes that are perpendicular to each other and lie as the sides of a lattice of control points do; any other axes hold
/// the hull as well, if not as closely.
#[inline(always)]
fn axes(points: &[[f32; LANES]; 3]) -> [Vec3; 3] {
    let diagonal = point(points, LANES - 1) - point(points, 0);
    let other = point(points, 3) - point(points, LANES - 4);
    let sides =
        if diagonal == Vec3::ZERO { farthest_two(points) } else { [diagonal + other, diagonal - other] };
    let is_longer = sides[0].length_squared() >= sides[1].length_squared();
    let [long, short] = if is_longer { sides } else { [sides[1], sides[0]] };
    let along = long.normalize_or(Vec3::X);
    let off = short - along * along.dot(short);
    let off = off - along * along.dot(off);
    let across = off.try_normalize().unwrap_or_else(
        #[inline(always)]
        || along.any_orthonormal_vector(),
    );
    [along, across, along.cross(across)]
}

/// One of some vectors.
#[inline(always)]
fn point([x, y, z]: &[[f32; LANES]; 3], ix: usize) -> Vec3 {
    Vec3::new(x[ix], y[ix], z[ix])
}

/// The longest way from the first of some points to another, and the one that is farthest off its direction.
#[cold]
fn farthest_two(points: &[[f32; LANES]; 3]) -> [Vec3; 2] {
    let ways: [Vec3; LANES] = std::array::from_fn(|ix| point(points, ix) - point(points, 0));
    let longest = |ways: &[Vec3]| {
        ways.iter().fold(Vec3::ZERO, |a, &b| if b.length_squared() > a.length_squared() { b } else { a })
    };
    let long = longest(&ways);
    let along = long.normalize_or(Vec3::X);
    [long, longest(&ways.map(|way| way - along * along.dot(way)))]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{hash32, signed_unit};

    #[test]
    fn what_is_folded_or_endless_has_balls_too() {
        let random = |n: u32| signed_unit(hash32(n));
        // Ends that meet: there is no diagonal.
        let mut points: [Vec3; 16] =
            std::array::from_fn(|n| Vec3::from([0, 100, 200].map(|axis| random(axis + n as u32))));
        points[15] = points[0];
        for level in SimdLevel::all() {
            let balls = level.run_lanes(BallsKernel { hull: &Hull::of(points), apart: 0.0 });
            for p in points {
                let is_in = |ball: usize| {
                    Vec3::from(balls.centers.map(|axis| axis[ball])).distance(p) <= balls.radius * 1.001
                };
                assert!((0..LANES).any(is_in), "{p} {level:?}");
            }
            let same = level.run_lanes(BallsKernel { hull: &Hull::of([Vec3::ONE]), apart: 0.5 });
            assert_eq!(same.centers, [[1.0; LANES]; 3], "{level:?}");
            assert!((0.5..0.50001).contains(&same.radius), "{level:?}");
            for wrong in [f32::NAN, f32::INFINITY, f32::MAX] {
                let mut points = points;
                points[7].y = wrong;
                points[9].y = -wrong;
                let balls = level.run_lanes(BallsKernel { hull: &Hull::of(points), apart: 0.0 });
                assert_eq!(balls.radius, f32::INFINITY, "{level:?}");
            }
        }
    }

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
                let balls = level.run_lanes(BallsKernel { hull: &hull, apart: 1e-5 });
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
