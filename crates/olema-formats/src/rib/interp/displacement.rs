//! Displacement: the shader, its bound, and both in the space of what they move.

use std::cell::RefCell;
use std::sync::Arc;

use glam::DMat4;
use olema::shading::DisplacementShader;

use super::super::displacement::{BoundSpace, BoundState, DisplacementState};
use super::super::fault::Fault;
use super::super::params;
use super::{Call, Flow, Interp};

impl Interp {
    /// Displacement. Where the shader wants an image that is not there yet, that is asked for first.
    pub(super) fn displacement(&mut self, call: &Call<'_>) -> Flow {
        let name = call.args.text(0).unwrap_or_default();
        if matches!(name, "" | "null") {
            Arc::make_mut(&mut self.attrs).displacement = None;
            return Flow::Next;
        }
        let before = self.said.len();
        let params = params::shader_params(call.args, &mut self.said);
        let wanted = RefCell::new(None);
        let images = |image: &str| {
            self.textures.get(image).cloned().unwrap_or_else(|| {
                *wanted.borrow_mut() = Some(image.to_owned());
                Err(String::new())
            })
        };
        let made = self.library.displacement(name, &params, &images);
        if let Some(name) = wanted.into_inner() {
            self.said.truncate(before);
            return Flow::Texture { name };
        }
        let shader = match made {
            Ok(made) => {
                self.said.extend(made.warnings.into_iter().map(|w| Fault::warning(call.site.pos, w)));
                Some(made.shader)
            }
            Err(why) => {
                self.say(Fault::warning(call.site.pos, why + "; the surface is drawn undisplaced"));
                None
            }
        };
        let (matrix, in_world) = (self.ctm.first(), self.world.is_some());
        Arc::make_mut(&mut self.attrs).displacement =
            shader.map(|shader| DisplacementState { shader, matrix, in_world, placed: None });
        Flow::Next
    }

    /// Attribute "displacementbound".
    pub(super) fn displacement_bound(&mut self, call: &Call<'_>) {
        let args = call.args;
        let Some(sphere) = args.find("sphere") else {
            let message = "expected \"float sphere\", how far displacement moves a point; ignored";
            return self.say(Fault::warning(call.site.pos, message));
        };
        let radius = args.param_floats(sphere).first().copied().unwrap_or(f32::NAN);
        if !(radius >= 0.0 && radius.is_finite()) {
            let message = format!("sphere is {radius}: expected a radius of 0 or more; ignored");
            return self.say(Fault::error(sphere.pos, message));
        }
        let space = args.find("coordinatesystem");
        let name = space.and_then(|p| args.param_texts(p).next()).unwrap_or("object");
        let found = match name {
            "object" => Some(BoundSpace::Object),
            "shader" => Some(BoundSpace::Shader),
            "world" => Some(BoundSpace::World(DMat4::IDENTITY)),
            "camera" | "current" => Some(BoundSpace::Camera(DMat4::IDENTITY)),
            name if self.world.is_some() => self.space(name).map(BoundSpace::World),
            name => self.space(name).map(BoundSpace::Camera),
        };
        let space = found.unwrap_or_else(|| {
            let message = format!(
                "\"{name}\" is unknown: expected \"object\", \"shader\", \"world\", \"camera\" or a named space; taken as \"object\""
            );
            self.said.push(Fault::warning(space.map_or(call.site.pos, |p| p.pos), message));
            BoundSpace::Object
        });
        Arc::make_mut(&mut self.attrs).displacement_bound = BoundState { radius: f64::from(radius), space };
    }

    /// Displacement shader and bound of a primitive that stands here, in its own space.
    pub(super) fn displaced(&mut self) -> (Option<Arc<dyn DisplacementShader>>, f32) {
        let Some(world) = &self.world else { return (None, 0.0) };
        let (object, camera) = (self.ctm.first(), world.scene.camera.world_to_camera.first());
        let state = self.attrs.displacement.as_ref();
        let bound = self.attrs.displacement_bound.in_object(&object, &camera, state);
        let Some(state) = state else { return (None, bound) };
        let shader = state.place(&object, &camera);
        let is_new = state.placed.as_ref().is_none_or(|placed| placed.0 != object);
        if is_new
            && !Arc::ptr_eq(&shader, &state.shader)
            && let Some(state) = &mut Arc::make_mut(&mut self.attrs).displacement
        {
            state.placed = Some((object, shader.clone()));
        }
        (Some(shader), bound)
    }
}
