//! Lanes against scalars, at every level.

use proptest::prelude::*;

use super::super::simd::{LanesKernel, SimdLevel};
use super::*;

struct Pairs<'a>(&'a [i32; LANES], &'a [i32; LANES]);

impl LanesKernel for Pairs<'_> {
    type Output = [[i32; LANES]; 9];

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Self::Output {
        let (a, b) = (lanes.load(self.0, 0), lanes.load(self.1, 0));
        let mut out = [[0; LANES]; 9];
        lanes.store(lanes.scale2(a, b), &mut out[0], 0);
        lanes.store(lanes.dot2(a, b), &mut out[1], 0);
        lanes.store(lanes.compress(a, lanes.gt(b, lanes.splat(0))), &mut out[2], 0);
        lanes.store(lanes.lookup(a, b), &mut out[3], 0);
        let by = lanes.and(b, lanes.splat(31));
        let shifted = lanes.xor(lanes.shl_each(a, by), lanes.shr_each(a, by));
        lanes.store(shifted, &mut out[4], 0);
        let (even, odd) = lanes.deinterleave(a, b);
        lanes.store(even, &mut out[5], 0);
        lanes.store(odd, &mut out[6], 0);
        let (low, high) = lanes.interleave(a, b);
        lanes.store(low, &mut out[7], 0);
        lanes.store(high, &mut out[8], 0);
        out
    }
}

proptest! {
    #[test]
    fn pairs_are_what_scalars_are_on_every_level(a: [[i16; 2]; LANES], b: [[i16; 2]; LANES]) {
        let pack = |v: [[i16; 2]; LANES]| v.map(|[x, y]| i32::from(x) & 0xffff | i32::from(y) << 16);
        let scale = |a: i16, b: i16| ((i32::from(a) * i32::from(b) + (1 << 14)) >> 15) as i16;
        let scaled = pack(std::array::from_fn(|i| [0, 1].map(|c| scale(a[i][c], b[i][c]))));
        let dots = std::array::from_fn(|i| {
            let product = |c: usize| i32::from(a[i][c]) * i32::from(b[i][c]);
            product(0).wrapping_add(product(1))
        });
        let (a, b) = (pack(a), pack(b));
        let mut kept: Vec<i32> = (0..LANES).filter(|&i| b[i] > 0).map(|i| a[i]).collect();
        kept.resize(LANES, 0);
        for level in SimdLevel::all() {
            let [scaled_too, dots_too, kept_too, found, shifted, even, odd, low, high] =
                level.run_lanes(Pairs(&a, &b));
            prop_assert_eq!(scaled_too, scaled, "{:?}", level);
            prop_assert_eq!(dots_too, dots, "{:?}", level);
            prop_assert_eq!(&kept_too[..], &kept[..], "{:?}", level);
            let both: Vec<i32> = a.iter().chain(&b).copied().collect();
            let in_turn: Vec<i32> = low.into_iter().chain(high).collect();
            for i in 0..LANES {
                prop_assert_eq!([even[i], odd[i]], [both[2 * i], both[2 * i + 1]], "{:?}", level);
                prop_assert_eq!(&in_turn[2 * i..2 * i + 2], &[a[i], b[i]], "{:?}", level);
                prop_assert_eq!(found[i], a[(b[i] & 15) as usize], "{:?}", level);
                prop_assert_eq!(shifted[i], a[i] << (b[i] & 31) ^ a[i] >> (b[i] & 31), "{:?}", level);
            }
        }
    }
}
