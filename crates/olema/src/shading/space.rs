//! Displacement shaders of another space than the object's.
//!
//! In: a shader whose points and lengths are of its own space, and the matrix from object space to it. Out: a shader
//! of object space. Widths and bounds are carried by the matrix's largest stretch, so they are never too small.

use std::sync::Arc;

use glam::{DMat3, DMat4, Mat4};

use super::displacement::{Balls, DisplacementPoints, DisplacementShader};
use crate::math::simd::SimdLevel;
use crate::math::{Vec3s, transform};

/// `shader`, given points of object space: offsets come back in object space. `object_to_shader` is affine and can be
/// inverted; the identity costs nothing.
pub fn displacement_in_space(
    shader: Arc<dyn DisplacementShader>,
    object_to_shader: &DMat4,
) -> Arc<dyn DisplacementShader> {
    if *object_to_shader == DMat4::IDENTITY {
        return shader;
    }
    let to_shader = DMat3::from_mat4(*object_to_shader);
    let to_object = to_shader.inverse();
    Arc::new(InSpace {
        shader,
        place: object_to_shader.as_mat4(),
        to_object: DMat4::from_mat3(to_object).as_mat4(),
        normal_to_shader: DMat4::from_mat3(to_object.transpose()).as_mat4(),
        level: SimdLevel::best(),
        stretch: largest_stretch(&to_shader) as f32,
        // Rounding of the offset's components must not lift it above the bound.
        unstretch: (largest_stretch(&to_object) * (1.0 + 1e-6)) as f32,
    })
}

/// The most that a matrix lengthens a vector: its largest singular value, or at most 1e-7 of it more, never less but
/// for rounding.
pub fn largest_stretch(m: &DMat3) -> f64 {
    // The largest eigenvalue of B = M^T M is at most |B^k|^(1/k) in any norm, and at least that / 3^(1/2k) in
    // Frobenius's. B is squared again and again; the lengths that were divided out are roots of the answer.
    let mut b = m.transpose() * *m;
    let mut lengths = [0.0; 24];
    for length in &mut lengths {
        *length = (b.x_axis.length_squared() + b.y_axis.length_squared() + b.z_axis.length_squared()).sqrt();
        if !(*length > 0.0 && length.is_finite()) {
            return if *length == 0.0 { 0.0 } else { f64::INFINITY };
        }
        b *= 1.0 / *length;
        b = b * b;
    }
    let eigenvalue = lengths.iter().rev().fold(1.0f64, |product, length| product.sqrt() * length);
    eigenvalue.sqrt()
}

/// A shader and the ways to its space and back.
#[derive(Debug)]
struct InSpace {
    shader: Arc<dyn DisplacementShader>,
    place: Mat4,
    to_object: Mat4,
    normal_to_shader: Mat4,
    level: SimdLevel,
    stretch: f32,
    unstretch: f32,
}

impl DisplacementShader for InSpace {
    fn reads_texture_coordinates(&self) -> bool {
        self.shader.reads_texture_coordinates()
    }

    fn reads_parameters(&self) -> bool {
        self.shader.reads_parameters()
    }

    fn name(&self) -> &str {
        self.shader.name()
    }

    fn amplitude(&self) -> Option<f32> {
        self.shader.amplitude().map(|length| length * self.unstretch)
    }

    fn knows_reach(&self) -> bool {
        self.shader.knows_reach()
    }

    fn reach(&self, balls: &Balls) -> Option<f32> {
        self.shader.reach(&balls.moved(&self.place, self.stretch)).map(|length| length * self.unstretch)
    }

    fn is_bump(&self) -> bool {
        self.shader.is_bump()
    }

    fn displace(&self, points: &DisplacementPoints, offset: &mut Vec3s) {
        let mut own = points.clone();
        transform::points(self.level, &self.place, &points.p, &mut own.p);
        transform::unit_vectors(self.level, &self.normal_to_shader, &points.n, &mut own.n);
        own.width.iter_mut().for_each(|width| *width *= self.stretch);
        self.shader.displace(&own, offset);
        let there = offset.clone();
        transform::vectors(self.level, &self.to_object, &there, offset);
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};
    use proptest::prelude::*;

    use super::*;
    use crate::shading::{ShaderParam, displacement};

    fn any_matrix() -> impl Strategy<Value = DMat3> {
        prop::array::uniform9(-3.0..3.0).prop_map(|m| DMat3::from_cols_array(&m))
    }

    proptest! {
        #[test]
        fn no_vector_is_stretched_more(m in any_matrix(), v in [-1.0..1.0, -1.0..1.0, -1.0..1.0]) {
            let v = DVec3::from(v);
            prop_assert!((m * v).length() <= largest_stretch(&m) * v.length() * (1.0 + 1e-12));
        }

        #[test]
        fn the_bound_is_carried_along(m in any_matrix(), p in prop::array::uniform3(-9.0f32..9.0)) {
            prop_assume!(m.determinant().abs() > 0.1);
            let made = displacement("vector", &[ShaderParam::float("amplitude", 2.0)]).unwrap();
            let shader = displacement_in_space(made.shader, &DMat4::from_mat3(m));
            let (points, mut offset) = (one_point(p.into()), Vec3s::splat(Vec3::ZERO, 1));
            shader.displace(&points, &mut offset);
            prop_assert!(offset.get(0).length() <= shader.amplitude().unwrap());
        }
    }

    fn one_point(p: Vec3) -> DisplacementPoints {
        DisplacementPoints {
            p: Vec3s::splat(p, 1),
            n: Vec3s::splat(Vec3::Z, 1),
            width: vec![0.01],
            ..DisplacementPoints::default()
        }
    }

    #[test]
    fn rotations_and_uniform_scales_are_measured_well() {
        let turned = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7) * 5.0;
        assert!((largest_stretch(&turned) / 5.0 - 1.0).abs() < 1e-7);
        assert!((largest_stretch(&DMat3::from_diagonal(DVec3::new(0.5, -7.0, 2.0))) - 7.0).abs() < 1e-9);
        assert_eq!(largest_stretch(&DMat3::ZERO), 0.0);
    }

    #[test]
    fn a_scaled_object_is_displaced_as_its_shaders_space_says() {
        // The object is ten times as large in the shader's space: a tenth of the offset there.
        let make = || displacement("noise", &[]).unwrap().shader;
        let scaled = displacement_in_space(make(), &DMat4::from_scale(DVec3::splat(10.0)));
        let (mut a, mut b) = (Vec3s::splat(Vec3::ZERO, 1), Vec3s::splat(Vec3::ZERO, 1));
        make().displace(&one_point(Vec3::new(3.0, 1.0, 0.5)), &mut a);
        scaled.displace(&one_point(Vec3::new(0.3, 0.1, 0.05)), &mut b);
        assert!((a.get(0) - 10.0 * b.get(0)).length() < 1e-5, "{a:?} {b:?}");
        assert!(a.get(0).length() > 1e-3);
        assert!((scaled.amplitude().unwrap() - 0.01).abs() < 1e-5);
        assert_eq!(scaled.name(), "noise");
    }
}
