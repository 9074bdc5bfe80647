//! What is said about an OBJ file.

use std::collections::HashMap;

use super::scan::Line;
use crate::diagnostic::{Diagnostic, Severity};

/// Most messages kept, and most lines for messages at the end of the file.
const MOST: usize = 1000;

/// Diagnostics, with places in a statement turned into lines and columns.
pub(super) struct Messages<'a> {
    file: &'a str,
    list: Vec<Diagnostic>,
    more: usize,
    /// Lines that may have to be shown later, by number.
    lines: HashMap<u32, String>,
}

impl<'a> Messages<'a> {
    pub(super) fn new(file: &'a str) -> Self {
        Messages { file, list: Vec::new(), more: 0, lines: HashMap::new() }
    }

    /// Says something about the byte at `offset` of a statement.
    pub(super) fn say(&mut self, severity: Severity, line: &Line<'_>, offset: usize, message: String) {
        if self.list.len() >= MOST {
            self.more += 1;
            return;
        }
        // A statement may go on over several lines; the message names the one that `offset` is in.
        let before = &line.bytes[..offset.min(line.bytes.len())];
        let number = line.number + before.iter().filter(|b| **b == b'\n').count() as u32;
        let start = before.iter().rposition(|b| *b == b'\n').map_or(0, |newline| newline + 1);
        let column = (offset - start + 1) as u32;
        let source_line = Some(shown(line, start, offset));
        self.push(severity, number, column, message, source_line);
    }

    /// Keeps a line that may have to be shown at the end of the file.
    pub(super) fn keep(&mut self, line: &Line<'_>) {
        if self.lines.len() < MOST {
            self.lines.insert(line.number, shown(line, 0, 0));
        }
    }

    /// Warns about a line that was read before.
    pub(super) fn warn_later(&mut self, number: u32, message: String) {
        if self.list.len() >= MOST {
            self.more += 1;
            return;
        }
        let source_line = self.lines.get(&number).cloned();
        self.push(Severity::Warning, number, 1, message, source_line);
    }

    pub(super) fn finish(mut self) -> Vec<Diagnostic> {
        if self.more > 0 {
            let message = format!("{} more messages about this file", self.more);
            self.push(Severity::Warning, 0, 0, message, None);
        }
        self.list
    }

    fn push(
        &mut self,
        severity: Severity,
        line: u32,
        column: u32,
        message: String,
        source_line: Option<String>,
    ) {
        let file = self.file.to_string();
        self.list.push(Diagnostic { severity, file, line, column, message, source_line });
    }
}

/// The part to show of the line that begins at `start`, around `offset`.
fn shown(line: &Line<'_>, start: usize, offset: usize) -> String {
    let rest = &line.bytes[start..];
    let end = rest.iter().position(|b| *b == b'\n').map_or(line.bytes.len(), |length| start + length);
    let from = start.max(offset.saturating_sub(100));
    String::from_utf8_lossy(&line.bytes[from..end.min(from + 200)]).trim_end().to_string()
}
