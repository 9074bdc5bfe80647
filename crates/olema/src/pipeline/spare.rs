//! Spare: lists of grids that are gone, for grids to come.
//!
//! In: grids that nothing needs any more. Out: their lists, empty, with the room they had. A grid has nine, and giving them
//! back to the system and asking for others took as long as shading.

use glam::Vec4;

use crate::math::Vec3s;

use super::shade::VertexSet;
use super::waiting::RasterLists;

/// Lists of one grid, empty.
#[derive(Debug, Default)]
pub struct GridLists {
    /// Where vertices are on the raster.
    pub on_raster: RasterLists,
    /// The same, packed.
    pub packed: Vec<i16>,
    /// Depth.
    pub depth: Vec<f32>,
    /// Positions that shaders see.
    pub p: Vec3s,
    /// Normals that shaders see.
    pub n: Vec3s,
    /// Colours.
    pub color: Vec<Vec4>,
    /// Vertices that are shaded.
    pub shaded: VertexSet,
    /// Vertices that are seen.
    pub seen: VertexSet,
}

impl GridLists {
    fn bytes(&self) -> usize {
        self.on_raster.bytes()
            + 2 * self.packed.capacity()
            + 4 * self.depth.capacity()
            + self.p.bytes()
            + self.n.bytes()
            + 16 * self.color.capacity()
    }
}

/// Lists that wait for a grid.
#[derive(Debug, Default)]
pub struct Spare {
    lists: Vec<GridLists>,
    /// Of grids that were packed.
    on_raster: Vec<RasterLists>,
    bytes: usize,
}

impl Spare {
    /// What is kept at most: about the grids of a tile.
    const MOST_BYTES: usize = 1 << 18;
    /// How many lists of packed grids are kept at most.
    const MOST_PACKED: usize = 2;

    /// Keeps lists, while there is room.
    pub fn keep(&mut self, lists: GridLists) {
        let bytes = lists.bytes();
        if self.bytes + bytes <= Self::MOST_BYTES {
            self.bytes += bytes;
            self.lists.push(lists);
        }
    }

    /// Keeps the lists of a grid that was packed: those of few, since they come back as soon as the next one is.
    pub fn keep_on_raster(&mut self, mut lists: RasterLists) {
        lists.clear();
        if lists.bytes() > 0 && self.on_raster.len() < Self::MOST_PACKED {
            self.on_raster.push(lists);
        }
    }

    /// Lists for a grid of `num_vertices` over all keys: such as had about as many, or new ones, as a grid may live long.
    pub fn take(&mut self, num_vertices: usize) -> GridLists {
        let about = num_vertices..=num_vertices + num_vertices / 8;
        let fits = |lists: &GridLists| about.contains(&lists.depth.capacity());
        let mut lists = match self.lists.iter().rposition(fits) {
            Some(ix) => self.lists.swap_remove(ix),
            None => GridLists::default(),
        };
        self.bytes -= lists.bytes();
        if lists.on_raster.bytes() == 0 {
            lists.on_raster = self.on_raster.pop().unwrap_or_default();
        }
        lists
    }
}
