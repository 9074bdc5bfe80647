//! The standard scenes of `olema bench`.
//!
//! In: a name. Out: a scene and its settings, as a reader of files gives them. All but the army are RIB, written
//! in memory and read as a file is, so that reading counts.
//!
//! The models are framed alike: 800 x 600, 40 degrees wide, 4 x 4 samples, shading rate 1, gaussian 2 x 2, the eye
//! 2.6 radii from the middle of the bounding sphere, plastic with one ambient and two distant lights. `-blur`
//! adds motion and a lens: the points turn by 12 degrees between two keys, DepthOfField has f-stop 1, focal length
//! 0.06 d and focus at 0.85 d, d being the distance.

use olema::Scene;
use olema::Settings;
use olema::image::{Filter, FilterKind};
use olema::standard::crowds;

use super::rib;
use super::text::Text;

/// A standard scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Standard {
    /// What it is called.
    pub name: &'static str,
    /// Width and height in pixels.
    pub resolution: [u32; 2],
    /// Samples a pixel on a side.
    pub samples: u32,
    /// What is drawn.
    pub what: What,
}

/// What is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum What {
    /// The torus on which renderers are compared.
    Torus(Blur),
    /// A model, framed as all models are, and whether it moves and is out of focus.
    Model(Model, bool),
    /// The army of the occlusion scenes, built by code.
    Army,
}

/// Motion and lens.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Blur {
    /// Whether it moves.
    pub motion: bool,
    /// Whether it is out of focus.
    pub lens: bool,
}

/// Surfaces that are framed alike.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// 32 bicubic patches.
    Teapot,
    /// 11,532 bicubic patches.
    Creature,
    /// A subdivision mesh of 1,575 faces and 315 creases.
    Tyre,
    /// The tyre with a displacement shader.
    Displaced,
}

const STILL: Blur = Blur { motion: false, lens: false };
const MOTION: Blur = Blur { motion: true, lens: false };
const LENS: Blur = Blur { motion: false, lens: true };
const BOTH: Blur = Blur { motion: true, lens: true };
const SMALL: [u32; 2] = [800, 600];
const LARGE: [u32; 2] = [1600, 1200];

const fn torus(name: &'static str, resolution: [u32; 2], samples: u32, blur: Blur) -> Standard {
    Standard { name, resolution, samples, what: What::Torus(blur) }
}

const fn model(name: &'static str, model: Model, blurred: bool) -> Standard {
    Standard { name, resolution: SMALL, samples: 4, what: What::Model(model, blurred) }
}

/// All of them, in the order in which they are run.
pub const ALL: [Standard; 23] = [
    torus("torus-still-4-800", SMALL, 2, STILL),
    torus("torus-motion-16-800", SMALL, 4, MOTION),
    torus("torus-lens-16-800", SMALL, 4, LENS),
    torus("torus-both-16-800", SMALL, 4, BOTH),
    torus("torus-motion-64-800", SMALL, 8, MOTION),
    torus("torus-lens-64-800", SMALL, 8, LENS),
    torus("torus-both-64-800", SMALL, 8, BOTH),
    torus("torus-still-4-1600", LARGE, 2, STILL),
    torus("torus-motion-16-1600", LARGE, 4, MOTION),
    torus("torus-lens-16-1600", LARGE, 4, LENS),
    torus("torus-both-16-1600", LARGE, 4, BOTH),
    torus("torus-motion-64-1600", LARGE, 8, MOTION),
    torus("torus-lens-64-1600", LARGE, 8, LENS),
    torus("torus-both-64-1600", LARGE, 8, BOTH),
    model("displaced", Model::Displaced, false),
    model("displaced-blur", Model::Displaced, true),
    model("creature", Model::Creature, false),
    model("creature-blur", Model::Creature, true),
    model("creased", Model::Tyre, false),
    model("creased-blur", Model::Tyre, true),
    model("teapot", Model::Teapot, false),
    model("teapot-blur", Model::Teapot, true),
    Standard { name: "army", resolution: crowds::RESOLUTION, samples: 4, what: What::Army },
];

/// The scenes that a word means: the one of that name, or all whose names begin with it and a hyphen.
pub fn named(word: &str) -> Vec<Standard> {
    let begins = |name: &str| name.strip_prefix(word).is_some_and(|rest| rest.starts_with('-'));
    match ALL.iter().find(|scene| scene.name == word) {
        Some(scene) => vec![*scene],
        None => ALL.iter().filter(|scene| begins(scene.name)).copied().collect(),
    }
}

/// What a scene is made of.
pub enum Source {
    /// A text to read.
    Rib(Text),
    /// A scene built by code, and its settings.
    Built(Box<(Scene, Settings)>),
}

impl Standard {
    /// The scene at a size that takes no time to speak of.
    pub fn quick(self) -> Self {
        Standard { resolution: self.resolution.map(|px| px / 20), ..self }
    }

    /// What it is made of.
    pub fn source(&self) -> Source {
        match self.what {
            What::Torus(blur) => Source::Rib(rib::torus(self.resolution, self.samples, blur)),
            What::Model(model, blurred) => {
                Source::Rib(rib::model(model, self.resolution, self.samples, blurred))
            }
            What::Army => {
                let filter = Filter { kind: FilterKind::Box, width: [1.0; 2] };
                let settings = Settings { resolution: self.resolution, filter, ..crowds::settings() };
                Source::Built(Box::new((crowds::army(350.0), settings)))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_means_one_scene_or_a_group() {
        let names = |word| named(word).iter().map(|s| s.name).collect::<Vec<_>>();
        assert_eq!(names("teapot"), ["teapot"]);
        assert_eq!(names("torus").len(), 14);
        assert_eq!(names("torus-both-64").len(), 2);
        assert!(names("tea").is_empty() && names("").is_empty());
    }

    #[test]
    fn names_are_distinct() {
        let names: std::collections::HashSet<_> = ALL.iter().map(|s| s.name).collect();
        assert_eq!(names.len(), ALL.len());
    }
}
