//! Opens scenes that are named on the command line; `-` is standard input.

use std::path::{Path, PathBuf};

use olema_formats::rib::{ReadError, ReadOptions, RibReader};

use crate::exit::{self, Failure};

/// Opens a scene.
///
/// # Errors
/// [`ReadError`] where it cannot be opened.
pub fn open(file: &Path, search_path: &[PathBuf]) -> Result<RibReader, ReadError> {
    let options = ReadOptions { search_path: search_path.to_vec(), ..ReadOptions::default() };
    if file == Path::new("-") {
        Ok(RibReader::from_stream("-", Box::new(std::io::stdin()), options))
    } else {
        RibReader::open(file, options)
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
