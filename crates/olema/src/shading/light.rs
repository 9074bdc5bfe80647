//! RenderMan's standard lights.
//!
//! In: parameters in the light's own space. Out: after placing, the light that arrives at a point of camera
//! space. Formulas and defaults are those of RenderMan Interface 3.2, appendix A.3; distances and angles are
//! measured in camera space, after the light's points were moved there.

use std::sync::Arc;

use glam::{DMat4, DVec3, Vec3};

use super::params::Params;
use super::reflect::{finite3, normalize_or_zero};
use super::reflect_lanes::{dot, finite, loaded, normalize, splat, stored};
use super::{Lanes3, LightSample, LightShader, PlacedLight};
use crate::error::Error;
use crate::math::function;
use crate::math::lanes::Lanes;
use crate::math::simd::{LANES, LanesKernel, SimdLevel};

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
        Some(level.run_lanes(Arriving { from: self.from, cl: self.cl, cone: None, p }))
    }
}

/// What arrives at 16 points of a light that is somewhere, in a cone around an axis if it has one.
struct Arriving<'a> {
    from: Vec3,
    cl: Vec3,
    cone: Option<(&'a Cone, Vec3)>,
    p: &'a Lanes3,
}

impl LanesKernel for Arriving<'_> {
    type Output = [Lanes3; 2];

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> [Lanes3; 2] {
        let Arriving { from, cl, cone, p } = self;
        let mut along = splat(lanes, from);
        for (along, p) in along.iter_mut().zip(loaded(lanes, p)) {
            *along = lanes.sub_f(*along, p);
        }
        let falloff = lanes.div_f(lanes.splat_f(1.0), dot(lanes, along, along));
        let mut share = lanes.lesser(falloff, lanes.splat_f(f32::MAX));
        let l = normalize(lanes, along, 0xffff);
        if let Some((cone, axis)) = cone {
            let (mut off_axis, mut shares) = ([0.0; LANES], [0.0; LANES]);
            lanes.store_f(dot(lanes, l, splat(lanes, axis)), &mut off_axis, 0);
            lanes.store_f(share, &mut shares, 0);
            for (share, along) in shares.iter_mut().zip(&off_axis) {
                *share = (*share * cone.share(-along)).min(f32::MAX);
            }
            share = lanes.load_f(&shares, 0);
        }
        let mut colors = splat(lanes, cl);
        for color in &mut colors {
            *color = finite(lanes, lanes.mul_f(share, *color));
        }
        [stored(lanes, l), stored(lanes, colors)]
    }
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
        let cone = Some((&self.cone, self.axis));
        Some(level.run_lanes(Arriving { from: self.from, cl: self.cl, cone, p }))
    }
}

#[cfg(test)]
#[path = "light_tests.rs"]
mod tests;
