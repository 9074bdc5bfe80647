//! Says what readers and renderer have to say, on standard error.
//!
//! People get the source line with a pointer (miette); `--progress json` gets an object a line. What repeats is
//! cut short and counted. Text from scenes is untrusted: control characters never reach the terminal.

mod snippet;

use std::collections::HashMap;
use std::io::{IsTerminal, Write};

use miette::{GraphicalReportHandler, GraphicalTheme};
use olema_formats::rib::ReadError;
use olema_formats::{Diagnostic, Severity};
use serde::Serialize;

use crate::exit::{self, Failure};
use snippet::Message;

/// How often the same message is shown.
const SAME: u32 = 3;
/// How many messages of one severity are shown.
const MANY: u64 = 50;

/// What is shown.
#[derive(Debug, Clone, Copy, Default)]
pub struct Options {
    /// Errors only.
    pub quiet: bool,
    /// All of it, however often it repeats.
    pub verbose: bool,
    /// Objects, not prose.
    pub json: bool,
}

/// Messages said so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Statements or files that were given up.
    pub errors: u64,
    /// Wrong or unusual, read as far as it made sense.
    pub warnings: u64,
    /// Correct but not drawn yet.
    pub notes: u64,
}

impl Counts {
    fn of(&mut self, severity: Severity) -> &mut u64 {
        match severity {
            Severity::Note => &mut self.notes,
            Severity::Warning => &mut self.warnings,
            Severity::Error => &mut self.errors,
        }
    }
}

/// Prints messages and counts them.
#[derive(Debug)]
pub struct Reporter {
    options: Options,
    counts: Counts,
    shown: Counts,
    /// How often each text was seen; grows no further than `MANY` texts a severity.
    seen: HashMap<(u8, String), u32>,
    handler: GraphicalReportHandler,
}

impl Reporter {
    /// A reporter that has said nothing.
    pub fn new(options: Options) -> Self {
        let theme = match (std::io::stderr().is_terminal(), std::env::var_os("NO_COLOR")) {
            (false, _) => GraphicalTheme::none(),
            (true, Some(value)) if !value.is_empty() => GraphicalTheme::unicode_nocolor(),
            (true, _) => GraphicalTheme::unicode(),
        };
        let handler = GraphicalReportHandler::new_themed(theme).with_wrap_lines(false).with_links(false);
        Reporter {
            options,
            counts: Counts::default(),
            shown: Counts::default(),
            seen: HashMap::new(),
            handler,
        }
    }

    /// What was said so far, shown or not.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// What a reader said.
    pub fn diagnostics(&mut self, diagnostics: impl IntoIterator<Item = Diagnostic>) {
        for diagnostic in diagnostics {
            self.say(&diagnostic);
        }
    }

    /// A warning that belongs to no place of a file.
    pub fn warning(&mut self, message: impl Into<String>) {
        self.say(&placeless(Severity::Warning, message.into()));
    }

    /// An error that belongs to no place of a file. Returns its exit code.
    pub fn failure(&mut self, failure: &Failure) -> u8 {
        self.say(&placeless(Severity::Error, failure.message.clone()));
        failure.code
    }

    /// The end of a reader. Returns the exit code.
    pub fn read_error(&mut self, error: ReadError) -> u8 {
        match error {
            ReadError::Fatal(diagnostic) => self.say(&diagnostic),
            ReadError::Io { .. } => self.say(&placeless(Severity::Error, error.to_string())),
        }
        exit::SCENE
    }

    /// Says how many messages there were, if some were not shown.
    pub fn finish(&self) {
        let Counts { errors, warnings, notes } = self.counts;
        let hidden = errors + warnings + notes - self.shown.errors - self.shown.warnings - self.shown.notes;
        if hidden == 0 || self.options.json || self.options.quiet && errors == self.shown.errors {
            return;
        }
        let number = |n: u64, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
        self.write(&format!(
            "{}, {}, {}; {hidden} of them not shown (--verbose shows all)\n",
            number(errors, "error"),
            number(warnings, "warning"),
            number(notes, "note")
        ));
    }

    fn say(&mut self, diagnostic: &Diagnostic) {
        *self.counts.of(diagnostic.severity) += 1;
        if !self.is_shown(diagnostic) {
            return;
        }
        *self.shown.of(diagnostic.severity) += 1;
        let message = Message::new(diagnostic);
        if self.options.json {
            self.write(&format!("{}\n", message.json()));
            return;
        }
        let mut text = String::new();
        if message.has_place() && self.handler.render_report(&mut text, &message).is_ok() {
            self.write(&text);
        } else {
            self.write(&format!("{message}\n"));
        }
    }

    fn is_shown(&mut self, diagnostic: &Diagnostic) -> bool {
        let severity = diagnostic.severity;
        if self.options.quiet && severity < Severity::Error {
            return false;
        }
        if self.options.verbose || self.options.json {
            return true;
        }
        if *self.shown.of(severity) >= MANY {
            return false;
        }
        let times = self.seen.entry((severity as u8, diagnostic.message.clone())).or_insert(0);
        *times = times.saturating_add(1);
        *times <= SAME
    }

    fn write(&self, text: &str) {
        // A closed standard error is no reason to stop rendering.
        let _ = std::io::stderr().lock().write_all(text.as_bytes());
    }
}

fn placeless(severity: Severity, message: String) -> Diagnostic {
    Diagnostic { severity, file: String::new(), line: 0, column: 0, message, source_line: None }
}

/// The text with its line ends, but nothing else that would steer a terminal.
pub fn printable_lines(text: &str) -> String {
    text.split('\n').map(snippet::printable).collect::<Vec<_>>().join("\n")
}

/// Prints to standard output. A reader that went away (`| head`) is no error.
///
/// # Errors
/// A render failure where standard output cannot be written otherwise (a full disk).
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::new(exit::RENDER, format!("standard output: {error}")))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How many of `texts`, each a warning, are shown.
    fn shown(options: Options, texts: impl Iterator<Item = String>) -> usize {
        let mut reporter = Reporter::new(options);
        let mut show = |text| {
            let diagnostic = placeless(Severity::Warning, text);
            let is_shown = reporter.is_shown(&diagnostic);
            *reporter.shown.of(Severity::Warning) += u64::from(is_shown);
            is_shown
        };
        texts.filter(|text| show(text.clone())).count()
    }

    #[test]
    fn what_repeats_is_cut_short() {
        let same = || (0..1000).map(|_| "same".to_owned());
        let different = || (0..1000).map(|n| format!("warning {n}"));
        assert_eq!(shown(Options::default(), same()), SAME as usize);
        assert_eq!(shown(Options::default(), different()), MANY as usize);
        assert_eq!(shown(Options { verbose: true, ..Options::default() }, same()), 1000);
        assert_eq!(shown(Options { quiet: true, ..Options::default() }, different()), 0);
    }

    #[test]
    fn quiet_keeps_errors_and_counts_the_rest() {
        let mut reporter = Reporter::new(Options { quiet: true, ..Options::default() });
        reporter.warning("a warning");
        assert_eq!(reporter.counts(), Counts { errors: 0, warnings: 1, notes: 0 });
        assert!(reporter.is_shown(&placeless(Severity::Error, "an error".to_owned())));
    }
}
