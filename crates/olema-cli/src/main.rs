//! The command `olema`.
fn main() {}
