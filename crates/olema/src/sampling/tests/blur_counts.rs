use super::blurred::{Blurred, How, NoHits, scalar};
use crate::sampling::{Micropolygons, Rasterizer, Region, RegionSamples, SamplePattern};

const RASTERIZERS: [Rasterizer; 4] =
    [Rasterizer::Interval, Rasterizer::InterleaveUvt, Rasterizer::BoundingBox, Rasterizer::Simple];

/// Sample tests of a pixel-sized square that starts at `from` and ends at `to` (px), by each rasterizer; Simple
/// draws the pattern with K = 1.
fn tests(from: [f64; 2], to: [f64; 2], coc: f64, micropolygons: Micropolygons) -> [u64; 4] {
    let grid = Blurred::from_fn([1, 1], &[0.0, 1.0], |key, i, j| {
        let [x, y] = [from, to][key];
        [x + i as f64, y + j as f64]
    });
    let grid = if coc > 0.0 { grid.defocused(coc) } else { grid };
    RASTERIZERS.map(|rasterizer| {
        let pattern = four(if rasterizer == Rasterizer::Simple { 1 } else { 2 });
        let samples = RegionSamples::new(&pattern, Region::new(-8, 8, -8, 8));
        grid.draw(How { micropolygons, ..scalar(rasterizer) }, &pattern, &samples, &mut NoHits).tests
    })
}

/// M = 4 in cells of half a pixel; with K = 2, N = 16.
fn four(tile: u32) -> SamplePattern {
    super::pattern([2, 2], tile)
}

#[test]
fn micropolygons_worked_by_hand_take_exact_numbers_of_tests() {
    use Micropolygons::{Quads, Triangles};
    // A pixel, exactly. Interval: that pixel, 4 strata. InterleaveUvt: its tile, 16 tuples. BoundingBox: its 4
    // cells. Simple: that pixel, 4 tuples.
    assert_eq!(tests([0.0, 0.0], [0.0, 0.0], 0.0, Quads), [4, 16, 4, 4]);
    // Its two triangles have the same box.
    assert_eq!(tests([0.0, 0.0], [0.0, 0.0], 0.0, Triangles), [8, 32, 8, 8]);
    // Half a pixel right and down: 4 pixels, all of one tile, and still 4 cells.
    assert_eq!(tests([0.5, 0.5], [0.5, 0.5], 0.0, Quads), [16, 16, 4, 16]);
    // Half a pixel left and up: 4 pixels in 4 tiles.
    assert_eq!(tests([-0.5, -0.5], [-0.5, -0.5], 0.0, Quads), [16, 64, 4, 16]);
    // From pixel 0 to pixel 4. Interval: in quarter j of the shutter it overlaps pixels j and j + 1, one
    // stratum each: 4 x 2. InterleaveUvt: in quarters 0 and 2 it lies within a tile, in 1 and 3 across two,
    // 4 tuples each: 4 (1 + 2 + 1 + 2). BoundingBox: 5 pixels of 4 cells. Simple: 4 tuples, 2 pixels each.
    assert_eq!(tests([0.0, 0.0], [4.0, 0.0], 0.0, Quads), [8, 24, 20, 8]);
    // Along both axes: 4 x (2 x 2); 4 (1 + 4 + 1 + 4); 5 x 5 pixels of 4 cells; 4 x (2 x 2).
    assert_eq!(tests([0.0, 0.0], [4.0, 4.0], 0.0, Quads), [16, 40, 100, 16]);
    // The other way, to negative pixels: the same but for the tiles, in quarter 0 and 2 across two.
    assert_eq!(tests([0.0, 0.0], [-4.0, 0.0], 0.0, Quads), [8, 24, 20, 8]);
}

#[test]
fn a_defocused_micropolygon_takes_exact_numbers_of_tests() {
    // A pixel, and a circle of 2 px radius: the box is 5 x 5 pixels.
    let [interval, interleave, boundingbox, simple] =
        tests([0.0, 0.0], [0.0, 0.0], 2.0, Micropolygons::Quads);
    assert_eq!(boundingbox, 100);
    // A lens place u moves it by 2 u: from there, one pixel wide, to where the last place of the cell moves it.
    let overlapped = |[least, most]: [i16; 2], unit: i64| {
        let at = |u15: i16| (i64::from(u15) * 512 + 16_384) >> 15;
        ((at(most) + 255).div_euclid(256 * unit) - at(least).div_euclid(256 * unit) + 1) as u64
    };
    let pattern = four(2);
    let expected: u64 = (0..4)
        .map(|stratum| {
            let cell = pattern.stratum_bounds(stratum);
            overlapped(cell.u15, 1) * overlapped(cell.v15, 1)
        })
        .sum();
    assert_eq!(interval, expected);
    // A quarter of the lens each: at most from one end of a radius to the other, 2 px.
    assert!((16..=4 * 16).contains(&interval), "{interval}");
    let of_tuples = |pattern: &SamplePattern, unit: i64| -> u64 {
        let both = |u15: i16, v15: i16| overlapped([u15; 2], unit) * overlapped([v15; 2], unit);
        pattern.tuples().iter().map(|tuple| both(tuple.u15, tuple.v15)).sum()
    };
    assert_eq!(interleave, of_tuples(&pattern, 2));
    assert_eq!(simple, of_tuples(&four(1), 1));
    assert_eq!(simple, 16, "2 x 2 pixels each, off the grid");
}
