//! Primitives that are not drawn yet: their counts are checked all the same.

use olema::scene::{Class, VarType};

use super::super::args::Args;
use super::super::fault::Fault;
use super::super::params;
use super::super::state::Sizes;
use super::super::statements::Id;
use super::{Call, Interp};

impl Interp {
    /// Checks and counts a primitive that is not drawn; `false` where the statement is another one.
    pub(super) fn undrawn(&mut self, call: &Call<'_>) -> Result<bool, Fault> {
        let args = call.args;
        let sizes = match call.statement.id {
            Id::Sphere
            | Id::Cone
            | Id::Cylinder
            | Id::Hyperboloid
            | Id::Paraboloid
            | Id::Disk
            | Id::Torus => Some(Sizes::QUADRIC),
            Id::Polygon | Id::Points => Some(by_points(call)?),
            Id::GeneralPolygon => {
                let vertex = sum(args, 0, 1)?;
                Some(polygons(1, vertex, vertex))
            }
            Id::PointsPolygons => {
                let corners = sum(args, 0, 1)?;
                Some(indexed(args, args.ints(0).len(), corners, 1)?)
            }
            Id::PointsGeneralPolygons => {
                let loops = sum(args, 0, 1)?;
                expect_len(args, 1, args.ints(1).len(), loops)?;
                let corners = sum(args, 1, 1)?;
                Some(indexed(args, args.ints(0).len(), corners, 2)?)
            }
            Id::NuPatch => Some(nurbs(args)?),
            Id::Curves => Some(self.curves(args)?),
            Id::Blobby => Some(blobby(args)?),
            Id::TrimCurve => {
                trim_curve(args)?;
                None
            }
            Id::Geometry => None,
            _ => return Ok(false),
        };
        if let Some(sizes) = sizes {
            params::check(args, &sizes, &mut self.said);
        }
        self.count(call.statement.name, call.site);
        Ok(true)
    }

    fn curves(&self, args: &Args) -> Result<Sizes, Fault> {
        let kind = args.text(0).unwrap_or_default();
        let wrap = args.text(2).unwrap_or_default();
        if !matches!(wrap, "periodic" | "nonperiodic") {
            let message = format!("expected \"periodic\" or \"nonperiodic\", found \"{wrap}\"");
            return Err(Fault::error(args.pos(2), message));
        }
        let (least, step, cubic) = match kind {
            "linear" => (2, 1, false),
            "cubic" => (4, self.attrs.basis[1].step.max(1) as usize, true),
            _ => {
                return Err(Fault::error(
                    args.pos(0),
                    format!("expected \"linear\" or \"cubic\", found \"{kind}\""),
                ));
            }
        };
        let periodic = wrap == "periodic";
        let vertex = sum(args, 1, if periodic { 1 } else { least })?;
        let varying = args.ints(1).iter().map(|n| *n as usize).map(|n| match (cubic, periodic) {
            (false, _) => n,
            (true, true) => n / step,
            (true, false) => n.saturating_sub(4) / step + 2,
        });
        Ok(Sizes { uniform: args.ints(1).len(), varying: varying.sum(), vertex, facevarying: 0 })
    }
}

fn polygons(uniform: usize, vertex: usize, corners: usize) -> Sizes {
    Sizes { uniform, varying: vertex, vertex, facevarying: corners }
}

/// Checks an array's length.
pub(super) fn expect_len(args: &Args, ix: usize, found: usize, expected: usize) -> Result<(), Fault> {
    if found == expected {
        return Ok(());
    }
    Err(Fault::error(args.pos(ix), format!("this array has {found} values: expected {expected}")))
}

/// The sum of an array of counts, each at least `least`.
pub(super) fn sum(args: &Args, ix: usize, least: i32) -> Result<usize, Fault> {
    let values = args.ints(ix);
    if let Some(bad) = values.iter().find(|n| **n < least) {
        return Err(Fault::error(args.pos(ix), format!("expected counts of at least {least}, found {bad}")));
    }
    Ok(values.iter().map(|n| *n as usize).sum())
}

/// Sizes where argument `ix + ...` indexes points: `corners` indices in the array after the counts.
fn indexed(args: &Args, faces: usize, corners: usize, ix: usize) -> Result<Sizes, Fault> {
    let indices = args.ints(ix);
    expect_len(args, ix, indices.len(), corners)?;
    if let Some(bad) = indices.iter().find(|n| **n < 0) {
        return Err(Fault::error(args.pos(ix), format!("expected indices of at least 0, found {bad}")));
    }
    let vertex = indices.iter().max().map_or(0, |n| *n as usize + 1);
    Ok(polygons(faces, vertex, corners))
}

/// Sizes where "P" tells how many points there are.
fn by_points(call: &Call<'_>) -> Result<Sizes, Fault> {
    let args = call.args;
    let Some(param) = args.find("P").or_else(|| args.find("Pw")).or_else(|| args.find("Pz")) else {
        return Err(Fault::error(call.site.pos, "expected points: \"P\""));
    };
    let (found, width) = (args.param_len(param), param.decl.width());
    if param.decl.class != Class::Vertex || param.decl.ty == VarType::String || !found.is_multiple_of(width) {
        let what = param.decl.describe();
        let message =
            format!("the points are \"{what}\" with {found} numbers: expected vertex points of {width} each");
        return Err(Fault::error(param.pos, message));
    }
    let vertex = found / width;
    if call.statement.id == Id::Polygon && vertex < 3 {
        return Err(Fault::error(param.pos, format!("expected at least 3 points, found {vertex}")));
    }
    Ok(polygons(1, vertex, vertex))
}

fn nurbs(args: &Args) -> Result<Sizes, Fault> {
    let direction = |ix: usize| -> Result<(usize, usize), Fault> {
        let (n, order) = (args.int(ix), args.int(ix + 1));
        if order < 1 || n < order {
            let message =
                format!("{n} points of order {order}: expected an order of at least 1 and as many points");
            return Err(Fault::error(args.pos(ix), message));
        }
        let (n, order) = (n as usize, order as usize);
        let knots = args.floats(ix + 2);
        expect_len(args, ix + 2, knots.len(), n + order)?;
        if knots.windows(2).any(|w| w[0] > w[1]) {
            return Err(Fault::error(args.pos(ix + 2), "expected knots that do not descend"));
        }
        Ok((n, 1 + n - order))
    };
    let ((nu, su), (nv, sv)) = (direction(0)?, direction(5)?);
    let (uniform, vertex) = (su.saturating_mul(sv), nu.saturating_mul(nv));
    Ok(Sizes {
        uniform,
        varying: (su + 1).saturating_mul(sv + 1),
        vertex,
        facevarying: uniform.saturating_mul(4),
    })
}

fn blobby(args: &Args) -> Result<Sizes, Fault> {
    let leaves = args.int(0);
    let Ok(leaves) = usize::try_from(leaves) else {
        return Err(Fault::error(args.pos(0), format!("expected a count of leaves, found {leaves}")));
    };
    if args.ints(1).is_empty() {
        return Err(Fault::error(args.pos(1), "expected instructions, found none"));
    }
    Ok(Sizes { uniform: 1, varying: leaves, vertex: leaves, facevarying: leaves })
}

fn trim_curve(args: &Args) -> Result<(), Fault> {
    let curves = sum(args, 0, 0)?;
    expect_len(args, 1, args.ints(1).len(), curves)?;
    let orders = sum(args, 1, 1)?;
    expect_len(args, 5, args.ints(5).len(), curves)?;
    let points = sum(args, 5, 1)?;
    expect_len(args, 2, args.floats(2).len(), points + orders)?;
    for ix in [3, 4] {
        expect_len(args, ix, args.floats(ix).len(), curves)?;
    }
    for ix in [6, 7, 8] {
        expect_len(args, ix, args.floats(ix).len(), points)?;
    }
    Ok(())
}
