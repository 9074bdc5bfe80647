//! Waiting: where a blurred grid's vertices are on the raster, in 16 bits while the grid waits for its next tile.
//!
//! In: lists of x, y and the circle of confusion over all keys. Out: the same as differences from an origin, half as large,
//! and the lists again with the same bits when a tile draws the grid. A grid that stands still or reaches over 256 px or more
//! stays wide.

use crate::math::simd::SimdLevel;

use super::grid::Grid;

/// Raster x and y and the circle of confusion, in 1/256 px, key after key; the last may be empty.
#[derive(Debug, Clone, Default)]
pub struct RasterLists {
    /// To the right.
    pub x: Vec<i32>,
    /// Down.
    pub y: Vec<i32>,
    /// Signed radius.
    pub coc: Vec<i32>,
}

impl RasterLists {
    /// Empties all lists, which keep their room.
    pub fn clear(&mut self) {
        [&mut self.x, &mut self.y, &mut self.coc].into_iter().for_each(Vec::clear);
    }

    /// Bytes that they have room for.
    pub fn bytes(&self) -> usize {
        4 * (self.x.capacity() + self.y.capacity() + self.coc.capacity())
    }
}

/// [`RasterLists`] in 16 bits.
#[derive(Debug, Clone)]
pub struct Packed {
    /// What each list counts from.
    origin: [i32; 3],
    /// Entries of a list.
    len: usize,
    /// x, y and, where there are any, circles of confusion, one list after the other.
    values: Vec<i16>,
}

impl Packed {
    /// Packs lists, into `values`; nothing where they do not fit.
    pub fn new(level: SimdLevel, lists: &RasterLists, mut values: Vec<i16>) -> Option<Self> {
        let RasterLists { x, y, coc } = lists;
        let all = [(x, origin(level, x)?), (y, origin(level, y)?), (coc, origin(level, coc)?)];
        values.clear();
        values.reserve_exact(x.len() + y.len() + coc.len());
        for (list, origin) in all {
            let first = values.len();
            values.resize(first + list.len(), 0);
            let to = &mut values[first..];
            level.run(
                #[inline(always)]
                || to.iter_mut().zip(list).for_each(|(to, &value)| *to = (value - origin) as i16),
            );
        }
        Some(Packed { origin: all.map(|(_, origin)| origin), len: x.len(), values })
    }

    /// The lists.
    pub fn unpack(&self, level: SimdLevel, lists: &mut RasterLists) {
        let (x, rest) = self.values.split_at(self.len);
        let (y, coc) = rest.split_at(self.len);
        let RasterLists { x: to_x, y: to_y, coc: to_coc } = lists;
        for ((from, to), origin) in [(x, to_x), (y, to_y), (coc, to_coc)].into_iter().zip(self.origin) {
            to.resize(from.len(), 0);
            level.run(
                #[inline(always)]
                || to.iter_mut().zip(from).for_each(|(to, &from)| *to = origin + i32::from(from)),
            );
        }
    }

    /// Its memory.
    pub fn into_values(self) -> Vec<i16> {
        self.values
    }

    /// Whether there are no circles of confusion.
    pub fn is_sharp(&self) -> bool {
        self.values.len() == 2 * self.len
    }
}

/// From where all values are within 16 bits; nothing where they are too far from each other.
fn origin(level: SimdLevel, values: &[i32]) -> Option<i32> {
    let (least, most) = level.run(
        #[inline(always)]
        || {
            let (mut least, mut most) = (i32::MAX, i32::MIN);
            for &value in values {
                (least, most) = (least.min(value), most.max(value));
            }
            (least, most)
        },
    );
    if values.is_empty() {
        return Some(0);
    }
    let fits = most.checked_sub(least)? <= i32::from(u16::MAX);
    // The least is -2^15 from it.
    fits.then(|| least.checked_add(1 << 15)).flatten()
}

impl Grid {
    /// Packs where the vertices are into `values`, if it can, and gives the lists away that are not needed then.
    pub fn pack(&mut self, level: SimdLevel, values: Vec<i16>) -> RasterLists {
        // What is clipped needs its lists, and of what stands still, with half as many of them, the little room that this
        // would save costs 1.5 % of a frame.
        if self.has_slow() || !self.is_blurred() {
            return RasterLists::default();
        }
        self.packed = Packed::new(level, &self.on_raster, values);
        if self.packed.is_some() { std::mem::take(&mut self.on_raster) } else { RasterLists::default() }
    }

    /// Where the vertices are; `room` is used where that is packed.
    pub fn lists<'a>(&'a self, level: SimdLevel, room: &'a mut RasterLists) -> &'a RasterLists {
        match &self.packed {
            Some(packed) => {
                packed.unpack(level, room);
                room
            }
            None => &self.on_raster,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::hash32;

    #[test]
    fn lists_come_back_with_their_bits_or_stay_wide() {
        let list = |seed: u32, from: i32, spread: u32| -> Vec<i32> {
            (0..77).map(|n| from + (hash32(seed + n) % spread) as i32).collect()
        };
        for level in SimdLevel::all() {
            for coc in [vec![], list(3, -900, 1800)] {
                let lists =
                    RasterLists { x: list(1, 4_000_000, 60_000), y: list(2, -3_000_000, 65_536), coc };
                let packed = Packed::new(level, &lists, vec![7; 9]).expect("less than 256 px");
                assert_eq!(packed.is_sharp(), lists.coc.is_empty());
                let mut unpacked = RasterLists { x: vec![5; 200], ..RasterLists::default() };
                packed.unpack(level, &mut unpacked);
                assert_eq!([&unpacked.x, &unpacked.y, &unpacked.coc], [&lists.x, &lists.y, &lists.coc]);
                for far in [70_000, i32::MAX, i32::MIN] {
                    let mut wide = lists.clone();
                    wide.y[9] = wide.y[9].wrapping_add(far);
                    assert!(Packed::new(level, &wide, Vec::new()).is_none());
                    if let Some(coc) = wide.coc.first_mut() {
                        (wide.y, *coc) = (lists.y.clone(), 70_000);
                        assert!(Packed::new(level, &wide, Vec::new()).is_none());
                    }
                }
            }
        }
    }
}
