//! Parameters: as many values as their class asks for, as primitive variables or for shaders.

use std::sync::Arc;

use olema::scene::{PrimVar, VarType, VarValues};
use olema::shading::{ParamValue, ShaderParam};

use super::args::{Args, ParamItem};
use super::fault::Fault;
use super::state::Sizes;

/// Whether a parameter has as many values as it should; says so if not. Too many are cut off (`true`), too few
/// leave the parameter out (`false`).
fn has_count(args: &Args, param: &ParamItem, expected: usize, said: &mut Vec<Fault>) -> bool {
    let found = args.param_len(param);
    if found == expected {
        return true;
    }
    let name = args.param_name(param);
    let unit = if param.decl.ty == VarType::String { "strings" } else { "numbers" };
    let message = format!("\"{name}\" ({}) has {found} {unit}: expected {expected}", param.decl.describe());
    if found < expected {
        said.push(Fault::error(param.pos, message + "; left out"));
        return false;
    }
    said.push(Fault::warning(param.pos, message + "; the rest is ignored"));
    true
}

/// Checks every parameter of a primitive that is not drawn.
pub fn check(args: &Args, sizes: &Sizes, said: &mut Vec<Fault>) {
    for param in &args.params {
        has_count(args, param, sizes.count(&param.decl), said);
    }
}

/// The parameters of a primitive other than its position.
pub fn prim_vars(args: &Args, sizes: &Sizes, said: &mut Vec<Fault>) -> Vec<PrimVar> {
    let mut vars = Vec::new();
    for (ix, param) in args.params.iter().enumerate() {
        let name = args.param_name(param);
        let replaced = args.params[ix + 1..].iter().any(|p| args.param_name(p) == name);
        if matches!(name, "P" | "Pz" | "Pw") || replaced {
            continue;
        }
        let count = sizes.count(&param.decl);
        if !has_count(args, param, count, said) {
            continue;
        }
        let values = if param.decl.ty == VarType::String {
            VarValues::Strings(args.param_texts(param).take(count).map(str::to_owned).collect())
        } else {
            VarValues::Floats(Arc::from(args.param_floats(param).get(..count).unwrap_or(&[])))
        };
        let (class, ty, array_len) = (param.decl.class, param.decl.ty, param.decl.array_len);
        vars.push(PrimVar { name: name.to_owned(), class, ty, array_len, values });
    }
    vars
}

/// The parameters of a shader: one value each, whatever their class.
pub fn shader_params(args: &Args, said: &mut Vec<Fault>) -> Vec<ShaderParam> {
    let mut params = Vec::new();
    for param in &args.params {
        let count = param.decl.width();
        if !has_count(args, param, count, said) {
            continue;
        }
        let values = if param.decl.ty == VarType::String {
            ParamValue::Strings(args.param_texts(param).take(count).map(str::to_owned).collect())
        } else {
            ParamValue::Floats(args.param_floats(param).get(..count).unwrap_or(&[]).to_vec())
        };
        params.push(ShaderParam { name: args.param_name(param).to_owned(), ty: param.decl.ty, values });
    }
    params
}
