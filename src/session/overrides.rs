//! What settings replace in a scene or add to it. It belongs to the scene and not to the settings: the content of the
//! scene, and with it its hash, are those of the scene that is rendered.

use super::{Media, Surroundings};
use crate::error::Result;
use crate::scene::description::Description;

/// Environment and media that are not those of the scene's file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Overrides {
    /// Environment that replaces the scene's own.
    pub surroundings: Option<Surroundings>,
    /// Media in addition to the scene's own.
    pub media: Media,
}

impl Overrides {
    /// Applies them to `description`; each density may take `memory` bytes.
    ///
    /// # Errors
    /// A file cannot be read, or a medium does not fit the scene.
    pub(super) fn apply(&self, description: &mut Description, memory: u64) -> Result<()> {
        if let Some(surroundings) = &self.surroundings {
            surroundings.surround(description)?;
        }
        self.media.fill(description, memory)
    }

    /// Returns them with absolute paths, for another process in another folder.
    pub fn absolute(&self) -> Overrides {
        Overrides { surroundings: self.surroundings.as_ref().map(Surroundings::absolute), media: self.media.absolute() }
    }
}
