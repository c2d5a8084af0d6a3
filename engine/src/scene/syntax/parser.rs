//! Tokens to a tree, going on after errors. Called by [`crate::scene`]'s readers.
//!
//! Each bracket is its own island: an error inside an element skips to that element's comma or to the
//! bracket's end. Depth is limited, so hostile nesting ends in a problem and not in a stack overflow.

use super::lexer::{Token, tokens};
use super::{Entry, Kind, Node, SyntaxError};

/// Brackets inside brackets that are read; an entity in an entity takes two.
const MAX_DEPTH: usize = 200;

/// Errors after which reading stops: the file is something else.
const MAX_ERRORS: usize = 200;

/// Reads one value that fills the text.
///
/// The tree holds all that could be read; where `errors` is empty it holds everything.
pub fn parse(text: &str) -> (Node<'_>, Vec<SyntaxError>) {
    let (tokens, errors) = tokens(text);
    let mut parser = Parser {
        tokens,
        next: 0,
        depth: 0,
        errors,
    };
    parser.extensions();
    let root = parser.value().unwrap_or(Node {
        at: 0,
        kind: Kind::Broken,
    });
    if *parser.peek() != Token::End && parser.errors.is_empty() {
        parser.unexpected("the end of the file");
    }
    parser.errors.truncate(MAX_ERRORS);
    (root, parser.errors)
}

struct Parser<'a> {
    /// Ends with [`Token::End`].
    tokens: Vec<(usize, Token<'a>)>,
    next: usize,
    depth: usize,
    errors: Vec<SyntaxError>,
}

impl<'a> Parser<'a> {
    fn peek(&self) -> &Token<'a> {
        &self.tokens[self.next].1
    }

    fn peek_second(&self) -> &Token<'a> {
        &self.tokens[(self.next + 1).min(self.tokens.len() - 1)].1
    }

    fn at(&self) -> usize {
        self.tokens[self.next].0
    }

    fn advance(&mut self) {
        if self.next + 1 < self.tokens.len() {
            self.next += 1;
        }
    }

    fn eat(&mut self, mark: char) -> bool {
        let found = *self.peek() == Token::Mark(mark);
        if found {
            self.advance();
        }
        found
    }

    fn unexpected(&mut self, expected: &str) {
        self.errors.push(SyntaxError {
            at: self.at(),
            what: format!("found {}", self.peek().describe()),
            expected: Some(expected.into()),
        });
    }

    /// `#![enable(implicit_some)]` lines are allowed and change nothing.
    fn extensions(&mut self) {
        while *self.peek() == Token::Mark('#') {
            while !matches!(self.peek(), Token::Mark(']') | Token::End) {
                self.advance();
            }
            self.advance();
        }
    }

    /// One value; none (reported) where there is none.
    fn value(&mut self) -> Option<Node<'a>> {
        let at = self.at();
        let kind = match self.peek().clone() {
            Token::Number(text) => {
                self.advance();
                Kind::Number(text)
            }
            Token::Text(text) => {
                self.advance();
                Kind::Text(text)
            }
            Token::Word(word) => {
                self.advance();
                if *self.peek() == Token::Mark('(') {
                    self.parenthesis(Some(word))?
                } else {
                    Kind::Word(word)
                }
            }
            Token::Mark('(') => self.parenthesis(None)?,
            Token::Mark('[') => {
                let items = self.bracket(']', |parser| parser.value())?;
                Kind::List(items)
            }
            Token::Mark('{') => {
                let pairs = self.bracket('}', |parser| {
                    let key = parser.value()?;
                    parser.colon()?;
                    Some((key, parser.value_or_broken()))
                })?;
                Kind::Map(pairs)
            }
            _ => {
                self.unexpected("a value");
                return None;
            }
        };
        Some(Node { at, kind })
    }

    /// A value, or [`Kind::Broken`] so that its key is still known.
    fn value_or_broken(&mut self) -> Node<'a> {
        let at = self.at();
        self.value().unwrap_or_else(|| {
            self.skip_element();
            Node {
                at,
                kind: Kind::Broken,
            }
        })
    }

    fn colon(&mut self) -> Option<()> {
        if self.eat(':') {
            return Some(());
        }
        self.unexpected("`:` after the name");
        None
    }

    fn parenthesis(&mut self, name: Option<&'a str>) -> Option<Kind<'a>> {
        let second = self
            .tokens
            .get(self.next + 2)
            .map_or(&Token::End, |(_, token)| token);
        // An identifier and a colon make a record, also where the first colon was forgotten later on.
        let record = matches!(self.peek_second(), Token::Word(_)) && *second == Token::Mark(':');
        if !record {
            let items = self.bracket(')', |parser| parser.value())?;
            return Some(Kind::Tuple(name, items));
        }
        let entries = self.bracket(')', |parser| {
            let at = parser.at();
            let Token::Word(field) = *parser.peek() else {
                parser.unexpected("the name of a field");
                return None;
            };
            parser.advance();
            parser.colon()?;
            Some(Entry {
                at,
                name: field,
                value: parser.value_or_broken(),
            })
        })?;
        Some(Kind::Record(name, entries))
    }

    /// The elements up to `close`; the opening bracket is the next token.
    fn bracket<T>(
        &mut self,
        close: char,
        element: impl Fn(&mut Self) -> Option<T>,
    ) -> Option<Vec<T>> {
        let open = self.at();
        if self.depth == MAX_DEPTH {
            self.errors.push(SyntaxError {
                at: open,
                what: format!("brackets nested more than {MAX_DEPTH} deep"),
                expected: Some("a flatter scene".into()),
            });
            self.advance();
            self.skip_to_close();
            self.advance();
            return None;
        }
        self.advance();
        self.depth += 1;
        let mut elements = Vec::new();
        while !self.eat(close) {
            if self.errors.len() >= MAX_ERRORS {
                self.next = self.tokens.len() - 1;
            }
            if matches!(self.peek(), Token::End | Token::Mark(')' | ']' | '}')) {
                self.unclosed(open, close);
                break;
            }
            match element(self) {
                Some(value) => elements.push(value),
                None => self.skip_element(),
            }
            let closing = matches!(self.peek(), Token::End | Token::Mark(')' | ']' | '}'));
            if !self.eat(',') && !closing {
                self.unexpected(&format!("`,` or `{close}`"));
                self.skip_element();
                self.eat(',');
            }
        }
        self.depth -= 1;
        Some(elements)
    }

    /// A bracket that ends with another one, or not at all: the inner one is taken as closed.
    fn unclosed(&mut self, open: usize, close: char) {
        if self.errors.len() < MAX_ERRORS {
            self.errors.push(SyntaxError {
                at: self.at(),
                what: format!("found {}", self.peek().describe()),
                expected: Some(format!("`{close}`")),
            });
        }
        // A closing bracket nobody opened would stop every level above; one that fits is left to its owner.
        if self.depth == 1 && *self.peek() != Token::End && open < self.at() {
            self.next = self.tokens.len() - 1;
        }
    }

    /// Skips to the comma or the closing bracket that ends this element.
    fn skip_element(&mut self) {
        while !matches!(self.peek(), Token::End | Token::Mark(',' | ')' | ']' | '}')) {
            if matches!(self.peek(), Token::Mark('(' | '[' | '{')) {
                self.advance();
                self.skip_to_close();
            }
            self.advance();
        }
    }

    /// Skips to the closing bracket that fits the opening one just read.
    fn skip_to_close(&mut self) {
        let mut depth = 1_usize;
        loop {
            match self.peek() {
                Token::End => return,
                Token::Mark('(' | '[' | '{') => depth += 1,
                Token::Mark(')' | ']' | '}') => {
                    depth -= 1;
                    if depth == 0 {
                        return;
                    }
                }
                _ => {}
            }
            self.advance();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(node: &Node) -> Vec<String> {
        match &node.kind {
            Kind::Record(_, entries) => entries.iter().map(|e| e.name.to_owned()).collect(),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn values_keep_their_places() {
        let (root, errors) = parse("(a: 1, b: [Two, \"x\\n\"], c: {\"k\": Euler(1, -2e-3)})");
        assert_eq!(errors, []);
        let Kind::Record(None, entries) = &root.kind else {
            panic!("{root:?}")
        };
        assert_eq!(entries[1].at, 7);
        let Kind::List(items) = &entries[1].value.kind else {
            panic!()
        };
        assert_eq!(items[1].kind, Kind::Text("x\n".into()));
        assert_eq!(items[1].at, 16);
    }

    #[test]
    fn an_error_in_one_element_leaves_the_others() {
        let (root, errors) = parse("(a: , b: 2 3, c 4, d: [1, :, 3], e: 5)");
        assert_eq!(names(&root), ["a", "b", "d", "e"]);
        assert_eq!(errors.len(), 4, "{errors:?}");
    }

    #[test]
    fn a_missing_bracket_is_one_problem_at_its_place() {
        let (root, errors) = parse("(a: [(x: 1, (y: 2)], b: 3)");
        assert_eq!(names(&root), ["a", "b"]);
        assert_eq!(errors[0].at, 12, "{errors:?}");
    }

    #[test]
    fn deep_nesting_is_a_problem_and_no_crash() {
        let text = "[".repeat(1_000_000);
        let (_, errors) = parse(&text);
        assert!(errors.iter().any(|e| e.what.contains("nested")));
    }

    #[test]
    fn comments_and_extensions_are_skipped() {
        let (root, errors) = parse("#![enable(implicit_some)]\n// x\n(/* a /* b */ */ a: 1,)");
        assert_eq!(errors, []);
        assert_eq!(names(&root), ["a"]);
    }
}
