//! Statements to scenes: what each statement does to the graphics state and the world.
//!
//! In: a statement with its checked arguments, from a file or from a recording. Out: a [`Flow`], which tells the
//! reader to go on, to read something else first, or to hand a frame out. The interpreter knows nothing of files.

mod attributes;
mod blocks;
mod detail;
mod displacement;
mod frame;
mod hider;
mod mesh_tags;
mod meshes;
mod motion;
mod options;
mod record;
mod shading;
mod spin;
mod surfaces;
mod transforms;
mod undrawn;

use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Weak};

use olema::Scene;
use olema::scene::{Attributes, PatchKind, Transform};
use olema::shading::TextureImage;

use super::RibFrame;
use super::args::Args;
use super::declare::Dictionary;
use super::fault::{Fault, Pos};
use super::shaders::ShaderLibrary;
use super::state::{AttrState, Block, BlockKind, Handle, Names, OptionState, Site};
use super::statements::{self, Id, Place, Statement, Support};
use super::values::Value;
use crate::room::Room;
use motion::Motion;
use record::Recorder;
pub use record::{Geometries, Recorded, Recording};

/// Most blocks open at a time.
const MAX_BLOCKS: usize = 1000;
/// Most times in a motion block.
const MAX_TIMES: usize = 128;
/// Most motion blocks in the current transformation.
const MAX_MOVING: usize = 256;
/// Most keys in the current transformation, over all motion blocks.
const MAX_KEYS: usize = 8192;
/// Most named spaces.
const MAX_SPACES: usize = 4096;
/// Most displays, and kinds of quantization.
const MAX_DISPLAYS: usize = 256;

/// What the reader does next.
#[derive(Debug)]
pub enum Flow {
    /// The next statement.
    Next,
    /// Hand this out.
    Frame(Box<RibFrame>),
    /// Read that archive first.
    Archive {
        /// Its name.
        name: String,
        /// As for [`Flow::Replay`].
        is_object: bool,
    },
    /// Give that image to [`Interp::textures`], or say why not, and run the statement again.
    Texture {
        /// Its name.
        name: String,
    },
    /// Read that recording first; an object's leaves the state as it was.
    Replay {
        /// The statements.
        recording: Arc<Recording>,
        /// Whether the state is returned to afterwards.
        is_object: bool,
    },
}

/// One statement to run.
#[derive(Clone, Copy)]
pub struct Call<'a> {
    /// Its line of the table.
    pub statement: &'static Statement,
    /// Its values.
    pub args: &'a Args,
    /// Where it stands.
    pub site: &'a Site,
    /// Where its geometry is kept, if it is run from a recording.
    pub geometries: Option<&'a Geometries>,
}

/// The world that is being described.
pub(super) struct World {
    pub scene: Scene,
}

/// The graphics state and everything that statements change.
pub struct Interp {
    pub(super) options: Arc<OptionState>,
    pub(super) attrs: Arc<AttrState>,
    /// What the last primitive carries, and the state that it was made from.
    pub(super) last_look: Option<(Weak<AttrState>, Arc<Attributes>)>,
    /// What the last sheet was.
    pub(super) last_kind: Option<Arc<PatchKind>>,
    pub(super) ctm: Transform,
    pub(super) blocks: Vec<Block>,
    /// Blocks below this one are not the current object's to close.
    pub(super) floor: usize,
    pub(super) dictionary: Dictionary,
    pub(super) room: Room,
    /// What was said and not yet given a file name.
    pub(super) said: Vec<Fault>,
    pub(super) names: Names,
    pub(super) world: Option<World>,
    pub(super) frame_number: Option<i32>,
    pub(super) objects: HashMap<Handle, Arc<Recording>>,
    pub(super) archives: HashMap<String, Arc<Recording>>,
    /// Bytes that stay from frame to frame.
    pub(super) kept: u64,
    pub(super) recorder: Option<Recorder>,
    pub(super) motion: Option<Motion>,
    /// What is not drawn: first place, and how often.
    pub(super) tally: BTreeMap<&'static str, (Site, u64)>,
    pub(super) library: Arc<dyn ShaderLibrary>,
    /// Images for the statement that is run, by name.
    pub(super) textures: HashMap<String, Result<Arc<TextureImage>, String>>,
}

impl Interp {
    /// The standard's initial state.
    pub fn new(memory: u64, library: Arc<dyn ShaderLibrary>) -> Self {
        Interp {
            options: Arc::default(),
            attrs: Arc::new(AttrState::new(library.default_surface())),
            last_look: None,
            last_kind: None,
            ctm: Transform::default(),
            blocks: Vec::new(),
            floor: 0,
            dictionary: Dictionary::default(),
            room: Room::new(memory),
            said: Vec::new(),
            names: Names::default(),
            world: None,
            frame_number: None,
            objects: HashMap::new(),
            archives: HashMap::new(),
            kept: 0,
            recorder: None,
            motion: None,
            tally: BTreeMap::new(),
            library,
            textures: HashMap::new(),
        }
    }

    /// Runs one statement.
    ///
    /// # Errors
    /// What is wrong with it; the state is then as before it.
    pub fn run(&mut self, call: Call<'_>) -> Result<Flow, Fault> {
        if self.recorder.is_some() {
            return self.record(call);
        }
        if !self.check_place(&call)? {
            return Ok(Flow::Next);
        }
        self.hold_args(&call)?;
        if self.motion.is_some() {
            return self.run_in_motion(call);
        }
        self.dispatch(call)
    }

    /// Whether the statement may stand here, or makes sense nevertheless.
    fn check_place(&mut self, call: &Call<'_>) -> Result<bool, Fault> {
        let statement = call.statement;
        let (name, pos) = (statement.name, call.site.pos);
        match (statement.place, self.world.is_some()) {
            (Place::Any, _) | (Place::Options, false) | (Place::World, true) => Ok(true),
            (Place::Options, true) => {
                self.say(Fault::warning(
                    pos,
                    format!("{name} in a world: expected before WorldBegin; ignored"),
                ));
                Ok(false)
            }
            (Place::World, false) if matches!(statement.id, Id::WorldEnd | Id::SolidEnd) => Ok(true),
            (Place::World, false) => {
                self.count("a primitive outside WorldBegin and WorldEnd belongs to no picture", call.site);
                Ok(matches!(statement.id, Id::SolidBegin))
            }
        }
    }

    /// Charges what a statement other than a drawn primitive leaves behind in the state.
    fn hold_args(&mut self, call: &Call<'_>) -> Result<(), Fault> {
        let state =
            matches!(call.statement.support, Support::State) || call.statement.place == Place::Options;
        let keeps = matches!(
            call.statement.id,
            Id::LightSource | Id::AreaLightSource | Id::Surface | Id::Displacement | Id::Imager
        );
        if !(state || keeps) {
            return Ok(());
        }
        let bytes = call.args.heap_bytes() + 64;
        self.hold(call.site.pos, bytes)?;
        if self.world.is_none() {
            self.kept = self.kept.saturating_add(bytes);
        }
        Ok(())
    }

    fn hold(&mut self, pos: Pos, bytes: u64) -> Result<(), Fault> {
        self.room.hold(bytes).map_err(|full| {
            let limit = full.limit;
            let message = format!("the {limit} bytes granted for a frame are used up: expected less data");
            Fault::error(pos, message)
        })
    }

    fn dispatch(&mut self, call: Call<'_>) -> Result<Flow, Fault> {
        match call.statement.id {
            Id::ArchiveBegin | Id::ObjectBegin => self.begin_recording(&call)?,
            Id::ObjectInstance => return self.instance(&call),
            Id::ReadArchive | Id::Procedural => return self.archive(&call),
            Id::WorldEnd => return self.world_end(&call),
            Id::Displacement => return Ok(self.displacement(&call)),
            id if is_surface(id) => self.geometry(&call)?,
            id if is_transform(id) => self.transform(&call)?,
            id if is_shader(id) => self.shader(&call)?,
            _ => self.dispatch_state(&call)?,
        }
        Ok(Flow::Next)
    }

    fn dispatch_state(&mut self, call: &Call<'_>) -> Result<(), Fault> {
        let statement = call.statement;
        if self.block(call)? || self.option(call)? || self.attribute(call)? || self.undrawn(call)? {
            return Ok(());
        }
        match statement.support {
            Support::Warned => {
                let remark = statement.remark;
                self.say(Fault::warning(
                    call.site.pos,
                    format!("{} has no effect: {remark}", statement.name),
                ));
            }
            Support::NotYet => self.count(statement.name, call.site),
            _ => {}
        }
        Ok(())
    }

    /// Replaces the shaders' source; for the beginning only, for it sets the attributes back.
    pub fn set_library(&mut self, library: Arc<dyn ShaderLibrary>) {
        self.attrs = Arc::new(AttrState::new(library.default_surface()));
        self.library = library;
    }

    /// Whether statements are recorded instead of run.
    pub fn is_recording(&self) -> bool {
        self.recorder.is_some()
    }

    /// The statement that would end the current recording, and the line it began at.
    pub fn open_recording(&self) -> Option<(&'static str, u32)> {
        self.recorder.as_ref().map(|r| (r.end_name(), r.pos.line))
    }

    /// Takes what was counted, a sentence each.
    pub fn take_notes(&mut self) -> Vec<(Site, String)> {
        let tally = std::mem::take(&mut self.tally);
        let sentence = |(what, (site, times)): (&str, (Site, u64))| {
            let what = match statements::find(what) {
                Some(_) => format!("{what} is not drawn yet"),
                None => what.to_owned(),
            };
            let times = if times == 1 { String::new() } else { format!(" ({times} times, here first)") };
            (site, what + &times)
        };
        let mut notes: Vec<_> = tally.into_iter().map(sentence).collect();
        notes.sort_by_key(|(site, _)| (site.file.clone(), site.pos.offset));
        notes
    }

    /// Says something.
    pub(super) fn say(&mut self, fault: Fault) {
        self.said.push(fault);
    }

    /// Counts something that is not drawn; a note at the end of the frame says it once.
    pub(super) fn count(&mut self, what: &'static str, site: &Site) {
        let entry = self.tally.entry(what).or_insert_with(|| (site.clone(), 0));
        entry.1 += 1;
    }

    /// Whether a block of that kind is open.
    pub(super) fn is_open(&self, kind: BlockKind) -> bool {
        self.blocks.iter().any(|b| b.kind == kind)
    }

    /// The value of a condition's variable.
    pub fn variable(&self, name: &str) -> Option<Value> {
        if matches!(name, "Frame" | "frame") {
            return self.frame_number.map(|n| Value::Num(f64::from(n)));
        }
        let option = |name: &str| self.options.values.get(name).cloned();
        let attribute = |name: &str| self.attrs.values.get(name).cloned();
        if let Some(rest) = name.strip_prefix("Option:") {
            return option(rest);
        }
        if let Some(rest) = name.strip_prefix("Attribute:") {
            return attribute(rest);
        }
        attribute(name).or_else(|| option(name))
    }
}

/// Whether a statement changes the current transformation.
fn is_transform(id: Id) -> bool {
    use Id::{
        ConcatTransform, CoordSysTransform, Identity, Perspective, Rotate, Scale, Skew, Transform, Translate,
    };
    matches!(
        id,
        ConcatTransform
            | CoordSysTransform
            | Identity
            | Perspective
            | Rotate
            | Scale
            | Skew
            | Transform
            | Translate
    )
}

/// Whether a statement is a surface that is drawn.
fn is_surface(id: Id) -> bool {
    matches!(id, Id::Patch | Id::PatchMesh | Id::SubdivisionMesh | Id::HierarchicalSubdivisionMesh)
}

/// Whether a statement names a shader.
fn is_shader(id: Id) -> bool {
    use Id::{AreaLightSource, Atmosphere, Deformation, Exterior, Illuminate, Imager, Interior};
    matches!(
        id,
        Id::Surface
            | Id::LightSource
            | AreaLightSource
            | Atmosphere
            | Deformation
            | Exterior
            | Illuminate
            | Imager
            | Interior
    )
}
