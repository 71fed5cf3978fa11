//! A Rust source file as the rules see it: tokens and comments with their lines. Not a parser: it knows comments,
//! literals and brackets, which is what it takes not to mistake a word in a string for code.

use std::path::Path;

/// What a token is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// An identifier or keyword.
    Word,
    /// A number with its suffix.
    Number,
    /// `::` or one other character.
    Mark,
    /// A string or character literal, without its text.
    Literal,
}

/// A token and the line it begins on, from 1.
#[derive(Debug, Clone)]
pub(crate) struct Token {
    pub(crate) line: usize,
    pub(crate) kind: Kind,
    pub(crate) text: String,
}

/// A file: its path from the project's root with `/`, its tokens, and its comments line by line.
#[derive(Debug)]
pub(crate) struct Source {
    pub(crate) path: String,
    pub(crate) lines: usize,
    pub(crate) tokens: Vec<Token>,
    pub(crate) comments: Vec<(usize, String)>,
}

impl Source {
    /// Reads the text of the file at `path`.
    pub(crate) fn new(path: &str, text: &str) -> Source {
        let mut lexer = Lexer { rest: text, line: 1, tokens: Vec::new(), comments: Vec::new() };
        lexer.run();
        let Lexer { tokens, comments, .. } = lexer;
        Source { path: path.to_owned(), lines: text.lines().count(), tokens, comments }
    }

    /// The modules from the crate's root to this file: `src/geometry/mesh.rs` is geometry, mesh; `src/lib.rs` is none.
    pub(crate) fn module(&self) -> Vec<&str> {
        let inside = self.path.strip_prefix("src/").unwrap_or(&self.path);
        let parts = inside.strip_suffix(".rs").unwrap_or(inside).split('/');
        parts.filter(|part| !["lib", "main", "mod"].contains(part)).collect()
    }

    /// The text of token `i`, empty past the end.
    pub(crate) fn text(&self, i: usize) -> &str {
        self.tokens.get(i).map_or("", |token| &token.text)
    }

    /// Whether the tokens from `i` on read `texts`.
    pub(crate) fn reads(&self, i: usize, texts: &[&str]) -> bool {
        texts.iter().enumerate().all(|(k, text)| self.text(i + k) == *text)
    }

    /// From `start`, the first token outside of the brackets opened since that is one of `texts`; the end if none is.
    pub(crate) fn find_level(&self, start: usize, texts: &[&str]) -> usize {
        let mut depth = 0i32;
        for i in start..self.tokens.len() {
            if depth == 0 && texts.contains(&self.text(i)) {
                return i;
            }
            match self.text(i) {
                "(" | "[" | "{" => depth += 1,
                ")" | "]" | "}" => depth -= 1,
                _ => {}
            }
        }
        self.tokens.len()
    }

    /// Ranges of tokens under `#[cfg(test)]`.
    pub(crate) fn test_code(&self) -> Vec<std::ops::Range<usize>> {
        let marks = (0..self.tokens.len()).filter(|&i| self.reads(i, &["#", "[", "cfg", "(", "test", ")", "]"]));
        let range = |i: usize| {
            let body = self.find_level(i + 7, &["{", ";"]);
            let end = if self.text(body) == "{" { self.find_level(body + 1, &["}"]) } else { body };
            i..end
        };
        marks.map(range).collect()
    }
}

/// Every `.rs` file under `folder` of the project at `root`, in the order of their paths.
///
/// # Panics
/// If something there cannot be read.
pub(crate) fn read_folder(root: &Path, folder: &str) -> Vec<Source> {
    let entries = std::fs::read_dir(root.join(folder)).unwrap_or_else(|e| panic!("{folder}: {e}"));
    let mut names: Vec<_> = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    let mut sources = Vec::new();
    for path in names.iter().map(|name| format!("{folder}/{name}")) {
        if root.join(&path).is_dir() {
            sources.extend(read_folder(root, &path));
        } else if path.ends_with(".rs") {
            let text = std::fs::read_to_string(root.join(&path)).unwrap_or_else(|e| panic!("{path}: {e}"));
            sources.push(Source::new(&path, &text));
        }
    }
    sources
}

struct Lexer<'a> {
    rest: &'a str,
    line: usize,
    tokens: Vec<Token>,
    comments: Vec<(usize, String)>,
}

impl<'a> Lexer<'a> {
    fn run(&mut self) {
        while let Some(c) = self.rest.chars().next() {
            if self.rest.starts_with("//") {
                let comment = self.take(self.rest.find('\n').unwrap_or(self.rest.len()));
                self.comments.push((self.line, comment.to_owned()));
            } else if self.rest.starts_with("/*") {
                self.block_comment();
            } else if let Some(length) = literal_length(self.rest) {
                self.token(Kind::Literal, length);
            } else if c == '\'' {
                self.take(1); // a lifetime: its name is no identifier of interest, but harmless as one
            } else if c.is_alphabetic() || c == '_' {
                let length = self.rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(self.rest.len());
                self.token(Kind::Word, length);
            } else if c.is_ascii_digit() {
                self.token(Kind::Number, number_length(self.rest));
            } else if c.is_whitespace() {
                self.take(c.len_utf8());
            } else {
                self.token(Kind::Mark, if self.rest.starts_with("::") { 2 } else { c.len_utf8() });
            }
        }
    }

    fn take(&mut self, length: usize) -> &'a str {
        let (taken, rest) = self.rest.split_at(length);
        self.rest = rest;
        self.line += taken.matches('\n').count();
        taken
    }

    fn token(&mut self, kind: Kind, length: usize) {
        let line = self.line;
        let text = self.take(length);
        let text = if kind == Kind::Literal { "\"\"" } else { text };
        self.tokens.push(Token { line, kind, text: text.to_owned() });
    }

    fn block_comment(&mut self) {
        let (mut depth, mut end) = (0, 0);
        while end < self.rest.len() {
            let rest = &self.rest.as_bytes()[end..];
            let step = if rest.starts_with(b"/*") {
                depth += 1;
                2
            } else if rest.starts_with(b"*/") {
                depth -= 1;
                2
            } else {
                1
            };
            end += step;
            if depth == 0 {
                break;
            }
        }
        let first = self.line;
        let text = self.take(end);
        self.comments.extend(text.lines().enumerate().map(|(i, line)| (first + i, line.to_owned())));
    }
}

/// The length of the string, byte string, raw string or character literal that `text` begins with.
fn literal_length(text: &str) -> Option<usize> {
    let prefix = ["br", "cr", "b", "c", "r", ""].into_iter().find(|p| {
        let rest = text.strip_prefix(p).map(|rest| if p.contains('r') { rest.trim_start_matches('#') } else { rest });
        rest.is_some_and(|rest| rest.starts_with('"') || (!p.contains(['r', 'c']) && rest.starts_with('\'')))
    })?;
    let rest = &text[prefix.len()..];
    if prefix.contains('r') {
        let hashes = rest.len() - rest.trim_start_matches('#').len();
        let close = format!("\"{}", "#".repeat(hashes));
        let body = rest[hashes + 1..].find(&close).unwrap_or(rest.len() - hashes - 1 - close.len());
        return Some(prefix.len() + hashes + 1 + body + close.len());
    }
    let quote = rest.chars().next()?;
    let second = rest[1..].chars().next()?;
    if quote == '\'' && second != '\\' && !rest[1 + second.len_utf8()..].starts_with('\'') {
        return None; // a lifetime
    }
    let mut escaped = false;
    let end = rest[1..].find(|c| {
        let closes = c == quote && !escaped;
        escaped = c == '\\' && !escaped;
        closes
    })?;
    Some(prefix.len() + 1 + end + 1)
}

/// The length of the number that `text` begins with, suffix included: `1e-4`, `0x1p-3` is not Rust, `1..2` is 1.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let hex = text.starts_with("0x");
    let mut i = 0;
    while let Some(&b) = bytes.get(i) {
        let next_is_digit = bytes.get(i + 1).is_some_and(u8::is_ascii_digit);
        let sign = i > 0 && !hex && matches!(b, b'+' | b'-') && matches!(bytes[i - 1], b'e' | b'E');
        if !(b.is_ascii_alphanumeric() || b == b'_' || (b == b'.' && next_is_digit) || (sign && next_is_digit)) {
            break;
        }
        i += 1;
    }
    i
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tokens(text: &str) -> Vec<String> {
        Source::new("src/x.rs", text).tokens.into_iter().map(|t| t.text).collect()
    }

    #[test]
    fn comments_and_literals_are_not_code() {
        let text = "a /* b /* c */ d */ // e\n\"f \\\" g\" 'h' '\\'' r#\"i \" j\"# b'k' br\"l\" x::<'m>";
        let quote = "\"\"";
        assert_eq!(tokens(text), ["a", quote, quote, quote, quote, quote, quote, "x", "::", "<", "m", ">"]);
        let source = Source::new("src/x.rs", text);
        assert_eq!(source.comments.len(), 2);
        assert_eq!(source.tokens[1].line, 2);
    }

    #[test]
    fn numbers_keep_their_exponents_and_ranges_are_cut() {
        assert_eq!(
            tokens("1e-4 1..2 0xE-1 2.5f32 x.0"),
            ["1e-4", "1", ".", ".", "2", "0xE", "-", "1", "2.5f32", "x", ".", "0"]
        );
    }

    #[test]
    fn modules_follow_from_paths() {
        for (path, module) in [
            ("src/lib.rs", &[][..]),
            ("src/error.rs", &["error"]),
            ("src/accel/mod.rs", &["accel"]),
            ("src/a/b/c.rs", &["a", "b", "c"]),
        ] {
            assert_eq!(Source::new(path, "").module(), module);
        }
    }

    #[test]
    fn test_code_ends_where_its_item_ends() {
        let source = Source::new("src/x.rs", "a #[cfg(test)] mod tests { fn b() { c } } d #[cfg(test)] mod e; f");
        let inside = |word: &str| {
            let i = (0..source.tokens.len()).find(|&i| source.text(i) == word).unwrap();
            source.test_code().iter().any(|range| range.contains(&i))
        };
        assert_eq!(["a", "b", "c", "d", "e", "f"].map(inside), [false, true, true, false, true, false]);
    }
}
