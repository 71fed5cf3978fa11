//! Rendering as an operation. A [`SettingsPatch`] resolves to [`RenderSettings`] and a [`PassPlan`]. A [`Session`]
//! renders whole passes into a film until the plan or a budget is met. It leaves film files with their [`Provenance`],
//! images and a [`RenderReport`]. A film is a set of passes, so that resuming, sharding and merging are set operations:
//! see [`mod@merge`]. This module is independent of light transport.

mod aov;
pub mod checkpoint;
mod existing_output;
pub mod film_file;
mod frame;
pub mod images;
mod job;
mod lens;
mod loaded_scene;
pub mod machine;
mod media;
pub mod merge;
mod method_settings;
mod outputs;
mod overrides;
mod plan;
mod progress;
pub(crate) mod provenance;
mod render;
mod rendered;
pub(crate) mod report;
#[allow(clippy::module_inception)] // it holds `Session`
mod session;
mod setting_value;
mod settings;
mod settings_patch;
mod surroundings;
pub mod target;
pub(crate) mod text;

pub use aov::Aov;
pub use checkpoint::Checkpoint;
pub use existing_output::ExistingOutput;
pub use frame::{FrameNumber, Moment};
pub use job::RenderJob;
pub use lens::{Aperture, Focus, LensSettings};
pub use loaded_scene::{LoadTimings, LoadedScene};
pub use media::Media;
pub use outputs::{Outputs, picture_name, writable};
pub use overrides::Overrides;
pub use plan::{PassPlan, PassSelection, StopCriteria, round_spp};
pub use progress::{Observer, Pace, Progress};
pub use provenance::{Program, Provenance, Work};
pub use render::{Image, Render};
pub use rendered::Rendered;
pub use report::RenderReport;
pub use session::{Ended, Session};
pub use setting_value::Form;
pub use settings::RenderSettings;
pub use settings_patch::{SETTINGS, Setting, SettingsPatch, ToneMapping};
pub use surroundings::{EnvironmentChoice, Surroundings};
pub use text::{Budget, Bytes, Size, Window, megabytes};
