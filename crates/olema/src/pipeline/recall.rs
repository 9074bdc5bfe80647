//! Recall: displaced points of welded edges and corners that another grid of the same worker had.
//!
//! In: the border of a lattice, and where its vertices are. Out: where those of them are that were known before. A point
//! of an edge is a function of the edge alone, so it has the same bits whether it is recalled or computed again. Most
//! edges are asked for twice and most corners four times, each time with the normals of all patches around them.

use std::ops::Range;

use glam::Vec3;

use crate::math::Vec3s;
use crate::math::hash::hash_all;

use super::piece::PointRef;

/// Runs that a worker remembers: those of a tile and more.
const REMEMBERED: usize = 1024;

/// Longer runs are not remembered.
const MOST_POINTS: u64 = 256;

/// What a run of points lies on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    Nowhere,
    Corner(u32),
    /// The edge, and the denominator of parameters along it.
    Edge(u32, u64),
}

/// Points `first..first + len` of a place, at all keys. One line of the cache: which run is asked for next cannot be foretold.
#[derive(Debug, Clone)]
#[repr(align(64))]
struct Run {
    place: Place,
    first: u64,
    /// Key after key.
    placed: Vec<Vec3>,
    len: u32,
    /// The grid that computes or computed it.
    made_by: u32,
    /// The last grid that uses it: until that is diced, nothing else takes its place.
    used_by: u32,
}

const _: () = assert!(size_of::<Run>() == 64);

/// A run that a grid asks for.
#[derive(Debug, Clone, Copy)]
struct Asked {
    place: Place,
    /// First and last point.
    ends: [u64; 2],
    /// Where it would be remembered.
    slot: u32,
    /// Whether it was there before the grid.
    is_there: bool,
    /// First vertex and the one behind the last one, in the list of the border.
    range: [u32; 2],
}

/// A vertex, and the point of a run that it is.
#[derive(Debug, Clone, Copy)]
struct Link {
    vertex: u32,
    slot: u32,
    point: u32,
}

/// One worker's memory.
#[derive(Debug, Default)]
pub struct Recall {
    runs: Vec<Run>,
    /// Number of the grid that is diced. What one with the same number had, 2^32 grids ago, is computed again.
    grid: u32,
    asked: Vec<Asked>,
    recalled: Vec<Link>,
    remembered: Vec<Link>,
}

impl Recall {
    /// Begins with the next grid, which has the vertices `border`: cuts them into runs, and looks for all of these before
    /// anything is done about one, since what is remembered is mostly far away in memory, and comes at the same time then.
    pub fn begin(&mut self, border: &[(u32, PointRef)]) {
        self.grid = self.grid.wrapping_add(1);
        self.asked.clear();
        self.recalled.clear();
        self.remembered.clear();
        if self.runs.is_empty() {
            let placed = Vec::new();
            let nothing = Run { place: Place::Nowhere, first: 0, len: 0, placed, made_by: 0, used_by: 0 };
            self.runs.resize(REMEMBERED, nothing);
        }
        let mut from = 0;
        for run in border.chunk_by(|a, b| are_neighbours(a.1, b.1)) {
            let (place, first, last) = span(run);
            let hash = match place {
                Place::Nowhere => 0,
                Place::Corner(corner) => hash_all([corner, 0]),
                Place::Edge(edge, denominator) => hash_all([edge, denominator as u32]),
            };
            let slot = hash % REMEMBERED as u32;
            let known = &self.runs[slot as usize];
            let is_there =
                (known.place == place) & (known.first <= first) & (last < known.first + u64::from(known.len));
            let range = [from, from + run.len() as u32];
            self.asked.push(Asked { place, ends: [first, last], slot, is_there, range });
            from = range[1];
        }
    }

    /// How many runs the grid's border has.
    pub fn num_runs(&self) -> usize {
        self.asked.len()
    }

    /// The vertices of a run in the list of the border: all on one tessellation of one edge, or a single one.
    pub fn run(&self, ix: usize) -> Range<usize> {
        let [from, to] = self.asked[ix].range;
        from as usize..to as usize
    }

    /// Whether the vertices of a run, which are given, are known; if not, they will be once [`Self::exchange`] has seen
    /// them.
    pub fn knows(&mut self, ix: usize, run: &[(u32, PointRef)], num_keys: usize) -> bool {
        let Asked { place, ends: [first, last], slot, is_there, .. } = self.asked[ix];
        if place == Place::Nowhere {
            return false;
        }
        let known = &mut self.runs[slot as usize];
        // A surface that is closed has an edge twice: what this grid is to compute is not known yet.
        let is_known = is_there && known.made_by != self.grid;
        if !is_known {
            if known.used_by == self.grid || last - first >= MOST_POINTS {
                return false;
            }
            (known.place, known.first, known.len) = (place, first, (last - first) as u32 + 1);
            known.placed.clear();
            known.placed.resize(known.len as usize * num_keys, Vec3::ZERO);
            known.made_by = self.grid;
        }
        known.used_by = self.grid;
        let first = known.first;
        let links = if is_known { &mut self.recalled } else { &mut self.remembered };
        links.extend(run.iter().map(|&(vertex, point)| Link {
            vertex,
            slot,
            point: (numerator(point) - first) as u32,
        }));
        is_known
    }

    /// Puts the known vertices where they are at motion key `key`, and remembers where the others are.
    pub fn exchange(&mut self, key: usize, vertices: &mut Vec3s) {
        for link in &self.recalled {
            let run = &self.runs[link.slot as usize];
            vertices.set(link.vertex as usize, run.placed[key * run.len as usize + link.point as usize]);
        }
        for link in &self.remembered {
            let run = &mut self.runs[link.slot as usize];
            run.placed[key * run.len as usize + link.point as usize] = vertices.get(link.vertex as usize);
        }
    }
}

/// Where a point is along its edge; 0 for any other point.
#[inline(always)]
pub fn numerator(point: PointRef) -> u64 {
    if let PointRef::Edge { numerator, .. } = point { numerator } else { 0 }
}

/// What a run lies on, and its first and last point there.
fn span(run: &[(u32, PointRef)]) -> (Place, u64, u64) {
    match run {
        [(_, PointRef::Corner(corner)), ..] => (Place::Corner(*corner), 0, 0),
        [(_, PointRef::Edge { edge, denominator, .. }), ..] => {
            let numerators = run.iter().map(|&(_, point)| numerator(point));
            let (first, last) = numerators.fold((u64::MAX, 0), |(a, b), n| (a.min(n), b.max(n)));
            (Place::Edge(*edge, *denominator), first, last)
        }
        _ => (Place::Nowhere, 0, 0),
    }
}

/// Whether two border points are the same or follow each other on one tessellation of one edge. (A grid's corner may be a
/// point of an edge that an earlier split made, in other steps than the side goes; and a surface that closes has points
/// of one edge on both sides of a grid: a run has no gaps.)
fn are_neighbours(a: PointRef, b: PointRef) -> bool {
    match (a, b) {
        (PointRef::Edge { edge: a, denominator: m, .. }, PointRef::Edge { edge: b, denominator: n, .. })
            if (a, m) == (b, n) => {}
        _ => return false,
    }
    numerator(a).abs_diff(numerator(b)) <= 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on_edge(edge: u32, numerators: &[u64]) -> Vec<(u32, PointRef)> {
        let point = |&numerator: &u64| PointRef::Edge { edge, numerator, denominator: 9 };
        (0..).zip(numerators.iter().map(point)).collect()
    }

    fn vertices(values: &[f32]) -> Vec3s {
        Vec3s::from_axes([values; 3])
    }

    /// What is known of the runs of a grid's border.
    fn ask(recall: &mut Recall, border: &[(u32, PointRef)], num_keys: usize) -> Vec<bool> {
        recall.begin(border);
        (0..recall.num_runs()).map(|ix| recall.knows(ix, &border[recall.run(ix)], num_keys)).collect()
    }

    #[test]
    fn a_second_grid_gets_what_the_first_one_computed() {
        let mut recall = Recall::default();
        assert_eq!(ask(&mut recall, &on_edge(3, &[2, 3, 4]), 2), [false]);
        recall.exchange(0, &mut vertices(&[2.0, 3.0, 4.0]));
        recall.exchange(1, &mut vertices(&[20.0, 30.0, 40.0]));
        let again = on_edge(3, &[4, 3, 3]);
        assert_eq!(ask(&mut recall, &again, 2), [true], "a part of it, the other way round, a point twice");
        let mut seen = vertices(&[0.0; 3]);
        recall.exchange(0, &mut seen);
        assert_eq!(seen.x(), [4.0, 3.0, 3.0]);
        recall.exchange(1, &mut seen);
        assert_eq!(seen.z(), [40.0, 30.0, 30.0]);
    }

    #[test]
    fn points_with_a_gap_between_them_are_no_run() {
        let [a, b, c] = [2, 3, 5].map(|numerator| PointRef::Edge { edge: 1, numerator, denominator: 9 });
        assert!(are_neighbours(a, b) && are_neighbours(b, a) && are_neighbours(a, a));
        assert!(!are_neighbours(b, c) && !are_neighbours(a, PointRef::Corner(1)));
        assert!(!are_neighbours(a, PointRef::Edge { edge: 1, numerator: 2, denominator: 18 }));
    }

    #[test]
    fn what_is_not_computed_yet_is_not_known() {
        let mut recall = Recall::default();
        let (edge, other) = (on_edge(3, &[1, 2]), on_edge(4, &[1, 2]));
        let twice = [&edge[..], &other, &edge].concat();
        let known = ask(&mut recall, &twice, 1);
        assert_eq!(known, [false; 3], "the same grid has the edge on two sides");
        recall.exchange(0, &mut vertices(&[5.0, 6.0]));
        assert_eq!(ask(&mut recall, &on_edge(3, &[0, 1]), 1), [false], "a point more");
        let corner = [(0, PointRef::Corner(3))];
        assert_eq!(ask(&mut recall, &corner, 1), [false]);
        assert_eq!(ask(&mut recall, &corner, 1), [true]);
    }
}
