//! Motion blocks: the same statement once for every time.
//!
//! Transforms get a key for every time, and so do the points of surfaces. Of any other statement the first one
//! counts.

use glam::DMat4;
use olema::scene::{Geometry, Keyed, PatchMesh, SubdivisionMesh};
use std::sync::Arc;

use super::super::fault::Fault;
use super::super::state::{Block, BlockKind, Site};
use super::super::statements::{Id, Place};
use super::{Call, Flow, Interp, MAX_TIMES, is_surface, is_transform};

/// An open motion block.
pub struct Motion {
    times: Vec<f32>,
    /// The statement that the block repeats.
    id: Option<Id>,
    seen: usize,
    matrices: Vec<DMat4>,
    replaces: bool,
    /// The first primitive, whose points get keys.
    geometry: Option<(Geometry, Site)>,
}

impl Interp {
    /// MotionBegin.
    pub(super) fn motion_begin(&mut self, call: &Call<'_>) -> Result<(), Fault> {
        let times = call.args.floats(0).to_vec();
        let ascend = times.windows(2).all(|w| w[0] < w[1]);
        if times.is_empty() || !ascend || times.len() > MAX_TIMES {
            return Err(Fault::error(
                call.args.pos(0),
                format!("expected 1 to {MAX_TIMES} times in ascending order"),
            ));
        }
        self.count("motion is not drawn yet: the first key is", call.site);
        let block = Block {
            kind: BlockKind::Motion,
            site: call.site.clone(),
            options: None,
            attrs: None,
            ctm: None,
            names: None,
        };
        self.blocks.push(block);
        self.motion =
            Some(Motion { times, id: None, seen: 0, matrices: Vec::new(), replaces: false, geometry: None });
        Ok(())
    }

    /// A statement within the block.
    pub(super) fn run_in_motion(&mut self, call: Call<'_>) -> Result<Flow, Fault> {
        let Some(motion) = &mut self.motion else { return Ok(Flow::Next) };
        let (id, pos) = (call.statement.id, call.site.pos);
        let first = motion.seen == 0;
        if call.statement.name.ends_with("Begin")
            || call.statement.name.ends_with("End")
            || id == Id::ObjectInstance
        {
            let name = call.statement.name;
            return Err(Fault::error(pos, format!("{name} in a motion block: expected MotionEnd; ignored")));
        }
        if motion.id.is_some_and(|other| other != id) {
            let name = call.statement.name;
            let message =
                format!("{name} in a motion block of another statement: expected the same; ignored");
            return Err(Fault::error(pos, message));
        }
        if motion.seen == motion.times.len() {
            let times = motion.times.len();
            return Err(Fault::error(
                pos,
                format!("expected {times} statements, one a time, found more; ignored"),
            ));
        }
        motion.id = Some(id);
        motion.seen += 1;
        if is_transform(id) {
            let (matrix, replaces) = self.matrix_of(&call)?;
            if let Some(motion) = &mut self.motion {
                motion.matrices.push(matrix);
                motion.replaces = replaces;
            }
        } else if is_surface(id) {
            let geometry = self.geometry_of(&call)?;
            self.add_key(&call, geometry)?;
        } else if first {
            // The flow of a statement that reads something else is not a motion block's business.
            if matches!(self.dispatch(call)?, Flow::Next) {
                return Ok(Flow::Next);
            }
            let name = call.statement.name;
            return Err(Fault::error(pos, format!("{name} in a motion block: expected MotionEnd; ignored")));
        } else if call.statement.place == Place::World {
            self.undrawn(&call)?;
        }
        Ok(Flow::Next)
    }

    fn add_key(&mut self, call: &Call<'_>, geometry: Geometry) -> Result<(), Fault> {
        let Some(motion) = &mut self.motion else { return Ok(()) };
        let Some((first, _)) = &mut motion.geometry else {
            motion.geometry = Some((geometry, call.site.clone()));
            return Ok(());
        };
        match (first, geometry) {
            (Geometry::Patches(first), Geometry::Patches(next)) if is_same_sheet(first, &next) => {
                Arc::make_mut(first).points.values.push(next.points.first().clone());
            }
            (Geometry::Subdivision(first), Geometry::Subdivision(next)) if is_same_mesh(first, &next) => {
                Arc::make_mut(first).points.values.push(next.points.first().clone());
            }
            _ => {
                let message = "this surface differs from the block's first in more than its values: expected \
                               the same shape";
                return Err(Fault::error(call.site.pos, message));
            }
        }
        Ok(())
    }

    /// MotionEnd.
    pub(super) fn motion_end(&mut self, call: &Call<'_>) -> Result<(), Fault> {
        let Some(motion) = self.motion.take() else { return Ok(()) };
        let (times, seen) = (motion.times.len(), motion.seen);
        if motion.seen < times {
            let message = format!("expected {times} statements, one a time, found {seen}");
            self.say(Fault::error(call.site.pos, message));
        }
        if let Some(keyed) = keyed(&motion.times, motion.matrices) {
            self.apply(call, &keyed, motion.replaces)?;
        }
        if let Some((mut geometry, site)) = motion.geometry {
            match &mut geometry {
                Geometry::Patches(mesh) => set_times(&mut Arc::make_mut(mesh).points, &motion.times),
                Geometry::Subdivision(mesh) => set_times(&mut Arc::make_mut(mesh).points, &motion.times),
                _ => {}
            }
            self.emit(call, geometry, &site)?;
        }
        Ok(())
    }
}

fn is_same_sheet(first: &PatchMesh, next: &PatchMesh) -> bool {
    first.kind == next.kind
        && (first.nu, first.nv, first.wrap_u, first.wrap_v) == (next.nu, next.nv, next.wrap_u, next.wrap_v)
        && std::mem::discriminant(first.points.first()) == std::mem::discriminant(next.points.first())
}

fn is_same_mesh(first: &SubdivisionMesh, next: &SubdivisionMesh) -> bool {
    first.scheme == next.scheme
        && first.face_vertex_counts == next.face_vertex_counts
        && first.indices == next.indices
        && first.points.first().len() == next.points.first().len()
}

/// Gives a surface's keys their times.
fn set_times<T>(points: &mut Keyed<T>, times: &[f32]) {
    if let Some(keyed) = keyed(times, std::mem::take(&mut points.values)) {
        *points = keyed;
    }
}

/// Values with their times: all of them, or the first alone where some are missing. `None` without any.
fn keyed<T>(times: &[f32], mut values: Vec<T>) -> Option<Keyed<T>> {
    if times.len() > 1 && values.len() == times.len() {
        return Some(Keyed { times: times.to_vec(), values });
    }
    values.truncate(1);
    values.pop().map(Keyed::still)
}
