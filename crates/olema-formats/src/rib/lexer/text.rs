//! Strings.

use super::super::fault::{Fault, Pos};
use super::{Lexer, WINDOW};
use crate::room::Room;

impl Lexer {
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
