//! Closed, consistently oriented surfaces made of patches, for the crack test.
//!
//! Everything is drawn from a seed, so that a failure can be repeated.

use std::sync::Arc;

use glam::DMat4;
use olema::Scene;
use olema::scene::{Attributes, Keyed, PatchBasis, PatchKind, PatchMesh, Points};
pub use olema::standard::build::Random;

use crate::scenes::{add, bicubic, bilinear, camera};

/// Uniform B-spline basis.
pub const B_SPLINE: PatchBasis = PatchBasis {
    matrix: [
        [-1.0 / 6.0, 3.0 / 6.0, -3.0 / 6.0, 1.0 / 6.0],
        [3.0 / 6.0, -6.0 / 6.0, 3.0 / 6.0, 0.0],
        [-3.0 / 6.0, 0.0, 3.0 / 6.0, 0.0],
        [1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0, 0.0],
    ],
    step: 1,
};

/// What kind of closed surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A B-spline sheet wrapped both ways.
    Torus,
    /// Six bilinear patches around a box, none sharing a point.
    Box,
    /// Bicubic patches around a cube, each turned at random, seams equal to about 1e-6.
    CubeOfPatches,
    /// A sheet wrapped in u whose first and last row are single points.
    Poles,
    /// Two bicubic patches whose four sides are short and whose insides are blown up: diced in blocks.
    Balloon,
}

/// All kinds.
pub const KINDS: [Kind; 5] = [Kind::Torus, Kind::Box, Kind::CubeOfPatches, Kind::Poles, Kind::Balloon];

/// A random closed surface in front of the camera.
pub fn scene(kind: Kind, seed: u32) -> Scene {
    let mut random = Random::new(seed);
    let eye = [random.range(-1.0, 1.0), -6.0, random.range(-2.0, 2.0)];
    let mut scene = Scene::new(camera(eye, [0.0; 3], 40.0));
    match kind {
        Kind::Torus => torus(&mut scene, &mut random),
        Kind::Box => cube(&mut scene, &mut random, false),
        Kind::CubeOfPatches => cube(&mut scene, &mut random, true),
        Kind::Poles => poles(&mut scene, &mut random),
        Kind::Balloon => balloon(&mut scene, &mut random),
    }
    scene
}

fn attributes(random: &mut Random) -> Arc<Attributes> {
    let shading_rate = [0.25, 1.0, 4.0, 19.0][random.below(4) as usize];
    Arc::new(Attributes { shading_rate, ..Attributes::default() })
}

fn turn(steps: f64) -> [f64; 2] {
    let angle = steps * std::f64::consts::TAU;
    [angle.cos(), angle.sin()]
}

fn wrapped(
    kind: PatchKind,
    nu: usize,
    nv: usize,
    wrap_v: bool,
    points: Vec<[f32; 3]>,
) -> olema::scene::Geometry {
    olema::scene::Geometry::Patches(Arc::new(PatchMesh {
        kind: Arc::new(kind),
        nu,
        nv,
        wrap_u: true,
        wrap_v,
        points: Keyed::still(Points::P(points)),
        vars: Vec::new(),
    }))
}

fn torus(scene: &mut Scene, random: &mut Random) {
    let (nu, nv) = (3 + random.below(6) as usize, 3 + random.below(6) as usize);
    let mut points = Vec::new();
    for j in 0..nv {
        for i in 0..nu {
            let [cu, su] = turn(i as f64 / nu as f64);
            let [cv, sv] = turn(j as f64 / nv as f64);
            let r = 1.2 + 0.7 * cv;
            let [dx, dy, dz] = random.jitter(0.25);
            points.push([r * cu + dx, r * su + dy, 0.7 * sv + dz].map(|c| c as f32));
        }
    }
    let kind = PatchKind::Bicubic { u: B_SPLINE, v: B_SPLINE };
    add(scene, wrapped(kind, nu, nv, true, points), DMat4::IDENTITY, &attributes(random));
}

/// A lattice of rings between two poles.
fn poles(scene: &mut Scene, random: &mut Random) {
    let (segments, rings) = (2 + random.below(5) as usize, 1 + random.below(3) as usize);
    let (nu, nv) = (segments * 3, rings * 3 + 1);
    let mut points = Vec::new();
    for j in 0..nv {
        let [c, s] = turn(0.5 * j as f64 / (nv - 1) as f64);
        for i in 0..nu {
            let [cu, su] = turn(i as f64 / nu as f64);
            let pole = j == 0 || j == nv - 1;
            let [dx, dy, dz] = if pole { [0.0; 3] } else { random.jitter(0.3) };
            let r = if pole { 0.0 } else { 1.6 * s };
            points.push([r * cu + dx, r * su + dy, 1.6 * c + dz].map(|c| c as f32));
        }
    }
    let kind = PatchKind::Bicubic { u: PatchBasis::BEZIER, v: PatchBasis::BEZIER };
    add(scene, wrapped(kind, nu, nv, false, points), DMat4::IDENTITY, &attributes(random));
}

fn balloon(scene: &mut Scene, random: &mut Random) {
    // Ends of the mouth, a tenth of a unit wide, and inner points far away on either side.
    let mut mouth = [[0.0f32; 3]; 16];
    for (ix, point) in mouth.iter_mut().enumerate() {
        let [dx, dy, dz] = random.jitter(0.01);
        let (i, j) = ((ix % 4) as f64, (ix / 4) as f64);
        *point = [i * 0.03 + dx, dy, j * 0.03 + dz].map(|c| c as f32);
    }
    for side in [-1.0, 1.0] {
        let mut points = mouth;
        for ix in [5, 6, 9, 10] {
            let [dx, dy, dz] = random.jitter(1.0);
            let (i, j) = (f64::from(ix % 4 * 2 - 3), f64::from(ix / 4 * 2 - 3));
            points[ix as usize] = [3.0 * i + dx, side * 5.0 + dy, 3.0 * j + dz].map(|c| c as f32);
        }
        if side > 0.0 {
            // The other side of the mouth: u runs the other way.
            points.chunks_mut(4).for_each(<[_]>::reverse);
        }
        add(scene, bicubic(points), DMat4::IDENTITY, &attributes(random));
    }
}

/// The six faces of a cube: origin, u and v axis, outwards along u x v.
const FACES: [[[f64; 3]; 3]; 6] = [
    [[-1.0, -1.0, -1.0], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0]],
    [[-1.0, -1.0, 1.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]],
    [[-1.0, -1.0, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]],
    [[-1.0, 1.0, -1.0], [0.0, 0.0, 2.0], [2.0, 0.0, 0.0]],
    [[-1.0, -1.0, -1.0], [0.0, 0.0, 2.0], [0.0, 2.0, 0.0]],
    [[1.0, -1.0, -1.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]],
];

fn cube(scene: &mut Scene, random: &mut Random, curved: bool) {
    let steps = if curved { 3 } else { 1 };
    // Points on the cube are moved by a function of where they are, so that faces agree on their borders.
    let field = random.below(1 << 30);
    let place = |p: [f64; 3]| -> [f64; 3] {
        let key: Vec<u32> = p.iter().map(|c| (c * 3.0).round() as i32 as u32).collect();
        let mut local = Random::new(olema::sampling::hash::hash(&[field, key[0], key[1], key[2]]));
        let [dx, dy, dz] = local.jitter(0.35);
        [p[0] + dx, p[1] + dy, p[2] + dz]
    };
    for [origin, u, v] in FACES {
        let at = |a: f64, b: f64| place(std::array::from_fn(|c| origin[c] + u[c] * a + v[c] * b));
        let rotation = random.below(4);
        let noise = if curved { 4e-7 } else { 0.0 };
        let mut point = |i: usize, j: usize| {
            let (a, b) = (i as f64 / steps as f64, j as f64 / steps as f64);
            let (a, b) = match rotation {
                0 => (a, b),
                1 => (b, 1.0 - a),
                2 => (1.0 - a, 1.0 - b),
                _ => (1.0 - b, a),
            };
            let [nx, ny, nz] = random.jitter(noise);
            let [x, y, z] = at(a, b);
            [x + nx, y + ny, z + nz].map(|c| c as f32)
        };
        let geometry = if curved {
            bicubic(std::array::from_fn(|ix| point(ix % 4, ix / 4)))
        } else {
            bilinear(std::array::from_fn(|ix| point(ix % 2, ix / 2)))
        };
        add(scene, geometry, DMat4::IDENTITY, &attributes(random));
    }
}

/// A random closed subdivision mesh in front of the camera: any faces, creases, corners, valences.
pub fn subdivision_scene(seed: u32) -> Scene {
    let mut random = Random::new(seed ^ 0x5eed_0000);
    let mesh = if seed % 4 == 3 {
        crate::shapes::random_closed_triangles(u64::from(seed))
    } else {
        crate::shapes::random_closed(u64::from(seed))
    };
    mesh_scene(mesh, &mut random)
}

/// A mesh scaled to fill the picture, at a random rate.
pub fn mesh_scene(mesh: olema::scene::SubdivisionMesh, random: &mut Random) -> Scene {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for point in mesh.points.first() {
        for c in 0..3 {
            (low[c], high[c]) = (low[c].min(point[c]), high[c].max(point[c]));
        }
    }
    let middle: [f64; 3] = std::array::from_fn(|c| f64::from(low[c] + high[c]) / 2.0);
    let size = (0..3).map(|c| f64::from(high[c] - low[c]).powi(2)).sum::<f64>().sqrt();
    let eye = [random.range(-2.0, 2.0), -6.0, random.range(-2.0, 2.0)];
    let mut scene = Scene::new(camera(eye, [0.0; 3], 40.0));
    let to_world = DMat4::from_scale(glam::DVec3::splat(4.0 / size.max(1e-9)))
        * DMat4::from_translation(-glam::DVec3::from_array(middle));
    let geometry = olema::scene::Geometry::Subdivision(Arc::new(mesh));
    add(&mut scene, geometry, to_world, &attributes(random));
    scene
}

/// Gives every primitive of a scene a random displacement of about `amplitude` in world units, each its own.
pub fn displace(scene: &mut Scene, seed: u32, amplitude: f32) {
    use olema::shading::{ShaderParam as Param, displacement};
    let mut random = Random::new(seed ^ 0xd15b);
    for primitive in &mut scene.primitives {
        let scale = primitive.to_world.first().x_axis.truncate().length();
        let name = ["noise", "fractal", "cells", "waves", "vector"][random.below(5) as usize];
        let params = [
            Param::float("amplitude", amplitude * random.range(0.3, 1.0) as f32 / scale as f32),
            Param::float("frequency", random.range(0.5, 6.0) as f32 * scale as f32),
        ];
        let made = displacement(name, &params).expect("a standard displacement");
        let attributes = (*primitive.attributes).clone();
        primitive.attributes = Arc::new(Attributes { displacement: Some(made.shader), ..attributes });
    }
}

/// Scene `seed` of the long crack test: meshes and patches, every second one displaced.
pub fn crack_scene(seed: u32) -> Scene {
    let mut scene = match seed % 3 {
        0 | 1 => subdivision_scene(seed),
        _ => scene(KINDS[seed as usize / 3 % KINDS.len()], seed),
    };
    if seed / 3 % 2 == 1 {
        displace(&mut scene, seed, 0.4);
    }
    scene
}
