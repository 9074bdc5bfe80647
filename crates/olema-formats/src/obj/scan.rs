//! Statements and words of an OBJ file, as places in its bytes.

/// A statement: one line, or several that `\` joins.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line<'a> {
    /// The whole file.
    pub(super) bytes: &'a [u8],
    pub(super) start: usize,
    pub(super) end: usize,
    /// Number of its first line, from 1.
    pub(super) number: u32,
}

/// A word and where it stands in the file.
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
        let (bytes, end, mut at) = (self.bytes, self.end, self.start);
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
        &self.bytes[(token.offset + token.text.len()).min(self.end)..self.end]
    }
}

/// All statements of a file.
pub(super) struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    number: u32,
}

impl<'a> Lines<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Lines { bytes, at: 0, number: 1 }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        if self.at >= self.bytes.len() {
            return None;
        }
        let (start, number) = (self.at, self.number);
        loop {
            let rest = &self.bytes[self.at..];
            let length = rest.iter().position(|b| *b == b'\n');
            let end = length.map_or(self.bytes.len(), |l| self.at + l);
            self.at = length.map_or(self.bytes.len(), |l| self.at + l + 1);
            self.number += 1;
            let joins = self.bytes[start..end].trim_ascii_end().last() == Some(&b'\\');
            if !joins || self.at >= self.bytes.len() {
                return Some(Line { bytes: self.bytes, start, end, number });
            }
        }
    }
}
