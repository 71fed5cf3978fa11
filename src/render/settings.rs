//! What decides the pixels of a pass. How many passes there are, on how many threads and into which file does not, so
//! that films of different runs can be continued and merged.

use super::{Aov, Frame, Moment};
use crate::accel::{Backend, Build};
use crate::defects::{Defect, planted};
use crate::film::{Crop, Filter, Layout, Plane};
use crate::integrator::{Method, MetropolisOptions, Options};
use crate::path::{Technique, Techniques};
use crate::sampling::{Heuristic, SamplerKind};
use crate::scene::BuildOptions;

/// Everything besides the scene that the pixels of a pass depend on.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Settings {
    /// The method.
    pub method: Method,
    /// Width of the full image.
    pub width: u32,
    /// Height of the full image.
    pub height: u32,
    /// What of it is rendered; `None` for all.
    pub crop: Option<Crop>,
    /// Camera by name or number; `None` for the first.
    pub camera: Option<String>,
    /// The frame of the scene's animations; `None` for the scene as it stands, which is hashed as before there were frames.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<Frame>,
    /// The only animation that is played there, by name or number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub animation: Option<String>,
    /// Longest path in scattering events; `None` for no limit.
    pub depth: Option<u32>,
    /// Pixel filter.
    pub filter: Filter,
    /// Source of sample points.
    pub sampler: SamplerKind,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Independent replicates.
    pub replicates: u32,
    /// Who finds what rays hit: ties between surfaces depend on it.
    pub backend: Backend,
    /// How the acceleration structure is built: ties between surfaces depend on it.
    pub build: Build,
    /// Extra layers, sorted.
    pub aovs: Vec<Aov>,
    /// Limit of a sample's radiance.
    pub clamp: Option<f32>,
    /// Whether the environment is hidden from the camera.
    pub transparent: bool,
    /// Techniques that bidirectional path tracing does without, sorted.
    pub without: Vec<Technique>,
    /// How its techniques share a path.
    pub heuristic: Heuristic,
    /// What chains of Metropolis methods are like.
    #[serde(default)]
    pub metropolis: MetropolisOptions,
}

impl Settings {
    /// How `threads` threads build the scene.
    pub fn build_options(&self, threads: usize) -> BuildOptions {
        BuildOptions { backend: self.backend, build: self.build, threads }
    }

    /// What of the scene's animations is shown.
    pub fn moment(&self) -> Moment {
        Moment { frame: self.frame, animation: self.animation.clone() }
    }

    /// A hash of what the method reads of it, in hexadecimal: what it does not read changes no pixel.
    pub fn hash(&self) -> String {
        // serde_json sorts fields by name and writes floats in their shortest exact form.
        let text = self.read().to_string();
        blake3::hash(text.as_bytes()).to_hex().to_string()
    }

    /// What the method reads of it. Everything is taken apart without `..`: a new setting does not compile until it has its line here.
    pub fn read(&self) -> serde_json::Value {
        if planted(Defect::HashOfAllOptions) {
            return serde_json::json!(self);
        }
        let Settings {
            method,
            width,
            height,
            crop,
            camera,
            frame,
            animation,
            depth,
            filter,
            sampler,
            seed,
            replicates,
            backend,
            build,
            aovs,
            clamp,
            transparent,
            without,
            heuristic,
            metropolis,
        } = self;
        let by_all = serde_json::json!({
            "method": method, "width": width, "height": height, "crop": crop, "camera": camera, "frame": frame,
            "animation": animation, "depth": depth,
            "filter": filter, "sampler": sampler, "seed": seed, "replicates": replicates, "backend": backend, "build": build,
            "aovs": aovs, "clamp": clamp, "transparent": transparent,
        });
        // Light tracing has one technique, whose weight is 1 by every heuristic.
        let of_techniques = serde_json::json!({ "without": without, "heuristic": heuristic });
        let MetropolisOptions { chains, large_step, lengths, mutations, limit, two_stage } = metropolis;
        let of_chains = serde_json::json!({ "chains": chains, "limit": limit, "two-stage": two_stage });
        let large_step = serde_json::json!({ "large-step": large_step });
        let large_step = if planted(Defect::HashForgetsLargeStep) { serde_json::json!({}) } else { large_step };
        let parts = match method {
            Method::PathNaive | Method::PathNee | Method::Path | Method::Light => vec![by_all],
            Method::Bdpt => vec![by_all, of_techniques],
            Method::Pssmlt => vec![by_all, of_techniques, of_chains, large_step],
            Method::Mmlt => vec![by_all, of_techniques, of_chains, large_step, serde_json::json!({ "lengths": lengths })],
            Method::Mlt => vec![by_all, of_techniques, of_chains, serde_json::json!({ "mutations": mutations })],
        };
        let fields = parts.into_iter().filter_map(|part| part.as_object().cloned()).flatten();
        serde_json::Value::Object(fields.filter(|(_, value)| !value.is_null()).collect())
    }

    /// What the integrators need of it.
    pub fn options(&self) -> Options {
        Options {
            seed: self.seed,
            sampler: self.sampler,
            filter: self.filter,
            max_depth: self.depth,
            clamp: self.clamp,
            replicates: self.replicates,
            transparent: self.transparent,
            techniques: Techniques::without(&self.without),
            heuristic: self.heuristic,
            crop: self.layout().crop,
            metropolis: self.metropolis,
        }
    }

    /// The film's pixels and planes.
    pub fn layout(&self) -> Layout {
        let planes = self.aovs.iter().filter_map(|aov| match aov.source() {
            super::aov::Source::Plane(plane) => Some(plane),
            _ => None,
        });
        let alpha = self.transparent.then_some(Plane::Alpha);
        Layout::new(self.width, self.height, self.crop, &planes.chain(alpha).collect::<Vec<_>>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Choices;

    fn settings() -> Settings {
        Choices::default().settings(None).unwrap()
    }

    #[test]
    fn settings_survive_json_and_keep_their_hash() {
        let settings = Settings { clamp: Some(0.1), ..settings() };
        let back: Settings = serde_json::from_value(serde_json::json!(settings)).unwrap();
        assert_eq!(back, settings);
        assert_eq!(back.hash(), settings.hash());
    }

    #[test]
    fn what_every_method_reads_enters_the_hash() {
        let base = settings();
        let other = if base.backend == Backend::Obvhs { Backend::Embree } else { Backend::Obvhs };
        let changed = [
            Settings { seed: 1, ..base.clone() },
            Settings { replicates: 8, ..base.clone() },
            Settings { depth: Some(3), ..base.clone() },
            Settings { clamp: Some(1.0), ..base.clone() },
            Settings { transparent: true, ..base.clone() },
            Settings { method: Method::Bdpt, ..base.clone() },
            Settings { width: 7, ..base.clone() },
            Settings { height: 7, ..base.clone() },
            Settings { crop: Some(Crop { x0: 0, y0: 0, x1: 1, y1: 1 }), ..base.clone() },
            Settings { camera: Some("0".into()), ..base.clone() },
            Settings { filter: Filter::Box, ..base.clone() },
            Settings { sampler: SamplerKind::Independent, ..base.clone() },
            Settings { build: Build::Fast, ..base.clone() },
            Settings { backend: other, ..base.clone() },
            Settings { aovs: vec![Aov::Depth], ..base.clone() },
            Settings { frame: Some(Frame { number: 0, fps: 24.0 }), ..base.clone() },
        ];
        assert!(changed.iter().all(|s| s.hash() != base.hash()));
    }

    /// What one option changes.
    type Change = fn(&mut Settings);

    /// The options that some methods read, each with those that do.
    const OPTIONS: &[(&str, &[Method], Change)] = {
        use Method::{Bdpt, Mlt, Mmlt, Pssmlt};
        &[
            ("heuristic", &[Bdpt, Pssmlt, Mmlt, Mlt], |s| s.heuristic = Heuristic::Power),
            ("without", &[Bdpt, Pssmlt, Mmlt, Mlt], |s| s.without = vec![Technique::Splat]),
            ("large-step", &[Pssmlt, Mmlt], |s| s.metropolis.large_step = 0.5),
            ("lengths", &[Mmlt], |s| s.metropolis.lengths = 5),
            ("mutations", &[Mlt], |s| s.metropolis.mutations.lens = 2.0),
            ("chains", &[Pssmlt, Mmlt, Mlt], |s| s.metropolis.chains = Some(7)),
            ("limit", &[Pssmlt, Mmlt, Mlt], |s| s.metropolis.limit = Some(0.0)),
            ("two-stage", &[Pssmlt, Mmlt, Mlt], |s| s.metropolis.two_stage = true),
        ]
    };

    #[test]
    fn a_method_hashes_what_it_reads_and_nothing_else() {
        for &method in <Method as clap::ValueEnum>::value_variants() {
            let base = Settings { method, ..settings() };
            for (name, readers, change) in OPTIONS {
                let mut changed = base.clone();
                change(&mut changed);
                assert_ne!(changed, base, "{name} changes nothing");
                assert_eq!(changed.hash() != base.hash(), readers.contains(&method), "{name} of {method:?}");
            }
        }
    }

    #[test]
    fn settings_without_a_frame_are_as_they_always_were() {
        let (rest, frame) = (settings(), Some(Frame { number: 3, fps: 0.1 }));
        assert!(serde_json::json!(rest).get("frame").is_none());
        let moved = Settings { frame, ..rest };
        let back: Settings = serde_json::from_value(serde_json::json!(moved)).unwrap();
        assert_eq!((back.frame, back.hash()), (frame, moved.hash()));
    }

    #[test]
    fn layers_bring_their_planes() {
        let layout = Settings { aovs: vec![Aov::Depth, Aov::Instance], ..settings() }.layout();
        assert_eq!(layout.planes(), [Plane::Color, Plane::Alpha, Plane::Depth]);
    }
}
