//! Provenance of a film: enough to continue it, to refuse mixing it with another film, and to document it in the image
//! header.

use super::{LoadedScene, Media, Overrides, PassPlan, RenderSettings, Surroundings, ToneMapping};
use crate::error::{Error, Result};
use crate::film::{Film, ImageError, Known, Prior};
use crate::integrator::{self, PassReport};
use std::path::PathBuf;

/// The program that rendered.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Program {
    /// Version of étendue.
    pub version: String,
    /// Git revision it was built from, where known.
    pub revision: Option<String>,
    /// Instruction set it was compiled for.
    pub isa: String,
}

/// The scene that was rendered.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SceneRecord {
    /// Path of its file.
    pub path: PathBuf,
    /// Environment that replaces its own, with the path of its file.
    pub surroundings: Option<Surroundings>,
    /// Media that it has in addition to its own, with the paths of their files.
    #[serde(default, skip_serializing_if = "Media::is_empty")]
    pub media: Media,
    /// Hash of its content.
    pub hash: String,
    /// Features that it uses and étendue ignores.
    pub ignored: Vec<String>,
    /// Warnings about it.
    pub warnings: Vec<String>,
    /// Blind spots of the method in it.
    pub blind_spots: Vec<String>,
    /// Prior on light of the scene that the method may miss.
    #[serde(default)]
    pub prior: Prior,
}

/// Work of a render so far, over all sessions and shards.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Work {
    /// Rays, guard counts and invalid samples.
    pub passes: PassReport,
    /// Seconds of wall-clock time, summed over sessions and shards.
    pub wall_seconds: f64,
    /// Seconds of processor time.
    pub cpu_seconds: f64,
    /// Number of sessions; a shard is one.
    pub sessions: u64,
    /// Start of the first session, in UTC.
    pub started: String,
    /// End of the last session, in UTC.
    pub finished: String,
}

/// Provenance of a film.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Provenance {
    /// The program.
    pub program: Program,
    /// The scene.
    pub scene: SceneRecord,
    /// The settings.
    pub settings: RenderSettings,
    /// The plan of passes.
    pub plan: PassPlan,
    /// Tone mapping of its PNG images.
    pub look: ToneMapping,
    /// The work so far.
    pub work: Work,
}

impl Program {
    /// Returns this program.
    pub fn current() -> Self {
        Program {
            version: env!("CARGO_PKG_VERSION").into(),
            revision: option_env!("ETENDUE_GIT_REVISION").filter(|r| !r.is_empty()).map(str::to_owned),
            isa: option_env!("ETENDUE_TARGET_FEATURES").unwrap_or(std::env::consts::ARCH).into(),
        }
    }
}

impl std::fmt::Display for Program {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let revision = self.revision.as_deref().unwrap_or("unknown revision");
        write!(f, "{} ({revision}, {})", self.version, self.isa)
    }
}

impl Work {
    /// Adds the work of another film.
    pub(super) fn absorb(&mut self, other: Work) {
        self.passes.absorb(other.passes);
        self.wall_seconds += other.wall_seconds;
        self.cpu_seconds += other.cpu_seconds;
        self.sessions += other.sessions;
        // RFC 3339 times in UTC sort as text.
        self.started = std::cmp::min(std::mem::take(&mut self.started), other.started);
        self.finished = std::cmp::max(std::mem::take(&mut self.finished), other.finished);
    }
}

impl SceneRecord {
    /// Returns what is not that of its file.
    pub fn overrides(&self) -> Overrides {
        Overrides { surroundings: self.surroundings.clone(), media: self.media.clone() }
    }
}

impl Provenance {
    /// Creates the provenance of a render that begins now.
    pub fn new(stage: &LoadedScene, settings: RenderSettings, plan: PassPlan, look: ToneMapping) -> Self {
        // The settings were resolved with an existing camera.
        let beyond =
            stage.scene.beyond_view(settings.camera.as_deref(), settings.width, settings.height).ok().flatten();
        let Overrides { surroundings, media } = stage.overrides.absolute();
        let scene = SceneRecord {
            // Resuming may happen in another process and folder.
            path: std::path::absolute(&stage.path).unwrap_or_else(|_| stage.path.clone()),
            surroundings,
            media,
            hash: stage.scene.hash().to_owned(),
            ignored: stage.info.ignored.clone(),
            warnings: stage.info.warnings.iter().cloned().chain(beyond).collect(),
            blind_spots: integrator::missing_light(settings.method.kind(), &stage.scene),
            prior: integrator::prior(settings.method.kind(), &stage.scene),
        };
        let work = Work { started: now(), finished: now(), ..Work::default() };
        Provenance { program: Program::current(), scene, settings, plan, look, work }
    }

    /// Returns a hash that identifies the complete image: a run with the same hash renders the same image. Render time
    /// and machine do not enter it.
    pub fn identity(&self) -> String {
        let what = (&self.program, &self.scene.hash, self.settings.json(), self.plan, self.look);
        blake3::hash(serde_json::json!(what).to_string().as_bytes()).to_hex()[..32].to_owned()
    }

    /// Returns prior knowledge about the samples.
    pub fn known(&self) -> Known {
        Known { independent: self.settings.method.kind().independent(), prior: self.scene.prior }
    }

    /// Returns the error of `film`, which has this provenance: see [`Film::image_error`].
    pub fn error_of(&self, film: &Film) -> Option<ImageError> {
        film.image_error(self.known())
    }

    /// Checks that `other` renders passes of the same picture.
    ///
    /// # Errors
    /// The first difference.
    pub fn same_picture(&self, other: &Provenance) -> Result<()> {
        let (a, b) = (&self.program, &other.program);
        // Checked before the scene hashes, which also differ if something moves.
        if self.settings.frame != other.settings.frame {
            let [a, b] = [self, other].map(|p| p.settings.frame.map_or("none".into(), |frame| frame.to_string()));
            return Err(differ("frames", &a, &b));
        }
        if self.scene.hash != other.scene.hash {
            return Err(differ("scenes", &self.scene.hash, &other.scene.hash));
        }
        if a != b {
            return Err(differ("versions of étendue", &a.to_string(), &b.to_string()));
        }
        if self.settings.seed != other.settings.seed {
            return Err(differ("seeds", &self.settings.seed.to_string(), &other.settings.seed.to_string()));
        }
        if self.settings.hash() != other.settings.hash() {
            let (a, b) = (self.settings.json(), other.settings.json());
            let (a, b) = first_difference(&a, &b);
            return Err(differ("settings", &a, &b));
        }
        Ok(())
    }

    /// Checks that this program and scene can continue the film.
    ///
    /// # Errors
    /// The first difference.
    pub(super) fn continuable_on(&self, stage: &LoadedScene) -> Result<()> {
        let here = Provenance::new(stage, self.settings.clone(), self.plan, self.look);
        self.same_picture(&here)
    }
}

fn differ(what: &str, a: &str, b: &str) -> Error {
    Error::usage(format!("different {what}: {a} and {b}"))
}

/// The first field in which two JSON objects differ, as text.
fn first_difference(a: &serde_json::Value, b: &serde_json::Value) -> (String, String) {
    let [first, second] = [a, b].map(|json| json.as_object().into_iter().flatten().map(|(key, _)| key));
    let different = first.chain(second).map(|key| (key, &a[key], &b[key])).find(|(_, value, other)| value != other);
    different.map_or_else(Default::default, |(key, value, other)| (format!("{key} {value}"), format!("{key} {other}")))
}

/// The current time in UTC, to the second.
pub(crate) fn now() -> String {
    humantime::format_rfc3339_seconds(std::time::SystemTime::now()).to_string()
}
