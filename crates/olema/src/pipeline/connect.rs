//! Connect: find the edges and corners that patches share, before anything is diced.
//!
//! In: all patches of the frame. Out: `EdgeTable`; each patch learns its edges and corners. Points are welded
//! where they agree bit for bit or within a tolerance relative to the smaller of the two patches (the
//! teapot's patches touch without sharing points); from then on the owner's point stands for all.
//!
//! An edge is owned by the lowest patch that has it. Its tessellation is a function of the owner's curve, the
//! finest shading rate of all its patches and the camera, so both sides agree whatever else differs.

use std::collections::hash_map::Entry;

use glam::{Vec3, Vec4};

use crate::math::map::Map;

use super::by_topology::ByTopology;
use super::edges::{Along, Corner, Edge, EdgeTable, EdgeUse, Owner, Part};
use super::known::Known;
use super::patch::{Patch, PatchTable, SIDE_CORNERS, Shape};
use super::rate::Fineness;
use super::weld::{KeyedWelder, Latest};

/// Points closer than this times the smaller patch's diagonal are one point.
pub const WELD_TOLERANCE: f32 = 1e-5;

/// Connects all patches of `table`; `fineness[primitive]` is each primitive's. Patches with control points are
/// welded by what these are at all keys, base quads of a mesh by its topology.
pub fn connect(table: &mut PatchTable, fineness: &[Fineness]) -> EdgeTable {
    let by_points = ByPoints::new(table);
    connect_with(table, fineness, by_points)
}

fn connect_with(table: &mut PatchTable, fineness: &[Fineness], mut by_points: ByPoints) -> EdgeTable {
    let mut edges = EdgeTable::default();
    // Sheets have about as many corners, and twice as many edges, as patches.
    edges.edges.reserve_exact(2 * table.patches.len());
    edges.corners.reserve_exact(table.patches.len());
    let rate_of = |primitive: u32| fineness[primitive as usize];
    let mut by_topology = ByTopology::default();
    for ix in 0..table.patches.len() {
        let patch = table.patches[ix];
        let rate = rate_of(patch.primitive);
        let (corners, uses, slack) = match patch.shape {
            Shape::Subdivision { limit, quad } => {
                let quad = table.limits[limit as usize].surface.quad(quad);
                by_topology.connect(&mut edges, limit, &quad, ix as u32, rate)
            }
            _ => by_points.connect(table, &mut edges, ix as u32, rate),
        };
        let patch = &mut table.patches[ix];
        (patch.corners, patch.edges, patch.slack) = (corners, uses, slack);
    }
    for edge in &mut edges.edges {
        edge.halved = edge.middle != u32::MAX;
    }
    edges.edges.shrink_to_fit();
    edges.corners.shrink_to_fit();
    edges.known = Known::new(edges.edges.len(), table.patches.len());
    edges
}

/// A patch's corners and edges, and how far its border as the owners draw it may be from its own.
pub(super) type Connected = ([u32; 4], [EdgeUse; 4], f32);

/// Corners and edges of the patches connected so far, by their control points.
///
/// Most corners and edges come again with the same bits, that of the owner at all keys: these are told by that and need
/// no search for what lies near. Those of a sheet are mostly the last patch's, and those of the patch after the one
/// below that.
struct ByPoints {
    /// How close is equal, for each patch.
    tolerance: Vec<f32>,
    /// Sides of the patch that is connected, key after key.
    keys: Vec<Sides>,
    /// Those of the patch before.
    before: Vec<Sides>,
    /// That patch, and the one whose top is its bottom.
    last: [Option<u32>; 2],
    /// Off: these are not looked at.
    has_neighbours: bool,
    corners: KeyedWelder,
    corner_of_weld: Map<u32, u32>,
    /// The last corner with a hash of its owner's points,
    corner_of_bits: Latest,
    /// The only edge between two corners, or [`SEVERAL`]: of the only one nobody asks where its middle is.
    between: Map<(u32, u32), u32>,
    middles: KeyedWelder,
    /// Of several between two corners the first with a middle,
    edges: Map<(u32, u32, u32), u32>,
    /// and after each edge the next one of these.
    next: Map<u32, u32>,
    /// The last such first edge with a hash of its corners and its owner's middles.
    edge_of_bits: Latest,
}

/// More than one edge.
const SEVERAL: u32 = u32::MAX;

impl ByPoints {
    fn new(table: &PatchTable) -> Self {
        let tolerance: Vec<f32> = table.patches.iter().map(|patch| tolerance(table, patch)).collect();
        ByPoints {
            keys: Vec::new(),
            before: Vec::new(),
            last: [None; 2],
            has_neighbours: true,
            corners: KeyedWelder::new(tolerance.iter().copied()),
            corner_of_weld: Map::default(),
            corner_of_bits: Latest::for_about(table.patches.len()),
            between: Map::default(),
            middles: KeyedWelder::new(tolerance.iter().copied()),
            edges: Map::default(),
            next: Map::default(),
            edge_of_bits: Latest::for_about(2 * table.patches.len()),
            tolerance,
        }
    }

    fn connect(
        &mut self,
        patches: &PatchTable,
        table: &mut EdgeTable,
        patch: u32,
        rate: Fineness,
    ) -> Connected {
        std::mem::swap(&mut self.keys, &mut self.before);
        let mut keys = std::mem::take(&mut self.keys);
        keys.clear();
        keys.extend(sides(patches, patch));
        let motion = patches.patches[patch as usize].motion;
        let tolerance = self.tolerance[patch as usize];
        let new = Joining { patches, patch, motion, tolerance, rate, keys: &keys };
        let [left, below] = self.neighbours(&new);
        let of = |patch: u32| &patches.patches[patch as usize];
        let known_corner = |corner: usize| match corner {
            0 => left.map(|l| of(l).corners[1]).or(below.map(|b| of(b).corners[2])),
            1 => below.map(|b| of(b).corners[3]),
            2 => left.map(|l| of(l).corners[3]),
            _ => None,
        };
        let known_edge = |side: usize| match side {
            0 => below.map(|b| of(b).edges[2]),
            3 => left.map(|l| of(l).edges[1]),
            _ => None,
        };
        let mut agrees = true;
        let corners: [u32; 4] = std::array::from_fn(|corner| match known_corner(corner) {
            Some(known) => table.corner(Some(known), patch, corner, rate),
            None => {
                let (ix, same) = self.corner(&new, table, corner);
                agrees &= same;
                ix
            }
        });
        let uses: [EdgeUse; 4] = std::array::from_fn(|side| match known_edge(side) {
            Some(known) => {
                table.use_edge(known.edge, rate);
                known
            }
            None => {
                let (used, same) = self.edge(&new, table, side, SIDE_CORNERS[side].map(|c| corners[c]));
                agrees &= same;
                used
            }
        });
        let bottom = table.edges[uses[0].edge as usize].owners[0];
        let below = below.or((bottom.side == 2 && bottom.patch < patch).then_some(bottom.patch));
        self.last = if self.has_neighbours { [Some(patch), below] } else { [None; 2] };
        self.keys = keys;
        (corners, uses, if agrees { 0.0 } else { 2.0 * tolerance })
    }

    /// The patches whose right side is a patch's left one, and whose top is its bottom, bit for bit and as their owners have
    /// them, if it follows its neighbours in a sheet.
    fn neighbours(&self, new: &Joining) -> [Option<u32>; 2] {
        let [left, below] = self.last;
        let agrees = |&patch: &u32| {
            let other = &new.patches.patches[patch as usize];
            patch < new.patch
                && other.slack == 0.0
                && new.moves_as(patch)
                && !matches!(other.shape, Shape::Subdivision { .. })
                && new.patches.num_keys(patch) == new.keys.len()
        };
        let is_left = |_: &u32| {
            !new.keys.is_empty()
                && self.before.len() == new.keys.len()
                && self.before.iter().zip(new.keys).all(|(before, sides)| before[1] == sides[3])
        };
        let is_below = |&patch: &u32| {
            let curve = |key: usize| new.patches.side_curve(patch, key, 2);
            !new.keys.is_empty()
                && new.keys.iter().enumerate().all(|(key, sides)| curve(key) == Some(sides[0]))
        };
        [left.filter(agrees).filter(is_left), below.map(|b| b + 1).filter(agrees).filter(is_below)]
    }

    /// The corner that a patch's corner is, and whether its owner's points are the patch's own.
    fn corner(&mut self, new: &Joining, table: &mut EdgeTable, corner: usize) -> (u32, bool) {
        let places = new.keys.iter().map(|sides| project(end_of(sides, corner)));
        let hash = self.corner_of_bits.hash([new.motion, 0, 0], places.clone());
        let likely = self.corner_of_bits.get(hash).map(|ix| (ix, table.corners[ix as usize]));
        if let Some((ix, known)) = likely
            && new.moves_as(known.owner)
            && new.has_points_of(&known, corner)
        {
            return (table.corner(Some(ix), new.patch, corner, new.rate), true);
        }
        let weld = self.corners.weld(new.motion, places, new.tolerance);
        let known = self.corner_of_weld.get(&weld).copied();
        let ix = table.corner(known, new.patch, corner, new.rate);
        if known.is_none() {
            self.corner_of_weld.insert(weld, ix);
            self.corner_of_bits.put(hash, ix);
        }
        (ix, new.has_points_of(&table.corners[ix as usize], corner))
    }

    /// The edge that a patch's side runs along, and whether its owner's curves are the patch's own.
    fn edge(
        &mut self,
        new: &Joining,
        table: &mut EdgeTable,
        side: usize,
        [from, to]: [u32; 2],
    ) -> (EdgeUse, bool) {
        let ends = [from.min(to), from.max(to)];
        let middles = new.keys.iter().map(|sides| curve_middle(&sides[side]));
        let hash = self.edge_of_bits.hash([new.motion, ends[0], ends[1]], middles.clone());
        let likely = self.edge_of_bits.get(hash).filter(|&ix| {
            let edge = &table.edges[ix as usize];
            let [a, b] = edge.corners;
            [a.min(b), a.max(b)] == ends && new.has_middles_of(edge.owners[0], side)
        });
        let along = |table: &EdgeTable, tolerance: &[f32], ix: u32| {
            let owner = table.edges[ix as usize].owners[0];
            let (reversed, same) = new.runs_along(owner, side, tolerance[owner.patch as usize])?;
            Some((ix, reversed, same))
        };
        let mut matched = likely.and_then(|ix| along(table, &self.tolerance, ix));
        if matched.is_none() {
            let next_edge = table.edges.len() as u32;
            match self.between.entry((ends[0], ends[1])) {
                Entry::Vacant(place) => {
                    place.insert(next_edge);
                    self.edge_of_bits.put(hash, next_edge);
                }
                Entry::Occupied(mut place) => {
                    let alone = std::mem::replace(place.get_mut(), SEVERAL);
                    if alone != SEVERAL {
                        self.note_middle(new.patches, table, alone);
                    }
                    let middle = self.middles.weld(new.motion, middles, new.tolerance);
                    let (mut last, mut next) = (None, None);
                    match self.edges.entry((ends[0], ends[1], middle)) {
                        Entry::Occupied(first) => next = Some(*first.get()),
                        Entry::Vacant(place) => {
                            place.insert(next_edge);
                            self.edge_of_bits.put(hash, next_edge);
                        }
                    }
                    // All that were found so far, in their order.
                    while let Some(ix) = next {
                        matched = along(table, &self.tolerance, ix);
                        last = next;
                        next = self.next.get(&ix).copied().filter(|_| matched.is_none());
                    }
                    if let (None, Some(last)) = (matched, last) {
                        self.next.insert(last, next_edge);
                    }
                }
            }
        }
        let (edge, reversed, same) = matched.unwrap_or_else(|| {
            table.edges.push(Edge {
                owners: [Owner { patch: new.patch, side: side as u8, along: Along::default() }; 2],
                halved: false,
                users: 0,
                corners: [from, to],
                middle: u32::MAX,
                fineness: new.rate,
            });
            (table.edges.len() as u32 - 1, false, true)
        });
        table.use_edge(edge, new.rate);
        (EdgeUse { edge, along: Along { part: Part::Whole, reversed } }, same)
    }
}

impl ByPoints {
    /// Notes where the middle of an edge is that was the only one between its corners.
    fn note_middle(&mut self, patches: &PatchTable, table: &EdgeTable, ix: u32) {
        let Edge { owners: [Owner { patch, side, .. }, _], corners: [a, b], .. } = table.edges[ix as usize];
        let curves =
            (0..patches.num_keys(patch)).map_while(|key| patches.side_curve(patch, key, side as usize));
        let motion = patches.patches[patch as usize].motion;
        let middles = curves.map(|curve| curve_middle(&curve));
        let middle = self.middles.weld(motion, middles, self.tolerance[patch as usize]);
        self.edges.insert((a.min(b), a.max(b), middle), ix);
    }
}

/// A patch that is connected to those before it.
struct Joining<'a> {
    patches: &'a PatchTable,
    patch: u32,
    motion: u32,
    tolerance: f32,
    rate: Fineness,
    /// Its sides, key after key.
    keys: &'a [Sides],
}

impl Joining<'_> {
    /// Whether a patch has the same key times.
    fn moves_as(&self, other: u32) -> bool {
        self.patches.patches[other as usize].motion == self.motion
    }

    /// Whether a corner's owner has the points of the patch's own there.
    fn has_points_of(&self, known: &Corner, corner: usize) -> bool {
        let [side, end] = CORNER_ENDS[known.corner as usize];
        self.keys.iter().enumerate().all(|(key, sides)| {
            let curve = self.patches.side_curve(known.owner, key, side);
            curve.map(|curve| curve[end]) == Some(end_of(sides, corner))
        })
    }

    /// Whether an edge's owner moves at the same times and has the middles of the patch's side.
    fn has_middles_of(&self, owner: Owner, side: usize) -> bool {
        self.moves_as(owner.patch)
            && self.keys.iter().enumerate().all(|(key, sides)| {
                let curve = self.patches.side_curve(owner.patch, key, owner.side as usize);
                curve.is_some_and(|curve| curve_middle(&curve) == curve_middle(&sides[side]))
            })
    }

    /// Whether the patch's side runs along an edge as its owner's does, within both tolerances, at all keys: the other way
    /// round or not, and whether with the same points.
    fn runs_along(&self, owner: Owner, side: usize, tolerance: f32) -> Option<(bool, bool)> {
        let tolerance = tolerance.min(self.tolerance);
        if self.keys.len() != self.patches.num_keys(owner.patch) {
            return None;
        }
        let (mut reversed, mut same) = (None, true);
        for (key, sides) in self.keys.iter().enumerate() {
            let mut curve = self.patches.side_curve(owner.patch, key, owner.side as usize)?;
            let other = same_curve(&sides[side], &curve, tolerance)?;
            if *reversed.get_or_insert(other) != other {
                return None;
            }
            if other {
                curve.reverse();
            }
            same &= curve == sides[side];
        }
        Some((reversed?, same))
    }
}

/// The curves of a patch's sides at one key.
type Sides = [[Vec4; 4]; 4];

/// The sides of a patch, key after key; none without control points.
fn sides(table: &PatchTable, patch: u32) -> impl Iterator<Item = Sides> + '_ {
    (0..table.num_keys(patch)).map_while(move |key| {
        let mut sides = [[Vec4::ZERO; 4]; 4];
        for (side, curve) in sides.iter_mut().enumerate() {
            *curve = table.side_curve(patch, key, side)?;
        }
        Some(sides)
    })
}

/// How close points of a patch have to be to be one.
fn tolerance(table: &PatchTable, patch: &Patch) -> f32 {
    table.extent(patch).diagonal() * WELD_TOLERANCE
}

/// Side and point of its curve for each corner, counted as [`super::Patch::corners`] counts them.
const CORNER_ENDS: [[usize; 2]; 4] = [[0, 0], [0, 3], [2, 0], [2, 3]];

fn end_of(sides: &Sides, corner: usize) -> Vec4 {
    let [side, end] = CORNER_ENDS[corner];
    sides[side][end]
}

fn project(p: Vec4) -> Vec3 {
    Vec3::new(p.x / p.w, p.y / p.w, p.z / p.w)
}

/// The middle of a curve, the same bits from either end.
fn curve_middle(c: &[Vec4; 4]) -> Vec3 {
    project(((c[0] + c[3]) + (c[1] + c[2]) * 3.0) * 0.125)
}

/// Whether two curves agree within `tolerance`: `Some(false)` in the same direction, `Some(true)` reversed.
fn same_curve(a: &[Vec4; 4], b: &[Vec4; 4], tolerance: f32) -> Option<bool> {
    let close = |p: Vec4, q: Vec4| (p - q).abs().max_element() <= tolerance;
    if (0..4).all(|ix| close(a[ix], b[ix])) {
        Some(false)
    } else if (0..4).all(|ix| close(a[ix], b[3 - ix])) {
        Some(true)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{hash32, signed_unit};
    use crate::pipeline::motion::KeyTimes;
    use crate::pipeline::patchify::patchify;
    use crate::standard::teapot::teapot;

    /// What is told by bits alone is what a search finds, where points differ by less than they may, at some keys only.
    #[test]
    fn bits_tell_what_a_search_finds() {
        let scene = teapot();
        let rate = Fineness { shading_rate: 1.0, motion_factor: 0.0, focus_factor: 0.0 };
        let fineness = vec![rate; scene.primitives.len()];
        for num_keys in [1, 2] {
            let mut times = KeyTimes::still(&scene);
            if num_keys == 2 {
                times.sets.push(vec![0.0, 1.0]);
                times.of_primitive.iter_mut().for_each(|set| *set = 1);
            }
            let (mut table, _) = patchify(&scene, &times);
            let is_moved = |ix: usize| hash32(ix as u32).is_multiple_of(16);
            for (ix, x) in table.floats.iter_mut().enumerate().filter(|(ix, _)| is_moved(*ix)) {
                *x += signed_unit(hash32(ix as u32 + 7)) * 2e-5;
            }
            let mut searched = table.clone();
            let by_search = ByPoints {
                corner_of_bits: Latest::never(),
                edge_of_bits: Latest::never(),
                has_neighbours: false,
                ..ByPoints::new(&searched)
            };
            let edges = connect(&mut table, &fineness);
            let expected = connect_with(&mut searched, &fineness, by_search);
            assert_eq!((&edges.edges, &edges.corners), (&expected.edges, &expected.corners));
            assert!(edges.num_welds() > 40 && edges.num_welds() < edges.edges.len());
            for (patch, twin) in table.patches.iter().zip(&searched.patches) {
                assert_eq!((patch.edges, patch.corners, patch.slack), (twin.edges, twin.corners, twin.slack));
            }
            assert!(table.patches.iter().any(|patch| patch.slack > 0.0));
        }
    }
}
