//! The reader's loop: statements from the innermost source, one after the other, to the interpreter.
//!
//! Sources stand on a stack: the file, the archives it reads, the recordings it runs. What is wrong with one
//! statement is said, and reading goes on at the next; what is wrong with an archive ends that archive.

use std::path::Path;
use std::sync::Arc;

use olema::shading::TextureImage;

use crate::diagnostic::{Diagnostic, Severity};

use super::args::{Args, Reading};
use super::fault::{Fault, Pos};
use super::interp::{Call, Flow, Interp, Recorded};
use super::lexer::Token;
use super::shaders::ShaderLibrary;
use super::source::{FileSource, Replay, Source, candidates};
use super::state::Site;
use super::statements::{self, Id, Statement};
use super::textures::Textures;
use super::{ReadError, ReadOptions, RibFrame};
use crate::room::{ARCHIVE_COST, REPLAY_COST};

/// An open IfBegin.
pub(super) struct Condition {
    /// Whether the current branch is read.
    pub active: bool,
    /// Whether a branch was read already.
    pub done: bool,
    /// Whether Else was there.
    pub last: bool,
    /// Where it began.
    pub site: Site,
}

/// The loop and what it needs.
pub struct Reader {
    pub(super) options: ReadOptions,
    pub(super) sources: Vec<Source>,
    /// Conditions open before each source.
    pub(super) floors: Vec<usize>,
    pub(super) interp: Interp,
    pub(super) args: Args,
    word: String,
    pub(super) conditions: Vec<Condition>,
    /// IfBegins open within a branch that is not read.
    pub(super) skipped: u32,
    pub(super) diagnostics: Vec<Diagnostic>,
    pub(super) left_out: u64,
    textures: Textures,
    /// The file of the statement that is being run.
    pub(super) file: Arc<str>,
    ended: bool,
}

/// What one step came to.
pub(super) enum Step {
    /// Go on.
    Go,
    /// A frame is finished.
    Frame(Box<RibFrame>),
    /// The input ended.
    End,
}

impl Reader {
    /// Starts at the beginning of `source`.
    pub fn new(source: FileSource, options: ReadOptions, library: Arc<dyn ShaderLibrary>) -> Self {
        let interp = Interp::new(options.memory, library);
        let file = source.name.clone();
        Reader {
            options,
            file,
            floors: vec![0],
            sources: vec![Source::File(Box::new(source))],
            interp,
            args: Args::default(),
            word: String::new(),
            conditions: Vec::new(),
            skipped: 0,
            diagnostics: Vec::new(),
            left_out: 0,
            textures: Textures::default(),
            ended: false,
        }
    }

    /// Replaces the shaders' source.
    pub fn set_library(&mut self, library: Arc<dyn ShaderLibrary>) {
        self.interp.set_library(library);
    }

    /// Reads up to the next frame.
    pub fn next_frame(&mut self) -> Result<Option<RibFrame>, ReadError> {
        while !self.ended {
            match self.step() {
                Ok(Step::Go) => {}
                Ok(Step::Frame(frame)) => {
                    self.flush_notes();
                    return Ok(Some(*frame));
                }
                Ok(Step::End) => {
                    self.ended = true;
                    self.finish()?;
                }
                Err(e) => {
                    self.ended = true;
                    return Err(e);
                }
            }
        }
        Ok(None)
    }

    /// Takes what was said.
    pub fn take_diagnostics(&mut self) -> Vec<Diagnostic> {
        let mut taken = std::mem::take(&mut self.diagnostics);
        if let (true, Some(last)) = (self.left_out > 0, taken.last()) {
            let message = format!("{} further messages were left out", self.left_out);
            let severity = Severity::Warning;
            let file = last.file.clone();
            taken.push(Diagnostic { severity, file, line: 0, column: 0, message, source_line: None });
        }
        self.left_out = 0;
        taken
    }

    fn step(&mut self) -> Result<Step, ReadError> {
        let result = match self.sources.last_mut() {
            None => return Ok(Step::End),
            Some(Source::Replay(_)) => self.step_replay(),
            Some(Source::File(_)) => self.step_file(),
        };
        match result {
            Ok(step) => {
                self.flush();
                Ok(step)
            }
            Err(fault) => self.recover(fault),
        }
    }

    fn step_file(&mut self) -> Result<Step, Fault> {
        let Some(Source::File(file)) = self.sources.last_mut() else { return Ok(Step::End) };
        let token = file.lexer.peek();
        let pos = file.lexer.here();
        self.file = file.name.clone();
        match token {
            Token::Word => {
                file.lexer.word(&mut self.word);
                let site = Site { file: file.name.clone(), pos };
                self.step_word(site)
            }
            Token::End => match file.lexer.take_error() {
                Some(error) => Err(Fault::fatal(pos, format!("the file cannot be read further: {error}"))),
                None if self.sources.len() == 1 => Ok(Step::End),
                None => {
                    self.leave();
                    Ok(Step::Go)
                }
            },
            Token::Stray(byte) if byte >= 0x80 => {
                let message =
                    format!("byte 0x{byte:02x}: binary RIB is not read yet; expected ASCII or gzip");
                Err(Fault::fatal(pos, message))
            }
            _ if self.is_skipping() => {
                self.skip_token(token)?;
                Ok(Step::Go)
            }
            other => Err(Fault::error(pos, format!("expected a statement, found {}", other.describe()))),
        }
    }

    fn step_word(&mut self, site: Site) -> Result<Step, Fault> {
        let Some(statement) = statements::find(&self.word) else {
            if self.is_skipping() {
                return Ok(Step::Go);
            }
            // Looking for neighbours takes long where everything is unknown.
            let few = self.diagnostics.len() < 100;
            let near = few.then(|| statements::nearest(&self.word)).flatten();
            let hint = near.map(|n| format!(" (\"{n}\"?)")).unwrap_or_default();
            let message =
                format!("unknown statement \"{}\": expected a RenderMan statement{hint}; skipped", self.word);
            return Err(Fault::error(site.pos, message));
        };
        if self.is_skipping() && !self.ends_skipping(statement.id) {
            return Ok(Step::Go);
        }
        let mut args = std::mem::take(&mut self.args);
        args.clear(&mut self.interp.room);
        let read = match self.sources.last_mut() {
            Some(Source::File(file)) => args.read(
                statement,
                &mut Reading {
                    lexer: &mut file.lexer,
                    dictionary: &self.interp.dictionary,
                    room: &mut self.interp.room,
                    said: &mut self.interp.said,
                },
            ),
            _ => Ok(false),
        };
        let result = match read {
            Ok(more) => {
                let rest = if more { self.skip_to_statement() } else { Ok(()) };
                rest.and_then(|()| self.run(Call { statement, args: &args, site: &site, geometries: None }))
            }
            Err(fault) => {
                if statement.id == Id::MotionBegin && !fault.fatal {
                    self.begin_without_times(&mut args, statement, &site);
                }
                Err(fault)
            }
        };
        self.args = args;
        result
    }

    /// A MotionBegin whose times cannot be read begins a block all the same: without one, its statements would be
    /// run one after the other.
    fn begin_without_times(&mut self, args: &mut Args, statement: &'static Statement, site: &Site) {
        args.clear(&mut self.interp.room);
        let run = self.run(Call { statement, args, site, geometries: None });
        self.interp.said.extend(run.err());
    }

    fn step_replay(&mut self) -> Result<Step, Fault> {
        let Some(Source::Replay(replay)) = self.sources.last_mut() else { return Ok(Step::End) };
        let recording = replay.recording.clone();
        let Some(recorded) = recording.statements.get(replay.next) else {
            self.leave();
            return Ok(Step::Go);
        };
        replay.next += 1;
        let pos = recorded.site.pos;
        self.file = recorded.site.file.clone();
        self.interp.room.hold(REPLAY_COST).map_err(|full| {
            let message = format!("the {} bytes granted for a frame are used up by instances", full.limit);
            Fault::fatal(pos, message + ": expected fewer")
        })?;
        if self.is_skipping() && !self.ends_skipping(recorded.statement.id) {
            return Ok(Step::Go);
        }
        let Recorded { statement, args, site, geometries } = &recorded;
        self.run(Call { statement, args, site, geometries: Some(geometries) })
    }

    fn run(&mut self, call: Call<'_>) -> Result<Step, Fault> {
        let id = call.statement.id;
        let conditional = matches!(id, Id::IfBegin | Id::ElseIf | Id::Else | Id::IfEnd);
        if conditional && !self.interp.is_recording() {
            self.condition(&call)?;
            return Ok(Step::Go);
        }
        let mut flow = self.interp.run(call)?;
        while let Flow::Texture { name } = flow {
            let found = self.texture(&name);
            self.interp.textures.insert(name, found);
            flow = self.interp.run(call)?;
        }
        self.interp.textures.clear();
        match flow {
            Flow::Next | Flow::Texture { .. } => {}
            Flow::Frame(frame) => return Ok(Step::Frame(frame)),
            Flow::Archive { name, is_object } => self.enter_archive(&name, is_object, call.site)?,
            Flow::Replay { recording, is_object } => {
                self.check_depth(call.site.pos)?;
                let saved = is_object.then(|| self.interp.enter_object());
                self.enter(Source::Replay(Replay { recording, next: 0, saved }));
            }
        }
        Ok(Step::Go)
    }

    fn check_depth(&self, pos: Pos) -> Result<(), Fault> {
        let limit = self.options.archive_depth as usize;
        if self.sources.len() > limit {
            let message = format!(
                "archives and objects are nested deeper than {limit}: expected no archive to read itself"
            );
            return Err(Fault::error(pos, message));
        }
        Ok(())
    }

    /// An image, found as archives are.
    fn texture(&mut self, name: &str) -> Result<Arc<TextureImage>, String> {
        let paths = [self.options.search_path.as_slice(), &self.interp.options.texture_path];
        let tried = candidates(name, self.beside(), &paths);
        let (image, bytes) = self.textures.find(name, &tried, self.interp.room.left())?;
        self.interp.room.hold(bytes).map_err(|full| {
            format!("image \"{name}\": the {} bytes granted for a frame are used up", full.limit)
        })?;
        self.interp.kept = self.interp.kept.saturating_add(bytes);
        Ok(image)
    }

    /// The file that is being read, if it is one.
    fn beside(&self) -> Option<&Path> {
        let innermost = self.sources.iter().rev().find_map(|s| match s {
            Source::File(file) => Some(file.path.as_deref()),
            Source::Replay(_) => None,
        });
        innermost.flatten()
    }

    fn enter_archive(&mut self, name: &str, is_object: bool, site: &Site) -> Result<(), Fault> {
        self.check_depth(site.pos)?;
        let paths = [self.options.search_path.as_slice(), &self.interp.options.search_path];
        let tried = candidates(name, self.beside(), &paths);
        let Some(path) = tried.iter().find(|p| p.is_file()) else {
            let message =
                format!("archive \"{name}\" is not in any of the {} places searched; left out", tried.len());
            return Err(Fault::warning(site.pos, message));
        };
        let mut source = FileSource::open(path).map_err(|e| {
            Fault::warning(site.pos, format!("archive \"{}\": {e}; left out", path.display()))
        })?;
        let is_open = |s: &Source| matches!(s, Source::File(f) if f.path == source.path);
        if self.sources.iter().any(is_open) {
            let message = format!("archive \"{name}\" reads itself: expected another one; left out");
            return Err(Fault::error(site.pos, message));
        }
        self.interp.room.hold(ARCHIVE_COST).map_err(|full| {
            let message = format!("the {} bytes granted for a frame are used up by archives", full.limit);
            Fault::error(site.pos, message + ": expected fewer; left out")
        })?;
        source.saved = is_object.then(|| self.interp.enter_object());
        self.enter(Source::File(Box::new(source)));
        Ok(())
    }

    fn enter(&mut self, source: Source) {
        self.floors.push(self.conditions.len());
        self.sources.push(source);
    }

    /// The innermost source ended.
    pub(super) fn leave(&mut self) {
        let saved = match self.sources.pop() {
            Some(Source::File(file)) => file.saved,
            Some(Source::Replay(replay)) => replay.saved,
            None => None,
        };
        self.close_conditions();
        if let Some(saved) = saved {
            self.interp.leave_object(saved);
        }
    }
}
