//! Files that import each other. They cannot be read, tested or moved one without the other.
//!
//! File A imports file B if A names an item that B defines, in a `use` or in a path, through `crate`, `super`, `self`,
//! a module that A declares or a module that A imports. Re-exports are followed to the definition. So a `mod.rs` that
//! re-exports the items of its children imports them as little as it is imported by them. Not counted: test modules,
//! since a test imports what it tests; and the import of an item by a module from a module that contains it, for a
//! parent that defines a trait, or the data of a task, and a child that does a part of it are one thing in two files.

use crate::rules::{Finding, finding};
use crate::source::{Kind, Source};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::ops::Range;

type Path = Vec<String>;

/// What a module brings into scope by a `use`; the last name of a glob is `*`.
struct Use {
    alias: String,
    path: Path,
}

/// A file's names.
struct Module<'a> {
    source: &'a Source,
    defined: BTreeSet<&'a str>,
    uses: Vec<Use>,
}

/// Every file by its module.
struct Modules<'a>(BTreeMap<Path, Module<'a>>);

/// For each group of files that import each other, the shortest circle through its first file.
pub(crate) fn circles(sources: &[Source]) -> Vec<Finding> {
    let modules = Modules::new(sources);
    let edges: BTreeMap<&Path, BTreeSet<&Path>> = modules.0.keys().map(|path| (path, modules.imports(path))).collect();
    let reach: BTreeMap<&Path, BTreeSet<&Path>> = edges.keys().map(|&path| (path, reachable(path, &edges))).collect();
    let circular: Vec<&Path> = edges.keys().copied().filter(|path| reach[path].contains(path)).collect();
    let is_first =
        |path: &&Path| !circular.iter().any(|&p| p < *path && reach[path].contains(p) && reach[p].contains(path));
    circular.iter().copied().filter(is_first).map(|path| modules.finding(&shortest(path, &edges))).collect()
}

/// The modules that `from` imports, and those that they import, and so on.
fn reachable<'m>(from: &'m Path, edges: &BTreeMap<&'m Path, BTreeSet<&'m Path>>) -> BTreeSet<&'m Path> {
    let (mut found, mut open) = (BTreeSet::new(), vec![from]);
    while let Some(path) = open.pop() {
        open.extend(edges[path].iter().copied().filter(|&to| found.insert(to)));
    }
    found
}

/// The shortest circle through `from`, which is on one.
fn shortest<'m>(from: &'m Path, edges: &BTreeMap<&'m Path, BTreeSet<&'m Path>>) -> Vec<&'m Path> {
    let mut open = VecDeque::from([vec![from]]);
    let mut known = BTreeSet::new();
    while let Some(chain) = open.pop_front() {
        for &to in &edges[chain[chain.len() - 1]] {
            let longer = [chain.clone(), vec![to]].concat();
            if to == from {
                return longer;
            }
            if known.insert(to) {
                open.push_back(longer);
            }
        }
    }
    vec![from]
}

impl<'a> Modules<'a> {
    fn new(sources: &'a [Source]) -> Self {
        let path = |source: &Source| source.module().into_iter().map(str::to_owned).collect::<Path>();
        let tests: BTreeSet<Path> =
            sources.iter().flat_map(|s| test_modules(s).map(move |name| [path(s), vec![name]].concat())).collect();
        let is_test = |s: &Source| s.path.ends_with("tests.rs") || tests.iter().any(|test| path(s).starts_with(test));
        Modules(sources.iter().filter(|s| !is_test(s)).map(|s| (path(s), Module::new(s))).collect())
    }

    /// The modules that `from` imports.
    fn imports(&self, from: &Path) -> BTreeSet<&Path> {
        let module = &self.0[from];
        let used = module.uses.iter().map(|u| u.path.clone());
        let named = module.paths().into_iter();
        let found = used.chain(named).filter_map(|path| self.definition(&path, &mut BTreeSet::new()));
        found.filter(|to| !from.starts_with(to.as_slice())).collect()
    }

    /// The module whose file defines the item at `path`.
    fn definition(&self, path: &[String], seen: &mut BTreeSet<Path>) -> Option<&Path> {
        if !seen.insert(path.to_vec()) {
            return None;
        }
        let length = (0..=path.len()).rev().find(|&n| self.0.contains_key(&path[..n]))?;
        let (key, module) = self.0.get_key_value(&path[..length])?;
        let (name, rest) = path[length..].split_first()?; // else a module, whose items count where they are named
        if module.defined.contains(name.as_str()) {
            return Some(key);
        }
        let by_name = module.uses.iter().filter(|u| u.alias == *name).map(|u| [&u.path, rest].concat());
        let by_glob = module.uses.iter().filter(|u| u.alias == "*").map(|u| [&u.path, &path[length..]].concat());
        by_name.chain(by_glob).find_map(|path| self.definition(&path, seen))
    }

    fn finding(&self, circle: &[&Path]) -> Finding {
        let names: Vec<&str> = circle.iter().map(|path| self.0[*path].source.path.as_str()).collect();
        finding(self.0[circle[0]].source, 1, format!("a circle of imports: {}", names.join(" → ")))
    }
}

/// The names of the modules that `source` declares for tests alone.
fn test_modules(source: &Source) -> impl Iterator<Item = String> + '_ {
    let declared =
        |range: Range<usize>| range.filter(|&i| source.text(i) == "mod").map(|i| source.text(i + 1).to_owned());
    source.test_code().into_iter().flat_map(declared)
}

const ITEMS: [&str; 9] = ["fn", "struct", "enum", "union", "trait", "type", "const", "static", "mod"];

impl<'a> Module<'a> {
    fn new(source: &'a Source) -> Self {
        let path: Path = source.module().into_iter().map(str::to_owned).collect();
        let tests = source.test_code();
        let (mut defined, mut uses) = (BTreeSet::new(), Vec::new());
        let mut depth = 0;
        for i in (0..source.tokens.len()).filter(|i| !tests.iter().any(|range| range.contains(i))) {
            match source.text(i) {
                "{" => depth += 1,
                "}" => depth -= 1,
                "mod" if source.text(i + 2) == ";" => {
                    let name = source.text(i + 1).to_owned();
                    uses.push(Use { path: [&path[..], std::slice::from_ref(&name)].concat(), alias: name });
                }
                "use" => read_use(source, i + 1, &[], &mut uses),
                item if depth == 0 && ITEMS.contains(&item) && source.tokens.get(i + 1).is_some_and(is_word) => {
                    defined.insert(source.text(i + 1));
                }
                _ => {}
            }
        }
        let children: BTreeSet<String> =
            uses.iter().filter(|u| u.path.len() == path.len() + 1).map(|u| u.alias.clone()).collect();
        uses.iter_mut().for_each(|u| u.path = absolute(&u.path, &path, &children));
        Module { source, defined, uses }
    }

    /// The paths in the code that begin at the root, at a containing module or at a module that is in scope.
    fn paths(&self) -> Vec<Path> {
        let (source, tests) = (self.source, self.source.test_code());
        let module: Path = source.module().into_iter().map(str::to_owned).collect();
        let begins = |&i: &usize| {
            source.text(i + 1) == "::"
                && (i == 0 || source.text(i - 1) != "::")
                && !tests.iter().any(|r| r.contains(&i))
        };
        let path = |i: usize| {
            let mut path = vec![source.text(i).to_owned()];
            let mut at = i;
            while source.text(at + 1) == "::" && source.tokens.get(at + 2).is_some_and(is_word) {
                at += 2;
                path.push(source.text(at).to_owned());
            }
            match self.uses.iter().find(|u| u.alias == path[0]) {
                Some(u) => [&u.path, &path[1..]].concat(),
                None => absolute(&path, &module, &BTreeSet::new()),
            }
        };
        (0..source.tokens.len()).filter(begins).map(path).collect()
    }
}

fn is_word(token: &crate::source::Token) -> bool {
    token.kind == Kind::Word
}

/// Reads the tree of paths at token `i`, which `prefix` precedes, as it is written.
fn read_use(source: &Source, i: usize, prefix: &[String], uses: &mut Vec<Use>) {
    let (mut path, mut at) = (prefix.to_vec(), i);
    while source.text(at + 1) == "::" {
        path.push(source.text(at).to_owned());
        at += 2;
    }
    match source.text(at) {
        "{" => {
            let close = source.find_level(at + 1, &["}"]);
            let mut item = at + 1;
            while item < close {
                read_use(source, item, &path, uses);
                item = source.find_level(item, &[",", "}"]) + 1;
            }
            return;
        }
        "self" | "*" => {}
        name => path.push(name.to_owned()),
    }
    let alias = match (source.text(at), source.text(at + 1)) {
        ("*", _) => "*",
        (_, "as") => source.text(at + 2),
        _ => path.last().map_or("", String::as_str),
    };
    uses.push(Use { alias: alias.to_owned(), path });
}

/// The path from the root for one that is written in `module`, whose declared modules are `children`. A path into
/// another crate stays as it is.
fn absolute(path: &[String], module: &[String], children: &BTreeSet<String>) -> Path {
    let supers = path.iter().take_while(|name| *name == "super").count();
    match path.first().map_or("", String::as_str) {
        "crate" => path[1..].to_vec(),
        "self" => [module, &path[1..]].concat(),
        "super" => [&module[..module.len().saturating_sub(supers)], &path[supers..]].concat(),
        first if children.contains(first) => [module, path].concat(),
        _ => path.to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The findings for files with these paths and texts, and a library that declares modules `a` and `b`.
    fn found(files: &[(&str, &str)]) -> Vec<String> {
        let library = ("src/lib.rs", "mod a; mod b;");
        let sources: Vec<Source> =
            [&[library], files].concat().iter().map(|(path, text)| Source::new(path, text)).collect();
        circles(&sources).iter().map(|finding| finding.to_string()).collect()
    }

    #[test]
    fn two_files_that_import_each_other_are_caught() {
        let circle = ["src/a/x.rs:1: a circle of imports: src/a/x.rs → src/a/y.rs → src/a/x.rs"];
        for (x, y) in [
            ("use super::y::Y; struct X;", "use super::x::X; struct Y;"),
            ("use super::{z, y::{self, Y}}; struct X;", "fn f(x: crate::a::x::X) {} struct Y;"),
            ("use crate::a::y::Y as Z; struct X;", "use super::x; struct Y; fn f() { x::X::new() }"),
            ("use super::Y; struct X;", "use super::{X}; struct Y;"),
            ("use super::*; struct X; fn f() { super::y::g() }", "use super::x::X; fn g() {}"),
        ] {
            let files =
                [("src/a/mod.rs", "mod x; mod y; pub use x::X; pub use y::Y;"), ("src/a/x.rs", x), ("src/a/y.rs", y)];
            assert_eq!(found(&files), circle, "{x} {y}");
        }
    }

    #[test]
    fn longer_circles_are_caught_once() {
        let files = [
            ("src/a/mod.rs", "mod x; mod y;"),
            ("src/a/x.rs", "use super::y::Y; pub struct X;"),
            ("src/a/y.rs", "use crate::b::B; pub struct Y;"),
            ("src/b.rs", "use crate::a::x::X; pub struct B;"),
        ];
        let circle = "src/a/x.rs:1: a circle of imports: src/a/x.rs → src/a/y.rs → src/b.rs → src/a/x.rs";
        assert_eq!(found(&files), [circle]);
    }

    #[test]
    fn re_exports_tests_and_parents_make_no_circle() {
        let x = "use super::{T, y::Y}; struct X; #[cfg(test)] mod tests { use super::super::z::Z; }";
        let files = [
            (
                "src/a/mod.rs",
                "mod x; mod y; mod z; #[cfg(test)] mod trial; pub use x::X; pub trait T {} fn f() { x::X::g() }",
            ),
            ("src/a/x.rs", x),
            ("src/a/y.rs", "//! See super::x::X.\npub struct Y; const S: &str = \"super::x::X\";"),
            ("src/a/z.rs", "use super::X; pub struct Z;"),
            ("src/a/trial.rs", "use super::x::X; pub struct Trial;"),
        ];
        assert_eq!(found(&files), [""; 0]);
    }
}
