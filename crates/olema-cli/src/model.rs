//! Models (OBJ): a mesh and nothing else becomes a scene, and what was added to it is said.
//!
//! In: a file of faces and tags. Out: a frame with a surface a part, a camera that sees all of it, three lights
//! that stand with the camera, and the words of the reader.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::sync::Arc;

use glam::{DMat3, DMat4, DVec3};
use olema::scene::{
    Attributes, Camera, Geometry, Light, Origin, Primitive, Projection, Scheme, ShadingInterpolation, Sides,
    Transform,
};
use olema::shading::{self, ShaderParam};
use olema::{Error, Scene, Settings};
use olema_formats::obj::{self, Obj, Part};
use olema_formats::rib::{Display, Quantize, RibFrame};
use olema_formats::{Diagnostic, ReadError, Severity};

use crate::values::{SchemeName, UpAxis};

/// Field of view in degrees, over the shorter side of the picture.
const FOV: f64 = 40.0;
/// From the middle of the bounding sphere to the eye, in radii: a sphere fills a view of 40 degrees at
/// 1 / sin(20 degrees) = 2.92 of them.
const DISTANCE: f64 = 3.0;
/// The three-quarter view: degrees to the right of the front, and above it.
const VIEW: [f64; 2] = [35.0, 25.0];
/// A model is taken for one that lies flat, z up, if it extends less far in z than this times x and y.
const FLAT: f64 = 0.1;

const COLOR: [f32; 3] = [0.78, 0.42, 0.24];
const BACKGROUND: [f32; 3] = [0.10, 0.13, 0.17];

/// What the command line says about models.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct ModelArgs {
    /// How an OBJ model is subdivided
    ///
    /// Without it the file's name tells, if it begins with catmark_, loop_ or bilinear_; else a file with
    /// subdivision tags is taken as catmark, one without as bilinear, which draws its faces as they are.
    #[arg(long, value_name = "SCHEME", value_enum)]
    pub subdivide: Option<SchemeName>,

    /// Axis of an OBJ model that points up; without it y, or z for one that is nearly flat in z
    #[arg(long, value_name = "AXIS", value_enum)]
    pub up: Option<UpAxis>,
}

/// A model that was read.
#[derive(Debug)]
pub struct Model {
    /// The scene, until it is taken; none where the file has no face.
    pub frame: Option<RibFrame>,
    /// What was said about it.
    pub said: Vec<Diagnostic>,
}

/// Whether the file is a model, by its name.
pub fn is_model(file: &Path) -> bool {
    file.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj"))
}

impl Model {
    /// Makes a scene of a file, of which at most `memory` bytes are held.
    ///
    /// # Errors
    /// [`ReadError`] where it cannot be opened, or read to its end.
    pub fn open(file: &Path, args: ModelArgs, memory: u64) -> Result<Self, ReadError> {
        let io = |source| ReadError::Io { path: file.display().to_string(), source };
        let input = BufReader::new(File::open(file).map_err(io)?);
        let (obj, said) = obj::read(&file.to_string_lossy(), input, memory)?;
        Ok(Model::new(file, &obj, said, args))
    }

    /// Makes a scene of what a file holds, and `said` was about it.
    fn new(file: &Path, obj: &Obj, mut said: Vec<Diagnostic>, args: ModelArgs) -> Self {
        let name = file.to_string_lossy();
        let (scheme, why) = scheme(&name, obj, args.subdivide);
        let parts = obj.parts(scheme.into());
        if parts.is_empty() {
            return Model { frame: None, said };
        }
        let view = View::of(&parts, args.up);
        said.push(note(format!("{name} is drawn as {scheme} ({why}); --subdivide changes that")));
        said.push(note(format!("no camera in {name}: {view}; lit by a key, a fill and an ambient light")));
        let stem = file.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        match scene(&name, &stem, parts, &view) {
            Ok(scene) => {
                let settings = Settings { background: Some(BACKGROUND), ..Settings::default() };
                let quantize = Quantize { one: 255, min: 0, max: 255, dither: 0.5 };
                let [driver, mode] = ["file", "rgba"].map(str::to_owned);
                let displays = vec![Display { name: stem, driver, mode, quantize }];
                Model { frame: Some(RibFrame { number: None, scene, settings, displays }), said }
            }
            Err(error) => {
                said.push(placeless(Severity::Error, error.to_string()));
                Model { frame: None, said }
            }
        }
    }
}

fn note(message: String) -> Diagnostic {
    placeless(Severity::Note, message)
}

fn placeless(severity: Severity, message: String) -> Diagnostic {
    Diagnostic { severity, file: String::new(), line: 0, column: 0, message, source_line: None }
}

/// The scheme, and who decided on it.
fn scheme(name: &str, obj: &Obj, asked: Option<SchemeName>) -> (SchemeName, &'static str) {
    match (asked, obj::scheme_of_name(name)) {
        (Some(scheme), _) => (scheme, "as asked"),
        (None, Some(Scheme::CatmullClark)) => (SchemeName::Catmark, "its name says so"),
        (None, Some(Scheme::Loop)) => (SchemeName::Loop, "its name says so"),
        (None, Some(Scheme::Bilinear)) => (SchemeName::Bilinear, "its name says so"),
        (None, None) if obj.tags.any => (SchemeName::Catmark, "it has subdivision tags"),
        (None, None) => (SchemeName::Bilinear, "it has no subdivision tags"),
    }
}

/// Where the model is looked at from.
#[derive(Debug, Clone, Copy, PartialEq)]
struct View {
    eye: DVec3,
    middle: DVec3,
    radius: f64,
    up: UpAxis,
}

impl View {
    /// A view of all points that the parts use. A surface lies within the hull of its control points.
    fn of(parts: &[Part], up: Option<UpAxis>) -> Self {
        let points = || {
            let used = parts.iter().flat_map(|Part { mesh, .. }| {
                let point = |ix: &i32| mesh.points.first().get(usize::try_from(*ix).ok()?).copied();
                mesh.indices.iter().filter_map(point)
            });
            used.map(|p| DVec3::from_array(p.map(f64::from))).filter(|p| p.is_finite())
        };
        let bounds = points().fold(None, |bounds: Option<[DVec3; 2]>, p| {
            let [min, max] = bounds.unwrap_or([p, p]);
            Some([min.min(p), max.max(p)])
        });
        let [min, max] = bounds.unwrap_or([DVec3::ZERO; 2]);
        let middle = (min + max) / 2.0;
        let radius = points().map(|p| (p - middle).length()).fold(0.0, f64::max);
        let radius = if radius > 0.0 { radius } else { 1.0 };
        let extent = max - min;
        let is_flat = extent.z < FLAT * extent.x.min(extent.y);
        let up = up.unwrap_or(if is_flat { UpAxis::Z } else { UpAxis::Y });
        let [right, above] = VIEW.map(f64::to_radians);
        let [x, y, front] = [right.sin() * above.cos(), above.sin(), right.cos() * above.cos()];
        let direction = match up {
            UpAxis::Y => DVec3::new(x, y, front),
            UpAxis::Z => DVec3::new(x, -front, y),
        };
        View { eye: middle + DISTANCE * radius * direction, middle, radius, up }
    }

    fn up(&self) -> DVec3 {
        if self.up == UpAxis::Z { DVec3::Z } else { DVec3::Y }
    }

    /// The model's space is right-handed, the camera's left-handed: x right, y up, z into the picture.
    fn world_to_camera(&self) -> DMat4 {
        let forward = (self.middle - self.eye).normalize();
        let right = forward.cross(self.up()).normalize();
        let up = right.cross(forward);
        let axes = DMat3::from_cols(right, up, forward).transpose();
        DMat4::from_mat3(axes) * DMat4::from_translation(-self.eye)
    }

    fn camera(&self) -> Camera {
        Camera {
            world_to_camera: Transform::still(self.world_to_camera()),
            projection: Projection::Perspective { fov: FOV as f32 },
            clipping: [(1e-3 * self.radius) as f32, f32::INFINITY],
            ..Camera::default()
        }
    }
}

impl std::fmt::Display for View {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // Four digits of the radius.
        let digits = (3.0 - self.radius.log10().floor()).clamp(0.0, 12.0) as usize;
        let point = |DVec3 { x, y, z }: DVec3| format!("({x:.digits$}, {y:.digits$}, {z:.digits$})");
        write!(f, "looking from {} at {}, {} up", point(self.eye), point(self.middle), self.up)
    }
}

fn scene(file: &str, stem: &str, parts: Vec<Part>, view: &View) -> Result<Scene, Error> {
    let mut scene = Scene::new(view.camera());
    let file: Arc<str> = Arc::from(file);
    let lights = lights(&view.world_to_camera().inverse())?.map(|light| scene.add_light(light));
    let shine = [("Ka", 1.0), ("Kd", 0.8), ("Ks", 0.25), ("roughness", 0.08)];
    let surface = shading::surface("plastic", &shine.map(|(name, value)| ShaderParam::float(name, value)))?;
    let look = Attributes {
        color: COLOR,
        surface: surface.shader,
        lights: Arc::from(lights),
        shading_interpolation: ShadingInterpolation::Smooth,
        sides: Sides::Two,
        ..Attributes::default()
    };
    for Part { name, line, mesh } in parts {
        let name = if name.is_empty() { stem.to_owned() } else { name };
        let attributes = Attributes { name, ..look.clone() };
        scene.primitives.push(Primitive {
            geometry: Geometry::Subdivision(Arc::new(mesh)),
            to_world: Transform::default(),
            attributes: Arc::new(attributes),
            origin: Origin { file: Arc::clone(&file), line },
        });
    }
    Ok(scene)
}

/// A key from the upper left, a fill from the right, and a little from everywhere.
fn lights(camera_to_world: &DMat4) -> Result<[Light; 3], Error> {
    let light = |name: &str, intensity: f32, color: [f32; 3], from: [f32; 3]| {
        let mut params =
            vec![ShaderParam::float("intensity", intensity), ShaderParam::color("lightcolor", color)];
        if name == "distantlight" {
            params.extend([ShaderParam::point("from", from), ShaderParam::point("to", [0.0; 3])]);
        }
        let shader = shading::light(name, &params)?.shader;
        Ok(Light { shader, to_world: Transform::still(*camera_to_world) })
    };
    Ok([
        light("distantlight", 0.95, [1.0, 0.97, 0.92], [-0.8, 1.1, -1.0])?,
        light("distantlight", 0.35, [0.75, 0.85, 1.0], [1.2, 0.1, -0.5])?,
        light("ambientlight", 0.18, [1.0, 1.0, 1.0], [0.0; 3])?,
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1\n\
        f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";

    fn obj(text: &str) -> Obj {
        obj::read("x.obj", text.as_bytes(), obj::MEMORY).expect("a model").0
    }

    fn view(text: &str, up: Option<UpAxis>) -> View {
        View::of(&obj(text).parts(Scheme::Bilinear), up)
    }

    #[test]
    fn the_whole_bounding_sphere_is_in_the_picture() {
        let view = view(CUBE, None);
        assert_eq!((view.middle, view.up), (DVec3::ZERO, UpAxis::Y));
        assert!((view.radius - 3f64.sqrt()).abs() < 1e-12);
        assert!(((view.eye.length() / view.radius).recip().asin().to_degrees()) < FOV / 2.0);
        let to_camera = view.world_to_camera();
        assert!(to_camera.transform_point3(DVec3::ZERO).abs_diff_eq(DVec3::Z * view.eye.length(), 1e-9));
        // What is up and what is to the right from the front are so in the picture.
        assert!(to_camera.transform_vector3(DVec3::Y).y > 0.0);
        assert!(to_camera.transform_vector3(DVec3::X).x > 0.0);
    }

    #[test]
    fn a_flat_model_lies_and_an_option_decides() {
        let flat = "v 0 0 0\nv 4 0 0\nv 4 3 0.1\nv 0 3 0\nf 1 2 3 4\n";
        assert_eq!(view(flat, None).up, UpAxis::Z);
        assert_eq!(view(flat, Some(UpAxis::Y)).up, UpAxis::Y);
        let upright = view(CUBE, Some(UpAxis::Z));
        assert!(upright.eye.z > 0.0 && upright.eye.y < 0.0);
        let to_camera = upright.world_to_camera();
        assert!(to_camera.transform_vector3(DVec3::Z).y > 0.0);
        assert!(to_camera.transform_vector3(DVec3::X).x > 0.0);
    }

    #[test]
    fn points_that_say_nothing_do_not_move_the_camera() {
        let far = CUBE.replace("f 1 3 4 2", "v 1e30 0 0\nv nan 0 0\nf 1 3 4 2\nf 1 2 10");
        assert_eq!(view(&far, None).radius, view(CUBE, None).radius);
        assert_eq!(view("v 5 5 5\nf 1 1 1\n", None).radius, 1.0);
    }

    #[test]
    fn the_scheme_is_asked_for_or_told_by_the_name_or_the_tags() {
        let of = |name: &str, text: &str, asked| scheme(name, &obj(text), asked).0;
        let tag = "t interpolateboundary 1/0/0 2\n";
        assert_eq!(of("a.obj", CUBE, None), SchemeName::Bilinear);
        assert_eq!(of("a.obj", tag, None), SchemeName::Catmark);
        assert_eq!(of("dir/loop_a.obj", tag, None), SchemeName::Loop);
        assert_eq!(of("dir/loop_a.obj", tag, Some(SchemeName::Bilinear)), SchemeName::Bilinear);
    }
}
