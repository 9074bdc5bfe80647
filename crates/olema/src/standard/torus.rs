//! A bumpy torus that turns and drifts: the surface on which renderers are compared.
//!
//! In: angles and a time. Out: points, seen as from (0, 0, 4) towards -z, in a window of 0.4 by 0.3 at distance 1.

/// The surface at angles `u` (around the axis) and `v` (around the tube), at time `t` in [0, 1].
pub fn point(u: f64, v: f64, t: f64) -> [f32; 3] {
    let tube = 0.45 * (1.0 + 0.06 * (24.0 * u).sin() * (10.0 * v).sin());
    let around = u + 0.03 * t;
    let ring = 1.0 + tube * v.cos();
    let (x, y, z) = (ring * around.cos(), ring * around.sin(), tube * v.sin());
    let (sin, cos) = 50.0f64.to_radians().sin_cos();
    [x + 0.03 * t, cos * y - sin * z - 0.2 + 0.02 * t, sin * y + cos * z].map(|c| c as f32)
}
