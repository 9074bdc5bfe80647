//! The displacement shaders there are.
//!
//! In: points in object space with their filter widths. Out: an offset for each, never longer than
//! [`DisplacementShader::amplitude`], and never anything but finite numbers.
//!
//! All but "vector" compute a height in [-1, 1] and move along the normal by amplitude * height; where there is no
//! normal they move nothing. Detail is left out before it gets finer than the filter can carry (Musgrave's clamping,
//! in Ebert et al., "Texturing and Modeling"): a wave of 4 widths is whole, one of 2 widths gone, smoothly between.

use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::displacement::{DisplacementPoints, DisplacementShader};
use super::params::Params;
use super::texture::TextureImage;
use crate::error::Error;
use crate::math::hash::{hash_all, signed_unit, unit};
use crate::math::{Vec3s, function, noise};

/// Names of the displacement shaders there are.
pub const DISPLACEMENTS: [&str; 7] = ["bumpy", "cells", "fractal", "image", "noise", "vector", "waves"];

/// Most octaves of a shader.
const MAX_OCTAVES: f32 = 16.0;

/// Offsets stay this part of the bound or below, so that rounding cannot lift them above it.
const WITHIN: f64 = 1.0 - 1e-6;

/// Where images come from: a name in, an image or a sentence out.
pub type Images<'a> = dyn Fn(&str) -> Result<Arc<TextureImage>, String> + 'a;

/// Makes the displacement shader of that name; `None` where there is none.
pub(super) fn make(
    name: &str,
    params: &mut Params,
    images: &Images,
) -> Result<Option<Arc<dyn DisplacementShader>>, Error> {
    Ok(Some(match name {
        // The standard's bump mapping, which has an image and an amplitude of 1.
        "bumpy" => Arc::new(AlongNormal {
            common: common("bumpy", params, 1.0, 1.0)?,
            height: image(params, images)?,
        }),
        "image" => Arc::new(AlongNormal {
            common: common("image", params, 0.1, 0.0)?,
            height: image(params, images)?,
        }),
        "cells" => {
            let octaves = octaves(params, 1.0)?;
            Arc::new(AlongNormal { common: common("cells", params, 0.1, 0.0)?, height: Cells { octaves } })
        }
        "fractal" => {
            let octaves = octaves(params, 6.0)?;
            Arc::new(AlongNormal {
                common: common("fractal", params, 0.1, 0.0)?,
                height: Fractal { octaves },
            })
        }
        "noise" => {
            let octaves = octaves(params, 1.0)?;
            Arc::new(AlongNormal { common: common("noise", params, 0.1, 0.0)?, height: Fractal { octaves } })
        }
        "waves" => {
            let octaves = octaves(params, 4.0)?;
            let waves = waves(params, octaves)?;
            Arc::new(AlongNormal { common: common("waves", params, 0.1, 0.0)?, height: Waves { waves } })
        }
        "vector" => {
            let octaves = octaves(params, 6.0)?;
            Arc::new(NoiseVector { common: common("vector", params, 0.1, 0.0)?, octaves })
        }
        _ => return Ok(None),
    }))
}

/// What all shaders have.
#[derive(Debug)]
struct Common {
    name: &'static str,
    /// Of either sign.
    amplitude: f32,
    bump: bool,
}

impl Common {
    /// The offset, shortened to the bound; none where it is not finite.
    #[inline]
    fn bounded(&self, offset: Vec3) -> Vec3 {
        if !offset.is_finite() {
            return Vec3::ZERO;
        }
        let (wide, most) = (offset.as_dvec3(), f64::from(self.amplitude.abs()) * WITHIN);
        let square = wide.length_squared();
        if square <= most * most { offset } else { (wide * (most / square.sqrt())).as_vec3() }
    }
}

fn common(name: &'static str, params: &mut Params, amplitude: f32, bump: f32) -> Result<Common, Error> {
    let amplitude = params.float("amplitude", amplitude)?;
    Ok(Common { name, amplitude, bump: params.float("bump", bump)? != 0.0 })
}

/// A height, -1 to 1, as a function of one point.
trait Height: std::fmt::Debug + Send + Sync {
    /// Whether it reads `s`, `t` or `st_width`.
    const READS_TEXTURE_COORDINATES: bool = false;

    fn at(&self, points: &DisplacementPoints, ix: usize) -> f32;
}

/// Moves along the normal by a height.
#[derive(Debug)]
struct AlongNormal<H> {
    common: Common,
    height: H,
}

impl<H: Height> DisplacementShader for AlongNormal<H> {
    fn reads_texture_coordinates(&self) -> bool {
        H::READS_TEXTURE_COORDINATES
    }

    fn name(&self) -> &str {
        self.common.name
    }

    fn amplitude(&self) -> Option<f32> {
        Some(self.common.amplitude.abs())
    }

    fn is_bump(&self) -> bool {
        self.common.bump
    }

    fn displace(&self, points: &DisplacementPoints, offset: &mut Vec3s) {
        for ix in 0..points.p.len() {
            let height = self.height.at(points, ix);
            offset.set(ix, self.common.bounded(points.n.get(ix) * (self.common.amplitude * height)));
        }
    }
}

/// One size of detail.
#[derive(Debug, Clone)]
struct Octave {
    frequency: f64,
    /// 1 / frequency, in object space.
    wavelength: f32,
    /// Part of the whole; all together make 1.
    weight: f32,
    /// Added to the point before scaling (the parameter "offset").
    offset: DVec3,
    /// Added after scaling: puts the octaves' lattices out of step, or all would be 0 at the origin.
    shift: DVec3,
    seed: u32,
}

impl Octave {
    /// How much of it is left at that filter width: 1 up to a quarter of its wavelength, 0 from a half on.
    #[inline]
    #[allow(clippy::manual_clamp)] // In this order infinity by infinity leaves nothing.
    fn left(&self, width: f32) -> f32 {
        if width > 0.0 {
            let t = (0.5 * (self.wavelength / width) - 1.0).max(0.0).min(1.0);
            t * t * (3.0 - 2.0 * t)
        } else {
            1.0
        }
    }

    /// The point in the octave's lattice.
    #[inline]
    fn place(&self, p: Vec3) -> [f64; 3] {
        ((p.as_dvec3() + self.offset) * self.frequency + self.shift).to_array()
    }
}

/// Octaves by the parameters "frequency", "octaves", "gain", "lacunarity", "seed" and "offset".
fn octaves(params: &mut Params, count: f32) -> Result<Vec<Octave>, Error> {
    let frequency = params.float("frequency", 1.0)?.abs();
    let count = params.float_within("octaves", count, [1.0, MAX_OCTAVES])?.round() as u32;
    let gain = params.float_within("gain", 0.5, [0.0, 1.0])?;
    let lacunarity = params.float_within("lacunarity", 2.0, [1.0, 16.0])?;
    let seed = params.float("seed", 0.0)? as i32 as u32;
    let offset = params.vector("offset", Vec3::ZERO)?.as_dvec3();
    let (mut octaves, mut sum) = (Vec::new(), 0.0);
    let (mut frequency, mut weight) = (f64::from(frequency), 1.0f32);
    for number in 0..count {
        let seed = hash_all([seed, number]);
        let shift = [1, 2, 3].map(|axis| f64::from(unit(hash_all([seed, axis]))));
        let wavelength = (1.0 / frequency) as f32;
        octaves.push(Octave { frequency, wavelength, weight, offset, shift: shift.into(), seed });
        sum += weight;
        weight *= gain;
        frequency *= f64::from(lacunarity);
    }
    octaves.iter_mut().for_each(|o| o.weight /= sum);
    Ok(octaves)
}

/// Gradient noise, in octaves: fractional Brownian motion.
#[derive(Debug)]
struct Fractal {
    octaves: Vec<Octave>,
}

impl Height for Fractal {
    fn at(&self, points: &DisplacementPoints, ix: usize) -> f32 {
        let (p, width) = (points.p.get(ix), points.width[ix]);
        fractal(&self.octaves, 0, p, width)
    }
}

/// Sum of the octaves; `channel` tells independent sums apart.
#[inline]
fn fractal(octaves: &[Octave], channel: u32, p: Vec3, width: f32) -> f32 {
    let mut sum = 0.0;
    for octave in octaves {
        let left = octave.left(width);
        // What follows is finer still.
        if left == 0.0 {
            break;
        }
        let seed = octave.seed.wrapping_add(channel.wrapping_mul(0x9e37_79b9));
        sum += octave.weight * left * noise::gradient(octave.place(p), seed);
    }
    sum.clamp(-1.0, 1.0)
}

/// Round bumps around random points, one a cell of the lattice; sharp valleys between them.
#[derive(Debug)]
struct Cells {
    octaves: Vec<Octave>,
}

/// Mean of [`cell_height`], which is what is left of one that is too fine.
const CELLS_MEAN: f32 = 0.4;

/// 1 at a feature point, -1 at the distance of a cell's side from all of them.
#[inline]
fn cell_height(place: [f64; 3], seed: u32) -> f32 {
    1.0 - 2.0 * noise::cellular(place, seed)
}

impl Height for Cells {
    fn at(&self, points: &DisplacementPoints, ix: usize) -> f32 {
        let (p, width) = (points.p.get(ix), points.width[ix]);
        let mut sum = 0.0;
        for octave in &self.octaves {
            let left = octave.left(width);
            let height = if left == 0.0 { CELLS_MEAN } else { cell_height(octave.place(p), octave.seed) };
            sum += octave.weight * (CELLS_MEAN + (height - CELLS_MEAN) * left);
        }
        sum.clamp(-1.0, 1.0)
    }
}

/// A plane wave.
#[derive(Debug)]
struct Wave {
    octave: Octave,
    direction: DVec3,
    /// In turns.
    phase: f64,
}

/// Plane sine waves in random directions.
#[derive(Debug)]
struct Waves {
    waves: Vec<Wave>,
}

/// A wave an octave, spread over all directions, or about that of the parameter "direction" where it is given.
fn waves(params: &mut Params, octaves: Vec<Octave>) -> Result<Vec<Wave>, Error> {
    let main = params.vector("direction", Vec3::ZERO)?.as_dvec3().normalize_or_zero();
    let wave = |octave: Octave| {
        let random = |channel: u32| f64::from(unit(hash_all([octave.seed, channel])));
        let (z, (sin, cos)) = (f64::from(signed_unit(hash_all([octave.seed, 4]))), turn(random(5)));
        let ring = (1.0 - z * z).sqrt();
        let any = DVec3::new(ring * cos, ring * sin, z);
        let direction = if main == DVec3::ZERO { any } else { (main + any * 0.5).normalize_or(main) };
        Wave { phase: random(6), octave, direction }
    };
    Ok(octaves.into_iter().map(wave).collect())
}

/// Sine and cosine of an angle in turns.
fn turn(turns: f64) -> (f64, f64) {
    let angle = turns * std::f64::consts::TAU;
    (function::sin64(angle), function::cos64(angle))
}

impl Height for Waves {
    fn at(&self, points: &DisplacementPoints, ix: usize) -> f32 {
        let (p, width) = (points.p.get(ix).as_dvec3(), points.width[ix]);
        let mut sum = 0.0;
        for Wave { octave, direction, phase } in &self.waves {
            let left = octave.left(width);
            if left == 0.0 {
                break;
            }
            let turns = (p + octave.offset).dot(*direction) * octave.frequency + phase;
            // Whole turns go while there are bits for them.
            let angle = (turns - turns.floor()) * std::f64::consts::TAU;
            sum += octave.weight * left * function::sin(angle as f32);
        }
        // One of infinite frequency or place has no height.
        if sum.is_nan() { 0.0 } else { sum.clamp(-1.0, 1.0) }
    }
}

/// Moves anywhere: three independent sums of octaves. A vector longer than 1 is taken as 1 long.
#[derive(Debug)]
struct NoiseVector {
    common: Common,
    octaves: Vec<Octave>,
}

impl DisplacementShader for NoiseVector {
    fn reads_texture_coordinates(&self) -> bool {
        false
    }

    fn name(&self) -> &str {
        self.common.name
    }

    fn amplitude(&self) -> Option<f32> {
        Some(self.common.amplitude.abs())
    }

    fn is_bump(&self) -> bool {
        self.common.bump
    }

    fn displace(&self, points: &DisplacementPoints, offset: &mut Vec3s) {
        for ix in 0..points.p.len() {
            let (p, width) = (points.p.get(ix), points.width[ix]);
            let vector = Vec3::from([0, 1, 2].map(|channel| fractal(&self.octaves, channel, p, width)));
            offset.set(ix, self.common.bounded(vector * self.common.amplitude));
        }
    }
}

/// A height from an image.
#[derive(Debug)]
struct ImageHeight {
    image: Arc<TextureImage>,
    /// The texel that moves nothing.
    zero: f32,
    /// Repetitions of the image over the unit square of texture coordinates.
    scale: [f32; 2],
}

/// By the parameters "texturename", "zero", "frequency", "sscale" and "tscale".
fn image(params: &mut Params, images: &Images) -> Result<ImageHeight, Error> {
    let texture = params.string("texturename")?;
    let zero = params.float_within("zero", 0.0, [0.0, 1.0])?;
    let frequency = params.float("frequency", 1.0)?;
    let scale = [params.float("sscale", 1.0)? * frequency, params.float("tscale", 1.0)? * frequency];
    if texture.is_empty() {
        return Err(params.error("parameter \"texturename\" is empty: expected the name of an image"));
    }
    let image = images(texture).map_err(|why| params.error(&why))?;
    Ok(ImageHeight { image, zero, scale })
}

impl Height for ImageHeight {
    const READS_TEXTURE_COORDINATES: bool = true;

    fn at(&self, points: &DisplacementPoints, ix: usize) -> f32 {
        let st = [points.s[ix], points.t[ix]];
        let place = [0, 1].map(|a| f64::from(st[a]) * f64::from(self.scale[a]));
        let width = self.scale.map(|s| points.st_width[ix] * s.abs());
        match self.image.sample(place, width) {
            Some(value) => (value - self.zero).clamp(-1.0, 1.0),
            None => 0.0,
        }
    }
}

#[cfg(test)]
#[path = "displacers_tests.rs"]
mod tests;
