//! Conditions of IfBegin and ElseIf.
//!
//! In: an expression such as `$user:pass == 'beauty' && !defined(user:fast)`. Out: whether it holds, or what is
//! wrong with it. Operators, from weak to strong: `||`, `&&`, `== != < <= > >=`, `!`, parentheses.

use super::values::Value;

/// Deepest nesting of parentheses and negations.
const MAX_DEPTH: u32 = 64;

struct Parser<'a, F> {
    text: &'a str,
    lookup: F,
    depth: u32,
    /// Operands that cannot change the result any more are read, but may be unknown.
    settled: u32,
}

/// Whether `text` holds. `lookup` finds a variable, whose name comes without `$`.
///
/// # Errors
/// What was expected where.
pub fn holds(text: &str, lookup: impl Fn(&str) -> Option<Value>) -> Result<bool, String> {
    let mut parser = Parser { text, lookup, depth: 0, settled: 0 };
    let value = parser.or()?;
    match parser.rest() {
        "" => Ok(truth(&value)),
        rest => Err(format!("expected an operator or the end, found {rest:?}")),
    }
}

fn truth(value: &Value) -> bool {
    match value {
        Value::Num(n) => *n != 0.0,
        Value::Text(t) => !t.is_empty(),
    }
}

fn number(truth: bool) -> Value {
    Value::Num(if truth { 1.0 } else { 0.0 })
}

impl<F: Fn(&str) -> Option<Value>> Parser<'_, F> {
    fn rest(&mut self) -> &str {
        self.text = self.text.trim_start();
        self.text
    }

    fn take(&mut self, token: &str) -> bool {
        let found = self.rest().starts_with(token);
        if found {
            self.text = &self.text[token.len()..];
        }
        found
    }

    fn or(&mut self) -> Result<Value, String> {
        let mut left = self.and()?;
        while self.take("||") {
            let settled = u32::from(truth(&left));
            self.settled += settled;
            let right = self.and()?;
            self.settled -= settled;
            left = number(truth(&left) | truth(&right));
        }
        Ok(left)
    }

    fn and(&mut self) -> Result<Value, String> {
        let mut left = self.comparison()?;
        while self.take("&&") {
            let settled = u32::from(!truth(&left));
            self.settled += settled;
            let right = self.comparison()?;
            self.settled -= settled;
            left = number(truth(&left) & truth(&right));
        }
        Ok(left)
    }

    fn comparison(&mut self) -> Result<Value, String> {
        use std::cmp::Ordering::{Equal, Greater, Less};
        let left = self.unary()?;
        if self.take("=~") {
            return Err("\"=~\" (pattern match) is not available: expected a comparison".to_owned());
        }
        const OPERATORS: [&str; 6] = ["==", "!=", "<=", ">=", "<", ">"];
        let Some(operator) = OPERATORS.into_iter().find(|o| self.take(o)) else { return Ok(left) };
        let right = self.unary()?;
        let order = match (&left, &right) {
            (Value::Num(a), Value::Num(b)) => a.partial_cmp(b).unwrap_or(Equal),
            (Value::Text(a), Value::Text(b)) => a.cmp(b),
            _ if self.settled > 0 => Equal,
            _ => return Err(format!("{operator} compares a number with a string: expected the same types")),
        };
        Ok(number(match operator {
            "==" => order == Equal,
            "!=" => order != Equal,
            "<=" => order != Greater,
            ">=" => order != Less,
            "<" => order == Less,
            _ => order == Greater,
        }))
    }

    fn unary(&mut self) -> Result<Value, String> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(format!("expected at most {MAX_DEPTH} nested parentheses and negations"));
        }
        let value = self.operand();
        self.depth -= 1;
        value
    }

    fn operand(&mut self) -> Result<Value, String> {
        if !self.rest().starts_with("!=") && self.take("!") {
            return self.unary().map(|v| number(!truth(&v)));
        }
        if self.take("(") {
            let value = self.or()?;
            return if self.take(")") { Ok(value) } else { Err("expected \")\"".to_owned()) };
        }
        match self.rest().chars().next() {
            None => Err("expected a value, found the end".to_owned()),
            Some(quote @ ('\'' | '"')) => {
                let inside = &self.text[1..];
                let end = inside.find(quote).ok_or_else(|| format!("expected a closing {quote}"))?;
                self.text = &inside[end + 1..];
                Ok(Value::Text(inside[..end].to_owned()))
            }
            Some('0'..='9' | '.' | '-' | '+') => self.literal(),
            _ => self.variable(),
        }
    }

    fn literal(&mut self) -> Result<Value, String> {
        let in_number = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '+');
        let len = self.text.find(|c| !in_number(c)).unwrap_or(self.text.len());
        let (word, rest) = self.text.split_at(len);
        self.text = rest;
        let value = word.parse::<f64>().ok().filter(|v| v.is_finite());
        value.map(Value::Num).ok_or_else(|| format!("expected a number, found {word:?}"))
    }

    fn name(&mut self) -> Result<&str, String> {
        self.take("$");
        let braces = self.take("{");
        let in_name = |c: char| c.is_alphanumeric() || matches!(c, '_' | ':' | '.');
        let len = self.text.find(|c| !in_name(c)).unwrap_or(self.text.len());
        if len == 0 {
            return Err(format!("expected a value, found {:?}", self.text));
        }
        let (name, rest) = self.text.split_at(len);
        self.text = rest;
        if braces && !self.take("}") {
            return Err("expected \"}\"".to_owned());
        }
        Ok(name)
    }

    fn variable(&mut self) -> Result<Value, String> {
        let text = self.text;
        let name = self.name()?.to_owned();
        let dollar = text.starts_with('$');
        if name == "defined" && !dollar && self.take("(") {
            let asked = self.name()?.to_owned();
            let known = (self.lookup)(&asked).is_some();
            return if self.take(")") { Ok(number(known)) } else { Err("expected \")\"".to_owned()) };
        }
        let value = (self.lookup)(&name).or((self.settled > 0).then_some(Value::Num(0.0)));
        value.ok_or_else(|| format!("{name:?} has no value: expected an option or attribute"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lookup(name: &str) -> Option<Value> {
        match name {
            "user:pass" => Some(Value::Text("beauty".to_owned())),
            "user:level" => Some(Value::Num(3.0)),
            _ => None,
        }
    }

    #[test]
    fn operators_bind_as_in_c() {
        for (text, expected) in [
            ("1", true),
            ("0 || 1 && 0", false),
            ("(0 || 1) && 1", true),
            ("$user:pass == 'beauty'", true),
            ("user:pass != \"beauty\"", false),
            ("${user:level} >= 3 && $user:level < 4", true),
            ("!defined(user:none) && defined($user:level)", true),
            ("!!0", false),
            ("!(1 == 2)", true),
            ("-1 < +2.5e0", true),
            ("'a' < 'b'", true),
            ("defined(user:none) && $user:none == 'a'", false),
            ("1 || $user:none", true),
        ] {
            assert_eq!(holds(text, lookup), Ok(expected), "{text}");
        }
    }

    #[test]
    fn what_is_no_condition_says_what_was_expected() {
        let deep = "!".repeat(1000) + "1";
        for text in [
            "",
            "1 +",
            "user:none",
            "'a",
            "(1",
            "1 == 'a'",
            "1 2",
            "$user:pass =~ 'b.*'",
            "é",
            "$",
            "1e999",
            &deep,
        ] {
            let why = holds(text, lookup).expect_err(text);
            assert!(why.contains("expected"), "{text}: {why}");
        }
    }
}
