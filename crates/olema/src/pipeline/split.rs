//! Split: cut a [`Piece`] that is too big to dice.
//!
//! In: one `Piece`, a quad in a patch's (u, v) with references to its four sides. Out: the plan to dice it, or
//! two pieces that cover it exactly. No geometry is copied.
//!
//! A piece is cut along the line between two *existing* vertices of opposite sides (so not always along a line
//! of constant u or v), and the new inner line belongs to both halves. A side remembers the edge it is part of
//! as (edge, halving, k, first, last), never as (start, end): vertex i of an edge is the same bits whoever asks.
//! Where a side has a single segment and the opposite one must be cut, one half keeps that segment and the
//! other is left with its first vertex only (a side without length). Source: Cook et al. 1987, section 3;
//! DiagSplit (Fisher et al. 2009).

use std::cell::RefCell;
use std::sync::Arc;

use crate::geometry::RasterCamera;

use super::bound::Hulls;
use super::dice::PrimitiveInfo;
use super::edges::{EdgeTable, Part};
use super::measure::Places;
use super::patch::{CORNER_UV, Patch, PatchTable, Surfaces, side_uv};
use super::piece::{Line, Piece, PieceKind, PointRef, Sabotage, Side, parameter};
use super::rate::{Fineness, MAX_LEVEL, Rate};
use super::recent::Recent;

/// What becomes of a piece.
#[allow(clippy::large_enum_variant)] // Lives on the stack between two stages only.
#[derive(Debug, Clone, Copy)]
pub enum Fate {
    /// It is small enough: dice it.
    Dice(Piece),
    /// It was cut.
    Split([Piece; 2]),
}

/// Micropolygons that a cut must save where opposite sides have different numbers of segments. A grid more costs as much
/// time as some 16; the rest is for micropolygons that are as large as the shading rate says.
const TAPER_MICROPOLYGONS: u32 = 8;

/// What splitting needs to know of the frame; one a worker.
pub struct SplitContext<'a> {
    /// Patches.
    pub patches: &'a PatchTable,
    /// The same patches, ready to evaluate.
    pub surfaces: Surfaces<'a>,
    /// Edges.
    pub edges: &'a EdgeTable,
    /// The camera.
    pub camera: &'a RasterCamera,
    /// Factor on every shading rate.
    pub rate_scale: f32,
    /// Most micropolygons in a grid.
    pub grid_size: u32,
    /// How often an edge through the eye plane is halved.
    pub eye_splits: u8,
    /// How finely each primitive is diced, with all factors but [`Self::rate_scale`].
    pub fineness: &'a [Fineness],
    /// All primitives.
    pub infos: &'a [Arc<PrimitiveInfo>],
    /// A rule to break on purpose; `None` outside tests.
    pub sabotage: Option<Sabotage>,
    /// Lists to measure with.
    pub places: RefCell<Places>,
    /// Lists to bound with.
    pub hulls: RefCell<Hulls>,
    /// What was measured of pieces, by patch and path; nothing is remembered where there is no room.
    pub judged: RefCell<Recent<(u32, u128), Judged>>,
}

/// What splitting measured of a piece.
#[derive(Debug, Clone, Copy, Default)]
pub struct Judged {
    /// Rate of the line that it was cut along.
    cut: Option<Rate>,
    /// Segments that its inside asks for.
    inside: Option<[u32; 2]>,
}

/// Pieces of which a worker remembers that, as a power of two.
pub const JUDGED_LOG: u32 = 12;

/// Splits are not nested deeper than this; what is left is diced as a lattice.
const MAX_DEPTH: u32 = 120;

/// Most lattice lines each way.
const MAX_LATTICE: u32 = 65_000;

impl<'a> SplitContext<'a> {
    pub(super) fn patch(&self, ix: u32) -> &'a Patch {
        &self.patches.patches[ix as usize]
    }

    /// The whole of a patch.
    pub fn whole(&self, patch_ix: u32) -> Piece {
        let patch = self.patch(patch_ix);
        let sides = std::array::from_fn(|side| {
            let used = patch.edges[side];
            let line = Line::Border { edge: used.edge, side: side as u8 };
            let (level, part) = match used.along.part {
                Part::Whole => (0, 0),
                Part::First => (1, 0),
                Part::Second => (1, 1),
            };
            self.part_of_line(patch_ix, line, [level, level], part, used.along.reversed)
        });
        Piece { patch: patch_ix, path: 1, kind: PieceKind::Quad, uv: CORNER_UV, sides }
    }

    /// A whole part of a line, as a side. `cuts` bounds further halving; it is a function of the line alone
    /// (its level, and for an inner line what its parallel sides had when it was drawn).
    fn part_of_line(
        &self,
        patch: u32,
        line: Line,
        [level, cuts]: [u8; 2],
        part: u32,
        reversed: bool,
    ) -> Side {
        // Another patch ends at the edge's middle.
        let is_halved = self.is_halved(line) && self.sabotage != Some(Sabotage::Middle);
        let measure = || self.measure(patch, line, [level.into(), part]);
        let measured = match line {
            _ if level == 0 && is_halved => Rate::Uneven,
            Line::Border { edge, .. } if self.sabotage.is_none() => {
                self.edges.known.rate(edge, is_halved, [level.into(), part], measure)
            }
            _ => measure(),
        };
        self.side(line, [level, cuts], part, reversed, measured)
    }

    /// A whole part of a line whose rate was measured.
    fn side(&self, line: Line, [level, cuts]: [u8; 2], part: u32, reversed: bool, measured: Rate) -> Side {
        let rate = match measured {
            Rate::Eye if cuts >= self.eye_splits => Rate::Even(1),
            Rate::Uneven if cuts >= MAX_LEVEL => Rate::Even(1),
            other => other,
        };
        let last = if let Rate::Even(k) = rate { k } else { 1 };
        Side { line, level, part, cuts, rate, first: 0, last, reversed }
    }

    fn is_halved(&self, line: Line) -> bool {
        matches!(line, Line::Border { edge, .. } if self.edges.edges[edge as usize].halved)
    }

    /// Whether the side was given one segment because it reaches the eye plane (for the statistics).
    pub fn stops_at_eye(&self, side: &Side) -> bool {
        side.cuts >= self.eye_splits && side.rate == Rate::Even(1)
    }

    /// The point at `numerator / denominator` of a line.
    pub(super) fn point_on(&self, patch: u32, line: Line, numerator: u64, denominator: u64) -> PointRef {
        match line {
            Line::Border { edge, .. } => {
                let known = &self.edges.edges[edge as usize];
                match numerator {
                    0 => PointRef::Corner(known.corners[0]),
                    n if n == denominator => PointRef::Corner(known.corners[1]),
                    n if known.halved && 2 * n == denominator => PointRef::Corner(known.middle),
                    _ => PointRef::Edge { edge, numerator, denominator },
                }
            }
            Line::Inner { ends, .. } if numerator == 0 => ends[0],
            Line::Inner { ends, .. } if numerator == denominator => ends[1],
            Line::Inner { .. } => PointRef::Inside(self.line_uv(patch, line, numerator, denominator)),
        }
    }

    /// The patch's own (u, v) at `numerator / denominator` of a line.
    fn line_uv(&self, patch: u32, line: Line, numerator: u64, denominator: u64) -> [f32; 2] {
        match line {
            Line::Border { side, .. } => {
                let along = self.patch(patch).edges[side as usize].along;
                let (numerator, denominator) = along.own(numerator, denominator);
                side_uv(side as usize, parameter(numerator, denominator))
            }
            Line::Inner { uv: [from, to], .. } => {
                let t = parameter(numerator, denominator);
                std::array::from_fn(|c| {
                    if numerator == denominator { to[c] } else { from[c] + (to[c] - from[c]) * t }
                })
            }
        }
    }

    /// Vertex `step` (0..=segments) of a piece's side: the point, and the patch's own (u, v) there.
    pub fn side_vertex(&self, patch: u32, side: &Side, step: u32) -> (PointRef, [f32; 2]) {
        let (numerator, denominator) = side.fraction(step);
        (
            self.point_on(patch, side.line, numerator, denominator),
            self.line_uv(patch, side.line, numerator, denominator),
        )
    }

    /// The patch that a point is evaluated on, and where: its owner's, or `patch` inside it.
    pub fn place(&self, patch: u32, point: PointRef) -> (u32, [f32; 2]) {
        match point {
            PointRef::Corner(corner) => {
                let corner = self.edges.corners[corner as usize];
                (corner.owner, CORNER_UV[corner.corner as usize])
            }
            PointRef::Edge { edge, numerator, denominator } => {
                let second_half = 2 * numerator > denominator;
                let owner = self.edges.edges[edge as usize].owners[usize::from(second_half)];
                let (numerator, denominator) = owner.along.own(numerator, denominator);
                (owner.patch, side_uv(owner.side as usize, parameter(numerator, denominator)))
            }
            PointRef::Inside(uv) => (patch, uv),
        }
    }

    /// Whether [`Self::fate`] cuts `piece`, where that can be told without evaluating anything.
    pub fn is_surely_split(&self, piece: &Piece) -> bool {
        if let PieceKind::Lattice { i, j, .. } = piece.kind {
            return u32::from(i[1] - i[0]) * u32::from(j[1] - j[0]) > self.grid_size;
        }
        let is_even = |side: &Side| matches!(side.rate, Rate::Even(_));
        let [u, v] = segments(piece);
        let big = u64::from(u.max(1)) * u64::from(v.max(1)) > u64::from(self.grid_size) && u.max(v) >= 2;
        piece.path.ilog2() < MAX_DEPTH && (big || !piece.sides.iter().all(is_even))
    }

    /// Decides whether `piece` is diced, and how finely, or cuts it.
    pub fn fate(&self, piece: &Piece) -> Fate {
        if let PieceKind::Lattice { m, n, i, j } = piece.kind {
            return self.lattice_fate(piece, [m, n], i, j);
        }
        let [bottom, right, top, left] = &piece.sides;
        let uneven = |a: &Side, b: &Side| !matches!((a.rate, b.rate), (Rate::Even(_), Rate::Even(_)));
        let (across_u, across_v) = (uneven(bottom, top), uneven(right, left));
        let deep = piece.path.ilog2() >= MAX_DEPTH;
        let [u_segments, v_segments] = segments(piece);
        if !deep && (across_u || across_v) {
            // The direction that is known to be long goes first, so that halves stay compact.
            let along_u = if across_u && across_v { self.is_wider(piece) } else { across_u };
            return Fate::Split(self.cut(piece, along_u));
        }
        let big = u64::from(u_segments.max(1)) * u64::from(v_segments.max(1)) > u64::from(self.grid_size);
        if !deep && big && u_segments.max(v_segments) >= 2 {
            return Fate::Split(self.cut(piece, u_segments >= v_segments));
        }
        let [m, n] = self.lattice_size(piece, [u_segments, v_segments]);
        if !deep && m * n > self.grid_size && u_segments.max(v_segments) >= 2 {
            let along_u = if u_segments < 2 { false } else { v_segments < 2 || m >= n };
            return Fate::Split(self.cut(piece, along_u));
        }
        if let Some(along_u) = tapers(piece, [m, n]).filter(|_| !deep) {
            return Fate::Split(self.cut(piece, along_u));
        }
        let [m, n] = [m, n].map(|s| s as u16);
        let lattice = Piece { kind: PieceKind::Lattice { m, n, i: [0, m], j: [0, n] }, ..*piece };
        self.lattice_fate(&lattice, [m, n], [0, m], [0, n])
    }

    /// Dices a block of a lattice that fits a grid, or halves it along a lattice line.
    fn lattice_fate(&self, piece: &Piece, [m, n]: [u16; 2], i: [u16; 2], j: [u16; 2]) -> Fate {
        let (columns, rows) = (i[1] - i[0], j[1] - j[0]);
        if u32::from(columns) * u32::from(rows) <= self.grid_size {
            return Fate::Dice(*piece);
        }
        let block = |i: [u16; 2], j: [u16; 2]| Piece { kind: PieceKind::Lattice { m, n, i, j }, ..*piece };
        if columns >= rows {
            let middle = i[0] + columns / 2;
            Fate::Split([block([i[0], middle], j), block([middle, i[1]], j)])
        } else {
            let middle = j[0] + rows / 2;
            Fate::Split([block(i, [j[0], middle]), block(i, [middle, j[1]])])
        }
    }

    /// Lattice lines that the sides and the interior ask for.
    fn lattice_size(&self, piece: &Piece, segments: [u32; 2]) -> [u32; 2] {
        let measure = || self.inner_segments(piece).map(|wanted| wanted.min(MAX_LATTICE));
        let wanted = match piece.path {
            1 => self.edges.known.inner_segments(piece.patch, measure),
            _ => self.judged(piece, |judged| &mut judged.inside, measure),
        };
        std::array::from_fn(|axis| segments[axis].max(1).max(wanted[axis]).min(MAX_LATTICE))
    }

    /// What was measured of a piece, or is measured now.
    fn judged<T: Copy>(
        &self,
        piece: &Piece,
        what: fn(&mut Judged) -> &mut Option<T>,
        measure: impl FnOnce() -> T,
    ) -> T {
        let name = (piece.patch, piece.path);
        let mut known = self.judged.borrow().get(&name).copied().unwrap_or_default();
        if let Some(measured) = *what(&mut known) {
            return measured;
        }
        let measured = measure();
        *what(&mut known) = Some(measured);
        self.judged.borrow_mut().put(name, known);
        measured
    }

    /// Whether the piece spans more of u than of v, where lengths on screen are not known.
    fn is_wider(&self, piece: &Piece) -> bool {
        let corner = piece.uv.map(|uv| self.surfaces.position(piece.patch, 0, uv));
        let width = (corner[1] - corner[0]).length() + (corner[3] - corner[2]).length();
        let height = (corner[2] - corner[0]).length() + (corner[3] - corner[1]).length();
        if width == height { piece.sides[0].level <= piece.sides[1].level } else { width > height }
    }

    /// Cuts a quad across its bottom and top (`along_u`) or across its left and right side.
    fn cut(&self, piece: &Piece, along_u: bool) -> [Piece; 2] {
        let (a, b) = if along_u { (0, 2) } else { (3, 1) };
        let (a_halves, a_point, a_uv) = self.halve(piece.patch, &piece.sides[a]);
        let (b_halves, b_point, b_uv) = self.halve(piece.patch, &piece.sides[b]);
        let line = Line::Inner { uv: [a_uv, b_uv], ends: [a_point, b_point] };
        let parallel = if along_u { [3, 1] } else { [0, 2] };
        let cuts = parallel.map(|side| piece.sides[side].cuts);
        // The line is the same whenever this piece is cut.
        let rate = self.judged(piece, |judged| &mut judged.cut, || self.measure(piece.patch, line, [0, 0]));
        let inner = self.side(line, [0, cuts[0].max(cuts[1])], 0, false, rate);
        let [uv00, uv10, uv01, uv11] = piece.uv;
        let [bottom, right, top, left] = piece.sides;
        let (uv, sides) = if along_u {
            (
                [[uv00, a_uv, uv01, b_uv], [a_uv, uv10, b_uv, uv11]],
                [[a_halves[0], inner, b_halves[0], left], [a_halves[1], right, b_halves[1], inner]],
            )
        } else {
            (
                [[uv00, uv10, a_uv, b_uv], [a_uv, b_uv, uv01, uv11]],
                [[bottom, b_halves[0], inner, a_halves[0]], [inner, b_halves[1], top, a_halves[1]]],
            )
        };
        std::array::from_fn(|half| Piece {
            path: piece.path * 2 + half as u128,
            uv: uv[half],
            sides: sides[half],
            ..*piece
        })
    }

    /// Both halves of a side in the piece's direction, and the point between them.
    fn halve(&self, patch: u32, side: &Side) -> ([Side; 2], PointRef, [f32; 2]) {
        if let Rate::Even(_) = side.rate {
            let middle = side.first + side.segments() / 2;
            let cuts = side.cuts.saturating_add(1);
            let lower = Side { last: middle, cuts, ..*side };
            let upper = Side { first: middle, cuts, ..*side };
            let halves = if side.reversed { [upper, lower] } else { [lower, upper] };
            let (point, uv) = self.side_vertex(patch, &halves[1], 0);
            return (halves, point, uv);
        }
        let next = [side.level + 1, side.cuts.saturating_add(1)];
        let part = |part| self.part_of_line(patch, side.line, next, part, side.reversed);
        let (lower, upper) = (part(side.part * 2), part(side.part * 2 + 1));
        let (numerator, denominator) = (u64::from(side.part) * 2 + 1, 2u64 << side.level);
        let point = self.point_on(patch, side.line, numerator, denominator);
        let uv = self.line_uv(patch, side.line, numerator, denominator);
        (if side.reversed { [upper, lower] } else { [lower, upper] }, point, uv)
    }
}

/// Whether a lattice of `size` has many micropolygons that only one of two opposite sides asks for, and if so whether the
/// piece is to be cut across its bottom and top. Halves between the ends of the sides that differ differ half as much.
fn tapers(piece: &Piece, [m, n]: [u32; 2]) -> Option<bool> {
    let [bottom, right, top, left] = piece.sides.map(|side| side.segments());
    let saved = |[a, b]: [u32; 2], [c, d]: [u32; 2], lines: u32| match c.max(d) >= 2 {
        true => a.abs_diff(b).saturating_mul(lines) / 4,
        false => 0,
    };
    let across_v = saved([bottom, top], [left, right], n);
    let across_u = saved([left, right], [bottom, top], m);
    (across_u.max(across_v) > TAPER_MICROPOLYGONS).then_some(across_u > across_v)
}

/// Segments of the longer of the sides along u, and along v.
fn segments(piece: &Piece) -> [u32; 2] {
    let [bottom, right, top, left] = &piece.sides;
    [bottom.segments().max(top.segments()), right.segments().max(left.segments())]
}
