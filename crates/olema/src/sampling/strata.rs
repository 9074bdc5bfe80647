//! Strata: the five-dimensional cells of a pixel's samples.
//!
//! In: the grid a x b of sub-pixel cells, a seed. Out: for each of the M = a b strata its fine column in
//! every dimension: sub-pixel x and y, time t, and the lens square (p, q). Sources: n-rooks and
//! multi-jittering are Chiu, Shirley and Wang, "Multi-Jittered Sampling", 1994; pairing time and lens strata
//! for good is Fatahalian 2009, section 3.2.1.
//!
//! Stratum j is sub-pixel cell j, row by row (j = cy a + cx). In every dimension the M strata take each of
//! the M columns of width 1/M once (n-rooks), so a 7 x 1 grid is spread in y as well as in x. The lens square
//! is cut into its own grid of M cells, time into M intervals.
//!
//! Which stratum gets which column starts from a Kronecker lattice over the sub-pixel cells and is then
//! improved by exchanges that lower the mixture discrepancy (Zhou, Fang and Ning 2013) of the M cell centres
//! in all five dimensions together, and the correlations of time, lens and place with each other. Figures
//! (tests `spread_figures` and `time_lens_and_place_are_not_correlated`), M = 16 / 64 / 256, squared
//! discrepancy x 1000: random points 423 / 113 / 26.5, the same cells paired by chance 92 / 17.6 / 4.0, here
//! 64 / 9.0 / 1.7. Correlation coefficients at M = 16: 0.035 root mean square, 0.09 at worst in 20 seeds
//! (without their weight in the exchanges: 0.12 and 0.29, at the same discrepancy).

use crate::math::simd::SimdLevel;

use super::discrepancy::{Discrepancy, Products, products, relations};
use super::hash::{Stream, unit};
use super::lens::{LensShape, Polar, concentric, ring};

/// Sub-pixel x.
pub const X: usize = 0;
/// Sub-pixel y.
pub const Y: usize = 1;
/// Time.
pub const T: usize = 2;
/// First axis of the lens square.
pub const P: usize = 3;
/// Second axis of the lens square.
pub const Q: usize = 4;

/// Positions 0..256 (sub-pixel) or 0..32768 (time) that belong to a cell: `(first, last)`, both inclusive.
///
/// They are those with `floor(position * num_cells / num_positions) == cell`. Where there are more cells
/// than positions, several cells share position `floor(cell * num_positions / num_cells)`.
pub fn positions_of_cell(cell: u32, num_cells: u32, num_positions: u32) -> (u32, u32) {
    let share = cell * num_positions / num_cells;
    if num_cells > num_positions {
        return (share, share);
    }
    ((cell * num_positions).div_ceil(num_cells), ((cell + 1) * num_positions).div_ceil(num_cells) - 1)
}

/// Cells that may hold a sub-pixel position in `first..=last` (each 0..256): `(first, last)`, inclusive;
/// empty (first above last) where more cells than positions leave none.
#[inline(always)]
pub fn cells_of_positions(first: u32, last: u32, num_cells: u32) -> (u32, u32) {
    if num_cells > 256 {
        return (
            (first * num_cells).div_ceil(256),
            (((last + 1) * num_cells).div_ceil(256)).saturating_sub(1),
        );
    }
    (first * num_cells / 256, last * num_cells / 256)
}

/// The strata of a pattern.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Strata {
    /// Sub-pixel cells across and down; their product is M.
    pub grid: [u32; 2],
    /// Lens cells along p and q; their product is M.
    pub lens_grid: [u32; 2],
    /// Whether the lens square is wound into rings (p the area inside, q the angle), for a prime M, or
    /// mapped concentrically.
    pub rings: bool,
    /// Of stratum j the column, 0..M, in each of x, y, t, p, q.
    ///
    /// A cell is a block of columns: sub-pixel cell cx = column / b, cy = column / a; lens cells alike.
    pub columns: Vec<[u16; 5]>,
}

impl Strata {
    /// The strata of an a x b grid of sub-pixel cells, `a b` in 1..=1024.
    pub fn new(grid: [u32; 2], seed: u32) -> Self {
        let m = grid[0] * grid[1];
        debug_assert!((1..=1024).contains(&m), "{m} samples a pixel");
        let lens_grid = factor_nearly_square(m);
        let rings = m > 1 && lens_grid[1] == 1;
        let mut stream = Stream::new(seed);
        let mut strata = Strata { grid, lens_grid, rings, columns: vec![[0; 5]; m as usize] };
        strata.start_as_lattice(&mut stream);
        strata.improve(&mut stream);
        strata
    }

    /// Number of strata, M.
    pub fn num(&self) -> u32 {
        self.grid[0] * self.grid[1]
    }

    /// The time interval of stratum j: `[t / M, (t + 1) / M)`.
    pub fn time_cell(&self, stratum: u32) -> u32 {
        u32::from(self.columns[stratum as usize][T])
    }

    /// The lens cell of stratum j along p and q.
    pub fn lens_cell(&self, stratum: u32) -> [u32; 2] {
        let column = self.columns[stratum as usize];
        [P, Q].map(|dim| u32::from(column[dim]) / self.columns_of_cell(dim))
    }

    /// Columns across a cell along an axis: x, y, t, p or q.
    pub fn columns_of_cell(&self, dim: usize) -> u32 {
        [self.grid[1], self.grid[0], 1, self.lens_grid[1], self.lens_grid[0]][dim]
    }

    /// From the lens square to the disk.
    pub fn to_disk(&self, p: f64, q: f64) -> Polar {
        if self.rings { ring(p, q) } else { concentric(p, q) }
    }

    /// Columns from lattices over the sub-pixel cells: neighbours in the pixel are far apart in the rest.
    fn start_as_lattice(&mut self, stream: &mut Stream) {
        let [a, b] = self.grid;
        let offsets: [f64; 5] = std::array::from_fn(|_| unit(stream.next_word()));
        let lattice = |along_x: f64, along_y: f64, dim: usize| -> Vec<f64> {
            let at = |j: u32| f64::from(j % a) * along_x + f64::from(j / a) * along_y + offsets[dim];
            (0..a * b).map(|j| at(j) - at(j).floor()).collect()
        };
        // Fractions of the golden ratio for one free axis, of its generalisations for more (Roberts' R_d).
        let in_x = ranks(
            &lattice(0.0, 0.618_033_988_749_895, X)[..]
                .iter()
                .step_by(a as usize)
                .copied()
                .collect::<Vec<_>>(),
        );
        let in_y = ranks(&lattice(0.618_033_988_749_895, 0.0, Y)[..a as usize]);
        let in_t = ranks(&lattice(0.754_877_666_246_693, 0.569_840_290_998_053, T));
        let p = lattice(0.819_172_513_396_164, 0.671_043_606_703_789, P);
        let q = lattice(0.856_674_883_854_502, 0.733_891_856_627_126, Q);
        let (in_p, in_q) = lens_columns(&p, &q, self.lens_grid);
        for (j, columns) in self.columns.iter_mut().enumerate() {
            let (cx, cy) = (j as u32 % a, j as u32 / a);
            let x = cx * b + in_x[cy as usize];
            let y = cy * a + in_y[cx as usize];
            *columns = [x, y, in_t[j], in_p[j], in_q[j]].map(|column| column as u16);
        }
    }

    /// Exchanges columns between strata to lower discrepancy and correlations, for a fixed amount of work.
    fn improve(&mut self, stream: &mut Stream) {
        let m = self.num();
        if m < 3 {
            return;
        }
        let num_trials = (WORK / m).min(500 * m);
        let level = SimdLevel::best();
        let mut discrepancy = Discrepancy::new(&self.columns);
        let lens_centres = self.lens_centres();
        let mut centres: Vec<Centres> = (0..m as usize).map(|i| self.centres(i, &lens_centres)).collect();
        let mut places: Vec<Products> = centres.iter().copied().map(products).collect();
        let mut related = relations(level, &places);
        let mut threshold = Threshold::new(HEAT, num_trials);
        for trial in 0..num_trials {
            let (i, k) = (stream.below(m) as usize, stream.below(m) as usize);
            let Some(dims) = self.exchange(i, k, stream.below(6)) else { continue };
            let kept = [i, k].map(|stratum| (centres[stratum], places[stratum]));
            let before = discrepancy.energy(i) + discrepancy.energy(k);
            self.swap(i, k, dims);
            for stratum in [i, k] {
                discrepancy.set(stratum, &self.columns[stratum]);
                let known = Some(centres[stratum]).filter(|_| !dims.iter().any(|dim| [P, Q].contains(dim)));
                centres[stratum] = self.moved(stratum, known, &lens_centres);
                places[stratum] = products(centres[stratum]);
            }
            let now_related = relations(level, &places);
            let change = discrepancy.energy(i) + discrepancy.energy(k) - before
                + RELATED * f64::from(m) * (now_related - related);
            if threshold.accepts(change, trial) {
                related = now_related;
            } else {
                self.swap(i, k, dims);
                for (stratum, kept) in [i, k].into_iter().zip(kept) {
                    discrepancy.set(stratum, &self.columns[stratum]);
                    (centres[stratum], places[stratum]) = kept;
                }
            }
        }
    }

    /// The middle of each cell of the lens, row by row: the mean of 4 x 4 places in it.
    fn lens_centres(&self) -> Vec<[f64; 2]> {
        let [a, b] = self.lens_grid;
        let within =
            |cell: u32, sub: u32, num: u32| (f64::from(cell) + (f64::from(sub) + 0.5) / 4.0) / f64::from(num);
        let of_cell = |cell: u32| {
            let mut sum = [0.0; 2];
            for sub in 0..16 {
                let polar = self.to_disk(within(cell % a, sub % 4, a), within(cell / a, sub / 4, b));
                let [u, v] = LensShape::Round.place(polar);
                sum = [sum[0] + u / 16.0, sum[1] + v / 16.0];
            }
            sum
        };
        (0..a * b).map(of_cell).collect()
    }

    /// Of stratum i the centre of its columns, where the one tuple of K = 1 is, and that of its cell, around which
    /// many are.
    fn centres(&self, i: usize, lens_centres: &[[f64; 2]]) -> Centres {
        self.moved(i, None, lens_centres)
    }

    /// The same where they are known but for their place and time.
    fn moved(&self, i: usize, known: Option<Centres>, lens_centres: &[[f64; 2]]) -> Centres {
        let m = f64::from(self.num());
        let at = |dim: usize, width: u32| {
            let cell = u32::from(self.columns[i][dim]) / width;
            (f64::from(cell) + 0.5) * f64::from(width) / m
        };
        let lens = match known {
            Some(centres) => centres.map(|[.., u, v]| [u, v]),
            None => {
                let lens = LensShape::Round.place(self.to_disk(at(P, 1), at(Q, 1)));
                let [p, q] = self.lens_cell(i as u32);
                let lens_centre = lens_centres[(q * self.lens_grid[0] + p) as usize];
                [lens, lens_centre].map(|[u, v]| [2.0 * u, 2.0 * v])
            }
        };
        let scaled = |[x, y, t]: [f64; 3], [u, v]: [f64; 2]| {
            let uniform = |value: f64| (value - 0.5) * 12.0f64.sqrt();
            [uniform(x), uniform(y), uniform(t), u, v]
        };
        let of_cell = [X, Y, T].map(|dim| at(dim, self.columns_of_cell(dim)));
        [scaled([X, Y, T].map(|dim| at(dim, 1)), lens[0]), scaled(of_cell, lens[1])]
    }

    /// The dimensions that strata i and k may exchange without leaving their cells, for a kind of exchange.
    fn exchange(&self, i: usize, k: usize, kind: u32) -> Option<&'static [usize]> {
        if i == k {
            return None;
        }
        let same = |dim: usize| {
            let cell = |stratum: usize| u32::from(self.columns[stratum][dim]) / self.columns_of_cell(dim);
            cell(i) == cell(k)
        };
        match kind {
            0 if same(X) => Some(&[X]),
            1 if same(Y) => Some(&[Y]),
            2 => Some(&[T]),
            3 => Some(&[P, Q]),
            4 if same(P) => Some(&[P]),
            5 if same(Q) => Some(&[Q]),
            _ => None,
        }
    }

    fn swap(&mut self, i: usize, k: usize, dims: &[usize]) {
        for &dim in dims {
            let kept = self.columns[i][dim];
            self.columns[i][dim] = self.columns[k][dim];
            self.columns[k][dim] = kept;
        }
    }
}

/// Pairs of strata looked at while improving: about 4 ms. Twice the work gains a twentieth of the discrepancy
/// at M = 64 and nothing at 16.
const WORK: u32 = 1 << 18;

/// Weight of squared correlations against the discrepancy, over M.
const RELATED: f64 = 0.5;

/// First threshold, over the size of a typical change.
const HEAT: f64 = 0.3;

/// Threshold accepting (Dueck and Scheuer 1990): a change for the worse is kept too if it is by less than a
/// threshold that falls to 0.
pub(super) struct Threshold {
    heat: f64,
    num_trials: u32,
    typical: f64,
}

impl Threshold {
    /// `heat` is the first threshold over the size of a typical change.
    pub fn new(heat: f64, num_trials: u32) -> Self {
        Threshold { heat, num_trials, typical: 0.0 }
    }

    /// Whether trial `trial` (0..num_trials) keeps a change of what is to become low.
    pub fn accepts(&mut self, change: f64, trial: u32) -> bool {
        let size = change.abs();
        self.typical = if self.typical == 0.0 { size } else { self.typical + 0.02 * (size - self.typical) };
        let left = 1.0 - f64::from(trial) / f64::from(self.num_trials);
        change < self.heat * self.typical * left * left
    }
}

/// Two places (x, y, t, u, v) of a stratum, each scaled to a mean of 0 and a variance of 1 over all of them.
type Centres = [[f64; 5]; 2];

/// a x b = m with a >= b and b as large as divides.
pub fn factor_nearly_square(m: u32) -> [u32; 2] {
    let b = (1..=m).take_while(|b| b * b <= m).filter(|b| m.is_multiple_of(*b)).last().unwrap_or(1);
    [m / b, b]
}

/// The place of each value in ascending order; equal values keep their order.
pub(super) fn ranks(values: &[f64]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..values.len() as u32).collect();
    order.sort_by(|&i, &k| values[i as usize].total_cmp(&values[k as usize]).then(i.cmp(&k)));
    let mut ranks = vec![0; values.len()];
    for (rank, &i) in order.iter().enumerate() {
        ranks[i as usize] = rank as u32;
    }
    ranks
}

/// Columns of p and q such that each cell of the lens grid and each column is taken once.
fn lens_columns(p: &[f64], q: &[f64], [a, b]: [u32; 2]) -> (Vec<u32>, Vec<u32>) {
    let in_p = ranks(p);
    let mut by_p = vec![0usize; p.len()];
    for (j, &rank) in in_p.iter().enumerate() {
        by_p[rank as usize] = j;
    }
    // Each block of b columns of p is spread over the b cells of q in q's order ...
    let mut cell_q = vec![0u32; p.len()];
    for block in by_p.chunks(b as usize) {
        let in_block = ranks(&block.iter().map(|&j| q[j]).collect::<Vec<_>>());
        for (&j, rank) in block.iter().zip(in_block) {
            cell_q[j] = rank;
        }
    }
    // ... and the a strata of each cell of q over its a columns.
    let mut in_q = vec![0u32; p.len()];
    for cell in 0..b {
        let members: Vec<usize> = (0..p.len()).filter(|&j| cell_q[j] == cell).collect();
        let in_cell = ranks(&members.iter().map(|&j| q[j]).collect::<Vec<_>>());
        for (&j, rank) in members.iter().zip(in_cell) {
            in_q[j] = cell * a + rank;
        }
    }
    (in_p, in_q)
}
