//! Rules of sharpness, common to Catmull-Clark and Loop.
//!
//! In: the sharpness of a vertex and of the edges around it. Out: which mask places the vertex in the next
//! level, and what sharpness is left. Source: DeRose, Kass, Truong 1998, section 3, with the blending of
//! OpenSubdiv where several edges of unlike sharpness meet.

use crate::scene::CreaseMethod;

/// What a vertex is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Rule {
    /// No sharp edge, or one (a dart).
    Smooth,
    /// On a crease through the two edges given by their place in the ring.
    Crease(u32, u32),
    /// Stays where it is.
    Corner,
}

/// The rule of a vertex of sharpness `corner` with edges of the sharpness `edges` around it.
pub(super) fn vertex_rule(corner: f32, edges: &[f32]) -> Rule {
    if corner > 0.0 {
        return Rule::Corner;
    }
    let mut sharp = (0u32..).zip(edges).filter(|e| *e.1 > 0.0).map(|e| e.0);
    match (sharp.next(), sharp.next(), sharp.next()) {
        (_, None, _) => Rule::Smooth,
        (Some(a), Some(b), None) => Rule::Crease(a, b),
        _ => Rule::Corner,
    }
}

/// How a vertex moves: by `parent`'s mask with `weight`, by `child`'s with the rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Blend {
    pub(super) parent: Rule,
    pub(super) child: Rule,
    pub(super) weight: f64,
}

/// The move of a vertex whose edges have `edges` before and `child_edges` after one level.
pub(super) fn blend(corner: f32, edges: &[f32], child_edges: &[f32]) -> Blend {
    let parent = vertex_rule(corner, edges);
    let child = vertex_rule(decay(corner), child_edges);
    if parent == child || parent == Rule::Smooth {
        return Blend { parent, child: parent, weight: 1.0 };
    }
    // What becomes smooth in this level does so by its sharpness, on average.
    let ends = |s: f32, after: f32| s > 0.0 && after <= 0.0;
    let (mut sum, mut count) = (0.0f64, 0.0f64);
    if ends(corner, decay(corner)) {
        (sum, count) = (f64::from(corner), 1.0);
    }
    for (&s, _) in edges.iter().zip(child_edges).filter(|e| ends(*e.0, *e.1)) {
        (sum, count) = (sum + f64::from(s), count + 1.0);
    }
    let weight = if count == 0.0 { 0.0 } else { (sum / count).min(1.0) };
    Blend { parent, child, weight }
}

/// Sharpness after one level.
pub(super) fn decay(sharpness: f32) -> f32 {
    if sharpness > 1.0 { sharpness - 1.0 } else { 0.0 }
}

/// Sharpness, after one level, of the half of edge `k` that ends at the vertex whose edges are `edges`.
pub(super) fn child_sharpness(method: CreaseMethod, edges: &[f32], k: usize) -> f32 {
    let own = edges[k];
    if method == CreaseMethod::Uniform || own <= 0.0 || own == f32::INFINITY {
        return decay(own);
    }
    let semi = edges.iter().filter(|&&s| s > 0.0 && s < f32::INFINITY);
    let (sum, count) = semi.fold((0.0, 0u32), |(sum, count), &s| (sum + s, count + 1));
    if count < 2 {
        return decay(own);
    }
    decay(0.75 * own + 0.25 * (sum - own) / (count - 1) as f32)
}
