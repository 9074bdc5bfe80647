//! A diagnostic as miette wants it: a sentence, a source of one line, a pointer.

use std::fmt;

use miette::{LabeledSpan, MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};
use olema_formats::{Diagnostic, Severity};
use serde_json::json;

/// Bytes of a long line that readers keep before the place they speak of.
const BEFORE: usize = 100;

/// A diagnostic whose text is safe to print.
#[derive(Debug)]
pub struct Message {
    severity: Severity,
    text: String,
    excerpt: Excerpt,
    span: Option<SourceSpan>,
}

/// One line of a file, or a part of it around a column.
#[derive(Debug)]
struct Excerpt {
    file: String,
    /// From 1; 0 is none.
    line: u32,
    /// From 1; 0 is none.
    column: u32,
    text: Option<String>,
}

impl Message {
    /// Prepares a diagnostic for printing.
    pub fn new(diagnostic: &Diagnostic) -> Self {
        let Diagnostic { severity, file, line, column, message, source_line } = diagnostic;
        let text = source_line.as_deref().map(|s| printable(s.trim_end_matches(['\r', '\n'])));
        let span = text.as_deref().and_then(|text| pointer(text, *column));
        let excerpt = Excerpt { file: printable(file), line: *line, column: *column, text };
        Message { severity: *severity, text: printable(message), excerpt, span }
    }

    /// Whether there is a source line to point into.
    pub fn has_place(&self) -> bool {
        self.span.is_some() && self.excerpt.line > 0
    }

    /// As one JSON object.
    pub fn json(&self) -> serde_json::Value {
        json!({
            "event": "message",
            "severity": self.word(),
            "file": self.excerpt.file,
            "line": self.excerpt.line,
            "column": self.excerpt.column,
            "message": self.text,
        })
    }

    fn word(&self) -> &'static str {
        match self.severity {
            Severity::Note => "note",
            Severity::Warning => "warning",
            Severity::Error => "error",
        }
    }
}

/// The pointer into the excerpt: from the column to the end of the word there.
///
/// The excerpt of a long line begins [`BEFORE`] bytes before the column. Where that is no place in it (what was
/// no UTF-8 may have changed the number of bytes), there is no pointer.
fn pointer(text: &str, column: u32) -> Option<SourceSpan> {
    if text.is_empty() {
        return None;
    }
    let start = (column as usize).checked_sub(1)?.min(BEFORE);
    let from = text.get(start..)?;
    let ends = |c: char| c.is_whitespace() || "[]".contains(c);
    let quoted = from.strip_prefix('"').and_then(|rest| rest.find('"')).map(|end| end + 2);
    let len = quoted.or_else(|| from.find(ends)).unwrap_or(from.len());
    Some((start, len.max(1).min(from.len())).into())
}

/// The same text, of the same number of bytes, without anything that would move the cursor, change colours or
/// reorder the line.
pub fn printable(text: &str) -> String {
    let unsafe_char = |c: char| {
        c.is_control() && c != '\t'
            || matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if unsafe_char(c) {
            out.extend(std::iter::repeat_n('?', c.len_utf8()));
        } else {
            out.push(c);
        }
    }
    out
}

impl fmt::Display for Message {
    /// `file:line:column: warning: text`, without what is not known. Before a source line, where the place
    /// stands anyway, `warning: text`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Excerpt { file, line, column, .. } = &self.excerpt;
        if !self.has_place() && !file.is_empty() {
            write!(f, "{file}:")?;
            if *line > 0 {
                write!(f, "{line}:{column}:")?;
            }
            write!(f, " ")?;
        }
        write!(f, "{}: {}", self.word(), self.text)
    }
}

impl std::error::Error for Message {}

impl miette::Diagnostic for Message {
    fn severity(&self) -> Option<miette::Severity> {
        Some(match self.severity {
            Severity::Note => miette::Severity::Advice,
            Severity::Warning => miette::Severity::Warning,
            Severity::Error => miette::Severity::Error,
        })
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        Some(&self.excerpt)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        Some(Box::new(self.span.map(LabeledSpan::underline).into_iter()))
    }
}

impl SourceCode for Excerpt {
    /// Always the whole line: there is no more of the file.
    fn read_span<'a>(
        &'a self,
        _span: &SourceSpan,
        _before: usize,
        _after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let text = self.text.as_deref().ok_or(MietteError::OutOfBounds)?;
        Ok(Box::new(MietteSpanContents::new_named(
            self.file.clone(),
            text.as_bytes(),
            (0, text.len()).into(),
            self.line.saturating_sub(1) as usize,
            self.column.saturating_sub(1) as usize,
            1,
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use miette::{GraphicalReportHandler, GraphicalTheme};

    fn diagnostic(column: u32, source_line: Option<&str>) -> Diagnostic {
        Diagnostic {
            severity: Severity::Warning,
            file: "a.rib".to_owned(),
            line: 12,
            column,
            message: "unknown shader \"foo\"".to_owned(),
            source_line: source_line.map(str::to_owned),
        }
    }

    fn rendered(diagnostic: &Diagnostic) -> String {
        let mut text = String::new();
        let handler = GraphicalReportHandler::new_themed(GraphicalTheme::none()).with_wrap_lines(false);
        handler.render_report(&mut text, &Message::new(diagnostic)).unwrap();
        text
    }

    #[test]
    fn the_pointer_stands_under_the_column() {
        let text = rendered(&diagnostic(9, Some("Surface \"foo\" \"Kd\" 1\n")));
        assert!(text.contains("warning: unknown shader"), "{text}");
        assert!(text.contains("a.rib:12:9"), "{text}");
        let lines: Vec<&str> = text.lines().collect();
        let at = lines.iter().position(|l| l.contains("Surface")).unwrap();
        let place = lines[at].find("\"foo\"").unwrap();
        let mark = lines[at + 1].find(['^', '-']).unwrap();
        assert_eq!(mark, place, "{text}");
        assert!(lines[at].contains("12 |"), "{text}");
    }

    #[test]
    fn the_excerpt_of_a_long_line_begins_a_hundred_bytes_before_the_place() {
        let line = format!("{}\"foo\" 1", "1 ".repeat(50));
        let text = rendered(&diagnostic(5001, Some(&line)));
        assert!(text.contains("a.rib:12:5001"), "{text}");
        let lines: Vec<&str> = text.lines().collect();
        let at = lines.iter().position(|l| l.contains("12 |")).unwrap();
        assert_eq!(lines[at + 1].find(['^', '-']), lines[at].find("\"foo\""), "{text}");
    }

    #[test]
    fn places_beyond_the_excerpt_are_told_without_a_pointer() {
        for (column, line) in
            [(9, None), (1, Some("")), (900, Some("Surface")), (0, Some("Surface")), (2, Some("é"))]
        {
            let message = Message::new(&diagnostic(column, line));
            assert!(!message.has_place());
            assert_eq!(message.to_string(), format!("a.rib:12:{column}: warning: unknown shader \"foo\""));
        }
    }

    #[test]
    fn a_pointer_at_the_end_of_the_line_is_drawn() {
        let text = rendered(&diagnostic(8, Some("Surface")));
        assert!(text.contains("a.rib:12:8") && text.contains("12 | Surface"), "{text}");
    }

    #[test]
    fn nothing_from_a_scene_steers_the_terminal() {
        let evil = "a\u{1b}[2J\u{9b}\r\u{202e}b";
        assert_eq!(printable(evil), "a?[2J?????b".replace("?????", "??????"));
        assert_eq!(printable(evil).len(), evil.len());
        assert_eq!(printable("a\tb é"), "a\tb é");
    }
}
