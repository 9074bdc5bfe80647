//! Motion blocks: the same statement once for every time.
//!
//! Transforms get a key for every time, and so do the points of surfaces. Of any other statement the first one
//! counts. So it does in a block with something wrong: what is wrong is said once, and what the block would have moved
//! stands still.

use std::sync::Arc;

use glam::DMat4;
use olema::scene::{Geometry, Keyed, PatchMesh, SubdivisionMesh};

use super::super::fault::Fault;
use super::super::state::{Block, BlockKind, Site};
use super::super::statements::{Id, Place, Statement};
use super::spin::spin;
use super::{Call, Flow, Interp, MAX_TIMES, is_surface, is_transform};

/// An open motion block.
#[derive(Default)]
pub struct Motion {
    times: Vec<f32>,
    /// Something is wrong with it, which was said: the first statement alone counts.
    broken: bool,
    /// The statement that the block repeats.
    statement: Option<&'static Statement>,
    seen: usize,
    /// Blocks open in it that do not belong there; all in them is passed over.
    inner: u32,
    matrices: Vec<DMat4>,
    /// The numbers of `Rotate`.
    rotations: Vec<[f64; 4]>,
    replaces: bool,
    /// The first primitive, whose points get keys.
    geometry: Option<(Geometry, Site)>,
}

impl Motion {
    /// Statements that gave the block what it needs of them.
    fn num_keys(&self) -> usize {
        match (&self.geometry, self.statement) {
            (Some((Geometry::Patches(mesh), _)), _) => mesh.points.values.len(),
            (Some((Geometry::Subdivision(mesh), _)), _) => mesh.points.values.len(),
            (_, Some(statement)) if is_transform(statement.id) => self.matrices.len(),
            (_, Some(statement)) if is_surface(statement.id) => 0,
            _ => self.seen.min(self.times.len()),
        }
    }

    /// Whether the block has no use for this statement, and if that was not said yet, why.
    fn refuses(&mut self, statement: &'static Statement) -> Option<Option<String>> {
        let (name, num_times) = (statement.name, self.times.len());
        let other = self.statement.filter(|first| first.id != statement.id);
        self.statement = self.statement.or(Some(statement));
        if self.broken {
            return (self.seen > 0).then_some(None);
        }
        if let Some(first) = other {
            self.broken = true;
            let first = first.name;
            return Some(Some(format!(
                "{name} in a motion block of {first}: expected the same statement; the first alone counts"
            )));
        }
        if self.seen == num_times {
            // Said once.
            self.seen += 1;
            let message = format!("expected {num_times} statements, one a time, found more; ignored");
            return Some(Some(message));
        }
        (self.seen > num_times).then_some(None)
    }
}

impl Interp {
    /// MotionBegin. One whose times are wrong begins a block nevertheless.
    pub(super) fn motion_begin(&mut self, call: &Call<'_>) -> Result<(), Fault> {
        let times = call.args.floats(0);
        let problem = if call.args.is_none(0) {
            // The reader has said what is wrong with them.
            Some(String::new())
        } else if times.is_empty() || times.len() > MAX_TIMES {
            Some(format!("{} times: expected 1 to {MAX_TIMES} times", times.len()))
        } else {
            let pair = times.windows(2).find(|pair| pair[0] >= pair[1]);
            pair.map(|p| format!("time {} comes after {}: expected times in ascending order", p[1], p[0]))
        };
        if let Some(problem) = problem.as_ref().filter(|problem| !problem.is_empty()) {
            let message = format!("{problem}; the block's first statement alone counts");
            self.say(Fault::error(call.args.pos(0), message));
        }
        self.blocks.push(Block {
            kind: BlockKind::Motion,
            site: call.site.clone(),
            options: None,
            attrs: None,
            ctm: None,
            names: None,
        });
        let broken = problem.is_some();
        let times = if broken { Vec::new() } else { times.to_vec() };
        self.motion = Some(Motion { times, broken, ..Motion::default() });
        Ok(())
    }

    /// A statement within the block.
    pub(super) fn run_in_motion(&mut self, call: Call<'_>) -> Result<Flow, Fault> {
        let Some(motion) = &mut self.motion else { return Ok(Flow::Next) };
        let (statement, pos) = (call.statement, call.site.pos);
        let (id, name) = (statement.id, statement.name);
        let (begins, ends) = (name.ends_with("Begin"), name.ends_with("End"));
        if motion.inner > 0 && !matches!(id, Id::WorldEnd | Id::FrameEnd) {
            motion.inner = motion.inner.saturating_add(begins.into()).saturating_sub(ends.into());
            return Ok(Flow::Next);
        }
        if ends {
            return self.dispatch(call);
        }
        if begins {
            motion.inner = 1;
            let message = format!("{name} in a motion block: expected MotionEnd; ignored up to its end");
            return Err(Fault::error(pos, message));
        }
        if id == Id::ObjectInstance {
            return Err(misplaced(&call));
        }
        match motion.refuses(statement) {
            None => self.add_to_motion(call),
            Some(problem) => {
                self.said.extend(problem.map(|message| Fault::warning(pos, message)));
                Ok(Flow::Next)
            }
        }
    }

    /// A statement that the block may repeat.
    fn add_to_motion(&mut self, call: Call<'_>) -> Result<Flow, Fault> {
        let id = call.statement.id;
        let Some(motion) = &mut self.motion else { return Ok(Flow::Next) };
        motion.seen += 1;
        let first = motion.seen == 1;
        if is_transform(id) {
            let (matrix, replaces) = self.matrix_of(&call)?;
            if let Some(motion) = &mut self.motion {
                motion.matrices.push(matrix);
                motion.rotations.extend(call.args.array(0).filter(|_| id == Id::Rotate));
                motion.replaces = replaces;
            }
        } else if is_surface(id) {
            let geometry = self.geometry_of(&call)?;
            self.add_key(&call, geometry);
        } else if first {
            return self.still_in_motion(call);
        } else if call.statement.place == Place::World {
            self.undrawn(&call)?;
        }
        Ok(Flow::Next)
    }

    /// The first statement of a block of those that do not move.
    fn still_in_motion(&mut self, call: Call<'_>) -> Result<Flow, Fault> {
        match self.dispatch(call)? {
            Flow::Next => {}
            flow @ Flow::Texture { .. } => {
                // It comes again when the image is there.
                if let Some(motion) = &mut self.motion {
                    motion.seen = 0;
                }
                return Ok(flow);
            }
            _ => return Err(misplaced(&call)),
        }
        if call.statement.place != Place::World {
            let what =
                "only transforms and points move: of another statement in a motion block the first counts";
            self.count(what, call.site);
        }
        Ok(Flow::Next)
    }

    fn add_key(&mut self, call: &Call<'_>, geometry: Geometry) {
        let Some(motion) = &mut self.motion else { return };
        let Some((first, _)) = &mut motion.geometry else {
            motion.geometry = Some((geometry, call.site.clone()));
            return;
        };
        let only_points_differ = match (first, geometry) {
            (Geometry::Patches(first), Geometry::Patches(next)) if is_same_sheet(first, &next) => {
                let points = &mut Arc::make_mut(first).points.values;
                points.reserve_exact(motion.times.len().saturating_sub(points.len()));
                points.push(next.points.first().clone());
                first.vars == next.vars
            }
            (Geometry::Subdivision(first), Geometry::Subdivision(next)) if is_same_mesh(first, &next) => {
                Arc::make_mut(first).points.values.push(next.points.first().clone());
                has_same_look(first, &next)
            }
            _ => {
                motion.broken = true;
                let message = "this surface differs from the block's first in more than its values: expected \
                               the same shape; the first is drawn still";
                return self.say(Fault::warning(call.site.pos, message));
            }
        };
        if !only_points_differ {
            let what =
                "only points move from key to key: primitive variables and tags are those of the first";
            self.count(what, call.site);
        }
    }

    /// What the block has gathered takes its effect: at MotionEnd, or where the block is closed without (`mended`,
    /// which was said).
    pub(super) fn motion_end(&mut self, site: &Site, mended: bool) -> Result<(), Fault> {
        let Some(motion) = self.motion.take() else { return Ok(()) };
        let (num_times, num_keys) = (motion.times.len(), motion.num_keys());
        if num_keys < num_times && !motion.broken && !mended {
            let still = if num_keys > 0 { "; the first alone counts" } else { "" };
            let message = format!("expected {num_times} statements, one a time, found {num_keys}{still}");
            self.say(Fault::error(site.pos, message));
        }
        let times = if motion.broken { &[][..] } else { &motion.times };
        if let (Some(keys), Some(statement)) = (keyed(times, motion.matrices), motion.statement) {
            let spun = if keys.times.is_empty() { Ok(None) } else { spin(times, &motion.rotations) };
            let spun = spun.unwrap_or_else(|problem| {
                let message = format!("{problem}; between its keys it goes the shorter way round");
                self.say(Fault::warning(site.pos, message));
                None
            });
            self.apply(statement.name, site, &spun.unwrap_or(keys), motion.replaces)?;
        }
        if let Some((mut geometry, site)) = motion.geometry {
            match &mut geometry {
                Geometry::Patches(mesh) => set_times(&mut Arc::make_mut(mesh).points, times),
                Geometry::Subdivision(mesh) => set_times(&mut Arc::make_mut(mesh).points, times),
                _ => {}
            }
            self.emit(geometry, &site)?;
        }
        Ok(())
    }
}

/// A statement that reads others cannot be repeated.
fn misplaced(call: &Call<'_>) -> Fault {
    let name = call.statement.name;
    Fault::error(call.site.pos, format!("{name} in a motion block: expected MotionEnd; ignored"))
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

/// Whether meshes differ in nothing but their points.
fn has_same_look(first: &SubdivisionMesh, next: &SubdivisionMesh) -> bool {
    first.vars == next.vars
        && (&first.creases, &first.corners, &first.holes) == (&next.creases, &next.corners, &next.holes)
        && (first.boundary, first.face_varying, first.crease_method)
            == (next.boundary, next.face_varying, next.crease_method)
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
