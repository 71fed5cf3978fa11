//! The rules, each a function from sources to findings, so that each can be shown to fail on a planted fault.

use crate::source::{Kind, Source};
use std::collections::BTreeSet;

/// Where a rule is broken and how.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Finding {
    pub(crate) path: String,
    line: usize,
    what: String,
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}: {}", self.path, self.line, self.what)
    }
}

pub(crate) fn finding(source: &Source, line: usize, what: impl Into<String>) -> Finding {
    Finding { path: source.path.clone(), line, what: what.into() }
}

/// Modules by floor, the lowest first. `error` stands on the first and may be used from everywhere.
pub(crate) type Floors<'a> = &'a [&'a [&'a str]];

fn floor(floors: Floors<'_>, module: &str) -> Option<usize> {
    floors.iter().position(|names| names.contains(&module)).map(|i| i + 1)
}

/// A module imports its own folder and lower floors only.
pub(crate) fn floors(source: &Source, floors: Floors<'_>) -> Vec<Finding> {
    let module = source.module();
    let Some(&own) = module.first() else { return Vec::new() }; // lib.rs and main.rs stand above all floors
    let Some(own_floor) = floor(floors, own) else {
        return vec![finding(
            source,
            1,
            format!("module `{own}` has no floor: add it to the table in tests/architecture"),
        )];
    };
    let judge = |(line, target): (usize, String)| {
        if target == own || target == "error" {
            return None;
        }
        let what = match floor(floors, &target) {
            Some(f) if f < own_floor => return None,
            Some(f) => format!("`{own}` (floor {own_floor}) imports `{target}` (floor {f})"),
            None => format!("`crate::{target}` is no module with a floor"),
        };
        Some(finding(source, line, what))
    };
    imports(source).into_iter().filter_map(judge).collect()
}

/// Only `of` names the crate `clap`: the library is free of the command line.
pub(crate) fn clap_outside(source: &Source, of: &str) -> Vec<Finding> {
    if source.path.starts_with(of) {
        return Vec::new();
    }
    let named = (0..source.tokens.len()).filter(|&i| source.text(i) == "clap");
    named.map(|i| finding(source, source.tokens[i].line, "`clap` is named outside of the command line")).collect()
}

/// The modules at the crate's root that the file names, by `crate::` or by a chain of `super::`, in code of any kind.
pub(crate) fn imports(source: &Source) -> BTreeSet<(usize, String)> {
    let mut found = BTreeSet::new();
    let file_depth = source.module().len();
    let mut inline: Vec<usize> = Vec::new(); // closing braces of the inline modules around token i
    for i in 0..source.tokens.len() {
        inline.retain(|&close| i < close);
        if source.text(i) == "mod" && source.text(i + 2) == "{" {
            inline.push(source.find_level(i + 3, &["}"]));
        }
        let continues = i >= 2 && source.text(i - 1) == "::" && source.text(i - 2) == "super";
        match source.text(i) {
            "crate" if source.text(i + 1) == "::" => follow(source, i + 2, 0, &mut found),
            "crate" if source.text(i + 1) == "as" => _ = found.insert((source.tokens[i].line, "*".into())),
            "super" if !continues => follow(source, i, file_depth + inline.len(), &mut found),
            _ => {}
        }
    }
    found
}

/// Follows the path or the group of paths at token `i`, seen from a module `depth` below the crate's root.
fn follow(source: &Source, i: usize, depth: usize, found: &mut BTreeSet<(usize, String)>) {
    match source.text(i) {
        "super" if source.text(i + 1) == "::" => follow(source, i + 2, depth.saturating_sub(1), found),
        "self" if source.text(i + 1) == "::" => follow(source, i + 2, depth, found),
        "{" => {
            let close = source.find_level(i + 1, &["}"]);
            let mut item = i + 1;
            while item < close {
                follow(source, item, depth, found);
                item = source.find_level(item, &[",", "}"]) + 1;
            }
        }
        "" | "self" => {}
        name if depth == 0 => _ = found.insert((source.tokens[i].line, name.to_owned())),
        _ => {}
    }
}

/// `unsafe` stands only where a path of `allowed` begins.
pub(crate) fn unsafe_code(source: &Source, allowed: &[&str]) -> Vec<Finding> {
    if allowed.iter().any(|folder| source.path.starts_with(folder)) {
        return Vec::new();
    }
    let words = source.tokens.iter().filter(|t| t.text == "unsafe");
    words.map(|t| finding(source, t.line, format!("`unsafe` outside of {}", allowed.join(" and ")))).collect()
}

/// Nothing unfinished: no `todo!`, `unimplemented!` or `dbg!`.
pub(crate) fn unfinished(source: &Source) -> Vec<Finding> {
    let macros = ["todo", "unimplemented", "dbg"];
    let found = (0..source.tokens.len()).filter(|&i| macros.contains(&source.text(i)) && source.text(i + 1) == "!");
    found.map(|i| finding(source, source.tokens[i].line, format!("`{}!`", source.text(i)))).collect()
}

/// The keys of the table in `references.md`, in its order.
pub(crate) fn reference_keys(table: &str) -> Vec<&str> {
    let rows = table.lines().filter_map(|line| line.strip_prefix("| ")?.split(" |").next());
    rows.map(str::trim).filter(|key| !key.is_empty() && *key != "key").collect()
}

/// The keys that the file's comments cite, as in `[Veach97 §10.2]` or `[Walter07; Heitz14 (5)]`: letters and then a
/// number.
pub(crate) fn citations(source: &Source) -> Vec<(usize, String)> {
    let is_key = |word: &str| {
        let letters = word.chars().take_while(|c| c.is_alphabetic()).count();
        let number = word.chars().skip(letters).take_while(char::is_ascii_digit).count();
        let rest = word.chars().skip(letters + number);
        letters >= 3 && number >= 1 && rest.clone().count() <= 1 && rest.into_iter().all(char::is_alphabetic)
    };
    let mut found = Vec::new();
    for (line, text) in &source.comments {
        for bracket in text.split('[').skip(1).filter_map(|after| after.split_once(']')).map(|(inside, _)| inside) {
            let words = bracket.split(';').filter_map(|part| part.split_whitespace().next());
            found.extend(words.filter(|word| is_key(word)).map(|word| (*line, word.to_owned())));
        }
    }
    found
}

/// Every cited key has a row.
pub(crate) fn uncited(source: &Source, keys: &[&str]) -> Vec<Finding> {
    let missing = citations(source).into_iter().filter(|(_, key)| !keys.contains(&key.as_str()));
    missing.map(|(line, key)| finding(source, line, format!("[{key}] has no row in src/references.md"))).collect()
}

/// Numbers of this size are tolerances until something says what they are.
const LARGEST_EPSILON: f64 = 1e-3;

/// A number above 0 and up to 1e-3 outside of tests is part of a named constant or has a comment on its line or just
/// above.
pub(crate) fn bare_epsilons(source: &Source) -> Vec<Finding> {
    if source.path.ends_with("tests.rs") {
        return Vec::new(); // the house's name for a test module in a file of its own
    }
    let tests = source.test_code();
    let constants = constants(source);
    let explained = |line: usize| source.comments.iter().any(|(at, _)| *at == line || *at + 1 == line);
    let mut found = Vec::new();
    for (i, token) in source.tokens.iter().enumerate() {
        let small = token.kind == Kind::Number && value(&token.text).is_some_and(|v| v > 0.0 && v <= LARGEST_EPSILON);
        let named = constants.iter().chain(&tests).any(|range| range.contains(&i));
        if small && !named && !explained(token.line) {
            found.push(finding(
                source,
                token.line,
                format!("{} is a bare epsilon: name it or say where it comes from", token.text),
            ));
        }
    }
    found
}

fn value(number: &str) -> Option<f64> {
    let plain = number.replace('_', "");
    plain.strip_suffix("f32").or(plain.strip_suffix("f64")).unwrap_or(&plain).parse().ok()
}

/// Ranges of tokens from `const NAME:` or `static NAME:` to the semicolon.
fn constants(source: &Source) -> Vec<std::ops::Range<usize>> {
    let starts = (0..source.tokens.len())
        .filter(|&i| ["const", "static"].contains(&source.text(i)) && source.text(i + 2) == ":");
    starts.map(|i| i..source.find_level(i, &[";"])).collect()
}

/// A function with the line it begins on and how many lines it has.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Function {
    pub(crate) name: String,
    pub(crate) line: usize,
    pub(crate) lines: usize,
}

/// Every function that has a body.
pub(crate) fn functions(source: &Source) -> Vec<Function> {
    let heads = (0..source.tokens.len())
        .filter(|&i| source.text(i) == "fn" && source.tokens.get(i + 1).is_some_and(|t| t.kind == Kind::Word));
    let bodies = heads.filter_map(|i| {
        let body = source.find_level(i, &["{", ";"]);
        let end = source.tokens.get(source.find_level(body + 1, &["}"]))?;
        let first = source.tokens[i].line;
        (source.text(body) == "{").then(|| Function {
            name: source.text(i + 1).into(),
            line: first,
            lines: end.line - first + 1,
        })
    });
    bodies.collect()
}

/// No file and no function grows beyond what one can read at a sitting.
pub(crate) fn sizes(source: &Source, file: usize, function: usize) -> Vec<Finding> {
    let mut found = Vec::new();
    if source.lines > file {
        found.push(finding(source, 1, format!("{} lines in one file, at most {file}", source.lines)));
    }
    for f in functions(source).into_iter().filter(|f| f.lines > function) {
        found.push(finding(source, f.line, format!("`{}` has {} lines, at most {function}", f.name, f.lines)));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLOORS: Floors<'static> = &[&["error", "numeric"], &["geometry", "stats"], &["film"]];

    fn broken_floors(path: &str, text: &str) -> Vec<String> {
        floors(&Source::new(path, text), FLOORS).into_iter().map(|f| f.what).collect()
    }

    #[test]
    fn lower_floors_the_own_folder_and_errors_may_be_imported() {
        let text = "use crate::{error::Result, numeric::{Scalar, gamma}};\nuse crate::geometry::Ray;\nfn f(x: crate::error::Error) {}";
        assert!(broken_floors("src/geometry/mesh.rs", text).is_empty());
        assert!(broken_floors("src/numeric/mod.rs", "use crate::error::Error;").is_empty());
        assert!(broken_floors("src/lib.rs", "use crate::film::Film;").is_empty());
    }

    #[test]
    fn a_lower_floor_that_imports_a_higher_one_is_caught() {
        let higher = "`geometry` (floor 2) imports `film` (floor 3)";
        for text in [
            "use crate::film::Film;",
            "use crate::{error::Result, film};",
            "use crate::{self, numeric::{a, b}, film::{c}};",
            "fn f() { crate::film::g() }",
            "#[cfg(test)] mod tests { use crate::film::Film; }",
            "#[cfg(test)] mod tests { use super::super::super::film::Film; }",
            "use super::super::film::Film;",
            "use super::{super::film::Film};",
            "use self::super::super::film::Film;",
        ] {
            assert_eq!(broken_floors("src/geometry/mesh.rs", text).last().map(String::as_str), Some(higher), "{text}");
        }
    }

    #[test]
    fn siblings_unknown_modules_and_the_whole_crate_are_caught() {
        assert_eq!(broken_floors("src/stats/mod.rs", "use crate::geometry::Ray;").len(), 1);
        assert_eq!(broken_floors("src/film/mod.rs", "use crate::utils::f;").len(), 1);
        assert_eq!(broken_floors("src/film/mod.rs", "use crate::*;").len(), 1);
        assert_eq!(broken_floors("src/film/mod.rs", "use crate as all;").len(), 1);
        assert_eq!(broken_floors("src/utils.rs", "").len(), 1);
    }

    #[test]
    fn what_is_not_an_import_is_left_alone() {
        let text = "//! See crate::film.\npub(crate) fn f() { g(\"crate::film\") }\nmod tests { use super::*; use super::super::mesh; }";
        assert!(broken_floors("src/geometry/mesh.rs", text).is_empty());
    }

    #[test]
    fn clap_is_caught_outside_of_its_folder() {
        let code = "#[derive(clap::Args)]\nstruct Args;";
        assert_eq!(clap_outside(&Source::new("src/film/mod.rs", code), "src/cli/").len(), 1);
        assert!(clap_outside(&Source::new("src/cli/mod.rs", code), "src/cli/").is_empty());
        assert!(clap_outside(&Source::new("src/film/mod.rs", "// clap\nfn clap_on() {}"), "src/cli/").is_empty());
    }

    #[test]
    fn unsafe_is_caught_outside_of_its_folders() {
        let text = "// unsafe\nunsafe fn f() { unsafe { g(\"unsafe\") } }";
        assert_eq!(unsafe_code(&Source::new("src/film/mod.rs", text), &["src/accel/embree/"]).len(), 2);
        assert!(unsafe_code(&Source::new("src/accel/embree/ray.rs", text), &["src/accel/embree/"]).is_empty());
    }

    #[test]
    fn unfinished_code_is_caught() {
        let source =
            Source::new("src/x.rs", "// todo!()\nfn f() { todo!() } fn g() { dbg!(1); unimplemented!() } fn todo() {}");
        assert_eq!(unfinished(&source).len(), 3);
    }

    #[test]
    fn citations_need_rows() {
        let keys = reference_keys("text\n\n| key | what |\n|---|---|\n| Veach97 | thesis |\n| glTF20 | spec |\n");
        assert_eq!(keys, ["Veach97", "glTF20"]);
        let text = "/// As in [Veach97 §10.2], [glTF20] and [`Vec3`], not [f32; 3].\n// [Knuth68 (1)], [Veach97; Heitz14b §2]\nlet x = [Foo12];";
        let missing: Vec<_> =
            uncited(&Source::new("src/x.rs", text), &keys).into_iter().map(|f| (f.line, f.what)).collect();
        let expected = ["[Knuth68] has no row in src/references.md", "[Heitz14b] has no row in src/references.md"];
        assert_eq!(missing, expected.map(|what| (2, what.to_owned())));
    }

    #[test]
    fn bare_epsilons_are_caught() {
        for text in [
            "fn f(x: f32) -> bool { x < 1e-4 }",
            "fn f() {\n g(0.000_1f32) }",
            "// why\n\nlet x = 1e-9;",
            "const fn f() { 1e-6 }",
        ] {
            assert_eq!(bare_epsilons(&Source::new("src/x.rs", text)).len(), 1, "{text}");
        }
        for text in [
            "const TINY: f64 = 1e-9;",
            "const POLYNOMIAL: [f64; 2] = [\n 1.0,\n 2.5e-4];",
            "// 2⁻²⁴ rounded up\nlet e = 6e-8;",
            "let e = 6e-8; // 2⁻²⁴ rounded up",
            "let x = 0.5 * 0.0 + 10.0 + 1e-2;",
            "#[cfg(test)] mod tests { fn f() { assert!(x < 1e-6) } }",
        ] {
            assert_eq!(bare_epsilons(&Source::new("src/x.rs", text)), [], "{text}");
        }
        assert_eq!(bare_epsilons(&Source::new("src/film/merge_tests.rs", "fn f() { assert!(x < 1e-6) }")), []);
    }

    #[test]
    fn long_files_and_functions_are_caught() {
        let long = format!(
            "trait T {{ fn a(&self, x: [u8; 2]); }}\nfn b() {{\n{}}}\nfn c() -> fn(u8) {{}}\n",
            "x();\n".repeat(5)
        );
        let source = Source::new("src/x.rs", &long);
        let measured: Vec<_> = functions(&source).into_iter().map(|f| (f.name, f.line, f.lines)).collect();
        assert_eq!(measured, [("b".to_owned(), 2, 7), ("c".to_owned(), 9, 1)]);
        assert_eq!(sizes(&source, 9, 7), []);
        assert_eq!(sizes(&source, 8, 6).len(), 2);
    }
}
