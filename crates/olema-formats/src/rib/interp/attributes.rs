//! Attributes: how primitives look.

use std::sync::Arc;

use olema::scene::{ShadingInterpolation, Sides};

use super::super::args::Args;
use super::super::basis;
use super::super::fault::Fault;
use super::super::state::AttrState;
use super::super::statements::Id;
use super::{Call, Interp};

impl Interp {
    /// Runs a statement that sets an attribute; `false` where it is another one.
    pub(super) fn attribute(&mut self, call: &Call<'_>) -> Result<bool, Fault> {
        let args = call.args;
        let wrong =
            |message: &str| Fault::error(args.pos(0), format!("{}: {message}; ignored", call.statement.name));
        match call.statement.id {
            Id::Orientation => self.orientation(call)?,
            Id::Detail => self.detail(call),
            Id::Attribute => self.named_attribute(call),
            Id::GeometricApproximation => self.approximation(call)?,
            _ => {}
        }
        let attrs = Arc::make_mut(&mut self.attrs);
        match call.statement.id {
            Id::Orientation | Id::Detail | Id::Attribute | Id::GeometricApproximation => {}
            Id::Color => attrs.look.color = triple(args),
            Id::Opacity => attrs.look.opacity = triple(args).map(|v| v.clamp(0.0, 1.0)),
            Id::Sides => {
                attrs.look.sides = match args.int(0) {
                    1 => Sides::One,
                    2 => Sides::Two,
                    n => return Err(wrong(&format!("expected 1 or 2, found {n}"))),
                }
            }
            Id::ReverseOrientation => attrs.inside = !attrs.inside,
            Id::Matte => attrs.look.matte = args.int(0) != 0,
            Id::TextureCoordinates => {
                let [s1, t1, s2, t2, s3, t3, s4, t4] =
                    args.array(0).unwrap_or_default().map(|v: f64| v as f32);
                attrs.look.texture_coordinates = [[s1, t1], [s2, t2], [s3, t3], [s4, t4]];
            }
            Id::ShadingRate => {
                let rate = args.num(0) as f32;
                if rate <= 0.0 {
                    return Err(wrong("expected an area above 0"));
                }
                attrs.look.shading_rate = rate;
            }
            Id::ShadingInterpolation => {
                attrs.look.shading_interpolation = match args.text(0).unwrap_or_default() {
                    "constant" => ShadingInterpolation::Constant,
                    "smooth" => ShadingInterpolation::Smooth,
                    other => {
                        return Err(wrong(&format!(
                            "expected \"constant\" or \"smooth\", found \"{other}\""
                        )));
                    }
                }
            }
            Id::Basis => set_basis(call, attrs)?,
            Id::DetailRange => {
                let range: [f64; 4] = args.array(0).unwrap_or_default();
                if range[0] < 0.0 || range.windows(2).any(|w| w[0] > w[1]) {
                    return Err(wrong("expected 0 <= minvisible <= lower <= upper <= maxvisible"));
                }
                attrs.detail_range = range;
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// "lh" and "rh" are the space's handedness in which the normal is dPdu x dPdv; the camera's is left-handed,
    /// so the object's is where nothing mirrors on the way. "outside" is the object's own.
    fn orientation(&mut self, call: &Call<'_>) -> Result<(), Fault> {
        let name = call.args.text(0).unwrap_or_default();
        let mut determinant = self.ctm.first().determinant();
        if let Some(world) = &self.world {
            determinant *= world.scene.camera.world_to_camera.first().determinant().signum();
        }
        let left = determinant > 0.0;
        let inside = match name {
            "outside" => false,
            "inside" => true,
            "lh" => !left,
            "rh" => left,
            _ => {
                let message =
                    format!("expected \"outside\", \"inside\", \"lh\" or \"rh\", found \"{name}\"; ignored");
                return Err(Fault::error(call.args.pos(0), message));
            }
        };
        Arc::make_mut(&mut self.attrs).inside = inside;
        Ok(())
    }

    fn approximation(&mut self, call: &Call<'_>) -> Result<(), Fault> {
        let (kind, value) = (call.args.text(0).unwrap_or_default(), call.args.num(1) as f32);
        let look = &mut Arc::make_mut(&mut self.attrs).look;
        let factor = match kind {
            "motionfactor" => &mut look.motion_factor,
            "focusfactor" => &mut look.focus_factor,
            _ => {
                let what = "of GeometricApproximation only motionfactor and focusfactor have an effect: dicing \
                            follows the shading rate";
                self.count(what, call.site);
                return Ok(());
            }
        };
        if !(value >= 0.0 && value.is_finite()) {
            let message = format!("\"{kind}\" {value}: expected a factor of at least 0; ignored");
            return Err(Fault::error(call.args.pos(1), message));
        }
        *factor = value;
        Ok(())
    }

    fn named_attribute(&mut self, call: &Call<'_>) {
        let args = call.args;
        let category = args.text(0).unwrap_or_default();
        let attrs = Arc::make_mut(&mut self.attrs);
        if category == "user" && !attrs.values.set_params(category, args) {
            let message = "too many user attributes: expected at most 1024; the last are ignored";
            self.said.push(Fault::warning(call.site.pos, message));
        }
        if category == "displacementbound" {
            return self.displacement_bound(call);
        }
        if category == "identifier"
            && let Some(name) = args.find("name").and_then(|p| args.param_texts(p).next())
        {
            // It is copied for every primitive.
            attrs.look.name = name.chars().take(256).collect();
        }
    }
}

fn triple(args: &Args) -> [f32; 3] {
    args.array(0).unwrap_or_default().map(|v: f64| v as f32)
}

fn set_basis(call: &Call<'_>, attrs: &mut AttrState) -> Result<(), Fault> {
    let args = call.args;
    let mut bases = attrs.basis;
    for (which, basis) in bases.iter_mut().enumerate() {
        let (ix, step_ix) = (2 * which, 2 * which + 1);
        *basis = match (args.text(ix), args.array::<16>(ix)) {
            (Some(name), _) => basis::named(name).ok_or_else(|| {
                let expected = "expected bezier, b-spline, catmull-rom, hermite, power or sixteen numbers";
                Fault::error(args.pos(ix), format!("basis \"{name}\" is unknown: {expected}; ignored"))
            })?,
            (None, numbers) => {
                let numbers = numbers.unwrap_or_default().map(|v| v as f32);
                let row =
                    |r: usize| [numbers[4 * r], numbers[4 * r + 1], numbers[4 * r + 2], numbers[4 * r + 3]];
                olema::scene::PatchBasis { matrix: [row(0), row(1), row(2), row(3)], step: 1 }
            }
        };
        let step = args.int(step_ix);
        if !(1..=4).contains(&step) {
            return Err(Fault::error(
                args.pos(step_ix),
                format!("expected a step from 1 to 4, found {step}; ignored"),
            ));
        }
        basis.step = step as u32;
    }
    attrs.basis = bases;
    Ok(())
}
