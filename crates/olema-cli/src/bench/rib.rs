//! The standard scenes as RIB.
//!
//! In: a surface, a size, samples, blur. Out: text, the same on every run.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use olema::standard::{teapot, torus};

use super::scenes::{Blur, Model};
use super::text::Text;

type Point = [f64; 3];

/// Waves of the torus, around it and around its tube, have this many control points each.
const POINTS_A_WAVE: usize = 8;
/// Area of the torus's micropolygons in pixels: all of it, what is hidden too, would be 4.19 million of them at 1600 x 1200
/// (`--cull none`), as many quads as other renderers get of it. Of these half are diced.
const TORUS_RATE: f64 = 0.715;
/// Patches along the creature and around it.
const CREATURE: [usize; 2] = [124, 93];
/// Faces around the tyre's axis and around its tube.
const TYRE: [usize; 2] = [35, 45];
/// Every this many edges around its tube the tyre has a crease that goes round.
const EDGES_A_CREASE: usize = 5;

/// The torus on which renderers are compared, as a sheet that goes through points of it: matte, one light, a box
/// filter of one pixel.
pub fn torus([width, height]: [u32; 2], samples: u32, blur: Blur) -> Text {
    let mut text = Text::default();
    let _ = write!(
        text,
        "Format {width} {height} 1\nPixelSamples {samples} {samples}\nPixelFilter \"box\" 1 1\n\
         ShadingInterpolation \"smooth\"\nShadingRate {TORUS_RATE}\nShutter 0 {}\n\
         Projection \"perspective\" \"fov\" [90]\nScreenWindow -0.4 0.4 -0.3 0.3\nClipping 0.1 100\n",
        u32::from(blur.motion)
    );
    if blur.lens {
        text.push_str("DepthOfField 1 0.1 4\n");
    }
    text.push_str(
        "Translate 0 0 4\nScale 1 1 -1\nWorldBegin\n\
         LightSource \"distantlight\" 1 \"intensity\" [1] \"from\" [1 2 4] \"to\" [0 0 0]\n\
         Color [0.8 0.8 0.8]\nSurface \"matte\"\nBasis \"catmull-rom\" 1 \"catmull-rom\" 1\n",
    );
    let [nu, nv] = [24, 10].map(|waves| waves * POINTS_A_WAVE);
    keyed(&mut text, blur.motion, |text, time| {
        let _ = write!(text, "PatchMesh \"bicubic\" {nu} \"periodic\" {nv} \"periodic\" \"P\" [");
        for ix in 0..nu * nv {
            let turn = |ix: usize, n: usize| TAU * ix as f64 / n as f64;
            write_point(text, torus::point(turn(ix % nu, nu), turn(ix / nu, nv), time).map(f64::from));
        }
        text.push_str("]\n");
    });
    text.push_str("WorldEnd\n");
    text
}

/// Writes a surface once, or at the two keys of a motion block.
fn keyed(text: &mut Text, moves: bool, mut write: impl FnMut(&mut Text, f64)) {
    if moves {
        text.push_str("MotionBegin [0 1]\n");
        write(text, 0.0);
        write(text, 1.0);
        text.push_str("MotionEnd\n");
    } else {
        write(text, 0.0);
    }
}

fn write_point(text: &mut Text, [x, y, z]: Point) {
    // Seven digits are those of a 32-bit float; shared points are the same text.
    let _ = write!(text, "{x:.6} {y:.6} {z:.6} ");
}

/// A model in the view that all models have.
pub fn model(model: Model, [width, height]: [u32; 2], samples: u32, blurred: bool) -> Text {
    let ([cx, cy, cz], radius) = sphere(model);
    let distance = 2.6 * radius;
    let mut text = Text::default();
    let _ = write!(
        text,
        "Format {width} {height} 1\nPixelSamples {samples} {samples}\nPixelFilter \"gaussian\" 2 2\n\
         ShadingInterpolation \"smooth\"\nShadingRate 1\nShutter 0 {}\n\
         Projection \"perspective\" \"fov\" [40]\nClipping 0.01 1000\n",
        u32::from(blurred)
    );
    if blurred {
        let _ = writeln!(text, "DepthOfField 1 {} {}", 0.06 * distance, 0.85 * distance);
    }
    // From the front, a little above, z up.
    let _ = write!(
        text,
        "Translate 0 0 {distance}\nRotate -25 1 0 0\nScale 1 1 -1\nRotate -90 1 0 0\n\
         Translate {} {} {}\nWorldBegin\n\
         LightSource \"ambientlight\" 1 \"intensity\" [0.2]\n\
         LightSource \"distantlight\" 2 \"intensity\" [0.8] \"from\" [-5 -7 9] \"to\" [0 0 0]\n\
         LightSource \"distantlight\" 3 \"intensity\" [0.4] \"from\" [8 -4 3] \"to\" [0 0 0]\n\
         Color [0.8 0.5 0.3]\nSurface \"plastic\"\nSides 2\n",
        -cx, -cy, -cz
    );
    if model == Model::Displaced {
        text.push_str(
            "Attribute \"displacementbound\" \"sphere\" [0.1] \"coordinatesystem\" [\"shader\"]\n\
             Displacement \"fractal\" \"amplitude\" [0.08] \"frequency\" [4]\n",
        );
    }
    match model {
        Model::Teapot => teapot_patches(&mut text, blurred),
        Model::Creature => creature(&mut text, blurred),
        Model::Tyre | Model::Displaced => tyre(&mut text, blurred),
    }
    text.push_str("WorldEnd\n");
    text
}

/// Middle and radius of a sphere around a model.
fn sphere(model: Model) -> (Point, f64) {
    match model {
        Model::Teapot => ([0.26, 0.0, 1.575], 3.6),
        Model::Creature => ([0.0; 3], 2.85),
        Model::Tyre | Model::Displaced => ([0.0; 3], 1.5),
    }
}

/// A point of a model at a key: models turn by 12 degrees about z.
fn turned([x, y, z]: Point, time: f64) -> Point {
    let (sin, cos) = (12.0f64.to_radians() * time).sin_cos();
    [cos * x - sin * y, sin * x + cos * y, z]
}

fn write_patch(text: &mut Text, blurred: bool, points: &[Point; 16]) {
    keyed(text, blurred, |text, time| {
        text.push_str("Patch \"bicubic\" \"P\" [");
        points.iter().for_each(|&point| write_point(text, turned(point, time)));
        text.push_str("]\n");
    });
}

fn teapot_patches(text: &mut Text, blurred: bool) {
    for patch in teapot::PATCHES {
        write_patch(text, blurred, &patch.map(|ix| teapot::POINTS[usize::from(ix)].map(f64::from)));
    }
}

/// A knotted tube with a swelling skin, a Bezier patch a statement.
fn creature(text: &mut Text, blurred: bool) {
    let [nu, nv] = CREATURE;
    let knots: Vec<Point> = (0..nu * nv).map(|ix| tube(ix % nu, ix / nu)).collect();
    let at = |i: usize, j: usize| knots[(j % nv) * nu + i % nu];
    for j in 0..nv {
        for i in 0..nu {
            let rows: [[Point; 4]; 4] =
                std::array::from_fn(|b| bezier(std::array::from_fn(|a| at(i + a, j + b))));
            let mut points = [[0.0; 3]; 16];
            for a in 0..4 {
                for (b, point) in bezier(rows.map(|row| row[a])).into_iter().enumerate() {
                    points[4 * b + a] = point;
                }
            }
            write_patch(text, blurred, &points);
        }
    }
}

/// Control points of the creature's B-spline.
fn tube(i: usize, j: usize) -> Point {
    let turn = |turns: f64| (turns * TAU).sin_cos();
    let (along, around) = (i as f64 / CREATURE[0] as f64, j as f64 / CREATURE[1] as f64);
    let ((s2, c2), (s3, c3), (sv, cv)) = (turn(2.0 * along), turn(3.0 * along), turn(around));
    let swell = 0.45 + 0.08 * turn(11.0 * along).0;
    let r = 1.7 + 0.6 * c3 + swell * cv;
    [r * c2, r * s2, 0.6 * s3 + swell * sv]
}

/// Bezier points of a segment of a uniform B-spline. The last of one segment are the bits of the next one's first.
fn bezier([p, q, r, s]: [Point; 4]) -> [Point; 4] {
    let mean = |weights: [f64; 3], of: [Point; 3]| -> Point {
        std::array::from_fn(|c| {
            (0..3).map(|k| weights[k] * of[k][c]).sum::<f64>() / weights.iter().sum::<f64>()
        })
    };
    [
        mean([1.0, 4.0, 1.0], [p, q, r]),
        mean([2.0, 1.0, 0.0], [q, r, s]),
        mean([1.0, 2.0, 0.0], [q, r, s]),
        mean([1.0, 4.0, 1.0], [q, r, s]),
    ]
}

/// A closed subdivision mesh with nine creases that go round, of sharpness 1 to 4.
fn tyre(text: &mut Text, blurred: bool) {
    let [nu, nv] = TYRE;
    let vertex = |i: usize, j: usize| (j % nv) * nu + i % nu;
    let numbers =
        |values: &mut dyn Iterator<Item = usize>| values.map(|n| n.to_string()).collect::<Vec<_>>().join(" ");
    let corners = |ix: usize| {
        let (i, j) = (ix % nu, ix / nu);
        [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)]
    };
    let num_creases = nv / EDGES_A_CREASE;
    let rings = (0..num_creases).flat_map(|ring| (0..=nu).map(move |i| vertex(i, ring * EDGES_A_CREASE)));
    let mesh = format!(
        "SubdivisionMesh \"catmull-clark\" [{}] [{}] [{}] [{}] [{}] [{}] \"P\" [",
        numbers(&mut std::iter::repeat_n(4, nu * nv)),
        numbers(&mut (0..nu * nv).flat_map(corners)),
        "\"crease\" ".repeat(num_creases),
        format!("{} 1 ", nu + 1).repeat(num_creases),
        numbers(&mut rings.into_iter()),
        numbers(&mut (0..num_creases).map(|ring| 1 + ring % 4)),
    );
    keyed(text, blurred, |text, time| {
        text.push_str(&mesh);
        for ix in 0..nu * nv {
            write_point(text, turned(tyre_point(ix % nu, ix / nu), time));
        }
        text.push_str("]\n");
    });
}

/// Control points of the tyre: its rings with creases stand out or lie deeper in turn.
fn tyre_point(i: usize, j: usize) -> Point {
    let (around, across) = (TAU * i as f64 / TYRE[0] as f64, TAU * j as f64 / TYRE[1] as f64);
    let is_crease = j.is_multiple_of(EDGES_A_CREASE);
    let tube = 0.42 + if is_crease { 0.06 } else { 0.0 } + 0.03 * (7.0 * around).sin();
    let ring = 1.0 + tube * across.cos();
    [ring * around.cos(), tube * across.sin(), ring * around.sin()]
}
