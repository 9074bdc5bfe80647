//! Options: how the picture is made.

use std::path::PathBuf;
use std::sync::Arc;

use olema::image::{Filter, FilterKind};
use olema::scene::{Lens, Projection};

use super::super::fault::Fault;
use super::super::state::{DisplayState, OptionState};
use super::super::statements::Id;
use super::super::{Display, Quantize};
use super::{Call, Interp, MAX_DISPLAYS};

/// Most directories in a search path.
const MAX_PATHS: usize = 256;

impl Interp {
    /// Runs a statement that sets an option; `false` where it is another one.
    pub(super) fn option(&mut self, call: &Call<'_>) -> Result<bool, Fault> {
        let args = call.args;
        match call.statement.id {
            Id::Declare => {
                let (name, text) = (args.text(0).unwrap_or_default(), args.text(1).unwrap_or_default());
                let done = self.dictionary.declare(name, text);
                done.map_err(|why| Fault::error(args.pos(1), format!("\"{text}\": {why}")))?;
            }
            Id::CoordinateSystem | Id::ScopedCoordinateSystem => self.name_space(call)?,
            Id::Option => self.named_option(call),
            Id::Display => self.display(call),
            Id::Projection => self.projection(call)?,
            Id::Hider => self.hider(call),
            _ => return self.frame_option(call),
        }
        Ok(true)
    }

    /// Options of the frame's size and place.
    fn frame_option(&mut self, call: &Call<'_>) -> Result<bool, Fault> {
        let args = call.args;
        let wrong =
            |message: &str| Fault::error(args.pos(0), format!("{}: {message}; ignored", call.statement.name));
        let options = Arc::make_mut(&mut self.options);
        match call.statement.id {
            Id::Format => format(call, options).map_err(|m| wrong(&m))?,
            Id::FrameAspectRatio => {
                let ratio = args.num(0);
                if !(1e-4..=1e4).contains(&ratio) {
                    return Err(wrong("expected a ratio from 1e-4 to 1e4"));
                }
                options.frame_aspect = Some(ratio);
            }
            Id::ScreenWindow => {
                let window = args.array(0).filter(|[l, r, b, t]| l != r && b != t);
                options.screen_window =
                    Some(window.ok_or_else(|| wrong("expected left and right, bottom and top to differ"))?);
            }
            Id::CropWindow => {
                let inside =
                    |c: &[f64; 4]| c.iter().all(|v| (0.0..=1.0).contains(v)) && c[0] < c[1] && c[2] < c[3];
                let crop = args.array(0).filter(inside);
                options.crop =
                    Some(crop.ok_or_else(|| wrong("expected 0 <= xmin < xmax <= 1 and the same for y"))?);
            }
            Id::Clipping => {
                let (near, far) = (args.num(0).max(1e-10), args.num(1));
                if near >= far {
                    return Err(wrong("expected 0 < near < far"));
                }
                options.clipping = [near, if far >= 1e30 { f64::INFINITY } else { far }];
            }
            _ => return self.sampling_option(call),
        }
        Ok(true)
    }

    /// Options of the lens, the shutter and the film.
    fn sampling_option(&mut self, call: &Call<'_>) -> Result<bool, Fault> {
        let args = call.args;
        let wrong =
            |message: &str| Fault::error(args.pos(0), format!("{}: {message}; ignored", call.statement.name));
        let options = Arc::make_mut(&mut self.options);
        match call.statement.id {
            Id::DepthOfField => {
                let lens = lens(args.nums(0)).map_err(wrong)?;
                options.lens = lens.map(|lens| (lens, call.site.clone()));
            }
            Id::Shutter => {
                let (open, close) = (args.num(0) as f32, args.num(1) as f32);
                if open > close {
                    return Err(wrong("expected the opening time not to be after the closing time"));
                }
                if !(close - open).is_finite() {
                    return Err(wrong("expected times that single precision can tell the difference of"));
                }
                options.shutter = [open, close];
            }
            Id::PixelSamples => {
                let samples = [args.num(0), args.num(1)].map(|n| n.round().clamp(0.0, 1e6) as u32);
                if samples[0] * samples[1].min(1025) > 1024 || samples.contains(&0) {
                    return Err(wrong("expected 1 to 1024 samples a pixel"));
                }
                options.samples = samples;
            }
            Id::PixelFilter => options.filter = filter(call).map_err(|m| wrong(&m))?,
            Id::Exposure => {
                let (gain, gamma) = (args.num(0), args.num(1));
                if gamma < 1e-3 || gain < 0.0 {
                    return Err(wrong("expected a gain of at least 0 and a gamma above 0"));
                }
                options.exposure = [gain as f32, gamma as f32];
            }
            Id::RelativeDetail => {
                if args.num(0) < 0.0 {
                    return Err(wrong("expected a factor of at least 0"));
                }
                options.relative_detail = args.num(0);
            }
            Id::Quantize => quantize(call, options).map_err(|m| wrong(&m))?,
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn projection(&mut self, call: &Call<'_>) -> Result<(), Fault> {
        let args = call.args;
        let projection = match args.text(0).unwrap_or_default() {
            "perspective" => {
                let fov =
                    args.find("fov").and_then(|p| args.param_floats(p).first()).copied().unwrap_or(90.0);
                if !(1e-3..179.999).contains(&fov) {
                    return Err(Fault::error(
                        args.pos(0),
                        format!("fov is {fov}: expected above 0 and below 180; ignored"),
                    ));
                }
                Projection::Perspective { fov }
            }
            "orthographic" | "" => Projection::Orthographic,
            name => {
                let message = format!(
                    "projection \"{name}\" is unknown: expected \"perspective\" or \"orthographic\"; ignored"
                );
                return Err(Fault::warning(args.pos(0), message));
            }
        };
        Arc::make_mut(&mut self.options).projection = projection;
        // Camera space begins here: what was before belongs to the projection.
        if self.ctm.first() != glam::DMat4::IDENTITY {
            let message = "transforms before Projection would move the finished picture: ignored; expected them after it";
            self.say(Fault::warning(call.site.pos, message));
        }
        self.ctm = Default::default();
        Ok(())
    }

    fn display(&mut self, call: &Call<'_>) {
        let args = call.args;
        let text = |ix| args.text(ix).unwrap_or_default().to_owned();
        let (name, driver, mode) = (text(0), text(1), text(2));
        let options = Arc::make_mut(&mut self.options);
        let name = match name.strip_prefix('+') {
            Some(rest) => rest.to_owned(),
            None => {
                options.displays.clear();
                name
            }
        };
        if options.displays.len() >= MAX_DISPLAYS {
            let message = format!("expected at most {MAX_DISPLAYS} displays; left out");
            return self.say(Fault::warning(call.site.pos, message));
        }
        let own = args.find("quantize").and_then(|p| <[f32; 4]>::try_from(args.param_floats(p)).ok());
        let dither = args.find("dither").and_then(|p| args.param_floats(p).first()).copied();
        let [zero, one, min, max] = own.unwrap_or_default();
        if zero != 0.0 {
            let pos = args.find("quantize").map_or(call.site.pos, |p| p.pos);
            let message = "\"quantize\" with a zero other than 0: the offset has no effect in Olema";
            self.said.push(Fault::note(pos, message));
        }
        let quantize = Quantize { one: one as i32, min: min as i32, max: max as i32, dither: 0.0 };
        let display = Display { name, driver, mode, quantize };
        options.displays.push(DisplayState { display, own: own.is_some(), dither });
    }

    fn named_option(&mut self, call: &Call<'_>) {
        let args = call.args;
        let category = args.text(0).unwrap_or_default();
        let options = Arc::make_mut(&mut self.options);
        if !options.values.set_params(category, args) {
            self.said.push(Fault::warning(
                call.site.pos,
                "too many options: expected at most 1024; the last are ignored",
            ));
        }
        for param in &args.params {
            let floats = args.param_floats(param);
            let whole = |ix: usize| floats.get(ix).map(|f| f.clamp(0.0, 65_536.0) as u32);
            match (category, args.param_name(param)) {
                ("limits", "gridsize") => options.grid_size = whole(0),
                ("limits", "eyesplits") => options.eye_splits = whole(0),
                ("limits", "bucketsize") => {
                    options.bucket = whole(0).zip(whole(1).or(whole(0))).map(|(x, y)| [x, y])
                }
                ("searchpath", "archive") => {
                    let text = args.param_texts(param).next().unwrap_or_default();
                    options.search_path = search_path(text, &options.search_path);
                }
                ("searchpath", "texture") => {
                    let text = args.param_texts(param).next().unwrap_or_default();
                    options.texture_path = search_path(text, &options.texture_path);
                }
                _ => {}
            }
        }
    }
}

fn format(call: &Call<'_>, options: &mut OptionState) -> Result<(), String> {
    let (width, height, aspect) = (call.args.int(0), call.args.int(1), call.args.num(2));
    // Negative numbers ask for the default.
    let size = |n: i32, default: u32| if n < 0 { default } else { n as u32 };
    let (width, height) = (size(width, 640), size(height, 480));
    if !(1..=65_535).contains(&width) || !(1..=65_535).contains(&height) {
        return Err(format!("{width} x {height}: expected 1 to 65535 pixels each way"));
    }
    if aspect > 0.0 && !(1e-4..=1e4).contains(&aspect) {
        return Err(format!("pixel aspect ratio {aspect}: expected 1e-4 to 1e4"));
    }
    options.format = [width, height];
    options.pixel_aspect = if aspect > 0.0 { aspect } else { 1.0 };
    Ok(())
}

fn lens(numbers: &[f64]) -> Result<Option<Lens>, &'static str> {
    let [fstop, focal_length, focal_distance] = *numbers else { return Ok(None) };
    // In single precision, as the scene keeps it.
    let lens = Lens::new(fstop as f32, focal_length as f32, focal_distance as f32);
    let radius = lens.focal_length / (2.0 * lens.fstop);
    if !(lens.fstop > 0.0 && lens.focal_length > 0.0 && lens.focal_distance > 0.0 && radius.is_finite()) {
        return Err("expected an f-stop, a focal length and a focal distance above 0");
    }
    // RI_INFINITY, the standard's pinhole, is written as 1e38.
    Ok((fstop < 1e30).then_some(lens))
}

fn filter(call: &Call<'_>) -> Result<Filter, String> {
    let name = call.args.text(0).unwrap_or_default();
    let kind = match name {
        "box" => FilterKind::Box,
        "triangle" => FilterKind::Triangle,
        "catmull-rom" => FilterKind::CatmullRom,
        "gaussian" => FilterKind::Gaussian,
        "sinc" => FilterKind::Sinc,
        "mitchell" => FilterKind::Mitchell,
        "blackman-harris" => FilterKind::BlackmanHarris,
        _ => {
            let expected = "box, triangle, catmull-rom, gaussian, sinc, mitchell or blackman-harris";
            return Err(format!("filter \"{name}\" is unknown: expected {expected}"));
        }
    };
    let filter = Filter { kind, width: [call.args.num(1) as f32, call.args.num(2) as f32] };
    if filter.is_valid() {
        Ok(filter)
    } else {
        Err("expected widths above 0 and at most 64 pixels".to_owned())
    }
}

fn quantize(call: &Call<'_>, options: &mut OptionState) -> Result<(), String> {
    let args = call.args;
    let (one, min, max) = (args.int(1), args.int(2), args.int(3));
    let dither = args.num(4) as f32;
    if one < 0 || min > max || !(0.0..=1e6).contains(&dither) {
        return Err("expected one of at least 0, min not above max, and a dither of at least 0".to_owned());
    }
    let name = match args.text(0).unwrap_or_default() {
        "rgb" | "a" | "rgbz" | "rgbaz" => "rgba",
        name => name,
    };
    let quantize = Quantize { one, min, max, dither };
    let full = options.quantize.len() >= MAX_DISPLAYS;
    match options.quantize.iter_mut().find(|q| q.0 == name) {
        Some(old) => old.1 = quantize,
        None if full => {
            return Err(format!("expected at most {MAX_DISPLAYS} types"));
        }
        None => options.quantize.push((name.to_owned(), quantize)),
    }
    Ok(())
}

/// A search path: "&" is what was there before, "@" the standard's (there is none).
fn search_path(text: &str, before: &[PathBuf]) -> Vec<PathBuf> {
    let mut paths: Vec<PathBuf> = Vec::new();
    for part in text.split([':', ';']).filter(|p| !p.is_empty()) {
        match part {
            "&" => paths.extend_from_slice(before),
            "@" => {}
            part => paths.push(part.into()),
        }
        paths.truncate(MAX_PATHS);
    }
    paths
}
