//! The OBJ reader, with the subdivision tags that OpenSubdiv's shapes use.
//!
//! In: bytes. Out: an [`Obj`] and diagnostics; never an error, since whatever lines make sense are kept.
//! Positions, texture coordinates, normals, faces of any size, negative indices, groups, materials' names and
//! `t` tags are read ([`Tags`]); curves and free-form surfaces are not.

mod parts;
mod scan;
mod tags;
#[cfg(test)]
mod tests;

use olema::scene::{Scheme, SubdivisionMesh};

use crate::diagnostic::{Diagnostic, Severity};
pub use parts::Part;
use scan::{Line, Lines};
use tags::Places;
pub use tags::Tags;

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

/// Reads an OBJ file; `name` is what diagnostics call it.
pub fn read(name: &str, bytes: &[u8]) -> (Obj, Vec<Diagnostic>) {
    let mut reader = Reader {
        obj: Obj::default(),
        messages: Messages { file: name, bytes, list: Vec::new(), more: 0 },
        faces_at: Vec::new(),
        tags_at: Places::default(),
        said_unknown: false,
    };
    for line in Lines::new(bytes) {
        reader.statement(line);
    }
    reader.check_indices();
    reader.tags_at.check(&mut reader.obj, &mut reader.messages);
    reader.messages.finish(reader.obj)
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

/// Diagnostics, with places in the bytes turned into lines and columns.
struct Messages<'a> {
    file: &'a str,
    bytes: &'a [u8],
    list: Vec<Diagnostic>,
    more: usize,
}

impl Messages<'_> {
    /// Messages kept.
    const MOST: usize = 1000;

    /// Says something about the byte at `offset` of a line that begins at `line_start` as number `line`.
    fn say(&mut self, severity: Severity, line: &Line<'_>, offset: usize, message: String) {
        if self.list.len() >= Self::MOST {
            self.more += 1;
            return;
        }
        // A statement may go on over several lines; the message names the one that `offset` is in.
        let before = &self.bytes[line.start..offset.min(self.bytes.len())];
        let number = line.number + before.iter().filter(|b| **b == b'\n').count() as u32;
        let start = before.iter().rposition(|b| *b == b'\n').map_or(line.start, |i| line.start + i + 1);
        let end =
            self.bytes[start..].iter().position(|b| *b == b'\n').map_or(self.bytes.len(), |i| start + i);
        let from = start.max(offset.saturating_sub(100));
        let source = &self.bytes[from..end.min(from + 200)];
        self.list.push(Diagnostic {
            severity,
            file: self.file.to_string(),
            line: number,
            column: (offset - start + 1) as u32,
            message,
            source_line: Some(String::from_utf8_lossy(source).trim_end().to_string()),
        });
    }

    fn finish(mut self, obj: Obj) -> (Obj, Vec<Diagnostic>) {
        if self.more > 0 {
            self.list.push(Diagnostic {
                severity: Severity::Warning,
                file: self.file.to_string(),
                line: 0,
                column: 0,
                message: format!("{} more messages about this file", self.more),
                source_line: None,
            });
        }
        (obj, self.list)
    }
}

struct Reader<'a> {
    obj: Obj,
    messages: Messages<'a>,
    /// Where each face stands, for indices that are checked at the end.
    faces_at: Vec<(u32, usize)>,
    tags_at: Places,
    said_unknown: bool,
}

impl Reader<'_> {
    fn statement(&mut self, line: Line<'_>) {
        let mut tokens = line.tokens();
        let Some(keyword) = tokens.next() else {
            return;
        };
        match keyword.text {
            b"v" => {
                let p = self.numbers(&line, 3);
                self.obj.positions.push([p[0], p[1], p[2]]);
            }
            b"vt" => {
                let t = self.numbers(&line, 1);
                self.obj.texcoords.push([t[0], t[1]]);
            }
            b"vn" => {
                let n = self.numbers(&line, 3);
                self.obj.normals.push([n[0], n[1], n[2]]);
            }
            b"f" | b"fo" => self.face(&line),
            b"g" | b"o" => {
                let name = String::from_utf8_lossy(line.rest_after(&keyword)).trim().to_string();
                self.begin_group(line.number, Some(name), None);
            }
            b"usemtl" => {
                let name = String::from_utf8_lossy(line.rest_after(&keyword)).trim().to_string();
                self.begin_group(line.number, None, Some(name));
            }
            b"t" => {
                tags::read_tag(&line, &mut self.obj.tags, &mut self.messages);
                self.tags_at.note(&line, &self.obj.tags);
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
    }

    /// Up to 3 numbers of a statement, 0 where missing; says so where fewer than `least` are there.
    fn numbers(&mut self, line: &Line<'_>, least: usize) -> [f32; 3] {
        let mut values = [0.0; 3];
        let mut count = 0;
        let mut end = line.start;
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

    fn face(&mut self, line: &Line<'_>) {
        let mut count = 0;
        for token in line.tokens().skip(1) {
            let mut parts = token.text.split(|b| *b == b'/');
            let lengths = [self.obj.positions.len(), self.obj.texcoords.len(), self.obj.normals.len()];
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
            self.obj.corners.push(Corner { position: corner[0], texcoord: corner[1], normal: corner[2] });
            count += 1;
        }
        if self.obj.groups.is_empty() {
            self.begin_group(line.number, None, None);
        }
        self.obj.face_counts.push(count);
        self.faces_at.push((line.number, line.start));
    }

    fn begin_group(&mut self, line: u32, name: Option<String>, material: Option<String>) {
        let first_face = self.obj.face_counts.len() as u32;
        let before = self.obj.groups.last();
        let name = name.or_else(|| before.map(|g| g.name.clone())).unwrap_or_default();
        let material = material.or_else(|| before.map(|g| g.material.clone())).unwrap_or_default();
        // A group without faces gives way to the next.
        if before.is_some_and(|g| g.first_face == first_face) {
            self.obj.groups.pop();
        }
        self.obj.groups.push(Group { name, material, first_face, line });
    }

    /// Indices may name what comes later in the file, so they are checked when it is known how much there is.
    fn check_indices(&mut self) {
        let lengths = [self.obj.positions.len(), self.obj.texcoords.len(), self.obj.normals.len()];
        let mut corners = self.obj.corners.iter_mut();
        for (&count, &(number, start)) in self.obj.face_counts.iter().zip(&self.faces_at) {
            for corner in corners.by_ref().take(count as usize) {
                let parts = [&mut corner.position, &mut corner.texcoord, &mut corner.normal];
                for ((ix, length), what) in parts.into_iter().zip(lengths).zip(["v", "vt", "vn"]) {
                    if *ix >= 0 && *ix as usize >= length {
                        let left_out = if what == "v" { "; face left out" } else { "" };
                        let named = i64::from(*ix) + 1;
                        let message = format!("the face names {what} {named} of {length}{left_out}");
                        let line = Line { bytes: self.messages.bytes, start, end: start, number };
                        self.messages.say(Severity::Warning, &line, start, message);
                        *ix = -1;
                    }
                }
            }
        }
    }
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
