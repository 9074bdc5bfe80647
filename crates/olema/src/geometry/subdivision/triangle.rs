//! Loop's scheme on neighbourhoods: refining, and telling where the surface is a box spline already.
//!
//! In: a [`Hood`] of a triangle, its rings without far corners. Out: its refinement, its children, its
//! [`BoxSpline`] control points. Source: Loop 1987; creases as in Catmull-Clark.
//!
//! ```text
//!            2
//!           / \            child k < 3 has corner k's vertex point at its own corner k;
//!         E2 - E1          child 3 is (E0, E1, E2)
//!         / \  / \
//!        0 - E0 - 1
//! ```

use glam::DVec3;

use super::box_spline::BoxSpline;
use super::hood::{Hood, Ring, Scratch, cut};
use super::limit::loop_weight;
use super::quad::mix;
use super::rules::{self, Blend, Rule};
use crate::scene::CreaseMethod;

/// The rings of all corners one level down, into `fine`, edge points in the places of edge ends.
pub(super) fn refine(hood: &Hood, method: CreaseMethod, fine: &mut Hood) {
    fine.copy_from(hood);
    for (c, ring) in hood.rings.iter().enumerate() {
        let sharpness = hood.ring_sharpness(c);
        for k in 0..sharpness.len() {
            fine.sharpness[ring.first_sharpness as usize + k] = rules::child_sharpness(method, sharpness, k);
        }
        let blend = rules::blend(ring.corner, sharpness, fine.ring_sharpness(c));
        fine.rings[c].corner = rules::decay(ring.corner);
        for channel in 0..hood.num_channels() {
            let first = channel * hood.num_points;
            let out = &mut fine.points[first..first + hood.num_points];
            refine_ring(ring, hood.channel(channel), sharpness, blend, out);
        }
    }
}

fn refine_ring(ring: &Ring, points: &[DVec3], sharpness: &[f32], blend: Blend, out: &mut [DVec3]) {
    let vertex = points[ring.vertex()];
    out[ring.vertex()] = mix(blend, |rule| match rule {
        Rule::Corner => vertex,
        Rule::Crease(a, b) => {
            vertex * 0.75 + (points[ring.edge(a as i32)] + points[ring.edge(b as i32)]) * 0.125
        }
        Rule::Smooth => {
            let w = loop_weight(ring.num_faces);
            let sum: DVec3 = (0..ring.num_faces as i32).map(|k| points[ring.edge(k)]).sum();
            vertex * (1.0 - w * f64::from(ring.num_faces)) + sum * w
        }
    });
    for (k, &s) in (0i32..).zip(sharpness) {
        let end = points[ring.edge(k)];
        let sharp = (vertex + end) * 0.5;
        out[ring.edge(k)] = if s >= 1.0 {
            sharp
        } else {
            let beside = points[ring.edge(k - 1)] + points[ring.edge(k + 1)];
            let smooth = (vertex + end) * 0.375 + beside * 0.125;
            if s > 0.0 { smooth.lerp(sharp, f64::from(s)) } else { smooth }
        };
    }
}

/// The neighbourhood of child `k`, 0 to 3, of the triangle whose refinement is `scratch.fine`, into
/// `scratch.child`.
pub(super) fn child(scratch: &mut Scratch, k: usize) {
    let Scratch { fine, child, sources } = scratch;
    child.clear();
    sources.clear();
    let mut builder = ChildBuilder { fine, child, sources };
    if k == 3 {
        // The middle is the second of three own faces at each edge point.
        for c in 0..3 {
            builder.edge_ring(c, 5, 1);
        }
    } else {
        let prev = (k + 2) % 3;
        builder.vertex_ring(k);
        builder.edge_ring(k, 0, 2);
        builder.edge_ring(prev, 4, 0);
        child.rings.rotate_right(k);
    }
    child.take_points(fine, sources);
}

/// Puts the rings of a child together from the refined rings of its parent.
struct ChildBuilder<'a> {
    fine: &'a Hood,
    child: &'a mut Hood,
    sources: &'a mut Vec<usize>,
}

impl ChildBuilder<'_> {
    fn edge_point(&self, c: usize) -> usize {
        let ring = &self.fine.rings[c % 3];
        ring.edge(ring.at as i32)
    }

    fn vertex_ring(&mut self, k: usize) {
        let old = self.fine.rings[k];
        let sharpness = self.fine.ring_sharpness(k);
        let (mut ring, first) = cut(old, sharpness);
        (ring.first, ring.first_sharpness) = (1, 0);
        self.sources.push(old.vertex());
        let n = sharpness.len();
        for i in 0..ring.num_edges() as usize {
            self.sources.push(old.edge((first + i) as i32));
            self.child.sharpness.push(sharpness[(first + i) % n]);
        }
        self.child.rings.push(ring);
    }

    /// The ring of the point on edge `c`; the child is face `at` of it, or `open_at` where it is open.
    fn edge_ring(&mut self, c: usize, at: u32, open_at: u32) {
        let (a, b) = (self.fine.rings[c], self.fine.rings[(c + 1) % 3]);
        let (a_at, b_at) = (a.at as i32, b.at as i32);
        let (left, right) = (self.edge_point(c + 2), self.edge_point(c + 1));
        let start = self.fine.ring_sharpness(c)[a.at as usize];
        let ends = self.fine.ring_sharpness((c + 1) % 3);
        let end = ends[(b.at + 1) as usize % ends.len()];
        let center = self.edge_point(c);
        if a.next_is_border() || [start, end] == [f32::INFINITY; 2] {
            self.push(
                center,
                &[b.vertex(), right, left, a.vertex()],
                &[end, 0.0, 0.0, start],
                false,
                open_at,
            );
        } else {
            let ring = [left, a.vertex(), a.edge(a_at - 1), b.edge(b_at + 2), b.vertex(), right];
            self.push(center, &ring, &[0.0, start, 0.0, 0.0, end, 0.0], true, at);
        }
    }

    fn push(&mut self, center: usize, ring: &[usize], sharpness: &[f32], closed: bool, at: u32) {
        self.child.rings.push(Ring {
            first: self.sources.len() as u32 + 1,
            step: 1,
            first_sharpness: self.child.sharpness.len() as u32,
            num_faces: ring.len() as u32 - u32::from(!closed),
            closed,
            at,
            corner: 0.0,
        });
        self.sources.push(center);
        self.sources.extend_from_slice(ring);
        self.child.sharpness.extend_from_slice(sharpness);
    }
}

/// The control points of every channel, if the limit surface over the triangle is one box spline: all
/// corners have six faces and nothing sharp, or lie on a border or infinite crease with three. Beyond
/// borders the control points are mirrored, which gives the same surface.
pub(super) fn box_spline(hood: &Hood) -> Option<Vec<BoxSpline>> {
    for (c, ring) in hood.rings.iter().enumerate() {
        let s = hood.ring_sharpness(c);
        let inner = if ring.closed { s } else { &s[1..s.len() - 1] };
        let num_faces = if ring.closed { 6 } else { 3 };
        if inner.iter().any(|&s| s > 0.0) || ring.corner != 0.0 || ring.num_faces != num_faces {
            return None;
        }
    }
    let patch = |channel: usize| {
        let points = hood.channel(channel);
        let rings = [0, 1, 2].map(|c| whole_ring(&hood.rings[c], points));
        let corners = [0, 1, 2].map(|c| points[hood.rings[c].vertex()]);
        BoxSpline::from_rings(rings, corners, hood.origins[channel])
    };
    Some((0..hood.num_channels()).map(patch).collect())
}

/// The six neighbours of a regular corner from edge `at` on, mirrored where there are only four.
fn whole_ring(ring: &Ring, points: &[DVec3]) -> [DVec3; 6] {
    let mut out = [DVec3::ZERO; 6];
    if ring.closed {
        for (k, p) in (0i32..).zip(&mut out) {
            *p = points[ring.edge(ring.at as i32 + k)];
        }
        return out;
    }
    let e = [0, 1, 2, 3].map(|k| points[ring.edge(k)]);
    let vertex = points[ring.vertex()];
    let all = [e[0], e[1], e[2], e[3], vertex + e[3] - e[2], vertex + e[0] - e[1]];
    for (k, p) in out.iter_mut().enumerate() {
        *p = all[(ring.at as usize + k) % 6];
    }
    out
}
