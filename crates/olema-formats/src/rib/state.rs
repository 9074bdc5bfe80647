//! The graphics state: options, attributes, and the blocks that save them.

use std::path::PathBuf;
use std::sync::Arc;

use glam::DMat4;
use olema::image::Filter;
use olema::sampling::Rasterizer;
use olema::scene::{Attributes, Lens, PatchBasis, Projection, Transform};
use olema::shading::{LightShader, SurfaceShader};

use super::args::Args;
use super::declare::Decl;
use super::displacement::{BoundState, DisplacementState};
use super::fault::Pos;
use super::values::Values;
use super::{Display, Quantize};

/// A place in a named file.
#[derive(Debug, Clone)]
pub struct Site {
    /// The file.
    pub file: Arc<str>,
    /// The place.
    pub pos: Pos,
}

/// A `Display` statement.
#[derive(Debug, Clone)]
pub struct DisplayState {
    /// Name, driver and mode; the quantization is that of the parameters, if `own` says so.
    pub display: Display,
    /// Whether the statement has a quantization of its own.
    pub own: bool,
    /// Its own amplitude of dither.
    pub dither: Option<f32>,
}

/// The options.
#[derive(Debug, Clone)]
pub struct OptionState {
    /// Width and height in pixels.
    pub format: [u32; 2],
    /// Width / height of a pixel.
    pub pixel_aspect: f64,
    /// `FrameAspectRatio`.
    pub frame_aspect: Option<f64>,
    /// `ScreenWindow`: left, right, bottom, top.
    pub screen_window: Option<[f64; 4]>,
    /// `CropWindow`: xmin, xmax, ymin, ymax.
    pub crop: Option<[f64; 4]>,
    /// `Projection`.
    pub projection: Projection,
    /// `Clipping`.
    pub clipping: [f64; 2],
    /// `Shutter`.
    pub shutter: [f32; 2],
    /// `Hider "hidden" "shutteropening"`.
    pub shutter_opening: [f32; 2],
    /// `DepthOfField`, and where it stands.
    pub lens: Option<(Lens, Site)>,
    /// `Hider "hidden" "aperture"`: blades, and the angle of the first corner in degrees.
    pub aperture: (u32, f32),
    /// `PixelSamples`.
    pub samples: [u32; 2],
    /// `PixelFilter`.
    pub filter: Filter,
    /// `Exposure`.
    pub exposure: [f32; 2],
    /// `Imager "background"`.
    pub background: Option<[f32; 3]>,
    /// `RelativeDetail`.
    pub relative_detail: f64,
    /// `Display`.
    pub displays: Vec<DisplayState>,
    /// `Quantize` by type.
    pub quantize: Vec<(String, Quantize)>,
    /// `Hider "hidden" "jitter"`.
    pub jitter: bool,
    /// `Hider "hidden" "rasterizer"`.
    pub rasterizer: Rasterizer,
    /// `Hider "hidden" "tile"`.
    pub pattern_tile: Option<u32>,
    /// `Hider "hidden" "permutations"`.
    pub permutations: Option<u32>,
    /// `Option "limits" "gridsize"`.
    pub grid_size: Option<u32>,
    /// `Option "limits" "bucketsize"`.
    pub bucket: Option<[u32; 2]>,
    /// `Option "limits" "eyesplits"`.
    pub eye_splits: Option<u32>,
    /// `Option "searchpath" "archive"`.
    pub search_path: Vec<PathBuf>,
    /// `Option "searchpath" "texture"`.
    pub texture_path: Vec<PathBuf>,
    /// Values for conditions.
    pub values: Values,
}

impl Default for OptionState {
    fn default() -> Self {
        let colour = Quantize { one: 255, min: 0, max: 255, dither: 0.5 };
        let depth = Quantize { one: 0, min: 0, max: 0, dither: 0.0 };
        OptionState {
            format: [640, 480],
            pixel_aspect: 1.0,
            frame_aspect: None,
            screen_window: None,
            crop: None,
            projection: Projection::Orthographic,
            clipping: [1e-10, f64::INFINITY],
            shutter: [0.0, 0.0],
            shutter_opening: [0.0, 1.0],
            lens: None,
            aperture: (0, 0.0),
            samples: [2, 2],
            filter: Filter::default(),
            exposure: [1.0, 1.0],
            background: None,
            relative_detail: 1.0,
            displays: Vec::new(),
            quantize: vec![("rgba".to_owned(), colour), ("z".to_owned(), depth)],
            jitter: true,
            rasterizer: Rasterizer::default(),
            pattern_tile: None,
            permutations: None,
            grid_size: None,
            bucket: None,
            eye_splits: None,
            search_path: Vec::new(),
            texture_path: Vec::new(),
            values: Values::default(),
        }
    }
}

/// The attributes.
#[derive(Debug, Clone)]
pub struct AttrState {
    /// What primitives carry; its lights are behind `lights`, its orientation behind `inside`.
    pub look: Attributes,
    /// Lights that are on.
    pub lights: Arc<Vec<u32>>,
    /// Whether `look.lights` is older than `lights`.
    pub lights_changed: bool,
    /// Whether the orientation differs from the handedness of the coordinate system. A transform that mirrors
    /// turns both around, so it leaves this alone.
    pub inside: bool,
    /// Basis in u and v.
    pub basis: [PatchBasis; 2],
    /// Area in pixels of the `Detail` box, times `RelativeDetail`.
    pub detail: f64,
    /// `DetailRange`.
    pub detail_range: [f64; 4],
    /// Spaces named by `ScopedCoordinateSystem`.
    pub spaces: Arc<Vec<Space>>,
    /// `Displacement`, in its own space.
    pub displacement: Option<DisplacementState>,
    /// `Attribute "displacementbound"`.
    pub displacement_bound: BoundState,
    /// Values for conditions.
    pub values: Values,
}

impl AttrState {
    /// The standard's initial attributes.
    pub fn new(surface: Arc<dyn SurfaceShader>) -> Self {
        let look = Attributes {
            name: String::new(),
            color: [1.0; 3],
            opacity: [1.0; 3],
            surface,
            displacement: None,
            displacement_bound: 0.0,
            lights: Arc::from([]),
            shading_rate: 1.0,
            motion_factor: 0.0,
            focus_factor: 0.0,
            shading_interpolation: olema::scene::ShadingInterpolation::Constant,
            sides: olema::scene::Sides::Two,
            reverse_orientation: false,
            matte: false,
            texture_coordinates: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]],
        };
        AttrState {
            look,
            lights: Arc::default(),
            lights_changed: false,
            inside: false,
            basis: [PatchBasis::BEZIER; 2],
            detail: f64::INFINITY,
            detail_range: [0.0, 0.0, f64::INFINITY, f64::INFINITY],
            spaces: Arc::default(),
            displacement: None,
            displacement_bound: BoundState::default(),
            values: Values::default(),
        }
    }

    /// Whether the current level of detail is drawn: of representations whose transitions meet, exactly one is.
    pub fn is_detail_drawn(&self) -> bool {
        let [min, lower, upper, max] = self.detail_range;
        let (from, to) = ((min + lower) / 2.0, (upper + max) / 2.0);
        self.detail >= from && (self.detail < to || to.is_infinite() || to >= 1e30)
    }
}

/// A named space: to world where it was named in a world, else to camera.
#[derive(Debug, Clone)]
pub struct Space {
    /// Its name.
    pub name: String,
    /// From it.
    pub matrix: DMat4,
    /// Whether the matrix leads to world.
    pub in_world: bool,
}

/// A light: as for [`Space`].
#[derive(Debug, Clone)]
pub struct LightState {
    /// The shader.
    pub shader: Arc<dyn LightShader>,
    /// From its space.
    pub matrix: Transform,
    /// Whether the matrix leads to world.
    pub in_world: bool,
}

/// What a light, an object or a resource is called.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Handle {
    /// By number.
    Number(i64),
    /// By name.
    Name(String),
}

impl Handle {
    /// Argument `ix` of a statement.
    pub fn of(args: &Args, ix: usize) -> Self {
        match args.text(ix) {
            Some(name) => Handle::Name(name.to_owned()),
            None => Handle::Number(args.num(ix) as i64),
        }
    }
}

impl std::fmt::Display for Handle {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Handle::Number(n) => write!(f, "{n}"),
            Handle::Name(n) => write!(f, "\"{n}\""),
        }
    }
}

/// Kinds of blocks that save state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockKind {
    /// FrameBegin.
    Frame,
    /// WorldBegin.
    World,
    /// AttributeBegin.
    Attribute,
    /// TransformBegin.
    Transform,
    /// SolidBegin.
    Solid,
    /// MotionBegin.
    Motion,
    /// ResourceBegin.
    Resource,
}

impl BlockKind {
    /// The statement that opens it.
    pub fn begin(self) -> &'static str {
        match self {
            BlockKind::Frame => "FrameBegin",
            BlockKind::World => "WorldBegin",
            BlockKind::Attribute => "AttributeBegin",
            BlockKind::Transform => "TransformBegin",
            BlockKind::Solid => "SolidBegin",
            BlockKind::Motion => "MotionBegin",
            BlockKind::Resource => "ResourceBegin",
        }
    }

    /// The statement that closes it.
    pub fn end(self) -> &'static str {
        match self {
            BlockKind::Frame => "FrameEnd",
            BlockKind::World => "WorldEnd",
            BlockKind::Attribute => "AttributeEnd",
            BlockKind::Transform => "TransformEnd",
            BlockKind::Solid => "SolidEnd",
            BlockKind::Motion => "MotionEnd",
            BlockKind::Resource => "ResourceEnd",
        }
    }
}

/// An open block.
#[derive(Debug)]
pub struct Block {
    /// Its kind.
    pub kind: BlockKind,
    /// Where it was opened.
    pub site: Site,
    /// Options to return to.
    pub options: Option<Arc<OptionState>>,
    /// Attributes to return to.
    pub attrs: Option<Arc<AttrState>>,
    /// Transformation to return to.
    pub ctm: Option<Transform>,
    /// Lights and named spaces to return to.
    pub names: Option<Names>,
}

/// Lights and named spaces.
#[derive(Debug, Clone, Default)]
pub struct Names {
    /// All lights of the frame.
    pub lights: Vec<LightState>,
    /// Lights by handle.
    pub handles: std::collections::HashMap<Handle, u32>,
    /// Named spaces.
    pub spaces: Vec<Space>,
}

/// Declared values a primitive of one kind has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Sizes {
    /// Patches or faces.
    pub uniform: usize,
    /// Parametric corners.
    pub varying: usize,
    /// Control points.
    pub vertex: usize,
    /// Corners of all faces.
    pub facevarying: usize,
}

impl Sizes {
    /// Of a surface with one patch and four corners.
    pub const QUADRIC: Sizes = Sizes { uniform: 1, varying: 4, vertex: 4, facevarying: 4 };

    /// Floats or strings that a parameter must have.
    pub fn count(&self, decl: &Decl) -> usize {
        use olema::scene::Class;
        let values = match decl.class {
            Class::Constant => 1,
            Class::Uniform => self.uniform,
            Class::Varying => self.varying,
            Class::Vertex => self.vertex,
            Class::FaceVarying => self.facevarying,
        };
        values.saturating_mul(decl.width())
    }
}
