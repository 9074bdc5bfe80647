//! Catmull-Clark on neighbourhoods: refining, and telling where the surface is a bicubic B-spline already.
//!
//! In: a [`Hood`]. Out: its refinement, its children, its [`Bicubic`] control points. Source: Catmull, Clark
//! 1978; DeRose, Kass, Truong 1998.
//!
//! A child keeps the directions of its parent, so u and v of the base quad are those of every piece of it:
//!
//! ```text
//!   3 ---- E2 ---- 2        child k has the vertex point of corner k at its own corner k,
//!   | c3   |   c2  |        the face point F opposite, and edge points at the other two
//!   E3 --- F ---- E1
//!   | c0   |   c1  |
//!   0 ---- E0 ---- 1
//! ```

use glam::DVec3;

use super::bicubic::Bicubic;
use super::hood::{Hood, Ring, Scratch, cut};
use super::rules::{self, Blend, Rule};
use crate::scene::CreaseMethod;

/// The rings of all corners one level down, into `fine`: each has its vertex point, edge points and face
/// points in the places of the vertex, edge ends and far corners before.
pub(super) fn refine(hood: &Hood, method: CreaseMethod, fine: &mut Hood) {
    fine.copy_from(hood);
    fine.has_middles = false;
    for (c, ring) in hood.rings.iter().enumerate() {
        let sharpness = hood.ring_sharpness(c);
        for k in 0..sharpness.len() {
            fine.sharpness[ring.first_sharpness as usize + k] = rules::child_sharpness(method, sharpness, k);
        }
        let blend = rules::blend(ring.corner, sharpness, fine.ring_sharpness(c));
        fine.rings[c].corner = rules::decay(ring.corner);
        for channel in 0..hood.num_channels() {
            let first = channel * hood.num_points + ring.vertex();
            let out = &mut fine.points[first..=first + ring.num_points() as usize];
            refine_ring(hood, ring, hood.channel(channel), sharpness, blend, out);
        }
    }
}

/// One ring's vertex point, edge points and face points; `fine` holds the vertex and the ring.
fn refine_ring(
    hood: &Hood,
    ring: &Ring,
    points: &[DVec3],
    sharpness: &[f32],
    blend: Blend,
    fine: &mut [DVec3],
) {
    let vertex = points[ring.vertex()];
    let n = ring.num_faces as i32;
    for k in 0..n {
        let (e0, far, e1) = (points[ring.edge(k)], points[ring.far(k)], points[ring.edge(k + 1)]);
        fine[k as usize * 2 + 2] = if hood.has_middles { far } else { ((vertex + far) + (e0 + e1)) * 0.25 };
    }
    let face = |fine: &[DVec3], k: i32| fine[(k.rem_euclid(n) * 2 + 2) as usize];
    fine[0] = mix(blend, |rule| match rule {
        Rule::Corner => vertex,
        Rule::Crease(a, b) => {
            vertex * 0.75 + (points[ring.edge(a as i32)] + points[ring.edge(b as i32)]) * 0.125
        }
        Rule::Smooth => {
            let sum: DVec3 = (0..n).map(|k| points[ring.edge(k)] + face(fine, k)).sum();
            let n = f64::from(n);
            vertex * ((n - 2.0) / n) + sum / (n * n)
        }
    });
    for (k, &s) in sharpness.iter().enumerate() {
        let end = points[ring.edge(k as i32)];
        let sharp = (vertex + end) * 0.5;
        fine[k * 2 + 1] = if s >= 1.0 {
            sharp
        } else {
            let k = k as i32;
            let smooth = ((vertex + end) + (face(fine, k - 1) + face(fine, k))) * 0.25;
            if s > 0.0 { smooth.lerp(sharp, f64::from(s)) } else { smooth }
        };
    }
}

/// The point that a blend of two rules gives.
pub(super) fn mix(blend: Blend, point: impl Fn(Rule) -> DVec3) -> DVec3 {
    let parent = point(blend.parent);
    if blend.weight >= 1.0 { parent } else { point(blend.child).lerp(parent, blend.weight) }
}

/// The neighbourhood of child `k` of the face whose refinement is `scratch.fine`, into `scratch.child`.
pub(super) fn child(scratch: &mut Scratch, k: usize) {
    let Scratch { fine, child, sources } = scratch;
    child.clear();
    sources.clear();
    let n = fine.rings.len();
    let (prev, next) = ((k + n - 1) % n, (k + 1) % n);
    let mut builder = ChildBuilder { fine, child, sources };
    builder.vertex_ring(k);
    builder.next_edge_ring(k, prev, next);
    builder.face_ring(k);
    builder.prev_edge_ring(k, prev);
    // The children of an n-gon are base quads of their own, with the n-gon's corner at (0, 0).
    child.rings.rotate_right(if n == 4 { k } else { 0 });
    child.take_points(fine, sources);
}

/// Puts the rings of a child together from the refined rings of its parent.
struct ChildBuilder<'a> {
    fine: &'a Hood,
    child: &'a mut Hood,
    sources: &'a mut Vec<usize>,
}

impl ChildBuilder<'_> {
    /// Own edge point of edge `c`, from corner c to the next.
    fn edge_point(&self, c: usize) -> usize {
        let ring = &self.fine.rings[c];
        ring.edge(ring.at as i32)
    }

    /// Half of own edge `c`: its sharpness at its beginning, and at its end where that is the corner `next`.
    fn half_sharpness(&self, c: usize, at_end: bool) -> f32 {
        let ring = &self.fine.rings[c];
        let k = ring.at + u32::from(at_end);
        self.fine.ring_sharpness(c)[(k % ring.num_edges()) as usize]
    }

    /// The ring around the parent's corner goes on as it is, but for what has become independent of it.
    fn vertex_ring(&mut self, k: usize) {
        let old = self.fine.rings[k];
        let sharpness = self.fine.ring_sharpness(k);
        let (mut ring, first) = cut(old, sharpness);
        ring.first = 1;
        ring.first_sharpness = 0;
        self.sources.push(old.vertex());
        for i in 0..ring.num_faces as i32 {
            self.sources.push(old.edge(first as i32 + i));
            self.sources.push(old.far(first as i32 + i));
        }
        if !ring.closed {
            self.sources.push(old.edge(first as i32 + ring.num_faces as i32));
        }
        let n = sharpness.len();
        self.child.sharpness.extend((0..ring.num_edges() as usize).map(|i| sharpness[(first + i) % n]));
        self.child.rings.push(ring);
    }

    /// The ring of the point on the edge to the next corner.
    fn next_edge_ring(&mut self, k: usize, prev: usize, next: usize) {
        let (a, b) = (self.fine.rings[k], self.fine.rings[next]);
        let (vertex, far_vertex) = (a.vertex(), b.vertex());
        let face = a.far(a.at as i32);
        let own = self.edge_point(prev);
        let beside = self.edge_point(next);
        let halves = [self.half_sharpness(k, false), self.half_sharpness(next, true)];
        let center = self.edge_point(k);
        if a.next_is_border() || halves == [f32::INFINITY; 2] {
            self.push(center, &[far_vertex, beside, face, own, vertex], &[halves[1], 0.0, halves[0]], 1);
        } else {
            let (a_at, b_at) = (a.at as i32, b.at as i32);
            let ring =
                [face, own, vertex, a.edge(a_at - 1), a.far(a_at - 1), b.edge(b_at + 2), far_vertex, beside];
            self.push(center, &ring, &[0.0, halves[0], 0.0, halves[1]], 0);
        }
    }

    /// The ring of the face point: own edge points and vertex points in turn.
    fn face_ring(&mut self, k: usize) {
        let n = self.fine.rings.len();
        let center = self.fine.rings[k].far(self.fine.rings[k].at as i32);
        self.begin(center, 2 * n, 0);
        for i in 0..n {
            let c = (k + i) % n;
            let edge_point = self.edge_point((c + n - 1) % n);
            self.sources.extend([edge_point, self.fine.rings[c].vertex()]);
            self.child.sharpness.push(0.0);
        }
    }

    /// The ring of the point on the edge to the corner before.
    fn prev_edge_ring(&mut self, k: usize, prev: usize) {
        let n = self.fine.rings.len();
        let (a, b) = (self.fine.rings[k], self.fine.rings[prev]);
        let (vertex, far_vertex) = (a.vertex(), b.vertex());
        let face = a.far(a.at as i32);
        let own = self.edge_point(k);
        let beside = self.edge_point((prev + n - 1) % n);
        let halves = [self.half_sharpness(k, true), self.half_sharpness(prev, false)];
        let center = self.edge_point(prev);
        if a.prev_is_border() || halves == [f32::INFINITY; 2] {
            self.push(center, &[vertex, own, face, beside, far_vertex], &[halves[0], 0.0, halves[1]], 0);
        } else {
            let (a_at, b_at) = (a.at as i32, b.at as i32);
            let ring =
                [vertex, own, face, beside, far_vertex, b.edge(b_at - 1), a.far(a_at + 1), a.edge(a_at + 2)];
            self.push(center, &ring, &[halves[0], 0.0, halves[1], 0.0], 0);
        }
    }

    /// Adds a ring of edge ends and far corners in turn; an odd number of them makes an open one.
    fn push(&mut self, center: usize, ring: &[usize], sharpness: &[f32], at: u32) {
        self.begin(center, ring.len(), at);
        self.sources.extend_from_slice(ring);
        self.child.sharpness.extend_from_slice(sharpness);
    }

    /// Begins a ring of `num_points` points.
    fn begin(&mut self, center: usize, num_points: usize, at: u32) {
        self.child.rings.push(Ring {
            first: self.sources.len() as u32 + 1,
            step: 2,
            first_sharpness: self.child.sharpness.len() as u32,
            num_faces: num_points as u32 / 2,
            closed: num_points.is_multiple_of(2),
            at,
            corner: 0.0,
        });
        self.sources.push(center);
    }
}

/// Offsets in the control grid of a corner's edge to the next and to the corner before.
const DIRECTIONS: [([i32; 2], [i32; 2]); 4] =
    [([1, 0], [0, 1]), ([0, 1], [-1, 0]), ([-1, 0], [0, -1]), ([0, -1], [1, 0])];

/// Place of the corners in the 4 x 4 control grid.
const CORNERS: [[i32; 2]; 4] = [[1, 1], [2, 1], [2, 2], [1, 2]];

/// The control points of every channel, if the limit surface over the face is one bicubic B-spline: all
/// corners have four faces and nothing sharp, or lie on a border or infinite crease with two, or are sharp
/// corners of one. Beyond borders the control points are mirrored, which gives the same surface.
pub(super) fn bicubic(hood: &Hood) -> Option<Vec<Bicubic>> {
    if hood.has_middles || hood.rings.len() != 4 {
        return None;
    }
    let mut source = [0usize; 16];
    for (c, ring) in hood.rings.iter().enumerate() {
        let inner_sharp = match (ring.closed, hood.ring_sharpness(c)) {
            (true, s) => s.iter().any(|&s| s > 0.0),
            (false, s) => s[1..s.len() - 1].iter().any(|&s| s > 0.0),
        };
        let corner = if !ring.closed && ring.num_faces == 1 { f32::INFINITY } else { 0.0 };
        let num_faces_fits = if ring.closed { ring.num_faces == 4 } else { ring.num_faces <= 2 };
        if inner_sharp || ring.corner != corner || !num_faces_fits {
            return None;
        }
        place_ring(ring, c, &mut source);
    }
    let border = |c: usize| hood.rings[c].next_is_border();
    let mirrored = [border(0), border(1), border(2), border(3)];
    let patch = |channel: usize| {
        let points = hood.channel(channel);
        Bicubic::mirrored(source.map(|ix| points[ix]), mirrored, hood.origins[channel])
    };
    Some((0..hood.num_channels()).map(patch).collect())
}

/// Enters the points of a regular corner's ring into the control grid, row after row.
fn place_ring(ring: &Ring, c: usize, source: &mut [usize; 16]) {
    let (next, prev) = DIRECTIONS[c];
    let at = ring.at as i32;
    let mut place = |along_next: i32, along_prev: i32, ix: usize| {
        let [x, y] = [0, 1].map(|i| CORNERS[c][i] + along_next * next[i] + along_prev * prev[i]);
        source[(y * 4 + x) as usize] = ix;
    };
    place(0, 0, ring.vertex());
    if ring.closed {
        place(-1, 1, ring.far(at + 1));
        place(-1, 0, ring.edge(at + 2));
        place(-1, -1, ring.far(at + 2));
        place(0, -1, ring.edge(at + 3));
        place(1, -1, ring.far(at + 3));
    } else if ring.num_faces == 2 && at == 0 {
        place(-1, 1, ring.far(1));
        place(-1, 0, ring.edge(2));
    } else if ring.num_faces == 2 {
        place(0, -1, ring.edge(0));
        place(1, -1, ring.far(0));
    }
}
