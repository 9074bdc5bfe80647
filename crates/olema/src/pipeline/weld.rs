//! Weld: gives points that lie together one number.
//!
//! In: points with a tolerance each. Out: numbers, counted from 0 in the order in which new ones appear. Used by
//! `connect` for corners and for the middles of edges.

use glam::Vec3;

use crate::math::map::{Map, Mixing};

/// Points by the cell that holds them.
#[derive(Default)]
struct Cells {
    /// The last entry of each cell.
    last: Map<[i64; 3], u32>,
    /// A point, and the entry before it in the same cell.
    entries: Vec<(u32, u32)>,
}

/// No entry.
const NONE: u32 = u32::MAX;

impl Cells {
    fn with_capacity(num: usize) -> Self {
        Cells {
            last: Map::with_capacity_and_hasher(num, Mixing::default()),
            entries: Vec::with_capacity(num),
        }
    }

    fn push(&mut self, cell: [i64; 3], point: u32) {
        let next = self.entries.len() as u32;
        let before = self.last.insert(cell, next).unwrap_or(NONE);
        self.entries.push((point, before));
    }

    /// Points in a cell.
    fn of(&self, cell: [i64; 3]) -> impl Iterator<Item = u32> + '_ {
        let mut next = self.last.get(&cell).copied().unwrap_or(NONE);
        std::iter::from_fn(move || {
            let &(point, before) = self.entries.get(next as usize)?;
            next = before;
            Some(point)
        })
    }
}

/// Gives points that lie together one number.
///
/// Points are kept in one grid of cells per octave of tolerance. A pair is as close as the *smaller* of its two
/// tolerances asks, so a point is entered in the grids of its own octave and all finer ones that occur, and
/// looked up in its own and the finer ones. Cells hold only points that did not weld, so they stay short.
pub struct Welder {
    /// Octaves that occur, ascending, and their grids.
    octaves: Vec<(i32, Cells)>,
    exact: Map<[u32; 3], u32>,
    points: Vec<(Vec3, f32)>,
}

impl Welder {
    /// Knows no point yet; `tolerances` are all that will be asked with.
    pub fn new(tolerances: impl Iterator<Item = f32>) -> Self {
        let mut octaves: Vec<i32> = tolerances.filter(|t| *t > 0.0).map(octave).collect();
        // Sheets have about as many corners, and middles twice as many, as patches.
        let num = octaves.len();
        octaves.sort_unstable();
        octaves.dedup();
        Welder {
            octaves: octaves.into_iter().map(|o| (o, Cells::with_capacity(num))).collect(),
            exact: Map::with_capacity_and_hasher(num, Mixing::default()),
            points: Vec::new(),
        }
    }

    /// The number of `p`: that of the lowest point it welds to, or a new one.
    pub fn weld(&mut self, p: Vec3, tolerance: f32) -> u32 {
        // + 0.0 makes -0 and 0 one.
        let bits = (p + Vec3::ZERO).to_array().map(f32::to_bits);
        if let Some(&id) = self.exact.get(&bits) {
            return id;
        }
        let own = if tolerance > 0.0 { octave(tolerance) } else { i32::MIN };
        let near = self
            .octaves
            .iter()
            .filter(|(o, _)| *o <= own)
            .flat_map(|(o, cells)| touched_cells(p, *o).flat_map(|cell| cells.of(cell)));
        let id = near
            .filter(|&id| {
                let (q, other) = self.points[id as usize];
                (p - q).abs().max_element() <= tolerance.min(other)
            })
            .min();
        let id = id.unwrap_or_else(|| {
            let id = self.points.len() as u32;
            self.points.push((p, tolerance));
            for (o, cells) in self.octaves.iter_mut().filter(|(o, _)| *o <= own) {
                cells.push(cell(p, *o), id);
            }
            id
        });
        self.exact.insert(bits, id);
        id
    }
}

/// Gives points that lie together at all motion keys one number.
pub struct KeyedWelder {
    keys: Vec<Welder>,
    tolerances: Vec<f32>,
    /// Numbers of pairs: what was found so far, and the next key's number.
    pairs: Map<(u32, u32), u32>,
}

/// Marks numbers of pairs, and sets of key times beside numbers of points.
const PAIR: u32 = 1 << 31;

impl KeyedWelder {
    /// Knows no point yet; `tolerances` are all that will be asked with.
    pub fn new(tolerances: impl Iterator<Item = f32>) -> Self {
        KeyedWelder { keys: Vec::new(), tolerances: tolerances.collect(), pairs: Map::default() }
    }

    /// The number of a point that is at `places` at the keys of set `motion` (0: a single key).
    pub fn weld(&mut self, motion: u32, places: impl Iterator<Item = Vec3>, tolerance: f32) -> u32 {
        let mut number = motion | PAIR;
        for (key, place) in places.enumerate() {
            if key == self.keys.len() {
                self.keys.push(Welder::new(self.tolerances.iter().copied()));
            }
            let at_key = self.keys[key].weld(place, tolerance);
            if motion == 0 {
                return at_key;
            }
            let next = PAIR | (1 << 30) | self.pairs.len() as u32;
            number = *self.pairs.entry((number, at_key)).or_insert(next);
        }
        number
    }
}

/// Smallest o with tolerance <= 2^o.
fn octave(tolerance: f32) -> i32 {
    let bits = tolerance.to_bits();
    (bits >> 23) as i32 - 127 + i32::from(bits & 0x7f_ffff != 0)
}

/// Cells are this many octaves wider than the tolerance, so that most points touch one cell only.
const CELL_OCTAVES: i32 = 4;

/// Cells of octave `octave` that a box of half side 2^octave around `p` touches (at most 8).
fn touched_cells(p: Vec3, octave: i32) -> impl Iterator<Item = [i64; 3]> {
    let power = |o: i32| f64::from_bits(((1023 + o.clamp(-1000, 1000)) as u64) << 52);
    let (reach, side) = (power(octave), power(octave + CELL_OCTAVES));
    let range = p.to_array().map(|x| {
        let x = f64::from(x);
        (((x - reach) / side).floor() as i64, ((x + reach) / side).floor() as i64)
    });
    let [x, y, z] = range.map(|(from, to)| from..=to.min(from.saturating_add(1)));
    x.flat_map(move |x| {
        let z = z.clone();
        y.clone().flat_map(move |y| z.clone().map(move |z| [x, y, z]))
    })
}

/// The cell that holds `p`.
fn cell(p: Vec3, octave: i32) -> [i64; 3] {
    let side = f64::from_bits(((1023 + (octave + CELL_OCTAVES).clamp(-1000, 1000)) as u64) << 52);
    p.to_array().map(|x| (f64::from(x) / side).floor() as i64)
}
