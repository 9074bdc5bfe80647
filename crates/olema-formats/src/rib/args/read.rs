//! Reading arguments: tokens to values, by a statement's form.

use std::ops::Range;

use olema::scene::VarType;

use super::super::declare::{Decl, Found};
use super::super::fault::{Fault, Pos};
use super::super::lexer::Token;
use super::super::statements::{Arg, Id, Statement};
use super::{Args, Item, ParamItem, Reading};

impl Args {
    /// Reads the arguments of `statement`. `Ok(true)` where more follows than it takes, which is said.
    pub fn read(&mut self, statement: &Statement, r: &mut Reading<'_>) -> Result<bool, Fault> {
        for arg in statement.form {
            match *arg {
                Arg::Params => self.read_params(statement.id, r)?,
                Arg::Tags => self.read_tags(r)?,
                arg => {
                    let token = r.lexer.peek();
                    let pos = r.lexer.here();
                    let item = self.read_item(arg, token, r)?;
                    self.items.push((pos, item));
                }
            }
        }
        // A world is handed out when it ends: on an open pipe what follows may not be there yet.
        if statement.id == Id::WorldEnd {
            return Ok(false);
        }
        if matches!(r.lexer.peek(), Token::Word | Token::End | Token::Stray(0x80..)) {
            return Ok(false);
        }
        let expected = match statement.form.last() {
            Some(Arg::Params) => "a parameter's name or the next statement",
            _ => "the next statement (too many arguments?)",
        };
        let mut fault = wrong(r, expected);
        fault.message.push_str("; ignored");
        r.said.push(fault);
        Ok(true)
    }

    fn read_item(&mut self, arg: Arg, token: Token, r: &mut Reading<'_>) -> Result<Item, Fault> {
        match (arg, token) {
            (Arg::Int(name), Token::Number | Token::Open) => {
                let item = self.read_nums(name, 1, r)?;
                let value = self.nums.last().copied().unwrap_or(0.0);
                if value.fract() != 0.0 || value.abs() > f64::from(i32::MAX) {
                    return Err(Fault::error(
                        r.lexer.here(),
                        format!("{name} is {value}: expected an integer"),
                    ));
                }
                Ok(item)
            }
            (Arg::Num(name), Token::Number | Token::Open) => self.read_nums(name, 1, r),
            (Arg::Nums(name, count), Token::Number | Token::Open) => self.read_nums(name, count, r),
            (Arg::MaybeNums(..), Token::Word) if !r.lexer.is_at_not_a_number() => Ok(Item::None),
            (Arg::MaybeNums(..), Token::End) => Ok(Item::None),
            (Arg::MaybeNums(name, count), Token::Number | Token::Open) => {
                if r.lexer.dash() {
                    Ok(Item::None)
                } else {
                    self.read_nums(name, count, r)
                }
            }
            (Arg::Handle(name), Token::Number) => self.read_nums(name, 1, r),
            (Arg::Basis(name), Token::Number | Token::Open) => self.read_nums(name, 16, r),
            (Arg::Floats(_), Token::Open) => {
                r.lexer.bump();
                let start = self.floats.len();
                r.lexer.floats(&mut self.floats, r.room)?;
                Ok(Item::Floats(start..self.floats.len()))
            }
            (Arg::Ints(_), Token::Open) => {
                r.lexer.bump();
                let start = self.ints.len();
                r.lexer.integers(&mut self.ints, r.room)?;
                Ok(Item::Ints(start..self.ints.len()))
            }
            (Arg::Texts(_), Token::Open | Token::Text) => Ok(Item::Texts(self.read_texts(r)?)),
            (Arg::Text(name) | Arg::Handle(name) | Arg::Basis(name), Token::Text | Token::Open) => {
                let pos = r.lexer.here();
                let texts = self.read_texts(r)?;
                if texts.len() != 1 {
                    return Err(Fault::error(
                        pos,
                        format!("expected one string for {name}, found {}", texts.len()),
                    ));
                }
                Ok(Item::Texts(texts))
            }
            _ => Err(wrong(r, &arg.usage())),
        }
    }

    fn read_nums(&mut self, name: &str, count: usize, r: &mut Reading<'_>) -> Result<Item, Fault> {
        let pos = r.lexer.here();
        let bracket = r.lexer.peek() == Token::Open;
        if bracket {
            r.lexer.bump();
        }
        let start = self.nums.len();
        for found in 0..count {
            match r.lexer.peek() {
                Token::Number => self.nums.push(r.lexer.number()?),
                other => {
                    let other = r.lexer.describe(other);
                    let message = format!("expected {count} numbers for {name}, found {other} after {found}");
                    return Err(Fault::error(r.lexer.here(), message));
                }
            }
        }
        if bracket {
            if r.lexer.peek() != Token::Close {
                let message = format!("expected {count} numbers for {name} in this array, found more");
                return Err(Fault::error(pos, message));
            }
            r.lexer.bump();
        }
        Ok(Item::Nums(start..self.nums.len()))
    }

    /// Reads one string or an array of them.
    fn read_texts(&mut self, r: &mut Reading<'_>) -> Result<Range<usize>, Fault> {
        let start = self.texts.len();
        if r.lexer.peek() != Token::Open {
            self.read_text(r)?;
            return Ok(start..self.texts.len());
        }
        r.lexer.bump();
        loop {
            match r.lexer.peek() {
                Token::Text => self.read_text(r)?,
                Token::Close => {
                    r.lexer.bump();
                    return Ok(start..self.texts.len());
                }
                other => return Err(r.lexer.not_in_array(other, "strings")),
            }
        }
    }

    fn read_text(&mut self, r: &mut Reading<'_>) -> Result<(), Fault> {
        let pos = r.lexer.here();
        let start = self.text.len();
        if !r.lexer.text(&mut self.text, r.room)? {
            r.said
                .push(Fault::warning(pos, "this string is not UTF-8: the bytes that are not were replaced"));
        }
        let range = start..self.text.len();
        let Reading { lexer, room, .. } = r;
        lexer.push(&mut self.texts, range, room)
    }

    fn read_tags(&mut self, r: &mut Reading<'_>) -> Result<(), Fault> {
        const FORM: [Arg; 5] = [
            Arg::Texts("tags"),
            Arg::Ints("tag counts"),
            Arg::Ints("tag integers"),
            Arg::Floats("tag floats"),
            Arg::Texts("tag strings"),
        ];
        let present = r.lexer.peek() == Token::Open;
        for (ix, arg) in FORM.into_iter().enumerate() {
            let token = r.lexer.peek();
            let pos = r.lexer.here();
            let left_out = ix == 4 && token != Token::Open;
            let item = if present && !left_out { self.read_item(arg, token, r)? } else { Item::None };
            self.items.push((pos, item));
        }
        Ok(())
    }

    fn read_params(&mut self, id: Id, r: &mut Reading<'_>) -> Result<(), Fault> {
        while r.lexer.peek() == Token::Text {
            let pos = r.lexer.here();
            let start = self.text.len();
            self.read_text(r)?;
            // The token is no value: its name is kept as a range instead.
            self.texts.pop();
            let token = self.text.get(start..).unwrap_or("");
            let name_at = |name: &str| {
                let from = start + (name.as_ptr() as usize).saturating_sub(token.as_ptr() as usize);
                from..from + name.len()
            };
            let (name, mut decl, guessed) = match r.dictionary.find(token) {
                Found::Known(name, decl) => (name_at(name), decl, false),
                Found::Wrong(why) => return Err(Fault::error(pos, format!("\"{token}\": {why}"))),
                Found::Unknown(name) => (name_at(name), guess(id, name, pos, r), true),
            };
            let values = self.read_values(&decl, r)?;
            if guessed {
                decl.array_len = u32::try_from(values.len().max(1)).unwrap_or(u32::MAX);
            }
            let param = ParamItem { pos, name, decl, values };
            let Reading { lexer, room, .. } = r;
            lexer.push(&mut self.params, param, room)?;
        }
        Ok(())
    }

    fn read_values(&mut self, decl: &Decl, r: &mut Reading<'_>) -> Result<Range<usize>, Fault> {
        let token = r.lexer.peek();
        match (decl.ty, token) {
            (VarType::String, Token::Text | Token::Open) => self.read_texts(r),
            (VarType::String, _) => Err(wrong(r, "a string")),
            (_, Token::Open) => {
                r.lexer.bump();
                let start = self.floats.len();
                if decl.ty == VarType::Integer {
                    let from = self.ints.len();
                    r.lexer.integers(&mut self.ints, r.room)?;
                    for ix in from..self.ints.len() {
                        r.lexer.push(&mut self.floats, self.ints[ix] as f32, r.room)?;
                    }
                    self.ints.truncate(from);
                } else {
                    r.lexer.floats(&mut self.floats, r.room)?;
                }
                Ok(start..self.floats.len())
            }
            (ty, Token::Number) => {
                let value =
                    if ty == VarType::Integer { r.lexer.integer()? as f32 } else { r.lexer.float()? };
                let Reading { lexer, room, .. } = r;
                lexer.push(&mut self.floats, value, room)?;
                Ok(self.floats.len() - 1..self.floats.len())
            }
            _ => Err(wrong(r, &format!("numbers ({})", decl.describe()))),
        }
    }
}

/// Something else stands where an argument was expected.
fn wrong(r: &mut Reading<'_>, expected: &str) -> Fault {
    let token = r.lexer.peek();
    let pos = r.lexer.here();
    let found = r.lexer.describe(token);
    Fault::error(pos, format!("expected {expected}, found {found}"))
}

/// What a name that nothing declares is taken for: a string or a float, by its value.
fn guess(id: Id, name: &str, pos: Pos, r: &mut Reading<'_>) -> Decl {
    let mut token = r.lexer.peek();
    if token == Token::Open {
        token = r.lexer.first_in_array();
    }
    let decl = if token == Token::Text { Decl::STRING } else { Decl::FLOAT };
    // A display driver's parameters are between the file and the driver.
    if !matches!(id, Id::Display | Id::Option | Id::Attribute | Id::Hider) {
        let taken = decl.describe();
        let message = format!("\"{name}\" is not declared: taken as \"{taken}\"; expected a declaration");
        r.said.push(Fault::warning(pos, message));
    }
    decl
}
