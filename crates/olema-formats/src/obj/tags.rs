//! Subdivision tags: `t NAME integers/floats/strings values...`, as OpenSubdiv's shapes write them.
//!
//! Vertices and faces in tags count from 0. Read are crease, corner, hole, interpolateboundary (0 none,
//! 1 edge and corner, 2 edge only), facevaryinginterpolateboundary (0 smooth, 1 to 3 ever more corners sharp,
//! 4 borders sharp, 5 linear), facevaryingpropagatecorners and creasemethod. smoothtriangles and hierarchical
//! edits are named and left out.

use olema::scene::{BoundaryRule, Crease, CreaseMethod, FaceVaryingRule};

use super::scan::{Line, Token};
use super::{Messages, Obj};
use crate::diagnostic::Severity;

/// The tags of a file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tags {
    /// `crease`.
    pub creases: Vec<Crease>,
    /// `corner`.
    pub corners: Vec<(i32, f32)>,
    /// `hole`.
    pub holes: Vec<i32>,
    /// `interpolateboundary`; edge only where the file says nothing.
    pub boundary: BoundaryRule,
    /// `facevaryinginterpolateboundary`; linear where the file says nothing.
    pub face_varying: FaceVaryingRule,
    /// `facevaryingpropagatecorners`.
    pub propagate_corners: bool,
    /// `creasemethod`.
    pub crease_method: CreaseMethod,
    /// Whether the file has any tag, be it one that says what holds anyway.
    pub any: bool,
}

/// The line that each crease, corner and hole comes from: what they name may come later in the file, so they are
/// checked when it is known how much there is.
#[derive(Debug, Default)]
pub(super) struct Places {
    creases: Vec<u32>,
    corners: Vec<u32>,
    holes: Vec<u32>,
}

/// Whether an index names none of `length` things.
fn missing(ix: i32, length: usize) -> bool {
    usize::try_from(ix).map_or(true, |ix| ix >= length)
}

impl Places {
    /// Notes that what is new among the tags comes from this line, which is kept if it may have to be shown.
    pub(super) fn note(&mut self, line: &Line<'_>, obj: &Obj, messages: &mut Messages<'_>) {
        let (tags, num_vertices) = (&obj.tags, obj.positions.len());
        let creases = tags.creases[self.creases.len()..].iter().flat_map(|crease| &crease.vertices);
        let corners = tags.corners[self.corners.len()..].iter().map(|(vertex, _)| vertex);
        let mut holes = tags.holes[self.holes.len()..].iter();
        if creases.chain(corners).any(|vertex| missing(*vertex, num_vertices))
            || holes.any(|face| missing(*face, obj.face_counts.len()))
        {
            messages.keep(line);
        }
        self.creases.resize(tags.creases.len(), line.number);
        self.corners.resize(tags.corners.len(), line.number);
        self.holes.resize(tags.holes.len(), line.number);
    }

    /// Takes out the tags that name vertices or faces which are not there, and says so.
    pub(super) fn check(&self, obj: &mut Obj, messages: &mut Messages<'_>) {
        let (num_vertices, num_faces) = (obj.positions.len(), obj.face_counts.len());
        let mut say = |line: Option<&u32>, message: String| {
            messages.warn_later(line.copied().unwrap_or(1), message);
        };
        let mut lines = self.creases.iter();
        obj.tags.creases.retain(|crease| {
            let line = lines.next();
            let bad = crease.vertices.iter().find(|v| missing(**v, num_vertices));
            bad.inspect(|v| say(line, format!("the crease names vertex {v} of {num_vertices}; left out")))
                .is_none()
        });
        let mut lines = self.corners.iter();
        obj.tags.corners.retain(|(vertex, _)| {
            let (line, bad) = (lines.next(), missing(*vertex, num_vertices));
            if bad {
                say(line, format!("the corner names vertex {vertex} of {num_vertices}; left out"));
            }
            !bad
        });
        let mut lines = self.holes.iter();
        obj.tags.holes.retain(|face| {
            let (line, bad) = (lines.next(), missing(*face, num_faces));
            if bad {
                say(line, format!("the hole names face {face} of {num_faces}; left out"));
            }
            !bad
        });
    }
}

impl Tags {
    /// The facevarying rule, corners propagated if the file says so.
    pub fn face_varying(&self) -> FaceVaryingRule {
        match self.face_varying {
            FaceVaryingRule::CornersPlus1 if self.propagate_corners => FaceVaryingRule::CornersPlus2,
            rule => rule,
        }
    }
}

/// The values of one tag.
struct Values<'a> {
    ints: Vec<i32>,
    floats: Vec<f32>,
    strings: Vec<Token<'a>>,
}

/// Reads the tag that a line holds into `tags`.
pub(super) fn read_tag(line: &Line<'_>, tags: &mut Tags, messages: &mut Messages<'_>) {
    let mut tokens = line.tokens().skip(1);
    let Some(name) = tokens.next() else {
        messages.say(Severity::Warning, line, 0, "expected a tag's name after `t`".to_string());
        return;
    };
    let mut say = |at: &Token<'_>, message: String| {
        messages.say(Severity::Warning, line, at.offset, message);
    };
    let values = match read_values(&name, &mut tokens) {
        Ok(values) => values,
        Err((at, message)) => {
            say(&at, message);
            return;
        }
    };
    tags.any = true;
    let integer = values.ints.first().copied();
    let mut unknown = |expected: &str| {
        say(&name, format!("tag {}: expected {expected}; tag left out", name.short()));
    };
    match name.text {
        b"crease" => {
            let fits = values.floats.len() == 1 || values.floats.len() + 1 == values.ints.len();
            match values.ints.len() >= 2 && fits {
                true => tags.creases.push(Crease { vertices: values.ints, sharpness: values.floats }),
                false => unknown("2 or more vertices and one sharpness, or one an edge"),
            }
        }
        b"corner" => match (values.ints.len(), values.floats.len()) {
            (n, m) if n > 0 && (m == 1 || m == n) => {
                let sharpness = |i: usize| values.floats[if m == 1 { 0 } else { i }];
                tags.corners.extend(values.ints.iter().enumerate().map(|(i, &v)| (v, sharpness(i))));
            }
            _ => unknown("vertices and one sharpness, or one each"),
        },
        b"hole" => tags.holes.extend(values.ints),
        b"interpolateboundary" => match integer.and_then(BoundaryRule::from_ri) {
            Some(rule) => tags.boundary = rule,
            None => unknown("0, 1 or 2"),
        },
        b"facevaryinginterpolateboundary" => match integer.and_then(face_varying_rule) {
            Some(rule) => tags.face_varying = rule,
            None => unknown("0 to 5"),
        },
        b"facevaryingpropagatecorners" => match integer {
            Some(i) => tags.propagate_corners = i != 0,
            None => unknown("0 or 1"),
        },
        b"creasemethod" => match values.strings.first().map(|s| s.text) {
            Some(b"chaikin") => tags.crease_method = CreaseMethod::Chaikin,
            Some(b"normal" | b"uniform") => tags.crease_method = CreaseMethod::Uniform,
            _ => unknown("\"normal\" or \"chaikin\""),
        },
        b"smoothtriangles" if values.strings.first().is_none_or(|s| s.text == b"normal") => {}
        b"smoothtriangles" | b"vertexedit" | b"edgeedit" | b"faceedit" => {
            say(&name, format!("tag {} is not supported; the surface is drawn without it", name.short()));
        }
        _ => say(&name, format!("unknown tag {}; left out", name.short())),
    }
}

/// The rule of OpenSubdiv's integer.
fn face_varying_rule(value: i32) -> Option<FaceVaryingRule> {
    use FaceVaryingRule as R;
    let rules = [R::Smooth, R::CornersOnly, R::CornersPlus1, R::CornersPlus2, R::Boundaries, R::Linear];
    usize::try_from(value).ok().and_then(|i| rules.get(i).copied())
}

/// The counts and values behind a tag's name; an error says where and what was expected.
fn read_values<'a>(
    name: &Token<'a>,
    tokens: &mut impl Iterator<Item = Token<'a>>,
) -> Result<Values<'a>, (Token<'a>, String)> {
    let missing = |what: &str| (*name, format!("tag {}: expected {what}", name.short()));
    let counts = tokens.next().ok_or_else(|| missing("counts as integers/floats/strings"))?;
    let parts: Vec<usize> =
        counts.text.split(|b| *b == b'/').filter_map(super::scan::parse::<usize>).collect();
    let &[num_ints, num_floats, num_strings] = parts.as_slice() else {
        return Err((counts, format!("`{}`: expected counts as integers/floats/strings", counts.short())));
    };
    // The counts are only believed as far as values follow.
    let mut values = Values { ints: Vec::new(), floats: Vec::new(), strings: Vec::new() };
    for _ in 0..num_ints {
        let token = tokens.next().ok_or_else(|| missing(&format!("{num_ints} integers")))?;
        let value = token.parse().ok_or_else(|| (token, format!("`{}` is no integer", token.short())))?;
        values.ints.push(value);
    }
    for _ in 0..num_floats {
        let token = tokens.next().ok_or_else(|| missing(&format!("{num_floats} numbers")))?;
        let value = token.parse().ok_or_else(|| (token, format!("`{}` is no number", token.short())))?;
        values.floats.push(value);
    }
    for _ in 0..num_strings {
        values.strings.push(tokens.next().ok_or_else(|| missing(&format!("{num_strings} strings")))?);
    }
    Ok(values)
}
