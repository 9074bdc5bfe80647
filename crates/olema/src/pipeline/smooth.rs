//! Smooth: where a surface goes on across the sides of a patch without a fold, by the way it was made.
//!
//! In: the basis of a sheet, or the topology of a mesh. Out: sides and corners of patches at which all that meet there have
//! the same normals. A point there is displaced along its owner's normal alone; elsewhere along the sum of all normals, for
//! which all patches there have to be evaluated. The sum is right anywhere, so a patch of which nothing is known is not smooth.

use crate::geometry::bezier::to_bezier;
use crate::geometry::subdivision::{BaseQuad, EdgeKind};
use crate::scene::{PatchBasis, PatchKind, PatchMesh, Scheme};

/// Sides next to each corner, both counted as a patch counts them.
const SIDES_AT: [[usize; 2]; 4] = [[0, 3], [0, 1], [2, 3], [1, 2]];

/// Which sides and corners of a patch are smooth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Smooth {
    /// A bit for each side; four bits on, one for each corner.
    bits: u8,
}

impl Smooth {
    /// Of sides, and of corners that are no tips.
    fn new(sides: [bool; 4], is_tip: [bool; 4]) -> Self {
        let mut bits = 0;
        for (side, is_smooth) in sides.into_iter().enumerate() {
            bits |= u8::from(is_smooth) << side;
        }
        for (corner, at) in SIDES_AT.into_iter().enumerate() {
            let is_smooth = at.into_iter().all(|side| sides[side]) && !is_tip[corner];
            bits |= u8::from(is_smooth) << (4 + corner);
        }
        Smooth { bits }
    }

    /// Of a base quad of a limit surface.
    pub fn of_quad(scheme: Scheme, quad: &BaseQuad) -> Self {
        if scheme == Scheme::Bilinear {
            return Smooth::default();
        }
        let sides = quad.edges.map(|edge| matches!(edge.kind, EdgeKind::Smooth | EdgeKind::SemiSharp));
        // A base quad's corners go round.
        let [a, b, c, d] = quad.tips;
        Smooth::new(sides, [a, b, d, c])
    }

    /// Whether all normals along a side are those of the other patches there.
    pub fn side(self, side: usize) -> bool {
        self.bits >> side & 1 != 0
    }

    /// The same of a corner.
    pub fn corner(self, corner: usize) -> bool {
        self.bits >> (4 + corner) & 1 != 0
    }
}

/// What is known of all patches of a sheet.
#[derive(Debug, Clone, Copy)]
pub struct SheetSmooth {
    /// Across lines of constant u, and of constant v.
    across: [bool; 2],
    wraps: [bool; 2],
    /// Patches along u and v.
    size: [usize; 2],
}

impl SheetSmooth {
    /// Of a sheet of `size` patches.
    pub fn new(mesh: &PatchMesh, size: [usize; 2]) -> Self {
        let wraps = [mesh.wrap_u, mesh.wrap_v];
        let across = match &*mesh.kind {
            // Nothing goes on beyond a single patch.
            PatchKind::Bicubic { u, v } if size != [1, 1] || wraps != [false; 2] => {
                [u, v].map(is_smooth_basis)
            }
            _ => [false; 2],
        };
        SheetSmooth { across, wraps, size }
    }

    /// Of the patch in a column and a row.
    pub fn of_patch(self, [column, row]: [usize; 2]) -> Smooth {
        let SheetSmooth { across, wraps, size } = self;
        let sides = [
            across[1] && (row > 0 || wraps[1]),
            across[0] && (column + 1 < size[0] || wraps[0]),
            across[1] && (row + 1 < size[1] || wraps[1]),
            across[0] && (column > 0 || wraps[0]),
        ];
        Smooth::new(sides, [false; 4])
    }
}

/// Whether a segment ends where the next one begins, with the same derivative, whatever the control points are.
fn is_smooth_basis(basis: &PatchBasis) -> bool {
    let bezier = to_bezier(basis);
    let step = basis.step as usize;
    let weight =
        |weights: &[f64; 4], ix: Option<usize>| ix.map_or(0.0, |ix| weights.get(ix).copied().unwrap_or(0.0));
    let difference = |to: usize, from: usize| [0, 1, 2, 3].map(|ix| bezier[to][ix] - bezier[from][ix]);
    let agree = |end: &[f64; 4], start: &[f64; 4]| {
        (0..4 + step).all(|ix| {
            let (end, start) = (weight(end, Some(ix)), weight(start, ix.checked_sub(step)));
            (end - start).abs() < 1e-6
        })
    };
    agree(&bezier[3], &bezier[0]) && agree(&difference(3, 2), &difference(1, 0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn basis(scale: f32, rows: [[f32; 4]; 4], step: u32) -> PatchBasis {
        PatchBasis { matrix: rows.map(|row| row.map(|c| c * scale)), step }
    }

    #[test]
    fn splines_are_smooth_and_bezier_curves_are_not() {
        let b_spline =
            [[-1.0, 3.0, -3.0, 1.0], [3.0, -6.0, 3.0, 0.0], [-3.0, 0.0, 3.0, 0.0], [1.0, 4.0, 1.0, 0.0]];
        let catmull_rom =
            [[-1.0, 3.0, -3.0, 1.0], [2.0, -5.0, 4.0, -1.0], [-1.0, 0.0, 1.0, 0.0], [0.0, 2.0, 0.0, 0.0]];
        assert!(is_smooth_basis(&basis(1.0 / 6.0, b_spline, 1)));
        assert!(is_smooth_basis(&basis(0.5, catmull_rom, 1)));
        assert!(!is_smooth_basis(&basis(1.0 / 6.0, b_spline, 2)), "every other segment is left out");
        assert!(!is_smooth_basis(&PatchBasis::BEZIER));
        // Ends meet, derivatives do not.
        let linear = [[0.0; 4], [0.0; 4], [-1.0, 1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]];
        assert!(!is_smooth_basis(&basis(1.0, linear, 1)));
    }

    #[test]
    fn a_corner_is_smooth_where_its_sides_are_and_there_is_no_tip() {
        let smooth = Smooth::new([true, false, true, true], [false, false, true, false]);
        assert_eq!([0, 1, 2, 3].map(|side| smooth.side(side)), [true, false, true, true]);
        assert_eq!([0, 1, 2, 3].map(|corner| smooth.corner(corner)), [true, false, false, false]);
    }
}
