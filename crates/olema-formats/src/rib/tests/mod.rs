//! Tests of the whole reader, by groups of statements.

mod archives;
mod bad_input;
mod blocks;
mod displacement;
mod meshes;
mod motion;
mod options;
mod soup;
mod surfaces;
mod undrawn;

use std::io::Cursor;

use glam::{DMat4, DVec3};

use super::{ReadError, ReadOptions, RibFrame, RibReader};
use crate::diagnostic::{Diagnostic, Severity};

/// What came out of a text.
struct Read {
    frames: Vec<RibFrame>,
    diagnostics: Vec<Diagnostic>,
    error: Option<ReadError>,
}

fn read_with(bytes: &[u8], options: ReadOptions) -> Read {
    let mut reader = RibReader::from_stream("test.rib", Box::new(Cursor::new(bytes.to_vec())), options);
    read_all(&mut reader)
}

fn read_all(reader: &mut RibReader) -> Read {
    let mut frames = Vec::new();
    let error = loop {
        match reader.next_frame() {
            Ok(Some(frame)) => frames.push(frame),
            Ok(None) => break None,
            Err(e) => break Some(e),
        }
    };
    Read { frames, diagnostics: reader.take_diagnostics(), error }
}

fn read(text: &str) -> Read {
    read_with(text.as_bytes(), ReadOptions::default())
}

/// The one frame of a text about which there is nothing to say.
fn frame(text: &str) -> RibFrame {
    let mut read = read(text);
    assert!(read.error.is_none(), "{:?}", read.error);
    assert_eq!(read.diagnostics, [], "{text}");
    assert_eq!(read.frames.len(), 1);
    read.frames.remove(0)
}

/// The frame of a world with `text` in it.
fn world(text: &str) -> RibFrame {
    frame(&format!("WorldBegin\n{text}\nWorldEnd"))
}

impl Read {
    /// Severity, line, column and message of what was said.
    fn said(&self) -> Vec<(Severity, u32, u32, &str)> {
        self.diagnostics.iter().map(|d| (d.severity, d.line, d.column, d.message.as_str())).collect()
    }

    /// Asserts that there is one message, and what it is.
    #[track_caller]
    fn says(&self, severity: Severity, line: u32, column: u32, part: &str) {
        let said = self.said();
        assert_eq!(said.len(), 1, "{said:#?}");
        assert_eq!((said[0].0, said[0].1, said[0].2), (severity, line, column), "{said:#?}");
        assert!(said[0].3.contains(part), "{said:#?}");
    }
}

/// A patch at the origin.
const PATCH: &str = "Patch \"bilinear\" \"P\" [0 0 0 1 0 0 0 1 0 1 1 0]";

fn to_world(frame: &RibFrame, ix: usize) -> DMat4 {
    frame.scene.primitives[ix].to_world.first()
}

fn near(a: DVec3, b: DVec3) -> bool {
    (a - b).length() < 1e-12
}
