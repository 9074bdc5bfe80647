//! Discrepancy: how evenly the strata of a pixel lie in all five dimensions together, in loops over strata.
//!
//! In: columns of strata, and which of them changed. Out: what a stratum adds to the mixture discrepancy, and the sum of
//! squared correlations. Twin: the formula pair by pair, in the tests. Source: Zhou, Fang and Ning 2013.

use crate::math::simd::SimdLevel;

/// The mixture discrepancy of the centres of columns.
pub(super) struct Discrepancy {
    level: SimdLevel,
    /// Of all strata the column, dimension by dimension,
    columns: [Vec<f64>; 5],
    /// and 15/16 - 1/4 |a - 1/2| there: a pair's factor is the sum of both, less `apart`.
    off: [Vec<f64>; 5],
    /// Factors of a stratum and each of the others.
    pairs: Vec<f64>,
}

/// At a distance of d columns: 3/4 |a - b| - 1/2 |a - b|^2.
#[inline(always)]
fn apart(d: f64, width: f64) -> f64 {
    let d = d * width;
    0.75 * d - 0.5 * d * d
}

impl Discrepancy {
    /// That of strata with these columns.
    pub fn new(columns: &[[u16; 5]]) -> Self {
        let of = || std::array::from_fn(|_| vec![0.0; columns.len()]);
        let pairs = vec![0.0; columns.len()];
        let mut all = Discrepancy { level: SimdLevel::best(), columns: of(), off: of(), pairs };
        columns.iter().enumerate().for_each(|(stratum, columns)| all.set(stratum, columns));
        all
    }

    fn width(&self) -> f64 {
        1.0 / self.pairs.len() as f64
    }

    fn off_middle(&self, column: f64) -> f64 {
        ((column + 0.5) * self.width() - 0.5).abs()
    }

    /// Puts a stratum elsewhere.
    pub fn set(&mut self, stratum: usize, columns: &[u16; 5]) {
        for (dim, &column) in columns.iter().enumerate() {
            let column = f64::from(column);
            self.off[dim][stratum] = 0.9375 - 0.25 * self.off_middle(column);
            self.columns[dim][stratum] = column;
        }
    }

    /// What a stratum adds to M^2 times the squared discrepancy, but for constants.
    pub fn energy(&mut self, stratum: usize) -> f64 {
        let width = self.width();
        let Discrepancy { level, columns, off, pairs } = self;
        pairs.fill(1.0);
        level.run(
            #[inline(always)]
            || {
                for (columns, off) in columns.iter().zip(off) {
                    let (column, own) = (columns[stratum], off[stratum]);
                    for ((pair, other), off) in pairs.iter_mut().zip(columns).zip(off) {
                        *pair *= own + *off - apart((column - *other).abs(), width);
                    }
                }
            },
        );
        let all: f64 = self.pairs.iter().sum();
        // A point's own factor: 5/3 - 1/4 |a - 1/2| - 1/4 |a - 1/2|^2.
        let own = |columns: &Vec<f64>| {
            let d = self.off_middle(columns[stratum]);
            5.0 / 3.0 - 0.25 * d - 0.25 * d * d
        };
        let own: f64 = self.columns.iter().map(own).product();
        2.0 * all - self.pairs[stratum] - 2.0 * self.pairs.len() as f64 * own
    }
}

/// Products of time, lens and place in the pixel of a stratum's centre and of that of its cell; their means are
/// correlations.
pub(super) type Products = [f64; 16];

/// The products of two places (x, y, t, u, v), each scaled to a mean of 0 and a variance of 1 over all strata.
pub(super) fn products(centres: [[f64; 5]; 2]) -> Products {
    let mut products = [0.0; 16];
    for (products, [x, y, t, u, v]) in products.chunks_exact_mut(8).zip(centres) {
        products.copy_from_slice(&[t * x, t * y, t * u, t * v, u * x, u * y, v * x, v * y]);
    }
    products
}

/// Sum of the squared correlations.
pub(super) fn relations(level: SimdLevel, products: &[Products]) -> f64 {
    let mut sums = [0.0; 16];
    level.run(
        #[inline(always)]
        || {
            for products in products {
                sums.iter_mut().zip(products).for_each(
                    #[inline(always)]
                    |(sum, product)| *sum += product,
                );
            }
        },
    );
    sums.iter().map(|sum| sum * sum).sum::<f64>() / (products.len() * products.len()) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::strata::Strata;

    /// The formula, pair by pair.
    fn energy(columns: &[[u16; 5]], i: usize) -> f64 {
        let width = 1.0 / columns.len() as f64;
        let from_middle = |column: u16| ((f64::from(column) + 0.5) * width - 0.5).abs();
        let off = |column: u16| 0.9375 - 0.25 * from_middle(column);
        let at = |a: u16, b: u16| off(a) + off(b) - apart(f64::from(a.abs_diff(b)), width);
        let pair = |a: &[u16; 5], b: &[u16; 5]| {
            at(a[0], b[0]) * at(a[1], b[1]) * at(a[2], b[2]) * at(a[3], b[3]) * at(a[4], b[4])
        };
        let point = &columns[i];
        let pairs: f64 = columns.iter().map(|other| pair(point, other)).sum();
        let own = |d: f64| 5.0 / 3.0 - 0.25 * d - 0.25 * d * d;
        let own: f64 = point.iter().map(|&column| own(from_middle(column))).product();
        2.0 * pairs - pair(point, point) - 2.0 * columns.len() as f64 * own
    }

    #[test]
    fn loops_have_the_bits_of_the_formula_at_every_level() {
        for grid in [[1, 3], [4, 4], [7, 1], [5, 5], [8, 8]] {
            let mut columns = Strata::new(grid, 3).columns;
            for level in SimdLevel::all() {
                let mut discrepancy = Discrepancy { level, ..Discrepancy::new(&columns) };
                let kept = columns[0][2];
                columns[0][2] = columns[1][2];
                columns[1][2] = kept;
                (0..2).for_each(|stratum| discrepancy.set(stratum, &columns[stratum]));
                for stratum in 0..columns.len() {
                    let (found, expected) = (discrepancy.energy(stratum), energy(&columns, stratum));
                    assert_eq!(found.to_bits(), expected.to_bits(), "{grid:?} {}", level.name());
                }
            }
        }
    }
}
