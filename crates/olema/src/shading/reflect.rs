//! What arrives at a vertex and what of it goes to the eye: RenderMan's `ambient`, `diffuse` and `specular`.
//!
//! In: a vertex's position, normals and direction from the eye, and the lights. Out: the three sums. Each
//! vertex by itself, lights in their order. Source: RenderMan Interface 3.2, section 15.6. Twin in lanes:
//! `reflect_lanes`.

use std::sync::Arc;

use glam::Vec3;

use super::{LightSample, PlacedLight, ShadingPoints};
use crate::math::function;

/// Unit vector along `v`; zero where `v` is zero or not finite.
#[inline]
pub(super) fn normalize_or_zero(v: Vec3) -> Vec3 {
    let squared = v.dot(v);
    if squared > 1e-30 && squared < 1e30 {
        return v * (1.0 / squared.sqrt());
    }
    // The square would lose digits or overflow: bring the longest component to 1 first.
    let longest = v.x.abs().max(v.y.abs()).max(v.z.abs());
    if longest > 0.0 && v.is_finite() {
        let scaled = v / longest;
        scaled / scaled.dot(scaled).sqrt()
    } else {
        Vec3::ZERO
    }
}

/// `x`, with infinities made the largest float and not-a-number 0: black times infinitely bright stays black.
#[inline(always)]
pub(super) fn finite(x: f32) -> f32 {
    if x.is_nan() { 0.0 } else { x.clamp(f32::MIN, f32::MAX) }
}

/// [`finite`] in each channel.
#[inline(always)]
pub(super) fn finite3(v: Vec3) -> Vec3 {
    Vec3::new(finite(v.x), finite(v.y), finite(v.z))
}

/// A vertex as the reflection functions need it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facing {
    /// Position, camera space.
    pub p: Vec3,
    /// Unit normal turned towards the eye, or zero.
    pub nf: Vec3,
    /// Unit vector towards the eye.
    pub v: Vec3,
}

impl Facing {
    /// Vertex `ix`: Nf = faceforward(normalize(N), I), V = -normalize(I).
    #[inline]
    pub fn new(points: &ShadingPoints, ix: usize) -> Self {
        let i = points.i.get(ix);
        let n = normalize_or_zero(points.n.get(ix));
        // RenderMan decides by the geometric normal; where that fails (an edge seen exactly from the side, a
        // pole) by the shading normal.
        let geometric = i.dot(points.ng.get(ix));
        let away = if geometric == 0.0 || geometric.is_nan() { i.dot(n) } else { geometric };
        let nf = if away > 0.0 { -n } else { n };
        Facing { p: points.p.get(ix), nf, v: -normalize_or_zero(i) }
    }
}

/// Sums over all lights.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Reflected {
    /// Sum of the ambient lights' colours.
    pub ambient: Vec3,
    /// Sum of Cl (N.L).
    pub diffuse: Vec3,
    /// Sum of Cl (N.H)^(1/roughness), H halfway between L and V.
    pub specular: Vec3,
}

impl Reflected {
    /// One channel of it.
    #[inline(always)]
    pub fn channel(&self, c: usize) -> ReflectedChannel {
        ReflectedChannel { ambient: self.ambient[c], diffuse: self.diffuse[c], specular: self.specular[c] }
    }
}

/// [`Reflected`] in one channel.
#[derive(Debug, Clone, Copy)]
pub(super) struct ReflectedChannel {
    pub ambient: f32,
    pub diffuse: f32,
    pub specular: f32,
}

/// Which sums are wanted besides the ambient one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted {
    /// Whether the diffuse one is.
    pub diffuse: bool,
    /// 1/roughness where the specular one is.
    pub exponent: Option<f32>,
}

/// What becomes of the sums: Ci / Os = Cs (Ka ambient + Kd diffuse + Ks specular) + highlight Ks specular.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mix {
    /// Ka.
    pub ambient: f32,
    /// Kd, if it is of any use.
    pub diffuse: Option<f32>,
    /// Ks of what has the surface's colour.
    pub specular: Option<f32>,
    /// Ks of what has a colour of its own, and that.
    pub highlight: Option<(f32, Vec3)>,
}

impl Mix {
    /// Channel `c` of the colour.
    #[inline(always)]
    pub fn color(&self, c: usize, cs: f32, r: ReflectedChannel) -> f32 {
        let mut body = self.ambient * r.ambient;
        if let Some(kd) = self.diffuse {
            body += kd * r.diffuse;
        }
        if let Some(ks) = self.specular {
            body += ks * r.specular;
        }
        let mut color = cs * body;
        if let Some((ks, highlight)) = self.highlight {
            color += highlight[c] * (ks * r.specular);
        }
        color
    }
}

/// Gathers the lights at a vertex. Directional light counts within a right angle of the normal; a zero normal
/// gets ambient light only.
#[inline]
pub(super) fn reflect(at: Facing, lights: &[Arc<dyn PlacedLight>], wanted: Wanted) -> Reflected {
    let mut sum = Reflected::default();
    for light in lights {
        match light.sample(at.p) {
            LightSample::Ambient { cl } => sum.ambient += cl,
            LightSample::From { l, cl } => {
                let cos = at.nf.dot(l);
                if cos > 0.0 {
                    if wanted.diffuse {
                        sum.diffuse += cl * cos;
                    }
                    if let Some(exponent) = wanted.exponent {
                        // Rounding may leave N.H a little above 1, which a great exponent would blow up.
                        let cos = at.nf.dot(normalize_or_zero(l + at.v)).clamp(0.0, 1.0);
                        sum.specular += cl * function::pow(cos, exponent);
                    }
                }
            }
        }
    }
    Reflected {
        ambient: finite3(sum.ambient),
        diffuse: finite3(sum.diffuse),
        specular: finite3(sum.specular),
    }
}
