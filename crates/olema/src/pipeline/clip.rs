//! Clip: micropolygons with a vertex on the slow path.
//!
//! In: a triangle in camera space, some of whose vertices lie in front of the near plane, beyond the far plane
//! or outside the guard band. Out: a convex polygon of raster vertices (a fan around its first one), each with
//! its depth and its weights in the triangle. A cut point is computed from the ends of its edge alone, from the
//! end that stays towards the one that goes, and plane after plane in one order: triangles that share the edge
//! get the same point.

use glam::{DVec3, Vec3};

use crate::geometry::camera::{GUARD_BAND_PX, RasterCamera, SUBPIXELS};
use crate::sampling::moving::scaled;

/// A vertex of a clipped triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClippedVertex {
    /// Raster position in 1/256 pixels.
    pub raster: [i32; 2],
    /// Depth.
    pub depth: f32,
    /// Weights of the triangle's three vertices.
    pub weights: [f32; 3],
}

/// Most vertices: three, and one more for each plane.
const MAX_VERTICES: usize = 9;

/// A clipped triangle.
#[derive(Debug, Clone, Copy)]
pub struct Clipped {
    vertices: [ClippedVertex; MAX_VERTICES],
    len: usize,
}

impl Clipped {
    /// Triangles of the fan.
    pub fn triangles(&self) -> impl Iterator<Item = [ClippedVertex; 3]> + '_ {
        (2..self.len).map(|ix| [self.vertices[0], self.vertices[ix - 1], self.vertices[ix]])
    }
}

#[derive(Debug, Clone, Copy)]
struct Vertex {
    p: DVec3,
    weights: DVec3,
    /// The raster position of an original vertex that is not on the slow path.
    fixed: Option<[i32; 2]>,
}

/// Clips the triangle `p`; `fixed` holds the raster positions of the vertices that are not slow, as they are seen
/// from the place `lens` (times 32768) of the lens.
pub fn clip_triangle(
    camera: &RasterCamera,
    p: [Vec3; 3],
    fixed: [Option<[i32; 2]>; 3],
    lens: [i16; 2],
) -> Clipped {
    let empty = ClippedVertex { raster: [0; 2], depth: 0.0, weights: [0.0; 3] };
    if p.iter().all(|p| p.z < camera.near) {
        return Clipped { vertices: [empty; MAX_VERTICES], len: 0 };
    }
    let mut polygon = Polygon { vertices: [ZERO; MAX_VERTICES], len: 0 };
    for ix in 0..3 {
        let weights = DVec3::AXES[ix];
        polygon.push(Vertex { p: p[ix].as_dvec3(), weights, fixed: fixed[ix] });
    }
    for plane in planes(camera) {
        if !polygon.is_inside(plane) {
            polygon = polygon.clip(plane);
        }
    }
    let mut clipped = Clipped { vertices: [empty; MAX_VERTICES], len: polygon.len };
    for (out, v) in clipped.vertices.iter_mut().zip(&polygon.vertices[..polygon.len]) {
        *out = ClippedVertex {
            raster: v.fixed.unwrap_or_else(|| project(camera, v.p, lens)),
            depth: v.p.z as f32,
            weights: v.weights.as_vec3().to_array(),
        };
    }
    clipped
}

impl Vertex {
    /// How far inside of a half space it is; one that is not slow is inside, whatever rounding says.
    fn distance(&self, normal: DVec3, offset: f64) -> f64 {
        let distance = normal.dot(self.p) + offset;
        if self.fixed.is_some() { distance.max(0.0) } else { distance }
    }
}

const ZERO: Vertex = Vertex { p: DVec3::ZERO, weights: DVec3::ZERO, fixed: None };

/// Half spaces `normal . p + offset >= 0`: near, far, then the guard band's left, right, top, bottom.
fn planes(camera: &RasterCamera) -> [(DVec3, f64); 6] {
    let guard = f64::from(GUARD_BAND_PX);
    let [sx, sy] = camera.scale.map(f64::from);
    let [cx, cy] = camera.center.map(f64::from);
    let far = if camera.far.is_finite() { (-DVec3::Z, f64::from(camera.far)) } else { (DVec3::ZERO, 1.0) };
    let side =
        |axis: DVec3, at: f64| if camera.perspective { (axis + DVec3::Z * at, 0.0) } else { (axis, at) };
    [
        (DVec3::Z, -f64::from(camera.near)),
        far,
        side(DVec3::X * sx, guard + cx),
        side(-DVec3::X * sx, guard - cx),
        side(-DVec3::Y * sy, guard + cy),
        side(DVec3::Y * sy, guard - cy),
    ]
}

fn project(camera: &RasterCamera, p: DVec3, lens: [i16; 2]) -> [i32; 2] {
    let inverse = if camera.perspective { 1.0 / p.z } else { 1.0 };
    let x = p.x * inverse * f64::from(camera.scale[0]) + f64::from(camera.center[0]);
    let y = f64::from(camera.center[1]) - p.y * inverse * f64::from(camera.scale[1]);
    // Rounding may put a cut point just beyond the guard band.
    let guard = f64::from(GUARD_BAND_PX) * 1.5;
    let [x, y] = [x, y].map(|px| (px.clamp(-guard, guard) * f64::from(SUBPIXELS)).round_ties_even() as i32);
    let coc = camera.coc(p.z as f32);
    [x + scaled(lens[0], coc), y + scaled(lens[1], coc)]
}

struct Polygon {
    vertices: [Vertex; MAX_VERTICES],
    len: usize,
}

impl Polygon {
    fn push(&mut self, vertex: Vertex) {
        // A convex polygon gains at most one vertex a plane.
        if self.len < MAX_VERTICES {
            self.vertices[self.len] = vertex;
            self.len += 1;
        }
    }

    fn is_inside(&self, (normal, offset): (DVec3, f64)) -> bool {
        self.vertices[..self.len].iter().all(|v| v.distance(normal, offset) >= 0.0)
    }

    fn clip(&self, (normal, offset): (DVec3, f64)) -> Polygon {
        let mut kept = Polygon { vertices: [ZERO; MAX_VERTICES], len: 0 };
        for ix in 0..self.len {
            let (a, b) = (&self.vertices[ix], &self.vertices[(ix + 1) % self.len]);
            let (da, db) = (a.distance(normal, offset), b.distance(normal, offset));
            if da >= 0.0 {
                kept.push(*a);
            }
            if (da >= 0.0) != (db >= 0.0) {
                let (inner, outer, di, d_outer) = if da >= 0.0 { (a, b, da, db) } else { (b, a, db, da) };
                let t = di / (di - d_outer);
                kept.push(Vertex {
                    p: inner.p + (outer.p - inner.p) * t,
                    weights: inner.weights + (outer.weights - inner.weights) * t,
                    fixed: None,
                });
            }
        }
        kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, Projection};

    fn camera(near: f32) -> RasterCamera {
        let camera = Camera {
            projection: Projection::Perspective { fov: 90.0 },
            clipping: [near, f32::INFINITY],
            ..Camera::default()
        };
        RasterCamera::new(&camera, [100, 100])
    }

    #[test]
    fn triangles_that_share_an_edge_are_cut_at_the_same_point() {
        let camera = camera(0.1);
        let (a, b) = (Vec3::new(0.3, 0.1, 2.0), Vec3::new(-0.7, 0.4, -1.0));
        let (c, d) = (Vec3::new(1.0, 1.0, 2.0), Vec3::new(-1.0, -1.0, 2.0));
        let one = clip_triangle(&camera, [a, b, c], [camera.fixed(a), None, camera.fixed(c)], [0; 2]);
        let two = clip_triangle(&camera, [b, a, d], [None, camera.fixed(a), camera.fixed(d)], [0; 2]);
        let cut = |clipped: &Clipped| -> Vec<[i32; 2]> {
            clipped.vertices[..clipped.len].iter().filter(|v| v.depth == 0.1).map(|v| v.raster).collect()
        };
        let (one, two) = (cut(&one), cut(&two));
        assert_eq!((one.len(), two.len()), (2, 2));
        assert!(one.iter().any(|p| two.contains(p)), "{one:?} {two:?}");
    }

    #[test]
    fn a_triangle_behind_the_eye_vanishes() {
        let camera = camera(0.1);
        let p = [Vec3::new(0.0, 0.0, -1.0), Vec3::new(1.0, 0.0, -1.0), Vec3::new(0.0, 1.0, -3.0)];
        assert_eq!(clip_triangle(&camera, p, [None; 3], [0; 2]).triangles().count(), 0);
    }

    #[test]
    fn a_vertex_at_the_eye_stays_within_the_guard_band() {
        let camera = camera(1e-10);
        let p = [Vec3::new(0.0, 0.0, 5.0), Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, -1e-12)];
        let clipped = clip_triangle(&camera, p, [camera.fixed(p[0]), None, None], [0; 2]);
        assert!(clipped.triangles().count() > 0);
        for v in clipped.triangles().flatten() {
            assert!(v.raster.iter().all(|c| c.abs() < 1 << 29), "{v:?}");
            assert!((v.weights.iter().sum::<f32>() - 1.0).abs() < 1e-5);
        }
    }
}
