//! Blocks: what they save, and what closes them.

use super::super::fault::Fault;
use super::super::source::Saved;
use super::super::state::{Block, BlockKind, Site};
use super::super::statements::Id;
use super::{Call, Flow, Interp, MAX_BLOCKS};
use olema::scene::Transform;

impl Interp {
    /// Runs a statement that opens or closes a block; `false` where it is another one.
    pub(super) fn block(&mut self, call: &Call<'_>) -> Result<bool, Fault> {
        match call.statement.id {
            Id::FrameBegin => self.frame_begin(call)?,
            Id::WorldBegin => self.world_begin(call)?,
            Id::AttributeBegin => self.open(BlockKind::Attribute, call)?,
            Id::TransformBegin => self.open(BlockKind::Transform, call)?,
            Id::SolidBegin => {
                self.open(BlockKind::Solid, call)?;
                let operation = call.args.text(0).unwrap_or_default();
                if !matches!(operation, "primitive" | "union" | "intersection" | "difference") {
                    let expected = "expected \"primitive\", \"union\", \"intersection\" or \"difference\"";
                    self.say(Fault::warning(call.args.pos(0), format!("\"{operation}\": {expected}")));
                }
                if operation != "primitive" {
                    self.count("solid operations are not drawn yet: the parts are, as they stand", call.site);
                }
            }
            Id::ResourceBegin => self.open(BlockKind::Resource, call)?,
            Id::MotionBegin => self.motion_begin(call)?,
            Id::FrameEnd => self.close(BlockKind::Frame, call)?,
            Id::AttributeEnd => self.close(BlockKind::Attribute, call)?,
            Id::TransformEnd => self.close(BlockKind::Transform, call)?,
            Id::SolidEnd => self.close(BlockKind::Solid, call)?,
            Id::ResourceEnd => self.close(BlockKind::Resource, call)?,
            Id::MotionEnd => {
                self.close(BlockKind::Motion, call)?;
                self.motion_end(call.site, false)?;
            }
            Id::ObjectEnd | Id::ArchiveEnd => {
                let message = format!("{} without its beginning; ignored", call.statement.name);
                return Err(Fault::error(call.site.pos, message));
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn open(&mut self, kind: BlockKind, call: &Call<'_>) -> Result<(), Fault> {
        if self.blocks.len() >= MAX_BLOCKS {
            let message = format!("expected at most {MAX_BLOCKS} blocks nested in each other; ignored");
            return Err(Fault::error(call.site.pos, message));
        }
        let all = matches!(kind, BlockKind::Frame | BlockKind::World);
        self.blocks.push(Block {
            kind,
            site: call.site.clone(),
            options: (kind == BlockKind::Frame).then(|| self.options.clone()),
            attrs: (kind != BlockKind::Transform).then(|| self.attrs.clone()),
            ctm: Some(self.ctm.clone()),
            names: all.then(|| self.names.clone()),
        });
        Ok(())
    }

    /// Closes the innermost block of that kind, and with a message those that were left open within it.
    fn close(&mut self, kind: BlockKind, call: &Call<'_>) -> Result<(), Fault> {
        let own = self.blocks.get(self.floor..).unwrap_or(&[]);
        // A block never reaches beyond the world, frame or object it was opened in.
        let outer = |b: &Block| matches!(b.kind, BlockKind::Frame | BlockKind::World);
        let stop = if outer_kind(kind) { None } else { own.iter().rposition(outer) };
        let found = own.iter().rposition(|b| b.kind == kind).filter(|ix| stop.is_none_or(|s| *ix > s));
        let Some(ix) = found else {
            let open = match own.last() {
                Some(b) => format!("{} of line {} is open", b.kind.begin(), b.site.pos.line),
                None => "no block is open".to_owned(),
            };
            let message = format!("{} without {}: {open}; ignored", kind.end(), kind.begin());
            return Err(Fault::error(call.site.pos, message));
        };
        while self.blocks.len() > self.floor + ix {
            let Some(block) = self.blocks.pop() else { break };
            if self.blocks.len() > self.floor + ix {
                let (begin, end, line) = (block.kind.begin(), block.kind.end(), block.site.pos.line);
                let message =
                    format!("{begin} of line {line} is still open: expected {end} before {}", kind.end());
                self.say(Fault::error(call.site.pos, message));
                self.mend_motion(&block, call.site);
            }
            self.restore(block);
        }
        Ok(())
    }

    /// A block was left open: what a motion block has gathered is drawn all the same.
    fn mend_motion(&mut self, block: &Block, site: &Site) {
        if block.kind == BlockKind::Motion
            && let Err(fault) = self.motion_end(site, true)
        {
            self.say(fault);
        }
    }

    /// Returns to what a block saved.
    pub(super) fn restore(&mut self, block: Block) {
        if block.kind == BlockKind::World {
            self.world = None;
        }
        if block.kind == BlockKind::Frame {
            self.frame_number = None;
        }
        self.options = block.options.unwrap_or_else(|| self.options.clone());
        self.attrs = block.attrs.unwrap_or_else(|| self.attrs.clone());
        if let Some(ctm) = block.ctm {
            self.ctm = ctm;
        }
        if let Some(names) = block.names {
            self.names = names;
        }
    }

    fn frame_begin(&mut self, call: &Call<'_>) -> Result<(), Fault> {
        if self.is_open(BlockKind::Frame) {
            return Err(Fault::error(
                call.site.pos,
                "FrameBegin in a frame: expected FrameEnd first; ignored",
            ));
        }
        self.open(BlockKind::Frame, call)?;
        self.frame_number = Some(call.args.int(0));
        Ok(())
    }

    fn world_begin(&mut self, call: &Call<'_>) -> Result<(), Fault> {
        self.open(BlockKind::World, call)?;
        let camera = self.camera(call.site);
        self.world = Some(super::World { scene: olema::Scene::new(camera) });
        self.ctm = Transform::default();
        Ok(())
    }

    /// WorldEnd: hands the frame out.
    pub(super) fn world_end(&mut self, call: &Call<'_>) -> Result<Flow, Fault> {
        if self.floor > 0 || self.world.is_none() {
            return Err(Fault::error(call.site.pos, "WorldEnd without WorldBegin; ignored"));
        }
        let own = self.blocks.iter().rposition(|b| b.kind == BlockKind::World);
        while let Some(block) = self.blocks.pop_if(|b| b.kind != BlockKind::World) {
            let (begin, end, line) = (block.kind.begin(), block.kind.end(), block.site.pos.line);
            let message = format!("{begin} of line {line} is still open: expected {end} before WorldEnd");
            self.say(Fault::error(call.site.pos, message));
            self.mend_motion(&block, call.site);
        }
        debug_assert!(own.is_some(), "a world is open, so its block is");
        let Some(world) = self.world.take() else { return Ok(Flow::Next) };
        let frame = self.frame(world);
        if let Some(block) = self.blocks.pop() {
            self.restore(block);
        }
        self.room.release(self.kept);
        Ok(Flow::Frame(Box::new(frame)))
    }

    /// An object's replay starts: its statements cannot close what is open now, and leave the state as it was.
    pub fn enter_object(&mut self) -> Saved {
        let saved = (self.attrs.clone(), self.ctm.clone(), self.floor);
        self.floor = self.blocks.len();
        saved
    }

    /// An object's replay ended.
    pub fn leave_object(&mut self, saved: Saved) {
        let floor = self.floor;
        if self.blocks.len() > floor
            && let Some(block) = self.blocks.pop_if(|block| block.kind == BlockKind::Motion)
        {
            let message = "MotionBegin is still open where its object ends: expected MotionEnd";
            self.say(Fault::error(block.site.pos, message));
            self.mend_motion(&block, &block.site);
        }
        self.blocks.truncate(self.floor.max(saved.2));
        (self.attrs, self.ctm, self.floor) = saved;
    }
}

fn outer_kind(kind: BlockKind) -> bool {
    matches!(kind, BlockKind::Frame | BlockKind::World)
}
