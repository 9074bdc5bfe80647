//! Edges: what connecting finds out of how patches meet.
//!
//! In: edges and corners, as [`connect`](super::connect) adds them. Out: who owns each, how finely it is diced, who has it.

use super::known::Known;
use super::patch::PatchTable;
use super::rate::Fineness;

/// How much of an edge a side of a patch is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Part {
    /// All of it.
    #[default]
    Whole,
    /// From its start to its middle.
    First,
    /// From its middle to its end.
    Second,
}

/// How a side of a patch runs along an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Along {
    /// How much of the edge it is.
    pub part: Part,
    /// Whether it runs against the edge's direction.
    pub reversed: bool,
}

impl Along {
    /// The edge's parameter `numerator / denominator`, which must lie on the side, as one of the side.
    pub fn own(self, numerator: u64, denominator: u64) -> (u64, u64) {
        let along = match self.part {
            Part::Whole => numerator,
            Part::First => 2 * numerator,
            Part::Second => 2 * numerator - denominator,
        };
        (if self.reversed { denominator - along } else { along }, denominator)
    }

    /// Whether the edge's parameter `numerator / denominator` lies on the side.
    pub fn has(self, numerator: u64, denominator: u64) -> bool {
        match self.part {
            Part::Whole => true,
            Part::First => 2 * numerator <= denominator,
            Part::Second => 2 * numerator >= denominator,
        }
    }
}

/// A patch's use of an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct EdgeUse {
    /// Index of the edge.
    pub edge: u32,
    /// How the patch's side runs along it.
    pub along: Along,
}

/// A side of a patch that runs along an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Owner {
    /// The patch.
    pub patch: u32,
    /// Its side.
    pub side: u8,
    /// How that runs along the edge.
    pub along: Along,
}

/// Not known yet.
pub(super) const NOBODY: Owner =
    Owner { patch: u32::MAX, side: 0, along: Along { part: Part::Whole, reversed: false } };

/// An edge, owned by one patch and shared by any number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// Owners of its first and second half; the same patch unless one that owns has only a half of it.
    pub owners: [Owner; 2],
    /// Whether some patch ends at its middle: it is halved before anything else then, for all of them.
    pub halved: bool,
    /// How many patches have it.
    pub users: u32,
    /// Corners at its start and end.
    pub corners: [u32; 2],
    /// The corner at its middle, where it is halved.
    pub middle: u32,
    /// Finest of its patches.
    pub fineness: Fineness,
}

/// A corner, owned by one patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// The patch whose point it is.
    pub owner: u32,
    /// The owner's corner.
    pub corner: u8,
    /// Finest shading rate of its patches.
    pub shading_rate: f32,
}

/// A patch's corner.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CornerUse {
    /// The patch.
    pub patch: u32,
    /// Its corner.
    pub corner: u8,
    /// +1 where its normal is dPdu x dPdv, -1 where it is the opposite.
    pub sign: f32,
}

/// A patch's side along an edge.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SideUse {
    /// The side.
    pub of: Owner,
    /// +1 where the patch's normal is dPdu x dPdv, -1 where it is the opposite.
    pub sign: f32,
}

/// Edges and corners of all patches.
#[derive(Debug, Default)]
pub struct EdgeTable {
    /// Edges, in the order of their owners.
    pub edges: Vec<Edge>,
    /// Corners, in the order of their owners.
    pub corners: Vec<Corner>,
    /// What was measured of them.
    pub known: Known,
    /// Where the owners' normals stand for all.
    smooth_edges: Vec<bool>,
    smooth_corners: Vec<bool>,
    edge_users: Lists<SideUse>,
    corner_users: Lists<CornerUse>,
}

/// Lists of different lengths, end to end. Empty where nobody asks for them.
#[derive(Debug, Clone, Default)]
struct Lists<T> {
    starts: Vec<u32>,
    items: Vec<T>,
}

impl<T: Copy + Default> Lists<T> {
    /// Sorts (list, item) pairs into lists; within a list the order stays.
    fn new(num_lists: usize, pairs: impl Iterator<Item = (u32, T)> + Clone) -> Self {
        let mut starts = vec![0u32; num_lists + 1];
        pairs.clone().for_each(|(list, _)| starts[list as usize + 1] += 1);
        for list in 0..num_lists {
            starts[list + 1] += starts[list];
        }
        let mut next = starts.clone();
        let mut items = vec![T::default(); starts[num_lists] as usize];
        for (list, item) in pairs {
            items[next[list as usize] as usize] = item;
            next[list as usize] += 1;
        }
        Lists { starts, items }
    }

    fn get(&self, list: u32) -> &[T] {
        match self.starts.get(list as usize..list as usize + 2) {
            Some(range) => &self.items[range[0] as usize..range[1] as usize],
            None => &[],
        }
    }
}

impl EdgeTable {
    /// Edges that two or more patches share.
    pub fn num_welds(&self) -> usize {
        self.edges.iter().filter(|e| e.users > 1).count()
    }

    /// Notes whose normals meet at each edge and corner, for those who displace. `sign` is that of a primitive's normals.
    pub fn list_users(&mut self, table: &PatchTable, sign: impl Fn(u32) -> f32 + Copy) {
        let EdgeTable { smooth_edges, smooth_corners, .. } = self;
        *smooth_edges = vec![true; self.edges.len()];
        *smooth_corners = vec![true; self.corners.len()];
        for patch in &table.patches {
            for ix in 0..4 {
                smooth_edges[patch.edges[ix].edge as usize] &= patch.smooth.side(ix);
                smooth_corners[patch.corners[ix] as usize] &= patch.smooth.corner(ix);
            }
        }
        let (smooth_edges, smooth_corners) = (&*smooth_edges, &*smooth_corners);
        let patches = || table.patches.iter().zip(0u32..);
        let sides = patches().flat_map(|(patch, ix)| {
            let sign = sign(patch.primitive);
            let side = move |(used, side): (&EdgeUse, u8)| {
                (used.edge, SideUse { of: Owner { patch: ix, side, along: used.along }, sign })
            };
            let all = patch.edges.iter().zip(0u8..);
            all.filter(|(used, _)| !smooth_edges[used.edge as usize]).map(side)
        });
        let corners = patches().flat_map(|(patch, ix)| {
            let sign = sign(patch.primitive);
            let corner = move |(&id, corner): (&u32, u8)| (id, CornerUse { patch: ix, corner, sign });
            let all = patch.corners.iter().zip(0u8..);
            all.filter(|(id, _)| !smooth_corners[**id as usize]).map(corner)
        });
        self.edge_users = Lists::new(self.edges.len(), sides);
        self.corner_users = Lists::new(self.corners.len(), corners);
    }

    /// Sides along an edge, in the order of their patches, once [`Self::list_users`] has run; `None` where the owners'
    /// normals are those of all, by the way the surface was made.
    pub fn edge_users(&self, edge: u32) -> Option<&[SideUse]> {
        (!self.smooth_edges[edge as usize]).then(|| self.edge_users.get(edge))
    }

    /// Corners at a corner, in the order of their patches, once [`Self::list_users`] has run; `None` where the owner's normal
    /// is that of all.
    pub fn corner_users(&self, corner: u32) -> Option<&[CornerUse]> {
        (!self.smooth_corners[corner as usize]).then(|| self.corner_users.get(corner))
    }

    /// Adds a corner of a patch, or lets a known one have it.
    pub(super) fn corner(
        &mut self,
        known: Option<u32>,
        owner: u32,
        corner: usize,
        fineness: Fineness,
    ) -> u32 {
        let shading_rate = fineness.shading_rate;
        match known {
            Some(ix) => {
                let corner = &mut self.corners[ix as usize];
                corner.shading_rate = corner.shading_rate.min(shading_rate);
                ix
            }
            None => {
                self.corners.push(Corner { owner, corner: corner as u8, shading_rate });
                self.corners.len() as u32 - 1
            }
        }
    }

    /// Lets a patch have an edge.
    pub(super) fn use_edge(&mut self, edge: u32, fineness: Fineness) {
        let edge = &mut self.edges[edge as usize];
        edge.users += 1;
        edge.fineness = edge.fineness.finest(fineness);
    }
}
