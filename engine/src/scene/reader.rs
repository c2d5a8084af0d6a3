//! From the tree of a file to values of the schema, collecting what does not fit.
//!
//! [`Schema`] is one trait for both directions, so that what is saved is what can be read. A reader that
//! returns `None` has reported why.

use super::problem::{Place, RawProblem, nearest};
use super::syntax::{Entry, Kind, Node};
use super::writer::Writer;

/// Problems kept; what comes after is more of the same.
const MAX_PROBLEMS: usize = 1000;

/// A type of the scene file.
pub trait Schema: Sized {
    /// The value of a node; none, and a problem, where it does not fit.
    fn read(reader: &mut Reader, node: &Node) -> Option<Self>;

    /// The text that [`Schema::read`] reads back to the same bits.
    fn write(&self, writer: &mut Writer);
}

/// Collects problems, and knows the path of the field being read.
#[derive(Default)]
pub struct Reader {
    path: String,
    pub(super) problems: Vec<RawProblem>,
}

impl Reader {
    /// The place of a byte in the field being read.
    pub fn place(&self, at: usize) -> Place {
        Place {
            at,
            field: self.path.trim_start_matches('.').to_owned(),
        }
    }

    /// Reports that `what` was found where `expected` should have been.
    pub fn expected(&mut self, at: usize, what: impl Into<String>, expected: impl Into<String>) {
        self.report(at, what, Some(expected.into()), None);
    }

    /// Reports a problem at a byte of the field being read.
    pub fn report(
        &mut self,
        at: usize,
        what: impl Into<String>,
        expected: Option<String>,
        suggestion: Option<String>,
    ) {
        let place = self.place(at);
        self.report_at(place, what, expected, suggestion);
    }

    /// Reports a problem at a place kept from before.
    pub fn report_at(
        &mut self,
        place: Place,
        what: impl Into<String>,
        expected: Option<String>,
        suggestion: Option<String>,
    ) {
        if self.problems.len() < MAX_PROBLEMS {
            self.problems.push(RawProblem {
                place,
                what: what.into(),
                expected,
                suggestion,
            });
        }
    }

    /// Reports a node that is not what it should be. What was not even readable is reported already.
    pub fn mismatch<T>(&mut self, node: &Node, expected: &str) -> Option<T> {
        if node.kind != Kind::Broken {
            self.expected(node.at, format!("found {}", node.kind.describe()), expected);
        }
        None
    }

    /// Reports a name that is none of `valid`.
    pub fn unknown<'n>(
        &mut self,
        at: usize,
        what: &str,
        name: &str,
        valid: impl IntoIterator<Item = &'n str>,
    ) {
        let valid: Vec<&str> = valid.into_iter().collect();
        let suggestion = nearest(name, valid.iter().copied());
        let mut list = valid
            .iter()
            .take(24)
            .copied()
            .collect::<Vec<_>>()
            .join(", ");
        if valid.len() > 24 {
            list.push_str(", ...");
        }
        let expected = if valid.is_empty() {
            format!("a {what} that exists (there is none)")
        } else {
            format!("one of {list}")
        };
        let short: String = name.chars().take(60).collect();
        self.report(
            at,
            format!("unknown {what} `{short}`"),
            Some(expected),
            suggestion,
        );
    }

    /// Runs `read` with a step added to the path: `.name`, `[3]` or ` "label"`.
    pub fn within<T>(&mut self, step: &str, read: impl FnOnce(&mut Self) -> T) -> T {
        let length = self.path.len();
        self.path.push_str(step);
        let value = read(self);
        self.path.truncate(length);
        value
    }

    /// The fields of a record without a name in front; unknown and repeated ones are reported.
    pub fn record<'n, 'a>(
        &mut self,
        node: &'n Node<'a>,
        valid: &[&str],
        what: &str,
    ) -> Option<Fields<'n, 'a>> {
        match &node.kind {
            Kind::Record(None, _) => Some(self.fields(node, valid)),
            Kind::Tuple(None, items) if items.is_empty() => Some(self.fields(node, valid)),
            _ => self.mismatch(node, &format!("{what} as `(name: value, ...)`")),
        }
    }

    /// The fields of a record, whatever name is in front.
    pub fn fields<'n, 'a>(&mut self, node: &'n Node<'a>, valid: &[&str]) -> Fields<'n, 'a> {
        let entries: &[Entry] = match &node.kind {
            Kind::Record(_, entries) => entries,
            _ => &[],
        };
        for (i, entry) in entries.iter().enumerate() {
            if !valid.contains(&entry.name) {
                self.unknown(entry.at, "field", entry.name, valid.iter().copied());
            } else if entries[..i].iter().any(|before| before.name == entry.name) {
                self.within(&format!(".{}", entry.name), |reader| {
                    reader.report(
                        entry.at,
                        "the field is there twice",
                        Some("it once".into()),
                        None,
                    );
                });
            }
        }
        Fields {
            at: node.at,
            entries,
        }
    }

    /// Reads each item of a list; items that do not fit are left out.
    pub fn list<T>(
        &mut self,
        node: &Node,
        what: &str,
        mut read: impl FnMut(&mut Self, &Node) -> Option<T>,
    ) -> Option<Vec<T>> {
        let Kind::List(items) = &node.kind else {
            return self.mismatch(node, &format!("{what} as `[...]`"));
        };
        let values = items
            .iter()
            .enumerate()
            .filter_map(|(i, item)| self.within(&format!("[{i}]"), |reader| read(reader, item)));
        Some(values.collect())
    }
}

/// The fields of one record.
pub struct Fields<'n, 'a> {
    /// Byte offset of the record.
    pub at: usize,
    entries: &'n [Entry<'a>],
}

impl<'n, 'a> Fields<'n, 'a> {
    /// The entry of a field, if it is there and not `None`.
    pub fn get(&self, name: &str) -> Option<&'n Entry<'a>> {
        self.entries
            .iter()
            .find(|entry| entry.name == name && entry.value.kind != Kind::Word("None"))
    }

    /// Reads a field with `read`, if it is there.
    pub fn with<T>(
        &self,
        reader: &mut Reader,
        name: &str,
        read: impl FnOnce(&mut Reader, &Node) -> Option<T>,
    ) -> Option<T> {
        let entry = self.get(name)?;
        reader.within(&format!(".{name}"), |reader| {
            // `Some(x)` is x: files written for the strict RON of the `ron` crate are welcome.
            match &entry.value.kind {
                Kind::Tuple(Some("Some"), inner) if inner.len() == 1 => read(reader, &inner[0]),
                _ => read(reader, &entry.value),
            }
        })
    }

    /// Reads a field, if it is there.
    pub fn read<T: Schema>(&self, reader: &mut Reader, name: &str) -> Option<T> {
        self.with(reader, name, T::read)
    }

    /// Reads a field, if it is there, and refuses a value out of range.
    pub fn read_checked<T: Schema>(
        &self,
        reader: &mut Reader,
        name: &str,
        check: fn(&T) -> Result<(), &'static str>,
    ) -> Option<T> {
        self.with(reader, name, |reader, node| {
            let value = T::read(reader, node)?;
            match check(&value) {
                Ok(()) => Some(value),
                Err(expected) => {
                    let mut text = Writer::inline();
                    value.write(&mut text);
                    reader.expected(node.at, format!("found {}", text.finish()), expected);
                    None
                }
            }
        })
    }
}

/// Implements [`Schema`] for a struct with a default: the names of the file beside the fields of the type.
///
/// `"name" => field: SchemaType` converts by `From` both ways; `, check` refuses values out of range. A
/// field equal to its default, bit for bit, is not written.
macro_rules! record {
    ($what:literal, $type:ty {
        $($name:literal => $field:ident $(. $part:ident)*: $schema:ty $(, $check:path)?;)*
    } $(, $whole:path)?) => {
        impl $crate::scene::reader::Schema for $type {
            fn read(
                reader: &mut $crate::scene::reader::Reader,
                node: &$crate::scene::syntax::Node,
            ) -> Option<Self> {
                let fields = reader.record(node, &[$($name),*], $what)?;
                let mut value = <$type>::default();
                $(
                    let check: fn(&$schema) -> Result<(), &'static str> =
                        $crate::scene::reader::record!(@check $($check)?);
                    if let Some(read) = fields.read_checked::<$schema>(reader, $name, check) {
                        value.$field $(. $part)* = read.into();
                    }
                )*
                $($whole(reader, &fields, &value)?;)?
                Some(value)
            }

            fn write(&self, writer: &mut $crate::scene::writer::Writer) {
                let default = <$type>::default();
                writer.record(None, |writer| {
                    $(writer.field_unless_default(
                        $name,
                        &<$schema>::from(self.$field $(. $part)*.clone()),
                        &<$schema>::from(default.$field $(. $part)*.clone()),
                    );)*
                });
            }
        }
    };
    (@check $check:path) => { $check };
    (@check) => { |_| Ok(()) };
}
pub(super) use record;
