//! Slots: the grids that a tile's records name, and what is known of their vertices.
//!
//! In: grids as they are drawn. Out: their numbers, their canonical order, their colours once these are known, and
//! which of their vertices something visible uses.

use std::cmp::Ordering;
use std::sync::Arc;

use crate::math::map::Map;
use crate::sampling::Payload;
use crate::scene::ShadingInterpolation;

use super::grid::{Grid, GridKey};
use super::shade::{Colors, ShadedGrid, VertexSet};

/// Grids of a tile, by the slot that records name them with.
#[derive(Debug, Default)]
pub struct GridSlots {
    slots: Vec<Slot>,
    known: Map<GridKey, u32>,
}

/// What a slot number means.
#[derive(Debug)]
struct Slot {
    key: GridKey,
    /// `None` once no record names it.
    grid: Option<Arc<ShadedGrid>>,
    /// Where they are known already.
    colors: Option<Arc<Colors>>,
}

/// All slots of a tile are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SlotsFull;

impl GridSlots {
    /// Forgets everything, and lets go of all grids.
    pub fn drain(&mut self) -> impl Iterator<Item = Arc<ShadedGrid>> + '_ {
        self.known.clear();
        self.slots.drain(..).filter_map(|Slot { grid, .. }| grid)
    }

    /// Gives `grid` a slot, the one it had in an earlier pass if it was drawn in one; and whether that is a new one.
    ///
    /// # Errors
    /// [`SlotsFull`] where the payload has no number left for it.
    pub fn insert(
        &mut self,
        grid: Arc<ShadedGrid>,
        colors: Option<Arc<Colors>>,
    ) -> Result<(u32, bool), SlotsFull> {
        let next = self.slots.len() as u32;
        let key = grid.grid.key;
        if let Some(&slot) = self.known.get(&key) {
            let known = &mut self.slots[slot as usize];
            *known = Slot { key, grid: Some(grid), colors: colors.or(known.colors.take()) };
            return Ok((slot, false));
        }
        if next >= Payload::NUM_SLOTS {
            return Err(SlotsFull);
        }
        self.known.insert(key, next);
        self.slots.push(Slot { key, grid: Some(grid), colors });
        Ok((next, true))
    }

    /// Takes back the slot that was given last, which no record names.
    pub(super) fn take_back(&mut self) {
        if let Some(last) = self.slots.pop() {
            self.known.remove(&last.key);
        }
    }

    /// The grid of a slot.
    pub fn grid(&self, slot: u32) -> Option<&Arc<ShadedGrid>> {
        self.slots.get(slot as usize)?.grid.as_ref()
    }

    /// Says what the vertices of a slot's grid look like.
    pub fn set_colors(&mut self, slot: u32, colors: Arc<Colors>) {
        self.slots[slot as usize].colors = Some(colors);
    }

    /// The grid of a record and its colours.
    pub fn surface(&self, payload: Payload) -> Option<(&Grid, &Colors)> {
        let slot = self.slots.get(payload.slot() as usize)?;
        Some((&slot.grid.as_ref()?.grid, slot.colors.as_ref()?))
    }

    /// The grid and colours of every slot.
    pub fn surfaces(&self) -> impl Iterator<Item = Option<(&Grid, &Colors)>> {
        self.slots.iter().map(|slot| Some((&slot.grid.as_ref()?.grid, slot.colors.as_deref()?)))
    }

    /// Number of slots taken.
    pub fn len(&self) -> usize {
        self.slots.len()
    }

    /// Whether no slot is taken.
    pub fn is_empty(&self) -> bool {
        self.slots.is_empty()
    }

    /// Lets go of grids that no record names any more; their slots stay taken, so that payloads keep their
    /// meaning.
    pub fn retain_used(&mut self, used: impl Iterator<Item = Payload>) {
        let mut is_used = vec![false; self.slots.len()];
        for payload in used {
            if let Some(flag) = is_used.get_mut(payload.slot() as usize) {
                *flag = true;
            }
        }
        for (slot, used) in self.slots.iter_mut().zip(is_used) {
            if !used {
                (slot.grid, slot.colors) = (None, None);
            }
        }
    }

    /// Canonical order of two hits, for equal depths.
    pub fn order(&self, a: Payload, b: Payload) -> Ordering {
        let key = |p: Payload| self.slots.get(p.slot() as usize).map(|slot| slot.key);
        key(a)
            .cmp(&key(b))
            .then(a.micropolygon().cmp(&b.micropolygon()))
            .then(a.triangle().cmp(&b.triangle()))
    }
}

/// Triangles that visible records name, by slot, and so the vertices that they use.
///
/// A bit for each triangle: that is one word to change for a record, where setting its vertices was a division and
/// three words; vertices are found row by row, at the end.
#[derive(Debug, Default)]
pub struct UsedVertices {
    /// Where each slot's words begin; [`UsedVertices::NONE`] while it has none.
    first: Vec<u32>,
    /// For each 64 micropolygons of a slot a word for their first triangles and one for their second.
    words: Vec<u64>,
}

impl UsedVertices {
    const NONE: u32 = u32::MAX;

    /// Forgets all.
    pub fn clear(&mut self) {
        self.first.clear();
        self.words.clear();
    }

    /// Adds what the colour of a hit is made from.
    #[inline(always)]
    pub fn insert(&mut self, grid: &Grid, payload: Payload) {
        if !self.insert_known(payload) {
            self.begin(grid, payload.slot() as usize);
            self.insert_known(payload);
        }
    }

    /// The same where the slot has words; else nothing, and returns false.
    #[inline(always)]
    pub(super) fn insert_known(&mut self, payload: Payload) -> bool {
        match self.first.get(payload.slot() as usize) {
            Some(&first) if first != Self::NONE => {
                let micropolygon = payload.micropolygon();
                let word = first + micropolygon / 64 * 2 + u32::from(payload.triangle());
                self.words[word as usize] |= 1 << (micropolygon % 64);
                true
            }
            _ => false,
        }
    }

    /// Makes room for a slot's triangles.
    #[cold]
    fn begin(&mut self, grid: &Grid, slot: usize) {
        if self.first.len() <= slot {
            self.first.resize(slot + 1, Self::NONE);
        }
        self.first[slot] = self.words.len() as u32;
        // Two more, so that a row that begins in the last ones has others after it.
        let num_words = 2 * grid.num_micropolygons().div_ceil(64) + 2;
        self.words.resize(self.words.len() + num_words, 0);
    }

    /// Slots that records name.
    pub fn slots(&self) -> impl Iterator<Item = u32> + '_ {
        (0..).zip(&self.first).filter(|(_, first)| **first != Self::NONE).map(|(slot, _)| slot)
    }

    /// The vertices of a slot's grid that the colours of its hits are made from, into `vertices`.
    pub fn find(&self, slot: u32, grid: &Grid, vertices: &mut VertexSet) {
        vertices.clear();
        if grid.look.matte {
            return;
        }
        vertices.make_room(grid.num_vertices());
        let words = &self.words[self.first[slot as usize] as usize..];
        let is_flat = grid.look.interpolation == ShadingInterpolation::Constant;
        let (columns, rows) = (grid.m as usize, grid.n as usize);
        for row in 0..rows {
            // Parts of a row whose vertices fit a word.
            for column in (0..columns).step_by(63) {
                let num = (columns - column).min(63);
                let [first, second] = [0, 1]
                    .map(|triangle| bits(words, triangle, row * columns + column) & (u64::MAX >> (64 - num)));
                // As in `Grid::corners` and `triangles`: (v0, v1, v2) and (v0, v2, v3).
                let (any, v0) = (first | second, row * (columns + 1) + column);
                if is_flat {
                    vertices.insert_word(v0, any);
                } else if any != 0 {
                    vertices.insert_word(v0, any | first << 1);
                    vertices.insert_word(v0 + columns + 1, any << 1 | second);
                }
            }
        }
    }
}

/// The bits of 64 micropolygons from `at` on, of their first or second triangles.
#[inline(always)]
fn bits(words: &[u64], triangle: usize, at: usize) -> u64 {
    let (word, shift) = (at / 64 * 2 + triangle, at % 64);
    // Two shifts, as one by 64 is none.
    words[word] >> shift | words[word + 2] << 1 << (63 - shift)
}

#[cfg(test)]
mod tests {
    use super::super::grid::{Look, triangles};
    use super::*;
    use crate::scene::Sides;

    fn grid([m, n]: [u32; 2], interpolation: ShadingInterpolation) -> Grid {
        let key = GridKey { primitive: 0, patch: 0, path: 1, block: [0; 2] };
        let look = Look { interpolation, sides: Sides::Two, front_is_positive: true, matte: false };
        Grid { m, n, keys: 1, ..Grid::empty(key, look, 0) }
    }

    /// Two grids, hits of each in turn, and the vertices that their triangles have.
    #[test]
    fn used_vertices_are_those_of_the_triangles_that_were_hit() {
        for interpolation in [ShadingInterpolation::Smooth, ShadingInterpolation::Constant] {
            let mut used = UsedVertices::default();
            let mut grids = [[7, 9], [1, 40]].map(|size| grid(size, interpolation));
            let mut expected = [VertexSet::default(), VertexSet::default()];
            for hit in 0..60u32 {
                let which = (hit % 2) as usize;
                let (slot, grid) = (which as u32 * 5 + 2, &grids[which]);
                let micropolygon = (hit * 37) as usize % grid.num_micropolygons();
                let triangle = hit / 3 % 2;
                used.insert(grid, Payload::new(slot, micropolygon as u32, triangle as u8));
                let vertices = triangles(grid, micropolygon)[triangle as usize];
                let num = if interpolation == ShadingInterpolation::Constant { 1 } else { 3 };
                vertices[..num].iter().for_each(|&vertex| expected[which].insert(vertex));
            }
            assert_eq!(used.slots().collect::<Vec<_>>(), [2, 7]);
            for (which, slot) in [2, 7].into_iter().enumerate() {
                let mut found = VertexSet::default();
                used.find(slot, &grids[which], &mut found);
                assert_eq!(found.iter().collect::<Vec<_>>(), expected[which].iter().collect::<Vec<_>>());
            }
            grids[0].look.matte = true;
            let mut found = expected[0].clone();
            used.find(2, &grids[0], &mut found);
            assert!(found.is_empty());
        }
    }
}
