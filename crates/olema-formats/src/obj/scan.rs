//! Statements and words of an OBJ file.
//!
//! In: a stream. Out: one statement after the other, of which only the current one is held.

use std::io::{self, BufRead, Read};

/// Most bytes of a statement.
const MAX_STATEMENT: usize = 16 << 20;

/// A statement: one line, or several that `\` joins.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line<'a> {
    /// Its bytes, without the last line's end.
    pub(super) bytes: &'a [u8],
    /// Number of its first line, from 1.
    pub(super) number: u32,
}

/// A word and where it stands in its statement.
#[derive(Debug, Clone, Copy)]
pub(super) struct Token<'a> {
    pub(super) text: &'a [u8],
    pub(super) offset: usize,
}

impl Token<'_> {
    pub(super) fn parse<T: std::str::FromStr>(&self) -> Option<T> {
        parse(self.text)
    }

    /// The word for a message.
    pub(super) fn short(&self) -> String {
        String::from_utf8_lossy(self.text).chars().take(40).collect()
    }
}

pub(super) fn parse<T: std::str::FromStr>(text: &[u8]) -> Option<T> {
    std::str::from_utf8(text).ok()?.parse().ok()
}

impl<'a> Line<'a> {
    /// Its words; a comment ends it.
    pub(super) fn tokens(&self) -> impl Iterator<Item = Token<'a>> + use<'a> {
        let (bytes, end, mut at) = (self.bytes, self.bytes.len(), 0);
        std::iter::from_fn(move || {
            let is_space = |b: u8| b.is_ascii_whitespace() || b == b'\\';
            while at < end && is_space(bytes[at]) {
                at += 1;
            }
            if at >= end || bytes[at] == b'#' {
                at = end;
                return None;
            }
            let offset = at;
            while at < end && !is_space(bytes[at]) {
                at += 1;
            }
            Some(Token { text: &bytes[offset..at], offset })
        })
    }

    /// What follows a word.
    pub(super) fn rest_after(&self, token: &Token<'_>) -> &'a [u8] {
        &self.bytes[(token.offset + token.text.len()).min(self.bytes.len())..]
    }
}

/// Why no further statement can be read.
#[derive(Debug)]
pub(super) enum Stop {
    /// The system says no.
    Io(io::Error),
    /// The statement that begins at this line is longer than this many bytes.
    TooLong { number: u32, limit: usize },
}

/// All statements of a file.
pub(super) struct Lines<R> {
    input: R,
    text: Vec<u8>,
    /// Number of the next line.
    next: u32,
}

impl<R: BufRead> Lines<R> {
    pub(super) fn new(input: R) -> Self {
        Lines { input, text: Vec::new(), next: 1 }
    }

    /// The next statement; `None` at the end.
    pub(super) fn next(&mut self) -> Result<Option<Line<'_>>, Stop> {
        self.text.clear();
        let number = self.next;
        loop {
            // One byte more than is allowed tells that there are more.
            let room = (MAX_STATEMENT + 1).saturating_sub(self.text.len()) as u64;
            let read = self.input.by_ref().take(room).read_until(b'\n', &mut self.text).map_err(Stop::Io)?;
            if self.text.len() > MAX_STATEMENT {
                return Err(Stop::TooLong { number, limit: MAX_STATEMENT });
            }
            self.next = self.next.saturating_add(1);
            let is_last = self.text.pop_if(|byte| *byte == b'\n').is_none();
            if is_last && self.text.is_empty() {
                return Ok(None);
            }
            let joins = self.text.trim_ascii_end().last() == Some(&b'\\');
            if !joins || is_last || read == 0 {
                return Ok(Some(Line { bytes: &self.text, number }));
            }
            self.text.push(b'\n');
        }
    }
}
