//! Rendering as an operation: what was asked for ([`Choices`], resolved to [`Settings`] and a [`Plan`]), a [`Session`]
//! that runs whole passes into a film until the plan or a budget is met, and what it leaves behind: film files with
//! their [`Provenance`], images, a [`Report`]. A film is a set of passes, so resuming, sharding and merging are set
//! operations: see [`mod@merge`]. Nothing in here knows how light travels.

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
pub use choices::{Choices, Look};
pub use complete::Found;
pub use conditions::Conditions;
pub use frames::{Frame, Frames, Moment};
pub use outputs::{Outputs, picture_name, writable};
pub use plan::{Plan, Selection, Stop, round_spp};
pub use progress::{Observer, Pace, Progress};
pub use provenance::{Program, Provenance, Work};
pub use rendered::Rendered;
pub use report::Report;
pub use session::{Ended, Session};
pub use settings::Settings;
pub use stage::{Preparation, Stage};
pub use surroundings::{Environment, Surroundings};
pub use text::{Budget, Bytes, Size, Window, megabytes};
