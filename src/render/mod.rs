//! Rendering as an operation. A [`SettingsPatch`] resolves to [`RenderSettings`] and a [`PassPlan`]. A [`Session`]
//! renders whole passes into a film until the plan or a budget is met. It leaves film files with their [`Provenance`],
//! images and a [`RenderReport`]. A film is a set of passes, so that resuming, sharding and merging are set operations:
//! see [`mod@merge`]. This module is independent of light transport.

mod aov;
pub mod checkpoint;
mod choices;
pub mod compare;
mod complete;
mod conditions;
pub mod film_file;
mod frames;
pub mod images;
pub mod job;
pub mod machine;
pub mod merge;
pub mod methods;
mod outputs;
mod plan;
mod progress;
mod provenance;
pub mod ray_bench;
mod rendered;
mod report;
mod report_files;
pub mod same_mean;
mod session;
mod settings;
mod stage;
mod surroundings;
pub mod target;
pub mod techniques;
mod text;
pub mod verify;

pub use aov::Aov;
pub use checkpoint::Checkpoint;
pub use choices::{SettingsPatch, ToneMapping};
pub use complete::ExistingOutput;
pub use conditions::Conditions;
pub use frames::{FrameNumber, Frames, Moment};
pub use outputs::{Outputs, picture_name, writable};
pub use plan::{PassPlan, PassSelection, StopCriteria, round_spp};
pub use progress::{Observer, Pace, Progress};
pub use provenance::{Program, Provenance, Work};
pub use rendered::Rendered;
pub use report::RenderReport;
pub use session::{Ended, Session};
pub use settings::RenderSettings;
pub use stage::{LoadTimings, LoadedScene};
pub use surroundings::{EnvironmentChoice, Surroundings};
pub use text::{Budget, Bytes, Size, Window, megabytes};
