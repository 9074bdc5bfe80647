//! The lens: from the unit square to the unit disk or a polygon in it.
//!
//! In: stratified (p, q) in [0, 1)^2. Out: a lens position (u, v) in the unit disk, equally dense
//! everywhere. Sources: the concentric map is Shirley and Chiu, "A Low Distortion Map Between Disk and
//! Square", 1997. Only + - * / and square roots are used, so the bits are the same on every machine.

/// The opening of the lens.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum LensShape {
    /// The unit disk.
    #[default]
    Round,
    /// A regular polygon inscribed in the unit disk.
    Blades {
        /// Number of sides, at least 3 (fewer count as 3).
        num: u32,
        /// Angle of the first corner in turns (1 is a full circle), counter-clockwise from u.
        rotation: f64,
    },
}

/// A point of the unit disk: radius in [0, 1], angle in turns in [0, 1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Polar {
    /// Distance from the centre.
    pub radius: f64,
    /// Angle in turns.
    pub turn: f64,
}

impl LensShape {
    /// Moves a point of the disk into the shape; equal areas stay equal among themselves.
    ///
    /// A polygon keeps the radius as the fraction of the way to its border, and the place along the arc of a
    /// wedge as the place along its side: both keep areas up to one factor for the whole disk.
    pub fn place(self, point: Polar) -> [f64; 2] {
        match self {
            LensShape::Round => {
                let [cos, sin] = cos_sin_of_turn(point.turn);
                [point.radius * cos, point.radius * sin]
            }
            LensShape::Blades { num, rotation } => {
                let num = num.max(3);
                let wedge = (point.turn * f64::from(num)).floor().min(f64::from(num - 1));
                let along = point.turn * f64::from(num) - wedge;
                let from = cos_sin_of_turn(rotation + wedge / f64::from(num));
                let to = cos_sin_of_turn(rotation + (wedge + 1.0) / f64::from(num));
                [0, 1].map(|axis| point.radius * (from[axis] + along * (to[axis] - from[axis])))
            }
        }
    }
}

/// The concentric map of the square onto the disk; it keeps areas (up to the factor pi).
pub fn concentric(p: f64, q: f64) -> Polar {
    let a = 2.0 * p - 1.0;
    let b = 2.0 * q - 1.0;
    // Each of the four triangles between the centre and a side becomes a quarter of the disk.
    let (radius, turn) = if a.abs() > b.abs() {
        (a, 0.125 * (b / a))
    } else if b != 0.0 {
        (b, 0.25 - 0.125 * (a / b))
    } else {
        (0.0, 0.0)
    };
    let turn = if radius < 0.0 { turn + 0.5 } else { turn };
    let turn = turn - turn.floor();
    Polar { radius: radius.abs(), turn: if turn < 1.0 { turn } else { 0.0 } }
}

/// Rings: p is the fraction of the disk's area inside the radius, q the angle; it keeps areas too.
pub fn ring(p: f64, q: f64) -> Polar {
    Polar { radius: p.sqrt(), turn: q }
}

/// Cosine and sine of an angle in turns, within 1e-15.
pub fn cos_sin_of_turn(turn: f64) -> [f64; 2] {
    // Nearest quarter turn, then the series on at most an eighth of a turn to either side.
    let quarter = (turn * 4.0 + 0.5).floor();
    let x = (turn - quarter * 0.25) * std::f64::consts::TAU;
    let x2 = x * x;
    let mut sin = 0.0;
    let mut cos = 0.0;
    for k in (0..9).rev() {
        let k2 = f64::from(2 * k);
        cos = 1.0 - x2 / ((k2 + 1.0) * (k2 + 2.0)) * cos;
        sin = 1.0 - x2 / ((k2 + 2.0) * (k2 + 3.0)) * sin;
    }
    sin *= x;
    match quarter.rem_euclid(4.0) as u32 {
        0 => [cos, sin],
        1 => [-sin, cos],
        2 => [-cos, -sin],
        _ => [sin, -cos],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_series_is_cosine_and_sine() {
        for i in -4000..4000 {
            let turn = f64::from(i) / 997.0;
            let [cos, sin] = cos_sin_of_turn(turn);
            let angle = turn * std::f64::consts::TAU;
            assert!((cos - angle.cos()).abs() < 4e-15 * (1.0 + angle.abs()), "cos {turn}");
            assert!((sin - angle.sin()).abs() < 4e-15 * (1.0 + angle.abs()), "sin {turn}");
        }
    }

    /// Fractions of a regular grid of points of the square that land in bins of the disk by ring and angle.
    fn bins(map: impl Fn(f64, f64) -> [f64; 2]) -> Vec<f64> {
        let n = 800;
        let mut bins = vec![0.0; 6 * 8];
        for i in 0..n {
            for k in 0..n {
                let [u, v] = map((f64::from(i) + 0.5) / f64::from(n), (f64::from(k) + 0.5) / f64::from(n));
                let ring = (((u * u + v * v) * 6.0) as usize).min(5);
                let angle = (v.atan2(u) / std::f64::consts::TAU).rem_euclid(1.0);
                bins[ring * 8 + ((angle * 8.0) as usize).min(7)] += 1.0 / f64::from(n * n);
            }
        }
        bins
    }

    #[test]
    fn both_maps_of_the_disk_keep_areas() {
        for map in [concentric, ring] {
            for share in bins(|p, q| LensShape::Round.place(map(p, q))) {
                assert!((share * 48.0 - 1.0).abs() < 0.02, "{share}");
            }
        }
    }

    #[test]
    fn blades_fill_their_polygon_evenly_and_nothing_else() {
        for num in [3, 5, 6, 9] {
            let shape = LensShape::Blades { num, rotation: 0.1 };
            let apothem = (std::f64::consts::PI / f64::from(num)).cos();
            let area = 0.5 * f64::from(num) * (std::f64::consts::TAU / f64::from(num)).sin();
            let n = 1000;
            let (mut in_square, side) = (0.0, 0.3);
            for i in 0..n {
                for k in 0..n {
                    let point = concentric((f64::from(i) + 0.5) / 1000.0, (f64::from(k) + 0.5) / 1000.0);
                    let [u, v] = shape.place(point);
                    for corner in 0..num {
                        let normal =
                            std::f64::consts::TAU * (0.1 + (f64::from(corner) + 0.5) / f64::from(num));
                        assert!(u * normal.cos() + v * normal.sin() <= apothem + 1e-12);
                    }
                    // A square off the centre holds its share of the points.
                    if (u - 0.15).abs() < side / 2.0 && (v + 0.1).abs() < side / 2.0 {
                        in_square += 1.0;
                    }
                }
            }
            let share: f64 = in_square / f64::from(n * n) * area / (side * side);
            assert!((share - 1.0).abs() < 0.02, "{num} blades: {share}");
        }
    }
}
