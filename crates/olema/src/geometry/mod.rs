//! Surfaces as functions of (u, v).

pub mod subdivision;
