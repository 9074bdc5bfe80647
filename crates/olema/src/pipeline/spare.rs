//! Spare: lists of grids that are gone, for grids to come.
//!
//! In: grids that nothing needs any more. Out: their lists, empty, with the room they had. A grid has nine, and giving them
//! back to the system and asking for others took as long as shading.

use glam::Vec4;

use crate::math::Vec3s;

use super::shade::VertexSet;

/// Lists of one grid, empty.
#[derive(Debug, Default)]
pub struct GridLists {
    /// Raster x.
    pub x: Vec<i32>,
    /// Raster y.
    pub y: Vec<i32>,
    /// Depth.
    pub depth: Vec<f32>,
    /// Circles of confusion.
    pub coc: Vec<i32>,
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
        let on_raster = self.x.capacity() + self.y.capacity() + self.depth.capacity() + self.coc.capacity();
        4 * on_raster + self.p.bytes() + self.n.bytes() + 16 * self.color.capacity()
    }
}

/// Lists that wait for a grid.
#[derive(Debug, Default)]
pub struct Spare {
    lists: Vec<GridLists>,
    bytes: usize,
}

impl Spare {
    /// What is kept at most: about the grids of a tile.
    const MOST_BYTES: usize = 1 << 19;

    /// Keeps lists, while there is room.
    pub fn keep(&mut self, lists: GridLists) {
        let bytes = lists.bytes();
        if self.bytes + bytes <= Self::MOST_BYTES {
            self.bytes += bytes;
            self.lists.push(lists);
        }
    }

    /// Lists for a grid of `num_vertices` over all keys: such as had about as many, or new ones, as a grid may live long.
    pub fn take(&mut self, num_vertices: usize) -> GridLists {
        let fits = |lists: &GridLists| {
            (num_vertices..=num_vertices + num_vertices / 8).contains(&lists.x.capacity())
        };
        let Some(ix) = self.lists.iter().rposition(fits) else {
            return GridLists::default();
        };
        let lists = self.lists.swap_remove(ix);
        self.bytes -= lists.bytes();
        lists
    }
}
