//! Tags of subdivision meshes: names, counts and values to creases, corners, holes and rules.
//!
//! In: the statement's arrays of tags, counts (integers and floats a tag, and strings where that array is there),
//! integers, floats and strings. A tag that is unknown or whose values do not fit is left out with a warning;
//! counts that do not add up leave nothing to read, and are an error.

use olema::scene::{BoundaryRule, Crease, CreaseMethod, FaceVaryingRule, SubdivisionMesh};

use super::super::args::Args;
use super::super::fault::Fault;
use super::undrawn::{expect_len, sum};

/// Where the tags' names stand among the arguments; counts, integers, floats and strings follow.
const TAGS: usize = 3;

/// The values of one tag.
struct Tag<'a> {
    name: &'a str,
    ints: &'a [i32],
    floats: &'a [f32],
    strings: &'a [&'a str],
}

/// Facevarying rules depend on two tags, which may come in any order.
#[derive(Default)]
struct FaceVarying {
    rule: Option<i32>,
    propagate: bool,
}

/// Puts the statement's tags into `mesh`.
///
/// # Errors
/// Counts that do not fit the arrays.
pub(super) fn apply(args: &Args, mesh: &mut SubdivisionMesh, said: &mut Vec<Fault>) -> Result<(), Fault> {
    let (counts, ints, floats) = (args.ints(TAGS + 1), args.ints(TAGS + 2), args.floats(TAGS + 3));
    let strings: Vec<&str> = args.texts(TAGS + 4).collect();
    let each = if args.is_none(TAGS + 4) { 2 } else { 3 };
    expect_len(args, TAGS + 1, counts.len(), each * args.texts(TAGS).len())?;
    sum(args, TAGS + 1, 0)?;
    let total = |which: usize| counts.iter().skip(which).step_by(each).map(|n| *n as usize).sum();
    expect_len(args, TAGS + 2, ints.len(), total(0))?;
    expect_len(args, TAGS + 3, floats.len(), total(1))?;
    if each == 3 {
        expect_len(args, TAGS + 4, strings.len(), total(2))?;
    }
    let (mut ints, mut floats, mut strings) = (ints, floats, strings.as_slice());
    let mut face_varying = FaceVarying::default();
    for (ix, (name, counts)) in args.texts(TAGS).zip(counts.chunks(each)).enumerate() {
        let tag = Tag {
            name,
            ints: take(&mut ints, counts[0]),
            floats: take(&mut floats, counts[1]),
            strings: take(&mut strings, counts.get(2).copied().unwrap_or(0)),
        };
        if let Err(problem) = tag.apply(mesh, &mut face_varying) {
            said.push(Fault::warning(args.pos(TAGS), format!("tag {} \"{name}\": {problem}", ix + 1)));
        }
    }
    let rule = face_varying.rule.and_then(|rule| FaceVaryingRule::from_ri(rule, face_varying.propagate));
    mesh.face_varying = rule.unwrap_or(mesh.face_varying);
    Ok(())
}

/// The first `count` values, which are there: the counts were added up.
fn take<'a, T>(values: &mut &'a [T], count: i32) -> &'a [T] {
    let count = usize::try_from(count).unwrap_or(0).min(values.len());
    let (first, rest) = values.split_at(count);
    *values = rest;
    first
}

impl Tag<'_> {
    /// Puts the tag into `mesh`; says what was expected, or that it has no effect, if it was left out.
    fn apply(&self, mesh: &mut SubdivisionMesh, face_varying: &mut FaceVarying) -> Result<(), String> {
        match self.name {
            "hole" => mesh.holes.extend(self.ints),
            "crease" => mesh.creases.push(self.crease()?),
            "corner" => self.corners(&mut mesh.corners)?,
            "interpolateboundary" => {
                let rule = if self.ints.is_empty() { Some(1) } else { self.integer() };
                let rule = rule.and_then(BoundaryRule::from_ri);
                mesh.boundary = rule.ok_or_else(|| self.expected("0, 1, 2 or no integer"))?;
            }
            "facevaryinginterpolateboundary" => {
                let rule = self.integer().filter(|i| (0..=3).contains(i));
                face_varying.rule = Some(rule.ok_or_else(|| self.expected("0, 1, 2 or 3"))?);
            }
            "facevaryingpropagatecorners" => {
                face_varying.propagate = self.integer().ok_or_else(|| self.expected("0 or 1"))? != 0;
            }
            "creasemethod" => {
                mesh.crease_method = match self.strings {
                    ["normal" | "uniform"] => CreaseMethod::Uniform,
                    ["chaikin"] => CreaseMethod::Chaikin,
                    _ => return Err(self.expected("the string \"normal\" or \"chaikin\"")),
                };
            }
            "smoothtriangles" if matches!(self.ints, [] | [0]) => {}
            "smoothtriangles" | "vertexedit" | "edgeedit" | "faceedit" => {
                return Err("has no effect: the surface is drawn without it".to_owned());
            }
            _ => return Err("is unknown; left out".to_owned()),
        }
        Ok(())
    }

    /// The one integer, if that is what the tag has.
    fn integer(&self) -> Option<i32> {
        match self.ints {
            [value] => Some(*value),
            _ => None,
        }
    }

    fn crease(&self) -> Result<Crease, String> {
        let fits = self.floats.len() == 1 || self.floats.len() + 1 == self.ints.len();
        if self.ints.len() < 2 || !fits {
            return Err(self.expected("2 or more vertices and one sharpness, or one an edge"));
        }
        Ok(Crease { vertices: self.ints.to_vec(), sharpness: self.floats.to_vec() })
    }

    fn corners(&self, corners: &mut Vec<(i32, f32)>) -> Result<(), String> {
        match (self.ints, self.floats) {
            ([], _) => return Err(self.expected("vertices and one sharpness, or one each")),
            (ints, [all]) => corners.extend(ints.iter().map(|v| (*v, *all))),
            (ints, each) if ints.len() == each.len() => {
                corners.extend(ints.iter().copied().zip(each.iter().copied()));
            }
            _ => return Err(self.expected("vertices and one sharpness, or one each")),
        }
        Ok(())
    }

    fn expected(&self, what: &str) -> String {
        let found = match (self.ints, self.floats, self.strings) {
            ([value], [], []) => value.to_string(),
            ([], [], [value]) => format!("\"{value}\""),
            (i, f, []) => format!("{} integers and {} floats", i.len(), f.len()),
            (i, f, s) => format!("{} integers, {} floats and {} strings", i.len(), f.len(), s.len()),
        };
        format!("expected {what}, found {found}; left out")
    }
}
