//! Cubic bases: the standard's names, and height fields over them.

use glam::{DMat4, DVec4};
use olema::scene::PatchBasis;

/// A basis by name, and the step it is used with.
pub fn named(name: &str) -> Option<PatchBasis> {
    let scaled = |scale: f32, m: [[f32; 4]; 4]| m.map(|row| row.map(|v| v / scale));
    let (matrix, step) = match name {
        "bezier" => return Some(PatchBasis::BEZIER),
        "b-spline" => {
            let m = [[-1., 3., -3., 1.], [3., -6., 3., 0.], [-3., 0., 3., 0.], [1., 4., 1., 0.]];
            (scaled(6.0, m), 1)
        }
        "catmull-rom" => {
            let m = [[-1., 3., -3., 1.], [2., -5., 4., -1.], [-1., 0., 1., 0.], [0., 2., 0., 0.]];
            (scaled(2.0, m), 1)
        }
        "hermite" => ([[2., 1., -2., 1.], [-3., -2., 3., -1.], [0., 1., 0., 0.], [1., 0., 0., 0.]], 2),
        "power" => ([[1., 0., 0., 0.], [0., 1., 0., 0.], [0., 0., 1., 0.], [0., 0., 0., 1.]], 4),
        _ => return None,
    };
    Some(PatchBasis { matrix, step })
}

/// The control values of the function x(u) = u over a whole sheet of `patches` segments, `None` for bilinear.
///
/// Segment k of a cubic sheet is x(t) = (k + t) / patches, so its four values solve M g = (0, 0, 1, k) / patches.
/// `None` where the matrix cannot be inverted.
pub fn linear_values(basis: Option<&PatchBasis>, points: usize, patches: usize) -> Option<Vec<f64>> {
    let scale = 1.0 / patches.max(1) as f64;
    let Some(basis) = basis else {
        return Some((0..points).map(|i| i as f64 * scale).collect());
    };
    // Rows of the matrix are its transpose's columns.
    let rows = basis.matrix.map(|r| DVec4::from_array(r.map(f64::from)));
    let matrix = DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose();
    if !super::transform::is_regular(&matrix) {
        return None;
    }
    let inverse = matrix.inverse();
    let step = basis.step.max(1) as usize;
    let values = (0..points).map(|i| {
        let segment = (i / step).min(patches.max(1) - 1);
        let point = i - segment * step;
        let values = (inverse * DVec4::new(0.0, 0.0, 1.0, segment as f64)).to_array();
        values.get(point).copied().unwrap_or(0.0) * scale
    });
    Some(values.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_stand_over_evenly_spaced_parameters_in_every_basis() {
        for name in ["bezier", "b-spline", "catmull-rom", "hermite", "power"] {
            let basis = named(name).expect("a basis");
            let step = basis.step as usize;
            let patches = 3;
            let points = 4 + 2 * step;
            let x = linear_values(Some(&basis), points, patches).expect("regular");
            for segment in 0..patches {
                for t in [0.0, 0.25, 1.0f64] {
                    let powers = [t * t * t, t * t, t, 1.0];
                    let value: f64 = (0..4)
                        .flat_map(|power| (0..4).map(move |point| (power, point)))
                        .map(|(power, point)| {
                            powers[power] * f64::from(basis.matrix[power][point]) * x[segment * step + point]
                        })
                        .sum();
                    let expected = (segment as f64 + t) / patches as f64;
                    assert!((value - expected).abs() < 1e-6, "{name} {segment} {t}: {value}");
                }
            }
        }
    }

    #[test]
    fn a_singular_basis_has_no_height_field() {
        let basis = PatchBasis { matrix: [[0.0; 4]; 4], step: 1 };
        assert_eq!(linear_values(Some(&basis), 4, 1), None);
        assert_eq!(linear_values(None, 3, 2), Some(vec![0.0, 0.5, 1.0]));
    }
}
