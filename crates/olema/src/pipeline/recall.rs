//! Recall: displaced points of welded edges and corners that another grid of the same worker had.
//!
//! In: the border of a lattice, and where its vertices are. Out: where those of them are that were known before. A point
//! of an edge is a function of the edge alone, so it has the same bits whether it is recalled or computed again. Most
//! edges are asked for twice and most corners four times, each time with the normals of all patches around them.

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

/// Points `first..first + len` of a place, at all keys.
#[derive(Debug, Clone)]
struct Run {
    place: Place,
    first: u64,
    len: usize,
    /// Key after key.
    placed: Vec<Vec3>,
    /// The grid that computes or computed it.
    made_by: u64,
    /// The last grid that uses it: until that is diced, nothing else takes its place.
    used_by: u64,
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
    /// Number of the grid that is diced.
    grid: u64,
    recalled: Vec<Link>,
    remembered: Vec<Link>,
}

impl Recall {
    /// Begins with the next grid.
    pub fn begin(&mut self) {
        self.grid += 1;
        self.recalled.clear();
        self.remembered.clear();
    }

    /// Whether the vertices of a run, all on one tessellation of one edge or on one corner, are known; if not, they will
    /// be once [`Self::exchange`] has seen them.
    pub fn knows(&mut self, run: &[(u32, PointRef)], num_keys: usize) -> bool {
        let (place, first, last) = span(run);
        let slot = match place {
            Place::Nowhere => return false,
            Place::Corner(corner) => hash_all([corner, 0]),
            Place::Edge(edge, denominator) => hash_all([edge, denominator as u32]),
        } as usize
            % REMEMBERED;
        if self.runs.is_empty() {
            let placed = Vec::new();
            let nothing = Run { place: Place::Nowhere, first: 0, len: 0, placed, made_by: 0, used_by: 0 };
            self.runs.resize(REMEMBERED, nothing);
        }
        let known = &mut self.runs[slot];
        let holds = known.place == place && known.first <= first && last < known.first + known.len as u64;
        // A surface that is closed has an edge twice: what this grid is to compute is not known yet.
        let is_known = holds && known.made_by != self.grid;
        if !is_known {
            if known.used_by == self.grid || last - first >= MOST_POINTS {
                return false;
            }
            (known.place, known.first, known.len) = (place, first, (last - first) as usize + 1);
            known.placed.clear();
            known.placed.resize(known.len * num_keys, Vec3::ZERO);
            known.made_by = self.grid;
        }
        known.used_by = self.grid;
        let links = if is_known { &mut self.recalled } else { &mut self.remembered };
        links.extend(run.iter().map(|&(vertex, point)| {
            let point = (numerator(point) - known.first) as u32;
            Link { vertex, slot: slot as u32, point }
        }));
        is_known
    }

    /// Puts the known vertices where they are at motion key `key`, and remembers where the others are.
    pub fn exchange(&mut self, key: usize, vertices: &mut Vec3s) {
        for link in &self.recalled {
            let run = &self.runs[link.slot as usize];
            vertices.set(link.vertex as usize, run.placed[key * run.len + link.point as usize]);
        }
        for link in &self.remembered {
            let run = &mut self.runs[link.slot as usize];
            run.placed[key * run.len + link.point as usize] = vertices.get(link.vertex as usize);
        }
    }
}

fn numerator(point: PointRef) -> u64 {
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
pub fn are_neighbours(a: PointRef, b: PointRef) -> bool {
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

    #[test]
    fn a_second_grid_gets_what_the_first_one_computed() {
        let mut recall = Recall::default();
        recall.begin();
        assert!(!recall.knows(&on_edge(3, &[2, 3, 4]), 2));
        recall.exchange(0, &mut vertices(&[2.0, 3.0, 4.0]));
        recall.exchange(1, &mut vertices(&[20.0, 30.0, 40.0]));
        recall.begin();
        assert!(recall.knows(&on_edge(3, &[4, 3, 3]), 2), "a part of it, the other way round, a point twice");
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
        recall.begin();
        assert!(!recall.knows(&on_edge(3, &[1, 2]), 1));
        assert!(!recall.knows(&on_edge(3, &[1, 2]), 1), "the same grid has the edge on two sides");
        recall.exchange(0, &mut vertices(&[5.0, 6.0]));
        recall.begin();
        assert!(!recall.knows(&on_edge(3, &[0, 1]), 1), "a point more");
        assert!(!recall.knows(&on_edge(4, &[1, 2]), 1), "another edge");
        let corner = [(0, PointRef::Corner(3))];
        assert!(!recall.knows(&corner, 1));
        recall.begin();
        assert!(recall.knows(&corner, 1));
    }
}
