//! The displacement shaders there are.
//!
//! In: points in object space with their filter widths. Out: an offset for each, never longer than
//! [`DisplacementShader::amplitude`], and never anything but finite numbers.
//!
//! All but "vector" compute a height in [-1, 1] and move along the normal by amplitude * height; where there is no
//! normal they move nothing. Detail is left out before it gets finer than the filter can carry (Musgrave's clamping,
//! in Ebert et al., "Texturing and Modeling"): a wave of 4 widths is whole, one of 2 widths gone, smoothly between.

#![allow(clippy::needless_range_loop)] // A loop over lanes reads as what it becomes.

use std::sync::Arc;

use glam::Vec3;

use super::displacement::{Balls, DisplacementPoints, DisplacementShader, surely_within};
use super::octaves::{Cells, Fractal, Octave, fractal, octaves, waves};
use super::params::Params;
use super::texture::TextureImage;
use crate::error::Error;
use crate::math::Vec3s;
use crate::math::simd::{LANES, SimdLevel};

/// Names of the displacement shaders there are.
pub const DISPLACEMENTS: [&str; 7] = ["bumpy", "cells", "fractal", "image", "noise", "vector", "waves"];

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
        "bumpy" => along_normal(common("bumpy", params, 1.0, 1.0)?, image(params, images)?),
        "image" => along_normal(common("image", params, 0.1, 0.0)?, image(params, images)?),
        "cells" => {
            let octaves = octaves(params, 1.0)?;
            along_normal(common("cells", params, 0.1, 0.0)?, Cells(octaves))
        }
        "fractal" => {
            let octaves = octaves(params, 6.0)?;
            along_normal(common("fractal", params, 0.1, 0.0)?, Fractal(octaves))
        }
        "noise" => {
            let octaves = octaves(params, 1.0)?;
            along_normal(common("noise", params, 0.1, 0.0)?, Fractal(octaves))
        }
        "waves" => {
            let octaves = octaves(params, 4.0)?;
            let waves = waves(params, octaves)?;
            along_normal(common("waves", params, 0.1, 0.0)?, waves)
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
    /// Length that no offset exceeds.
    bound: f32,
    bump: bool,
    level: SimdLevel,
}

impl Common {
    /// Computes the offsets of all points, `LANES` at a time. `offsets` gets the number of the first point and the
    /// points, and gives the offsets by axis.
    #[inline(always)]
    fn displace(
        &self,
        points: &DisplacementPoints,
        offset: &mut Vec3s,
        offsets: impl Fn(usize, &Group) -> [[f32; LANES]; 3],
    ) {
        self.level.run(
            #[inline(always)]
            || {
                for first in (0..points.p.len()).step_by(LANES) {
                    let mut moved = offsets(first, &Group::load(points, first));
                    if !self.fit(&moved) {
                        self.bound(&mut moved);
                    }
                    for (axis, moved) in offset.groups_mut().into_iter().zip(&moved) {
                        axis[first..first + LANES].copy_from_slice(moved);
                    }
                }
            },
        );
    }

    /// Square of the longest offset.
    #[inline(always)]
    fn longest(&self) -> f64 {
        let most = f64::from(self.bound) * WITHIN;
        most * most
    }

    /// Whether surely no offset is too long, nor anything but finite: a look in single precision.
    #[inline(always)]
    fn fit(&self, [x, y, z]: &[[f32; LANES]; 3]) -> bool {
        let surely = surely_within(self.longest());
        let mut num_fit = 0;
        for lane in 0..LANES {
            let square = x[lane] * x[lane] + y[lane] * y[lane] + z[lane] * z[lane];
            num_fit += u32::from(square <= surely);
        }
        num_fit == LANES as u32
    }

    /// Shortens offsets that are too long to the bound; where one is not finite, none is left.
    #[cold]
    fn bound(&self, offsets: &mut [[f32; LANES]; 3]) {
        for lane in 0..LANES {
            let offset = Vec3::new(offsets[0][lane], offsets[1][lane], offsets[2][lane]);
            let (wide, longest) = (offset.as_dvec3(), self.longest());
            let square = wide.length_squared();
            let bounded = if !offset.is_finite() {
                Vec3::ZERO
            } else if square <= longest {
                offset
            } else {
                (wide * (longest.sqrt() / square.sqrt())).as_vec3()
            };
            (0..3).for_each(|axis| offsets[axis][lane] = bounded[axis]);
        }
    }
}

fn common(name: &'static str, params: &mut Params, amplitude: f32, bump: f32) -> Result<Common, Error> {
    let amplitude = params.float("amplitude", amplitude)?;
    let bump = params.float("bump", bump)? != 0.0;
    Ok(Common { name, amplitude, bound: amplitude.abs(), bump, level: SimdLevel::best() })
}

/// Points that are displaced at a time: by component and lane.
pub(super) struct Group {
    /// Position.
    pub p: [[f32; LANES]; 3],
    /// Filter width.
    pub width: [f32; LANES],
}

impl Group {
    /// Points `first..first + LANES`; beyond the last point, anywhere, with the last one's width.
    #[inline(always)]
    fn load(points: &DisplacementPoints, first: usize) -> Self {
        Group { p: group(&points.p, first), width: lanes(&points.width, first) }
    }
}

/// `values[first..first + LANES]`; beyond the last value, that one again.
#[inline(always)]
fn lanes(values: &[f32], first: usize) -> [f32; LANES] {
    let values = &values[first..];
    match values.first_chunk() {
        Some(all) => *all,
        None => {
            let mut padded = [values[values.len() - 1]; LANES];
            padded[..values.len()].copy_from_slice(values);
            padded
        }
    }
}

/// Vectors `first..first + LANES`, by axis; beyond the last one, anything.
#[inline(always)]
fn group(vectors: &Vec3s, first: usize) -> [[f32; LANES]; 3] {
    let [x, y, z] = vectors.groups();
    let mut group = [[0.0; LANES]; 3];
    group[0].copy_from_slice(&x[first..first + LANES]);
    group[1].copy_from_slice(&y[first..first + LANES]);
    group[2].copy_from_slice(&z[first..first + LANES]);
    group
}

/// A height, -1 to 1, as a function of one point.
pub(super) trait Height: std::fmt::Debug + Send + Sync {
    /// Whether it reads `s`, `t` or `st_width`.
    const READS_TEXTURE_COORDINATES: bool = false;
    /// Whether [`Self::most_within`] says more than [`Self::most`].
    const KNOWS_REACH: bool = false;

    /// Heights of points `first..first + LANES`, which are those of `group`; beyond the last point, anything.
    fn heights(&self, points: &DisplacementPoints, first: usize, group: &Group) -> [f32; LANES];

    /// Size that no height exceeds.
    fn most(&self) -> f32 {
        1.0
    }

    /// Size that no height within `balls` exceeds.
    fn most_within(&self, _balls: &Balls) -> f32 {
        self.most()
    }
}

/// Moves along the normal by a height.
#[derive(Debug)]
struct AlongNormal<H> {
    common: Common,
    height: H,
}

fn along_normal(common: Common, height: impl Height + 'static) -> Arc<dyn DisplacementShader> {
    let bound = common.bound * height.most();
    Arc::new(AlongNormal { common: Common { bound, ..common }, height })
}

impl<H: Height> DisplacementShader for AlongNormal<H> {
    fn reads_texture_coordinates(&self) -> bool {
        H::READS_TEXTURE_COORDINATES
    }

    fn reads_parameters(&self) -> bool {
        false
    }

    fn name(&self) -> &str {
        self.common.name
    }

    fn amplitude(&self) -> Option<f32> {
        Some(self.common.bound)
    }

    fn knows_reach(&self) -> bool {
        H::KNOWS_REACH
    }

    fn reach(&self, balls: &Balls) -> Option<f32> {
        let most = self.common.level.run(
            #[inline(always)]
            || self.height.most_within(balls),
        );
        Some(self.common.amplitude.abs() * most)
    }

    fn is_bump(&self) -> bool {
        self.common.bump
    }

    fn displace(&self, points: &DisplacementPoints, offset: &mut Vec3s) {
        self.common.displace(
            points,
            offset,
            #[inline(always)]
            |first, group| {
                let height = self.height.heights(points, first, group);
                let mut out = self::group(&points.n, first);
                for axis in &mut out {
                    for lane in 0..LANES {
                        axis[lane] *= self.common.amplitude * height[lane];
                    }
                }
                out
            },
        );
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

    fn reads_parameters(&self) -> bool {
        false
    }

    fn name(&self) -> &str {
        self.common.name
    }

    fn amplitude(&self) -> Option<f32> {
        Some(self.common.bound)
    }

    fn is_bump(&self) -> bool {
        self.common.bump
    }

    fn displace(&self, points: &DisplacementPoints, offset: &mut Vec3s) {
        self.common.displace(
            points,
            offset,
            #[inline(always)]
            |_, group| {
                let mut out = fractal(&self.octaves, [0, 1, 2], group);
                for axis in &mut out {
                    axis.iter_mut().for_each(|value| *value *= self.common.amplitude);
                }
                out
            },
        );
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

    fn most(&self) -> f32 {
        let [least, most] = self.image.range().map(|value| (value - self.zero).abs());
        least.max(most).min(1.0)
    }

    #[inline(always)]
    fn heights(&self, points: &DisplacementPoints, first: usize, _: &Group) -> [f32; LANES] {
        let (places, st_width) =
            ([lanes(&points.s, first), lanes(&points.t, first)], lanes(&points.st_width, first));
        let (mut st, mut width) = ([[0.0; LANES]; 2], [[0.0; LANES]; 2]);
        for axis in 0..2 {
            let scale = self.scale[axis];
            for lane in 0..LANES {
                st[axis][lane] = f64::from(places[axis][lane]) * f64::from(scale);
                width[axis][lane] = st_width[lane] * scale.abs();
            }
        }
        let mut heights = self.image.sample_lanes(&st, &width);
        for height in &mut heights {
            let moved = (*height - self.zero).clamp(-1.0, 1.0);
            *height = if height.is_nan() { 0.0 } else { moved };
        }
        heights
    }
}

#[cfg(test)]
#[path = "displacers_tests.rs"]
mod tests;
