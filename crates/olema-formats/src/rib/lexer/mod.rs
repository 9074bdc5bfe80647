//! Tokens of an ASCII RIB stream.
//!
//! In: a byte stream. Out: words, numbers, strings and brackets, one at a time, with line and column. A window of
//! 64 KiB slides over the stream; a token never needs more than what is in it, except strings and comments,
//! which are copied or skipped piece by piece. Arrays of numbers go straight from the window into a vector: that
//! loop is where nearly all of a large file is read.

mod numbers;
mod text;

use std::io::Read;

use super::fault::{Fault, Pos};
use super::number::MAX_LEN;
use crate::room::{Full, Room};

/// Bytes of the window.
const WINDOW: usize = 64 << 10;
/// Bytes that stay in the window behind the current place, to show the source line.
const HISTORY: usize = 512;
/// Bytes that are in the window ahead of a token's start, unless the stream ends.
const AHEAD: usize = 2 * MAX_LEN;
/// Longest statement name.
const MAX_WORD: usize = 128;

/// The kind of the next token.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Token {
    /// A statement's name.
    Word,
    /// A number, or what looks like one.
    Number,
    /// A string.
    Text,
    /// `[`
    Open,
    /// `]`
    Close,
    /// The end of the stream.
    End,
    /// A byte that starts no token.
    Stray(u8),
}

impl Token {
    /// The token in words, for messages.
    pub fn describe(self) -> String {
        match self {
            Token::Word => "a statement name".to_owned(),
            Token::Number => "a number".to_owned(),
            Token::Text => "a string".to_owned(),
            Token::Open => "\"[\"".to_owned(),
            Token::Close => "\"]\"".to_owned(),
            Token::End => "the end of the file".to_owned(),
            Token::Stray(b) if b.is_ascii_graphic() => format!("\"{}\"", b as char),
            Token::Stray(b) => format!("byte 0x{b:02x}"),
        }
    }
}

/// The lexer.
pub struct Lexer {
    stream: Box<dyn Read>,
    window: Vec<u8>,
    pos: usize,
    end: usize,
    /// Bytes of the stream before the window.
    base: u64,
    line: u32,
    /// Offset of the current line's first byte.
    line_start: u64,
    eof: bool,
    error: Option<std::io::Error>,
    text: Vec<u8>,
}

impl Lexer {
    /// Starts at the beginning of `stream`, which is ASCII already.
    pub fn new(stream: Box<dyn Read>) -> Self {
        Lexer {
            stream,
            window: vec![0; WINDOW],
            pos: 0,
            end: 0,
            base: 0,
            line: 1,
            line_start: 0,
            eof: false,
            error: None,
            text: Vec::new(),
        }
    }

    /// The error that ended the stream early, once.
    pub fn take_error(&mut self) -> Option<std::io::Error> {
        self.error.take()
    }

    /// The current place.
    pub fn here(&self) -> Pos {
        let offset = self.base + self.pos as u64;
        let column = offset.saturating_sub(self.line_start).saturating_add(1);
        Pos { offset, line: self.line, column: u32::try_from(column).unwrap_or(u32::MAX) }
    }

    /// The line around `pos`, at most 200 bytes of it, if it is still in the window.
    pub fn source_line(&self, pos: Pos) -> Option<String> {
        let at = usize::try_from(pos.offset.checked_sub(self.base)?).ok()?;
        let window = self.window.get(..self.end)?;
        if at > window.len() {
            return None;
        }
        let line_start = at.checked_sub(pos.column as usize - 1);
        let start = line_start.unwrap_or(0).max(at.saturating_sub(100));
        let rest = &window[start..window.len().min(start + 200)];
        let len = rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
        Some(String::from_utf8_lossy(&rest[..len]).trim_end().to_owned())
    }

    /// Slides the window and reads until [`AHEAD`] bytes are there or the stream ends.
    #[cold]
    fn refill(&mut self) {
        let drop = self.pos.saturating_sub(HISTORY);
        self.window.copy_within(drop..self.end, 0);
        self.base += drop as u64;
        self.pos -= drop;
        self.end -= drop;
        while self.end - self.pos < AHEAD && !self.eof {
            match self.stream.read(&mut self.window[self.end..]) {
                Ok(0) => self.eof = true,
                Ok(len) => self.end += len,
                Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
                Err(e) => {
                    self.error = Some(e);
                    self.eof = true;
                }
            }
        }
    }

    #[inline(always)]
    fn look_ahead(&mut self) {
        if self.end - self.pos < AHEAD && !self.eof {
            self.refill();
        }
    }

    #[inline(always)]
    fn new_line(&mut self, after: usize) {
        self.line = self.line.saturating_add(1);
        self.line_start = self.base + after as u64;
    }

    /// Skips space and comments and says what comes next.
    #[inline]
    pub fn peek(&mut self) -> Token {
        loop {
            self.look_ahead();
            if self.pos >= self.end {
                return Token::End;
            }
            match self.window[self.pos] {
                b'\n' => {
                    self.pos += 1;
                    self.new_line(self.pos);
                }
                b' ' | b'\t' | b'\r' | 0x0b | 0x0c => self.pos += 1,
                b'#' => self.skip_comment(),
                b'[' => return Token::Open,
                b']' => return Token::Close,
                b'"' => return Token::Text,
                b'0'..=b'9' | b'-' | b'+' | b'.' => return Token::Number,
                b'a'..=b'z' | b'A'..=b'Z' | b'_' => return Token::Word,
                byte => return Token::Stray(byte),
            }
        }
    }

    /// What stands behind the opening bracket that [`Self::peek`] saw, as far as it is plain to see.
    pub fn first_in_array(&self) -> Token {
        let rest = self.window[..self.end].get(self.pos + 1..).unwrap_or(&[]);
        match rest.iter().find(|b| !b.is_ascii_whitespace()) {
            Some(b'"') => Token::Text,
            Some(b']') => Token::Close,
            _ => Token::Number,
        }
    }

    fn skip_comment(&mut self) {
        loop {
            let rest = &self.window[self.pos..self.end];
            if let Some(len) = rest.iter().position(|b| *b == b'\n') {
                self.pos += len;
                return;
            }
            self.pos = self.end;
            self.look_ahead();
            if self.pos >= self.end {
                return;
            }
        }
    }

    /// Whether the word that [`Self::peek`] saw is meant as a number.
    pub fn is_at_not_a_number(&self) -> bool {
        let rest = &self.window[self.pos..self.end.min(self.pos + 16)];
        let len = rest.iter().position(|b| !b.is_ascii_alphanumeric()).unwrap_or(rest.len());
        std::str::from_utf8(&rest[..len]).is_ok_and(not_a_number)
    }

    /// Takes a one-byte token.
    pub fn bump(&mut self) {
        self.pos = (self.pos + 1).min(self.end);
    }

    /// Takes the word that [`Self::peek`] saw.
    pub fn word(&mut self, into: &mut String) {
        into.clear();
        loop {
            self.look_ahead();
            let rest = &self.window[self.pos..self.end];
            let len =
                rest.iter().position(|b| !b.is_ascii_alphanumeric() && *b != b'_').unwrap_or(rest.len());
            let keep = len.min(MAX_WORD - into.len());
            into.extend(rest[..keep].iter().map(|b| *b as char));
            self.pos += len;
            if self.pos < self.end || self.eof {
                return;
            }
        }
    }

    /// Appends to a vector that is charged to `room`.
    #[inline]
    pub fn push<T>(&self, out: &mut Vec<T>, value: T, room: &mut Room) -> Result<(), Fault> {
        if out.len() == out.capacity() {
            room.grow(out).map_err(|e| self.no_room(e))?;
        }
        out.push(value);
        Ok(())
    }

    /// The memory limit is passed.
    pub fn no_room(&self, full: Full) -> Fault {
        let limit = full.limit;
        Fault::error(
            self.here(),
            format!("more than the {limit} bytes granted for a frame are needed: expected less data"),
        )
    }

    /// Something stands in an array that does not belong there.
    pub fn not_in_array(&mut self, found: Token, wanted: &str) -> Fault {
        let pos = self.here();
        Fault::error(pos, format!("expected {wanted} or \"]\" in this array, found {}", self.describe(found)))
    }

    /// The next token in words; words that are meant as numbers are shown.
    pub fn describe(&mut self, token: Token) -> String {
        if token != Token::Word {
            return token.describe();
        }
        let rest = &self.window[self.pos..self.end.min(self.pos + 32)];
        let len = rest.iter().position(|b| !b.is_ascii_alphanumeric()).unwrap_or(rest.len());
        let word = String::from_utf8_lossy(&rest[..len]).into_owned();
        if not_a_number(&word) { format!("\"{word}\" (not a finite number)") } else { format!("\"{word}\"") }
    }
}

/// Whether a word is how some program wrote a number that is none.
pub fn not_a_number(word: &str) -> bool {
    ["nan", "inf", "infinity", "qnan", "snan", "ind"].iter().any(|w| word.eq_ignore_ascii_case(w))
}
