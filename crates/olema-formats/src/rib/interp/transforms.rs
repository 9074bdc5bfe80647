//! Transforms and named spaces.

use glam::{DMat4, DVec3};
use olema::scene::{Keyed, Transform};

use super::super::fault::Fault;
use super::super::state::{Site, Space};
use super::super::statements::Id;
use super::super::transform;
use super::{Call, Interp, MAX_KEYS, MAX_MOVING, MAX_SPACES};

impl Interp {
    /// Runs a transform statement.
    pub(super) fn transform(&mut self, call: &Call<'_>) -> Result<(), Fault> {
        let (matrix, replaces) = self.matrix_of(call)?;
        self.apply(call.statement.name, call.site, &Keyed::still(matrix), replaces)
    }

    /// A transform statement's matrix, and whether it replaces the current one.
    pub(super) fn matrix_of(&mut self, call: &Call<'_>) -> Result<(DMat4, bool), Fault> {
        let args = call.args;
        let numbers = |message: &str| Fault::error(args.pos(0), message);
        let offset =
            || args.array::<3>(0).map(DVec3::from_array).ok_or_else(|| numbers("expected 3 numbers"));
        let sixteen =
            || args.array(0).map(|m| transform::matrix(&m)).ok_or_else(|| numbers("expected 16 numbers"));
        Ok(match call.statement.id {
            Id::Identity => (DMat4::IDENTITY, true),
            Id::Transform => (sixteen()?, true),
            Id::ConcatTransform => (sixteen()?, false),
            Id::Translate => (DMat4::from_translation(offset()?), false),
            Id::Scale => (DMat4::from_scale(offset()?), false),
            Id::Rotate => {
                let matrix = args.array(0).and_then(transform::rotate);
                (matrix.ok_or_else(|| numbers("expected a finite angle and an axis longer than 0"))?, false)
            }
            Id::Skew => {
                let matrix = args.array(0).and_then(transform::skew);
                let expected =
                    "expected an angle below that between the two axes, and both axes longer than 0";
                (matrix.ok_or_else(|| numbers(expected))?, false)
            }
            Id::Perspective => {
                let matrix = transform::perspective(args.num(0));
                (matrix.ok_or_else(|| numbers("expected an angle between 0 and 180 degrees"))?, false)
            }
            _ => {
                let name = args.text(0).unwrap_or_default();
                let found = self.space(name);
                (
                    found.ok_or_else(|| {
                        numbers(&format!("\"{name}\" is unknown: expected the name of a space"))
                    })?,
                    true,
                )
            }
        })
    }

    /// Changes the current transformation, if it can still be inverted then. The statement is `name` at `site`.
    pub(super) fn apply(
        &mut self,
        name: &str,
        site: &Site,
        m: &Keyed<DMat4>,
        replaces: bool,
    ) -> Result<(), Fault> {
        let mut next = if replaces { Transform::default() } else { self.ctm.clone() };
        next.concat(m);
        if m.values.len() > 1 {
            self.check_moving(site, &next)?;
            let bytes = m.values.len() * (size_of::<DMat4>() + size_of::<f32>());
            self.hold(site.pos, bytes as u64)?;
            if self.world.is_none() {
                self.kept = self.kept.saturating_add(bytes as u64);
            }
        }
        // All factors but the last were looked at before.
        let last = next.factors().last().is_none_or(|last| last.values.iter().all(transform::is_regular));
        if !(last && transform::is_regular(&next.first())) {
            let message =
                format!("{name} makes a singular transformation: expected one that can be inverted; ignored");
            return Err(Fault::error(site.pos, message));
        }
        self.ctm = next;
        Ok(())
    }

    /// What moves costs time for every primitive that it moves.
    fn check_moving(&self, site: &Site, next: &Transform) -> Result<(), Fault> {
        let keys = || next.factors().iter().map(|factor| factor.times.len());
        let (num_moving, num_keys) = (keys().filter(|num| *num > 0).count(), keys().sum::<usize>());
        if num_moving <= MAX_MOVING && num_keys <= MAX_KEYS {
            return Ok(());
        }
        let message = format!(
            "{num_moving} motion blocks with {num_keys} keys around an object: expected at most {MAX_MOVING} with \
             {MAX_KEYS}; this one is ignored"
        );
        Err(Fault::error(site.pos, message))
    }

    /// From a named space to the space that the current transformation leads to.
    pub(super) fn space(&self, name: &str) -> Option<DMat4> {
        let to_camera = self.world.as_ref().map(|w| w.scene.camera.world_to_camera.first());
        match (name, to_camera) {
            ("world", Some(_)) | ("camera" | "current", None) => return Some(DMat4::IDENTITY),
            ("camera", Some(to_camera)) => return Some(to_camera.inverse()),
            ("object" | "shader" | "current", _) => return Some(self.ctm.first()),
            _ => {}
        }
        let scoped = self.attrs.spaces.iter().rev();
        let found = scoped.chain(self.names.spaces.iter().rev()).find(|s| s.name == name)?;
        match to_camera {
            Some(to_camera) if !found.in_world => Some(to_camera.inverse() * found.matrix),
            _ => Some(found.matrix),
        }
    }

    /// CoordinateSystem and ScopedCoordinateSystem.
    pub(super) fn name_space(&mut self, call: &Call<'_>) -> Result<(), Fault> {
        if self.names.spaces.len() + self.attrs.spaces.len() >= MAX_SPACES {
            let message = format!("expected at most {MAX_SPACES} named spaces; ignored");
            return Err(Fault::error(call.site.pos, message));
        }
        let name = call.args.text(0).unwrap_or_default().to_owned();
        let space = Space { name, matrix: self.ctm.first(), in_world: self.world.is_some() };
        if call.statement.id == Id::ScopedCoordinateSystem {
            let attrs = std::sync::Arc::make_mut(&mut self.attrs);
            std::sync::Arc::make_mut(&mut attrs.spaces).push(space);
            return Ok(());
        }
        match self.names.spaces.iter_mut().find(|s| s.name == space.name) {
            Some(old) => *old = space,
            None => self.names.spaces.push(space),
        }
        Ok(())
    }
}
