//! TEMP stand-in until branch `film` is merged.
#![allow(missing_docs)]
use std::collections::BTreeSet;
#[derive(Debug, Clone, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct PassSet(BTreeSet<u64>);
impl PassSet {
    pub fn contains(&self, pass: u64) -> bool {
        self.0.contains(&pass)
    }
    pub fn len(&self) -> u64 {
        self.0.len() as u64
    }
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
    pub fn insert(&mut self, pass: u64) {
        self.0.insert(pass);
    }
    pub fn iter(&self) -> impl Iterator<Item = u64> + '_ {
        self.0.iter().copied()
    }
}
impl std::fmt::Display for PassSet {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut runs: Vec<(u64, u64)> = Vec::new();
        for p in self.iter() {
            match runs.last_mut() {
                Some(last) if last.1 + 1 == p => last.1 = p,
                _ => runs.push((p, p)),
            }
        }
        let text: Vec<String> = runs.iter().map(|(a, b)| if a == b { a.to_string() } else { format!("{a}-{b}") }).collect();
        f.write_str(&text.join(","))
    }
}
