//! Settings that determine the pixels of a pass. The number of passes, the number of threads and the output file are
//! not among them, so that films of different runs can be continued and merged.

use super::{Aov, FrameNumber, Moment};
use crate::accel::{Backend, Build};
use crate::camera::Camera;
use crate::error::Result;
use crate::film::{Crop, Filter, Layout, Plane};
use crate::integrator::{Execution, IntegratorConfig, MethodConfig};
use crate::light::LightChoice;
use crate::named::Named;
use crate::sampling::SamplerKind;
use crate::scene::description::Lens;
use crate::scene::{BuildOptions, Scene};

/// All settings, besides the scene, that the pixels of a pass depend on.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct RenderSettings {
    /// Light transport algorithm with its own parameters.
    #[serde(flatten)]
    pub method: MethodConfig,
    /// Width of the full image in pixels.
    pub width: u32,
    /// Height of the full image in pixels.
    pub height: u32,
    /// Rendered window; `None` for the full image.
    pub crop: Option<Crop>,
    /// Camera by name or number; `None` for the first.
    pub camera: Option<String>,
    /// Lens that replaces the camera's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lens: Option<Lens>,
    /// The frame of the scene's animations; `None` for the scene at rest. Its hash is then the same as before frames
    /// were introduced.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<FrameNumber>,
    /// The only animation that is played, by name or number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub animation: Option<String>,
    /// Longest path in scattering events; `None` for no limit.
    pub depth: Option<u32>,
    /// Pixel filter.
    pub filter: Filter,
    /// Sample generator.
    pub sampler: SamplerKind,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Independent replicates.
    pub replicates: u32,
    /// Ray-tracing backend. It decides ties between surfaces.
    pub backend: Backend,
    /// Build of the acceleration structure. It decides ties between surfaces.
    pub build: Build,
    /// How lights are selected.
    pub light_choice: LightChoice,
    /// Execution of `path`. It changes no pixel, so that no hash or file knows it.
    #[serde(skip)]
    pub execution: Option<Execution>,
    /// AOVs, sorted.
    pub aovs: Vec<Aov>,
    /// Clamp of a sample's radiance.
    pub clamp: Option<f32>,
    /// Whether the environment is hidden from the camera.
    pub transparent: bool,
}

impl RenderSettings {
    /// Returns the camera in `scene`.
    ///
    /// # Errors
    /// It does not exist.
    pub fn camera_in(&self, scene: &Scene) -> Result<Camera> {
        scene.camera_with_lens(self.camera.as_deref(), self.width, self.height, self.lens.as_ref())
    }

    /// Returns the options for building the scene on `threads` threads.
    pub fn build_options(&self, threads: usize) -> BuildOptions {
        BuildOptions { backend: self.backend, build: self.build, threads, light_choice: self.light_choice }
    }

    /// Returns the setting that biases the image by a limit, and its value.
    pub fn clamping(&self) -> Option<(&'static str, f64)> {
        let virtual_lights = self.method.clamp_vpl().map(|limit| ("clamp-vpl", limit));
        self.clamp.map(|limit| ("clamp", f64::from(limit))).or(virtual_lights)
    }

    /// Returns the name of the approximation that the image is made with, if it is one.
    pub fn approximation(&self) -> Option<String> {
        self.method.subsurface().map(|model| format!("subsurface scattering by {}", model.name()))
    }

    /// Returns the time and animation of the scene that are rendered.
    pub fn moment(&self) -> Moment {
        Moment { frame: self.frame, animation: self.animation.clone() }
    }

    /// Returns a hexadecimal hash of the settings.
    pub fn hash(&self) -> String {
        // serde_json sorts fields by name and writes floats in their shortest exact form.
        let text = self.json().to_string();
        blake3::hash(text.as_bytes()).to_hex().to_string()
    }

    /// Returns the settings as JSON, without those that are not set.
    pub fn json(&self) -> serde_json::Value {
        let fields = serde_json::json!(self).as_object().cloned().unwrap_or_default();
        serde_json::Value::Object(fields.into_iter().filter(|(_, value)| !value.is_null()).collect())
    }

    /// Returns the configuration of the integrators.
    pub fn options(&self) -> IntegratorConfig {
        IntegratorConfig {
            method: self.method,
            seed: self.seed,
            sampler: self.sampler,
            filter: self.filter,
            max_depth: self.depth,
            clamp: self.clamp,
            replicates: self.replicates,
            transparent: self.transparent,
            crop: self.layout().crop,
            execution: self.execution,
        }
    }

    /// Returns the pixels and planes of the film.
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
    use crate::integrator::{Method, Mutations};
    use crate::path::Technique;
    use crate::sampling::Heuristic;
    use crate::session::SettingsPatch;
    use crate::subsurface::DiffusionModel;

    fn settings() -> RenderSettings {
        SettingsPatch::default().settings(None).unwrap()
    }

    #[test]
    fn settings_survive_json_and_keep_their_hash() {
        let settings = RenderSettings { clamp: Some(0.1), ..settings() };
        let back: RenderSettings = serde_json::from_value(serde_json::json!(settings)).unwrap();
        assert_eq!(back, settings);
        assert_eq!(back.hash(), settings.hash());
    }

    #[test]
    fn common_options_change_the_settings_hash() {
        let base = settings();
        let other = if base.backend == Backend::Obvhs { Backend::Embree } else { Backend::Obvhs };
        let changed = [
            RenderSettings { seed: 1, ..base.clone() },
            RenderSettings { replicates: 8, ..base.clone() },
            RenderSettings { depth: Some(3), ..base.clone() },
            RenderSettings { clamp: Some(1.0), ..base.clone() },
            RenderSettings { transparent: true, ..base.clone() },
            RenderSettings { method: Method::Bdpt.into(), ..base.clone() },
            RenderSettings { width: 7, ..base.clone() },
            RenderSettings { height: 7, ..base.clone() },
            RenderSettings { crop: Some(Crop { x0: 0, y0: 0, x1: 1, y1: 1 }), ..base.clone() },
            RenderSettings { camera: Some("0".into()), ..base.clone() },
            RenderSettings { filter: Filter::Box, ..base.clone() },
            RenderSettings { sampler: SamplerKind::Independent, ..base.clone() },
            RenderSettings { build: Build::Fast, ..base.clone() },
            RenderSettings { backend: other, ..base.clone() },
            RenderSettings { aovs: vec![Aov::Depth], ..base.clone() },
            RenderSettings { frame: Some(FrameNumber { number: 0, fps: 24.0 }), ..base.clone() },
        ];
        assert!(changed.iter().all(|s| s.hash() != base.hash()));
    }

    /// Change of one choice.
    type Change = fn(&mut SettingsPatch);

    /// Choices read by some methods only, each with those methods.
    const CHOICES: &[(&str, &[Method], Change)] = {
        use Method::{Bdpt, DeterministicLightcuts, Lightcuts, Mlt, Mmlt, Path, PathNee, Pssmlt, Vpl};
        &[
            ("subsurface", &[Path, PathNee], |s| s.subsurface = Some(DiffusionModel::Burley)),
            ("heuristic", &[Bdpt, Pssmlt, Mmlt, Mlt], |s| s.heuristic = Some(Heuristic::Power)),
            ("without", &[Bdpt, Pssmlt, Mmlt, Mlt], |s| s.without = Some(vec![Technique::Splat])),
            ("large-step", &[Pssmlt, Mmlt], |s| s.large_step = Some(0.5)),
            ("mmlt-depths", &[Mmlt], |s| s.mmlt_depths = Some(5)),
            ("mutations", &[Mlt], |s| s.mutations = Some(Mutations { lens: 2.0, ..Mutations::default() })),
            ("chains", &[Pssmlt, Mmlt, Mlt], |s| s.chains = Some(7)),
            ("chain-threshold", &[Pssmlt, Mmlt, Mlt], |s| s.chain_threshold = Some(0.0)),
            ("virtual-lights", &[Vpl, Lightcuts, DeterministicLightcuts], |s| s.virtual_lights = Some(7)),
            ("clamp-vpl", &[Vpl, Lightcuts, DeterministicLightcuts], |s| s.clamp_vpl = Some(0.5)),
            ("cut-error", &[DeterministicLightcuts], |s| s.cut_error = Some(0.3)),
            ("cut-size", &[Lightcuts], |s| s.cut_size = Some(7)),
            ("two-stage", &[Pssmlt, Mmlt, Mlt], |s| s.two_stage = Some(true)),
        ]
    };

    #[test]
    fn settings_hash_covers_exactly_the_options_of_the_method() {
        for &method in Method::all() {
            let base = SettingsPatch { method: Some(method), ..SettingsPatch::default() };
            let hash = |patch: &SettingsPatch| patch.settings(None).unwrap().hash();
            for (name, readers, change) in CHOICES {
                let mut changed = base.clone();
                change(&mut changed);
                assert_eq!(hash(&changed) != hash(&base), readers.contains(&method), "{name} of {method:?}");
            }
        }
    }

    #[test]
    fn settings_without_a_frame_keep_their_hash() {
        let (rest, frame) = (settings(), Some(FrameNumber { number: 3, fps: 0.1 }));
        assert!(serde_json::json!(rest).get("frame").is_none());
        let moved = RenderSettings { frame, ..rest };
        let back: RenderSettings = serde_json::from_value(serde_json::json!(moved)).unwrap();
        assert_eq!((back.frame, back.hash()), (frame, moved.hash()));
    }

    #[test]
    fn settings_without_a_lens_are_as_they_always_were() {
        let (pinhole, lens) = (settings(), Some(Lens { radius: 0.1, focus: 2.5, blades: 6, rotation: 0.0 }));
        assert!(serde_json::json!(pinhole).get("lens").is_none());
        let focused = RenderSettings { lens, ..pinhole.clone() };
        let back: RenderSettings = serde_json::from_value(serde_json::json!(focused)).unwrap();
        assert_eq!((back.lens, back.hash()), (lens, focused.hash()));
        assert_ne!(focused.hash(), pinhole.hash());
    }

    #[test]
    fn aovs_add_their_film_planes() {
        let layout = RenderSettings { aovs: vec![Aov::Depth, Aov::Instance], ..settings() }.layout();
        assert_eq!(layout.planes(), [Plane::Color, Plane::Alpha, Plane::Depth]);
    }
}
