//! The words of an NFF or AFF text, each with its line. Called by the statements' readers.
//!
//! Whitespace parts words, line ends mean nothing more, `{` and `}` are words of their own, and `#` (in AFF also `%`)
//! makes the rest of its line a comment. Counts are checked against the bytes that are left before anything of
//! their size is allocated.

use glam::{DVec3, Vec3};

use crate::world::FARTHEST;

/// Where reading is. A copy looks ahead.
#[derive(Clone, Copy, Debug)]
pub struct Words<'t> {
    rest: &'t str,
    line: usize,
    /// Which included file, in sentences; empty for the file itself.
    file: &'t str,
}

/// A place in a text.
#[derive(Clone, Copy, Debug)]
pub struct Mark {
    left: usize,
    line: usize,
}

impl<'t> Words<'t> {
    /// All words of a text. `file` names it in sentences; empty: need not be named.
    pub fn new(text: &'t str, file: &'t str) -> Self {
        Self {
            rest: text,
            line: 1,
            file,
        }
    }

    /// Bytes that are left: no two words of one text have the same number.
    pub fn left(&self) -> usize {
        self.rest.len()
    }

    /// Where reading is, for [`Words::go_to`].
    pub fn mark(&self) -> Mark {
        Mark {
            left: self.rest.len(),
            line: self.line,
        }
    }

    /// Goes on from a place further on in the same text.
    pub fn go_to(&mut self, mark: Mark) {
        let skipped = self.rest.len().saturating_sub(mark.left);
        self.rest = self.rest.get(skipped..).unwrap_or_default();
        self.line = mark.line;
    }

    /// Which text, as sentences call it.
    pub fn file(&self) -> &'t str {
        self.file
    }

    /// "line 3", or "line 3 of `walls.aff`".
    pub fn place(&self) -> String {
        if self.file.is_empty() {
            format!("line {}", self.line)
        } else {
            format!("line {} of `{}`", self.line, self.file)
        }
    }

    /// The next word; none at the end.
    pub fn next(&mut self) -> Option<&'t str> {
        self.skip_blanks();
        let first = self.rest.chars().next()?;
        let length = if matches!(first, '{' | '}') {
            1
        } else {
            let ends = |c: char| c.is_whitespace() || matches!(c, '{' | '}' | '#');
            self.rest.find(ends).unwrap_or(self.rest.len())
        };
        let (word, rest) = self.rest.split_at(length);
        self.rest = rest;
        Some(word)
    }

    /// The next word without going past it.
    pub fn peek(&self) -> Option<&'t str> {
        let mut ahead = *self;
        ahead.next()
    }

    /// Whether the next word is a number.
    pub fn is_number_next(&self) -> bool {
        self.peek().is_some_and(|word| word.parse::<f64>().is_ok())
    }

    /// The next word, if it is on the line of the last one and no number.
    pub fn next_on_line(&mut self) -> Option<&'t str> {
        let mut ahead = *self;
        let word = ahead.next()?;
        let fits = ahead.line == self.line && word.parse::<f64>().is_err();
        fits.then(|| {
            *self = ahead;
            word
        })
    }

    fn skip_blanks(&mut self) {
        loop {
            let trimmed = self.rest.trim_start();
            let blank = &self.rest[..self.rest.len() - trimmed.len()];
            self.line += blank.bytes().filter(|&byte| byte == b'\n').count();
            self.rest = trimmed;
            if !trimmed.starts_with(['#', '%']) {
                return;
            }
            self.rest = &trimmed[trimmed.find('\n').unwrap_or(trimmed.len())..];
        }
    }

    /// A word that must be there.
    ///
    /// # Errors
    /// The file ends.
    pub fn word(&mut self, what: &str) -> Result<&'t str, String> {
        self.next()
            .ok_or_else(|| format!("{}: the file ends where {what} should be", self.place()))
    }

    /// A word that must be this one.
    ///
    /// # Errors
    /// It is another.
    pub fn expect(&mut self, expected: &str) -> Result<(), String> {
        let found = self.word(&format!("`{expected}`"))?;
        if found == expected {
            Ok(())
        } else {
            Err(self.wrong(&format!("`{expected}`"), found))
        }
    }

    /// The sentence that another word should be here.
    pub fn wrong(&self, expected: &str, found: &str) -> String {
        let short: String = found.chars().take(24).collect();
        format!("{}: expected {expected}, found `{short}`", self.place())
    }

    /// A finite number.
    ///
    /// # Errors
    /// There is none.
    pub fn number(&mut self, what: &str) -> Result<f64, String> {
        let word = self.word(what)?;
        let number = word.parse::<f64>().ok().filter(|n| n.is_finite());
        number.ok_or_else(|| self.wrong(&format!("{what}, a number"), word))
    }

    /// Three finite numbers.
    ///
    /// # Errors
    /// There are fewer.
    pub fn vector(&mut self, what: &str) -> Result<DVec3, String> {
        let [x, y, z] = [self.number(what)?, self.number(what)?, self.number(what)?];
        Ok(DVec3::new(x, y, z))
    }

    /// Three numbers that are a place of a picture.
    ///
    /// # Errors
    /// There are fewer, or one is too far out.
    pub fn point(&mut self, what: &str) -> Result<DVec3, String> {
        let point = self.vector(what)?;
        if point.abs().max_element() <= FARTHEST {
            Ok(point)
        } else {
            Err(format!(
                "{}: {what} is farther out than {FARTHEST:e}",
                self.place()
            ))
        }
    }

    /// Three numbers of a colour, none of them negative.
    ///
    /// # Errors
    /// There are fewer.
    pub fn color(&mut self, what: &str) -> Result<Vec3, String> {
        let color = self.vector(what)?;
        Ok(color.clamp(DVec3::ZERO, DVec3::splat(1e6)).as_vec3())
    }

    /// A thing of a list, named by its number from 0.
    ///
    /// # Errors
    /// There is no such number, or no such thing.
    pub fn index<T: Copy>(&mut self, what: &str, things: &[T]) -> Result<T, String> {
        let word = self.word(what)?;
        let number = word.parse::<usize>();
        let number = number.map_err(|_| self.wrong(&format!("the number of {what}"), word))?;
        things.get(number).copied().ok_or_else(|| {
            let count = things.len();
            format!(
                "{}: it names {what} {number}, but there are {count}",
                self.place()
            )
        })
    }

    /// How many things follow that take at least so many bytes each.
    ///
    /// # Errors
    /// There is no such number, or not so many can follow.
    pub fn count(&mut self, what: &str, bytes_each: usize) -> Result<usize, String> {
        let word = self.word(what)?;
        let count = word
            .parse::<usize>()
            .map_err(|_| self.wrong(&format!("{what}, a whole number"), word))?;
        if count > self.left() / bytes_each + 1 {
            return Err(format!(
                "{}: it says {count} {what}, more than the rest of the file can hold",
                self.place()
            ));
        }
        Ok(count)
    }
}
