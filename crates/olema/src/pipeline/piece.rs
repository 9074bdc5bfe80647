//! Pieces: parts of patches, as `split` cuts them and `dice` takes them.
//!
//! A [`Piece`] is a quad in a patch's (u, v) with its four sides, or a block of a lattice over one. It holds no
//! geometry: a side says which line it is part of, and a point of it is computed from that line alone.

use super::rate::Rate;

/// A point that every piece touching it computes alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PointRef {
    /// A welded corner.
    Corner(u32),
    /// An inner point of a welded edge, at `numerator / denominator` in the owner's direction.
    Edge {
        /// The edge.
        edge: u32,
        /// Parameter's numerator.
        numerator: u64,
        /// Parameter's denominator.
        denominator: u64,
    },
    /// A point inside the patch.
    Inside([f32; 2]),
}

/// The line that a side lies on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Line {
    /// A welded edge, which is side `side` of this patch.
    Border {
        /// The edge.
        edge: u32,
        /// The patch's own side.
        side: u8,
    },
    /// A straight line in (u, v) that an earlier split drew.
    Inner {
        /// Its ends in (u, v).
        uv: [[f32; 2]; 2],
        /// Its ends, which lie on other lines.
        ends: [PointRef; 2],
    },
}

/// One side of a piece: vertices `first..=last` of one halving of a line, whose own direction may be against
/// the piece's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Side {
    /// The line.
    pub line: Line,
    /// How often the line was halved.
    pub level: u8,
    /// Which of the 2^level parts of the line.
    pub part: u32,
    /// How often the piece's side was cut, halvings of the line it grew from included: bounds the recursion.
    pub cuts: u8,
    /// How that part is cut.
    pub rate: Rate,
    /// First vertex of that part that belongs to the side; 0 where the rate is not even.
    pub first: u32,
    /// Last vertex, at least `first`; 1 where the rate is not even.
    pub last: u32,
    /// Whether the piece runs along it from `last` to `first`.
    pub reversed: bool,
}

impl Side {
    /// Segments of the side.
    pub fn segments(&self) -> u32 {
        self.last - self.first
    }

    /// Parameter along the line, as a fraction, of the side's vertex `step` (0..=segments) in the piece's
    /// direction.
    pub fn fraction(&self, step: u32) -> (u64, u64) {
        let vertex = if self.reversed { self.last - step } else { self.first + step };
        let k = if let Rate::Even(k) = self.rate { k } else { 1 };
        (u64::from(self.part) * u64::from(k) + u64::from(vertex), u64::from(k) << self.level)
    }
}

/// A quotient of integers as a parameter: the same bits for the same rational number.
pub fn parameter(numerator: u64, denominator: u64) -> f32 {
    (numerator as f64 / denominator as f64) as f32
}

/// What a piece is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PieceKind {
    /// A quad that is still to be judged.
    Quad,
    /// Columns `i[0]..i[1]` and rows `j[0]..j[1]` of an m x n lattice over the quad.
    Lattice {
        /// Columns of the whole lattice.
        m: u16,
        /// Rows of the whole lattice.
        n: u16,
        /// First and last column line of this block.
        i: [u16; 2],
        /// First and last row line.
        j: [u16; 2],
    },
}

/// A part of a patch: a quad in its (u, v), or a block of the lattice over one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    /// Patch in the table.
    pub patch: u32,
    /// Halves taken so far: a leading 1, then a bit each.
    pub path: u128,
    /// Quad or block of a lattice.
    pub kind: PieceKind,
    /// Corners (0,0), (1,0), (0,1), (1,1) in the patch's (u, v).
    pub uv: [[f32; 2]; 4],
    /// Sides 0: bottom, 1: right, 2: top, 3: left; bottom and top run left to right, the others upwards.
    pub sides: [Side; 4],
}

/// (u, v) at (a, b) in [0, 1]^2 of a quad with corners (0,0), (1,0), (0,1), (1,1).
#[inline(always)]
pub fn quad_uv(uv: &[[f32; 2]; 4], a: f32, b: f32) -> [f32; 2] {
    std::array::from_fn(|c| {
        let bottom = uv[0][c] + (uv[1][c] - uv[0][c]) * a;
        let top = uv[2][c] + (uv[3][c] - uv[2][c]) * a;
        bottom + (top - bottom) * b
    })
}

/// Smallest box in (u, v) that holds the piece's vertices: `[u0, u1]`, `[v0, v1]`. A block of a lattice has vertices of the
/// quad's sides where these have them, which is not where its own lines end.
pub fn uv_box(piece: &Piece) -> ([f32; 2], [f32; 2]) {
    let mut ranges = [[1.0f32, 0.0f32]; 2];
    let mut include = |uv: [f32; 2]| {
        for (range, c) in ranges.iter_mut().zip(uv) {
            *range = [range[0].min(c), range[1].max(c)];
        }
    };
    match piece.kind {
        PieceKind::Quad => piece.uv.into_iter().for_each(include),
        PieceKind::Lattice { m, n, i, j } => {
            for (column, row) in i.into_iter().flat_map(|column| j.map(|row| (column, row))) {
                include(quad_uv(&piece.uv, f32::from(column) / f32::from(m), f32::from(row) / f32::from(n)));
            }
            let part = |side: usize, line: u16, lines: u16| {
                let segments = piece.sides[side].segments();
                snapped(line, lines, segments) as f32 / segments.max(1) as f32
            };
            for (side, is_there, b) in [(0, j[0] == 0, 0.0), (2, j[1] == n, 1.0)] {
                for column in i.into_iter().filter(|_| is_there) {
                    include(quad_uv(&piece.uv, part(side, column, m), b));
                }
            }
            for (side, is_there, a) in [(3, i[0] == 0, 0.0), (1, i[1] == m, 1.0)] {
                for row in j.into_iter().filter(|_| is_there) {
                    include(quad_uv(&piece.uv, a, part(side, row, n)));
                }
            }
        }
    }
    (ranges[0], ranges[1])
}

/// Vertex round(line * segments / lines) of a side: every edge vertex is hit, in order, some of them twice.
pub fn snapped(line: u16, lines: u16, segments: u32) -> u32 {
    if u32::from(lines) == segments {
        return line.into();
    }
    let (line, lines, segments) = (u64::from(line), u64::from(lines), u64::from(segments));
    ((2 * line * segments + lines) / (2 * lines)) as u32
}

/// Rules that keep surfaces watertight, each of which the crack test breaks once to show that it would notice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sabotage {
    /// A grid's border takes points at its own steps, not the edge's vertices.
    Snap,
    /// Border points come from the grid's own patch, not from the owner.
    Owner,
    /// An edge's rate follows the patch that asks, not the finest of its patches.
    Rate,
    /// Filter widths at borders follow the patch that asks.
    Width,
    /// Normals at borders are those of the patch that asks.
    Normal,
    /// An edge beside an n-gon is not halved first.
    Middle,
    /// Points are displaced along normals estimated from neighbouring points of the same patch, not along exact
    /// ones (what Sattlecker 2015, section 3.2, shows to open holes).
    EstimatedNormals,
    /// Each primitive keeps its own key times, not those of all that it is welded to.
    KeyTimes,
}
