//! Values to RON text a person would have written: short things on one line, long ones indented.

use super::reader::Schema;

/// Columns up to which a bracket stays on one line.
const WIDTH: usize = 100;

/// Builds the text of a value.
///
/// Every bracket is first written on one line; one that comes out too long is broken into a line an
/// element. The text is a pure function of the values, so saving twice gives the same bytes.
pub struct Writer {
    /// Elements of the open brackets, outermost first.
    open: Vec<Vec<String>>,
    done: String,
    /// Whether everything goes on one line.
    inline: bool,
}

impl Writer {
    /// A writer that breaks long lines.
    pub fn pretty() -> Self {
        Self {
            open: Vec::new(),
            done: String::new(),
            inline: false,
        }
    }

    /// A writer of one line, for messages and comparisons.
    pub fn inline() -> Self {
        Self {
            inline: true,
            ..Self::pretty()
        }
    }

    /// The text.
    pub fn finish(self) -> String {
        self.done
    }

    /// The text of one value on one line.
    pub fn text_of<T: Schema>(value: &T) -> String {
        let mut writer = Self::inline();
        value.write(&mut writer);
        writer.finish()
    }

    /// Writes a number, a word or a string as it is.
    pub fn atom(&mut self, text: &str) {
        self.done.push_str(text);
    }

    /// Writes a string in quotes, escaped.
    pub fn string(&mut self, text: &str) {
        let mut quoted = String::with_capacity(text.len() + 2);
        quoted.push('"');
        for c in text.chars() {
            match c {
                '"' => quoted.push_str("\\\""),
                '\\' => quoted.push_str("\\\\"),
                '\n' => quoted.push_str("\\n"),
                '\r' => quoted.push_str("\\r"),
                '\t' => quoted.push_str("\\t"),
                c if c.is_control() => quoted.push_str(&format!("\\u{{{:x}}}", u32::from(c))),
                c => quoted.push(c),
            }
        }
        quoted.push('"');
        self.atom(&quoted);
    }

    /// `name(...)` around what `write` adds by [`Writer::field`] and [`Writer::item`].
    pub fn record(&mut self, name: Option<&str>, write: impl FnOnce(&mut Self)) {
        self.bracket(&format!("{}(", name.unwrap_or_default()), ")", false, write);
    }

    /// `[...]`; one whose elements are records of their own is broken into lines if `tall`.
    pub fn list(&mut self, tall: bool, write: impl FnOnce(&mut Self)) {
        self.bracket("[", "]", tall, write);
    }

    /// `{...}`, a line an element.
    pub fn map(&mut self, write: impl FnOnce(&mut Self)) {
        self.bracket("{", "}", true, write);
    }

    /// An element without a name.
    pub fn item<T: Schema>(&mut self, value: &T) {
        self.element("", |writer| value.write(writer));
    }

    /// An element with a name.
    pub fn field<T: Schema>(&mut self, name: &str, value: &T) {
        self.element(&format!("{name}: "), |writer| value.write(writer));
    }

    /// A named element, unless its text is that of the default.
    pub fn field_unless_default<T: Schema>(&mut self, name: &str, value: &T, default: &T) {
        if Self::text_of(value) != Self::text_of(default) {
            self.field(name, value);
        }
    }

    /// A named element that is there or not.
    pub fn field_if<T: Schema>(&mut self, name: &str, value: Option<&T>) {
        if let Some(value) = value {
            self.field(name, value);
        }
    }

    /// An element of the open bracket: `prefix` and what `write` writes.
    pub fn element(&mut self, prefix: &str, write: impl FnOnce(&mut Self)) {
        let outer = std::mem::replace(&mut self.done, prefix.to_owned());
        write(self);
        let element = std::mem::replace(&mut self.done, outer);
        if let Some(open) = self.open.last_mut() {
            open.push(element);
        }
    }

    fn bracket(&mut self, open: &str, close: &str, tall: bool, write: impl FnOnce(&mut Self)) {
        self.open.push(Vec::new());
        write(self);
        let elements = self.open.pop().unwrap_or_default();
        let width: usize = elements.iter().map(|element| element.len() + 2).sum();
        // The name before the bracket and what encloses it take columns too.
        let used = self.done.len() + open.len() + 4 * self.open.len();
        let long = used + width > WIDTH || elements.iter().any(|element| element.contains('\n'));
        self.done.push_str(open);
        if self.inline || elements.is_empty() || !(long || tall) {
            self.done.push_str(&elements.join(", "));
        } else {
            for element in elements {
                self.done.push_str("\n    ");
                push_indented(&mut self.done, &element);
                self.done.push(',');
            }
            self.done.push('\n');
        }
        self.done.push_str(close);
    }
}

/// Strings hold no line breaks of their own (they are escaped), so every line may be indented.
fn push_indented(text: &mut String, element: &str) {
    for (i, line) in element.split('\n').enumerate() {
        if i > 0 {
            text.push_str("\n    ");
        }
        text.push_str(line);
    }
}
