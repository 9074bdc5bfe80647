//! What `olema info` tells of time and lens: the shutter, what moves and when, the depth of field.

use std::collections::BTreeMap;

use olema::Scene;
use olema::scene::{Camera, Geometry, Lens, Primitive};
use serde::Serialize;

/// Most names of things that move; the others are counted.
const MAX_NAMES: usize = 100;
/// Most names and times in a line of prose.
const MAX_SHOWN: usize = 8;

/// The shutter.
#[derive(Debug, Serialize)]
pub struct ShutterInfo {
    open: f32,
    close: f32,
    /// Parts of the time between at which it is fully open, and begins to close.
    opening: [f32; 2],
}

/// The lens, as `DepthOfField` and the aperture have it.
#[derive(Debug, Serialize)]
pub struct LensInfo {
    fstop: f32,
    focal_length: f32,
    focal_distance: f32,
    /// Straight sides; 0 is round.
    blades: u32,
    /// Degrees.
    blade_angle: f32,
}

/// What moves.
#[derive(Debug, Default, Serialize)]
pub struct MotionInfo {
    /// Key times of all that moves, ascending.
    times: Vec<f32>,
    /// Primitives that move.
    primitives: u64,
    /// Names of things that move, and how many have each.
    objects: BTreeMap<String, u64>,
    /// Things whose names are not listed any more.
    others: u64,
}

impl ShutterInfo {
    pub fn new(camera: &Camera) -> Self {
        let [open, close] = camera.shutter;
        ShutterInfo { open, close, opening: camera.shutter_opening }
    }

    /// The line after "shutter".
    pub fn prose(&self) -> String {
        let ShutterInfo { open, close, opening: [full, closing] } = self;
        if open == close {
            return format!("at {open}, still");
        }
        match [*full, *closing] {
            [0.0, 1.0] => format!("{open} to {close}"),
            _ => format!("{open} to {close}, opening for {full} of the time, closing from {closing} of it"),
        }
    }
}

impl LensInfo {
    /// The lens; none for a pinhole.
    pub fn new(camera: &Camera) -> Option<Self> {
        let Lens { fstop, focal_length, focal_distance, blades, blade_angle } = camera.lens?;
        let blades = if blades < 3 { 0 } else { blades };
        Some(LensInfo { fstop, focal_length, focal_distance, blades, blade_angle })
    }

    /// The line after "lens".
    pub fn prose(&self) -> String {
        let LensInfo { fstop, focal_length, focal_distance, blades, blade_angle } = self;
        let shape = match blades {
            0 => "round".to_owned(),
            _ => format!("{blades} blades at {blade_angle} degrees"),
        };
        format!("f/{fstop}, focal length {focal_length}, focused at {focal_distance}, {shape}")
    }
}

impl MotionInfo {
    pub fn new(scene: &Scene) -> Self {
        let mut info = MotionInfo::default();
        if !scene.camera.world_to_camera.is_still() {
            info.add("camera", &scene.camera.world_to_camera.times());
        }
        for light in scene.lights.iter().filter(|light| !light.to_world.is_still()) {
            info.add(light.shader.name(), &light.to_world.times());
        }
        for primitive in &scene.primitives {
            let times = key_times(primitive);
            if times.is_empty() {
                continue;
            }
            info.primitives += 1;
            let name = &primitive.attributes.name;
            if name.is_empty() {
                info.add(&primitive.origin.to_string(), &times);
            } else {
                info.add(name, &times);
            }
        }
        info
    }

    fn add(&mut self, name: &str, times: &[f32]) {
        if times.iter().any(|time| self.times.binary_search_by(|t| t.total_cmp(time)).is_err()) {
            self.times.extend_from_slice(times);
            self.times.sort_by(f32::total_cmp);
            self.times.dedup();
        }
        let full = self.objects.len() >= MAX_NAMES;
        match self.objects.get_mut(name) {
            Some(count) => *count += 1,
            None if full => self.others += 1,
            None => {
                self.objects.insert(name.to_owned(), 1);
            }
        }
    }

    /// The line after "motion", in a scene of that many primitives.
    pub fn prose(&self, num_primitives: usize) -> String {
        if self.objects.is_empty() {
            return "none".to_owned();
        }
        let times: Vec<String> = self.times.iter().map(f32::to_string).collect();
        let times = match times.as_slice() {
            few if few.len() <= MAX_SHOWN => few.join(", "),
            [first, .., last] => format!("{} times from {first} to {last}", times.len()),
            _ => String::new(),
        };
        let name = |(name, count): (&String, &u64)| match count {
            1 => name.clone(),
            _ => format!("{name} ({count})"),
        };
        let mut names: Vec<String> = self.objects.iter().take(MAX_SHOWN).map(name).collect();
        let shown: u64 = self.objects.values().take(MAX_SHOWN).sum();
        let more = self.objects.values().sum::<u64>() + self.others - shown;
        if more > 0 {
            names.push(format!("{more} more"));
        }
        let count = self.primitives;
        format!("{count} of {num_primitives} primitives; {}; keys at {times}", names.join(", "))
    }
}

/// Key times of a primitive and its points; none where both stand still.
fn key_times(primitive: &Primitive) -> Vec<f32> {
    let mut times = Vec::new();
    if !primitive.to_world.is_still() {
        times = primitive.to_world.times();
    }
    match &primitive.geometry {
        Geometry::Patches(mesh) if !mesh.points.is_still() => times.extend(&mesh.points.times),
        Geometry::Subdivision(mesh) if !mesh.points.is_still() => times.extend(&mesh.points.times),
        _ => {}
    }
    times
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shutter_and_lens_are_told_in_a_line() {
        let mut camera = Camera::default();
        assert_eq!(
            (ShutterInfo::new(&camera).prose().as_str(), LensInfo::new(&camera).is_none()),
            ("at 0, still", true)
        );
        camera.shutter = [0.0, 0.5];
        assert_eq!(ShutterInfo::new(&camera).prose(), "0 to 0.5");
        camera.shutter_opening = [0.25, 0.5];
        assert_eq!(
            ShutterInfo::new(&camera).prose(),
            "0 to 0.5, opening for 0.25 of the time, closing from 0.5 of it"
        );
        camera.lens = Some(Lens::new(2.8, 1.0, 10.0));
        let prose = |camera: &Camera| LensInfo::new(camera).expect("a lens").prose();
        assert_eq!(prose(&camera), "f/2.8, focal length 1, focused at 10, round");
        camera.lens = Some(Lens { blades: 5, blade_angle: 18.0, ..Lens::new(2.8, 1.0, 10.0) });
        assert_eq!(prose(&camera), "f/2.8, focal length 1, focused at 10, 5 blades at 18 degrees");
    }

    #[test]
    fn of_many_things_that_move_the_first_are_named() {
        let mut info = MotionInfo::default();
        assert_eq!(info.prose(3), "none");
        for n in 0..300u16 {
            info.add(&format!("a.rib:{n:03}"), &[0.0, f32::from(n)]);
        }
        info.add("a.rib:001", &[0.0, 1.0]);
        info.primitives = 301;
        assert_eq!((info.objects.len(), info.others, info.times.len()), (100, 200, 300));
        let prose = info.prose(400);
        assert!(prose.starts_with("301 of 400 primitives; a.rib:000, a.rib:001 (2), a.rib:002"), "{prose}");
        assert!(prose.ends_with("a.rib:007, 292 more; keys at 300 times from 0 to 299"), "{prose}");
    }
}
