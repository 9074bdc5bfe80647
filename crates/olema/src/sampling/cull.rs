//! Culling of triangles that face away for every time and lens place.
//!
//! In: a triangle of a [`MovingGrid`]. Out: whether it is certain that no tuple can see one side of it.
//! Source: Fatahalian 2009, section 4 (back faces at both ends of the shutter), made conservative.
//!
//! Over a segment each edge vector from v0 is linear in time, e(t) = (1 - t) p + t q, so twice the area
//! e1 x e2 is a quadratic, which lies within the range of its Bernstein coefficients p1 x p2,
//! (p1 x q2 + q1 x p2) / 2 and q1 x q2. What the lens adds to an edge vector is the difference of two circles
//! of confusion, and positions are rounded: both together move each component of each e by at most some d, and
//! so twice the area by at most d (sum of all |components|) + 2 d^2. All in exact integers.

use super::moving::MovingGrid;

/// Whether twice the area of the triangle, times `side` (+1 or -1), is at most 0 for every tuple.
pub(super) fn never_faces(grid: &MovingGrid, vertices: [usize; 3], side: i8) -> bool {
    let num_segments = (grid.num_keys() - 1).max(1) as u16;
    (0..num_segments).all(|segment| greatest_area(grid, vertices, side, segment) <= 0)
}

/// An upper bound of four times `side` times the area within a segment.
fn greatest_area(grid: &MovingGrid, vertices: [usize; 3], side: i8, segment: u16) -> i128 {
    let [ends0, ends1, ends2] = vertices.map(|vertex| grid.ends(vertex, segment));
    let edge = |to: [usize; 2]| {
        [0, 1].map(|end| [&grid.x, &grid.y].map(|v| i128::from(v[to[end]]) - i128::from(v[ends0[end]])))
    };
    let [[p1, q1], [p2, q2]] = [edge(ends1), edge(ends2)];
    let cross = |a: [i128; 2], b: [i128; 2]| (a[0] * b[1] - a[1] * b[0]) * i128::from(side);
    let coefficients = [2 * cross(p1, p2), cross(p1, q2) + cross(q1, p2), 2 * cross(q1, q2)];
    let most = coefficients.into_iter().fold(i128::MIN, i128::max);

    let slack = slack(grid, ends0, ends1).max(slack(grid, ends0, ends2));
    let components: i128 = (0..2).map(|i| p1[i].abs().max(q1[i].abs()) + p2[i].abs().max(q2[i].abs())).sum();
    most + 2 * (slack * components + 2 * slack * slack)
}

/// Most by which a component of the difference of two vertices can differ from a linear function of time.
fn slack(grid: &MovingGrid, a: [usize; 2], b: [usize; 2]) -> i128 {
    let moves_alike = [&grid.x, &grid.y]
        .iter()
        .all(|v| i64::from(v[a[1]]) - i64::from(v[a[0]]) == i64::from(v[b[1]]) - i64::from(v[b[0]]));
    // Two values, each rounded by at most a half.
    let motion = if moves_alike { 0 } else { 1 };
    if grid.coc.is_empty() {
        return motion;
    }
    let apart = [0, 1].map(|end| (i128::from(grid.coc[b[end]]) - i128::from(grid.coc[a[end]])).abs());
    let same_circles = apart == [0, 0];
    // Two radii and two shifts, each rounded by at most a half.
    motion + if same_circles { 0 } else { apart[0].max(apart[1]) + 2 }
}
