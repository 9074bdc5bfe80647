//! Lattice: the places on a patch that a grid asks for.
//!
//! In: `Piece` whose lattice is decided. Out: (u, v) of the grid's vertices on the piece's own patch, which of them lie on
//! welded edges and corners, and the ghost places around them that normals need.
//!
//! A side with fewer segments than the lattice has its vertices used more than once, so that the grid's border is exactly
//! the edge's polyline: some micropolygons collapse to triangles or to nothing, and no T-junction opens.
//!
//! ```text
//!        g  g  g       g: ghosts, where the surface goes on beyond the side
//!     g  v  v  v  g    v: vertices, numbered from the lower left, row after row
//!     g  v  v  v  g
//!        g  g  g
//! ```

use crate::geometry::lanes::SLACK;
use crate::math::Vec3s;
use crate::math::simd::SimdLevel;

use super::piece::{Line, Piece, PieceKind, PointRef, Sabotage, Side, quad_uv, snapped};
use super::split::SplitContext;

/// Places on one patch; used again for every grid.
#[derive(Debug, Default)]
pub struct Lattice {
    /// Vertices of a row.
    pub columns: usize,
    /// Rows of vertices.
    pub rows: usize,
    /// u of all places: one a vertex, row after row, then ghosts, then those on other patches.
    pub u: Vec<f32>,
    /// v of all places.
    pub v: Vec<f32>,
    /// Places of the lattice itself; those behind them are on other patches.
    pub own: usize,
    /// Vertices that edges keep from where the lattice has them, and where they are instead.
    pub snapped: Vec<(u32, [f32; 2])>,
    /// Vertices that do not lie at their own places, or on welded edges and corners, side after side.
    pub border: Vec<(u32, PointRef)>,
    /// For each vertex of the bottom, right, top and left side, where the lattice goes on: a ghost, or the vertex itself.
    /// Empty without a ring.
    beyond: [Vec<u32>; 4],
    /// Which of them have ghosts.
    ghosts: [bool; 4],
    is_straight: bool,
    column_u: Vec<f32>,
    row_v: Vec<f32>,
    /// u and v of the bottom and the top of the quad, at each column.
    ends: [[Vec<f32>; 2]; 2],
}

/// The lattice of a piece.
#[derive(Clone, Copy)]
struct Block {
    m: u16,
    n: u16,
    i: [u16; 2],
    j: [u16; 2],
}

impl Block {
    fn of(piece: &Piece) -> Self {
        let PieceKind::Lattice { m, n, i, j } = piece.kind else {
            unreachable!("only pieces with a lattice are diced");
        };
        Block { m, n, i, j }
    }

    /// (u, v) of a lattice point, which may lie beyond the block.
    fn uv(&self, piece: &Piece, column: i32, row: i32) -> [f32; 2] {
        quad_uv(&piece.uv, column as f32 / f32::from(self.m), row as f32 / f32::from(self.n))
    }
}

impl Lattice {
    /// Number of vertices.
    pub fn num_vertices(&self) -> usize {
        self.columns * self.rows
    }

    /// A place.
    #[inline(always)]
    pub fn place(&self, place: u32) -> [f32; 2] {
        [self.u[place as usize], self.v[place as usize]]
    }

    /// Replaces all places by the vertices of `piece`, with ghosts around them for a ring.
    pub fn set(&mut self, context: &SplitContext, piece: &Piece, ring: bool) {
        let block = Block::of(piece);
        self.set_vertices(context.surfaces.level, piece, block);
        self.border.clear();
        self.snapped.clear();
        self.beyond.iter_mut().for_each(Vec::clear);
        if context.sabotage != Some(Sabotage::Snap) {
            for side in 0..4 {
                self.snap(context, piece, block, side);
            }
        }
        if ring {
            self.add_ghosts(piece, block);
        } else {
            for &(vertex, [u, v]) in &self.snapped {
                (self.u[vertex as usize], self.v[vertex as usize]) = (u, v);
            }
            // Points inside the patch are where they are asked for.
            self.border.retain(|(_, point)| !matches!(point, PointRef::Inside(_)));
        }
        self.own = self.u.len();
    }

    fn set_vertices(&mut self, level: SimdLevel, piece: &Piece, block: Block) {
        let Block { m, n, i, j } = block;
        self.columns = usize::from(i[1] - i[0]) + 1;
        self.rows = usize::from(j[1] - j[0]) + 1;
        // What `quad_uv` says, with that part of it that columns have alike computed once.
        let [bottom, top] = &mut self.ends;
        for (ends, [from, to]) in [(&mut *bottom, [0, 1]), (&mut *top, [2, 3])] {
            let [from, to] = [piece.uv[from], piece.uv[to]];
            let at = |column: u16, c: usize| from[c] + (to[c] - from[c]) * (f32::from(column) / f32::from(m));
            for (c, ends) in ends.iter_mut().enumerate() {
                ends.clear();
                ends.extend((i[0]..=i[1]).map(|column| at(column, c)));
            }
        }
        let alike = |values: &[f32]| values.iter().all(|value| *value == values[0]);
        self.is_straight = bottom[0] == top[0] && alike(&bottom[1]) && alike(&top[1]);
        let (columns, rows) = (self.columns, self.rows);
        for (c, places) in [&mut self.u, &mut self.v].into_iter().enumerate() {
            places.clear();
            places.resize(columns * rows, 0.0);
            let (bottom, top) = (&bottom[c][..], &top[c][..]);
            level.run(
                #[inline(always)]
                || {
                    for (row, places) in (j[0]..=j[1]).zip(places.chunks_exact_mut(columns)) {
                        let b = f32::from(row) / f32::from(n);
                        for ((place, bottom), top) in places.iter_mut().zip(bottom).zip(top) {
                            *place = bottom + (top - bottom) * b;
                        }
                    }
                },
            );
        }
        self.column_u.clear();
        self.row_v.clear();
        if self.is_straight {
            self.column_u.extend_from_slice(&self.u[..columns]);
            self.column_u.resize(columns + SLACK, 0.0);
            self.row_v.extend(self.v.iter().step_by(columns));
        }
    }

    /// Puts a place behind the others and gives its number.
    pub fn push(&mut self, [u, v]: [f32; 2]) -> u32 {
        self.u.push(u);
        self.v.push(v);
        self.u.len() as u32 - 1
    }

    /// Vertex `step` of the block's side 0: bottom, 1: right, 2: top, 3: left.
    fn on_side(&self, side: usize, step: usize) -> usize {
        match side {
            0 => step,
            1 => step * self.columns + self.columns - 1,
            2 => (self.rows - 1) * self.columns + step,
            _ => step * self.columns,
        }
    }

    /// Takes the vertices on a side of the quad from its edge. Corners belong to the bottom and the top.
    fn snap(&mut self, context: &SplitContext, piece: &Piece, block: Block, side: usize) {
        let Block { m, n, i, j } = block;
        let along_u = side == 0 || side == 2;
        let (lines, [from, to], is_there) = match side {
            0 => (m, i, j[0] == 0),
            1 => (n, [j[0].max(1), j[1].min(n - 1)], i[1] == m),
            2 => (m, i, j[1] == n),
            _ => (n, [j[0].max(1), j[1].min(n - 1)], i[0] == 0),
        };
        if !is_there {
            return;
        }
        let segments = piece.sides[side].segments();
        for line in from..=to {
            let step = line - if along_u { i[0] } else { j[0] };
            let vertex = self.on_side(side, step.into());
            let (point, uv) =
                context.side_vertex(piece.patch, &piece.sides[side], snapped(line, lines, segments));
            let is_snapped = uv != self.place(vertex as u32);
            if is_snapped {
                self.snapped.push((vertex as u32, uv));
            }
            let is_elsewhere = !matches!(point, PointRef::Inside(_)) || is_snapped;
            if is_elsewhere && context.sabotage != Some(Sabotage::Owner) {
                self.border.push((vertex as u32, point));
            }
        }
    }

    /// Adds the places around the vertices that normals of a displaced surface need.
    fn add_ghosts(&mut self, piece: &Piece, block: Block) {
        for side in 0..4 {
            let mut beyond = std::mem::take(&mut self.beyond[side]);
            let steps = if side % 2 == 0 { self.columns } else { self.rows };
            let goes_on = goes_on(&piece.sides[side], block, side);
            self.ghosts[side] = goes_on;
            for step in 0..steps {
                let vertex = self.on_side(side, step) as u32;
                let ghost = goes_on.then(|| self.ghost(piece, block, side, step)).flatten();
                beyond.push(ghost.map_or(vertex, |uv| self.push(uv)));
            }
            self.beyond[side] = beyond;
        }
    }

    /// Whether there are places for normals of a displaced surface.
    pub fn has_ring(&self) -> bool {
        !self.beyond[0].is_empty()
    }

    /// u of the columns, with [`SLACK`] more, and v of the rows, where columns have constant u and rows constant v before
    /// they are snapped.
    pub fn straight(&self) -> Option<[&[f32]; 2]> {
        self.is_straight.then_some([&self.column_u, &self.row_v])
    }

    /// (u, v) of the vertices, snapped to edges. With a ring, a vertex's place may be another: normals of a displaced
    /// surface come from points in even steps.
    pub fn vertex_uv(&self) -> Vec<[f32; 2]> {
        let mut uv: Vec<[f32; 2]> =
            (0..self.num_vertices() as u32).map(|vertex| self.place(vertex)).collect();
        self.snapped.iter().for_each(|&(vertex, at)| uv[vertex as usize] = at);
        uv
    }

    /// Vertices with what surrounds them, from values at all places: `columns + 2` a row, `rows + 2` rows, whose corners
    /// mean nothing. Where the surface ends, a vertex stands beyond itself.
    pub fn ring(&self, values: &Vec3s, ring: &mut Vec3s) {
        let (columns, width) = (self.columns, self.columns + 2);
        ring.set_len(width * (self.rows + 2));
        let last = self.num_vertices() - columns;
        // First place beyond each side, and the step to the next one.
        let sides = [(1, 1), (2 * width - 1, width), ((self.rows + 1) * width + 1, 1), (width, width)];
        for (to, from) in ring.axes_mut().into_iter().zip(values.axes()) {
            let rows = from.chunks_exact(columns).take(self.rows);
            for (to, from) in to[width..].chunks_exact_mut(width).zip(rows) {
                to[1..=columns].copy_from_slice(from);
                (to[0], to[columns + 1]) = (from[0], from[columns - 1]);
            }
            to[1..=columns].copy_from_slice(&from[..columns]);
            to[(self.rows + 1) * width + 1..][..columns].copy_from_slice(&from[last..][..columns]);
            let has_ghosts = |&(side, _): &(usize, _)| self.ghosts[side];
            for (side, (first, step)) in sides.into_iter().enumerate().filter(has_ghosts) {
                for (to, &place) in to[first..].iter_mut().step_by(step).zip(&self.beyond[side]) {
                    *to = from[place as usize];
                }
            }
        }
    }

    /// Takes what belongs to the vertices out of a list that [`Self::ring`] has made the places for.
    pub fn without_ring(&self, ring: &Vec3s, values: &mut Vec3s) {
        let (columns, width) = (self.columns, self.columns + 2);
        for (to, from) in values.axes_mut().into_iter().zip(ring.axes()) {
            for (to, from) in to.chunks_exact_mut(columns).zip(from[width + 1..].chunks(width)) {
                to.copy_from_slice(&from[..columns]);
            }
        }
    }

    /// Calls `visit` with the number in the ring of every vertex, in order.
    pub fn each_in_ring(&self, mut visit: impl FnMut(usize, usize)) {
        for row in 0..self.rows {
            for column in 0..self.columns {
                visit(row * self.columns + column, (row + 1) * (self.columns + 2) + column + 1);
            }
        }
    }

    /// Calls `visit` with each ghost and the vertex that it is next to.
    pub fn each_ghost(&self, mut visit: impl FnMut(usize, usize)) {
        for (side, beyond) in self.beyond.iter().enumerate() {
            for (step, &place) in beyond.iter().enumerate() {
                if place as usize >= self.num_vertices() {
                    visit(self.on_side(side, step), place as usize);
                }
            }
        }
    }

    /// The place next to a side, unless it lies beyond the patch.
    fn ghost(&self, piece: &Piece, block: Block, side: usize, step: usize) -> Option<[f32; 2]> {
        let (i, j) = (block.i.map(i32::from), block.j.map(i32::from));
        let step = step as i32;
        let (column, row) = match side {
            0 => (i[0] + step, j[0] - 1),
            1 => (i[1] + 1, j[0] + step),
            2 => (i[0] + step, j[1] + 1),
            _ => (i[0] - 1, j[0] + step),
        };
        let uv = block.uv(piece, column, row);
        // A rounding beyond the patch still counts as on it.
        uv.iter().all(|&c| (-1e-5..=1.0 + 1e-5).contains(&c)).then(|| uv.map(|c| c.clamp(0.0, 1.0)))
    }
}

/// Whether the patch goes on beyond a side of a block.
fn goes_on(of_quad: &Side, block: Block, side: usize) -> bool {
    let Block { m, n, i, j } = block;
    let is_within = [j[0] > 0, i[1] < m, j[1] < n, i[0] > 0][side];
    is_within || matches!(of_quad.line, Line::Inner { .. })
}
