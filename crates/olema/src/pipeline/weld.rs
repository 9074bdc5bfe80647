//! Weld: gives points that lie together one number.
//!
//! In: points with a tolerance each. Out: numbers, counted from 0 in the order in which new ones appear. Used by
//! `connect` for corners and for the middles of edges.

use std::hash::BuildHasher;

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
        let Welder { octaves, chains, mixing, points, .. } = &*self;
        let hash = |octave: i32, cell: [i64; 3]| (mixing.hash_one((octave, cell)) >> 32) as u32;
        let hash_of_bits = (mixing.hash_one(bits) >> 32) as u32;
        let has_bits = |id: &u32| points[*id as usize].0.to_array().map(f32::to_bits) == bits;
        if let Some(id) = chains.of(hash_of_bits).find(has_bits) {
            return id;
        }
        if let Some(&id) = self.welded.get(&bits) {
            return id;
        }
        let own = if tolerance > 0.0 { octave(tolerance) } else { i32::MIN };
        let num_octaves = octaves.partition_point(|&o| o <= own);
        let near = octaves[..num_octaves]
            .iter()
            .flat_map(|&o| touched_cells(p, o).flat_map(move |cell| chains.of(hash(o, cell))));
        let id = near
            .filter(|&id| {
                let (q, other) = points[id as usize];
                (p - q).abs().max_element() <= tolerance.min(other)
            })
            .min();
        if let Some(id) = id {
            self.welded.insert(bits, id);
            return id;
        }
        let id = self.points.len() as u32;
        self.points.push((p, tolerance));
        self.chains.push(hash_of_bits, id);
        for &o in &self.octaves[..num_octaves] {
            let hash = (self.mixing.hash_one((o, cell(p, o))) >> 32) as u32;
            self.chains.push(hash, id);
        }
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
