//! Levels of detail: how large a box is in the picture.

use std::sync::Arc;

use glam::{DMat4, DVec3};
use olema::scene::Projection;

use super::super::state::OptionState;
use super::super::transform::sin_cos_degrees;
use super::{Call, Interp};

impl Interp {
    /// Detail: measures the box under the current transformation.
    pub(super) fn detail(&mut self, call: &Call<'_>) {
        let numbers: [f64; 6] = call.args.array(0).unwrap_or_default();
        let mut to_camera = self.ctm.first();
        if let Some(world) = &self.world {
            to_camera = world.scene.camera.world_to_camera.first() * to_camera;
        }
        let area = raster_area(&self.options, &to_camera, numbers);
        Arc::make_mut(&mut self.attrs).detail = area * self.options.relative_detail;
    }
}

/// Area in pixels of the raster bound of a box; infinite where it reaches the eye.
fn raster_area(options: &OptionState, to_camera: &DMat4, [x0, x1, y0, y1, z0, z1]: [f64; 6]) -> f64 {
    let [left, right, bottom, top] = options.screen();
    let [width, height] = options.resolution().map(f64::from);
    let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for corner in 0..8 {
        let pick = |bit: u32, a: f64, b: f64| if corner >> bit & 1 == 0 { a } else { b };
        let p = to_camera.project_point3(DVec3::new(pick(0, x0, x1), pick(1, y0, y1), pick(2, z0, z1)));
        let scale = match options.projection {
            Projection::Orthographic => 1.0,
            Projection::Perspective { fov } => {
                if p.z <= options.clipping[0] {
                    return f64::INFINITY;
                }
                let (sin, cos) = sin_cos_degrees(f64::from(fov) / 2.0);
                cos / (sin * p.z)
            }
        };
        let raster = [p.x * scale / (right - left) * width, p.y * scale / (top - bottom) * height];
        for axis in 0..2 {
            min[axis] = min[axis].min(raster[axis]);
            max[axis] = max[axis].max(raster[axis]);
        }
    }
    (max[0] - min[0]) * (max[1] - min[1])
}
