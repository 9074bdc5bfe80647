//! Limits: the limit surfaces of subdivision meshes, placed in camera space.
//!
//! In: a mesh's limit surface and where it stands at the motion keys. Out: points, derivatives and hulls of its base quads
//! at a key, between two keys of the file where the key is.

use glam::Vec3;

use crate::geometry::SurfacePoint;
use crate::geometry::hull::Hull;
use crate::geometry::subdivision::{Evaluator, LimitPoint, LimitSurface, Part, Spline};

use super::motion::Placement;

/// A subdivision mesh's limit surface and where it stands.
#[derive(Debug, Clone)]
pub struct Limit {
    /// In object space.
    pub surface: LimitSurface,
    /// Where it is at each key.
    pub placements: Vec<Placement>,
}

impl Limit {
    /// The surface in camera space at a key.
    pub(super) fn evaluate(&self, evaluator: &mut Evaluator, key: usize, [u, v]: [f32; 2]) -> SurfacePoint {
        let placement = &self.placements[key];
        let [from, to] = placement.points.keys;
        let mut at = evaluator.evaluate(from, u, v);
        if placement.points.part != 0.0 {
            at = blended(at, evaluator.evaluate(to, u, v), placement.points.part as f32);
        }
        placement.carry(at)
    }

    /// The surface at a key, where it is one spline.
    pub(super) fn spline<'e>(&self, evaluator: &'e Evaluator, key: usize) -> Option<PlacedSpline<'e>> {
        let placement = self.placements[key];
        let [from, to] = placement.points.keys;
        let next = if placement.points.part != 0.0 { Some(evaluator.spline(to)?) } else { None };
        Some(PlacedSpline { spline: evaluator.spline(from)?, next, placement })
    }

    /// The surface at a key over a part of the quad.
    pub(super) fn spline_of<'e>(
        &self,
        evaluator: &'e Evaluator,
        key: usize,
        part: Part,
    ) -> Option<PlacedSpline<'e>> {
        let placement = self.placements[key];
        let [from, to] = placement.points.keys;
        let next = if placement.points.part != 0.0 { Some(evaluator.spline_of(part, to)?) } else { None };
        Some(PlacedSpline { spline: evaluator.spline_of(part, from)?, next, placement })
    }
}

/// A limit surface in camera space at a key, where it is one spline.
pub(super) struct PlacedSpline<'e> {
    spline: Spline<'e>,
    /// The spline at the file's next key, where the key lies between two of them.
    pub next: Option<Spline<'e>>,
    placement: Placement,
}

impl PlacedSpline<'_> {
    /// What [`Limit::evaluate`] gives without a next key.
    #[inline(always)]
    pub fn evaluate(&self, u: f32, v: f32) -> SurfacePoint {
        self.placement.carry(self.spline.evaluate(u, v))
    }

    /// What [`Limit::evaluate`] gives with the next key.
    #[inline(always)]
    pub fn evaluate_between(&self, next: &Spline, u: f32, v: f32) -> SurfacePoint {
        let part = self.placement.points.part as f32;
        self.placement.carry(blended(self.spline.evaluate(u, v), next.evaluate(u, v), part))
    }
}

/// Part of the way from one point to another.
#[inline(always)]
fn blended(at: LimitPoint, next: LimitPoint, part: f32) -> LimitPoint {
    LimitPoint {
        p: at.p + (next.p - at.p) * part,
        dp_du: at.dp_du + (next.dp_du - at.dp_du) * part,
        dp_dv: at.dp_dv + (next.dp_dv - at.dp_dv) * part,
    }
}

impl Limit {
    /// Corners of a box in object space that holds the surface over `u` x `v` at a key, in camera space.
    pub(super) fn hull(&self, evaluator: &mut Evaluator, key: usize, u: [f32; 2], v: [f32; 2]) -> Hull {
        let placement = &self.placements[key];
        let [from, to] = placement.points.keys;
        let mut bounds = evaluator.bounds(from, u, v);
        if placement.points.part != 0.0 {
            // The box of both holds all that lies between, whatever the rounding.
            let next = evaluator.bounds(to, u, v);
            bounds.min = bounds.min.min(next.min);
            bounds.max = bounds.max.max(next.max);
        }
        let corner = |corner: usize| {
            let pick = |axis: usize| [bounds.min[axis], bounds.max[axis]][corner >> axis & 1];
            placement.place(Vec3::new(pick(0), pick(1), pick(2)))
        };
        Hull::of::<8>(std::array::from_fn(corner))
    }
}

impl Placement {
    #[inline(always)]
    fn carry(&self, at: LimitPoint) -> SurfacePoint {
        SurfacePoint { p: self.place(at.p), du: self.turn(at.dp_du), dv: self.turn(at.dp_dv) }
    }

    #[inline(always)]
    fn place(&self, p: Vec3) -> Vec3 {
        self.to_camera.transform_point3(p.as_dvec3()).as_vec3()
    }

    #[inline(always)]
    fn turn(&self, v: Vec3) -> Vec3 {
        self.to_camera.transform_vector3(v.as_dvec3()).as_vec3()
    }
}
