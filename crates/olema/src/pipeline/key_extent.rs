//! Extents at keys: what holds something at one time, in camera space and on the raster.
//!
//! In: points. Out: [`KeyExtent`], of which [`sweep`] makes a [`Sweep`] over the time.

use glam::Vec3;

use crate::geometry::RasterCamera;
use crate::geometry::camera::GUARD_BAND_PX;

use super::sweep::{Extent, NOWHERE, Sweep, grown, union};

/// Something at one key.
#[derive(Debug, Clone, Copy)]
pub struct KeyExtent {
    /// Box in camera space.
    pub least: Vec3,
    /// Its other corner.
    pub most: Vec3,
    /// Box on the raster of what is in front of the near plane.
    pub raster: [f32; 4],
}

impl KeyExtent {
    /// Around nothing.
    pub const EMPTY: KeyExtent =
        KeyExtent { least: Vec3::INFINITY, most: Vec3::NEG_INFINITY, raster: NOWHERE };

    /// Grows to hold a point.
    #[inline(always)]
    pub fn include(&mut self, camera: &RasterCamera, p: Vec3) {
        self.least = self.least.min(p);
        self.most = self.most.max(p);
        if p.z >= camera.near {
            let [x, y] = camera.project(p);
            self.raster = union(&self.raster, &[x, x, y, y]);
        }
    }

    /// Whether a vertex within may take the slow path.
    pub(super) fn may_be_slow(&self, camera: &RasterCamera) -> bool {
        let is_near = self.raster.iter().all(|px| px.abs() <= GUARD_BAND_PX);
        let depth = [self.least.z, self.most.z];
        !(depth[0] >= camera.near && depth[1] <= camera.far && is_near)
            || camera.greatest_coc_px(depth) > GUARD_BAND_PX
    }

    /// The box on the raster of the part of the camera-space box that is in front of the near plane, if there is any.
    pub(super) fn project(&self, camera: &RasterCamera) -> Option<[f32; 4]> {
        let [near, far] = [self.least.z.max(camera.near), self.most.z];
        if far.is_nan() || far < camera.near {
            return None;
        }
        let along = |least: f32, most: f32, scale: f32, center: f32| {
            let ends = if camera.perspective {
                [
                    if least < 0.0 { least / near } else { least / far },
                    if most > 0.0 { most / near } else { most / far },
                ]
            } else {
                [least, most]
            };
            let [a, b] = ends.map(|end| end * scale + center);
            [a.min(b), a.max(b)]
        };
        let [x0, x1] = along(self.least.x, self.most.x, camera.scale[0], camera.center[0]);
        let [y0, y1] = along(self.least.y, self.most.y, -camera.scale[1], camera.center[1]);
        let coc = camera.greatest_coc_px([near, far]);
        Some(grown([x0, x1, y0, y1], coc))
    }

    /// Part of the way to another.
    pub(super) fn between(&self, to: &KeyExtent, part: f32) -> KeyExtent {
        let mix = |from: Vec3, to: Vec3| from + (to - from) * part;
        KeyExtent { least: mix(self.least, to.least), most: mix(self.most, to.most), raster: NOWHERE }
    }
}

/// Where something is over the time, given where it is at the keys; `grow_px` is added to all sides.
pub fn sweep(camera: &RasterCamera, keys: &[KeyExtent], key_times: &[f32], grow_px: f32) -> Sweep {
    let extent_of = |key: &KeyExtent| {
        let near = key.least.z;
        if key.may_be_slow(camera) {
            let held = key.project(camera);
            return held.map_or(Extent::NOWHERE, |b| Extent {
                in_focus: grown(b, grow_px),
                coc: [0.0; 2],
                near,
            });
        }
        let coc = camera.coc_range_px([near, key.most.z]);
        Extent { in_focus: grown(key.raster, grow_px), coc, near }
    };
    let mut swept = match keys {
        // Nearly all have one key or two.
        [only] => Sweep::of_keys(&[extent_of(only)], key_times),
        [from, to] => Sweep::of_keys(&[extent_of(from), extent_of(to)], key_times),
        _ => Sweep::of_keys(&keys.iter().map(extent_of).collect::<Vec<_>>(), key_times),
    };
    for (ends, times) in keys.windows(2).zip(key_times.windows(2)) {
        if ends.iter().any(|key| key.may_be_slow(camera)) {
            swept.add_slices([&ends[0], &ends[1]], camera, [times[0], times[1]], grow_px);
        }
    }
    swept
}
