//! Images behind a judgement: each candidate's picture, and the difference of the worst pair in standard errors.

use super::{Candidate, REPLICATES};
use crate::error::{Error, Kind, Result};
use crate::film::Plane;
use crate::io::png::ToneCurve;
use crate::io::{exr, png};
use crate::lab::same_mean::{Judgement, PairJudgement};
use crate::session::{Outputs, RenderReport, images};
use std::path::Path;

/// Writes an EXR and a PNG of each candidate, and of the differences of the worst pair, into `folder`, which is created
/// if needed.
///
/// # Errors
/// A folder or file cannot be written.
pub fn write(folder: &Path, candidates: &[Candidate<'_>], judgement: &Judgement) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(|cause| Error::write(folder, cause))?;
    candidates.iter().try_for_each(|candidate| write_candidate(folder, candidate))?;
    match judgement.worst() {
        Some(pair) => write_differences(folder, &candidates[pair.a], &candidates[pair.b]),
        None => Ok(()),
    }
}

/// Name of a candidate in file names.
fn stem(candidate: &Candidate<'_>) -> String {
    candidate.name.replace('/', "-")
}

fn write_candidate(folder: &Path, candidate: &Candidate<'_>) -> Result<()> {
    let outputs = Outputs::of(&folder.join(stem(candidate) + ".exr"))?.with_png();
    let layers = images::layers(&candidate.provenance, candidate.film(), None);
    let report = RenderReport::new(
        &candidate.provenance,
        candidate.film(),
        &layers,
        &outputs,
        Some(candidate.stage.preparation),
    );
    images::write(&outputs, &candidate.provenance, candidate.film(), &layers, &report)
}

/// Pixel differences of two candidates in standard errors; 0 where neither has an error.
fn scores(a: &Candidate<'_>, b: &Candidate<'_>) -> Option<Vec<f32>> {
    let errors = a.film().standard_error()?.into_iter().zip(b.film().standard_error()?);
    let means = a.film().mean(Plane::Color).into_iter().zip(b.film().mean(Plane::Color));
    let score = |((a, b), (sa, sb)): ((f32, f32), (f32, f32))| {
        let error = sa.hypot(sb);
        if error > 0.0 { (a - b) / error } else { 0.0 }
    };
    Some(means.zip(errors).map(score).collect())
}

fn write_differences(folder: &Path, a: &Candidate<'_>, b: &Candidate<'_>) -> Result<()> {
    let Some(z) = scores(a, b) else {
        return Err(Error::new(Kind::Internal, format!("{REPLICATES} replicates without a standard error")));
    };
    let name = format!("z-{}-minus-{}", stem(a), stem(b));
    let layout = a.film().layout();
    let channel = |c: usize| z.iter().skip(c).step_by(3).copied().collect();
    let layers: Vec<exr::Layer> = ["R", "G", "B"]
        .iter()
        .enumerate()
        .map(|(c, &name)| exr::Layer { name: name.into(), values: channel(c) })
        .collect();
    let crop = layout.crop;
    exr::write(
        &folder.join(format!("{name}.exr")),
        layout.width,
        layout.height,
        a.provenance.settings.crop,
        &layers,
        &[],
    )?;
    let shown: Vec<f32> = z.chunks_exact(3).flat_map(|z| shade((z[0] + z[1] + z[2]) / 3.0)).collect();
    let (width, height) = (crop.x1 - crop.x0, crop.y1 - crop.y0);
    let picture = png::PngPicture { width, height, rgb: &shown, alpha: None };
    png::write(&folder.join(format!("{name}.png")), picture, 0.0, ToneCurve::Srgb, &[])
}

/// White for no difference, red where the first is brighter, blue where the second is; saturated at five standard
/// errors.
fn shade(z: f32) -> [f32; 3] {
    let rest = 1.0 - (z.abs() / 5.0).min(1.0);
    if z > 0.0 { [1.0, rest, rest] } else { [rest, rest, 1.0] }
}

impl Judgement {
    /// Returns the pair with the most significant difference.
    pub fn worst(&self) -> Option<&PairJudgement> {
        let worst = |p: &PairJudgement| {
            let tile = p.tile.map_or((1.0, 0.0), |t| (t.p_value, t.t.abs()));
            (p.image.p_value.min(tile.0), p.image.t.abs().max(tile.1))
        };
        self.pairs.iter().min_by(|x, y| {
            let (x, y) = (worst(x), worst(y));
            x.0.total_cmp(&y.0).then(y.1.total_cmp(&x.1))
        })
    }
}
