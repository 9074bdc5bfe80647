//! How large micropolygons are: what of a surface's grids follows from its shading rate, and what is lost on the way.
//!
//! In: scenes of smooth surfaces. Out: [`Sizes`], whose ratio is the number of micropolygons over the projected area that
//! they have, in units of the shading rate.

use std::sync::Arc;

use glam::DMat4;
use olema::pipeline::Grid;
use olema::scene::{Attributes, Camera, Projection};
use olema::{Error, Scene, Settings};

use crate::creature::tube;
use crate::scenes::{add, add_lights, bicubic, bilinear, camera, mesh, surface, teapot};
use crate::shapes;

/// What the grids of a scene have.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sizes {
    /// Micropolygons.
    pub count: u64,
    /// Their area on the raster as the shutter opens, in pixels: of two triangles each, both counted as positive.
    pub area: f64,
    /// The area that they would have if their sides met at right angles, in pixels.
    pub upright: f64,
}

impl Sizes {
    /// Of all grids of a scene, seen or not.
    ///
    /// # Errors
    /// Those of the renderer.
    pub fn of(scene: &Scene, settings: &Settings) -> Result<Self, Error> {
        let mut sizes = Sizes::default();
        olema::engine::grids(scene, settings, None, |_, grid, _, _| sizes.add(grid))?;
        Ok(sizes)
    }

    /// Micropolygons for each that the area asks for at a shading rate.
    pub fn ratio(&self, shading_rate: f64) -> f64 {
        self.count as f64 * shading_rate / self.area
    }

    fn add(&mut self, grid: &Grid) {
        self.count += grid.num_micropolygons() as u64;
        for micropolygon in 0..grid.num_micropolygons() {
            let [a, b, c, d] = grid
                .corners(micropolygon)
                .map(|v| [grid.on_raster.x[v], grid.on_raster.y[v]].map(|c| f64::from(c) / 256.0));
            let to = |p: [f64; 2], q: [f64; 2]| [q[0] - p[0], q[1] - p[1]];
            let cross = |p: [f64; 2], q: [f64; 2]| (p[0] * q[1] - p[1] * q[0]).abs();
            let length = |p: [f64; 2]| p[0].hypot(p[1]);
            self.area += (cross(to(a, b), to(a, c)) + cross(to(a, c), to(a, d))) / 2.0;
            let along = (length(to(a, b)) + length(to(d, c))) / 2.0;
            self.upright += along * (length(to(a, d)) + length(to(b, c))) / 2.0;
        }
    }
}

/// Smooth surfaces, each with its name.
pub fn smooth_scenes() -> Vec<(&'static str, Scene)> {
    vec![
        ("sphere of 8 patches", sphere()),
        ("teapot", teapot()),
        ("tube of 11,520 patches", tube(144, 80)),
        ("subdivision torus", mesh(shapes::torus(8, 6))),
        ("subdivision torus, fine", mesh(shapes::torus(48, 36))),
        ("subdivision cube", mesh(shapes::cube())),
        ("subdivision prism", mesh(shapes::prism(5))),
        ("subdivision icosahedron, Loop", mesh(shapes::icosahedron(olema::scene::Scheme::Loop))),
    ]
}

/// A sphere of two rings of four bicubic patches with a pole each.
pub fn sphere() -> Scene {
    const ARC: f64 = 0.552_284_749_8;
    let quarter = [[1.0, 0.0], [1.0, ARC], [ARC, 1.0], [0.0, 1.0]];
    let mut scene = Scene::new(camera([2.2, -4.6, 2.4], [0.0; 3], 38.0));
    let lights = add_lights(&mut scene, [3.0, -4.0, 6.0]);
    let attributes = Arc::new(Attributes {
        name: "sphere".into(),
        surface: surface("plastic"),
        lights,
        ..Attributes::default()
    });
    for turn in 0..4 {
        for up in [-1.0, 1.0] {
            let point = |ix: usize| {
                let ([x, y], [r, z]) = (quarter[ix % 4], quarter[ix / 4]);
                let [x, y] = [[x, y], [-y, x], [-x, -y], [y, -x]][turn];
                [x * r, y * r, up * z].map(|c| (1.4 * c) as f32)
            };
            add(&mut scene, bicubic(std::array::from_fn(point)), DMat4::IDENTITY, &attributes);
        }
    }
    scene
}

/// A square of `side` pixels that faces the camera, turned by `angle`, in a picture of 320 x 240.
pub fn facing_square(side: f64, angle: f64) -> Scene {
    let mut scene = Scene::new(Camera { projection: Projection::Orthographic, ..Camera::default() });
    let (sin, cos) = angle.sin_cos();
    let corner = |a: f64, b: f64| {
        let (x, y) = (a * side / 240.0, b * side / 240.0);
        [x * cos - y * sin, x * sin + y * cos, 5.0].map(|c| c as f32)
    };
    let square = bilinear([corner(-1.0, -1.0), corner(1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0)]);
    let attributes = Arc::new(Attributes { surface: surface("constant"), ..Attributes::default() });
    add(&mut scene, square, DMat4::IDENTITY, &attributes);
    scene
}
