//! Displacement in the graphics state: a shader and a bound, each in a space of its own, carried to the object's.
//!
//! A shader's space is that of its statement, as RenderMan has it: where a transform follows, the primitive's space is
//! another one, and points, lengths and offsets are carried over. What moves counts at its first key.

use std::sync::Arc;

use glam::{DMat3, DMat4};
use olema::shading::{self, DisplacementShader};

/// A displacement shader and its space: that of the statement, to world (or to camera before WorldBegin).
#[derive(Debug, Clone)]
pub struct DisplacementState {
    /// The shader.
    pub shader: Arc<dyn DisplacementShader>,
    /// From its space.
    pub matrix: DMat4,
    /// Whether the matrix leads to world.
    pub in_world: bool,
    /// Object to world of the last primitive that was displaced by it, and the shader in that space: primitives
    /// that follow in the same space share it.
    pub placed: Option<(DMat4, Arc<dyn DisplacementShader>)>,
}

/// How far displacement may move a point, and in which space that is said.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BoundState {
    /// Radius of a sphere; 0 says nothing.
    pub radius: f64,
    /// The space.
    pub space: BoundSpace,
}

/// The space of a displacement bound.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum BoundSpace {
    /// Each primitive's own.
    #[default]
    Object,
    /// That of the displacement shader.
    Shader,
    /// From the space to world.
    World(DMat4),
    /// From the space to camera.
    Camera(DMat4),
}

impl DisplacementState {
    /// From the shader's space to world.
    pub fn to_world(&self, world_to_camera: &DMat4) -> DMat4 {
        if self.in_world { self.matrix } else { world_to_camera.inverse() * self.matrix }
    }

    /// The shader in the space of an object.
    pub fn place(&self, object_to_world: &DMat4, world_to_camera: &DMat4) -> Arc<dyn DisplacementShader> {
        if let Some((at, shader)) = &self.placed
            && at == object_to_world
        {
            return shader.clone();
        }
        let to_world = self.to_world(world_to_camera);
        if to_world == *object_to_world {
            return self.shader.clone();
        }
        shading::displacement_in_space(self.shader.clone(), &(to_world.inverse() * *object_to_world))
    }
}

impl BoundState {
    /// The radius in the space of an object: no less than any part of the sphere reaches there.
    pub fn in_object(
        &self,
        object_to_world: &DMat4,
        world_to_camera: &DMat4,
        displacement: Option<&DisplacementState>,
    ) -> f32 {
        let to_world = match (self.space, displacement) {
            (BoundSpace::Object, _) | (BoundSpace::Shader, None) => return self.radius as f32,
            (BoundSpace::Shader, Some(d)) => d.to_world(world_to_camera),
            (BoundSpace::World(m), _) => m,
            (BoundSpace::Camera(m), _) => world_to_camera.inverse() * m,
        };
        if self.radius == 0.0 || to_world == *object_to_world {
            return self.radius as f32;
        }
        let to_object = DMat3::from_mat4(object_to_world.inverse() * to_world);
        (self.radius * shading::largest_stretch(&to_object)) as f32
    }
}
