//! Values that conditions can ask for: those of options and of user attributes.

use std::sync::Arc;

use super::args::Args;

/// A value that a condition can ask for.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// The first of some numbers.
    Num(f64),
    /// The first of some strings.
    Text(String),
}

/// Named values.
#[derive(Debug, Clone, Default)]
pub struct Values(Arc<Vec<(String, Value)>>);

impl Values {
    /// The value of that name.
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.0.iter().find(|v| v.0 == name).map(|v| &v.1)
    }

    /// Sets a value; `false` where there are too many.
    pub fn set(&mut self, name: String, value: Value) -> bool {
        let values = Arc::make_mut(&mut self.0);
        let full = values.len() >= 1024;
        match values.iter_mut().find(|v| v.0 == name) {
            Some(old) => old.1 = value,
            None if full => return false,
            None => values.push((name, value)),
        }
        true
    }

    /// Keeps the first value of every parameter as "category:name".
    pub fn set_params(&mut self, category: &str, args: &Args) -> bool {
        let mut all = true;
        for param in &args.params {
            let text = args.param_texts(param).next().map(|t| Value::Text(t.to_owned()));
            let value = text.or_else(|| args.param_floats(param).first().map(|f| Value::Num(f64::from(*f))));
            if let Some(value) = value {
                all &= self.set(format!("{category}:{}", args.param_name(param)), value);
            }
        }
        all
    }
}
