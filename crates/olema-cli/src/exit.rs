//! Exit codes, the same for all subcommands and documented in the README.

use olema::Error;

/// Everything was done.
pub const OK: u8 = 0;
/// A picture could not be rendered or written; for `diff`: the pictures differ.
pub const RENDER: u8 = 1;
/// The arguments make no sense (clap uses the same number).
pub const USAGE: u8 = 2;
/// A scene or an asset is missing or wrong.
pub const SCENE: u8 = 3;
/// Out of memory.
pub const MEMORY: u8 = 4;
/// 128 + the signal's number is the convention of shells: 130 for Ctrl-C, 143 for a polite `kill`.
pub const SIGNAL: u8 = 128;

/// Something went wrong: what to say and how to exit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure {
    /// Exit code.
    pub code: u8,
    /// One sentence, without "error:".
    pub message: String,
}

impl Failure {
    /// A failure with this code and sentence.
    pub fn new(code: u8, message: impl Into<String>) -> Self {
        Failure { code, message: message.into() }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        let code = match error {
            // What the options may say was checked before: such a value came from the scene.
            Error::Setting { .. } | Error::Scene { .. } | Error::Shader(_) => SCENE,
            Error::Memory { .. } => MEMORY,
            _ => RENDER,
        };
        Failure::new(code, error.to_string())
    }
}
