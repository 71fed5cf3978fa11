//! Mutant schemata: sources with all mutations in them, of which at most one is on (Untch, Offutt and Harrold 1993).
//! All mutants are compiled at once.

use crate::mutations::Mutation;
use crate::sites::Site;
use std::ops::Range;

/// Module of the copy that says which mutation is on.
pub(crate) const SWITCH: &str = "src/mutant.rs";

/// Returns `text` with all `sites`, sorted as by [`crate::sites::locate`].
pub(crate) fn apply(text: &str, sites: &[Site]) -> String {
    within(text, 0..text.len(), sites)
}

/// Returns the part `range` of `text` with `sites`, which lie inside it.
fn within(text: &str, range: Range<usize>, mut sites: &[Site]) -> String {
    let (mut out, mut at) = (String::new(), range.start);
    while let Some(outer) = sites.first() {
        let equal = sites.iter().take_while(|site| site.span == outer.span).count();
        let inside = sites.iter().take_while(|site| site.span.end <= outer.span.end).count();
        out += &text[at..outer.span.start];
        out += &choice(&sites[..equal], &within(text, outer.span.clone(), &sites[equal..inside]));
        at = outer.span.end;
        sites = &sites[inside..];
    }
    out + &text[at..range.end]
}

/// Returns the choice between the wrong texts of `sites` and the right one. Parentheses keep the precedence of an
/// expression. Statements and blocks need none.
fn choice(sites: &[Site], right: &str) -> String {
    let branches = |site: &Site| format!("if crate::mutant::on({}) {{ {} }} else ", site.number, site.after);
    let choice = sites.iter().map(branches).collect::<String>() + &format!("{{ {right} }}");
    if right.ends_with([';', '}']) { choice } else { format!("({choice})") }
}

/// Returns the source of [`SWITCH`].
pub(crate) fn switch(mutations: &[Mutation]) -> String {
    let names: String = mutations.iter().map(|mutation| format!("    {:?},\n", mutation.name)).collect();
    format!(
        r#"//! Which mutation is on: the one of `ETENDUE_MUTANT`. Written by tests/kill_matrix.

static NAMES: &[&str] = &[
{names}];

/// Whether the mutation `number` is on.
#[inline]
pub fn on(number: usize) -> bool {{
    static CHOSEN: std::sync::OnceLock<usize> = std::sync::OnceLock::new();
    *CHOSEN.get_or_init(chosen) == number
}}

#[cold]
fn chosen() -> usize {{
    let name = std::env::var("ETENDUE_MUTANT").unwrap_or_default();
    if name.is_empty() {{
        return 0;
    }}
    let found = NAMES.iter().position(|&known| known == name);
    1 + found.unwrap_or_else(|| panic!("ETENDUE_MUTANT={{name}} is no mutation"))
}}
"#
    )
}
