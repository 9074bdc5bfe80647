//! The scene: what is drawn, from where, under which lights. It keeps what a file says; nothing here is
//! tessellated or transformed yet.
//!
//! Spaces: *object* -> *world* (a primitive's `to_world`) -> *camera* (`Camera::world_to_camera`; left-handed,
//! x right, y up, z into the picture) -> *raster* (pixels, y down).

mod geometry;
mod keyed;
mod subdivision;

pub use geometry::{Class, Geometry, PatchBasis, PatchKind, PatchMesh, Points, PrimVar, VarType, VarValues};
pub use keyed::{Between, Keyed, Transform};
pub use subdivision::{BoundaryRule, Crease, CreaseMethod, FaceVaryingRule, Scheme, SubdivisionMesh};

use std::sync::Arc;

use glam::DMat4;

use crate::error::Error;
use crate::shading::{DisplacementShader, LightShader, SurfaceShader};

/// A whole scene.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The camera.
    pub camera: Camera,
    /// All lights; primitives refer to them by index.
    pub lights: Vec<Light>,
    /// What is drawn, in the file's order.
    pub primitives: Vec<Primitive>,
    /// Named spaces: name and the matrix from that space to world.
    pub coordinate_systems: Vec<(String, DMat4)>,
}

impl Scene {
    /// An empty scene seen by `camera`.
    pub fn new(camera: Camera) -> Self {
        Scene { camera, lights: Vec::new(), primitives: Vec::new(), coordinate_systems: Vec::new() }
    }

    /// Checks what every stage relies on: finite matrices, a usable camera, positive shading rates.
    ///
    /// # Errors
    /// [`Error::Scene`] names the object and what was expected.
    pub fn validate(&self) -> Result<(), Error> {
        let fail = |object: String, problem: &str| Err(Error::Scene { object, problem: problem.to_owned() });
        let camera = &self.camera;
        let [near, far] = camera.clipping;
        if !(near > 0.0 && near < far) {
            return fail(
                "camera".to_owned(),
                &format!("clipping planes {near} and {far}: expected 0 < near < far"),
            );
        }
        if let Projection::Perspective { fov } = camera.projection
            && !(fov > 0.0 && fov < 180.0)
        {
            return fail(
                "camera".to_owned(),
                &format!("field of view {fov}: expected more than 0, less than 180"),
            );
        }
        if let Some(window @ [left, right, bottom, top]) = camera.screen_window
            && (left == right || bottom == top || !window.iter().all(|w| w.is_finite()))
        {
            return fail(
                "camera".to_owned(),
                &format!("screen window {window:?}: expected two finite extents"),
            );
        }
        if !(camera.pixel_aspect > 0.0 && camera.pixel_aspect.is_finite()) {
            return fail(
                "camera".to_owned(),
                &format!("pixel aspect {}: expected above 0", camera.pixel_aspect),
            );
        }
        check_shutter(camera)?;
        check_transform(&camera.world_to_camera, || "camera".to_owned())?;
        for (ix, light) in self.lights.iter().enumerate() {
            check_transform(&light.to_world, || format!("light {ix}"))?;
        }
        for (ix, primitive) in self.primitives.iter().enumerate() {
            let name = || primitive.object_name(ix);
            check_transform(&primitive.to_world, name)?;
            let (times, num_keys) = match &primitive.geometry {
                Geometry::Patches(mesh) => (&mesh.points.times, mesh.points.values.len()),
                Geometry::Subdivision(mesh) => (&mesh.points.times, mesh.points.values.len()),
            };
            if !are_key_times(times, num_keys) {
                return fail(
                    name(),
                    &format!("times {times:?} of {num_keys} keys of its points: {KEY_TIMES}"),
                );
            }
            let Attributes { motion_factor, focus_factor, .. } = *primitive.attributes;
            if ![motion_factor, focus_factor].iter().all(|factor| *factor >= 0.0 && factor.is_finite()) {
                return fail(name(), "motion and focus factor: expected finite numbers of at least 0");
            }
            let rate = primitive.attributes.shading_rate;
            if !(rate > 0.0 && rate.is_finite()) {
                return fail(name(), &format!("shading rate {rate}: expected a finite number above 0"));
            }
            if let Some(light) =
                primitive.attributes.lights.iter().find(|&&l| l as usize >= self.lights.len())
            {
                return fail(
                    name(),
                    &format!("light {light} of {}: expected a lower index", self.lights.len()),
                );
            }
        }
        Ok(())
    }

    /// Lets go of the control points of sheets, of which patches have been made.
    pub(crate) fn let_go_of_points(&mut self) {
        let mut last: Option<Arc<PatchMesh>> = None;
        for primitive in &mut self.primitives {
            let Geometry::Patches(mesh) = &mut primitive.geometry else { continue };
            let rest = match last.take() {
                // A file may have a primitive for each patch.
                Some(last) if last.is_like_without_points(mesh) => last,
                _ => Arc::new(mesh.without_points()),
            };
            *mesh = Arc::clone(&rest);
            last = Some(rest);
        }
    }

    /// Adds a light and returns its index for [`Attributes::lights`].
    pub fn add_light(&mut self, light: Light) -> u32 {
        self.lights.push(light);
        (self.lights.len() - 1) as u32
    }
}

/// What times of keys have to be.
const KEY_TIMES: &str = "expected one a key, finite and ascending, or none for a single key";

fn are_key_times(times: &[f32], num_keys: usize) -> bool {
    let ascend = times.windows(2).all(|pair| pair[0] < pair[1]) && times.iter().all(|time| time.is_finite());
    ascend && (times.len() == num_keys && num_keys > 0 || times.is_empty() && num_keys == 1)
}

fn check_transform(transform: &Transform, object: impl Fn() -> String) -> Result<(), Error> {
    let fail = |problem: String| Err(Error::Scene { object: object(), problem });
    if !transform.all(DMat4::is_finite) {
        return fail("its matrix has a number that is not finite".to_owned());
    }
    match transform.factors().iter().find(|factor| !are_key_times(&factor.times, factor.values.len())) {
        Some(factor) => {
            let (times, num_keys) = (&factor.times, factor.values.len());
            fail(format!("times {times:?} of {num_keys} keys of its matrix: {KEY_TIMES}"))
        }
        None => Ok(()),
    }
}

fn check_shutter(camera: &Camera) -> Result<(), Error> {
    let fail = |problem: String| Err(Error::Scene { object: "camera".to_owned(), problem });
    let [open, close] = camera.shutter;
    if !(open <= close && open.is_finite() && close.is_finite()) {
        return fail(format!(
            "shutter {open} to {close}: expected two finite times, the second not before the first"
        ));
    }
    let [full, closing] = camera.shutter_opening;
    if !(0.0 <= full && full <= closing && closing <= 1.0) {
        return fail(format!("shutter opening {full} {closing}: expected 0 <= first <= second <= 1"));
    }
    if let Some(Lens { fstop, focal_length, focal_distance, blade_angle, .. }) = camera.lens {
        let is_positive = |number: f32| number > 0.0 && number.is_finite();
        if ![fstop, focal_length, focal_distance].into_iter().all(is_positive) || !blade_angle.is_finite() {
            return fail(format!(
                "lens of f-stop {fstop}, focal length {focal_length} and focal distance {focal_distance}: expected \
                 finite numbers above 0"
            ));
        }
    }
    Ok(())
}

/// How camera space becomes raster space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// Points at depth z are divided by z; `fov` is the full angle in degrees, in (0, 180), that the
    /// screen coordinates -1 to 1 span.
    Perspective {
        /// Field of view in degrees.
        fov: f32,
    },
    /// Screen coordinates are x and y of camera space.
    Orthographic,
}

/// The camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// World to camera space; keys move the camera.
    pub world_to_camera: Transform,
    /// Projection.
    pub projection: Projection,
    /// `[left, right, bottom, top]` of the frame in screen coordinates; `None` makes the shorter side span
    /// -1 to 1 and the longer the frame's aspect ratio.
    pub screen_window: Option<[f32; 4]>,
    /// Width / height of one pixel.
    pub pixel_aspect: f32,
    /// Near and far clipping depth, 0 < near < far; far may be infinite.
    pub clipping: [f32; 2],
    /// Times at which the shutter begins to open and is closed again; the same for a still picture.
    pub shutter: [f32; 2],
    /// Parts of the time between at which the shutter is fully open and at which it begins to close:
    /// 0 <= first <= second <= 1. `[0, 1]` opens and closes at once.
    pub shutter_opening: [f32; 2],
    /// The thin lens; `None` is a pinhole.
    pub lens: Option<Lens>,
}

impl Default for Camera {
    fn default() -> Self {
        Camera {
            world_to_camera: Transform::default(),
            projection: Projection::Orthographic,
            screen_window: None,
            pixel_aspect: 1.0,
            clipping: [1e-10, f32::INFINITY],
            shutter: [0.0, 0.0],
            shutter_opening: [0.0, 1.0],
            lens: None,
        }
    }
}

/// A thin lens (`DepthOfField`); of perspective cameras only. Its radius is `focal_length / (2 fstop)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    /// Focal length over aperture diameter, above 0.
    pub fstop: f32,
    /// Focal length in camera units, above 0.
    pub focal_length: f32,
    /// Depth in focus, in camera units, above 0.
    pub focal_distance: f32,
    /// Blades of the aperture, 3 or more; fewer make it round.
    pub blades: u32,
    /// Angle of the aperture's first corner in degrees, counter-clockwise from the right as highlights behind the
    /// focus show it.
    pub blade_angle: f32,
}

impl Lens {
    /// A round lens.
    pub fn new(fstop: f32, focal_length: f32, focal_distance: f32) -> Self {
        Lens { fstop, focal_length, focal_distance, blades: 0, blade_angle: 0.0 }
    }
}

/// A light: its shader and where it stands.
#[derive(Debug, Clone)]
pub struct Light {
    /// What it does.
    pub shader: Arc<dyn LightShader>,
    /// The space its points and directions are given in, to world.
    pub to_world: Transform,
}

/// One surface or a sheet of them, with its attributes.
#[derive(Debug, Clone)]
pub struct Primitive {
    /// The shape, shared by all instances of it.
    pub geometry: Geometry,
    /// Object to world space.
    pub to_world: Transform,
    /// How it looks, shared by all that look alike.
    pub attributes: Arc<Attributes>,
    /// Where it stands in its file.
    pub origin: Origin,
}

impl Primitive {
    /// What messages call it: its name and place, or its index.
    pub fn object_name(&self, ix: usize) -> String {
        let (name, origin) = (&self.attributes.name, &self.origin);
        match (name.is_empty(), origin.is_empty()) {
            (false, false) => format!("{name} ({origin})"),
            (false, true) => name.clone(),
            (true, false) => origin.to_string(),
            (true, true) => format!("primitive {ix}"),
        }
    }
}

/// A place in a file, for messages ("teapot.rib:12"), or none.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Origin {
    /// Name of the file; empty for none.
    pub file: Arc<str>,
    /// Its line.
    pub line: u32,
}

impl Origin {
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.file.is_empty()
    }
}

impl std::fmt::Display for Origin {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.is_empty() { Ok(()) } else { write!(f, "{}:{}", self.file, self.line) }
    }
}

/// Sides that are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sides {
    /// Only the side that the surface normal points to.
    One,
    /// Both.
    #[default]
    Two,
}

/// How colour varies over a micropolygon.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ShadingInterpolation {
    /// One colour a micropolygon, that of its first vertex.
    #[default]
    Constant,
    /// Linear between the vertices of the triangle that is hit.
    Smooth,
}

/// Attributes of a primitive.
#[derive(Debug, Clone)]
pub struct Attributes {
    /// Name for messages (`Attribute "identifier" "name"`), or empty.
    pub name: String,
    /// Colour, linear.
    pub color: [f32; 3],
    /// Opacity, 0 to 1 a channel.
    pub opacity: [f32; 3],
    /// Surface shader.
    pub surface: Arc<dyn SurfaceShader>,
    /// Displacement or bump shader.
    pub displacement: Option<Arc<dyn DisplacementShader>>,
    /// How far displacement may move a point, in object space, as the file says
    /// (`Attribute "displacementbound"`); where the shader knows its amplitude, the smaller of both counts.
    /// 0 leaves it to the shader.
    pub displacement_bound: f32,
    /// Indices into [`Scene::lights`] of the lights that are on.
    pub lights: Arc<[u32]>,
    /// Area of a micropolygon in pixels, above 0.
    pub shading_rate: f32,
    /// How much motion coarsens dicing, at least 0: the area of a micropolygon grows by the factor
    /// 1 + `motion_factor` * (pixels moved while the shutter is open) / 16
    /// (`GeometricApproximation "motionfactor"`).
    pub motion_factor: f32,
    /// The same for defocus, with the diameter of the circle of confusion in pixels.
    pub focus_factor: f32,
    /// Colour over a micropolygon.
    pub shading_interpolation: ShadingInterpolation,
    /// Sides drawn.
    pub sides: Sides,
    /// Turns the surface normal around. Without it the normal is dPdu x dPdv as computed in object space
    /// (numerically, whatever the handedness), carried to camera space as a normal.
    pub reverse_orientation: bool,
    /// Cuts a hole: hides what is behind and leaves colour and alpha 0.
    pub matte: bool,
    /// (s, t) at (u, v) = (0,0), (1,0), (0,1), (1,1).
    pub texture_coordinates: [[f32; 2]; 4],
}

impl Default for Attributes {
    fn default() -> Self {
        Attributes {
            name: String::new(),
            color: [1.0; 3],
            opacity: [1.0; 3],
            surface: crate::shading::default_surface(),
            displacement: None,
            displacement_bound: 0.0,
            lights: Arc::from([]),
            shading_rate: 1.0,
            motion_factor: 0.0,
            focus_factor: 0.0,
            shading_interpolation: ShadingInterpolation::default(),
            sides: Sides::default(),
            reverse_orientation: false,
            matte: false,
            texture_coordinates: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]],
        }
    }
}
