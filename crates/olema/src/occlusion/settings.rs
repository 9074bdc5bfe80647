//! What is culled, where, and how finely: plain data, with the words the command line knows it by.
//!
//! In: words. Out: [`CullSettings`], checked by [`CullSettings::validate`]. No value of them changes a bit of
//! the picture; they trade depth reads and memory for geometry that is not made.

use std::fmt;
use std::str::FromStr;

use crate::error::Error;

/// Which hierarchy of depths tells what is hidden.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum CullKind {
    /// None: all that is in the frame is drawn.
    None,
    /// A z-pyramid: one slice of time.
    Z,
    /// A tz-pyramid: a tree of slices in each node.
    #[default]
    Tz,
    /// A z-pyramid for each slice: the tz-pyramid without the inner nodes of its trees.
    Slice,
}

impl CullKind {
    const WORDS: [(&'static str, CullKind); 4] =
        [("none", CullKind::None), ("z", CullKind::Z), ("tz", CullKind::Tz), ("slice", CullKind::Slice)];
}

impl fmt::Display for CullKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(word_of(&Self::WORDS, self))
    }
}

impl FromStr for CullKind {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        by_word(&Self::WORDS, s).ok_or_else(|| "expected none, z, tz or slice".to_owned())
    }
}

/// What samples are put into slices by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum CullOrder {
    /// Time.
    Time,
    /// Place on the lens.
    Lens,
    /// Both are kept where the camera has a lens, and each query takes the one that makes its box smaller.
    #[default]
    Auto,
}

impl CullOrder {
    const WORDS: [(&'static str, CullOrder); 3] =
        [("time", CullOrder::Time), ("lens", CullOrder::Lens), ("auto", CullOrder::Auto)];
}

impl fmt::Display for CullOrder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(word_of(&Self::WORDS, self))
    }
}

impl FromStr for CullOrder {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        by_word(&Self::WORDS, s).ok_or_else(|| "expected time, lens or auto".to_owned())
    }
}

/// The stages before which a sub-patch is looked up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct CullPlaces {
    /// Before a sub-patch is split.
    pub split: bool,
    /// Before it is diced.
    pub dice: bool,
    /// Before its grid is shaded, with the bounds of the displaced vertices.
    pub shade: bool,
}

impl Default for CullPlaces {
    fn default() -> Self {
        CullPlaces { split: true, dice: true, shade: true }
    }
}

impl fmt::Display for CullPlaces {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words = [("split", self.split), ("dice", self.dice), ("shade", self.shade)];
        let on: Vec<&str> = words.iter().filter(|(_, on)| *on).map(|(word, _)| *word).collect();
        f.pad(&if on.is_empty() { "none".to_owned() } else { on.join(",") })
    }
}

impl FromStr for CullPlaces {
    type Err = String;

    /// `split`, `dice` and `shade` with commas between, in any order; or `none`.
    fn from_str(s: &str) -> Result<Self, String> {
        let mut places = CullPlaces { split: false, dice: false, shade: false };
        if s == "none" {
            return Ok(places);
        }
        for word in s.split(',') {
            match word {
                "split" => places.split = true,
                "dice" => places.dice = true,
                "shade" => places.shade = true,
                _ => return Err("expected split, dice and shade with commas between, or none".to_owned()),
            }
        }
        Ok(places)
    }
}

/// Occlusion culling.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct CullSettings {
    /// Which hierarchy.
    pub kind: CullKind,
    /// Where it is asked.
    pub at: CullPlaces,
    /// Side of a spatial leaf in pixels: 2, 4, 8 or 16.
    pub leaf_px: u32,
    /// Slices of time (or lens): 64, 16, 4 or 1. A z-pyramid has one whatever this says.
    pub slices: u32,
    /// What the slices order.
    pub order: CullOrder,
}

impl Default for CullSettings {
    /// The tz-pyramid at every place, with all slices. Leaves of 4 pixels cull nearly as much as those of 2, and
    /// cost less.
    fn default() -> Self {
        CullSettings {
            kind: CullKind::default(),
            at: CullPlaces::default(),
            leaf_px: 4,
            slices: 64,
            order: CullOrder::default(),
        }
    }
}

impl CullSettings {
    /// Leaf sides that are allowed.
    pub const LEAVES_PX: [u32; 4] = [2, 4, 8, 16];
    /// Numbers of slices that are allowed.
    pub const SLICES: [u32; 4] = [64, 16, 4, 1];

    /// Slices that the hierarchy has.
    pub fn num_slices(&self) -> u32 {
        if self.kind == CullKind::Z { 1 } else { self.slices }
    }

    /// Checks every range.
    ///
    /// # Errors
    /// [`Error::Setting`] names the first field outside its range.
    pub fn validate(&self) -> Result<(), Error> {
        let fail = |what, found: u32, expected: &str| {
            Err(Error::Setting { what, found: found.to_string(), expected: expected.to_owned() })
        };
        if !Self::LEAVES_PX.contains(&self.leaf_px) {
            return fail("cull leaf", self.leaf_px, "2, 4, 8 or 16 pixels");
        }
        if !Self::SLICES.contains(&self.slices) {
            return fail("cull slices", self.slices, "64, 16, 4 or 1");
        }
        Ok(())
    }
}

/// The value of a word.
pub(crate) fn by_word<T: Copy>(words: &[(&str, T)], s: &str) -> Option<T> {
    words.iter().find(|(word, _)| *word == s).map(|(_, value)| *value)
}

/// The word of a value.
pub(crate) fn word_of<T: PartialEq>(words: &[(&'static str, T)], value: &T) -> &'static str {
    words.iter().find(|(_, v)| v == value).map_or("", |(word, _)| *word)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_read_as_they_are_written() {
        for (word, kind) in CullKind::WORDS {
            assert_eq!((kind.to_string().as_str(), word.parse()), (word, Ok(kind)));
        }
        for (word, order) in CullOrder::WORDS {
            assert_eq!((order.to_string().as_str(), word.parse()), (word, Ok(order)));
        }
        for bits in 0..8 {
            let places = CullPlaces { split: bits & 1 > 0, dice: bits & 2 > 0, shade: bits & 4 > 0 };
            assert_eq!(places.to_string().parse(), Ok(places));
        }
        assert_eq!("shade,split".parse(), Ok(CullPlaces { split: true, dice: false, shade: true }));
        for wrong in ["", "TZ", "tz,slice", "zbuffer"] {
            assert_eq!(wrong.parse::<CullKind>(), Err("expected none, z, tz or slice".to_owned()));
        }
        for wrong in ["", "split,", "dicing", "none,split"] {
            assert!(wrong.parse::<CullPlaces>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn only_the_papers_sizes_are_allowed() {
        assert_eq!(CullSettings::default().validate(), Ok(()));
        for leaf_px in 0..40 {
            let settings = CullSettings { leaf_px, ..CullSettings::default() };
            assert_eq!(settings.validate().is_ok(), [2, 4, 8, 16].contains(&leaf_px), "{leaf_px}");
        }
        for slices in 0..140 {
            let settings = CullSettings { slices, ..CullSettings::default() };
            assert_eq!(settings.validate().is_ok(), [1, 4, 16, 64].contains(&slices), "{slices}");
        }
        let z = CullSettings { kind: CullKind::Z, ..CullSettings::default() };
        assert_eq!(z.num_slices(), 1);
    }
}
