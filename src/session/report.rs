//! Render reports: one document, printed with `--json`, written with `--report`, and flattened into the header of the
//! EXR image as `etendue.` attributes (`etendue.render.wall_seconds`, …).

use super::provenance::Program;
use super::target::{self, Check};
use super::{LoadTimings, Outputs, PassPlan, Provenance, RenderSettings, Surroundings, machine};
use crate::film::{Film, ImageError, Plane};
use crate::integrator::{ChainDigest, Guards, InvalidSample, LightSelection};
use crate::io::exr::{self, Attribute, Layer};
use crate::numeric;
use crate::spectrum::LANES;
use serde::Serialize;
use serde_json::Value;

/// Image attribute that identifies its content: see [`Provenance::identity`].
pub(super) const IDENTITY: &str = "etendue.identity";

/// The report of a render or a merge.
#[derive(Debug, Clone, Serialize)]
pub struct RenderReport {
    image: Option<String>,
    film: Option<String>,
    program: Program,
    machine: Machine,
    scene: Scene,
    settings: RenderSettings,
    settings_hash: String,
    /// See [`Provenance::identity`]; `None` where passes are missing.
    identity: Option<String>,
    plan: PassPlan,
    load: Option<Phase>,
    build: Option<Phase>,
    render: Render,
    error: Option<ImageError>,
    target: Option<TargetReport>,
    guards: Guards,
    chains: Option<ChainDigest>,
    clamp: Option<Clamp>,
    /// See [`RenderSettings::approximation`].
    approximate: Option<String>,
    invalid: Vec<Invalid>,
    pixel_hash: String,
}

#[derive(Debug, Clone, Serialize)]
struct Machine {
    processor: Option<String>,
    threads: Option<usize>,
    peak_memory_bytes: Option<u64>,
}

#[derive(Debug, Clone, Serialize)]
struct Scene {
    file: String,
    hash: String,
    environment: Option<Surroundings>,
    camera: String,
    ignored: Vec<String>,
    warnings: Vec<String>,
    blind_spots: Vec<String>,
}

#[derive(Debug, Clone, Serialize)]
struct Phase {
    seconds: f64,
}

#[derive(Debug, Clone, Serialize)]
struct Render {
    wall_seconds: f64,
    cpu_seconds: f64,
    started: String,
    finished: String,
    sessions: u64,
    passes: String,
    spp: u64,
    rays: Rays,
    rays_per_second: f64,
    light_selection: Option<Selection>,
}

/// See [`LightSelection`].
#[derive(Debug, Clone, Copy, Serialize)]
struct Selection {
    /// Share of the CPU time.
    time_share: f64,
    /// Mean number of groups in a cut through a light tree, if there are cuts.
    mean_cut_size: Option<f64>,
}

#[derive(Debug, Clone, Serialize)]
struct Rays {
    camera: u64,
    bounce: u64,
    shadow: u64,
    total: u64,
}

/// Effect of `--clamp` or `--clamp-vpl` on the image.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Clamp {
    /// Always true: clamping biases the image.
    pub biased: bool,
    /// The setting.
    pub setting: &'static str,
    /// Its value: a radiance, or a multiple of the typical radiance.
    pub limit: f64,
    /// Number of clamped samples.
    pub samples: u64,
    /// Radiance removed from the average pixel, as a mean over lanes.
    pub mean_removed: f64,
    /// The removed radiance as a fraction of the unclamped mean.
    pub share_removed: f64,
}

/// Outcome of an error target.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TargetReport {
    /// The target of the relative mean squared error.
    pub relmse: f64,
    /// Whether the error is below the target, at the confidence that the looks share.
    pub reached: bool,
    /// One minus that confidence.
    pub level: f64,
    /// The last look; `None` if there was none.
    pub last_look: Option<Check>,
}

#[derive(Debug, Clone, Serialize)]
struct Invalid {
    #[serde(flatten)]
    sample: InvalidSample,
    /// Arguments of `render` that trace only this sample.
    replay: String,
}

impl RenderReport {
    /// Reports on `film`, whose image has `layers`. `preparation` is given if a scene was loaded for it.
    pub(crate) fn new(
        provenance: &Provenance,
        film: &Film,
        layers: &[Layer],
        outputs: &Outputs,
        preparation: Option<LoadTimings>,
    ) -> RenderReport {
        let (work, settings) = (&provenance.work, &provenance.settings);
        let name = |path: Option<&std::path::Path>| path.map(|p| p.display().to_string());
        let error = provenance.error_of(film);
        RenderReport {
            image: name(outputs.image()),
            film: name(outputs.film.as_deref()),
            program: provenance.program.clone(),
            machine: Machine::now(preparation),
            scene: Scene::of(provenance),
            settings: settings.clone(),
            settings_hash: settings.hash(),
            identity: provenance.plan.may_be_met_by(film.passes()).then(|| provenance.identity()),
            plan: provenance.plan,
            load: preparation.map(|p| Phase { seconds: p.load_seconds }),
            build: preparation.map(|p| Phase { seconds: p.build_seconds }),
            render: Render::of(provenance, film),
            guards: work.passes.guards,
            chains: work
                .passes
                .chains
                .as_ref()
                .map(|chains| chains.digest(mean_of(film) * film.layout().pixels() as f64)),
            clamp: settings.clamping().map(|clamping| clamp(clamping, provenance, film, error.as_ref())),
            approximate: settings.approximation(),
            error,
            target: None,
            invalid: work.passes.invalid.iter().map(|&sample| Invalid { sample, replay: replay(sample) }).collect(),
            pixel_hash: exr::hash_pixels(settings.width, settings.height, settings.crop, layers),
        }
    }

    /// Adds the outcome of the plan's error target, if it has one, according to the last look.
    pub(super) fn with_target(self, last_look: Option<&Check>) -> RenderReport {
        let target = self.plan.stop.target_error.map(|relmse| TargetReport {
            relmse,
            reached: last_look.is_some_and(|look| look.reached),
            level: target::LEVEL,
            last_look: last_look.copied(),
        });
        RenderReport { target, ..self }
    }

    /// Returns the outcome of the error target, if there is one.
    pub fn target(&self) -> Option<&TargetReport> {
        self.target.as_ref()
    }

    /// Returns a sentence about an error target that was not reached.
    pub fn target_missed(&self) -> Option<String> {
        let target = self.target.filter(|target| !target.reached)?;
        let found = match target.last_look {
            Some(look) if look.upper_limit <= 0.0 => "the image is black".into(),
            Some(look) if look.upper_limit <= target.relmse => "the interval is not to be trusted".into(),
            Some(look) => {
                format!("at {} samples per pixel it is only known to be below {:.3e}", look.passes, look.upper_limit)
            }
            None => "there were too few samples to look at it".into(),
        };
        Some(format!("the target error {:e} was not reached: {found}", target.relmse))
    }

    /// Labels of an image format that has no room for the whole report.
    pub(super) fn labels(&self) -> Vec<(&'static str, &str)> {
        let identity = self.identity.as_deref().map(|identity| (IDENTITY, identity));
        let approximate = self.approximate.as_deref().map(|text| ("Approximate", text));
        [("Software", "étendue")].into_iter().chain(identity).chain(approximate).collect()
    }

    /// Returns the error of the image, if it has replicates to measure it between.
    pub fn error(&self) -> Option<&ImageError> {
        self.error.as_ref()
    }

    /// Returns the effect of clamping, if it was asked for.
    pub fn clamp(&self) -> Option<Clamp> {
        self.clamp
    }

    /// See [`exr::hash_pixels`].
    pub fn pixel_hash(&self) -> &str {
        &self.pixel_hash
    }

    /// Returns the counts of fired guards.
    pub fn guards(&self) -> Guards {
        self.guards
    }

    /// Returns the arguments that trace the first non-finite sample again.
    pub fn first_replay(&self) -> Option<&str> {
        self.invalid.first().map(|i| i.replay.as_str())
    }

    /// Returns doubts about the chains, one sentence each.
    pub fn doubts_of_chains(&self) -> Vec<String> {
        let Some(chains) = &self.chains else { return Vec::new() };
        let mut doubts = Vec::new();
        if chains.owned_tiles > 0 {
            let (owned, lit) = (chains.owned_tiles, chains.lit_tiles);
            doubts.push(format!(
                "{owned} of {lit} tiles owe most of their light to one chain: their error is unknown (--aov \
                 error-unknown)"
            ));
        }
        if chains.lost_seeds > 0 {
            doubts.push(format!("{} chains found their seed dark: their light is missing", chains.lost_seeds));
        }
        doubts
    }

    /// Returns a one-line summary: samples, time, rays per second, error.
    pub fn summary(&self) -> String {
        let render = &self.render;
        let speed = render.rays_per_second / 1e6;
        let mut line = format!("{} spp in {:.2} s, {speed:.2} Mrays/s", render.spp, render.wall_seconds);
        if let Some(error) = &self.error {
            let relmse = &error.relmse;
            let interval = format!("95% [{:.3e}, {:.3e}]", relmse.low, relmse.high);
            line.push_str(&format!(", relMSE {:.3e} {interval}", relmse.value));
            line.push_str(&format!(", mean {:.6} ± {:.1e}", error.mean, error.mean_standard_error));
            if let Some(largest) = &error.largest {
                line.push_str(&format!(", largest sample {:.1e} of the light", largest.share));
            }
        }
        if let Some(scale) = self.chains.as_ref().and_then(|chains| chains.scale_error) {
            line.push_str(&format!(", global scale ± {:.2} %", 100.0 * scale));
        }
        line
    }

    /// Returns the report as attributes for an EXR header.
    pub fn attributes(&self) -> Vec<(String, Attribute)> {
        let mut attributes = Vec::new();
        flatten("etendue", &serde_json::json!(self), &mut attributes);
        attributes
    }
}

impl Machine {
    fn now(preparation: Option<LoadTimings>) -> Self {
        Machine {
            processor: machine::Processor::detect().model,
            threads: preparation.map(|p| p.threads),
            peak_memory_bytes: machine::peak_memory(),
        }
    }
}

impl Scene {
    fn of(provenance: &Provenance) -> Self {
        let record = &provenance.scene;
        Scene {
            file: record.path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            hash: record.hash.clone(),
            environment: record.surroundings.as_ref().map(Surroundings::without_folder),
            camera: provenance.settings.camera.clone().unwrap_or_else(|| "0".into()),
            ignored: record.ignored.clone(),
            warnings: record.warnings.clone(),
            blind_spots: record.blind_spots.clone(),
        }
    }
}

impl Render {
    fn of(provenance: &Provenance, film: &Film) -> Self {
        let work = &provenance.work;
        let rays = work.passes.rays;
        let total = rays.total();
        Render {
            wall_seconds: work.wall_seconds,
            cpu_seconds: work.cpu_seconds,
            started: work.started.clone(),
            finished: work.finished.clone(),
            sessions: work.sessions,
            passes: film.passes().to_string(),
            spp: film.passes().len(),
            rays: Rays { camera: rays.camera, bounce: rays.bounce, shadow: rays.shadow, total },
            rays_per_second: if work.wall_seconds > 0.0 { total as f64 / work.wall_seconds } else { 0.0 },
            light_selection: selection(work.passes.selection, work.cpu_seconds),
        }
    }
}

/// Returns the digest of a render of `cpu_seconds`; `None` if lights were not selected by receiver.
fn selection(LightSelection { seconds, cuts, groups }: LightSelection, cpu_seconds: f64) -> Option<Selection> {
    let mean_cut_size = (cuts > 0).then(|| groups as f64 / cuts as f64);
    (seconds > 0.0 && cpu_seconds > 0.0).then(|| Selection { time_share: seconds / cpu_seconds, mean_cut_size })
}

fn clamp(
    (setting, limit): (&'static str, f64),
    provenance: &Provenance,
    film: &Film,
    error: Option<&ImageError>,
) -> Clamp {
    let guards = provenance.work.passes.guards;
    let samples = provenance.settings.layout().pixels() as f64 * film.passes().len() as f64;
    let mean_removed = if samples > 0.0 { guards.clamped_energy / (samples * LANES as f64) } else { 0.0 };
    let mean = error.map_or_else(|| mean_of(film), |e| e.mean);
    let share_removed = if mean_removed > 0.0 { mean_removed / (mean + mean_removed) } else { 0.0 };
    Clamp { biased: true, setting, limit, samples: guards.clamped, mean_removed, share_removed }
}

/// Mean of all pixels and lanes.
fn mean_of(film: &Film) -> f64 {
    numeric::mean(&film.mean(Plane::Color))
}

/// Arguments of `render` that trace only this sample.
fn replay(InvalidSample { pass, x, y }: InvalidSample) -> String {
    format!("--passes {pass}..{} --crop {x},{y},{},{}", pass + 1, x + 1, y + 1)
}

/// Flattens a JSON document to attributes named by their path in it. Absent and empty values are left out. Numbers that
/// an attribute cannot hold exactly become text.
pub(crate) fn flatten(name: &str, value: &Value, out: &mut Vec<(String, Attribute)>) {
    let attribute = match value {
        Value::Null => return,
        Value::Object(fields) => {
            for (key, field) in fields {
                flatten(&format!("{name}.{key}"), field, out);
            }
            return;
        }
        Value::Array(items) if items.is_empty() => return,
        Value::Array(_) => Attribute::Text(value.to_string()),
        Value::Bool(truth) => Attribute::Int(i32::from(*truth)),
        Value::String(text) => Attribute::Text(text.clone()),
        Value::Number(number) => match number.as_i64().map(i32::try_from) {
            Some(Ok(int)) => Attribute::Int(int),
            None if number.is_f64() => Attribute::Float(number.as_f64().unwrap_or_default() as f32),
            _ => Attribute::Text(number.to_string()),
        },
    };
    out.push((name.to_owned(), attribute));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_flatten_to_named_attributes() {
        let json = serde_json::json!({
            "a": { "b": 1.5, "c": 7, "d": null, "e": [] },
            "f": "text", "g": true, "h": 10_000_000_000_u64, "i": ["x", "y"],
        });
        let mut flat = Vec::new();
        flatten("etendue", &json, &mut flat);
        let text = |s: &str| Attribute::Text(s.into());
        let expected = [
            ("etendue.a.b", Attribute::Float(1.5)),
            ("etendue.a.c", Attribute::Int(7)),
            ("etendue.f", text("text")),
            ("etendue.g", Attribute::Int(1)),
            ("etendue.h", text("10000000000")),
            ("etendue.i", text("[\"x\",\"y\"]")),
        ];
        assert_eq!(flat, expected.map(|(name, value)| (name.to_owned(), value)));
    }

    #[test]
    fn a_replay_names_one_pass_and_one_pixel() {
        assert_eq!(replay(InvalidSample { pass: 17, x: 12, y: 40 }), "--passes 17..18 --crop 12,40,13,41");
    }
}
