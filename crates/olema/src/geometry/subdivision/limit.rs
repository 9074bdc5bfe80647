//! Limit masks: where a control vertex itself ends up, and the tangent plane there.
//!
//! In: a corner of a [`Hood`] that has a mask. Out: the limit point and two tangents, the first
//! along the own face's edge to the next corner, the second along the edge to the corner before.
//!
//! The tangents are left eigenvectors of the subdivision matrix. Their directions are exact. Their lengths
//! are those of the derivatives at regular vertices; elsewhere the derivatives by (u, v) vanish or have no
//! bound, and the length is that of the same mask. Source: Halstead, Kass, DeRose 1993; the masks across
//! creases are derived below.
//!
//! Sharp corners of two or more faces have a limit point but in general no tangent plane (Biermann, Levin,
//! Zorin 2000), nor have creases with more than 3 faces (Loop: 5) on one side, nor smooth vertices of two
//! faces: there is no tangent then, and the evaluator takes those a little inside the face.

use glam::DVec3;

use super::hood::{Hood, Ring};
use super::rules::{Rule, vertex_rule};
use super::trig::half_turn_fraction;

/// A limit point and its tangents, where the mask defines them.
pub(super) struct Limit {
    pub(super) p: DVec3,
    pub(super) tangents: Option<[DVec3; 2]>,
}

/// The limit of corner `c`, which has a mask ([`Hood::has_mask`]), or lies in a piece so small that any mask
/// will do: that of a smooth vertex where an infinite crease ends.
pub(super) fn limit(hood: &Hood, c: usize, channel: usize) -> Limit {
    debug_assert!(!hood.has_middles, "a mask needs far corners");
    let ring = &hood.rings[c];
    let points = hood.channel(channel);
    let vertex = points[ring.vertex()];
    match vertex_rule(ring.corner, hood.ring_sharpness(c)) {
        Rule::Corner => Limit { p: vertex, tangents: None },
        Rule::Crease(a, b) => {
            let (a, b) = (points[ring.edge(a as i32)], points[ring.edge(b as i32)]);
            let p = (vertex * 4.0 + a + b) / 6.0;
            // A crease in a ring that was not cut cannot be settled, so the ends are the crease.
            let tangents = if ring.closed { None } else { crease_tangents(ring, points) };
            Limit { p, tangents }
        }
        Rule::Smooth => smooth_limit(ring, points, vertex),
    }
}

/// Limit inside a closed ring.
fn smooth_limit(ring: &Ring, points: &[DVec3], vertex: DVec3) -> Limit {
    let n = f64::from(ring.num_faces);
    let faces = 0..ring.num_faces as i32;
    let edges: DVec3 = faces.clone().map(|k| points[ring.edge(k)]).sum();
    let p = if ring.step == 2 {
        let far: DVec3 = faces.map(|k| points[ring.far(k)]).sum();
        (vertex * (n * n) + edges * 4.0 + far) / (n * (n + 5.0))
    } else {
        let w = 1.0 / (n + 3.0 / (8.0 * loop_weight(ring.num_faces)));
        vertex * (1.0 - n * w) + edges * w
    };
    let at = i64::from(ring.at);
    let tangents = (ring.num_faces > 2)
        .then(|| [smooth_tangent(ring, points, at), smooth_tangent(ring, points, at + 1)]);
    Limit { p, tangents }
}

/// Tangent towards edge `k` of a closed ring.
fn smooth_tangent(ring: &Ring, points: &[DVec3], k: i64) -> DVec3 {
    let n = i64::from(ring.num_faces);
    let cos = |i: i64| half_turn_fraction(2 * (i - k), n).0;
    if ring.step == 1 {
        return (0..n).map(|i| points[ring.edge(i as i32)] * cos(i)).sum::<DVec3>() * (2.0 / n as f64);
    }
    let (c1, _) = half_turn_fraction(2, n);
    let (half, _) = half_turn_fraction(1, n);
    let a = 1.0 + c1 + half * (2.0 * (9.0 + c1)).sqrt();
    let weighted = |i: i64| {
        points[ring.edge(i as i32)] * (a * cos(i)) + points[ring.far(i as i32)] * (cos(i) + cos(i + 1))
    };
    (0..n).map(weighted).sum::<DVec3>() * (4.0 / (3.0 * n as f64 * a))
}

/// Weight of each neighbour in Loop's rule for a smooth vertex.
pub(super) fn loop_weight(num_faces: u32) -> f64 {
    let (cos, _) = half_turn_fraction(2, i64::from(num_faces));
    let root = 0.375 + 0.25 * cos;
    (0.625 - root * root) / f64::from(num_faces)
}

/// Tangents in an open ring whose ends are a crease through the vertex, if there is a tangent plane.
fn crease_tangents(ring: &Ring, points: &[DVec3]) -> Option<[DVec3; 2]> {
    // With more faces the second mode across the crease shrinks no faster than the one along it.
    let most_faces = if ring.step == 2 { 3 } else { 5 };
    if ring.num_faces > most_faces {
        return None;
    }
    let along = (points[ring.edge(0)] - points[ring.edge(ring.num_faces as i32)]) * 0.5;
    let across = tangent_across(ring, points);
    // All inner edges leave the crease in one direction: the first order of the surface across it.
    Some(match (ring.next_is_border(), ring.prev_is_border()) {
        (true, false) => [along, across],
        (false, true) => [across, -along],
        _ => [across + along, across - along],
    })
}

/// Tangent across a crease: the left eigenvector with sin(j t), t = pi / m, at the inner edges j of m faces.
///
/// Under Loop, inner edge points follow 3/8 (vertex + own) + 1/8 (neighbours), so the eigenvalue is
/// l = 3/8 + cos(t) / 4. Under Catmull-Clark, far corners get z (sin(j t) + sin((j + 1) t)) and their columns
/// demand z = 1 / (16 l - 4); l is that of a smooth vertex of 2 m faces. With the crease rules 3/4, 1/8, 1/8
/// and 1/2, 1/2, the columns of the vertex (x) and of a crease edge (y) demand, for s the sum of sin(j t),
/// ```text
///   l x = 3/4 x +     y + a s          a = 3/8, b = 1/8             under Loop
///   l y = 1/8 x + 1/2 y + b sin(t)     a = 3/8 + z/2, b = 1/16 + z/4  under Catmull-Clark
/// ```
/// The mask that is in use elsewhere for Catmull-Clark (Biermann et al.) agrees for two faces only: for three
/// it missed the normals around by 2 degrees.
fn tangent_across(ring: &Ring, points: &[DVec3]) -> DVec3 {
    let m = i64::from(ring.num_faces);
    let vertex = points[ring.vertex()];
    let ends = points[ring.edge(0)] + points[ring.edge(m as i32)];
    if m == 1 {
        return ends * 0.5 - vertex;
    }
    let (cos, sin) = half_turn_fraction(1, m);
    let (l, z, a, b, scale) = if ring.step == 2 {
        let (half, _) = half_turn_fraction(1, 2 * m);
        let l = (5.0 + cos + half * (2.0 * (9.0 + cos)).sqrt()) / 16.0;
        let z = 1.0 / (16.0 * l - 4.0);
        (l, z, 0.375 + 0.5 * z, 0.0625 + 0.25 * z, 4.0 / 3.0)
    } else {
        (0.375 + 0.25 * cos, 0.0, 0.375, 0.125, 2.0)
    };
    let (mut sum, mut s) = (DVec3::ZERO, 0.0);
    for j in 0..m {
        let (_, weight) = half_turn_fraction(j, m);
        s += weight;
        sum += points[ring.edge(j as i32)] * weight;
        if ring.step == 2 {
            let (_, next) = half_turn_fraction(j + 1, m);
            sum += points[ring.far(j as i32)] * (z * (weight + next));
        }
    }
    let y = (a * s + 8.0 * b * (l - 0.75) * sin) / (8.0 * (l - 0.5) * (l - 0.75) - 1.0);
    let x = 8.0 * ((l - 0.5) * y - b * sin);
    (sum + vertex * x + ends * y) * (scale / m as f64)
}
