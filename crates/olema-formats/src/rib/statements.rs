//! The table of statements: what each takes and what becomes of it.
//!
//! The reader checks and reads every statement's arguments by this table, and `docs/rib.md` is printed from it
//! (a test compares them), so that neither can say what the other does not.

use Arg::{Basis, Floats, Handle, Int, Ints, MaybeNums, Num, Nums, Params, Tags, Text, Texts};

/// An argument.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arg {
    /// A whole number.
    Int(&'static str),
    /// A number.
    Num(&'static str),
    /// So many numbers, bare or in one array.
    Nums(&'static str, usize),
    /// The same, or "-", or nothing at all.
    MaybeNums(&'static str, usize),
    /// A string.
    Text(&'static str),
    /// A number or a string that names something.
    Handle(&'static str),
    /// An array of numbers.
    Floats(&'static str),
    /// An array of whole numbers.
    Ints(&'static str),
    /// An array of strings.
    Texts(&'static str),
    /// A basis by name or as sixteen numbers.
    Basis(&'static str),
    /// The arrays of a subdivision mesh's tags, all or none; the last, of strings, may be left out.
    Tags,
    /// Names and values to the statement's end.
    Params,
}

/// What becomes of a statement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Support {
    /// Drawn, or has its full effect on the picture.
    Drawn,
    /// Kept, with an effect on how other statements are read or on the picture.
    State,
    /// Read and checked; not drawn yet, which a note says once a frame.
    NotYet,
    /// Read and checked; has no effect, which a warning says.
    Warned,
    /// Refused: it would run foreign code.
    Refused,
}

impl Support {
    /// The word in the documentation.
    pub fn word(self) -> &'static str {
        match self {
            Support::Drawn => "drawn",
            Support::State => "kept as state",
            Support::NotYet => "noted, not drawn yet",
            Support::Warned => "warned",
            Support::Refused => "refused",
        }
    }
}

/// Where a statement may stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Anywhere.
    Any,
    /// Before WorldBegin.
    Options,
    /// Between WorldBegin and WorldEnd.
    World,
}

/// One line of the table.
#[derive(Debug)]
pub struct Statement {
    /// Name in a file.
    pub name: &'static str,
    /// The same as a value.
    pub id: Id,
    /// What becomes of it.
    pub support: Support,
    /// Where it may stand.
    pub place: Place,
    /// Its arguments.
    pub form: &'static [Arg],
    /// What else is to be known.
    pub remark: &'static str,
}

macro_rules! statements {
    ($($name:literal $id:ident $support:ident $place:ident [$($arg:expr),*] $remark:literal;)*) => {
        /// A statement's name as a value.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[allow(missing_docs)]
        pub enum Id { $($id),* }

        /// All statements, by name.
        pub static TABLE: &[Statement] = &[$(Statement {
            name: $name,
            id: Id::$id,
            support: Support::$support,
            place: Place::$place,
            form: &[$($arg),*],
            remark: $remark,
        }),*];
    };
}

statements! {
    "ArchiveBegin" ArchiveBegin Drawn Any [Text("name"), Params] "Statements up to ArchiveEnd are kept and read by ReadArchive.";
    "ArchiveEnd" ArchiveEnd Drawn Any [] "";
    "AreaLightSource" AreaLightSource NotYet Any [Text("shader"), Handle("handle"), Params] "Taken as a plain light of that shader.";
    "Atmosphere" Atmosphere NotYet Any [Text("shader"), Params] "";
    "Attribute" Attribute State Any [Text("name"), Params] "\"identifier\" \"name\" names primitives in messages; \"displacementbound\" sphere and coordinatesystem limit displacement; \"user\" values can be asked for by IfBegin; others have no effect.";
    "AttributeBegin" AttributeBegin Drawn Any [] "";
    "AttributeEnd" AttributeEnd Drawn Any [] "";
    "Basis" Basis Drawn Any [Basis("u basis"), Int("u step"), Basis("v basis"), Int("v step")] "bezier, b-spline, catmull-rom, hermite, power, or sixteen numbers.";
    "Blobby" Blobby NotYet World [Int("leaves"), Ints("code"), Floats("numbers"), Texts("strings"), Params] "";
    "Bound" Bound State Any [Nums("box", 6)] "Primitives bound themselves.";
    "Camera" Camera Warned Options [Text("name"), Params] "there is one camera.";
    "Clipping" Clipping Drawn Options [Num("near"), Num("far")] "";
    "ClippingPlane" ClippingPlane Warned Options [Nums("point and normal", 6)] "only Clipping clips.";
    "Color" Color Drawn Any [Nums("color", 3)] "";
    "ColorSamples" ColorSamples Warned Options [Floats("nRGB"), Floats("RGBn")] "colours have three samples.";
    "ConcatTransform" ConcatTransform Drawn Any [Nums("matrix", 16)] "";
    "Cone" Cone NotYet World [Nums("height radius thetamax", 3), Params] "";
    "ConnectShaderLayers" ConnectShaderLayers Warned Any [Text("type"), Text("layer"), Text("variable"), Text("layer"), Text("variable")] "shaders cannot be connected.";
    "CoordSysTransform" CoordSysTransform Drawn Any [Text("space")] "";
    "CoordinateSystem" CoordinateSystem State Any [Text("name")] "";
    "CropWindow" CropWindow Drawn Options [Nums("xmin xmax ymin ymax", 4)] "";
    "Curves" Curves NotYet World [Text("type"), Ints("vertices"), Text("wrap"), Params] "";
    "Cylinder" Cylinder NotYet World [Nums("radius zmin zmax thetamax", 4), Params] "";
    "Declare" Declare State Any [Text("name"), Text("declaration")] "";
    "Deformation" Deformation NotYet Any [Text("shader"), Params] "";
    "DepthOfField" DepthOfField Drawn Options [MaybeNums("fstop focallength focaldistance", 3)] "Nothing, \"-\" and an fstop of 1e30 or more are a pinhole. Perspective only.";
    "Detail" Detail Drawn Any [Nums("box", 6)] "";
    "DetailRange" DetailRange Drawn Any [Nums("minvisible lower upper maxvisible", 4)] "A representation is drawn from the middle of its lower transition to the middle of its upper one.";
    "Disk" Disk NotYet World [Nums("height radius thetamax", 3), Params] "";
    "Displacement" Displacement Drawn Any [Text("shader"), Params] "bumpy, cells, fractal, image, noise, vector, waves; one that is unknown, or whose image is missing, leaves the surface as it is, with a warning.";
    "Display" Display Drawn Options [Text("name"), Text("driver"), Text("mode"), Params] "A name that starts with \"+\" adds a display; \"quantize\" and \"dither\" are honoured, other parameters are the driver's.";
    "Else" Else Drawn Any [] "";
    "ElseIf" ElseIf Drawn Any [Text("condition"), Params] "";
    "ErrorHandler" ErrorHandler State Any [Text("name")] "Has no effect: messages say where and what, and reading goes on where it can.";
    "Exposure" Exposure Drawn Options [Num("gain"), Num("gamma")] "";
    "Exterior" Exterior NotYet Any [Text("shader"), Params] "";
    "Format" Format Drawn Options [Int("width"), Int("height"), Num("pixel aspect ratio")] "";
    "FrameAspectRatio" FrameAspectRatio Drawn Options [Num("ratio")] "";
    "FrameBegin" FrameBegin Drawn Options [Int("number")] "";
    "FrameEnd" FrameEnd Drawn Options [] "";
    "GeneralPolygon" GeneralPolygon NotYet World [Ints("vertices"), Params] "";
    "GeometricApproximation" GeometricApproximation State Any [Text("type"), Num("value")] "motionfactor and focusfactor, at least 0, make micropolygons larger where they are blurred: their area grows by 1 + factor * pixels / 16, with the pixels moved while the shutter is open, and with the diameter of the circle of confusion. Others have no effect, which a note says: dicing follows the shading rate.";
    "GeometricRepresentation" GeometricRepresentation State Any [Text("type")] "Has no effect.";
    "Geometry" Geometry NotYet World [Text("type"), Params] "";
    "Hider" Hider State Options [Text("type"), Params] "\"hidden\" only, with the parameters listed above; others have no effect, which a note says.";
    "HierarchicalSubdivisionMesh" HierarchicalSubdivisionMesh Drawn World [Text("scheme"), Ints("vertices"), Ints("indices"), Tags, Params] "As SubdivisionMesh; edits of vertices, edges and faces are warned about, and the mesh is drawn without them.";
    "Hyperboloid" Hyperboloid NotYet World [Nums("point1 point2 thetamax", 7), Params] "";
    "Identity" Identity Drawn Any [] "";
    "IfBegin" IfBegin Drawn Any [Text("condition"), Params] "";
    "IfEnd" IfEnd Drawn Any [] "";
    "Illuminate" Illuminate Drawn Any [Handle("light"), Int("on")] "";
    "Imager" Imager Drawn Any [Text("shader"), Params] "\"background\" only.";
    "Interior" Interior NotYet Any [Text("shader"), Params] "";
    "LightSource" LightSource Drawn Any [Text("shader"), Handle("handle"), Params] "";
    "MakeBrickMap" MakeBrickMap Warned Any [Texts("point clouds"), Text("texture"), Params] "Olema makes no textures, and writes no file that a scene names.";
    "MakeBump" MakeBump Warned Any [Text("picture"), Text("texture"), Text("swrap"), Text("twrap"), Text("filter"), Num("swidth"), Num("twidth"), Params] "Olema makes no textures, and writes no file that a scene names.";
    "MakeCubeFaceEnvironment" MakeCubeFaceEnvironment Warned Any [Text("px"), Text("nx"), Text("py"), Text("ny"), Text("pz"), Text("nz"), Text("texture"), Num("fov"), Text("filter"), Num("swidth"), Num("twidth"), Params] "Olema makes no textures, and writes no file that a scene names.";
    "MakeLatLongEnvironment" MakeLatLongEnvironment Warned Any [Text("picture"), Text("texture"), Text("filter"), Num("swidth"), Num("twidth"), Params] "Olema makes no textures, and writes no file that a scene names.";
    "MakeOcclusion" MakeOcclusion Warned Any [Texts("pictures"), Text("shadow"), Params] "Olema makes no textures, and writes no file that a scene names.";
    "MakeShadow" MakeShadow Warned Any [Text("picture"), Text("shadow"), Params] "Olema makes no textures, and writes no file that a scene names.";
    "MakeTexture" MakeTexture Warned Any [Text("picture"), Text("texture"), Text("swrap"), Text("twrap"), Text("filter"), Num("swidth"), Num("twidth"), Params] "Olema makes no textures, and writes no file that a scene names.";
    "Matte" Matte Drawn Any [Int("on")] "";
    "MotionBegin" MotionBegin Drawn Any [Floats("times")] "Transforms and the points of surfaces move; of any other statement the first counts.";
    "MotionEnd" MotionEnd Drawn Any [] "";
    "NuPatch" NuPatch NotYet World [Int("nu"), Int("u order"), Floats("u knots"), Num("umin"), Num("umax"), Int("nv"), Int("v order"), Floats("v knots"), Num("vmin"), Num("vmax"), Params] "";
    "ObjectBegin" ObjectBegin Drawn Any [Handle("handle"), Params] "";
    "ObjectEnd" ObjectEnd Drawn Any [] "";
    "ObjectInstance" ObjectInstance Drawn World [Handle("handle"), Params] "Instances share their geometry.";
    "Opacity" Opacity Drawn Any [Nums("opacity", 3)] "";
    "Option" Option State Any [Text("name"), Params] "\"limits\" gridsize, bucketsize and eyesplits, \"searchpath\" archive and texture, and \"user\" values are honoured.";
    "Orientation" Orientation Drawn Any [Text("orientation")] "";
    "Paraboloid" Paraboloid NotYet World [Nums("rmax zmin zmax thetamax", 4), Params] "";
    "Patch" Patch Drawn World [Text("type"), Params] "";
    "PatchMesh" PatchMesh Drawn World [Text("type"), Int("nu"), Text("u wrap"), Int("nv"), Text("v wrap"), Params] "";
    "Perspective" Perspective Drawn Any [Num("fov")] "As the projection's transform; a model that is projected so is drawn only where the matrix is affine.";
    "PixelFilter" PixelFilter Drawn Options [Text("filter"), Num("x width"), Num("y width")] "";
    "PixelSamples" PixelSamples Drawn Options [Num("x"), Num("y")] "";
    "PixelVariance" PixelVariance State Options [Num("variance")] "Has no effect: every pixel has the same number of samples.";
    "Points" Points NotYet World [Params] "";
    "PointsGeneralPolygons" PointsGeneralPolygons NotYet World [Ints("loops"), Ints("vertices"), Ints("indices"), Params] "";
    "PointsPolygons" PointsPolygons NotYet World [Ints("vertices"), Ints("indices"), Params] "";
    "Polygon" Polygon NotYet World [Params] "";
    "Procedural" Procedural Refused World [Text("type"), Texts("arguments"), Nums("box", 6)] "\"DelayedReadArchive\" is drawn (read at once); \"RunProgram\" and \"DynamicLoad\" would run foreign code.";
    "Projection" Projection Drawn Options [Text("type"), Params] "perspective with fov, orthographic.";
    "Quantize" Quantize Drawn Options [Text("type"), Int("one"), Int("min"), Int("max"), Num("dither")] "";
    "ReadArchive" ReadArchive Drawn Any [Text("name"), Params] "";
    "RelativeDetail" RelativeDetail Drawn Options [Num("factor")] "";
    "Resource" Resource Warned Any [Text("handle"), Text("type"), Params] "there are no resources.";
    "ResourceBegin" ResourceBegin State Any [] "";
    "ResourceEnd" ResourceEnd State Any [] "";
    "ReverseOrientation" ReverseOrientation Drawn Any [] "";
    "Rotate" Rotate Drawn Any [Nums("angle axis", 4)] "";
    "Scale" Scale Drawn Any [Nums("factors", 3)] "";
    "ScopedCoordinateSystem" ScopedCoordinateSystem State Any [Text("name")] "";
    "ScreenWindow" ScreenWindow Drawn Options [Nums("left right bottom top", 4)] "";
    "ShaderLayer" ShaderLayer Warned Any [Text("type"), Text("shader"), Text("layer"), Params] "shaders cannot be connected.";
    "ShadingInterpolation" ShadingInterpolation Drawn Any [Text("type")] "";
    "ShadingRate" ShadingRate Drawn Any [Num("pixels")] "";
    "Shutter" Shutter Drawn Options [Num("open"), Num("close")] "";
    "Sides" Sides Drawn Any [Int("sides")] "";
    "Skew" Skew Drawn Any [Nums("angle axis axis", 7)] "";
    "SolidBegin" SolidBegin NotYet World [Text("operation")] "Solids are drawn as they stand, not combined.";
    "SolidEnd" SolidEnd NotYet World [] "";
    "Sphere" Sphere NotYet World [Nums("radius zmin zmax thetamax", 4), Params] "";
    "SubdivisionMesh" SubdivisionMesh Drawn World [Text("scheme"), Ints("vertices"), Ints("indices"), Tags, Params] "catmull-clark, loop, bilinear; tags hole, crease, corner, interpolateboundary, facevaryinginterpolateboundary, facevaryingpropagatecorners, creasemethod; others are warned about. Without interpolateboundary border faces are not drawn (bilinear ones are).";
    "Surface" Surface Drawn Any [Text("shader"), Params] "A shader that is unknown is replaced by the default surface, with a warning.";
    "TextureCoordinates" TextureCoordinates Drawn Any [Nums("s t of four corners", 8)] "";
    "Torus" Torus NotYet World [Nums("major minor phimin phimax thetamax", 5), Params] "";
    "Transform" Transform Drawn Any [Nums("matrix", 16)] "";
    "TransformBegin" TransformBegin Drawn Any [] "";
    "TransformEnd" TransformEnd Drawn Any [] "";
    "Translate" Translate Drawn Any [Nums("offset", 3)] "";
    "TrimCurve" TrimCurve NotYet Any [Ints("curves"), Ints("orders"), Floats("knots"), Floats("min"), Floats("max"), Ints("points"), Floats("u"), Floats("v"), Floats("w")] "";
    "WorldBegin" WorldBegin Drawn Options [] "";
    "WorldEnd" WorldEnd Drawn World [] "";
    "version" Version State Any [Num("version")] "Has no effect.";
}

/// The statement of that name.
pub fn find(name: &str) -> Option<&'static Statement> {
    TABLE.binary_search_by(|s| s.name.cmp(name)).ok().map(|ix| &TABLE[ix])
}

/// The known name that is nearest to a misspelt one, if any is near.
pub fn nearest(name: &str) -> Option<&'static str> {
    let folded = TABLE.iter().find(|s| s.name.eq_ignore_ascii_case(name));
    if let Some(found) = folded {
        return Some(found.name);
    }
    if !(5..=40).contains(&name.len()) {
        return None;
    }
    let alike = TABLE.iter().filter(|s| s.name.len().abs_diff(name.len()) <= 2);
    let best = alike.map(|s| (distance(s.name.as_bytes(), name.as_bytes()), s.name)).min()?;
    (best.0 <= 2).then_some(best.1)
}

/// Edits between two words.
fn distance(a: &[u8], b: &[u8]) -> usize {
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

impl Arg {
    /// The argument as the documentation prints it.
    pub fn usage(self) -> String {
        match self {
            Int(name) | Num(name) => name.to_owned(),
            Nums(name, count) => format!("{name} ({count} numbers)"),
            MaybeNums(name, count) => format!("[{name} ({count} numbers)]"),
            Text(name) => format!("\"{name}\""),
            Handle(name) => format!("{name} (number or string)"),
            Floats(name) => format!("[{name}...]"),
            Ints(name) => format!("[{name}... (integers)]"),
            Texts(name) => format!("[\"{name}\"...]"),
            Basis(name) => format!("{name} (name or 16 numbers)"),
            Tags => "[tags] [counts] [integers] [floats] [strings] (all or none; strings may be left out)"
                .to_owned(),
            Params => "parameters".to_owned(),
        }
    }
}

/// The documentation's table.
pub fn table_as_markdown() -> String {
    let mut out = String::from("| Statement | Arguments | Support | Remarks |\n|---|---|---|---|\n");
    for s in TABLE {
        let form: Vec<String> = s.form.iter().map(|a| a.usage()).collect();
        let line = format!("| `{}` | {} | {} | {} |\n", s.name, form.join(", "), s.support.word(), s.remark);
        out.push_str(&line);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_sorted_and_parameters_come_last() {
        assert!(TABLE.windows(2).all(|w| w[0].name < w[1].name));
        for s in TABLE {
            let before_last = s.form.len().saturating_sub(1);
            assert!(!s.form[..before_last].contains(&Params), "{}", s.name);
        }
    }

    #[test]
    fn a_misspelt_name_finds_its_neighbour() {
        assert_eq!(nearest("Sphre"), Some("Sphere"));
        assert_eq!(nearest("worldbegin"), Some("WorldBegin"));
        assert_eq!(nearest("Nonsense"), None);
    }

    /// `OLEMA_BLESS=1 cargo test -p olema-formats` writes the page anew.
    #[test]
    fn the_documentation_holds_this_table() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/rib.md");
        let page = std::fs::read_to_string(path).expect("docs/rib.md");
        let (head, rest) = page.split_once("<!-- table -->\n").expect("start mark");
        let (table, tail) = rest.split_once("<!-- /table -->\n").expect("end mark");
        if std::env::var_os("OLEMA_BLESS").is_some() {
            let new = format!("{head}<!-- table -->\n{}<!-- /table -->\n{tail}", table_as_markdown());
            std::fs::write(path, new).expect("docs/rib.md can be written");
        } else {
            assert_eq!(table, table_as_markdown(), "docs/rib.md is old: OLEMA_BLESS=1 writes it anew");
        }
    }
}
