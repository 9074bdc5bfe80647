//! Pieces are culled and filed by their bounds: no vertex that is diced from one may lie outside.

use conformance::closed::{self, Kind};
use conformance::scenes::small;
use olema::engine::Bench;
use olema::pipeline::sweep::to_pixels;
use olema::{Scene, Settings};

/// Pieces of a scene whose grids leave their bounds, and by how many pixels at most; and how many were blocks of a lattice.
fn outside(scene: &Scene, settings: &Settings) -> (usize, i32, usize) {
    let bench = Bench::new(scene, settings).expect("a correct scene");
    let (mut num, mut most, mut blocks) = (0, 0, 0);
    for piece in bench.split() {
        let pieces = std::slice::from_ref(&piece);
        let bounds = bench.bound(pieces);
        for diced in bench.dice(pieces) {
            let grid = &diced.grid;
            if grid.has_slow() {
                continue;
            }
            blocks += usize::from(grid.key.block != [0, 0]);
            let of = |values: &[i32]| {
                let (least, most) =
                    values.iter().fold((i32::MAX, i32::MIN), |(a, b), &v| (a.min(v), b.max(v)));
                [least >> 8, most >> 8]
            };
            let ([x0, x1], [y0, y1]) = (of(&grid.on_raster.x), of(&grid.on_raster.y));
            let apart = match bounds.first() {
                Some(bound) => {
                    let [px0, px1, py0, py1] = to_pixels(bound.sweep.whole());
                    [px0 - x0, x1 - px1, py0 - y0, y1 - py1].into_iter().max().unwrap_or(0)
                }
                // What cannot be seen lies on one side of the frame.
                None => {
                    let [width, height] = settings.resolution.map(|side| side as i32);
                    [x1 + 1, width - x0, y1 + 1, height - y0].into_iter().min().unwrap_or(0)
                }
            };
            if apart > 0 {
                (num, most) = (num + 1, most.max(apart));
            }
        }
    }
    (num, most, blocks)
}

#[test]
fn no_grid_leaves_the_bound_of_its_piece() {
    let mut blocks = 0;
    for seed in 0..40 {
        let settings = Settings { shading_rate_scale: 8.0, ..small(160, 120, [1, 1]) };
        for scene in [closed::crack_scene(seed), closed::scene(Kind::Balloon, seed)] {
            let (num, most, lattices) = outside(&scene, &settings);
            assert_eq!(num, 0, "seed {seed}: up to {most} px outside");
            blocks += lattices;
        }
    }
    assert!(blocks > 20, "{blocks} blocks");
}
