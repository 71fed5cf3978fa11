//! Merges films of the same picture: shards of a farm, ranges of passes, sessions on several machines. Sums are
//! integers per replicate. The result is therefore bit-identical to a single run, in any merge order.

use super::{PassPlan, PassSelection, Provenance, StopCriteria, checkpoint};
use crate::error::{Error, Kind, Result};
use crate::film::{Film, PassSet};
use std::path::PathBuf;

/// Treatment of passes that no film holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gaps {
    /// Missing passes are an error.
    Refuse,
    /// Merges the passes that are there.
    Allow,
}

/// Reads the films at `paths` and merges them.
///
/// # Errors
/// Unreadable films; films of another scene, settings, seed or version; passes held twice; passes missing.
pub fn merge(paths: &[PathBuf], gaps: Gaps) -> Result<(Provenance, Film)> {
    let [first, others @ ..] = paths else { return Err(Error::usage("nothing to merge")) };
    let (mut provenance, mut film) = checkpoint::restore(first)?;
    let (mut plans, replicates) = (vec![provenance.plan], provenance.settings.replicates);
    for path in others {
        let named = |mut e: Error| {
            e.kind = Kind::Usage;
            e.context(format!("cannot merge {} with {}", path.display(), first.display()))
        };
        let (other, file) = checkpoint::open(path)?;
        provenance.same_picture(&other).map_err(named)?;
        film.head().admits(file.head()).map_err(named)?;
        file.add_to(&mut film)?;
        provenance.work.absorb(other.work);
        plans.push(other.plan);
    }
    let total = plans.iter().map(|plan| plan.picture(film.passes(), replicates)).max().unwrap_or_default();
    if gaps == Gaps::Refuse {
        let mut missing = PassSet::default();
        plans.iter().for_each(|plan| missing.union(&plan.missing(film.passes(), replicates)));
        complete(&missing, total)?;
    }
    provenance.plan = PassPlan { stop: StopCriteria::after(total), selection: PassSelection::All };
    Ok((provenance, film))
}

fn complete(missing: &PassSet, total: u64) -> Result<()> {
    if missing.is_empty() {
        return Ok(());
    }
    Err(Error::usage(format!("passes {missing} of {total} are missing: add their films, or merge with --allow-gaps")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{PassFilm, Units};
    use crate::session::provenance::{Program, SceneRecord, Work};
    use crate::session::{SettingsPatch, ToneMapping, film_file};
    use rayon::iter::ParallelIterator;

    struct Films(tempfile::TempDir);

    impl Films {
        fn new() -> Self {
            Films(tempfile::tempdir().unwrap())
        }

        /// Writes a film of a tiny picture with the passes of `selection`, after `change` to its provenance.
        fn write(&self, name: &str, selection: &str, change: impl Fn(&mut Provenance)) -> PathBuf {
            self.write_some(name, selection, usize::MAX, change)
        }

        /// As [`Self::write`], with at most `most` of the passes.
        fn write_some(&self, name: &str, selection: &str, most: usize, change: impl Fn(&mut Provenance)) -> PathBuf {
            let choices =
                SettingsPatch { size: Some("4x2".parse().unwrap()), spp: Some(16), ..SettingsPatch::default() };
            let selection = if selection.is_empty() { PassSelection::All } else { selection.parse().unwrap() };
            let mut provenance = Provenance {
                program: Program::current(),
                scene: SceneRecord {
                    path: "scene.gltf".into(),
                    surroundings: None,
                    media: crate::session::Media::default(),
                    hash: "a".into(),
                    ignored: vec![],
                    warnings: vec![],
                    blind_spots: vec![],
                    prior: Default::default(),
                },
                settings: choices.settings(None).unwrap(),
                plan: choices.plan(selection).unwrap(),
                look: ToneMapping::default(),
                work: Work { sessions: 1, ..Work::default() },
            };
            change(&mut provenance);
            let (settings, path) = (&provenance.settings, self.0.path().join(name));
            let units = Units { radiance: 1.0, length: 1.0 };
            let mut film = Film::new(settings.layout(), settings.replicates, settings.seed, units);
            let mut values = PassFilm::new(&settings.layout());
            for pass in provenance.plan.passes().take(most) {
                values.par_chunks(1).for_each(|(pixel, out)| out.fill((pass * 8 + pixel as u64) as f32 * 0.1));
                film.commit(pass, &values);
            }
            film_file::write(&path, &serde_json::json!(provenance), &film).unwrap();
            path
        }
    }

    fn refusal(paths: &[PathBuf]) -> String {
        merge(paths, Gaps::Refuse).err().unwrap().chain()
    }

    #[test]
    fn merged_shards_equal_one_run_in_any_order() {
        let films = Films::new();
        let mut shards: Vec<_> = (0..3).map(|i| films.write(&format!("{i}.film"), &format!("{i}/3"), |_| ())).collect();
        let (provenance, film) = merge(&shards, Gaps::Refuse).unwrap();
        assert_eq!((film.passes().to_string(), provenance.work.sessions), ("0-15".into(), 3));
        shards.rotate_left(1);
        shards.swap(0, 1);
        assert!(merge(&shards, Gaps::Refuse).unwrap().1 == film);
        let whole = films.write("whole.film", "", |_| ());
        assert!(merge(&[whole], Gaps::Refuse).unwrap().1 == film);
    }

    #[test]
    fn merged_films_can_be_merged_again() {
        let films = Films::new();
        let shards: Vec<_> = (0..3).map(|i| films.write(&format!("{i}.film"), &format!("{i}/3"), |_| ())).collect();
        let (provenance, film) = merge(&shards[..2], Gaps::Allow).unwrap();
        let part = films.0.path().join("part.film");
        checkpoint::save(&part, &provenance, &film).unwrap();
        assert!(merge(&[part, shards[2].clone()], Gaps::Refuse).is_ok());
    }

    #[test]
    fn gaps_are_refused_unless_allowed() {
        let films = Films::new();
        let one = films.write("1.film", "1/2", |_| ());
        assert!(refusal(std::slice::from_ref(&one)).contains("missing"));
        assert_eq!(merge(&[one], Gaps::Allow).unwrap().1.passes().len(), 8);
        let (a, c) = (films.write("a.film", "0..4", |_| ()), films.write("c.film", "6..8", |_| ()));
        assert!(refusal(&[a.clone(), c.clone()]).contains("4-5 of 8"));
        let b = films.write("b.film", "4..6", |_| ());
        assert!(merge(&[c, b, a], Gaps::Refuse).is_ok());
    }

    /// Timed shards stop independently. A merged film is continued up to the last pass of the furthest shard.
    #[test]
    fn time_limited_shards_of_unequal_length_merge() {
        let films = Films::new();
        let timed =
            |p: &mut Provenance| p.plan.stop = StopCriteria { spp: None, seconds: Some(1.0), target_error: None };
        let shards = [5, 3, 4]
            .map(|most| films.write_some(&format!("{most}.film"), &format!("{}/3", (5 - most) % 3), most, timed));
        let (provenance, film) = merge(&shards, Gaps::Refuse).unwrap();
        assert_eq!((film.passes().to_string(), provenance.plan.stop.spp), ("0-10,12".to_owned(), Some(13)));
        assert!(refusal(&shards[..2]).contains("are missing"));
    }

    #[test]
    fn overlaps_and_other_pictures_are_refused_by_name() {
        let films = Films::new();
        let all = films.write("all.film", "", |_| ());
        assert!(refusal(&[all.clone(), films.write("again.film", "3..5", |_| ())]).contains("both hold pass 3"));
        type Change = fn(&mut Provenance);
        let others: [(&str, Change); 4] = [
            ("scenes", |p| p.scene.hash = "b".into()),
            ("settings: depth", |p| p.settings.depth = Some(1)),
            ("seeds", |p| p.settings.seed = 1),
            ("versions", |p| p.program.version = "0.0.0".into()),
        ];
        for (what, change) in others {
            let text = refusal(&[all.clone(), films.write("other.film", "16..32", change)]);
            assert!(text.contains(what) && text.contains("other.film"), "{text}");
        }
    }
}
