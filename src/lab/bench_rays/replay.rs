//! Replays one ray by its address: its bits, and the answer of every row.

use super::compare::reference;
use super::row::Row;
use super::stream::RayStream;
use crate::accel::Intersector;
use crate::error::{Error, Result};
use crate::geometry::{Geometry, Opaque, Ray};
use crate::lab::equivalence::{Agreement, agreement};
use crate::lab::hard_cases;
use serde::Serialize;
use std::str::FromStr;

/// Address of a ray: `cornell-box/shadow:17` in the stream of a scene, `sphere-edges:1234` in a hard case.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RayAddress {
    /// The scene; `None` for a hard case.
    pub scene: Option<String>,
    /// The group of rays, or the hard case.
    pub group: String,
    /// Index in the group, from 0.
    pub index: u64,
}

/// A ray and the answers of all rows.
#[derive(Debug, Clone, Serialize)]
pub struct Replay {
    /// Its address.
    pub address: String,
    /// Origin, direction, first and last parameter in decimals. Non-finite values are `null` in JSON.
    pub ray: [f32; 8],
    /// The same values as hexadecimal bits.
    pub bits: [String; 8],
    /// The answers by backend.
    pub answers: Vec<Answer>,
}

/// Answer of a backend for a ray.
#[derive(Debug, Clone, Serialize)]
pub struct Answer {
    /// The backend and its build.
    pub backend: String,
    /// The closest hit.
    pub closest: Option<Met>,
    /// Whether the ray is occluded.
    pub occluded: bool,
    /// Agreement with the closest hit of the reference.
    pub agreement: Agreement,
}

/// A hit.
#[derive(Debug, Clone, Serialize)]
pub struct Met {
    /// Index of the object in the geometry.
    pub object: u32,
    /// Name of its mesh.
    pub mesh: String,
    /// Index of the triangle in the mesh.
    pub primitive: u32,
    /// Ray parameter, recomputed from the triangle; `None` for a triangle without area.
    pub t: Option<f32>,
}

impl FromStr for RayAddress {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let wrong = || format!("'{text}' is no address: write SCENE/CLASS:INDEX or CASE:INDEX, as reports do");
        let (place, index) = text.rsplit_once(':').ok_or_else(wrong)?;
        let (scene, group) =
            place.rsplit_once('/').map_or((None, place), |(scene, group)| (Some(scene.to_owned()), group));
        let index = index.parse().map_err(|_| wrong())?;
        Ok(RayAddress { scene, group: group.to_owned(), index })
    }
}

impl std::fmt::Display for RayAddress {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let RayAddress { scene, group, index } = self;
        scene.as_ref().map_or(Ok(()), |scene| write!(f, "{scene}/"))?;
        write!(f, "{group}:{index}")
    }
}

impl RayAddress {
    /// Returns the ray at this address of `stream`.
    ///
    /// # Errors
    /// A usage error if there is none.
    pub(super) fn in_stream(&self, stream: &RayStream) -> Result<Ray> {
        let groups = stream.groups();
        let Some(group) = groups.iter().find(|group| group.name == self.group) else {
            let names: Vec<_> = groups.iter().map(|group| group.name).collect();
            return Err(Error::usage(format!("--replay {self}: there are no such rays, but {}", names.join(", "))));
        };
        let question = usize::try_from(self.index).ok().and_then(|index| group.questions.get(index));
        let none = || Error::usage(format!("--replay {self}: there are {} such rays", group.questions.len()));
        Ok(question.ok_or_else(none)?.ray)
    }

    /// Returns the hard case of this address.
    ///
    /// # Errors
    /// A usage error if there is none.
    pub(super) fn case(&self) -> Result<hard_cases::HardCase> {
        hard_cases::by_name(&self.group)
            .ok_or_else(|| Error::usage(format!("--replay {self}: there is no such hard case")))
    }
}

/// Traces the ray on all `rows`, built over `geometry`.
pub(super) fn replay(address: &RayAddress, geometry: &Geometry, ray: &Ray, rows: &[Row]) -> Replay {
    let expected = reference(rows).structure.closest(ray, &Opaque);
    let answer = |row: &Row| {
        let closest = row.structure.closest(ray, &Opaque);
        Answer {
            backend: row.title.clone(),
            closest: closest.map(|hit| Met {
                object: hit.object,
                mesh: geometry.mesh_of(hit.object).name().to_owned(),
                primitive: hit.primitive,
                t: geometry.triangle(hit).meet(ray).map(|met| met.t),
            }),
            occluded: row.structure.occluded(ray, &Opaque),
            agreement: agreement(geometry, ray, closest, expected),
        }
    };
    let ([ox, oy, oz], [dx, dy, dz]) = (ray.origin.to_array(), ray.direction.to_array());
    let numbers = [ox, oy, oz, dx, dy, dz, ray.t_min, ray.t_max];
    Replay {
        address: address.to_string(),
        ray: numbers,
        bits: numbers.map(|x| format!("{:08x}", x.to_bits())),
        answers: rows.iter().map(answer).collect(),
    }
}

impl Replay {
    /// Formats the replay as lines of text.
    pub fn lines(&self) -> Vec<String> {
        let part = |name: &str, range: std::ops::Range<usize>| {
            let decimals: Vec<String> = self.ray[range.clone()].iter().map(|x| format!("{x:?}")).collect();
            format!("  {name:9} {}  (bits {})", decimals.join(" "), self.bits[range].join(" "))
        };
        let mut lines = vec![self.address.clone(), part("origin", 0..3), part("direction", 3..6), part("t", 6..8)];
        lines.extend(self.answers.iter().map(|answer| {
            let hit = answer.closest.as_ref().map_or("nothing".into(), |met| {
                let t = met.t.map_or("of a triangle without area".into(), |t| format!("at t {t:?}"));
                format!("object {} ('{}') triangle {} {t}", met.object, met.mesh, met.primitive)
            });
            let occluded = if answer.occluded { "occluded" } else { "not occluded" };
            let agreement = match answer.agreement {
                Agreement::Same => "the same as the reference",
                Agreement::Tie => "a tie",
                Agreement::Graze => "a graze",
                Agreement::Different => "a true difference",
            };
            format!("  {:15} hits {hit}, {occluded}: {agreement}", answer.backend)
        }));
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_read_as_they_are_written() {
        for text in ["cornell-box/bounce-4+:17", "a:b/c/shadow:0", "sphere-edges:1234"] {
            assert_eq!(text.parse::<RayAddress>().unwrap().to_string(), text);
        }
        assert_eq!("a/b/shadow:3".parse::<RayAddress>().unwrap().scene.as_deref(), Some("a/b"));
        for text in ["", "shadow", "box/shadow", "box/shadow:", "box/shadow:-1", "box/shadow:x"] {
            assert!(text.parse::<RayAddress>().unwrap_err().contains("no address"), "{text}");
        }
    }
}
