//! What the moving scenes to measure occlusion culling on are like.
//!
//! In: nothing, or how far things move. Out: the scenes of [`olema::standard::crowds`], and [`measure`].

pub use olema::standard::crowds::{RESOLUTION, army, city, open, settings, sticks};

mod measure;
pub use measure::{Measured, measure};

#[cfg(test)]
mod tests {
    use olema::Scene;

    use super::*;

    /// Small pictures have the same depth complexity, and motion is stated for 1080p.
    fn check(scene: &Scene, complexity: f64, motion_px: f64) {
        scene.validate().expect("a correct scene");
        assert!((300..20_000).contains(&scene.primitives.len()), "{}", scene.primitives.len());
        let measured = measure(scene, [240, 135]).expect("a correct scene");
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 0.15;
        assert!(near(measured.depth_complexity, complexity), "{measured:?}, expected {complexity}");
        assert!(near(measured.motion_px, motion_px), "{measured:?}, expected {motion_px} px");
    }

    #[test]
    fn scenes_have_the_papers_motion_and_depth_complexity() {
        check(&army(350.0), 11.0, 350.0);
        check(&sticks(40.0), 4.0, 40.0);
        check(&city(10.0), 6.0, 10.0);
    }

    #[test]
    fn motion_is_as_asked_for() {
        let mean = |scene: &Scene| measure(scene, [120, 68]).expect("a correct scene").motion_px;
        let (slow, fast) = (mean(&army(350.0)), mean(&army(1300.0)));
        assert!((fast / slow / (1300.0 / 350.0) - 1.0).abs() < 0.25, "{slow} and {fast} px");
        assert_eq!(mean(&sticks(0.0)), 0.0);
    }
}
