//! Displacement: shaders that move a surface's points.
//!
//! In: lists of points in object space, with explicit filter widths. Out: an offset for each. A point on an edge
//! of patches is asked for once, with inputs that are functions of the edge alone, so that both sides get the
//! same offset: an implementation must be a pure function of one point's inputs.

use std::fmt::Debug;

use glam::{DMat4, DVec3};

use crate::math::Vec3s;
use crate::math::simd::LANES;

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

/// Balls that together hold a part of a surface, in object space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Balls {
    /// Their centres, by axis and ball.
    pub centers: [[f32; LANES]; 3],
    /// Radius of all of them.
    pub radius: f32,
}

impl Balls {
    /// Balls that hold what these hold, in another space: `to_other` lengthens no vector by more than `stretch`.
    #[inline(always)]
    pub fn moved(&self, to_other: &DMat4, stretch: f32) -> Self {
        let mut moved = Balls { radius: self.radius * stretch * 1.00001, ..*self };
        for ball in 0..LANES {
            let [x, y, z] = [self.centers[0][ball], self.centers[1][ball], self.centers[2][ball]];
            let center = DVec3::new(x.into(), y.into(), z.into());
            let center = to_other.transform_point3(center).as_vec3();
            (moved.centers[0][ball], moved.centers[1][ball], moved.centers[2][ball]) =
                (center.x, center.y, center.z);
        }
        moved
    }
}

/// A displacement shader with its parameters.
pub trait DisplacementShader: Debug + Send + Sync {
    /// The name it was asked for by.
    fn name(&self) -> &str;
    /// Length that no offset exceeds, in object space, if the shader knows it.
    fn amplitude(&self) -> Option<f32>;
    /// Length that no offset of a point within `balls` exceeds, in object space, if the shader knows it: what is asked to
    /// tell early where a surface can be seen. The amplitude, unless a shader knows better.
    fn reach(&self, _balls: &Balls) -> Option<f32> {
        self.amplitude()
    }
    /// Whether only the shading normals follow, and the surface stays where it is (bump mapping).
    fn is_bump(&self) -> bool;
    /// Whether it reads `s`, `t` or `st_width`; they are left at 0 for one that does not.
    fn reads_texture_coordinates(&self) -> bool {
        true
    }
    /// Whether it reads `u` or `v`; they are left at 0 for one that does not.
    fn reads_parameters(&self) -> bool {
        true
    }
    /// Writes the offset of each point, in object space, into `offset`, which has as many entries as `points`.
    fn displace(&self, points: &DisplacementPoints, offset: &mut Vec3s);
}
