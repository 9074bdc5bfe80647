//! Tokens of an ASCII RIB stream.
//!
//! In: a byte stream. Out: words, numbers, strings and brackets, one at a time, with line and column. A window of
//! 64 KiB slides over the stream; a token never needs more than what is in it, except strings and comments,
//! which are copied or skipped piece by piece. Arrays of numbers go straight from the window into a vector: that
//! loop is where nearly all of a large file is read.

use std::io::Read;

use super::fault::{Fault, Pos};
use super::number::{self, MAX_LEN};
use super::room::{Full, Room};

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

    fn bad_number(&mut self) -> Fault {
        let pos = self.here();
        let rest = &self.window[self.pos..self.end.min(self.pos + 40)];
        let ends = |b: &u8| b.is_ascii_whitespace() || b"[]\"".contains(b);
        let len = rest.iter().position(ends).unwrap_or(rest.len());
        let text = String::from_utf8_lossy(&rest[..len]).into_owned();
        self.pos += len.max(1);
        Fault::error(pos, format!("\"{text}\" is not a finite number"))
    }

    /// Takes a number as a double.
    pub fn number(&mut self) -> Result<f64, Fault> {
        self.look_ahead();
        let bytes = &self.window[self.pos..self.end];
        let found = number::scan(bytes).filter(|d| d.len <= MAX_LEN);
        match found.map(|d| (d.to_f64(bytes), d.len)) {
            Some((value, len)) if value.abs() <= f64::from(f32::MAX) => {
                self.pos += len;
                Ok(value)
            }
            _ => Err(self.bad_number()),
        }
    }

    /// Takes a number that must be whole.
    pub fn integer(&mut self) -> Result<i32, Fault> {
        self.look_ahead();
        let bytes = &self.window[self.pos..self.end];
        let Some(decimal) = number::scan(bytes).filter(|d| d.len <= MAX_LEN) else {
            return Err(self.bad_number());
        };
        let Some(value) = decimal.to_i32(bytes) else {
            let text = String::from_utf8_lossy(&bytes[..decimal.len.min(40)]).into_owned();
            return Err(Fault::error(self.here(), format!("expected a 32-bit integer, found {text}")));
        };
        self.pos += decimal.len;
        Ok(value)
    }

    /// Takes a lone "-", which stands for "none" in `DepthOfField -`.
    pub fn dash(&mut self) -> bool {
        let rest = &self.window[self.pos..self.end];
        let found = rest.first() == Some(&b'-') && rest.get(1).is_none_or(u8::is_ascii_whitespace);
        self.pos += usize::from(found);
        found
    }

    /// Takes numbers up to the closing bracket, which is taken too; the opening one is taken already.
    pub fn floats(&mut self, out: &mut Vec<f32>, room: &mut Room) -> Result<(), Fault> {
        loop {
            self.run_of_floats(out, room)?;
            match self.peek() {
                Token::Close => {
                    self.bump();
                    return Ok(());
                }
                Token::Number => {
                    let value = self.float()?;
                    self.push(out, value, room)?;
                }
                other => return Err(self.not_in_array(other, "numbers")),
            }
        }
    }

    /// The loop over numbers and spaces that lie whole in the window.
    #[inline]
    fn run_of_floats(&mut self, out: &mut Vec<f32>, room: &mut Room) -> Result<(), Fault> {
        self.look_ahead();
        let limit = if self.eof { self.end } else { self.end.saturating_sub(MAX_LEN) };
        let bytes = &self.window[..self.end];
        let (mut pos, mut line, mut line_start) = (self.pos, self.line, self.line_start);
        let mut full = None;
        while pos < limit {
            let byte = bytes[pos];
            if byte <= b' ' {
                pos += 1;
                match byte {
                    b' ' | b'\t' | b'\r' => continue,
                    b'\n' => {
                        line = line.saturating_add(1);
                        line_start = self.base + pos as u64;
                        continue;
                    }
                    _ => {
                        pos -= 1;
                        break;
                    }
                }
            }
            let Some(decimal) = number::scan(&bytes[pos..]).filter(|d| d.len <= MAX_LEN) else { break };
            let value = decimal.to_f32(&bytes[pos..]);
            if !value.is_finite() {
                break;
            }
            if out.len() == out.capacity()
                && let Err(e) = room.grow(out)
            {
                full = Some(e);
                break;
            }
            out.push(value);
            pos += decimal.len;
        }
        (self.pos, self.line, self.line_start) = (pos, line, line_start);
        full.map_or(Ok(()), |e| Err(self.no_room(e)))
    }

    /// Takes a number as a float.
    pub fn float(&mut self) -> Result<f32, Fault> {
        self.look_ahead();
        let bytes = &self.window[self.pos..self.end];
        let found = number::scan(bytes).filter(|d| d.len <= MAX_LEN);
        match found.map(|d| (d.to_f32(bytes), d.len)) {
            Some((value, len)) if value.is_finite() => {
                self.pos += len;
                Ok(value)
            }
            _ => Err(self.bad_number()),
        }
    }

    /// Takes integers up to the closing bracket, which is taken too.
    pub fn integers(&mut self, out: &mut Vec<i32>, room: &mut Room) -> Result<(), Fault> {
        loop {
            match self.peek() {
                Token::Close => {
                    self.bump();
                    return Ok(());
                }
                Token::Number => {
                    let value = self.integer()?;
                    self.push(out, value, room)?;
                }
                other => return Err(self.not_in_array(other, "integers")),
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

    /// Takes a string and appends it to `into`. `Ok(false)` where it is not UTF-8 and was patched.
    pub fn text(&mut self, into: &mut String, room: &mut Room) -> Result<bool, Fault> {
        let start = self.here();
        let mut text = std::mem::take(&mut self.text);
        text.clear();
        self.bump();
        let read = self.text_bytes(&mut text, start, room);
        let read = read.and_then(|()| room.use_scratch(text.len() as u64).map_err(|e| self.no_room(e)));
        let valid = read.map(|()| {
            let piece = String::from_utf8_lossy(&text);
            into.push_str(&piece);
            matches!(piece, std::borrow::Cow::Borrowed(_))
        });
        if text.capacity() <= WINDOW {
            self.text = text;
        }
        valid
    }

    fn text_bytes(&mut self, text: &mut Vec<u8>, start: Pos, room: &mut Room) -> Result<(), Fault> {
        loop {
            self.look_ahead();
            let Some(&byte) = self.window[..self.end].get(self.pos) else {
                return Err(Fault::fatal(
                    start,
                    "the file ends inside this string: expected a closing quote",
                ));
            };
            self.pos += 1;
            match byte {
                b'"' => return Ok(()),
                b'\\' => {
                    if let Some(escaped) = self.escape() {
                        self.push(text, escaped, room)?;
                    }
                }
                _ => {
                    if byte == b'\n' {
                        self.new_line(self.pos);
                    }
                    self.push(text, byte, room)?;
                }
            }
        }
    }

    /// The byte that stands after a backslash; `None` for an escaped line end.
    fn escape(&mut self) -> Option<u8> {
        let byte = *self.window[..self.end].get(self.pos)?;
        self.pos += 1;
        match byte {
            b'n' => Some(b'\n'),
            b'r' => Some(b'\r'),
            b't' => Some(b'\t'),
            b'b' => Some(0x08),
            b'f' => Some(0x0c),
            b'\n' => {
                self.new_line(self.pos);
                None
            }
            b'0'..=b'7' => {
                let mut value = u32::from(byte - b'0');
                for _ in 0..2 {
                    let Some(digit @ b'0'..=b'7') = self.window[..self.end].get(self.pos) else { break };
                    value = value * 8 + u32::from(digit - b'0');
                    self.pos += 1;
                }
                Some((value & 0xff) as u8)
            }
            other => Some(other),
        }
    }
}

/// Whether a word is how some program wrote a number that is none.
pub fn not_a_number(word: &str) -> bool {
    ["nan", "inf", "infinity", "qnan", "snan", "ind"].iter().any(|w| word.eq_ignore_ascii_case(w))
}
