//! Readers and writers for Olema: RIB scenes in, image files out.
//!
//! Scene files are untrusted: nothing here starts a program, writes a file that the caller did not name, or
//! lets an input decide how much memory is used.

pub mod diagnostic;
pub mod image_file;
pub mod obj;
pub mod rib;
mod room;

pub use diagnostic::{Diagnostic, ReadError, Severity};
