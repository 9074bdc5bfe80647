//! Shade: colour and opacity at the vertices of a grid.
//!
//! In: `Diced`. Out: `Grid` with colours; opacity is kept only where some of it is below 1.

use std::sync::Arc;

use crate::math::Vec3s;
use crate::shading::{PlacedLight, ShadedPoints, SurfaceShader};

use super::dice::Diced;
use super::grid::Grid;

/// Shades all vertices.
pub fn shade(diced: Diced, shader: &dyn SurfaceShader, lights: &[Arc<dyn PlacedLight>]) -> Grid {
    let Diced { mut grid, points } = diced;
    let len = grid.num_vertices();
    let zeros = || Vec3s::splat(glam::Vec3::ZERO, len);
    let mut shaded = ShadedPoints { ci: zeros(), oi: Vec3s::splat(glam::Vec3::ONE, len) };
    if !grid.look.matte {
        let vertices: Vec<u32> = (0..len as u32).collect();
        shader.shade(&points, &vertices, lights, &mut shaded);
    }
    let opaque = [&shaded.oi.x, &shaded.oi.y, &shaded.oi.z].iter().all(|c| c.iter().all(|&o| o >= 1.0));
    grid.color = shaded.ci;
    if !opaque {
        grid.opacity = shaded.oi;
    }
    grid
}
