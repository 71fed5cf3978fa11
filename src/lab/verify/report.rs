//! The report of `verify`: one JSON document, and the table derived from it.

use super::lineup::Excluded;
use super::{Candidate, Lineup, Outlier, REPLICATES};
use crate::film::pyramid::CHANNELS;
use crate::integrator::{Guards, Method};
use crate::lab::same_mean::{Judgement, Outcome, TestedPicture};
use crate::session::Program;
use serde::Serialize;

/// The result of a verification.
#[derive(Debug, Clone, Serialize)]
pub struct VerifyReport {
    /// Whether every pair was decided and no difference was found.
    pub agree: bool,
    /// Outcome over all pairs: a difference if any pair differs.
    pub outcome: Outcome,
    /// The scene's file.
    pub scene: String,
    /// The hash of its content.
    pub scene_hash: String,
    program: Program,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Independent replicates of each candidate.
    pub replicates: u32,
    /// The compared candidates.
    pub candidates: Vec<Entry>,
    /// The excluded methods.
    pub excluded: Vec<Excluded>,
    /// Verdict on all pairs.
    #[serde(flatten)]
    pub judgement: Judgement,
    /// The candidates involved in all differences.
    pub odd: Option<Outlier>,
}

/// A candidate in the report.
#[derive(Debug, Clone, Serialize)]
pub struct Entry {
    /// Method and backend.
    pub name: String,
    /// The method.
    pub method: Method,
    /// The backend.
    pub backend: crate::accel::Backend,
    /// Its seed. `render` with this seed, the method, the backend and 32 replicates renders the same passes.
    pub seed: u64,
    /// Samples per pixel.
    pub spp: u64,
    /// Seconds of rendering.
    pub seconds: f64,
    /// Mean of each channel.
    pub mean: [f64; CHANNELS],
    /// Standard error of each mean.
    pub standard_error: [f64; CHANNELS],
    /// Reason to distrust the error, if there is one.
    pub doubt: Option<&'static str>,
    /// Number of samples changed by guards.
    pub guards: Guards,
}

impl VerifyReport {
    /// Builds the report on candidates with these pictures.
    pub fn new(
        candidates: &[Candidate<'_>],
        pictures: &[TestedPicture<'_, Method>],
        lineup: Lineup,
        judgement: Judgement,
    ) -> VerifyReport {
        let entries: Vec<Entry> = candidates.iter().zip(pictures).map(|(c, p)| Entry::new(c, p)).collect();
        let provenance = &candidates[0].provenance;
        VerifyReport {
            agree: judgement.outcome() == Outcome::Agree,
            outcome: judgement.outcome(),
            scene: candidates[0].stage.path.display().to_string(),
            scene_hash: provenance.scene.hash.clone(),
            program: provenance.program.clone(),
            size: [provenance.settings.width, provenance.settings.height],
            replicates: REPLICATES,
            candidates: entries,
            excluded: lineup.excluded,
            odd: Outlier::among(candidates, &judgement),
            judgement,
        }
    }
}

impl Entry {
    fn new(candidate: &Candidate<'_>, picture: &TestedPicture<'_, Method>) -> Entry {
        let settings = &candidate.provenance.settings;
        let image = std::array::from_fn::<_, CHANNELS, _>(|c| picture.pyramid.image_mean(c));
        Entry {
            name: candidate.name.clone(),
            method: settings.method.kind(),
            backend: settings.backend,
            seed: settings.seed,
            spp: candidate.spp(),
            seconds: candidate.seconds(),
            mean: image.map(|e| e.value),
            standard_error: image.map(|e| e.standard_error),
            doubt: picture.doubt.map(|doubt| doubt.sentence),
            guards: candidate.provenance.work.passes.guards,
        }
    }
}
