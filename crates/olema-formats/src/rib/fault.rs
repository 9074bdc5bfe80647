//! Places in a file and what is said about them, before the file's name is known.

use crate::diagnostic::Severity;

/// A place in a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Pos {
    /// Bytes before it.
    pub offset: u64,
    /// Line, from 1.
    pub line: u32,
    /// Column in bytes, from 1.
    pub column: u32,
}

/// Something to say about a place.
#[derive(Debug, Clone)]
pub struct Fault {
    /// How bad it is.
    pub severity: Severity,
    /// Where.
    pub pos: Pos,
    /// What was found and what was expected.
    pub message: String,
    /// Whether nothing further can be read.
    pub fatal: bool,
}

impl Fault {
    /// A statement that is given up.
    pub fn error(pos: Pos, message: impl Into<String>) -> Self {
        Fault { severity: Severity::Error, pos, message: message.into(), fatal: false }
    }

    /// Something odd that is read as far as it makes sense.
    pub fn warning(pos: Pos, message: impl Into<String>) -> Self {
        Fault { severity: Severity::Warning, pos, message: message.into(), fatal: false }
    }

    /// Something correct that is not drawn.
    pub fn note(pos: Pos, message: impl Into<String>) -> Self {
        Fault { severity: Severity::Note, pos, message: message.into(), fatal: false }
    }

    /// The end of reading.
    pub fn fatal(pos: Pos, message: impl Into<String>) -> Self {
        Fault { severity: Severity::Error, pos, message: message.into(), fatal: true }
    }
}
