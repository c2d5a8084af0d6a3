//! Numbers, strings, vectors and colours of the scene file. Numbers are finite.

use glam::{DVec3, Vec3};

use crate::scene::problem::Place;
use crate::scene::reader::{Reader, Schema};
use crate::scene::syntax::{Kind, Node};
use crate::scene::writer::Writer;

/// A value and the place it was read from, for problems found later on. Places do not take part in `==`.
#[derive(Clone, Debug, Default)]
pub struct At<T> {
    /// The value.
    pub value: T,
    /// Where it stood; the default where it came from no file.
    pub place: Place,
}

impl<T> From<T> for At<T> {
    fn from(value: T) -> Self {
        Self {
            value,
            place: Place::default(),
        }
    }
}

impl<T: PartialEq> PartialEq for At<T> {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

impl<T: Schema> Schema for At<T> {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        let place = reader.place(node.at);
        T::read(reader, node).map(|value| Self { value, place })
    }

    fn write(&self, writer: &mut Writer) {
        self.value.write(writer);
    }
}

/// The text of a number as Rust reads it.
fn number_text(reader: &mut Reader, node: &Node, expected: &str) -> Option<String> {
    match &node.kind {
        Kind::Number(text) => Some(text.replace('_', "")),
        Kind::Word(text @ ("inf" | "NaN")) => Some((*text).to_owned()),
        _ => reader.mismatch(node, expected),
    }
}

macro_rules! float {
    ($type:ty) => {
        impl Schema for $type {
            fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
                let text = number_text(reader, node, "a number")?;
                match text.parse::<$type>() {
                    Ok(value) if value.is_finite() => Some(value),
                    Ok(_) => reader.mismatch(node, "a finite number"),
                    Err(_) => reader.mismatch(node, "a number"),
                }
            }

            fn write(&self, writer: &mut Writer) {
                // The shortest text that reads back to the same bits; whole numbers without ".0".
                let text = format!("{self:?}");
                writer.atom(text.strip_suffix(".0").unwrap_or(&text));
            }
        }
    };
}
float!(f32);
float!(f64);

impl Schema for u32 {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        let text = number_text(reader, node, "a whole number")?;
        match text.parse() {
            Ok(value) => Some(value),
            Err(_) => reader.mismatch(node, "a whole number of at least 0"),
        }
    }

    fn write(&self, writer: &mut Writer) {
        writer.atom(&self.to_string());
    }
}

impl Schema for bool {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        match node.kind {
            Kind::Word("true") => Some(true),
            Kind::Word("false") => Some(false),
            _ => reader.mismatch(node, "`true` or `false`"),
        }
    }

    fn write(&self, writer: &mut Writer) {
        writer.atom(if *self { "true" } else { "false" });
    }
}

impl Schema for String {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        match &node.kind {
            Kind::Text(text) => Some(text.clone().into_owned()),
            _ => reader.mismatch(node, "a string in quotes"),
        }
    }

    fn write(&self, writer: &mut Writer) {
        writer.string(self);
    }
}

impl<T: Schema> Schema for Option<T> {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        match &node.kind {
            Kind::Word("None") => Some(None),
            _ => T::read(reader, node).map(Some),
        }
    }

    fn write(&self, writer: &mut Writer) {
        match self {
            Some(value) => value.write(writer),
            None => writer.atom("None"),
        }
    }
}

/// `N` numbers in parentheses.
pub(super) fn numbers<const N: usize, T: Schema + Copy + Default>(
    reader: &mut Reader,
    node: &Node,
    expected: &str,
) -> Option<[T; N]> {
    let Kind::Tuple(None, items) = &node.kind else {
        return reader.mismatch(node, expected);
    };
    if items.len() != N {
        return reader.mismatch(node, expected);
    }
    let mut values = [T::default(); N];
    let mut complete = true;
    for (value, item) in values.iter_mut().zip(items) {
        match T::read(reader, item) {
            Some(read) => *value = read,
            None => complete = false,
        }
    }
    complete.then_some(values)
}

/// Writes numbers in parentheses.
pub(super) fn write_numbers<T: Schema>(writer: &mut Writer, name: Option<&str>, values: &[T]) {
    writer.record(name, |writer| {
        for value in values {
            writer.item(value);
        }
    });
}

impl Schema for DVec3 {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        numbers(reader, node, "three numbers (x, y, z)").map(Self::from_array)
    }

    fn write(&self, writer: &mut Writer) {
        write_numbers(writer, None, &self.to_array());
    }
}

/// A linear RGB colour of at least 0: three numbers, or one for a grey.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Color(pub Vec3);

impl From<Vec3> for Color {
    fn from(color: Vec3) -> Self {
        Self(color)
    }
}

impl From<Color> for Vec3 {
    fn from(color: Color) -> Self {
        color.0
    }
}

impl Schema for Color {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        let color = match &node.kind {
            Kind::Number(_) => Vec3::splat(f32::read(reader, node)?),
            _ => Vec3::from_array(numbers(
                reader,
                node,
                "a colour (r, g, b), or one number for a grey",
            )?),
        };
        if color.min_element() < 0.0 {
            let text = Writer::text_of(&Self(color));
            reader.expected(node.at, format!("found {text}"), "numbers of at least 0");
            return None;
        }
        Some(Self(color))
    }

    fn write(&self, writer: &mut Writer) {
        write_numbers(writer, None, &self.0.to_array());
    }
}

/// Factors along the axes: three numbers, or one for all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale(pub DVec3);

impl From<DVec3> for Scale {
    fn from(scale: DVec3) -> Self {
        Self(scale)
    }
}

impl From<Scale> for DVec3 {
    fn from(scale: Scale) -> Self {
        scale.0
    }
}

impl Schema for Scale {
    fn read(reader: &mut Reader, node: &Node) -> Option<Self> {
        match &node.kind {
            Kind::Number(_) => f64::read(reader, node).map(|scale| Self(DVec3::splat(scale))),
            _ => numbers(reader, node, "three numbers (x, y, z), or one for all")
                .map(|scale| Self(DVec3::from_array(scale))),
        }
    }

    fn write(&self, writer: &mut Writer) {
        let [x, y, z] = self.0.to_array();
        if x.to_bits() == y.to_bits() && y.to_bits() == z.to_bits() {
            x.write(writer);
        } else {
            self.0.write(writer);
        }
    }
}
