//! Subdivision surfaces as a file gives them: a control mesh and its tags, nothing checked yet.
//!
//! Out: [`SubdivisionMesh`]. What is wrong with one is found when it is made into a
//! [`LimitSurface`](crate::geometry::subdivision::LimitSurface), which names it and draws the rest.

use super::{Keyed, PrimVar};

/// How a control mesh becomes a smooth surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scheme {
    /// Catmull and Clark 1978: bicubic B-splines wherever four quads meet.
    #[default]
    CatmullClark,
    /// Loop 1987: quartic box splines wherever six triangles meet. Triangles only; larger faces are cut into fans.
    Loop,
    /// The control mesh itself, bilinear over its quads (n-gons become n quads about their middle).
    Bilinear,
}

/// What happens at the border of the control mesh (`interpolateboundary`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BoundaryRule {
    /// 0: faces that touch a border edge which is not an infinite crease are not drawn.
    None,
    /// 1: borders are sharp creases, and vertices of one face only are sharp corners.
    EdgeAndCorner,
    /// 2: borders are sharp creases; corners are rounded.
    #[default]
    EdgeOnly,
}

impl BoundaryRule {
    /// The rule of RenderMan's integer, if it is one.
    pub fn from_ri(value: i32) -> Option<Self> {
        match value {
            0 => Some(BoundaryRule::None),
            1 => Some(BoundaryRule::EdgeAndCorner),
            2 => Some(BoundaryRule::EdgeOnly),
            _ => None,
        }
    }
}

/// How far facevarying values are smoothed. A *seam* is an edge where the values of two faces differ; it is
/// a border of the values, as is a border of the mesh. Inside, values follow the rule of the positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FaceVaryingRule {
    /// Smooth everywhere; seams are smooth curves with rounded corners.
    Smooth,
    /// As `Smooth`, but values that one face alone has are kept sharp.
    CornersOnly,
    /// As `CornersOnly`, and where three or more values meet at a vertex all are kept sharp; so are both of two where
    /// one is cut by a crease or comes in several parts.
    CornersPlus1,
    /// As `CornersPlus1`, and sharp as well are both values of a vertex where one of two has a single face,
    /// and values where a seam ends inside a surface.
    CornersPlus2,
    /// Every value on a border or seam is kept sharp: seams are straight.
    Boundaries,
    /// Bilinear over each base quad.
    #[default]
    Linear,
}

impl FaceVaryingRule {
    /// The rule of RenderMan's `facevaryinginterpolateboundary`: 0 bilinear, 1 edges and corners, 2 edges
    /// only, 3 always sharp; `propagate` is `facevaryingpropagatecorners`.
    pub fn from_ri(value: i32, propagate: bool) -> Option<Self> {
        match value {
            0 => Some(FaceVaryingRule::Linear),
            1 if propagate => Some(FaceVaryingRule::CornersPlus2),
            1 => Some(FaceVaryingRule::CornersPlus1),
            2 => Some(FaceVaryingRule::Smooth),
            3 => Some(FaceVaryingRule::Boundaries),
            _ => None,
        }
    }
}

/// How semi-sharp creases lose their sharpness from level to level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CreaseMethod {
    /// By 1 a level (DeRose et al. 1998).
    #[default]
    Uniform,
    /// By 1 after averaging along the crease, 3/4 own and 1/4 of the others at each end.
    Chaikin,
}

/// A chain of edges that are sharp together.
#[derive(Debug, Clone, PartialEq)]
pub struct Crease {
    /// Vertices along the chain, at least 2.
    pub vertices: Vec<i32>,
    /// Sharpness: one for the chain, or one an edge. 0 is smooth, 10 and more infinitely sharp.
    pub sharpness: Vec<f32>,
}

/// A control mesh with its tags.
#[derive(Debug, Clone, PartialEq)]
pub struct SubdivisionMesh {
    /// The rule of subdivision.
    pub scheme: Scheme,
    /// Vertices of each face.
    pub face_vertex_counts: Vec<i32>,
    /// Vertices of the faces, face after face, counter-clockwise seen from the side dPdu x dPdv points to.
    pub indices: Vec<i32>,
    /// Control points; every key has as many.
    pub points: Keyed<Vec<[f32; 3]>>,
    /// Sharp edges. The last crease that names an edge counts.
    pub creases: Vec<Crease>,
    /// Sharp vertices and their sharpness, as for creases.
    pub corners: Vec<(i32, f32)>,
    /// Faces that shape the surface but are not drawn.
    pub holes: Vec<i32>,
    /// Border of the mesh.
    pub boundary: BoundaryRule,
    /// Facevarying values.
    pub face_varying: FaceVaryingRule,
    /// Semi-sharp creases.
    pub crease_method: CreaseMethod,
    /// Primitive variables other than the position: one value a mesh (constant), a face (uniform), a vertex
    /// (varying, vertex), a face corner (facevarying).
    pub vars: Vec<PrimVar>,
}

impl SubdivisionMesh {
    /// A still mesh without tags.
    pub fn new(
        scheme: Scheme,
        face_vertex_counts: Vec<i32>,
        indices: Vec<i32>,
        points: Vec<[f32; 3]>,
    ) -> Self {
        SubdivisionMesh {
            scheme,
            face_vertex_counts,
            indices,
            points: Keyed::still(points),
            creases: Vec::new(),
            corners: Vec::new(),
            holes: Vec::new(),
            boundary: BoundaryRule::default(),
            face_varying: FaceVaryingRule::default(),
            crease_method: CreaseMethod::default(),
            vars: Vec::new(),
        }
    }
}
