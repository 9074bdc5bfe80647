//! Standard scenes: what renderers are tested with, measured on and compared by.
//!
//! In: nothing, or how large and how fast. Out: scenes, or the points of their surfaces. The command's bench, the
//! tests and the experiments draw the same ones from here.

pub mod build;
pub mod crowds;
pub mod teapot;
pub mod torus;
