//! Batch files: many pictures of many scenes, with output paths from a pattern.
//!
//! ```toml
//! output = "out/{scene}.{camera}.{frame:04}.{method}.exr"
//!
//! [settings]              # as in render.toml, for all pictures
//! spp = 64
//!
//! [[render]]              # each of its scenes by each camera and each method
//! scenes = ["cup.glb", "bowl.glb"]
//! cameras = ["front", "side"]
//! methods = ["path", "bdpt"]
//! settings.size = "640x480"
//!
//! [[render]]
//! scenes = ["walk.glb"]
//! frames = "1-240"
//! ```
//!
//! Paths in a batch file are relative to its folder. Precedence of settings, highest first: the command line,
//! `[[render]]`, `[settings]`, the `render.toml` beside the scene.

use super::Frames;
use crate::error::{Error, Result};
use crate::integrator::Method;
use crate::named::Named;
use crate::session::{SettingsPatch, picture_name};
use std::collections::HashMap;
use std::ffi::OsString;
use std::path::{Component, Path, PathBuf};

/// Maximum number of pictures of a batch.
const MOST_PICTURES: usize = 1_000_000;

/// A batch file.
#[derive(Debug, Clone, Default, serde::Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Job {
    /// Path pattern of the outputs; `{scene}`, `{camera}`, `{method}`, `{seed}` and `{frame:04}` stand for their
    /// values.
    pub output: Option<PathBuf>,
    /// Path pattern of the reports; `None` writes none.
    pub report: Option<PathBuf>,
    /// Choices for all pictures.
    pub settings: SettingsPatch,
    /// The requested pictures.
    pub render: Vec<JobRequest>,
    /// Whether to ignore the `render.toml` beside each scene.
    pub no_config: bool,
}

/// A group of pictures with common settings.
#[derive(Debug, Clone, Default, serde::Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct JobRequest {
    /// Scene files.
    pub scenes: Vec<PathBuf>,
    /// Cameras by name or number; the settings' own if empty.
    pub cameras: Vec<String>,
    /// Methods; the settings' own if empty.
    pub methods: Vec<Method>,
    /// Frames of the scenes' animations; the settings' own if `None`.
    pub frames: Option<Frames>,
    /// Choices for this group.
    pub settings: SettingsPatch,
    /// Path pattern of the outputs that replaces the job's.
    pub output: Option<PathBuf>,
}

/// A picture to render.
#[derive(Debug, Clone)]
pub struct JobPicture {
    /// The scene file.
    pub scene: PathBuf,
    /// The choices for it.
    pub choices: SettingsPatch,
    /// Path of the image.
    pub output: PathBuf,
    /// Path of the report.
    pub report: Option<PathBuf>,
}

impl Job {
    /// Reads a batch file.
    ///
    /// # Errors
    /// A usage error with the path, and the line where there is one.
    pub fn read(path: &Path) -> Result<Job> {
        let text = std::fs::read_to_string(path)
            .map_err(|cause| Error::usage(format!("cannot read {}", path.display())).because(cause))?;
        crate::session::text::toml(&text).map_err(|e| e.context(path.display()))
    }

    /// Returns all pictures in order, for a batch file in `folder`. `over` takes precedence over the file's choices.
    ///
    /// # Errors
    /// There is nothing to render, a pattern has an unknown field, two pictures have the same path, or a `render.toml`
    /// cannot be read.
    pub fn pictures(&self, folder: &Path, over: &SettingsPatch) -> Result<Vec<JobPicture>> {
        let mut pictures = Vec::new();
        for (index, request) in self.render.iter().enumerate() {
            if request.scenes.is_empty() {
                return Err(Error::usage(format!("[[render]] number {} has no scenes", index + 1)));
            }
            for scene in &request.scenes {
                let scene = folder.join(scene);
                let near = over.clone().or(seen_from(&request.settings, folder)).or(seen_from(&self.settings, folder));
                let beside = if self.no_config { SettingsPatch::default() } else { SettingsPatch::beside(&scene)? };
                let choices = near.or(beside);
                self.pictures_of(&scene, &choices, request, folder, &mut pictures)?;
            }
        }
        if pictures.is_empty() {
            return Err(Error::usage("there is nothing to render: write [[render]] with scenes = [\"…\"]"));
        }
        distinct(&pictures)?;
        Ok(pictures)
    }

    fn pictures_of(
        &self,
        scene: &Path,
        choices: &SettingsPatch,
        request: &JobRequest,
        folder: &Path,
        pictures: &mut Vec<JobPicture>,
    ) -> Result<()> {
        let output =
            request.output.as_ref().or(self.output.as_ref()).map_or(Path::new(DEFAULT_OUTPUT), PathBuf::as_path);
        let frames = request.frames.as_ref().map_or(&[][..], Frames::numbers);
        for frame in each(frames, choices.frame) {
            for camera in each(&request.cameras, choices.camera.clone()) {
                for method in each(&request.methods, choices.method) {
                    if pictures.len() == MOST_PICTURES {
                        return Err(Error::usage(format!("more than {MOST_PICTURES} pictures in one batch: split it")));
                    }
                    let choices = SettingsPatch { frame, camera: camera.clone(), method, ..choices.clone() };
                    let fields = fields(scene, &choices);
                    let at = |pattern: &Path| {
                        path_name(pattern, &fields).map(|name| folder.join(name)).map_err(Error::usage)
                    };
                    let (output, report) = (at(output)?, self.report.as_deref().map(at).transpose()?);
                    pictures.push(JobPicture { scene: scene.to_owned(), choices, output, report });
                }
            }
        }
        Ok(())
    }
}

/// Default path pattern of the outputs.
const DEFAULT_OUTPUT: &str = "{scene}.{camera}.{method}.exr";

/// All of `values`, or only `usual` if there are none.
fn each<T: Clone>(values: &[T], usual: Option<T>) -> Vec<Option<T>> {
    if values.is_empty() { vec![usual] } else { values.iter().cloned().map(Some).collect() }
}

/// The choices with relative paths resolved against `folder`.
fn seen_from(choices: &SettingsPatch, folder: &Path) -> SettingsPatch {
    SettingsPatch { env: choices.env.clone().map(|env| env.seen_from(folder)), ..choices.clone() }
}

/// Pattern fields of a picture.
fn fields(scene: &Path, choices: &SettingsPatch) -> Fields {
    // Camera names come from files and may hold any character.
    let camera =
        choices.camera.as_deref().unwrap_or("0").replace(|c: char| c == '/' || c == '\\' || c.is_control(), "_");
    HashMap::from([
        ("scene", picture_name(scene)),
        ("camera", camera.into()),
        ("method", choices.method.unwrap_or_default().name().into()),
        ("frame", choices.frame.unwrap_or(0).to_string().into()),
        ("seed", choices.seed.unwrap_or(0).to_string().into()),
    ])
}

/// Values of the pattern fields, as raw bytes of the platform.
type Fields = HashMap<&'static str, OsString>;

/// Expands the pattern of a path. Components that are not valid Unicode have no fields and are kept.
fn path_name(pattern: &Path, fields: &Fields) -> std::result::Result<PathBuf, String> {
    match pattern.to_str() {
        Some(text) => name(text, fields).map(PathBuf::from),
        None => {
            let part = |part: Component<'_>| {
                part.as_os_str().to_str().map_or(Ok(part.as_os_str().to_owned()), |text| name(text, fields))
            };
            pattern.components().map(part).collect()
        }
    }
}

/// Expands a pattern: `{field}`, or `{field:04}` for a number with leading zeros; `{{` is a literal brace.
///
/// # Errors
/// An unknown field, or an unclosed brace.
fn name(pattern: &str, fields: &Fields) -> std::result::Result<OsString, String> {
    let (mut out, mut rest) = (OsString::new(), pattern);
    while let Some(at) = rest.find(['{', '}']) {
        out.push(&rest[..at]);
        let brace = &rest[at..=at];
        rest = &rest[at + 1..];
        if let Some(after) = rest.strip_prefix(brace) {
            out.push(brace);
            rest = after;
            continue;
        }
        let end =
            rest.find('}').filter(|_| brace == "{").ok_or_else(|| format!("'{pattern}': a brace is not matched"))?;
        out.push(&field(&rest[..end], fields).map_err(|what| format!("'{pattern}': {what}"))?);
        rest = &rest[end + 1..];
    }
    out.push(rest);
    Ok(out)
}

/// Expands one field with its width.
fn field(text: &str, fields: &Fields) -> std::result::Result<OsString, String> {
    let (name, width) = text.split_once(':').map_or((text, None), |(name, width)| (name, Some(width)));
    let value = fields.get(name).ok_or_else(|| {
        let mut known: Vec<&str> = fields.keys().copied().collect();
        known.sort_unstable();
        format!("there is no field '{name}': write one of {}", known.join(", "))
    })?;
    let Some(width) = width else { return Ok(value.clone()) };
    let wide = width.strip_prefix('0').and_then(|w| w.parse::<usize>().ok()).filter(|w| *w <= 16);
    let wide = wide.ok_or_else(|| format!("'{width}' is not a width: write one such as 04"))?;
    // A value that is not valid Unicode is not padded.
    Ok(value.to_str().map_or_else(|| value.clone(), |value| format!("{value:0>wide$}").into()))
}

/// Rejects two pictures with the same path.
fn distinct(pictures: &[JobPicture]) -> Result<()> {
    let mut places = HashMap::new();
    for picture in pictures {
        for path in std::iter::once(&picture.output).chain(&picture.report) {
            if places.insert(path, &picture.scene).is_some() {
                let what = "two pictures go there: put {scene}, {camera}, {frame} or {method} into its name";
                return Err(Error::usage(format!("{}: {what}", path.display())));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fields() -> Fields {
        HashMap::from([("scene", "cup".into()), ("frame", "7".into())])
    }

    #[test]
    fn patterns_are_filled_in() {
        assert_eq!(name("out/{scene}.{frame:04}.exr", &fields()).unwrap(), "out/cup.0007.exr");
        assert_eq!(name("{{{scene}}}", &fields()).unwrap(), "{cup}");
        for wrong in ["{scene", "scene}", "{who}", "{frame:4}", "{frame:0x}", "{frame:099}", "{"] {
            assert!(name(wrong, &fields()).is_err(), "{wrong}");
        }
    }

    fn pictures(text: &str) -> Result<Vec<JobPicture>> {
        let job: Job = crate::session::text::toml(text)?;
        job.pictures(Path::new("jobs"), &SettingsPatch::default())
    }

    #[test]
    fn job_is_the_product_of_scenes_cameras_and_methods() {
        let text = "output = '{scene}.{camera}.{method}.exr'\nsettings.spp = 4\n[[render]]\nscenes = ['a.glb', \
            'b.glb']\ncameras = ['0', 'x/y']\nmethods = ['path', 'mlt']\nsettings.spp = 8\n[[render]]\nscenes = \
            ['c.glb']";
        let all = pictures(text).unwrap();
        assert_eq!(all.len(), 9);
        assert_eq!(all[3].output, Path::new("jobs/a.x_y.mlt.exr"));
        assert_eq!(all[3].choices.camera.as_deref(), Some("x/y"));
        assert_eq!((all[3].choices.spp, all[8].choices.spp), (Some(8), Some(4)));
        assert_eq!(all[8].output, Path::new("jobs/c.0.path.exr"));
    }

    #[test]
    fn contradictory_jobs_are_refused() {
        for (text, why) in [
            ("", "nothing to render"),
            ("[[render]]", "no scenes"),
            ("output = 'x.exr'\n[[render]]\nscenes = ['a.glb', 'b.glb']", "two pictures"),
            ("output = '{film}.exr'\n[[render]]\nscenes = ['a.glb']", "no field 'film'"),
            ("[[render]]\nscenes = ['a.glb']\nspp = 4", "line 3"),
        ] {
            let error = pictures(text).unwrap_err().chain();
            assert!(error.contains(why), "{error}");
        }
    }
}
