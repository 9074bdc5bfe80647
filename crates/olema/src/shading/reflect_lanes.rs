//! What arrives at 16 vertices and what of it goes to the eye.
//!
//! In: vertices of a grid, the lights. Out: colours, the same bits as those of the scalar twin, [`super::reflect`]. Loops
//! over lanes, choices by selects; to be called within [`SimdLevel::run`]. What is rare (a vector too long or too short to
//! be squared) goes to the twin.

#![allow(clippy::needless_range_loop)] // A loop over lanes reads as what it becomes.

use std::sync::Arc;

use glam::Vec3;

use super::reflect::{ReflectedChannel, Wanted, finite, normalize_or_zero};
use super::{Lanes3, LightSample, PlacedLight, ShadedPoints, ShadingPoints};
use crate::math::simd::{LANES, SimdLevel};
use crate::math::{Vec3s, function};

const ZEROS: Lanes3 = [[0.0; LANES]; 3];

/// Writes Oi = Os, Ci = Os * `color(channel, Cs, what is reflected)` at `vertices`.
pub(super) fn write_lit(
    level: SimdLevel,
    points: &ShadingPoints,
    vertices: &[u32],
    (lights, wanted): (&[Arc<dyn PlacedLight>], Wanted),
    out: &mut ShadedPoints,
    color: impl Fn(usize, f32, ReflectedChannel) -> f32,
) {
    write_each(
        level,
        points,
        vertices,
        out,
        #[inline(always)]
        |picked| reflect(level, points, picked, lights, wanted),
        #[inline(always)]
        |sums, c, cs, lane| {
            let reflected = ReflectedChannel {
                ambient: finite(sums.ambient[c][lane]),
                diffuse: finite(sums.diffuse[c][lane]),
                specular: finite(sums.specular[c][lane]),
            };
            color(c, cs, reflected)
        },
    );
}

/// Writes Oi = Os, Ci = Os * `color(Cs, cosine between N and I)` at `vertices`.
pub(super) fn write_facing(
    level: SimdLevel,
    points: &ShadingPoints,
    vertices: &[u32],
    out: &mut ShadedPoints,
    color: impl Fn(f32, f32) -> f32,
) {
    write_each(
        level,
        points,
        vertices,
        out,
        #[inline(always)]
        |picked| dot(&normalize(&picked.load(&points.n)), &normalize(&picked.load(&points.i))),
        #[inline(always)]
        |cos, _, cs, lane| color(cs, cos[lane]),
    );
}

/// Writes Oi = Os, Ci = Os * `color(known, channel, Cs, lane)` at `vertices`; what is `known` is found out for 16 at a time.
#[inline(always)]
fn write_each<T>(
    level: SimdLevel,
    points: &ShadingPoints,
    vertices: &[u32],
    out: &mut ShadedPoints,
    find: impl Fn(&Picked) -> T,
    color: impl Fn(&T, usize, f32, usize) -> f32,
) {
    level.run(
        #[inline(always)]
        || {
            let mut left = vertices;
            while !left.is_empty() {
                let (picked, rest) = Picked::next(left, points.p.len());
                let known = find(&picked);
                let (cs, os) = (picked.load(&points.cs), picked.load(&points.os));
                let mut ci: Lanes3 = ZEROS;
                // Channel by channel: vectors of three would not go in lanes.
                for c in 0..3 {
                    for lane in 0..LANES {
                        ci[c][lane] = os[c][lane] * finite(color(&known, c, cs[c][lane], lane));
                    }
                }
                picked.store(&mut out.oi, &os);
                picked.store(&mut out.ci, &ci);
                left = rest;
            }
        },
    );
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

    /// Their values; any other vertex's in lanes that are left over.
    #[inline(always)]
    fn load(&self, from: &Vec3s) -> Lanes3 {
        let mut to = ZEROS;
        for (to, from) in to.iter_mut().zip(from.axes()) {
            match *self {
                Picked::Row { first, .. } => to.copy_from_slice(&from[first..first + LANES]),
                Picked::Apart(vertices) => {
                    *to = [from[vertices[0] as usize]; LANES];
                    to.iter_mut().zip(vertices).for_each(|(to, &vertex)| *to = from[vertex as usize]);
                }
            }
        }
        to
    }

    #[inline(always)]
    fn store(&self, to: &mut Vec3s, from: &Lanes3) {
        for (to, from) in to.axes_mut().into_iter().zip(from) {
            match *self {
                Picked::Row { first, bits } => {
                    let to = &mut to[first..first + LANES];
                    for lane in 0..LANES {
                        to[lane] = if bits >> lane & 1 == 1 { from[lane] } else { to[lane] };
                    }
                }
                Picked::Apart(vertices) => {
                    from.iter().zip(vertices).for_each(|(&from, &vertex)| to[vertex as usize] = from);
                }
            }
        }
    }
}

/// Sums over all lights.
struct Sums {
    ambient: Lanes3,
    diffuse: Lanes3,
    specular: Lanes3,
}

#[inline(always)]
fn reflect(
    level: SimdLevel,
    points: &ShadingPoints,
    picked: &Picked,
    lights: &[Arc<dyn PlacedLight>],
    wanted: Wanted,
) -> Sums {
    let mut sums = Sums { ambient: ZEROS, diffuse: ZEROS, specular: ZEROS };
    let i = picked.load(&points.i);
    let nf = facing(&i, &picked.load(&points.n), &picked.load(&points.ng));
    // Vectors towards the eye, where a highlight needs them.
    let v = match wanted.exponent {
        Some(_) => normalize(&i).map(|component| component.map(|c| -c)),
        None => i,
    };
    let p = picked.load(&points.p);
    for light in lights {
        let Some((l, cl)) = arriving(level, &**light, &p, &mut sums.ambient) else { continue };
        let cos = dot(&nf, &l);
        if !cos.iter().fold(false, |any, &cos| any | (cos > 0.0)) {
            continue;
        }
        if wanted.diffuse {
            add(&mut sums.diffuse, &cl, &cos, &cos);
        }
        if let Some(exponent) = wanted.exponent {
            let mut half = l;
            for c in 0..3 {
                for lane in 0..LANES {
                    half[c][lane] += v[c][lane];
                }
            }
            let mut share = dot(&nf, &normalize(&half));
            for share in &mut share {
                *share = function::pow_in_lanes(share.clamp(0.0, 1.0), exponent);
            }
            add(&mut sums.specular, &cl, &share, &cos);
        }
    }
    sums
}

/// Adds `cl * by` where `cos` is above 0.
#[inline(always)]
fn add(sum: &mut Lanes3, cl: &Lanes3, by: &[f32; LANES], cos: &[f32; LANES]) {
    for c in 0..3 {
        for lane in 0..LANES {
            let more = sum[c][lane] + cl[c][lane] * by[lane];
            sum[c][lane] = if cos[lane] > 0.0 { more } else { sum[c][lane] };
        }
    }
}

/// Unit vectors to a light from 16 points and its colours there; what comes from everywhere goes to `ambient`.
#[inline(always)]
fn arriving(
    level: SimdLevel,
    light: &dyn PlacedLight,
    p: &Lanes3,
    ambient: &mut Lanes3,
) -> Option<(Lanes3, Lanes3)> {
    if light.is_alike_everywhere() {
        return match light.sample(at(p, 0)) {
            LightSample::Ambient { cl } => {
                for c in 0..3 {
                    for lane in 0..LANES {
                        ambient[c][lane] += cl[c];
                    }
                }
                None
            }
            LightSample::From { l, cl } => Some((splat(l), splat(cl))),
        };
    }
    if let Some([l, cl]) = light.sample_lanes(level, p) {
        return Some((l, cl));
    }
    let (mut to_light, mut colors, mut is_from) = (ZEROS, ZEROS, false);
    for lane in 0..LANES {
        match light.sample(at(p, lane)) {
            LightSample::Ambient { cl } => set(ambient, lane, at(ambient, lane) + cl),
            LightSample::From { l, cl } => {
                is_from = true;
                set(&mut to_light, lane, l);
                set(&mut colors, lane, cl);
            }
        }
    }
    // Where it is ambient the vector is zero, and so is the cosine.
    is_from.then_some((to_light, colors))
}

/// Unit normals turned towards the eye, or zeros: see [`super::reflect::Facing`].
#[inline(always)]
fn facing(i: &Lanes3, n: &Lanes3, ng: &Lanes3) -> Lanes3 {
    let n = normalize(n);
    let (geometric, shading) = (dot(i, ng), dot(i, &n));
    let mut nf = n;
    for c in 0..3 {
        for lane in 0..LANES {
            let fails = geometric[lane] == 0.0 || geometric[lane].is_nan();
            let away = if fails { shading[lane] } else { geometric[lane] };
            nf[c][lane] = if away > 0.0 { -n[c][lane] } else { n[c][lane] };
        }
    }
    nf
}

/// [`normalize_or_zero`] in every lane.
#[inline(always)]
pub(super) fn normalize(v: &Lanes3) -> Lanes3 {
    let squared = dot(v, v);
    let (mut unit, mut all_fit) = (*v, true);
    for lane in 0..LANES {
        let scale = 1.0 / squared[lane].sqrt();
        for c in 0..3 {
            unit[c][lane] = v[c][lane] * scale;
        }
        all_fit &= squared[lane] > 1e-30 && squared[lane] < 1e30;
    }
    if !all_fit {
        (0..LANES).for_each(|lane| set(&mut unit, lane, normalize_or_zero(at(v, lane))));
    }
    unit
}

#[inline(always)]
pub(super) fn dot(a: &Lanes3, b: &Lanes3) -> [f32; LANES] {
    std::array::from_fn(|lane| a[0][lane] * b[0][lane] + a[1][lane] * b[1][lane] + a[2][lane] * b[2][lane])
}

#[inline(always)]
pub(super) fn splat(v: Vec3) -> Lanes3 {
    [[v.x; LANES], [v.y; LANES], [v.z; LANES]]
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
