//! RON text as a tree that keeps the place of everything.
//!
//! The `ron` crate stops at the first error and drops places; a scene file's user wants all errors, each
//! with its line. So the grammar is read here: RON 0.12's values with `implicit_some`,
//! `unwrap_newtypes` and `unwrap_variant_newtypes` taken for granted. A syntax error is reported, the text
//! up to the end of the broken element is skipped, and reading goes on: [`Kind::Broken`] stands for it.

mod lexer;
mod parser;

pub use parser::parse;

use std::borrow::Cow;

/// A value and where it begins.
#[derive(Clone, Debug, PartialEq)]
pub struct Node<'a> {
    /// Byte offset of its first character.
    pub at: usize,
    /// The value.
    pub kind: Kind<'a>,
}

/// What a [`Node`] can be. Names are those in front of parentheses: `Euler(0, 90, 0)`.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind<'a> {
    /// A number as written.
    Number(&'a str),
    /// A bare word: `true`, `None`, `Repeat`.
    Word(&'a str),
    /// A string, unescaped.
    Text(Cow<'a, str>),
    /// `[a, b]`.
    List(Vec<Node<'a>>),
    /// `(a, b)` or `Name(a, b)`; also `()`.
    Tuple(Option<&'a str>, Vec<Node<'a>>),
    /// `(a: 1)` or `Name(a: 1)`.
    Record(Option<&'a str>, Vec<Entry<'a>>),
    /// `{a: 1}`.
    Map(Vec<(Node<'a>, Node<'a>)>),
    /// What could not be read; the problem is already reported.
    Broken,
}

/// A named field of a record.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry<'a> {
    /// Byte offset of the name.
    pub at: usize,
    /// The name.
    pub name: &'a str,
    /// The value.
    pub value: Node<'a>,
}

/// A place where the text is not RON.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SyntaxError {
    /// Byte offset.
    pub at: usize,
    /// What was found.
    pub what: String,
    /// What would have been right.
    pub expected: Option<String>,
}

impl Kind<'_> {
    /// What this is, in words, for messages.
    pub fn describe(&self) -> String {
        match self {
            Self::Number(text) => format!("the number {text}"),
            Self::Word(word) => format!("`{word}`"),
            Self::Text(text) => {
                let short: String = text.chars().take(40).collect();
                format!("the string {short:?}")
            }
            Self::List(items) => format!("a list of {}", items.len()),
            Self::Tuple(None, items) if items.is_empty() => "`()`".into(),
            Self::Tuple(None, items) => format!("a tuple of {}", items.len()),
            Self::Tuple(Some(name), _) | Self::Record(Some(name), _) => format!("`{name}(...)`"),
            Self::Record(None, _) => "a record `(name: ...)`".into(),
            Self::Map(_) => "a map `{...}`".into(),
            Self::Broken => "nothing readable".into(),
        }
    }
}
