//! `Hider "hidden"`: how samples are placed and found, and the shapes of lens and shutter.

use std::sync::Arc;

use olema::Settings;

use super::super::args::{Args, ParamItem};
use super::super::fault::Fault;
use super::super::state::OptionState;
use super::{Call, Interp};

/// Most blades of an aperture.
const MAX_BLADES: f32 = 64.0;

impl Interp {
    /// Hider. A parameter that is wrong is left out, the others count.
    pub(super) fn hider(&mut self, call: &Call<'_>) {
        let args = call.args;
        let name = args.text(0).unwrap_or_default();
        if name != "hidden" {
            let message = format!("hider \"{name}\" is unknown: expected \"hidden\", which is used");
            return self.say(Fault::warning(args.pos(0), message));
        }
        let options = Arc::make_mut(&mut self.options);
        for param in &args.params {
            let name = args.param_name(param);
            match parameter(args, param, options) {
                Ok(None) => {}
                Ok(Some(note)) => {
                    self.said.push(Fault::note(param.pos, format!("hider parameter \"{name}\" {note}")))
                }
                Err(problem) => {
                    self.said.push(Fault::error(param.pos, format!("\"{name}\": {problem}; ignored")));
                }
            }
        }
    }
}

/// Sets one parameter; returns what is to be noted about it.
fn parameter(
    args: &Args,
    param: &ParamItem,
    options: &mut OptionState,
) -> Result<Option<&'static str>, String> {
    match args.param_name(param) {
        "jitter" => options.jitter = numbers::<1>(args, param)? != [0.0],
        "aperture" => return aperture(numbers(args, param)?, options),
        "shutteropening" => {
            let opening @ [open, close] = numbers(args, param)?;
            if !(0.0 <= open && open <= close && close <= 1.0) {
                let problem =
                    "expected the parts of the shutter's time at which it is open and begins to close";
                return Err(format!("{open} {close}: {problem}, 0 <= open <= close <= 1"));
            }
            options.shutter_opening = opening;
        }
        "rasterizer" => {
            let name = args.param_texts(param).next().ok_or("expected a string")?;
            options.rasterizer = name.parse().map_err(|error: olema::Error| error.to_string())?;
        }
        "tile" => {
            let pattern_tile = Some(whole(args, param)?);
            check(Settings { pattern_tile, ..Settings::default() })?;
            options.pattern_tile = pattern_tile;
        }
        "permutations" => {
            let permutations = whole(args, param)?;
            check(Settings { permutations, ..Settings::default() })?;
            options.permutations = Some(permutations);
        }
        _ => return Ok(Some("has no effect in Olema")),
    }
    Ok(None)
}

/// Sides of the aperture, angle of its first corner, roundness of its sides, how light gathers at its border.
fn aperture(
    [sides, angle, roundness, density]: [f32; 4],
    options: &mut OptionState,
) -> Result<Option<&'static str>, String> {
    if !(0.0..=MAX_BLADES).contains(&sides) || sides.fract() != 0.0 {
        return Err(format!("{sides} sides: expected a whole number from 0 to {MAX_BLADES}"));
    }
    options.aperture = (sides as u32, angle);
    let has_more = roundness != 0.0 || density != 0.0;
    Ok(has_more.then_some("has roundness or density: they have no effect in Olema"))
}

fn numbers<const N: usize>(args: &Args, param: &ParamItem) -> Result<[f32; N], String> {
    args.param_floats(param).try_into().map_err(|_| match N {
        1 => format!("expected one number, found {}", args.param_len(param)),
        _ => format!("expected {N} numbers, found {}", args.param_len(param)),
    })
}

fn whole(args: &Args, param: &ParamItem) -> Result<u32, String> {
    let [number] = numbers(args, param)?;
    // What is not whole, or too large, is outside every setting's range.
    if number.fract() == 0.0 && number >= 0.0 {
        Ok(number as u32)
    } else {
        Err(format!("{number}: expected a whole number of at least 0"))
    }
}

fn check(settings: Settings) -> Result<(), String> {
    settings.validate().map_err(|error| error.to_string())
}
