//! Opens scenes and models that are named on the command line; `-` is a scene from standard input.

use std::path::{Path, PathBuf};

use olema_formats::Diagnostic;
use olema_formats::rib::{ReadError, ReadOptions, RibFrame, RibReader};

use crate::exit::{self, Failure};
use crate::model::{self, Model, ModelArgs};

/// A file whose frames are read one by one.
pub enum Source {
    /// A scene.
    Rib(Box<RibReader>),
    /// A model, which is one frame.
    Model(Box<Model>),
}

/// Opens a scene or a model, of which at most `memory` bytes are held.
///
/// # Errors
/// [`ReadError`] where it cannot be opened.
pub fn open(
    file: &Path,
    search_path: &[PathBuf],
    model: ModelArgs,
    memory: u64,
) -> Result<Source, ReadError> {
    if model::is_model(file) {
        return Ok(Source::Model(Box::new(Model::open(file, model, memory)?)));
    }
    let options = ReadOptions { search_path: search_path.to_vec(), memory, ..ReadOptions::default() };
    let reader = if file == Path::new("-") {
        RibReader::from_stream("-", Box::new(std::io::stdin()), options)
    } else {
        RibReader::open(file, options)?
    };
    Ok(Source::Rib(Box::new(reader)))
}

impl Source {
    /// The next frame; `None` at the end.
    ///
    /// # Errors
    /// [`ReadError`] where nothing further can be read.
    pub fn next_frame(&mut self) -> Result<Option<RibFrame>, ReadError> {
        match self {
            Source::Rib(reader) => reader.next_frame(),
            Source::Model(model) => Ok(model.frame.take()),
        }
    }

    /// Takes what was said since the last call.
    pub fn take_diagnostics(&mut self) -> Vec<Diagnostic> {
        match self {
            Source::Rib(reader) => reader.take_diagnostics(),
            Source::Model(model) => std::mem::take(&mut model.said),
        }
    }

    /// What a file that has no frame lacks.
    pub fn expected(&self) -> &'static str {
        match self {
            Source::Rib(_) => "WorldBegin ... WorldEnd",
            Source::Model(_) => "faces (f)",
        }
    }
}

/// Directories given with `--search-path` must be there: a slip of the keyboard is found at once.
///
/// # Errors
/// A usage failure that names the first one that is not.
pub fn check_search_path(search_path: &[PathBuf]) -> Result<(), Failure> {
    match search_path.iter().find(|dir| !dir.is_dir()) {
        Some(dir) => {
            let message = format!("--search-path {}: expected a directory", dir.display());
            Err(Failure::new(exit::USAGE, message))
        }
        None => Ok(()),
    }
}
