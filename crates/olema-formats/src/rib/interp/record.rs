//! Objects and inline archives: statements that are kept and run again.
//!
//! A recording is a list of statements with their values. Geometry that was made from one is kept beside it, so
//! that all instances share it.

use std::sync::{Arc, OnceLock};

use olema::scene::{Geometry, PatchBasis};

use super::super::args::Args;
use super::super::fault::{Fault, Pos};
use super::super::state::{Handle, Site};
use super::super::statements::{Id, Statement};
use super::{Call, Flow, Interp};

/// Geometry made from a recorded statement, and the bases it was made with.
pub type Geometries = OnceLock<([PatchBasis; 2], Geometry)>;

/// A recorded statement.
#[derive(Debug)]
pub struct Recorded {
    /// Its line of the table.
    pub statement: &'static Statement,
    /// Its values.
    pub args: Args,
    /// Where it stands.
    pub site: Site,
    /// Its geometry, once made.
    pub geometries: Geometries,
}

/// A recording.
#[derive(Debug, Default)]
pub struct Recording {
    /// The statements.
    pub statements: Vec<Recorded>,
}

/// A recording that is being made.
pub struct Recorder {
    handle: Handle,
    /// ObjectBegin or ArchiveBegin.
    begin: Id,
    end: Id,
    /// Blocks of the same kind open within it.
    nested: u32,
    recording: Recording,
    /// Where it began.
    pub pos: Pos,
    bytes: u64,
}

impl Recorder {
    /// The statement that would end it.
    pub fn end_name(&self) -> &'static str {
        if self.end == Id::ObjectEnd { "ObjectEnd" } else { "ArchiveEnd" }
    }
}

impl Interp {
    /// ObjectBegin and ArchiveBegin.
    pub(super) fn begin_recording(&mut self, call: &Call<'_>) -> Result<(), Fault> {
        let handle = Handle::of(call.args, 0);
        let (begin, end) = match call.statement.id {
            Id::ObjectBegin => (Id::ObjectBegin, Id::ObjectEnd),
            _ => (Id::ArchiveBegin, Id::ArchiveEnd),
        };
        let recording = Recording::default();
        self.recorder =
            Some(Recorder { handle, begin, end, nested: 0, recording, pos: call.site.pos, bytes: 0 });
        Ok(())
    }

    /// Adds a statement to the recording, or ends it.
    pub(super) fn record(&mut self, call: Call<'_>) -> Result<Flow, Fault> {
        let Some(recorder) = &mut self.recorder else { return Ok(Flow::Next) };
        let id = call.statement.id;
        if id == recorder.end && recorder.nested == 0 {
            self.end_recording();
            return Ok(Flow::Next);
        }
        if id == recorder.begin {
            if id == Id::ObjectBegin {
                let message = "ObjectBegin in an object: expected ObjectEnd first; ignored";
                return Err(Fault::error(call.site.pos, message));
            }
            recorder.nested += 1;
        } else if id == recorder.end {
            recorder.nested -= 1;
        }
        let bytes = call.args.heap_bytes() + size_of::<Recorded>() as u64;
        recorder.bytes += bytes;
        self.hold(call.site.pos, bytes)?;
        self.kept = self.kept.saturating_add(bytes);
        if id == Id::Declare {
            // What follows is read with it.
            self.option(&call)?;
        }
        if let Some(recorder) = &mut self.recorder {
            recorder.recording.statements.push(Recorded {
                statement: call.statement,
                args: call.args.clone(),
                site: call.site.clone(),
                geometries: OnceLock::new(),
            });
        }
        Ok(Flow::Next)
    }

    /// Keeps the recording that is being made under its name.
    pub fn end_recording(&mut self) {
        let Some(recorder) = self.recorder.take() else { return };
        let recording = Arc::new(recorder.recording);
        if recorder.begin == Id::ObjectBegin {
            self.objects.insert(recorder.handle, recording);
        } else {
            let name = match recorder.handle {
                Handle::Name(name) => name,
                Handle::Number(number) => number.to_string(),
            };
            self.archives.insert(name, recording);
        }
    }

    /// ObjectInstance.
    pub(super) fn instance(&mut self, call: &Call<'_>) -> Result<Flow, Fault> {
        let handle = Handle::of(call.args, 0);
        match self.objects.get(&handle) {
            Some(recording) => Ok(Flow::Replay { recording: recording.clone(), is_object: true }),
            None => {
                let message = format!("object {handle} is unknown: expected one that ObjectBegin defined");
                Err(Fault::error(call.args.pos(0), message))
            }
        }
    }

    /// ReadArchive and Procedural.
    pub(super) fn archive(&mut self, call: &Call<'_>) -> Result<Flow, Fault> {
        let args = call.args;
        if call.statement.id == Id::ReadArchive {
            let name = args.text(0).unwrap_or_default();
            return Ok(match self.archives.get(name) {
                Some(recording) => Flow::Replay { recording: recording.clone(), is_object: false },
                None => Flow::Archive { name: name.to_owned(), is_object: false },
            });
        }
        let kind = args.text(0).unwrap_or_default();
        let refused = match kind {
            "DelayedReadArchive" => {
                let Some(name) = args.text(1) else {
                    return Err(Fault::error(
                        args.pos(1),
                        "DelayedReadArchive: expected the name of an archive",
                    ));
                };
                return Ok(match self.archives.get(name) {
                    Some(recording) => Flow::Replay { recording: recording.clone(), is_object: true },
                    None => Flow::Archive { name: name.to_owned(), is_object: true },
                });
            }
            "RunProgram" => {
                "RunProgram is refused: Olema starts no program that a scene names; nothing is drawn for it"
            }
            "DynamicLoad" => {
                "DynamicLoad is refused: Olema loads no code that a scene names; nothing is drawn for it"
            }
            _ => "this procedural is unknown: expected \"DelayedReadArchive\"",
        };
        self.say(Fault::warning(call.site.pos, refused));
        Ok(Flow::Next)
    }
}
