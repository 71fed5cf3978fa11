//! Where a film comes from: enough to continue it, to refuse to mix it with another, and to say so in the image.

use super::{Look, Plan, Settings, Stage, Surroundings};
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
    /// Where it was.
    pub path: PathBuf,
    /// What was put around it; a file of it where it was.
    pub surroundings: Option<Surroundings>,
    /// Hash of its content.
    pub hash: String,
    /// What it uses and étendue ignores.
    pub ignored: Vec<String>,
    /// What is doubtful about it.
    pub warnings: Vec<String>,
    /// What the method cannot see in it.
    pub blind_spots: Vec<String>,
    /// What light of it the method may miss.
    #[serde(default)]
    pub prior: Prior,
}

/// What rendering has taken so far, over all sessions and shards.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Work {
    /// Rays, guards and invalid samples.
    pub passes: PassReport,
    /// Seconds of wall-clock time, summed over sessions and shards.
    pub wall_seconds: f64,
    /// Seconds of processor time.
    pub cpu_seconds: f64,
    /// How many sessions, a shard being one.
    pub sessions: u64,
    /// When the first began, in UTC.
    pub started: String,
    /// When the last ended, in UTC.
    pub finished: String,
}

/// Where a film comes from.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Provenance {
    /// The program.
    pub program: Program,
    /// The scene.
    pub scene: SceneRecord,
    /// The settings.
    pub settings: Settings,
    /// Which passes the run wanted.
    pub plan: Plan,
    /// How PNG images of it look.
    pub look: Look,
    /// What it took.
    pub work: Work,
}

impl Program {
    /// This program. The version names the defect that is planted in it, if one is.
    pub fn current() -> Self {
        let planted = crate::defects::current().map_or(String::new(), |d| format!("+defect.{}", d.name()));
        Program {
            version: format!("{}{planted}", env!("CARGO_PKG_VERSION")),
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

impl Provenance {
    /// The provenance of a render that begins now.
    pub fn new(stage: &Stage, settings: Settings, plan: Plan, look: Look) -> Self {
        // Settings come of a camera that is there.
        let beyond = stage.scene.beyond_view(settings.camera.as_deref(), settings.width, settings.height).ok().flatten();
        let scene = SceneRecord {
            // Another process, in another folder, may resume.
            path: std::path::absolute(&stage.path).unwrap_or_else(|_| stage.path.clone()),
            surroundings: stage.surroundings.as_ref().map(Surroundings::absolute),
            hash: stage.scene.hash().to_owned(),
            ignored: stage.info.ignored.clone(),
            warnings: stage.info.warnings.iter().cloned().chain(beyond).collect(),
            blind_spots: integrator::blind_spots(settings.method, &stage.scene),
            prior: integrator::prior(settings.method, &stage.scene),
        };
        let work = Work { started: now(), finished: now(), ..Work::default() };
        Provenance { program: Program::current(), scene, settings, plan, look, work }
    }

    /// What the whole image would be, as a hash: another run with the same would make the same again. How long it took, and on what,
    /// is not in it.
    pub fn identity(&self) -> String {
        let what = (&self.program, &self.scene.hash, self.settings.read(), self.plan, self.look);
        blake3::hash(serde_json::json!(what).to_string().as_bytes()).to_hex()[..32].to_owned()
    }

    /// What is known of the samples beforehand.
    pub fn known(&self) -> Known {
        Known { independent: self.settings.method.independent(), prior: self.scene.prior }
    }

    /// The error of `film`, which is of this: see [`Film::image_error`].
    pub fn error_of(&self, film: &Film) -> Option<ImageError> {
        film.image_error(self.known())
    }

    /// Refuses `other` unless its passes are passes of the same picture.
    ///
    /// # Errors
    /// Says what differs.
    pub fn same_picture(&self, other: &Provenance) -> Result<()> {
        let (a, b) = (&self.program, &other.program);
        // Before the scenes, which differ too where something moves.
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
            let (a, b) = (self.settings.read(), other.settings.read());
            let (a, b) = first_difference(&a, &b);
            return Err(differ("settings", &a, &b));
        }
        Ok(())
    }

    /// Refuses to be continued by another program than the one that began it.
    ///
    /// # Errors
    /// Says what differs.
    pub(super) fn continuable_on(&self, stage: &Stage) -> Result<()> {
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

/// The time, in UTC, to the second.
pub(super) fn now() -> String {
    humantime::format_rfc3339_seconds(std::time::SystemTime::now()).to_string()
}
