//! Displacement shaders that break their word, for tests of what the renderer makes of it.
//!
//! Each is a pure function of a point, as the interface asks, so that a picture with one is still the same for any
//! threads, tiles and grids, and a closed surface is still closed.

use olema::math::Vec3s;
use olema::math::hash::hash_all;
use olema::shading::{DisplacementPoints, DisplacementShader};

/// What a bad shader does at the points that it picks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// Returns not-a-number in one component.
    NotANumber,
    /// Returns infinity, of either sign, in one component.
    Infinite,
    /// Moves the point so many times as far as it said it would.
    Beyond(f32),
    /// Returns finite numbers whose square is not finite.
    Huge,
}

/// Moves points along the normal by half of `amplitude`; some of them wrongly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BadDisplacement {
    /// What goes wrong.
    pub fault: Fault,
    /// Bound that it claims, in object space.
    pub amplitude: f32,
    /// Whether it claims a bound at all.
    pub is_amplitude_known: bool,
    /// About one in so many points goes wrong; 1 is all of them.
    pub one_in: u32,
    /// Whether it says that only normals follow.
    pub is_bump: bool,
}

impl BadDisplacement {
    /// One that goes wrong at every fifth point and claims a bound of `amplitude`.
    pub fn new(fault: Fault, amplitude: f32) -> Self {
        BadDisplacement { fault, amplitude, is_amplitude_known: true, one_in: 5, is_bump: false }
    }

    /// Whether it goes wrong at a point.
    pub fn picks(&self, points: &DisplacementPoints, ix: usize) -> bool {
        let p = points.p.get(ix).to_array().map(f32::to_bits);
        hash_all(p).is_multiple_of(self.one_in.max(1))
    }
}

impl DisplacementShader for BadDisplacement {
    fn name(&self) -> &str {
        match self.fault {
            Fault::NotANumber => "not a number",
            Fault::Infinite => "infinite",
            Fault::Beyond(_) => "beyond its bound",
            Fault::Huge => "huge",
        }
    }

    fn amplitude(&self) -> Option<f32> {
        self.is_amplitude_known.then_some(self.amplitude)
    }

    fn is_bump(&self) -> bool {
        self.is_bump
    }

    fn displace(&self, points: &DisplacementPoints, offset: &mut Vec3s) {
        for ix in 0..points.p.len() {
            let n = points.n.get(ix);
            let mut moved = n * (0.5 * self.amplitude);
            if self.picks(points, ix) {
                match self.fault {
                    Fault::NotANumber => moved.y = f32::NAN,
                    Fault::Infinite => {
                        moved.z = if points.p.x()[ix] < 0.0 { f32::NEG_INFINITY } else { f32::INFINITY }
                    }
                    Fault::Beyond(times) => moved = n * (times * self.amplitude),
                    Fault::Huge => moved = n * 3e38,
                }
            }
            offset.set(ix, moved);
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn each_does_wrong_at_some_points_and_right_at_the_others() {
        for fault in [Fault::NotANumber, Fault::Infinite, Fault::Beyond(3.0), Fault::Huge] {
            let shader = BadDisplacement::new(fault, 0.5);
            let mut points = DisplacementPoints::default();
            for n in 0..200 {
                points.p.push(Vec3::new(n as f32 - 100.0, 0.5, 1.0));
                points.n.push(Vec3::Z);
            }
            let mut offset = Vec3s::splat(Vec3::ZERO, 200);
            shader.displace(&points, &mut offset);
            let is_wrong = |ix: &usize| {
                let length = offset.get(*ix).length();
                length.is_nan() || length > 0.5
            };
            let wrong = (0..200).filter(is_wrong).count();
            assert!((10..90).contains(&wrong), "{fault:?}: {wrong} of 200");
            assert!((0..200).all(|ix| is_wrong(&ix) == shader.picks(&points, ix)), "{fault:?}");
        }
    }
}
