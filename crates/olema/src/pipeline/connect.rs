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

use crate::geometry::Aabb;

use crate::geometry::subdivision::{BaseQuad, CornerId, Piece};
use crate::math::map::Map;

use super::known::Known;
use super::patch::{Patch, PatchTable, SIDE_CORNERS, Shape};
use super::rate::Fineness;
use super::weld::KeyedWelder;

/// Points closer than this times the smaller patch's diagonal are one point.
pub const WELD_TOLERANCE: f32 = 1e-5;

/// How much of an edge a side of a patch is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Part {
    /// All of it.
    #[default]
    Whole,
    /// From its start to its middle.
    First,
    /// From its middle to its end.
    Second,
}

/// How a side of a patch runs along an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Along {
    /// How much of the edge it is.
    pub part: Part,
    /// Whether it runs against the edge's direction.
    pub reversed: bool,
}

impl Along {
    /// The edge's parameter `numerator / denominator`, which must lie on the side, as one of the side.
    pub fn own(self, numerator: u64, denominator: u64) -> (u64, u64) {
        let along = match self.part {
            Part::Whole => numerator,
            Part::First => 2 * numerator,
            Part::Second => 2 * numerator - denominator,
        };
        (if self.reversed { denominator - along } else { along }, denominator)
    }

    /// Whether the edge's parameter `numerator / denominator` lies on the side.
    pub fn has(self, numerator: u64, denominator: u64) -> bool {
        match self.part {
            Part::Whole => true,
            Part::First => 2 * numerator <= denominator,
            Part::Second => 2 * numerator >= denominator,
        }
    }
}

/// A patch's use of an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct EdgeUse {
    /// Index of the edge.
    pub edge: u32,
    /// How the patch's side runs along it.
    pub along: Along,
}

/// A side of a patch that runs along an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Owner {
    /// The patch.
    pub patch: u32,
    /// Its side.
    pub side: u8,
    /// How that runs along the edge.
    pub along: Along,
}

/// Not known yet.
const NOBODY: Owner = Owner { patch: u32::MAX, side: 0, along: Along { part: Part::Whole, reversed: false } };

/// An edge, owned by one patch and shared by any number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// Owners of its first and second half; the same patch unless one that owns has only a half of it.
    pub owners: [Owner; 2],
    /// Whether some patch ends at its middle: it is halved before anything else then, for all of them.
    pub halved: bool,
    /// How many patches have it.
    pub users: u32,
    /// Corners at its start and end.
    pub corners: [u32; 2],
    /// The corner at its middle, where it is halved.
    pub middle: u32,
    /// Finest of its patches.
    pub fineness: Fineness,
}

/// A corner, owned by one patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// The patch whose point it is.
    pub owner: u32,
    /// The owner's corner.
    pub corner: u8,
    /// Finest shading rate of its patches.
    pub shading_rate: f32,
}

/// A patch's corner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CornerUse {
    /// The patch.
    pub patch: u32,
    /// Its corner.
    pub corner: u8,
}

/// Edges and corners of all patches.
#[derive(Debug, Default)]
pub struct EdgeTable {
    /// Edges, in the order of their owners.
    pub edges: Vec<Edge>,
    /// Corners, in the order of their owners.
    pub corners: Vec<Corner>,
    /// What was measured of them.
    pub known: Known,
    edge_users: Lists<Owner>,
    corner_users: Lists<CornerUse>,
}

/// Lists of different lengths, end to end. Empty where nobody asks for them.
#[derive(Debug, Clone, Default)]
struct Lists<T> {
    starts: Vec<u32>,
    items: Vec<T>,
}

impl<T: Copy + Default> Lists<T> {
    /// Sorts (list, item) pairs into lists; within a list the order stays.
    fn new(num_lists: usize, pairs: impl Iterator<Item = (u32, T)> + Clone) -> Self {
        let mut starts = vec![0u32; num_lists + 1];
        pairs.clone().for_each(|(list, _)| starts[list as usize + 1] += 1);
        for list in 0..num_lists {
            starts[list + 1] += starts[list];
        }
        let mut next = starts.clone();
        let mut items = vec![T::default(); starts[num_lists] as usize];
        for (list, item) in pairs {
            items[next[list as usize] as usize] = item;
            next[list as usize] += 1;
        }
        Lists { starts, items }
    }

    fn get(&self, list: u32) -> &[T] {
        match self.starts.get(list as usize..list as usize + 2) {
            Some(range) => &self.items[range[0] as usize..range[1] as usize],
            None => &[],
        }
    }
}

impl EdgeTable {
    /// Edges that two or more patches share.
    pub fn num_welds(&self) -> usize {
        self.edges.iter().filter(|e| e.users > 1).count()
    }

    /// Notes who meets at each edge and corner, for those who displace.
    pub fn list_users(&mut self, table: &PatchTable) {
        let patches = || table.patches.iter().zip(0u32..);
        let sides = patches().flat_map(|(patch, ix)| {
            patch
                .edges
                .iter()
                .zip(0u8..)
                .map(move |(used, side)| (used.edge, Owner { patch: ix, side, along: used.along }))
        });
        let corners = patches().flat_map(|(patch, ix)| {
            patch.corners.iter().zip(0u8..).map(move |(&id, corner)| (id, CornerUse { patch: ix, corner }))
        });
        self.edge_users = Lists::new(self.edges.len(), sides);
        self.corner_users = Lists::new(self.corners.len(), corners);
    }

    /// Sides along an edge, in the order of their patches, once [`Self::list_users`] has run.
    pub fn edge_users(&self, edge: u32) -> &[Owner] {
        self.edge_users.get(edge)
    }

    /// Corners at a corner, in the order of their patches, once [`Self::list_users`] has run.
    pub fn corner_users(&self, corner: u32) -> &[CornerUse] {
        self.corner_users.get(corner)
    }

    fn corner(&mut self, known: Option<u32>, owner: u32, corner: usize, fineness: Fineness) -> u32 {
        let shading_rate = fineness.shading_rate;
        match known {
            Some(ix) => {
                let corner = &mut self.corners[ix as usize];
                corner.shading_rate = corner.shading_rate.min(shading_rate);
                ix
            }
            None => {
                self.corners.push(Corner { owner, corner: corner as u8, shading_rate });
                self.corners.len() as u32 - 1
            }
        }
    }

    fn use_edge(&mut self, edge: u32, fineness: Fineness) {
        let edge = &mut self.edges[edge as usize];
        edge.users += 1;
        edge.fineness = edge.fineness.finest(fineness);
    }
}

/// Connects all patches of `table`; `fineness[primitive]` is each primitive's. Patches with control points are
/// welded by what these are at all keys, base quads of a mesh by its topology.
pub fn connect(table: &mut PatchTable, fineness: &[Fineness]) -> EdgeTable {
    let mut edges = EdgeTable::default();
    // Sheets have about as many corners, and twice as many edges, as patches.
    edges.edges.reserve_exact(2 * table.patches.len());
    edges.corners.reserve_exact(table.patches.len());
    let rate_of = |primitive: u32| fineness[primitive as usize];
    let mut by_points = ByPoints::new(table);
    let mut by_topology = ByTopology::default();
    for ix in 0..table.patches.len() {
        let patch = table.patches[ix];
        let rate = rate_of(patch.primitive);
        let (corners, uses) = match patch.shape {
            Shape::Subdivision { limit, quad } => {
                let quad = table.limits[limit as usize].surface.quad(quad);
                by_topology.connect(&mut edges, limit, &quad, ix as u32, rate)
            }
            _ => by_points.connect(table, &mut edges, ix as u32, rate),
        };
        (table.patches[ix].corners, table.patches[ix].edges) = (corners, uses);
    }
    for edge in &mut edges.edges {
        edge.halved = edge.middle != u32::MAX;
    }
    for ix in 0..table.patches.len() {
        table.patches[ix].slack = by_points.slack(table, &edges, ix);
    }
    edges.edges.shrink_to_fit();
    edges.corners.shrink_to_fit();
    edges.known = Known::new(edges.edges.len(), table.patches.len());
    edges
}

/// Corners and edges of the patches connected so far, by topology.
#[derive(Default)]
struct ByTopology {
    corners: Map<(u32, CornerId), u32>,
    edges: Map<(u32, u32), u32>,
}

impl ByTopology {
    fn connect(
        &mut self,
        table: &mut EdgeTable,
        limit: u32,
        quad: &BaseQuad,
        patch: u32,
        rate: Fineness,
    ) -> ([u32; 4], [EdgeUse; 4]) {
        // A base quad's corners go round; a patch's are (0,0), (1,0), (0,1), (1,1).
        let ids = [quad.corners[0], quad.corners[1], quad.corners[3], quad.corners[2]];
        let corners: [u32; 4] = std::array::from_fn(|c| {
            let known = self.corners.get(&(limit, ids[c])).copied();
            let ix = table.corner(known, patch, c, rate);
            self.corners.insert((limit, ids[c]), ix);
            ix
        });
        let uses = std::array::from_fn(|side| {
            let edge = &quad.edges[side];
            let part = match edge.piece {
                Piece::Whole => Part::Whole,
                Piece::FirstHalf => Part::First,
                Piece::SecondHalf => Part::Second,
            };
            // Top and left run the other way round the quad.
            let along = Along { part, reversed: edge.reversed != (side >= 2) };
            let mut ends = SIDE_CORNERS[side].map(|c| corners[c]);
            if along.reversed {
                ends.reverse();
            }
            let owner = Owner { patch, side: side as u8, along };
            let ix = *self.edges.entry((limit, edge.edge)).or_insert_with(|| {
                table.edges.push(Edge {
                    owners: [NOBODY; 2],
                    halved: true,
                    users: 0,
                    corners: [u32::MAX; 2],
                    middle: u32::MAX,
                    fineness: rate,
                });
                table.edges.len() as u32 - 1
            });
            table.use_edge(ix, rate);
            let known = &mut table.edges[ix as usize];
            match part {
                Part::Whole => known.corners = ends,
                Part::First => (known.corners[0], known.middle) = (ends[0], ends[1]),
                Part::Second => (known.middle, known.corners[1]) = (ends[0], ends[1]),
            }
            // The first patch that has a half owns it.
            let (first, second) = (part != Part::Second, part != Part::First);
            for (owned, has) in known.owners.iter_mut().zip([first, second]) {
                if has && *owned == NOBODY {
                    *owned = owner;
                }
            }
            EdgeUse { edge: ix, along }
        });
        (corners, uses)
    }
}

/// Corners and edges of the patches connected so far, by their control points.
struct ByPoints {
    /// How close is equal, for each patch.
    tolerance: Vec<f32>,
    /// Sides of the patch that is connected, key after key.
    keys: Vec<Sides>,
    corners: KeyedWelder,
    corner_of_weld: Map<u32, u32>,
    middles: KeyedWelder,
    /// The first edge between two corners with a middle,
    edges: Map<(u32, u32, u32), u32>,
    /// and after each edge the next one of these.
    next: Map<u32, u32>,
}

impl ByPoints {
    fn new(table: &PatchTable) -> Self {
        let tolerance: Vec<f32> = table.patches.iter().map(|patch| tolerance(table, patch)).collect();
        ByPoints {
            keys: Vec::new(),
            corners: KeyedWelder::new(tolerance.iter().copied()),
            corner_of_weld: Map::default(),
            middles: KeyedWelder::new(tolerance.iter().copied()),
            edges: Map::default(),
            next: Map::default(),
            tolerance,
        }
    }

    fn connect(
        &mut self,
        patches: &PatchTable,
        table: &mut EdgeTable,
        patch: u32,
        rate: Fineness,
    ) -> ([u32; 4], [EdgeUse; 4]) {
        let tolerance = self.tolerance[patch as usize];
        let motion = patches.patches[patch as usize].motion;
        let mut keys = std::mem::take(&mut self.keys);
        keys.clear();
        keys.extend(sides(patches, patch));
        let corners: [u32; 4] = std::array::from_fn(|corner| {
            let places = keys.iter().map(|sides| project(end_of(sides, corner)));
            let weld = self.corners.weld(motion, places, tolerance);
            let ix = table.corner(self.corner_of_weld.get(&weld).copied(), patch, corner, rate);
            self.corner_of_weld.insert(weld, ix);
            ix
        });
        let uses = std::array::from_fn(|side| {
            let [from, to] = SIDE_CORNERS[side].map(|c| corners[c]);
            let places = keys.iter().map(|sides| curve_middle(&sides[side]));
            let middle = self.middles.weld(motion, places, tolerance);
            let first = self.edges.entry((from.min(to), from.max(to), middle));
            let is_new = matches!(first, Entry::Vacant(_));
            let next_edge = table.edges.len() as u32;
            let first = *first.or_insert(next_edge);
            let matches = |ix: u32| {
                let owner = table.edges[ix as usize].owners[0];
                let tolerance = tolerance.min(self.tolerance[owner.patch as usize]);
                let mut agree = keys.iter().enumerate().map(|(key, sides)| {
                    let owners = patches.side_curve(owner.patch, key, owner.side as usize)?;
                    same_curve(&sides[side], &owners, tolerance)
                });
                let reversed = agree.next()??;
                (keys.len() == patches.num_keys(owner.patch) && agree.all(|other| other == Some(reversed)))
                    .then_some((ix, reversed))
            };
            // All that were found so far, in their order.
            let (mut matched, mut last, mut next) = (None, None, (!is_new).then_some(first));
            while let Some(ix) = next {
                matched = matches(ix);
                last = next;
                next = self.next.get(&ix).copied().filter(|_| matched.is_none());
            }
            if let (None, Some(last)) = (matched, last) {
                self.next.insert(last, next_edge);
            }
            let (edge, reversed) = matched.unwrap_or_else(|| {
                let along = Along::default();
                table.edges.push(Edge {
                    owners: [Owner { patch, side: side as u8, along }; 2],
                    halved: false,
                    users: 0,
                    corners: [from, to],
                    middle: u32::MAX,
                    fineness: rate,
                });
                (table.edges.len() as u32 - 1, false)
            });
            table.use_edge(edge, rate);
            EdgeUse { edge, along: Along { part: Part::Whole, reversed } }
        });
        self.keys = keys;
        (corners, uses)
    }

    /// How far the border of a patch as its owners draw it may be from its own.
    fn slack(&self, patches: &PatchTable, table: &EdgeTable, ix: usize) -> f32 {
        let patch = &patches.patches[ix];
        let agrees = |(key, mine): (usize, Sides)| {
            let edges_agree = (0..4).all(|side| {
                let used = patch.edges[side];
                let owner = table.edges[used.edge as usize].owners[0];
                let curve = patches.side_curve(owner.patch, key, owner.side as usize).map(|mut curve| {
                    if used.along.reversed {
                        curve.reverse();
                    }
                    curve
                });
                curve == Some(mine[side])
            });
            let corners_agree = (0..4).all(|c| {
                let corner = &table.corners[patch.corners[c] as usize];
                let [side, end] = CORNER_ENDS[corner.corner as usize];
                let curve = patches.side_curve(corner.owner, key, side);
                curve.map(|curve| curve[end]) == Some(end_of(&mine, c))
            });
            edges_agree && corners_agree
        };
        let all_agree = sides(patches, ix as u32).enumerate().all(agrees);
        if all_agree { 0.0 } else { 2.0 * self.tolerance[ix] }
    }
}

/// The curves of a patch's sides at one key.
type Sides = [[Vec4; 4]; 4];

/// The sides of a patch, key after key; none without control points.
fn sides(table: &PatchTable, patch: u32) -> impl Iterator<Item = Sides> + '_ {
    (0..table.num_keys(patch)).map_while(move |key| {
        let surface = table.control_surface(&table.patches[patch as usize], key)?;
        Some(std::array::from_fn(|side| surface.side_curve(side)))
    })
}

/// How close points of a patch have to be to be one.
fn tolerance(table: &PatchTable, patch: &Patch) -> f32 {
    let Some(surface) = table.control_surface(patch, 0) else { return 0.0 };
    let mut bounds = Aabb::EMPTY;
    surface.hull([0.0, 1.0], [0.0, 1.0], |p| bounds.include(p));
    bounds.diagonal() * WELD_TOLERANCE
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
