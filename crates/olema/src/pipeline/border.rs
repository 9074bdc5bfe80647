//! Border: who owns the vertices on welded edges and corners, and whose normals meet there.
//!
//! In: a lattice and the edges. Out: the places on other patches that have to be evaluated for it, put behind its own. A
//! point on a welded edge or corner is its owner's, with the sum of the normals of all patches that meet there and do not
//! agree by the way they were made ([`smooth`](super::smooth)), in their order: whoever dices it gets the same bits.

use std::ops::Range;

use glam::Vec3;

use crate::math::Vec3s;

use super::displace::DisplaceContext;
use super::edges::{CornerUse, SideUse};
use super::lattice::Lattice;
use super::normals::unit_sums;
use super::patch::{CORNER_UV, side_uv};
use super::piece::{PointRef, Sabotage, parameter};
use super::recall::{Recall, numerator};

/// No place yet.
const NOWHERE: u32 = u32::MAX;

/// A vertex that is not at the lattice's place for it, or not displaced as that is.
#[derive(Debug, Clone, Copy)]
pub struct BorderPoint {
    /// The vertex.
    pub vertex: u32,
    /// Patch that owns it.
    pub owner: u32,
    /// Where that is evaluated, in the list of all places.
    pub place: u32,
    /// Finest shading rate of the patches there.
    pub shading_rate: f32,
}

/// A normal that is added at a border point.
#[derive(Debug, Clone, Copy)]
struct Summand {
    /// Entry of [`Border::points`].
    point: u32,
    /// Whose normal, in the list of all places.
    place: u32,
    /// Its orientation.
    sign: f32,
}

/// What a lattice needs of other patches; used again for every grid.
#[derive(Debug, Default)]
pub struct Border {
    /// Vertices that are evaluated elsewhere, or displaced along a sum of normals.
    pub points: Vec<BorderPoint>,
    /// Patch and first place of each run of places that were put behind the lattice's own.
    runs: Vec<(u32, u32)>,
    summands: Vec<Summand>,
    /// Vertices of an edge or corner that are not what the lattice has for them.
    elsewhere: Vec<(u32, PointRef)>,
    /// Normals that `points` are displaced along; none where they are not.
    pub normals: Vec3s,
}

impl Border {
    /// Finds the owners of a lattice's border vertices. Where it is `displaced`, these are vertices on welded edges and
    /// corners, with the normals that meet there, but for what is recalled and for what the lattice has already, being the
    /// owner; else only those that lie at another place than the lattice has for them.
    pub fn collect(
        &mut self,
        context: &DisplaceContext,
        patch: u32,
        lattice: &mut Lattice,
        displaced: Option<&mut Recall>,
    ) {
        self.points.clear();
        self.runs.clear();
        self.summands.clear();
        self.normals.clear();
        let border = std::mem::take(&mut lattice.border);
        let mut elsewhere = std::mem::take(&mut self.elsewhere);
        match displaced {
            None => border.iter().for_each(|&at| self.add_owner(context, patch, lattice, at)),
            Some(recall) => {
                let num_keys = context.frame.patches.num_keys(patch);
                let may_recall = context.frame.sabotage.is_none();
                recall.begin(&border);
                for ix in 0..recall.num_runs() {
                    let run = &border[recall.run(ix)];
                    if may_recall && recall.knows(ix, run, num_keys) {
                        continue;
                    }
                    let run = if is_displaced_alike(context, patch, run[0].1) {
                        let is_elsewhere = |&(vertex, point): &(u32, PointRef)| {
                            context.frame.place(patch, point) != (patch, lattice.place(vertex))
                        };
                        elsewhere.clear();
                        elsewhere.extend(run.iter().copied().filter(is_elsewhere));
                        &elsewhere
                    } else {
                        run
                    };
                    match run {
                        [] => (),
                        [(_, PointRef::Edge { edge, denominator, .. }), ..] if !is_broken(context) => {
                            self.add_edge(context, patch, lattice, run, (*edge, *denominator));
                        }
                        _ => run.iter().for_each(|&at| self.add(context, patch, lattice, at)),
                    }
                }
            }
        }
        lattice.border = border;
        self.elsewhere = elsewhere;
    }

    /// Places that were put behind the lattice's own, up to `end`, by patch.
    pub fn runs(&self, end: usize) -> impl Iterator<Item = (u32, Range<usize>)> + '_ {
        let ends = self.runs.iter().skip(1).map(|run| run.1 as usize).chain([end]);
        self.runs.iter().zip(ends).map(|(&(patch, first), end)| (patch, first as usize..end))
    }

    /// Adds a border vertex of a patch that is not displaced.
    fn add_owner(
        &mut self,
        context: &DisplaceContext,
        patch: u32,
        lattice: &mut Lattice,
        (vertex, point): (u32, PointRef),
    ) {
        let (owner, uv) = context.frame.place(patch, point);
        if owner != patch || uv != lattice.place(vertex) {
            let place = self.place(lattice, owner, uv);
            self.points.push(BorderPoint { vertex, owner, place, shading_rate: 0.0 });
        }
    }

    /// Adds a border vertex that is not on an edge, with the normals that meet there.
    fn add(
        &mut self,
        context: &DisplaceContext,
        patch: u32,
        lattice: &mut Lattice,
        (vertex, point): (u32, PointRef),
    ) {
        let (owner, uv) = context.frame.place(patch, point);
        let own_uv = lattice.place(vertex);
        let mut place = (owner == patch && uv == own_uv).then_some(vertex);
        if let PointRef::Corner(corner) = point
            && !is_broken(context)
        {
            let known = context.frame.edges.corners[corner as usize];
            let only = [CornerUse { patch: owner, corner: known.corner, sign: context.normal_sign(owner) }];
            for user in context.frame.edges.corner_users(corner).unwrap_or(&only) {
                let user_uv = CORNER_UV[user.corner as usize];
                let (at, sign) = if user.patch == patch && user_uv == own_uv {
                    (vertex, 1.0)
                } else {
                    (self.place(lattice, user.patch, user_uv), user.sign)
                };
                if user.patch == owner && user_uv == uv {
                    place = Some(at);
                }
                self.summands.push(Summand { point: self.points.len() as u32, place: at, sign });
            }
        }
        let place = place.unwrap_or_else(|| self.place(lattice, owner, uv));
        let shading_rate = context.border_rate(patch, point);
        self.points.push(BorderPoint { vertex, owner, place, shading_rate });
    }

    /// Adds border vertices on one tessellation of one edge, with the normals that meet there.
    fn add_edge(
        &mut self,
        context: &DisplaceContext,
        patch: u32,
        lattice: &mut Lattice,
        run: &[(u32, PointRef)],
        (edge, denominator): (u32, u64),
    ) {
        let edges = context.frame.edges;
        let owners = edges.edges[edge as usize].owners;
        let shading_rate = context.border_rate(patch, run[0].1);
        let first = self.points.len();
        for &(vertex, point) in run {
            let owner = owners[usize::from(2 * numerator(point) > denominator)].patch;
            self.points.push(BorderPoint { vertex, owner, place: NOWHERE, shading_rate });
        }
        let only = owners.map(|of| SideUse { of, sign: context.normal_sign(of.patch) });
        let only = if owners[0] == owners[1] { &only[..1] } else { &only };
        // Patch after patch, so that a point's normals are still added in the patches' order.
        for &SideUse { of: user, sign: sign_elsewhere } in edges.edge_users(edge).unwrap_or(only) {
            let owns = owners.map(|owner| (user.patch, user.side) == (owner.patch, owner.side));
            for (&(vertex, point), ix) in run.iter().zip(first..) {
                let numerator = numerator(point);
                if !user.along.has(numerator, denominator) {
                    continue;
                }
                let (along, denominator) = user.along.own(numerator, denominator);
                let uv = side_uv(user.side as usize, parameter(along, denominator));
                let (place, sign) = if user.patch == patch && uv == lattice.place(vertex) {
                    (vertex, 1.0)
                } else {
                    (self.place(lattice, user.patch, uv), sign_elsewhere)
                };
                if owns[usize::from(2 * numerator > denominator)] {
                    self.points[ix].place = place;
                }
                self.summands.push(Summand { point: ix as u32, place, sign });
            }
        }
        for (&(_, point), ix) in run.iter().zip(first..) {
            if self.points[ix].place == NOWHERE {
                let (owner, uv) = context.frame.place(patch, point);
                self.points[ix].place = self.place(lattice, owner, uv);
            }
        }
    }

    /// Puts a place on another patch behind the others.
    #[inline(always)]
    fn place(&mut self, lattice: &mut Lattice, patch: u32, uv: [f32; 2]) -> u32 {
        let place = lattice.push(uv);
        if self.runs.last().is_none_or(|run| run.0 != patch) {
            self.runs.push((patch, place));
        }
        place
    }

    /// Sums the normals that meet at each point. Sides that face each other leave nothing: the owner's normal stands
    /// then. Normals of the lattice's own places are oriented, the others not.
    pub fn sum_normals(&mut self, context: &DisplaceContext, normals: &Vec3s) {
        let Border { points, summands, normals: sums, .. } = self;
        sums.clear();
        sums.resize(points.len());
        let ([x, y, z], [to_x, to_y, to_z]) = (normals.axes(), sums.axes_mut());
        for &Summand { point, place, sign } in &*summands {
            let (to, from) = (point as usize, place as usize);
            to_x[to] += x[from] * sign;
            to_y[to] += y[from] * sign;
            to_z[to] += z[from] * sign;
        }
        if unit_sums(context.frame.surfaces.level, sums) {
            return;
        }
        let broken = is_broken(context);
        for (ix, point) in points.iter().enumerate() {
            if sums.get(ix) != Vec3::ZERO {
                continue;
            }
            let normal = if broken || point.place == point.vertex {
                normals.get(point.vertex as usize)
            } else {
                normals.get(point.place as usize) * context.normal_sign(point.owner)
            };
            sums.set(ix, normal);
        }
    }
}

/// Whether what a patch has at a point of an edge or corner is displaced as the owner's is, if it is the owner: by one
/// normal, with the same width.
fn is_displaced_alike(context: &DisplaceContext, patch: u32, point: PointRef) -> bool {
    let edges = context.frame.edges;
    let has_one_normal = match point {
        PointRef::Edge { edge, .. } => {
            let [first, second] = edges.edges[edge as usize].owners;
            edges.edge_users(edge).is_none() && first == second
        }
        PointRef::Corner(corner) => edges.corner_users(corner).is_none(),
        PointRef::Inside(_) => false,
    };
    has_one_normal && !is_broken(context) && context.border_rate(patch, point) == context.shading_rate(patch)
}

/// Whether points are displaced along the normals of the patch that asks.
fn is_broken(context: &DisplaceContext) -> bool {
    matches!(context.frame.sabotage, Some(Sabotage::Normal | Sabotage::EstimatedNormals))
}
