//! Transforms: RenderMan's statements as matrices.
//!
//! RenderMan writes row vectors (p' = p M) and adds a statement in front of the current matrix; glam's matrices
//! are for column vectors (p' = M p). The sixteen numbers of a RenderMan matrix, row after row, are a column
//! matrix's columns in order, and "in front" becomes "behind": current = current * statement.

use glam::{DMat4, DVec3, DVec4};

/// Sine and cosine of an angle in degrees. Multiples of 90 are exact, and the bits are the same on every machine:
/// the reduction is exact and the series use nothing but additions and multiplications.
pub fn sin_cos_degrees(degrees: f64) -> (f64, f64) {
    let turn = degrees % 360.0;
    let quarter = (turn / 90.0).round();
    let x = (turn - quarter * 90.0) * (std::f64::consts::PI / 180.0);
    let square = x * x;
    // Taylor series about 0, |x| <= pi / 4: the first term left out is below 2^-60.
    let (mut sin, mut cos) = (0.0, 0.0);
    for n in (0..=9).rev() {
        let n = f64::from(n);
        sin = 1.0 - sin * square / ((2.0 * n + 2.0) * (2.0 * n + 3.0));
        cos = 1.0 - cos * square / ((2.0 * n + 1.0) * (2.0 * n + 2.0));
    }
    let sin = sin * x;
    match (quarter as i64).rem_euclid(4) {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// Sixteen numbers as RenderMan writes them.
pub fn matrix(numbers: &[f64; 16]) -> DMat4 {
    DMat4::from_cols_array(numbers)
}

/// `Rotate`: counterclockwise about the axis seen in a right-handed space; `None` for an axis of length 0 and for an
/// angle that is not finite.
pub fn rotate([angle, x, y, z]: [f64; 4]) -> Option<DMat4> {
    let (sin, cos) = sin_cos_degrees(angle);
    let axis = DVec3::new(x, y, z);
    let length = axis.length();
    if !(length > 0.0 && length.is_finite() && angle.is_finite()) {
        return None;
    }
    let a = axis / length;
    // Rodrigues' formula; columns are the images of the axes.
    let column = |e: DVec3| (e * cos + a.cross(e) * sin + a * (a.dot(e) * (1.0 - cos))).extend(0.0);
    Some(DMat4::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z), DVec4::W))
}

/// `Skew`: points move along `(dx2, dy2, dz2)` so that the first axis is turned towards it by the angle. `None`
/// where the angle is not below that between the axes, or not above that minus 180 degrees.
pub fn skew(numbers: [f64; 7]) -> Option<DMat4> {
    let [angle, x1, y1, z1, x2, y2, z2] = numbers;
    let from = DVec3::new(x1, y1, z1).try_normalize()?;
    let along = DVec3::new(x2, y2, z2).try_normalize()?;
    let cos_between = from.dot(along);
    let across = (from - along * cos_between).try_normalize()?;
    let sin_between = from.dot(across);
    let (sin, cos) = sin_cos_degrees(angle);
    let sin_left = sin_between * cos - cos_between * sin;
    if angle.abs() >= 180.0 || sin_left < 1e-9 || sin_between < 1e-9 {
        return None;
    }
    let shear = (cos_between * cos + sin_between * sin) / sin_left - cos_between / sin_between;
    let column = |e: DVec3| (e + along * (shear * across.dot(e))).extend(0.0);
    Some(DMat4::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z), DVec4::W))
}

/// `Perspective`: the statement's matrix, which is not affine. `None` for an angle outside (0, 180).
pub fn perspective(fov: f64) -> Option<DMat4> {
    if !(fov > 0.0 && fov < 180.0) {
        return None;
    }
    let (sin, cos) = sin_cos_degrees(fov / 2.0);
    let tan = sin / cos;
    Some(DMat4::from_cols(
        DVec4::X,
        DVec4::Y,
        DVec4::new(0.0, 0.0, tan, tan),
        DVec4::new(0.0, 0.0, -tan, 0.0),
    ))
}

/// Whether a matrix can be inverted in doubles with sense.
pub fn is_regular(m: &DMat4) -> bool {
    let determinant = m.determinant();
    m.is_finite() && determinant.is_finite() && determinant.abs() > 1e-280 && m.inverse().is_finite()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_are_those_of_the_standard_library() {
        for step in -2000..2000 {
            let degrees = f64::from(step) * 0.37;
            let (sin, cos) = sin_cos_degrees(degrees);
            assert!((sin - degrees.to_radians().sin()).abs() < 2e-15, "{degrees}");
            assert!((cos - degrees.to_radians().cos()).abs() < 2e-15, "{degrees}");
        }
        assert_eq!(sin_cos_degrees(-90.0), (-1.0, 0.0));
        assert_eq!(sin_cos_degrees(540.0).1, -1.0);
    }

    #[test]
    fn a_quarter_turn_about_z_takes_x_to_y() {
        let m = rotate([90.0, 0.0, 0.0, 2.0]).expect("an axis");
        assert_eq!(m.transform_point3(DVec3::X), DVec3::Y);
        assert_eq!(rotate([1.0, 0.0, 0.0, 0.0]), None);
        assert_eq!(rotate([f64::INFINITY, 0.0, 0.0, 1.0]), None);
    }

    #[test]
    fn the_last_row_of_a_renderman_matrix_is_the_translation() {
        let mut numbers = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 5., 6., 7., 1.];
        assert_eq!(matrix(&numbers).transform_point3(DVec3::ZERO), DVec3::new(5.0, 6.0, 7.0));
        numbers[1] = 3.0;
        // x has a part that goes to y.
        assert_eq!(matrix(&numbers).transform_vector3(DVec3::X), DVec3::new(1.0, 3.0, 0.0));
    }

    #[test]
    fn skew_turns_the_first_axis_towards_the_second() {
        let m = skew([45.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0]).expect("45 is below 90");
        let turned = m.transform_vector3(DVec3::Y);
        assert!((turned - DVec3::new(1.0, 1.0, 0.0)).length() < 1e-14);
        assert_eq!(m.transform_vector3(DVec3::X), DVec3::X);
        assert_eq!(skew([90.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0]), None);
        assert_eq!(skew([1.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0]), None);
    }
}
