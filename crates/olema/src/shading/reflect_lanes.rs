//! What arrives at 16 vertices and what of it goes to the eye.
//!
//! In: vertices of a grid, the lights. Out: colours, the same bits as those of the scalar twin, [`super::reflect`]. What is
//! rare (a vector too long or too short to be squared) goes to the twin.

use std::sync::Arc;

use glam::Vec3;

use super::reflect::{Mix, Wanted, normalize_or_zero};
use super::{Lanes3, LightSample, PlacedLight, ShadedPoints, ShadingPoints};
use crate::math::lanes::Lanes;
use crate::math::simd::{LANES, LanesKernel, SimdLevel};
use crate::math::{Vec3s, function};

const ZEROS: Lanes3 = [[0.0; LANES]; 3];

/// Vectors by component.
pub(super) type Vectors<L> = [<L as Lanes>::F; 3];

/// Writes Oi = Os, Ci = Os * what `mix` makes of Cs and of what is reflected, at `vertices`.
pub(super) fn write_lit(
    level: SimdLevel,
    points: &ShadingPoints,
    vertices: &[u32],
    (lights, wanted): (&[Arc<dyn PlacedLight>], Wanted),
    out: &mut ShadedPoints,
    mix: &Mix,
) {
    level.run_lanes(Lit { level, points, vertices, lights, wanted, out, mix });
}

/// Writes Oi = Os, Ci = Os Cs (`ka` + `kd` d^2) at `vertices`, d the cosine between N and I.
pub(super) fn write_facing(
    level: SimdLevel,
    points: &ShadingPoints,
    vertices: &[u32],
    out: &mut ShadedPoints,
    [ka, kd]: [f32; 2],
) {
    level.run_lanes(FacingEye { points, vertices, out, ka, kd });
}

struct Lit<'a> {
    level: SimdLevel,
    points: &'a ShadingPoints,
    vertices: &'a [u32],
    lights: &'a [Arc<dyn PlacedLight>],
    wanted: Wanted,
    out: &'a mut ShadedPoints,
    mix: &'a Mix,
}

impl LanesKernel for Lit<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Lit { level, points, vertices, lights, wanted, out, mix } = self;
        let mut left = vertices;
        while !left.is_empty() {
            let (picked, rest) = Picked::next(left, points.p.len());
            let sums = reflect(lanes, level, points, &picked, lights, wanted);
            let (cs, os) = (picked.load(lanes, &points.cs), picked.load(lanes, &points.os));
            let mut ci = cs;
            for c in 0..3 {
                let color = sums.mixed(lanes, mix, c, cs[c]);
                ci[c] = lanes.mul_f(os[c], finite(lanes, color));
            }
            picked.store(lanes, &mut out.oi, os);
            picked.store(lanes, &mut out.ci, ci);
            left = rest;
        }
    }
}

struct FacingEye<'a> {
    points: &'a ShadingPoints,
    vertices: &'a [u32],
    out: &'a mut ShadedPoints,
    ka: f32,
    kd: f32,
}

impl LanesKernel for FacingEye<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let FacingEye { points, vertices, out, ka, kd } = self;
        let mut left = vertices;
        while !left.is_empty() {
            let (picked, rest) = Picked::next(left, points.p.len());
            let n = normalize(lanes, picked.load(lanes, &points.n), picked.lanes());
            let d = dot(lanes, n, normalize(lanes, picked.load(lanes, &points.i), picked.lanes()));
            let shown = lanes.mul_f(lanes.splat_f(kd), lanes.mul_f(d, d));
            let shown = lanes.add_f(lanes.splat_f(ka), shown);
            let (cs, os) = (picked.load(lanes, &points.cs), picked.load(lanes, &points.os));
            let mut ci = cs;
            for c in 0..3 {
                ci[c] = lanes.mul_f(os[c], finite(lanes, lanes.mul_f(cs[c], shown)));
            }
            picked.store(lanes, &mut out.oi, os);
            picked.store(lanes, &mut out.ci, ci);
            left = rest;
        }
    }
}

/// Up to 16 vertices.
enum Picked<'a> {
    /// Of 16 in a row those whose bit is set: loads and stores of lists, which is faster where at least half are.
    Row { first: usize, bits: u32 },
    /// Any.
    Apart(&'a [u32]),
}

impl<'a> Picked<'a> {
    /// The next of `vertices`, of `num` that there are, and those that are left.
    #[inline(always)]
    fn next(vertices: &'a [u32], num: usize) -> (Self, &'a [u32]) {
        let (first, mut bits, mut within) = (vertices[0], 0u32, 0);
        for &vertex in vertices {
            let lane = vertex.wrapping_sub(first);
            // In order, within the row.
            if lane as usize >= LANES || bits >> lane != 0 {
                break;
            }
            bits |= 1 << lane;
            within += 1;
        }
        if 2 * within >= LANES && first as usize + LANES <= num {
            return (Picked::Row { first: first as usize, bits }, &vertices[within..]);
        }
        let (picked, left) = vertices.split_at(vertices.len().min(LANES));
        (Picked::Apart(picked), left)
    }

    /// The lanes they are in.
    #[inline(always)]
    fn lanes(&self) -> u32 {
        match self {
            Picked::Row { bits, .. } => *bits,
            Picked::Apart(vertices) => 0xffff >> (LANES - vertices.len()),
        }
    }

    /// Their values; any other vertex's in lanes that are left over.
    #[inline(always)]
    fn load<L: Lanes>(&self, lanes: L, from: &Vec3s) -> Vectors<L> {
        let mut to = [lanes.splat_f(0.0); 3];
        for (to, from) in to.iter_mut().zip(from.axes()) {
            *to = match *self {
                Picked::Row { first, .. } => lanes.load_f(from, first),
                Picked::Apart(vertices) => {
                    let mut all = [from[vertices[0] as usize]; LANES];
                    all.iter_mut().zip(vertices).for_each(|(to, &vertex)| *to = from[vertex as usize]);
                    lanes.load_f(&all, 0)
                }
            };
        }
        to
    }

    #[inline(always)]
    fn store<L: Lanes>(&self, lanes: L, to: &mut Vec3s, from: Vectors<L>) {
        for (to, from) in to.axes_mut().into_iter().zip(from) {
            match *self {
                Picked::Row { first, bits } => {
                    let all = lanes.select_f(lanes.mask(bits), from, lanes.load_f(to, first));
                    lanes.store_f(all, to, first);
                }
                Picked::Apart(vertices) => {
                    let mut all = [0.0; LANES];
                    lanes.store_f(from, &mut all, 0);
                    all.iter().zip(vertices).for_each(|(&from, &vertex)| to[vertex as usize] = from);
                }
            }
        }
    }
}

/// Sums over all lights.
struct Sums<L: Lanes> {
    ambient: Vectors<L>,
    diffuse: Vectors<L>,
    specular: Vectors<L>,
}

impl<L: Lanes> Sums<L> {
    /// [`Mix::color`] in every lane.
    #[inline(always)]
    fn mixed(&self, lanes: L, mix: &Mix, c: usize, cs: L::F) -> L::F {
        let times = |by: f32, sum: L::F| lanes.mul_f(lanes.splat_f(by), finite(lanes, sum));
        let mut body = times(mix.ambient, self.ambient[c]);
        if let Some(kd) = mix.diffuse {
            body = lanes.add_f(body, times(kd, self.diffuse[c]));
        }
        if let Some(ks) = mix.specular {
            body = lanes.add_f(body, times(ks, self.specular[c]));
        }
        let mut color = lanes.mul_f(cs, body);
        if let Some((ks, highlight)) = mix.highlight {
            let shine = lanes.mul_f(lanes.splat_f(highlight[c]), times(ks, self.specular[c]));
            color = lanes.add_f(color, shine);
        }
        color
    }
}

#[inline(always)]
fn reflect<L: Lanes>(
    lanes: L,
    level: SimdLevel,
    points: &ShadingPoints,
    picked: &Picked,
    lights: &[Arc<dyn PlacedLight>],
    wanted: Wanted,
) -> Sums<L> {
    let none = [lanes.splat_f(0.0); 3];
    let mut sums = Sums { ambient: none, diffuse: none, specular: none };
    let i = picked.load(lanes, &points.i);
    let n = normalize(lanes, picked.load(lanes, &points.n), picked.lanes());
    let nf = facing(lanes, i, n, picked.load(lanes, &points.ng));
    // Vectors from the eye, of unit length where a highlight needs them.
    let i = if wanted.exponent.is_some() { normalize(lanes, i, picked.lanes()) } else { i };
    let p = picked.load(lanes, &points.p);
    for light in lights {
        let Some((l, cl)) = arriving(lanes, level, &**light, p, &mut sums.ambient) else { continue };
        let cos = dot(lanes, nf, l);
        let faces = lanes.lt_f(lanes.splat_f(0.0), cos);
        if lanes.bits(faces) & picked.lanes() == 0 {
            continue;
        }
        if wanted.diffuse {
            add(lanes, &mut sums.diffuse, cl, cos, faces);
        }
        if let Some(exponent) = wanted.exponent {
            let mut half = l;
            for (half, i) in half.iter_mut().zip(i) {
                *half = lanes.add_f(*half, negated(lanes, i));
            }
            let mut share = [0.0; LANES];
            lanes.store_f(dot(lanes, nf, normalize(lanes, half, picked.lanes())), &mut share, 0);
            for share in &mut share {
                *share = function::pow_in_lanes(share.clamp(0.0, 1.0), exponent);
            }
            add(lanes, &mut sums.specular, cl, lanes.load_f(&share, 0), faces);
        }
    }
    sums
}

/// Adds `cl * by` where the light is in front.
#[inline(always)]
fn add<L: Lanes>(lanes: L, sum: &mut Vectors<L>, cl: Vectors<L>, by: L::F, faces: L::M) {
    for (sum, cl) in sum.iter_mut().zip(cl) {
        *sum = lanes.select_f(faces, lanes.add_f(*sum, lanes.mul_f(cl, by)), *sum);
    }
}

/// Unit vectors to a light from 16 points and its colours there; what comes from everywhere goes to `ambient`.
#[inline(always)]
fn arriving<L: Lanes>(
    lanes: L,
    level: SimdLevel,
    light: &dyn PlacedLight,
    p: Vectors<L>,
    ambient: &mut Vectors<L>,
) -> Option<(Vectors<L>, Vectors<L>)> {
    if light.is_alike_everywhere() {
        return match light.sample(Vec3::ZERO) {
            LightSample::Ambient { cl } => {
                for (ambient, cl) in ambient.iter_mut().zip(cl.to_array()) {
                    *ambient = lanes.add_f(*ambient, lanes.splat_f(cl));
                }
                None
            }
            LightSample::From { l, cl } => Some((splat(lanes, l), splat(lanes, cl))),
        };
    }
    let all = stored(lanes, p);
    if let Some([l, cl]) = light.sample_lanes(level, &all) {
        return Some((loaded(lanes, &l), loaded(lanes, &cl)));
    }
    let (mut to_light, mut colors, mut is_from) = (ZEROS, ZEROS, false);
    let mut sums = stored(lanes, *ambient);
    for lane in 0..LANES {
        match light.sample(at(&all, lane)) {
            LightSample::Ambient { cl } => {
                let sum = at(&sums, lane) + cl;
                set(&mut sums, lane, sum);
            }
            LightSample::From { l, cl } => {
                is_from = true;
                set(&mut to_light, lane, l);
                set(&mut colors, lane, cl);
            }
        }
    }
    *ambient = loaded(lanes, &sums);
    // Where it is ambient the vector is zero, and so is the cosine.
    is_from.then(
        #[inline(always)]
        || (loaded(lanes, &to_light), loaded(lanes, &colors)),
    )
}

/// Normals, of unit length or zeros, turned towards the eye: see [`super::reflect::Facing`].
#[inline(always)]
fn facing<L: Lanes>(lanes: L, i: Vectors<L>, n: Vectors<L>, ng: Vectors<L>) -> Vectors<L> {
    let (geometric, shading) = (dot(lanes, i, ng), dot(lanes, i, n));
    let zero = lanes.splat_f(0.0);
    // Neither zero nor anything but a number.
    let decides = lanes.either(lanes.lt_f(geometric, zero), lanes.lt_f(zero, geometric));
    let away = lanes.lt_f(zero, lanes.select_f(decides, geometric, shading));
    let mut nf = n;
    for n in &mut nf {
        *n = lanes.select_f(away, negated(lanes, *n), *n);
    }
    nf
}

/// [`normalize_or_zero`] in the lanes that are `wanted`; anything in the others, which may well have nothing to normalize.
#[inline(always)]
pub(super) fn normalize<L: Lanes>(lanes: L, v: Vectors<L>, wanted: u32) -> Vectors<L> {
    let squared = dot(lanes, v, v);
    let (least, most) = (lanes.splat_f(1e-30), lanes.splat_f(1e30));
    let fit = lanes.bits(lanes.both(lanes.lt_f(least, squared), lanes.lt_f(squared, most)));
    let scale = lanes.div_f(lanes.splat_f(1.0), lanes.sqrt_f(squared));
    let mut unit = v;
    for c in &mut unit {
        *c = lanes.mul_f(*c, scale);
    }
    if wanted & !fit != 0 {
        let (mut all, given) = (ZEROS, stored(lanes, v));
        (0..LANES).for_each(|lane| set(&mut all, lane, normalize_or_zero(at(&given, lane))));
        unit = loaded(lanes, &all);
    }
    unit
}

/// [`super::reflect::finite`] in every lane.
#[inline(always)]
pub(super) fn finite<L: Lanes>(lanes: L, x: L::F) -> L::F {
    let within = lanes.lesser(lanes.greater(x, lanes.splat_f(f32::MIN)), lanes.splat_f(f32::MAX));
    lanes.select_f(lanes.eq_f(x, x), within, lanes.splat_f(0.0))
}

#[inline(always)]
pub(super) fn dot<L: Lanes>(lanes: L, a: Vectors<L>, b: Vectors<L>) -> L::F {
    let sum = lanes.add_f(lanes.mul_f(a[0], b[0]), lanes.mul_f(a[1], b[1]));
    lanes.add_f(sum, lanes.mul_f(a[2], b[2]))
}

#[inline(always)]
fn negated<L: Lanes>(lanes: L, x: L::F) -> L::F {
    lanes.of_bits(lanes.xor(lanes.bits_of(x), lanes.splat(i32::MIN)))
}

#[inline(always)]
pub(super) fn splat<L: Lanes>(lanes: L, v: Vec3) -> Vectors<L> {
    [lanes.splat_f(v.x), lanes.splat_f(v.y), lanes.splat_f(v.z)]
}

#[inline(always)]
pub(super) fn loaded<L: Lanes>(lanes: L, v: &Lanes3) -> Vectors<L> {
    [lanes.load_f(&v[0], 0), lanes.load_f(&v[1], 0), lanes.load_f(&v[2], 0)]
}

#[inline(always)]
pub(super) fn stored<L: Lanes>(lanes: L, v: Vectors<L>) -> Lanes3 {
    let mut all = ZEROS;
    for (all, v) in all.iter_mut().zip(v) {
        lanes.store_f(v, all, 0);
    }
    all
}

#[inline(always)]
fn at(v: &Lanes3, lane: usize) -> Vec3 {
    Vec3::new(v[0][lane], v[1][lane], v[2][lane])
}

#[inline(always)]
fn set(v: &mut Lanes3, lane: usize, to: Vec3) {
    (v[0][lane], v[1][lane], v[2][lane]) = (to.x, to.y, to.z);
}

#[cfg(test)]
#[path = "reflect_lanes_tests.rs"]
mod tests;
