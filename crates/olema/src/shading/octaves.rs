//! Heights made of octaves: noise, cells and waves of ever smaller size.
//!
//! In: `LANES` points in object space with their filter widths. Out: a height for each, -1 to 1. Detail is left out
//! before it gets finer than the filter can carry: see [`displacers`](super::displacers).

use glam::DVec3;

use super::displacement::{Balls, DisplacementPoints};
use super::displacers::{Group, Height};
use super::params::Params;
use crate::error::Error;
use crate::math::hash::{hash_all, signed_unit, unit};
use crate::math::simd::LANES;
use crate::math::{function, noise_lanes};

/// Most octaves of a shader.
const MAX_OCTAVES: f32 = 16.0;

/// One size of detail.
#[derive(Debug, Clone)]
pub(super) struct Octave {
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
    /// How much of it is left at each filter width: 1 up to a quarter of its wavelength, 0 from a half on. `None` where
    /// it is 0 in every lane.
    #[inline(always)]
    #[allow(clippy::manual_clamp)] // In this order infinity by infinity leaves nothing.
    fn left(&self, width: &[f32; LANES]) -> Option<[f32; LANES]> {
        let mut left = [0.0f32; LANES];
        let mut any = 0;
        for lane in 0..LANES {
            let t = (0.5 * (self.wavelength / width[lane]) - 1.0).max(0.0).min(1.0);
            left[lane] = if width[lane] > 0.0 { t * t * (3.0 - 2.0 * t) } else { 1.0 };
            any |= left[lane].to_bits();
        }
        (any != 0).then_some(left)
    }

    /// The points in the octave's lattice.
    #[inline(always)]
    fn cells(&self, p: &[[f32; LANES]; 3]) -> noise_lanes::Cells {
        let (offset, shift) = (self.offset.to_array(), self.shift.to_array());
        let mut place = [[0.0; LANES]; 3];
        for axis in 0..3 {
            for lane in 0..LANES {
                place[axis][lane] = (f64::from(p[axis][lane]) + offset[axis]) * self.frequency + shift[axis];
            }
        }
        noise_lanes::Cells::of(&place)
    }
}

/// Octaves by the parameters "frequency", "octaves", "gain", "lacunarity", "seed" and "offset".
pub(super) fn octaves(params: &mut Params, count: f32) -> Result<Vec<Octave>, Error> {
    let frequency = params.float("frequency", 1.0)?.abs();
    let count = params.float_within("octaves", count, [1.0, MAX_OCTAVES])?.round() as u32;
    let gain = params.float_within("gain", 0.5, [0.0, 1.0])?;
    let lacunarity = params.float_within("lacunarity", 2.0, [1.0, 16.0])?;
    let seed = params.float("seed", 0.0)? as i32 as u32;
    let offset = params.vector("offset", glam::Vec3::ZERO)?.as_dvec3();
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

/// What gradient noise changes by within a cell's side, at most: it is steepest along an axis, in the middle of a cell at
/// whose corners all slopes point that way (15/4 before it is scaled to 1; found by trying, over all of a cell).
const MOST_CHANGE: f32 = 3.62;

/// More than noise is rounded by.
const ROUNDING: f32 = 1e-3;

/// Gradient noise, in octaves: fractional Brownian motion.
#[derive(Debug)]
pub(super) struct Fractal(pub Vec<Octave>);

impl Height for Fractal {
    const KNOWS_REACH: bool = true;

    #[inline(always)]
    fn heights(&self, _: &DisplacementPoints, _: usize, group: &Group) -> [f32; LANES] {
        let [sum] = fractal(&self.0, [0], group);
        sum
    }

    #[inline(always)]
    fn most_within(&self, balls: &Balls) -> f32 {
        let mut sum = 0.0;
        for octave in &self.0 {
            // How far the noise may be from what it is at the balls' centres.
            let change = MOST_CHANGE * balls.radius * octave.frequency as f32 + ROUNDING;
            let mut most = 0.0f32;
            if change < 1.0 {
                let value = noise_lanes::gradient(&octave.cells(&balls.centers), octave.seed);
                value.iter().for_each(|value| most = most.max(value.abs()));
            }
            sum += octave.weight * (most + change).min(1.0);
        }
        sum.min(1.0)
    }
}

/// Sums of the octaves; `channels` tell independent sums apart.
#[inline(always)]
pub(super) fn fractal<const N: usize>(
    octaves: &[Octave],
    channels: [u32; N],
    group: &Group,
) -> [[f32; LANES]; N] {
    let mut sums = [[0.0; LANES]; N];
    for octave in octaves {
        // What follows is finer still.
        let Some(left) = octave.left(&group.width) else { break };
        let cells = octave.cells(&group.p);
        for n in 0..N {
            let seed = octave.seed.wrapping_add(channels[n].wrapping_mul(0x9e37_79b9));
            let value = noise_lanes::gradient(&cells, seed);
            for lane in 0..LANES {
                sums[n][lane] += octave.weight * left[lane] * value[lane];
            }
        }
    }
    for sum in &mut sums {
        sum.iter_mut().for_each(|value| *value = value.clamp(-1.0, 1.0));
    }
    sums
}

/// Round bumps around random points, one a cell of the lattice; sharp valleys between them.
#[derive(Debug)]
pub(super) struct Cells(pub Vec<Octave>);

/// Mean of a height of cells, which is what is left of one that is too fine.
pub(super) const CELLS_MEAN: f32 = 0.4;

impl Height for Cells {
    #[inline(always)]
    fn heights(&self, _: &DisplacementPoints, _: usize, group: &Group) -> [f32; LANES] {
        let mut sum = [0.0; LANES];
        for octave in &self.0 {
            let Some(left) = octave.left(&group.width) else {
                sum.iter_mut().for_each(|value| *value += octave.weight * CELLS_MEAN);
                continue;
            };
            let nearest = noise_lanes::cellular(&octave.cells(&group.p), octave.seed);
            for lane in 0..LANES {
                // 1 at a feature point, -1 at the distance of a cell's side from all of them.
                let height = 1.0 - 2.0 * nearest[lane];
                sum[lane] += octave.weight * (CELLS_MEAN + (height - CELLS_MEAN) * left[lane]);
            }
        }
        sum.iter_mut().for_each(|value| *value = value.clamp(-1.0, 1.0));
        sum
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
pub(super) struct Waves(Vec<Wave>);

/// A wave an octave, spread over all directions, or about that of the parameter "direction" where it is given.
pub(super) fn waves(params: &mut Params, octaves: Vec<Octave>) -> Result<Waves, Error> {
    let main = params.vector("direction", glam::Vec3::ZERO)?.as_dvec3().normalize_or_zero();
    let wave = |octave: Octave| {
        let random = |channel: u32| f64::from(unit(hash_all([octave.seed, channel])));
        let (z, (sin, cos)) = (f64::from(signed_unit(hash_all([octave.seed, 4]))), turn(random(5)));
        let ring = (1.0 - z * z).sqrt();
        let any = DVec3::new(ring * cos, ring * sin, z);
        let direction = if main == DVec3::ZERO { any } else { (main + any * 0.5).normalize_or(main) };
        Wave { phase: random(6), octave, direction }
    };
    Ok(Waves(octaves.into_iter().map(wave).collect()))
}

/// Sine and cosine of an angle in turns.
fn turn(turns: f64) -> (f64, f64) {
    let angle = turns * std::f64::consts::TAU;
    (function::sin64(angle), function::cos64(angle))
}

impl Wave {
    /// The wave at each point; not a number where its frequency or the place is infinite.
    #[inline(always)]
    fn at(&self, p: &[[f32; LANES]; 3]) -> [f32; LANES] {
        let (offset, direction) = (self.octave.offset.to_array(), self.direction.to_array());
        let mut angle = [0.0; LANES];
        for lane in 0..LANES {
            let x = (f64::from(p[0][lane]) + offset[0]) * direction[0];
            let y = (f64::from(p[1][lane]) + offset[1]) * direction[1];
            let z = (f64::from(p[2][lane]) + offset[2]) * direction[2];
            let turns = (x + y + z) * self.octave.frequency + self.phase;
            // Whole turns go while there are bits for them.
            angle[lane] = ((turns - turns.floor()) * std::f64::consts::TAU) as f32;
        }
        let mut value = [0.0; LANES];
        for lane in 0..LANES {
            value[lane] = function::sin_of_few_turns(angle[lane]);
        }
        value
    }
}

impl Height for Waves {
    #[inline(always)]
    fn heights(&self, _: &DisplacementPoints, _: usize, group: &Group) -> [f32; LANES] {
        let mut sum = [0.0; LANES];
        for wave in &self.0 {
            let Some(left) = wave.octave.left(&group.width) else { break };
            let value = wave.at(&group.p);
            for lane in 0..LANES {
                sum[lane] += wave.octave.weight * left[lane] * value[lane];
            }
        }
        for value in &mut sum {
            *value = if value.is_nan() { 0.0 } else { value.clamp(-1.0, 1.0) };
        }
        sum
    }
}
