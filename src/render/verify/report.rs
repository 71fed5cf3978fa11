//! What `verify` tells: one document for programs, and the table that is made of it for people.

use super::lineup::Excluded;
use super::{Candidate, Lineup, Odd, REPLICATES};
use crate::integrator::{Guards, Method};
use crate::render::Program;
use crate::render::same_mean::{CHANNELS, Judgement, Outcome, Picture};
use serde::Serialize;

/// The result of a verification.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// Whether no difference was found and every pair could be told.
    pub agree: bool,
    /// What all pairs come to: a difference if one has it.
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
    /// Who was compared.
    pub candidates: Vec<Entry>,
    /// Who was not.
    pub excluded: Vec<Excluded>,
    /// What was found.
    #[serde(flatten)]
    pub judgement: Judgement,
    /// Whom all differences have in common.
    pub odd: Option<Odd>,
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
    /// Its seed: `render` with it, the method, the backend and 32 replicates makes the same passes.
    pub seed: u64,
    /// Samples per pixel.
    pub spp: u64,
    /// Seconds of rendering.
    pub seconds: f64,
    /// Mean of each channel.
    pub mean: [f64; CHANNELS],
    /// Its standard error.
    pub standard_error: [f64; CHANNELS],
    /// Why that is not to be trusted, if it is not.
    pub doubt: Option<&'static str>,
    /// How often guards changed a sample.
    pub guards: Guards,
}

impl Report {
    /// The report on candidates with these pictures.
    pub fn new(candidates: &[Candidate<'_>], pictures: &[Picture<'_, Method>], lineup: Lineup, judgement: Judgement) -> Report {
        let entries: Vec<Entry> = candidates.iter().zip(pictures).map(|(c, p)| Entry::new(c, p)).collect();
        let provenance = &candidates[0].provenance;
        Report {
            agree: judgement.outcome() == Outcome::Agree,
            outcome: judgement.outcome(),
            scene: candidates[0].stage.path.display().to_string(),
            scene_hash: provenance.scene.hash.clone(),
            program: provenance.program.clone(),
            size: [provenance.settings.width, provenance.settings.height],
            replicates: REPLICATES,
            candidates: entries,
            excluded: lineup.excluded,
            odd: Odd::among(candidates, &judgement),
            judgement,
        }
    }
}

impl Entry {
    fn new(candidate: &Candidate<'_>, picture: &Picture<'_, Method>) -> Entry {
        let settings = &candidate.provenance.settings;
        let image = std::array::from_fn::<_, CHANNELS, _>(|c| picture.pyramid.image_mean(c));
        Entry {
            name: candidate.name.clone(),
            method: settings.method,
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
