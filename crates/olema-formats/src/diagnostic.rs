//! What a reader has to say about its input.

use std::fmt;

/// How bad it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Correct, but something that Olema does not draw yet was kept or left out.
    Note,
    /// Wrong or unusual; read as far as it makes sense.
    Warning,
    /// Wrong; the statement (or the file) was given up.
    Error,
}

/// A message about one place of an input.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// File as the user named it, or "-" for standard input.
    pub file: String,
    /// Line, from 1; 0 where the message is about the whole file.
    pub line: u32,
    /// Column in bytes, from 1; 0 as for `line`.
    pub column: u32,
    /// What was found and what was expected.
    pub message: String,
    /// The source line, at most 200 bytes around the column, where it is still known.
    pub source_line: Option<String>,
}

/// The input could not be read any further. Everything that was said on the way is among the diagnostics.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file cannot be opened or read.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: String,
        /// The system's word.
        source: std::io::Error,
    },
    /// The file is wrong in a way that leaves nothing to recover.
    #[error("{0}")]
    Fatal(Diagnostic),
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = match self.severity {
            Severity::Note => "note",
            Severity::Warning => "warning",
            Severity::Error => "error",
        };
        write!(f, "{}:{}:{}: {word}: {}", self.file, self.line, self.column, self.message)
    }
}
