//! Compares the hits of each row with those of a reference: the scenes' streams class by class, and the hard cases.

use super::row::{Mode, Row, Structure};
use super::stream::Group;
use crate::accel::{Backend, Build};
use crate::error::Result;
use crate::geometry::{Geometry, Ray};
use crate::lab::equivalence::{Category, DifferenceCounts};
use crate::lab::hard_cases;
use serde::Serialize;

/// Agreement of a backend with the reference on a group of rays.
#[derive(Debug, Clone, Serialize)]
pub struct CategoryRow {
    /// The scene; `None` for a hard case.
    pub scene: Option<String>,
    /// The group of rays, the backend, and the counts.
    #[serde(flatten)]
    pub category: Category,
    /// Replay addresses of the first rays with a true difference or a leak.
    pub addresses: Vec<String>,
}

impl CategoryRow {
    fn new(scene: Option<&str>, category: Category) -> CategoryRow {
        let group = scene.map_or(category.name.clone(), |scene| format!("{scene}/{}", category.name));
        let addresses = category.tally.suspects.iter().map(|index| format!("{group}:{index}")).collect();
        CategoryRow { scene: scene.map(str::to_owned), category, addresses }
    }
}

/// The reference row: the robust build of the default backend, else the first row.
pub(super) fn reference(rows: &[Row]) -> &Row {
    let preferred = hard_cases::title(hard_cases::reference());
    rows.iter().find(|row| row.title == preferred).unwrap_or(&rows[0])
}

/// Runs both queries of every row, in each of its modes, on every ray of a scene's groups.
pub(super) fn streams(geometry: &Geometry, scene: &str, groups: &[Group], rows: &mut [Row]) -> Vec<CategoryRow> {
    let mut found = Vec::new();
    for group in groups {
        let rays = group.rays();
        for row in 0..rows.len() {
            let modes: Vec<Mode> = rows[row].ways.iter().map(|way| way.mode).collect();
            found.extend(modes.into_iter().map(|mode| {
                rows[row].prepare(mode);
                let (row, reference) = (&rows[row], reference(rows));
                let (name, backend) = (group.name.to_owned(), row.title_of(mode));
                let tally = tally(geometry, &rays, (&row.structure, mode), &reference.structure);
                let category = Category { name, backend, reference: reference.title.clone(), tally };
                CategoryRow::new(Some(scene), category)
            }));
        }
    }
    found
}

/// Compares a structure with the reference. It is unknown whether a scene is closed, so that leaks are not counted.
fn tally(
    geometry: &Geometry,
    rays: &[Ray],
    (structure, mode): (&Structure, Mode),
    reference: &Structure,
) -> DifferenceCounts {
    match mode {
        Mode::Single => DifferenceCounts::of(geometry, rays, structure, reference, false),
        Mode::Batch { coherence, .. } => {
            DifferenceCounts::of_batches(geometry, rays, (structure, coherence), reference, false)
        }
    }
}

/// Runs every backend on the first `rays` rays of every hard case. `note` receives the name of each.
///
/// # Errors
/// As [`crate::accel::Accel::build`].
pub(super) fn hard(
    setups: &[(Backend, Build)],
    rays: u64,
    threads: usize,
    note: &mut dyn FnMut(&str),
) -> Result<Vec<CategoryRow>> {
    let mut found = Vec::new();
    for case in hard_cases::all() {
        note(&format!("{}: comparing the hits of {rays} rays", case.name()));
        found.extend(case.measure(setups, rays, threads)?.into_iter().map(|category| CategoryRow::new(None, category)));
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::RayClass;
    use crate::lab::bench_rays::RayStream;
    use crate::lab::bench_rays::{Query, RayQuery};
    use crate::stats::test_random::Random;
    use glam::Vec3;

    /// Streams may contain any bit pattern. Nothing panics, and a ray without finite origin and direction hits nothing
    /// on any backend.
    #[test]
    fn rays_of_any_bits_can_be_compared() {
        let case = hard_cases::by_name("random").unwrap();
        let backends =
            Backend::AVAILABLE.iter().map(|&backend| Row::of_backend(case.geometry(), (backend, Build::Robust), 1));
        let rows = backends.chain([Row::of_cwbvh(case.geometry())]).collect::<Result<Vec<Row>>>();
        let mut rows = rows.unwrap();
        let mut random = Random::new(1);
        let question = |i: u32| {
            let mut bits = || f32::from_bits((random.uniform() * f64::from(u32::MAX)) as u32);
            let mut vector = || Vec3::new(bits(), bits(), bits());
            let (mut origin, mut direction) = (Vec3::ZERO, vector());
            match i % 3 {
                0 => origin = vector(),
                1 => origin[(i / 3) as usize % 3] = f32::NAN,
                _ => direction[(i / 3) as usize % 3] = f32::INFINITY,
            }
            let (t_min, t_max) = (bits().abs(), bits());
            // Camera rays may be valid, the others are not.
            let class = if i % 3 == 0 { RayClass::Camera } else { RayClass::Shadow };
            RayQuery { ray: Ray { t_min, t_max, ..Ray::new(origin, direction) }, query: Query::Closest, class }
        };
        let questions = (0..30_000).map(question).collect();
        let stream = RayStream { name: "bits".into(), scene_hash: String::new(), questions };
        let found = streams(case.geometry(), &stream.name, &stream.groups(), &mut rows);
        assert_eq!(found.len(), 2 * rows.iter().map(|row| row.ways.len()).sum::<usize>());
        for row in found.iter().filter(|row| row.category.name == "shadow") {
            let tally = &row.category.tally;
            assert_eq!((tally.rays, tally.hits, tally.true_differences), (20_000, 0, 0), "{row:?}");
        }
    }
}
