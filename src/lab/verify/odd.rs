//! Identifies the candidates responsible for the differences, as far as the pattern of differing pairs allows.

use super::Candidate;
use crate::accel::Backend;
use crate::integrator::Method;
use crate::lab::same_mean::Judgement;
use crate::named::Named;
use serde::Serialize;

/// The smallest group of candidates involved in all differences.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Outlier {
    /// The group: one candidate, a method with every backend, or a backend with every method.
    pub who: String,
    /// Whether each of them differs from every candidate outside the group.
    pub from_all: bool,
}

/// A candidate's method, backend and name.
pub(super) type Label = (Method, Backend, String);

impl Outlier {
    /// Finds the smallest group involved in all differences, if one stands out.
    pub fn among(candidates: &[Candidate<'_>], judgement: &Judgement) -> Option<Outlier> {
        let settings =
            |c: &Candidate<'_>| (c.provenance.settings.method.kind(), c.provenance.settings.backend, c.name.clone());
        Outlier::of(&candidates.iter().map(settings).collect::<Vec<_>>(), judgement)
    }

    pub(super) fn of(candidates: &[Label], judgement: &Judgement) -> Option<Outlier> {
        let different: Vec<[usize; 2]> = judgement.pairs.iter().filter(|p| p.differs()).map(|p| [p.a, p.b]).collect();
        if different.is_empty() || candidates.len() < 3 {
            return None;
        }
        let explained = |members: &[usize]| different.iter().all(|[a, b]| members.contains(a) != members.contains(b));
        let across = |members: &[usize]| members.len() * (candidates.len() - members.len());
        let suspects = groups(candidates).into_iter().filter(|(_, members)| explained(members));
        let found: Vec<Outlier> =
            suspects.map(|(who, members)| Outlier { who, from_all: across(&members) == different.len() }).collect();
        let certain: Vec<&Outlier> = found.iter().filter(|o| o.from_all).collect();
        match (certain.as_slice(), found.as_slice()) {
            ([one], _) => Some((*one).clone()),
            ([], [one]) => Some(one.clone()),
            _ => None,
        }
    }
}

/// Groups of candidates: each candidate, each method and each backend, with their members. Two backends count as one
/// distinction.
fn groups(candidates: &[Label]) -> Vec<(String, Vec<usize>)> {
    let members =
        |is: &dyn Fn(&Label) -> bool| (0..candidates.len()).filter(|&i| is(&candidates[i])).collect::<Vec<_>>();
    let mut groups: Vec<(String, Vec<usize>)> =
        candidates.iter().enumerate().map(|(i, c)| (c.2.clone(), vec![i])).collect();
    for (method, backend, _) in candidates {
        groups.push((format!("{} with every backend", method.name()), members(&|c| c.0 == *method)));
        groups.push((format!("{} with every method", backend.name()), members(&|c| c.1 == *backend)));
    }
    let mut kept: Vec<(String, Vec<usize>)> = Vec::new();
    for (who, members) in groups {
        let is_same = |other: &[usize]| {
            other == members || (0..candidates.len()).all(|i| other.contains(&i) != members.contains(&i))
        };
        let is_whole = members.len() == candidates.len();
        match kept.iter_mut().find(|(_, other)| is_same(other)) {
            _ if is_whole => {}
            Some((name, other)) if other.len() == members.len() && *other != members => {
                *name = "one backend or the other".into()
            }
            Some(_) => {}
            None => kept.push((who, members)),
        }
    }
    kept
}

#[cfg(test)]
#[path = "odd_tests.rs"]
mod tests;
