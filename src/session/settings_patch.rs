//! Render settings as given on the command line or in `render.toml`. One type serves both, and every field is optional.
//! The same names therefore mean the same in both places, and the command line overrides the file field by field.

use super::plan::round_spp;
use super::{
    Aov, Aperture, Budget, EnvironmentChoice, Focus, FrameNumber, LensSettings, PassPlan, PassSelection,
    RenderSettings, Size, StopCriteria, Surroundings, Window,
};
use crate::accel::{Backend, Build};
use crate::error::{Error, Result};
use crate::film::{Crop, Filter};
use crate::integrator::{Method, MetropolisOptions, Mutations};
use crate::io::png::ToneCurve;
use crate::path::Technique;
use crate::sampling::{Heuristic, SamplerKind};
use std::path::Path;

/// Default samples per pixel if no stopping criterion is given.
const DEFAULT_SPP: u32 = 64;

/// Default frames per second, as in cinema and in Blender.
const DEFAULT_FPS: f64 = 24.0;

/// Limit of samples per pixel if only an error target is given, so that a render that cannot reach it ends.
const MOST_SPP_UNASKED: u32 = 1 << 16;

/// Choices about a render; `None` stands for the default.
#[derive(Debug, Clone, Default, clap::Args, serde::Deserialize)]
#[command(next_help_heading = "Picture")]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct SettingsPatch {
    /// Light transport algorithm [default: path]
    #[arg(long, short, value_enum)]
    pub method: Option<Method>,
    /// Samples per pixel at most, rounded up to the replicates times a power of two [default: 64; none with --time;
    /// 65536 with --target-error alone]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1 << 30))]
    pub spp: Option<u32>,
    /// Render for this long at most, e.g. 30s or 5m
    #[arg(long, value_name = "TIME")]
    pub time: Option<Budget>,
    /// Stop once the relative mean squared error is below this with 95 % confidence, e.g. 1e-3
    #[arg(long, value_name = "RELMSE", allow_negative_numbers = true)]
    pub target_error: Option<f64>,
    /// Image size; without a height the camera's aspect decides [default: 1280 wide, or 1280x720]
    #[arg(long, value_name = "WIDTH[xHEIGHT]")]
    pub size: Option<Size>,
    /// Render only these pixels, from the top left, X1 and Y1 exclusive
    #[arg(long, value_name = "X0,Y0,X1,Y1")]
    pub crop: Option<Window>,
    /// Camera by name or number from 0 [default: the first]
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,
    /// Aperture of the camera's lens: an f-stop, for full-frame film 24 mm high and scene units in metres, or a radius
    /// in scene units [default: a pinhole, everything in focus]
    #[arg(long, value_name = "f/STOP|RADIUS", allow_negative_numbers = true)]
    pub aperture: Option<Aperture>,
    /// What the lens is focused on: a distance along the camera's axis in scene units, the centre of a node, or what
    /// the camera sees at the centre of a pixel
    #[arg(long, value_name = "DISTANCE|node:NAME|pixel:X,Y", allow_negative_numbers = true)]
    pub focus: Option<Focus>,
    /// Blades of the aperture, at least 3, in place of a disk of the same area [default: 0, a disk]
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true)]
    pub blades: Option<u32>,
    /// Frame of the scene's animations; frame 0 is at time 0 [default: the scene as it stands]
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true)]
    pub frame: Option<u32>,
    /// The only animation that is played, by name or number from 0, from frame 0 if no other is chosen [default: all
    /// together; where two move the same the later one]
    #[arg(long, value_name = "NAME|NUMBER")]
    pub animation: Option<String>,
    /// Frames per second, for --frame [default: 24]
    #[arg(long, value_name = "RATE", allow_negative_numbers = true)]
    pub fps: Option<f64>,
    /// Longest light path, in scattering events [default: unlimited, ended by roulette]
    #[arg(long, value_name = "EVENTS")]
    pub depth: Option<u32>,
    /// Pixel filter [default: blackman-harris]
    #[arg(long, value_enum)]
    pub filter: Option<Filter>,
    /// Sample generator [default: sobol]
    #[arg(long, value_enum)]
    pub sampler: Option<SamplerKind>,
    /// Seed of all random numbers [default: 0]
    #[arg(long)]
    pub seed: Option<u64>,
    /// Independent replicates, between which the error is measured; 1 measures none [default: 16 for methods with
    /// chains, else 4]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=256))]
    pub replicates: Option<u32>,
    /// Ray-tracing backend [default: embree; obvhs where étendue was built without it]
    #[arg(long, value_enum)]
    pub backend: Option<Backend>,
    /// Build of the acceleration structure [default: robust]
    #[arg(long, value_enum)]
    pub build: Option<Build>,
    /// Extra layers of the EXR image, separated by commas
    #[arg(long = "aov", value_enum, value_delimiter = ',', value_name = "LAYERS")]
    #[serde(rename = "aov")]
    pub aovs: Option<Vec<Aov>>,
    /// Clamp each sample to this radiance: less noise, but the image is biased (darker)
    #[arg(long, value_name = "RADIANCE", allow_negative_numbers = true)]
    pub clamp: Option<f32>,
    /// Hide the environment, map or not, from the camera and write coverage as alpha: it still lights the scene
    #[arg(long, num_args = 0..=1, default_missing_value = "true", require_equals = true, value_name = "BOOL")]
    pub transparent: Option<bool>,
    /// Techniques to exclude from bdpt, separated by commas
    #[arg(long, value_enum, value_delimiter = ',', value_name = "TECHNIQUES")]
    pub without: Option<Vec<Technique>>,
    /// Heuristic of the MIS weights of bdpt [default: balance]
    #[arg(long, value_enum)]
    pub heuristic: Option<Heuristic>,
    /// Chains per pass of a Metropolis method [default: one for 500 pixels, 1024 at most]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1 << 20))]
    pub chains: Option<u32>,
    /// Large-step probability in primary sample space, for pssmlt and mmlt [default: 0.3]
    #[arg(long, value_name = "PROBABILITY", allow_negative_numbers = true)]
    pub large_step: Option<f64>,
    /// Scattering events up to which mmlt has chains for each path length; longer paths share theirs [default: 8]
    #[arg(long, value_name = "EVENTS", value_parser = clap::value_parser!(u32).range(2..=64))]
    pub lengths: Option<u32>,
    /// Relative frequencies of the mutations of mlt, e.g. bidirectional=1,lens=2; others are off [default: all alike]
    #[arg(long, value_name = "NAME=WEIGHT,...")]
    pub mutations: Option<Mutations>,
    /// Contribution above which chains estimate a sample's excess, in units of the typical radiance at its position; 0
    /// leaves all to chains [default: 10 where a pilot finds little noise, else 0]
    #[arg(long, value_name = "TIMES", allow_negative_numbers = true)]
    pub limit: Option<f64>,
    /// Two-stage MLT: let chains visit dark parts of the image as often as bright ones
    #[arg(long, num_args = 0..=1, default_missing_value = "true", require_equals = true, value_name = "BOOL")]
    pub two_stage: Option<bool>,
    /// Environment that replaces the scene's own: a radiance (one number or R,G,B), or a lat-long map (.exr, .hdr)
    #[arg(long, alias = "environment", value_name = "RADIANCE|FILE", allow_negative_numbers = true)]
    #[serde(alias = "environment")]
    pub env: Option<EnvironmentChoice>,
    /// Turn the map about the up axis, counter-clockwise seen from above [default: 0]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    pub env_rotation: Option<f64>,
    /// Take this layer or part of an EXR map [default: the plain channels, else Combined, else the first]
    #[arg(long, value_name = "NAME")]
    pub env_layer: Option<String>,
    /// Multiply the radiance of --env [default: 1]
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true)]
    pub env_scale: Option<f32>,
    /// Exposure of PNG images, in stops [default: 0]
    #[arg(long, value_name = "STOPS", allow_negative_numbers = true)]
    pub exposure: Option<f32>,
    /// Tone curve of PNG images [default: srgb]
    #[arg(long, value_enum)]
    pub curve: Option<ToneCurve>,
}

/// Tone mapping of 8-bit images.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct ToneMapping {
    /// Exposure in stops.
    pub exposure: f32,
    /// Tone curve.
    pub curve: ToneCurve,
}

impl SettingsPatch {
    /// Reads the choices of the `render.toml` beside `scene`; returns none if there is no such file. Relative paths in
    /// it are relative to its folder.
    ///
    /// # Errors
    /// The file cannot be read, or has an unknown key or value; the error names the line.
    pub fn beside(scene: &Path) -> Result<SettingsPatch> {
        let path = scene.with_file_name("render.toml");
        match std::fs::read_to_string(&path) {
            Ok(text) => {
                let choices = SettingsPatch::parse(&text).map_err(|e| e.context(path.display()))?;
                let folder = path.parent().unwrap_or(Path::new(""));
                Ok(SettingsPatch { env: choices.env.map(|env| env.seen_from(folder)), ..choices })
            }
            Err(cause) if cause.kind() == std::io::ErrorKind::NotFound => Ok(SettingsPatch::default()),
            // The scene path leads through a file. The scene loader reports this better.
            Err(cause) if cause.kind() == std::io::ErrorKind::NotADirectory => Ok(SettingsPatch::default()),
            Err(cause) => Err(Error::usage(format!("cannot read {}", path.display())).because(cause)),
        }
    }

    /// Parses the text of a `render.toml`.
    ///
    /// # Errors
    /// A usage error with the line if the text has an unknown key or value.
    pub fn parse(text: &str) -> Result<SettingsPatch> {
        super::text::toml(text)
    }

    /// Returns these choices, with those of `fallback` where there are none.
    pub fn or(self, fallback: SettingsPatch) -> SettingsPatch {
        let stops_here = self.stops();
        // Rotation and scale belong to the environment that they were given with.
        let surrounds_here = self.env.is_some();
        SettingsPatch {
            method: self.method.or(fallback.method),
            spp: if stops_here { self.spp } else { fallback.spp },
            time: if stops_here { self.time } else { fallback.time },
            target_error: if stops_here { self.target_error } else { fallback.target_error },
            size: self.size.or(fallback.size),
            crop: self.crop.or(fallback.crop),
            camera: self.camera.or(fallback.camera),
            aperture: self.aperture.or(fallback.aperture),
            focus: self.focus.or(fallback.focus),
            blades: self.blades.or(fallback.blades),
            frame: self.frame.or(fallback.frame),
            animation: self.animation.or(fallback.animation),
            fps: self.fps.or(fallback.fps),
            depth: self.depth.or(fallback.depth),
            filter: self.filter.or(fallback.filter),
            sampler: self.sampler.or(fallback.sampler),
            seed: self.seed.or(fallback.seed),
            replicates: self.replicates.or(fallback.replicates),
            backend: self.backend.or(fallback.backend),
            build: self.build.or(fallback.build),
            aovs: self.aovs.or(fallback.aovs),
            clamp: self.clamp.or(fallback.clamp),
            transparent: self.transparent.or(fallback.transparent),
            without: self.without.or(fallback.without),
            heuristic: self.heuristic.or(fallback.heuristic),
            chains: self.chains.or(fallback.chains),
            large_step: self.large_step.or(fallback.large_step),
            lengths: self.lengths.or(fallback.lengths),
            mutations: self.mutations.or(fallback.mutations),
            limit: self.limit.or(fallback.limit),
            two_stage: self.two_stage.or(fallback.two_stage),
            env: self.env.or(fallback.env),
            env_rotation: self.env_rotation.or(fallback.env_rotation.filter(|_| !surrounds_here)),
            env_layer: self.env_layer.or(fallback.env_layer.filter(|_| !surrounds_here)),
            env_scale: self.env_scale.or(fallback.env_scale.filter(|_| !surrounds_here)),
            exposure: self.exposure.or(fallback.exposure),
            curve: self.curve.or(fallback.curve),
        }
    }

    /// Resolves the settings, for a camera with aspect ratio `aspect` (width over height). Those without a scene have
    /// no lens: see [`super::LoadedScene::settings`].
    ///
    /// # Errors
    /// Values out of range, a crop outside the image.
    pub fn settings(&self, aspect: Option<f64>) -> Result<RenderSettings> {
        self.lens()?;
        let [width, height] = self.image_size(aspect);
        let mut aovs = self.aovs.clone().unwrap_or_default();
        aovs.sort_unstable();
        aovs.dedup();
        let mut without = self.without.clone().unwrap_or_default();
        without.sort_unstable();
        without.dedup();
        Ok(RenderSettings {
            method: self.method.unwrap_or_default(),
            width,
            height,
            crop: self.crop.map(|w| within(w.0, width, height)).transpose()?,
            camera: self.camera.clone(),
            lens: None,
            frame: self.frame()?,
            animation: self.animation.clone(),
            depth: self.depth,
            filter: self.filter.unwrap_or_default(),
            sampler: self.sampler.unwrap_or_default(),
            seed: self.seed.unwrap_or(0),
            replicates: in_range("replicates", self.replicates(), 256)?,
            backend: self.backend.unwrap_or_default(),
            build: self.build.unwrap_or_default(),
            aovs,
            clamp: self.clamp.map(positive).transpose()?,
            transparent: self.transparent.unwrap_or(false),
            without,
            heuristic: self.heuristic.unwrap_or_default(),
            metropolis: self.metropolis()?,
        })
    }

    /// Returns the chosen lens, if any.
    ///
    /// # Errors
    /// As [`LensSettings::chosen`].
    pub fn lens(&self) -> Result<Option<LensSettings>> {
        LensSettings::chosen(self.aperture, self.focus.clone(), self.blades)
    }

    /// Returns the chosen frame, if any.
    fn frame(&self) -> Result<Option<FrameNumber>> {
        let fps = self.fps.unwrap_or(DEFAULT_FPS);
        if !(fps > 0.0 && fps.is_finite()) {
            return Err(Error::usage("fps must be above zero"));
        }
        let first = self.animation.as_ref().map(|_| 0);
        Ok(self.frame.or(first).map(|number| FrameNumber { number, fps }))
    }

    /// Resolves the options of the Metropolis methods.
    fn metropolis(&self) -> Result<MetropolisOptions> {
        let usual = MetropolisOptions::default();
        let large_step = self.large_step.unwrap_or(usual.large_step);
        if !(large_step > 0.0 && large_step <= 1.0) {
            return Err(Error::usage(
                "large-step must be above 0 and at most 1: small steps alone do not reach every path",
            ));
        }
        if self.limit.is_some_and(|limit| !(limit >= 0.0 && limit.is_finite())) {
            return Err(Error::usage("limit must not be negative"));
        }
        if self.clamp.is_some() && self.method.is_some_and(Method::has_chains) {
            return Err(Error::usage(
                "clamp does nothing sensible to chains, whose samples are all alike: leave it out",
            ));
        }
        Ok(MetropolisOptions {
            chains: self.chains.map(|chains| in_range("chains", chains, 1 << 20)).transpose()?,
            large_step,
            lengths: self.lengths.unwrap_or(usual.lengths).clamp(2, 64),
            mutations: self.mutations.unwrap_or_default(),
            limit: self.limit,
            two_stage: self.two_stage.unwrap_or(usual.two_stage),
        })
    }

    /// Returns the chosen environment, if any.
    ///
    /// # Errors
    /// A rotation without a map, a scale without an environment, values out of range.
    pub fn surroundings(&self) -> Result<Option<Surroundings>> {
        Surroundings::chosen(self.env.as_ref(), self.env_rotation, self.env_scale, self.env_layer.as_deref())
    }

    fn replicates(&self) -> u32 {
        self.replicates.unwrap_or_else(|| self.method.unwrap_or_default().replicates())
    }

    /// Whether any stopping criterion is given.
    pub fn stops(&self) -> bool {
        self.spp.is_some() || self.time.is_some() || self.target_error.is_some()
    }

    /// Resolves the plan, for that selection of the passes.
    ///
    /// # Errors
    /// Values out of range; an error target for a share of the passes, or without replicates to measure the error
    /// between.
    pub fn plan(&self, selection: PassSelection) -> Result<PassPlan> {
        let replicates = self.replicates();
        if let Some(target) = self.target_error {
            measurable(target, replicates, selection)?;
        }
        let unasked = match (self.time, self.target_error) {
            (Some(_), _) => None,
            (None, Some(_)) => Some(MOST_SPP_UNASKED),
            (None, None) => Some(DEFAULT_SPP),
        };
        let spp = self.spp.or(unasked).map(|spp| in_range("spp", spp, 1 << 30)).transpose()?;
        let stop = StopCriteria {
            spp: spp.map(|spp| round_spp(u64::from(spp), replicates)),
            seconds: self.time.map(|Budget(time)| time.as_secs_f64()),
            target_error: self.target_error,
        };
        Ok(PassPlan { stop, selection })
    }

    /// Returns the tone mapping of PNG images.
    ///
    /// # Errors
    /// An exposure that is not finite.
    pub fn look(&self) -> Result<ToneMapping> {
        let exposure = self.exposure.unwrap_or(0.0);
        if !exposure.is_finite() {
            return Err(Error::usage("exposure must be finite"));
        }
        Ok(ToneMapping { exposure, curve: self.curve.unwrap_or_default() })
    }

    fn image_size(&self, aspect: Option<f64>) -> [u32; 2] {
        let width = self.size.map_or(1280, |s| s.width);
        let aspect = aspect.filter(|a| a.is_finite() && *a > 0.0).unwrap_or(16.0 / 9.0);
        let by_aspect = (f64::from(width) / aspect).round().clamp(1.0, 65536.0) as u32;
        [width, self.size.and_then(|s| s.height).unwrap_or(by_aspect)]
    }
}

fn in_range(name: &str, value: u32, most: u32) -> Result<u32> {
    if (1..=most).contains(&value) { Ok(value) } else { Err(Error::usage(format!("{name} must be from 1 to {most}"))) }
}

fn positive(clamp: f32) -> Result<f32> {
    if clamp.is_finite() && clamp > 0.0 { Ok(clamp) } else { Err(Error::usage("clamp must be above zero")) }
}

/// Rejects an error target that cannot be measured.
fn measurable(target: f64, replicates: u32, selection: PassSelection) -> Result<()> {
    let refuse = |what: &str| Err(Error::usage(format!("target-error {what}")));
    match (target.is_finite() && target > 0.0, replicates, selection) {
        (false, ..) => refuse("must be above zero"),
        (_, 0 | 1, _) => refuse("needs replicates to measure the error between: leave out --replicates 1"),
        (_, _, PassSelection::All) => Ok(()),
        _ => refuse("needs the whole picture: merge the shards, look at the error, and resume"),
    }
}

fn within(crop: Crop, width: u32, height: u32) -> Result<Crop> {
    if crop.x1 <= width && crop.y1 <= height {
        Ok(crop)
    } else {
        let Crop { x0, y0, x1, y1 } = crop;
        Err(Error::usage(format!("crop {x0},{y0},{x1},{y1} reaches outside the {width}x{height} image")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_wins_field_by_field() {
        let line = SettingsPatch { seed: Some(7), ..SettingsPatch::default() };
        let file = SettingsPatch::parse("seed = 1\nreplicates = 8\nfilter = \"box\"\nsize = \"64x32\"").unwrap();
        let settings = line.or(file).settings(None).unwrap();
        assert_eq!((settings.seed, settings.replicates, settings.width, settings.height), (7, 8, 64, 32));
        assert_eq!(settings.filter, Filter::Box);
    }

    #[test]
    fn when_to_stop_is_chosen_in_one_place() {
        let stop = |choices: &SettingsPatch| choices.plan(PassSelection::All).unwrap().stop;
        let line = SettingsPatch { spp: Some(16), ..SettingsPatch::default() };
        let file = SettingsPatch::parse("time = \"5m\"").unwrap();
        assert_eq!(stop(&line.or(file.clone())), StopCriteria::after(16));
        assert_eq!(stop(&file), StopCriteria { seconds: Some(300.0), ..StopCriteria::default() });
        let several = SettingsPatch::parse("time = \"5m\"\nspp = 100\ntarget-error = 1e-3").unwrap();
        assert_eq!(stop(&several), StopCriteria { spp: Some(128), seconds: Some(300.0), target_error: Some(1e-3) });
        let target = SettingsPatch::parse("target-error = 0.01").unwrap();
        assert_eq!(stop(&target), StopCriteria { target_error: Some(0.01), ..StopCriteria::after(65536) });
        assert_eq!(stop(&SettingsPatch::default()), StopCriteria::after(64));
    }

    #[test]
    fn frames_have_a_rate_and_are_none_without_a_number() {
        let frame = |text: &str| SettingsPatch::parse(text).unwrap().settings(None).map(|settings| settings.frame);
        assert_eq!(frame("fps = 30").unwrap(), None);
        assert_eq!(frame("frame = 12").unwrap(), Some(FrameNumber { number: 12, fps: 24.0 }));
        assert_eq!(frame("frame = 0\nfps = 29.97").unwrap(), Some(FrameNumber { number: 0, fps: 29.97 }));
        for text in ["fps = 0", "fps = -24.0", "fps = nan", "frame = 1\nfps = inf"] {
            assert!(frame(text).unwrap_err().to_string().contains("fps must be above zero"), "{text}");
        }
        assert!(SettingsPatch::parse("frame = -1").is_err() && SettingsPatch::parse("frame = 1.5").is_err());
        let line = SettingsPatch { frame: Some(3), ..SettingsPatch::default() };
        let both = line.or(SettingsPatch::parse("frame = 1\nfps = 30").unwrap());
        assert_eq!(both.settings(None).unwrap().frame, Some(FrameNumber { number: 3, fps: 30.0 }));
    }

    #[test]
    fn targets_that_cannot_be_measured_are_refused() {
        for text in
            ["target-error = 0.0", "target-error = -1.0", "target-error = nan", "target-error = 0.1\nreplicates = 1"]
        {
            assert!(SettingsPatch::parse(text).unwrap().plan(PassSelection::All).is_err(), "{text}");
        }
        let target = SettingsPatch::parse("target-error = 0.1").unwrap();
        assert!(target.plan("0/2".parse().unwrap()).is_err() && target.plan("0..8".parse().unwrap()).is_err());
    }

    #[test]
    fn unknown_keys_are_named_with_their_line() {
        let error = SettingsPatch::parse("seed = 1\nsped = 2").unwrap_err();
        assert!(error.chain().contains("line 2") && error.chain().contains("sped"), "{}", error.chain());
    }

    #[test]
    fn wrong_values_in_a_file_are_refused_like_those_on_the_line() {
        for text in [
            "size = \"0x4\"",
            "env = -1.0",
            "env = \"sky.png\"",
            "spp = -4",
            "target-error = \"low\"",
            "aov = [\"beauty\"]",
        ] {
            assert!(SettingsPatch::parse(text).is_err(), "{text}");
        }
        for text in
            ["replicates = 0", "replicates = 1000", "clamp = 0.0", "clamp = inf", "size = \"4x4\"\ncrop = \"0,0,5,4\""]
        {
            assert!(SettingsPatch::parse(text).unwrap().settings(None).is_err(), "{text}");
        }
        assert!(SettingsPatch::parse("spp = 0").unwrap().plan(PassSelection::All).is_err());
    }

    #[test]
    fn environments_may_be_numbers_arrays_or_text() {
        for text in ["env = 0.5", "env = [0.5, 0.5, 0.5]", "env = \"0.5\"", "environment = 0.5"] {
            assert_eq!(SettingsPatch::parse(text).unwrap().env, Some(EnvironmentChoice::Radiance([0.5; 3])), "{text}");
        }
    }

    #[test]
    fn another_environment_leaves_rotation_and_scale_behind() {
        let file = || SettingsPatch::parse("env = \"sky.hdr\"\nenv-rotation = 30\nenv-scale = 2.0").unwrap();
        let line = |env: Option<&str>| SettingsPatch {
            env: env.map(|e| e.parse().unwrap()),
            env_scale: Some(3.0),
            ..SettingsPatch::default()
        };
        let placed = |choices: SettingsPatch| choices.surroundings().unwrap().map(|s| (s.rotation, s.scale));
        assert_eq!(placed(SettingsPatch::default().or(file())), Some((30.0, 2.0)));
        assert_eq!(placed(line(None).or(file())), Some((30.0, 3.0)));
        assert_eq!(placed(line(Some("1")).or(file())), Some((0.0, 3.0)));
    }

    #[test]
    fn paths_in_a_file_are_seen_from_its_folder() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("render.toml"), "env = \"maps/sky.hdr\"").unwrap();
        let choices = SettingsPatch::beside(&folder.path().join("scene.gltf")).unwrap();
        assert_eq!(choices.env, Some(EnvironmentChoice::File(folder.path().join("maps/sky.hdr"))));
    }

    #[test]
    fn the_camera_decides_a_missing_height() {
        let height = |size: Option<&str>, aspect| {
            let size = size.map(|s| s.parse().unwrap());
            SettingsPatch { size, ..SettingsPatch::default() }.settings(aspect).unwrap().height
        };
        assert_eq!(height(None, None), 720);
        assert_eq!(height(None, Some(2.0)), 640);
        assert_eq!(height(Some("100"), Some(0.5)), 200);
        assert_eq!(height(Some("100x7"), Some(0.5)), 7);
        assert_eq!(height(Some("100"), Some(f64::NAN)), 56);
    }
}
