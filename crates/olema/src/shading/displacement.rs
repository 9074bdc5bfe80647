//! Displacement: shaders that move a surface's points.
//!
//! In: lists of points in object space, with explicit filter widths. Out: an offset for each. A point on an edge
//! of patches is asked for once, with inputs that are functions of the edge alone, so that both sides get the
//! same offset: an implementation must be a pure function of one point's inputs.

use std::fmt::Debug;

use glam::Mat4;

use crate::math::simd::LANES;
use crate::math::{Vec3s, transform};

/// The points to move, one entry a point in every array; all in object space.
#[derive(Debug, Clone, Default)]
pub struct DisplacementPoints {
    /// Position.
    pub p: Vec3s,
    /// Unit normal, turned by the orientation attribute; zero where the surface has none.
    pub n: Vec3s,
    /// Surface parameters of the primitive, 0 to 1.
    pub u: Vec<f32>,
    /// See `u`.
    pub v: Vec<f32>,
    /// Texture coordinates.
    pub s: Vec<f32>,
    /// See `s`.
    pub t: Vec<f32>,
    /// Filter width: the length of one micropolygon's side at the point, in object space. Detail finer than
    /// twice this cannot be seen.
    pub width: Vec<f32>,
    /// The same length in texture coordinates.
    pub st_width: Vec<f32>,
}

/// What a few operations in single precision round a point by at most, as part of its distance from the origin and that of
/// the spaces that it goes through.
pub const ROUNDING: f32 = 1e-6;

/// Balls that together hold a part of a surface, in object space. Their radius has room for [`ROUNDING`] of their centres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Balls {
    /// Their centres, by axis and ball.
    pub centers: [[f32; LANES]; 3],
    /// Radius of all of them.
    pub radius: f32,
}

impl Balls {
    /// Balls that hold what these hold, in another space: `to_other` lengthens no vector by more than `stretch`. What
    /// becomes of [`ROUNDING`] is within their radius again.
    #[inline(always)]
    pub fn moved(&self, to_other: &Mat4, stretch: f32) -> Self {
        let rounding = ROUNDING * to_other.w_axis.truncate().length();
        Balls {
            centers: transform::placed(to_other, &self.centers),
            radius: self.radius * stretch * 1.00001 + rounding,
        }
    }
}

/// What the square of a length in single precision has to be at most to be below `square` whatever was rounded; below zero
/// where squares may vanish, so that none is.
#[inline(always)]
pub(crate) fn surely_within(square: f64) -> f32 {
    let square = (square * 0.999_99).min(f32::MAX.into()) as f32;
    if square >= f32::MIN_POSITIVE { square } else { -1.0 }
}

/// A displacement shader with its parameters.
pub trait DisplacementShader: Debug + Send + Sync {
    /// The name it was asked for by.
    fn name(&self) -> &str;
    /// Length that no offset exceeds, in object space, if the shader knows it.
    fn amplitude(&self) -> Option<f32>;
    /// Whether [`Self::reach`] says more of a part of space than [`Self::amplitude`] says of all.
    fn knows_reach(&self) -> bool {
        false
    }
    /// Length that no offset of a point within `balls` exceeds, in object space, if the shader knows it: what is asked to
    /// tell early where a surface can be seen.
    fn reach(&self, _balls: &Balls) -> Option<f32> {
        self.amplitude()
    }
    /// Whether only the shading normals follow, and the surface stays where it is (bump mapping).
    fn is_bump(&self) -> bool;
    /// Whether it reads `s`, `t` or `st_width`; their lists may be empty for one that does not.
    fn reads_texture_coordinates(&self) -> bool {
        true
    }
    /// Whether it reads `u` or `v`; their lists may be empty for one that does not.
    fn reads_parameters(&self) -> bool {
        true
    }
    /// Writes the offset of each point, in object space, into `offset`, which has as many entries as `points`.
    fn displace(&self, points: &DisplacementPoints, offset: &mut Vec3s);
}
