//! Weld: gives points that lie together one number.
//!
//! In: points with a tolerance each. Out: numbers, counted from 0 in the order in which new ones appear. Used by
//! `connect` for corners and for the middles of edges.

use std::hash::{BuildHasher, Hasher};

use glam::Vec3;

use crate::math::map::{Map, Mixing};

/// Points by a hash of what they are looked up by. Others that have the same hash come with them.
#[derive(Default)]
struct Chains {
    /// The last entry of each bucket, a power of two of them.
    last: Vec<u32>,
    entries: Vec<Entry>,
}

/// A point under a hash, and the entry before it in the same bucket.
struct Entry {
    hash: u32,
    point: u32,
    before: u32,
}

/// No entry.
const NONE: u32 = u32::MAX;

impl Chains {
    fn bucket(&self, hash: u32) -> usize {
        hash as usize & (self.last.len() - 1)
    }

    fn push(&mut self, hash: u32, point: u32) {
        if self.entries.len() == self.last.len() {
            self.grow();
        }
        let bucket = self.bucket(hash);
        let before = std::mem::replace(&mut self.last[bucket], self.entries.len() as u32);
        self.entries.push(Entry { hash, point, before });
    }

    fn grow(&mut self) {
        let num_buckets = (2 * self.last.len()).max(64);
        self.last.clear();
        self.last.resize(num_buckets, NONE);
        for (entry, ix) in self.entries.iter_mut().zip(0u32..) {
            let bucket = entry.hash as usize & (num_buckets - 1);
            entry.before = std::mem::replace(&mut self.last[bucket], ix);
        }
        self.entries.reserve_exact(num_buckets - self.entries.len());
    }

    /// Points under a hash.
    fn of(&self, hash: u32) -> impl Iterator<Item = u32> + '_ {
        let mut next = if self.last.is_empty() { NONE } else { self.last[self.bucket(hash)] };
        std::iter::from_fn(move || {
            while let Some(entry) = self.entries.get(next as usize) {
                next = entry.before;
                if entry.hash == hash {
                    return Some(entry.point);
                }
            }
            None
        })
    }
}

/// Numbers by a hash, of those with the same place in the table the last.
pub struct Latest {
    /// A power of two of them.
    numbers: Vec<u32>,
    mixing: Mixing,
}

impl Latest {
    /// For about so many numbers.
    pub fn for_about(num: usize) -> Self {
        Latest { numbers: vec![NONE; (2 * num).next_power_of_two()], mixing: Mixing::default() }
    }

    /// Knows no number, ever.
    #[cfg(test)]
    pub fn never() -> Self {
        Latest { numbers: Vec::new(), mixing: Mixing::default() }
    }

    /// The hash of points and words; points that are equal have the same.
    pub fn hash(&self, words: [u32; 3], points: impl Iterator<Item = Vec3>) -> u64 {
        let mut hasher = self.mixing.build_hasher();
        words.iter().for_each(|&word| hasher.write_u32(word));
        for point in points {
            // + 0.0 makes -0 and 0 one.
            (point + Vec3::ZERO).to_array().iter().for_each(|x| hasher.write_u32(x.to_bits()));
        }
        hasher.finish()
    }

    fn place(&self, hash: u64) -> usize {
        (hash >> 32) as usize & self.numbers.len().wrapping_sub(1)
    }

    /// The number under a hash, or under another one.
    pub fn get(&self, hash: u64) -> Option<u32> {
        self.numbers.get(self.place(hash)).copied().filter(|&number| number != NONE)
    }

    /// Puts a number in the place of another.
    pub fn put(&mut self, hash: u64, number: u32) {
        let place = self.place(hash);
        if let Some(known) = self.numbers.get_mut(place) {
            *known = number;
        }
    }
}

/// Gives points that lie together one number.
///
/// Points are kept in one grid of cells per octave of tolerance. A pair is as close as the *smaller* of its two
/// tolerances asks, so a point is entered in the grids of its own octave and all finer ones that occur, and
/// looked up in its own and the finer ones. Cells hold only points that did not weld, so they stay short.
pub struct Welder {
    /// Octaves that occur, ascending.
    octaves: Vec<i32>,
    /// Points by octave and cell, and by their bits. That a cell's come with a few of others does no harm, as all are
    /// compared.
    chains: Chains,
    mixing: Mixing,
    points: Vec<(Vec3, f32)>,
    /// Numbers of points that were welded to others.
    welded: Map<[u32; 3], u32>,
}

impl Welder {
    /// Knows no point yet; `tolerances` are all that will be asked with.
    pub fn new(tolerances: impl Iterator<Item = f32>) -> Self {
        let mut octaves: Vec<i32> = Vec::new();
        for octave in tolerances.filter(|t| *t > 0.0).map(octave) {
            if let Err(place) = octaves.binary_search(&octave) {
                octaves.insert(place, octave);
            }
        }
        Welder {
            octaves,
            chains: Chains::default(),
            mixing: Mixing::default(),
            points: Vec::new(),
            welded: Map::default(),
        }
    }

    /// The number of `p`: that of the lowest point it welds to, or a new one.
    pub fn weld(&mut self, p: Vec3, tolerance: f32) -> u32 {
        // + 0.0 makes -0 and 0 one.
        let p = p + Vec3::ZERO;
        let bits = p.to_array().map(f32::to_bits);
        let hash_of_bits = (self.mixing.hash_one(bits) >> 32) as u32;
        let has_bits = |id: &u32| self.points[*id as usize].0.to_array().map(f32::to_bits) == bits;
        if let Some(id) = self.chains.of(hash_of_bits).find(has_bits) {
            return id;
        }
        if let Some(&id) = self.welded.get(&bits) {
            return id;
        }
        let own = if tolerance > 0.0 { octave(tolerance) } else { i32::MIN };
        let num_octaves = self.octaves.partition_point(|&o| o <= own);
        let octaves = &self.octaves[..num_octaves];
        let id = octaves.iter().filter_map(|&octave| self.lowest_near(p, tolerance, octave)).min();
        if let Some(id) = id {
            self.welded.insert(bits, id);
            return id;
        }
        let id = self.points.len() as u32;
        self.points.push((p, tolerance));
        self.chains.push(hash_of_bits, id);
        for &octave in octaves {
            let cell = Cells { octave }.hold(p).map(floor);
            self.chains.push(hash_of_cell(self.mixing, octave, cell), id);
        }
        id
    }

    /// The lowest of an octave's points in the cells that `p` touches that it welds to.
    fn lowest_near(&self, p: Vec3, tolerance: f32, octave: i32) -> Option<u32> {
        let mut lowest = None;
        let [x, y, z] = Cells { octave }.touched(p);
        for x in x[0]..=x[1] {
            for y in y[0]..=y[1] {
                for z in z[0]..=z[1] {
                    for id in self.chains.of(hash_of_cell(self.mixing, octave, [x, y, z])) {
                        let (q, other) = self.points[id as usize];
                        let is_near = (p - q).abs().max_element() <= tolerance.min(other);
                        if is_near && lowest.is_none_or(|lowest| id < lowest) {
                            lowest = Some(id);
                        }
                    }
                }
            }
        }
        lowest
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

/// The cells of an octave.
struct Cells {
    octave: i32,
}

impl Cells {
    /// Where `p` is, in cells; exact, as their side is a power of two.
    fn hold(&self, p: Vec3) -> [f64; 3] {
        let per_side =
            f64::from_bits(((1023 - (self.octave + CELL_OCTAVES).clamp(-1000, 1000)) as u64) << 52);
        p.to_array().map(|x| f64::from(x) * per_side)
    }

    /// First and last cell on each axis that a box of half side 2^octave around `p` touches, at most two.
    fn touched(&self, p: Vec3) -> [[i64; 2]; 3] {
        const REACH: f64 = 1.0 / (1 << CELL_OCTAVES) as f64;
        self.hold(p).map(|at| {
            let from = floor(at - REACH);
            [from, floor(at + REACH).min(from.saturating_add(1))]
        })
    }
}

fn hash_of_cell(mixing: Mixing, octave: i32, cell: [i64; 3]) -> u32 {
    let mut hasher = mixing.build_hasher();
    hasher.write_u32(octave as u32);
    cell.iter().for_each(|&c| hasher.write_u64(c as u64));
    (hasher.finish() >> 32) as u32
}

/// The floor; not floor(), which is a call where the processor is not known.
fn floor(x: f64) -> i64 {
    let whole = x as i64;
    whole.saturating_sub(i64::from(whole as f64 > x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{hash_all, unit};

    /// Points around the corners of a lattice, with tolerances of several octaves; many come again.
    #[test]
    fn points_weld_to_the_lowest_that_is_close_enough_for_both() {
        let asked: Vec<(Vec3, f32)> = (0..3000u32)
            .map(|ix| {
                let random = |axis: u32| unit(hash_all([ix / 2, axis]));
                let place = |axis: u32| (random(axis) * 6.0).floor() + (random(axis + 3) - 0.5) * 0.006;
                let p = Vec3::new(place(0), place(1), place(2));
                (p, if ix % 7 == 0 { 0.0 } else { 1e-4 * (random(9) * 7.0).exp2() })
            })
            .collect();
        let mut welder = Welder::new(asked.iter().map(|&(_, tolerance)| tolerance));
        let (mut points, mut known) = (Vec::<(Vec3, f32)>::new(), Vec::<(Vec3, u32)>::new());
        for &(p, tolerance) in &asked {
            let exact = known.iter().find(|(q, _)| *q == p).map(|&(_, id)| id);
            let close = |(q, other): &(Vec3, f32)| (p - *q).abs().max_element() <= tolerance.min(*other);
            let near = || points.iter().position(close).map(|id| id as u32);
            let id = exact.or_else(near).unwrap_or(points.len() as u32);
            if id as usize == points.len() {
                points.push((p, tolerance));
            }
            known.push((p, id));
            assert_eq!(welder.weld(p, tolerance), id, "{p} within {tolerance}");
        }
        assert!(points.len() > 250 && points.len() < 1400, "{}", points.len());
    }
}
