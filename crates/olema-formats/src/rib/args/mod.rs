//! Arguments: a statement's values, read by its form in the table of statements.
//!
//! In: tokens. Out: [`Args`], whose buffers are used again for the next statement. Types are checked here; how
//! many values a parameter must have depends on the primitive and is checked by `params`.

mod read;

use std::ops::Range;

use super::declare::{Decl, Dictionary};
use super::fault::{Fault, Pos};
use super::lexer::Lexer;
use crate::room::Room;
use olema::scene::VarType;

/// One argument's values.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    /// Scalars in `nums`.
    Nums(Range<usize>),
    /// A range of `floats`.
    Floats(Range<usize>),
    /// A range of `ints`.
    Ints(Range<usize>),
    /// A range of `texts`; one for a plain string.
    Texts(Range<usize>),
    /// Left out.
    None,
}

/// A name and its values.
#[derive(Debug, Clone, PartialEq)]
pub struct ParamItem {
    /// Where the name stands.
    pub pos: Pos,
    /// Bytes of the name in `text`.
    name: Range<usize>,
    /// What it stands for.
    pub decl: Decl,
    /// A range of `floats`, or of `texts` for strings.
    values: Range<usize>,
}

/// The values of one statement.
#[derive(Debug, Clone, Default)]
pub struct Args {
    items: Vec<(Pos, Item)>,
    nums: Vec<f64>,
    floats: Vec<f32>,
    ints: Vec<i32>,
    /// All strings, one after the other.
    text: String,
    /// Where each string lies in `text`.
    texts: Vec<Range<usize>>,
    /// The parameters.
    pub params: Vec<ParamItem>,
}

/// What reading arguments needs besides the tokens.
pub struct Reading<'a> {
    /// The file.
    pub lexer: &'a mut Lexer,
    /// Declared names.
    pub dictionary: &'a Dictionary,
    /// The memory account.
    pub room: &'a mut Room,
    /// What is said and does not stop the statement.
    pub said: &'a mut Vec<Fault>,
}

impl Args {
    /// Forgets the values. Large buffers are given back.
    pub fn clear(&mut self, room: &mut Room) {
        if room.is_scratch_large() {
            *self = Args::default();
            room.clear_scratch();
            return;
        }
        self.items.clear();
        self.nums.clear();
        self.floats.clear();
        self.ints.clear();
        self.text.clear();
        self.texts.clear();
        self.params.clear();
    }

    /// Bytes on the heap once copied.
    pub fn heap_bytes(&self) -> u64 {
        let bytes = size_of_val(self.items.as_slice())
            + size_of_val(self.nums.as_slice())
            + size_of_val(self.floats.as_slice())
            + size_of_val(self.ints.as_slice())
            + self.text.len()
            + size_of_val(self.texts.as_slice())
            + size_of_val(self.params.as_slice());
        bytes as u64
    }

    /// The number of argument `ix`, 0 where it is not one.
    pub fn num(&self, ix: usize) -> f64 {
        self.nums(ix).first().copied().unwrap_or(0.0)
    }

    /// The whole number of argument `ix`.
    pub fn int(&self, ix: usize) -> i32 {
        self.num(ix) as i32
    }

    /// The numbers of argument `ix`; empty where it was left out or is no number.
    pub fn nums(&self, ix: usize) -> &[f64] {
        match self.items.get(ix) {
            Some((_, Item::Nums(range))) => self.nums.get(range.clone()).unwrap_or(&[]),
            _ => &[],
        }
    }

    /// The numbers of argument `ix` as an array; `None` where they are not that many.
    pub fn array<const N: usize>(&self, ix: usize) -> Option<[f64; N]> {
        self.nums(ix).try_into().ok()
    }

    /// The array of floats of argument `ix`.
    pub fn floats(&self, ix: usize) -> &[f32] {
        match self.items.get(ix) {
            Some((_, Item::Floats(range))) => self.floats.get(range.clone()).unwrap_or(&[]),
            _ => &[],
        }
    }

    /// The array of integers of argument `ix`.
    pub fn ints(&self, ix: usize) -> &[i32] {
        match self.items.get(ix) {
            Some((_, Item::Ints(range))) => self.ints.get(range.clone()).unwrap_or(&[]),
            _ => &[],
        }
    }

    /// The string of argument `ix`, or the first of its array; `None` where it is not a string.
    pub fn text(&self, ix: usize) -> Option<&str> {
        self.texts(ix).next()
    }

    /// The strings of argument `ix`.
    pub fn texts(&self, ix: usize) -> impl ExactSizeIterator<Item = &str> {
        let range = match self.items.get(ix) {
            Some((_, Item::Texts(range))) => range.clone(),
            _ => 0..0,
        };
        self.texts.get(range).unwrap_or(&[]).iter().map(|r| self.text.get(r.clone()).unwrap_or(""))
    }

    /// Where argument `ix` stands.
    pub fn pos(&self, ix: usize) -> Pos {
        self.items.get(ix).map(|i| i.0).unwrap_or_default()
    }

    /// Whether argument `ix` was left out.
    pub fn is_none(&self, ix: usize) -> bool {
        matches!(self.items.get(ix), None | Some((_, Item::None)))
    }

    /// A parameter's name.
    pub fn param_name(&self, param: &ParamItem) -> &str {
        self.text.get(param.name.clone()).unwrap_or("")
    }

    /// A parameter's numbers; empty for strings.
    pub fn param_floats(&self, param: &ParamItem) -> &[f32] {
        if param.decl.ty == VarType::String {
            &[]
        } else {
            self.floats.get(param.values.clone()).unwrap_or(&[])
        }
    }

    /// A parameter's strings; empty for numbers.
    pub fn param_texts(&self, param: &ParamItem) -> impl ExactSizeIterator<Item = &str> {
        let range = if param.decl.ty == VarType::String { param.values.clone() } else { 0..0 };
        self.texts.get(range).unwrap_or(&[]).iter().map(|r| self.text.get(r.clone()).unwrap_or(""))
    }

    /// Number of floats or strings that a parameter was given.
    pub fn param_len(&self, param: &ParamItem) -> usize {
        param.values.len()
    }

    /// The last parameter of that name.
    pub fn find(&self, name: &str) -> Option<&ParamItem> {
        self.params.iter().rev().find(|p| self.param_name(p) == name)
    }
}
