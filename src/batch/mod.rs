//! Many pictures in one process: batch files, frame lists, and the cache that loads the next scene while the present
//! one renders.

mod frames;
mod job;
mod scene_cache;

pub use frames::Frames;
pub use job::{Job, JobPicture, JobRequest};
pub use scene_cache::{SceneCache, SceneKey};
