//! The OBJ reader, with the subdivision tags that OpenSubdiv's shapes use.
//!
//! In: a stream, of which a statement is held at a time. Out: an [`Obj`] and diagnostics; whatever lines make sense
//! are kept, and the only errors are those of the system, of memory, and of lines without end.
//! Positions, texture coordinates, normals, faces of any size, negative indices, groups, materials' names and
//! `t` tags are read ([`Tags`]); curves and free-form surfaces are not.

mod messages;
mod parts;
mod scan;
mod tags;
#[cfg(test)]
mod tests;

use std::io::BufRead;

use olema::scene::{Scheme, SubdivisionMesh};

use crate::diagnostic::{Diagnostic, ReadError, Severity};
use crate::room::{Full, Room};
use messages::Messages;
pub use parts::Part;
use scan::{Line, Lines, Stop};
use tags::Places;
pub use tags::Tags;

/// Most bytes that are kept of a file, where the caller grants no other number.
pub const MEMORY: u64 = 8 << 30;

/// What an OBJ file holds.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Obj {
    /// `v`.
    pub positions: Vec<[f32; 3]>,
    /// `vt`, the first two numbers.
    pub texcoords: Vec<[f32; 2]>,
    /// `vn`.
    pub normals: Vec<[f32; 3]>,
    /// Corners of each face.
    pub face_counts: Vec<i32>,
    /// Corners, face after face.
    pub corners: Vec<Corner>,
    /// Runs of faces with one name and material, in order. The first begins at face 0.
    pub groups: Vec<Group>,
    /// Subdivision tags.
    pub tags: Tags,
}

/// A corner of a face: indices from 0, -1 where there is none or it was wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Corner {
    /// Into [`Obj::positions`].
    pub position: i32,
    /// Into [`Obj::texcoords`].
    pub texcoord: i32,
    /// Into [`Obj::normals`].
    pub normal: i32,
}

/// Faces that follow each other under one `g` or `o` and `usemtl`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Group {
    /// Names after `g` or `o`, or empty.
    pub name: String,
    /// Name after `usemtl`, or empty.
    pub material: String,
    /// First face; the group ends where the next begins.
    pub first_face: u32,
    /// Line of the statement that began it, from 1.
    pub line: u32,
}

/// The scheme that a file's name tells by its beginning: `catmark_`, `loop_` or `bilinear_`.
pub fn scheme_of_name(path: &str) -> Option<Scheme> {
    let name = path.rsplit(['/', '\\']).next().unwrap_or(path);
    [("catmark", Scheme::CatmullClark), ("loop", Scheme::Loop), ("bilinear", Scheme::Bilinear)]
        .into_iter()
        .find(|(prefix, _)| name.strip_prefix(prefix).is_some_and(|rest| rest.starts_with(['_', '.'])))
        .map(|(_, scheme)| scheme)
}

/// Reads an OBJ file; `name` is what diagnostics call it, and `memory` the most bytes that are kept of it.
///
/// # Errors
/// [`ReadError`] where the file cannot be read, holds more than that, or has a line without end.
pub fn read(name: &str, input: impl BufRead, memory: u64) -> Result<(Obj, Vec<Diagnostic>), ReadError> {
    let mut reader = Reader {
        obj: Obj::default(),
        messages: Messages::new(name),
        room: Room::new(memory),
        early: Vec::new(),
        tags_at: Places::default(),
        said_unknown: false,
    };
    let mut lines = Lines::new(input);
    let fatal = |line: u32, message: String| {
        let (severity, file) = (Severity::Error, name.to_string());
        ReadError::Fatal(Diagnostic { severity, file, line, column: 1, message, source_line: None })
    };
    loop {
        let line = match lines.next() {
            Ok(Some(line)) => line,
            Ok(None) => break,
            Err(Stop::Io(source)) => return Err(ReadError::Io { path: name.to_string(), source }),
            Err(Stop::TooLong { number, limit }) => {
                let message =
                    format!("this line has more than {limit} bytes: expected an OBJ file's statements");
                return Err(fatal(number, message));
            }
        };
        reader.statement(line).map_err(|full| {
            let message =
                format!("the {} bytes granted for a model are used up here: expected less", full.limit);
            fatal(line.number, message)
        })?;
    }
    reader.check_indices();
    reader.tags_at.check(&mut reader.obj, &mut reader.messages);
    Ok((reader.obj, reader.messages.finish()))
}

impl Obj {
    /// The file's faces as one control mesh: texture coordinates become the facevarying "st" (if every corner
    /// has one), tags its creases, corners, holes and rules.
    pub fn subdivision_mesh(&self, scheme: Scheme) -> SubdivisionMesh {
        let indices = self.corners.iter().map(|c| c.position).collect();
        let mut mesh =
            SubdivisionMesh::new(scheme, self.face_counts.clone(), indices, self.positions.clone());
        mesh.creases = self.tags.creases.clone();
        mesh.corners = self.tags.corners.clone();
        mesh.holes = self.tags.holes.clone();
        let st: Option<Vec<[f32; 2]>> = self.corners.iter().map(|c| self.texcoord(c)).collect();
        mesh.vars.extend(st.and_then(|st| parts::st_var(st.into_flattened())));
        self.rules(mesh)
    }
}

struct Reader<'a> {
    obj: Obj,
    messages: Messages<'a>,
    room: Room,
    /// Faces that name what was not there when they were read: it may come later, and is looked for at the end.
    early: Vec<EarlyFace>,
    tags_at: Places,
    said_unknown: bool,
}

/// A face that came before what it names.
struct EarlyFace {
    first_corner: usize,
    num_corners: usize,
    /// Its line.
    number: u32,
}

/// Adds to a list that is charged.
fn push<T>(room: &mut Room, values: &mut Vec<T>, value: T) -> Result<(), Full> {
    if values.len() == values.capacity() {
        room.grow(values)?;
    }
    values.push(value);
    Ok(())
}

impl Reader<'_> {
    fn statement(&mut self, line: Line<'_>) -> Result<(), Full> {
        let mut tokens = line.tokens();
        let Some(keyword) = tokens.next() else {
            return Ok(());
        };
        match keyword.text {
            b"v" => {
                let position = self.numbers(&line, 3);
                push(&mut self.room, &mut self.obj.positions, position)?;
            }
            b"vt" => {
                let [s, t, _] = self.numbers(&line, 1);
                push(&mut self.room, &mut self.obj.texcoords, [s, t])?;
            }
            b"vn" => {
                let normal = self.numbers(&line, 3);
                push(&mut self.room, &mut self.obj.normals, normal)?;
            }
            b"f" | b"fo" => self.face(&line)?,
            b"g" | b"o" => {
                let name = String::from_utf8_lossy(line.rest_after(&keyword)).trim().to_string();
                self.begin_group(line.number, Some(name), None)?;
            }
            b"usemtl" => {
                let name = String::from_utf8_lossy(line.rest_after(&keyword)).trim().to_string();
                self.begin_group(line.number, None, Some(name))?;
            }
            b"t" => {
                // No value takes more room than its text does eight times over.
                self.room.hold(64 + 8 * line.bytes.len() as u64)?;
                tags::read_tag(&line, &mut self.obj.tags, &mut self.messages);
                self.tags_at.note(&line, &self.obj, &mut self.messages);
            }
            b"s" | b"mtllib" | b"mg" => {}
            _ if !self.said_unknown => {
                self.said_unknown = true;
                let text = String::from_utf8_lossy(keyword.text);
                let text = text.chars().take(40).collect::<String>();
                let message = format!("`{text}` is not read, nor are others of its kind");
                self.messages.say(Severity::Note, &line, keyword.offset, message);
            }
            _ => {}
        }
        Ok(())
    }

    /// Up to 3 numbers of a statement, 0 where missing; says so where fewer than `least` are there.
    fn numbers(&mut self, line: &Line<'_>, least: usize) -> [f32; 3] {
        let mut values = [0.0; 3];
        let mut count = 0;
        let mut end = 0;
        for (value, token) in values.iter_mut().zip(line.tokens().skip(1)) {
            match token.parse::<f32>() {
                Some(x) => *value = x,
                None => self.messages.say(
                    Severity::Warning,
                    line,
                    token.offset,
                    format!("`{}` is no number, taken as 0", token.short()),
                ),
            }
            count += 1;
            end = token.offset;
        }
        if count < least {
            let message = format!("expected {least} numbers, found {count}; the others taken as 0");
            self.messages.say(Severity::Warning, line, end, message);
        }
        values
    }

    fn face(&mut self, line: &Line<'_>) -> Result<(), Full> {
        let first_corner = self.obj.corners.len();
        let lengths = self.lengths();
        for token in line.tokens().skip(1) {
            let mut parts = token.text.split(|b| *b == b'/');
            let mut corner = [-1; 3];
            for (ix, length) in corner.iter_mut().zip(lengths) {
                let Some(part) = parts.next().filter(|p| !p.is_empty()) else {
                    continue;
                };
                match scan::parse::<i64>(part).and_then(|i| absolute(i, length)) {
                    Some(i) => *ix = i,
                    None => self.messages.say(
                        Severity::Warning,
                        line,
                        token.offset,
                        format!("`{}` is no index (from 1, or negative from the end)", token.short()),
                    ),
                }
            }
            let corner = Corner { position: corner[0], texcoord: corner[1], normal: corner[2] };
            push(&mut self.room, &mut self.obj.corners, corner)?;
        }
        if self.obj.groups.is_empty() {
            self.begin_group(line.number, None, None)?;
        }
        let corners = &self.obj.corners[first_corner..];
        let num_corners = corners.len();
        if corners.iter().any(|corner| missing(corner, lengths).any(|part| part.is_some())) {
            self.messages.keep(line);
            let early = EarlyFace { first_corner, num_corners, number: line.number };
            push(&mut self.room, &mut self.early, early)?;
        }
        push(&mut self.room, &mut self.obj.face_counts, num_corners as i32)
    }

    /// Positions, texture coordinates and normals so far.
    fn lengths(&self) -> [usize; 3] {
        [self.obj.positions.len(), self.obj.texcoords.len(), self.obj.normals.len()]
    }

    fn begin_group(&mut self, line: u32, name: Option<String>, material: Option<String>) -> Result<(), Full> {
        let first_face = self.obj.face_counts.len() as u32;
        let before = self.obj.groups.last();
        let name = name.or_else(|| before.map(|g| g.name.clone())).unwrap_or_default();
        let material = material.or_else(|| before.map(|g| g.material.clone())).unwrap_or_default();
        self.room.hold((name.len() + material.len()) as u64)?;
        // A group without faces gives way to the next.
        if before.is_some_and(|g| g.first_face == first_face) {
            self.obj.groups.pop();
        }
        push(&mut self.room, &mut self.obj.groups, Group { name, material, first_face, line })
    }

    /// What early faces name is there now, or is not.
    fn check_indices(&mut self) {
        let lengths = self.lengths();
        for EarlyFace { first_corner, num_corners, number } in std::mem::take(&mut self.early) {
            for corner in &mut self.obj.corners[first_corner..][..num_corners] {
                let parts = [("v", "; face left out"), ("vt", ""), ("vn", "")];
                let missing: Vec<_> = missing(corner, lengths).collect();
                let indices = [&mut corner.position, &mut corner.texcoord, &mut corner.normal];
                for (((ix, missing), (what, left_out)), length) in
                    indices.into_iter().zip(missing).zip(parts).zip(lengths)
                {
                    if let Some(named) = missing {
                        let message = format!("the face names {what} {named} of {length}{left_out}");
                        self.messages.warn_later(number, message);
                        *ix = -1;
                    }
                }
            }
        }
    }
}

/// Of position, texture coordinate and normal of a corner the number, from 1, if there is none of it.
fn missing(corner: &Corner, lengths: [usize; 3]) -> impl Iterator<Item = Option<i64>> {
    let indices = [corner.position, corner.texcoord, corner.normal];
    let is_missing = |(ix, length): (i32, usize)| {
        usize::try_from(ix).is_ok_and(|ix| ix >= length).then_some(i64::from(ix) + 1)
    };
    indices.into_iter().zip(lengths).map(is_missing)
}

/// An index from 0, from one that counts from 1 or back from the end.
fn absolute(index: i64, length: usize) -> Option<i32> {
    let ix = match index {
        0 => return None,
        i if i > 0 => i - 1,
        i => length as i64 + i,
    };
    i32::try_from(ix).ok().filter(|i| *i >= 0)
}
