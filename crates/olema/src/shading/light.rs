//! RenderMan's standard lights.
//!
//! In: parameters in the light's own space. Out: after placing, the light that arrives at a point of camera
//! space. Formulas and defaults are those of RenderMan Interface 3.2, appendix A.3; distances and angles are
//! measured in camera space, after the light's points were moved there.

use std::sync::Arc;

use glam::{DMat4, DVec3, Vec3};

use super::params::Params;
use super::reflect::{finite, finite3, normalize_or_zero};
use super::reflect_lanes::{dot, normalize, splat};
use super::{Lanes3, LightSample, LightShader, PlacedLight};
use crate::error::Error;
use crate::math::function;
use crate::math::simd::{LANES, SimdLevel};

/// Names of the lights there are.
pub const LIGHTS: [&str; 4] = ["ambientlight", "distantlight", "pointlight", "spotlight"];

/// Makes the light of that name; `None` where there is none.
pub(super) fn make(name: &str, params: &mut Params) -> Result<Option<Arc<dyn LightShader>>, Error> {
    if !LIGHTS.contains(&name) {
        return Ok(None);
    }
    let cl = finite3(params.float("intensity", 1.0)? * params.color("lightcolor", 1.0)?);
    Ok(Some(match name {
        "ambientlight" => Arc::new(AmbientLight { cl }),
        "distantlight" => Arc::new(DistantLight { beam: Beam::read(params)?, cl }),
        "pointlight" => Arc::new(PointLight { from: params.point("from", Vec3::ZERO)?.as_dvec3(), cl }),
        _ => Arc::new(SpotLight::read(params, cl)?),
    }))
}

/// From somewhere towards somewhere.
#[derive(Debug, Clone, Copy)]
struct Beam {
    from: DVec3,
    to: DVec3,
}

impl Beam {
    /// Reads "from" and "to", (0, 0, 0) and (0, 0, 1) by default.
    fn read(params: &mut Params) -> Result<Self, Error> {
        let (from, to) = (params.point("from", Vec3::ZERO)?, params.point("to", Vec3::Z)?);
        if from == to {
            params.warn("from and to are one point: a light without direction gives no light");
        }
        Ok(Beam { from: from.as_dvec3(), to: to.as_dvec3() })
    }

    /// Where it starts and its unit direction, in camera space; `None` where it has none.
    fn place(&self, to_camera: &DMat4) -> Option<(Vec3, Vec3)> {
        let (from, to) = (move_point(to_camera, self.from)?, move_point(to_camera, self.to)?);
        let along = to - from;
        let longest = along.abs().max_element();
        // First to the size of 1, so that neither squaring nor going to floats can lose it.
        (longest > 0.0).then(|| {
            let scaled = along / longest;
            (from.as_vec3(), (scaled / scaled.dot(scaled).sqrt()).as_vec3())
        })
    }
}

/// A point carried over by a matrix that may be projective; `None` where it does not stay finite.
fn move_point(matrix: &DMat4, point: DVec3) -> Option<DVec3> {
    let moved = *matrix * point.extend(1.0);
    let place = if moved.w == 1.0 { moved.truncate() } else { moved.truncate() / moved.w };
    (place.is_finite() && place.as_vec3().is_finite()).then_some(place)
}

/// Light everywhere, from everywhere: Cl = intensity lightcolor.
#[derive(Debug)]
struct AmbientLight {
    cl: Vec3,
}

impl LightShader for AmbientLight {
    fn name(&self) -> &str {
        "ambientlight"
    }

    fn place(&self, _to_camera: &DMat4) -> Arc<dyn PlacedLight> {
        Arc::new(PlacedAmbient { cl: self.cl })
    }
}

#[derive(Debug)]
struct PlacedAmbient {
    cl: Vec3,
}

impl PlacedLight for PlacedAmbient {
    fn sample(&self, _p: Vec3) -> LightSample {
        LightSample::Ambient { cl: self.cl }
    }

    fn is_alike_everywhere(&self) -> bool {
        true
    }
}

/// Parallel light along to - from: Cl = intensity lightcolor.
#[derive(Debug)]
struct DistantLight {
    beam: Beam,
    cl: Vec3,
}

impl LightShader for DistantLight {
    fn name(&self) -> &str {
        "distantlight"
    }

    fn place(&self, to_camera: &DMat4) -> Arc<dyn PlacedLight> {
        match self.beam.place(to_camera) {
            Some((_, axis)) => Arc::new(PlacedDistant { l: -axis, cl: self.cl }),
            None => Arc::new(PlacedDistant { l: Vec3::ZERO, cl: Vec3::ZERO }),
        }
    }
}

#[derive(Debug)]
struct PlacedDistant {
    l: Vec3,
    cl: Vec3,
}

impl PlacedLight for PlacedDistant {
    fn sample(&self, _p: Vec3) -> LightSample {
        LightSample::From { l: self.l, cl: self.cl }
    }

    fn is_alike_everywhere(&self) -> bool {
        true
    }
}

/// Light from a point to all sides: Cl = intensity lightcolor / L.L.
#[derive(Debug)]
struct PointLight {
    from: DVec3,
    cl: Vec3,
}

impl LightShader for PointLight {
    fn name(&self) -> &str {
        "pointlight"
    }

    fn place(&self, to_camera: &DMat4) -> Arc<dyn PlacedLight> {
        match move_point(to_camera, self.from) {
            Some(from) => Arc::new(PlacedPoint { from: from.as_vec3(), cl: self.cl }),
            None => Arc::new(PlacedPoint { from: Vec3::ZERO, cl: Vec3::ZERO }),
        }
    }
}

/// Unit vector from `p` to `from` and 1 / distance squared, at most the largest float. At the light itself
/// there is no direction, and so no light.
#[inline]
fn towards(from: Vec3, p: Vec3) -> (Vec3, f32) {
    let along = from - p;
    (normalize_or_zero(along), (1.0 / along.dot(along)).min(f32::MAX))
}

#[derive(Debug)]
struct PlacedPoint {
    from: Vec3,
    cl: Vec3,
}

impl PlacedLight for PlacedPoint {
    fn sample(&self, p: Vec3) -> LightSample {
        let (l, falloff) = towards(self.from, p);
        LightSample::From { l, cl: finite3(falloff * self.cl) }
    }

    fn sample_lanes(&self, level: SimdLevel, p: &Lanes3) -> Option<[Lanes3; 2]> {
        Some(level.run(
            #[inline(always)]
            || {
                let (l, falloff) = towards_lanes(self.from, p);
                [l, colors(&falloff, self.cl)]
            },
        ))
    }
}

/// [`towards`] in lanes.
#[inline(always)]
fn towards_lanes(from: Vec3, p: &Lanes3) -> (Lanes3, [f32; LANES]) {
    let mut along = splat(from);
    for (along, p) in along.iter_mut().zip(p) {
        along.iter_mut().zip(p).for_each(|(along, p)| *along -= p);
    }
    let mut falloff = dot(&along, &along);
    for falloff in &mut falloff {
        *falloff = (1.0 / *falloff).min(f32::MAX);
    }
    (normalize(&along), falloff)
}

/// Colours of a light of which a share arrives.
#[inline(always)]
fn colors(shares: &[f32; LANES], cl: Vec3) -> Lanes3 {
    let mut colors = splat(cl);
    for channel in &mut colors {
        channel.iter_mut().zip(shares).for_each(|(color, share)| *color = finite(share * *color));
    }
    colors
}

/// A cone of light: with c the cosine of the angle off the axis, Cl = intensity lightcolor
/// c^beamdistribution / L.L smoothstep(cos(coneangle), cos(coneangle - conedeltaangle), c).
#[derive(Debug)]
struct SpotLight {
    beam: Beam,
    cl: Vec3,
    cone: Cone,
}

#[derive(Debug, Clone, Copy)]
struct Cone {
    /// Cosine of the cone's half angle: no light from here outwards.
    cos_outer: f32,
    /// Cosine where the light begins to fade.
    cos_inner: f32,
    beam_distribution: f32,
}

impl Cone {
    /// The share of light at an angle of that cosine off the axis.
    #[inline(always)]
    fn share(&self, cos: f32) -> f32 {
        let beam = function::pow_in_lanes(cos.clamp(0.0, 1.0), self.beam_distribution).min(f32::MAX);
        let t = (cos - self.cos_outer) / (self.cos_inner - self.cos_outer);
        let fading = beam * (t * t * (3.0 - 2.0 * t));
        let within = if cos >= self.cos_inner { beam } else { fading };
        if cos < self.cos_outer { 0.0 } else { within }
    }
}

impl SpotLight {
    fn read(params: &mut Params, cl: Vec3) -> Result<Self, Error> {
        let beam = Beam::read(params)?;
        let radians = std::f32::consts::PI / 180.0;
        let outer = params.float("coneangle", 30.0 * radians)?;
        let delta = params.float("conedeltaangle", 5.0 * radians)?;
        let beam_distribution = params.float("beamdistribution", 2.0)?;
        // Beyond half a turn the cone is all there is; the cosine alone would close it again.
        let outer = f64::from(outer).clamp(0.0, std::f64::consts::PI);
        let cone = Cone {
            cos_outer: function::cos64(outer) as f32,
            cos_inner: function::cos64(outer - f64::from(delta)) as f32,
            beam_distribution,
        };
        Ok(SpotLight { beam, cl, cone })
    }
}

impl LightShader for SpotLight {
    fn name(&self) -> &str {
        "spotlight"
    }

    fn place(&self, to_camera: &DMat4) -> Arc<dyn PlacedLight> {
        let (from, axis, cl) = match self.beam.place(to_camera) {
            Some((from, axis)) => (from, axis, self.cl),
            None => (Vec3::ZERO, Vec3::Z, Vec3::ZERO),
        };
        Arc::new(PlacedSpot { from, axis, cl, cone: self.cone })
    }
}

#[derive(Debug)]
struct PlacedSpot {
    from: Vec3,
    axis: Vec3,
    cl: Vec3,
    cone: Cone,
}

impl PlacedLight for PlacedSpot {
    fn sample(&self, p: Vec3) -> LightSample {
        let (l, falloff) = towards(self.from, p);
        let share = self.cone.share(-l.dot(self.axis));
        LightSample::From { l, cl: finite3((falloff * share).min(f32::MAX) * self.cl) }
    }

    fn sample_lanes(&self, level: SimdLevel, p: &Lanes3) -> Option<[Lanes3; 2]> {
        Some(level.run(
            #[inline(always)]
            || {
                let (l, mut shares) = towards_lanes(self.from, p);
                let along = dot(&l, &splat(self.axis));
                for (share, along) in shares.iter_mut().zip(along) {
                    *share = (*share * self.cone.share(-along)).min(f32::MAX);
                }
                [l, colors(&shares, self.cl)]
            },
        ))
    }
}

#[cfg(test)]
#[path = "light_tests.rs"]
mod tests;
