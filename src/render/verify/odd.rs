//! Which candidates are to blame, as far as who differs from whom tells.

use super::Candidate;
use crate::accel::Backend;
use crate::integrator::Method;
use crate::render::same_mean::Judgement;
use serde::Serialize;

/// Candidates that all differences have in common.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Odd {
    /// What they are: one candidate, a method with every backend, a backend with every method.
    pub who: String,
    /// Whether every one of them differs from every other candidate.
    pub from_all: bool,
}

/// A candidate's method, backend and name.
pub(super) type Label = (Method, Backend, String);

impl Odd {
    /// The smallest group that all differences have in common, if one stands out.
    pub fn among(candidates: &[Candidate<'_>], judgement: &Judgement) -> Option<Odd> {
        let settings = |c: &Candidate<'_>| (c.provenance.settings.method, c.provenance.settings.backend, c.name.clone());
        Odd::of(&candidates.iter().map(settings).collect::<Vec<_>>(), judgement)
    }

    pub(super) fn of(candidates: &[Label], judgement: &Judgement) -> Option<Odd> {
        let different: Vec<[usize; 2]> = judgement.pairs.iter().filter(|p| p.differs()).map(|p| [p.a, p.b]).collect();
        if different.is_empty() || candidates.len() < 3 {
            return None;
        }
        let explained = |members: &[usize]| different.iter().all(|[a, b]| members.contains(a) != members.contains(b));
        let across = |members: &[usize]| members.len() * (candidates.len() - members.len());
        let suspects = groups(candidates).into_iter().filter(|(_, members)| explained(members));
        let found: Vec<Odd> = suspects.map(|(who, members)| Odd { who, from_all: across(&members) == different.len() }).collect();
        let certain: Vec<&Odd> = found.iter().filter(|o| o.from_all).collect();
        match (certain.as_slice(), found.as_slice()) {
            ([one], _) => Some((*one).clone()),
            ([], [one]) => Some(one.clone()),
            _ => None,
        }
    }
}

/// Each candidate, each method and each backend, with who belongs to it; two backends are one distinction.
fn groups(candidates: &[Label]) -> Vec<(String, Vec<usize>)> {
    let members = |is: &dyn Fn(&Label) -> bool| (0..candidates.len()).filter(|&i| is(&candidates[i])).collect::<Vec<_>>();
    let mut groups: Vec<(String, Vec<usize>)> = candidates.iter().enumerate().map(|(i, c)| (c.2.clone(), vec![i])).collect();
    for (method, backend, _) in candidates {
        groups.push((format!("{} with every backend", super::lineup::name(*method)), members(&|c| c.0 == *method)));
        groups.push((format!("{} with every method", backend.name()), members(&|c| c.1 == *backend)));
    }
    let mut kept: Vec<(String, Vec<usize>)> = Vec::new();
    for (who, members) in groups {
        let is_same =
            |other: &[usize]| other == members || (0..candidates.len()).all(|i| other.contains(&i) != members.contains(&i));
        let is_whole = members.len() == candidates.len();
        match kept.iter_mut().find(|(_, other)| is_same(other)) {
            _ if is_whole => {}
            Some((name, other)) if other.len() == members.len() && *other != members => *name = "one backend or the other".into(),
            Some(_) => {}
            None => kept.push((who, members)),
        }
    }
    kept
}

#[cfg(test)]
#[path = "odd_tests.rs"]
mod tests;
