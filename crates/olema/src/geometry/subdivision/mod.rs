//! Subdivision surfaces: exact limit points, derivatives and bounds.
//!
//! In: a [`SubdivisionMesh`](crate::scene::SubdivisionMesh), Catmull-Clark, Loop or bilinear. Out: a
//! [`LimitSurface`], the mesh's tables, which never change; its [`BaseQuad`]s, the domains that are split
//! and diced, welded by edge and corner ids; and for each an [`Evaluator`] of the limit surface over it.
//!
//! A face that is a quad is a base quad. Any other polygon of n sides is n base quads, and under Loop a
//! triangle is 3: each from a corner over the middle of a side to the middle of the face.
//!
//! ```text
//!   mesh -> faces -> topology -> hood -> tree -> evaluator      by the limit masks (limit) and the splines
//!                       |         ^  quad, triangle: refine     (bicubic, box_spline)
//!                    connect      rules: sharpness
//! ```
//!
//! Evaluation is feature-adaptive (Niessner et al. 2012) but on demand: a neighbourhood is refined along
//! the way to (u, v) until it is a spline patch or its corner is asked for. All arithmetic is f64: near an
//! extraordinary vertex control points differ by 1e-12 of the mesh, and f32 has lost normals by then.

mod bicubic;
mod box_spline;
mod connect;
mod evaluator;
mod faces;
mod facevarying;
mod hood;
mod limit;
mod quad;
mod rules;
mod surface;
mod topology;
mod tree;
mod triangle;
mod trig;
mod warning;

pub use connect::{BaseQuad, CornerId, EdgeKind, EdgeRef, Piece};
pub use evaluator::{Aabb, Evaluator, LimitPoint, Part, Spline};
pub use surface::LimitSurface;
pub use warning::MeshWarning;
