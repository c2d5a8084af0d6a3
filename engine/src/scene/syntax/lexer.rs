//! RON's tokens, each with its byte offset. Called by the parser only.

use std::borrow::Cow;

use super::SyntaxError;

/// One token.
#[derive(Clone, Debug, PartialEq)]
pub enum Token<'a> {
    /// One of `( ) [ ] { } : , # !`.
    Mark(char),
    /// A number as written.
    Number(&'a str),
    /// A bare word.
    Word(&'a str),
    /// A string, unescaped.
    Text(Cow<'a, str>),
    /// The end of the text.
    End,
}

impl Token<'_> {
    /// What this is, in words.
    pub fn describe(&self) -> String {
        match self {
            Self::Mark(mark) => format!("`{mark}`"),
            Self::Number(text) => format!("the number {text}"),
            Self::Word(word) => format!("`{word}`"),
            Self::Text(_) => "a string".into(),
            Self::End => "the end of the file".into(),
        }
    }
}

/// Tokens of `text` with their offsets, the last being [`Token::End`], and what is no token.
pub fn tokens(text: &str) -> (Vec<(usize, Token<'_>)>, Vec<SyntaxError>) {
    let mut lexer = Lexer {
        text,
        at: 0,
        errors: Vec::new(),
    };
    let mut tokens = Vec::new();
    // An editor's byte-order mark is no part of the text.
    if text.starts_with('\u{feff}') {
        lexer.at = '\u{feff}'.len_utf8();
    }
    loop {
        lexer.skip_blank();
        let at = lexer.at;
        match lexer.next() {
            Some(Token::End) => {
                tokens.push((at, Token::End));
                return (tokens, lexer.errors);
            }
            Some(token) => tokens.push((at, token)),
            None => {}
        }
    }
}

struct Lexer<'a> {
    text: &'a str,
    at: usize,
    errors: Vec<SyntaxError>,
}

impl<'a> Lexer<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    fn error(&mut self, at: usize, what: impl Into<String>, expected: Option<&str>) {
        self.errors.push(SyntaxError {
            at,
            what: what.into(),
            expected: expected.map(Into::into),
        });
    }

    /// Skips white space and comments; block comments nest.
    fn skip_blank(&mut self) {
        loop {
            let rest = self.rest();
            let trimmed = rest.trim_start();
            self.at += rest.len() - trimmed.len();
            if trimmed.starts_with("//") {
                self.at += trimmed.find('\n').unwrap_or(trimmed.len());
            } else if trimmed.starts_with("/*") {
                self.skip_block_comment();
            } else {
                return;
            }
        }
    }

    fn skip_block_comment(&mut self) {
        let start = self.at;
        let mut depth = 0_usize;
        while self.at < self.text.len() {
            let bytes = &self.text.as_bytes()[self.at..];
            if bytes.starts_with(b"/*") {
                depth += 1;
                self.at += 2;
            } else if bytes.starts_with(b"*/") {
                depth -= 1;
                self.at += 2;
                if depth == 0 {
                    return;
                }
            } else {
                self.at += self.rest().chars().next().map_or(1, char::len_utf8);
            }
        }
        self.error(start, "a comment that does not end", Some("`*/`"));
    }

    /// The next token; none where a character was refused.
    fn next(&mut self) -> Option<Token<'a>> {
        let rest = self.rest();
        let Some(first) = rest.chars().next() else {
            return Some(Token::End);
        };
        match first {
            '(' | ')' | '[' | ']' | '{' | '}' | ':' | ',' | '#' | '!' => {
                self.at += 1;
                Some(Token::Mark(first))
            }
            '"' => Some(self.string()),
            'r' if rest[1..].starts_with(['"', '#']) => Some(self.raw_string()),
            '0'..='9' | '+' | '-' | '.' => Some(self.number()),
            _ if first.is_alphabetic() || first == '_' => {
                let end = rest
                    .find(|c: char| !(c.is_alphanumeric() || c == '_'))
                    .unwrap_or(rest.len());
                self.at += end;
                Some(Token::Word(&rest[..end]))
            }
            _ => {
                self.error(
                    self.at,
                    format!("the character {first:?}"),
                    Some("a value or a name"),
                );
                self.at += first.len_utf8();
                None
            }
        }
    }

    /// A number runs over letters, digits, dots and underscores, and over a sign after an exponent's `e`.
    fn number(&mut self) -> Token<'a> {
        let rest = self.rest();
        let mut end = 1;
        let mut last = rest.as_bytes()[0];
        for &byte in &rest.as_bytes()[1..] {
            let sign = matches!(byte, b'+' | b'-') && matches!(last, b'e' | b'E');
            if !(byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'_') || sign) {
                break;
            }
            last = byte;
            end += 1;
        }
        self.at += end;
        Token::Number(&rest[..end])
    }

    fn raw_string(&mut self) -> Token<'a> {
        let start = self.at;
        let rest = &self.rest()[1..];
        let hashes = rest.len() - rest.trim_start_matches('#').len();
        let close = format!("\"{}", "#".repeat(hashes));
        let body = &rest[hashes..];
        if !body.starts_with('"') {
            self.at += 1 + hashes;
            self.error(
                start,
                "a raw string that does not begin",
                Some("`r\"...\"`"),
            );
            return Token::Text(Cow::Borrowed(""));
        }
        let Some(length) = body[1..].find(&close) else {
            self.at = self.text.len();
            self.error(start, "a string that does not end", Some("a closing quote"));
            return Token::Text(Cow::Borrowed(""));
        };
        self.at += 1 + hashes + 1 + length + close.len();
        Token::Text(Cow::Borrowed(&body[1..=length]))
    }

    fn string(&mut self) -> Token<'a> {
        let start = self.at;
        let body = &self.rest()[1..];
        if let Some(end) = body.find(['"', '\\'])
            && body.as_bytes()[end] == b'"'
        {
            self.at += end + 2;
            return Token::Text(Cow::Borrowed(&body[..end]));
        }
        self.at += 1;
        let mut text = String::new();
        loop {
            let Some(c) = self.rest().chars().next() else {
                self.error(start, "a string that does not end", Some("a closing quote"));
                return Token::Text(Cow::Owned(text));
            };
            self.at += c.len_utf8();
            match c {
                '"' => return Token::Text(Cow::Owned(text)),
                '\\' => text.extend(self.escape()),
                _ => text.push(c),
            }
        }
    }

    /// The character an escape stands for; the backslash is already read.
    fn escape(&mut self) -> Option<char> {
        let at = self.at - 1;
        let c = self.rest().chars().next()?;
        self.at += c.len_utf8();
        let simple = match c {
            'n' => Some('\n'),
            't' => Some('\t'),
            'r' => Some('\r'),
            '0' => Some('\0'),
            '\\' | '"' | '\'' => Some(c),
            'x' => self.hexadecimal(2),
            'u' if self.rest().starts_with('{') => {
                let digits = self.rest()[1..].find('}').filter(|&n| n <= 6);
                digits.and_then(|count| {
                    self.at += 1;
                    let code = self.hexadecimal(count);
                    self.at += 1;
                    code
                })
            }
            _ => None,
        };
        if simple.is_none() {
            self.error(
                at,
                "an unknown escape",
                Some("one of \\n \\t \\r \\0 \\\\ \\\" \\xHH \\u{HHHH}"),
            );
        }
        simple
    }

    fn hexadecimal(&mut self, digits: usize) -> Option<char> {
        let code = self.rest().get(..digits)?;
        self.at += digits;
        u32::from_str_radix(code, 16).ok().and_then(char::from_u32)
    }
}
