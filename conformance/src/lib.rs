//! Scenes, comparisons, goldens and benches shared by the tests of all engines.
//! (in work)

pub mod shapes;
