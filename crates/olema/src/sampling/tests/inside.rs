use proptest::prelude::*;

use crate::sampling::hash::Stream;
use crate::sampling::inside::{GUARD_BAND, Hit, Weights, depth_at, point_at, triangle_hit};

/// Sum of signs and number of hits of triangles.
fn count(triangles: &[[[i32; 2]; 3]], s: [i32; 2]) -> (i32, u32) {
    let hits = triangles.iter().filter_map(|&t| triangle_hit(t, s));
    hits.fold((0, 0), |(sum, n), hit| (sum + i32::from(hit.sign), n + 1))
}

fn halves(quad: [[i32; 2]; 4]) -> [[[i32; 2]; 3]; 2] {
    [[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]
}

/// Turns some triangles over and starts them at other vertices: what is drawn stays the same.
fn rewound(mut triangles: Vec<[[i32; 2]; 3]>, seed: u32) -> Vec<[[i32; 2]; 3]> {
    let mut stream = Stream::new(seed);
    for triangle in &mut triangles {
        triangle.rotate_left(stream.below(3) as usize);
        if stream.below(2) == 1 {
            triangle.swap(0, 1);
        }
    }
    triangles
}

/// Quads of a grid of (n + 1)^2 vertices, as triangles.
fn grid_triangles(n: usize, at: impl Fn(usize, usize) -> [i32; 2]) -> Vec<[[i32; 2]; 3]> {
    let mut triangles = Vec::new();
    for j in 0..n {
        for i in 0..n {
            triangles.extend(halves([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]));
        }
    }
    triangles
}

#[test]
fn right_down_is_the_side_plus_one() {
    let quad = [[0, 0], [256, 0], [256, 256], [0, 256]];
    let [first, second] = halves(quad);
    assert_eq!(
        triangle_hit(first, [200, 100]),
        Some(Hit { sign: 1, w: [14_336, 25_600, 25_600], area: 65_536 })
    );
    assert_eq!(triangle_hit(first, [100, 200]), None);
    assert_eq!(triangle_hit(second, [100, 200]).map(|hit| hit.sign), Some(1));
    let [mut turned, _] = halves(quad);
    turned.swap(0, 2);
    assert_eq!(triangle_hit(turned, [200, 100]).map(|hit| hit.sign), Some(-1));
}

#[test]
fn the_upper_and_left_border_belong_to_a_square_and_the_others_do_not() {
    let square = halves([[0, 0], [2, 0], [2, 2], [0, 2]]);
    for y in -1..=3 {
        for x in -1..=3 {
            let inside = (0..2).contains(&x) && (0..2).contains(&y);
            assert_eq!(count(&square, [x, y]).1, u32::from(inside), "({x}, {y})");
        }
    }
}

#[test]
fn degenerate_triangles_are_never_hit() {
    let lines = [
        [[0, 0], [0, 0], [0, 0]],
        [[0, 0], [0, 0], [4, 2]],
        [[0, 0], [4, 2], [0, 0]],
        [[0, 0], [2, 1], [4, 2]],
        [[0, 3], [9, 3], [4, 3]],
        [[3, 0], [3, 9], [3, 4]],
    ];
    for triangle in lines {
        for y in -1..10 {
            for x in -1..10 {
                assert_eq!(triangle_hit(triangle, [x, y]), None, "{triangle:?}");
            }
        }
    }
}

#[test]
fn the_guard_band_does_not_overflow() {
    let far = GUARD_BAND;
    let corners = [[-far, -far], [far, -far], [far, far], [-far, far]];
    let square = halves(corners);
    for s in corners.into_iter().chain([[0, 0], [far - 1, far - 1], [1 - far, far - 1], [5, -7]]) {
        let inside = s[0] < far && s[1] < far;
        let (sum, num) = count(&square, s);
        assert_eq!((sum, num), (i32::from(inside), u32::from(inside)), "{s:?}");
        let mut turned = square;
        turned[0].swap(0, 1);
        turned[1].swap(1, 2);
        assert_eq!(count(&turned, s), (-sum, num));
    }
    let hit = triangle_hit(square[0], [far - 1, -far]).unwrap();
    assert_eq!(hit.area, 1 << 60);
    assert_eq!(hit.w.iter().sum::<i64>(), hit.area);
}

#[test]
fn depth_is_the_plane_and_stays_between_the_vertices() {
    let triangle = [[0, 0], [512, 0], [512, 512]];
    let at = |s, z| depth_at(&triangle_hit(triangle, s).unwrap(), z);
    assert_eq!(at([0, 0], [1.0, 2.0, 4.0]), 1.0);
    assert_eq!(at([256, 0], [1.0, 2.0, 4.0]), 1.5);
    assert_eq!(at([256, 128], [1.0, 2.0, 4.0]), 1.0 + 0.25 + 0.75);
    assert_eq!(at([256, 128], [7.0; 3]), 7.0);
    assert_eq!(at([256, 128], [f32::INFINITY; 3]), f32::INFINITY);
    assert!(!at([256, 128], [1.0, f32::INFINITY, 2.0]).is_nan());
    let point = point_at(&triangle_hit(triangle, [256, 128]).unwrap(), [7.0; 3]);
    assert_eq!(point.weights.get(), [0.5, 0.25, 0.25]);
}

#[test]
fn weights_stay_between_0_and_1_and_sum_to_1_whatever_rounding_did() {
    let a_bit_more = 1.0 + f32::EPSILON;
    for upper in [[0.0, 0.0], [1.0, 0.0], [0.0, a_bit_more], [0.5, 0.5 * a_bit_more], [-0.0, 1.0 / 3.0]] {
        let weights = Weights::new(upper).get();
        assert_eq!(weights.iter().sum::<f32>(), 1.0, "{upper:?}");
        assert!(weights.iter().all(|w| (0.0..=1.0).contains(w)), "{weights:?}");
        assert!((0..2).all(|c| (weights[c + 1] - upper[c]).abs() < 2.0 / 65_536.0), "{weights:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn depth_never_leaves_the_range_of_its_vertices(
        xy in prop::array::uniform3(prop::array::uniform2(-40i32..40)),
        z in prop::array::uniform3(-1e6f32..1e6),
        s in prop::array::uniform2(-40i32..40),
    ) {
        if let Some(hit) = triangle_hit(xy, s) {
            let depth = depth_at(&hit, z);
            prop_assert!(z.iter().any(|&v| v <= depth) && z.iter().any(|&v| v >= depth));
            let sign = i64::from(hit.sign);
            prop_assert!(hit.w.iter().all(|&w| w * sign >= 0) && hit.area * sign > 0);
            let exact = (0..3).map(|i| hit.w[i] as f64 / hit.area as f64 * f64::from(z[i])).sum::<f64>();
            prop_assert!((exact - f64::from(depth)).abs() < 2.0, "{exact} {depth}");
        }
    }

    /// The interior vertices of a grid move about without folding; its border is the square [0, 8 n)^2.
    #[test]
    fn a_grid_covers_its_inside_exactly_once_whatever_the_winding(seed in any::<u32>()) {
        let n = 5usize;
        let mut stream = Stream::new(seed);
        let mut moved = Vec::new();
        for j in 0..=n {
            for i in 0..=n {
                let inner = i > 0 && j > 0 && i < n && j < n;
                // Up to 2 of 8 units keeps every quad convex.
                let mut step = || if inner { stream.below(5) as i32 - 2 } else { 0 };
                moved.push([8 * i as i32 + step(), 8 * j as i32 + step()]);
            }
        }
        let triangles = rewound(grid_triangles(n, |i, j| moved[j * (n + 1) + i]), seed);
        let side = 8 * n as i32;
        for y in -1..=side {
            for x in -1..=side {
                let inside = (0..side).contains(&x) && (0..side).contains(&y);
                prop_assert_eq!(count(&triangles, [x, y]).1, u32::from(inside), "({}, {})", x, y);
            }
        }
    }

    /// Fans about a vertex at a sample place, the rim a square.
    #[test]
    fn a_fan_covers_its_inside_exactly_once(
        centre in prop::array::uniform2(0i32..=12),
        rim in prop::collection::btree_set(0i32..48, 0..12),
        seed in any::<u32>(),
    ) {
        // Corners of the square are always on the rim.
        let mut stops: Vec<i32> = rim.into_iter().chain([0, 12, 24, 36]).collect();
        stops.sort_unstable();
        stops.dedup();
        let place = |s: i32| match s / 12 {
            0 => [s, 0],
            1 => [12, s - 12],
            2 => [36 - s, 12],
            _ => [0, 48 - s],
        };
        let triangles: Vec<_> = (0..stops.len())
            .map(|i| [centre, place(stops[i]), place(stops[(i + 1) % stops.len()])])
            .collect();
        let triangles = rewound(triangles, seed);
        for y in -1..=13 {
            for x in -1..=13 {
                let inside = (0..12).contains(&x) && (0..12).contains(&y);
                prop_assert_eq!(count(&triangles, [x, y]).1, u32::from(inside), "({}, {})", x, y);
            }
        }
    }

    /// A grid thrown about at random, folded many times over, with its border kept: every sample inside
    /// the border has the net count of a flat one, every other sample 0.
    #[test]
    fn a_folded_grid_keeps_its_signed_count(seed in any::<u32>(), huge in any::<bool>()) {
        let n = 4usize;
        let mut stream = Stream::new(seed);
        let mut vertices = Vec::new();
        for j in 0..=n {
            for i in 0..=n {
                let inner = i > 0 && j > 0 && i < n && j < n;
                let reach = if huge { GUARD_BAND as u32 } else { 30 };
                let far = |stream: &mut Stream| stream.below(2 * reach + 1) as i32 - reach as i32;
                let thrown = [far(&mut stream), far(&mut stream)];
                vertices.push(if inner { thrown } else { [4 * i as i32, 4 * j as i32] });
            }
        }
        let triangles = grid_triangles(n, |i, j| vertices[j * (n + 1) + i]);
        for y in -20..=35 {
            for x in -20..=35 {
                let inside = (0..16).contains(&x) && (0..16).contains(&y);
                prop_assert_eq!(count(&triangles, [x, y]).0, i32::from(inside), "({}, {})", x, y);
            }
        }
    }

    /// A closed surface (an octahedron thrown about) is seen as often from the front as from behind.
    #[test]
    fn a_closed_surface_has_no_net_hits(
        v in prop::array::uniform6(prop::array::uniform2(-6i32..6)),
    ) {
        let faces = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1], [5, 2, 1], [5, 3, 2], [5, 4, 3], [5, 1, 4]];
        let triangles = faces.map(|f: [usize; 3]| f.map(|i| v[i]));
        for y in -7..7 {
            for x in -7..7 {
                prop_assert_eq!(count(&triangles, [x, y]).0, 0, "({}, {})", x, y);
            }
        }
    }
}
