//! Between two matrices: the path that a single motion takes.
//!
//! In: two affine matrices A and B. Out: A (A^-1 B)^t, t in [0, 1]. Where B differs from A by one translation,
//! rotation or scaling, about whatever point and in whatever coordinates, this is that motion done in part: a
//! turning wheel keeps its shape. Logarithm and exponential by inverse scaling and squaring (Kenney and Laub 1989),
//! square roots by the iteration of Denman and Beavers 1976; only + - * / are used, so the bits are the same on
//! every machine.

use glam::DMat4;

/// A (A^-1 B)^t.
///
/// Where there is no such path (B mirrors A, is half a turn from it or is not affine), the matrices' numbers are
/// interpolated.
pub fn between(a: &DMat4, b: &DMat4, t: f64) -> DMat4 {
    if t == 0.0 || a == b {
        return *a;
    }
    if t == 1.0 {
        return *b;
    }
    match power(&(a.inverse() * *b), t) {
        Some(part) => *a * part,
        None => *a * (1.0 - t) + *b * t,
    }
}

/// Largest |entry| of M - I at which the series are used.
const CLOSE: f64 = 0.06;

/// Square roots taken at most; each halves an angle.
const MOST_ROOTS: u32 = 24;

/// M^t of an affine matrix, if it is well defined.
fn power(m: &DMat4, t: f64) -> Option<DMat4> {
    let is_affine = m.row(3) == glam::DVec4::W;
    if !(is_affine && m.is_finite()) {
        return None;
    }
    if m.x_axis == glam::DVec4::X && m.y_axis == glam::DVec4::Y && m.z_axis == glam::DVec4::Z {
        // A translation, to the last bit.
        return Some(DMat4::from_translation(m.w_axis.truncate() * t));
    }
    // The linear part decides how many roots are needed; a translation adds nothing to the series but itself.
    let mut root = *m;
    let mut num_roots = 0;
    while distance_to_identity(&root) > CLOSE {
        if num_roots == MOST_ROOTS {
            return None;
        }
        root = square_root(&root)?;
        num_roots += 1;
    }
    let mut result = exponential(&(logarithm(&root) * t));
    for _ in 0..num_roots {
        result = result * result;
    }
    result.is_finite().then_some(result)
}

fn distance_to_identity(m: &DMat4) -> f64 {
    let linear = glam::DMat3::from_mat4(*m) - glam::DMat3::IDENTITY;
    linear.to_cols_array().into_iter().fold(0.0, |most, entry| most.max(entry.abs()))
}

/// The principal square root, if the iteration finds it.
fn square_root(m: &DMat4) -> Option<DMat4> {
    let (mut y, mut z) = (*m, DMat4::IDENTITY);
    for _ in 0..40 {
        let next = (y + z.inverse()) * 0.5;
        z = (z + y.inverse()) * 0.5;
        let moved = largest(&(next - y));
        y = next;
        if !y.is_finite() || !z.is_finite() {
            return None;
        }
        if moved <= 1e-15 * largest(&y) {
            break;
        }
    }
    (largest(&(y * y - *m)) <= 1e-9 * largest(m)).then_some(y)
}

fn largest(m: &DMat4) -> f64 {
    m.to_cols_array().into_iter().fold(0.0, |most, entry| most.max(entry.abs()))
}

/// log M = 2 atanh((M - I) (M + I)^-1), for M close to the identity.
fn logarithm(m: &DMat4) -> DMat4 {
    let z = (*m - DMat4::IDENTITY) * (*m + DMat4::IDENTITY).inverse();
    let square = z * z;
    let (mut term, mut sum) = (z, z);
    for n in 1..10 {
        term *= square;
        sum += term * (1.0 / f64::from(2 * n + 1));
    }
    sum * 2.0
}

/// exp M, for a small M.
fn exponential(m: &DMat4) -> DMat4 {
    let mut sum = DMat4::IDENTITY;
    for n in (1..=14).rev() {
        sum = DMat4::IDENTITY + *m * sum * (1.0 / f64::from(n));
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn close(a: &DMat4, b: &DMat4) -> bool {
        largest(&(*a - *b)) < 1e-12 * (1.0 + largest(b))
    }

    #[test]
    fn a_wheel_turns_about_its_hub_wherever_that_is() {
        let hub = DMat4::from_translation(DVec3::new(50.0, -3.0, 7.0)) * DMat4::from_rotation_x(0.3);
        let inner = DMat4::from_scale(DVec3::new(1.0, 2.0, -0.5)) * DMat4::from_translation(DVec3::X);
        for angle in [0.001, 0.2, 1.5, 3.0, -3.1] {
            let at = |t: f64| hub * DMat4::from_rotation_z(angle * t) * inner;
            for t in [0.1, 0.25, 0.5, 0.9] {
                assert!(close(&between(&at(0.0), &at(1.0), t), &at(t)), "angle {angle}, t {t}");
            }
        }
    }

    #[test]
    fn translations_are_straight_and_scales_geometric() {
        let from = DMat4::from_rotation_y(1.0);
        let to = DMat4::from_rotation_y(1.0) * DMat4::from_translation(DVec3::new(3.0, 1e6, -2.0));
        let half = DMat4::from_rotation_y(1.0) * DMat4::from_translation(DVec3::new(1.5, 5e5, -1.0));
        assert!(close(&between(&from, &to, 0.5), &half));
        let grown = between(&DMat4::IDENTITY, &DMat4::from_scale(DVec3::splat(4.0)), 0.5);
        assert!(close(&grown, &DMat4::from_scale(DVec3::splat(2.0))));
    }

    #[test]
    fn what_has_no_path_is_interpolated_number_by_number() {
        let mirror = DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let middle = between(&DMat4::IDENTITY, &mirror, 0.25);
        assert!(close(&middle, &DMat4::from_scale(DVec3::new(0.5, 1.0, 1.0))));
        let half_turn = DMat4::from_rotation_z(std::f64::consts::PI);
        assert!(between(&DMat4::IDENTITY, &half_turn, 0.5).is_finite());
    }

    #[test]
    fn ends_are_exact() {
        let (a, b) = (DMat4::from_rotation_x(0.7), DMat4::from_rotation_z(0.2));
        assert_eq!(between(&a, &b, 0.0), a);
        assert_eq!(between(&a, &b, 1.0), b);
        assert_eq!(between(&a, &a, 0.3), a);
    }
}
