//! Connecting by topology: base quads of meshes, whose corners and edges have numbers.
//!
//! In: base quads, in the order of their patches. Out: entries of the `EdgeTable`.

use crate::geometry::subdivision::{BaseQuad, CornerId, Piece};
use crate::math::map::Map;

use super::connect::Connected;
use super::edges::{Along, Edge, EdgeTable, EdgeUse, NOBODY, Owner, Part};
use super::patch::SIDE_CORNERS;
use super::rate::Fineness;

/// Corners and edges of the patches connected so far, by topology.
#[derive(Default)]
pub(super) struct ByTopology {
    corners: Map<(u32, CornerId), u32>,
    edges: Map<(u32, u32), u32>,
}

impl ByTopology {
    /// Connects a base quad of a mesh's limit surface, which is a patch.
    pub fn connect(
        &mut self,
        table: &mut EdgeTable,
        limit: u32,
        quad: &BaseQuad,
        patch: u32,
        rate: Fineness,
    ) -> Connected {
        // A base quad's corners go round; a patch's are (0,0), (1,0), (0,1), (1,1).
        let ids = [quad.corners[0], quad.corners[1], quad.corners[3], quad.corners[2]];
        let corners: [u32; 4] = std::array::from_fn(|c| {
            let known = self.corners.get(&(limit, ids[c])).copied();
            let ix = table.corner(known, patch, c, rate);
            self.corners.insert((limit, ids[c]), ix);
            ix
        });
        let uses = std::array::from_fn(|side| {
            let edge = &quad.edges[side];
            let part = match edge.piece {
                Piece::Whole => Part::Whole,
                Piece::FirstHalf => Part::First,
                Piece::SecondHalf => Part::Second,
            };
            // Top and left run the other way round the quad.
            let along = Along { part, reversed: edge.reversed != (side >= 2) };
            let mut ends = SIDE_CORNERS[side].map(|c| corners[c]);
            if along.reversed {
                ends.reverse();
            }
            let owner = Owner { patch, side: side as u8, along };
            let ix = *self.edges.entry((limit, edge.edge)).or_insert_with(|| {
                table.edges.push(Edge {
                    owners: [NOBODY; 2],
                    halved: true,
                    users: 0,
                    corners: [u32::MAX; 2],
                    middle: u32::MAX,
                    fineness: rate,
                });
                table.edges.len() as u32 - 1
            });
            table.use_edge(ix, rate);
            let known = &mut table.edges[ix as usize];
            match part {
                Part::Whole => known.corners = ends,
                Part::First => (known.corners[0], known.middle) = (ends[0], ends[1]),
                Part::Second => (known.middle, known.corners[1]) = (ends[0], ends[1]),
            }
            // The first patch that has a half owns it.
            let (first, second) = (part != Part::Second, part != Part::First);
            for (owned, has) in known.owners.iter_mut().zip([first, second]) {
                if has && *owned == NOBODY {
                    *owned = owner;
                }
            }
            EdgeUse { edge: ix, along }
        });
        (corners, uses, 0.0)
    }
}
