//! Connect: find the edges and corners that patches share, before anything is diced.
//!
//! In: all patches of the frame. Out: `EdgeTable`; each patch learns its edges and corners. Points are welded
//! where they agree bit for bit or within a tolerance relative to the smaller of the two patches (the
//! teapot's patches touch without sharing points); from then on the owner's point stands for all.
//!
//! An edge is owned by the lowest patch that has it. Its tessellation is a function of the owner's curve, the
//! finest shading rate of all its patches and the camera, so both sides agree whatever else differs.

use std::collections::HashMap;

use glam::{Vec3, Vec4};

use crate::geometry::Aabb;

use super::patch::{PatchTable, SIDE_CORNERS};

/// Points closer than this times the smaller patch's diagonal are one point.
pub const WELD_TOLERANCE: f32 = 1e-5;

/// Rounding of an evaluated point, relative to the patch's largest coordinate.
const ROUNDING: f32 = 1e-6;

/// A patch's use of an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct EdgeUse {
    /// Index of the edge.
    pub edge: u32,
    /// Whether the patch runs along it against the owner.
    pub reversed: bool,
}

/// An edge, owned by one patch and shared by any number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// The patch whose curve it is.
    pub owner: u32,
    /// The owner's side.
    pub side: u8,
    /// How many patches have it.
    pub users: u32,
    /// Corners at its start and end.
    pub corners: [u32; 2],
    /// Finest shading rate of its patches (pixels of area).
    pub shading_rate: f32,
}

/// A corner, owned by one patch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Corner {
    /// The patch whose point it is.
    pub owner: u32,
    /// The owner's corner.
    pub corner: u8,
}

/// Edges and corners of all patches.
#[derive(Debug, Clone, Default)]
pub struct EdgeTable {
    /// Edges, in the order of their owners.
    pub edges: Vec<Edge>,
    /// Corners, in the order of their owners.
    pub corners: Vec<Corner>,
}

impl EdgeTable {
    /// Edges that two or more patches share.
    pub fn num_welds(&self) -> usize {
        self.edges.iter().filter(|e| e.users > 1).count()
    }
}

/// Connects all patches of `table`; `shading_rate[primitive]` is each primitive's rate.
pub fn connect(table: &mut PatchTable, shading_rate: &[f32]) -> EdgeTable {
    let curves = Curves::new(table);
    let (corners, corner_of) = weld_corners(table, &curves);
    let mut middles = Welder::new(curves.tolerances());
    let mut found: HashMap<(u32, u32, u32), Vec<u32>> = HashMap::new();
    let mut edges: Vec<Edge> = Vec::new();
    for (patch_ix, patch_curves) in curves.sides.iter().enumerate() {
        let patch_corners = corner_of[patch_ix];
        let rate = shading_rate[table.patches[patch_ix].primitive as usize];
        for (side, curve) in patch_curves.iter().enumerate() {
            let tolerance = curves.tolerance[patch_ix];
            let [from, to] = SIDE_CORNERS[side].map(|c| patch_corners[c]);
            let middle = middles.weld(curve_middle(curve), tolerance);
            let known = found.entry((from.min(to), from.max(to), middle)).or_default();
            let matched = known.iter().find_map(|&ix| {
                let edge = &edges[ix as usize];
                let owner_curve = &curves.sides[edge.owner as usize][edge.side as usize];
                let tolerance = tolerance.min(curves.tolerance[edge.owner as usize]);
                same_curve(curve, owner_curve, tolerance).map(|reversed| (ix, reversed))
            });
            let used = match matched {
                Some((edge, reversed)) => {
                    let known = &mut edges[edge as usize];
                    known.users += 1;
                    known.shading_rate = known.shading_rate.min(rate);
                    EdgeUse { edge, reversed }
                }
                None => {
                    let edge = edges.len() as u32;
                    known.push(edge);
                    edges.push(Edge {
                        owner: patch_ix as u32,
                        side: side as u8,
                        users: 1,
                        corners: [from, to],
                        shading_rate: rate,
                    });
                    EdgeUse { edge, reversed: false }
                }
            };
            table.patches[patch_ix].edges[side] = used;
        }
    }
    let table_edges = EdgeTable { edges, corners };
    for (patch_ix, corner_ixs) in corner_of.into_iter().enumerate() {
        let exact = is_exact(&curves, &table_edges, table, patch_ix, corner_ixs);
        let patch = &mut table.patches[patch_ix];
        patch.corners = corner_ixs;
        let weld = if exact { 0.0 } else { 2.0 * curves.tolerance[patch_ix] };
        patch.slack = weld + ROUNDING * curves.reach[patch_ix];
    }
    table_edges
}

/// Side curves of all patches at the first key, and how close is equal.
struct Curves {
    sides: Vec<[[Vec4; 4]; 4]>,
    tolerance: Vec<f32>,
    /// Largest coordinate of each patch.
    reach: Vec<f32>,
}

impl Curves {
    fn new(table: &PatchTable) -> Self {
        let mut curves = Curves { sides: Vec::new(), tolerance: Vec::new(), reach: Vec::new() };
        for patch in &table.patches {
            let surface = table.surface(patch, 0);
            let mut bounds = Aabb::EMPTY;
            surface.hull([0.0, 1.0], [0.0, 1.0], |p| bounds.include(p));
            curves.sides.push(std::array::from_fn(|side| surface.side_curve(side)));
            curves.reach.push(bounds.min.abs().max(bounds.max.abs()).max_element());
            curves.tolerance.push(bounds.diagonal() * WELD_TOLERANCE);
        }
        curves
    }

    fn tolerances(&self) -> impl Iterator<Item = f32> {
        self.tolerance.iter().copied()
    }
}

fn weld_corners(table: &PatchTable, curves: &Curves) -> (Vec<Corner>, Vec<[u32; 4]>) {
    let mut welder = Welder::new(curves.tolerances());
    let mut corners: Vec<Corner> = Vec::new();
    let mut corner_of = Vec::with_capacity(table.patches.len());
    for (ix, sides) in curves.sides.iter().enumerate() {
        let ends = [sides[0][0], sides[0][3], sides[2][0], sides[2][3]];
        corner_of.push(std::array::from_fn(|corner| {
            let id = welder.weld(project(ends[corner]), curves.tolerance[ix]);
            if id as usize == corners.len() {
                corners.push(Corner { owner: ix as u32, corner: corner as u8 });
            }
            id
        }));
    }
    (corners, corner_of)
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

/// Whether the patch's borders and corners are bit for bit those of their owners.
fn is_exact(curves: &Curves, table: &EdgeTable, patches: &PatchTable, ix: usize, corners: [u32; 4]) -> bool {
    let mine = &curves.sides[ix];
    let edges_agree = (0..4).all(|side| {
        let used = patches.patches[ix].edges[side];
        let edge = &table.edges[used.edge as usize];
        let mut owner = curves.sides[edge.owner as usize][edge.side as usize];
        if used.reversed {
            owner.reverse();
        }
        owner == mine[side]
    });
    let ends = [mine[0][0], mine[0][3], mine[2][0], mine[2][3]];
    edges_agree
        && (0..4).all(|c| {
            let corner = &table.corners[corners[c] as usize];
            let owner = &curves.sides[corner.owner as usize];
            [owner[0][0], owner[0][3], owner[2][0], owner[2][3]][corner.corner as usize] == ends[c]
        })
}

/// Points by the cell that holds them.
type Cells = HashMap<[i64; 3], Vec<u32>>;

/// Gives points that lie together one number.
///
/// Points are kept in one grid of cells per octave of tolerance. A pair is as close as the *smaller* of its two
/// tolerances asks, so a point is entered in the grids of its own octave and all finer ones that occur, and
/// looked up in its own and the finer ones. Cells hold only points that did not weld, so they stay short.
struct Welder {
    /// Octaves that occur, ascending, and their grids.
    octaves: Vec<(i32, Cells)>,
    exact: HashMap<[u32; 3], u32>,
    points: Vec<(Vec3, f32)>,
}

impl Welder {
    fn new(tolerances: impl Iterator<Item = f32>) -> Self {
        let mut octaves: Vec<i32> = tolerances.filter(|t| *t > 0.0).map(octave).collect();
        octaves.sort_unstable();
        octaves.dedup();
        Welder {
            octaves: octaves.into_iter().map(|o| (o, HashMap::new())).collect(),
            exact: HashMap::new(),
            points: Vec::new(),
        }
    }

    /// The number of `p`: that of the lowest point it welds to, or a new one.
    fn weld(&mut self, p: Vec3, tolerance: f32) -> u32 {
        // + 0.0 makes -0 and 0 one.
        let bits = (p + Vec3::ZERO).to_array().map(f32::to_bits);
        if let Some(&id) = self.exact.get(&bits) {
            return id;
        }
        let own = if tolerance > 0.0 { octave(tolerance) } else { i32::MIN };
        let near = self.octaves.iter().filter(|(o, _)| *o <= own).flat_map(|(o, cells)| {
            touched_cells(p, *o).filter_map(|cell| cells.get(&cell)).flatten().copied()
        });
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
                cells.entry(cell(p, *o)).or_default().push(id);
            }
            id
        });
        self.exact.insert(bits, id);
        id
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
