//! A text in pieces, each of which is gone once it is read: what a program holds of a file while it reads it.

use std::collections::VecDeque;
use std::fmt;
use std::io::{self, Read};

/// Bytes of a piece; what a reader asks for at a time.
const PIECE: usize = 64 << 10;

/// A text to be read once, from its beginning.
#[derive(Debug, Default)]
pub struct Text {
    pieces: VecDeque<Vec<u8>>,
    /// Bytes of the first piece that were read.
    read: usize,
}

impl Text {
    /// Appends to it.
    pub fn push_str(&mut self, more: &str) {
        let mut more = more.as_bytes();
        while !more.is_empty() {
            let room = self.pieces.back().map_or(0, |last| PIECE - last.len());
            if room == 0 {
                self.pieces.push_back(Vec::with_capacity(PIECE));
                continue;
            }
            let (now, later) = more.split_at(room.min(more.len()));
            self.pieces.back_mut().into_iter().for_each(|last| last.extend_from_slice(now));
            more = later;
        }
    }
}

impl fmt::Write for Text {
    fn write_str(&mut self, more: &str) -> fmt::Result {
        self.push_str(more);
        Ok(())
    }
}

impl Read for Text {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let Some(first) = self.pieces.front() else { return Ok(0) };
        let len = (&first[self.read..]).read(out)?;
        self.read += len;
        if self.read == first.len() {
            self.pieces.pop_front();
            self.read = 0;
        }
        Ok(len)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let line = "Patch \"bicubic\"\n";
        let mut text = Text::default();
        (0..10_000).for_each(|_| text.push_str(line));
        assert!(text.pieces.len() > 2 && text.pieces.iter().all(|piece| piece.capacity() == PIECE));
        let mut read = String::new();
        text.read_to_string(&mut read).expect("no file");
        assert!(read == line.repeat(10_000) && text.pieces.is_empty());
    }
}
