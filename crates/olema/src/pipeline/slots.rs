//! Slots: the grids that a tile's records name, and what is known of their vertices.
//!
//! In: grids as they are drawn. Out: their numbers, their canonical order, their colours once these are known, and
//! which of their vertices something visible uses.

use std::cmp::Ordering;
use std::collections::HashMap;
use std::sync::Arc;

use crate::sampling::Payload;
use crate::scene::ShadingInterpolation;

use super::grid::{Grid, GridKey, triangles};
use super::shade::{Colors, ShadedGrid, VertexSet};

/// Grids of a tile, by the slot that records name them with.
#[derive(Debug, Default)]
pub struct GridSlots {
    slots: Vec<Slot>,
    known: HashMap<GridKey, u32>,
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
    /// Forgets everything.
    pub fn clear(&mut self) {
        self.slots.clear();
        self.known.clear();
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

/// Vertices that visible micropolygons use, by slot.
#[derive(Debug, Default)]
pub struct UsedVertices {
    by_slot: Vec<VertexSet>,
}

impl UsedVertices {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.by_slot.clear();
    }

    /// Adds what the colour of a hit is made from.
    pub fn insert(&mut self, grid: &Grid, payload: Payload) {
        let slot = payload.slot() as usize;
        if self.by_slot.len() <= slot {
            self.by_slot.resize(slot + 1, VertexSet::default());
        }
        let set = &mut self.by_slot[slot];
        match grid.look.interpolation {
            _ if grid.look.matte => {}
            ShadingInterpolation::Constant => {
                set.insert(grid.corners(payload.micropolygon() as usize)[0]);
            }
            ShadingInterpolation::Smooth => {
                let triangle = triangles(grid, payload.micropolygon() as usize)[payload.triangle() as usize];
                triangle.into_iter().for_each(|vertex| set.insert(vertex));
            }
        }
    }

    /// Slots and their vertices, where there are any.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &VertexSet)> {
        (0..).zip(&self.by_slot).filter(|(_, set)| !set.is_empty())
    }
}
