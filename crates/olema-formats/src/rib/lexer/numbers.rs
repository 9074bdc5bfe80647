//! Numbers and arrays of them.

use super::super::fault::Fault;
use super::super::number::{self, MAX_LEN};
use super::{Lexer, Token};
use crate::room::Room;

impl Lexer {
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
            let short = bytes[pos..].first_chunk().and_then(number::short);
            if let Some((value, len)) = short.filter(|_| out.len() < out.capacity()) {
                out.push(value);
                // Most often a space.
                pos += len + usize::from(bytes[pos + len] == b' ');
                continue;
            }
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
}
