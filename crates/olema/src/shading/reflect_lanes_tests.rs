//! Lanes against their scalar twins, at every level.

use glam::DMat4;

use super::super::reflect::{Facing, finite3, reflect as reflect_one};
use super::super::{ShaderParam, light};
use super::*;
use crate::sampling::hash::Stream;

/// A light that is ambient on one side.
#[derive(Debug)]
struct HalfAmbient;

impl PlacedLight for HalfAmbient {
    fn sample(&self, p: Vec3) -> LightSample {
        let cl = Vec3::new(0.5, 0.25, 2.0);
        if p.x < 0.0 { LightSample::Ambient { cl } } else { LightSample::From { l: Vec3::NEG_Z, cl } }
    }
}

fn number(stream: &mut Stream) -> f32 {
    let odd = [0.0, -0.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e-30, 1e30, f32::MAX, 1e-40];
    match stream.below(30) {
        pick @ 0..9 => odd[pick as usize],
        _ => stream.below(2001) as f32 / 500.0 - 2.0,
    }
}

fn random_points(len: usize, stream: &mut Stream) -> ShadingPoints {
    let mut points = ShadingPoints::default();
    let ShadingPoints { p, n, ng, i, cs, os, .. } = &mut points;
    for all in [p, n, ng, i, cs, os] {
        for _ in 0..len {
            let is_zero = stream.below(12) == 0;
            let v = Vec3::from_array(std::array::from_fn(|_| number(stream)));
            all.push(if is_zero { Vec3::ZERO } else { v });
        }
    }
    points
}

const MIXES: [Mix; 3] = [
    Mix {
        ambient: 0.7,
        diffuse: Some(0.4),
        specular: None,
        highlight: Some((0.6, Vec3::new(0.1, 0.2, 0.3))),
    },
    Mix { ambient: 0.7, diffuse: None, specular: Some(0.4), highlight: None },
    Mix { ambient: 0.7, diffuse: Some(0.4), specular: None, highlight: None },
];

/// Bits, but one for all that are not numbers.
fn bits(shaded: &ShadedPoints) -> Vec<u32> {
    let bits = |&value: &f32| if value.is_nan() { u32::MAX } else { value.to_bits() };
    [&shaded.ci, &shaded.oi].into_iter().flat_map(Vec3s::axes).flatten().map(bits).collect()
}

/// What lanes give at each level, and what the twin gives for normals that are `off`.
fn compare(off: f32) -> usize {
    let mut stream = Stream::new(11);
    let place = |name: &str| light(name, &[ShaderParam::float("intensity", 2.0)]).expect(name);
    let mut lights: Vec<Arc<dyn PlacedLight>> = ["ambientlight", "distantlight", "pointlight", "spotlight"]
        .map(|name| place(name).shader.place(&DMat4::from_rotation_x(0.4)))
        .into();
    lights.push(Arc::new(HalfAmbient));
    let mut differ = 0;
    for len in [1usize, 5, 16, 33, 200] {
        let points = random_points(len, &mut stream);
        let all: Vec<u32> = (0..len as u32).collect();
        let some: Vec<u32> = all.iter().copied().filter(|_| stream.below(4) > 0).collect();
        let cases = [(&all, Some(10.0)), (&some, Some(0.3)), (&some, None), (&all, Some(f32::INFINITY))];
        for ((vertices, exponent), mix) in cases.iter().flat_map(|case| MIXES.map(|mix| (*case, mix))) {
            let wanted = Wanted { diffuse: true, exponent };
            let blank =
                || ShadedPoints { ci: Vec3s::splat(Vec3::ONE, len), oi: Vec3s::splat(Vec3::ONE, len) };
            let mut expected = blank();
            for &vertex in vertices {
                let ix = vertex as usize;
                let mut facing = Facing::new(&points, ix);
                facing.nf.x += off;
                let reflected = reflect_one(facing, &lights, wanted);
                let os = points.os.get(ix);
                expected.oi.set(ix, os);
                let cs = points.cs.get(ix);
                let ci = [0, 1, 2].map(|c| mix.color(c, cs[c], reflected.channel(c)));
                expected.ci.set(ix, os * finite3(Vec3::from_array(ci)));
            }
            for level in SimdLevel::all() {
                let mut out = blank();
                write_lit(level, &points, vertices, (&lights, wanted), &mut out, &mix);
                differ += usize::from(bits(&out) != bits(&expected));
            }
        }
    }
    differ
}

#[test]
fn what_faces_the_eye_has_the_bits_of_the_twin() {
    let mut stream = Stream::new(5);
    for (len, shift) in [(1usize, 0.0), (16, 0.0), (77, 0.0), (300, 1e-5)] {
        let points = random_points(len, &mut stream);
        let vertices: Vec<u32> = (0..len as u32).filter(|_| stream.below(5) > 0).collect();
        let blank = || ShadedPoints { ci: Vec3s::splat(Vec3::ONE, len), oi: Vec3s::splat(Vec3::ONE, len) };
        let color = |cs: f32, d: f32| cs * (0.2 + 0.8 * (d * d));
        let mut expected = blank();
        for ix in vertices.iter().map(|&vertex| vertex as usize) {
            let (n, i) = (normalize_or_zero(points.n.get(ix)), normalize_or_zero(points.i.get(ix)));
            let os = points.os.get(ix);
            expected.oi.set(ix, os);
            let ci = points.cs.get(ix).to_array().map(|cs| color(cs, n.dot(i) + shift));
            expected.ci.set(ix, os * finite3(Vec3::from_array(ci)));
        }
        for level in SimdLevel::all() {
            let mut out = blank();
            write_facing(level, &points, &vertices, &mut out, [0.2, 0.8]);
            assert_eq!(bits(&out) == bits(&expected), shift == 0.0, "{len} points, {level:?}");
        }
    }
}

#[test]
fn lanes_give_the_bits_of_the_twin_for_any_input() {
    assert_eq!(compare(0.0), 0);
}

#[test]
fn a_normal_a_little_off_is_noticed() {
    assert!(compare(1e-6) > 0);
}
