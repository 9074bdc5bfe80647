//! The RIB reader (RenderMan Interface 3.2).
//!
//! In: a byte stream, ASCII or gzip. Out: one [`RibFrame`] for each WorldBegin/WorldEnd, and diagnostics.
//!
//! A byte goes through `lexer` (a sliding window, tokens), `args` (a statement's values, by the form that the
//! table in `statements` gives) and `interp` (the graphics state and the world); `reader` is the loop around
//! them, with its stack of files and recordings. No token tree is built: what is held is the scene, the state,
//! and what ObjectBegin and ArchiveBegin ask to keep. Source: The RenderMan Interface, version 3.2 (Pixar 2000).

mod args;
mod basis;
mod condition;
mod declare;
mod displacement;
mod fault;
mod interp;
mod lexer;
mod number;
mod params;
mod reader;
mod recover;
pub mod shaders;
mod source;
mod state;
pub mod statements;
mod textures;
mod transform;

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use olema::{Scene, Settings};

use crate::diagnostic::Diagnostic;
pub use crate::diagnostic::ReadError;

use shaders::ShaderLibrary;

/// What a reader may do and use.
#[derive(Debug, Clone)]
pub struct ReadOptions {
    /// Directories searched for archives and images, before the file's own `Option "searchpath"`; "&" in the latter
    /// stands for what was there before.
    pub search_path: Vec<PathBuf>,
    /// Most archives nested in each other.
    pub archive_depth: u32,
    /// Most bytes of statements, arrays and geometry held for one frame.
    pub memory: u64,
}

impl Default for ReadOptions {
    fn default() -> Self {
        ReadOptions { search_path: Vec::new(), archive_depth: 64, memory: 8 << 30 }
    }
}

/// One world, ready to render.
#[derive(Debug)]
pub struct RibFrame {
    /// Number given to FrameBegin, if the world stands in a frame block.
    pub number: Option<i32>,
    /// The scene.
    pub scene: Scene,
    /// The options of the file, as settings.
    pub settings: Settings,
    /// Displays, at least one; the first is the primary one.
    pub displays: Vec<Display>,
}

/// A `Display` statement with the quantization that was in force.
#[derive(Debug, Clone, PartialEq)]
pub struct Display {
    /// File name as given (without a leading "+").
    pub name: String,
    /// Driver as given ("file", "framebuffer", "png", ...).
    pub driver: String,
    /// Channels ("rgb", "rgba", "a", "z", or an AOV's name).
    pub mode: String,
    /// Quantization of colour and alpha.
    pub quantize: Quantize,
}

/// `Quantize`: value -> round(one * value + dither * noise), clamped to [min, max]; `one` 0 keeps floats.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantize {
    /// Value that 1.0 becomes.
    pub one: i32,
    /// Smallest value.
    pub min: i32,
    /// Largest value.
    pub max: i32,
    /// Amplitude of the dither, 0 to 1.
    pub dither: f32,
}

/// Reads a RIB stream world by world.
pub struct RibReader {
    reader: reader::Reader,
}

impl RibReader {
    /// Opens a file; gzip is recognised by its first bytes.
    ///
    /// # Errors
    /// [`ReadError::Io`] where it cannot be opened.
    pub fn open(path: &Path, options: ReadOptions) -> Result<Self, ReadError> {
        let io = |source| ReadError::Io { path: path.display().to_string(), source };
        Ok(Self::new(source::FileSource::open(path).map_err(io)?, options))
    }

    /// Reads from a stream; `name` is what diagnostics call it.
    pub fn from_stream(name: &str, stream: Box<dyn Read>, options: ReadOptions) -> Self {
        Self::new(source::FileSource::new(name, stream, None), options)
    }

    fn new(source: source::FileSource, options: ReadOptions) -> Self {
        RibReader { reader: reader::Reader::new(source, options, Arc::new(shaders::Standard)) }
    }

    /// Takes shaders from `library`; to be called before the first frame is read.
    pub fn with_library(mut self, library: Arc<dyn ShaderLibrary>) -> Self {
        self.reader.set_library(library);
        self
    }

    /// Reads up to the next WorldEnd; `None` at the end of the input.
    ///
    /// # Errors
    /// [`ReadError`] where nothing further can be read.
    pub fn next_frame(&mut self) -> Result<Option<RibFrame>, ReadError> {
        self.reader.next_frame()
    }

    /// Takes the diagnostics said since the last call, in the input's order; what a frame leaves undrawn comes at
    /// its end. At most 1000 are kept between two calls.
    pub fn take_diagnostics(&mut self) -> Vec<Diagnostic> {
        self.reader.take_diagnostics()
    }
}

#[cfg(test)]
mod tests;
