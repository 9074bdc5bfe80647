//! Shaders and lights.

use std::sync::Arc;

use super::super::fault::Fault;
use super::super::params;
use super::super::state::{Handle, LightState};
use super::super::statements::Id;
use super::{Call, Interp};

impl Interp {
    /// Runs a statement that names a shader or a light.
    pub(super) fn shader(&mut self, call: &Call<'_>) -> Result<(), Fault> {
        match call.statement.id {
            Id::Surface => self.surface(call),
            Id::LightSource => self.light(call),
            Id::AreaLightSource => {
                self.count("area lights are not drawn yet: plain lights are, of the same shader", call.site);
                self.light(call);
            }
            Id::Illuminate => self.illuminate(call)?,
            Id::Imager => self.imager(call),
            _ if call.args.text(0).is_some_and(|name| !name.is_empty() && name != "null") => {
                params::shader_params(call.args, &mut self.said);
                self.count(call.statement.name, call.site);
            }
            _ => {}
        }
        Ok(())
    }

    fn surface(&mut self, call: &Call<'_>) {
        let params = params::shader_params(call.args, &mut self.said);
        let made = self.library.surface(call.args.text(0).unwrap_or_default(), &params);
        let shader = match made {
            Ok(made) => {
                self.note_params(call, &made.warnings);
                made.shader
            }
            Err(why) => {
                self.say(Fault::warning(call.site.pos, why + "; the default surface is used"));
                self.library.default_surface()
            }
        };
        Arc::make_mut(&mut self.attrs).look.surface = shader;
    }

    /// A parameter that a shader does not have is no mistake of the file: other renderers' shaders of the same
    /// name may have it.
    fn note_params(&mut self, call: &Call<'_>, warnings: &[String]) {
        if !warnings.is_empty() {
            self.say(Fault::note(call.site.pos, warnings.join("; ")));
        }
    }

    fn light(&mut self, call: &Call<'_>) {
        let params = params::shader_params(call.args, &mut self.said);
        let made = match self.library.light(call.args.text(0).unwrap_or_default(), &params) {
            Ok(made) => made,
            Err(why) => {
                // The handle stays known, so that Illuminate does not complain as well.
                self.names.handles.insert(Handle::of(call.args, 1), u32::MAX);
                return self.say(Fault::warning(call.site.pos, why + "; the light is left out"));
            }
        };
        self.note_params(call, &made.warnings);
        let ix = u32::try_from(self.names.lights.len()).unwrap_or(u32::MAX);
        let (matrix, in_world) = (self.ctm.clone(), self.world.is_some());
        self.names.lights.push(LightState { shader: made.shader, matrix, in_world });
        self.names.handles.insert(Handle::of(call.args, 1), ix);
        let attrs = Arc::make_mut(&mut self.attrs);
        Arc::make_mut(&mut attrs.lights).push(ix);
        attrs.lights_changed = true;
    }

    fn illuminate(&mut self, call: &Call<'_>) -> Result<(), Fault> {
        let handle = Handle::of(call.args, 0);
        let Some(ix) = self.names.handles.get(&handle).copied() else {
            let message =
                format!("light {handle} is unknown: expected one that LightSource defined; ignored");
            return Err(Fault::error(call.args.pos(0), message));
        };
        let on = call.args.int(1) != 0;
        if ix == u32::MAX || self.attrs.lights.contains(&ix) == on {
            return Ok(());
        }
        let attrs = Arc::make_mut(&mut self.attrs);
        let lights = Arc::make_mut(&mut attrs.lights);
        lights.retain(|l| *l != ix);
        if on {
            lights.push(ix);
        }
        attrs.lights_changed = true;
        Ok(())
    }

    fn imager(&mut self, call: &Call<'_>) {
        let args = call.args;
        let name = args.text(0).unwrap_or_default();
        if self.world.is_some() {
            let message = "Imager in a world: taken as if it stood before WorldBegin, where it is expected";
            self.say(Fault::note(call.site.pos, message));
        }
        if name != "background" {
            if !matches!(name, "" | "null") {
                let message = format!("imager \"{name}\" is unknown: expected \"background\"; ignored");
                self.say(Fault::warning(call.site.pos, message));
            }
            return;
        }
        let found = ["color", "background", "bgcolor"].into_iter().find_map(|n| args.find(n));
        let color = found.and_then(|p| <[f32; 3]>::try_from(args.param_floats(p)).ok());
        if let (Some(param), None) = (found, color) {
            self.say(Fault::error(param.pos, "expected a color (3 numbers); the background is black"));
        }
        Arc::make_mut(&mut self.options).background = Some(color.unwrap_or_default());
    }
}
