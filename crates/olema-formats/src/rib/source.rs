//! Where statements come from: files, which may be compressed, and recordings.

use std::fs::File;
use std::io::{self, Cursor, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use flate2::read::MultiGzDecoder;

use super::interp::Recording;
use super::lexer::Lexer;
use super::state::AttrState;

/// State to return to after an object.
use olema::scene::Transform;

pub type Saved = (Arc<AttrState>, Transform, usize);

/// A file or a recording that is being read.
pub enum Source {
    /// A file.
    File(Box<FileSource>),
    /// A recording.
    Replay(Replay),
}

/// A file that is being read.
pub struct FileSource {
    /// Its tokens.
    pub lexer: Lexer,
    /// What messages call it.
    pub name: Arc<str>,
    /// Where it is, if it is a file.
    pub path: Option<PathBuf>,
    /// State to return to at its end.
    pub saved: Option<Saved>,
}

/// A recording that is being read.
pub struct Replay {
    /// The statements.
    pub recording: Arc<Recording>,
    /// The next one.
    pub next: usize,
    /// State to return to at its end.
    pub saved: Option<Saved>,
}

impl FileSource {
    /// A stream that may be gzip.
    pub fn new(name: &str, stream: Box<dyn Read>, path: Option<PathBuf>) -> Self {
        let lexer = Lexer::new(Box::new(Unpacked::Unknown(Some(stream))));
        FileSource { lexer, name: name.into(), path, saved: None }
    }

    /// Opens a file.
    pub fn open(path: &Path) -> io::Result<Self> {
        let file = File::open(path)?;
        // A directory opens, and reading a pipe may never end.
        if file.metadata()?.is_dir() {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "is a directory"));
        }
        let full = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        Ok(Self::new(&path.to_string_lossy(), Box::new(file), Some(full)))
    }
}

/// A stream with its first bytes put back.
type Whole = io::Chain<Cursor<Vec<u8>>, Box<dyn Read>>;

/// A stream that is looked at when it is first read: gzip is recognised by its first two bytes.
enum Unpacked {
    Unknown(Option<Box<dyn Read>>),
    Plain(Whole),
    Gzip(Box<MultiGzDecoder<Whole>>),
}

impl Read for Unpacked {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if let Unpacked::Unknown(stream) = self {
            let Some(mut stream) = stream.take() else { return Ok(0) };
            let mut magic = Vec::new();
            (&mut stream).take(2).read_to_end(&mut magic)?;
            let gzip = magic == [0x1f, 0x8b];
            let whole = Cursor::new(magic).chain(stream);
            *self = if gzip {
                Unpacked::Gzip(Box::new(MultiGzDecoder::new(whole)))
            } else {
                Unpacked::Plain(whole)
            };
        }
        match self {
            Unpacked::Unknown(_) => Ok(0),
            Unpacked::Plain(stream) => stream.read(out),
            Unpacked::Gzip(stream) => stream.read(out),
        }
    }
}

/// The files that an archive's name may stand for, in the order they are tried: beside the file that names it,
/// in the directories of the search paths, in the working directory.
pub fn candidates(name: &str, beside: Option<&Path>, paths: &[&[PathBuf]]) -> Vec<PathBuf> {
    let name = Path::new(name);
    if name.is_absolute() {
        return vec![name.to_owned()];
    }
    let beside = beside.and_then(Path::parent);
    let mut found: Vec<PathBuf> = beside.map(|d| d.join(name)).into_iter().collect();
    for path in paths.iter().copied().flatten() {
        if let (Some(beside), true) = (beside, path.is_relative()) {
            found.push(beside.join(path).join(name));
        }
        found.push(path.join(name));
    }
    found.push(name.to_owned());
    found
}
