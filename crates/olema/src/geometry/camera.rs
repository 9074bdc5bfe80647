//! Camera space to raster space.
//!
//! In: points in camera space. Out: raster positions in pixels (y down), or in fixed point with 8 fractional
//! bits. Sources: sampling rules of this project
//! (ARCHITECTURE.md, "Samples and positions"); the circle of confusion of a thin lens is Potmesil and
//! Chakravarty 1981.

use glam::Vec3;

use crate::math::function::{cos64, sin64};
use crate::scene::{Camera, Projection};

/// Raster positions beyond this many pixels from the frame's corner are clipped in camera space first.
pub const GUARD_BAND_PX: f32 = 1_048_576.0;

/// One pixel in fixed-point raster units.
pub const SUBPIXELS: i32 = 256;

/// A camera bound to a resolution.
#[derive(Debug, Clone, PartialEq)]
pub struct RasterCamera {
    /// Whether x and y are divided by depth.
    pub perspective: bool,
    /// Pixels per unit of x and of -y (at depth 1 in perspective).
    pub scale: [f32; 2],
    /// Raster position of the optical axis, in pixels.
    pub center: [f32; 2],
    /// Width and height of the full frame, in pixels.
    pub frame_px: [f32; 2],
    /// Nearest depth drawn, above 0.
    pub near: f32,
    /// Farthest depth drawn; may be infinite.
    pub far: f32,
    /// The lens; `None` where all is in focus.
    pub lens: Option<RasterLens>,
}

/// A thin lens bound to a resolution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RasterLens {
    /// Radius of the circle of confusion of what is infinitely far behind the focus, times the depth in focus:
    /// the lens radius in camera units times the larger scale.
    pub radius: f32,
    /// Depth in focus.
    pub focus: f32,
}

impl RasterLens {
    /// Signed radius of the circle of confusion at depth `z` above 0, in pixels, above 0 behind the focus.
    ///
    /// A point seen from the place (u, v) of the lens, -1 to 1, moves by (u c, v c) on the raster.
    #[inline(always)]
    pub fn coc_px(&self, z: f32) -> f32 {
        self.radius * (1.0 / self.focus - 1.0 / z)
    }
}

impl RasterCamera {
    /// Binds `camera` to a frame of `resolution` pixels.
    pub fn new(camera: &Camera, resolution: [u32; 2]) -> Self {
        let [width, height] = resolution.map(f64::from);
        let aspect = width * f64::from(camera.pixel_aspect) / height;
        let [left, right, bottom, top] = match camera.screen_window {
            Some(window) => window.map(f64::from),
            None if aspect >= 1.0 => [-aspect, aspect, -1.0, 1.0],
            None => [-1.0, 1.0, -1.0 / aspect, 1.0 / aspect],
        };
        let (perspective, zoom) = match camera.projection {
            Projection::Perspective { fov } => {
                let half = f64::from(fov).to_radians() / 2.0;
                (true, cos64(half) / sin64(half))
            }
            Projection::Orthographic => (false, 1.0),
        };
        let (x, y) = (width / (right - left), height / (top - bottom));
        let scale = [(x * zoom) as f32, (y * zoom) as f32];
        let lens = camera.lens.filter(|_| perspective).map(|lens| RasterLens {
            radius: lens.focal_length / (2.0 * lens.fstop) * scale[0].abs().max(scale[1].abs()),
            focus: lens.focal_distance,
        });
        RasterCamera {
            perspective,
            scale,
            lens: lens.filter(|lens| lens.radius > 0.0 && lens.radius.is_finite()),
            center: [(-left * x) as f32, (top * y) as f32],
            frame_px: resolution.map(|size| size as f32),
            near: camera.clipping[0],
            far: camera.clipping[1],
        }
    }

    /// Raster position in pixels of a point with depth above 0.
    #[inline(always)]
    pub fn project(&self, p: Vec3) -> [f32; 2] {
        let inverse = if self.perspective { 1.0 / p.z } else { 1.0 };
        [p.x * inverse * self.scale[0] + self.center[0], self.center[1] - p.y * inverse * self.scale[1]]
    }

    /// The point in camera space at a raster position and a depth above 0.
    pub fn point_at(&self, [x, y]: [f32; 2], z: f32) -> Vec3 {
        let w = if self.perspective { z } else { 1.0 };
        Vec3::new((x - self.center[0]) / self.scale[0] * w, (self.center[1] - y) / self.scale[1] * w, z)
    }

    /// Fixed-point raster position, rounded to nearest even, or `None` where the vertex lies in front of the
    /// near or beyond the far plane or outside the guard band (the slow path).
    #[inline(always)]
    pub fn fixed(&self, p: Vec3) -> Option<[i32; 2]> {
        self.fast_px(p).map(|[x, y]| [to_fixed(x), to_fixed(y)])
    }

    /// The same in pixels, not rounded.
    #[inline(always)]
    pub fn fast_px(&self, p: Vec3) -> Option<[f32; 2]> {
        if !(p.z >= self.near && p.z <= self.far) {
            return None;
        }
        let [x, y] = self.project(p);
        if !(x.abs() <= GUARD_BAND_PX && y.abs() <= GUARD_BAND_PX) {
            return None;
        }
        if self.lens.is_some_and(|lens| lens.coc_px(p.z).abs() > GUARD_BAND_PX) {
            return None;
        }
        Some([x, y])
    }

    /// Signed radius of the circle of confusion at depth `z` above 0, in 1/256 pixels, at most [`GUARD_BAND_PX`];
    /// 0 without a lens.
    #[inline(always)]
    pub fn coc(&self, z: f32) -> i32 {
        self.lens.map_or(0, |lens| to_fixed(lens.coc_px(z).clamp(-GUARD_BAND_PX, GUARD_BAND_PX)))
    }

    /// Largest radius of the circles of confusion between two depths, in pixels, as far as these are above 0.
    pub fn greatest_coc_px(&self, depth: [f32; 2]) -> f32 {
        let [least, most] = self.coc_range_px(depth);
        least.abs().max(most.abs())
    }

    /// Least and greatest signed radius of the circles of confusion between two depths, in pixels, as far as these are
    /// above 0.
    pub fn coc_range_px(&self, depth: [f32; 2]) -> [f32; 2] {
        // The radius grows with the depth.
        self.lens.map_or([0.0; 2], |lens| depth.map(|z| lens.coc_px(z.max(f32::MIN_POSITIVE))))
    }

    /// Sizes of the circles of confusion along x and y, of which the larger is 1.
    pub fn lens_scale(&self) -> [f64; 2] {
        let [x, y] = self.scale.map(|s| f64::from(s.abs()));
        [x / x.max(y), y / x.max(y)]
    }

    /// Unit direction-like vector from the eye to `p`: the shading variable I.
    #[inline(always)]
    pub fn incident(&self, p: Vec3) -> Vec3 {
        if self.perspective { p } else { Vec3::Z }
    }
}

/// Pixels to 1/256 pixels, to nearest even.
#[inline(always)]
pub fn to_fixed(px: f32) -> i32 {
    (px * SUBPIXELS as f32).round_ties_even() as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_corners_map_to_raster_corners() {
        let camera = Camera { projection: Projection::Perspective { fov: 90.0 }, ..Camera::default() };
        let raster = RasterCamera::new(&camera, [200, 100]);
        // 90 degrees over the shorter side: y = 1 at depth 1 is the top edge, x = 2 the right one.
        let close = |a: [f32; 2], b: [f32; 2]| (a[0] - b[0]).abs() < 1e-3 && (a[1] - b[1]).abs() < 1e-3;
        assert!(close(raster.project(Vec3::new(2.0, 1.0, 1.0)), [200.0, 0.0]));
        assert!(close(raster.project(Vec3::new(-4.0, -2.0, 2.0)), [0.0, 100.0]));
        assert!(close(raster.project(raster.point_at([30.0, 70.0], 5.0)), [30.0, 70.0]));
    }

    #[test]
    fn fixed_point_rounds_to_even_once() {
        assert_eq!(to_fixed(0.5 / 256.0), 0);
        assert_eq!(to_fixed(1.5 / 256.0), 2);
        assert_eq!(to_fixed(-0.5 / 256.0), 0);
        assert_eq!(to_fixed(3.0), 768);
    }

    #[test]
    fn vertices_outside_the_clipping_planes_take_the_slow_path() {
        let camera = Camera { clipping: [1.0, 10.0], ..Camera::default() };
        let raster = RasterCamera::new(&camera, [10, 10]);
        assert!(raster.fixed(Vec3::new(0.0, 0.0, 0.5)).is_none());
        assert!(raster.fixed(Vec3::new(0.0, 0.0, 10.5)).is_none());
        assert!(raster.fixed(Vec3::new(1e9, 0.0, 5.0)).is_none());
        assert!(raster.fixed(Vec3::new(f32::NAN, 0.0, 5.0)).is_none());
        assert_eq!(raster.fixed(Vec3::new(0.0, 0.0, 5.0)), Some([5 * 256, 5 * 256]));
    }
}
