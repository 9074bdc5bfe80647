//! `olema info`: what is in a scene, without rendering it.

mod motion;

use std::collections::BTreeMap;
use std::fmt::Write;

use olema::Scene;
use olema::scene::{
    Geometry, Keyed, PatchKind, PatchMesh, Points, Primitive, Projection, Scheme, SubdivisionMesh,
};
use olema_formats::rib::RibFrame;
use serde::Serialize;

use crate::args::InfoArgs;
use crate::exit::{self, Failure};
use crate::memory::Budget;
use crate::report::{self, Counts, Reporter};
use crate::source;
use motion::{LensInfo, MotionInfo, ShutterInfo};

/// Most times at which a moving primitive is looked at for the bounding box.
const MAX_BOX_TIMES: usize = 64;

/// What is told of a file.
#[derive(Debug, Serialize)]
struct FileInfo {
    file: String,
    frames: Vec<FrameInfo>,
    diagnostics: Counts,
}

/// What is told of a frame.
#[derive(Debug, Serialize)]
struct FrameInfo {
    number: i32,
    resolution: [u32; 2],
    /// `[x0, x1, y0, y1]` in pixels, end exclusive.
    window_px: [u32; 4],
    samples: [u32; 2],
    projection: String,
    shutter: ShutterInfo,
    /// None for a pinhole.
    lens: Option<LensInfo>,
    motion: MotionInfo,
    displays: Vec<String>,
    /// Primitives by kind.
    primitives: BTreeMap<&'static str, u64>,
    patches: u64,
    /// Faces of subdivision meshes.
    faces: u64,
    control_points: u64,
    /// Light shaders and how many lights use each.
    lights: BTreeMap<String, u64>,
    /// Surface shaders and how many primitives use each.
    shaders: BTreeMap<String, u64>,
    /// Smallest and largest x, y, z of the control points in world space, at their key times; none where there is
    /// no point.
    bounding_box: Option<[[f64; 3]; 2]>,
}

/// Prints what is in the file. Returns the exit code.
pub fn run(args: &InfoArgs) -> u8 {
    let options = report::Options { quiet: args.quiet, verbose: args.verbose, json: false };
    let mut reporter = Reporter::new(options);
    let (info, mut code) = match read(args, &mut reporter) {
        Ok(read) => read,
        Err(failure) => return reporter.failure(&failure),
    };
    if code == exit::OK && info.diagnostics.errors > 0 {
        code = exit::SCENE;
    }
    if let Err(failure) = text(&info, args.json).and_then(|text| report::print(&text)) {
        code = reporter.failure(&failure);
    }
    reporter.finish();
    code
}

fn text(info: &FileInfo, json: bool) -> Result<String, Failure> {
    if !json {
        return Ok(prose(info));
    }
    let text = serde_json::to_string_pretty(info);
    text.map(|t| t + "\n").map_err(|e| Failure::new(exit::RENDER, e.to_string()))
}

/// Reads the file to its end, or to where nothing further can be read, and the exit code of that.
fn read(args: &InfoArgs, reporter: &mut Reporter) -> Result<(FileInfo, u8), Failure> {
    source::check_search_path(&args.search_path)?;
    let file = args.file.to_string_lossy().into_owned();
    let mut info = FileInfo { file, frames: Vec::new(), diagnostics: Counts::default() };
    let mut code = exit::OK;
    match source::open(&args.file, &args.search_path, args.model, Budget::new(None).reader()) {
        Err(error) => code = reporter.read_error(error),
        Ok(mut reader) => loop {
            let next = reader.next_frame();
            reporter.diagnostics(reader.take_diagnostics());
            match next {
                Ok(None) => break,
                Err(error) => {
                    code = reporter.read_error(error);
                    break;
                }
                Ok(Some(frame)) => {
                    let ordinal = i32::try_from(info.frames.len()).unwrap_or(i32::MAX).saturating_add(1);
                    info.frames.push(FrameInfo::new(&frame, ordinal));
                }
            }
        },
    }
    info.diagnostics = reporter.counts();
    Ok((info, code))
}

impl FrameInfo {
    fn new(frame: &RibFrame, ordinal: i32) -> Self {
        let RibFrame { number, scene, settings, displays } = frame;
        let mut info = FrameInfo {
            number: number.unwrap_or(ordinal),
            resolution: settings.resolution,
            window_px: settings.window_px(),
            samples: settings.samples,
            projection: projection(scene),
            shutter: ShutterInfo::new(&scene.camera),
            lens: LensInfo::new(&scene.camera),
            motion: MotionInfo::new(scene),
            displays: displays.iter().map(|d| format!("{} ({})", d.name, d.mode)).collect(),
            primitives: BTreeMap::new(),
            patches: 0,
            faces: 0,
            control_points: 0,
            lights: BTreeMap::new(),
            shaders: BTreeMap::new(),
            bounding_box: None,
        };
        for light in &scene.lights {
            *info.lights.entry(light.shader.name().to_owned()).or_default() += 1;
        }
        for primitive in &scene.primitives {
            info.add(primitive);
        }
        info
    }

    fn add(&mut self, primitive: &Primitive) {
        *self.shaders.entry(primitive.attributes.surface.name().to_owned()).or_default() += 1;
        let kind = match &primitive.geometry {
            Geometry::Patches(mesh) => {
                self.add_patches(primitive, mesh);
                match *mesh.kind {
                    PatchKind::Bilinear => "bilinear patches",
                    PatchKind::Bicubic { .. } => "bicubic patches",
                }
            }
            Geometry::Subdivision(mesh) => {
                self.add_mesh(primitive, mesh);
                match mesh.scheme {
                    Scheme::CatmullClark => "catmull-clark meshes",
                    Scheme::Loop => "loop meshes",
                    Scheme::Bilinear => "bilinear meshes",
                }
            }
            _ => "other",
        };
        *self.primitives.entry(kind).or_default() += 1;
    }

    fn add_patches(&mut self, primitive: &Primitive, mesh: &PatchMesh) {
        let [pu, pv] = mesh.num_patches().unwrap_or([0, 0]);
        self.patches += pu as u64 * pv as u64;
        self.control_points += mesh.points.first().len() as u64;
        self.add_points(primitive, &mesh.points, positions);
    }

    fn add_mesh(&mut self, primitive: &Primitive, mesh: &SubdivisionMesh) {
        self.faces += mesh.face_vertex_counts.len() as u64;
        self.control_points += mesh.points.first().len() as u64;
        self.add_points(primitive, &mesh.points, |key| Box::new(key.iter().map(|p| p.map(f64::from))));
    }

    /// Grows the bounding box by all keys of a primitive's points.
    fn add_points<T>(
        &mut self,
        primitive: &Primitive,
        points: &Keyed<T>,
        positions: impl Fn(&T) -> Box<dyn Iterator<Item = [f64; 3]> + '_>,
    ) {
        let times = primitive.to_world.times();
        // Some of very many, evenly spread, the last among them.
        let step = times.len().div_ceil(MAX_BOX_TIMES).max(1);
        let mut times: Vec<f64> = times.iter().rev().step_by(step).map(|&t| f64::from(t)).collect();
        if times.is_empty() {
            times.push(0.0);
        }
        for to_world in times.iter().map(|&time| primitive.to_world.at(time)) {
            for key in &points.values {
                for p in positions(key) {
                    self.grow(to_world.transform_point3(p.into()).into());
                }
            }
        }
    }

    fn grow(&mut self, p: [f64; 3]) {
        if p.iter().any(|c| !c.is_finite()) {
            return;
        }
        let [min, max] = self.bounding_box.get_or_insert([p, p]);
        for axis in 0..3 {
            min[axis] = min[axis].min(p[axis]);
            max[axis] = max[axis].max(p[axis]);
        }
    }
}

fn positions(points: &Points) -> Box<dyn Iterator<Item = [f64; 3]> + '_> {
    match points {
        Points::P(p) => Box::new(p.iter().map(|p| p.map(f64::from))),
        Points::Pw(p) => {
            Box::new(p.iter().map(|&[x, y, z, w]| [x, y, z].map(|c| f64::from(c) / f64::from(w))))
        }
    }
}

fn projection(scene: &Scene) -> String {
    match scene.camera.projection {
        Projection::Perspective { fov } => format!("perspective, {fov} degrees"),
        Projection::Orthographic => "orthographic".to_owned(),
    }
}

/// A few lines a frame.
fn prose(info: &FileInfo) -> String {
    let mut out = String::new();
    let name = if info.file == "-" { "standard input" } else { &info.file };
    let frames = info.frames.len();
    let _ = writeln!(out, "{name}: {frames} frame{}", if frames == 1 { "" } else { "s" });
    for frame in &info.frames {
        let [w, h] = frame.resolution;
        let [nx, ny] = frame.samples;
        let _ = writeln!(out, "\nframe {}", frame.number);
        let mut line = |what: &str, text: String| {
            let _ = writeln!(out, "  {what:<15} {text}");
        };
        line("resolution", format!("{w}x{h}"));
        if frame.window_px != [0, w, 0, h] {
            let [x0, x1, y0, y1] = frame.window_px;
            line("crop", format!("{x0},{x1},{y0},{y1} pixels"));
        }
        line("samples", format!("{nx}x{ny}"));
        line("projection", frame.projection.clone());
        line("shutter", frame.shutter.prose());
        line("lens", frame.lens.as_ref().map_or("pinhole".to_owned(), LensInfo::prose));
        line("displays", frame.displays.join(", "));
        line("primitives", counts(&frame.primitives));
        line("motion", frame.motion.prose(frame.primitives.values().sum::<u64>() as usize));
        line("patches", frame.patches.to_string());
        line("faces", frame.faces.to_string());
        line("control points", frame.control_points.to_string());
        line("lights", counts(&frame.lights));
        line("shaders", counts(&frame.shaders));
        let corner = |[x, y, z]: [f64; 3]| format!("({x:.6}, {y:.6}, {z:.6})");
        let bounds = frame.bounding_box.map(|[min, max]| format!("{} to {}", corner(min), corner(max)));
        line("bounding box", bounds.unwrap_or_else(|| "none".to_owned()));
    }
    let Counts { errors, warnings, notes } = info.diagnostics;
    let _ = writeln!(out, "\nmessages: {errors} errors, {warnings} warnings, {notes} notes");
    report::printable_lines(&out)
}

fn counts<K: AsRef<str>>(of: &BTreeMap<K, u64>) -> String {
    if of.is_empty() {
        return "none".to_owned();
    }
    of.iter().map(|(name, n)| format!("{n} {}", name.as_ref())).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_without_frames_is_told_in_a_line() {
        let info = FileInfo { file: "a.rib".to_owned(), frames: Vec::new(), diagnostics: Counts::default() };
        assert_eq!(prose(&info), "a.rib: 0 frames\n\nmessages: 0 errors, 0 warnings, 0 notes\n");
    }

    #[test]
    fn rational_points_are_divided_by_their_weight() {
        let points = Points::Pw(vec![[2.0, 4.0, 6.0, 2.0]]);
        assert_eq!(positions(&points).collect::<Vec<_>>(), [[1.0, 2.0, 3.0]]);
    }
}
