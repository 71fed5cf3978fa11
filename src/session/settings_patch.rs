//! Render settings as given on the command line or in `render.toml`. One type serves both, and every field is optional.
//! The same names therefore mean the same in both places, and the command line overrides the file field by field.

use super::plan::round_spp;
use super::setting_value::{Form, SettingValue};
use super::{
    Aov, Aperture, Budget, EnvironmentChoice, Focus, FrameNumber, LensSettings, Media, Overrides, PassPlan,
    PassSelection, RenderSettings, Size, StopCriteria, Surroundings, Window,
};
use crate::accel::{Backend, Build};
use crate::error::{Error, Result};
use crate::film::{Crop, Filter};
use crate::integrator::{Execution, Method, Mutations};
use crate::io::png::ToneCurve;
use crate::light::LightChoice;
use crate::path::Technique;
use crate::sampling::{Heuristic, SamplerKind};
use crate::subsurface::DiffusionModel;
use std::ops::RangeInclusive;
use std::path::Path;

/// Default samples per pixel if no stopping criterion is given.
const DEFAULT_SPP: u32 = 64;

/// Default frames per second, as in cinema and in Blender.
const DEFAULT_FPS: f64 = 24.0;

/// Limit of samples per pixel if only an error target is given, so that a render that cannot reach it ends.
const MOST_SPP_UNASKED: u32 = 1 << 16;

/// A render setting: the source of its `render.toml` key, its flag and its explanation.
#[derive(Debug, Clone, Copy)]
pub struct Setting {
    /// Key in `render.toml`, and flag.
    pub name: &'static str,
    /// Another spelling of the name.
    pub alias: Option<&'static str>,
    /// Short flag.
    pub short: Option<char>,
    /// Explanation.
    pub help: &'static str,
    /// Placeholder of the value.
    pub value: &'static str,
    /// A valid value, as written in `render.toml`.
    pub example: &'static str,
    /// Form of the value on the command line.
    pub form: Form,
    /// Names and explanations of the possible values; empty if they cannot be listed.
    pub values: fn() -> Vec<(&'static str, &'static str)>,
    /// Parses a value and sets it.
    set: fn(&mut SettingsPatch, &str) -> std::result::Result<(), String>,
}

impl Setting {
    /// Parses `text`, as written on the command line, and sets the value in `patch`.
    ///
    /// # Errors
    /// A sentence about the text.
    pub fn set(&self, patch: &mut SettingsPatch, text: &str) -> std::result::Result<(), String> {
        (self.set)(patch, text)
    }
}

/// Writes [`SettingsPatch`] and [`SETTINGS`] from one row a setting.
macro_rules! settings {
    ($($(#[doc = $doc:literal])+ $name:literal $(| $alias:literal)? => $field:ident: $type:ty {
        value: $value:literal, example: $example:literal $(, short: $short:expr)?
    })*) => {
        /// Choices about a render; `None` stands for the default.
        #[derive(Debug, Clone, Default, serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct SettingsPatch {
            $($(#[doc = $doc])+ #[serde(rename = $name $(, alias = $alias)?)] pub $field: Option<$type>,)*
            /// Media, which only files tell.
            pub media: Media,
        }

        impl SettingsPatch {
            /// Returns these choices, each with that of `fallback` where there is none.
            fn completed(self, fallback: SettingsPatch) -> SettingsPatch {
                let media = if self.media.is_empty() { fallback.media } else { self.media };
                SettingsPatch { $($field: self.$field.or(fallback.$field),)* media }
            }
        }

        /// All settings.
        pub const SETTINGS: &[Setting] = &[$(Setting {
            name: $name,
            alias: [$(Some($alias),)? None][0],
            short: [$($short,)? None][0],
            help: concat!($($doc),+),
            value: $value,
            example: $example,
            form: <$type as SettingValue>::FORM,
            values: <$type as SettingValue>::values,
            set: |patch, text| {
                patch.$field = Some(SettingValue::parse(text)?);
                Ok(())
            },
        },)*];
    };
}

settings! {
    /// Light transport algorithm [default: path]
    "method" => method: Method { value: "METHOD", example: r#""path""#, short: Some('m') }
    /// Samples per pixel at most, rounded up to the replicates times a power of two [default: 64; none with --time;
    /// 65536 with --target-error alone]
    "spp" => spp: u32 { value: "SPP", example: r#"64"# }
    /// Render for this long at most, e.g. 30s or 5m
    "time" => time: Budget { value: "TIME", example: r#""5m""# }
    /// Stop once the relative mean squared error is below this with 95 % confidence, e.g. 1e-3
    "target-error" => target_error: f64 { value: "RELMSE", example: r#"1e-3"# }
    /// Image size; without a height the camera's aspect decides [default: 1280 wide, or 1280x720]
    "size" => size: Size { value: "WIDTH[xHEIGHT]", example: r#""1280x720""# }
    /// Render only these pixels, from the top left, X1 and Y1 exclusive
    "crop" => crop: Window { value: "X0,Y0,X1,Y1", example: r#""0,0,640,360""# }
    /// Camera by name or number from 0 [default: the first]
    "camera" => camera: String { value: "NAME", example: r#""0""# }
    /// Aperture of the camera's lens: an f-stop, for full-frame film 24 mm high and scene units in metres, or a radius
    /// in scene units [default: a pinhole, everything in focus]
    "aperture" => aperture: Aperture { value: "f/STOP|RADIUS", example: r#""f/2.8""# }
    /// What the lens is focused on: a distance along the camera's axis in scene units, the centre of a node, or what
    /// the camera sees at the centre of a pixel
    "focus" => focus: Focus { value: "DISTANCE|node:NAME|pixel:X,Y", example: r#"2.5"# }
    /// Blades of the aperture, at least 3, in place of a disk of the same area [default: 0, a disk]
    "blades" => blades: u32 { value: "NUMBER", example: r#"6"# }
    /// Frame of the scene's animations; frame 0 is at time 0 [default: the scene as it stands]
    "frame" => frame: u32 { value: "NUMBER", example: r#"0"# }
    /// The only animation that is played, by name or number from 0, from frame 0 if no other is chosen [default: all
    /// together; where two move the same the later one]
    "animation" => animation: String { value: "NAME|NUMBER", example: r#""walk""# }
    /// Frames per second, for --frame [default: 24]
    "fps" => fps: f64 { value: "RATE", example: r#"24.0"# }
    /// Longest light path, in scattering events [default: unlimited, ended by roulette]
    "depth" => depth: u32 { value: "EVENTS", example: r#"64"# }
    /// Pixel filter [default: blackman-harris]
    "filter" => filter: Filter { value: "FILTER", example: r#""blackman-harris""# }
    /// Sample generator [default: sobol]
    "sampler" => sampler: SamplerKind { value: "SAMPLER", example: r#""sobol""# }
    /// Seed of all random numbers [default: 0]
    "seed" => seed: u64 { value: "SEED", example: r#"0"# }
    /// Independent replicates, between which the error is measured; 1 measures none [default: 16 for methods with
    /// chains or virtual lights, else 4]
    "replicates" => replicates: u32 { value: "REPLICATES", example: r#"4"# }
    /// Ray-tracing backend [default: embree; obvhs where étendue was built without it]
    "backend" => backend: Backend { value: "BACKEND", example: r#""obvhs""# }
    /// Build of the acceleration structure [default: robust]
    "build" => build: Build { value: "BUILD", example: r#""robust""# }
    /// How a light is chosen to light a point [default: auto]
    "light-choice" => light_choice: LightChoice { value: "CHOICE", example: r#""tree""# }
    /// Execution of path: one path after the other, or many together; the pixels are the same [default: the faster one]
    "execution" => execution: Execution { value: "EXECUTION", example: r#""batched""# }
    /// Extra layers of the EXR image, separated by commas
    "aov" => aovs: Vec<Aov> { value: "LAYERS", example: r#"["albedo", "normal"]"# }
    /// Clamp each sample to this radiance: less noise, but the image is biased (darker)
    "clamp" => clamp: f32 { value: "RADIANCE", example: r#"10.0"# }
    /// Hide the environment, map or not, from the camera and write coverage as alpha: it still lights the scene
    "transparent" => transparent: bool { value: "BOOL", example: r#"true"# }
    /// Techniques to exclude from bdpt, separated by commas
    "without" => without: Vec<Technique> { value: "TECHNIQUES", example: r#"["splat"]"# }
    /// Heuristic of the MIS weights of bdpt [default: balance]
    "heuristic" => heuristic: Heuristic { value: "HEURISTIC", example: r#""balance""# }
    /// Chains per pass of a Metropolis method [default: one for 500 pixels, 1024 at most]
    "chains" => chains: u32 { value: "CHAINS", example: r#"128"# }
    /// Large-step probability in primary sample space, for pssmlt and mmlt [default: 0.3]
    "large-step" => large_step: f64 { value: "PROBABILITY", example: r#"0.3"# }
    /// Scattering events up to which mmlt has chains for each path length; longer paths share theirs [default: 8]
    "mmlt-depths" | "lengths" => mmlt_depths: u32 { value: "EVENTS", example: r#"8"# }
    /// Relative frequencies of the mutations of mlt, e.g. bidirectional=1,lens=2; others are off [default: all alike]
    "mutations" => mutations: Mutations { value: "NAME=WEIGHT,...", example: r#""bidirectional=1,lens=2""# }
    /// Contribution above which chains estimate a sample's excess, in units of the typical radiance at its position; 0
    /// leaves all to chains [default: 10 where a pilot finds little noise, else 0]
    "chain-threshold" | "limit" => chain_threshold: f64 { value: "TIMES", example: r#"10.0"# }
    /// Two-stage MLT: let chains visit dark parts of the image as often as bright ones
    "two-stage" => two_stage: bool { value: "BOOL", example: r#"true"# }
    /// Light subpaths per pass whose vertices are virtual lights, for vpl and both lightcuts [default: 64; one for
    /// 16 pixels for lightcuts]
    "virtual-lights" => virtual_lights: u32 { value: "SUBPATHS", example: r#"4096"# }
    /// Groups of lights, and of virtual lights, that lightcuts samples at a point [default: 8]
    "cut-size" => cut_size: u32 { value: "GROUPS", example: r#"8"# }
    /// Largest error of the light at a point for deterministic-lightcuts, as a share of it [default: 0.1]
    "cut-error" => cut_error: f64 { value: "SHARE", example: r#"0.1"# }
    /// Limit what a virtual light contributes to this multiple of the typical radiance: less noise, but the image is
    /// biased (darker in corners) [default: what the limit takes away is traced]
    "clamp-vpl" => clamp_vpl: f64 { value: "TIMES", example: r#"1.0"# }
    /// Approximate subsurface scattering in thick bodies, for path and path-nee: fast, and the image says so [default:
    /// the random walk, which is exact]
    "subsurface" => subsurface: DiffusionModel { value: "MODEL", example: r#""photon-beam""# }
    /// Environment that replaces the scene's own: a radiance (one number or R,G,B), or a lat-long map (.exr, .hdr)
    "env" | "environment" => env: EnvironmentChoice { value: "RADIANCE|FILE", example: r#""sky.hdr""# }
    /// Turn the map about the up axis, counter-clockwise seen from above [default: 0]
    "env-rotation" => env_rotation: f64 { value: "DEGREES", example: r#"90.0"# }
    /// Take this layer or part of an EXR map [default: the plain channels, else Combined, else the first]
    "env-layer" => env_layer: String { value: "NAME", example: r#""ViewLayer.Combined""# }
    /// Multiply the radiance of --env [default: 1]
    "env-scale" => env_scale: f32 { value: "FACTOR", example: r#"1.0"# }
    /// Exposure of PNG images, in stops [default: 0]
    "exposure" => exposure: f32 { value: "STOPS", example: r#"0.0"# }
    /// Tone curve of PNG images [default: srgb]
    "curve" => curve: ToneCurve { value: "CURVE", example: r#""filmic""# }
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
                let (env, media) = (choices.env.map(|env| env.seen_from(folder)), choices.media.seen_from(folder));
                Ok(SettingsPatch { env, media, ..choices })
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
        let mut fallback = fallback;
        if stops_here {
            (fallback.spp, fallback.time, fallback.target_error) = (None, None, None);
        }
        if surrounds_here {
            (fallback.env_rotation, fallback.env_layer, fallback.env_scale) = (None, None, None);
        }
        self.completed(fallback)
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
        Ok(RenderSettings {
            method: self.method_config()?,
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
            light_choice: self.light_choice.unwrap_or_default(),
            execution: self.execution,
            aovs,
            clamp: self.clamp.map(positive).transpose()?,
            transparent: self.transparent.unwrap_or(false),
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

    /// Returns the chosen environment and media, if any.
    ///
    /// # Errors
    /// A rotation without a map, a scale without an environment, values out of range.
    pub fn overrides(&self) -> Result<Overrides> {
        self.media.check()?;
        let surroundings =
            Surroundings::chosen(self.env.as_ref(), self.env_rotation, self.env_scale, self.env_layer.as_deref())?;
        Ok(Overrides { surroundings, media: self.media.clone() })
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
    pub fn tone(&self) -> Result<ToneMapping> {
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

pub(super) fn in_range(name: &str, value: u32, most: u32) -> Result<u32> {
    between(name, value, 1..=most)
}

pub(super) fn between(name: &str, value: u32, range: RangeInclusive<u32>) -> Result<u32> {
    let (least, most) = (range.start(), range.end());
    if range.contains(&value) { Ok(value) } else { Err(Error::usage(format!("{name} must be from {least} to {most}"))) }
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
        let placed = |choices: SettingsPatch| choices.overrides().unwrap().surroundings.map(|s| (s.rotation, s.scale));
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
