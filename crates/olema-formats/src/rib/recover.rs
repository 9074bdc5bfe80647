//! What the reader does about faults, conditions and the end of a file.

use crate::diagnostic::{Diagnostic, Severity};

use super::ReadError;
use super::condition;
use super::fault::{Fault, Pos};
use super::interp::Call;
use super::lexer::Token;
use super::reader::{Condition, Reader, Step};
use super::source::Source;
use super::state::{BlockKind, Site};
use super::statements::Id;

/// Most messages kept until they are taken.
const MAX_DIAGNOSTICS: usize = 1000;
/// Deepest conditions.
const MAX_CONDITIONS: usize = 1000;

impl Reader {
    /// Keeps a message; of very many, only the first.
    fn keep(&mut self, diagnostic: Diagnostic) {
        if self.diagnostics.len() < MAX_DIAGNOSTICS {
            self.diagnostics.push(diagnostic);
        } else {
            self.left_out += 1;
        }
    }

    /// A fault with its file's name and source line.
    fn diagnostic(&self, fault: Fault) -> Diagnostic {
        let line = self.sources.iter().rev().find_map(|s| match s {
            Source::File(file) if file.name == self.file => Some(file.lexer.source_line(fault.pos)),
            _ => None,
        });
        Diagnostic {
            severity: fault.severity,
            file: self.file.to_string(),
            line: fault.pos.line,
            column: fault.pos.column,
            message: fault.message,
            source_line: line.flatten(),
        }
    }

    /// Gives what the interpreter said its place among the messages.
    pub(super) fn flush(&mut self) {
        if self.interp.said.is_empty() {
            return;
        }
        for fault in std::mem::take(&mut self.interp.said) {
            let diagnostic = self.diagnostic(fault);
            self.keep(diagnostic);
        }
    }

    /// Says once a frame what was not drawn.
    pub(super) fn flush_notes(&mut self) {
        for (site, message) in self.interp.take_notes() {
            let Pos { line, column, .. } = site.pos;
            let (severity, file) = (Severity::Note, site.file.to_string());
            self.keep(Diagnostic { severity, file, line, column, message, source_line: None });
        }
    }

    /// Goes on after a fault: at the next statement, or behind the archive.
    pub(super) fn recover(&mut self, fault: Fault) -> Result<Step, ReadError> {
        self.flush();
        let fatal = fault.fatal;
        let diagnostic = self.diagnostic(fault);
        if fatal && self.sources.len() <= 1 {
            return Err(ReadError::Fatal(diagnostic));
        }
        self.keep(diagnostic);
        if fatal {
            self.leave();
            return Ok(Step::Go);
        }
        match self.skip_to_statement() {
            Ok(()) => Ok(Step::Go),
            Err(fault) => self.recover(Fault { fatal: true, ..fault }),
        }
    }

    /// Skips what is left of a statement in a file.
    pub(super) fn skip_to_statement(&mut self) -> Result<(), Fault> {
        loop {
            let Some(Source::File(file)) = self.sources.last_mut() else { return Ok(()) };
            match file.lexer.peek() {
                Token::Word if !file.lexer.is_at_not_a_number() => return Ok(()),
                Token::End | Token::Stray(0x80..) => return Ok(()),
                token => self.skip_token(token)?,
            }
        }
    }

    /// Skips one token.
    pub(super) fn skip_token(&mut self, token: Token) -> Result<(), Fault> {
        let Some(Source::File(file)) = self.sources.last_mut() else { return Ok(()) };
        match token {
            Token::Text => {
                let mut text = String::new();
                file.lexer.text(&mut text, &mut self.interp.room)?;
                self.args.clear(&mut self.interp.room);
            }
            Token::Number => {
                // Whether it is one does not matter here.
                let _ = file.lexer.number();
            }
            Token::Word => file.lexer.word(&mut String::new()),
            _ => file.lexer.bump(),
        }
        Ok(())
    }

    /// Whether statements are skipped for a condition.
    pub(super) fn is_skipping(&self) -> bool {
        self.conditions.last().is_some_and(|c| !c.active)
    }

    /// Whether a statement within a skipped branch may end it.
    pub(super) fn ends_skipping(&mut self, id: Id) -> bool {
        match id {
            Id::IfBegin => {
                self.skipped = self.skipped.saturating_add(1);
                false
            }
            Id::IfEnd if self.skipped > 0 => {
                self.skipped -= 1;
                false
            }
            Id::IfEnd | Id::ElseIf | Id::Else => self.skipped == 0,
            _ => false,
        }
    }

    /// IfBegin, ElseIf, Else, IfEnd.
    pub(super) fn condition(&mut self, call: &Call<'_>) -> Result<(), Fault> {
        let (id, pos) = (call.statement.id, call.site.pos);
        if id == Id::IfBegin {
            if self.conditions.len() >= MAX_CONDITIONS {
                let message =
                    format!("expected at most {MAX_CONDITIONS} conditions nested in each other; ignored");
                return Err(Fault::error(pos, message));
            }
            let active = self.holds(call);
            self.conditions.push(Condition { active, done: active, last: false, site: call.site.clone() });
            return Ok(());
        }
        let floor = self.floors.last().copied().unwrap_or(0);
        let open = self.conditions.len() > floor;
        let Some(condition) = self.conditions.last_mut().filter(|_| open) else {
            return Err(Fault::error(pos, format!("{} without IfBegin; ignored", call.statement.name)));
        };
        if id == Id::IfEnd {
            self.conditions.pop();
            return Ok(());
        }
        if condition.last {
            condition.active = false;
            return Err(Fault::error(
                pos,
                format!("{} after Else: expected IfEnd; skipped", call.statement.name),
            ));
        }
        condition.last = id == Id::Else;
        let asked = !condition.done;
        let active = asked && (id == Id::Else || self.holds(call));
        if let Some(condition) = self.conditions.last_mut() {
            condition.active = active;
            condition.done |= active;
        }
        Ok(())
    }

    fn holds(&mut self, call: &Call<'_>) -> bool {
        let text = call.args.text(0).unwrap_or_default();
        condition::holds(text, |name| self.interp.variable(name)).unwrap_or_else(|why| {
            let message = format!("condition {text:?}: {why}; taken as false");
            self.interp.said.push(Fault::warning(call.args.pos(0), message));
            false
        })
    }

    /// Closes the conditions that the source that ended left open.
    pub(super) fn close_conditions(&mut self) {
        let floor = self.floors.pop().unwrap_or(0);
        while self.conditions.len() > floor {
            let Some(condition) = self.conditions.pop() else { break };
            self.skipped = 0;
            self.say_open("IfBegin", "IfEnd", &condition.site);
        }
    }

    fn say_open(&mut self, begin: &str, end: &str, site: &Site) {
        let message = format!("{begin} is still open where the file ends: expected {end}");
        let (severity, file) = (Severity::Error, site.file.to_string());
        let Pos { line, column, .. } = site.pos;
        self.keep(Diagnostic { severity, file, line, column, message, source_line: None });
    }

    /// The input ended: says what is still open.
    ///
    /// # Errors
    /// Where that is a world or a recording: the input was cut off.
    pub(super) fn finish(&mut self) -> Result<(), ReadError> {
        self.flush();
        self.close_conditions();
        self.flush_notes();
        let here = match self.sources.last() {
            Some(Source::File(file)) => file.lexer.here(),
            _ => Pos::default(),
        };
        if let Some((end, line)) = self.interp.open_recording() {
            let message = format!("the file ends in what line {line} began to record: expected {end}");
            return Err(ReadError::Fatal(self.diagnostic(Fault::fatal(here, message))));
        }
        for block in std::mem::take(&mut self.interp.blocks) {
            if block.kind == BlockKind::World {
                let line = block.site.pos.line;
                let message = format!("the file ends in the world of line {line}: expected WorldEnd");
                return Err(ReadError::Fatal(self.diagnostic(Fault::fatal(here, message))));
            }
            self.say_open(block.kind.begin(), block.kind.end(), &block.site);
        }
        Ok(())
    }
}
