//! The part of Python's literals that the header of an array is written in.

/// Deepest nesting of lists: fields of a structured array take two.
const DEPTH: usize = 8;

/// A literal.
#[derive(Debug, PartialEq)]
pub(super) enum Literal {
    Text(String),
    Whole(u64),
    Truth(bool),
    /// A list or a tuple.
    List(Vec<Literal>),
    Dict(Vec<(String, Literal)>),
}

/// Reads a text that holds one literal and blanks; `None` for anything else.
pub(super) fn parse(text: &str) -> Option<Literal> {
    let mut reader = Reader { rest: text };
    let literal = reader.literal(0)?;
    reader.rest.trim_start().is_empty().then_some(literal)
}

struct Reader<'a> {
    rest: &'a str,
}

impl Reader<'_> {
    fn peek(&mut self) -> Option<char> {
        self.rest = self.rest.trim_start();
        self.rest.chars().next()
    }

    fn take(&mut self, wanted: char) -> bool {
        let there = self.peek() == Some(wanted);
        if there {
            self.rest = &self.rest[wanted.len_utf8()..];
        }
        there
    }

    fn word(&mut self, word: &str) -> bool {
        let after = self.rest.strip_prefix(word);
        self.rest = after.unwrap_or(self.rest);
        after.is_some()
    }

    fn literal(&mut self, depth: usize) -> Option<Literal> {
        if depth > DEPTH {
            return None;
        }
        match self.peek()? {
            '\'' | '"' => self.text().map(Literal::Text),
            '0'..='9' => self.whole().map(Literal::Whole),
            '(' => self.list('(', ')', depth),
            '[' => self.list('[', ']', depth),
            '{' => self.dict(depth),
            _ if self.word("True") => Some(Literal::Truth(true)),
            _ if self.word("False") => Some(Literal::Truth(false)),
            _ => None,
        }
    }

    fn text(&mut self) -> Option<String> {
        let mut chars = self.rest.chars();
        let quote = chars.next()?;
        let mut text = String::new();
        loop {
            match chars.next()? {
                end if end == quote => break,
                '\\' => match chars.next()? {
                    same @ ('\\' | '\'' | '"') => text.push(same),
                    _ => return None,
                },
                other => text.push(other),
            }
        }
        self.rest = chars.as_str();
        Some(text)
    }

    fn whole(&mut self) -> Option<u64> {
        let digits = |c: char| !c.is_ascii_digit();
        let end = self.rest.find(digits).unwrap_or(self.rest.len());
        let (number, rest) = self.rest.split_at(end);
        // Python 2 marked long numbers.
        self.rest = rest.strip_prefix('L').unwrap_or(rest);
        number.parse().ok()
    }

    fn list(&mut self, open: char, close: char, depth: usize) -> Option<Literal> {
        self.take(open);
        let mut entries = Vec::new();
        while !self.take(close) {
            entries.push(self.literal(depth + 1)?);
            if !self.take(',') && self.peek()? != close {
                return None;
            }
        }
        Some(Literal::List(entries))
    }

    fn dict(&mut self, depth: usize) -> Option<Literal> {
        self.take('{');
        let mut entries = Vec::new();
        while !self.take('}') {
            let Some(Literal::Text(key)) = self.literal(depth + 1) else {
                return None;
            };
            if !self.take(':') {
                return None;
            }
            entries.push((key, self.literal(depth + 1)?));
            if !self.take(',') && self.peek()? != '}' {
                return None;
            }
        }
        Some(Literal::Dict(entries))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_as_numpy_writes_them() {
        let text = "{'descr': [('t', '<f8'), ('y', '>i4', (2,))], 'fortran_order': False, 'shape': (3L,), }  \n";
        let Some(Literal::Dict(entries)) = parse(text) else {
            panic!("{text}");
        };
        assert_eq!(entries[1], ("fortran_order".into(), Literal::Truth(false)));
        assert_eq!(entries[2].1, Literal::List(vec![Literal::Whole(3)]));
        let Literal::List(fields) = &entries[0].1 else {
            panic!("{entries:?}");
        };
        assert_eq!(fields.len(), 2);
    }

    #[test]
    fn anything_else_is_turned_away() {
        let deep = "[".repeat(100);
        for text in [
            "", "{", "{'a' 1}", "(1 2)", "'a", "1 1", "nan", "{1: 2}", &deep,
        ] {
            assert_eq!(parse(text), None, "{text}");
        }
    }
}
