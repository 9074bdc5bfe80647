//! The tree of one base quad: pieces of its domain, refined on demand until they are splines.
//!
//! In: the [`Hood`] of a face. Out: jets at (u, v) and boxes of parts of the domain. A piece is refined when
//! something is asked of it that it cannot answer; a piece that is a B-spline (or box spline) answers
//! exactly. Pieces that never become splines shrink onto one extraordinary vertex; there the limit masks
//! answer. So depth follows from the question, and no crease is rounded by a depth fixed beforehand. What
//! the tree answers does not depend on what it was asked before.
//!
//! Tables of stored patches were the alternative: ten levels of patches around each extraordinary vertex
//! take 6 KB a corner, 36 MB for 1,600 faces. A tree is made again when its face is taken up again, at a few
//! microseconds, and a regular face needs only its 16 control points.

use glam::DVec3;

use super::bicubic::{Bicubic, Jet};
use super::box_spline::BoxSpline;
use super::hood::{Hood, Scratch};
use super::{limit, quad, triangle};
use crate::scene::CreaseMethod;

/// Levels after which a piece counts as its nearest corner. Around a vertex of valence 4 a piece is 1e-12 of
/// the face then, around one of the highest valence, which shrinks by 0.655 a level, 5e-8.
const MAX_DEPTH: u32 = 40;

/// Pieces kept before the tree starts again.
const MOST_PIECES: usize = 4096;

/// A piece of the domain.
#[derive(Debug, Clone)]
enum Piece {
    /// One B-spline a channel.
    Bicubic(Box<[Bicubic]>),
    /// One box spline a channel.
    BoxSpline(Box<[BoxSpline]>),
    /// Not (yet) a spline; children 0 to 3 follow each other in the tree once made.
    Hood { hood: Box<Hood>, children: Option<u32> },
}

/// A piece and its level below the root.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    piece: u32,
    depth: u32,
}

/// Pieces of one face or base quad.
#[derive(Debug, Clone)]
pub(super) struct Tree {
    pieces: Vec<Piece>,
    method: CreaseMethod,
    scratch: Scratch,
}

impl Tree {
    /// The tree over a neighbourhood: a quad, or a triangle under Loop.
    pub(super) fn new(root: &Hood, method: CreaseMethod) -> Tree {
        Tree { pieces: vec![piece(root)], method, scratch: Scratch::default() }
    }

    /// The tree over the base quad at a corner of a polygon.
    pub(super) fn of_corner(polygon: &Hood, corner: u32, method: CreaseMethod) -> Tree {
        let mut scratch = Scratch::default();
        quad::refine(polygon, method, &mut scratch.fine);
        quad::child(&mut scratch, corner as usize);
        Tree { pieces: vec![piece(&scratch.child)], method, scratch }
    }

    /// Finds the B-splines of a quad that points lie in: of each the piece, and where in that the point is, with no bit
    /// lost. `None` for points that are no spline's, but a corner's.
    pub(super) fn splines_at(&mut self, [u, v]: [&[f32]; 2], out: &mut Vec<Option<(Place, [f32; 2])>>) {
        self.trim();
        for (&u, &v) in u.iter().zip(v) {
            let found = self.spline_at([u, v]);
            out.push(found);
        }
    }

    fn spline_at(&mut self, [mut u, mut v]: [f32; 2]) -> Option<(Place, [f32; 2])> {
        let mut at = Place { piece: 0, depth: 0 };
        // As `quad_jet` goes.
        while let Piece::Hood { hood, .. } = &self.pieces[at.piece as usize] {
            let corner = [[0, 3], [1, 2]][usize::from(u >= 0.5)][usize::from(v >= 0.5)];
            let is_corner = (u == 0.0 || u == 1.0) && (v == 0.0 || v == 1.0);
            if at.depth >= MAX_DEPTH || is_corner && hood.has_mask(corner) {
                return None;
            }
            at = Place { piece: self.children(at.piece) + corner as u32, depth: at.depth + 1 };
            u = if u >= 0.5 { 2.0 * u - 1.0 } else { 2.0 * u };
            v = if v >= 0.5 { 2.0 * v - 1.0 } else { 2.0 * v };
        }
        Some((at, [u, v]))
    }

    /// The B-spline of a channel over a piece that [`Self::splines_at`] found, and the scale of its derivatives.
    pub(super) fn spline_of(&self, at: Place, channel: usize) -> Option<(&Bicubic, f64)> {
        match &self.pieces[at.piece as usize] {
            Piece::Bicubic(patches) => Some((&patches[channel], (1u64 << at.depth) as f64)),
            _ => None,
        }
    }

    /// The B-spline of a channel, if it is one over the whole domain.
    pub(super) fn spline(&self, channel: usize) -> Option<&Bicubic> {
        match &self.pieces[0] {
            Piece::Bicubic(patches) => Some(&patches[channel]),
            _ => None,
        }
    }

    /// Bytes of the pieces made so far.
    pub(super) fn num_bytes(&self) -> usize {
        let held = |piece: &Piece| match piece {
            Piece::Bicubic(patches) => size_of_val::<[Bicubic]>(patches),
            Piece::BoxSpline(patches) => size_of_val::<[BoxSpline]>(patches),
            Piece::Hood { hood, .. } => {
                size_of::<Hood>() + size_of_val(hood.points.as_slice()) + 4 * hood.sharpness.len()
            }
        };
        self.pieces.iter().map(|piece| size_of::<Piece>() + held(piece)).sum()
    }

    /// Forgets pieces when there are too many of them.
    fn trim(&mut self) {
        if self.pieces.len() > MOST_PIECES {
            self.pieces.truncate(1);
            if let Piece::Hood { children, .. } = &mut self.pieces[0] {
                *children = None;
            }
        }
    }

    /// First of the four children of a piece that is no spline.
    fn children(&mut self, ix: u32) -> u32 {
        let Piece::Hood { hood, children } = &self.pieces[ix as usize] else {
            unreachable!("a spline has no children");
        };
        if let Some(first) = *children {
            return first;
        }
        let is_loop = hood.rings[0].step == 1;
        let refine = if is_loop { triangle::refine } else { quad::refine };
        let child = if is_loop { triangle::child } else { quad::child };
        refine(hood, self.method, &mut self.scratch.fine);
        let first = self.pieces.len() as u32;
        for k in 0..4 {
            child(&mut self.scratch, k);
            self.pieces.push(piece(&self.scratch.child));
        }
        if let Piece::Hood { children, .. } = &mut self.pieces[ix as usize] {
            *children = Some(first);
        }
        first
    }

    /// The jet of a channel at (u, v) of a quad, each in [0, 1], and whether its derivatives are defined: at
    /// vertices without a tangent mask they are not.
    pub(super) fn quad_jet(&mut self, [mut u, mut v]: [f64; 2], channel: usize) -> (Jet, bool) {
        self.trim();
        let mut at = Place { piece: 0, depth: 0 };
        loop {
            match &self.pieces[at.piece as usize] {
                Piece::Bicubic(patches) => {
                    let scale = (1u64 << at.depth) as f64;
                    let jet = patches[channel].evaluate(u, v);
                    return (Jet { du: jet.du * scale, dv: jet.dv * scale, ..jet }, true);
                }
                Piece::BoxSpline(_) => unreachable!("a box spline in a tree of quads"),
                Piece::Hood { hood, .. } => {
                    let corner = [[0, 3], [1, 2]][usize::from(u >= 0.5)][usize::from(v >= 0.5)];
                    let is_corner = (u == 0.0 || u == 1.0) && (v == 0.0 || v == 1.0);
                    if at.depth >= MAX_DEPTH || is_corner && hood.has_mask(corner) {
                        let scale = (1u64 << at.depth) as f64;
                        let limit = limit::limit(hood, corner, channel);
                        let p = limit.p + hood.origins[channel];
                        let jet = quad_corner_jet(corner, p, limit.tangents, scale);
                        return (jet, limit.tangents.is_some());
                    }
                    at = Place { piece: self.children(at.piece) + corner as u32, depth: at.depth + 1 };
                    u = if u >= 0.5 { 2.0 * u - 1.0 } else { 2.0 * u };
                    v = if v >= 0.5 { 2.0 * v - 1.0 } else { 2.0 * v };
                }
            }
        }
    }

    /// As [`Tree::quad_jet`], for barycentric coordinates of a triangle and two directions in them.
    pub(super) fn triangle_jet(
        &mut self,
        mut b: [f64; 3],
        mut directions: [[f64; 3]; 2],
        channel: usize,
    ) -> (Jet, bool) {
        self.trim();
        let mut at = Place { piece: 0, depth: 0 };
        loop {
            match &self.pieces[at.piece as usize] {
                Piece::BoxSpline(patches) => {
                    return (patches[channel].evaluate(b, directions[0], directions[1]), true);
                }
                Piece::Bicubic(_) => unreachable!("a B-spline in a tree of triangles"),
                Piece::Hood { hood, .. } => {
                    let corner = (0..3).fold(0, |best, k| if b[k] > b[best] { k } else { best });
                    if at.depth >= MAX_DEPTH || b[corner] == 1.0 && hood.has_mask(corner) {
                        let limit = limit::limit(hood, corner, channel);
                        let p = limit.p + hood.origins[channel];
                        let mut jet = Jet { p, ..Jet::default() };
                        if let Some([next, prev]) = limit.tangents {
                            let along = |d: [f64; 3]| next * d[(corner + 1) % 3] + prev * d[(corner + 2) % 3];
                            (jet.du, jet.dv) = (along(directions[0]), along(directions[1]));
                        }
                        return (jet, limit.tangents.is_some());
                    }
                    let k = triangle_child(b);
                    at = Place { piece: self.children(at.piece) + k as u32, depth: at.depth + 1 };
                    b = into_triangle_child(k, b, 1.0);
                    directions = directions.map(|d| into_triangle_child(k, d, 0.0));
                }
            }
        }
    }

    /// Calls `grow` with points whose hull holds the part `u` x `v` of a quad.
    ///
    /// A piece that is no spline is refined until it is eight times smaller than the part, then its whole
    /// ring counts.
    pub(super) fn quad_hull(
        &mut self,
        u: [f64; 2],
        v: [f64; 2],
        channel: usize,
        grow: &mut impl FnMut(DVec3),
    ) {
        self.trim();
        let smallest = (u[1] - u[0]).max(v[1] - v[0]) / 8.0;
        self.quad_hull_in(Place { piece: 0, depth: 0 }, u, v, smallest, channel, grow);
    }

    fn quad_hull_in(
        &mut self,
        at: Place,
        u: [f64; 2],
        v: [f64; 2],
        smallest: f64,
        channel: usize,
        grow: &mut impl FnMut(DVec3),
    ) {
        match &self.pieces[at.piece as usize] {
            Piece::Bicubic(patches) => patches[channel].bezier(u, v).into_iter().for_each(grow),
            Piece::BoxSpline(_) => unreachable!("a box spline in a tree of quads"),
            Piece::Hood { hood, .. } => {
                let size = 1.0 / (1u64 << at.depth) as f64;
                if at.depth >= MAX_DEPTH || size <= smallest && !hood.has_middles {
                    hood.channel(channel).iter().for_each(|&p| grow(p + hood.origins[channel]));
                    return;
                }
                let first = self.children(at.piece);
                for (k, (x, y)) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].into_iter().enumerate() {
                    let cut = |[a, b]: [f64; 2], side: f64| {
                        [(2.0 * a - side).clamp(0.0, 1.0), (2.0 * b - side).clamp(0.0, 1.0)]
                    };
                    let (cu, cv) = (cut(u, x), cut(v, y));
                    // A part that only touches the child is held by the neighbour, unless it is a line itself.
                    let misses = |part: [f64; 2], [a, b]: [f64; 2], side: f64| {
                        part[0] == part[1] && (a < b || 2.0 * b - side < 0.0 || 2.0 * a - side > 1.0)
                    };
                    if !misses(cu, u, x) && !misses(cv, v, y) {
                        let child = Place { piece: first + k as u32, depth: at.depth + 1 };
                        self.quad_hull_in(child, cu, cv, smallest, channel, grow);
                    }
                }
            }
        }
    }

    /// Calls `grow` with points whose hull holds the part of a triangle within a convex polygon of
    /// barycentric corners.
    pub(super) fn triangle_hull(
        &mut self,
        polygon: &[[f64; 3]],
        channel: usize,
        grow: &mut impl FnMut(DVec3),
    ) {
        self.trim();
        let extent = (0..3).map(|c| {
            let of = || polygon.iter().map(move |b| b[c]);
            of().fold(f64::MIN, f64::max) - of().fold(f64::MAX, f64::min)
        });
        let smallest = extent.fold(0.0, f64::max) / 8.0;
        self.triangle_hull_in(Place { piece: 0, depth: 0 }, polygon, smallest, channel, grow);
    }

    fn triangle_hull_in(
        &mut self,
        at: Place,
        polygon: &[[f64; 3]],
        smallest: f64,
        channel: usize,
        grow: &mut impl FnMut(DVec3),
    ) {
        match &self.pieces[at.piece as usize] {
            Piece::BoxSpline(patches) => {
                for i in 1..polygon.len() - 1 {
                    let t = [polygon[0], polygon[i], polygon[i + 1]];
                    patches[channel].bezier(t).into_iter().for_each(&mut *grow);
                }
            }
            Piece::Bicubic(_) => unreachable!("a B-spline in a tree of triangles"),
            Piece::Hood { hood, .. } => {
                if at.depth >= MAX_DEPTH || 1.0 / (1u64 << at.depth) as f64 <= smallest {
                    hood.channel(channel).iter().for_each(|&p| grow(p + hood.origins[channel]));
                    return;
                }
                let first = self.children(at.piece);
                for k in 0..4 {
                    let part: Vec<_> = polygon.iter().map(|&b| into_triangle_child(k, b, 1.0)).collect();
                    let part = clip_to_triangle(part);
                    if part.len() > 2 {
                        let child = Place { piece: first + k as u32, depth: at.depth + 1 };
                        self.triangle_hull_in(child, &part, smallest, channel, grow);
                    }
                }
            }
        }
    }
}

/// The part of a convex polygon inside the triangle of its coordinates, or a hair beyond, so that what lies
/// on a line between two pieces is in one of them in spite of rounding.
fn clip_to_triangle(mut polygon: Vec<[f64; 3]>) -> Vec<[f64; 3]> {
    const HAIR: f64 = -1e-12;
    for c in 0..3 {
        let mut inside = Vec::with_capacity(polygon.len() + 1);
        for (i, &a) in polygon.iter().enumerate() {
            let b = polygon[(i + 1) % polygon.len()];
            if a[c] >= HAIR {
                inside.push(a);
            }
            if (a[c] >= HAIR) != (b[c] >= HAIR) {
                let t = (HAIR - a[c]) / (b[c] - a[c]);
                inside.push([0, 1, 2].map(|i| a[i] + (b[i] - a[i]) * t));
            }
        }
        polygon = inside;
    }
    polygon
}

/// Makes the piece of a neighbourhood.
fn piece(hood: &Hood) -> Piece {
    if hood.rings[0].step == 1 {
        if let Some(patches) = triangle::box_spline(hood) {
            return Piece::BoxSpline(patches.into());
        }
    } else if let Some(patches) = quad::bicubic(hood) {
        return Piece::Bicubic(patches.into());
    }
    Piece::Hood { hood: Box::new(hood.clone()), children: None }
}

/// Derivatives by u and v at a corner, from the tangents along its two edges.
fn quad_corner_jet(corner: usize, p: DVec3, tangents: Option<[DVec3; 2]>, scale: f64) -> Jet {
    let Some([next, prev]) = tangents.map(|t| t.map(|t| t * scale)) else {
        return Jet { p, ..Jet::default() };
    };
    let (du, dv) = match corner {
        0 => (next, prev),
        1 => (-prev, next),
        2 => (-next, -prev),
        _ => (prev, -next),
    };
    Jet { p, du, dv }
}

/// The child of a triangle that holds the point.
fn triangle_child(b: [f64; 3]) -> usize {
    (0..3).find(|&k| b[k] >= 0.5).unwrap_or(3)
}

/// Coordinates in child `k`, of a point (`sum` 1) or a direction (`sum` 0).
fn into_triangle_child(k: usize, b: [f64; 3], sum: f64) -> [f64; 3] {
    if k == 3 {
        return [sum - 2.0 * b[2], sum - 2.0 * b[0], sum - 2.0 * b[1]];
    }
    let mut out = b.map(|x| 2.0 * x);
    out[k] -= sum;
    out
}
