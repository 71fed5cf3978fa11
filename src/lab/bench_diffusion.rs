//! Errors of the diffusion models in a medium, against the random walk in a half-space.

use crate::named::Named;
use crate::stats::Estimate;
use crate::subsurface::reference::{Bins, Incidence, Reflectance, Walk};
use crate::subsurface::{DiffusionModel, MediumLane, RadialProfile, Tabulated, totals};
use rayon::prelude::*;
use std::fmt::Write;

/// Rings that profiles are compared in, in mean free paths.
const RINGS: Bins = Bins { first: 0.1, last: 10.0, count: 40 };

/// Media to measure, and how long.
#[derive(Debug, Clone, PartialEq)]
pub struct DiffusionBench {
    /// Single-scattering albedos in [0, 1].
    pub albedos: Vec<f64>,
    /// Mean cosine g of the phase function, inside (−1, 1).
    pub mean_cosine: f64,
    /// Index inside over that outside, at least 1.
    pub eta: f64,
    /// Paths for each albedo.
    pub paths: usize,
    /// Seed of the walks.
    pub seed: u64,
}

/// Results for one albedo. Errors are relative.
#[derive(Debug, Clone, PartialEq)]
pub struct DiffusionErrors {
    /// The medium, with a mean free path of 1.
    pub medium: MediumLane,
    /// The exact total reflectance of diffuse light that has entered.
    pub exact: f64,
    /// The total by the walk.
    pub walk: Estimate,
    /// Sum of the standard errors of the rings over the light in them.
    pub noise: f64,
    /// Errors by model, in the order of their declaration.
    pub models: Vec<ModelErrors>,
}

/// Errors of one model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelErrors {
    /// Of the total.
    pub total: f64,
    /// Of the profile: ∫ |M − R| r dr / ∫ R r dr over the rings.
    pub profile: f64,
}

impl DiffusionBench {
    /// Measures all models in all media.
    pub fn run(&self) -> Vec<DiffusionErrors> {
        self.albedos.par_iter().map(|&albedo| self.measure(albedo)).collect()
    }

    fn measure(&self, albedo: f64) -> DiffusionErrors {
        let &DiffusionBench { mean_cosine, eta, paths, seed, .. } = self;
        let medium = MediumLane { absorption: 1.0 - albedo, scattering: albedo, mean_cosine, eta };
        let (depth, incidence) = (f64::INFINITY, Incidence::Diffuse);
        let walk = Walk { albedos: vec![albedo], mean_cosine, eta, depth, incidence, bins: RINGS };
        let found = walk.run(paths, seed).remove(0);
        let exact = totals::diffuse_total(&medium);
        let errors = |model: &DiffusionModel| errors(&model.profile(&medium), exact, &found);
        let light: f64 = found.rings.iter().map(|ring| ring.value).sum();
        let noise = found.rings.iter().map(|ring| ring.standard_error).sum::<f64>() / light;
        let models = DiffusionModel::all().iter().map(errors).collect();
        DiffusionErrors { medium, exact, walk: found.total, noise, models }
    }
}

fn errors(profile: &Tabulated, exact: f64, walk: &Reflectance) -> ModelErrors {
    let ring = |i: usize| profile.total() * (profile.tail(RINGS.edge(i)) - profile.tail(RINGS.edge(i + 1)));
    let light: f64 = walk.rings.iter().map(|ring| ring.value).sum();
    let distance: f64 = walk.rings.iter().enumerate().map(|(i, found)| (ring(i) - found.value).abs()).sum();
    ModelErrors { total: profile.total() / exact - 1.0, profile: distance / light }
}

/// Returns the errors as tables in Markdown, in percent.
pub fn table(results: &[DiffusionErrors]) -> String {
    let mut text = String::from("Error of the total reflectance of diffuse light, %\n\n");
    rows(&mut text, &["exact", "walk"], results, |result| {
        let Estimate { value, standard_error, .. } = result.walk;
        let known = [format!("{:.6}", result.exact), format!("{value:.5} ± {standard_error:.5}")];
        let errors = result.models.iter().map(|model| format!("{:+.1}", 100.0 * model.total));
        known.into_iter().chain(errors).collect()
    });
    text.push_str("\nMean error of the profile over 0.1 to 10 mean free paths, %\n\n");
    rows(&mut text, &["noise of the walk"], results, |result| {
        let noise = format!("{:.2}", 100.0 * result.noise);
        let errors = result.models.iter().map(|model| format!("{:.1}", 100.0 * model.profile));
        std::iter::once(noise).chain(errors).collect()
    });
    text
}

/// Appends a table with a row for each result: its albedo, and the `cells` under `known` columns and the models.
fn rows(
    text: &mut String,
    known: &[&str],
    results: &[DiffusionErrors],
    cells: impl Fn(&DiffusionErrors) -> Vec<String>,
) {
    let models = DiffusionModel::all().iter().map(|model| model.name());
    let columns: Vec<&str> = std::iter::once("ω").chain(known.iter().copied()).chain(models).collect();
    // Writing to a string does not fail.
    let _ = writeln!(text, "| {} |\n|{}", columns.join(" | "), "---|".repeat(columns.len()));
    for result in results {
        let _ = writeln!(text, "| {} | {} |", result.medium.scattering, cells(result).join(" | "));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The walk and the exact total agree by Student's test at the level 1e-6, and tables have a row for each albedo.
    #[test]
    fn the_walk_has_the_exact_total() {
        let bench = DiffusionBench { albedos: vec![0.5, 0.9], mean_cosine: 0.3, eta: 1.4, paths: 200_000, seed: 1 };
        let results = bench.run();
        for result in &results {
            assert!(result.walk.sigmas(result.exact).abs() < 5.42, "{result:?}");
            let beam = result.models[DiffusionModel::PhotonBeam as usize];
            assert!(beam.total.abs() < 1e-9 && beam.profile < 0.2, "{result:?}");
        }
        let text = table(&results);
        assert_eq!(text.lines().filter(|line| line.starts_with("| 0.")).count(), 4, "{text}");
    }
}
