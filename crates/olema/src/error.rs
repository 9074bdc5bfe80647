//! What can go wrong in the library, as one type.

/// An error of the renderer itself. Readers have their own, with file, line and column.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A setting is outside its range; nothing was rendered.
    #[error("{what} is {found}: expected {expected}")]
    Setting {
        /// The setting's name, as the command line spells it.
        what: &'static str,
        /// The value that was given.
        found: String,
        /// What would have been accepted.
        expected: String,
    },
    /// The scene contradicts itself (for example a point array of the wrong length).
    #[error("{object}: {problem}")]
    Scene {
        /// The primitive's name, or what stands for it.
        object: String,
        /// What is wrong and what was expected.
        problem: String,
    },
    /// A shader of that name does not exist, or a parameter has the wrong type.
    #[error("{0}")]
    Shader(String),
    /// The picture does not fit the memory that was granted.
    #[error("out of memory: {needed} bytes are needed for {what}, {granted} are granted")]
    Memory {
        /// What the memory is for.
        what: &'static str,
        /// Bytes needed.
        needed: u64,
        /// Bytes granted.
        granted: u64,
    },
    /// The system refused the worker threads.
    #[error("worker threads could not be started: {0}")]
    Threads(String),
    /// The cancel token was set before the picture was finished.
    #[error("cancelled")]
    Cancelled,
}
